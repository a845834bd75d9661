//! The keys of a robot's proximity cover.

use serde::Deserialize;

use super::range::{NoiseFile, constant};
use crate::diagnostics::Place;
use crate::sensor::cover::Cover;
use perirobot_march::Result;

/// A robot's skin that feels what is near.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct CoverFile {
    /// How far it senses; each is a candidate.
    inflation_m: Vec<f64>,
    /// How far off it feels what is near, on each axis: { std_m }. Default exact.
    noise: Option<NoiseFile>,
}

pub(super) fn check(at: &Place, file: CoverFile, noiseless: bool) -> Result<Cover> {
    at.some("inflation_m", &file.inflation_m, "inflation_m = [0.1, 0.2]")?;
    for (i, &metres) in file.inflation_m.iter().enumerate() {
        at.number("inflation_m", metres, f64::MIN_POSITIVE..=10.0, "lengths above 0 and at most 10 m")?;
        if file.inflation_m[..i].contains(&metres) {
            return Err(at.wrong("inflation_m", metres, "stands twice: name each distance once"));
        }
    }
    let farthest_m = file.inflation_m.iter().copied().fold(0.0, f64::max);
    Ok(Cover { inflation_m: file.inflation_m, noise_std_m: constant(at, file.noise, farthest_m, noiseless)? })
}
