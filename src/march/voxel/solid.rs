//! Solids as voxels: which centres lie in a ball, a box, a cylinder, a column or near other voxels, row by
//! row and all in integers.
//!
//! | solid | voxels |
//! |---|---|
//! | [`ball`] | centres strictly within a radius of a voxel's centre |
//! | [`cylinder()`] | flat ends at two voxels' centres, strictly within a radius of the axis |
//! | [`cuboid`] | from a lowest to a highest voxel, both included |
//! | [`half_open_box`] | centres in a half-open box |
//! | [`column()`] | centres over a polygon, in a range of layers; half-open |
//! | [`dilate()`] | centres at most a distance from those of other voxels |

mod cylinder;
mod polygon;
mod within;

use std::ops::Range;

use super::BitGrid;
use super::grid::ONE_Q16;
pub use cylinder::cylinder;
pub use polygon::{NotSimple, column, is_simple};
pub use within::dilate;

/// Longest radius, as for all ranges: no grid is as large, and squares of lengths up to it stay within 64
/// bits.
pub const MAX_RADIUS_Q16: i64 = 2047 * ONE_Q16;

/// The first voxel whose centre is at or above a bound.
pub fn first_centre(bound_q16: i64) -> i64 {
    -(-(bound_q16 - ONE_Q16 / 2)).div_euclid(ONE_Q16)
}

/// The voxels whose centre is in a half-open range.
pub fn centres_in(range_q16: Range<i64>) -> Range<i64> {
    first_centre(range_q16.start)..first_centre(range_q16.end)
}

/// The centre of a voxel on one axis.
pub fn centre_q16(voxel: i64) -> i64 {
    voxel * ONE_Q16 + ONE_Q16 / 2
}

/// Sets a run of voxels along x, cut to the plane's window.
pub fn mark(plane: &mut BitGrid, run: &Range<i64>, y: i64, z: i64) {
    let window = plane.window();
    let (low, high) = (window.min[0] as i64, window.end()[0] as i64);
    if let (Ok(y), Ok(z)) = (i32::try_from(y), i32::try_from(z)) {
        plane.set_run(run.start.clamp(low, high) as i32, run.end.clamp(low, high) as i32, y, z);
    }
}

/// Sets the runs that `run` gives for the rows y, z of a plane among these; a run is along x.
fn mark_rows(plane: &mut BitGrid, [ys, zs]: [Range<i64>; 2], run: impl Fn(i64, i64) -> Range<i64>) {
    let (min, end) = (plane.window().min, plane.window().end());
    let cut = |rows: Range<i64>, r: usize| rows.start.max(min[r] as i64)..rows.end.min(end[r] as i64);
    for z in cut(zs, 2) {
        for y in cut(ys.clone(), 1) {
            mark(plane, &run(y, z), y, z);
        }
    }
}

/// Centres strictly within a radius of a point.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    center_q16: [i64; 3],
    radius_q16: i64,
}

impl Ball {
    /// `radius_q16` beyond [`MAX_RADIUS_Q16`] counts as that, below 0 as 0.
    pub fn new(center_q16: [i64; 3], radius_q16: i64) -> Ball {
        Ball { center_q16, radius_q16: radius_q16.clamp(0, MAX_RADIUS_Q16) }
    }

    /// The rows y, z that may hold a voxel.
    pub fn rows(&self) -> [Range<i64>; 2] {
        [1, 2].map(|r| {
            centres_in(self.center_q16[r] - self.radius_q16 + 1..self.center_q16[r] + self.radius_q16)
        })
    }

    /// The run along x of one of [`Ball::rows`].
    pub fn run(&self, y: i64, z: i64) -> Range<i64> {
        let [x, away_y, away_z] =
            [self.center_q16[0], centre_q16(y) - self.center_q16[1], centre_q16(z) - self.center_q16[2]];
        let left = self.radius_q16.pow(2) - away_y.pow(2) - away_z.pow(2);
        if left <= 0 {
            return 0..0;
        }
        // The largest whole x offset with x² < left.
        let reach = (left - 1).isqrt();
        centres_in(x - reach..x + reach + 1)
    }
}

/// Sets the voxels whose centre is less than a radius from the centre of voxel `center`: d² < r².
pub fn ball(plane: &mut BitGrid, center: [i32; 3], radius_q16: i64) {
    let ball = Ball::new(center.map(|c| centre_q16(c as i64)), radius_q16);
    mark_rows(plane, ball.rows(), |y, z| ball.run(y, z));
}

/// Sets the voxels from the smallest to the largest of `voxels` on each axis, both included; without voxels,
/// none.
pub fn cuboid(plane: &mut BitGrid, voxels: impl IntoIterator<Item = [i32; 3]>) {
    let grown = |all: Option<[[i32; 3]; 2]>, voxel: [i32; 3]| {
        let [low, high] = all.unwrap_or([voxel; 2]);
        Some([std::array::from_fn(|r| low[r].min(voxel[r])), std::array::from_fn(|r| high[r].max(voxel[r]))])
    };
    if let Some([low, high]) = voxels.into_iter().fold(None, grown) {
        let [x, y, z] = std::array::from_fn(|r| low[r] as i64..high[r] as i64 + 1);
        mark_rows(plane, [y, z], |_, _| x.clone());
    }
}

/// The voxels on each axis whose centre is at or above `low_q16` and below `high_q16`.
pub fn box_voxels(low_q16: [i64; 3], high_q16: [i64; 3]) -> [Range<i64>; 3] {
    std::array::from_fn(|r| centres_in(low_q16[r]..high_q16[r]))
}

/// Sets the voxels whose centre is at or above `low_q16` and below `high_q16` on every axis.
pub fn half_open_box(plane: &mut BitGrid, low_q16: [i64; 3], high_q16: [i64; 3]) {
    let [x, y, z] = box_voxels(low_q16, high_q16);
    mark_rows(plane, [y, z], |_, _| x.clone());
}

/// The x with a·x + b ≥ 0.
pub fn at_least_zero(a: i64, b: i64) -> Range<i64> {
    match a.signum() {
        1 => -b.div_euclid(a)..i64::MAX,
        -1 => i64::MIN..b.div_euclid(-a) + 1,
        _ if b >= 0 => i64::MIN..i64::MAX,
        _ => 0..0,
    }
}

/// What two ranges share.
pub fn both(a: Range<i64>, b: Range<i64>) -> Range<i64> {
    a.start.max(b.start)..a.end.min(b.end)
}

/// ⌈num / den⌉, den ≠ 0 of either sign.
pub fn ceil_div(num: i128, den: i128) -> i128 {
    let (num, den) = if den < 0 { (-num, -den) } else { (num, den) };
    -(-num).div_euclid(den)
}

/// Where an edge of points (s, t) passes a level of t, rounded up to a whole number, or `None` where it does
/// not: an edge has its lower end and lacks its upper one. It is the same for an edge and its reverse, so
/// what two areas share is never both's.
pub fn passes(from: [i64; 2], to: [i64; 2], level: i64) -> Option<i64> {
    if (from[1] <= level) == (to[1] <= level) {
        return None;
    }
    let [ds, dt] = [0, 1].map(|r| (to[r] - from[r]) as i128);
    Some(from[0] + ceil_div(ds * (level - from[1]) as i128, dt) as i64)
}

#[cfg(test)]
mod tests;
