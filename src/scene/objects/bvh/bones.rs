//! Which bone of a BVH skeleton begins at which joint of a person: by the names that common skeletons have, or as the
//! user says.

use std::collections::BTreeMap;

use glam::{DAffine3, DVec3};

use super::hierarchy::Bone;
use crate::objects::keypoints::{HIPS, JOINTS, Keypoints, face};
use perirobot_march::error::Issue;

/// What may be named: COCO's joints, and the base of the skull, by which a head without eyes, ears and nose is placed.
pub const BONES: [&str; 18] = {
    let mut all = [HEAD; 18];
    let mut joint = 0;
    while joint < JOINTS.len() {
        all[joint] = JOINTS[joint];
        joint += 1;
    }
    all
};
const HEAD: &str = "head";

/// The names of the bone that begins at a joint of one side, as [`plain`] writes them without the side: first the joint's
/// own, since a skeleton that has it may have the bone of a neighbour, too (SMPL has ankles and feet). But an arm's own
/// bone is preferred to what some call a shoulder, which is the collarbone.
const USUAL: [(&str, &[&str]); 6] = [
    ("shoulder", &["arm", "upperarm", "shldr", "shoulder"]),
    ("elbow", &["elbow", "forearm", "lowerarm"]),
    ("wrist", &["wrist", "hand"]),
    ("hip", &["upleg", "upperleg", "thigh", "hip"]),
    ("knee", &["knee", "leg", "lowerleg", "shin", "calf"]),
    ("ankle", &["ankle", "foot"]),
];

/// The bones that begin at the joints of a person.
#[derive(Debug, PartialEq)]
pub(super) struct JointBones {
    joints: [Option<usize>; 17],
    head: Option<usize>,
}

/// The joint before one on the same limb, whose bone carries that of the other.
fn previous_joint(joint: &str) -> Option<String> {
    let (side, part) = joint.split_once('_')?;
    let before = match part {
        "elbow" => "shoulder",
        "wrist" => "elbow",
        "knee" => "hip",
        "ankle" => "knee",
        _ => return None,
    };
    Some(format!("{side}_{before}"))
}

/// Whether a bone hangs on another one, directly or by others.
fn hangs_on(bones: &[Bone], bone: usize, other: usize) -> bool {
    std::iter::successors(bones[bone].parent, |&parent| bones[parent].parent).any(|parent| parent == other)
}

/// Chooses the bones of a skeleton: those that are named, else those with usual names. No bone serves two joints, and
/// of several with usual names one that hangs on the joint before it on the limb is preferred.
pub(super) fn choose(bones: &[Bone], named: &BTreeMap<String, String>) -> Result<JointBones, Issue> {
    let plain: Vec<String> = bones.iter().map(|bone| plain(&bone.name)).collect();
    let there_are = || {
        let names: Vec<&str> = bones.iter().take(40).map(|bone| bone.name.as_str()).collect();
        format!("there are {}{}", names.join(", "), if bones.len() > names.len() { ", …" } else { "" })
    };
    // Which joint has a bone, in the order in which they are chosen.
    let mut taken: Vec<(usize, &str)> = Vec::new();
    for joint in BONES {
        let Some(name) = named.get(joint).filter(|name| !name.is_empty()) else { continue };
        let wrong = |rule: String| Issue::value(format!("bones.{joint}"), format!("{name:?}"), rule);
        let bone = bones.iter().position(|bone| bone.name == *name);
        let bone = bone.ok_or_else(|| wrong("no bone has that name".into()).cure(there_are()))?;
        if let Some((_, other)) = taken.iter().find(|(taken, _)| *taken == bone) {
            return Err(wrong(format!("is the bone of {other}, too: each joint has its own")));
        }
        taken.push((bone, joint));
    }
    for joint in BONES {
        let usual = usual(joint);
        if named.contains_key(joint) || usual.is_empty() {
            continue;
        }
        let is_free = |bone: &usize| taken.iter().all(|(taken, _)| taken != bone);
        let found = usual.iter().flat_map(|name| (0..bones.len()).filter(|&bone| plain[bone] == *name));
        let found: Vec<usize> = found.filter(is_free).collect();
        let carrier = previous_joint(joint).and_then(|before| bone_of(&taken, &before));
        let carried =
            found.iter().find(|&&bone| carrier.is_some_and(|carrier| hangs_on(bones, bone, carrier)));
        let bone = carried.or(found.first()).ok_or_else(|| {
            Issue::says(format!("none of its bones has a usual name of the one at {joint}"))
                .with_advice(format!(
                    "name it, as in bones = {{ {joint} = \"…\" }}, or leave it out with \"\""
                ))
                .cure(there_are())
        })?;
        taken.push((*bone, joint));
    }
    Ok(JointBones { joints: JOINTS.map(|joint| bone_of(&taken, joint)), head: bone_of(&taken, HEAD) })
}

/// The bone of a joint.
fn bone_of(taken: &[(usize, &str)], joint: &str) -> Option<usize> {
    taken.iter().find(|(_, other)| *other == joint).map(|(bone, _)| *bone)
}

/// The plain names that the bone of a joint usually has; none for joints of the face, which skeletons do not have.
fn usual(joint: &str) -> Vec<String> {
    if joint == HEAD {
        return vec![HEAD.into()];
    }
    let side_and_part = joint.split_once('_');
    let Some((side, parts)) =
        side_and_part.and_then(|(side, part)| Some((side, USUAL.iter().find(|(name, _)| *name == part)?.1)))
    else {
        return Vec::new();
    };
    let letter = &side[..1];
    let ways = |part: &&str| [format!("{side}{part}"), format!("{letter}{part}"), format!("{part}{letter}")];
    parts.iter().flat_map(ways).collect()
}

/// A bone's name in small letters and digits, without what programs put before all names.
fn plain(name: &str) -> String {
    let own = name.rsplit(':').next().unwrap_or(name).to_ascii_lowercase();
    let plain: String = own.chars().filter(char::is_ascii_alphanumeric).collect();
    for program in ["mixamorig", "bip"] {
        if let Some(rest) = plain.strip_prefix(program) {
            return rest.trim_start_matches(|c: char| c.is_ascii_digit()).into();
        }
    }
    plain
}

impl JointBones {
    /// The joints of a person, in the file's axes and in metres. `rest` and `now` are the bones of the skeleton as it is
    /// drawn and as it is posed, `up` is a unit vector. Of a head, eyes, ears and nose that have no bones are where an
    /// adult's are: at rest it looks where the hips do, and it turns with its bone. None if the hips do not tell where
    /// that is.
    pub(super) fn keypoints(
        &self,
        [rest, now]: [&[DAffine3]; 2],
        scale: f64,
        up: DVec3,
    ) -> Option<Keypoints> {
        let at = |bone: usize| scale * now[bone].translation;
        let mut joints: Keypoints = self.joints.map(|bone| bone.map(at));
        let Some(head) = self.head else { return Some(joints) };
        let [Some(left_hip), Some(right_hip)] = HIPS.map(|hip| self.joints[hip]) else { return Some(joints) };
        let left = rest[left_hip].translation - rest[right_hip].translation;
        let left = left.reject_from_normalized(up).try_normalize()?;
        let turn = now[head].matrix3;
        for (joint, usual) in joints.iter_mut().zip(face(at(head), turn * left, turn * up)) {
            *joint = joint.or(usual);
        }
        Some(joints)
    }
}
