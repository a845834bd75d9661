//! Warns of switches that the environment alone trips, by which object, where and when, and of those that are always muted.

use std::collections::HashSet;
use std::sync::Arc;

use super::World;
use super::warnings::first_of;
use crate::input::Study;
use crate::sensor::Station;
use crate::world::place::Places;
use perirobot_march::voxel::BitGrid;
use perirobot_scene::truth::Truth;

/// What trips a switch if no object has surface there.
const INSIDE: &str = "the inside of a body";

/// The candidates of a sensor that are always on without anybody there, at some moment of the scene.
pub(super) fn warning(study: &Study, places: &Places, sensor: usize, worlds: &[World]) -> Option<String> {
    let kind = &*study.sensors[sensor].kind;
    let mut stuck = HashSet::new();
    // The first candidate and snapshot, and what trips it.
    let mut earliest = None;
    let mut moments = 0;
    for (snapshot, world) in worlds.iter().enumerate() {
        let truth = world.truth();
        let before = moments;
        for candidate in 0..world.settings[sensor].len() {
            let station = exact_station(world, &truth, [sensor, candidate]);
            let by = kind.stuck_by(&station);
            if by.is_empty() {
                continue;
            }
            moments = before + 1;
            earliest.get_or_insert_with(|| {
                let case = kind.as_scanner().and_then(|scanner| {
                    let case = *scanner.applying_cases(&station).first()?;
                    Some(format!(" in field case {:?}", scanner.cases()[case]))
                });
                (candidate, snapshot, what(&truth, &by), case.unwrap_or_default())
            });
            stuck.insert(candidate);
        }
    }
    let (candidate, snapshot, what, case) = earliest?;
    let first = first_of(study, places, sensor, &[candidate])?;
    let when = match worlds.len() {
        all if moments == all => String::new(),
        all => format!(" in {moments} of {all} snapshots (the first is {snapshot})"),
    };
    Some(format!(
        "sensor {:?}: the environment alone trips {} of {}{when}: occupied is reported then whether or not somebody is there ({first}; \
         {what}{case}): {}",
        study.sensors[sensor].name,
        stuck.len(),
        match study.sensors[sensor].candidates.len() {
            1 => "1 pose".into(),
            all => format!("{all} poses"),
        },
        kind.stuck_advice()
    ))
}

/// That a candidate of a sensor is muted at every moment of the scene.
pub(super) fn muted_warning(
    study: &Study,
    places: &Places,
    sensor: usize,
    worlds: &[World],
) -> Option<String> {
    let is_muted = |world: &World, candidate: usize| {
        study.sensors[sensor].kind.is_muted(&exact_station(world, &world.truth(), [sensor, candidate]))
    };
    let always = |candidate: &usize| worlds.iter().all(|world| is_muted(world, *candidate));
    let candidate = (0..study.sensors[sensor].candidates.len()).find(always)?;
    let first = first_of(study, places, sensor, &[candidate])?;
    Some(format!(
        "sensor {:?}: is muted at every moment of the scene ({first}), so that it detects nothing: correct muted_by or muted_at",
        study.sensors[sensor].name
    ))
}

/// The same of one candidate at one moment: what trips it, if anything does.
pub(super) fn tripped_by(study: &Study, world: &World, [sensor, candidate]: [usize; 2]) -> Option<String> {
    let (truth, by) = tripping_voxels(study, world, [sensor, candidate])?;
    Some(what(&truth, &by))
}

/// The truth of a moment, and the voxels of the environment that trip a candidate of a sensor, if any do.
fn tripping_voxels(
    study: &Study,
    world: &World,
    [sensor, candidate]: [usize; 2],
) -> Option<(Arc<Truth>, BitGrid)> {
    let truth = world.truth();
    let voxels = study.sensors[sensor].kind.stuck_by(&exact_station(world, &truth, [sensor, candidate]));
    (!voxels.is_empty()).then_some((truth, voxels))
}

/// A sensor at a candidate, over the whole grid, where it is believed to be; `truth` is the world's.
pub(super) fn exact_station<'a>(
    world: &World,
    truth: &'a Truth,
    [sensor, candidate]: [usize; 2],
) -> Station<'a> {
    Station {
        moment: [world.scene, world.snapshot],
        truth,
        window: truth.grid.window(),
        setting: world.settings[sensor][candidate],
        rays: None,
        truly: None,
        draws: 0,
    }
}

/// The object with most of some voxels, and the first of its voxels there.
fn what(truth: &Truth, voxels: &BitGrid) -> String {
    let Some((object, at)) = most_shared(truth, voxels) else { return INSIDE.into() };
    let at = truth.grid.corner_m(at) + truth.grid.voxel_size_m / 2.0;
    format!("{object:?} does at x {:.2}, y {:.2}, z {:.2} m", at.x + 0.0, at.y + 0.0, at.z + 0.0)
}

/// The object that alone trips a candidate of a sensor in a world, by its name.
pub fn tripping_object(study: &Study, world: &World, [sensor, candidate]: [usize; 2]) -> Option<String> {
    let (truth, by) = tripping_voxels(study, world, [sensor, candidate])?;
    Some(most_shared(&truth, &by).map_or(INSIDE, |(object, _)| object).into())
}

/// The object that has most of some voxels, and the first of these.
fn most_shared<'t>(truth: &'t Truth, voxels: &BitGrid) -> Option<(&'t str, [i32; 3])> {
    let shared = truth.objects.iter().map(|object| {
        let mut shared = object.voxels.to_window(voxels.window().intersection(&object.voxels.window()));
        shared.keep(voxels);
        (object, shared)
    });
    let most = shared.rev().max_by_key(|(_, shared)| shared.count());
    most.and_then(|(object, shared)| Some((object.name.as_str(), shared.voxels().next()?)))
}
