//! Where the links are when the joints have values, and how far they can get. All in f64 with `libm`'s
//! trigonometry, so that two machines place them alike.

use std::collections::BTreeMap;

use glam::{DAffine3, DMat3, DVec3};

use super::{Follows, Joint, JointMotion, RobotModel};
use crate::objects::Linkage;
use crate::objects::joint_table::AngleUnit;
use crate::pose::{Pose, RotationFrame};
use perirobot_march::Result;
use perirobot_march::error::Issue;

/// A URDF's limits are often written with a few digits of π: 180° must be within 3.14159.
const SLACK_RAD: f64 = 1e-5;
/// The same for prismatic joints, in metres.
const SLACK_M: f64 = 1e-9;

/// Values of the joints by name; a joint without one is at 0, or where the one leads that it mimics.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointValues {
    /// Revolute and continuous joints, in degrees.
    pub angles_deg: BTreeMap<String, f64>,
    /// Prismatic joints, in metres.
    pub travels_m: BTreeMap<String, f64>,
}

impl JointValues {
    /// Takes over other values, which replace those of the same joints.
    pub(crate) fn extend(&mut self, others: JointValues) {
        self.angles_deg.extend(others.angles_deg);
        self.travels_m.extend(others.travels_m);
    }
}

impl RobotModel {
    /// Values that were recorded of joints, sorted into those that turn and those that slide. Joints that mimic others
    /// are passed over, since they go where those lead; so are fixed ones, which some programs record as 0.
    ///
    /// # Errors
    /// When there is no joint of a name.
    pub(crate) fn sort_recorded<'n>(
        &self,
        values: impl Iterator<Item = (&'n str, f64)>,
        angles: AngleUnit,
    ) -> Result<JointValues, Issue> {
        let mut sorted = JointValues::default();
        for (name, value) in values {
            let joint = self.links.iter().find_map(|l| l.joint.as_ref().filter(|j| j.name == name));
            let joint = joint.ok_or_else(|| {
                let what = format!("{} has no such joint; {}", self.path.display(), self.movable());
                Issue::says(format!("column {name:?}")).with_advice(what)
            })?;
            let degrees = if angles == AngleUnit::Rad { value.to_degrees() } else { value };
            match (&joint.motion, &joint.follows) {
                (JointMotion::Fixed, _) | (_, Some(_)) => None,
                (JointMotion::Turn { .. }, None) => sorted.angles_deg.insert(name.into(), degrees),
                (JointMotion::Slide { .. }, None) => sorted.travels_m.insert(name.into(), value),
            };
        }
        Ok(sorted)
    }

    /// A whole turn of a joint that turns without end; `None` of any other.
    pub(crate) fn turn(&self, name: &str, angles: AngleUnit) -> Option<f64> {
        let joint = self.links.iter().find_map(|l| l.joint.as_ref().filter(|j| j.name == name))?;
        let JointMotion::Turn { limits_rad: [lower, upper], .. } = joint.motion else { return None };
        let whole = if angles == AngleUnit::Rad { std::f64::consts::TAU } else { 360.0 };
        (lower.is_infinite() && upper.is_infinite()).then_some(whole)
    }

    /// `root_from_link` for every link, parents before children.
    ///
    /// # Errors
    /// When a value names no joint, or one of the other kind, or is outside its limits, and when a joint
    /// without a value cannot be at 0. Messages begin with the key: `joints_deg.elbow = 200: …`.
    pub(crate) fn pose(&self, values: &JointValues) -> Result<Vec<DAffine3>> {
        self.check_names(values)?;
        let mut root_from_link: Vec<DAffine3> = Vec::with_capacity(self.links.len());
        for link in &self.links {
            let placed = match &link.joint {
                None => DAffine3::IDENTITY,
                Some(joint) => {
                    let moved = self.joint_transform(joint, values)?;
                    root_from_link[joint.parent] * joint.parent_from_joint * moved
                }
            };
            root_from_link.push(placed);
        }
        Ok(root_from_link)
    }

