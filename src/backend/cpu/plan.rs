//! What is worth doing: which voxels matter, which way a table's rays are carved, which of its bundles are
//! cast. One place, by cost; whatever it says, the counts are the same.

use super::bundle::Bundles;
use crate::backend::Carving;
use crate::voxel::{BitGrid, Window};

/// Edge of the largest boxes in voxels; a row of one lies in one word of a plane.
pub(super) const LARGEST: i32 = 4;

/// The voxels that matter, and the boxes that hold some.
pub(super) struct Wanted {
    pub(super) cells: BitGrid,
    /// Lowest voxels of boxes of [`LARGEST`] voxels.
    pub(super) boxes: Vec<[i32; 3]>,
}

impl Wanted {
    /// These voxels of a window.
    pub(super) fn of(window: Window, regions: &[BitGrid]) -> Wanted {
        let mut cells = BitGrid::new(window);
        regions.iter().for_each(|region| cells.add(region));
        Wanted::cells(cells)
    }

    /// All voxels of a window.
    pub(super) fn all(window: Window) -> Wanted {
        Wanted::cells(BitGrid::full(window))
    }

    fn cells(cells: BitGrid) -> Wanted {
        let window = cells.window();
        let steps = window.size.map(|n| n.div_ceil(LARGEST as u32) as usize);
        let mut held = vec![false; steps.iter().product()];
        let row_words = cells.words_per_row().max(1) as usize;
        for (row, words) in cells.words().chunks_exact(row_words).enumerate() {
            let (y, z) = (row % window.size[1] as usize, row / window.size[1] as usize);
            let edge = LARGEST as usize;
            let first = (z / edge * steps[1] + y / edge) * steps[0];
            for x in 0..steps[0] {
                held[first + x] |= words[x * edge / 32] >> (x * edge % 32) & ((1 << edge) - 1) != 0;
            }
        }
        let at = |i: usize| [i % steps[0], i / steps[0] % steps[1], i / steps[0] / steps[1]];
        let corner = |i| std::array::from_fn(|r| window.min[r] + at(i)[r] as i32 * LARGEST);
        let boxes = (0..held.len()).filter(|&i| held[i]).map(corner).collect();
        Wanted { cells, boxes }
    }
}

/// Which way is cheaper for a table in a window. To walk a cell costs about as much as to decide a voxel,
/// since most voxels are decided with many others.
pub(super) fn carving(bundles: &Bundles, window: Window) -> Carving {
    let across: u64 = window.size.iter().map(|&n| u64::from(n)).sum::<u64>() / 2;
    let walked = bundles.rays() as u64 * across;
    match bundles.image() {
        Some(_) if walked > window.volume() => Carving::Gather,
        _ => Carving::Walk,
    }
}
