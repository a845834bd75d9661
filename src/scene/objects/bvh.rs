//! Reads motion capture as BVH: a skeleton of bones, and how each of them is turned in each frame. What a frame makes
//! of a person's joints is in `joints`.
//!
//! The format states neither its unit nor what is up. Angles are degrees; of a bone with several, the one that is
//! written first turns last. A position channel replaces the bone's offset along its axis, as recorders write it.

mod bones;
mod hierarchy;
mod motion;

use perirobot_march::lengths::describe_place;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{DAffine3, DMat3, DVec3};

use super::keypoints::{FARTHEST_M, Keypoints};
use super::mesh_file::z_up;
use super::{Up, keypoints};
use crate::source::Sources;
use crate::spelling::plural;
use hierarchy::{Bone, BoneAxis, Channel};
use motion::MotionFrames;
use perirobot_march::Result;
use perirobot_march::error::Issue;

pub use bones::BONES;

/// A recorded motion of a person, and what the user says about its file.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionFile {
    /// The file.
    pub path: PathBuf,
    /// Metres in one of its units.
    pub scale: f64,
    /// Its up axis.
    pub up: Up,
    /// Which bone begins at which joint, instead of the usual names; with an empty name a joint is unknown. The head's
    /// is at the base of the skull.
    pub bones: BTreeMap<String, String>,
    /// When, in seconds from its first frame.
    pub time_s: f64,
    /// Whether the person is moved to where its hips are above the origin, and turned to face +x.
    pub centred: bool,
}

/// A file that was read, to be posed as often as needed.
#[derive(Debug)]
pub struct Bvh {
    path: PathBuf,
    /// Parents before children.
    bones: Vec<Bone>,
    motion: MotionFrames,
}

impl Bvh {
    /// Reads a file.
    ///
    /// # Errors
    /// When it cannot be read, is cut off, or contradicts itself. Frames are checked when they are posed.
    pub fn load(path: &Path, sources: &Sources) -> Result<Bvh> {
        let file = Bvh::parse(path, sources.table(path)?).map_err(|issue| issue.with_place(path))?;
        if file.motion.behind > 0 {
            let lines = plural(file.motion.behind, "line");
            sources.remark(path, format!("without {lines} behind the frames that it declares"));
        }
        Ok(file)
    }

    fn parse(path: &Path, text: String) -> Result<Bvh, Issue> {
        let (bones, rest) = hierarchy::read(&text)?;
        let channels = bones.iter().map(|bone| bone.channels.len()).sum();
        let motion = MotionFrames::read(text, rest, channels)?;
        Ok(Bvh { path: path.into(), bones, motion })
    }

    /// The time of the first and of the last frame, in seconds. Before and after them, the pose is that of the nearer
    /// one.
    pub fn span_s(&self) -> [f64; 2] {
        self.motion.span_s()
    }

    /// The joints of the person in the frame that is nearest to the time, in metres, z up.
    ///
    /// # Errors
    /// When the frame is damaged, a joint has no bone, a bone that is named is none of the file's, or a joint is farther
    /// away than any; where the person is moved above the origin, when it has no hips side by side.
    pub fn keypoints(&self, file: &MotionFile) -> Result<Keypoints> {
        self.pose(file).map_err(|issue| issue.with_place(&self.path).into())
    }

    fn pose(&self, file: &MotionFile) -> Result<Keypoints, Issue> {
        let chosen = bones::choose(&self.bones, &file.bones)?;
        let rest = self.place_bones(None);
        let now = self.place_bones(Some(&self.motion.frame(file.time_s)?));
        let unknown =
            || Issue::says("its left and its right hip are on one spot, so that nothing says where it faces");
        let up = if file.up == Up::Y { DVec3::Y } else { DVec3::Z };
        let keypoints = chosen.keypoints([&rest, &now], file.scale, up).ok_or_else(unknown)?;
        let keypoints = keypoints.map(|joint| joint.map(|joint| z_up(joint, file.up)));
        if let Some(far) = keypoints.iter().flatten().find(|joint| joint.abs().max_element() > FARTHEST_M) {
            let rule = format!("must be within {FARTHEST_M} m of the origin: is its unit right?");
            return Err(Issue::says(format!("has a joint at {}", describe_place(*far))).with_advice(rule));
        }
        if file.centred { centre(&keypoints).ok_or_else(unknown) } else { Ok(keypoints) }
    }

    /// Where the bones are in the file's own frame and unit: as the skeleton is drawn, or by the channels of a frame.
    fn place_bones(&self, frame: Option<&[f64]>) -> Vec<DAffine3> {
        let mut placed: Vec<DAffine3> = Vec::with_capacity(self.bones.len());
        let mut values = frame.into_iter().flatten().copied();
        for bone in &self.bones {
            let (mut offset, mut turn) = (bone.offset, DMat3::IDENTITY);
            if frame.is_some() {
                for (channel, value) in bone.channels.iter().zip(values.by_ref()) {
                    match channel {
                        Channel::Position(axis) => offset[*axis as usize] = value,
                        Channel::Rotation(axis) => turn *= about(*axis, value.to_radians()),
                    }
                }
            }
            let own = DAffine3::from_mat3_translation(turn, offset);
            placed.push(bone.parent.map_or(own, |parent| placed[parent] * own));
        }
        placed
    }
}

/// A turn about an axis, with the sines of `libm`, so that two machines agree.
fn about(axis: BoneAxis, angle_rad: f64) -> DMat3 {
    let (sin, cos) = libm::sincos(angle_rad);
    match axis {
        BoneAxis::X => DMat3::from_cols_array(&[1.0, 0.0, 0.0, 0.0, cos, sin, 0.0, -sin, cos]),
        BoneAxis::Y => DMat3::from_cols_array(&[cos, 0.0, -sin, 0.0, 1.0, 0.0, sin, 0.0, cos]),
        BoneAxis::Z => DMat3::from_cols_array(&[cos, sin, 0.0, -sin, cos, 0.0, 0.0, 0.0, 1.0]),
    }
}

/// A person whose hips are above the origin, turned about z to face +x, as high as before.
fn centre(joints: &Keypoints) -> Option<Keypoints> {
    let [left, right] = keypoints::HIPS.map(|hip| joints[hip]);
    let (left, right) = (left?, right?);
    let middle = (left + right) / 2.0;
    let [x, y] = (left - right).truncate().try_normalize()?.to_array();
    // What points left becomes +y.
    let turned = |v: DVec3| DVec3::new(y * v.x - x * v.y, x * v.x + y * v.y, v.z);
    Some(joints.map(|joint| joint.map(|joint| turned(joint - middle.with_z(0.0)))))
}

#[cfg(test)]
mod tests;
