//! A score over several moments that is compared exactly.

use std::cmp::Ordering;

use crate::controller::Excess;
use perirobot_march::metrics::{Across, Confusion, Ratio, Score, gcd};
use perirobot_study::input::Limit;

/// Binary digits of a sum of fractions per step.
const DIGITS: u32 = 32;

/// A value to compare with a limit.
#[derive(Clone, Debug)]
pub enum Value {
    /// The mean of some fractions, at least one.
    Mean(Vec<Ratio>),
    /// A distance, as the fraction of its square.
    Root(Ratio),
    /// The excess of a distance, by its square, over another distance.
    Beyond(Ratio, Ratio),
    /// The excess of a measured distance over the true one.
    Excess(Excess),
    /// More than any number: the distance of a body that never comes near, or of a person who is present but not
    /// measured.
    Endless,
}

impl Value {
    /// The value of counts, moment by moment. The worst of several is the one closest to missing the limit. Moments
    /// without a value are left out; `None` if none has one.
    pub fn from_counts(score: Score, over: Across, limit: &Limit, counts: &[Confusion]) -> Option<Value> {
        let each = || counts.iter().filter_map(|counts| Ratio::from_score(score, counts));
        let parts: Vec<Ratio> = match over {
            Across::Mean => each().collect(),
            Across::Worst => {
                each().reduce(|a, b| if limit.is_worse(&a, &b) { a } else { b }).into_iter().collect()
            }
            Across::Pooled => {
                let all = counts.iter().fold(Confusion::default(), |sum, counts| sum.plus(counts));
                Ratio::from_score(score, &all).into_iter().collect()
            }
        };
        (!parts.is_empty()).then_some(Value::Mean(parts))
    }

    /// One fraction.
    pub(super) fn from_ratio(ratio: Ratio) -> Value {
        Value::Mean(vec![ratio])
    }

    /// Compares it with a fraction.
    pub fn cmp_ratio(&self, ratio: Ratio) -> Ordering {
        let Ratio { numerator, denominator } = ratio;
        match self {
            Value::Mean(parts) => cmp_means(parts, &[ratio]),
            Value::Root(_) if numerator < 0 => Ordering::Greater,
            Value::Root(square) => cmp_means(
                &[*square],
                &[Ratio { numerator: numerator.pow(2), denominator: denominator.pow(2) }],
            ),
            // Both have nine decimals, so the square of their sum stays in bounds.
            Value::Beyond(square, other) => Value::Root(*square).cmp_ratio(ratio.plus(*other)),
            Value::Excess(excess) => excess.cmp_ratio(ratio),
            Value::Endless => Ordering::Greater,
        }
    }

    /// Whether it meets a limit.
    pub fn meets(&self, limit: &Limit) -> bool {
        match limit {
            Limit::AtLeast(limit) => self.cmp_ratio(*limit).is_ge(),
            Limit::AtMost(limit) => self.cmp_ratio(*limit).is_le(),
        }
    }

    /// As a number for display.
    pub fn number(&self) -> f64 {
        match self {
            Value::Mean(parts) => parts.iter().map(|ratio| ratio.value()).sum::<f64>() / parts.len() as f64,
            Value::Root(square) => square.value().sqrt(),
            Value::Beyond(square, other) => square.value().sqrt() - other.value(),
            Value::Excess(excess) => excess.metres(),
            Value::Endless => f64::INFINITY,
        }
    }
}

/// Compares the means of some fractions.
fn cmp_means(one: &[Ratio], other: &[Ratio]) -> Ordering {
    let [a, b] = [one, other].map(|parts| parts.len() as i128);
    let own = one.iter().map(|one| (one.numerator * b, one.denominator));
    let others = other.iter().map(|one| (-one.numerator * a, one.denominator));
    sign(own.chain(others))
}

impl Ord for Value {
    /// Values of one requirement are compared: all are of one kind, or infinite.
    fn cmp(&self, other: &Value) -> Ordering {
        let kind = |value: &Value| match value {
            Value::Mean(_) => 0,
            Value::Root(_) => 1,
            Value::Beyond(..) => 2,
            Value::Excess(_) => 3,
            Value::Endless => 4,
        };
        match (self, other) {
            (Value::Mean(one), Value::Mean(other)) => cmp_means(one, other),
            // The other distance is equal in all of them.
            (Value::Root(one), Value::Root(other)) | (Value::Beyond(one, _), Value::Beyond(other, _)) => {
                cmp_means(&[*one], &[*other])
            }
            (Value::Excess(one), Value::Excess(other)) => one.cmp(other),
            _ => kind(self).cmp(&kind(other)),
        }
    }
}

