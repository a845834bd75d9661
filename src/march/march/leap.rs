//! Many crossings at once: where a ray is at a distance, and when it comes to a voxel.
//!
//! # Theory
//! Crossing n of an axis happens at first + n · period (`SEMANTICS.md`, "Rays"), so how many lie at or before
//! a place in the order of (distance, axis) is a floor division, without rounding: the ray lands where single
//! steps would have led.
//!
//! # Practice
//! Used wherever a ray passes space that is known to be empty, for the place where a return is read, and to
//! test whether one ray visits one voxel.

use super::{March, NEVER};

/// How many whole periods lie in a distance: ⌊x / period⌋, for the period of a direction component of
/// magnitude `d`.
///
/// period = ⌊2³² / d⌋, so x·d / 2³² is below x / period by less than 2⁻¹⁶ of it. With fewer than 2¹⁶ periods
/// in any range it falls short of the next whole number at most once, which a multiplication finds.
#[inline(always)]
pub fn periods_in(x: u32, period_q16: u32, d: u32) -> u32 {
    let low = ((x as u64 * d as u64) >> 32) as u32;
    low + ((low + 1) * period_q16 <= x) as u32
}

/// [`super::made_at`] by a multiplication with the direction component's magnitude `d`, which is much quicker
/// than the division where each leap asks.
#[inline(always)]
pub(crate) fn made_at(first_q16: u32, period_q16: u32, d: u32, own: u32, t_q16: u32, axis: u32) -> u32 {
    // At the same distance a later axis has not crossed yet.
    let later = (own > axis) as u32;
    if first_q16 > t_q16 || (first_q16 == t_q16 && own > axis) {
        return 0;
    }
    periods_in(t_q16 - first_q16 - later, period_q16, d) + 1
}

/// One axis of a ray. Crossings come in the order of (distance, axis), so that both are one number,
/// distance · 4 + axis: adding periods never changes the axis, and no tie is left.
#[derive(Clone, Copy, Debug)]
pub struct RayAxis {
    /// −1, 0 or 1: where a crossing leads. As wide as crossings are, so that lanes are compared together.
    pub step: i64,
    /// The next crossing.
    pub next: u64,
    /// Distance between crossings in 1/65536 voxels.
    pub period_q16: u32,
}

impl RayAxis {
    /// Axis `r` of a ray at its start, from what [`super::start_axis`] says of it.
    #[inline(always)]
    pub(crate) fn new(r: usize, step: i32, first_q16: u32, period_q16: u32) -> RayAxis {
        RayAxis { step: step.into(), next: 4 * u64::from(first_q16) + r as u64, period_q16 }
    }

    /// The crossing after `n` others.
    #[inline(always)]
    pub(crate) fn crossing(&self, n: u32) -> u64 {
        self.next + 4 * (u64::from(n) * u64::from(self.period_q16))
    }

    /// The crossing that leaves the voxels from `low` to `high`, counted from the ray's own, which is one of
    /// them.
    #[inline(always)]
    pub(crate) fn leaves(&self, low: i32, high: i32) -> u64 {
        self.crossing((if self.step < 0 { -low } else { high }) as u32)
    }

    /// The crossings that enter and leave the voxels from `low` to `high`, counted from the ray's own: 0
    /// enters if that is one of them, none (`u64::MAX`) if the ray leads away from them.
    #[inline(always)]
    pub(crate) fn slab(&self, low: i32, high: i32) -> [u64; 2] {
        if low <= 0 && high >= 0 {
            return [0, self.leaves(low, high)];
        }
        let (towards, near, far) = if low > 0 { (1, low, high) } else { (-1, -high, -low) };
        let enters = self.crossing(near as u32) - 4 * u64::from(self.period_q16);
        [if self.step == towards { enters } else { u64::MAX }, self.crossing(far as u32)]
    }
}

/// The crossings by which a ray enters and leaves a box, from its lowest voxel to its highest, both counted
/// from the ray's own; `None` if it never is in it, 0 for entering the box where it begins.
#[inline(always)]
pub(crate) fn span(axis: impl Fn(usize) -> RayAxis, low: [i32; 3], high: [i32; 3]) -> Option<[u64; 2]> {
    let (mut enters, mut leaves) = (0, u64::MAX);
    for r in 0..3 {
        let [own_enters, own_leaves] = axis(r).slab(low[r], high[r]);
        (enters, leaves) = (enters.max(own_enters), leaves.min(own_leaves));
        // Both are the same where a ray leaves at once what it begins in, and nowhere else.
        if enters > leaves {
            return None;
        }
    }
    Some([enters, leaves])
}

/// When a ray enters a voxel, were nothing in its way; `None` if it does not, 0 for the voxel where it
/// begins. The ray must be at its start.
pub fn entry_q16(begin: &March, voxel: [i32; 3]) -> Option<u32> {
    let away = std::array::from_fn(|r| voxel[r] - begin.voxel[r]);
    let axis = |r: usize| RayAxis::new(r, begin.step[r], begin.next_q16[r], begin.period_q16[r]);
    let [enters, _] = span(axis, away, away)?;
    Some((enters / 4).min(NEVER.into()) as u32)
}

