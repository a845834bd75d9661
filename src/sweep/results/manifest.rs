//! `manifest.json`: the sweep, its inputs, and its runs. The hash of everything that affects the counts or the names
//! next to them is the sweep's fingerprint, by which two machines prove that they worked on the same sweep.

mod changes;
mod identity;
mod sets;

use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use sha2::{Digest, Sha256};

use crate::results::columns;
use crate::results::files::{MANIFEST, json_issue, read_regular, shards_below};
use crate::results::journal::Shard;
pub use changes::changes;
pub use identity::{Identity, SceneFileIdentity, SensorIdentity, Sensors};
use perirobot_march::progress::Fault;
use perirobot_march::{Error, Result};
use perirobot_scene::source::hex;
use perirobot_study::input::Study;
use perirobot_study::world::World;

/// The end of a run that never wrote one.
pub const KILLED: &str = "killed";

/// A manifest.
#[derive(Clone, Debug, PartialEq)]
pub struct Manifest {
    /// Everything that affects the counts.
    pub identity: Identity,
    /// The same as in the file, independent of the program's version: it is hashed and compared.
    as_written: Map<String, Value>,
    /// Sources and runs, which do not affect counts.
    pub provenance: Provenance,
}

/// Values that do not affect counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// The program and its inputs.
    pub about: About,
    /// The fingerprint as written in the file; [`Manifest::fingerprint`] computes it.
    pub fingerprint: String,
    /// The runs, latest last.
    pub runs: Vec<Run>,
    /// The part of the sweep in this folder.
    pub shard: Shard,
}

/// The program and inputs of a manifest.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct About {
    /// The version of the program.
    pub perirobot: String,
    /// The command of the sweep, word by word.
    pub command: Vec<String>,
    /// The study.
    pub study: StudyFileIdentity,
    /// Paths of its scenes.
    pub scene_files: Vec<String>,
    /// Warnings.
    pub warnings: Vec<String>,
}

/// The file of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StudyFileIdentity {
    /// Its path.
    pub file: String,
    /// Its text.
    pub text: String,
}

/// One run of the program on a sweep; some values are unknown until it ends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Its part of the sweep.
    pub shard: Shard,
    /// `cpu`, `gpu` or `oracle`.
    pub backend: String,
    /// Adapter or processor.
    pub device: String,
    /// Its start, in seconds since 1970.
    pub began_unix_s: u64,
    /// Seconds of reading and voxelizing scenes.
    pub prepare_s: f64,
    /// Seconds of casting and counting.
    pub sweep_s: Option<f64>,
    /// The number of scored poses, in each scene, snapshot and repeat.
    pub poses: Option<u64>,
    /// The same per second.
    pub poses_per_s: Option<f64>,
    /// The number of them that the CPU counted again with equal results.
    pub verified: Option<u64>,
    /// Failures, and the backends that replaced the failed ones.
    pub faults: Option<Vec<Fault>>,
    /// `finished`, or why not; [`KILLED`] from its start until it ends.
    pub ended: String,
}

impl Manifest {
    /// The manifest of a sweep that has not run. `command` is the command of the sweep, word by word.
    pub fn new(study: &Study, worlds: &[World], shard: Shard, command: &[String]) -> Manifest {
        Manifest::with_poses(study, worlds, &columns::poses_csv(study, &worlds[0]), shard, command)
    }

    /// The same with a known table of poses.
    pub(crate) fn with_poses(
        study: &Study,
        worlds: &[World],
        poses_csv: &[u8],
        shard: Shard,
        command: &[String],
    ) -> Manifest {
        let identity = Identity::new(study, worlds, poses_csv);
        let as_written = object(&identity);
        let warnings = worlds
            .iter()
            .flat_map(|world| world.warnings.iter().map(|warning| format!("{}: {warning}", world.name)));
        let about = About {
            perirobot: env!("CARGO_PKG_VERSION").into(),
            command: command.into(),
            study: StudyFileIdentity { file: study.path.display().to_string(), text: study.text.clone() },
            scene_files: study.scenes.iter().map(|spec| spec.path.display().to_string()).collect(),
            warnings: warnings.collect(),
        };
        let fingerprint = hex(&hash(&as_written));
        let provenance = Provenance { about, fingerprint, runs: Vec::new(), shard };
        Manifest { identity, as_written, provenance }
    }

    /// Reads the manifest of a folder.
    ///
    /// # Errors
    /// `Error::Input` that names the file and the missing or wrong value; `Error::Storage` if the disk fails.
    pub fn read(folder: &Path) -> Result<Manifest> {
        let path = folder.join(MANIFEST);
        if folder.is_dir() && !path.exists() {
            let cure = match shards_below(folder) {
                Ok(_) => "these are shards: merge them with `perirobot merge`",
                Err(_) => "name a folder written by `perirobot sweep` or `perirobot choose`",
            };
            return Err(Error::input(path, "does not exist").with_advice(cure));
        }
        let bytes = read_regular(&path)?;
        Manifest::parse(&bytes)
            .map_err(|e| json_issue(&e).cure("sweep again, or choose again").with_place(path).into())
    }

