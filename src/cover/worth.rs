//! What counts are worth over several moments, so that no rounding decides which set is the better one.

use std::cmp::Ordering;

pub use perirobot_march::metrics::Ratio;
use perirobot_march::metrics::{Across, Confusion, Score};

/// What a set is worth.
#[derive(Clone, Copy, Debug)]
pub enum Worth {
    /// A score of counts added up, or the worst of several scores.
    Exact(Ratio),
    /// A mean of scores, added up in the order of the moments.
    Mean(f64),
}

/// Voxels of a region in all moments together that fractions are exact for.
pub const MOST_VOXELS: u64 = 1 << 31;

impl Worth {
    /// What counts are worth, moment by moment; `None` where no score has a value.
    pub fn from_counts(score: Score, over: Across, counts: &[Confusion]) -> Option<Worth> {
        match over {
            Across::Pooled => {
                let all = counts.iter().fold(Confusion::default(), |sum, counts| sum.plus(counts));
                Ratio::from_score(score, &all).map(Worth::Exact)
            }
            Across::Worst => {
                let each = counts.iter().filter_map(|counts| Ratio::from_score(score, counts));
                let worst = if score.less_is_better() { each.max() } else { each.min() };
                worst.map(Worth::Exact)
            }
            Across::Mean => {
                let values: Vec<f64> = counts.iter().filter_map(|counts| score.evaluate(counts)).collect();
                (!values.is_empty()).then(|| Worth::Mean(values.iter().sum::<f64>() / values.len() as f64))
            }
        }
    }

    /// As a number.
    pub fn value(self) -> f64 {
        match self {
            Worth::Exact(ratio) => ratio.value(),
            Worth::Mean(mean) => mean,
        }
    }

    /// Whether no score is higher.
    pub(super) fn is_full(self) -> bool {
        match self {
            Worth::Exact(ratio) => ratio.numerator >= ratio.denominator,
            Worth::Mean(mean) => mean >= 1.0,
        }
    }

    /// Whether it is no less than a fraction.
    pub fn reaches(self, least: Ratio) -> bool {
        match self {
            Worth::Exact(ratio) => ratio >= least,
            Worth::Mean(mean) => mean >= least.value(),
        }
    }
}

impl Ord for Worth {
    fn cmp(&self, other: &Worth) -> Ordering {
        match (self, other) {
            (Worth::Exact(a), Worth::Exact(b)) => a.cmp(b),
            _ => self.value().total_cmp(&other.value()),
        }
    }
}

impl PartialOrd for Worth {
    fn partial_cmp(&self, other: &Worth) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Worth {
    fn eq(&self, other: &Worth) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Worth {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearly_equal_fractions_are_told_apart() {
        let near = |numerator, denominator| Ratio { numerator, denominator };
        let s = i128::from(MOST_VOXELS);
        assert!(near(s * s - 1, s * s) < near(s * s, s * s));
        let all_but_full = Worth::Exact(near(s * s - 1, s * s));
        assert!(all_but_full.value() == 1.0 && !all_but_full.is_full(), "a rounded score is not a full one");
        assert!(Worth::Exact(near(s, s)).is_full() && Worth::Mean(1.0).is_full());
        assert!(near(1, 3) > near(333_333_333, 1_000_000_000));
        assert_eq!(near(2, 6), near(1, 3));
        assert!(near(-1, 3) < near(0, 5));
    }
}
