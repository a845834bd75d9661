//! Turns what a file says into a checked tree of links: one root, no loops, unique names, supported
//! joints, finite numbers.

use std::collections::{HashMap, HashSet, VecDeque};

use glam::{DAffine3, DVec3};

use super::document::{self, Geometry, JointKind, OriginElement, Robot};
use super::{Follows, Joint, JointMotion, Link, LinkShape, PlacedShape};
use perirobot_march::error::Issue;

/// No length or distance is larger; beyond it there are slips of the pen.
const FARTHEST_M: f64 = 1e6;
/// Nor is a body smaller.
const SMALLEST_M: f64 = 1e-6;

/// The links of a robot, parents before children, and how many bodies without extent were passed over.
pub(super) fn links(robot: &Robot) -> Result<(Vec<Link>, usize), Issue> {
    unique("link", robot.links.iter().map(|l| l.name.as_str()))?;
    unique("joint", robot.joints.iter().map(|j| j.name.as_str()))?;
    let places: HashMap<&str, usize> =
        robot.links.iter().enumerate().map(|(i, l)| (l.name.as_str(), i)).collect();
    // For each link of the file, the joint that holds it and the joints that hang on it.
    let mut held: Vec<Option<usize>> = vec![None; robot.links.len()];
    let mut hanging: Vec<Vec<usize>> = vec![Vec::new(); robot.links.len()];
    for (number, joint) in robot.joints.iter().enumerate() {
        let find = |role: &str, name: &str| {
            let what = || {
                Issue::says(format!("joint {:?}", joint.name))
                    .with_advice(format!("its {role} {name:?} is no link of the file"))
            };
            places.get(name).copied().ok_or_else(what)
        };
        let (parent, child) = (find("parent", &joint.parent)?, find("child", &joint.child)?);
        if let Some(other) = held[child].replace(number) {
            return Err(Issue::says(format!(
                "link {:?} is the child of two joints, {:?} and {:?}",
                robot.links[child].name, robot.joints[other].name, joint.name
            ))
            .with_advice("a link has one"));
        }
        hanging[parent].push(number);
    }
    let root = root(robot, &held)?;

    let mut links: Vec<Link> = Vec::with_capacity(robot.links.len());
    let mut passed_over = 0;
    let mut open = VecDeque::from([(root, None)]);
    while let Some((place, joint)) = open.pop_front() {
        let parent = links.len();
        let entry = &robot.links[place];
        links.push(link(entry, joint)?);
        let read = &links[parent];
        passed_over += entry.collision.len() + entry.visual.len() - read.collision.len() - read.visual.len();
        for &number in &hanging[place] {
            let entry = &robot.joints[number];
            let joint = joint_of(entry, parent)
                .map_err(|issue| issue.with_place(format!("joint {:?}", entry.name)))?;
            open.push_back((places[entry.child.as_str()], Some(joint)));
        }
    }
    // One root and one joint a link: what was not reached hangs on itself.
    if links.len() < robot.links.len() {
        let reached: HashSet<&str> = links.iter().map(|link| link.name.as_str()).collect();
        let lost = robot.links.iter().find(|link| !reached.contains(link.name.as_str()));
        let name = lost.map_or("", |link| link.name.as_str());
        return Err(Issue::says(format!("link {name:?} is among its own ancestors"))
            .with_advice("links must form a tree"));
    }
    check_followers(&links)?;
    Ok((links, passed_over))
}

fn unique<'n>(kind: &str, names: impl Iterator<Item = &'n str>) -> Result<(), Issue> {
    let mut seen = HashSet::new();
    for name in names {
        if name.is_empty() {
            return Err(Issue::says(format!("one of the {kind}s has an empty name")));
        }
        if !seen.insert(name) {
            return Err(
                Issue::says(format!("two {kind}s are named {name:?}")).with_advice("give each its own name")
            );
        }
    }
    Ok(())
}

