//! An object of a scene: its surface, where it is, and what it stands for.

use glam::{DQuat, DVec3};

use super::person::PersonKeys;
use super::surface::{refuse_strange_keys, surface};
use super::{ObjectFile, rotation, timeline};
use crate::diagnostics::Place;
use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_scene::objects::spec::{MotionSpec, NodeRule, ObjectSpec, SurfaceSpec};
use perirobot_scene::objects::{Interior, ObjectCarrier, Optical, RadarOptics, Role};

/// The names of the objects that are on a link of a robot, or on such an object.
pub(super) fn on_robots(entries: &[ObjectFile]) -> Vec<String> {
    let carrier = |entry: &&ObjectFile| {
        let on = entry.on.as_ref()?;
        entries.iter().find(|other| other.name == on.object)
    };
    let chain = |entry| std::iter::successors(Some(entry), carrier).take(entries.len());
    let is_on_link = |entry: &ObjectFile| entry.on.as_ref().is_some_and(|on| on.link.is_some());
    let on_robots = entries.iter().filter(|entry| chain(*entry).any(is_on_link));
    on_robots.map(|entry| entry.name.clone()).collect()
}

pub(super) fn check(
    at: &Place,
    entry: ObjectFile,
    default_interior: Interior,
    on_robots: &[String],
) -> Result<ObjectSpec> {
    let at = &at.key(&format!("object {:?}", entry.name));
    let person =
        PersonKeys { layout: entry.layout, unit: entry.unit, up: entry.up, bones: entry.bones.as_ref() };
    let surface = surface(at, &entry, &person)?;
    refuse_strange_keys(at, &entry, &surface)?;
    let (position_m, rotation) = pose(at, &entry, &surface)?;
    let interior = interior(at, entry.interior, &surface)?.unwrap_or(default_interior);
    let role = entry.role.unwrap_or_else(|| usual_role(&surface, on_robots.contains(&entry.name)));
    refuse_strange_keypoints(at, &entry, &surface, role, &person)?;
    let keypoints = entry.keypoints.as_ref().map(|path| person.joints(at, "keypoints", path)).transpose()?;
    let has_role = entry.role.is_some();
    refuse_transparent_people(at, &entry, role)?;
    let speed_m_s = entry.speed_m_s.map(|speed| timeline::speed(at, "speed_m_s", speed)).transpose()?;
    let motion = entry
        .snapshots
        .map(|snapshots| timeline::check(at, snapshots, &surface, rotation, &person))
        .transpose()?;
    let motion = motion.unwrap_or_default();
    refuse_strange_carrying(at, entry.on.as_ref(), &motion, has_role)?;
    Ok(ObjectSpec {
        role,
        interior,
        optical: entry.optical.unwrap_or(Optical::Opaque),
        radar: entry.radar.unwrap_or_default(),
        speed_m_s,
        reflectance: reflectance(at, entry.reflectance)?,
        specular: entry.surface,
        shade: 0,
        person_shade: 0,
        tag_only: entry.tag_only,
        on: entry.on,
        position_m,
        rotation,
        surface,
        keypoints,
        nodes: entry.nodes,
        animated: None,
        motion,
        name: entry.name,
    })
}

/// Where it is, and how it is turned.
fn pose(at: &Place, entry: &ObjectFile, surface: &SurfaceSpec) -> Result<(DVec3, DQuat)> {
    let rotation = rotation(at, "", entry.rpy_deg, entry.quaternion)?;
    let position_m = at.vector("position_m", entry.position_m)?;
    let is_moved = position_m != DVec3::ZERO || rotation != DQuat::IDENTITY || entry.on.is_some();
    match is_moved && matches!(surface, SurfaceSpec::Octomap(_)) {
        true => Err(at
            .says("an octomap stays where it is")
            .with_advice("its voxels are the grid's; take its pose away")),
        false => Ok((position_m, rotation)),
    }
}

/// Refuses people through whom radar passes, in the object itself and in its parts.
fn refuse_transparent_people(at: &Place, entry: &ObjectFile, role: Role) -> Result<()> {
    let passes = |radar: Option<RadarOptics>| radar == Some(RadarOptics::Passes);
    let rule = "does not belong to a person: radar stops at people";
    if role == Role::Human && passes(entry.radar) {
        return Err(at.wrong("radar", "\"passes\"", rule));
    }
    let is_wrong = |node: &&NodeRule| {
        node.role.unwrap_or(role) == Role::Human && passes(node.radar.or(entry.radar)) && !node.ignore
    };
    match entry.nodes.iter().find(is_wrong) {
        Some(node) => Err(at.key(&format!("nodes {:?}", node.name())).wrong("radar", "\"passes\"", rule)),
        None => Ok(()),
    }
}

