//! Warns of what a robot carries: inside of the robot, far away from it, or beyond the reach that a region allows for.

use std::collections::BTreeMap;

use glam::DVec3;

use super::World;
use crate::input::Study;
use perirobot_march::voxel::flood::enclosed_voxels;
use perirobot_march::voxel::{BitGrid, Distances, rounded_up};
use perirobot_scene::objects::spec::ObjectSpec;
use perirobot_scene::objects::{ObjectCarrier, Scene, Surface};
use perirobot_scene::truth::{RegionShape, Truth};

/// With a larger share of its voxels in its robot, an object is inside of it rather than mounted on it.
const INSIDE: f64 = 0.9;
/// What is held is at most so far away, in metres and in voxels.
const HELD_M: f64 = 0.2;
const HELD_VOXELS: i32 = 2;

/// What is wrong with each carried object, each fault once however many snapshots have it.
pub(super) fn warnings(study: &Study, scenes: &[Scene], worlds: &[World]) -> Vec<String> {
    let spec = &study.scenes[worlds[0].scene];
    let carried: Vec<&ObjectSpec> = spec.objects.iter().filter(|object| object.on.is_some()).collect();
    let mut faults: BTreeMap<(usize, &str), (usize, String)> = BTreeMap::new();
    let mut beyond_m = vec![0.0; carried.len()];
    for (snapshot, (scene, world)) in scenes.iter().zip(worlds).enumerate() {
        for (number, object) in carried.iter().enumerate() {
            let now = object.snapshot(snapshot);
            let Some(on) = &now.on else { continue };
            beyond_m[number] = f64::max(beyond_m[number], farthest_from_link(scene, object, on));
            if let Some((kind, what)) = placement(scene, &world.truth(), &carried, number) {
                faults.entry((number, kind)).or_insert((snapshot, what));
            }
        }
    }
    let line = |((number, _), (first, what)): (&(usize, &str), &(usize, String))| {
        let when = if worlds.len() == 1 { String::new() } else { format!(" (first in snapshot {first})") };
        format!("object {:?} {what}{when}", carried[*number].name)
    };
    let mut lines: Vec<String> = faults.iter().map(line).collect();
    for (object, beyond_m) in carried.iter().zip(beyond_m) {
        let on_robot = object.on.as_ref().filter(|on| on.link.is_some());
        lines.extend(on_robot.and_then(|on| short_reach(study, object, on, beyond_m)));
    }
    lines
}

/// The parts of an object, by their places in the scene.
fn parts<'a>(scene: &'a Scene, name: &'a str) -> impl Iterator<Item = usize> + 'a {
    (0..scene.objects.len()).filter(move |&index| scene.objects[index].is_part_of(name))
}

/// How far any point of a carried object is from the frame of its link, in metres.
fn farthest_from_link(scene: &Scene, object: &ObjectSpec, on: &ObjectCarrier) -> f64 {
    let Ok(link) = scene.carrier(on) else { return 0.0 };
    let corners = parts(scene, &object.name).filter_map(|index| match &scene.objects[index].surface {
        Surface::Mesh(mesh) => Some(&mesh.vertices),
        Surface::Voxels { .. } => None,
    });
    corners.flatten().map(|corner: &DVec3| corner.distance(link.position_m)).fold(0.0, f64::max)
}

/// Whether it is inside its robot, or far from it and from what hangs on the same robot.
fn placement(
    scene: &Scene,
    truth: &Truth,
    carried: &[&ObjectSpec],
    number: usize,
) -> Option<(&'static str, String)> {
    let object = carried[number];
    let on = object.on.as_ref()?;
    let mut own = BitGrid::new(truth.grid.window());
    parts(scene, &object.name).for_each(|index| own.add(&truth.objects[index].voxels));
    let robot = scene.objects.iter().position(|part| part.name == on.object)?;
    let robot_voxels = &truth.objects[robot].voxels;
    if own.count() == 0 || robot_voxels.count() == 0 {
        return None;
    }
    let mut hidden = enclosed_voxels(robot_voxels);
    hidden.add(robot_voxels);
    let mut hidden = hidden.to_window(own.window());
    hidden.keep(&own);
    let share = hidden.count() as f64 / own.count() as f64;
    if share > INSIDE {
        let percent = 100.0 * share;
        let what = format!(
            "is inside {:?}, which carries it, with {percent:.0} % of its voxels: move it with position_m, which is in \
             the frame of {}",
            on.object,
            on.words()
        );
        return Some(("inside", what));
    }
    let reach = HELD_VOXELS.max((HELD_M / truth.grid.voxel_size_m).ceil() as i32);
    let around = own.trim().bounds().grown(reach).intersection(&truth.grid.window());
    let distances = Distances::from_set(&own.to_window(around));
    let is_near = |&index: &usize| {
        let voxels = &truth.objects[index].voxels;
        let near = voxels.to_window(around.intersection(&voxels.window()));
        distances.least(&near).is_some_and(|squared| squared <= (reach * reach) as u32)
    };
    let others = carried.iter().filter(|other| other.name != object.name);
    let mut holders = others.flat_map(|other| parts(scene, &other.name)).chain([robot]);
    holders.all(|index| !is_near(&index)).then(|| {
        let what = format!(
            "is carried by {:?}, but is more than {HELD_M} m away from it: position_m is in the frame of {}, not in the \
             world",
            on.object,
            on.words()
        );
        ("far", what)
    })
}

/// Regions of a robot's reach that what it carries may leave.
fn short_reach(study: &Study, object: &ObjectSpec, on: &ObjectCarrier, beyond_m: f64) -> Option<String> {
    study.regions.iter().find_map(|(name, spec)| match spec.robot_reach() {
        Some(RegionShape::RobotReach { object: robot, tool_m, .. })
            if robot.as_ref().is_none_or(|robot| *robot == on.object) && beyond_m > tool_m + 1e-6 =>
        {
            let needed = rounded_up(beyond_m, 2);
            Some(format!(
                "region {name:?}: {:?} gets up to {needed} m from {} that carries it, and \
                 robot_reach.tool_m is {tool_m}: write tool_m = {needed} for all that it can reach",
                object.name,
                on.words()
            ))
        }
        _ => None,
    })
}