fn root(robot: &Robot, held: &[Option<usize>]) -> Result<usize, Issue> {
    let mut roots = (0..held.len()).filter(|&place| held[place].is_none());
    match (roots.next(), roots.next()) {
        (Some(root), None) => Ok(root),
        (Some(a), Some(b)) => Err(Issue::says(format!(
            "links {:?} and {:?} both hang on nothing",
            robot.links[a].name, robot.links[b].name
        ))
        .with_advice("join them (a fixed joint does)")),
        (None, _) if robot.links.is_empty() => Err(Issue::says("has no link")),
        (None, _) => {
            Err(Issue::says(format!("link {:?} is among its own ancestors, as all are", robot.links[0].name))
                .with_advice("links must form a tree with one root"))
        }
    }
}

fn link(entry: &document::LinkElement, joint: Option<Joint>) -> Result<Link, Issue> {
    let bodies = |kind: &str, bodies: &[document::LinkBody]| {
        let body = |(number, body): (usize, &document::LinkBody)| {
            let placed = affine(&body.origin).and_then(|link_from_body| {
                Ok(shape(&body.geometry)?.map(|shape| PlacedShape { link_from_body, shape }))
            });
            placed.map_err(|issue| issue.with_place(format!("link {:?}: {kind} {}", entry.name, number + 1)))
        };
        let bodies = bodies.iter().enumerate().filter_map(|entry| body(entry).transpose());
        bodies.collect::<Result<_, _>>()
    };
    let collision = bodies("collision", &entry.collision)?;
    Ok(Link { name: entry.name.clone(), joint, collision, visual: bodies("visual", &entry.visual)? })
}

fn joint_of(entry: &document::JointElement, parent: usize) -> Result<Joint, Issue> {
    let unsupported = |kind: &str, cure: &str| {
        Err(Issue::unsupported(format!("is {kind}, which is not supported")).with_advice(cure))
    };
    let limits = entry.limits;
    let motion = match entry.kind {
        JointKind::Fixed => JointMotion::Fixed,
        JointKind::Revolute => JointMotion::Turn { axis: axis(entry)?, limits_rad: order(limits)? },
        JointKind::Continuous => {
            JointMotion::Turn { axis: axis(entry)?, limits_rad: [f64::NEG_INFINITY, f64::INFINITY] }
        }
        JointKind::Prismatic => {
            if !limits.iter().all(|limit| limit.abs() <= FARTHEST_M) {
                return Err(Issue::says(format!(
                    "its limits {limits:?} must be metres from -{FARTHEST_M} to {FARTHEST_M}"
                )));
            }
            JointMotion::Slide { axis: axis(entry)?, limits_m: order(limits)? }
        }
        JointKind::Floating => {
            return unsupported(
                "floating",
                "make it fixed, and put the pose into <origin> or into the scene file",
            );
        }
        JointKind::Planar => {
            return unsupported(
                "planar",
                "use two prismatic joints and a revolute one, with links without geometry",
            );
        }
        JointKind::Spherical => {
            return unsupported(
                "spherical",
                "use three revolute joints, with links without geometry between them",
            );
        }
    };
    let follows = entry.mimic.as_ref().filter(|_| motion != JointMotion::Fixed).map(follows).transpose()?;
    Ok(Joint { name: entry.name.clone(), parent, parent_from_joint: affine(&entry.origin)?, motion, follows })
}

fn follows(mimic: &document::Mimic) -> Result<Follows, Issue> {
    let [multiplier, offset] = [mimic.multiplier, mimic.offset];
    if ![multiplier, offset].iter().all(|number| number.abs() <= FARTHEST_M) {
        return Err(Issue::says(format!("<mimic multiplier = {multiplier} offset = {offset}>"))
            .with_advice(format!("must be numbers from -{FARTHEST_M} to {FARTHEST_M}")));
    }
    Ok(Follows { joint: mimic.joint.clone(), multiplier, offset })
}

