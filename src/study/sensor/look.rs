//! Single rays, cast on the host: towards a keypoint, or round a scanner's field. They are few, so the host
//! casts them for all backends, with the same arithmetic as theirs.

use perirobot_march::backend::{GridPose, Rays, Shades};
use perirobot_march::march;
use perirobot_march::voxel::BitGrid;
use perirobot_scene::truth::Truth;

/// A return.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Return {
    /// The voxel that stopped the ray.
    pub hit: [i32; 3],
    /// Distance at which it was entered, in 1/65536 voxels.
    pub distance_q16: u32,
    /// The voxel where the return is read: `hit`, unless there is noise or the sensor's mount is off.
    pub read: [i32; 3],
}

/// The direction of a ray in the grid, Q16.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RayDirection {
    /// Where it truly goes.
    pub truly_q16: [i32; 3],
    /// Where it is believed to go; the same, unless the sensor's mount is off.
    pub believed_q16: [i32; 3],
    /// How much of it goes along the sensor's third axis, Q15.
    pub z_q15: i32,
}

impl RayDirection {
    /// The direction of a ray of a table.
    pub fn new(from: &GridPose, dir_q15: [i32; 3]) -> RayDirection {
        let way = |from: &GridPose| from.axis_q15.map(|axis| march::direction_q16(axis, dir_q15));
        RayDirection { truly_q16: way(&from.caster()), believed_q16: way(from), z_q15: dir_q15[2] }
    }
}

/// What rays may end at.
#[derive(Clone, Copy, Debug)]
pub struct Obstacles<'a> {
    /// What stops rays, over the whole grid.
    pub blockers: &'a BitGrid,
    /// How dark it is, if sensors do not detect all of it equally far.
    pub shades: Option<&'a Shades>,
}

impl<'a> Obstacles<'a> {
    /// All of a scene.
    pub fn of(truth: &'a Truth) -> Obstacles<'a> {
        Obstacles { blockers: &truth.blockers, shades: truth.shades.as_deref() }
    }
}

/// Casts a ray with the gates and the noise of a table, as ray number `ray` of it.
pub fn look(
    obstacles: Obstacles,
    rays: &Rays,
    from: &GridPose,
    way: RayDirection,
    ray: u32,
) -> Option<Return> {
    let Obstacles { blockers, shades } = obstacles;
    let (gates, size) = (rays.gates.ray_gates(way.z_q15), blockers.window().size);
    let inside = |crossing: &march::Crossing| {
        crossing.t_q16 <= gates.range_max_q16 && blockers.window().contains(crossing.voxel)
    };
    let mut entered =
        march::crossings(march::start(from.caster().origin_q16, way.truly_q16)).take_while(inside);
    let to = entered.find(|to| to.t_q16 >= gates.near_ignore_q16 && blockers.get(to.voxel))?;
    let drawn = march::draw(from.draws, ray);
    let is_too_weak = shades.is_some_and(|shades| shades.is_too_weak(to.voxel, to.t_q16, &gates));
    if to.t_q16 < gates.range_min_q16 || is_too_weak || march::is_lost(drawn, rays.noise.lost_below) {
        return None;
    }
    let read = read(rays, from, way, drawn, &to, size);
    Some(Return { hit: to.voxel, distance_q16: to.t_q16, read })
}

/// The voxel where a return is read that comes from the voxel into which a crossing leads, in a grid of some
/// size; `drawn` is what its ray drew.
pub(super) fn read(
    rays: &Rays,
    from: &GridPose,
    way: RayDirection,
    drawn: u32,
    to: &march::Crossing,
    size: [u32; 3],
) -> [i32; 3] {
    match rays.noise.step_q16(rays.gates.slant(way.z_q15), drawn, to.t_q16) {
        0 if from.truly.is_none() => to.voxel,
        step => {
            let begin = march::start(from.origin_q16, way.believed_q16);
            let read_q16 = march::noisy_q16(to.t_q16, step);
            march::voxel_after(begin, march::crossings_at(&begin, march::room(&begin, size), read_q16))
        }
    }
}

/// All returns of a table from a placement.
pub(crate) fn returns<'a>(
    obstacles: Obstacles<'a>,
    rays: &'a Rays,
    from: &'a GridPose,
) -> impl Iterator<Item = Return> + 'a {
    rays.dirs_q15
        .iter()
        .zip(0..)
        .filter_map(move |(&dir_q15, ray)| look(obstacles, rays, from, RayDirection::new(from, dir_q15), ray))
}
