//! The study file, as TOML: keys, units in their names, and defaults. Only spelling and type are checked
//! here.

use std::collections::BTreeMap;
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Deserialize;

use super::choose::ChooseFile;
use super::sensor::AnySensor;
use super::value::{Unit, UpFile, exactly, exactly_if_given};
use crate::backend::Fusion;

/// A study: what is placed where, in which cells.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct StudyFile {
    /// Seed of all noise and of random poses. Default 0.
    #[serde(default)]
    pub(super) seed: u64,
    /// How the evidence of a combination's sensors becomes one label a voxel, unless the combination has its
    /// own rule. Default "occupied_wins".
    #[serde(default)]
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
    /// The voxels.
    #[serde(default)]
    pub(super) grid: GridFile,
    /// The cells that are swept, at least one.
    #[serde(default)]
    pub(super) scene: Vec<SceneEntry>,
    /// The regions in which voxels are counted, at least one.
    #[serde(default)]
    pub(super) region: Vec<RegionFile>,
    /// The sensors to be placed, at least one.
    #[serde(default)]
    #[schemars(with = "Vec<AnySensor>")]
    pub(super) sensor: Vec<toml::Table>,
    /// Sensors that are scored together; each alone if there is none.
    #[serde(default)]
    pub(super) combination: Vec<CombinationFile>,
    /// What `perirobot choose` looks for: the best set of sensors.
    pub(super) choose: Option<ChooseFile>,
}

fn once() -> u32 {
    1
}

fn three() -> u32 {
    3
}

/// The voxels.
#[derive(Deserialize, JsonSchema)]
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
#[derive(Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub(super) enum Outside {
    Nothing,
    Backdrop,
}

/// A box along the axes of the world.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
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
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneEntry {
    /// Its file, from the folder of this one.
    pub(super) file: PathBuf,
    /// Its name in results. Default: the name of the file.
    pub(super) name: Option<String>,
}

/// A region in which voxels are counted: a name and one shape.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RegionFile {
    /// Its name in results.
    pub(super) name: String,
    /// A ball.
    pub(super) sphere: Option<SphereFile>,
    /// A half of a ball.
    pub(super) half_sphere: Option<HalfSphereFile>,
    /// A box along the axes of the world.
    pub(super) r#box: Option<BoxFile>,
    /// The box around a person.
    pub(super) human_box: Option<HumanBoxFile>,
    /// The ball that a robot of the scene reaches.
    pub(super) robot_reach: Option<RobotReachFile>,
    /// The inside of a watertight .glb, .gltf, .stl, .obj or .dae file.
    pub(super) mesh: Option<PathBuf>,
    /// The unit of the mesh's numbers. Default "m"; a .dae file states its own.
    pub(super) unit: Option<Unit>,
    /// The axis that points up in an .stl or .obj file. Default "z".
    pub(super) up: Option<UpFile>,
    /// Where the mesh is, [x, y, z] in metres. Default the origin.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub(super) position_m: Option<[f64; 3]>,
    /// How the mesh is turned: roll, pitch, yaw in degrees.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub(super) rpy_deg: Option<[f64; 3]>,
    /// Names of regions above: what is in any of them.
    pub(super) union: Option<Vec<String>>,
    /// Names of regions above: what is in the first and in no other.
    pub(super) difference: Option<Vec<String>>,
}

/// A ball.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct SphereFile {
    /// [x, y, z] in metres.
    #[serde(deserialize_with = "exactly")]
    pub(super) center_m: [f64; 3],
    /// In metres, above 0.
    pub(super) radius_m: f64,
}

/// A half of a ball.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct HalfSphereFile {
    /// [x, y, z] in metres.
    #[serde(deserialize_with = "exactly")]
    pub(super) center_m: [f64; 3],
    /// In metres, above 0.
    pub(super) radius_m: f64,
    /// Which half: the side that this direction points to. Default up.
    #[serde(default = "upward", deserialize_with = "exactly")]
    pub(super) normal: [f64; 3],
}

fn upward() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

/// What a robot reaches.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RobotReachFile {
    /// Its object in the scene; the only robot if left out.
    pub(super) object: Option<String>,
    /// How far a tool reaches beyond its last link. Default 0.
    #[serde(default)]
    pub(super) tool_m: f64,
}

/// A box along the axes of the world or of a sensor.
#[derive(Clone, Copy, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct BoxFile {
    /// Lowest corner, [x, y, z] in metres.
    #[serde(deserialize_with = "exactly")]
    pub(super) min_m: [f64; 3],
    /// Highest corner, [x, y, z] in metres.
    #[serde(deserialize_with = "exactly")]
    pub(super) max_m: [f64; 3],
}

/// The box around a person.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct HumanBoxFile {
    /// Its object in the scene; the only person if left out.
    pub(super) object: Option<String>,
    /// Added on all sides. Default 0.
    pub(super) margin_m: Option<f64>,
    /// Added below on x, y and z, instead of margin_m.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub(super) margin_min_m: Option<[f64; 3]>,
    /// Added above on x, y and z, instead of margin_m.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub(super) margin_max_m: Option<[f64; 3]>,
}

/// Sensors that are scored together: every pose of each with every pose of the others.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct CombinationFile {
    /// Its name in results. Default: the names of its sensors, joined.
    pub(super) name: Option<String>,
    /// Names of sensors of the study, each once.
    pub(super) sensors: Vec<String>,
    /// How their evidence becomes one label a voxel. Default: the fusion of the study.
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