/// The share of light that it reflects.
fn reflectance(at: &Place, share: Option<f64>) -> Result<Option<f64>> {
    match share {
        Some(share) if !(share > 0.0 && share <= 1.0) => {
            let rule = match (1.0..=100.0).contains(&share) {
                true => format!("must be a share from 0 to 1: {share} % is {}", share / 100.0),
                false => "must be the share of light that it reflects, above 0 and up to 1".into(),
            };
            Err(at.wrong("reflectance", share, &rule))
        }
        share => Ok(share),
    }
}

/// What its inside is; `None` if the scene decides.
fn interior(at: &Place, said: Option<Interior>, surface: &SurfaceSpec) -> Result<Option<Interior>> {
    match (surface, said) {
        (SurfaceSpec::Room { .. }, Some(_)) => {
            Err(at.says("interior does not belong to a room").with_advice("it is the cell"))
        }
        // The cell is inside the room, so a room has no interior of its own. A map mostly shows a whole cell: its closed
        // walls are no body either, unless `interior` says so.
        (SurfaceSpec::Room { .. } | SurfaceSpec::Octomap(_), None) => Ok(Some(Interior::Free)),
        (_, said) => Ok(said),
    }
}

/// Refuses moments of carrying without a carrier, and a role that nobody decided of what is put down.
fn refuse_strange_carrying(
    at: &Place,
    on: Option<&ObjectCarrier>,
    motion: &MotionSpec,
    has_role: bool,
) -> Result<()> {
    match on {
        None if !motion.carried.is_empty() => Err(at
            .key("snapshots")
            .says("carried belongs to an object on another one")
            .with_advice("add on = { object = \"robot\", link = \"tool0\" }, or on = { object = \"cart\" }")),
        Some(_) if motion.carried.contains(&false) && !has_role => {
            Err(at.wrap(Issue::missing("role")).with_advice(
                "it is put down at some moments: say role = \"environment\", or \"robot\" if people must also keep away \
                 from it then",
            ))
        }
        Some(_) if motion.carried.contains(&false) && motion.carried.contains(&true) && motion.position_m.is_empty() => {
            Err(at.key("snapshots").wrap(Issue::missing("position_m")).with_advice(
                "give a place for each moment: in the link's frame where it is carried, in the world where it is not",
            ))
        }
        _ => Ok(()),
    }
}

/// Refuses objects that are carried by none of these names, or by each other.
pub(super) fn check_carriers(at: &Place, names: &[String], objects: &[ObjectSpec]) -> Result<()> {
    for object in objects {
        let Some(on) = &object.on else { continue };
        let known: Vec<&String> = names.iter().filter(|name| **name != object.name).collect();
        if !names.contains(&on.object) {
            let at = at.key(&format!("object {:?}", object.name)).key("on");
            let rule = format!("must be another object of the scene: {known:?}");
            return Err(at.wrong("object", format!("{:?}", on.object), &rule));
        }
    }
    let carrier = |object: &ObjectSpec| {
        let on = object.on.as_ref()?;
        objects.iter().find(|other| other.name == on.object)
    };
    // A chain of carriers that is longer than the scene has a circle.
    let ends = |object: &&ObjectSpec| {
        std::iter::successors(Some(*object), |object| carrier(object)).nth(objects.len()).is_none()
    };
    match objects.iter().find(|object| !ends(object)) {
        Some(object) => Err(at
            .key(&format!("object {:?}", object.name))
            .key("on")
            .says("it is carried by what it carries itself")
            .with_advice("one of them must stand in the world: take its on away")),
        None => Ok(()),
    }
}

/// What an object stands for unless it says so. What a robot carries is as dangerous as the robot.
fn usual_role(surface: &SurfaceSpec, is_on_robot: bool) -> Role {
    match surface {
        SurfaceSpec::Mannequin(_) => Role::Human,
        _ if is_on_robot => Role::Robot,
        SurfaceSpec::Urdf(_) => Role::Robot,
        _ => Role::Environment,
    }
}

/// Refuses joints of what is no person, or has joints of its own.
fn refuse_strange_keypoints(
    at: &Place,
    entry: &ObjectFile,
    surface: &SurfaceSpec,
    role: Role,
    person: &PersonKeys,
) -> Result<()> {
    let moving = entry.snapshots.as_ref().is_some_and(|snapshots| snapshots.keypoints.is_some());
    let has_keypoints = moving || entry.keypoints.is_some();
    if has_keypoints && matches!(surface, SurfaceSpec::Mannequin(_)) {
        return Err(at.wrap(Issue::says("a mannequin's are its own; take them away").with_place("keypoints")));
    }
    person.belong(at, surface, has_keypoints)?;
    let human = role == Role::Human || entry.nodes.iter().any(|rule| rule.role == Some(Role::Human));
    match has_keypoints && !human {
        true => Err(at.says("keypoints are a human's joints").with_advice("add role = \"human\"")),
        false => Ok(()),
    }
}
