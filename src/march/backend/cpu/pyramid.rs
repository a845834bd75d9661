//! How many voxels each pixel of a camera frees, as an image, and the least and most of them over blocks of
//! pixels.
//!
//! # Theory
//! Blocks that hold a rectangle have a least that is at most the rectangle's, and a most that is at least
//! the rectangle's: an error can only leave a box undecided. Pixels that were not cast free nothing, which
//! can only lower a least, or all that matters (`beyond`). The nearer the blocks come to the rectangle, the more
//! boxes are decided whole, above all where noise makes neighbouring pixels differ: so blocks of two and of four
//! times a level's size begin wherever one of its own does, and overlap.
//!
//! # Practice
//! Made once a pose, for `carve_voxels`: a rectangle of any size is looked up in four blocks.

use fearless_simd::{Level as Vectors, Simd, dispatch};

use super::packet::{Lanes, RAYS, TILE};
use crate::backend::Image;

/// Levels above the pixels; the highest has blocks of 2⁶ pixels on an axis, and wider ones of up to four times that.
const LEVELS: usize = 6;

/// The level whose blocks are tiles.
const TILES: usize = TILE.ilog2() as usize;

/// The widest blocks, in blocks.
const WIDEST: usize = 4;

/// The image and its levels.
pub(super) struct Pyramid {
    /// Tiles side by side.
    across: u32,
    /// Tile by tile; what is past the edge of the image frees what the pixel before it frees.
    tiles: Vec<Lanes<u16>>,
    /// Blocks of 2, 4, 8, … pixels.
    levels: Vec<Level>,
}

/// What the pixels of a block free: the least, and what the most leaves of the largest number, so that both are least.
type FreedRange = [u16; 2];

/// Of no pixels at all.
const NOTHING: FreedRange = [u16::MAX; 2];

/// Blocks of one size, row by row, and wider ones that begin where they do.
struct Level {
    /// Blocks of the image on each axis. The lists have [`WIDEST`] more, of no pixels, so that no wider block ends outside.
    size: [usize; 2],
    single: Vec<FreedRange>,
    double: Vec<FreedRange>,
    quadruple: Vec<FreedRange>,
}

impl Level {
    fn new(size: [usize; 2]) -> Level {
        let blocks = vec![NOTHING; size.map(|n| n + WIDEST).iter().product()];
        Level { size, single: blocks.clone(), double: blocks.clone(), quadruple: blocks }
    }

    /// Blocks from one row to the next.
    #[inline(always)]
    fn row(&self) -> usize {
        self.size[0] + WIDEST
    }

    /// Makes the wider blocks.
    #[inline(always)]
    fn widen<S: Simd>(&mut self, _: S) {
        let row = self.row();
        widen(&self.single, 1, row, self.size[1], &mut self.double);
        widen(&self.double, 2, row, self.size[1], &mut self.quadruple);
    }

    /// Makes the blocks, from the wider ones of the level below.
    fn take(&mut self, below: &Level) {
        let row = self.row();
        for (v, to) in self.single.chunks_exact_mut(row).take(self.size[1]).enumerate() {
            let from = &below.double[2 * v * below.row()..][..below.row()];
            to.iter_mut().zip(from.iter().step_by(2)).take(self.size[0]).for_each(|(to, from)| *to = *from);
        }
    }
}

/// Joins blocks with those so many to the right and below.
#[inline(always)]
fn widen(blocks: &[FreedRange], by: usize, row: usize, rows: usize, wider: &mut [FreedRange]) {
    let ends = (row - by) * 2;
    for (v, to) in wider.as_flattened_mut().chunks_exact_mut(2 * row).take(rows).enumerate() {
        let [upper, lower] = [v, v + by].map(|v| blocks[v * row..][..row].as_flattened());
        let (left, right) =
            (upper[..ends].iter().zip(&lower[..ends]), upper[2 * by..].iter().zip(&lower[2 * by..]));
        for (to, ((a, b), (c, d))) in to.iter_mut().zip(left.zip(right)) {
            *to = (*a).min(*b).min((*c).min(*d));
        }
    }
}

