//! The shapes of regions, as TOML: keys, units in their names, and defaults.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Deserialize;

use super::approach::Machine;
use crate::keys::{BoxFile, Unit, UpFile, exactly, exactly_if_given};

/// A region in which voxels are counted: a name and one shape.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
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
    /// What a robot of the scene reaches.
    pub(super) robot_reach: Option<RobotReachFile>,
    /// All that is nearer to the robot than people may be at a speed, by `[stopping]`.
    pub(super) separation: Option<SeparationFile>,
    /// All that the robot or the people fill at some moment of the scene.
    pub(super) swept: Option<SweptFile>,
    /// The inside of a watertight .glb, .gltf, .stl, .obj, .dae or .step file.
    pub(super) mesh: Option<PathBuf>,
    /// The unit of the mesh's numbers. Default "m"; .dae and .step files state their own.
    pub(super) unit: Option<Unit>,
    /// The axis that points up in an .stl, .obj or .step file (default "z"), or in a glTF that is z up against the rules of the
    /// format (default "y").
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
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct SphereFile {
    /// [x, y, z] in metres.
    #[serde(deserialize_with = "exactly")]
    pub(super) center_m: [f64; 3],
    /// In metres, above 0.
    pub(super) radius_m: f64,
}

/// A half of a ball.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
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
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct RobotReachFile {
    /// Its object in the scene; the only robot if left out.
    pub(super) object: Option<String>,
    /// How far a tool reaches beyond its last link. Default 0.
    #[serde(default)]
    pub(super) tool_m: f64,
    /// Whether the region is what the links reach within the limits of the joints, instead of a ball. Default false.
    #[serde(default)]
    pub(super) joint_limits: bool,
    /// Limits of the robot's safety controller for joints that turn, in degrees; others keep those of the URDF.
    #[serde(default)]
    pub(super) limits_deg: BTreeMap<String, [f64; 2]>,
    /// The same for joints that slide, in metres.
    #[serde(default)]
    pub(super) limits_m: BTreeMap<String, [f64; 2]>,
    /// Planes that the robot's safety controller keeps it from passing.
    #[serde(default)]
    pub(super) planes: Vec<SafetyPlaneFile>,
}

/// A plane behind which the robot does not get.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct SafetyPlaneFile {
    /// A point of it, [x, y, z] in metres.
    #[serde(deserialize_with = "exactly")]
    pub(super) point_m: [f64; 3],
    /// The side on which the robot stays, as a direction from the plane.
    #[serde(deserialize_with = "exactly")]
    pub(super) normal: [f64; 3],
}

/// How near to the robot nobody may be at a speed.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct SeparationFile {
    /// From where the distance counts: the robot at each moment, or all that it fills at some moment. Default "robot".
    #[serde(default)]
    pub(super) from: Machine,
    /// One of the speeds of `[stopping]`. Without, each of them makes a region, with its speed in its name: near@0.5.
    pub(super) speed_m_s: Option<f64>,
}

/// What moves.
#[derive(Clone, Copy, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub(super) enum SweptFile {
    Robot,
    Human,
}

/// The box around a person.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
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
