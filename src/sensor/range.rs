//! What all sensors that measure distances share: how near and far, what silence means, how noisy.

use crate::backend::Rays;
use crate::march::{Gates, MAX_RANGE_VOXELS};
use crate::voxel::grid::length_q16;

use super::{Scale, noise};

/// The distances that a sensor measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Nearest and farthest distance it can measure, in metres.
    pub range_m: [f64; 2],
    /// Blockers entered before this distance are the sensor's own housing.
    pub near_ignore_m: f64,
    /// Whether a ray without a return certifies that what it passed is free.
    pub no_return_is_free: bool,
    /// Standard deviation of a measured distance in metres; 0 for none.
    pub noise_std_m: f64,
}

impl Range {
    /// What ends its rays, in voxels.
    pub fn gates(&self, scale: &Scale) -> Gates {
        let range_q16 =
            |metres| length_q16(metres, scale.voxel_size_m).clamp(0, (MAX_RANGE_VOXELS as i64) << 16) as u32;
        Gates {
            range_min_q16: range_q16(self.range_m[0]),
            range_max_q16: range_q16(self.range_m[1]),
            near_ignore_q16: range_q16(self.near_ignore_m),
            no_return_is_free: self.no_return_is_free,
            backdrop: scale.backdrop,
        }
    }

    /// A table of rays in these directions.
    pub fn rays(&self, dirs_q15: Vec<[i32; 3]>, scale: &Scale) -> Rays {
        let noise_q16 = noise::table_q16(self.noise_std_m, scale.voxel_size_m);
        Rays { dirs_q15, image: None, gates: self.gates(scale), noise_q16 }
    }
}