/// Pixels from the first to the last on each axis, both included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rect {
    pub(super) first: [u32; 2],
    pub(super) last: [u32; 2],
}

impl Rect {
    /// The columns and rows of a tile in which it lies, from the tile's first on.
    #[inline]
    pub(super) fn tile_overlap(&self, tile: [u32; 2]) -> [std::ops::Range<u32>; 2] {
        std::array::from_fn(|a| {
            let first = tile[a] * TILE;
            self.first[a].max(first) - first..(self.last[a] + 1).min(first + TILE) - first
        })
    }

    /// Those of its pixels that lie in a tile, as lanes of it.
    pub(super) fn part(&self, tile: [u32; 2]) -> impl Iterator<Item = usize> {
        let [columns, rows] = self.tile_overlap(tile);
        rows.flat_map(move |v| columns.clone().map(move |u| (v * TILE + u) as usize))
    }
}

impl Pyramid {
    /// No pixel frees anything.
    pub(super) fn new(image: &Image) -> Self {
        let [across, down] = image.size_px.map(|n| n.div_ceil(TILE));
        let level = |k: usize| Level::new([across, down].map(|n| (n * TILE).div_ceil(1 << k) as usize));
        let tiles = vec![[0; RAYS]; across as usize * down as usize];
        Pyramid { across, tiles, levels: (1..=LEVELS).map(level).collect() }
    }

    /// Forgets all pixels.
    pub(super) fn clear(&mut self) {
        self.tiles.fill([0; RAYS]);
    }

    /// What a pixel frees.
    #[inline]
    pub(super) fn get(&self, [u, v]: [u32; 2]) -> u32 {
        self.tile([u / TILE, v / TILE])[(v % TILE * TILE + u % TILE) as usize].into()
    }

    /// The most over a block of pixels about one of them that reaches no farther than so many pixels beside it.
    #[inline]
    pub(super) fn most_about(&self, [u, v]: [u32; 2], beside: u32) -> u32 {
        match (beside + 1).ilog2().min(LEVELS as u32) {
            0 => self.get([u, v]),
            k => {
                let level = &self.levels[k as usize - 1];
                let [_, rest] = level.single[(v >> k) as usize * level.row() + (u >> k) as usize];
                (!rest).into()
            }
        }
    }

    /// What the pixels of a tile free, from its column and row.
    #[inline]
    pub(super) fn tile(&self, [u, v]: [u32; 2]) -> &Lanes<u16> {
        &self.tiles[(v * self.across + u) as usize]
    }

    /// Sets what the pixels of a tile free.
    pub(super) fn set_tile(&mut self, tile: usize, freed: &Lanes<u32>) {
        self.tiles[tile] = freed.map(|freed| freed as u16);
    }

    /// Makes the levels from the pixels.
    pub(super) fn build(&mut self, vectors: Vectors) {
        let first = &mut self.levels[0];
        let (row, half) = (first.row(), TILE as usize / 2);
        for (i, tile) in self.tiles.iter().enumerate() {
            let [u, v] = [i % self.across as usize * half, i / self.across as usize * half];
            for (down, pixels) in tile.as_chunks::<{ 2 * TILE as usize }>().0.iter().enumerate() {
                let own = &mut first.single[(v + down) * row + u..][..half];
                for (k, block) in own.iter_mut().enumerate() {
                    let [upper, lower] = [2 * k, 2 * k + TILE as usize];
                    let [a, b, c, d] = [upper, upper + 1, lower, lower + 1].map(|i| pixels[i]);
                    *block = [a.min(b).min(c.min(d)), !a.max(b).max(c.max(d))];
                }
            }
        }
        for k in 0..LEVELS {
            let (below, above) = self.levels.split_at_mut(k);
            if let Some(below) = below.last() {
                above[0].take(below);
            }
            dispatch!(vectors, simd => above[0].widen(simd));
        }
    }

    /// The tiles in which a rectangle lies, by column and row, that have a pixel which frees more than `away` voxels.
    pub(super) fn tiles(&self, rect: &Rect, away: u32) -> impl Iterator<Item = [u32; 2]> {
        let [columns, rows] = std::array::from_fn(|a| rect.first[a] / TILE..=rect.last[a] / TILE);
        let level = &self.levels[TILES - 1];
        let tiles = rows.flat_map(move |v| columns.clone().map(move |u| [u, v]));
        tiles.filter(move |&[u, v]| {
            let [_, rest] = level.single[v as usize * level.row() + u as usize];
            u32::from(!rest) > away
        })
    }

