//! The keys that all sensors which measure distances share.

use super::Silence;
use crate::Result;
use crate::sensor::range::Range;
use crate::study::Place;

/// Their values, as each kind reads them.
pub(super) struct RangeKeys {
    pub(super) range_m: [f64; 2],
    pub(super) near_ignore_m: Option<f64>,
    pub(super) no_return: Option<Silence>,
    pub(super) noise_std_m: Option<f64>,
}

impl RangeKeys {
    pub(super) fn check(self, at: &Place, noiseless: bool) -> Result<Range> {
        let [near, far] = self.range_m;
        if !(near >= 0.0 && near < far && far < 1e6) {
            let rule = "must be [nearest, farthest] in metres, 0 <= nearest < farthest < 1000000";
            return Err(at.wrong("range_m", format!("{:?}", self.range_m), rule));
        }
        let near_ignore_m = self.near_ignore_m.unwrap_or(0.0);
        at.number("near_ignore_m", near_ignore_m, 0.0..far, "a distance from 0 to the sensor's range")?;
        Ok(Range {
            range_m: self.range_m,
            near_ignore_m,
            no_return_is_free: self.no_return == Some(Silence::Free),
            noise_std_m: noise(at, self.noise_std_m, far, noiseless)?,
        })
    }
}

/// A standard deviation; checked even where noise is switched off.
pub(super) fn noise(at: &Place, std_m: Option<f64>, most_m: f64, noiseless: bool) -> Result<f64> {
    let rule = format!("a length in metres from 0 to {most_m}, how far the sensor measures");
    let std_m = at.number("noise_std_m", std_m.unwrap_or(0.0), 0.0..=most_m, &rule)?;
    Ok(if noiseless { 0.0 } else { std_m })
}
