//! How an object moves from one snapshot of its scene to the next: lists with an entry a snapshot, checked.

mod walk;

use std::collections::BTreeMap;
use std::path::PathBuf;

use glam::DQuat;
use serde::Deserialize;

use super::person::PersonKeys;
use super::rotation;
use crate::diagnostics::Place;
use crate::input::urdf::joints;
use crate::keys::{AxisValues, NameOrNumber, QuaternionKeys, exactly, numbers};
use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_scene::objects::gltf::WhichClip;
use perirobot_scene::objects::joint_table::{AngleUnit, JointTableFile};
use perirobot_scene::objects::spec::{MotionSpec, ObjectSpec, PersonFile, SurfaceSpec};

/// More snapshots than any recording that is scored one by one.
const MAX_SNAPSHOTS: usize = 10_000;

/// Lists with an entry for each moment of the scene.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct SnapshotsFile {
    /// Where it is, instead of its own position.
    position_m: Option<Vec<Triple>>,
    /// How it is turned, instead of its own rotation.
    rpy_deg: Option<Vec<Triple>>,
    /// The same as quaternions.
    quaternion: Option<Vec<QuaternionKeys>>,
    /// A walk along a path, in place of lists: where it is, which way it faces, and how long at each place.
    walk: Option<WalkFile>,
    /// Whether the link of `on` carries it; at a moment with false its pose is in the world. Default true for all.
    carried: Option<Vec<bool>>,
    /// Files with the joints of a mannequin.
    pub(super) mannequin: Option<Vec<PathBuf>>,
    /// Files with the joints of another person.
    pub(super) keypoints: Option<Vec<PathBuf>>,
    /// Angles of joints, instead of the robot's own.
    joints_deg: Option<Vec<BTreeMap<String, f64>>>,
    /// Travels of sliding joints, instead of the robot's own.
    joints_m: Option<Vec<BTreeMap<String, f64>>>,
    /// Moments of an animation of a .glb or .gltf file, of a .bvh mannequin, or of a table of a robot's joints.
    animation: Option<AnimationFile>,
    /// How long it stays at each, in seconds: weights of the snapshots in weighted means of scores. Those of lists that
    /// are crossed are multiplied. Default all alike.
    dwell_s: Option<Vec<f64>>,
    /// How fast it moves at each, in metres a second, instead of its own speed_m_s.
    speed_m_s: Option<Vec<f64>>,
    /// The lists repeat until the scene's moments are through. Default false.
    #[serde(default)]
    cycle: bool,
    /// Every entry is met with every moment of the rest of the scene, as people at several places with all that a
    /// robot does. Default false.
    #[serde(default)]
    cross: bool,
}

/// A walk, or a drive, along straight lines.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct WalkFile {
    /// Corners of the path, [x, y, z] in metres, at least two.
    path_m: Vec<Triple>,
    /// How far it gets from one moment to the next, in metres.
    step_m: f64,
    /// How fast it goes, in metres a second: decides how long each moment lasts, and which radars detect it. Default 1.6, a person who walks.
    speed_m_s: Option<f64>,
}

#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
struct Triple(#[serde(deserialize_with = "exactly")] [f64; 3]);

/// Moments of what moves: of an animation of a .glb or .gltf file, of motion capture (.bvh), or of a table of a robot's
/// joints.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct AnimationFile {
    /// Its name, or its number in the file, counted from 0; the only one if left out.
    clip: Option<NameOrNumber>,
    /// What a robot did: a CSV file with the columns time_s and, by their names, its joints.
    joints: Option<PathBuf>,
    /// In what that file's angles are; what slides is in metres.
    angles: Option<AngleUnit>,
    /// A list of seconds, or { start, stop, step }.
    times_s: AxisValues,
}

impl From<NameOrNumber> for WhichClip {
    fn from(written: NameOrNumber) -> WhichClip {
        match written {
            NameOrNumber::Name(name) => WhichClip::Named(name),
            NameOrNumber::Number(number) => WhichClip::Number(number),
        }
    }
}

