//! `manifest.json`: what is swept, from which inputs, and what each run of it did. All keys but [`BESIDE`] decide the
//! counts or the names beside them; their hash is the sweep's fingerprint, by which two machines prove that they worked on the
//! same.

use std::path::Path;

use serde_json::{Map, Value, json};
use sha2::{Digest, Sha256};

use crate::backend::{Noise, Rays};
use crate::results::columns;
use crate::results::files::{MANIFEST, read_regular, shards_below};
use crate::results::journal::Shard;
use crate::source::{hex, sha256};
use crate::study::{Study, catalogue};
use crate::world::{self, World};
use crate::{Error, Result};

/// Keys that decide nothing: the fingerprint itself, which part this folder holds, where things came from, what was done.
pub const BESIDE: [&str; 4] = ["fingerprint", "shard", "about", "runs"];

/// Keys that say what the user wrote; all others follow from these and from the program.
const CAUSES: [&str; 7] =
    ["semantics_version", "study", "scene_files", "files", "seed", "voxel_size_m", "noiseless"];

/// Most differences that are told; one is enough to refuse.
const MOST_TOLD: usize = 6;

/// How a run ended that nobody heard of again.
pub const KILLED: &str = "killed";

/// Longest text of which old and new are both shown.
const SHORT: usize = 60;

/// A manifest: an object with the keys of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct Manifest(Map<String, Value>);

/// What one run of the program did for a sweep.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Run {
    /// Which part of the sweep it worked on.
    pub shard: Shard,
    /// `cpu`, `gpu` or `oracle`.
    pub backend: &'static str,
    /// Adapter or processor.
    pub device: String,
    /// When it began, in seconds since 1970.
    pub began_unix_s: u64,
    /// Seconds that it read and voxelized scenes.
    pub prepare_s: f64,
    /// Seconds that it cast and counted.
    pub sweep_s: f64,
    /// How many poses it scored, each in every scene, snapshot and repeat for itself.
    pub poses: u64,
    /// The same in a second.
    pub poses_per_s: f64,
    /// How many of them were counted again on the CPU and found equal.
    pub verified: u64,
    /// What failed on the way, and who stepped in.
    pub faults: Vec<Fault>,
    /// `finished`, or why it was not; [`KILLED`] from its beginning until it ends.
    pub ended: String,
}

/// Something that failed, and what was done about it.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Fault {
    /// What the backend said.
    pub what: String,
    /// The scene that it worked on.
    pub scene: String,
    /// Who did the work instead.
    pub instead: String,
}

impl Manifest {
    /// The manifest of a sweep that has not run. `command` is the command that makes it, word by word.
    pub fn new(study: &Study, worlds: &[World], shard: Shard, command: &[String]) -> Manifest {
        let sensors = study.sensors.iter().enumerate().map(|(number, sensor)| {
            let rays = world::ray_table(study, number);
            json!({
                "name": sensor.name,
                "kind": sensor.kind.name(),
                "representations": sensor.kind.representations(),
                "poses": sensor.candidates.len(),
                "rays_per_pose": rays.as_ref().map_or(0, |rays| rays.dirs_q15.len()),
                "rays_sha256": rays.as_ref().map(rays_sha256),
            })
        });
        let combinations = study.combinations.iter().map(|combination| {
            let sensors = combination.members.iter().map(|member| study.sensors[member.sensor].name.as_str());
            json!({
                "name": combination.name,
                "sensors": sensors.collect::<Vec<_>>(),
                "poses": combination.members.iter().map(|m| ranges(&m.candidates)).collect::<Vec<_>>(),
                "fusion": combination.fusion,
                "choices": combination.choices(),
            })
        });
        let mut manifest = Manifest(object(json!({
            "semantics_version": crate::SEMANTICS_VERSION,
            "study": study_says(&study.text),
            "scene_files": study.scenes.iter().map(|spec| {
                json!({ "name": spec.name, "says": says(&spec.text) })
            }).collect::<Vec<_>>(),
            "files": files(study),
            "seed": study.seed,
            "voxel_size_m": study.voxel_size_m,
            "repeats": study.repeats,
            "noiseless": study.noiseless,
            "scenes": worlds.iter().map(|world| &world.described).collect::<Vec<_>>(),
            "sensors": sensors.collect::<Vec<_>>(),
            "poses_sha256": sha256([&columns::poses_csv(study, &worlds[0])]),
            "combinations": combinations.collect::<Vec<_>>(),
        })));
        let about = json!({
            "perirobot": env!("CARGO_PKG_VERSION"),
            "command": command,
            "study": { "file": study.path.display().to_string(), "text": study.text },
            "scene_files": study.scenes.iter().map(|spec| spec.path.display().to_string()).collect::<Vec<_>>(),
            "warnings": worlds.iter().flat_map(|world| {
                world.warnings.iter().map(|warning| format!("{}: {warning}", world.name))
            }).collect::<Vec<_>>(),
        });
        let fingerprint = hex(&manifest.fingerprint());
        manifest.0.insert("fingerprint".into(), fingerprint.into());
        manifest.0.insert("shard".into(), json!(shard));
        manifest.0.insert("about".into(), about);
        manifest.0.insert("runs".into(), json!([]));
        manifest
    }

