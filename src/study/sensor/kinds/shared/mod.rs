//! Keys that several kinds of sensor share.

pub(crate) mod camera;
pub(crate) mod camera_info;
pub(crate) mod range;

use serde::Deserialize;

use crate::diagnostics::Place;
use crate::keys::BoxFile;
use crate::sensor::prism::Prism;
use perirobot_march::Result;

/// What a sensor without a return or a detection says about the voxels that it watches.
#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub(crate) enum Silence {
    Unknown,
    Free,
}

/// A box of keys as a volume in the sensor's frame.
pub(crate) fn prism(at: &Place, key: &str, file: &BoxFile) -> Result<Prism> {
    let [min, max] = file.corners(&at.key(key))?;
    Ok(Prism::from_corners(min, max))
}

/// Checks that there are representations, and none twice.
pub(crate) fn each_once<T: PartialEq>(at: &Place, names: &[T], example: &str) -> Result<()> {
    at.some("representations", names, example)?;
    match (0..names.len()).find(|&i| names[..i].contains(&names[i])) {
        Some(i) => {
            Err(at.says(format!("representations[{i}] is there already")).with_advice("name each once"))
        }
        None => Ok(()),
    }
}

/// A length that must be above zero.
pub(crate) fn length(at: &Place, key: &str, metres: f64) -> Result<f64> {
    at.number(key, metres, f64::MIN_POSITIVE..1e6, "a length in metres above 0 and below 1000000")
}
