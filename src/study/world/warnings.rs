//! What was assumed about a scene that the user may not expect, each thing once however many snapshots have
//! it.

use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;

use super::place::{Places, is_room, room_m};
use super::sizes::{Lengths, Surfaces, guess_unit};
use super::{World, carried, cut_warnings, dead, floor, people, robots, specular, stuck, thin};
use crate::diagnostics::FAR_M;
use crate::input::Study;
use crate::sensor::{Kind, Sensor, Setting, Stance};
use perirobot_march::voxel::Grid;
use perirobot_scene::objects::{Interior, Role, Scene};
use perirobot_scene::truth::{ObjectVoxels, Truth};

/// The warnings of a scene.
pub(super) struct SceneWarnings {
    pub(super) lines: Vec<String>,
    /// Whether a hull fills most of the grid by its interior, which explains whatever else is odd.
    pub(super) is_filled: bool,
}

/// The warnings of a scene from all its snapshots, which have the same objects in the same order. What explains others
/// comes before them, or instead of them.
pub(super) fn warnings(study: &Study, scenes: &[Scene], worlds: &[World]) -> SceneWarnings {
    let scene = &study.scenes[worlds[0].scene];
    let of_file = |path: &Path, said: &[String]| {
        said.iter().map(|what| format!("{}: {what}", path.display())).collect::<Vec<_>>()
    };
    let mut warnings = of_file(&study.path, &study.warnings);
    warnings.extend(of_file(&scene.path, &scene.warnings));
    let first = worlds[0].truth();
    let glances: Vec<Glance> = worlds.par_iter().map(|world| Glance::new(study, world)).collect();
    if let Some(hull) = hull_warning(&scenes[0], &first, &glances) {
        warnings.insert(0, hull);
        return SceneWarnings { lines: warnings, is_filled: true };
    }
    let ignored: Vec<f64> = glances.iter().map(|glance| glance.ignored_share).collect();
    let (at, when) = largest(&ignored);
    if ignored[at] > MOST {
        let percent = 100.0 * ignored[at];
        warnings.push(format!(
            "{percent:.0} % of the grid is inside bodies whose interior is ignored{when}: a hull that is the room itself \
             needs interior = \"free\""
        ));
    }
    let (lengths, surfaces) = (Lengths::new(&first.objects), Surfaces::new(scene));
    for (index, object) in first.objects.iter().enumerate() {
        object_warnings(&glances, &object.name, index, &mut warnings);
        warnings.extend(lengths.warning(object, index, study.voxel_size_m, &surfaces));
    }
    if !first.objects.iter().any(|o| o.role == Role::Human) {
        warnings.push(
            "no object has role = \"human\": human_seen, human_claimed, people_detected and parts_detected have no value"
                .into(),
        );
    }
    let regions: Vec<usize> = (0..study.regions.len()).collect();
    warnings.extend(cut_warnings(study, worlds, &regions));
    warnings.extend(floor::warning(study, &scenes[0]));
    let places = Places::new(study, &worlds[0]);
    let outside = poses_outside(study, &first, &worlds[0]);
    let across_m = worlds[0].across_m();
    let of_sensor = |(sensor, outside): (usize, &Vec<(usize, Option<String>)>)| {
        let spec = &study.sensors[sensor];
        let all = spec.warnings.iter().map(|what| format!("sensor {:?}: {what}", spec.name));
        let all =
            all.chain(once_warning(study, sensor)).chain(range_warning(&spec.name, &*spec.kind, across_m));
        let all = all.chain(stuck::warning(study, &places, sensor, worlds));
        let all = all.chain(stuck::muted_warning(study, &places, sensor, worlds));
        all.chain(warn_outside(study, &places, sensor, outside)).collect::<Vec<_>>()
    };
    let explained = |sensor: usize, candidate: usize| {
        begins_beyond(&*study.sensors[sensor].kind, across_m)
            || outside[sensor].binary_search_by_key(&candidate, |(candidate, _)| *candidate).is_ok()
    };
    let of_sensors = || outside.par_iter().enumerate().map(of_sensor).collect::<Vec<_>>();
    let of_bodies = || (people::warnings(study, scenes, worlds), thin::warnings(study, scenes, worlds));
    let dead = || dead::warnings(study, worlds, &explained);
    let (dead, (of_sensors, (of_people, thin))) = rayon::join(dead, || rayon::join(of_sensors, of_bodies));
    warnings.extend(of_sensors.into_iter().flatten());
    warnings
        .extend((0..study.sensors.len()).filter_map(|sensor| warn_inside(study, &places, sensor, &glances)));
    warnings.extend(specular::warnings(study, &worlds[0]));
    warnings.extend(robots::warnings(&scenes[0], &worlds[0]));
    warnings.extend(robots::planes_before_robots(study, &worlds[0]));
    warnings.extend(carried::warnings(study, scenes, worlds));
    warnings.extend(of_people.into_iter().chain(thin).chain(dead));
    SceneWarnings { lines: warnings, is_filled: false }
}

