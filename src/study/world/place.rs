//! Where a pose is, in words for people: `left wall, x 0.5 m, 2.2 m high, 30° down`. What it is on is the object whose
//! surface the study names; else the wall, ceiling or floor is taken from the name of the group of poses; where that
//! names none, it is what stands next to the sensor in the first scene. Heights are above the floor that is walked on.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;

use super::World;
use crate::input::{Combination, Study};
use crate::sensor::turned::Turned;
use crate::sensor::{Candidate, GroupSurface, MountLink, Sensor, Setting, Stance};
use perirobot_march::voxel::Grid;
use perirobot_scene::objects::Role;
use perirobot_scene::pose::Pose;
use perirobot_scene::truth::{ObjectVoxels, Truth};

/// A sensor is mounted on a surface that is at most this far away.
const MOUNTED_M: f64 = 0.3;
/// A wall of a room, or of a building in one piece, ends at most this far from a sensor that is mounted on
/// it.
pub(super) const WALL_M: f64 = 0.6;
/// An object as large as this share of the cell along each axis is the room itself.
const ROOM_SHARE: f64 = 0.8;
/// Coordinates in a group that differ by less are one.
const SAME_M: f64 = 1e-6;
/// Angles below this, in degrees, are not told.
const LEVEL_DEG: f64 = 0.05;

/// Steps of a voxel towards each side.
const WAYS: [[i32; 3]; 6] = [[-1, 0, 0], [1, 0, 0], [0, -1, 0], [0, 1, 0], [0, 0, -1], [0, 0, 1]];
/// What a room has there.
const SIDES: [&str; 6] = ["wall at -x", "wall at +x", "wall at -y", "wall at +y", "floor", "ceiling"];
/// The sides of an object that has a sensor outside of it.
const FACING: [&str; 6] = ["-x side", "+x side", "-y side", "+y side", "underside", "top"];
const DOWN: usize = 4;
const UP: usize = 5;

/// The places of a study's poses in one of its scenes.
pub struct Places<'a> {
    study: &'a Study,
    truth: Arc<Truth>,
    room_m: [DVec3; 2],
    floor_m: f64,
    /// Of each sensor, the groups named after a wall, with the axis that the wall is across.
    walls: Vec<HashMap<&'a str, Option<usize>>>,
}

/// What a sensor is mounted on, and which axis its surface is across if that is a wall.
struct Mount {
    words: String,
    across: Option<usize>,
}

