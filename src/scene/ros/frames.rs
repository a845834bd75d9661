//! The tree of frames that a bag tells: on `tf_static` those that do not move among each other, on `tf` others.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

use glam::{DQuat, DVec3};

use super::messages::TransformStamped;
use crate::pose::Pose;
use perirobot_march::error::Issue;

/// Most frames of a bag.
const MOST_FRAMES: usize = 10_000;
/// Most frames around each other.
const DEEPEST: usize = 256;
/// How far a frame that stands still may seem to move, in metres and in parts of a quaternion.
const STILL: f64 = 1e-6;

/// Where each frame is in the one that holds it.
#[derive(Debug, Default)]
pub(crate) struct Frames {
    still: BTreeMap<String, ChildFrame>,
    moving: BTreeMap<String, ChildFrame>,
    /// Frames that two topics place differently.
    contradicted: BTreeSet<String>,
}

/// A frame in the one that holds it.
#[derive(Debug, PartialEq)]
struct ChildFrame {
    by: String,
    /// None if what the bag tells is no pose.
    pose: Option<Pose>,
    topic: String,
    /// Whether it was told to be at several places.
    moves: bool,
}

impl ChildFrame {
    fn new(topic: &str, said: &TransformStamped) -> ChildFrame {
        let (at, turned) = (said.transform.translation, said.transform.rotation);
        let position_m = DVec3::new(at.x, at.y, at.z);
        let rotation = DQuat::from_xyzw(turned.x, turned.y, turned.z, turned.w);
        let is_pose = position_m.is_finite() && (rotation.length() - 1.0).abs() < 1e-3;
        let pose = is_pose.then(|| Pose { position_m, rotation: rotation.normalize() });
        ChildFrame {
            by: plain(&said.header.frame_id).to_owned(),
            pose,
            topic: topic.to_owned(),
            moves: false,
        }
    }

    fn is_as(&self, other: &ChildFrame) -> bool {
        let is_near = match (&self.pose, &other.pose) {
            (Some(a), Some(b)) => {
                a.position_m.abs_diff_eq(b.position_m, STILL)
                    && a.rotation.dot(b.rotation).abs() > 1.0 - STILL
            }
            (a, b) => a.is_none() && b.is_none(),
        };
        self.by == other.by && is_near
    }
}

impl Frames {
    /// Learns where a frame is for good. Of two words about one frame the later counts, as in tf2.
    ///
    /// # Errors
    /// When there are too many frames.
    pub(super) fn learn(&mut self, topic: &str, said: TransformStamped) -> Result<(), Issue> {
        let held = ChildFrame::new(topic, &said);
        let child = plain(&said.child_frame_id).to_owned();
        if self.still.get(&child).is_some_and(|before| before.topic != held.topic && !before.is_as(&held)) {
            self.contradicted.insert(child.clone());
        }
        self.still.insert(child, held);
        self.count()
    }

    /// Learns where a frame is at a moment.
    ///
    /// # Errors
    /// As [`Frames::learn`].
    pub(super) fn learn_moving(&mut self, topic: &str, said: TransformStamped) -> Result<(), Issue> {
        let held = ChildFrame::new(topic, &said);
        match self.moving.entry(plain(&said.child_frame_id).to_owned()) {
            Entry::Vacant(first) => drop(first.insert(held)),
            Entry::Occupied(mut first) => {
                let moves = !first.get().is_as(&held);
                first.get_mut().moves |= moves;
            }
        }
        self.count()
    }

    fn count(&self) -> Result<(), Issue> {
        match self.still.len() + self.moving.len() > MOST_FRAMES {
            true => Err(Issue::too_large(format!("has more than {MOST_FRAMES} frames"))),
            false => Ok(()),
        }
    }

    /// The outermost frame around one that does not move in it, and where that one is in it.
    ///
    /// # Errors
    /// When frames hold each other in a ring, or one has no pose.
    pub(crate) fn outermost(&self, frame: &str) -> Result<(String, Pose), Issue> {
        let mut found = (plain(frame), Pose::ORIGIN);
        for _ in 0..=DEEPEST {
            let Some(held) = self.still.get(found.0) else { return Ok((found.0.to_owned(), found.1)) };
            let pose = held.pose.as_ref().ok_or_else(|| {
                let what = format!(
                    "its transform of the frame {:?} has no finite place and unit quaternion",
                    found.0
                );
                Issue::damaged(what)
            })?;
            found = (&held.by, found.1.carried_by(pose));
        }
        let frame = plain(frame);
        let what = format!(
            "its frames hold each other in a ring, or more than {DEEPEST} deep, beginning at {frame:?}"
        );
        Err(Issue::damaged(what))
    }

    /// What a user should know of the frame of a cloud, and of the outermost one around it.
    pub(crate) fn remarks(&self, frame: &str, outermost: &str) -> Vec<String> {
        let by = |frame: &&str| self.still.get(*frame).map(|held| held.by.as_str());
        let chain: Vec<&str> = std::iter::successors(Some(plain(frame)), by).take(DEEPEST + 1).collect();
        let moving = self.moving.get(outermost).map(|held| {
            let ChildFrame { by, topic, pose, moves } = held;
            let doing = match (moves, pose) {
                (false, Some(Pose { position_m: p, .. })) => {
                    format!("has the frame {outermost:?} at {:.3}, {:.3}, {:.3} m in {by:?}", p.x, p.y, p.z)
                }
                _ => format!("moves the frame {outermost:?} in {by:?}"),
            };
            format!(
                "{topic} {doing}, and is not followed: the recording's frame is {outermost:?}; say where that is in the \
                 world, or record it on /{}",
                super::STATIC_FRAMES
            )
        });
        let contradicted = self.contradicted.iter().filter(|frame| chain.contains(&frame.as_str()));
        let twice = contradicted.map(|frame| {
            format!("several topics place the frame {frame:?} differently: the last word counts; record one robot alone")
        });
        moving.into_iter().chain(twice).collect()
    }
}

/// A name without the slash that old drivers put before it.
fn plain(frame: &str) -> &str {
    frame.strip_prefix('/').unwrap_or(frame)
}
