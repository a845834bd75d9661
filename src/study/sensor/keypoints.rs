//! Which of a person's keypoints a camera sees, and where it detects them: rays towards the 17 joints of
//! COCO, cast on the host. `rgbd` and `rgb` turn detections into claims.

use glam::DVec3;

use super::look::{self, RayDirection, Return};
use super::{Camera, Station, quantise_q15};
use perirobot_march::backend::{GridPose, Rays};
use perirobot_march::error::Issue;
use perirobot_march::voxel::grid::length_q16;
use perirobot_scene::objects::Role;
use perirobot_scene::objects::keypoints::JOINTS;
use perirobot_scene::truth::{ObjectVoxels, Truth};

/// The return from each joint of one person that is detected; `None` where it is not.
pub type Detected = [Option<Return>; JOINTS.len()];

/// How far a return may be from the joint that it is taken for, in metres, by default: a joint lies inside
/// the body, and a camera sees the surface.
pub const TOLERANCE_M: f64 = 0.15;

/// The bones of COCO's skeleton, as pairs of joints.
pub const BONES: [[usize; 2]; 15] = [
    [0, 1],
    [0, 2],
    [1, 3],
    [2, 4],
    [5, 6],
    [5, 7],
    [6, 8],
    [7, 9],
    [8, 10],
    [0, 11],
    [0, 12],
    [11, 13],
    [12, 14],
    [13, 15],
    [14, 16],
];

/// A camera with a table of rays, from a placement.
pub struct KeypointCamera<'a> {
    /// Its optics.
    pub camera: &'a Camera,
    /// Its table of rays, for gates and noise; the rays towards joints are numbered after those of the table.
    pub rays: &'a Rays,
    /// Where it is.
    pub placement: &'a GridPose,
    /// Largest difference between the distance of a return and of the joint, in metres.
    pub tolerance_m: f64,
}

/// What a camera detects of each person of a scene, in the order of the scene's objects.
pub(crate) fn detect(eye: &KeypointCamera, at: &Station) -> Vec<Detected> {
    let nobody = [None; JOINTS.len()];
    humans(at.truth)
        .zip(0u32..)
        .map(|(human, number)| {
            let Some(keypoints) = &human.keypoints else { return nobody };
            let first_ray = eye.rays.dirs_q15.len() as u32 + JOINTS.len() as u32 * number;
            std::array::from_fn(|joint| {
                joint_return(eye, at, human, keypoints[joint]?, first_ray.wrapping_add(joint as u32))
            })
        })
        .collect()
}

/// The people of a scene.
pub(super) fn humans(truth: &Truth) -> impl Iterator<Item = &ObjectVoxels> {
    truth.objects.iter().map(|object| &**object).filter(|object| object.role == Role::Human)
}

/// Refuses a scene in which keypoints cannot be detected.
pub(crate) fn check(at: &Station) -> Result<(), Issue> {
    match humans(at.truth).find(|human| human.keypoints.is_none()) {
        None => Ok(()),
        Some(human) => Err(Issue::says(format!("needs keypoints, and human {:?} has none", human.name))
            .with_advice(
                "give it keypoints = \"joints.csv\" in the scene file (17 joints, COCO's \
                order), or make it a mannequin",
            )),
    }
}

/// The return from a joint: in front and in the image, its ray ending in the same person near the joint.
fn joint_return(
    eye: &KeypointCamera,
    at: &Station,
    human: &ObjectVoxels,
    joint_m: DVec3,
    ray: u32,
) -> Option<Return> {
    let grid = &at.truth.grid;
    let from = eye.placement.caster().origin_q16;
    let joint = grid.position_q16(joint_m);
    let way: [i64; 3] = std::array::from_fn(|r| joint[r] - i64::from(from[r]));
    let way_f64 = DVec3::from_array(way.map(|x| x as f64));
    let seen = at.truly.unwrap_or(at.pose()).optical().transpose() * way_f64;
    if !eye.camera.sees(seen) {
        return None;
    }
    let dir_q16 = |way: DVec3| (way / way_f64.length()).to_array().map(|x| (x * 65_536.0).round() as i32);
    let truly_q16 = dir_q16(way_f64);
    // The joint is read as seen from the believed pose of the camera.
    let believed_q16 = if at.truly.is_some() { dir_q16(at.pose().optical() * seen) } else { truly_q16 };
    let z_q15 = quantise_q15(seen.z / way_f64.length());
    let found = look::look(
        look::Obstacles::of(at.truth),
        eye.rays,
        eye.placement,
        RayDirection { truly_q16, believed_q16, z_q15 },
        ray,
    )?;
    let distance = way.iter().map(|&x| x as i128 * x as i128).sum::<i128>().isqrt();
    let off = (i128::from(found.distance_q16) - distance).abs();
    let near = off <= i128::from(length_q16(eye.tolerance_m, grid.voxel_size_m));
    (near && human.voxels.get(found.hit)).then_some(found)
}

/// How many joints of a person are detected.
pub(crate) fn count(detected: &Detected) -> usize {
    detected.iter().flatten().count()
}