impl<'a> Places<'a> {
    /// Of the poses as they are in a world of the study.
    pub fn new(study: &'a Study, world: &'a World) -> Places<'a> {
        let truth = world.truth();
        let room_m = room_m(&truth);
        let walls = study.sensors.iter().map(walls).collect();
        Places { study, truth, room_m, floor_m: world.floor.z_m, walls }
    }

    /// Where a sensor is at a candidate; nothing where it has no place of its own.
    pub fn words(&self, sensor: usize, candidate: usize) -> String {
        let sensor_spec = &self.study.sensors[sensor];
        let Candidate { group, setting, .. } = &sensor_spec.candidates[candidate];
        match (setting, &sensor_spec.on) {
            (Setting::Fixed, None) => String::new(),
            (Setting::Fixed, Some(link)) => carrier(link),
            (Setting::Inflation(metres), _) => format!("on the robot, senses up to {}", length(*metres)),
            (Setting::Pose(pose), Some(link)) => {
                let [x, y, z] = pose.position_m.to_array().map(length);
                let Turned { pan_deg, tilt_deg, roll_deg } = Turned::new(pose);
                let [pan, tilt, roll] = [pan_deg, tilt_deg, roll_deg].map(tenths);
                let rolled = if roll == "0" { String::new() } else { format!(", roll {roll}°") };
                let carrier = carrier(link);
                format!("{carrier} (in its frame x {x}, y {y}, z {z}, pan {pan}°, tilt {tilt}°{rolled})")
            }
            (Setting::Pose(pose), None) => {
                let mount = self.mount(sensor, group, pose.position_m);
                self.describe_in_world(mount, pose, sensor_spec.kind.stance())
            }
        }
    }

    /// Where the sensors of a choice are.
    pub fn describe_choice(&self, combination: &Combination, choice: usize) -> String {
        let members = combination.members.iter().zip(combination.choice(choice));
        let places = members.map(|(member, candidate)| {
            (self.study.sensors[member.sensor].name.as_str(), self.words(member.sensor, candidate))
        });
        join(&places.collect::<Vec<_>>())
    }

    fn describe_in_world(&self, mount: Mount, pose: &Pose, stance: Stance) -> String {
        let at = pose.position_m;
        let mut parts = vec![mount.words];
        let along = [("x", at.x), ("y", at.y)].into_iter().enumerate();
        let told = along.filter(|(axis, _)| mount.across != Some(*axis));
        parts.extend(told.map(|(_, (name, metres))| format!("{name} {}", length(metres))));
        parts.push(format!("{} high", length(at.z - self.floor_m)));
        let inwards_deg = mount.across.map(|axis| {
            let middle = (self.room_m[0][axis] + self.room_m[1][axis]) / 2.0;
            match (axis, at[axis] < middle) {
                (0, true) => 0.0,
                (0, false) => 180.0,
                (_, true) => 90.0,
                (_, false) => -90.0,
            }
        });
        parts.extend(direction(pose, stance, inwards_deg));
        parts.join(", ")
    }

    /// What a sensor of a group is mounted on.
    fn mount(&self, sensor: usize, group: &str, at: DVec3) -> Mount {
        let name = || group.replace('-', " ");
        let mut surfaces = self.study.sensors[sensor].surfaces.iter();
        if let Some(GroupSurface { object, .. }) = surfaces.find(|surface| surface.group == group) {
            return self.mount_on(object, at);
        }
        if let Some(&across) = self.walls[sensor].get(group) {
            return Mount { words: name(), across };
        }
        if ["ceiling", "floor"].iter().any(|surface| group.contains(surface)) {
            return Mount { words: name(), across: None };
        }
        let Some((way, object)) = next_to(&self.truth, at) else {
            return Mount { words: "free-standing".into(), across: None };
        };
        let object = &self.truth.objects[object];
        let words = match (self.is_wall(object, way, at), way) {
            (true, _) => return wall(way),
            (false, DOWN) => format!("on {}", object.name),
            (false, UP) => format!("under {}", object.name),
            (false, _) => format!("at {}", object.name),
        };
        Mount { words, across: None }
    }

    /// The mount of a sensor of which the study says what it is on: a wall of the room, or a side of that object.
    fn mount_on(&self, name: &str, at: DVec3) -> Mount {
        let on = |side: &str| Mount { words: format!("on {name}{side}"), across: None };
        let Some(object) = self.truth.objects.iter().find(|object| object.name == name) else {
            return on("");
        };
        let [low, high] = object.bounds_m;
        // How far the sensor is from each side, inwards and outwards.
        let inwards: [f64; 6] = std::array::from_fn(|way| [at - low, high - at][way % 2][way / 2]);
        let nearest = (0..6).reduce(|a, b| if inwards[b] < inwards[a] { b } else { a });
        match nearest {
            Some(way) if self.is_wall(object, way, at) => wall(way),
            Some(way) if inwards[way] < 0.0 && way != UP => on(&format!(" ({})", FACING[way])),
            _ => on(""),
        }
    }

    /// Whether what is on this side of a sensor is the room's own wall, floor or ceiling.
    fn is_wall(&self, object: &ObjectVoxels, way: usize, at: DVec3) -> bool {
        let side_m = self.room_m[way % 2][way / 2];
        is_room(object, self.room_m) && (at[way / 2] - side_m).abs() <= WALL_M
    }
}

/// A wall, the floor or the ceiling of the room.
fn wall(way: usize) -> Mount {
    Mount { words: SIDES[way].into(), across: Some(way / 2).filter(|axis| *axis < 2) }
}

/// Whether a pose of a group is mounted on a wall that is this object: the room itself, or what is next to a group named
/// after a wall.
pub(super) fn is_own_wall(truth: &Truth, group: &str, at: DVec3, object: usize) -> bool {
    let is_next = next_to(truth, at).is_some_and(|(_, next)| next == object);
    is_next && (group.contains("wall") || is_room(&truth.objects[object], room_m(truth)))
}

/// The nearest fixture along an axis, by its index, and on which side it is; the first of several.
fn next_to(truth: &Truth, at: DVec3) -> Option<(usize, usize)> {
    let start = Grid::voxel_of(truth.grid.position_q16(at));
    let steps = (MOUNTED_M / truth.grid.voxel_size_m).ceil() as i32;
    let object_at = |voxel: [i32; 3]| {
        if !truth.occupied.get(voxel) {
            return None;
        }
        let mut objects = truth.objects.iter();
        objects.position(|object| object.role == Role::Environment && object.voxels.get(voxel))
    };
    // A sensor inside an object lies on it.
    let inside = object_at(start).map(|object| (DOWN, object));
    inside.or_else(|| {
        (1..=steps).find_map(|step| {
            (0..6).find_map(|way| {
                let voxel = std::array::from_fn(|axis| start[axis] + step * WAYS[way][axis]);
                object_at(voxel).map(|object| (way, object))
            })
        })
    })
}

/// The names of the walls at −x, +x, −y and +y of the room: of the groups of poses there that are named after a wall,
/// and where there are none that of the room's own side, if the cell has walls in one piece.
pub fn names_of_walls(study: &Study, truth: &Truth) -> [Vec<String>; 4] {
    let room_m = room_m(truth);
    let mut names: [Vec<String>; 4] = Default::default();
    for sensor in study.sensors.iter().filter(|sensor| sensor.on.is_none()) {
        let walls = walls(sensor);
        for Candidate { group, setting, .. } in &sensor.candidates {
            let (Setting::Pose(pose), Some(Some(axis))) = (setting, walls.get(group.as_str())) else {
                continue;
            };
            let at = pose.position_m[*axis];
            let way = 2 * axis + usize::from(at > (room_m[0][*axis] + room_m[1][*axis]) / 2.0);
            let name = group.replace('-', " ");
            if (at - room_m[way % 2][*axis]).abs() <= WALL_M && !names[way].contains(&name) {
                names[way].push(name);
            }
        }
    }
    if fixtures(truth).any(|object| is_room(object, room_m)) {
        for (names, side) in names.iter_mut().zip(SIDES).filter(|(names, _)| names.is_empty()) {
            names.push(side.into());
        }
    }
    names
}

