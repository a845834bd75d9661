//! A ray through the voxels, in integers: the arithmetic of `SEMANTICS.md` as pure functions. Each function
//! of `shaders/march.wgsl` has its twin of the same name here or in [`leap`], and `tests/backends/twins.rs` runs both.
//! Only the host uses the functions without a twin: [`crossings`], [`last_crossing`], [`voxel_after`], [`fold`], and
//! [`leap::made_at`], a quicker [`made_at`] for callers that have the direction at hand.

pub mod deviation;
pub mod leap;

/// A crossing that does not happen, later than any range.
pub const NEVER: u32 = 0x7fff_ffff;

/// Ranges are clamped to this many voxels. A grid's diagonal is at most 1772, so nothing is lost, and no
/// running sum of crossings leaves 32 bits.
pub const MAX_RANGE_VOXELS: u32 = 2047;

/// The least of a ray's length that is taken to go along the sensor's axis, in Q15: a sixteenth, as 86 degrees off it. So no
/// product with a ray's slant leaves 32 bits.
pub const LEAST_AXIAL_Q15: i32 = 1 << 11;

/// Largest standard deviation of a distance in voxels; a larger one would say nothing of any grid.
pub const MAX_STD_VOXELS: u32 = 64;

/// Deviations of the unit table: a standard normal distribution cut into so many equal shares.
pub const NOISE_STEPS: u32 = 4096;

/// The ray met no blocker within range inside the grid.
pub const NOTHING: u32 = 0;
/// The ray ended in a blocker within its range.
pub const RETURN: u32 = 1;
/// The ray's first blocker was nearer than the sensor can measure; it claims nothing.
pub const BLIND: u32 = 2;
/// The ray left the grid towards a backdrop: a return just outside.
pub const LEFT: u32 = 3;

/// How a ray ended, and in which of its voxels: `crossings` made on reaching the last voxel it entered inside
/// the grid (for a return or a blind ray, the blocker).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct End {
    /// [`NOTHING`], [`RETURN`], [`BLIND`] or [`LEFT`].
    pub kind: u32,
    /// Voxel boundaries crossed before the last voxel; the first voxel has none.
    pub crossings: u32,
}

impl End {
    /// One word, as the shaders store it: kind in the upper half, crossings in the lower.
    pub fn packed(self) -> u32 {
        self.kind << 16 | self.crossings
    }

    /// The inverse of [`End::packed`].
    pub fn unpacked(word: u32) -> Self {
        End { kind: word >> 16, crossings: word & 0xffff }
    }
}

/// How many bits number the shades of blockers.
pub const SHADE_BITS: usize = 3;

/// How many shades blockers may have, besides that of none.
pub const SHADES: usize = (1 << SHADE_BITS) - 1;

/// [`Gates::shade_ranges_q16`] where no shade matters.
pub const FULL_RANGE: [u32; SHADES] = [MAX_RANGE_VOXELS << 16; SHADES];

/// What decides how a ray ends, in 1/65536 voxels. Of a table, ranges may be depths; [`Gates::ray_gates`] makes distances of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gates {
    /// A first blocker entered before this distance blinds the ray.
    pub range_min_q16: u32,
    /// Nothing is entered after this distance; at most [`MAX_RANGE_VOXELS`].
    pub range_max_q16: u32,
    /// Whether ranges and noise are those of depth, which is measured along the sensor's axis (`range_along = "axis"`).
    pub along_axis: bool,
    /// The longest distance of a return by the shade of its blocker, from 1 on ([`crate::backend::Shades`]): from farther ones
    /// none comes back. The longest range where a shade does not matter.
    pub shade_ranges_q16: [u32; SHADES],
    /// Voxels entered before this distance are not tested: they are the sensor's own housing.
    pub near_ignore_q16: u32,
    /// Whether a ray that ends in nothing certifies that what it passed is free (`no_return = "free"`).
    pub no_return_is_free: bool,
    /// Whether a ray that leaves the grid returns from just outside (`outside = "backdrop"`).
    pub backdrop: bool,
}

impl Gates {
    /// The slant of a ray with `z_q15` of its length along the sensor's axis.
    pub fn slant(&self, z_q15: i32) -> Slant {
        Slant::new(axial_q16(z_q15, self.along_axis))
    }