impl PartialOrd for Value {
    fn partial_cmp(&self, other: &Value) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Value {
    fn eq(&self, other: &Value) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Value {}

/// The sign of a sum of fractions. Denominators are above 0 and, like numerators, below 2⁹⁴ in size.
///
/// The sum is computed digit by digit: with n fractions, it lies in an interval of n units above a known whole number
/// of units. A nonzero sum differs from 0 by at least 1 / (product of the denominators), so enough digits decide.
fn sign(fractions: impl Iterator<Item = (i128, i128)>) -> Ordering {
    let mut rests: Vec<(i128, i128)> = fractions.collect();
    let mut denominators: Vec<i128> =
        rests.iter().map(|&(numerator, denominator)| denominator / gcd(numerator, denominator)).collect();
    denominators.sort_unstable();
    denominators.dedup();
    let bits: u64 = denominators.iter().map(|denominator| u64::from(128 - denominator.leading_zeros())).sum();
    let count = rests.len() as i128;
    let mut units = 0;
    for rest in &mut rests {
        units += rest.0.div_euclid(rest.1);
        rest.0 = rest.0.rem_euclid(rest.1);
    }
    // A few bits more than the product has, since the interval has as many units as there are fractions.
    for _ in 0..(bits + 64).div_ceil(DIGITS.into()) + 1 {
        rests.retain(|rest| rest.0 != 0);
        if rests.is_empty() || units > 0 || units <= -count {
            break;
        }
        units <<= DIGITS;
        for rest in &mut rests {
            let scaled = rest.0 << DIGITS;
            units += scaled / rest.1;
            rest.0 = scaled % rest.1;
        }
    }
    match units {
        _ if rests.is_empty() => units.cmp(&0),
        1.. => Ordering::Greater,
        _ if units <= -count => Ordering::Less,
        _ => Ordering::Equal,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(parts: &[(i128, i128)]) -> Value {
        Value::Mean(parts.iter().map(|&(numerator, denominator)| Ratio { numerator, denominator }).collect())
    }

    #[test]
    fn means_are_compared_exactly() {
        // 1/3 + 1/6 + 1/2 = 1, although no binary fraction shows it.
        let third = mean(&[(1, 3), (1, 6), (1, 2)]);
        assert_eq!(third, mean(&[(1, 3)]));
        assert_eq!(third, mean(&[(2, 6), (5, 15)]));
        let huge = (1i128 << 62) - 57;
        assert!(mean(&[(1, 3), (1, 6), (huge / 2, huge)]) < third, "half of an odd number, rounded down");
        assert!(mean(&[(1, 3), (1, 6), (huge / 2 + 1, huge)]) > third);
        assert_eq!(mean(&[(huge - 1, huge), (1, huge)]), mean(&[(1, 2)]));
        assert!(mean(&[(-1, 3)]) < mean(&[(0, 7)]) && mean(&[(-1, 3), (1, 3)]) == mean(&[(0, 5)]));
    }

    #[test]
    fn distances_are_compared_by_their_squares() {
        let root = |numerator, denominator| Value::Root(Ratio { numerator, denominator });
        let limit = |value| Limit::AtLeast(Ratio::from_f64(value));
        // 441 voxels squared of 5 cm: 1.05 m, although no root of a binary fraction shows it.
        let distance = root(441, 400);
        assert!(distance.meets(&limit(1.05)) && !distance.meets(&limit(1.050_000_001)));
        assert!(distance.meets(&limit(1.049_999_999)) && root(0, 400).meets(&limit(0.0)));
        assert!(root(440, 400) < distance && distance < Value::Endless && Value::Endless.meets(&limit(1e4)));
        // The largest grid of the largest voxels.
        assert!(root(3 << 20, 1).meets(&limit(1e4)) == (f64::from(3 << 20).sqrt() >= 1e4));
        assert!(root(100 * (3 << 20), 1).meets(&limit(1e4)));
    }

    #[test]
    fn margins_are_exact_however_many_digits_their_parts_have() {
        let exceeds = |edge_m: f64, squared: i128, needed_m: f64| {
            let Ratio { numerator, denominator } = Ratio::from_f64(edge_m);
            let square = Ratio { numerator: squared * numerator.pow(2), denominator: denominator.pow(2) };
            Value::Beyond(square, Ratio::from_f64(needed_m))
        };
        let limit = |value| Limit::AtLeast(Ratio::from_f64(value));
        // 1 m if 0.5 m are needed, 1.414 m if 1.2 m are, 0.960 m if 0.5 m are.
        assert!(exceeds(0.05, 400, 0.5).meets(&limit(0.0)) && exceeds(0.05, 400, 0.5).meets(&limit(0.5)));
        assert!(!exceeds(0.05, 400, 0.5).meets(&limit(0.500_000_001)));
        assert!(exceeds(0.1, 200, 1.2).meets(&limit(0.0)) && exceeds(0.05, 369, 0.5).meets(&limit(0.1)));
        // Far more is needed than is available.
        for needed_m in [13.04, 13.5, 14.0, 100.0, 9000.0] {
            for distance in [1, 5, 12] {
                assert!(!exceeds(1.0, distance * distance, needed_m).meets(&limit(0.0)), "{needed_m}");
            }
        }
        assert!(!exceeds(0.05, 400, 0.5).meets(&limit(20.0)) && exceeds(0.05, 0, 0.5).meets(&limit(-1.0)));
        let mut state = 5u64;
        let mut next = |below: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % below
        };
        for _ in 0..20_000 {
            let edge_m = [0.05, 0.1, 0.02, 0.033][next(4) as usize];
            let (squared, needed_m) = (next(40_000), next(30_000_000) as f64 / 1e6);
            let least = next(9_000_000) as f64 / 1e6 - 2.0;
            let margin = (squared as f64).sqrt() * edge_m - needed_m - least;
            if margin.abs() > 1e-9 {
                let value = exceeds(edge_m, squared.into(), needed_m);
                let found = value.meets(&limit(least));
                assert_eq!(found, margin > 0.0, "{squared} voxels² of {edge_m} m, {needed_m} m, {least} m");
            }
        }
    }

    /// Comparison with sums over a common denominator.
    #[test]
    fn signs_are_those_of_common_denominators() {
        let mut state = 3u64;
        let mut next = |below: i128| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            i128::from(state >> 33) % below
        };
        let mut signs = [0; 3];
        for case in 0..20_000 {
            let all: Vec<(i128, i128)> = (0..1 + next(6)).map(|_| (next(41) - 20, 1 + next(30))).collect();
            let common: i128 = all.iter().map(|fraction| fraction.1).product();
            let sum: i128 = all.iter().map(|(n, d)| n * (common / d)).sum();
            assert_eq!(sign(all.iter().copied()), sum.cmp(&0), "case {case}: {all:?}");
            signs[(sum.signum() + 1) as usize] += 1;
        }
        assert!(signs.iter().all(|&count| count > 50), "{signs:?}");
    }

    #[test]
    fn the_worst_is_nearest_to_missing_the_limit() {
        let counts = |uo| Confusion { tp: 4 - uo, uo, ..Default::default() };
        let moments = [counts(1), counts(3), counts(0)];
        let value = |over, limit| Value::from_counts(Score::Unknown, over, &limit, &moments).unwrap();
        let (least, most) = (Limit::AtLeast(Ratio::from_f64(0.25)), Limit::AtMost(Ratio::from_f64(0.25)));
        assert_eq!(value(Across::Worst, least), mean(&[(0, 1)]));
        assert_eq!(value(Across::Worst, most), mean(&[(3, 4)]));
        assert_eq!(value(Across::Pooled, most), mean(&[(1, 3)]));
        assert_eq!(value(Across::Mean, most), mean(&[(1, 3)]));
        assert!(mean(&[(1, 4)]).meets(&least) && mean(&[(1, 4)]).meets(&most));
        assert!(!value(Across::Pooled, most).meets(&most));
        assert_eq!(Value::from_counts(Score::HumanSeen, Across::Mean, &least, &moments), None);
    }
}
