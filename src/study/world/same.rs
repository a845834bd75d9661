//! The worlds of a study that was changed, where their voxels are as before: most edits of a plan move sensors only.

use std::sync::Arc;

use super::{World, extent};
use crate::input::Study;
use crate::sensor::{MountLink, Sensor};
use perirobot_scene::pose::Pose;

/// All that the voxels of a study's worlds are made of, as text, but for the grid that its sensors stretch. A mesh that
/// changes on disk is not noticed; a scene file is.
pub fn worlds_key(study: &Study) -> String {
    let files = study.sources.read_files().into_iter();
    let scene_files = files.filter(|file| study.scenes.iter().any(|scene| scene.path == file.path));
    let hashes: Vec<String> =
        scene_files.filter(|file| file.path != study.path).map(|file| file.sha256).collect();
    let Study { scenes, regions, bounds_m, voxel_size_m, min_hits, approach, .. } = study;
    let floor_m = approach.floor_m;
    format!("{:?}", (scenes, regions, bounds_m, voxel_size_m, min_hits, floor_m, hashes))
}

/// The worlds of a study from those of another with the same [`worlds_key`]: the same voxels, with the sensors of this one.
/// What is said of poses stays as it was: warnings, baselines and the entries of the manifest. `None` where they must be
/// prepared anew, since a sensor stretches the grid, leaves it, or is carried by a link that carried none.
pub fn with_sensors_of(worlds: &[World], before: &Study, now: &Study) -> Option<Vec<World>> {
    let each = worlds.iter().map(|world| {
        let carriers = now.sensors.iter().map(|sensor| carrier(world, before, sensor));
        let carriers: Vec<Option<Pose>> = carriers.collect::<Option<_>>()?;
        Some(World { carriers, ..world.clone() }.with_sensors(&now.sensors))
    });
    let all: Vec<World> = each.collect::<Option<_>>()?;
    let is_as_before = |scene: &[World]| {
        let settings: Vec<_> = scene.iter().map(|world| world.settings.clone()).collect();
        extent::grid_of(now, &settings, &scene[0].surfaces) == Some(scene[0].grid)
    };
    all.chunk_by(|one, next| one.scene == next.scene).all(is_as_before).then_some(all)
}

/// Where the link is that carries a sensor, if one does; `None` where that is not known.
fn carrier(world: &World, before: &Study, sensor: &Sensor) -> Option<Option<Pose>> {
    let Some(MountLink { object, link }) = &sensor.on else { return Some(None) };
    let same = |known: &Sensor| known.on.as_ref().is_some_and(|on| on.object == *object && on.link == *link);
    let known = before.sensors.iter().position(same)?;
    Some(world.carriers[known])
}

/// Gives sensors that are as before the very kinds of before, and the tables of rays with them, which then need not be
/// made again. Kinds are compared by all that they hold, written out.
pub fn share_kinds(before: &Study, now: &mut Study) {
    now.kept_rays = before.kept_rays.clone();
    let known: Vec<(String, &Arc<_>)> =
        before.sensors.iter().map(|sensor| (format!("{:?}", sensor.kind), &sensor.kind)).collect();
    for sensor in &mut now.sensors {
        let own = format!("{:?}", sensor.kind);
        if let Some((_, kind)) = known.iter().find(|(text, _)| *text == own) {
            sensor.kind = Arc::clone(kind);
        }
    }
}