/// Whether each joint that follows another one leads back to one that follows none.
fn check_followers(links: &[Link]) -> Result<(), Issue> {
    let joints: HashMap<&str, &Joint> = links
        .iter()
        .filter_map(|link| link.joint.as_ref())
        .map(|joint| (joint.name.as_str(), joint))
        .collect();
    for joint in joints.values() {
        let wrong = |what: String| Err(Issue::says(what).with_place(format!("joint {:?}", joint.name)));
        let (mut leader, mut steps) = (*joint, 0);
        while let Some(follows) = &leader.follows {
            leader = match joints.get(follows.joint.as_str()) {
                None => return wrong(format!("mimics {:?}, which is no joint of the file", follows.joint)),
                Some(next) if next.motion == JointMotion::Fixed => {
                    return wrong(format!("mimics {:?}, which is fixed", follows.joint));
                }
                Some(next) => next,
            };
            steps += 1;
            if steps > joints.len() {
                return wrong("mimics joints that mimic each other in a ring".into());
            }
        }
    }
    Ok(())
}

fn axis(entry: &document::JointElement) -> Result<DVec3, Issue> {
    let axis = DVec3::from_array(entry.axis);
    let length = axis.length();
    if !(length.is_finite() && length > 1e-9) {
        return Err(Issue::says(format!("<axis xyz = {:?}>", axis.to_array()))
            .with_advice("must be finite and not zero"));
    }
    Ok(axis / length)
}

fn order(limits: [f64; 2]) -> Result<[f64; 2], Issue> {
    if limits[0] <= limits[1] {
        return Ok(limits);
    }
    Err(Issue::says(format!("<limit lower = {} upper = {}>", limits[0], limits[1]))
        .with_advice("lower must not be above upper"))
}

fn affine(origin: &OriginElement) -> Result<DAffine3, Issue> {
    if !origin.xyz.iter().all(|x| x.abs() <= FARTHEST_M) {
        return Err(Issue::says(format!("<origin xyz = {:?}>", origin.xyz))
            .with_advice(format!("must be numbers from -{FARTHEST_M} to {FARTHEST_M}")));
    }
    Ok(DAffine3::from_mat3_translation(origin.rotation, DVec3::from_array(origin.xyz)))
}

/// A shape; none if it has no surface, as a ball of radius 0 has none. A plate without thickness has one.
fn shape(geometry: &Geometry) -> Result<Option<LinkShape>, Issue> {
    let length = |name: &str, value: f64| match value == 0.0 || (SMALLEST_M..=FARTHEST_M).contains(&value) {
        true => Ok(value.max(SMALLEST_M)),
        false => Err(Issue::value(name, value, "must be 0 or a length in metres from 0.000001 to 1000000")),
    };
    let is_nothing = match geometry {
        Geometry::Box { size } => size.iter().filter(|edge| **edge == 0.0).count() > 1,
        Geometry::Mesh { scale, .. } => *scale == [0.0; 3],
        Geometry::Cylinder { radius, .. }
        | Geometry::Capsule { radius, .. }
        | Geometry::Sphere { radius } => *radius == 0.0,
    };
    if is_nothing {
        return Ok(None);
    }
    Ok(Some(match geometry {
        Geometry::Box { size: [x, y, z] } => {
            let edge = |edge: &f64| length("box size", *edge);
            LinkShape::Box { size_m: DVec3::new(edge(x)?, edge(y)?, edge(z)?) }
        }
        Geometry::Cylinder { radius, length: height } => LinkShape::Cylinder {
            radius_m: length("cylinder radius", *radius)?,
            length_m: length("cylinder length", *height)?,
        },
        Geometry::Capsule { radius, length: distance } => LinkShape::Capsule {
            radius_m: length("capsule radius", *radius)?,
            length_m: length("capsule length", *distance)?,
        },
        Geometry::Sphere { radius } => LinkShape::Sphere { radius_m: length("sphere radius", *radius)? },
        Geometry::Mesh { filename, scale } => {
            if scale.iter().any(|s| !(SMALLEST_M..=FARTHEST_M).contains(&s.abs())) {
                return Err(Issue::says(format!("mesh {filename:?} scale = {scale:?}"))
                    .with_advice("none may be zero, nor beyond 0.000001 to 1000000 (a minus mirrors)"));
            }
            LinkShape::Mesh { filename: filename.clone(), scale: DVec3::from_array(*scale) }
        }
    }))
}
