//! Overlaps of candidates: for each pair the voxels that both have. They are counted once and kept,
//! since only their weights differ from question to question.

use std::ops::Range;

use rayon::prelude::*;

use super::evidence::CandidateEvidence;
use super::question::{Inequality, Segment};
use perirobot_march::voxel::Ones;

/// The most bytes that the counts may take.
const MOST_BYTES: usize = 512 << 20;

/// Rows that are compared with others while they are in the cache.
const BLOCK: usize = 8;

/// Bits of a plane that are counted together.
type Class = (usize, Range<usize>);

/// The voxels that both of two candidates have, class by class.
pub struct PairCounts {
    classes: Vec<Class>,
    /// Of each class a square.
    counts: Vec<Vec<u32>>,
}

/// Lower bounds of the overlaps of pairs, which are what two candidates add to a set one by one less what they add
/// together: a square for each inequality.
pub(super) struct OverlapTable {
    size: usize,
    squares: Vec<Vec<i64>>,
}

impl PairCounts {
    /// Of all candidates, as some inequalities need it; `None` if that is too much to be kept.
    pub(super) fn new(evidence: &CandidateEvidence, inequalities: &[Inequality]) -> Option<PairCounts> {
        let classes = classes_of(inequalities);
        let size = evidence.count();
        let counts = classes.len() * size * size * size_of::<u32>();
        if evidence.is_filed() || classes.is_empty() || counts > MOST_BYTES {
            return None;
        }
        // Besides, tables of them, and rows while they are counted.
        let tables = inequalities.len() * size * size * size_of::<i64>();
        let rows: usize = classes.iter().map(|(_, words)| 8 * words.len() * size).sum();
        if (counts + tables.max(rows)) as u64 > evidence.spare_bytes() {
            return None;
        }
        let rows = ClassRows::new(evidence, &classes);
        let mut counts = vec![vec![0; size * size]; classes.len()];
        for (number, square) in counts.iter_mut().enumerate() {
            square.par_chunks_mut(BLOCK * size).enumerate().for_each(|(block, part)| {
                let of = block * BLOCK..(block * BLOCK + BLOCK).min(size);
                rows.count(evidence.ones, number, of, part);
            });
        }
        Some(PairCounts { classes, counts })
    }

    /// The table of some inequalities and all candidates, before anything is chosen.
    pub(super) fn table(&self, inequalities: &[Inequality]) -> Option<OverlapTable> {
        let size = self.counts[0].len().isqrt();
        let square = |inequality: &Inequality| {
            let weighted = weights(inequality, &self.classes)?;
            let of_pair = |pair| {
                weighted.iter().map(|&(class, weight)| weight * i64::from(self.counts[class][pair])).sum()
            };
            Some((0..size * size).into_par_iter().map(of_pair).collect())
        };
        let squares = inequalities.iter().map(square).collect::<Option<Vec<_>>>()?;
        Some(OverlapTable { size, squares })
    }
}

impl OverlapTable {
    /// Of so many candidates and inequalities, with what is known of each pair.
    pub(super) fn new(
        size: usize,
        inequalities: usize,
        known: impl Fn(usize, usize, usize) -> i64,
    ) -> OverlapTable {
        let mut squares = vec![vec![0; size * size]; inequalities];
        for (number, square) in squares.iter_mut().enumerate() {
            for a in 0..size {
                for b in 0..a {
                    let overlap = known(number, a, b);
                    square[a * size + b] = overlap;
                    square[b * size + a] = overlap;
                }
            }
        }
        OverlapTable { size, squares }
    }

    /// Keeps how much less two candidates add together, by an inequality.
    pub(super) fn set(&mut self, inequality: usize, a: usize, b: usize, overlap: i64) {
        self.squares[inequality][a * self.size + b] = overlap;
        self.squares[inequality][b * self.size + a] = overlap;
    }

    /// How much less two candidates add together, by an inequality.
    #[inline(always)]
    pub(super) fn overlap(&self, inequality: usize, a: usize, b: usize) -> i64 {
        self.squares[inequality][a * self.size + b]
    }
}

/// The bits that some inequalities count.
fn classes_of(inequalities: &[Inequality]) -> Vec<Class> {
    let mut classes: Vec<Class> = Vec::new();
    for segment in inequalities.iter().filter(|one| one.is_plain()).flat_map(Inequality::segments) {
        let class = (segment.plane, segment.words.clone());
        if !classes.contains(&class) {
            classes.push(class);
        }
    }
    classes
}

/// Classes of an inequality with the weights of their bits; `None` if it counts anything else.
fn weights(inequality: &Inequality, classes: &[Class]) -> Option<Vec<(usize, i64)>> {
    let of = |segment: &Segment| {
        let class =
            classes.iter().position(|(plane, words)| *plane == segment.plane && *words == segment.words)?;
        Some((class, segment.weight as i64))
    };
    inequality.is_plain().then(|| inequality.segments().map(of).collect()).flatten()
}

/// What candidates say: of each class the words in which anybody says anything, row by row.
struct ClassRows {
    classes: Vec<(usize, Vec<u64>)>,
}

impl ClassRows {
    fn new(evidence: &CandidateEvidence, classes: &[Class]) -> ClassRows {
        let of_class = |(plane, words): &Class| {
            let all = || (0..evidence.count()).map(|item| evidence.plane(item, *plane)).enumerate();
            let all = || all().filter(|(_, row)| !row.is_empty());
            let mut any = vec![0; words.len()];
            for (_, row) in all() {
                any.iter_mut().zip(&row[words.clone()]).for_each(|(any, word)| *any |= word);
            }
            let width = any.iter().filter(|any| **any != 0).count();
            let mut rows = vec![0; evidence.count() * width];
            for (item, row) in all() {
                let kept = row[words.clone()].iter().zip(&any).filter(|(_, any)| **any != 0);
                let own = &mut rows[item * width..(item + 1) * width];
                own.iter_mut().zip(kept).for_each(|(to, (word, _))| *to = *word);
            }
            (width, rows)
        };
        ClassRows { classes: classes.iter().map(of_class).collect() }
    }

    /// The bits that some rows share with each row, in one class.
    fn count(&self, ones: Ones, class: usize, of: Range<usize>, counts: &mut [u32]) {
        let (width, rows) = &self.classes[class];
        let row = |i: usize| &rows[i * width..(i + 1) * width];
        let size = counts.len() / of.len();
        for b in 0..size {
            for a in of.clone() {
                counts[(a - of.start) * size + b] = ones.count_both(row(a), row(b)) as u32;
            }
        }
    }
}