/// Whether an object is as large as the cell.
pub fn is_room(object: &ObjectVoxels, room_m: [DVec3; 2]) -> bool {
    let [own, all] = [object.bounds_m, room_m].map(|[low, high]| high - low);
    own.cmpge(all * ROOM_SHARE).all()
}

/// The places of several sensors, each after the sensor's name; of a sensor alone without it.
pub fn join<S: AsRef<str>>(places: &[(&str, S)]) -> String {
    if let [(_, place)] = places {
        return place.as_ref().to_string();
    }
    let told = places.iter().filter(|(_, place)| !place.as_ref().is_empty());
    told.map(|(sensor, place)| format!("{sensor}: {}", place.as_ref())).collect::<Vec<_>>().join("; ")
}

/// The groups of a sensor that are named after a wall, with the axis on which all poses of the group are at
/// one place.
fn walls(sensor: &Sensor) -> HashMap<&str, Option<usize>> {
    let mut ranges: HashMap<&str, [DVec3; 2]> = HashMap::new();
    for Candidate { group, setting, .. } in &sensor.candidates {
        if let Setting::Pose(pose) = setting
            && group.contains("wall")
        {
            let at = pose.position_m;
            let [low, high] = ranges.entry(group).or_insert([at; 2]);
            (*low, *high) = (low.min(at), high.max(at));
        }
    }
    let across = |[low, high]: [DVec3; 2]| match [0, 1].map(|axis| high[axis] - low[axis] < SAME_M) {
        [true, false] => Some(0),
        [false, true] => Some(1),
        _ => None,
    };
    ranges.into_iter().map(|(group, range)| (group, across(range))).collect()
}

/// Lowest and highest corner of all that is not robot or human, in metres: walls, floor and ceiling, where
/// the scene has them. Of the grid where it has nothing else.
pub fn room_m(truth: &Truth) -> [DVec3; 2] {
    let corners = fixtures(truth).map(|object| object.bounds_m);
    let end = truth.grid.window().end();
    let whole = || [truth.grid.corner_m([0; 3]), truth.grid.corner_m(end)];
    corners.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]).unwrap_or_else(whole)
}

fn fixtures(truth: &Truth) -> impl Iterator<Item = &ObjectVoxels> {
    truth.objects.iter().map(AsRef::as_ref).filter(|object| object.role == Role::Environment)
}

fn carrier(MountLink { object, link }: &MountLink) -> String {
    let article = if object == "robot" { "the " } else { "" };
    format!("on {article}{object}'s {link}")
}

/// How a sensor is turned. The pan of a sensor that looks straight away from its wall is left out, and so are
/// tilt and roll of 0.
fn direction(pose: &Pose, stance: Stance, inwards_deg: Option<f64>) -> Option<String> {
    let Turned { pan_deg, tilt_deg, roll_deg } = Turned::new(pose);
    let is_vertical = tilt_deg.abs() > 90.0 - LEVEL_DEG;
    let usual_deg = match stance {
        Stance::Facing if !is_vertical => inwards_deg,
        _ => Some(0.0),
    };
    let mut parts = Vec::new();
    // 180° and -180° are one.
    let is_usual = |usual: f64| ((pan_deg - usual + 180.0).rem_euclid(360.0) - 180.0).abs() < LEVEL_DEG;
    if !usual_deg.is_some_and(is_usual) {
        parts.push(format!("pan {}°", tenths(pan_deg)));
    }
    match tilt_deg {
        _ if is_vertical => parts.push(if tilt_deg < 0.0 { "straight down" } else { "straight up" }.into()),
        up if up >= LEVEL_DEG => parts.push(format!("{}° up", tenths(up))),
        down if down <= -LEVEL_DEG => parts.push(format!("{}° down", tenths(-down))),
        _ if stance == Stance::Level => {}
        _ => parts.push("level".into()),
    }
    if roll_deg.abs() >= LEVEL_DEG {
        parts.push(format!("roll {}°", tenths(roll_deg)));
    }
    (!parts.is_empty()).then(|| parts.join(", "))
}

/// Degrees with one decimal where that is not 0.
fn tenths(degrees: f64) -> String {
    let text = format!("{degrees:.1}");
    text.strip_suffix(".0").map_or(text.clone(), String::from)
}

/// Metres with one decimal, or two where the second is not 0.
fn length(metres: f64) -> String {
    let cm = (metres * 100.0).round() + 0.0;
    if cm % 10.0 == 0.0 { format!("{:.1} m", cm / 100.0) } else { format!("{:.2} m", cm / 100.0) }
}

#[cfg(test)]
mod tests;
