//! `[mounting_error]`: how far mounts may be from where they are planned.

use std::ops::RangeInclusive;

use serde::Deserialize;

use crate::diagnostics::Place;
use crate::sensor::Calibration;
use perirobot_march::Result;

/// How many draws of mounts there may be.
const DRAWS: RangeInclusive<u32> = 1..=10_000;

/// How far mounts may be from where they are planned, for requirements under "mounting_error".
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct MountingErrorFile {
    /// How many times the mounts of all sensors are drawn, at most 10000.
    draws: u32,
    /// Seed of the draws. Default 0.
    #[serde(default)]
    #[cfg_attr(test, schemars(range(max = i64::MAX)))]
    seed: u64,
    /// Standard deviation of the position along each of a sensor's own axes, in metres. Default 0.
    #[serde(default)]
    position_m: f64,
    /// Standard deviation of the rotation about each of them, in degrees. Default 0.
    #[serde(default)]
    angle_deg: f64,
}

/// How far mounts may be from where they are planned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MountingError {
    /// How many times they are drawn.
    pub draws: u32,
    /// Seed of the draws.
    pub seed: u64,
    /// Standard deviations.
    pub off: Calibration,
}

impl MountingErrorFile {
    pub(crate) fn check(self, at: &Place) -> Result<MountingError> {
        let at = at.key("mounting_error");
        let MountingErrorFile { draws, seed, position_m, angle_deg } = self;
        if !DRAWS.contains(&draws) {
            let rule = format!("must be from {} to {}", DRAWS.start(), DRAWS.end());
            return Err(at.wrong("draws", draws, &rule));
        }
        at.number("position_m", position_m, 0.0..=1.0, "a standard deviation in metres, from 0 to 1")?;
        at.number("angle_deg", angle_deg, 0.0..=30.0, "a standard deviation in degrees, from 0 to 30")?;
        if position_m == 0.0 && angle_deg == 0.0 {
            let example = "as in position_m = 0.01 and angle_deg = 0.5";
            return Err(at.says(format!("give position_m, angle_deg or both, above 0, {example}")));
        }
        Ok(MountingError { draws, seed, off: Calibration { position_m, angle_rad: angle_deg.to_radians() } })
    }
}
