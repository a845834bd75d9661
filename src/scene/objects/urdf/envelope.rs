//! All that a robot reaches whatever its joint values, each within its limits: from the tips of its links to the root, what
//! hangs on a joint is turned or slid as far as the joint goes. Joints count as independent, also where the robot would hit
//! itself, so that more is reached than the robot can and never less.

mod polar;

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DMat3, DVec3};

use super::kinematics::degrees;
use super::{Joint, JointMotion, RobotModel};
use crate::objects::Mesh;
use perirobot_march::error::Issue;
use polar::{HALF_CELL, PolarSet};

/// Cells of a joint's set are at least this part of the radius around it.
const FINEST: f64 = 1.0 / 160.0;

/// Points of a surface that is sampled are at most this many steps from each other.
const SAMPLED: f64 = 0.8;

/// Limits may be written with fewer digits than those of the URDF.
const SLACK: f64 = 1e-3;

/// Limits that a safety controller keeps the joints within, by the joints' names; others keep those of the URDF.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AxisLimits {
    /// Of joints that turn, in degrees.
    pub limits_deg: BTreeMap<String, [f64; 2]>,
    /// Of joints that slide, in metres.
    pub limits_m: BTreeMap<String, [f64; 2]>,
}

/// The points that a robot reaches, in its own frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Envelope {
    /// Triangles of links that no joint moves, root and all.
    fixed: Mesh,
    /// What hangs on the first joints that move.
    moved: Vec<(DAffine3, PolarSet)>,
    step_m: f64,
    error_m: f64,
}

impl Envelope {
    /// How far a point that is reached may be from the nearest one that [`Envelope::for_each`] gives, in metres.
    pub fn error_m(&self) -> f64 {
        self.error_m
    }

    /// Calls a function with each point.
    pub fn for_each(&self, visit: &mut dyn FnMut(DVec3)) {
        sample(&self.fixed, &DAffine3::IDENTITY, self.step_m, visit);
        for (root_from_set, set) in &self.moved {
            set.for_each(&mut |at| visit(root_from_set.transform_point3(at)));
        }
    }
}

/// What is known while the links are gone through from their tips.
struct Gathered<'a> {
    meshes: &'a [Mesh],
    /// What hangs on each joint that moves, and how far others may be from it.
    sets: &'a [Option<(PolarSet, f64)>],
    tool_m: f64,
    tool_links: &'a [&'a str],
}