    /// The farthest that the frame of any link can get from the base, whatever the joint values: the greatest
    /// sum, along a chain of joints, of the distances between one joint and the next, and of the travel of
    /// those that slide. The base is the root or, where the root and what follows it have no body, the link
    /// they carry.
    pub(crate) fn reach_m(&self) -> f64 {
        let base = self.base();
        let mut reach_m = vec![0.0f64; self.links.len()];
        for (number, link) in self.links.iter().enumerate().skip(base + 1) {
            let Some(joint) = &link.joint else { continue };
            let travel_m = match joint.motion {
                JointMotion::Slide { limits_m: [lower, upper], .. } => lower.abs().max(upper.abs()),
                JointMotion::Fixed | JointMotion::Turn { .. } => 0.0,
            };
            reach_m[number] = reach_m[joint.parent] + joint.parent_from_joint.translation.length() + travel_m;
        }
        reach_m.into_iter().fold(0.0, f64::max)
    }

    /// The links' poses in the world, with the robot's own frame at `world_from_root`.
    pub(crate) fn linkage(&self, root_from_link: &[DAffine3], world_from_root: &Pose) -> Linkage {
        let pose = |root_from_link: &DAffine3| {
            let position_m =
                world_from_root.rotation * root_from_link.translation + world_from_root.position_m;
            Pose::from_rotation(
                position_m,
                world_from_root.link() * root_from_link.matrix3,
                RotationFrame::Link,
            )
        };
        let links: Vec<(String, Pose)> = self
            .links
            .iter()
            .zip(root_from_link)
            .map(|(link, placed)| (link.name.clone(), pose(placed)))
            .collect();
        let base_m = links[self.base()].1.position_m;
        Linkage { links, base_m, reach_m: self.reach_m() }
    }

    /// Many files begin with an empty `world` that a fixed joint ties to the robot; the robot begins where
    /// that ends.
    fn base(&self) -> usize {
        let is_empty =
            |place: usize| self.links[place].collision.is_empty() && self.links[place].visual.is_empty();
        let mut base = 0;
        loop {
            let mut children = (self.links.iter().enumerate())
                .filter_map(|(place, link)| Some((place, link.joint.as_ref()?)))
                .filter(|(_, joint)| joint.parent == base);
            match (children.next(), children.next()) {
                (Some((only, joint)), None) if joint.motion == JointMotion::Fixed && is_empty(base) => {
                    base = only
                }
                _ => return base,
            }
        }
    }

    fn check_names(&self, values: &JointValues) -> Result<(), Issue> {
        let find = |name: &str| self.links.iter().find_map(|l| l.joint.as_ref().filter(|j| j.name == name));
        let named = values.angles_deg.iter().map(|(name, value)| ("joints_deg", name, value));
        for (key, name, value) in named.chain(values.travels_m.iter().map(|(n, v)| ("joints_m", n, v))) {
            let joint = find(name);
            if let Some(follows) = joint.and_then(|joint| joint.follows.as_ref()) {
                let wrong =
                    format!("mimics {:?}: take its value away, and give that joint one", follows.joint);
                return Err(Issue::value(format!("{key}.{name}"), value, wrong));
            }
            let wrong = match joint.map(|joint| &joint.motion) {
                None => format!("{} has no such joint; {}", self.path.display(), self.movable()),
                Some(JointMotion::Fixed) => "is a fixed joint; take its value away".into(),
                Some(JointMotion::Turn { .. }) if key == "joints_m" => {
                    "turns: write its degrees under joints_deg".into()
                }
                Some(JointMotion::Slide { .. }) if key == "joints_deg" => {
                    "slides: write its metres under joints_m".into()
                }
                Some(_) => continue,
            };
            return Err(Issue::value(format!("{key}.{name}"), value, wrong));
        }
        Ok(())
    }

    pub(super) fn movable(&self) -> String {
        let movable = |joint: &&Joint| joint.motion != JointMotion::Fixed && joint.follows.is_none();
        let names: Vec<&str> = (self.links.iter())
            .filter_map(|link| Some(link.joint.as_ref().filter(movable)?.name.as_str()))
            .collect();
        if names.is_empty() {
            "none of its joints move".into()
        } else {
            format!("there are {}", names.join(", "))
        }
    }

