//! A LIDAR or safety scanner: rings of rays about a spin axis, scored by its points or, as a switch, by a field that it
//! guards.

mod angles;
mod cases;
mod corners;
mod field;
mod ring;
mod zone;

use std::sync::Arc;

use glam::{DMat3, DVec3};
use serde::Deserialize;
use toml::Table;

use self::angles::{azimuths, elevations, left_out};
use self::cases::FieldCaseFile;
use self::cases::FieldSet;
#[cfg(test)]
pub(crate) use self::cases::{CaseRule, FieldCase};
use self::field::FieldFile;
pub(crate) use self::field::{FARTHEST_M, MAX_CORNERS, ProtectiveField, bound_area};
use self::ring::environment;
use super::shared::range::{CalibrationFile, NoiseFile, RangeKeys, refuse_former};
use super::shared::{Silence, each_once};
use super::{Checked, Context, KindFile};
#[cfg(test)]
use super::{EvidenceWords, POINTS, Page};
use crate::diagnostics::Place;
use crate::keys::{OneOrTwo, exactly, exactly_if_given};
use crate::sensor::contour::Scanner;
use crate::sensor::range::Range;
use crate::sensor::spacing::RaySpacing;
use crate::sensor::{
    Approached, Claim, Extent, FieldOfView, Kind, MAX_RAYS, MEASURES, RayScale, SWITCHES, Stance, Station,
    look, placement, quantise_q15, switch_planes, watch,
};
use perirobot_march::Result;
use perirobot_march::backend::Rays;
use perirobot_march::error::Issue;
use perirobot_march::voxel::BitGrid;
use perirobot_scene::pose::{Pose, RotationFrame};
use perirobot_scene::source::Sources;

/// A LIDAR, or a safety scanner.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct LidarFile {
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
    /// How far it detects what reflects a share of its light, as [[0.1, 8], [0.9, 25]] for 8 m at 10 % and 25 m at 90 %; one to
    /// three pairs. Default: everything up to the longest range.
    reflectance_ranges_m: Option<Vec<[f64; 2]>>,
    /// How far its mount may be off, drawn anew in each repeat. Default not at all.
    calibration: Option<CalibrationFile>,
    /// The representations that are scored, each separately. Default ["field"] where there is one, else
    /// ["points"].
    representations: Option<Vec<Representation>>,
    /// Makes it a switch: a return in this field makes the volume above it occupied.
    field: Option<FieldFile>,
    /// Further fields to which it switches at some moments: the first whose conditions all hold counts, else `field`.
    #[serde(default)]
    field_cases: Vec<FieldCaseFile>,
}

#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
enum Representation {
    Points,
    Field,
}

/// How a LIDAR is fixed where a pose says which way it faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub(crate) enum LidarMount {
    /// The spin axis is the pose's up: world z for a facing pose; azimuth 0 looks where the pose faces.
    Upright,
    /// The spin axis is where the pose faces; azimuth 0 looks to its right.
    Facing,
}

impl KindFile for LidarFile {
    const NAME: &'static str = "lidar";
    #[cfg(test)]
    const PAGE: Page = Page {
        what: "lidar or safety scanner, scored as `points`, or as a switch by a `field`",
        keys: "`fov_deg` (`[around the spin axis, across the rings]`; or `fov_deg?` around it alone, 360, with \
        `elevation_deg` or `rings_deg`), `resolution_deg` (the step) or `beams` and `rings` (numbers), \
        `range_m`, `mount?` (upright), `representations?`, `field = { polygon_m, height_m, otherwise? }?` \
        (free; instead of `polygon_m`, `polygon` names a CSV with columns x_m, y_m, and `psenscan` a zone of a \
        PSENscan: `file`, `zone_set`, `zone?`, `scanner?`); `[[sensor.field_cases]]`: \
        `name`, `at?`, `scenes?`, `speed_m_s?`, `of?` (what carries it), and the keys of `field`, which has the \
        defaults of `height_m?` and `otherwise?`",
        evidence: &[
            POINTS,
            EvidenceWords {
                says: "`field`",
                occupied: "the field's volume, if a return is read in it",
                free: "else the volume, unless `otherwise = \"unknown\"`",
            },
        ],
    };

    fn prepare(at: &Place, keys: &mut Table, _: &Sources) -> Result<Vec<String>> {
        refuse_former(at, keys)?;
        Ok(Vec::new())
    }