    /// Reads the manifest of a folder.
    pub fn read(folder: &Path) -> Result<Manifest> {
        let path = folder.join(MANIFEST);
        if folder.is_dir() && !path.exists() {
            let cure = match shards_below(folder) {
                Ok(_) => "these are shards, put them together by `perirobot merge`",
                Err(_) => "name a folder that `perirobot sweep --out` has written",
            };
            return Err(Error::input(path.display(), format!("cannot be read, it is not there: {cure}")));
        }
        let json = serde_json::from_slice(&read_regular(&path)?);
        json.map(Manifest).map_err(|e| Error::input(path.display(), format!("{e}; sweep again")))
    }

    /// As it stands in the file.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = serde_json::to_vec_pretty(&self.0).expect("a JSON value is serialisable");
        bytes.push(b'\n');
        bytes
    }

    /// What it says under a key.
    pub fn get(&self, key: &str) -> &Value {
        self.0.get(key).unwrap_or(&Value::Null)
    }

    /// The command that makes it, word by word.
    pub fn command(&self) -> Vec<String> {
        let words = self.get("about")["command"].as_array();
        words.into_iter().flatten().filter_map(|word| Some(word.as_str()?.to_string())).collect()
    }

    /// The whole as one value.
    pub fn value(&self) -> Value {
        Value::Object(self.0.clone())
    }

    /// The hash of all that decides the counts, made from what is here, not from what it claims.
    pub fn fingerprint(&self) -> [u8; 32] {
        let decides: Map<String, Value> = self.decides().map(|(k, v)| (k.clone(), v.clone())).collect();
        Sha256::digest(serde_json::to_vec(&decides).expect("a JSON value is serialisable")).into()
    }

    /// Adds a run that begins; until [`Manifest::end_run`] nobody knows how it ended.
    pub fn begin_run(&mut self, run: &Run) {
        let mut begun = json!(run);
        for unknown in ["sweep_s", "poses", "poses_per_s", "verified", "faults"] {
            begun[unknown] = Value::Null;
        }
        self.add_runs([begun]);
    }

    /// Says of the run that was begun last what it did.
    pub fn end_run(&mut self, run: &Run) {
        if let Some(Value::Array(runs)) = self.0.get_mut("runs") {
            runs.pop();
        }
        self.add_runs([json!(run)]);
    }

    /// Says that what such runs counted was checked by a later one.
    pub fn runs_are_checked(&mut self) {
        let runs = self.0.get_mut("runs").and_then(Value::as_array_mut);
        for run in runs.into_iter().flatten().filter(|run| run["ended"] == KILLED) {
            run["ended"] = format!("{KILLED}; what it counted was checked later").into();
        }
    }

    /// Whether a run on a GPU ended without a word, so that nobody checked what it counted.
    pub fn has_unchecked_run(&self) -> bool {
        let runs = self.get("runs").as_array();
        runs.into_iter().flatten().any(|run| run["backend"] == "gpu" && run["ended"] == KILLED)
    }

    /// Keeps what earlier runs did.
    pub fn keep_runs(&mut self, earlier: &Manifest) {
        self.add_runs(earlier.get("runs").as_array().cloned().unwrap_or_default());
    }

    /// The same sweep as a whole, before anything is known of runs.
    pub fn of_whole(&self) -> Manifest {
        let mut whole = self.clone();
        whole.0.insert("shard".into(), json!(Shard::WHOLE));
        whole.0.insert("runs".into(), json!([]));
        whole
    }

    /// In words, what another manifest has that decides the counts and is not the same here; effects only where there is
    /// no cause.
    pub fn changes(&self, now: &Manifest) -> Vec<String> {
        let mut told = Vec::new();
        CAUSES.iter().for_each(|key| differences(key, self.get(key), now.get(key), &mut told));
        if told.is_empty() {
            let effects = now.decides().map(|(key, _)| key.as_str()).filter(|key| !CAUSES.contains(key));
            effects.for_each(|key| differences(key, self.get(key), now.get(key), &mut told));
        }
        told
    }

    fn decides(&self) -> impl Iterator<Item = (&String, &Value)> {
        self.0.iter().filter(|(key, _)| !BESIDE.contains(&key.as_str()))
    }

    fn add_runs(&mut self, more: impl IntoIterator<Item = Value>) {
        let runs = self.0.entry("runs").or_insert_with(|| json!([]));
        if let Value::Array(runs) = runs {
            runs.extend(more);
        }
    }
}