    /// Least and most over a rectangle, or over a little more: the four blocks at its corners hold it.
    #[inline]
    pub(super) fn range(&self, rect: &Rect) -> [u32; 2] {
        let beyond = (rect.last[0] - rect.first[0]).max(rect.last[1] - rect.first[1]);
        if beyond < 2 {
            let ([left, top], [right, bottom]) = (rect.first, rect.last);
            let [a, b, c, d] =
                [[left, top], [right, top], [left, bottom], [right, bottom]].map(|pixel| self.get(pixel));
            return [a.min(b).min(c.min(d)), a.max(b).max(c.max(d))];
        }
        // Blocks so wide that two of them, side by side, are as wide as what it may lie in.
        let k = if beyond <= 6 {
            1
        } else {
            (beyond.div_ceil(7) - 1).checked_ilog2().map_or(1, |k| k as usize + 1)
        };
        if k > LEVELS {
            return [0, u16::MAX.into()];
        }
        let level = &self.levels[k - 1];
        let (blocks, wide) = if beyond <= 6 { (&level.double, 2) } else { (&level.quadruple, WIDEST as u32) };
        let first = rect.first.map(|x| x >> k);
        let last: [u32; 2] =
            std::array::from_fn(|a| first[a].max((rect.last[a] >> k).saturating_sub(wide - 1)));
        let block = |u: u32, v: u32| blocks[v as usize * level.row() + u as usize];
        let and = |a: FreedRange, b: FreedRange| [a[0].min(b[0]), a[1].min(b[1])];
        let upper = and(block(first[0], first[1]), block(last[0], first[1]));
        let [least, rest] = and(upper, and(block(first[0], last[1]), block(last[0], last[1])));
        [least.into(), (!rest).into()]
    }
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    #[test]
    fn blocks_hold_their_rectangle_and_little_more() {
        let mut random = ChaCha8Rng::seed_from_u64(19);
        let mut below = |n: u32| random.next_u32() % n;
        for size_px in [[1, 1], [3, 90], [64, 8], [83, 61], [500, 300]] {
            let mut pyramid = Pyramid::new(&Image { size_px, focal_px: [1.0; 2] });
            for tile in 0..pyramid.tiles.len() {
                pyramid.set_tile(tile, &std::array::from_fn(|_| below(1 << 16)));
            }
            pyramid.build(Vectors::new());
            // All that the pyramid holds, from a pixel to a pixel; tiles reach past the edge of the image.
            let range = |first: [u32; 2], last: [u32; 2]| {
                let [across, down] = size_px.map(|n| n.next_multiple_of(TILE) - 1);
                let rows = first[1]..=last[1].min(down);
                let pixels = rows.flat_map(|v| (first[0]..=last[0].min(across)).map(move |u| [u, v]));
                let freed: Vec<u32> = pixels.map(|pixel| pyramid.get(pixel)).collect();
                [*freed.iter().min().unwrap(), *freed.iter().max().unwrap()]
            };
            for turn in 0..2000 {
                let most = 1 + below([40, 440][turn % 2]);
                let first = size_px.map(&mut below);
                let last = std::array::from_fn(|a| (first[a] + below(most)).min(size_px[a] - 1));
                let rect = Rect { first, last };
                let [least, most] = pyramid.range(&rect);
                let [own_least, own_most] = range(first, last);
                assert!(least <= own_least && most >= own_most, "{rect:?} of {size_px:?}");
                // Little more than the square on the longer edge: by three pixels, or a third of that edge.
                let edge = (last[0] - first[0]).max(last[1] - first[1]);
                let by = (edge / 3).max(3);
                let [grown_least, grown_most] =
                    range(first.map(|x| x.saturating_sub(by)), first.map(|x| x + edge + by));
                assert!(least >= grown_least && most <= grown_most, "{rect:?} of {size_px:?}");
            }
        }
    }
}
