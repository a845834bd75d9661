//! People who are a voxel a joint, and cameras to look at them.

use super::*;
use crate::sensor::Camera;
use crate::sensor::noise::Deviation;
use crate::sensor::range::{Along, Range, ReflectanceRanges};

/// Half the image is as wide as it is far.
pub(super) const CAMERA: Camera = Camera { fov_rad: [std::f64::consts::FRAC_PI_2; 2], resolution_px: [8, 8] };

pub(super) const RANGE: Range = Range {
    reflectance: ReflectanceRanges::NONE,
    range_m: [0.0, 30.0],
    along: Along::Ray,
    near_ignore_m: 0.0,
    no_return_is_free: false,
    noise: Deviation::NONE,
    dropout: 0.0,
    calibration: None,
};

/// A person whose joints are the centres of these voxels, in a cell of 1 m voxels.
pub(super) fn person(truth: &mut Truth, joints: &[(usize, [i32; 3])]) {
    let mut keypoints = [None; 17];
    joints.iter().for_each(|&(joint, voxel)| keypoints[joint] = Some(centre(voxel)));
    let voxels: Vec<_> = joints.iter().map(|&(_, voxel)| voxel).collect();
    put(truth, Role::Human, &voxels, Some(keypoints));
}

/// The centre of a voxel of 1 m.
pub(super) fn centre(voxel: [i32; 3]) -> DVec3 {
    DVec3::from_array(voxel.map(|c| f64::from(c) + 0.5))
}