/// A larger share of the grid is most of it.
const MOST: f64 = 0.5;

/// An object around the whole cell that fills it by its interior, or leaves it out.
fn hull_warning(scene: &Scene, first: &Truth, glances: &[Glance]) -> Option<String> {
    let room_m = room_m(first);
    let share_of = |index: usize| {
        let (object, share) = match scene.objects[index].interior {
            Interior::Free => return None,
            Interior::Occupied => {
                let counts = glances.iter().map(|glance| glance.objects[index].voxels.count());
                let volume = first.grid.window().volume() as f64;
                (&first.objects[index], counts.max()? as f64 / volume)
            }
            Interior::Ignored => {
                let shares = glances.iter().map(|glance| glance.ignored_share);
                (&first.objects[index], shares.fold(0.0, f64::max))
            }
        };
        (share > MOST && is_room(object, room_m)).then_some((index, share))
    };
    let (index, share) = (0..scene.objects.len()).find_map(share_of)?;
    let (name, percent) = (&scene.objects[index].name, 100.0 * share);
    Some(match scene.objects[index].interior {
        Interior::Occupied => format!(
            "object {name:?} fills {percent:.0} % of the grid by interior = \"occupied\": a hull that is the room itself \
             needs interior = \"free\""
        ),
        _ => format!(
            "object {name:?} is around {percent:.0} % of the grid, whose interior is ignored: a hull that is the room itself \
             needs interior = \"free\""
        ),
    })
}

/// What the warnings need of each snapshot.
struct Glance {
    objects: Vec<Arc<ObjectVoxels>>,
    /// How much of the grid is inside bodies whose interior is ignored.
    ignored_share: f64,
    /// For each sensor, the candidates that stand in a blocker. Pads lie in the floor and gates may stand in
    /// anything; only sensors that cast rays count.
    inside: Vec<Vec<usize>>,
}

impl Glance {
    fn new(study: &Study, world: &World) -> Glance {
        let truth = world.truth();
        let stands = |kind: &dyn Kind, setting: &Setting| match setting {
            Setting::Pose(pose) => {
                kind.blockers(&truth).get(Grid::voxel_of(world.grid.position_q16(pose.position_m)))
            }
            _ => false,
        };
        let inside = study.sensors.iter().enumerate().map(|(number, sensor)| {
            let looks = sensor.kind.stance() != Stance::Level;
            candidates(world, number, |setting| looks && stands(&*sensor.kind, setting))
        });
        Glance {
            objects: truth.objects.clone(),
            ignored_share: truth.ignored.count() as f64 / world.grid.window().volume() as f64,
            inside: inside.collect(),
        }
    }
}

/// What is odd about one object, in the first snapshot where something is, and where the object is left out.
fn object_warnings(glances: &[Glance], name: &str, index: usize, warnings: &mut Vec<String>) {
    let all = || glances.iter().map(|glance| &glance.objects[index]);
    if let Some(odd) = all().find(|object| !object.warnings.is_empty()) {
        warnings.extend(odd.warnings.iter().map(|w| format!("object {name:?} {w}")));
    }
    let outside = all().filter(|object| object.voxels.is_empty()).count();
    if outside == glances.len() {
        warnings.push(format!("object {name:?} lies outside the grid and is left out"));
    } else if outside > 0 {
        warnings.push(format!(
            "object {name:?} lies outside the grid in {outside} of {} snapshots and is left out there",
            glances.len()
        ));
    }
}

/// The first snapshot where a value is largest, and words that name it; no words where all snapshots are
/// alike.
pub(super) fn largest(values: &[f64]) -> (usize, String) {
    let larger = |at: usize, i: usize| if values[i] > values[at] { i } else { at };
    let at = (0..values.len()).fold(0, larger);
    let alike = values.iter().all(|&value| value == values[at]);
    (at, if alike { String::new() } else { format!(" (in snapshot {at}, where it is most)") })
}

/// A mount that is drawn once only.
fn once_warning(study: &Study, sensor: usize) -> Option<String> {
    let Sensor { name, kind, .. } = &study.sensors[sensor];
    (kind.calibration().is_some() && study.repeats == 1).then(|| {
        format!(
            "sensor {name:?}: of its calibration one mount is drawn for each pose, and another would score otherwise: write \
             repeats = 10 at the top of the study, and look at the worst and at the spread"
        )
    })
}

