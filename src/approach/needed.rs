//! Whether a body stays away as far as people must be by `[stopping]`, in words. Squared distances decide.

use super::table::root_m;
use crate::study::{AtSpeed, Stopping};
use crate::voxel::{Grid, rounded_down, rounded_up, squared_voxels};

/// At which speeds of the robot a distance is enough.
pub(super) fn in_words(stopping: &Stopping, squared: u32, grid: &Grid) -> String {
    let is_enough = |at: &&AtSpeed| squared_voxels(at.needed_m, grid.voxel_size_m) <= squared;
    let AtSpeed { speed_m_s, needed_m } = *stopping.fastest();
    let margin_m = root_m(squared, grid) - needed_m;
    let needed = rounded_up(needed_m, 2);
    match stopping.speeds.iter().rfind(is_enough) {
        Some(at) if at.speed_m_s == speed_m_s => format!(
            "far enough: {needed} m are needed at {speed_m_s} m/s, the highest listed speed, {} m less",
            rounded_down(margin_m, 2)
        ),
        slower => {
            let slower = slower.map_or("at no listed speed is it far enough".into(), |at| {
                let needed = rounded_up(at.needed_m, 2);
                format!("far enough up to {} m/s, where {needed} m are needed", at.speed_m_s)
            });
            let more = rounded_up(-margin_m, 2);
            format!("too near at {speed_m_s} m/s: {needed} m are needed, {more} m more; {slower}")
        }
    }
}

/// How far from the hazard a body is noticed at its entry, and whether that is nearer than is needed at the highest
/// listed speed.
pub(super) fn noticed_in_words(stopping: Option<&Stopping>, squared: u32, grid: &Grid) -> String {
    let away = rounded_down(root_m(squared, grid), 2);
    let needed = stopping.map(|stopping| stopping.fastest().needed_m);
    match needed.filter(|&needed_m| squared < squared_voxels(needed_m, grid.voxel_size_m)) {
        Some(needed_m) => {
            let needed = rounded_up(needed_m, 2);
            format!("{away} m from the hazard: nearer than the {needed} m that are needed")
        }
        None => format!("{away} m from the hazard"),
    }
}

/// That the grid ends before the distance that is needed, if it does; `farthest` is the greatest in the grid.
pub(super) fn beyond_the_grid(stopping: &Stopping, farthest: u32, grid: &Grid) -> String {
    let AtSpeed { speed_m_s, needed_m } = *stopping.fastest();
    if squared_voxels(needed_m, grid.voxel_size_m) <= farthest {
        return String::new();
    }
    format!(
        "  {} m are needed at {speed_m_s} m/s, and nothing in the grid is farther away than {} m: who is \
         noticed where they come in is noticed too late, and what is said here is a bound (widen bounds_m)\n",
        rounded_up(needed_m, 2),
        rounded_down(root_m(farthest, grid), 2)
    )
}
