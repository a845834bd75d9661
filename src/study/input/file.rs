//! The study file, as TOML: keys, units in their names, and defaults. Only spelling and type are checked
//! here.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Deserialize;

use super::approach::ApproachFile;
use super::candidates::CandidateFile;
use super::choose::ChooseFile;
use super::postures::PosturesFile;
use super::region_file::RegionFile;
use super::require::{MountingErrorFile, RequirementFile};
use super::stopping::StoppingFile;
use crate::keys::exactly;
use perirobot_march::backend::Fusion;

/// A study: what is placed where, in which cells.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct StudyFile {
    /// Seed of all noise and of random poses. Default 0.
    #[serde(default)]
    #[cfg_attr(test, schemars(range(max = i64::MAX)))]
    pub(super) seed: u64,
    /// How the evidence of a combination's sensors becomes one label a voxel, unless the combination has its
    /// own rule. Default "occupied_wins".
    #[serde(default)]
    #[cfg_attr(test, schemars(with = "super::schema::counted::FusionName"))]
    pub(super) fusion: Fusion,
    /// How often everything is measured, each time with other noise. Default 1.
    #[serde(default = "once")]
    pub(super) repeats: u32,
    /// Whether sensors of unknown noise may be compared with sensors whose noise is known. Default false.
    #[serde(default)]
    pub(super) mixed_noise: bool,
    /// How many voxels of a body part must be hit for it to be detected. Default 3.
    #[serde(default = "three")]
    pub(super) min_hits: u32,
    /// The unit of all costs, a word of 1 to 8 characters such as "EUR". Default none.
    #[cfg_attr(test, schemars(length(min = 1, max = 8), regex(pattern = r"^\S+$")))]
    pub(super) currency: Option<String>,
    /// A catalogue of your own devices, which sensors then name in `model`: a TOML file with a list `[[model]]`, each
    /// with a name and the keys of a sensor.
    pub(super) catalogue: Option<PathBuf>,
    /// The voxels.
    #[serde(default)]
    pub(super) grid: GridFile,
    /// The cells that are swept, at least one.
    #[serde(default)]
    pub(super) scene: Vec<SceneEntry>,
    /// Places where objects of the scenes may stand: each choice of them is a scene of its own.
    #[serde(default)]
    pub(super) candidate: Vec<CandidateFile>,
    /// The regions in which voxels are counted, at least one.
    #[serde(default)]
    pub(super) region: Vec<RegionFile>,
    /// The sensors to be placed, at least one.
    #[serde(default)]
    #[cfg_attr(test, schemars(with = "Vec<super::sensor::AnySensor>"))]
    pub(super) sensor: Vec<toml::Table>,
    /// Sensors that are scored together; each alone if there is none.
    #[serde(default)]
    pub(super) combination: Vec<CombinationFile>,
    /// What `perirobot choose` looks for: the best set of sensors.
    pub(super) choose: Option<ChooseFile>,
    /// What `perirobot judge` decides: scores that a choice of sensors must reach.
    #[serde(default)]
    pub(super) require: Vec<RequirementFile>,
    /// How far mounts may be from where they are planned.
    pub(super) mounting_error: Option<MountingErrorFile>,
    /// Who stands where, for requirements under "postures".
    pub(super) postures: Option<PosturesFile>,
    /// What `perirobot approach` looks for: how near a body can come to the robot unnoticed.
    pub(super) approach: Option<ApproachFile>,
    /// How far people must be from the robot at which of its speeds.
    pub(super) stopping: Option<StoppingFile>,
}

fn once() -> u32 {
    1
}

fn three() -> u32 {
    3
}

/// The voxels.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub(super) struct GridFile {
    /// Edge of a voxel in metres, from 0.0001 to 10. Default 0.05.
    pub(super) voxel_size_m: f64,
    /// Corners of the grid; without, it holds all surfaces and sensors.
    pub(super) bounds_m: Option<BoundsFile>,
    /// What a ray that leaves the grid hits. Default "nothing".
    pub(super) outside: Outside,
}

impl Default for GridFile {
    fn default() -> Self {
        GridFile { voxel_size_m: 0.05, bounds_m: None, outside: Outside::Nothing }
    }
}

/// What a ray that leaves the grid hits.
#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub(super) enum Outside {
    Nothing,
    Backdrop,
}

/// A box along the axes of the world.
#[derive(Clone, Copy, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct BoundsFile {
    /// Lowest corner, [x, y, z] in metres.
    #[serde(deserialize_with = "exactly")]
    pub(super) min: [f64; 3],
    /// Highest corner, [x, y, z] in metres.
    #[serde(deserialize_with = "exactly")]
    pub(super) max: [f64; 3],
}

/// A cell.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct SceneEntry {
    /// Its file, from the folder of this one.
    pub(super) file: PathBuf,
    /// Its name in results. Default: the name of the file.
    pub(super) name: Option<String>,
}

/// Sensors that are scored together: every pose of each with every pose of the others.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct CombinationFile {
    /// Its name in results. Default: the names of its sensors, joined.
    pub(super) name: Option<String>,
    /// Names of sensors of the study, each once.
    pub(super) sensors: Vec<String>,
    /// How their evidence becomes one label a voxel. Default: the fusion of the study.
    #[cfg_attr(test, schemars(with = "Option<super::schema::counted::FusionName>"))]
    pub(super) fusion: Option<Fusion>,
    /// Which poses of some sensors take part: patterns with * and ?, as in camera = ["ceiling/*"]. Default
    /// all.
    #[serde(default)]
    pub(super) poses: BTreeMap<String, Vec<String>>,
    /// How many equal ones of some sensors there are, as in camera = 3. No two of them are in the same pose,
    /// and their order does not matter. Default 1.
    #[serde(default)]
    pub(super) count: BTreeMap<String, usize>,
}
