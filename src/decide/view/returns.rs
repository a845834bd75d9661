//! The point cloud of a sensor: the returns of its rays.

use glam::DVec3;

use super::{SensorView, View};
use perirobot_march::march::{self, RETURN};
use perirobot_study::sensor::look::{self, RayDirection};
use perirobot_study::world::ray_table;

/// A return of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReturnPoint {
    /// Index of the ray in the sensor's table.
    pub ray: usize,
    /// The point, in world metres: along the ray, at the near side of the voxel plus the noise, and then at least
    /// 1/1024 voxel inside the voxel.
    pub at_m: DVec3,
    /// Its voxel.
    pub voxel: [i32; 3],
}

/// Least depth of a return inside its voxel, in voxels.
const INSIDE: f64 = 1.0 / 1024.0;

impl View<'_> {
    /// The returns of a sensor's rays, in ray order; empty if it casts none.
    pub fn returns(&self, member: &SensorView) -> Vec<ReturnPoint> {
        let (Some(cast), Some(rays)) = (&member.cast, &ray_table(self.study, member.sensor)) else {
            return Vec::new();
        };
        let (from, grid) = (&member.placement, &self.world.grid);
        let returned = cast.ends.iter().enumerate().filter(|(_, end)| end.kind == RETURN);
        let found = returned.filter_map(|(ray, _)| {
            let way = RayDirection::new(from, rays.dirs_q15[ray]);
            let found = look::look(look::Obstacles::of(&self.truth), rays, from, way, ray as u32)?;
            let drawn = march::draw(from.draws, ray as u32);
            let step_q16 = rays.noise.step_q16(rays.gates.slant(way.z_q15), drawn, found.distance_q16);
            let voxels = f64::from(march::noisy_q16(found.distance_q16, step_q16)) / 65536.0;
            let along = way.believed_q16.map(|d| f64::from(d) / 65536.0);
            let begin = from.origin_q16.map(|o| f64::from(o) / 65536.0);
            let at = DVec3::from_array(begin) + DVec3::from_array(along) * voxels;
            // A point on the near side may be rounded into the voxel before; inside, it is read back correctly.
            let low = DVec3::from_array(found.read.map(f64::from));
            let at = at.clamp(low + INSIDE, low + 1.0 - INSIDE);
            let at_m = grid.corner_m([0; 3]) + at * grid.voxel_size_m;
            Some(ReturnPoint { ray, at_m, voxel: found.read })
        });
        found.collect()
    }
}
