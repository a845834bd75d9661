//! The orders in which detectors and body models write a person's joints, and what COCO's 17 are of each.

use glam::DVec3;

use super::{JOINTS, Keypoints, SHOULDERS};

/// Which joints a table has, in which order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum JointLayout {
    /// COCO's.
    #[default]
    #[serde(rename = "coco-17")]
    Coco17,
    /// COCO's 17, then head, neck, hip, toes and heels, which no body is drawn from.
    #[serde(rename = "halpe-26")]
    Halpe26,
    /// The joints of the body model SMPL, which has no face: eyes, ears and nose are put where an adult's are.
    #[serde(rename = "smpl-24")]
    Smpl24,
}

/// What Halpe has behind COCO's.
const HALPE_ONLY: [&str; 9] = [
    "head",
    "neck",
    "hip",
    "left_big_toe",
    "right_big_toe",
    "left_small_toe",
    "right_small_toe",
    "left_heel",
    "right_heel",
];

const SMPL: [&str; 24] = [
    "pelvis",
    "left_hip",
    "right_hip",
    "spine1",
    "left_knee",
    "right_knee",
    "spine2",
    "left_ankle",
    "right_ankle",
    "spine3",
    "left_foot",
    "right_foot",
    "neck",
    "left_collar",
    "right_collar",
    "head",
    "left_shoulder",
    "right_shoulder",
    "left_elbow",
    "right_elbow",
    "left_wrist",
    "right_wrist",
    "left_hand",
    "right_hand",
];

/// How far the line from SMPL's neck to its head leans forward in somebody who looks straight ahead.
const LEAN_DEG: f64 = 30.0;

impl JointLayout {
    /// The names of its joints, in its order.
    pub(crate) fn joints(self) -> Vec<&'static str> {
        match self {
            JointLayout::Coco17 => JOINTS.to_vec(),
            JointLayout::Halpe26 => [&JOINTS[..], &HALPE_ONLY].concat(),
            JointLayout::Smpl24 => SMPL.to_vec(),
        }
    }

    /// As a study writes it.
    pub(crate) fn describe(self) -> &'static str {
        match self {
            JointLayout::Coco17 => "layout \"coco-17\"",
            JointLayout::Halpe26 => "layout \"halpe-26\"",
            JointLayout::Smpl24 => "layout \"smpl-24\"",
        }
    }

    /// COCO's joints among those of this layout.
    pub(super) fn keypoints(self, points: &[Option<DVec3>]) -> Keypoints {
        let joints = self.joints();
        let point =
            |name: &str| joints.iter().position(|joint| *joint == name).and_then(|place| points[place]);
        let mut keypoints = JOINTS.map(point);
        if self == JointLayout::Smpl24
            && let (Some(neck), Some(head)) = (point("neck"), point("head"))
            && let [Some(left), Some(right)] = SHOULDERS.map(|shoulder| keypoints[shoulder])
            && let Some(left) = (left - right).reject_from(head - neck).try_normalize()
        {
            let (sin, cos) = libm::sincos(-LEAN_DEG.to_radians());
            // A turn about the axis to the left that takes what leans forward back upright.
            let along = (head - neck).normalize();
            let up = cos * along + sin * left.cross(along);
            keypoints[..5].copy_from_slice(&face(head, left, up));
        }
        keypoints
    }
}

/// An adult's nose, eyes and ears, by where the head is joined to the neck and by which way the head is: `left` and
/// `up` are unit vectors at a right angle.
pub(crate) fn face(head: DVec3, left: DVec3, up: DVec3) -> [Option<DVec3>; 5] {
    let forward = left.cross(up);
    let at = |ahead: f64, aside: f64, above: f64| Some(head + ahead * forward + aside * left + above * up);
    [
        at(0.1, 0.0, 0.05),
        at(0.08, 0.03, 0.08),
        at(0.08, -0.03, 0.08),
        at(0.0, 0.07, 0.06),
        at(0.0, -0.07, 0.06),
    ]
}
