//! What single rays hit first, for callers on the host that follow a ray here and there: the leaps of
//! `first_hit` without its packets.

use super::first_hit::{self, Box3, Layer, LeapingRay, Search};
use crate::march::leap::{self, RayAxis};
use crate::march::{self, Crossing, Gates};
use crate::voxel::BitGrid;

/// The blockers of a scene, made ready.
#[derive(Debug)]
pub struct BlockerSearch {
    layer: Layer,
}

/// A place from which many rays go, and an empty box around it.
#[derive(Clone, Copy)]
pub struct RaysFrom {
    origin_q16: [i32; 3],
    clearing: Box3,
}

impl BlockerSearch {
    /// Makes the blockers of a scene ready.
    pub fn new(blockers: &BitGrid) -> BlockerSearch {
        BlockerSearch { layer: Layer::new(blockers.clone()) }
    }

    /// Rays from a place of the grid, in 1/65536 voxels from its corner.
    pub fn rays_from(&self, origin_q16: [i32; 3]) -> RaysFrom {
        RaysFrom { origin_q16, clearing: self.layer.clearing(origin_q16.map(|x| x >> 16)) }
    }

    /// The crossing into the first blocker that a ray in a direction (Q16) meets within its range, housing
    /// left out.
    pub fn first(&self, from: &RaysFrom, dir_q16: [i32; 3], gates: &Gates) -> Option<Crossing> {
        let begin = march::start(from.origin_q16, dir_q16);
        let axis = |r: usize| RayAxis::new(r, begin.step[r], begin.next_q16[r], begin.period_q16[r]);
        let d = dir_q16.map(i32::unsigned_abs);
        let ray = LeapingRay { voxel: begin.voxel, axes: std::array::from_fn(axis), d };
        let search = Search {
            clearing: from.clearing.into(),
            ..Search::new(&self.layer, gates.near_ignore_q16, begin.voxel)
        };
        let limit = first_hit::range(gates.range_max_q16);
        let hit = search.first_hit(ray, true, limit, first_hit::NOTHING);
        (hit < first_hit::LEFT).then(|| {
            let at = first_hit::crossing(hit);
            let made = |r: usize| {
                leap::made_at(begin.next_q16[r], begin.period_q16[r], d[r], r as u32, at.t_q16, at.axis)
            };
            let voxel = std::array::from_fn(|r| begin.voxel[r] + begin.step[r] * made(r) as i32);
            Crossing { t_q16: at.t_q16, axis: at.axis as usize, voxel }
        })
    }
}
