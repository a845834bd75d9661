//! How many bits of rows are set.
//!
//! Rows are 64-bit words; of rows that are not equally long the shortest decides. Each way to combine rows is a
//! function of its own, so that all of them are compiled here, as one unit with the vector instructions that they need.

use fearless_simd::{Level, Simd, dispatch};

/// Counts bits of rows.
#[derive(Clone, Copy, Debug)]
pub struct Ones {
    level: Level,
}

/// A row, or what two have together, without putting them together.
#[derive(Clone, Copy, Debug)]
pub struct Joined<'a> {
    row: &'a [u64],
    /// Nothing, if no bit is set.
    more: Option<&'a [u64]>,
}

/// Words whose bits are counted before the sum is compared.
const STRETCH: usize = 64;

impl Ones {
    /// With all instructions of the machine that it runs on.
    #[allow(clippy::new_without_default)]
    pub fn new() -> Ones {
        Ones { level: Level::new() }
    }

    /// Without vector instructions that not every processor of its kind has.
    pub fn plain() -> Ones {
        Ones { level: Level::baseline() }
    }

    /// Bits of a row.
    pub fn count(self, row: &[u64]) -> u64 {
        dispatch!(self.level, simd => ones(simd, row.iter().copied()))
    }

    /// Bits that two rows have.
    pub fn count_both(self, a: &[u64], b: &[u64]) -> u64 {
        dispatch!(self.level, simd => ones(simd, a.iter().zip(b).map(|(a, b)| a & b)))
    }

    /// Bits that two rows have; where they are more than `most`, some number above it.
    pub fn count_both_up_to(self, a: &[u64], b: &[u64], most: u64) -> u64 {
        dispatch!(self.level, simd => ones_up_to(simd, a, b, most))
    }

    /// Bits that a row has and another one lacks.
    pub fn count_minus(self, row: &[u64], other: &[u64]) -> u64 {
        dispatch!(self.level, simd => ones(simd, row.iter().zip(other).map(|(row, other)| row & !other)))
    }

    /// Bits that a row has and two others lack.
    pub fn count_minus_two(self, row: &[u64], [a, b]: [&[u64]; 2]) -> u64 {
        let others = a.iter().zip(b);
        dispatch!(self.level, simd => {
            ones(simd, row.iter().zip(others).map(|(row, (a, b))| row & !a & !b))
        })
    }

    /// Bits that two rows have and a third lacks.
    pub fn count_both_minus(self, [a, b]: [&[u64]; 2], other: &[u64]) -> u64 {
        let both = a.iter().zip(b);
        dispatch!(self.level, simd => {
            ones(simd, both.zip(other).map(|((a, b), other)| a & b & !other))
        })
    }

    /// Bits of what rows have together.
    pub fn count_joined(self, rows: Joined) -> u64 {
        dispatch!(self.level, simd => ones(simd, rows.words()))
    }

    /// Bits of what rows have together and others lack.
    pub fn joined_beyond(self, rows: Joined, others: Joined) -> u64 {
        let all = rows.words().zip(others.words());
        dispatch!(self.level, simd => ones(simd, all.map(|(row, other)| row & !other)))
    }

    /// Bits of a row that are in the first rows, in the second alone, and in neither.
    pub fn shared_out(self, row: &[u64], first: Joined, second: Joined) -> [u64; 3] {
        dispatch!(self.level, simd => shared_out(simd, row, first, second))
    }
}

impl<'a> Joined<'a> {
    /// Two rows; the second is empty if no bit is set.
    pub fn new(row: &'a [u64], more: &'a [u64]) -> Joined<'a> {
        Joined { row, more: (!more.is_empty()).then_some(more) }
    }

    /// Some words of them.
    ///
    /// # Panics
    /// When a row has fewer words.
    pub fn part(&self, words: &std::ops::Range<usize>) -> Joined<'a> {
        let more = self.more.map(|more| &more[words.clone()]);
        Joined { row: &self.row[words.clone()], more }
    }

    #[inline(always)]
    fn words(&self) -> impl Iterator<Item = u64> + 'a {
        // Where there is no other row, the same once more changes nothing.
        self.row.iter().zip(self.more.unwrap_or(self.row)).map(|(a, b)| a | b)
    }
}

#[inline(always)]
fn ones<S: Simd>(_: S, words: impl Iterator<Item = u64>) -> u64 {
    // No sum is as large as to wrap, and without a check of that loops become vectors.
    words.fold(0, |sum, word| sum.wrapping_add(word.count_ones().into()))
}

