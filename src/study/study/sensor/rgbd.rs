//! The keys of an RGB-D camera, and of cameras at large.

use serde::Deserialize;

use super::range::{CalibrationFile, NoiseFile, RangeKeys};
use super::{MAX_RAYS, Silence, each_once, length};
use crate::diagnostics::Place;
use crate::keys::exactly;
use crate::sensor::Camera;
use crate::sensor::keypoints::TOLERANCE_M;
use crate::sensor::range::Along;
use crate::sensor::rgbd::{KeypointShape, Rgbd};
use perirobot_march::{Error, Result};

/// Radii that the paper's code has at voxels of 5 cm, in metres.
const SPHERES_RADIUS_M: f64 = 0.20;
const CYLINDERS_RADIUS_M: f64 = 0.25;

/// An RGB-D camera.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct RgbdFile {
    /// Horizontal and vertical angle of view, below 180.
    #[serde(deserialize_with = "exactly")]
    fov_deg: [f64; 2],
    /// Pixels across and down.
    #[serde(deserialize_with = "exactly")]
    resolution_px: [u32; 2],
    /// Nearest and farthest distance that it measures, in metres.
    #[serde(deserialize_with = "exactly")]
    range_m: [f64; 2],
    /// What range_m and noise are measured along: "ray", the distance, or "axis", the depth, as most data sheets have it. Default
    /// "ray".
    range_along: Option<Along>,
    /// Hits nearer than this are its own housing, in metres. Default 0.
    near_ignore_m: Option<f64>,
    /// What a ray that hits nothing says about the voxels that it passed. Default "unknown".
    no_return: Option<Silence>,
    /// Noise of measured distances. Default none.
    noise: Option<NoiseFile>,
    /// Share of returns that is lost, from 0 to below 1. Default 0.
    dropout: Option<f64>,
    /// How far its mount may be off, drawn anew in each repeat. Default not at all.
    calibration: Option<CalibrationFile>,
    /// The representations that are scored, each separately. Default ["points"].
    representations: Option<Vec<ShapeName>>,
    /// Radius of the spheres around joints, in metres. Default 0.2.
    spheres_radius_m: Option<f64>,
    /// Radius of the cylinders between joints, in metres. Default 0.25.
    cylinders_radius_m: Option<f64>,
    /// How far a hit may be from a joint to count as that joint, in metres. Default 0.15.
    keypoint_tolerance_m: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
enum ShapeName {
    Points,
    Spheres,
    Cylinders,
    Box,
}

pub(super) fn check(at: &Place, file: RgbdFile, noiseless: bool) -> Result<Rgbd> {
    let range = RangeKeys {
        range_m: file.range_m,
        along: file.range_along,
        near_ignore_m: file.near_ignore_m,
        no_return: file.no_return,
        noise: file.noise,
        dropout: file.dropout,
        calibration: file.calibration,
    };
    let names = file.representations.unwrap_or_else(|| vec![ShapeName::Points]);
    each_once(at, &names, "representations = [\"points\", \"cylinders\"]")?;
    let spheres = length(at, "spheres_radius_m", file.spheres_radius_m.unwrap_or(SPHERES_RADIUS_M))?;
    let cylinders = length(at, "cylinders_radius_m", file.cylinders_radius_m.unwrap_or(CYLINDERS_RADIUS_M))?;
    let shape = |name| match name {
        ShapeName::Points => KeypointShape::Points,
        ShapeName::Spheres => KeypointShape::Spheres { radius_m: spheres },
        ShapeName::Cylinders => KeypointShape::Cylinders { radius_m: cylinders },
        ShapeName::Box => KeypointShape::Box,
    };
    Ok(Rgbd {
        camera: camera(at, file.fov_deg, file.resolution_px)?,
        range: range.check(at, noiseless)?,
        shapes: names.into_iter().map(shape).collect(),
        keypoint_tolerance_m: tolerance(at, file.keypoint_tolerance_m)?,
    })
}

/// The optics of a camera.
pub(super) fn camera(at: &Place, fov_deg: [f64; 2], resolution_px: [u32; 2]) -> Result<Camera> {
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
pub(super) fn tolerance(at: &Place, metres: Option<f64>) -> Result<f64, Error> {
    at.number("keypoint_tolerance_m", metres.unwrap_or(TOLERANCE_M), 0.0..=100.0, "a length from 0 to 100 m")
}
