//! The keys of a LIDAR or safety scanner.

use glam::DVec2;
use serde::Deserialize;

use super::range::{CalibrationFile, NoiseFile, RangeKeys};
use super::{MAX_RAYS, Silence, each_once, length};
use crate::diagnostics::Place;
use crate::keys::{OneOrTwo, exactly, exactly_if_given};
use crate::sensor::lidar::{self, ProtectiveField};
use crate::sensor::prism::Prism;
use crate::sensor::{Lidar, LidarMount};
use perirobot_march::error::Issue;
use perirobot_march::voxel::solid::is_simple;
use perirobot_march::{Error, Result};

/// How many rings devices have, and the widest step between them, in degrees.
const DEVICE_RINGS: [f64; 4] = [16.0, 32.0, 64.0, 128.0];
const WIDEST_STEP_DEG: f64 = 2.0;
/// Most corners of a field; scanners allow some dozens.
const MAX_CORNERS: usize = 1000;

/// A LIDAR, or a safety scanner.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct LidarFile {
    /// Angle about its axis, or [about its axis, vertical]. Default 360.
    fov_deg: Option<OneOrTwo>,
    /// Step between rays: one number, or [about its axis, vertical]. Angles go from the first on in these steps; the last angle
    /// of an interval is left out. `beams` and `rings` give both ends instead.
    resolution_deg: Option<OneOrTwo>,
    /// How many rays about its axis, spread evenly over fov_deg, both ends included; a full turn counts its end, which is its
    /// start, once. Instead of the step about the axis.
    beams: Option<u32>,
    /// [from, to] above the plane of its rings, in steps of resolution_deg without `to`, or as many rings as `rings` says with
    /// both ends.
    #[serde(default, deserialize_with = "exactly_if_given")]
    elevation_deg: Option<[f64; 2]>,
    /// How many rings, spread evenly over elevation_deg or the vertical angle of fov_deg, both ends included. Instead of
    /// the vertical step.
    rings: Option<u32>,
    /// Elevation of each ring.
    rings_deg: Option<Vec<f64>>,
    /// Default "upright".
    mount: Option<LidarMount>,
    /// Nearest and farthest distance that it measures, in metres.
    #[serde(deserialize_with = "exactly")]
    range_m: [f64; 2],
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
    /// The representations that are scored, each separately. Default ["field"] where there is one, else
    /// ["points"].
    representations: Option<Vec<Representation>>,
    /// Makes it a switch: a return in this field makes the volume above it occupied.
    field: Option<FieldFile>,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
enum Representation {
    Points,
    Field,
}

/// A protective field.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct FieldFile {
    /// Corners [x, y] in metres, x ahead and y left; its sides must not cross.
    polygon_m: Vec<[f64; 2]>,
    /// Height of the volume above it, in metres.
    height_m: f64,
    /// What a field without returns says about its volume. Default "free".
    otherwise: Option<Silence>,
}

pub(super) fn check(at: &Place, file: LidarFile, noiseless: bool) -> Result<Lidar> {
    if let Some(OneOrTwo { horizontal, vertical }) = file.resolution_deg {
        for angle in [Some(horizontal), vertical].into_iter().flatten() {
            at.number("resolution_deg", angle, 1e-3..=360.0, "angles from 0.001 to 360")?;
        }
    }
    let span = file.fov_deg.map_or(360.0, |fov| fov.horizontal);
    at.number("fov_deg", span, f64::MIN_POSITIVE..=360.0, "above 0 and at most 360 around the spin axis")?;
    let azimuths = azimuths(at, &file, span)?;
    let elevations = elevations(at, &file)?;
    let rays = azimuths.len().saturating_mul(elevations.len());
    if rays == 0 || rays > MAX_RAYS {
        let rule = format!("from 1 to {MAX_RAYS} are possible");
        return Err(match file.resolution_deg {
            Some(step) => at.wrong(
                "resolution_deg",
                step.horizontal,
                &format!("gives {rays} rays, {rule}: write a larger step"),
            ),
            None => at.says(format!("has {rays} rays")).wanted(rule + ": write fewer beams and rings"),
        });
    }
    let range = RangeKeys {
        range_m: file.range_m,
        along: None,
        near_ignore_m: file.near_ignore_m,
        no_return: file.no_return,
        noise: file.noise,
        dropout: file.dropout,
        calibration: file.calibration,
    };
    // If there is a field, it is scored and the points are not, unless both are listed.
    let usual = if file.field.is_some() { Representation::Field } else { Representation::Points };
    let scored = file.representations.unwrap_or_else(|| vec![usual]);
    each_once(at, &scored, "representations = [\"points\"]")?;
    let field = file.field.map(|field| field.check(&at.key("field"))).transpose()?;
    let scores_field = scored.contains(&Representation::Field);
    if scores_field && field.is_none() {
        return Err(at.says("representation \"field\" needs field = { polygon_m = [[x, y], ...], height_m }"));
    }
    if field.is_some() && !scores_field {
        return Err(at
            .says("field is given and not among the representations")
            .wanted("add \"field\", or take it away"));
    }
    Ok(Lidar {
        azimuths_rad: azimuths.into_iter().map(f64::to_radians).collect(),
        elevations_rad: elevations.into_iter().map(f64::to_radians).collect(),
        mount: file.mount.unwrap_or(LidarMount::Upright),
        range: range.check(at, noiseless)?,
        points: scored.contains(&Representation::Points),
        field,
    })
}

