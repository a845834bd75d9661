//! Candidate poses as the user writes them.

use std::path::PathBuf;

use serde::Deserialize;

use super::surface::SurfaceFile;
use crate::keys::{AxisValues, QuaternionKeys, exactly, exactly_if_given};
use perirobot_scene::pose::RotationFrame;

/// Candidate poses: a lattice (x_m, y_m, z_m), an object's surface, a list, a table (csv), or random ones.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct PosesFile {
    /// First part of the names of its poses.
    pub(crate) name: String,
    /// A number, a list, or { start, stop, step }.
    pub(crate) x_m: Option<AxisValues>,
    /// A number, a list, or { start, stop, step }.
    pub(crate) y_m: Option<AxisValues>,
    /// A number, a list, or { start, stop, step }.
    pub(crate) z_m: Option<AxisValues>,
    /// On the surface of an object of the scenes.
    pub(crate) surface: Option<SurfaceFile>,
    /// Where the sensors look: a direction, as [0, 1, 0]. Default, on a surface, straight away from it.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub(crate) facing: Option<[f64; 3]>,
    /// Turned from there, at each point of the lattice or the surface. Default straight.
    pub(crate) orientations_deg: Option<Vec<PanTilt>>,
    /// Poses one by one.
    pub(crate) list: Option<Vec<PoseFile>>,
    /// A table with the columns x_m,y_m,z_m,qw,qx,qy,qz and, optional, sensor and pose.
    pub(crate) csv: Option<PathBuf>,
    /// What the quaternions of the table turn. Default "link".
    pub(crate) frame: Option<RotationFrame>,
    /// Poses drawn from a box.
    pub(crate) random: Option<RandomFile>,
}

/// A turn from where a sensor faces.
#[derive(Clone, Copy, Default, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub(crate) struct PanTilt {
    /// About the vertical, to the left, in degrees.
    pub(crate) pan: f64,
    /// Upwards, in degrees.
    pub(crate) tilt: f64,
}

/// One pose: facing (with pan and tilt), rpy_deg, or quaternion.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct PoseFile {
    /// Last part of its name. Default: its number.
    pub(crate) name: Option<String>,
    /// [x, y, z] in metres.
    #[serde(deserialize_with = "exactly")]
    pub(crate) position_m: [f64; 3],
    /// Where the sensor looks: a direction.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub(crate) facing: Option<[f64; 3]>,
    /// Turned to the left from there.
    pub(crate) pan_deg: Option<f64>,
    /// Turned upwards from there.
    pub(crate) tilt_deg: Option<f64>,
    /// Roll, pitch, yaw in degrees.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub(crate) rpy_deg: Option<[f64; 3]>,
    /// A rotation.
    pub(crate) quaternion: Option<QuaternionKeys>,
    /// What rpy_deg or quaternion turn. Default "link".
    pub(crate) frame: Option<RotationFrame>,
}

/// Poses drawn from a box.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct RandomFile {
    /// How many.
    pub(crate) count: u32,
    /// Lowest corner, [x, y, z] in metres.
    #[serde(deserialize_with = "exactly")]
    pub(crate) min_m: [f64; 3],
    /// Highest corner, [x, y, z] in metres.
    #[serde(deserialize_with = "exactly")]
    pub(crate) max_m: [f64; 3],
    /// [from, to]. Default straight.
    #[serde(default, deserialize_with = "exactly")]
    pub(crate) pan_deg: [f64; 2],
    /// [from, to]. Default straight.
    #[serde(default, deserialize_with = "exactly")]
    pub(crate) tilt_deg: [f64; 2],
}
