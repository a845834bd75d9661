//! The inputs of evidence: its planes cover all voxels of the grid, for any question.
//!
//! | key of a study | effect on planes |
//! |---|---|
//! | `seed`, `repeats` | the noise that is drawn, and how often |
//! | `grid` | voxels, and the end of a ray that leaves them |
//! | `scene`, `candidate` | the surfaces that are hit |
//! | `sensor`, `catalogue` | rays, poses and noise; but not `cost`, `at_most` and `emits`, which are terms of sets |
//! | `choose` | the `representation` of each sensor; the other keys ask about the same planes |
//! | `region`, `stopping` | nothing: regions are picked from planes over the whole grid |
//! | `min_hits` | nothing: hits are counted later |
//! | `fusion`, `combination`, `mixed_noise` | nothing: each sensor is cast alone |
//! | `currency` | nothing: it is a word for costs |
//! | `require`, `mounting_error`, `postures`, `approach` | nothing: they are judged elsewhere |
//!
//! Evidence also depends on the rules of casting ([`perirobot_march::SEMANTICS_VERSION`]), on the command line's size of
//! voxels and noise, on scene files, and on other files that were read, except meshes of regions. If an object of a scene
//! has the same mesh, a change of it shows in the voxels of the scene.

use std::collections::HashSet;

use serde_json::{Map, Value, json};

use perirobot_study::input::{RegionSpec, Study};
use perirobot_study::sensor::Sensor;
use perirobot_study::world::World;
use perirobot_sweep::results::journal::Shard;
use perirobot_sweep::results::manifest::Manifest;

/// Keys that decide a sweep but not evidence. `poses_sha256` covers names of places, with heights above the floor of
/// `[approach]`; the study and the hashes of placements determine the sensors' poses.
const NOT_DECIDING: [&str; 2] = ["combinations", "poses_sha256"];

/// The same for the keys of a study; those that do not decide a sweep either are already removed.
const STUDY_NOT_DECIDING: [&str; 6] =
    ["approach", "combination", "fusion", "min_hits", "mixed_noise", "region"];

/// All inputs of a study's evidence; `representations` is the representation of each sensor.
pub(super) fn deciding(study: &Study, worlds: &[World], representations: &[usize]) -> Map<String, Value> {
    let mut all = Manifest::new(study, worlds, Shard::WHOLE, &[]).deciding().clone();
    remove(&mut all, &NOT_DECIDING);
    all.get_mut("study")
        .and_then(Value::as_object_mut)
        .iter_mut()
        .for_each(|keys| remove(keys, &STUDY_NOT_DECIDING));
    let scenes = all.get_mut("scenes").and_then(Value::as_array_mut).into_iter().flatten();
    scenes.filter_map(Value::as_object_mut).for_each(|scene| remove(scene, &["regions"]));
    let meshes: HashSet<String> = study
        .regions
        .iter()
        .filter_map(|(_, region)| match region {
            RegionSpec::Mesh { file, .. } => Some(study.sources.name(&file.path)),
            _ => None,
        })
        .collect();
    if let Some(files) = all.get_mut("files").and_then(Value::as_object_mut) {
        files.retain(|name, _| !meshes.contains(name));
    }
    let way = |(sensor, &way): (&Sensor, &usize)| {
        (sensor.name.clone(), Value::from(sensor.kind.representations()[way]))
    };
    let representations: Map<String, Value> = study.sensors.iter().zip(representations).map(way).collect();
    all.insert("choose".into(), json!({ "representation": representations }));
    all
}

fn remove(from: &mut Map<String, Value>, keys: &[&str]) {
    from.retain(|key, _| !keys.contains(&key.as_str()));
}
