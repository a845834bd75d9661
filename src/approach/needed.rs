//! Whether a body stays away as far as people must be by `[stopping]`, in words. Squared distances decide.

use super::table::root_m;
use crate::study::{AtSpeed, Stopping};
use crate::voxel::{Grid, squared_voxels};

/// At which speeds of the robot a distance is enough.
pub(super) fn in_words(stopping: &Stopping, squared: u32, grid: &Grid) -> String {
    let is_enough = |at: &&AtSpeed| squared_voxels(at.needed_m, grid.voxel_size_m) <= squared;
    let AtSpeed { speed_m_s, needed_m } = *stopping.fastest();
    let off = (root_m(squared, grid) - needed_m).abs();
    match stopping.speeds.iter().rfind(is_enough) {
        Some(at) if at.speed_m_s == speed_m_s => format!(
            "far enough: {needed_m:.2} m are needed at {speed_m_s} m/s, the highest listed speed, {off:.2} m less"
        ),
        slower => {
            let slower = slower.map_or("at no listed speed is it far enough".into(), |at| {
                format!("far enough up to {} m/s, where {:.2} m are needed", at.speed_m_s, at.needed_m)
            });
            format!("too near at {speed_m_s} m/s: {needed_m:.2} m are needed, {off:.2} m more; {slower}")
        }
    }
}

/// That the grid ends before the distance that is needed, if it does; `farthest` is the greatest in the grid.
pub(super) fn beyond_the_grid(stopping: &Stopping, farthest: u32, grid: &Grid) -> String {
    let AtSpeed { speed_m_s, needed_m } = *stopping.fastest();
    if squared_voxels(needed_m, grid.voxel_size_m) <= farthest {
        return String::new();
    }
    format!(
        "  {needed_m:.2} m are needed at {speed_m_s} m/s, and nothing in the grid is farther away than {:.2} m: who is \
         noticed where they come in is noticed too late, and what is said here is a bound (widen bounds_m)\n",
        root_m(farthest, grid)
    )
}
