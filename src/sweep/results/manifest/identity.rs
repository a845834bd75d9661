//! The identity of a sweep: all keys of `manifest.json` that affect the counts or the names next to them.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use perirobot_march::backend::{Fusion, Noise, Rays};
use perirobot_scene::source::{little_endian, sha256};
use perirobot_study::input::{Member, Study, catalogue};
use perirobot_study::world::{self, Described, World};

/// Everything that affects the counts. Values that are not needed to read a sweep may be missing in a file, and are
/// empty then.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Identity {
    /// The [`perirobot_march::SEMANTICS_VERSION`] of the counts.
    pub semantics_version: u32,
    /// The contents of the study, without comments and order of keys.
    #[serde(default)]
    pub study: Value,
    /// The same for its scenes.
    #[serde(default)]
    pub scene_files: Vec<SceneFileIdentity>,
    /// Hashes of the other files, by path.
    #[serde(default)]
    pub files: BTreeMap<String, String>,
    /// Seed of all random draws.
    #[serde(default)]
    pub seed: u64,
    /// Edge of a voxel in metres.
    pub voxel_size_m: f64,
    /// The number of repeats.
    pub repeats: usize,
    /// Whether sensors measure without noise, overriding the study.
    pub noiseless: bool,
    /// Each snapshot of each scene.
    pub scenes: Vec<Described>,
    /// Sensors in study order.
    pub sensors: Vec<SensorIdentity>,
    /// Hash of `poses.csv`.
    pub poses_sha256: String,
    /// Combinations in study order.
    pub combinations: Vec<Sensors>,
}

/// The contents of a scene file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneFileIdentity {
    /// The scene's name.
    pub name: String,
    /// The contents, as for the study.
    pub says: Value,
}

/// A sensor of the study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorIdentity {
    /// Its name.
    pub name: String,
    /// Its key `kind` in the study.
    pub kind: String,
    /// Its representations.
    pub representations: Vec<String>,
    /// The number of its poses.
    pub poses: usize,
    /// The number of rays from each.
    pub rays_per_pose: usize,
    /// Hash of their directions, ranges and noise; `None` for a sensor without rays.
    pub rays_sha256: Option<String>,
}

/// Sensors of a combination.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sensors {
    /// The combination's name.
    pub name: String,
    /// Names of its sensors.
    pub sensors: Vec<String>,
    /// For each sensor, ranges of its poses: the first, and one beyond the last.
    pub poses: Vec<Vec<[usize; 2]>>,
    /// Their fusion.
    #[serde(default)]
    pub fusion: Fusion,
    /// The number of its choices of poses.
    #[serde(default)]
    pub choices: usize,
}

impl Identity {
    /// The identity of a study. `worlds` are those of [`World::prepare_all`]. `poses_csv` is their table of poses.
    pub(super) fn new(study: &Study, worlds: &[World], poses_csv: &[u8]) -> Identity {
        let scene_files = study.scenes.iter().map(|spec| {
            let says = toml::from_str(&spec.text).unwrap_or_else(|_| spec.text.as_str().into());
            SceneFileIdentity { name: spec.name.clone(), says }
        });
        let sensors = study.sensors.iter().enumerate().map(|(number, sensor)| {
            let rays = world::ray_table(study, number);
            SensorIdentity {
                name: sensor.name.clone(),
                kind: sensor.kind.name().into(),
                representations: sensor.kind.representations().into_iter().map(String::from).collect(),
                poses: sensor.candidates.len(),
                rays_per_pose: rays.as_ref().map_or(0, |rays| rays.dirs_q15.len()),
                rays_sha256: rays.as_ref().map(rays_sha256),
            }
        });
        let combinations = study.combinations.iter().map(|combination| {
            let name = |member: &Member| study.sensors[member.sensor].name.clone();
            Sensors {
                name: combination.name.clone(),
                sensors: combination.members.iter().map(name).collect(),
                poses: combination.members.iter().map(|member| ranges(&member.candidates)).collect(),
                fusion: combination.fusion,
                choices: combination.choices(),
            }
        });
        Identity {
            semantics_version: perirobot_march::SEMANTICS_VERSION,
            study: says(&study.text),
            scene_files: scene_files.collect(),
            files: files(study),
            seed: study.seed,
            voxel_size_m: study.voxel_size_m,
            repeats: study.repeats as usize,
            noiseless: study.noiseless,
            scenes: worlds.iter().map(|world| world.described.clone()).collect(),
            sensors: sensors.collect(),
            poses_sha256: sha256([poses_csv]),
            combinations: combinations.collect(),
        }
    }
}

