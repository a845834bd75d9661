//! A score as a fraction of whole numbers, so that no rounding decides which of two is the higher one.

use std::cmp::Ordering;

use super::{Confusion, Score};

/// A fraction; its denominator is above zero. Both are below 2⁶³ in size, so that two can be compared in 128
/// bits.
#[derive(Clone, Copy, Debug)]
pub struct Ratio {
    /// Above the line.
    pub numerator: i128,
    /// Below the line.
    pub denominator: i128,
}

/// What numbers of a study are told apart by: nine digits after the point.
const NINE_DIGITS: i128 = 1_000_000_000;

impl Ratio {
    /// A number of at most nine digits after the point.
    pub fn from_f64(value: f64) -> Ratio {
        Ratio { numerator: (value * NINE_DIGITS as f64).round() as i128, denominator: NINE_DIGITS }
    }

    /// The sum of two over their least common denominator.
    pub fn plus(self, other: Ratio) -> Ratio {
        let common = self.denominator / gcd(self.denominator, other.denominator) * other.denominator;
        let scaled = |ratio: Ratio| ratio.numerator * (common / ratio.denominator);
        Ratio { numerator: scaled(self) + scaled(other), denominator: common }
    }

    /// One division.
    pub fn value(self) -> f64 {
        self.numerator as f64 / self.denominator as f64
    }

    /// The fraction of a score, if it has a value.
    pub fn from_score(score: Score, counts: &Confusion) -> Option<Ratio> {
        let wide = |n: u64| i128::from(n);
        let [tp, fp, fn_, tn] = [counts.tp, counts.fp, counts.fn_, counts.tn].map(wide);
        let (s, found) = (wide(counts.total()), &counts.detection);
        let (numerator, denominator) = match score {
            Score::F1 => (2 * tp, s + tp - tn),
            Score::Kappa => {
                let occupied = tp + fn_ + wide(counts.uo);
                let chance = (tp + fp) * occupied + (fn_ + tn) * (s - occupied);
                (s * (tp + tn) - chance, s * s - chance)
            }
            Score::HumanSeen => (wide(found.hit_human), wide(counts.people_voxels())),
            Score::HumanClaimed => (wide(counts.human.tp), wide(counts.people_voxels())),
            Score::PeopleDetected => (wide(found.people_detected), wide(found.people)),
            Score::PartsDetected => (wide(found.parts_detected), wide(found.parts)),
            Score::Unknown => (wide(counts.uo + counts.uf), s),
            Score::FalseAlarm => (fp, fp + tn),
            Score::SeenTwice => (wide(counts.overlap.twice), s),
        };
        (denominator != 0).then_some(Ratio { numerator, denominator })
    }
}

/// The greatest common divisor of two numbers, not below 0.
pub fn gcd(a: i128, b: i128) -> i128 {
    if b == 0 { a.abs() } else { gcd(b, a % b) }
}

impl Ord for Ratio {
    fn cmp(&self, other: &Ratio) -> Ordering {
        (self.numerator * other.denominator).cmp(&(other.numerator * self.denominator))
    }
}

impl PartialOrd for Ratio {
    fn partial_cmp(&self, other: &Ratio) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Ratio {
    fn eq(&self, other: &Ratio) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Ratio {}