impl FieldFile {
    fn check(self, at: &Place) -> Result<ProtectiveField> {
        let height_m = length(at, "height_m", self.height_m)?;
        let corners = self.polygon_m.len();
        if corners > MAX_CORNERS {
            return Err(at.wrong(
                "polygon_m",
                format!("({corners} corners)"),
                &format!("must have at most {MAX_CORNERS}"),
            ));
        }
        let reach = "must be [x, y] in metres within 1000 of the scanner";
        if let Some(corner) = self.polygon_m.iter().flatten().find(|value| !(-1e3..=1e3).contains(*value)) {
            return Err(at.wrong("polygon_m", corner, reach));
        }
        // Sides are tested in hundredths of a millimetre, independent of the voxel size.
        let fine = |value: f64| (value * 1e5).round() as i64;
        let corners: Vec<_> = self.polygon_m.iter().map(|corner| corner.map(fine)).collect();
        is_simple(&corners).map_err(|e| at.around(Issue::says(e.to_string()).at("polygon_m")))?;
        let polygon_m = self.polygon_m.into_iter().map(DVec2::from_array).collect();
        let volume = Prism { polygon_m, z_m: [0.0, height_m] };
        Ok(ProtectiveField { volume, otherwise_free: self.otherwise != Some(Silence::Unknown) })
    }
}

/// Azimuths in degrees, by number or by step.
fn azimuths(at: &Place, entry: &LidarFile, span: f64) -> Result<Vec<f64>> {
    match (entry.beams, entry.resolution_deg) {
        (Some(beams), None) if span == 360.0 => {
            number(at, "beams", beams, 1)?;
            Ok(lidar::angles(-180.0, 360.0, 360.0 / f64::from(beams)))
        }
        (Some(beams), None) => {
            number(at, "beams", beams, 2)?;
            Ok(lidar::spread(-span / 2.0, span, beams))
        }
        (None, Some(step)) => Ok(lidar::angles(-span / 2.0, span, step.horizontal)),
        (Some(beams), Some(_)) => {
            let rule = "and resolution_deg: give one of them; with beams, rings gives the number of rings";
            Err(at.wrong("beams", beams, rule))
        }
        (None, None) => Err(at.says("neither resolution_deg nor beams").wanted(
            "give the step between rays, as in resolution_deg = 0.5, or their number with both ends, as in beams = 1081",
        )),
    }
}

/// Angles from one to another in degrees, by number or by step.
fn rings(at: &Place, entry: &LidarFile, [from, to]: [f64; 2]) -> Result<Vec<f64>> {
    let step = entry.resolution_deg.map(|step| (step.horizontal, step.vertical));
    match (entry.rings, step) {
        (Some(rings), Some((_, Some(_)))) => {
            let rule = "and a vertical resolution_deg: give one of them";
            Err(at.wrong("rings", rings, rule))
        }
        (Some(rings), _) => {
            number(at, "rings", rings, 2)?;
            Ok(lidar::spread(from, to - from, rings))
        }
        (None, Some((horizontal, vertical))) => {
            Ok(lidar::angles(from, to - from, vertical.unwrap_or(horizontal)))
        }
        (None, None) => Err(at
            .says("neither rings nor a vertical step")
            .wanted("give the number of rings with both ends, as in rings = 16, or rings_deg")),
    }
}

