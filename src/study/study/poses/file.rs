//! Candidate poses as the user writes them.

use std::path::PathBuf;

use serde::Deserialize;

use crate::study::value::{Axis, exactly, exactly_if_given};
use perirobot_scene::pose::Frame;

/// Candidate poses: a lattice (x_m, y_m, z_m), a list, a table (csv), or random ones.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(in crate::study) struct PosesFile {
    /// First part of the names of its poses.
    pub(in crate::study) name: String,
    /// A number, a list, or { start, stop, step }.
    pub(in crate::study) x_m: Option<Axis>,
    /// A number, a list, or { start, stop, step }.
    pub(in crate::study) y_m: Option<Axis>,
    /// A number, a list, or { start, stop, step }.
    pub(in crate::study) z_m: Option<Axis>,
    /// Where the sensors look: a direction, as [0, 1, 0].
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub(in crate::study) facing: Option<[f64; 3]>,
    /// Turned from there, at each point of the lattice. Default straight.
    pub(in crate::study) orientations_deg: Option<Vec<PanTilt>>,
    /// Poses one by one.
    pub(in crate::study) list: Option<Vec<PoseFile>>,
    /// A table with the columns x_m,y_m,z_m,qw,qx,qy,qz and, optional, sensor and pose.
    pub(in crate::study) csv: Option<PathBuf>,
    /// What the quaternions of the table turn. Default "link".
    pub(in crate::study) frame: Option<Frame>,
    /// Poses drawn from a box.
    pub(in crate::study) random: Option<RandomFile>,
}

/// A turn from where a sensor faces.
#[derive(Clone, Copy, Default, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, default)]
pub(in crate::study) struct PanTilt {
    /// About the vertical, to the left, in degrees.
    pub(in crate::study) pan: f64,
    /// Upwards, in degrees.
    pub(in crate::study) tilt: f64,
}

/// One pose: facing (with pan and tilt), rpy_deg, or quaternion.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(in crate::study) struct PoseFile {
    /// Last part of its name. Default: its number.
    pub(in crate::study) name: Option<String>,
    /// [x, y, z] in metres.
    #[serde(deserialize_with = "exactly")]
    pub(in crate::study) position_m: [f64; 3],
    /// Where the sensor looks: a direction.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub(in crate::study) facing: Option<[f64; 3]>,
    /// Turned to the left from there.
    pub(in crate::study) pan_deg: Option<f64>,
    /// Turned upwards from there.
    pub(in crate::study) tilt_deg: Option<f64>,
    /// Roll, pitch, yaw in degrees.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub(in crate::study) rpy_deg: Option<[f64; 3]>,
    /// A rotation.
    pub(in crate::study) quaternion: Option<Quaternion>,
    /// What rpy_deg or quaternion turn. Default "link".
    pub(in crate::study) frame: Option<Frame>,
}

/// A rotation; its length is 1.
#[derive(Clone, Copy)]
#[cfg_attr(test, derive(schemars::JsonSchema), schemars(deny_unknown_fields))]
pub(in crate::study) struct Quaternion {
    pub(in crate::study) w: f64,
    pub(in crate::study) x: f64,
    pub(in crate::study) y: f64,
    pub(in crate::study) z: f64,
}

/// Poses drawn from a box.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(in crate::study) struct RandomFile {
    /// How many.
    pub(in crate::study) count: u32,
    /// Lowest corner, [x, y, z] in metres.
    #[serde(deserialize_with = "exactly")]
    pub(in crate::study) min_m: [f64; 3],
    /// Highest corner, [x, y, z] in metres.
    #[serde(deserialize_with = "exactly")]
    pub(in crate::study) max_m: [f64; 3],
    /// [from, to]. Default straight.
    #[serde(default, deserialize_with = "exactly")]
    pub(in crate::study) pan_deg: [f64; 2],
    /// [from, to]. Default straight.
    #[serde(default, deserialize_with = "exactly")]
    pub(in crate::study) tilt_deg: [f64; 2],
}
