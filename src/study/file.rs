//! The study file, as TOML: keys, units in their names, and defaults. Nothing is checked here but spelling and type.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Deserialize;

use super::scene_file::{Unit, Up};
use super::value::{Axis, exactly, exactly_if_given};
use crate::backend::Fusion;
use crate::sensor::pose::Frame;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StudyFile {
    #[serde(default)]
    pub(super) seed: u64,
    #[serde(default)]
    pub(super) fusion: Fusion,
    #[serde(default = "once")]
    pub(super) repeats: u32,
    #[serde(default)]
    pub(super) grid: GridFile,
    #[serde(default)]
    pub(super) scene: Vec<SceneEntry>,
    #[serde(default)]
    pub(super) region: Vec<RegionFile>,
    #[serde(default)]
    pub(super) sensor: Vec<toml::Table>,
    #[serde(default)]
    pub(super) combination: Vec<CombinationFile>,
}

fn once() -> u32 {
    1
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct GridFile {
    pub(super) voxel_size_m: f64,
    pub(super) bounds_m: Option<BoundsFile>,
    pub(super) outside: Outside,
}

impl Default for GridFile {
    fn default() -> Self {
        GridFile { voxel_size_m: 0.05, bounds_m: None, outside: Outside::Nothing }
    }
}

/// What a ray meets that leaves the grid.
#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Outside {
    Nothing,
    Backdrop,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BoundsFile {
    #[serde(deserialize_with = "exactly")]
    pub(super) min: [f64; 3],
    #[serde(deserialize_with = "exactly")]
    pub(super) max: [f64; 3],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SceneEntry {
    pub(super) file: PathBuf,
    pub(super) name: Option<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RegionFile {
    pub(super) name: String,
    pub(super) sphere: Option<SphereFile>,
    pub(super) half_sphere: Option<HalfSphereFile>,
    pub(super) r#box: Option<BoxFile>,
    pub(super) human_box: Option<HumanBoxFile>,
    pub(super) robot_reach: Option<RobotReachFile>,
    pub(super) mesh: Option<PathBuf>,
    pub(super) unit: Option<Unit>,
    pub(super) up: Option<Up>,
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub(super) position_m: Option<[f64; 3]>,
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub(super) rpy_deg: Option<[f64; 3]>,
    pub(super) union: Option<Vec<String>>,
    pub(super) difference: Option<Vec<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SphereFile {
    #[serde(deserialize_with = "exactly")]
    pub(super) center_m: [f64; 3],
    pub(super) radius_m: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HalfSphereFile {
    #[serde(deserialize_with = "exactly")]
    pub(super) center_m: [f64; 3],
    pub(super) radius_m: f64,
    #[serde(default = "upward", deserialize_with = "exactly")]
    pub(super) normal: [f64; 3],
}

fn upward() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RobotReachFile {
    pub(super) object: Option<String>,
    #[serde(default)]
    pub(super) tool_m: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BoxFile {
    #[serde(deserialize_with = "exactly")]
    pub(super) min_m: [f64; 3],
    #[serde(deserialize_with = "exactly")]
    pub(super) max_m: [f64; 3],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HumanBoxFile {
    pub(super) object: Option<String>,
    pub(super) margin_m: Option<f64>,
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub(super) margin_min_m: Option<[f64; 3]>,
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub(super) margin_max_m: Option<[f64; 3]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CombinationFile {
    pub(super) name: Option<String>,
    pub(super) sensors: Vec<String>,
    pub(super) fusion: Option<Fusion>,
    #[serde(default)]
    pub(super) poses: BTreeMap<String, Vec<String>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PosesFile {
    pub(super) name: String,
    pub(super) x_m: Option<Axis>,
    pub(super) y_m: Option<Axis>,
    pub(super) z_m: Option<Axis>,
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub(super) facing: Option<[f64; 3]>,
    pub(super) orientations_deg: Option<Vec<PanTilt>>,
    pub(super) list: Option<Vec<PoseFile>>,
    pub(super) csv: Option<PathBuf>,
    pub(super) frame: Option<Frame>,
    pub(super) random: Option<RandomFile>,
}

#[derive(Clone, Copy, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct PanTilt {
    pub(super) pan: f64,
    pub(super) tilt: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PoseFile {
    pub(super) name: Option<String>,
    #[serde(deserialize_with = "exactly")]
    pub(super) position_m: [f64; 3],
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub(super) facing: Option<[f64; 3]>,
    pub(super) pan_deg: Option<f64>,
    pub(super) tilt_deg: Option<f64>,
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub(super) rpy_deg: Option<[f64; 3]>,
    pub(super) quaternion: Option<Quaternion>,
    pub(super) frame: Option<Frame>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Quaternion {
    pub(super) w: f64,
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) z: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RandomFile {
    pub(super) count: u32,
    #[serde(deserialize_with = "exactly")]
    pub(super) min_m: [f64; 3],
    #[serde(deserialize_with = "exactly")]
    pub(super) max_m: [f64; 3],
    #[serde(default, deserialize_with = "exactly")]
    pub(super) pan_deg: [f64; 2],
    #[serde(default, deserialize_with = "exactly")]
    pub(super) tilt_deg: [f64; 2],
}
