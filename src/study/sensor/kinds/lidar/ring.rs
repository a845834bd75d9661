//! How far the level ring of a scanner is clear in the environment alone, from which its largest field is made.

use std::sync::Arc;

use glam::DVec2;

use super::{FieldSet, Lidar, ProtectiveField};
use crate::sensor::contour::{RingRay, Scanner};
use crate::sensor::look::{self, RayDirection};
use crate::sensor::prism::Prism;
use crate::sensor::{Kind, RayScale, Station, placement};
use perirobot_march::error::Issue;
use perirobot_march::march::FULL_RANGE;
use perirobot_march::voxel::BitGrid;
use perirobot_scene::truth::Truth;

/// The blockers without people and robots.
pub(super) fn environment(truth: &Truth) -> BitGrid {
    let mut fixed = BitGrid::clone(&truth.blockers);
    fixed.remove(&truth.human);
    fixed.remove(&truth.robot);
    fixed
}

impl Scanner for Lidar {
    fn clear_rays(&self, at: &Station, height_m: f64) -> Result<Vec<RingRay>, Issue> {
        if !self.elevations_rad.iter().any(|elevation| elevation.abs() < 1e-9) {
            return Err(Issue::says("has no ring at elevation 0, and a field is level")
                .with_advice("give it one, as in rings_deg = [0]"));
        }
        if self.scanner(&at.pose()).link().z_axis.z.abs() <= 1.0 - 1e-9 {
            return Err(Issue::says("is tilted, and a field is level").with_advice("choose a level pose"));
        }
        let (grid, blockers) = (&at.truth.grid, environment(at.truth));
        let scale = RayScale::new(grid.voxel_size_m, false);
        let mut rays = self.range.to_noiseless().rays(self.dirs_q15(), &scale);
        // What is too near or too dark to be measured ends a ray, too.
        rays.gates.range_min_q16 = 0;
        rays.gates.shade_ranges_q16 = FULL_RANGE;
        let obstacles = look::Obstacles { blockers: &blockers, shades: None };
        let from = placement(self, &at.pose(), grid, 0);
        let column = Prism { polygon_m: Vec::new(), z_m: [0.0, height_m] };
        let own = grid.position_q16(at.pose().position_m)[2] >> 16;
        let layers = column.layers_above(&at.pose(), grid, own);
        let range_m = self.range.range_m[1];
        // Rays are in the order of columns, an azimuth each.
        let rings = self.elevations_rad.len();
        let clear = |(column, &azimuth_rad): (usize, &f64)| {
            let free = RingRay { azimuth_rad, reach_m: range_m, hit: None };
            self.elevations_rad.iter().enumerate().fold(free, |least, (ring, elevation)| {
                let ray = column * rings + ring;
                let way = RayDirection::new(&from, rays.dirs_q15[ray]);
                match look::look(obstacles, &rays, &from, way, ray as u32) {
                    Some(found) if layers.contains(&found.hit[2].into()) => {
                        let metres = f64::from(found.distance_q16) / 65_536.0 * grid.voxel_size_m;
                        let reach_m = metres * libm::cos(*elevation);
                        let nearer = RingRay { azimuth_rad, reach_m, hit: Some(found.hit) };
                        if reach_m < least.reach_m { nearer } else { least }
                    }
                    _ => least,
                }
            })
        };
        Ok(self.azimuths_rad.iter().enumerate().map(clear).collect())
    }

    fn field_height_m(&self, case: Option<usize>) -> Option<f64> {
        Some(self.field.as_ref()?.case(case).volume.z_m[1])
    }

    fn field_reach_m(&self) -> Option<f64> {
        let fields = self.field.as_ref().filter(|_| !self.points)?;
        let all = std::iter::once(&fields.usual).chain(fields.cases.iter().map(|case| &case.field));
        let corners = all.flat_map(|field| &field.volume.polygon_m).map(|corner| corner.length());
        corners.reduce(f64::max)
    }

    fn cases(&self) -> Vec<&str> {
        self.field.iter().flat_map(FieldSet::names).collect()
    }

    fn applying_cases(&self, at: &Station) -> Vec<usize> {
        self.field.as_ref().map_or(Vec::new(), |fields| fields.applying(at).collect())
    }

    fn guard(&self, polygon_m: Vec<DVec2>, height_m: f64) -> Arc<dyn Kind> {
        let volume = Prism { polygon_m, z_m: [0.0, height_m] };
        let field = Some(ProtectiveField { volume, otherwise_free: true }.into());
        Arc::new(Lidar { points: false, field, ..self.clone() })
    }
}
