//! How many cells each pixel of a camera frees, as an image, and the least and most of them over blocks of pixels. What a
//! block of pixels says about voxels is `gather`'s business.
//!
//! # Theory
//! The least of a block that holds a rectangle is at most the rectangle's least, and the most at least its most: both err on
//! the side that decides nothing. Pixels that were not cast free nothing, which at most lowers a least.

use crate::backend::Image;

/// Levels above the pixels; the highest has blocks of 2⁶ pixels.
const LEVELS: usize = 6;

/// Blocks on an axis that a rectangle may be looked up in.
const BLOCKS: u32 = 3;

/// The image and its levels.
pub(super) struct Pyramid {
    /// Level 0 has the pixels, each in both.
    levels: Vec<Level>,
}

/// The blocks of one size, row by row.
struct Level {
    size: [u32; 2],
    least: Vec<u16>,
    most: Vec<u16>,
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
            let blocks = size[0] as usize * size[1] as usize;
            Level { size, least: if k == 0 { vec![] } else { vec![0; blocks] }, most: vec![0; blocks] }
        };
        Pyramid { levels: (0..=LEVELS).map(level).collect() }
    }

    /// Forgets all pixels.
    pub(super) fn clear(&mut self) {
        self.levels[0].most.fill(0);
    }

    /// What a pixel frees.
    #[inline]
    pub(super) fn get(&self, [u, v]: [u32; 2]) -> u32 {
        self.levels[0].most[(v * self.levels[0].size[0] + u) as usize].into()
    }

    /// A row of pixels.
    #[inline]
    pub(super) fn row(&self, v: u32, first: u32, last: u32) -> &[u16] {
        let start = (v * self.levels[0].size[0]) as usize;
        &self.levels[0].most[start + first as usize..=start + last as usize]
    }

    /// Sets what pixel number `ray` frees.
    #[inline]
    pub(super) fn set(&mut self, ray: usize, freed: u32) {
        self.levels[0].most[ray] = freed as u16;
    }

    /// Makes the levels from the pixels.
    pub(super) fn build(&mut self) {
        for k in 1..=LEVELS {
            let (below, above) = self.levels.split_at_mut(k);
            reduce(&below[k - 1], &mut above[0]);
        }
    }

    /// Least and most over a rectangle, or over a little more.
    #[inline]
    pub(super) fn range(&self, rect: &Rect) -> [u32; 2] {
        let mut k = 0;
        while (0..2).any(|a| (rect.last[a] >> k) - (rect.first[a] >> k) >= BLOCKS) && k < LEVELS {
            k += 1;
        }
        let level = &self.levels[k];
        let least = if k == 0 { &level.most } else { &level.least };
        let (mut low, mut high) = (u16::MAX, 0);
        let columns = (rect.first[0] >> k) as usize..(rect.last[0] >> k) as usize + 1;
        for v in rect.first[1] >> k..=rect.last[1] >> k {
            let row = (v * level.size[0]) as usize;
            let part = row + columns.start..row + columns.end;
            least[part.clone()].iter().for_each(|&x| low = low.min(x));
            level.most[part].iter().for_each(|&x| high = high.max(x));
        }
        [low.into(), high.into()]
    }
}

/// Makes the next level: least and most of 2 × 2 blocks, fewer at the edges.
fn reduce(below: &Level, above: &mut Level) {
    let width = below.size[0] as usize;
    let least = if below.least.is_empty() { &below.most } else { &below.least };
    let rows = above.size[0] as usize;
    let each = above.least.chunks_exact_mut(rows).zip(above.most.chunks_exact_mut(rows));
    for (v, (low, high)) in each.enumerate() {
        let first = 2 * v * width;
        // At the lower edge a row may stand alone.
        let second = if 2 * v + 1 < below.size[1] as usize { first + width } else { first };
        let row = |all: &[u16], from: usize, u: usize| -> [u16; 2] {
            let part = &all[from..from + width];
            [part[2 * u], part[(2 * u + 1).min(width - 1)]]
        };
        for u in 0..rows {
            let [a, b] = row(least, first, u);
            let [c, d] = row(least, second, u);
            low[u] = a.min(b).min(c.min(d));
            let [a, b] = row(&below.most, first, u);
            let [c, d] = row(&below.most, second, u);
            high[u] = a.max(b).max(c.max(d));
        }
    }
}
