//! A LIDAR or safety scanner: rings of rays about a spin axis, scored by its points or, as a switch, by a field that it
//! guards.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::prism::Prism;
use super::range::Range;
use super::{
    Claim, Extent, FieldOfView, Kind, MEASURES, SWITCHES, Scale, Stance, Station, look, placement,
    quantise_q15, switched, watch,
};
use perirobot_march::backend::Rays;
use perirobot_march::error::Issue;
use perirobot_march::voxel::BitGrid;
use perirobot_scene::pose::{Frame, Pose};

/// How a LIDAR is fixed where a pose says which way it faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum LidarMount {
    /// The spin axis is the pose's up: world z for a facing pose; azimuth 0 looks where the pose faces.
    Upright,
    /// The spin axis is where the pose faces; azimuth 0 looks to its right.
    Facing,
}

/// Azimuths and elevations of a LIDAR in radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Lidar {
    /// Columns, from −span/2.
    pub azimuths_rad: Vec<f64>,
    /// Rows: elevation above the ring plane.
    pub elevations_rad: Vec<f64>,
    /// How it is fixed.
    pub mount: LidarMount,
    /// What it measures.
    pub range: Range,
    /// Whether its points are scored.
    pub points: bool,
    /// The field that it guards, if that is scored.
    pub field: Option<ProtectiveField>,
}

/// A protective field: the volume above a polygon in the scanner's frame (x is azimuth 0), from the layer of voxels that
/// the scanner is in up, so that what its level rays meet lies inside wherever in a voxel they run.
#[derive(Clone, Debug, PartialEq)]
pub struct ProtectiveField {
    /// Where it is.
    pub volume: Prism,
    /// Whether it is certified free while no return lies in it.
    pub otherwise_free: bool,
}

/// ⌈span/step − 1e-9⌉ angles start + i · step, as many as a scan of `span` holds without its end.
pub(crate) fn angles(start: f64, span: f64, step: f64) -> Vec<f64> {
    let count = (span / step - 1e-9).ceil().max(0.0) as usize;
    (0..count).map(|i| start + i as f64 * step).collect()
}

/// So many angles, two at least, spread evenly over a span from its start to its end, both included.
pub(crate) fn spread(start: f64, span: f64, count: u32) -> Vec<f64> {
    (0..count).map(|i| start + span * f64::from(i) / f64::from(count - 1)).collect()
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
        Pose::turned(pose.position_m, self.frame(pose), Frame::Link)
    }

    /// Which field a representation is scored by; `None` for the points.
    fn field(&self, representation: usize) -> Option<&ProtectiveField> {
        if self.points && representation == 0 { None } else { self.field.as_ref() }
    }
}

impl ProtectiveField {
    /// The voxels that it guards, over the part of the grid that holds them.
    fn voxels(&self, lidar: &Lidar, at: &Station) -> BitGrid {
        let (pose, grid) = (at.pose(), &at.truth.grid);
        let own = grid.position_q16(pose.position_m)[2] >> 16;
        let scanner = lidar.scanner(&pose);
        self.volume.layers(&scanner, grid, grid.window(), self.volume.layers_above(&scanner, grid, own))
    }
}

impl Kind for Lidar {
    fn name(&self) -> &'static str {
        "lidar"
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

    fn rays(&self, scale: &Scale) -> Option<Rays> {
        Some(self.range.rays(self.dirs_q15(), scale))
    }

    fn guarded_m(&self, pose: &Pose) -> Vec<DVec3> {
        self.field.as_ref().map_or(Vec::new(), |field| field.volume.footprint_m(&self.scanner(pose)))
    }

