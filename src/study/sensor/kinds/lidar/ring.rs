//! What a scanner's level ring meets of the environment alone, from which its largest field is made.

use std::sync::Arc;

use glam::DVec2;

use super::{Lidar, ProtectiveField};
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
    fn level_ring(&self, at: &Station) -> Result<Vec<RingRay>, Issue> {
        if !self.elevations_rad.iter().any(|elevation| elevation.abs() < 1e-9) {
            return Err(Issue::says("has no ring at elevation 0, and a field is level")
                .with_advice("give it one, as in rings_deg = [0]"));
        }
        if self.scanner(&at.pose()).link().z_axis.z.abs() <= 1.0 - 1e-9 {
            return Err(Issue::says("is tilted, and a field is level").with_advice("choose a level pose"));
        }
        let (grid, blockers) = (&at.truth.grid, environment(at.truth));
        let ring = Lidar { elevations_rad: vec![0.0], ..self.clone() };
        let scale = RayScale::new(grid.voxel_size_m, false);
        let mut rays = self.range.to_noiseless().rays(ring.dirs_q15(), &scale);
        // What is too near or too dark to be measured ends a ray, too.
        rays.gates.range_min_q16 = 0;
        rays.gates.shade_ranges_q16 = FULL_RANGE;
        let obstacles = look::Obstacles { blockers: &blockers, shades: None };
        let from = placement(self, &at.pose(), grid, 0);
        let cast = |(azimuth_rad, (&dir_q15, ray))| {
            let way = RayDirection::new(&from, dir_q15);
            let found = look::look(obstacles, &rays, &from, way, ray);
            let metres = |q16: u32| f64::from(q16) / 65_536.0 * grid.voxel_size_m;
            let reach_m = found.map_or(self.range.range_m[1], |found| metres(found.distance_q16));
            RingRay { azimuth_rad, reach_m, hit: found.map(|found| found.hit) }
        };
        Ok(self.azimuths_rad.iter().copied().zip(rays.dirs_q15.iter().zip(0..)).map(cast).collect())
    }

    fn field_height_m(&self) -> Option<f64> {
        self.field.as_ref().map(|field| field.volume.z_m[1])
    }

    fn guard(&self, polygon_m: Vec<DVec2>, height_m: f64) -> Arc<dyn Kind> {
        let volume = Prism { polygon_m, z_m: [0.0, height_m] };
        let field = Some(ProtectiveField { volume, otherwise_free: true });
        Arc::new(Lidar { points: false, field, ..self.clone() })
    }
}
