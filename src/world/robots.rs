//! Warns of robots that float: a robot stands on something or hangs from something.

use super::World;
use crate::scene::{Role, Scene};
use crate::truth::{ObjectVoxels, Truth};
use crate::voxel::Distances;

/// A robot that is this near to anything, or to the floor, is mounted there, in metres and in voxels.
const MOUNTED_M: f64 = 0.2;
const MOUNTED_VOXELS: i32 = 2;

/// What is wrong with each robot of a scene, at its first moment.
pub(super) fn warnings(scene: &Scene, world: &World) -> Vec<String> {
    let truth = world.truth();
    let all = scene.objects.iter().zip(&truth.objects);
    let robots = all.enumerate().filter(|(_, (object, voxels))| {
        object.role == Role::Robot && !object.tag_only && !voxels.voxels.is_empty()
    });
    robots.filter_map(|(index, (_, robot))| floats(world, &truth, index, robot)).collect()
}

/// That nothing is near a robot, if nothing is.
fn floats(world: &World, truth: &Truth, index: usize, robot: &ObjectVoxels) -> Option<String> {
    let above_m = robot.bounds_m[0].z - world.floor.z_m;
    if above_m <= MOUNTED_M {
        return None;
    }
    let reach = MOUNTED_VOXELS.max((MOUNTED_M / truth.grid.voxel_size_m).ceil() as i32);
    let around = robot.voxels.bounds().grown(reach).intersection(&truth.grid.window());
    let distances = Distances::to(&robot.voxels.over(around));
    let is_near = |other: &ObjectVoxels| {
        let near = other.voxels.over(around.intersection(&other.voxels.window()));
        distances.least(&near).is_some_and(|squared| squared <= (reach * reach) as u32)
    };
    let mut others = truth.objects.iter().enumerate();
    let is_mounted =
        others.any(|(other, object)| other != index && object.role != Role::Human && is_near(object));
    (!is_mounted).then(|| {
        format!(
            "robot {:?} floats: it begins {above_m:.2} m above the floor, and nothing is near it: mend its position_m, \
             or model what it stands on or hangs from",
            robot.name
        )
    })
}
