//! Layers of blockers that lie across a section of a cone: where a wall or a floor stops all rays of a tile.
//!
//! # Theory
//! All rays of a tile are in the box around a section of their cone (`cone`) from one distance to another. If they are before
//! a layer of voxels across some axis at the first, and in it or behind it at the second, they enter it inside the box. So
//! if that part of the layer is all blockers, every ray enters a blocker there, unless one before stops it, and nothing
//! behind the layer matters. All of them enter it by the same number of crossings of the axis.
//!
//! # Practice
//! Most rays end on a wall, a floor or a table, which are layers where they are level. Other surfaces, and edges, are
//! stepped through or held against rays one by one.

use super::cone::ConeAtPose;
use crate::voxel::{BitGrid, Window};

/// How many sections of a cone a layer is looked for in, as one.
const LONGER: [f32; 3] = [1.0, 2.0, 4.0];

/// A layer of blockers across a cone.
pub(super) struct BlockerLayer {
    pub(super) axis: usize,
    /// The layer, counted along the axis.
    pub(super) at: i32,
    /// Voxels in which the cone's rays may be before they enter it, from the distance on where the section begins.
    pub(super) before: Window,
}

impl BlockerLayer {
    /// The layer across a cone from `begin` on, within a few sections and up to `limit`.
    pub(super) fn new(
        blockers: &BitGrid,
        cone: &ConeAtPose,
        begin: f32,
        section: f32,
        limit: f32,
    ) -> Option<BlockerLayer> {
        let ends = LONGER.into_iter().map(|n| begin + section * n);
        ends.take_while(|&end| end < limit).find_map(|end| BlockerLayer::find(blockers, cone, begin, end))
    }

    /// The nearest layer across some axis that all rays enter between two distances, having been before it at the first.
    fn find(blockers: &BitGrid, cone: &ConeAtPose, begin: f32, end: f32) -> Option<BlockerLayer> {
        let (section, grid) = (cone.section(begin, end), blockers.window());
        (0..3).find_map(|axis| {
            let aside = (0..3).filter(|&a| a != axis);
            // A ray that leaves the grid enters no layer.
            let mut inside =
                aside.map(|a| section.min[a] >= grid.min[a] && section.end()[a] <= grid.end()[a]);
            if !inside.all(|inside| inside) {
                return None;
            }
            let (mut layers, is_up) = cone.layers(axis, begin, end);
            let at = layers.find(|&at| {
                let mut layer = section;
                (layer.min[axis], layer.size[axis]) = (at, 1);
                // One look says of most that they are not.
                let middle = std::array::from_fn(|r| layer.min[r] + layer.size[r] as i32 / 2);
                blockers.get(middle) && blockers.all_in(&layer)
            })?;
            let mut before = section;
            let behind = before.end()[axis];
            if is_up {
                before.size[axis] = (at - before.min[axis]).max(0) as u32;
            } else {
                (before.min[axis], before.size[axis]) = (at + 1, (behind - at - 1).max(0) as u32);
            }
            Some(BlockerLayer { axis, at, before })
        })
    }
}