/// Checks `[object.snapshots]` of an object with this surface.
pub(super) fn check(
    at: &Place,
    entry: SnapshotsFile,
    surface: &SurfaceSpec,
    own_rotation: DQuat,
    person: &PersonKeys,
) -> Result<MotionSpec> {
    let at = &at.key("snapshots");
    let walk = entry.walk.as_ref().map(|walk| walk::moments(&at.key("walk"), walk)).transpose()?;
    let has_places = entry.position_m.is_some() || entry.rpy_deg.is_some() || entry.quaternion.is_some();
    if walk.is_some() && (has_places || entry.dwell_s.is_some() || entry.speed_m_s.is_some()) {
        return Err(at
            .says("both walk and a list of positions, rotations, dwell_s or speed_m_s")
            .with_advice("a walk gives all of them"));
    }
    if entry.cycle && entry.cross {
        return Err(at
            .says("both cycle and cross")
            .with_advice("its lists repeat, or are crossed with the others"));
    }
    let turned = entry.rpy_deg.is_some() || entry.quaternion.is_some();
    if matches!(surface, SurfaceSpec::Octomap(_))
        && (entry.position_m.is_some() || turned || entry.walk.is_some())
    {
        return Err(at
            .says("an octomap stays where it is")
            .with_advice("its voxels are the grid's; it can only have keypoints"));
    }
    let joint_table = entry
        .animation
        .as_ref()
        .map(|animation| check_animation(at, animation, surface))
        .transpose()?
        .flatten();
    let (joints_deg, joints_m) = (entry.joints_deg, entry.joints_m);
    if (joints_deg.is_some() || joints_m.is_some()) && !matches!(surface, SurfaceSpec::Urdf(_)) {
        return Err(at.says("joints_deg and joints_m belong to a urdf"));
    }
    if (joints_deg.is_some() || joints_m.is_some()) && joint_table.is_some() {
        return Err(at.says("both animation.joints and a list of joints").with_advice("give one"));
    }
    if let (Some(deg), Some(m)) = (&joints_deg, &joints_m)
        && deg.len() != m.len()
    {
        let (deg, m) = (deg.len(), m.len());
        return Err(at
            .says(format!("joints_deg has {deg} entries and joints_m {m}"))
            .with_advice("give both for each snapshot"));
    }
    if entry.rpy_deg.is_some() && entry.quaternion.is_some() {
        return Err(at.says("both rpy_deg and quaternion").with_advice("give one rotation"));
    }
    let files = |key, list: Option<Vec<PathBuf>>| {
        let list = check_filled(at, key, list)?.into_iter().enumerate();
        list.map(|(i, path)| person.joints(at, &format!("{key}[{i}]"), &path)).collect::<Result<_>>()
    };
    let position_m = check_filled(at, "position_m", entry.position_m)?;
    let rpy_deg =
        check_filled(at, "rpy_deg", entry.rpy_deg)?.into_iter().map(|Triple(rpy)| (Some(rpy), None));
    let quaternion = check_filled(at, "quaternion", entry.quaternion)?.into_iter().map(|q| (None, Some(q)));
    let times_s = entry
        .animation
        .as_ref()
        .map(|animation| numbers(&at.key("animation"), "times_s", &animation.times_s));
    let joints_deg = check_filled(at, "joints_deg", joints_deg)?;
    let joints_m = check_filled(at, "joints_m", joints_m)?;
    let states = 0..joints_deg.len().max(joints_m.len());
    let joints =
        check_each(states, |i, _| joints(&at.key(&format!("[{i}]")), joints_deg.get(i), joints_m.get(i)))?;
    let mut motion = MotionSpec {
        position_m: check_each(position_m, |i, Triple(p)| at.vector(&format!("position_m[{i}]"), p))?,
        rotation: check_each(rpy_deg.chain(quaternion), |i, (rpy, quaternion)| {
            rotation(at, &format!("[{i}]"), rpy, quaternion)
        })?,
        carried: check_filled(at, "carried", entry.carried)?,
        mannequin: files("mannequin", entry.mannequin)?,
        keypoints: files("keypoints", entry.keypoints)?,
        joints,
        clip: entry.animation.and_then(|animation| animation.clip).map_or(WhichClip::Only, WhichClip::from),
        joint_table,
        times_s: times_s.transpose()?.unwrap_or_default(),
        dwell_s: check_each(check_filled(at, "dwell_s", entry.dwell_s)?, |i, seconds| {
            at.number(&format!("dwell_s[{i}]"), seconds, 0.0..=1e9, "seconds from 0 to 1000000000")
        })?,
        speed_m_s: check_each(check_filled(at, "speed_m_s", entry.speed_m_s)?, |i, speed_m_s| {
            speed(at, &format!("speed_m_s[{i}]"), speed_m_s)
        })?,
        cycle: entry.cycle,
        cross: entry.cross,
    };
    if let Some(walk) = walk {
        motion.position_m = walk.position_m;
        motion.rotation = walk.heading.into_iter().map(|heading| heading * own_rotation).collect();
        motion.speed_m_s = vec![walk.speed_m_s; walk.dwell_s.len()];
        motion.dwell_s = walk.dwell_s;
    }
    match motion.lists().into_iter().find(|(_, length)| *length > MAX_SNAPSHOTS) {
        _ if motion.lists().iter().all(|(key, _)| NO_MOTION.contains(key)) => {
            Err(at.says("no list").with_advice(
                "give at least one of walk, position_m, rpy_deg, quaternion, carried, mannequin, keypoints, \
                joints_deg, joints_m, animation",
            ))
        }
        Some((key, length)) => {
            Err(at.wrong(key, format!("({length} entries)"), &format!("must have at most {MAX_SNAPSHOTS}")))
        }
        None => Ok(motion),
    }
}

