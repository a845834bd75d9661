//! What was assumed about a scene that the user may not expect, each thing once however many snapshots have
//! it.

use std::path::Path;
use std::sync::Arc;

use super::{World, dead, floor, people, robots, stuck, thin};
use crate::scene::{Object, Role, Scene};
use crate::sensor::{Sensor, Setting, Stance};
use crate::study::{RegionSpec, Study};
use crate::truth::voxelize::{HUGE_M, LARGE_M};
use crate::truth::{ObjectVoxels, RegionShape, Truth};
use crate::voxel::Grid;
use crate::world::place::Places;

/// The warnings of a scene from all its snapshots, which have the same objects in the same order.
pub(super) fn warnings(study: &Study, scenes: &[Scene], worlds: &[World]) -> Vec<String> {
    let scene = &study.scenes[worlds[0].scene];
    let of_file = |path: &Path, said: &[String]| {
        said.iter().map(|what| format!("{}: {what}", path.display())).collect::<Vec<_>>()
    };
    let mut warnings = of_file(&study.path, &study.warnings);
    warnings.extend(of_file(&scene.path, &scene.warnings));
    let first = worlds[0].truth();
    let glances: Vec<Glance> = worlds.iter().map(|world| Glance::of(study, world)).collect();
    for (index, object) in first.objects.iter().enumerate() {
        object_warnings(&glances, &object.name, index, &mut warnings);
        warnings.extend(size_warning(
            study,
            &scenes[0].objects[index],
            worlds[0].scene,
            &first.objects,
            index,
        ));
    }
    if !first.objects.iter().any(|o| o.role == Role::Human) {
        warnings.push(
            "no object has role = \"human\": human_seen, human_claimed, people_detected and parts_detected have no value"
                .into(),
        );
    }
    warnings.extend((0..study.regions.len()).filter_map(|region| cut_warning(study, worlds, region)));
    let ignored: Vec<f64> = glances.iter().map(|glance| glance.ignored_share).collect();
    let (at, when) = largest(&ignored);
    if ignored[at] > 0.5 {
        let percent = 100.0 * ignored[at];
        warnings.push(format!(
            "{percent:.0} % of the grid is inside bodies whose interior is ignored{when}: a hull that is the room itself \
             needs interior = \"free\""
        ));
    }
    warnings.extend(floor::warning(study, &scenes[0]));
    let places = Places::of(study, &worlds[0]);
    for sensor in 0..study.sensors.len() {
        let spec = &study.sensors[sensor];
        warnings.extend(spec.warnings.iter().map(|what| format!("sensor {:?}: {what}", spec.name)));
        warnings.extend(once_warning(study, sensor));
        warnings.extend(stuck::warning(study, &places, sensor, worlds));
        warnings.extend(outside_warning(study, &places, sensor, &first, &worlds[0]));
    }
    warnings.extend(
        (0..study.sensors.len()).filter_map(|sensor| inside_warning(study, &places, sensor, &glances)),
    );
    warnings.extend(robots::warnings(&scenes[0], &worlds[0]));
    warnings.extend(people::warnings(scenes, worlds));
    warnings.extend(thin::warnings(study, scenes, worlds));
    warnings.extend(dead::warnings(study, worlds));
    warnings
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
    fn of(study: &Study, world: &World) -> Glance {
        let truth = world.truth();
        let stands = |setting: &Setting| match setting {
            Setting::Pose(pose) => {
                truth.blockers.get(Grid::voxel_of(world.grid.position_q16(pose.position_m)))
            }
            _ => false,
        };
        let inside = study.sensors.iter().enumerate().map(|(number, sensor)| {
            let looks = sensor.kind.stance() != Stance::Level;
            candidates(world, number, |setting| looks && stands(setting))
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

/// A wrong unit makes an object smaller than a voxel, or a mesh much larger than all others.
fn size_warning(
    study: &Study,
    object: &Object,
    scene: usize,
    objects: &[Arc<ObjectVoxels>],
    index: usize,
) -> Option<String> {
    let length_m = |object: &ObjectVoxels| (object.bounds_m[1] - object.bounds_m[0]).max_element();
    let (name, own_m) = (&objects[index].name, length_m(&objects[index]));
    let is_map = objects[index].watertight.is_none();
    if !is_map && own_m < study.voxel_size_m {
        let mm = own_m * 1e3;
        return Some(format!(
            "object {name:?} is {mm:.1} mm long, less than a voxel: is its unit right? Lengths in a scene are metres"
        ));
    }
    let others = objects.iter().enumerate().filter(|(other, _)| *other != index);
    let longest_m = others.map(|(_, object)| length_m(object)).reduce(f64::max)?;
    // Longer objects are told of when they are voxelized.
    let is_odd = own_m > LARGE_M && own_m <= HUGE_M && own_m >= 5.0 * longest_m;
    (is_odd && thin::is_of_a_file(study, scene, object)).then(|| {
        format!(
            "object {name:?} is {own_m:.1} m long, and no other is longer than {longest_m:.1} m: is its file in \
             millimetres? (unit = \"mm\")"
        )
    })
}

/// How much of a region the grid cuts off, where, and what to do if that matters; in the snapshot where it is
/// most.
pub fn cut_warning(study: &Study, worlds: &[World], region: usize) -> Option<String> {
    let cut: Vec<f64> = worlds.iter().map(|world| world.regions[region].cut_share).collect();
    let (at, when) = largest(&cut);
    let (name, spec) = &study.regions[region];
    let sides = sides(worlds[at].regions[region].cut_at);
    let smaller = match spec {
        RegionSpec::RegionShape(RegionShape::HumanBox { .. }) => "take a smaller margin_m",
        RegionSpec::Separation { .. } => "take what is said of it as a bound",
        _ => "make the region smaller there",
    };
    let bounds = if study.bounds_m.is_some() { "widen bounds_m of [grid]" } else { "set bounds_m of [grid]" };
    let percent = 100.0 * cut[at];
    (percent > 0.0).then(|| {
        format!(
            "region {name:?}: {percent:.1} % of it lies outside the grid ({sides}) and is not counted{when}: no loss \
             if the cell ends there; if not, {bounds}, or {smaller}"
        )
    })
}

/// The sides of the grid in words, from whether something goes beyond the low and the high end of each axis.
fn sides(beyond: [[bool; 2]; 3]) -> String {
    let names = [["towards -x", "towards +x"], ["towards -y", "towards +y"], ["below", "above"]];
    // Floors and ceilings are what is cut off most often.
    let order = [2, 0, 1].into_iter().flat_map(|axis| [0, 1].map(|end| (axis, end)));
    let cut: Vec<&str> =
        order.filter(|&(axis, end)| beyond[axis][end]).map(|(axis, end)| names[axis][end]).collect();
    cut.join(", ")
}

/// The first snapshot where a value is largest, and words that name it; no words where all snapshots are
/// alike.
fn largest(values: &[f64]) -> (usize, String) {
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

/// Which poses are outside everything that is modelled, in the first snapshot.
fn outside_warning(
    study: &Study,
    places: &Places,
    sensor: usize,
    truth: &Truth,
    world: &World,
) -> Option<String> {
    let all = truth.objects.iter().map(|object| object.bounds_m);
    let [low, high] = all.reduce(|[low, high], [l, h]| [low.min(l), high.max(h)])?;
    let is_outside = |setting: &Setting| match setting {
        Setting::Pose(pose) => !(pose.position_m.cmpge(low) & pose.position_m.cmple(high)).all(),
        _ => false,
    };
    let outside = candidates(world, sensor, is_outside);
    let first = first_of(study, places, sensor, &outside)?;
    Some(format!(
        "sensor {:?}: {} poses ({first}) are outside all surfaces of the scene: is that where they should be?",
        study.sensors[sensor].name,
        outside.len()
    ))
}

/// How many poses stand in a blocker, in the snapshot where most do.
fn inside_warning(study: &Study, places: &Places, sensor: usize, glances: &[Glance]) -> Option<String> {
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
    fn sides_are_named_with_floor_and_ceiling_first() {
        assert_eq!(sides([[true, false], [false; 2], [true, false]]), "below, towards -x");
        assert_eq!(
            sides([[false, true], [true, true], [false, true]]),
            "above, towards +x, towards -y, towards +y"
        );
        assert_eq!(sides([[false; 2]; 3]), "");
    }

    #[test]
    fn the_worst_snapshot_is_named_unless_all_are_alike() {
        assert_eq!(largest(&[0.3]), (0, String::new()));
        assert_eq!(largest(&[0.3, 0.3]), (0, String::new()));
        assert_eq!(largest(&[0.0, 0.2, 0.1, 0.2]), (1, " (in snapshot 1, where it is most)".into()));
    }
}
