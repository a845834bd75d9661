//! The ray of a sensor nearest to a voxel's centre, and whether the voxel is in view.
//!
//! # Practice
//! A camera's pixel is found by projection, the ray of any other table by a search within the
//! largest distance of a ray that crosses the voxel, or that decides whether the voxel is in view.

use glam::DVec3;

use super::nearest::{NearestDirection, gap};
use perirobot_march::backend::{GridPose, Image, Rays};
use perirobot_march::march::March;
use perirobot_study::sensor::{FieldOfView, quantise_q15};

/// A sensor's rays from its pose.
pub(crate) struct Sight<'a> {
    rays: &'a Rays,
    from: &'a GridPose,
    field: FieldOfView,
    finder: Finder<'a>,
}

enum Finder<'a> {
    Pixels(Image),
    Table {
        nearest: NearestDirection<'a>,
        /// Largest distance of a direction from the nearest ray to be in view of a table without other bounds, squared
        /// in Q30.
        reach: i64,
    },
}

/// A voxel as seen from a sensor.
pub(crate) struct Look {
    /// Whether the voxel's centre is in the field of view.
    pub(crate) in_view: bool,
    /// The ray nearest to its centre; `None` if none is near enough to cross it.
    pub(crate) ray: Option<u32>,
    /// The distance of its centre, squared, in 1/2^32 voxels squared.
    pub(crate) squared_q32: i128,
}

impl<'a> Sight<'a> {
    pub(crate) fn new(rays: &'a Rays, from: &'a GridPose, field: FieldOfView) -> Self {
        let finder = match rays.image {
            Some(image) => Finder::Pixels(image),
            None => Finder::Table {
                nearest: NearestDirection::new(&rays.dirs_q15),
                // The middle of a square of rays is half a diagonal from each of them.
                reach: if field == FieldOfView::Spacing { gap(&rays.dirs_q15) / 2 } else { 0 },
            },
        };
        Sight { rays, from, field, finder }
    }

    /// Direction and distance of a voxel's centre.
    pub(crate) fn look(&self, voxel: [i32; 3]) -> Look {
        let way: [i64; 3] = std::array::from_fn(|r| {
            (i64::from(voxel[r]) << 16) + 0x8000 - i64::from(self.from.origin_q16[r])
        });
        let squared_q32 = way.iter().map(|&x| i128::from(x) * i128::from(x)).sum();
        // At most 2^43 on each axis, so floats are exact.
        let axis =
            |a: usize| (0..3).map(|r| i64::from(self.from.axis_q15[r][a]) * way[r]).sum::<i64>() as f64;
        let direction = DVec3::new(axis(0), axis(1), axis(2));
        let in_field = self.field.holds(direction);
        let (ray, is_near) = match &self.finder {
            Finder::Pixels(image) => (Some(pixel(image, direction)), true),
            Finder::Table { nearest, reach } => {
                let unit = direction / direction.length().max(1.0);
                // A ray that crosses a voxel passes its centre within half a diagonal, which is less than 1.
                let crossing = (1i128 << 64) / i128::max(squared_q32, 1);
                let within = i64::try_from(crossing).unwrap_or(i64::MAX).max(*reach);
                match nearest.find(unit.to_array().map(quantise_q15), within) {
                    Some((ray, off)) => (Some(ray), off <= *reach),
                    None => (None, false),
                }
            }
        };
        Look { in_view: in_field.unwrap_or(is_near), ray, squared_q32 }
    }

    /// A ray at its start.
    pub(crate) fn start(&self, ray: u32) -> March {
        self.from.launch(self.rays.dirs_q15[ray as usize])
    }
}

/// The pixel of a direction, or the nearest one of the image.
fn pixel(image: &Image, direction: DVec3) -> u32 {
    let pixel = |a: usize| {
        let last = f64::from(image.size_px[a]) - 1.0;
        let slope = match direction[a] {
            _ if direction.z > 0.0 => image.focal_px[a] * direction[a] / direction.z,
            0.0 => 0.0,
            aside => aside.signum() * f64::INFINITY,
        };
        (slope + f64::from(image.size_px[a]) / 2.0).floor().clamp(0.0, last) as u32
    };
    pixel(1) * image.size_px[0] + pixel(0)
}
