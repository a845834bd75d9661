//! Single rays, cast on the host: towards a keypoint, or round a scanner's field. Cheap enough to be done once for all
//! backends, with the same arithmetic as theirs.

use crate::backend::{Placement, Rays};
use crate::march;
use crate::voxel::BitGrid;

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
pub struct Way {
    /// Where it truly goes.
    pub truly_q16: [i32; 3],
    /// Where it is believed to go; the same, unless the sensor's mount is off.
    pub believed_q16: [i32; 3],
}

impl Way {
    /// Of a ray of a table.
    pub fn of(from: &Placement, dir_q15: [i32; 3]) -> Way {
        let way = |from: &Placement| from.axis_q15.map(|axis| march::direction_q16(axis, dir_q15));
        Way { truly_q16: way(&from.caster()), believed_q16: way(from) }
    }
}

/// Casts a ray with the gates and the noise of a table, as ray number `ray` of it.
pub fn look(blockers: &BitGrid, rays: &Rays, from: &Placement, way: Way, ray: u32) -> Option<Return> {
    let (gates, size) = (&rays.gates, blockers.window().size);
    let mut at = march::start(from.caster().origin_q16, way.truly_q16);
    loop {
        let axis = march::next_axis(at.next_q16);
        let t = at.next_q16[axis];
        if t > gates.range_max_q16 {
            return None;
        }
        march::cross(&mut at, axis);
        if !blockers.window().contains(at.cell) {
            return None;
        }
        if t >= gates.near_ignore_q16 && blockers.get(at.cell) {
            if t < gates.range_min_q16 {
                return None;
            }
            let drawn = march::draw(from.draws, ray);
            if march::is_lost(drawn, rays.noise.lost_below) {
                return None;
            }
            let read = match rays.noise.step_q16(drawn, t) {
                0 if from.truly.is_none() => at.cell,
                step => {
                    let begin = march::start(from.origin_q16, way.believed_q16);
                    let read_q16 = march::noisy_q16(t, step);
                    after(begin, march::crossings_at(&begin, march::room(&begin, size), read_q16))
                }
            };
            return Some(Return { hit: at.cell, distance_q16: t, read });
        }
    }
}

/// The cell that a ray is in after so many crossings.
pub fn after(mut ray: march::March, crossings: u32) -> [i32; 3] {
    for _ in 0..crossings {
        let axis = march::next_axis(ray.next_q16);
        march::cross(&mut ray, axis);
    }
    ray.cell
}

/// All returns of a table from a placement.
pub fn returns<'a>(
    blockers: &'a BitGrid,
    rays: &'a Rays,
    from: &'a Placement,
) -> impl Iterator<Item = Return> + 'a {
    rays.dirs_q15
        .iter()
        .zip(0..)
        .filter_map(move |(&dir_q15, ray)| look(blockers, rays, from, Way::of(from, dir_q15), ray))
}
