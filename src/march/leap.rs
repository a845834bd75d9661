//! Many crossings at once: where a ray is at a distance. Exact like single steps, because crossings have a closed form.

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
