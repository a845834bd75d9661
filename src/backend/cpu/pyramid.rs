//! How many voxels each pixel of a camera frees, as an image, and the least and most of them over blocks of
//! pixels.
//!
//! # Theory
//! A block that holds a rectangle has a least that is at most the rectangle's, and a most that is at least
//! the rectangle's: an error can only leave a box undecided. Pixels that were not cast free nothing, which
//! can only lower a least, or all that matters (`beyond`).
//!
//! # Practice
//! Made once a pose, for `carve_voxels`: a rectangle of any size is looked up in four blocks.

use super::packet::{Lanes, RAYS, TILE};
use crate::backend::Image;

/// Levels above the pixels; the highest has blocks of 2⁸ pixels.
const LEVELS: usize = 8;

/// The level whose blocks are tiles.
const TILES: usize = TILE.ilog2() as usize;

/// The image and its levels.
pub(super) struct Pyramid {
    /// Tiles side by side.
    across: u32,
    /// Tile by tile; what is past the edge of the image frees what the pixel before it frees.
    tiles: Vec<Lanes<u16>>,
    /// Blocks of 2, 4, 8, … pixels.
    levels: Vec<Level>,
}

/// The blocks of one size, row by row.
struct Level {
    size: [u32; 2],
    blocks: Vec<FreedRange>,
}

/// What the pixels of a block free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct FreedRange {
    least: u16,
    most: u16,
}

impl FreedRange {
    fn of(freed: u16) -> FreedRange {
        FreedRange { least: freed, most: freed }
    }

    #[inline]
    fn and(self, other: FreedRange) -> FreedRange {
        FreedRange { least: self.least.min(other.least), most: self.most.max(other.most) }
    }
}

/// Pixels from the first to the last on each axis, both included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rect {
    pub(super) first: [u32; 2],
    pub(super) last: [u32; 2],
}

impl Rect {
    /// Those of its pixels that lie in a tile, as lanes of it.
    pub(super) fn part(&self, tile: [u32; 2]) -> impl Iterator<Item = usize> {
        let [columns, rows]: [std::ops::Range<u32>; 2] = std::array::from_fn(|a| {
            let first = tile[a] * TILE;
            self.first[a].max(first) - first..(self.last[a] + 1).min(first + TILE) - first
        });
        rows.flat_map(move |v| columns.clone().map(move |u| (v * TILE + u) as usize))
    }
}

impl Pyramid {
    /// No pixel frees anything.
    pub(super) fn new(image: &Image) -> Self {
        let [across, down] = image.size_px.map(|n| n.div_ceil(TILE));
        let level = |k: usize| {
            let size = [across, down].map(|n| (n * TILE).div_ceil(1 << k));
            Level { size, blocks: vec![FreedRange::of(0); size[0] as usize * size[1] as usize] }
        };
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
                level.blocks[((v >> k) * level.size[0] + (u >> k)) as usize].most.into()
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
    pub(super) fn build(&mut self) {
        let Level { size, blocks } = &mut self.levels[0];
        let half = TILE as usize / 2;
        for (i, tile) in self.tiles.iter().enumerate() {
            let [u, v] = [i % self.across as usize * half, i / self.across as usize * half];
            for (row, pixels) in tile.as_chunks::<{ 2 * TILE as usize }>().0.iter().enumerate() {
                let own = &mut blocks[(v + row) * size[0] as usize + u..][..half];
                for (k, block) in own.iter_mut().enumerate() {
                    let [upper, lower] = [2 * k, 2 * k + TILE as usize];
                    let [a, b, c, d] =
                        [upper, upper + 1, lower, lower + 1].map(|i| FreedRange::of(pixels[i]));
                    *block = a.and(b).and(c.and(d));
                }
            }
        }
        for k in 1..LEVELS {
            let (below, above) = self.levels.split_at_mut(k);
            reduce(&below[k - 1], &mut above[0]);
        }
    }

    /// The tiles in which a rectangle lies, by column and row, that have a pixel which frees more than `away` voxels.
    pub(super) fn tiles(&self, rect: &Rect, away: u32) -> impl Iterator<Item = [u32; 2]> {
        let [columns, rows] = std::array::from_fn(|a| rect.first[a] / TILE..=rect.last[a] / TILE);
        let level = &self.levels[TILES - 1];
        let tiles = rows.flat_map(move |v| columns.clone().map(move |u| [u, v]));
        tiles.filter(move |[u, v]| u32::from(level.blocks[(v * level.size[0] + u) as usize].most) > away)
    }

    /// Least and most over a rectangle, or over a little more: the four blocks at its corners hold it.
    #[inline]
    pub(super) fn range(&self, rect: &Rect) -> [u32; 2] {
        let across = (rect.last[0] - rect.first[0]).max(rect.last[1] - rect.first[1]);
        // Blocks at least as large as what lies between the corners, which so fall in the same block or in
        // neighbours.
        let k = if across < 2 { 0 } else { (u32::BITS - (across - 1).leading_zeros()) as usize };
        if k > LEVELS {
            return [0, u16::MAX.into()];
        }
        let block = |u: u32, v: u32| match k {
            0 => FreedRange::of(self.get([u, v]) as u16),
            _ => {
                let level = &self.levels[k - 1];
                level.blocks[((v >> k) * level.size[0] + (u >> k)) as usize]
            }
        };
        let ([left, top], [right, bottom]) = (rect.first, rect.last);
        let upper = block(left, top).and(block(right, top));
        let FreedRange { least, most } = upper.and(block(left, bottom)).and(block(right, bottom));
        [least.into(), most.into()]
    }
}

/// Makes the next level: blocks of 2 × 2, fewer at the edges.
fn reduce(below: &Level, above: &mut Level) {
    let [width, height] = below.size.map(|n| n as usize);
    for (v, row) in above.blocks.chunks_exact_mut(above.size[0] as usize).enumerate() {
        let upper = &below.blocks[2 * v * width..][..width];
        // At the lower edge a row stands alone, at the right edge a column.
        let lower = &below.blocks[(2 * v + 1).min(height - 1) * width..][..width];
        for (u, to) in row.iter_mut().enumerate() {
            let (left, right) = (2 * u, (2 * u + 1).min(width - 1));
            *to = upper[left].and(upper[right]).and(lower[left].and(lower[right]));
        }
    }
}