/// Lists that move nothing by themselves.
const NO_MOTION: [&str; 2] = ["dwell_s", "speed_m_s"];

/// A speed of an object.
pub(super) fn speed(at: &Place, key: &str, speed_m_s: f64) -> Result<f64> {
    at.number(key, speed_m_s, 0.0..=100.0, "a speed in metres a second from 0 to 100")
}

/// Checks `animation` of an object with this surface; of a robot it is a table of joints.
fn check_animation(
    at: &Place,
    entry: &AnimationFile,
    surface: &SurfaceSpec,
) -> Result<Option<JointTableFile>> {
    let of = &at.key("animation");
    match (surface, &entry.joints, entry.angles) {
        (SurfaceSpec::Urdf(_), Some(joints), Some(angles)) => {
            Ok(Some(JointTableFile { path: at.folder().join(joints), angles }))
        }
        (SurfaceSpec::Urdf(_), Some(_), None) => Err(of
            .wrap(Issue::missing("angles"))
            .with_advice("add angles = \"rad\" (as ROS records them) or \"deg\"")),
        (SurfaceSpec::Urdf(_), None, _) => {
            Err(of.wrap(Issue::missing("joints")).with_advice("name a table of its joints over time (.csv)"))
        }
        (_, None, None) if surface.gltf().is_some() => Ok(None),
        (SurfaceSpec::Mannequin(PersonFile::Motion(_)), None, None) if entry.clip.is_none() => Ok(None),
        (SurfaceSpec::Mannequin(PersonFile::Motion(_)), None, None) => {
            Err(of.says("clip belongs to a .glb or .gltf mesh").with_advice("a .bvh file has one motion"))
        }
        (_, None, None) => {
            let what = "animation belongs to a .glb or .gltf mesh, a .bvh mannequin or a urdf with a table of joints";
            Err(at.says(what))
        }
        _ => Err(of.says("joints and angles belong to a urdf")),
    }
}

fn check_each<T, U>(
    list: impl IntoIterator<Item = T>,
    check: impl Fn(usize, T) -> Result<U>,
) -> Result<Vec<U>> {
    list.into_iter().enumerate().map(|(i, entry)| check(i, entry)).collect()
}

/// A list that has entries if it is given.
fn check_filled<T>(at: &Place, key: &str, list: Option<Vec<T>>) -> Result<Vec<T>> {
    match list {
        Some(list) if list.is_empty() => {
            Err(at.wrong(key, "[]", "must have one entry a snapshot, or be left out"))
        }
        list => Ok(list.unwrap_or_default()),
    }
}

/// How many snapshots the objects of a scene make, after the lists of objects that are crossed with the rest were
/// written out.
pub(super) fn count(at: &Place, objects: &mut [ObjectSpec]) -> Result<usize> {
    let mut count = count_of_rest(at, objects)?;
    let (crossed, rest): (Vec<&mut ObjectSpec>, Vec<_>) =
        objects.iter_mut().partition(|object| object.motion.cross);
    if crossed.is_empty() {
        return Ok(count);
    }
    // Lists that repeat begin again with each entry that is crossed.
    rest.into_iter().for_each(|object| write_out(&mut object.motion, ListExpansion::Again(count)));
    for object in crossed {
        let lists = object.motion.lists();
        let (first_key, entries) = lists[0];
        let at = at.key(&format!("object {:?}", object.name)).key("snapshots");
        if let Some((key, length)) = lists.iter().find(|(_, length)| *length != entries) {
            let what = format!("{key} has {length} entries, but {first_key} has {entries}");
            return Err(at
                .says(what)
                .with_advice("all lists of an object that is crossed must be equally long"));
        }
        if count * entries > MAX_SNAPSHOTS {
            let what = format!("its {entries} entries make {} snapshots with the rest", count * entries);
            return Err(at.says(what).with_advice(format!("at most {MAX_SNAPSHOTS} can be")));
        }
        write_out(&mut object.motion, ListExpansion::Long(count));
        count *= entries;
    }
    Ok(count)
}

