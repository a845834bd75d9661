//! A bit for each voxel of a window, in 32-bit words that host and GPU share. Rows run along x and are padded
//! to whole words; padding bits are always zero.

use std::ops::Range;

use super::grid::Window;

/// A bit plane over a window.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BitGrid {
    window: Window,
    words_per_row: u32,
    words: Vec<u32>,
}

impl BitGrid {
    /// A plane of zeros.
    pub fn new(window: Window) -> Self {
        let words_per_row = window.size[0].div_ceil(32);
        let words = words_per_row as usize * window.size[1] as usize * window.size[2] as usize;
        BitGrid { window, words_per_row, words: vec![0; words] }
    }

    /// A plane over an empty window.
    pub fn nowhere() -> Self {
        BitGrid::new(Window::from_corners([0; 3], [-1; 3]))
    }

    /// A plane whose voxels are all set.
    pub fn full(window: Window) -> Self {
        let mut plane = BitGrid::new(window);
        let (min, end) = (window.min, window.end());
        for z in min[2]..end[2] {
            (min[1]..end[1]).for_each(|y| plane.set_run(min[0], end[0], y, z));
        }
        plane
    }

    /// A plane from words laid out as [`BitGrid::words`]; `None` if their number does not fit the window.
    pub fn from_words(window: Window, words: Vec<u32>) -> Option<Self> {
        let blank = BitGrid::new(window);
        (blank.words.len() == words.len()).then_some(BitGrid { words, ..blank })
    }

    /// The voxels the plane covers.
    pub fn window(&self) -> Window {
        self.window
    }

    /// Words in a row of x: ⌈size x / 32⌉.
    pub fn words_per_row(&self) -> u32 {
        self.words_per_row
    }

    /// The words: bit x & 31 of word (z · size y + y) · words per row + (x >> 5), x, y, z from the window's
    /// corner.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// The words, to be changed; padding bits must stay zero.
    pub fn words_mut(&mut self) -> &mut [u32] {
        &mut self.words
    }

    /// Index of a voxel's bit, counting 32 bits a word, or `None` outside the window.
    pub fn bit_index(&self, voxel: [i32; 3]) -> Option<usize> {
        if !self.window.contains(voxel) {
            return None;
        }
        let [x, y, z] = std::array::from_fn(|r| (voxel[r] - self.window.min[r]) as usize);
        let row = z * self.window.size[1] as usize + y;
        Some(row * self.words_per_row as usize * 32 + x)
    }

    /// Whether a voxel is set; voxels outside the window are not.
    pub fn get(&self, voxel: [i32; 3]) -> bool {
        self.bit_index(voxel).is_some_and(|bit| self.words[bit >> 5] >> (bit & 31) & 1 == 1)
    }

    /// Sets a voxel; one outside the window is left alone.
    pub fn set(&mut self, voxel: [i32; 3]) {
        if let Some(bit) = self.bit_index(voxel) {
            self.words[bit >> 5] |= 1 << (bit & 31);
        }
    }

    /// Clears a voxel; nothing outside the window.
    pub fn unset(&mut self, voxel: [i32; 3]) {
        if let Some(bit) = self.bit_index(voxel) {
            self.words[bit >> 5] &= !(1 << (bit & 31));
        }
    }

    /// How many voxels are set.
    pub fn count(&self) -> u64 {
        self.words.iter().map(|w| w.count_ones() as u64).sum()
    }

    /// Whether no voxel is set.
    pub fn is_empty(&self) -> bool {
        self.words.iter().all(|&w| w == 0)
    }

