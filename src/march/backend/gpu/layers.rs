//! Layers of blockers on the device.

use std::cell::OnceCell;
use std::sync::Arc;

use super::device::GpuDevice;
use crate::backend::{Shades, VoxelScene};
use crate::voxel::{BitGrid, Bricks};

// Half a word holds a bit for each voxel of a brick, and a byte.
const _: () = assert!(Bricks::EDGE == 2);

/// A layer that is uploaded when it is first asked for: of a scene with snapshots, first hits mostly need the others only.
pub(super) struct LazyLayer {
    blockers: Arc<BitGrid>,
    shades: Option<Arc<Shades>>,
    buffer: OnceCell<wgpu::Buffer>,
}

impl LazyLayer {
    /// All blockers of a scene.
    pub(super) fn new(scene: &VoxelScene) -> LazyLayer {
        LazyLayer { blockers: scene.blockers.clone(), shades: scene.shades.clone(), buffer: OnceCell::new() }
    }

    /// Whether it has shades.
    pub(super) fn is_shaded(&self) -> bool {
        self.shades.is_some()
    }

    /// Uploads the words of the layer, which are made already.
    pub(super) fn fill(&self, device: &GpuDevice, words: &[u32]) {
        self.buffer.get_or_init(|| device.upload("blockers", words));
    }

    /// The blockers, their bricks, and shades.
    pub(super) fn buffer(&self, device: &GpuDevice) -> &wgpu::Buffer {
        let words = || layer_words(&self.blockers, self.shades.as_deref());
        self.buffer.get_or_init(|| device.upload("blockers", &words()))
    }
}

/// A layer of blockers as `shaders/layer.wgsl` reads it: its words, then its bricks, two a word, then the two planes of
/// shades, if there are any.
pub(super) fn layer_words(blockers: &BitGrid, shades: Option<&Shades>) -> Vec<u32> {
    let bricks = Bricks::new(blockers);
    let mut halves: Vec<u32> = bricks.reach().iter().map(|&reach| u32::from(reach) << 8).collect();
    let [_, ny, _] = blockers.window().size;
    let row_words = blockers.words_per_row().max(1) as usize;
    for (row, words) in blockers.words().chunks_exact(row_words).enumerate() {
        let (y, z) = (row as u32 % ny, row as u32 / ny);
        // The voxels of a brick's row are two bits.
        let place = Bricks::EDGE * (y % Bricks::EDGE + Bricks::EDGE * (z % Bricks::EDGE));
        for (w, &word) in words.iter().enumerate().filter(|(_, word)| **word != 0) {
            let first = bricks.index_at([32 * w as i32, y as i32, z as i32]);
            for brick in (0..16).filter(|brick| word >> (2 * brick) & 3 != 0) {
                halves[first + brick] |= (word >> (2 * brick) & 3) << place;
            }
        }
    }
    let two = |halves: &[u32]| halves.iter().rev().fold(0, |word, half| word << 16 | half);
    let shades = shades.into_iter().flat_map(|shades| &shades.bits).flat_map(|plane| plane.words());
    blockers.words().iter().copied().chain(halves.chunks(2).map(two)).chain(shades.copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxel::Window;

    #[test]
    fn a_brick_holds_the_bit_of_each_of_its_voxels() {
        for (size, step) in [([1, 1, 1], 1), ([67, 5, 4], 3), ([64, 3, 7], 11), ([31, 8, 2], 2)] {
            let mut plane = BitGrid::new(Window { min: [0; 3], size });
            BitGrid::full(plane.window()).voxels().step_by(step).for_each(|voxel| plane.set(voxel));
            let (bricks, words) = (Bricks::new(&plane), layer_words(&plane, None));
            let (voxels, bricks_words) = words.split_at(plane.words().len());
            assert_eq!(voxels, plane.words());
            assert_eq!(bricks_words.len(), bricks.reach().len().div_ceil(2));
            let half = |brick: usize| bricks_words[brick / 2] >> (16 * (brick % 2)) & 0xffff;
            let mut expected: Vec<u32> = bricks.reach().iter().map(|&reach| u32::from(reach) << 8).collect();
            for voxel @ [x, y, z] in plane.voxels() {
                expected[bricks.index_at(voxel)] |= 1 << (x % 2 + 2 * (y % 2) + 4 * (z % 2));
            }
            let found: Vec<u32> = (0..expected.len()).map(half).collect();
            assert_eq!(found, expected, "{size:?}");
        }
    }
}