impl RobotModel {
    /// All that the links reach, and a tool of any direction on the last ones and on those named. Cells are about `step_m`
    /// long, or larger for a large robot.
    ///
    /// # Errors
    /// When a limit names no joint that moves so, or is wider than the URDF's, and when a joint slides too far.
    pub(crate) fn envelope(
        &self,
        meshes: &[Mesh],
        limits: &AxisLimits,
        (tool_m, tool_links): (f64, &[&str]),
        step_m: f64,
    ) -> Result<Envelope, Issue> {
        self.check_limits(limits)?;
        let mut radii = vec![0.0f64; self.links.len()];
        let mut sets: Vec<Option<(PolarSet, f64)>> = vec![None; self.links.len()];
        // Children come after their parents.
        for link in (0..self.links.len()).rev() {
            let tool = if self.has_tool(link, tool_links) { tool_m } else { 0.0 };
            radii[link] =
                meshes[link].vertices.iter().map(|at| at.length()).fold(radii[link].max(tool), f64::max);
            let Some(joint) = &self.links[link].joint else { continue };
            let moves = self.limits(joint, limits);
            let slid = if let JointMotion::Slide { limits_m, .. } = moves { limits_m } else { [0.0, 0.0] };
            if let Some(axis) = axis_of(&moves) {
                let set_from_link = DAffine3::from_mat3(onto_z(axis));
                let step_m = step_m.max(radii[link] * FINEST);
                let mut set = PolarSet::new(step_m, radii[link], slid).ok_or_else(|| {
                    let what = format!("joint {:?}: slides from {} to {} m", joint.name, slid[0], slid[1]);
                    Issue::too_large(what)
                        .with_advice(format!("limit it, as in limits_m = {{ {} = [0, 1] }}", joint.name))
                })?;
                let error_m = self.gather(
                    link,
                    &set_from_link,
                    &Gathered { meshes, sets: &sets, tool_m, tool_links },
                    step_m,
                    &mut |at| set.add(at),
                );
                match moves {
                    JointMotion::Turn { limits_rad, .. } => set.turn(limits_rad),
                    _ => set.slide(slid),
                }
                sets[link] = Some((set, error_m + HALF_CELL * step_m));
            }
            let travel_m = slid[0].abs().max(slid[1].abs());
            let reached_m = joint.parent_from_joint.translation.length() + travel_m + radii[link];
            radii[joint.parent] = radii[joint.parent].max(reached_m);
        }
        let (mut fixed, mut moved, mut error_m) = (Mesh::default(), Vec::new(), SAMPLED * step_m);
        let mut open = vec![(0, DAffine3::IDENTITY)];
        while let Some((link, root_from_link)) = open.pop() {
            fixed.append(&meshes[link].place(&root_from_link));
            for (child, joint) in self.children(link) {
                let root_from_joint = root_from_link * joint.parent_from_joint;
                match sets[child].take() {
                    None => open.push((child, root_from_joint)),
                    Some((set, error)) => {
                        let joint_from_set =
                            axis_of(&joint.motion).map_or(DMat3::IDENTITY, |axis| onto_z(axis).transpose());
                        moved.push((root_from_joint * DAffine3::from_mat3(joint_from_set), set));
                        error_m = error_m.max(error);
                    }
                }
            }
        }
        Ok(Envelope { fixed, moved, step_m, error_m })
    }

    /// Gives the points of a link and of all that hangs on it, in a frame, and returns how far others may be from them.
    fn gather(
        &self,
        link: usize,
        frame: &DAffine3,
        known: &Gathered,
        step_m: f64,
        add: &mut dyn FnMut(DVec3),
    ) -> f64 {
        let Gathered { meshes, sets, tool_m, tool_links } = *known;
        sample(&meshes[link], frame, step_m, add);
        let mut error_m = SAMPLED * step_m;
        for (child, joint) in self.children(link) {
            let from_joint = *frame * joint.parent_from_joint;
            error_m = error_m.max(match (&sets[child], axis_of(&joint.motion)) {
                (Some((set, error)), Some(axis)) => {
                    let from_set = from_joint * DAffine3::from_mat3(onto_z(axis).transpose());
                    set.for_each(&mut |at| add(from_set.transform_point3(at)));
                    *error
                }
                _ => self.gather(child, &from_joint, known, step_m, add),
            });
        }
        if tool_m > 0.0 && self.has_tool(link, tool_links) {
            sample_ball(frame.translation, tool_m, step_m, add);
        }
        error_m
    }

    /// Whether a tool may be on a link: it is the last of its chain, or one of these.
    fn has_tool(&self, link: usize, tool_links: &[&str]) -> bool {
        self.children(link).next().is_none() || tool_links.contains(&self.links[link].name.as_str())
    }

    fn children(&self, link: usize) -> impl Iterator<Item = (usize, &Joint)> {
        let joints =
            self.links.iter().enumerate().filter_map(|(child, own)| Some((child, own.joint.as_ref()?)));
        joints.filter(move |(_, joint)| joint.parent == link)
    }

    /// How far a joint goes. One that mimics another keeps the limits of the URDF.
    fn limits(&self, joint: &Joint, narrower: &AxisLimits) -> JointMotion {
        match joint.motion {
            JointMotion::Turn { axis, limits_rad } => {
                let own = narrower.limits_deg.get(&joint.name).map(|limits| limits.map(f64::to_radians));
                JointMotion::Turn { axis, limits_rad: own.unwrap_or(limits_rad) }
            }
            JointMotion::Slide { axis, limits_m } => {
                let own = narrower.limits_m.get(&joint.name).copied();
                JointMotion::Slide { axis, limits_m: own.unwrap_or(limits_m) }
            }
            JointMotion::Fixed => JointMotion::Fixed,
        }
    }

