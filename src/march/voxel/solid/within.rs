//! What lies near a solid: the voxels at most a Euclidean distance from its own, whole rows at a time.

use super::super::{BitGrid, Window};
use super::MAX_RADIUS_Q16;

/// The voxels of `window` whose centre is at most a distance from a centre of `solid`, its own included:
/// d² · 2³² ≤ distance². A distance beyond [`MAX_RADIUS_Q16`] counts as that, below 0 as 0.
pub fn dilate(solid: &BitGrid, distance_q16: i64, window: Window) -> BitGrid {
    let bounds = solid.bounds();
    if bounds.is_empty() || window.is_empty() {
        return BitGrid::new(window);
    }
    // All of the solid is kept along x: what is outside the window may be near enough.
    let from = bounds.min[0].min(window.min[0]);
    let length = (bounds.end()[0].max(window.end()[0]) - from) as u32;
    let lengthened =
        |w: Window| Window { min: [from, w.min[1], w.min[2]], size: [length, w.size[1], w.size[2]] };
    let mut near = BitGrid::new(lengthened(window));
    let mut spread = solid.to_window(lengthened(bounds));
    let rows = filled_rows(&spread);
    for (reach, offsets) in offsets_by_reach(distance_q16, &bounds, &window).iter().enumerate() {
        if reach > 0 {
            spread.spread_x();
        }
        for [dy, dz] in offsets {
            rows.iter().for_each(|[y, z]| near.add_row(y + dy, z + dz, spread.row(*y, *z)));
        }
    }
    near.to_window(window)
}

/// How far a row of voxels reaches along x in other rows: entry r lists the offsets y, z at which voxels up
/// to r along x are within the distance and no farther ones. Offsets that lead from no row of `bounds` into
/// `window` are left out.
fn offsets_by_reach(distance_q16: i64, bounds: &Window, window: &Window) -> Vec<Vec<[i32; 2]>> {
    let distance_q16 = distance_q16.clamp(0, MAX_RADIUS_Q16);
    let most = (distance_q16.pow(2) >> 32) as i32;
    let farthest = most.isqrt();
    let offsets = |r: usize| {
        let (back, forth) = (window.min[r] - (bounds.end()[r] - 1), window.end()[r] - 1 - bounds.min[r]);
        back.max(-farthest)..=forth.min(farthest)
    };
    let mut by_reach = vec![Vec::new(); farthest as usize + 1];
    for dz in offsets(2) {
        for dy in offsets(1) {
            let left = most - dy * dy - dz * dz;
            if left >= 0 {
                by_reach[left.isqrt() as usize].push([dy, dz]);
            }
        }
    }
    by_reach
}

/// The rows y, z that have a voxel.
fn filled_rows(plane: &BitGrid) -> Vec<[i32; 2]> {
    let (min, end) = (plane.window().min, plane.window().end());
    let all = (min[2]..end[2]).flat_map(|z| (min[1]..end[1]).map(move |y| [y, z]));
    all.filter(|&[y, z]| plane.row(y, z).iter().any(|&word| word != 0)).collect()
}
