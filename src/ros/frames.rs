//! The tree of frames that a bag's `/tf_static` tells.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};

use super::messages::TransformStamped;
use crate::error::Issue;
use crate::pose::Pose;

/// Where each frame is in the one that holds it.
#[derive(Debug, Default)]
pub(crate) struct Frames {
    holders: BTreeMap<String, (String, Pose)>,
}

impl Frames {
    /// Learns where a frame is. Of two words about one frame the later counts, as in tf2.
    ///
    /// # Errors
    /// When its place is not finite, or its rotation is none.
    pub(super) fn learn(&mut self, said: TransformStamped) -> Result<(), Issue> {
        let (at, turned) = (said.transform.translation, said.transform.rotation);
        let position_m = DVec3::new(at.x, at.y, at.z);
        let rotation = DQuat::from_xyzw(turned.x, turned.y, turned.z, turned.w);
        let child = plain(&said.child_frame_id).to_owned();
        let is_unit = (rotation.length() - 1.0).abs() < 1e-3;
        if !position_m.is_finite() || !is_unit {
            let what =
                format!("its transform of the frame {child:?} has no finite place and unit quaternion");
            return Err(Issue::damaged(what));
        }
        let pose = Pose { position_m, rotation: rotation.normalize() };
        self.holders.insert(child, (plain(&said.header.frame_id).to_owned(), pose));
        Ok(())
    }

    /// The outermost frame around one, and where that one is in it.
    ///
    /// # Errors
    /// When frames hold each other in a ring.
    pub(crate) fn outermost<'a>(&'a self, frame: &'a str) -> Result<(&'a str, Pose), Issue> {
        let mut found = (plain(frame), Pose::ORIGIN);
        for _ in 0..=self.holders.len() {
            match self.holders.get(found.0) {
                Some((holder, pose)) => found = (holder, found.1.carried_by(pose)),
                None => return Ok(found),
            }
        }
        Err(Issue::damaged(format!("its frames hold each other in a ring, beginning at {:?}", plain(frame))))
    }
}

/// A name without the slash that old drivers put before it.
fn plain(frame: &str) -> &str {
    frame.strip_prefix('/').unwrap_or(frame)
}
