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
    /// The voxel where the return is read: `hit`, unless there is noise.
    pub read: [i32; 3],
}

/// Casts a ray in a direction of the grid (Q16) with the gates and the noise of a table, as ray number `ray` of it.
pub fn look(
    blockers: &BitGrid,
    rays: &Rays,
    from: &Placement,
    dir_q16: [i32; 3],
    ray: u32,
) -> Option<Return> {
    let (gates, size) = (&rays.gates, blockers.window().size);
    let begin = march::start(from.origin_q16, dir_q16);
    let mut at = begin;
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
            let step = match rays.noise_q16.is_empty() {
                true => 0,
                false => rays.noise_q16[march::draw(from.draws, ray) as usize],
            };
            let read = match step {
                0 => at.cell,
                _ => {
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
    rays.dirs_q15.iter().zip(0..).filter_map(move |(&dir_q15, ray)| {
        let dir_q16 = from.axis_q15.map(|axis| march::direction_q16(axis, dir_q15));
        look(blockers, rays, from, dir_q16, ray)
    })
}
