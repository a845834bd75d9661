//! A small study that asks for the cheapest set that passes.

use super::program::Folder;

/// Cameras around a robot, a shelf and a colleague; a door on the other side.
pub(crate) const STUDY: &str = r#"[grid]
voxel_size_m = 0.1
bounds_m = { min = [-2, -1.5, 0], max = [2, 1.5, 2.2] }
[[scene]]
file = "cell.toml"
[[region]]
name = "robot"
sphere = { center_m = [-1, 0, 0.6], radius_m = 0.8 }
[[sensor]]
name = "camera"
kind = "rgbd"
fov_deg = [110, 90]
resolution_px = [96, 72]
range_m = [0.1, 6.0]
cost = 450
[[sensor.poses]]
name = "wall"
list = [
    { name = "west", position_m = [-1.9, 0, 2.1], facing = [1, 0, 0], tilt_deg = -30 },
    { name = "east", position_m = [1.9, 0, 2.1], facing = [-1, 0, 0], tilt_deg = -30 },
    { name = "north", position_m = [0.1, 1.4, 2.1], facing = [0, -1, 0], tilt_deg = -40 },
    { name = "south", position_m = [0.1, -1.4, 2.1], facing = [0, 1, 0], tilt_deg = -40 },
]
[[sensor]]
name = "narrow"
kind = "rgbd"
fov_deg = [70, 60]
resolution_px = [64, 48]
range_m = [0.1, 6.0]
cost = 250.5
[[sensor.poses]]
name = "corner"
list = [
    { name = "ne", position_m = [1.9, 1.4, 2.1], facing = [-1, -0.6, 0], tilt_deg = -30 },
    { name = "se", position_m = [1.9, -1.4, 2.1], facing = [-1, 0.6, 0], tilt_deg = -30 },
]
[[require]]
name = "nobody comes near"
score = "nearest_unnoticed_m"
at_least = 1.2
under = ["as_planned", "one_sensor_dead"]
[[require]]
name = "the robot's surroundings are known"
score = "unknown"
region = "robot"
at_most = 0.9
[stopping]
formula = "speed_and_separation"
robot_speeds_m_s = [0.25, 0.5, 4.0]
sensor_reaction_s = 0.05
control_reaction_s = 0.05
robot_deceleration_m_s2 = 4.0
intrusion_m = 0.1
person_uncertainty_m = 0.05
robot_uncertainty_m = 0.01
[approach]
hazard = "robot"
min_voxels = 3
[[approach.body]]
name = "standing"
[[approach.entry]]
name = "door"
box = { min_m = [1.2, -1.2, 0], max_m = [2.0, 1.2, 2.0] }
"#;

const SCENE: &str = include_str!("../../scenes/approach/cell.toml");

/// The study in a folder of its own.
pub(crate) fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("cell.toml", SCENE);
    folder.write("study.toml", STUDY);
    folder
}