/// How long each of so many snapshots lasts, if an object says so: as long as the one object that is not crossed
/// says, times what each says that is.
pub(super) fn dwell_s(at: &Place, objects: &[ObjectSpec], snapshots: usize) -> Result<Option<Vec<f64>>> {
    let say = || objects.iter().filter(|object| !object.motion.dwell_s.is_empty());
    let alone = say().find(|object| !object.motion.cross);
    let differs = |first: &&ObjectSpec, other: &ObjectSpec| {
        !other.motion.cross && other.motion.dwell_s != first.motion.dwell_s
    };
    if let Some((first, second)) =
        alone.and_then(|first| Some((first, say().find(|other| differs(&first, other))?)))
    {
        let what = format!(
            "objects {:?} and {:?} both have snapshots.dwell_s or a walk, and other durations",
            first.name, second.name
        );
        return Err(at.says(what).with_advice(
            "they pass through their snapshots together: let one of them say how long each lasts",
        ));
    }
    if say().next().is_none() {
        return Ok(None);
    }
    let of = |snapshot: usize| -> f64 {
        let weighing = say().filter(|object| object.motion.cross).chain(alone);
        weighing.map(|object| object.motion.dwell_s[snapshot % object.motion.dwell_s.len()]).product()
    };
    let all: Vec<f64> = (0..snapshots).map(of).collect();
    match all.iter().sum::<f64>() > 0.0 {
        true => Ok(Some(all)),
        false => Err(at
            .says("snapshots.dwell_s is 0 for every snapshot")
            .with_advice("give the time at one of them at least")),
    }
}

/// How a list is written out.
#[derive(Clone, Copy)]
enum ListExpansion {
    /// From the beginning again, until it has so many entries.
    Again(usize),
    /// Each entry so many times.
    Long(usize),
}

impl ListExpansion {
    fn expand<T: Clone>(self, list: &mut Vec<T>) {
        *list = match self {
            ListExpansion::Again(count) => {
                list.iter().cycle().take(if list.is_empty() { 0 } else { count }).cloned().collect()
            }
            ListExpansion::Long(count) => list.iter().flat_map(|entry| vec![entry.clone(); count]).collect(),
        };
    }
}

/// Writes out all lists of a motion.
fn write_out(motion: &mut MotionSpec, how: ListExpansion) {
    how.expand(&mut motion.position_m);
    how.expand(&mut motion.rotation);
    how.expand(&mut motion.carried);
    how.expand(&mut motion.mannequin);
    how.expand(&mut motion.keypoints);
    how.expand(&mut motion.joints);
    how.expand(&mut motion.times_s);
    how.expand(&mut motion.dwell_s);
    how.expand(&mut motion.speed_m_s);
}

/// How many snapshots the objects make that are not crossed: the common length of all lists that do not repeat, else
/// the longest that does, else one.
fn count_of_rest(at: &Place, objects: &[ObjectSpec]) -> Result<usize> {
    let lists = |cycle: bool| {
        let rest = objects.iter().filter(|object| !object.motion.cross);
        let moving = rest.filter(move |object| object.motion.cycle == cycle);
        moving.flat_map(|o| o.motion.lists().into_iter().map(|(key, length)| (o.name.as_str(), key, length)))
    };
    let Some((first, first_key, count)) = lists(false).next() else {
        return Ok(lists(true).map(|(_, _, length)| length).max().unwrap_or(1));
    };
    let says = |name: &str, key: &str, length: usize, cure: &str| {
        let at = at.key(&format!("object {name:?}")).key("snapshots");
        let other = format!("object {first:?}.snapshots.{first_key} has {count}");
        Err(at.says(format!("{key} has {length} entries, but {other}")).with_advice(cure))
    };
    if let Some((name, key, length)) = lists(false).find(|&(_, _, length)| length != count) {
        let cure =
            "all lists of a scene must be equally long, or those of an object repeat with cycle = true";
        return says(name, key, length, cure);
    }
    if let Some((name, key, length)) = lists(true).find(|&(_, _, length)| length > count) {
        return says(name, key, length, "the rest of a list that repeats would never be seen; shorten it");
    }
    Ok(count)
}

#[cfg(test)]
mod built_tests;
#[cfg(test)]
mod tests;