    fn check_limits(&self, limits: &AxisLimits) -> Result<(), Issue> {
        let find = |name: &str| self.links.iter().find_map(|l| l.joint.as_ref().filter(|j| j.name == name));
        let turns = limits.limits_deg.iter().map(|named| ("limits_deg", named));
        let slides = limits.limits_m.iter().map(|named| ("limits_m", named));
        for (key, (name, written)) in turns.chain(slides) {
            if let Some(follows) = find(name).and_then(|joint| joint.follows.as_ref()) {
                let wrong = format!("mimics {:?}: limit that joint", follows.joint);
                return Err(Issue::value(format!("{key}.{name}"), format!("{written:?}"), wrong));
            }
            let own = match find(name).map(|joint| &joint.motion) {
                None => Err(format!("{} has no such joint; {}", self.path.display(), self.movable())),
                Some(JointMotion::Turn { limits_rad, .. }) if key == "limits_deg" => {
                    Ok(limits_rad.map(degrees))
                }
                Some(JointMotion::Slide { limits_m, .. }) if key == "limits_m" => Ok(*limits_m),
                Some(JointMotion::Turn { .. }) => Err("turns: write its degrees under limits_deg".into()),
                Some(JointMotion::Slide { .. }) => Err("slides: write its metres under limits_m".into()),
                Some(JointMotion::Fixed) => Err("is a fixed joint: leave it out".into()),
            };
            let is_within = |[low, high]: [f64; 2]| low - SLACK <= written[0] && written[1] <= high + SLACK;
            let wrong = match own {
                Err(wrong) => wrong,
                Ok(_) if written[0].partial_cmp(&written[1]).is_none_or(Ordering::is_gt) => {
                    "must be [lowest, highest]".into()
                }
                Ok(own) if !is_within(own) => {
                    format!("must be within {own:?}, its limits in {}", self.path.display())
                }
                Ok(_) => continue,
            };
            return Err(Issue::value(format!("{key}.{name}"), format!("{written:?}"), wrong));
        }
        Ok(())
    }
}

fn axis_of(motion: &JointMotion) -> Option<DVec3> {
    match *motion {
        JointMotion::Fixed => None,
        JointMotion::Turn { axis, .. } | JointMotion::Slide { axis, .. } => Some(axis),
    }
}

/// A rotation that turns a unit vector to z.
fn onto_z(axis: DVec3) -> DMat3 {
    let (x, y) = axis.any_orthonormal_pair();
    DMat3::from_cols(x, y, axis).transpose()
}

/// Gives points of all triangles, so close to each other that none of their surface is farther than a step away.
fn sample(mesh: &Mesh, frame: &DAffine3, step_m: f64, add: &mut dyn FnMut(DVec3)) {
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|corner| frame.transform_point3(mesh.vertices[corner as usize]));
        let longest_m = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let parts = (longest_m / (SAMPLED * step_m)).ceil().max(1.0) as usize;
        for along in 0..=parts {
            for across in 0..=parts - along {
                let [s, t] = [along, across].map(|part| part as f64 / parts as f64);
                add(a + (b - a) * s + (c - a) * t);
            }
        }
    }
}

/// The same for a ball.
fn sample_ball(center_m: DVec3, radius_m: f64, step_m: f64, add: &mut dyn FnMut(DVec3)) {
    let parts = |length_m: f64| (length_m / (SAMPLED * step_m)).ceil().max(1.0) as usize;
    let rows = parts(PI * radius_m);
    for row in 0..=rows {
        let (sin, cos) = libm::sincos(PI * row as f64 / rows as f64);
        let columns = parts(TAU * radius_m * sin);
        for column in 0..columns {
            let (y, x) = libm::sincos(TAU * column as f64 / columns as f64);
            add(center_m + radius_m * DVec3::new(sin * x, sin * y, cos));
        }
    }
}

#[cfg(test)]
mod tests;
