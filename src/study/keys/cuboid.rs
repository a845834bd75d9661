//! A box by its corners.

use glam::DVec3;
use serde::Deserialize;

use super::exactly;
use crate::diagnostics::Place;
use perirobot_march::Result;

/// A box along the axes of the world or of a sensor.
#[derive(Clone, Copy, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct BoxFile {
    /// Lowest corner, [x, y, z] in metres.
    #[serde(deserialize_with = "exactly")]
    min_m: [f64; 3],
    /// Highest corner, [x, y, z] in metres.
    #[serde(deserialize_with = "exactly")]
    max_m: [f64; 3],
}

impl BoxFile {
    /// Its corners, the lowest first.
    pub(crate) fn corners(&self, at: &Place) -> Result<[DVec3; 2]> {
        let (min, max) = (at.vector("min_m", self.min_m)?, at.vector("max_m", self.max_m)?);
        match min.cmplt(max).all() {
            true => Ok([min, max]),
            false => Err(at.wrong("max_m", format!("{:?}", self.max_m), "must be above min_m on every axis")),
        }
    }
}
