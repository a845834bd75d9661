//! Chooses by cost which voxels are looked at, in which way a table's rays are carved, and which of its
//! packets are cast. The counts do not depend on the choice.

use super::packet::Packets;
use crate::backend::Carving;
use crate::voxel::{BitGrid, Window};

/// The voxels that matter, and the boxes that hold some.
pub(super) struct RelevantVoxels {
    pub(super) voxels: BitGrid,
    /// Edge of the largest boxes in voxels; a row of one lies in one word of a plane.
    pub(super) edge: i32,
    /// Lowest voxels of boxes of that edge.
    pub(super) boxes: Vec<[i32; 3]>,
}

impl RelevantVoxels {
    /// These voxels of a window.
    pub(super) fn new(window: Window, regions: &[BitGrid]) -> RelevantVoxels {
        let mut voxels = BitGrid::new(window);
        regions.iter().for_each(|region| voxels.add(region));
        RelevantVoxels::from_voxels(voxels)
    }

    /// All voxels of a window.
    pub(super) fn all(window: Window) -> RelevantVoxels {
        RelevantVoxels::from_voxels(BitGrid::full(window))
    }

    /// These voxels.
    pub(super) fn from_voxels(voxels: BitGrid) -> RelevantVoxels {
        let window = voxels.window();
        // Larger boxes pay where many are decided whole.
        let largest = if window.volume() > 1 << 20 { 8 } else { 4 };
        let edge = largest as usize;
        let steps = window.size.map(|n| n.div_ceil(largest as u32) as usize);
        let mut held = vec![false; steps.iter().product()];
        let row_words = voxels.words_per_row().max(1) as usize;
        for (row, words) in voxels.words().chunks_exact(row_words).enumerate() {
            let (y, z) = (row % window.size[1] as usize, row / window.size[1] as usize);
            let first = (z / edge * steps[1] + y / edge) * steps[0];
            for x in 0..steps[0] {
                held[first + x] |= words[x * edge / 32] >> (x * edge % 32) & ((1 << edge) - 1) != 0;
            }
        }
        let at = |i: usize| [i % steps[0], i / steps[0] % steps[1], i / steps[0] / steps[1]];
        let corner = |i| std::array::from_fn(|r| window.min[r] + at(i)[r] as i32 * largest);
        let boxes = (0..held.len()).filter(|&i| held[i]).map(corner).collect();
        RelevantVoxels { voxels, edge: largest, boxes }
    }
}

/// Which way is cheaper for a table in a window. To mark a voxel along a ray costs about as much as to decide
/// a voxel, since most voxels are decided with many others.
pub(super) fn carving(packets: &Packets, window: Window) -> Carving {
    let across: u64 = window.size.iter().map(|&n| u64::from(n)).sum::<u64>() / 2;
    let along_rays = packets.rays() as u64 * across;
    match packets.image() {
        Some(_) if along_rays > window.volume() => Carving::ByVoxel,
        _ => Carving::ByRay,
    }
}