/// Checks how many angles are spread over an interval.
fn number(at: &Place, key: &str, count: u32, least: u32) -> Result<()> {
    match (least..=MAX_RAYS as u32).contains(&count) {
        true => Ok(()),
        false => Err(at.wrong(key, count, &format!("must be from {least} to {MAX_RAYS}"))),
    }
}

/// Warns of an interval whose end lies on a step, and is left out.
pub(super) fn left_out(file: &LidarFile) -> Vec<String> {
    let mut warnings = Vec::new();
    let degrees = |angle: f64| (angle * 1e6).round() / 1e6;
    let mut look = |key: &str, from: f64, span: f64, step: f64, instead: &str| {
        let steps = (span / step).round();
        if span < 360.0 && steps >= 1.0 && (steps * step - span).abs() < 1e-9 * span {
            warnings.push(format!(
                "{key} by steps of {step} leaves its end out: {steps} angles from {from} to {}. If the device has both ends, \
                 write {instead} = {} instead of the step",
                degrees(from + (steps - 1.0) * step),
                steps + 1.0
            ));
        }
    };
    let Some(step) = file.resolution_deg else { return warnings };
    if let Some(fov) = file.fov_deg.filter(|_| file.beams.is_none()) {
        look("fov_deg", -fov.horizontal / 2.0, fov.horizontal, step.horizontal, "beams");
    }
    let vertical_step = step.vertical.unwrap_or(step.horizontal);
    if let Some([from, to]) = file.elevation_deg.filter(|_| file.rings.is_none()) {
        look("elevation_deg", from, to - from, vertical_step, "rings");
    }
    // A vertical angle is a device's own if both ends make a number of rings that devices have.
    let is_device = |span: &f64| {
        vertical_step <= WIDEST_STEP_DEG
            && DEVICE_RINGS.iter().any(|rings| (span / vertical_step + 1.0 - rings).abs() < 1e-9)
    };
    let vertical = file.fov_deg.and_then(|fov| fov.vertical).filter(|_| file.rings.is_none());
    if let Some(span) = vertical.filter(is_device) {
        look("the vertical part of fov_deg", -span / 2.0, span, vertical_step, "rings");
    }
    warnings
}

/// Elevations above the ring plane in degrees, from whichever of three keys is given.
fn elevations(at: &Place, entry: &LidarFile) -> Result<Vec<f64>> {
    let vertical = entry.fov_deg.and_then(|fov| fov.vertical);
    let within = |key: &str, angle: f64| at.number(key, angle, -90.0..=90.0, "between -90 and 90");
    match (&entry.rings_deg, entry.elevation_deg, vertical) {
        (Some(all), None, None) => {
            at.some("rings_deg", all, "rings_deg = [-15, -13, ...]")?;
            if let Some(count) = entry.rings {
                return Err(at.wrong("rings", count, "and rings_deg: give one of them"));
            }
            all.iter().map(|&angle| within("rings_deg", angle)).collect()
        }
        (None, Some([from, to]), None) => {
            within("elevation_deg", from)?;
            within("elevation_deg", to)?;
            if from >= to {
                return Err(at.wrong("elevation_deg", format!("[{from}, {to}]"), "must rise"));
            }
            rings(at, entry, [from, to])
        }
        (None, None, Some(vertical)) => {
            let rule = "above 0 and at most 180 vertically; a scanner of one plane has one angle and one ring, as in fov_deg = \
                        270 and rings_deg = [0]";
            at.number("fov_deg", vertical, f64::MIN_POSITIVE..=180.0, rule)?;
            rings(at, entry, [-vertical / 2.0, vertical / 2.0])
        }
        (None, None, None) => Err(elevation_error(at, "no elevations")),
        _ => Err(elevation_error(at, "elevations given twice")),
    }
}

fn elevation_error(at: &Place, what: &str) -> Error {
    at.says(what).wanted(
        "give one of fov_deg = [horizontal, vertical], elevation_deg = [from, to], \
            rings_deg; the last two go with one angle, as in fov_deg = 270 and rings_deg = \
            [0] for a scanner of one plane",
    )
}
