//! How far a ray may leap: bricks of 2 × 2 × 2 voxels, each knowing how far away the nearest brick with a
//! blocker is.
//!
//! # Theory
//! The chessboard distance of two bricks is the largest of their distances along the axes. If the nearest
//! brick with a blocker is `k` away, the cube of (2k − 1)³ bricks around a brick holds no blocker, so no
//! voxel in it can stop a ray (`SEMANTICS.md`, "Rays"). Growing a set of bricks by one on each axis in turn
//! reaches exactly the bricks at chessboard distance 1, so counting how often the occupied ones must grow
//! until they hold a brick gives its distance: a few operations a word of 32 bricks and step, and as many
//! steps as the largest gap has bricks.
//!
//! # Practice
//! Made once for each layer of blockers, on the host; every backend that leaps reads the same bytes.

use super::BitGrid;
use super::grid::Window;

/// A layer of blockers in bricks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Bricks {
    size: [u32; 3],
    reach: Vec<u8>,
}

impl Bricks {
    /// Voxels along the edge of a brick.
    pub(crate) const EDGE: u32 = 1 << Self::EDGE_LOG2;

    /// Its logarithm: brick = voxel >> this.
    pub(crate) const EDGE_LOG2: u32 = 1;

    /// The reach of a brick whose nearest blocker is this far away or farther.
    pub(crate) const FAR: u8 = u8::MAX;

    /// The bricks of a plane over a grid; voxels outside the plane count as empty.
    pub(crate) fn new(blockers: &BitGrid) -> Self {
        let mut grown = occupied_bricks(blockers);
        let size = grown.window().size;
        let mut reach = vec![Self::FAR; size.iter().map(|&n| n as usize).product()];
        mark(&mut reach, &grown, None, 0);
        for distance in 1..Self::FAR {
            let before = grown.clone();
            grow(&mut grown);
            if !mark(&mut reach, &grown, Some(&before), distance) {
                break;
            }
        }
        Bricks { size, reach }
    }

    /// Bricks on each axis of a grid of so many voxels.
    pub(crate) fn size_of(voxels: [u32; 3]) -> [u32; 3] {
        voxels.map(|n| n.div_ceil(Self::EDGE))
    }

    /// Bricks on each axis.
    #[cfg(test)]
    pub(crate) fn size(&self) -> [u32; 3] {
        self.size
    }

    /// For each brick, x fastest, then y, then z: the chessboard distance in bricks to the nearest brick that
    /// holds a blocker, 0 in one that does; [`Bricks::FAR`] for any distance from there on.
    #[cfg(any(test, feature = "gpu"))]
    pub(crate) fn reach(&self) -> &[u8] {
        &self.reach
    }

    /// Which brick holds a voxel of the grid, in the order of [`Bricks::reach`].
    pub(crate) fn index_at(&self, voxel: [i32; 3]) -> usize {
        let [x, y, z] = voxel.map(|c| c as usize >> Self::EDGE_LOG2);
        (z * self.size[1] as usize + y) * self.size[0] as usize + x
    }

    /// The reach of the brick that holds a voxel of the grid.
    pub(crate) fn reach_at(&self, voxel: [i32; 3]) -> u32 {
        self.reach[self.index_at(voxel)] as u32
    }
}

/// The bricks that hold a set voxel.
fn occupied_bricks(blockers: &BitGrid) -> BitGrid {
    let [_, ny, nz] = blockers.window().size;
    let size = Bricks::size_of(blockers.window().size);
    let mut bricks = BitGrid::new(Window { min: [0; 3], size });
    let words_per_row = bricks.words_per_row() as usize;
    let voxels_per_row = blockers.words_per_row().max(1) as usize;
    for (row, words) in blockers.words().chunks_exact(voxels_per_row).enumerate() {
        let (y, z) = (row as u32 % ny, row as u32 / ny);
        debug_assert!(z < nz, "as many rows as the plane has");
        let brick_row = (z / Bricks::EDGE * size[1] + y / Bricks::EDGE) as usize * words_per_row;
        for (w, &word) in words.iter().enumerate() {
            bricks.words_mut()[brick_row + w / 2] |= pairs(word) << (w % 2 * 16);
        }
    }
    bricks
}

/// A bit for each two bits of a word, set if either of them is.
fn pairs(word: u32) -> u32 {
    let any = (word | word >> 1) & 0x5555_5555;
    let twos = (any | any >> 1) & 0x3333_3333;
    let fours = (twos | twos >> 2) & 0x0f0f_0f0f;
    let eights = (fours | fours >> 4) & 0x00ff_00ff;
    (eights | eights >> 8) & 0xffff
}

