//! What all sensors that measure distances share: nearest and farthest distance, the meaning of a ray without
//! return, noise, calibration of the mount.

use perirobot_march::backend::Rays;
use perirobot_march::march::{Gates, MAX_RANGE_VOXELS};
use perirobot_march::voxel::grid::length_q16;

use super::noise::{self, Deviation};
use super::{Calibration, RayScale};

/// What the range and the noise of a sensor are measured along.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Along {
    /// Along each ray: its length.
    #[default]
    Ray,
    /// Along the optical axis: depth.
    Axis,
}

/// The distances that a sensor measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Nearest and farthest distance it can measure, in metres.
    pub range_m: [f64; 2],
    /// What these, and noise, are measured along.
    pub along: Along,
    /// Blockers entered before this distance are the sensor's own housing.
    pub near_ignore_m: f64,
    /// Whether a ray without a return certifies that what it passed is free.
    pub no_return_is_free: bool,
    /// How far off its distances are.
    pub noise: Deviation,
    /// Which share of its returns is lost, from 0 to below 1.
    pub dropout: f64,
    /// How far its mount may be off, if it may.
    pub calibration: Option<Calibration>,
    /// How far it detects dark objects.
    pub reflectance: ReflectanceRanges,
}

/// How far a sensor detects objects by the share of light that they reflect, as a data sheet says of one to three of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReflectanceRanges {
    /// Shares, ascending, each with a range in metres, which ascends, too.
    pairs: [Option<[f64; 2]>; 3],
}

impl ReflectanceRanges {
    /// Everything is detected up to the longest range.
    pub const NONE: ReflectanceRanges = ReflectanceRanges { pairs: [None; 3] };

    /// Of pairs of a share and a range, at most three, both ascending.
    pub fn new(pairs: &[[f64; 2]]) -> ReflectanceRanges {
        ReflectanceRanges { pairs: std::array::from_fn(|number| pairs.get(number).copied()) }
    }

    /// Whether a range is given.
    pub fn is_given(&self) -> bool {
        self.pairs[0].is_some()
    }

    /// The range for a share: on a straight line between its neighbours where both are logarithms, and beyond the first and
    /// the last with the square root of the share, as light that comes back from a surface which fills the beam falls with the
    /// square of the distance. Infinite where no range is given.
    pub fn range_m(&self, share: f64) -> f64 {
        let pairs: Vec<[f64; 2]> = self.pairs.iter().flatten().copied().collect();
        let (Some(first), Some(last)) = (pairs.first(), pairs.last()) else { return f64::INFINITY };
        let beyond = |[known, range_m]: &[f64; 2]| range_m * libm::sqrt(share / known);
        if share <= first[0] {
            return beyond(first);
        }
        if share >= last[0] {
            return beyond(last);
        }
        let after = pairs.iter().position(|pair| pair[0] > share).unwrap_or(pairs.len() - 1).max(1);
        let ([low, near_m], [high, far_m]) = (pairs[after - 1], pairs[after]);
        let way = libm::log(share / low) / libm::log(high / low);
        near_m * libm::pow(far_m / near_m, way)
    }
}

impl Range {
    /// What ends its rays, in voxels.
    pub(crate) fn gates(&self, scale: &RayScale) -> Gates {
        let range_q16 =
            |metres| length_q16(metres, scale.voxel_size_m).clamp(0, (MAX_RANGE_VOXELS as i64) << 16) as u32;
        Gates {
            range_min_q16: range_q16(self.range_m[0]),
            range_max_q16: range_q16(self.range_m[1]),
            shade_ranges_q16: scale
                .reflectances
                .map(|share| range_q16(self.reflectance.range_m(share).min(self.range_m[1]))),
            along_axis: self.along == Along::Axis,
            near_ignore_q16: range_q16(self.near_ignore_m),
            no_return_is_free: self.no_return_is_free,
            backdrop: scale.backdrop,
        }
    }

    /// A table of rays in these directions.
    pub(crate) fn rays(&self, dirs_q15: Vec<[i32; 3]>, scale: &RayScale) -> Rays {
        let gates = self.gates(scale);
        let voxels = gates.range_max_q16 >> 16;
        let noise = noise::noise(&self.noise, self.dropout, voxels, scale.voxel_size_m);
        Rays { dirs_q15: dirs_q15.into(), image: None, gates, noise }
    }

    /// Whether its readings depend on chance.
    pub(crate) fn is_noisy(&self) -> bool {
        self.noise != Deviation::NONE || self.dropout > 0.0 || self.calibration.is_some()
    }

    /// The same without chance.
    pub(crate) fn to_noiseless(self) -> Self {
        Range { noise: Deviation::NONE, dropout: 0.0, calibration: None, ..self }
    }
}
