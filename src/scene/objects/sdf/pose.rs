//! Reads the poses of an SDF file.

use glam::{DAffine3, DMat3, DQuat, DVec3};
use roxmltree::Node;

use super::element::child;
use crate::pose::{from_rpy, unit_quaternion};
use perirobot_march::error::Issue;

/// No number of a file is larger; beyond it there are slips of the pen.
pub(super) const LARGEST: f64 = 1e6;

/// Where something is in the frame of something else.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct SdfPose {
    pub(super) parent_from_own: DAffine3,
    /// The other's name; if there is none, what it is by default.
    pub(super) relative_to: Option<String>,
}

impl SdfPose {
    /// The pose of an element: its child, or where its parent is.
    pub(super) fn from_element(element: Node) -> Result<SdfPose, Issue> {
        let Some(node) = child(element, "pose") else {
            return Ok(SdfPose { parent_from_own: DAffine3::IDENTITY, relative_to: None });
        };
        let relative_to = node.attribute("relative_to").filter(|name| !name.is_empty()).map(String::from);
        let text = node.text().unwrap_or_default();
        let wrong = |rule: &str| Issue::value("pose", format!("{:?}", text.trim()), rule.to_string());
        let values = numbers(text).ok_or_else(|| wrong("must be numbers from -1000000 to 1000000"))?;
        let is_degrees = matches!(node.attribute("degrees"), Some("true" | "1"));
        let (place, turn) = match (node.attribute("rotation_format").unwrap_or("euler_rpy"), &values[..]) {
            // An empty element is none.
            (_, []) => (DVec3::ZERO, DMat3::IDENTITY),
            ("euler_rpy", &[x, y, z, roll, pitch, yaw]) => {
                let angles =
                    [roll, pitch, yaw].map(|angle| if is_degrees { angle.to_radians() } else { angle });
                (DVec3::new(x, y, z), from_rpy(angles))
            }
            ("quat_xyzw", &[x, y, z, qx, qy, qz, qw]) => {
                let turn = unit_quaternion(DQuat::from_xyzw(qx, qy, qz, qw));
                let turn = turn.ok_or_else(|| wrong("its quaternion must have a finite length"))?;
                (DVec3::new(x, y, z), DMat3::from_quat(turn))
            }
            ("euler_rpy", _) => return Err(wrong("must be six numbers: x y z roll pitch yaw")),
            ("quat_xyzw", _) => return Err(wrong("must be seven numbers: x y z, then a quaternion x y z w")),
            _ => return Err(wrong("rotation_format must be euler_rpy or quat_xyzw")),
        };
        Ok(SdfPose { parent_from_own: DAffine3::from_mat3_translation(turn, place), relative_to })
    }
}

/// The numbers of a text; none if a word is none.
pub(super) fn numbers(text: &str) -> Option<Vec<f64>> {
    let number = |word: &str| word.parse::<f64>().ok().filter(|number| number.abs() <= LARGEST);
    text.split_whitespace().map(number).collect()
}
