//! The keys of a LIDAR or safety scanner.

use glam::DVec2;
use serde::Deserialize;

use super::range::{CalibrationFile, NoiseFile, RangeKeys};
use super::{MAX_RAYS, Silence, each_once, length};
use crate::error::Issue;
use crate::sensor::lidar::{self, ProtectiveField};
use crate::sensor::prism::Prism;
use crate::sensor::{Lidar, LidarMount};
use crate::study::Place;
use crate::study::value::{OneOrTwo, exactly, exactly_if_given};
use crate::voxel::solid::is_simple;
use crate::{Error, Result};

/// Most corners of a field; scanners allow some dozens.
const MAX_CORNERS: usize = 1000;

/// A LIDAR, or a safety scanner.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct LidarFile {
    /// Angle about its axis, or [about its axis, vertical]. Default 360.
    fov_deg: Option<OneOrTwo>,
    /// Between rays: one number, or [about its axis, vertical].
    resolution_deg: OneOrTwo,
    /// [from, to] above the plane of its rings.
    #[serde(default, deserialize_with = "exactly_if_given")]
    elevation_deg: Option<[f64; 2]>,
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
    let step = file.resolution_deg;
    let vertical_step = step.vertical.unwrap_or(step.horizontal);
    for angle in [step.horizontal, vertical_step] {
        at.number("resolution_deg", angle, 1e-3..=360.0, "angles from 0.001 to 360")?;
    }
    let span = file.fov_deg.map_or(360.0, |fov| fov.horizontal);
    at.number("fov_deg", span, f64::MIN_POSITIVE..=360.0, "above 0 and at most 360 around the spin axis")?;
    let elevations = elevations(at, &file, vertical_step)?;
    let azimuths = lidar::angles(-span / 2.0, span, step.horizontal);
    let rays = azimuths.len().saturating_mul(elevations.len());
    if rays == 0 || rays > MAX_RAYS {
        return Err(at.wrong(
            "resolution_deg",
            step.horizontal,
            &format!("gives {rays} rays, from 1 to {MAX_RAYS} are possible"),
        ));
    }
    let range = RangeKeys {
        range_m: file.range_m,
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

/// Elevations above the ring plane in degrees, from whichever of three keys is given.
fn elevations(at: &Place, entry: &LidarFile, step: f64) -> Result<Vec<f64>> {
    let vertical = entry.fov_deg.and_then(|fov| fov.vertical);
    let within = |key: &str, angle: f64| at.number(key, angle, -90.0..=90.0, "between -90 and 90");
    match (&entry.rings_deg, entry.elevation_deg, vertical) {
        (Some(rings), None, None) => {
            at.some("rings_deg", rings, "rings_deg = [-15, -13, ...]")?;
            rings.iter().map(|&angle| within("rings_deg", angle)).collect()
        }
        (None, Some([from, to]), None) => {
            within("elevation_deg", from)?;
            within("elevation_deg", to)?;
            if from >= to {
                return Err(at.wrong("elevation_deg", format!("[{from}, {to}]"), "must rise"));
            }
            Ok(lidar::angles(from, to - from, step))
        }
        (None, None, Some(vertical)) => {
            let rule = "above 0 and at most 180 vertically; a scanner of one plane has one angle and one ring, as in fov_deg = \
                        270 and rings_deg = [0]";
            at.number("fov_deg", vertical, f64::MIN_POSITIVE..=180.0, rule)?;
            Ok(lidar::angles(-vertical / 2.0, vertical, step))
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