    /// Every set voxel, x fastest, then y, then z.
    pub fn voxels(&self) -> impl Iterator<Item = [i32; 3]> + '_ {
        let filled = self.words.iter().enumerate().filter(|(_, word)| **word != 0);
        filled.flat_map(|(at, &word)| {
            let [x, y, z] = self.first_of(at);
            bits_of(word).map(move |bit| [x + bit as i32, y, z])
        })
    }

    /// The voxel of the lowest bit of a word.
    fn first_of(&self, word: usize) -> [i32; 3] {
        let (row, x) = (word / self.words_per_row as usize, 32 * (word % self.words_per_row as usize));
        let (y, z) = (row % self.window.size[1] as usize, row / self.window.size[1] as usize);
        let min = self.window.min;
        [min[0] + x as i32, min[1] + y as i32, min[2] + z as i32]
    }

    /// The smallest window that holds every set voxel; empty if none is set.
    pub fn bounds(&self) -> Window {
        let nowhere = Window::from_corners([0; 3], [-1; 3]);
        let (min, end) = (self.window.min, self.window.end());
        let rows = (min[2]..end[2]).flat_map(|z| (min[1]..end[1]).map(move |y| [y, z]));
        rows.fold(nowhere, |all, [y, z]| {
            let words = self.row(y, z);
            let filled = |w: &usize| words[*w] != 0;
            let (first, last) = ((0..words.len()).find(filled), (0..words.len()).rfind(filled));
            let (Some(first), Some(last)) = (first, last) else { return all };
            let low = min[0] + (first as u32 * 32 + words[first].trailing_zeros()) as i32;
            let high = min[0] + (last as u32 * 32 + 31 - words[last].leading_zeros()) as i32;
            all.union(&Window::from_corners([low, y, z], [high, y, z]))
        })
    }

    /// The same bits over the smallest window that holds them.
    pub fn trim(&self) -> BitGrid {
        self.to_window(self.bounds())
    }

    /// The same bits over another window: cut where it is smaller, zero where it is larger.
    pub fn to_window(&self, window: Window) -> BitGrid {
        let mut out = BitGrid::new(window);
        out.merge(self, |_, from| from);
        out
    }

    /// Sets every voxel that is set in `other`, inside this window.
    pub fn add(&mut self, other: &BitGrid) {
        self.merge(other, |to, from| to | from);
    }

    /// Clears every voxel that is set in `other`.
    pub fn remove(&mut self, other: &BitGrid) {
        self.merge(other, |to, from| to & !from);
    }

    /// Keeps only voxels that are set in `other` too.
    pub fn keep(&mut self, other: &BitGrid) {
        if self.window == other.window {
            self.words.iter_mut().zip(&other.words).for_each(|(to, from)| *to &= from);
        } else {
            let mut beyond = self.clone();
            beyond.remove(other);
            self.remove(&beyond);
        }
    }

    /// Whether some voxel is set in both.
    pub fn intersects(&self, other: &BitGrid) -> bool {
        let mut shared = self.to_window(self.window.intersection(&other.window));
        shared.keep(other);
        !shared.is_empty()
    }

    /// Combines rows word by word where the windows meet. `f(to, 0)` must be `to`.
    fn merge(&mut self, other: &BitGrid, f: impl Fn(u32, u32) -> u32) {
        let shared = self.window.intersection(&other.window);
        if shared.is_empty() {
            return;
        }
        let end = shared.end();
        for z in shared.min[2]..end[2] {
            for y in shared.min[1]..end[1] {
                let start = self.row_start(y, z);
                let row = &mut self.words[start..start + self.words_per_row as usize];
                other.merge_row(row, self.window, [y, z], &f);
            }
        }
    }

    /// Sets voxels in rows `ys` of layer `z` of another window, all inside it, whose words these are, where
    /// this plane has them.
    pub(crate) fn add_to_rows(&self, words: &mut [u32], window: Window, ys: Range<i32>, z: i32) {
        let shared = self.window.intersection(&window);
        let rows = shared.min[1].max(ys.start)..shared.end()[1].min(ys.end);
        if !(shared.min[2]..shared.end()[2]).contains(&z) || shared.is_empty() || rows.is_empty() {
            return;
        }
        let row_words = window.size[0].div_ceil(32) as usize;
        if window == self.window {
            let from = &self.words[self.row_start(ys.start, z)..];
            return words.iter_mut().zip(from).for_each(|(to, from)| *to |= from);
        }
        for y in rows {
            let start = (y - ys.start) as usize * row_words;
            self.merge_row(&mut words[start..start + row_words], window, [y, z], |to, from| to | from);
        }
    }

    /// Combines one row of another window with the same row of this plane, where they meet.
    fn merge_row(&self, to: &mut [u32], window: Window, [y, z]: [i32; 2], f: impl Fn(u32, u32) -> u32) {
        let from = self.row(y, z);
        let shift = window.min[0] - self.window.min[0];
        // Words of `to` that hold an x of this plane.
        let first = (-shift).max(0) as usize / 32;
        let end = (self.window.size[0] as i32 - shift).max(0) as usize;
        let to_end = end.div_ceil(32).min(to.len());
        let last_bits = last_bits(window.size[0]);
        let Some(last) = to.len().checked_sub(1) else { return };
        if first >= to_end {
            return;
        }
        if shift % 32 == 0 {
            let skipped = (first as i32 + shift / 32) as usize;
            to[first..to_end].iter_mut().zip(&from[skipped..]).for_each(|(to, &from)| *to = f(*to, from));
        } else {
            for w in first..to_end {
                to[w] = f(to[w], word_at(from, w as i32 * 32 + shift));
            }
        }
        to[last] &= last_bits;
    }

    fn row_start(&self, y: i32, z: i32) -> usize {
        let y = (y - self.window.min[1]) as usize;
        let z = (z - self.window.min[2]) as usize;
        (z * self.window.size[1] as usize + y) * self.words_per_row as usize
    }

    /// Sets a run of voxels of one row, `from` to `to` (exclusive) on x, cut to the window.
    pub fn set_run(&mut self, from: i32, to: i32, y: i32, z: i32) {
        self.set_all(&Window { min: [from, y, z], size: [(to as i64 - from as i64).max(0) as u32, 1, 1] });
    }

    /// Sets all voxels of a box, cut to the window.
    pub(crate) fn set_all(&mut self, part: &Window) {
        let part = part.intersection(&self.window);
        if part.is_empty() {
            return;
        }
        let first = (part.min[0] - self.window.min[0]) as usize;
        let last = first + part.size[0] as usize - 1;
        let (words_per_row, rows) = (self.words_per_row as usize, part.size[1] as usize);
        for z in part.min[2]..part.end()[2] {
            let start = self.row_start(part.min[1], z);
            let layer = &mut self.words[start..];
            for w in first / 32..=last / 32 {
                let all = span(w, first, last);
                layer[w..].iter_mut().step_by(words_per_row).take(rows).for_each(|word| *word |= all);
            }
        }
    }

    /// Every set voxel of a box.
    pub fn each_in(&self, part: &Window, mut see: impl FnMut([i32; 3])) {
        self.words_in(part, |[first, y, z], word, _| {
            bits_of(word).for_each(|b| see([first + b as i32, y, z]));
            true
        });
    }

    /// Whether any voxel of a box is set.
    pub(crate) fn any_in(&self, part: &Window) -> bool {
        !self.words_in(part, |_, word, _| word == 0)
    }

    /// Whether all voxels of a box lie in the window and are set.
    pub(crate) fn all_in(&self, part: &Window) -> bool {
        part.intersection(&self.window) == *part && self.words_in(part, |_, word, all| word == all)
    }

    /// Hands the words of a box to `see`, cut to the box, each with its first voxel and with all bits of the box set, until
    /// `see` returns false; whether all were handed over.
    fn words_in(&self, part: &Window, mut see: impl FnMut([i32; 3], u32, u32) -> bool) -> bool {
        let part = part.intersection(&self.window);
        if part.is_empty() {
            return true;
        }
        let first = (part.min[0] - self.window.min[0]) as usize;
        let last = first + part.size[0] as usize - 1;
        (part.min[2]..part.end()[2]).all(|z| {
            (part.min[1]..part.end()[1]).all(|y| {
                let row = self.row(y, z);
                (first / 32..=last / 32).all(|w| {
                    let x = self.window.min[0] + w as i32 * 32;
                    let all = span(w, first, last);
                    see([x, y, z], row[w] & all, all)
                })
            })
        })
    }

    /// The words of one row along x, which must lie in the window.
    pub fn row(&self, y: i32, z: i32) -> &[u32] {
        let start = self.row_start(y, z);
        &self.words[start..start + self.words_per_row as usize]
    }

    /// Sets the voxels of a row that are set in the row of a plane with the same x; nothing outside the
    /// window.
    pub(crate) fn add_row(&mut self, y: i32, z: i32, words: &[u32]) {
        if self.window.contains([self.window.min[0], y, z]) {
            let start = self.row_start(y, z);
            self.words[start..].iter_mut().zip(words).for_each(|(to, from)| *to |= from);
        }
    }

    /// Sets the voxels of a layer of z that are set in a plane of one layer with the same x and y.
    pub(crate) fn add_layer(&mut self, z: i32, layer: &BitGrid) {
        let start = self.row_start(self.window.min[1], z);
        self.words[start..].iter_mut().zip(&layer.words).for_each(|(to, from)| *to |= from);
    }

    /// Sets both neighbours along x of every voxel that is set, inside the window.
    pub(crate) fn spread_x(&mut self) {
        let Some(last) = (self.words_per_row as usize).checked_sub(1) else { return };
        let valid = last_bits(self.window.size[0]);
        for row in self.words.chunks_exact_mut(last + 1) {
            let mut below = 0;
            for w in 0..=last {
                let word = row[w];
                let above = row.get(w + 1).map_or(0, |next| next << 31);
                row[w] = word | word << 1 | word >> 1 | below | above;
                below = word >> 31;
            }
            row[last] &= valid;
        }
    }
}

/// 32 bits of a row from a voxel on, counted from the row's first; bits outside the row are zero.
fn word_at(row: &[u32], offset: i32) -> u32 {
    let (word, shift) = (offset.div_euclid(32), offset.rem_euclid(32));
    let fetch = |w: i32| usize::try_from(w).ok().and_then(|w| row.get(w)).map_or(0, |&word| u64::from(word));
    ((fetch(word) | fetch(word + 1) << 32) >> shift) as u32
}

/// The bits of the last word of a row that are voxels, not padding.
fn last_bits(voxels: u32) -> u32 {
    u32::MAX >> (voxels.wrapping_neg() & 31)
}

/// The bits of word `w` of a row from bit `first` to bit `last` of the row, both included.
fn span(w: usize, first: usize, last: usize) -> u32 {
    let low = if w == first / 32 { u32::MAX << (first % 32) } else { u32::MAX };
    let high = if w == last / 32 { u32::MAX >> (31 - last % 32) } else { u32::MAX };
    low & high
}

/// The positions of the set bits of a word, lowest first.
fn bits_of(mut word: u32) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let bit = word.trailing_zeros();
        word &= word.wrapping_sub(1);
        (bit < 32).then_some(bit)
    })
}

#[cfg(test)]
mod tests;