    /// Whether dark blockers return less far than others.
    pub fn has_shades(&self) -> bool {
        self.shade_ranges_q16.iter().any(|&range_q16| range_q16 < self.range_max_q16)
    }

    /// The gates of a ray with `z_q15` of its length along the sensor's axis: its ranges as distances along it.
    pub fn ray_gates(&self, z_q15: i32) -> Gates {
        let slant = self.slant(z_q15);
        Gates {
            range_min_q16: ray_range_q16(self.range_min_q16, slant.period_q16),
            range_max_q16: ray_range_q16(self.range_max_q16, slant.period_q16),
            shade_ranges_q16: self.shade_ranges_q16.map(|q16| ray_range_q16(q16, slant.period_q16)),
            along_axis: false,
            ..*self
        }
    }
}

/// How far a ray goes to come a voxel farther along what ranges and noise are measured along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slant {
    /// The ray's component along it, Q16 ([`axial_q16`]).
    pub axial_q16: u32,
    /// The distance for a voxel, as if it were an axis that the ray crosses: [`period_q16`] of the component.
    pub period_q16: u32,
}

impl Slant {
    /// From the component.
    pub fn new(axial_q16: u32) -> Slant {
        Slant { axial_q16, period_q16: period_q16(axial_q16) }
    }

    /// What a depth is along the ray ([`ray_range_q16`]).
    pub fn ray_range_q16(&self, depth_q16: u32) -> u32 {
        ray_range_q16(depth_q16, self.period_q16)
    }
}

/// How much of a ray goes along what its sensor measures along, in Q16: all, or with `along_axis` the component `z_q15` (Q15) of
/// its direction along the sensor's axis, [`LEAST_AXIAL_Q15`] at least.
#[inline(always)]
pub fn axial_q16(z_q15: i32, along_axis: bool) -> u32 {
    if along_axis { 2 * z_q15.max(LEAST_AXIAL_Q15) as u32 } else { 1 << 16 }
}

/// How far along a ray a depth is: ⌊depth · period / 2¹⁶⌋ for the period of its slant, and at most [`MAX_RANGE_VOXELS`], as the
/// depth.
#[inline(always)]
pub fn ray_range_q16(depth_q16: u32, period_q16: u32) -> u32 {
    let range_q16 = (depth_q16 >> 16) * period_q16 + first_q16(depth_q16 & 0xffff, period_q16);
    range_q16.min(MAX_RANGE_VOXELS << 16)
}

/// The standard deviation along a ray whose depth has `std_q16`: at most [`MAX_STD_VOXELS`].
#[inline(always)]
pub fn std_along_q16(std_q16: u32, period_q16: u32) -> u32 {
    ray_range_q16(std_q16, period_q16).min(MAX_STD_VOXELS << 16)
}

/// A ray on its way: the voxel it is in and when it next crosses a boundary of each axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct March {
    /// The voxel, from the grid's corner.
    pub voxel: [i32; 3],
    /// −1, 0 or 1: where a crossing of each axis leads.
    pub step: [i32; 3],
    /// Distance of the next crossing of each axis in 1/65536 voxels.
    pub next_q16: [u32; 3],
    /// Distance between crossings of each axis.
    pub period_q16: [u32; 3],
}

/// Distance between two crossings of an axis for a direction component of magnitude `d` in Q16:
/// ⌊2³² / d⌋, at most [`NEVER`], and [`NEVER`] for zero.
///
/// By a division of floats, which processors do many at a time. A quotient that is no whole number is 1/65539 or more from
/// the next above, so that rounding what is less by almost a half rounds the quotient down. Adding 2⁵² rounds, and leaves
/// the whole number in the lowest bits; a conversion, which looks at what cannot be converted, is made one by one.
#[inline(always)]
pub fn period_q16(d: u32) -> u32 {
    const DOWN: f64 = 0.5 - 1.0 / 262_144.0;
    const WHOLE: f64 = (1u64 << 52) as f64;
    // 2³² / 2 is already past NEVER.
    let quotient = 4_294_967_296.0 / f64::from(d.max(3)) - DOWN + WHOLE;
    if d < 3 { NEVER } else { quotient.to_bits() as u32 }
}

/// Distance to the first crossing when `f` of 65536 parts of the first voxel lie ahead: ⌊f · period / 2¹⁶⌋.
pub fn first_q16(f: u32, period: u32) -> u32 {
    (period >> 16) * f + (((period & 0xffff) * f) >> 16)
}