    fn parse(bytes: &[u8]) -> Result<Manifest, serde_json::Error> {
        let json: Value = serde_json::from_slice(bytes)?;
        let (identity, provenance) = (Identity::deserialize(&json)?, Provenance::deserialize(&json)?);
        let beside = object(&provenance);
        let mut as_written = object(&json);
        as_written.retain(|key, _| !beside.contains_key(key));
        Ok(Manifest { identity, as_written, provenance })
    }

    /// The manifest as bytes.
    pub fn bytes(&self) -> Vec<u8> {
        let mut whole = self.as_written.clone();
        whole.extend(object(&self.provenance));
        let mut bytes = serde_json::to_vec_pretty(&whole).expect("a JSON value is serialisable");
        bytes.push(b'\n');
        bytes
    }

    /// The hash of everything that affects the counts, computed from the values, not copied from the file.
    pub fn fingerprint(&self) -> [u8; 32] {
        hash(&self.as_written)
    }

    /// Everything that affects the counts, key by key.
    pub fn deciding(&self) -> &Map<String, Value> {
        &self.as_written
    }

    /// Records the end of the last run.
    pub(crate) fn end_run(&mut self, run: Run) {
        self.provenance.runs.pop();
        self.provenance.runs.push(run);
    }

    /// Records that a later run checked the counts of unchecked runs.
    pub(crate) fn runs_are_checked(&mut self) {
        for run in self.provenance.runs.iter_mut().filter(|run| run.ended == KILLED) {
            run.ended = format!("{KILLED}; what it counted was checked later");
        }
    }

    /// Whether a run on a GPU was killed before its counts were checked.
    pub(crate) fn has_unchecked_run(&self) -> bool {
        self.provenance.runs.iter().any(|run| run.backend == "gpu" && run.ended == KILLED)
    }

    /// The differences of another manifest that affect the counts, in words; effects only if there is no cause.
    pub fn changes(&self, now: &Manifest) -> Vec<String> {
        changes(&self.as_written, &now.as_written)
    }
}

/// A structure as a JSON object with sorted keys.
fn object(of: &impl Serialize) -> Map<String, Value> {
    match serde_json::to_value(of) {
        Ok(Value::Object(map)) => map,
        _ => Map::new(),
    }
}

fn hash(map: &Map<String, Value>) -> [u8; 32] {
    Sha256::digest(serde_json::to_vec(map).expect("a JSON value is serialisable")).into()
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// A manifest of an older program: some keys are missing, one is no longer known.
    fn old() -> Value {
        let run = json!({
            "shard": { "number": 0, "of": 1 }, "backend": "gpu", "device": "a", "began_unix_s": 1, "prepare_s": 0.1,
            "sweep_s": null, "poses": null, "poses_per_s": null, "verified": null, "faults": null, "ended": "killed",
        });
        json!({
            "semantics_version": 2, "seed": 7, "voxel_size_m": 0.05, "repeats": 1, "noiseless": false, "scenes": [],
            "sensors": [], "poses_sha256": "x", "combinations": [], "gone": [0.1, { "since": "long" }],
            "about": {
                "perirobot": "0.0.9", "command": ["perirobot"], "study": { "file": "a.toml", "text": "" },
                "scene_files": [], "warnings": [],
            },
            "fingerprint": "y", "runs": [run], "shard": { "number": 0, "of": 1 },
        })
    }

    fn parse(json: &Value) -> Result<Manifest, serde_json::Error> {
        Manifest::parse(&serde_json::to_vec(json).unwrap())
    }

    #[test]
    fn what_stands_in_a_file_is_what_is_written_again() {
        let manifest = parse(&old()).unwrap();
        assert_eq!(serde_json::from_slice::<Value>(&manifest.bytes()).unwrap(), old());
        assert!(manifest.bytes().starts_with(b"{\n  \"about\": {") && manifest.bytes().ends_with(b"}\n"));
        assert_eq!((manifest.identity.semantics_version, manifest.has_unchecked_run()), (2, true));
    }

    #[test]
    fn what_decides_nothing_changes_nothing() {
        let was = parse(&old()).unwrap();
        let with = |key: &str, value: Value| {
            let mut json = old();
            json[key] = value;
            parse(&json).unwrap()
        };
        for beside in [
            with("runs", json!([])),
            with("fingerprint", json!("z")),
            with("shard", json!({ "number": 1, "of": 2 })),
        ] {
            assert_eq!((beside.fingerprint(), was.changes(&beside)), (was.fingerprint(), vec![]));
        }
        // Unknown keys were hashed by the version that wrote them.
        for (key, told) in
            [("seed", "seed was 7, is 8"), ("gone", "gone was [0.1,{\"since\":\"long\"}], is 8")]
        {
            let other = with(key, json!(8));
            assert_ne!(other.fingerprint(), was.fingerprint(), "{key}");
            assert_eq!(was.changes(&other), [told]);
        }
    }

    #[test]
    fn what_is_missing_is_named() {
        for key in
            ["semantics_version", "voxel_size_m", "noiseless", "poses_sha256", "about", "runs", "shard"]
        {
            let mut json = old();
            json.as_object_mut().unwrap().remove(key);
            assert_eq!(parse(&json).unwrap_err().to_string(), format!("missing field `{key}`"));
        }
    }
}
