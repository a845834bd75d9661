//! The grid of a scene: the user's bounds, or all surfaces of all snapshots and sensor positions.

use std::sync::Arc;

use glam::DVec3;

use super::{sizes, true_poses};
use crate::input::Study;
use crate::sensor::{Setting, Stance};
use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_march::voxel::{Grid, Window};
use perirobot_scene::objects::Scene;
use perirobot_scene::truth::voxelize;

/// The grid of a scene: the user's bounds, or all surfaces of all snapshots and sensor positions.
pub(super) fn grid(
    study: &Study,
    snapshots: &[Scene],
    settings: &[Vec<Arc<Vec<Setting>>>],
    surfaces: &Window,
) -> Result<Grid> {
    let size_m = study.voxel_size_m;
    let at_world = Grid { voxel_size_m: size_m, origin: [0; 3], size: [1; 3] };
    let key = |p: DVec3| Grid::voxel_of(at_world.position_q16(p));
    let one = |p: DVec3| Window::from_corners(key(p), key(p));
    let Some([min, max]) = study.bounds_m else {
        voxelize::grid_over_all(surfaces, size_m, snapshots)?;
        return voxelize::grid_over(&stretched(study, settings, surfaces), size_m).map_err(|e| {
            let (mut extent, mut last) = (*surfaces, DVec3::ZERO);
            let stretches = |p: DVec3| {
                (extent, last) = (extent.union(&one(p)), p);
                voxelize::grid_over(&extent, size_m).is_err()
            };
            let Some(pose) = first_pose(study, settings, stretches) else { return e };
            let e = e.with_place(format!("{pose} stretches the grid"));
            let cell = [at_world.corner_m(surfaces.min), at_world.corner_m(surfaces.end())];
            match sizes::guess_unit(last, cell) {
                Some(cause) => e.cure(format!("it {cause}")),
                None => e,
            }
        });
    };
    let bounds = Window::from_corners(key(min), key(max));
    match first_pose(study, settings, |p| !bounds.contains(key(p))) {
        None => voxelize::grid_over(&bounds, size_m),
        Some(pose) => Err(Issue::says(format!("{pose} is outside grid.bounds_m {min} to {max}"))
            .with_advice("move it, or widen the bounds")
            .into()),
    }
}

/// The grid of a scene of which all surfaces are known; `None` where it cannot be.
pub(super) fn grid_of(study: &Study, settings: &[Vec<Arc<Vec<Setting>>>], surfaces: &Window) -> Option<Grid> {
    let at_world = Grid { voxel_size_m: study.voxel_size_m, origin: [0; 3], size: [1; 3] };
    let key = |p: DVec3| Grid::voxel_of(at_world.position_q16(p));
    let window = match study.bounds_m {
        None => stretched(study, settings, surfaces),
        Some([min, max]) => {
            let bounds = Window::from_corners(key(min), key(max));
            if first_pose(study, settings, |p| !bounds.contains(key(p))).is_some() {
                return None;
            }
            bounds
        }
    };
    voxelize::grid_over(&window, study.voxel_size_m).ok()
}

/// All surfaces, and all positions of sensors.
fn stretched(study: &Study, settings: &[Vec<Arc<Vec<Setting>>>], surfaces: &Window) -> Window {
    let at_world = Grid { voxel_size_m: study.voxel_size_m, origin: [0; 3], size: [1; 3] };
    let key = |p: DVec3| Grid::voxel_of(at_world.position_q16(p));
    let each = settings.iter().flat_map(|snapshot| snapshot.iter().enumerate());
    let all = each.flat_map(|(sensor, all)| {
        let candidates = all.iter().enumerate();
        candidates.flat_map(move |(candidate, setting)| positions(study, [sensor, candidate], setting))
    });
    all.fold(*surfaces, |all, p| all.union(&Window::from_corners(key(p), key(p))))
}

/// Where a setting puts a sensor that looks out from there: where it is believed to be, and where it truly is
/// in each repeat if its mount may be off. Pads and gates are checked against the grid, and do not stretch
/// it.
fn positions<'a>(
    study: &'a Study,
    [sensor, candidate]: [usize; 2],
    setting: &Setting,
) -> impl Iterator<Item = DVec3> + use<'a> {
    let kind = &study.sensors[sensor].kind;
    let believed = match setting {
        Setting::Pose(pose) if kind.stance() != Stance::Level => Some(*pose),
        _ => None,
    };
    let truly = believed
        .into_iter()
        .flat_map(move |pose| true_poses(study, Setting::Pose(pose), [sensor, candidate]));
    believed.into_iter().chain(truly).map(|pose| pose.position_m)
}

/// The first pose of the study, in any snapshot, whose position is so, in words.
fn first_pose(
    study: &Study,
    settings: &[Vec<Arc<Vec<Setting>>>],
    mut is_so: impl FnMut(DVec3) -> bool,
) -> Option<String> {
    let each = settings.iter().flat_map(|snapshot| snapshot.iter().enumerate());
    let mut poses = each.flat_map(|(s, all)| {
        let candidates = all.iter().enumerate();
        candidates.flat_map(move |(c, setting)| {
            positions(study, [s, c], setting).map(move |at| (s, c, setting, at))
        })
    });
    let (s, c, setting, at) = poses.find(|(.., at)| is_so(*at))?;
    let (sensor, believed) = (&study.sensors[s], setting.pose().position_m);
    let off = if at == believed {
        String::new()
    } else {
        format!(" (where its calibration puts it, which is believed at {believed})")
    };
    Some(format!("sensor {:?}: pose {} at {at}{off}", sensor.name, sensor.candidates[c].name))
}