/// One component of a ray's direction in the grid, Q16: the row of `world_from_sensor` for that axis (Q15)
/// times the direction in the sensor's frame (Q15), rounded.
pub fn direction_q16(axis_q15: [i32; 3], dir_q15: [i32; 3]) -> i32 {
    (axis_q15[0] * dir_q15[0] + axis_q15[1] * dir_q15[1] + axis_q15[2] * dir_q15[2] + (1 << 13)) >> 14
}

/// One axis of [`start`]: when it is first crossed, and how often after that.
#[inline(always)]
pub fn start_axis(origin_q16: i32, dir_q16: i32) -> [u32; 2] {
    let frac = (origin_q16 & 0xffff) as u32;
    let ahead = if dir_q16 < 0 { frac } else { (1 << 16) - frac };
    let period = period_q16(dir_q16.unsigned_abs());
    // Computed in any case, without a branch, so that lanes are computed together.
    let first = first_q16(ahead, period);
    [if dir_q16 == 0 { NEVER } else { first }, period]
}

/// The march from a position (1/65536 voxels from the grid's corner) along a direction in Q16.
pub fn start(origin_q16: [i32; 3], dir_q16: [i32; 3]) -> March {
    let axes: [[u32; 2]; 3] = std::array::from_fn(|r| start_axis(origin_q16[r], dir_q16[r]));
    March {
        voxel: origin_q16.map(|x| x >> 16),
        step: dir_q16.map(i32::signum),
        next_q16: axes.map(|[first, _]| first),
        period_q16: axes.map(|[_, period]| period),
    }
}

/// The march of a ray of a table: [`start`] in the direction that the rows of `world_from_sensor` (Q15) give
/// it.
pub fn launch(origin_q16: [i32; 3], axis_q15: [[i32; 3]; 3], dir_q15: [i32; 3]) -> March {
    start(origin_q16, axis_q15.map(|axis| direction_q16(axis, dir_q15)))
}

/// The axis crossed next. Ties take x before y before z, so that every backend visits the same voxels.
pub fn next_axis(next_q16: [u32; 3]) -> usize {
    let [x, y, z] = next_q16;
    // Two selections instead of nested branches: which axis comes next is close to random, and a wrong guess
    // of the processor costs more than the whole step.
    let (nearest, axis) = if y < x { (y, 1) } else { (x, 0) };
    if z < nearest { 2 } else { axis }
}

/// Makes the next crossing, of `axis`. Not to be called once `next_q16[axis]` is past the range: within it no
/// sum leaves 32 bits.
pub fn cross(march: &mut March, axis: usize) {
    march.voxel[axis] += march.step[axis];
    march.next_q16[axis] += march.period_q16[axis];
}

/// A crossing of a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossing {
    /// Its distance in 1/65536 voxels.
    pub t_q16: u32,
    /// The axis whose boundary is crossed.
    pub axis: usize,
    /// The voxel that it leads into, inside a grid or not.
    pub voxel: [i32; 3],
}

/// The crossings of a ray one by one, in order, up to the longest range; for the host, where one ray at a
/// time is followed.
pub fn crossings(mut ray: March) -> impl Iterator<Item = Crossing> {
    std::iter::from_fn(move || {
        let axis = next_axis(ray.next_q16);
        let t_q16 = ray.next_q16[axis];
        (t_q16 <= MAX_RANGE_VOXELS << 16).then(|| {
            cross(&mut ray, axis);
            Crossing { t_q16, axis, voxel: ray.voxel }
        })
    })
}

/// The last of so many crossings of a ray; none if it makes none.
pub fn last_crossing(begin: March, made: u32) -> Option<Crossing> {
    crossings(begin).take(made as usize).last()
}

/// The voxel that a ray is in after so many crossings.
pub fn voxel_after(begin: March, made: u32) -> [i32; 3] {
    last_crossing(begin, made).map_or(begin.voxel, |crossing| crossing.voxel)
}

/// How many leading voxels of a ray its end proves free: those before the blocker of a return, all that it
/// entered when it left towards a backdrop or when a silent ray certifies, none otherwise.
pub fn freed(end: End, no_return_is_free: bool) -> u32 {
    match end.kind {
        RETURN => end.crossings,
        LEFT => end.crossings + 1,
        NOTHING if no_return_is_free => end.crossings + 1,
        _ => 0,
    }
}

