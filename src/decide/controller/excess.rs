//! The excess of one distance between voxels over another, compared exactly: a difference of roots.

use std::cmp::Ordering;

use super::separation::Separation;
use perirobot_march::metrics::{Ratio, gcd};

/// The excess of a measured distance of a person over the true one; both squared, in whole voxels, with the first at
/// least the second.
#[derive(Clone, Copy, Debug)]
pub struct Excess {
    /// The measured distance.
    pub measured: u32,
    /// The true distance.
    pub truly: u32,
    /// Edge of a voxel, equal in all compared values.
    pub voxel_size_m: f64,
}

impl Excess {
    /// As a number for display.
    pub(crate) fn metres(&self) -> f64 {
        let metres = |squared| Separation::metres(squared, self.voxel_size_m);
        metres(self.measured) - metres(self.truly)
    }

    /// Compares it with a nonnegative fraction of at most nine decimals; the edge of a voxel is rounded to nine
    /// decimals as well.
    ///
    /// With edge e and limit l in whole nanometres, e√m - e√t is compared with l as e√m with l + e√t: by squares, as
    /// e²m - e²t - l² with 2le√t, and if that is not below 0, by squares again.
    pub(crate) fn cmp_ratio(&self, limit: Ratio) -> Ordering {
        let edge = Ratio::from_f64(self.voxel_size_m);
        let (e, l) = (edge.numerator * limit.denominator, limit.numerator * edge.denominator);
        let common = gcd(e, l);
        let (e, l) = (e / common, l / common);
        let [m, t] = [self.measured, self.truly].map(i128::from);
        let left = e * e * (m - t) - l * l;
        if left < 0 {
            return Ordering::Less;
        }
        let (left, right) = (left.unsigned_abs(), (2 * l * e).unsigned_abs());
        product(left, left).cmp(&product(right, right * t.unsigned_abs()))
    }
}

impl Ord for Excess {
    /// √m - √t compared with √n - √u, as √m + √u with √n + √t, by squares.
    fn cmp(&self, other: &Excess) -> Ordering {
        let [m, t, n, u] = [self.measured, self.truly, other.measured, other.truly].map(i128::from);
        let (apart, one, two) = (m + u - n - t, m * u, n * t);
        // apart + 2√one compared with 2√two.
        let is_above = |apart: i128, one: i128, two: i128| {
            let rest = apart * apart + 4 * (one - two);
            if rest >= 0 && (rest > 0 || one > 0) {
                Ordering::Greater
            } else {
                (16 * apart * apart * one).cmp(&(rest * rest))
            }
        };
        match apart.signum() {
            0 => one.cmp(&two),
            1 => is_above(apart, one, two),
            _ => is_above(-apart, two, one).reverse(),
        }
    }
}

impl PartialOrd for Excess {
    fn partial_cmp(&self, other: &Excess) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Excess {
    fn eq(&self, other: &Excess) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Excess {}

/// A product as its upper and its lower 128 bits.
fn product(a: u128, b: u128) -> [u128; 2] {
    let halves = |n: u128| [n >> 64, n & u128::from(u64::MAX)];
    let ([a1, a0], [b1, b0]) = (halves(a), halves(b));
    let (low, cross) = (a0 * b0, a1 * b0);
    let middle = (low >> 64) + halves(cross)[1] + halves(a0 * b1)[1];
    let upper = a1 * b1 + (cross >> 64) + ((a0 * b1) >> 64) + (middle >> 64);
    [upper, (middle << 64) | halves(low)[1]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn excess(measured: u32, truly: u32, voxel_size_m: f64) -> Excess {
        Excess { measured, truly, voxel_size_m }
    }

    /// Whole roots are compared exactly; for other roots floating point decides unless they are nearly equal.
    #[test]
    fn differences_of_roots_are_compared_exactly() {
        let mut equal = 0;
        for number in 0..12u32.pow(4) {
            let [a, b, c, d] = [1, 12, 144, 1728].map(|place| number / place % 12);
            // Whole roots, and ten times as many voxels: the difference is √10 times as large.
            for times in [1, 10] {
                let between = |m: u32, t: u32| excess(times * m.max(t).pow(2), times * t.min(m).pow(2), 0.05);
                let expected = a.abs_diff(b).cmp(&c.abs_diff(d));
                assert_eq!(between(a, b).cmp(&between(c, d)), expected, "{a} {b} {c} {d}");
                equal += usize::from(expected.is_eq());
            }
            let one = excess(a * b + a, a * b.min(a), 1.0);
            let two = excess(c * d + c, c * d.min(c), 1.0);
            let apart = one.metres() - two.metres();
            if apart.abs() > 1e-9 {
                assert_eq!(one.cmp(&two), apart.total_cmp(&0.0), "{one:?} {two:?}");
            }
        }
        assert!(equal > 1000, "{equal}");
    }

    #[test]
    fn a_limit_is_met_at_its_value_and_no_farther() {
        for (measured, truly, edge, limit, expected) in [
            // 21 and 9 voxels of 5 cm: 0.6 m.
            (441, 81, 0.05, 0.6, Ordering::Equal),
            (441, 81, 0.05, 0.600000001, Ordering::Less),
            (441, 81, 0.05, 0.599999999, Ordering::Greater),
            (442, 81, 0.05, 0.6, Ordering::Greater),
            (441, 82, 0.05, 0.6, Ordering::Less),
            (7, 7, 0.05, 0.0, Ordering::Equal),
            (8, 7, 0.05, 0.0, Ordering::Greater),
            // √12 - √3 = √3, which differs from all of these.
            (12, 3, 1.0, 1.732050807, Ordering::Greater),
            (12, 3, 1.0, 1.732050808, Ordering::Less),
            // The largest grid of voxels with nine digits: 1023 of 9.999999999 m.
            (1_046_529, 0, 9.999999999, 10_000.0, Ordering::Greater),
            (1_046_529, 1_044_484, 9.999999999, 9.999999999, Ordering::Equal),
            (1_046_529, 1_044_484, 9.999999999, 9.999999998, Ordering::Greater),
        ] {
            assert_eq!(
                excess(measured, truly, edge).cmp_ratio(Ratio::from_f64(limit)),
                expected,
                "{measured} {truly} {limit}"
            );
        }
    }

    #[test]
    fn products_have_all_their_bits() {
        assert_eq!(product(u128::MAX, u128::MAX), [u128::MAX - 1, 1]);
        assert_eq!(product(1 << 100, 1 << 100), [1 << 72, 0]);
        assert_eq!(product((1 << 64) + 3, (1 << 64) + 5), [1, (8 << 64) + 15]);
    }
}