/// Adds all 26 neighbours of every brick of a set: along x, then of those along y, then along z.
fn grow(bricks: &mut BitGrid) {
    bricks.spread_x();
    let [_, ny, nz] = bricks.window().size.map(|n| n as usize);
    let row = bricks.words_per_row() as usize;
    let before = bricks.words().to_vec();
    let words = bricks.words_mut();
    join(words, &before, row, |r| (r % ny > 0, r % ny + 1 < ny));
    let before = words.to_vec();
    join(words, &before, row * ny, |layer| (layer > 0, layer + 1 < nz));
}

/// Adds to each chunk of words what the chunks before and after it held; `beside` says which of them are
/// neighbours.
fn join(words: &mut [u32], before: &[u32], chunk: usize, beside: impl Fn(usize) -> (bool, bool)) {
    for (i, to) in words.chunks_exact_mut(chunk.max(1)).enumerate() {
        let (below, above) = beside(i);
        let mut add = |from: usize| {
            let from = &before[from * chunk..(from + 1) * chunk];
            to.iter_mut().zip(from).for_each(|(to, from)| *to |= from);
        };
        if below {
            add(i - 1);
        }
        if above {
            add(i + 1);
        }
    }
}

/// Writes a distance to the bricks that are new in a set; whether there were any.
fn mark(reach: &mut [u8], grown: &BitGrid, before: Option<&BitGrid>, distance: u8) -> bool {
    let [nx, ..] = grown.window().size.map(|n| n as usize);
    let row = grown.words_per_row().max(1) as usize;
    let mut any = false;
    for (w, &word) in grown.words().iter().enumerate() {
        let mut new = word & !before.map_or(0, |before| before.words()[w]);
        any |= new != 0;
        let first = w / row * nx + w % row * 32;
        while new != 0 {
            reach[first + new.trailing_zeros() as usize] = distance;
            new &= new - 1;
        }
    }
    any
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(size: [u32; 3], voxels: &[[i32; 3]]) -> BitGrid {
        let mut plane = BitGrid::new(Window { min: [0; 3], size });
        voxels.iter().for_each(|&voxel| plane.set(voxel));
        plane
    }

    #[test]
    fn a_brick_is_as_far_as_its_farthest_axis() {
        // 3 × 2 × 2 bricks, the last of x one voxel wide; the blocker is in brick (0, 1, 0).
        let bricks = Bricks::new(&plane([5, 4, 4], &[[1, 2, 0]]));
        assert_eq!(bricks.size(), [3, 2, 2]);
        assert_eq!(bricks.reach(), [1, 1, 2, 0, 1, 2, 1, 1, 2, 1, 1, 2]);
        assert_eq!((bricks.reach_at([1, 3, 1]), bricks.reach_at([4, 3, 3])), (0, 2));
    }

    #[test]
    fn nothing_is_far() {
        assert!(Bricks::new(&plane([40, 3, 9], &[])).reach().iter().all(|&reach| reach == Bricks::FAR));
        // 300 bricks in a row: the 256th is exactly as far as FAR says.
        let row = Bricks::new(&plane([600, 1, 1], &[[0, 0, 0]]));
        let expected: Vec<u8> = (0..300).map(|x| x.min(255) as u8).collect();
        assert_eq!(row.reach(), expected);
        assert!(Bricks::new(&plane([0, 3, 9], &[])).reach().is_empty());
    }

    #[test]
    fn each_voxel_of_a_row_has_its_brick() {
        for x in 0..130 {
            let bricks = Bricks::new(&plane([130, 1, 1], &[[x, 0, 0]]));
            let nearest = bricks.reach().iter().position(|&reach| reach == 0);
            assert_eq!(nearest, Some(x as usize / 2), "voxel {x}");
            assert_eq!(bricks.reach().iter().filter(|&&reach| reach == 0).count(), 1, "voxel {x}");
        }
    }

    /// Every brick against the distances to all occupied bricks, on planes with a few voxels and on full
    /// ones.
    #[test]
    fn reach_is_the_smallest_distance() {
        let mut state = 1u64;
        let mut random = move |n: u32| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) % n as u64) as i32
        };
        for case in 0..60 {
            let size = [90, 30, 30].map(|n| 1 + random(n) as u32);
            let voxels: Vec<_> = (0..[1, 3, 40][case % 3]).map(|_| size.map(&mut random)).collect();
            let bricks = Bricks::new(&plane(size, &voxels));
            let [nx, ny, nz] = bricks.size().map(|n| n as i32);
            for z in 0..nz {
                for y in 0..ny {
                    for x in 0..nx {
                        let far = |c: &[i32; 3]| {
                            (c[0] / 2 - x).abs().max((c[1] / 2 - y).abs()).max((c[2] / 2 - z).abs())
                        };
                        let expected = voxels.iter().map(far).min().unwrap_or(255) as u32;
                        assert_eq!(
                            bricks.reach_at([2 * x, 2 * y, 2 * z]),
                            expected,
                            "{x} {y} {z} of {size:?}"
                        );
                    }
                }
            }
        }
    }
}
