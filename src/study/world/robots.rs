//! Warns of robots that float: a robot stands on something or hangs from something.

use super::World;
use crate::input::Study;
use perirobot_march::voxel::Distances;
use perirobot_scene::objects::{Role, Scene};
use perirobot_scene::truth::{ObjectVoxels, RegionShape, SafetyPlane, Truth};

/// A robot that is this near to anything, or to the floor, is mounted there, in metres and in voxels.
const MOUNTED_M: f64 = 0.2;
const MOUNTED_VOXELS: i32 = 2;

/// What is wrong with each robot of a scene, at its first moment. Robots that hold each other up float together.
pub(super) fn warnings(scene: &Scene, world: &World) -> Vec<String> {
    let truth = world.truth();
    let above_m = |robot: usize| truth.objects[robot].bounds_m[0].z - world.floor.z_m;
    let is_raised = |&robot: &usize| {
        let (object, voxels) = (&scene.objects[robot], &truth.objects[robot].voxels);
        let is_robot = object.role == Role::Robot && !object.tag_only;
        is_robot && !voxels.is_empty() && above_m(robot) > MOUNTED_M
    };
    let raised = (0..scene.objects.len()).filter(is_raised);
    let mut floating: Vec<(usize, Vec<usize>)> =
        raised.map(|robot| (robot, neighbours(&truth, robot))).collect();
    loop {
        let before: Vec<usize> = floating.iter().map(|(robot, _)| *robot).collect();
        floating.retain(|(_, near)| near.iter().all(|other| before.contains(other)));
        if floating.len() == before.len() {
            break;
        }
    }
    let line = |(robot, near): &(usize, Vec<usize>)| {
        let with = near.iter().map(|&other| format!("{:?}", truth.objects[other].name));
        let with = with.collect::<Vec<_>>().join(", ");
        let support = match with.is_empty() {
            true => "nothing is near it".into(),
            false => format!("only {with} is near it, which also floats"),
        };
        format!(
            "robot {:?} floats: it begins {:.2} m above the floor, and {support}: correct its position_m, or model what it \
             stands on or hangs from",
            truth.objects[*robot].name,
            above_m(*robot)
        )
    };
    floating.iter().map(line).collect()
}

/// Safety planes of regions that have the base of their robot behind them.
pub(super) fn planes_before_robots(study: &Study, world: &World) -> Vec<String> {
    let truth = world.truth();
    let mut lines = Vec::new();
    for (name, spec) in &study.regions {
        let Some(RegionShape::RobotReach { object, planes, .. }) = spec.robot_reach() else { continue };
        let is_meant = |robot: &ObjectVoxels| object.as_ref().is_none_or(|object| robot.name == *object);
        for robot in truth.objects.iter().filter(|robot| is_meant(robot)) {
            let Some(reach) = robot.reach else { continue };
            let is_behind = |plane: &SafetyPlane| plane.normal.dot(reach.base_m - plane.point_m) < 0.0;
            lines.extend(planes.iter().position(is_behind).map(|number| {
                format!(
                    "region {name:?}: the base of {:?} is behind robot_reach.planes[{number}]: does its normal point to the side \
                     on which the robot stays?",
                    robot.name
                )
            }));
        }
    }
    lines
}

/// The objects near a robot that may carry it.
fn neighbours(truth: &Truth, robot: usize) -> Vec<usize> {
    let reach = MOUNTED_VOXELS.max((MOUNTED_M / truth.grid.voxel_size_m).ceil() as i32);
    let own = &truth.objects[robot].voxels;
    let around = own.bounds().grown(reach).intersection(&truth.grid.window());
    let distances = Distances::from_set(&own.to_window(around));
    let is_near = |other: &ObjectVoxels| {
        let near = other.voxels.to_window(around.intersection(&other.voxels.window()));
        distances.least(&near).is_some_and(|squared| squared <= (reach * reach) as u32)
    };
    let others = truth.objects.iter().enumerate().filter(|(other, _)| *other != robot);
    let carrying = others.filter(|(_, object)| object.role != Role::Human && is_near(object));
    carrying.map(|(other, _)| other).collect()
}
