//! The cylinder between two voxels' centres, as a run of voxels a row. It is convex, so a row has one run:
//! where the ends let it through and the axis is near enough.

use std::ops::Range;

use super::super::BitGrid;
use super::super::grid::ONE_Q16;
use super::{MAX_RADIUS_Q16, at_least_zero, both, ceil_div, mark_rows};

/// Sets the voxels whose centre's projection on the axis lies between the centres of voxels `from` and `to`,
/// both included, and whose distance from the axis is less than the radius. Nothing if `from` is `to`: there
/// is no axis.
///
/// Voxels lie in a grid. A radius beyond [`MAX_RADIUS_Q16`] counts as that.
pub fn cylinder(plane: &mut BitGrid, from: [i32; 3], to: [i32; 3], radius_q16: i64) {
    let radius_q16 = radius_q16.clamp(0, MAX_RADIUS_Q16);
    let axis: [i64; 3] = std::array::from_fn(|r| (to[r] - from[r]) as i64);
    if axis == [0; 3] || radius_q16 == 0 {
        return;
    }
    let length_squared: i64 = dot(axis, axis);
    // |p × axis|² · 2³² < radius² · |axis|², as an inclusive bound on |p × axis|².
    let most = ((radius_q16 as i128).pow(2) * length_squared as i128 - 1) >> 32;
    let reach = radius_q16 / ONE_Q16 + 1;
    let rows = [1, 2].map(|r| {
        let (low, high) = (from[r].min(to[r]) as i64, from[r].max(to[r]) as i64);
        low - reach..high + reach + 1
    });
    mark_rows(plane, rows, |y, z| {
        let [start_x, start_y, start_z] = from.map(i64::from);
        // Along the row p = beside + (x, 0, 0), x from the start's.
        let beside = [0, y - start_y, z - start_z];
        let along = dot(beside, axis);
        let between = both(at_least_zero(axis[0], along), at_least_zero(-axis[0], length_squared - along));
        let run = both(between, axis_range(axis, beside, most));
        run.start.saturating_add(start_x)..run.end.saturating_add(start_x)
    });
}

/// The x for which |(beside + (x, 0, 0)) × axis|² ≤ most: a x² + 2 b x + c ≤ most, a square completed.
fn axis_range(axis: [i64; 3], beside: [i64; 3], most: i128) -> Range<i64> {
    let (at_zero, a_step) = (cross(beside, axis), [0, -axis[2], axis[1]]);
    let [a, b, c] = [dot(a_step, a_step), dot(at_zero, a_step), dot(at_zero, at_zero)].map(i128::from);
    let left = most - c;
    if a == 0 {
        return if left >= 0 { i64::MIN..i64::MAX } else { 0..0 };
    }
    let root_squared = b * b + a * left;
    if root_squared < 0 {
        return 0..0;
    }
    let root = root_squared.isqrt();
    ceil_div(-root - b, a) as i64..(root - b).div_euclid(a) as i64 + 1
}

fn dot(p: [i64; 3], q: [i64; 3]) -> i64 {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

fn cross(p: [i64; 3], q: [i64; 3]) -> [i64; 3] {
    std::array::from_fn(|r| {
        let (s, t) = ((r + 1) % 3, (r + 2) % 3);
        p[s] * q[t] - p[t] * q[s]
    })
}
