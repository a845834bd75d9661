//! Text about whether a body keeps the distance that people need by `[stopping]`. Squared distances decide.

use perirobot_march::voxel::{Grid, gap_error_m, rounded_down, rounded_up, squared_voxels};
use perirobot_study::input::{AtSpeed, Stopping};

/// At which speeds of the robot a distance is enough.
pub(super) fn describe(stopping: &Stopping, squared: u32, grid: &Grid) -> String {
    let is_enough = |at: &&AtSpeed| squared_voxels(at.needed_m, grid.voxel_size_m) <= squared;
    let AtSpeed { speed_m_s, needed_m } = *stopping.fastest();
    let margin_m = root_m(squared, grid) - needed_m;
    let needed = rounded_up(needed_m, 2);
    match stopping.speeds.iter().rfind(is_enough) {
        Some(at) if at.speed_m_s == speed_m_s => format!(
            "far enough: {needed} m are needed at {speed_m_s} m/s, the highest listed speed, {} m less{}",
            rounded_down(margin_m, 2),
            describe_thin_margin(at, squared, grid)
        ),
        slower => {
            let slower = slower.map_or("at no listed speed is it far enough".into(), |at| {
                let needed = rounded_up(at.needed_m, 2);
                let thin = describe_thin_margin(at, squared, grid);
                format!("far enough up to {} m/s, where {needed} m are needed{thin}", at.speed_m_s)
            });
            let more = rounded_up(-margin_m, 2);
            format!("too near at {speed_m_s} m/s: {needed} m are needed, {more} m more; {slower}")
        }
    }
}

/// That surfaces may be too near although the distance between voxels is enough.
fn describe_thin_margin(at: &AtSpeed, squared: u32, grid: &Grid) -> String {
    let (margin_m, error_m) = (root_m(squared, grid) - at.needed_m, gap_error_m(grid.voxel_size_m));
    match margin_m < error_m {
        true => format!(
            " (by {} m: not certain, since the gap may be {error_m:.2} m less)",
            rounded_down(margin_m.max(0.0), 2)
        ),
        false => String::new(),
    }
}

/// That an entry begins nearer to the hazard than is needed at the highest listed speed, where no sensor can help, and
/// how far out it has to begin; `entry` is the least squared distance of a body at it. `None` where it begins far enough.
pub(super) fn begins_too_near(stopping: &Stopping, entry: u32, grid: &Grid) -> Option<String> {
    let AtSpeed { speed_m_s, needed_m } = *stopping.fastest();
    let begins_m = root_m(entry, grid);
    (entry < squared_voxels(needed_m, grid.voxel_size_m)).then(|| {
        format!(
            "no sensor can help at {speed_m_s} m/s: the entry begins {} m from the hazard, and has to begin {} m from it \
             or farther, {} m farther out",
            rounded_down(begins_m, 2),
            rounded_up(needed_m, 2),
            rounded_up(needed_m - begins_m, 2)
        )
    })
}

/// That the grid ends before the distance that is needed, if it does; `farthest` is the greatest in the grid.
pub(super) fn describe_grid_end(stopping: &Stopping, farthest: u32, grid: &Grid) -> String {
    let AtSpeed { speed_m_s, needed_m } = *stopping.fastest();
    if squared_voxels(needed_m, grid.voxel_size_m) <= farthest {
        return String::new();
    }
    format!(
        "  {} m are needed at {speed_m_s} m/s, and nothing in the grid is farther away than {} m: a body that is \
         noticed at its entry is noticed too late, and the distances below are bounds (widen bounds_m)\n",
        rounded_up(needed_m, 2),
        rounded_down(root_m(farthest, grid), 2)
    )
}

/// A distance from its square in voxels.
pub(super) fn root_m(squared: u32, grid: &Grid) -> f64 {
    f64::from(squared).sqrt() * grid.voxel_size_m
}