/// Whether a ray visits a voxel, were nothing in its way. The ray must be at its start.
pub fn visits(begin: &March, voxel: [i32; 3]) -> bool {
    entry_q16(begin, voxel).is_some_and(|enters_q16| enters_q16 < NEVER)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::march::{MAX_RANGE_VOXELS, cross, crossings, next_axis, period_q16, start};

    #[test]
    fn cells_are_entered_when_single_steps_enter_them() {
        // Along lattice lines, through corners, and in no simple direction.
        let dirs =
            [[65_536, 0, 0], [-37_837; 3], [46_341, -46_341, 0], [1, -2, 65_535], [40_000, 30_000, -41_000]];
        for origin_q16 in [[5 << 16; 3], [0x5_8000; 3], [0x5_1234, 0x4_ffff, 0x6_0001]] {
            for dir_q16 in dirs {
                let begin = start(origin_q16, dir_q16);
                let (mut at, mut entered) = (begin, vec![(begin.voxel, 0)]);
                for _ in 0..30 {
                    let axis = next_axis(at.next_q16);
                    let t = at.next_q16[axis];
                    if t < NEVER {
                        cross(&mut at, axis);
                        entered.push((at.voxel, t));
                    }
                }
                for voxel in (0..11i32.pow(3)).map(|i| [i % 11, i / 11 % 11, i / 121]) {
                    let expected = entered.iter().find(|(entered, _)| *entered == voxel).map(|(_, t)| *t);
                    let found = entry_q16(&begin, voxel).filter(|&t| t < NEVER);
                    assert_eq!(found, expected, "{voxel:?} from {origin_q16:?} along {dir_q16:?}");
                }
            }
        }
    }

    /// A ray's crossings as numbers, distance · 4 + axis, each with the voxel it leads into.
    fn step_all(begin: March) -> Vec<(u64, [i32; 3])> {
        let number = |to: crate::march::Crossing| (4 * u64::from(to.t_q16) + to.axis as u64, to.voxel);
        crossings(begin).map(number).take(60).collect()
    }

    #[test]
    fn boxes_are_entered_and_left_by_the_crossings_of_single_steps() {
        let dirs =
            [[65_536, 0, 0], [-37_837; 3], [46_341, -46_341, 0], [3, -4, 65_535], [40_000, 30_000, -41_000]];
        let mut missed = 0;
        for origin_q16 in [[5 << 16; 3], [0x5_8000; 3], [0x5_1234, 0x4_ffff, 0x6_0001]] {
            for dir_q16 in dirs {
                let begin = start(origin_q16, dir_q16);
                let steps = step_all(begin);
                for number in 0..9i32.pow(3) {
                    let low = [number % 9, number / 9 % 9, number / 81];
                    let high = std::array::from_fn(|r| low[r] + (number + r as i32) % 4);
                    let holds = |voxel: [i32; 3]| (0..3).all(|r| low[r] <= voxel[r] && voxel[r] <= high[r]);
                    let enters = steps.iter().find(|(_, voxel)| holds(*voxel)).map(|(at, _)| *at);
                    let enters = if holds(begin.voxel) { Some(0) } else { enters };
                    let leaves = |enters: u64| {
                        let after = |&&(at, voxel): &&(u64, [i32; 3])| {
                            (at > enters || holds(begin.voxel)) && !holds(voxel)
                        };
                        steps.iter().find(after).map(|(at, _)| [enters, *at])
                    };
                    let away = |voxel: [i32; 3]| std::array::from_fn(|r| voxel[r] - begin.voxel[r]);
                    let axis =
                        |r: usize| RayAxis::new(r, begin.step[r], begin.next_q16[r], begin.period_q16[r]);
                    let found = span(axis, away(low), away(high));
                    missed += usize::from(found.is_none());
                    assert_eq!(
                        found,
                        enters.and_then(leaves),
                        "{low:?} to {high:?} from {origin_q16:?} along {dir_q16:?}"
                    );
                }
            }
        }
        assert!((1000..10_500).contains(&missed), "{missed} of 10,935 boxes are missed");
    }

    /// Directions, distances and multiples of periods, and what lies beside them.
    fn distances(period: u32) -> impl Iterator<Item = u32> {
        const LAST: u64 = (2 * MAX_RANGE_VOXELS as u64) << 16;
        let multiples = (0..40u64).chain([500, 1022, 1023]).map(move |n| n * u64::from(period));
        let beside = multiples.flat_map(|x| [x.saturating_sub(1), x, x + 1]);
        beside.chain([LAST - 1, LAST]).filter(|&x| x <= LAST).map(|x| x as u32)
    }

    #[test]
    fn periods_are_counted_exactly() {
        for d in (1..=65_539u32).step_by(7).chain([1, 2, 3, 65_535, 65_536, 65_537, 65_539]) {
            let period = period_q16(d);
            for x in distances(period) {
                assert_eq!(periods_in(x, period, d), x / period, "{x} in periods of {period}, d {d}");
            }
        }
    }

    #[test]
    fn crossings_made_are_those_up_to_a_place() {
        for d in [3, 700, 21_845, 32_768, 65_535, 65_536, 65_539] {
            let period = period_q16(d);
            for first in [0, 1, period / 2, period - 1] {
                for t in distances(period) {
                    for (own, axis) in [(0, 0), (0, 2), (1, 0), (1, 1), (2, 1)] {
                        let crossings = (0..2100u64).map(|n| u64::from(first) + n * u64::from(period));
                        let place = (u64::from(t), axis);
                        let made = crossings.take_while(|&at| (at, own) <= place).count() as u32;
                        if made < 2100 {
                            assert_eq!(made_at(first, period, d, own, t, axis), made, "{first} {period} {t}");
                            let shared = crate::march::made_at(first, period, own as i32, t, axis as i32);
                            assert_eq!(shared, made, "{first} {period} {t}");
                        }
                    }
                }
            }
        }
    }
}
