//! Many crossings at once: where a ray is at a distance, and when it comes to a voxel.
//!
//! # Theory
//! Crossing n of an axis happens at first + n · period (`SEMANTICS.md`, "Rays"), so how many lie at or before
//! a place in the order of (distance, axis) is a floor division, without rounding: the ray lands where single
//! steps would have led.
//!
//! # Practice
//! Wherever a ray passes what is known to be empty, where returns are read, and where single voxels ask for
//! single rays.

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

/// How many crossings of one axis are made when a ray has come to (`t_q16`, `axis`) in the order of all
/// crossings, those at that very place included: `own` is the axis in question.
#[inline(always)]
pub fn made_at(first_q16: u32, period_q16: u32, d: u32, own: u32, t_q16: u32, axis: u32) -> u32 {
    // At the same distance a later axis has not crossed yet.
    let later = (own > axis) as u32;
    if first_q16 > t_q16 || (first_q16 == t_q16 && own > axis) {
        return 0;
    }
    periods_in(t_q16 - first_q16 - later, period_q16, d) + 1
}

/// When a ray enters a voxel, were nothing in its way; `None` if it does not, 0 for the voxel where it
/// begins. The ray must be at its start.
pub fn entry_q16(begin: &March, voxel: [i32; 3]) -> Option<u32> {
    if voxel == begin.voxel {
        return Some(0);
    }
    // Crossings in order are numbers, distance · 4 + axis.
    let (mut enters, mut leaves) = (0, u64::MAX);
    for r in 0..3 {
        let away = voxel[r] - begin.voxel[r];
        let (first, period) = (u64::from(begin.next_q16[r]), u64::from(begin.period_q16[r]));
        let last = 4 * (first + u64::from(away.unsigned_abs()) * period) + r as u64;
        leaves = leaves.min(last);
        if away != 0 {
            if away.signum() != begin.step[r] {
                return None;
            }
            enters = enters.max(last - 4 * period);
        }
    }
    (enters < leaves).then_some((enters / 4).min(NEVER.into()) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::march::{MAX_RANGE_VOXELS, cross, next_axis, period_q16, start};

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
                        }
                    }
                }
            }
        }
    }
}
