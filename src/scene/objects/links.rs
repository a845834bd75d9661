//! The links of robots: where they are, and what is mounted on them.

use glam::DVec3;
use serde::Deserialize;

use super::Scene;
use crate::pose::Pose;
use perirobot_march::error::Issue;

/// A link of a robot, by the robot's name.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MountLink {
    /// The robot's object in the scene.
    pub object: String,
    /// The link's name in the URDF.
    pub link: String,
}

/// What carries an object: a link of a robot, or another object, which goes somewhere.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ObjectCarrier {
    /// Its object in the scene.
    pub object: String,
    /// The link's name in the URDF, if it is a robot.
    pub link: Option<String>,
}

impl ObjectCarrier {
    /// As in a sentence: `link "tool0" of "robot"`.
    pub fn words(&self) -> String {
        match &self.link {
            Some(link) => format!("link {link:?} of {:?}", self.object),
            None => format!("{:?}", self.object),
        }
    }
}

/// The links of a robot where its joint values put them, for what is mounted on them or measured from them.
#[derive(Clone, Debug, PartialEq)]
pub struct Linkage {
    /// Each link's name and its frame in the world; the root is the first.
    pub links: Vec<(String, Pose)>,
    /// Where the robot begins, in the world: what `reach_m` is measured from.
    pub base_m: DVec3,
    /// The farthest from there that the frame of any link can get, whatever the joint values, in metres.
    pub reach_m: f64,
}

impl Linkage {
    /// The frame of a link in the world.
    ///
    /// # Errors
    /// Names the links there are.
    pub fn link(&self, name: &str) -> Result<&Pose, Issue> {
        let found = self.links.iter().find(|(link, _)| link == name).map(|(_, pose)| pose);
        found.ok_or_else(|| unknown_link(name, self.links.iter().map(|(link, _)| link.as_str())))
    }

    /// The same robot, standing somewhere else.
    pub(crate) fn carried_by(&self, frame: &Pose) -> Linkage {
        let links = self.links.iter().map(|(name, pose)| (name.clone(), pose.carried_by(frame)));
        let base = Pose { position_m: self.base_m, ..Pose::ORIGIN };
        Linkage { links: links.collect(), base_m: base.carried_by(frame).position_m, reach_m: self.reach_m }
    }
}

impl Scene {
    /// The frame of a link in the world at this moment.
    ///
    /// # Errors
    /// Names the robots, or the links, there are.
    pub fn link(&self, on: &MountLink) -> Result<Pose, Issue> {
        let robot = self.objects.iter().find(|object| object.name == on.object);
        let linkage = robot.and_then(|object| object.linkage.as_deref()).ok_or_else(|| {
            let robots = self.objects.iter().filter(|object| object.linkage.is_some());
            let robots: Vec<&str> = robots.map(|robot| robot.name.as_str()).collect();
            let rule = "must be a robot with links, an object with urdf = ...";
            Issue::value("object", format!("{:?}", on.object), rule)
                .cure(format!("scene {:?} has {robots:?}", self.name))
        })?;
        linkage.link(&on.link).copied().map_err(|e| e.with_place(format!("link = {:?}", on.link)))
    }

    /// The frame of what carries an object in the world at this moment.
    ///
    /// # Errors
    /// Names the objects, or the links, there are.
    pub fn carrier(&self, on: &ObjectCarrier) -> Result<Pose, Issue> {
        let exactly = self.objects.iter().find(|object| object.name == on.object);
        let part = || self.objects.iter().find(|object| object.is_part_of(&on.object));
        let carrier = exactly.or_else(part).ok_or_else(|| {
            let known: Vec<&str> = self.objects.iter().map(|object| object.name.as_str()).collect();
            Issue::value("object", format!("{:?}", on.object), format!("must be another object: {known:?}"))
        })?;
        match (&carrier.linkage, &on.link) {
            (_, Some(link)) => self.link(&MountLink { object: on.object.clone(), link: link.clone() }),
            (None, None) => Ok(carrier.frame),
            (Some(linkage), None) => {
                let links: Vec<&str> = linkage.links.iter().map(|(name, _)| name.as_str()).collect();
                let advice = format!("{:?} is a robot with the links {}", on.object, links.join(", "));
                Err(Issue::missing("link").with_advice(advice))
            }
        }
    }
}

/// The error for a link that a robot does not have.
pub(crate) fn unknown_link<'a>(name: &str, links: impl Iterator<Item = &'a str>) -> Issue {
    let known = links.collect::<Vec<_>>().join(", ");
    Issue::says(format!("there is no link {name:?}")).cure(format!("there are {known}"))
}
