//! How far a ray may leap: bricks of 2 × 2 × 2 voxels, each knowing how far away the nearest brick with a
//! blocker is.
//!
//! # Theory
//! The chessboard distance of two bricks is the largest of their distances along the axes. If the nearest
//! brick with a blocker is `k` away, the cube of (2k − 1)³ bricks around a brick holds no blocker, so no
//! voxel in it can stop a ray (`SEMANTICS.md`, "Rays"). This distance is the length of a shortest path through the 26
//! neighbours. Its steps may be taken in any order, inside the box that both bricks span, so first all those towards higher
//! z (in one layer higher y, in one row higher x) and then all those back: one pass over the bricks in their order takes
//! the first, one in the opposite order the others (Rosenfeld and Pfaltz, Pattern Recognition 1, 1968).
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
        let occupied = occupied_bricks(blockers);
        let size = occupied.window().size;
        let mut reach = unpack(&occupied);
        let [nx, ny, nz] = size.map(|n| n as usize);
        if !reach.is_empty() {
            let mut nearest = vec![Self::FAR; nx];
            for row in 0..ny * nz {
                approach(&mut reach, &mut nearest, row, neighbours_before(row, [ny, nz]));
                spread(&mut reach[row * nx..][..nx]);
            }
            for row in (0..ny * nz).rev() {
                approach(&mut reach, &mut nearest, row, neighbours_behind(row, [ny, nz]));
                spread(&mut reach[row * nx..][..nx]);
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

/// 0 for each brick of a set, and [`Bricks::FAR`] for the others.
fn unpack(bricks: &BitGrid) -> Vec<u8> {
    let nx = bricks.window().size[0] as usize;
    let rows = bricks.words().chunks_exact(bricks.words_per_row().max(1) as usize);
    let of_row = |row: &[u32], x: usize| if row[x / 32] >> (x % 32) & 1 == 1 { 0 } else { Bricks::FAR };
    rows.flat_map(|row| (0..nx).map(move |x| of_row(row, x))).collect()
}

/// The rows of bricks beside a row that come before it: three of the layer below, and one of its own.
fn neighbours_before(row: usize, [ny, _]: [usize; 2]) -> [Option<usize>; 4] {
    let (y, has_layer) = (row % ny, row >= ny);
    let below = |is_there: bool, ahead: usize| (has_layer && is_there).then(|| row - ny + ahead - 1);
    [below(y > 0, 0), below(true, 1), below(y + 1 < ny, 2), (y > 0).then(|| row - 1)]
}

/// The same of those that come after it.
fn neighbours_behind(row: usize, [ny, nz]: [usize; 2]) -> [Option<usize>; 4] {
    let (y, has_layer) = (row % ny, row / ny + 1 < nz);
    let above = |is_there: bool, ahead: usize| (has_layer && is_there).then(|| row + ny + ahead - 1);
    [above(y > 0, 0), above(true, 1), above(y + 1 < ny, 2), (y + 1 < ny).then(|| row + 1)]
}

/// Brings the bricks of a row as near as those beside them in other rows let them be. `nearest` is room for a row.
fn approach(reach: &mut [u8], nearest: &mut [u8], row: usize, others: [Option<usize>; 4]) {
    let nx = nearest.len();
    nearest.fill(Bricks::FAR);
    for other in others.into_iter().flatten() {
        let other = &reach[other * nx..][..nx];
        nearest.iter_mut().zip(other).for_each(|(to, from)| *to = (*to).min(*from));
    }
    let own = &mut reach[row * nx..][..nx];
    let lower = |own: &mut [u8], from: &[u8]| {
        own.iter_mut().zip(from).for_each(|(to, from)| *to = (*to).min(from.saturating_add(1)));
    };
    lower(own, nearest);
    lower(&mut own[1..], nearest);
    lower(own, &nearest[1..]);
}

/// Brings the bricks of a row as near as those beside them in it let them be.
fn spread(row: &mut [u8]) {
    let mut before = Bricks::FAR;
    for to in row.iter_mut() {
        before = (*to).min(before.saturating_add(1));
        *to = before;
    }
    let mut behind = Bricks::FAR;
    for to in row.iter_mut().rev() {
        behind = (*to).min(behind.saturating_add(1));
        *to = behind;
    }
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
