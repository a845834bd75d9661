//! How many voxels each pixel of a camera frees, as an image, and the least and most of them over blocks of
//! pixels.
//!
//! # Theory
//! A block that holds a rectangle has a least that is at most the rectangle's, and a most that is at least
//! the rectangle's: an error can only leave a box undecided. Pixels that were not cast free nothing, which
//! can only lower a least.
//!
//! # Practice
//! Made once a pose, for `carve_voxels`: a rectangle of any size is looked up in four blocks.

use super::packet::{Lanes, TILE};
use crate::backend::Image;

/// Levels above the pixels; the highest has blocks of 2⁸ pixels.
const LEVELS: usize = 8;

/// The level by whose blocks pixels are searched.
const SEARCHED: usize = 3;

/// The image and its levels.
pub(super) struct Pyramid {
    width: usize,
    pixels: Vec<u16>,
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

impl Pyramid {
    /// No pixel frees anything.
    pub(super) fn new(image: &Image) -> Self {
        let level = |k: usize| {
            let size = image.size_px.map(|n| n.div_ceil(1 << k));
            Level { size, blocks: vec![FreedRange::of(0); size[0] as usize * size[1] as usize] }
        };
        let pixels = vec![0; image.size_px[0] as usize * image.size_px[1] as usize];
        Pyramid { width: image.size_px[0] as usize, pixels, levels: (1..=LEVELS).map(level).collect() }
    }

    /// Forgets all pixels.
    pub(super) fn clear(&mut self) {
        self.pixels.fill(0);
    }

    /// What a pixel frees.
    #[inline]
    pub(super) fn get(&self, [u, v]: [u32; 2]) -> u32 {
        self.pixels[v as usize * self.width + u as usize].into()
    }

    /// A part of a row of pixels, the last included.
    #[inline]
    pub(super) fn row(&self, v: u32, first: u32, last: u32) -> &[u16] {
        let start = v as usize * self.width;
        &self.pixels[start + first as usize..=start + last as usize]
    }

    /// Sets what the pixels of a tile free, as far as it lies in the image.
    pub(super) fn set_tile(&mut self, tile: usize, freed: &Lanes<u32>) {
        let (edge, height) = (TILE as usize, self.pixels.len() / self.width);
        let across = self.width.div_ceil(edge);
        let [left, top] = [tile % across * edge, tile / across * edge];
        let right = (left + edge).min(self.width);
        for (v, freed) in (top..height).zip(freed.chunks_exact(edge)) {
            let row = &mut self.pixels[v * self.width..][left..right];
            row.iter_mut().zip(freed).for_each(|(pixel, &freed)| *pixel = freed as u16);
        }
    }

    /// Makes the levels from the pixels.
    pub(super) fn build(&mut self) {
        reduce(&self.pixels, self.width, FreedRange::of, &mut self.levels[0]);
        for k in 1..LEVELS {
            let (below, above) = self.levels.split_at_mut(k);
            let Level { size, blocks } = &below[k - 1];
            reduce(blocks, size[0] as usize, |block| block, &mut above[0]);
        }
    }

    /// A rectangle cut into parts that each lie in one block of 2³ pixels.
    pub(super) fn blocks(&self, rect: &Rect) -> impl Iterator<Item = Rect> {
        let [columns, rows] = std::array::from_fn(|a| rect.first[a] >> SEARCHED..=rect.last[a] >> SEARCHED);
        let rect = *rect;
        rows.flat_map(move |v| {
            columns.clone().map(move |u| {
                let block = [u, v];
                Rect {
                    first: std::array::from_fn(|a| rect.first[a].max(block[a] << SEARCHED)),
                    last: std::array::from_fn(|a| rect.last[a].min(((block[a] + 1) << SEARCHED) - 1)),
                }
            })
        })
    }

    /// Most over the block that a part of [`Pyramid::blocks`] lies in.
    #[inline]
    pub(super) fn most(&self, part: &Rect) -> u32 {
        let level = &self.levels[SEARCHED - 1];
        let [u, v] = part.first.map(|x| x >> SEARCHED);
        level.blocks[(v * level.size[0] + u) as usize].most.into()
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
            0 => FreedRange::of(self.pixels[v as usize * self.width + u as usize]),
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
fn reduce<T: Copy>(below: &[T], width: usize, block: impl Fn(T) -> FreedRange, above: &mut Level) {
    let height = below.len() / width;
    for (v, row) in above.blocks.chunks_exact_mut(above.size[0] as usize).enumerate() {
        let upper = &below[2 * v * width..][..width];
        // At the lower edge a row stands alone, at the right edge a column.
        let lower = &below[(2 * v + 1).min(height - 1) * width..][..width];
        for (u, to) in row.iter_mut().enumerate() {
            let (left, right) = (2 * u, (2 * u + 1).min(width - 1));
            *to =
                block(upper[left]).and(block(upper[right])).and(block(lower[left]).and(block(lower[right])));
        }
    }
}
