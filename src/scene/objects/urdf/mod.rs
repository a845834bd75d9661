//! Reads a robot from a URDF: its links and joints, where each link is for given joint values, and the bodies
//! that hang on the links.
//!
//! Conventions are those of ROS: metres and radians, z up, roll-pitch-yaw about fixed axes; a mesh's numbers are
//! metres times its `scale`. glTF is turned from y up to z up, as RViz does since 2025; COLLADA's `<unit>` is
//! honoured and its `<up_axis>` is not, as in RViz and MoveIt. Inertia, colours, transmissions and everything that a
//! simulator adds are passed over.

mod document;
mod envelope;
mod geometry;
mod kinematics;
mod model;
mod packages;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DAffine3;

use crate::source::Sources;
use crate::spelling::plural;
pub use envelope::{AxisLimits, Envelope};
pub(super) use geometry::merge;
pub use kinematics::JointValues;
pub use packages::Packages;
use perirobot_march::Result;

/// Which of a link's two descriptions of its shape is used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum GeometryUse {
    /// What planners keep clear of; often simplified and a little larger than the robot.
    #[default]
    Collision,
    /// What is drawn, as exact as its author made it.
    Visual,
}

/// A robot as its file describes it: a tree of links.
#[derive(Clone, Debug)]
pub struct RobotModel {
    path: PathBuf,
    /// Parents before children; the root is the first.
    links: Vec<Link>,
    /// Bodies without extent, which are not among those of the links.
    passed_over: usize,
}

#[derive(Clone, Debug)]
struct Link {
    name: String,
    /// What holds the link; nothing for the root.
    joint: Option<Joint>,
    collision: Vec<PlacedShape>,
    visual: Vec<PlacedShape>,
}

#[derive(Clone, Debug)]
struct Joint {
    name: String,
    /// Index of the link that it hangs on.
    parent: usize,
    /// Where the joint is, at value 0.
    parent_from_joint: DAffine3,
    motion: JointMotion,
    follows: Option<Follows>,
}

/// How a joint goes where another one leads (`<mimic>`): its value is so many times that of the other, and so much
/// more, in radians or metres each.
#[derive(Clone, Debug, PartialEq)]
struct Follows {
    joint: String,
    multiplier: f64,
    offset: f64,
}

/// How a joint moves its child, along or about a unit axis of its own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
enum JointMotion {
    Fixed,
    Turn { axis: glam::DVec3, limits_rad: [f64; 2] },
    Slide { axis: glam::DVec3, limits_m: [f64; 2] },
}

/// A shape at its place in a link.
#[derive(Clone, Debug)]
struct PlacedShape {
    link_from_body: DAffine3,
    shape: LinkShape,
}

#[derive(Clone, Debug, PartialEq)]
enum LinkShape {
    Box { size_m: glam::DVec3 },
    Cylinder { radius_m: f64, length_m: f64 },
    Capsule { radius_m: f64, length_m: f64 },
    Sphere { radius_m: f64 },
    Mesh { filename: String, scale: glam::DVec3 },
}

/// Reads and checks a URDF, or a xacro with its arguments if those may be expanded; the meshes it names are read by
/// [`RobotModel::meshes`].
///
/// # Errors
/// When the file cannot be read, is a xacro or no URDF, its links are no tree, a joint is of a kind that is not
/// supported, or a number is not what it must be. The message names the file, the link or joint, and the cure.
pub(crate) fn load(
    path: &Path,
    xacro_args: &BTreeMap<String, String>,
    packages: &Packages,
    sources: &Sources,
) -> Result<RobotModel> {
    let mut text = sources.text(path)?;
    if is_xacro(path) {
        let expanded = sources.expand(path, xacro_args, packages.folders())?;
        text = expanded.ok_or_else(|| document::expand(path).with_place(path))?;
    }
    let model = parse(path, &text)?;
    if model.passed_over > 0 {
        let shapes = plural(model.passed_over, "shape");
        sources.remark(path, format!("without {shapes} of no extent"));
    }
    Ok(model)
}

/// Whether a file is a xacro by the ending of its name.
pub fn is_xacro(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("xacro"))
}

fn parse(path: &Path, text: &str) -> Result<RobotModel> {
    let read = document::read(path, text).and_then(|robot| model::links(&robot));
    let (links, passed_over) = read.map_err(|problem| problem.with_place(path))?;
    Ok(RobotModel { path: path.into(), links, passed_over })
}

#[cfg(test)]
impl RobotModel {
    /// Names of the links, parents before children, the root first.
    pub(crate) fn link_names(&self) -> impl Iterator<Item = &str> {
        self.links.iter().map(|link| link.name.as_str())
    }
}

#[cfg(test)]
mod tests;