    /// `joint_from_child` for a joint's value.
    fn joint_transform(&self, joint: &Joint, values: &JointValues) -> Result<DAffine3, Issue> {
        match joint.motion {
            JointMotion::Fixed => Ok(DAffine3::IDENTITY),
            JointMotion::Turn { axis, limits_rad } => {
                let angle_rad = self.value(joint, values);
                if !is_within(angle_rad, limits_rad, SLACK_RAD) {
                    let limits_deg = limits_rad.map(degrees);
                    return Err(self.limit_issue(
                        "joints_deg",
                        joint,
                        (values, degrees(angle_rad)),
                        limits_deg,
                        "degrees",
                    ));
                }
                Ok(DAffine3::from_mat3(about(axis, angle_rad)))
            }
            JointMotion::Slide { axis, limits_m } => {
                let travel_m = self.value(joint, values);
                if !is_within(travel_m, limits_m, SLACK_M) {
                    return Err(self.limit_issue("joints_m", joint, (values, travel_m), limits_m, "metres"));
                }
                Ok(DAffine3::from_translation(axis * travel_m))
            }
        }
    }

    /// The value of a joint, in radians or metres: its own, or the one that it mimics.
    fn value(&self, joint: &Joint, values: &JointValues) -> f64 {
        let find = |name: &str| self.links.iter().find_map(|l| l.joint.as_ref().filter(|j| j.name == name));
        match (&joint.follows, joint.motion) {
            (Some(Follows { joint, multiplier, offset }), _) => {
                let leader =
                    find(joint).expect("a robot is made of joints that lead to one that follows none");
                multiplier * self.value(leader, values) + offset
            }
            (None, JointMotion::Turn { .. }) => {
                values.angles_deg.get(&joint.name).copied().unwrap_or(0.0).to_radians()
            }
            (None, _) => values.travels_m.get(&joint.name).copied().unwrap_or(0.0),
        }
    }

    fn limit_issue(
        &self,
        key: &str,
        joint: &Joint,
        (values, reached): (&JointValues, f64),
        limits: [f64; 2],
        unit: &str,
    ) -> Issue {
        let (name, [lower, upper], file) = (&joint.name, limits, self.path.display());
        if let Some(Follows { joint: leader, .. }) = &joint.follows {
            let what = format!("joint {name:?} mimics {leader:?}, and is at {reached} {unit} then");
            return Issue::says(what)
                .with_advice(format!("its limits in {file} are {lower} to {upper} {unit}"))
                .cure(format!("give {leader:?} another value"));
        }
        let given = match joint.motion {
            JointMotion::Turn { .. } => values.angles_deg.get(name).copied(),
            _ => values.travels_m.get(name).copied(),
        };
        match given {
            Some(value) => {
                let rule = format!("must be from {lower} to {upper} {unit}, its limits in {file}");
                Issue::value(format!("{key}.{name}"), value, rule)
            }
            None => Issue::missing(format!("{key}.{name}"))
                .with_advice(format!(
                    "the joint cannot be at 0, its limits in {file} are {lower} to {upper} {unit}"
                ))
                .cure("give it a value"),
        }
    }
}

/// False for NaN.
fn is_within(value: f64, limits: [f64; 2], slack: f64) -> bool {
    value.is_finite() && (limits[0] - slack..=limits[1] + slack).contains(&value)
}

/// Degrees for a message, without the last digits that a product with π leaves.
pub(super) fn degrees(angle_rad: f64) -> f64 {
    (angle_rad.to_degrees() * 1e4).round() / 1e4
}

/// A turn about a unit axis, after Rodrigues.
fn about(axis: DVec3, angle_rad: f64) -> DMat3 {
    let (sin, cos) = libm::sincos(angle_rad);
    let outer = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
    let cross = DMat3::from_cols(
        DVec3::new(0.0, axis.z, -axis.y),
        DVec3::new(-axis.z, 0.0, axis.x),
        DVec3::new(axis.y, -axis.x, 0.0),
    );
    DMat3::IDENTITY * cos + cross * sin + outer * (1.0 - cos)
}

#[cfg(test)]
mod tests;