/// The contents of a study, with the keys of its device models: other values of a device are another study. Keys on
/// choosing and judging sets, and on approaches, affect no count and are left out, except for the floor from which
/// heights in tables are measured; so are the keys on stopping, which determine regions: their voxels are compared
/// instead.
fn says(text: &str) -> Value {
    let mut says = toml::from_str(text)
        .map_or_else(|_| text.into(), |study| serde_json::json!(catalogue::written_out(study)));
    if let Some(keys) = says.as_object_mut() {
        let floor_m = keys.get("approach").and_then(|approach| approach.get("floor_m")).cloned();
        for asked in ["choose", "currency", "require", "mounting_error", "postures", "approach", "stopping"] {
            keys.remove(asked);
        }
        keys.extend(floor_m.map(|z| ("approach".into(), serde_json::json!({ "floor_m": z }))));
        let sensors = keys.get_mut("sensor").and_then(Value::as_array_mut).into_iter().flatten();
        for sensor in sensors.filter_map(Value::as_object_mut) {
            for term in ["cost", "at_most", "emits"] {
                sensor.remove(term);
            }
        }
    }
    says
}

/// Hashes of all files except the study and its scenes, whose contents are compared.
fn files(study: &Study) -> BTreeMap<String, String> {
    let texts = study.scenes.iter().map(|spec| &spec.text).chain([&study.text]);
    let known: Vec<String> = texts.map(|text| sha256([text.as_bytes()])).collect();
    let files = study.sources.read_files().into_iter().filter(|file| !known.contains(&file.sha256));
    files.map(|file| (file.path.display().to_string(), file.sha256)).collect()
}

/// Ascending numbers as ranges `[first, end]`.
fn ranges(numbers: &[usize]) -> Vec<[usize; 2]> {
    let runs = numbers.chunk_by(|a, b| a + 1 == *b);
    runs.filter_map(|run| Some([*run.first()?, run.last()? + 1])).collect()
}

fn rays_sha256(rays: &Rays) -> String {
    let gates = &rays.gates;
    let numbers = [gates.range_min_q16, gates.range_max_q16, gates.near_ignore_q16]
        .into_iter()
        .chain([gates.no_return_is_free as u32, gates.backdrop as u32])
        .chain(gates.along_axis.then_some(1))
        .chain(gates.shade_ranges_q16.into_iter().filter(|_| gates.has_shades()));
    let gates: Vec<u32> = numbers.collect();
    let Noise { unit_q12, std_q16, lost_below } = &rays.noise;
    let parts = [
        little_endian(&gates),
        little_endian(&rays.dirs_q15),
        little_endian(unit_q12),
        little_endian(std_q16),
        little_endian(std::slice::from_ref(lost_below)),
    ];
    sha256(parts.each_ref().map(|part| &**part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_and_order_of_keys_say_nothing() {
        assert_eq!(says("a = 1\nb = 2 # much"), says("b = 2\n\na = 1"));
        assert_ne!(says("a = 1"), says("a = 1.5"));
        let sensor = "[[sensor]]\nname = \"a\"\n";
        assert_eq!(
            says(sensor),
            says(&format!(
                "currency = \"EUR\"\n{sensor}cost = 3.5\nat_most = 2\nemits = \"tof\"\n[choose]\nat_most = 1\n[[require]]\nname = \"b\"\n[mounting_error]\ndraws = 2\n[postures]\npeople = []\n[approach]\nmin_voxels = 2\n[stopping]\nformula = \"iso13855\""
            ))
        );
        let floor = |z: &str| says(&format!("{sensor}[approach]\nmin_voxels = 2\nfloor_m = {z}"));
        assert_ne!(floor("0.0"), says(sensor));
        assert_ne!(floor("0.0"), floor("0.3"));
    }

    #[test]
    fn candidates_are_told_as_ranges() {
        assert_eq!(ranges(&[0, 1, 2, 5, 7, 8]), [[0, 3], [5, 6], [7, 9]]);
        assert_eq!(ranges(&[]), [[0; 2]; 0]);
    }
}
