//! The keys of a pressure pad.

use glam::DVec3;
use serde::Deserialize;

use super::{Silence, length};
use crate::diagnostics::Place;
use crate::keys::exactly;
use crate::sensor::pad::Pad;
use crate::sensor::prism::Prism;
use perirobot_march::Result;

/// The height of the column that a pad labels: a person with an arm raised.
const HEIGHT_M: f64 = 2.2;

/// A pressure pad.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct PadFile {
    /// Along and across where it faces, in metres.
    #[serde(deserialize_with = "exactly")]
    size_m: [f64; 2],
    /// Height of the column above it that it labels, in metres. Default 2.2.
    height_m: Option<f64>,
    /// Whether objects that always stand on it were zeroed at set-up. Default true.
    tare: Option<bool>,
    /// What an idle pad says about the column. Default "free".
    otherwise: Option<Silence>,
}

pub(super) fn check(at: &Place, file: PadFile) -> Result<Pad> {
    let [width_m, depth_m] = file.size_m;
    for size_m in file.size_m {
        length(at, "size_m", size_m)?;
    }
    let height_m = length(at, "height_m", file.height_m.unwrap_or(HEIGHT_M))?;
    Ok(Pad {
        column: Prism::between(DVec3::ZERO, DVec3::new(width_m, depth_m, height_m)),
        tare: file.tare.unwrap_or(true),
        otherwise_free: file.otherwise != Some(Silence::Unknown),
    })
}
