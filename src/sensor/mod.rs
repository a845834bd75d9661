//! What a sensor is: the rays it casts and the poses it may stand at. Everything leaves this room quantised; how a
//! ray travels is `march`'s business.

pub mod camera;
pub mod lidar;
pub mod pose;

use crate::backend::{Placement, Rays};
use crate::march::{Gates, MAX_RANGE_VOXELS};
use crate::voxel::{Grid, grid::length_q16};
pub use camera::Camera;
pub use lidar::{Lidar, Mount};
pub use pose::Pose;

/// What kind of sensor it is, with what decides its rays.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// An RGB-D camera: one ray a pixel.
    Camera(Camera),
    /// A LIDAR: one ray for each azimuth and elevation.
    Lidar(Lidar),
}

/// A range sensor, in metres and radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensor {
    /// Unique in the study.
    pub name: String,
    /// What rays it casts.
    pub kind: Kind,
    /// Nearest and farthest distance it can measure.
    pub range_m: [f64; 2],
    /// Blockers entered before this distance are the sensor's own housing.
    pub near_ignore_m: f64,
    /// Whether a ray without a return certifies that what it passed is free.
    pub no_return_is_free: bool,
    /// Candidate poses in study order.
    pub candidates: Vec<Candidate>,
}

/// One pose a sensor may have.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Unique among the sensor's poses, and stable: `right-wall/12/3`.
    pub name: String,
    /// The set of poses it belongs to: `right-wall`.
    pub group: String,
    /// Where it is.
    pub pose: Pose,
}

impl Sensor {
    /// The sensor's rays and gates on a grid of this voxel size. `backdrop`: rays that leave the grid return.
    pub fn rays(&self, voxel_size_m: f64, backdrop: bool) -> Rays {
        let dirs_q15 = match &self.kind {
            Kind::Camera(camera) => camera.dirs_q15(),
            Kind::Lidar(lidar) => lidar.dirs_q15(),
        };
        let range_q16 =
            |metres| length_q16(metres, voxel_size_m).clamp(0, (MAX_RANGE_VOXELS as i64) << 16) as u32;
        let gates = Gates {
            range_min_q16: range_q16(self.range_m[0]),
            range_max_q16: range_q16(self.range_m[1]),
            near_ignore_q16: range_q16(self.near_ignore_m),
            no_return_is_free: self.no_return_is_free,
            backdrop,
        };
        Rays { dirs_q15, gates, noise_q16: Vec::new() }
    }

    /// A pose as integers. The position must lie in the grid.
    pub fn placement(&self, pose: &Pose, grid: &Grid) -> Placement {
        let rotation = match &self.kind {
            Kind::Camera(_) => pose.optical(),
            Kind::Lidar(lidar) => lidar.frame(pose),
        };
        let row = |r: usize| std::array::from_fn(|a| quantise_q15(rotation.col(a)[r]));
        Placement {
            origin_q16: grid.position_q16(pose.position_m).map(|x| x as i32),
            axis_q15: std::array::from_fn(row),
            draws: 0,
        }
    }
}

/// A component of a unit vector in Q15, ties away from zero: −32768 to 32768.
fn quantise_q15(value: f64) -> i32 {
    (value * 32_768.0).round() as i32
}