    fn check(self, at: &Place, context: &Context) -> Result<Checked> {
        let mut warnings = left_out(&self);
        if let Some(OneOrTwo { horizontal, vertical }) = self.resolution_deg {
            for angle in [Some(horizontal), vertical].into_iter().flatten() {
                at.number("resolution_deg", angle, 1e-3..=360.0, "angles from 0.001 to 360")?;
            }
        }
        let span = self.fov_deg.map_or(360.0, |fov| fov.horizontal);
        at.number(
            "fov_deg",
            span,
            f64::MIN_POSITIVE..=360.0,
            "above 0 and at most 360 around the spin axis",
        )?;
        let azimuths = azimuths(at, &self, span)?;
        let elevations = elevations(at, &self)?;
        let rays = azimuths.len().saturating_mul(elevations.len());
        if rays == 0 || rays > MAX_RAYS {
            let rule = format!("from 1 to {MAX_RAYS} are possible");
            return Err(match self.resolution_deg {
                Some(step) => at.wrong(
                    "resolution_deg",
                    step.horizontal,
                    &format!("gives {rays} rays, {rule}: write a larger step"),
                ),
                None => {
                    at.says(format!("has {rays} rays")).with_advice(rule + ": write fewer beams and rings")
                }
            });
        }
        let range = RangeKeys {
            range_m: self.range_m,
            along: None,
            near_ignore_m: self.near_ignore_m,
            no_return: self.no_return,
            noise: self.noise,
            dropout: self.dropout,
            calibration: self.calibration,
            reflectance_ranges_m: self.reflectance_ranges_m,
        };
        // If there is a field, it is scored and the points are not, unless both are listed.
        let usual = if self.field.is_some() { Representation::Field } else { Representation::Points };
        let scored = self.representations.unwrap_or_else(|| vec![usual]);
        each_once(at, &scored, "representations = [\"points\"]")?;
        let field = self.field.map(|field| field.check(&at.key("field"), context.sources)).transpose()?;
        let field = cases::check(at, field, self.field_cases, context, &mut warnings)?;
        let scores_field = scored.contains(&Representation::Field);
        if scores_field && field.is_none() {
            return Err(
                at.says("representation \"field\" needs field = { polygon_m = [[x, y], ...], height_m }")
            );
        }
        if field.is_some() && !scores_field {
            return Err(at
                .says("field is given and not among the representations")
                .with_advice("add \"field\", or take it away"));
        }
        let lidar = Lidar {
            azimuths_rad: azimuths.into_iter().map(f64::to_radians).collect(),
            elevations_rad: elevations.into_iter().map(f64::to_radians).collect(),
            mount: self.mount.unwrap_or(LidarMount::Upright),
            range: range.check(at, context.noiseless)?,
            points: scored.contains(&Representation::Points),
            field,
        };
        Ok(Checked { kind: Arc::new(lidar), warnings })
    }
}

/// Azimuths and elevations of a LIDAR in radians.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Lidar {
    /// Columns, from −span/2.
    pub(crate) azimuths_rad: Vec<f64>,
    /// Rows: elevation above the ring plane.
    pub(crate) elevations_rad: Vec<f64>,
    /// How it is fixed.
    pub(crate) mount: LidarMount,
    /// What it measures.
    pub(crate) range: Range,
    /// Whether its points are scored.
    pub(crate) points: bool,
    /// The fields that it guards, if they are scored.
    pub(crate) field: Option<FieldSet>,
}

impl Lidar {
    /// Directions in the LIDAR's frame (z is the spin axis, x azimuth 0), column by column.
    pub(crate) fn dirs_q15(&self) -> Vec<[i32; 3]> {
        let mut dirs = Vec::with_capacity(self.azimuths_rad.len() * self.elevations_rad.len());
        for &azimuth in &self.azimuths_rad {
            let (sin_azimuth, cos_azimuth) = libm::sincos(azimuth);
            for &elevation in &self.elevations_rad {
                let (sin_elevation, cos_elevation) = libm::sincos(elevation);
                let dir = DVec3::new(cos_elevation * cos_azimuth, cos_elevation * sin_azimuth, sin_elevation);
                dirs.push(dir.to_array().map(quantise_q15));
            }
        }
        dirs
    }

    /// Its own frame, as fields are told in.
    fn scanner(&self, pose: &Pose) -> Pose {
        Pose::from_rotation(pose.position_m, self.frame(pose), RotationFrame::Link)
    }

    /// Which fields a representation is scored by; `None` for the points.
    fn field(&self, representation: usize) -> Option<&FieldSet> {
        if self.points && representation == 0 { None } else { self.field.as_ref() }
    }
}

