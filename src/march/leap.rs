//! Many crossings at once: where a ray is at a distance, and how it leaves a box of voxels. Exact like single steps,
//! because crossings have a closed form; which boxes are empty is for others to know.

use super::{NEVER, crossing_q16, next_axis};

/// How many whole periods lie in a distance: ⌊x / period⌋, for the period of a direction component of magnitude `d`.
///
/// period = ⌊2³² / d⌋, so x·d / 2³² is below x / period by less than 2⁻¹⁶ of it. With fewer than 2¹⁶ periods in any range
/// it falls short of the next whole number at most once, which a multiplication finds.
#[inline(always)]
pub fn periods_in(x: u32, period_q16: u32, d: u32) -> u32 {
    let low = ((x as u64 * d as u64) >> 32) as u32;
    low + ((low + 1) * period_q16 <= x) as u32
}

/// How many crossings of one axis are made when a ray has come to (`t_q16`, `axis`) in the order of all crossings, those
/// at that very place included: `own` is the axis in question.
#[inline(always)]
pub fn made_at(first_q16: u32, period_q16: u32, d: u32, own: u32, t_q16: u32, axis: u32) -> u32 {
    // At the same distance a later axis has not crossed yet.
    let later = (own > axis) as u32;
    if first_q16 > t_q16 || (first_q16 == t_q16 && own > axis) {
        return 0;
    }
    periods_in(t_q16 - first_q16 - later, period_q16, d) + 1
}

/// A crossing: its distance and axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// Distance along the ray in 1/65536 voxels.
    pub t_q16: u32,
    /// 0, 1 or 2; at one distance x crosses before y before z.
    pub axis: u32,
}

/// The crossing by which a ray leaves a box, of which `room` more voxels lie ahead on each axis.
#[inline(always)]
pub fn exit(next_q16: [u32; 3], period_q16: [u32; 3], room: [u32; 3]) -> Key {
    let leaves: [u32; 3] = std::array::from_fn(|r| crossing_q16(next_q16[r], period_q16[r], room[r]));
    let axis = next_axis(leaves);
    Key { t_q16: leaves[axis], axis: axis as u32 }
}

/// Whether a ray from a voxel visits another: `ahead` voxels away on each axis in the direction of its steps, told from
/// its first crossings. It does if it enters on every axis before it leaves on any.
#[inline(always)]
pub fn visits(first_q16: [u32; 3], period_q16: [u32; 3], ahead: [u32; 3]) -> bool {
    let mut enters = None;
    for r in 0..3 {
        if ahead[r] > 0 {
            let t_q16 = crossing_q16(first_q16[r], period_q16[r], ahead[r] - 1);
            enters = enters.max(Some(Key { t_q16, axis: r as u32 }));
        }
    }
    let leaves = exit(first_q16, period_q16, ahead);
    // A crossing that never happens enters nothing.
    enters.is_none_or(|enters| enters.t_q16 < NEVER && enters < leaves)
}