fn object(value: Value) -> Map<String, Value> {
    match value {
        Value::Object(map) => map,
        _ => Map::new(),
    }
}

/// Hashes of the files that were read, but for the study and its scenes: of those, what they say is compared.
fn files(study: &Study) -> Map<String, Value> {
    let texts = study.scenes.iter().map(|spec| &spec.text).chain([&study.text]);
    let known: Vec<String> = texts.map(|text| sha256([text.as_bytes()])).collect();
    let files = study.sources.read_files().into_iter().filter(|file| !known.contains(&file.sha256));
    files.map(|file| (file.path.display().to_string(), file.sha256.into())).collect()
}

/// What a TOML file says, without comments and order of keys.
fn says(text: &str) -> Value {
    toml::from_str(text).unwrap_or_else(|_| text.into())
}

/// The same of a study, with the keys of the devices that it names: other values of a device are another study.
fn study_says(text: &str) -> Value {
    toml::from_str(text).map_or_else(|_| text.into(), |study| json!(catalogue::written_out(study)))
}

/// Numbers in ascending order as ranges `[first, end]`.
fn ranges(numbers: &[usize]) -> Vec<[usize; 2]> {
    let runs = numbers.chunk_by(|a, b| a + 1 == *b);
    runs.filter_map(|run| Some([*run.first()?, run.last()? + 1])).collect()
}

/// Adds where two values differ, while there is room.
fn differences(place: &str, was: &Value, is: &Value, told: &mut Vec<String>) {
    match (was, is) {
        _ if told.len() == MOST_TOLD || was == is => {}
        (Value::Object(a), Value::Object(b)) => {
            let keys = a.keys().chain(b.keys().filter(|key| !a.contains_key(*key)));
            for key in keys {
                let at = |map: &Map<String, Value>| map.get(key).cloned().unwrap_or(Value::Null);
                differences(&format!("{place}.{key}"), &at(a), &at(b), told);
            }
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() && a.iter().any(|v| v.is_object()) => {
            for (i, (a, b)) in a.iter().zip(b).enumerate() {
                differences(&format!("{place}[{i}]"), a, b, told);
            }
        }
        _ => {
            let (was, is) = (was.to_string(), is.to_string());
            let long = was.len().max(is.len()) > SHORT;
            told.push(if long {
                format!("{place} is another")
            } else {
                format!("{place} was {was}, is {is}")
            });
        }
    }
}

fn rays_sha256(rays: &Rays) -> String {
    let gates = &rays.gates;
    let numbers = [gates.range_min_q16, gates.range_max_q16, gates.near_ignore_q16]
        .into_iter()
        .chain([gates.no_return_is_free as u32, gates.backdrop as u32]);
    let gates: Vec<u8> = numbers.flat_map(u32::to_le_bytes).collect();
    let Noise { unit_q12, std_q16, lost_below } = &rays.noise;
    let unit = unit_q12.iter().map(|&unit| unit as u32);
    let noise = unit.chain(std_q16.iter().copied()).chain([*lost_below]);
    let noise: Vec<u8> = noise.flat_map(u32::to_le_bytes).collect();
    let dirs: Vec<u8> = rays.dirs_q15.iter().flatten().flat_map(|d| d.to_le_bytes()).collect();
    sha256([gates.as_slice(), &dirs, &noise])
}

#[cfg(test)]
mod tests;
