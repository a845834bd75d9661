//! The keys of an RGB camera that watches a zone.

use serde::Deserialize;

use super::Silence;
use super::range::{CalibrationFile, RangeKeys};
use super::rgbd::{camera, tolerance};
use crate::diagnostics::Place;
use crate::keys::{BoxFile, exactly};
use crate::sensor::rgb::Rgb;
use perirobot_march::Result;
use perirobot_scene::scene::keypoints::JOINTS;

/// An RGB camera that watches a zone.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct RgbFile {
    /// Horizontal and vertical angle of view, below 180.
    #[serde(deserialize_with = "exactly")]
    fov_deg: [f64; 2],
    /// Pixels across and down.
    #[serde(deserialize_with = "exactly")]
    resolution_px: [u32; 2],
    /// Nearest and farthest distance that it measures, in metres.
    #[serde(deserialize_with = "exactly")]
    range_m: [f64; 2],
    /// Hits nearer than this are its own housing, in metres. Default 0.
    near_ignore_m: Option<f64>,
    /// How far its mount may be off, drawn anew in each repeat. Default not at all.
    calibration: Option<CalibrationFile>,
    /// The box that it calls occupied while it sees a person, in the world.
    zone: BoxFile,
    /// How many joints of one person it must see. Default 1.
    min_keypoints: Option<u32>,
    /// How far a hit may be from a joint to count as that joint, in metres. Default 0.15.
    keypoint_tolerance_m: Option<f64>,
    /// What it says about the zone while it sees nobody. Default "unknown".
    otherwise: Option<Silence>,
}

pub(super) fn check(at: &Place, file: RgbFile, noiseless: bool) -> Result<Rgb> {
    let range = RangeKeys {
        range_m: file.range_m,
        along: None,
        near_ignore_m: file.near_ignore_m,
        no_return: None,
        noise: None,
        dropout: None,
        calibration: file.calibration,
    };
    let min_keypoints = file.min_keypoints.unwrap_or(1) as usize;
    if !(1..=JOINTS.len()).contains(&min_keypoints) {
        return Err(at.wrong("min_keypoints", min_keypoints, "must be from 1 to 17, COCO's joints"));
    }
    Ok(Rgb {
        camera: camera(at, file.fov_deg, file.resolution_px)?,
        range: range.check(at, noiseless)?,
        zone: file.zone.prism(at, "zone")?,
        min_keypoints,
        keypoint_tolerance_m: tolerance(at, file.keypoint_tolerance_m)?,
        // A blocked view certifies nothing.
        otherwise_free: file.otherwise == Some(Silence::Free),
    })
}
