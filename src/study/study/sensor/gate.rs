//! The keys of a light curtain.

use serde::Deserialize;

use super::Silence;
use crate::diagnostics::Place;
use crate::keys::BoxFile;
use crate::sensor::gate::Gate;
use perirobot_march::Result;

/// A light curtain.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct GateFile {
    /// Where it senses.
    r#box: BoxFile,
    /// What is occupied while something is in the box.
    zone: BoxFile,
    /// What an idle curtain says of the zone. Default "unknown".
    otherwise: Option<Silence>,
}

pub(super) fn check(at: &Place, file: GateFile) -> Result<Gate> {
    Ok(Gate {
        gate: file.r#box.prism(at, "box")?,
        zone: file.zone.prism(at, "zone")?,
        // An uncrossed curtain does not show that nobody stepped over it.
        otherwise_free: file.otherwise == Some(Silence::Free),
    })
}