/// How many crossings of one axis are made when a ray has come to (`t_q16`, `axis`) in the order of all
/// crossings, those at that very place included: `own` is the axis in question. An axis below 0 comes before
/// all crossings at its distance.
pub fn made_at(first_q16: u32, period_q16: u32, own: i32, t_q16: u32, axis: i32) -> u32 {
    // At the same distance a later axis has not crossed yet.
    let from_q16 = first_q16 + (own > axis) as u32;
    if from_q16 > t_q16 { 0 } else { (t_q16 - from_q16) / period_q16 + 1 }
}

/// When crossing `n` of an axis happens, in closed form; [`NEVER`] where that is past any grid, so nothing
/// wraps.
pub fn crossing_q16(first_q16: u32, period_q16: u32, n: u32) -> u32 {
    if first_q16 == NEVER || n * (period_q16 >> 16) > MAX_RANGE_VOXELS {
        return NEVER;
    }
    first_q16 + n * period_q16
}

/// How many crossings a ray has made at a distance, stopped in the last voxel inside the grid. `room` says
/// how many crossings of each axis stay inside; the ray must be at its start.
pub fn crossings_at(begin: &March, room: [u32; 3], t_q16: u32) -> u32 {
    made_until(begin, room, t_q16, 2).iter().sum()
}

/// How many crossings of each axis are made by a ray that has come to (`t_q16`, `axis`) in the order of all
/// crossings ([`made_at`]), or to the last voxel inside the grid before.
pub fn made_until(begin: &March, room: [u32; 3], t_q16: u32, axis: i32) -> [u32; 3] {
    let [first, period] = [begin.next_q16, begin.period_q16];
    let leaves: [u32; 3] = std::array::from_fn(|r| crossing_q16(first[r], period[r], room[r]));
    let exit = next_axis(leaves);
    let (t_q16, axis) = match (leaves[exit], exit as i32) {
        // Of crossings at the same distance as the exit, those of lower axes come first.
        (exit_q16, exit) if (exit_q16, exit) <= (t_q16, axis) => (exit_q16, exit - 1),
        _ => (t_q16, axis),
    };
    std::array::from_fn(|r| made_at(first[r], period[r], r as i32, t_q16, axis))
}

/// How many crossings of each axis stay inside a grid.
pub fn room(begin: &March, size: [u32; 3]) -> [u32; 3] {
    std::array::from_fn(|r| {
        if begin.step[r] < 0 { begin.voxel[r] as u32 } else { size[r] - 1 - begin.voxel[r] as u32 }
    })
}

/// The PCG hash of 32 bits (Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 2020).
pub fn pcg(word: u32) -> u32 {
    let state = word.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let mixed = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (mixed >> 22) ^ mixed
}

/// The number that a ray draws; `draws` is the hash of all that precedes the ray ([`fold`]).
pub fn draw(draws: u32, ray: u32) -> u32 {
    pcg(draws ^ ray)
}

/// Which of the [`NOISE_STEPS`] deviations of a table goes with a drawn number.
pub fn entry(drawn: u32) -> u32 {
    drawn >> (32 - NOISE_STEPS.ilog2())
}

/// Whether the return of a ray that drew this number is lost. The number is hashed once more, so that what is
/// lost does not depend on how far off it would be read.
pub fn is_lost(drawn: u32, lost_below: u32) -> bool {
    pcg(drawn) < lost_below
}

/// The error in distance of a return: a deviation of the unit table (Q12) times the standard deviation at its
/// distance (Q16), rounded: (unit · std + 2¹¹) >> 12. In two parts, since the product has more than 32 bits.
pub fn step_q16(unit_q12: i32, std_q16: u32) -> i32 {
    let (whole, part) = ((std_q16 >> 12) as i32, (std_q16 & 0xfff) as i32);
    unit_q12 * whole + ((unit_q12 * part + (1 << 11)) >> 12)
}

/// The hash of a sequence of words.
pub fn fold(words: impl IntoIterator<Item = u32>) -> u32 {
    words.into_iter().fold(0, |hash, word| pcg(hash ^ word))
}

/// Where a return at `t_q16` is read with a step of noise.
pub fn noisy_q16(t_q16: u32, step_q16: i32) -> u32 {
    (t_q16 as i32 + step_q16).max(0) as u32
}

#[cfg(test)]
mod tests;