impl Kind for Lidar {
    fn name(&self) -> &'static str {
        LidarFile::NAME
    }

    fn representations(&self) -> Vec<&'static str> {
        [self.points.then_some("points"), self.field.as_ref().map(|_| "field")]
            .into_iter()
            .flatten()
            .collect()
    }

    fn only(&self, representation: usize) -> Option<Arc<dyn Kind>> {
        let field = self.field(representation).cloned();
        Some(Arc::new(Lidar { points: field.is_none(), field, ..self.clone() }))
    }

    fn rays(&self, scale: &RayScale) -> Option<Rays> {
        Some(self.range.rays(self.dirs_q15(), scale))
    }

    fn guarded_m(&self, pose: &Pose) -> Vec<DVec3> {
        self.field.as_ref().map_or(Vec::new(), |fields| fields.usual.volume.footprint_m(&self.scanner(pose)))
    }

    fn guarded_now_m(&self, at: &Station) -> Vec<DVec3> {
        let footprint = |fields: &FieldSet| fields.field(at).volume.footprint_m(&self.scanner(&at.pose()));
        self.field.as_ref().map_or(Vec::new(), footprint)
    }

    fn field_of_view(&self) -> FieldOfView {
        FieldOfView::from_rings(&self.azimuths_rad, &self.elevations_rad)
    }

    fn spacing(&self) -> Option<RaySpacing> {
        Some(RaySpacing::from_rings(&self.azimuths_rad, &self.elevations_rad))
    }

    fn frame(&self, pose: &Pose) -> DMat3 {
        match self.mount {
            LidarMount::Facing => pose.optical(),
            LidarMount::Upright => pose.link(),
        }
    }

    fn stance(&self) -> Stance {
        match self.mount {
            LidarMount::Facing => Stance::Facing,
            LidarMount::Upright => Stance::Upright,
        }
    }

    fn range(&self) -> Option<&Range> {
        Some(&self.range)
    }

    fn approached(&self) -> Option<Approached> {
        Some(Approached::AlongRays)
    }

    fn log_odds(&self, representation: usize) -> [i32; 2] {
        if self.field(representation).is_some() { SWITCHES } else { MEASURES }
    }

    fn check(&self, at: &Station) -> Result<(), Issue> {
        let Some(fields) = self.field.as_ref().filter(|fields| fields.field(at).voxels(self, at).is_empty())
        else {
            return Ok(());
        };
        let empty = Issue::says("has a field without a voxel of the grid")
            .with_advice("make it larger, or turn it into the grid");
        Err(match fields.applying(at).next().and_then(|case| fields.names().nth(case)) {
            Some(case) => empty.with_place(format!("field case {case:?}")),
            None => empty,
        })
    }

    fn feels_presence(&self, representation: usize) -> bool {
        self.field(representation).is_some()
    }

    fn adds(&self, representation: usize) -> bool {
        self.field(representation).is_some()
    }

    fn stuck_by(&self, at: &Station) -> BitGrid {
        let Some(fields) = &self.field else { return BitGrid::nowhere() };
        let voxels = fields.field(at).voxels(self, at);
        let scale = RayScale::new(at.truth.grid.voxel_size_m, false);
        // The returns of the environment alone, without noise.
        let fixed = environment(at.truth);
        let mut rays = self.range.to_noiseless().rays(self.dirs_q15(), &scale);
        if let Some(own) = at.rays {
            rays.gates.shade_ranges_q16 = own.gates.shade_ranges_q16;
        }
        let obstacles = look::Obstacles { blockers: &fixed, shades: at.truth.shades.as_deref() };
        let from = placement(self, &at.pose(), &at.truth.grid, 0);
        let tripping = look::returns(obstacles, &rays, &from).filter(|found| voxels.get(found.read));
        let mut hit = BitGrid::new(fixed.window());
        tripping.for_each(|found| hit.set(found.hit));
        hit
    }

    fn as_scanner(&self) -> Option<&dyn Scanner> {
        Some(self)
    }

    fn claims(&self, at: &Station) -> Vec<Claim> {
        let points = || Claim { cast: true, planes: None };
        let guarded = |(fields, rays): (&FieldSet, &Rays)| {
            let field = fields.field(at);
            let whole = field.voxels(self, at);
            let from = at.placement(self);
            let mut felt = BitGrid::new(at.truth.human.window());
            let mut on = false;
            for found in look::returns(look::Obstacles::of(at.truth), rays, &from)
                .filter(|found| whole.get(found.read))
            {
                on = true;
                felt.set(found.hit);
            }
            felt.keep(&at.truth.human);
            let window = whole.window().intersection(&at.window);
            switch_planes(at, whole.to_window(window), on, field.otherwise_free, felt)
        };
        let claim = |r| self.field(r).zip(at.rays).map_or_else(points, guarded);
        (0..self.representations().len()).map(claim).collect()
    }

    fn watches(&self, representation: usize, at: &Station) -> Option<BitGrid> {
        let (fields, rays) = self.field(representation).zip(at.rays)?;
        let field = fields.field(at).voxels(self, at);
        let rays = watch::rays_that_notice(self, rays, at);
        Some(watch::ray_watch(&rays, &at.placement(self), &at.truth.blockers, Some(&field)))
    }

    fn reach(&self, at: &Station) -> Extent {
        match &self.field {
            None => Extent::Rays,
            Some(fields) if self.points => Extent::RaysAnd(fields.field(at).voxels(self, at)),
            Some(fields) => Extent::Only(fields.field(at).voxels(self, at)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::noise::Deviation;
    use crate::sensor::range::{Along, ReflectanceRanges};

    #[test]
    fn rays_go_column_by_column() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let lidar = Lidar {
            azimuths_rad: vec![0.0, quarter],
            elevations_rad: vec![0.0, quarter],
            mount: LidarMount::Upright,
            range: Range {
                reflectance: ReflectanceRanges::NONE,
                range_m: [0.0, 1.0],
                along: Along::Ray,
                near_ignore_m: 0.0,
                no_return_is_free: false,
                noise: Deviation::NONE,
                dropout: 0.0,
                calibration: None,
            },
            points: true,
            field: None,
        };
        let up = [0, 0, 32_768];
        assert_eq!(lidar.dirs_q15(), [[32_768, 0, 0], up, [0, 32_768, 0], up]);
    }
}