#[inline(always)]
fn ones_up_to<S: Simd>(simd: S, a: &[u64], b: &[u64], most: u64) -> u64 {
    let mut sum = 0;
    for (a, b) in a.chunks(STRETCH).zip(b.chunks(STRETCH)) {
        sum += ones(simd, a.iter().zip(b).map(|(a, b)| a & b));
        if sum > most {
            break;
        }
    }
    sum
}

#[inline(always)]
fn shared_out<S: Simd>(_: S, row: &[u64], first: Joined, second: Joined) -> [u64; 3] {
    let mut counts = [0u64; 3];
    for ((&row, first), second) in row.iter().zip(first.words()).zip(second.words()) {
        for (count, word) in
            counts.iter_mut().zip([row & first, row & second & !first, row & !second & !first])
        {
            *count = count.wrapping_add(word.count_ones().into());
        }
    }
    counts
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::cpu::SimdLevel;

    /// Rows of bits that look like chance, of a few words more than vectors have.
    fn rows() -> [Vec<u64>; 4] {
        let mut state = 5u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            state ^ state >> 29
        };
        [0; 4].map(|_| (0..3 * STRETCH + 11).map(|_| random() & random()).collect())
    }

    /// For each set of vector instructions that this processor has.
    fn levels() -> Vec<Ones> {
        SimdLevel::all().into_iter().map(|simd| Ones { level: simd.level }).collect()
    }

    /// Bits of words of which a rule is true, one by one.
    fn count(rows: &[Vec<u64>; 4], rule: impl Fn([bool; 4]) -> bool) -> u64 {
        let is_set = |row: &[u64], bit: usize| row[bit / 64] >> (bit % 64) & 1 == 1;
        let of = |&bit: &usize| rule(std::array::from_fn(|row| is_set(&rows[row], bit)));
        (0..64 * rows[0].len()).filter(of).count() as u64
    }

    #[test]
    fn bits_are_counted_as_one_by_one_on_every_level() {
        let rows = rows();
        let [a, b, c, d] = [0, 1, 2, 3].map(|row| &rows[row][..]);
        for ones in levels() {
            assert_eq!(ones.count(a), count(&rows, |[a, ..]| a));
            assert_eq!(ones.count_both(a, b), count(&rows, |[a, b, ..]| a && b));
            assert_eq!(ones.count_minus(a, b), count(&rows, |[a, b, ..]| a && !b));
            assert_eq!(ones.count_minus_two(a, [b, c]), count(&rows, |[a, b, c, _]| a && !b && !c));
            assert_eq!(ones.count_both_minus([a, b], c), count(&rows, |[a, b, c, _]| a && b && !c));
            let (first, second) = (Joined::new(a, b), Joined::new(c, d));
            assert_eq!(ones.count_joined(first), count(&rows, |[a, b, ..]| a || b));
            assert_eq!(ones.count_joined(Joined::new(a, &[])), ones.count(a));
            let expected = count(&rows, |[a, b, c, d]| (a || b) && !(c || d));
            assert_eq!(ones.joined_beyond(first, second), expected);
            let [single, pair] = [Joined::new(b, &[]), Joined::new(c, d)];
            let expected = [
                count(&rows, |[a, b, ..]| a && b),
                count(&rows, |[a, b, c, d]| a && !b && (c || d)),
                count(&rows, |[a, b, c, d]| a && !b && !(c || d)),
            ];
            assert_eq!(ones.shared_out(a, single, pair), expected);
            let part = 7..STRETCH + 9;
            assert_eq!(
                ones.count_joined(first.part(&part)),
                ones.count_joined(Joined::new(&a[part.clone()], &b[part]))
            );
        }
    }

    #[test]
    fn counting_stops_above_the_most_that_is_of_interest() {
        let rows = rows();
        let [a, b] = [&rows[0][..], &rows[1][..]];
        for ones in levels() {
            let all = ones.count_both(a, b);
            for most in 0..all + 2 {
                let found = ones.count_both_up_to(a, b, most);
                assert_eq!(found > most, all > most);
                assert!(found == all || found > most);
            }
            let first = ones.count_both(&a[..STRETCH], &b[..STRETCH]);
            assert_eq!(ones.count_both_up_to(a, b, first - 1), first, "the rest is not looked at");
        }
    }

    #[test]
    fn the_shortest_row_decides() {
        let rows = rows();
        let [a, b] = [&rows[0][..], &rows[1][..]];
        for ones in levels() {
            let short = STRETCH + 3;
            assert_eq!(ones.count_both(a, &b[..short]), ones.count_both(&a[..short], &b[..short]));
            assert_eq!(ones.count_minus(&a[..short], b), ones.count_minus(&a[..short], &b[..short]));
            assert_eq!(
                ones.count_both_up_to(&a[..short], b, u64::MAX),
                ones.count_both(&a[..short], &b[..short])
            );
        }
    }
}
