//! Which bone of a BVH skeleton begins at which joint of a person: by the names that common skeletons have, or as the
//! user says.

use std::collections::BTreeMap;

use glam::{DAffine3, DVec3};

use super::hierarchy::Bone;
use crate::error::Issue;
use crate::scene::keypoints::{HIPS, JOINTS, Keypoints, face};

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

/// The names of the bone that begins at a joint of one side, the likelier first, as [`plain`] writes them without the
/// side. An arm's own bone is preferred to what some call a shoulder, which is the collarbone.
const USUAL: [(&str, &[&str]); 6] = [
    ("shoulder", &["arm", "upperarm", "shldr", "shoulder"]),
    ("elbow", &["forearm", "lowerarm", "elbow"]),
    ("wrist", &["hand", "wrist"]),
    ("hip", &["upleg", "upperleg", "thigh", "hip"]),
    ("knee", &["leg", "lowerleg", "shin", "calf", "knee"]),
    ("ankle", &["foot", "ankle"]),
];

/// The bones that begin at the joints of a person.
#[derive(Debug, PartialEq)]
pub(super) struct Chosen {
    joints: [Option<usize>; 17],
    head: Option<usize>,
}

/// Chooses the bones of a skeleton: those that are named, else those with usual names.
pub(super) fn choose(bones: &[Bone], named: &BTreeMap<String, String>) -> Result<Chosen, Issue> {
    let plain: Vec<String> = bones.iter().map(|bone| plain(&bone.name)).collect();
    let there_are = || {
        let names: Vec<&str> = bones.iter().take(40).map(|bone| bone.name.as_str()).collect();
        format!("there are {}{}", names.join(", "), if bones.len() > names.len() { ", …" } else { "" })
    };
    let choose = |joint: &str| match named.get(joint).map(String::as_str) {
        Some("") => Ok(None),
        Some(name) => match bones.iter().position(|bone| bone.name == name) {
            Some(bone) => Ok(Some(bone)),
            None => Err(Issue::value(format!("bones.{joint}"), format!("{name:?}"), "no bone has that name")
                .cure(there_are())),
        },
        None => {
            let usual = usual(joint);
            let found = usual.iter().find_map(|name| plain.iter().position(|bone| bone == name));
            match found.is_some() || usual.is_empty() {
                true => Ok(found),
                false => {
                    Err(Issue::says(format!("none of its bones has a usual name of the one at {joint}"))
                        .wanted(format!(
                            "name it, as in bones = {{ {joint} = \"…\" }}, or leave it out with \"\""
                        ))
                        .cure(there_are()))
                }
            }
        }
    };
    let mut joints = [None; 17];
    for (joint, name) in joints.iter_mut().zip(JOINTS) {
        *joint = choose(name)?;
    }
    Ok(Chosen { joints, head: choose(HEAD)? })
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

impl Chosen {
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
