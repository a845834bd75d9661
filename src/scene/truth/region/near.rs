//! The voxels around a robot: all that is nearer to one of its voxels than a distance.

use perirobot_march::error::Issue;
use perirobot_march::voxel::distance::{Distances, squared_voxels};
use perirobot_march::voxel::grid::MAX_VOXELS_PER_AXIS;
use perirobot_march::voxel::{BitGrid, Grid};

/// Most voxels among which distances are measured at once; each takes eight bytes.
const MOST_VOXELS: u64 = 1 << 28;

/// The voxels nearer to a set than a distance, also those outside the grid; without a distance the set itself. A
/// voxel exactly at the distance is far enough, as in every verdict on a distance.
pub(super) fn expand(set: &BitGrid, distance_m: f64, grid: &Grid) -> Result<BitGrid, Issue> {
    let squared = squared_voxels(distance_m, grid.voxel_size_m);
    let bounds = set.bounds();
    if bounds.is_empty() {
        return Err(Issue::says("no object of the scene is a robot in the grid")
            .with_advice("give an object role = \"robot\""));
    }
    // Each axis is at most as long as no product of two lengths overflows on.
    let radius = squared.isqrt() as i32;
    let is_large = || bounds.grown(radius).volume() > MOST_VOXELS;
    if radius > 4 * MAX_VOXELS_PER_AXIS as i32 || is_large() {
        let what = format!("{distance_m:.3} m around the robot are more than {MOST_VOXELS} voxels");
        return Err(
            Issue::too_large(what).with_advice("take larger voxels, or check the times of [stopping]")
        );
    }
    Ok(Distances::from_set(&set.to_window(bounds.grown(radius))).voxels_within(squared.saturating_sub(1)))
}
