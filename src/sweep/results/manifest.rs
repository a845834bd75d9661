//! `manifest.json`: what is swept, from which inputs, and what each run of it did. The hash of all that
//! decides the counts or the names beside them is the sweep's fingerprint, by which two machines prove that
//! they worked on the same.

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

/// How a run ended that never wrote its end.
pub const KILLED: &str = "killed";

/// A manifest.
#[derive(Clone, Debug, PartialEq)]
pub struct Manifest {
    /// All that decides the counts.
    pub identity: Identity,
    /// The same as it stands in the file, whichever version of the program wrote it: this is hashed and
    /// compared.
    as_written: Map<String, Value>,
    /// Where it came from and what was done; this does not affect counts.
    pub provenance: Provenance,
}

/// Values that do not affect counts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Who made it, and from what.
    pub about: About,
    /// The fingerprint as written in the file; [`Manifest::fingerprint`] computes it.
    pub fingerprint: String,
    /// What each run did, the latest last.
    pub runs: Vec<Run>,
    /// Which part of the sweep its folder holds.
    pub shard: Shard,
}

/// Who made a manifest, and from what.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct About {
    /// The version of the program.
    pub perirobot: String,
    /// The command that makes it, word by word.
    pub command: Vec<String>,
    /// The study.
    pub study: StudyFileIdentity,
    /// Paths of its scenes.
    pub scene_files: Vec<String>,
    /// What was warned of.
    pub warnings: Vec<String>,
}

/// The file of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StudyFileIdentity {
    /// Its path.
    pub file: String,
    /// All that stands in it.
    pub text: String,
}

/// What one run of the program did for a sweep; some values are unknown until it ends.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Which part of the sweep it worked on.
    pub shard: Shard,
    /// `cpu`, `gpu` or `oracle`.
    pub backend: String,
    /// Adapter or processor.
    pub device: String,
    /// When it began, in seconds since 1970.
    pub began_unix_s: u64,
    /// Seconds that it read and voxelized scenes.
    pub prepare_s: f64,
    /// Seconds that it cast and counted.
    pub sweep_s: Option<f64>,
    /// How many poses it scored, each in every scene, snapshot and repeat for itself.
    pub poses: Option<u64>,
    /// The same in a second.
    pub poses_per_s: Option<f64>,
    /// How many of them were counted again on the CPU and found equal.
    pub verified: Option<u64>,
    /// What failed, and which backend did the work instead.
    pub faults: Option<Vec<Fault>>,
    /// `finished`, or why it was not; [`KILLED`] from its beginning until it ends.
    pub ended: String,
}

impl Manifest {
    /// The manifest of a sweep that has not run. `command` is the command that makes it, word by word.
    pub fn new(study: &Study, worlds: &[World], shard: Shard, command: &[String]) -> Manifest {
        Manifest::with_poses(study, worlds, &columns::poses_csv(study, &worlds[0]), shard, command)
    }

    /// The same where the table of poses is known.
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
    /// `Error::Input` that names the file and what is missing in it or wrong; `Error::Storage` if the disk
    /// fails.
    pub fn read(folder: &Path) -> Result<Manifest> {
        let path = folder.join(MANIFEST);
        if folder.is_dir() && !path.exists() {
            let cure = match shards_below(folder) {
                Ok(_) => "these are shards, put them together by `perirobot merge`",
                Err(_) => "name a folder that `perirobot sweep` or `perirobot choose` has written",
            };
            return Err(Error::input(path, "cannot be read, it is not there").with_advice(cure));
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

    /// As it stands in the file.
    pub fn bytes(&self) -> Vec<u8> {
        let mut whole = self.as_written.clone();
        whole.extend(object(&self.provenance));
        let mut bytes = serde_json::to_vec_pretty(&whole).expect("a JSON value is serialisable");
        bytes.push(b'\n');
        bytes
    }

    /// The hash of all that decides the counts, computed from the values, not copied from the file.
    pub fn fingerprint(&self) -> [u8; 32] {
        hash(&self.as_written)
    }

    /// All that decides the counts, key by key.
    pub fn deciding(&self) -> &Map<String, Value> {
        &self.as_written
    }

    /// Records what the last run did.
    pub(crate) fn end_run(&mut self, run: Run) {
        self.provenance.runs.pop();
        self.provenance.runs.push(run);
    }

    /// Records that what such runs counted was checked by a later run.
    pub(crate) fn runs_are_checked(&mut self) {
        for run in self.provenance.runs.iter_mut().filter(|run| run.ended == KILLED) {
            run.ended = format!("{KILLED}; what it counted was checked later");
        }
    }

    /// Whether a run on a GPU was killed before what it counted was checked.
    pub(crate) fn has_unchecked_run(&self) -> bool {
        self.provenance.runs.iter().any(|run| run.backend == "gpu" && run.ended == KILLED)
    }

    /// In words, what another manifest has that decides the counts and is not the same here; effects only
    /// where there is no cause.
    pub fn changes(&self, now: &Manifest) -> Vec<String> {
        changes(&self.as_written, &now.as_written)
    }
}

/// A structure as the object that stands for it in JSON, its keys in order.
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

    /// A manifest of an older program: some keys are missing, one is not known any more.
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
        // Keys that are not known here were hashed by the version that wrote them.
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
