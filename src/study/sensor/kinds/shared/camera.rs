//! The keys of cameras.

use crate::diagnostics::Place;
use crate::sensor::keypoints::TOLERANCE_M;
use crate::sensor::{Camera, MAX_RAYS};
use perirobot_march::Result;

/// The optics of a camera.
pub(crate) fn camera(at: &Place, fov_deg: [f64; 2], resolution_px: [u32; 2]) -> Result<Camera> {
    for angle in fov_deg {
        at.number("fov_deg", angle, 0.001..180.0, "angles from 0.001 and below 180")?;
    }
    let pixels = resolution_px.iter().map(|&n| n as usize).product::<usize>();
    if pixels == 0 || pixels > MAX_RAYS {
        let rule = format!("must be at least 1 each and {MAX_RAYS} pixels together");
        return Err(at.wrong("resolution_px", format!("{resolution_px:?}"), &rule));
    }
    Ok(Camera { fov_rad: fov_deg.map(f64::to_radians), resolution_px })
}

/// The tolerance for a hit near a joint.
pub(crate) fn tolerance(at: &Place, metres: Option<f64>) -> Result<f64> {
    at.number("keypoint_tolerance_m", metres.unwrap_or(TOLERANCE_M), 0.0..=100.0, "a length from 0 to 100 m")
}