    fn field_of_view(&self) -> FieldOfView {
        FieldOfView::of_rings(&self.azimuths_rad, &self.elevations_rad)
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

    fn log_odds(&self, representation: usize) -> [i32; 2] {
        if self.field(representation).is_some() { SWITCHES } else { MEASURES }
    }

    fn check(&self, at: &Station) -> Result<(), Issue> {
        match self.field.as_ref().is_some_and(|field| field.voxels(self, at).is_empty()) {
            true => Err(Issue::says("has a field without a voxel of the grid")
                .wanted("make its polygon_m or height_m larger")),
            false => Ok(()),
        }
    }

    fn feels_presence(&self, representation: usize) -> bool {
        self.field(representation).is_some()
    }

    fn adds(&self, representation: usize) -> bool {
        self.field(representation).is_some()
    }

    fn stuck_by(&self, at: &Station) -> BitGrid {
        let Some(field) = &self.field else { return BitGrid::nowhere() };
        let voxels = field.voxels(self, at);
        let scale = Scale { voxel_size_m: at.truth.grid.voxel_size_m, backdrop: false };
        // The returns of the environment alone, without noise.
        let mut fixed = BitGrid::clone(&at.truth.blockers);
        fixed.remove(&at.truth.human);
        fixed.remove(&at.truth.robot);
        let rays = self.range.without_noise().rays(self.dirs_q15(), &scale);
        let from = placement(self, &at.pose(), &at.truth.grid, 0);
        let tripping = look::returns(&fixed, &rays, &from).filter(|found| voxels.get(found.read));
        let mut hit = BitGrid::new(fixed.window());
        tripping.for_each(|found| hit.set(found.hit));
        hit
    }

    fn claims(&self, at: &Station) -> Vec<Claim> {
        let points = || Claim { cast: true, planes: None };
        let guarded = |(field, rays): (&ProtectiveField, &Rays)| {
            let whole = field.voxels(self, at);
            let from = at.placement(self);
            let mut felt = BitGrid::new(at.truth.human.window());
            let mut on = false;
            for found in look::returns(&at.truth.blockers, rays, &from).filter(|found| whole.get(found.read))
            {
                on = true;
                felt.set(found.hit);
            }
            felt.keep(&at.truth.human);
            let window = whole.window().intersection(&at.window);
            switched(at, whole.over(window), on, field.otherwise_free, felt)
        };
        let claim = |r| self.field(r).zip(at.rays).map_or_else(points, guarded);
        (0..self.representations().len()).map(claim).collect()
    }

    fn watches(&self, representation: usize, at: &Station) -> Option<BitGrid> {
        let (field, rays) = self.field(representation).zip(at.rays)?;
        let field = field.voxels(self, at);
        Some(watch::by_rays(rays, &at.placement(self), &at.truth.blockers, Some(&field)))
    }

    fn reach(&self, at: &Station) -> Extent {
        match &self.field {
            None => Extent::Rays,
            Some(field) if self.points => Extent::RaysAnd(field.voxels(self, at)),
            Some(field) => Extent::Only(field.voxels(self, at)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::noise::Deviation;
    use crate::sensor::range::Along;

    #[test]
    fn spans_have_their_start_and_not_their_end() {
        assert_eq!(angles(0.0, 90.0, 30.0), [0.0, 30.0, 60.0]);
        assert_eq!(angles(-180.0, 360.0, 0.7).len(), 515);
        assert_eq!(angles(45.0, 45.0, 0.7).len(), 65);
        // 0.3 / 0.1 is 2.9999999999999996: still three angles.
        assert_eq!(angles(0.0, 0.3, 0.1).len(), 3);
    }

    #[test]
    fn spread_angles_have_both_ends() {
        assert_eq!(spread(-15.0, 30.0, 16)[..2], [-15.0, -13.0]);
        assert_eq!(spread(-135.0, 270.0, 1081).last(), Some(&135.0));
        assert_eq!(spread(-5.0, 5.0, 2), [-5.0, 0.0]);
    }

    #[test]
    fn rays_go_column_by_column() {
        let quarter = std::f64::consts::FRAC_PI_2;
        let lidar = Lidar {
            azimuths_rad: vec![0.0, quarter],
            elevations_rad: vec![0.0, quarter],
            mount: LidarMount::Upright,
            range: Range {
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