/// Whether a sensor measures from a distance on that is most of the cell, which no sensor does.
fn begins_beyond(kind: &dyn Kind, across_m: f64) -> bool {
    kind.range().is_some_and(|range| range.range_m[0] > across_m / 2.0)
}

/// A range in centimetres; a longer one is told of where it is written.
fn range_warning(name: &str, kind: &dyn Kind, across_m: f64) -> Option<String> {
    let [nearest, farthest] = kind.range()?.range_m;
    let metres = |cm: f64| (cm * 1e4).round() / 1e6;
    (begins_beyond(kind, across_m) && farthest < FAR_M).then(|| {
        format!(
            "sensor {name:?}: range_m = [{nearest}, {farthest}] begins {nearest} m from it, and the cell is {across_m:.1} m across: \
             is it in centimetres? Then write [{}, {}]",
            metres(nearest),
            metres(farthest)
        )
    })
}

/// The first of some candidates of a sensor, by name and place.
pub(super) fn first_of(
    study: &Study,
    places: &Places,
    sensor: usize,
    candidates: &[usize],
) -> Option<String> {
    let first = *candidates.first()?;
    let (name, place) = (&study.sensors[sensor].candidates[first].name, places.words(sensor, first));
    Some(if place.is_empty() { format!("first {name}") } else { format!("first {name}: {place}") })
}

/// The candidates of a sensor whose setting in a world is so.
fn candidates(world: &World, sensor: usize, is_so: impl Fn(&Setting) -> bool) -> Vec<usize> {
    let settings = &world.settings[sensor];
    (0..settings.len()).filter(|&candidate| is_so(&settings[candidate])).collect()
}

/// Of each sensor the poses outside everything that is modelled, in the first snapshot; with what the unit of their
/// coordinates looks like, if another one would put them inside.
fn poses_outside(study: &Study, truth: &Truth, world: &World) -> Vec<Vec<(usize, Option<String>)>> {
    let all = truth.objects.iter().map(|object| object.bounds_m);
    let Some([low, high]) = all.reduce(|[low, high], [l, h]| [low.min(l), high.max(h)]) else {
        return vec![Vec::new(); study.sensors.len()];
    };
    let is_outside = |setting: &Setting| match setting {
        Setting::Pose(pose) => !(pose.position_m.cmpge(low) & pose.position_m.cmple(high)).all(),
        _ => false,
    };
    let unit = |sensor: usize, candidate: usize| {
        let position_m = world.settings[sensor][candidate].pose().position_m;
        (candidate, guess_unit(position_m, [low, high]))
    };
    let of_sensor = |sensor: usize| {
        let outside = candidates(world, sensor, is_outside).into_iter();
        outside.map(|candidate| unit(sensor, candidate)).collect()
    };
    (0..study.sensors.len()).map(of_sensor).collect()
}

/// How many poses are outside, those in another unit apart.
fn warn_outside(
    study: &Study,
    places: &Places,
    sensor: usize,
    outside: &[(usize, Option<String>)],
) -> impl Iterator<Item = String> {
    let (in_unit, others): (Vec<_>, Vec<_>) = outside.iter().partition(|(_, unit)| unit.is_some());
    let candidates = |some: &[&(usize, Option<String>)]| some.iter().map(|(c, _)| *c).collect::<Vec<_>>();
    let line = |some: &[&(usize, Option<String>)], question: String| {
        let first = first_of(study, places, sensor, &candidates(some))?;
        Some(format!(
            "sensor {:?}: {} poses ({first}) are outside all surfaces of the scene: {question}",
            study.sensors[sensor].name,
            some.len()
        ))
    };
    let unit = in_unit.first().and_then(|(_, unit)| unit.clone()).unwrap_or_default();
    [line(&in_unit, format!("its position {unit}")), line(&others, "is that where they should be?".into())]
        .into_iter()
        .flatten()
}

/// How many poses stand in a blocker, in the snapshot where most do.
fn warn_inside(study: &Study, places: &Places, sensor: usize, glances: &[Glance]) -> Option<String> {
    let counts: Vec<f64> = glances.iter().map(|glance| glance.inside[sensor].len() as f64).collect();
    let (at, when) = largest(&counts);
    let inside = &glances[at].inside[sensor];
    let first = first_of(study, places, sensor, inside)?;
    Some(format!(
        "sensor {:?}: {} poses ({first}) stand in an occupied voxel (move them out of it): their rays start behind its \
         surface{when}",
        study.sensors[sensor].name,
        inside.len()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_snapshot_is_named_unless_all_are_alike() {
        assert_eq!(largest(&[0.3]), (0, String::new()));
        assert_eq!(largest(&[0.3, 0.3]), (0, String::new()));
        assert_eq!(largest(&[0.0, 0.2, 0.1, 0.2]), (1, " (in snapshot 1, where it is most)".into()));
    }
}
