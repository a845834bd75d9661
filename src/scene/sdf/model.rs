//! The tree of models of a world, and where the frames of each are: a pose may be relative to any frame beside it.

use glam::DAffine3;
use roxmltree::Node;

use super::File;
use super::geometry::Body;
use super::pose::Pose;
use crate::error::Issue;

/// The name of a model's own frame.
pub(super) const OWN: &str = "__model__";
/// More frames in a row than any file has; a ring has no end.
const LONGEST_CHAIN: usize = 256;

/// A model, or the whole world, which has no name.
#[derive(Debug)]
pub(super) struct Model {
    pub(super) name: Option<String>,
    /// The file that it is in.
    pub(super) file: File,
    pub(super) pose: Pose,
    /// The frame that its pose places; its own if there is none.
    pub(super) placement_frame: Option<String>,
    /// Whether its frames are those of the model around it, too.
    pub(super) is_merged: bool,
    pub(super) links: Vec<Link>,
    /// Joints and frames: name, pose, and what that is relative to by default.
    pub(super) frames: Vec<(String, Pose, String)>,
    pub(super) models: Vec<Model>,
}

/// A link with the bodies that count.
#[derive(Debug)]
pub(super) struct Link {
    pub(super) name: String,
    pub(super) pose: Pose,
    pub(super) bodies: Vec<Body>,
}

impl Model {
    /// Its place in a message.
    pub(super) fn place(&self) -> String {
        self.name.as_ref().map_or("world".into(), |name| format!("model {name:?}"))
    }

    /// Where a pose of one of its elements is in its own frame.
    pub(super) fn pose(&self, pose: &Pose, default: &str) -> Result<DAffine3, Issue> {
        self.posed(pose, default, 0)
    }

    /// Where the frame of a model in it is in its own.
    pub(super) fn place_of(&self, inner: &Model) -> Result<DAffine3, Issue> {
        self.placed(inner, 0)
    }

    fn posed(&self, pose: &Pose, default: &str, steps: usize) -> Result<DAffine3, Issue> {
        let name = pose.relative_to.as_deref().unwrap_or(default);
        if steps > LONGEST_CHAIN {
            return Err(Issue::says(format!("poses relative to {name:?} lead back to themselves")));
        }
        let frame = self.frame(name, steps + 1)?;
        let frame = frame.ok_or_else(|| {
            Issue::says(format!("a pose is relative to {name:?}"))
                .wanted("there is no such link, joint, frame or model")
        })?;
        Ok(frame * pose.parent_from_own)
    }

    fn placed(&self, inner: &Model, steps: usize) -> Result<DAffine3, Issue> {
        let placed = self.posed(&inner.pose, OWN, steps)?;
        let Some(name) = &inner.placement_frame else { return Ok(placed) };
        let frame = inner.frame(name, steps + 1)?;
        let frame = frame.ok_or_else(|| {
            Issue::value("placement_frame", format!("{name:?}"), "there is no such link, joint or frame")
                .at(inner.place())
        })?;
        Ok(placed * frame.inverse())
    }

    /// Where a frame is in the model's own, if there is one of that name: a link, a joint, a frame, a model, or, behind
    /// a model's name and `::`, one of that.
    fn frame(&self, name: &str, steps: usize) -> Result<Option<DAffine3>, Issue> {
        if name == OWN || (self.name.is_none() && name == "world") {
            return Ok(Some(DAffine3::IDENTITY));
        }
        if let Some((outer, rest)) = name.split_once("::") {
            let Some(model) = self.models.iter().find(|model| model.name.as_deref() == Some(outer)) else {
                return Ok(None);
            };
            let frame = model.frame(rest, steps + 1)?;
            return frame.map(|frame| Ok(self.placed(model, steps)? * frame)).transpose();
        }
        if let Some(link) = self.links.iter().find(|link| link.name == name) {
            return self.posed(&link.pose, OWN, steps).map(Some);
        }
        if let Some((_, pose, default)) = self.frames.iter().find(|(frame, ..)| frame == name) {
            return self.posed(pose, default, steps).map(Some);
        }
        if let Some(model) = self.models.iter().find(|model| model.name.as_deref() == Some(name)) {
            return self.placed(model, steps).map(Some);
        }
        for model in self.models.iter().filter(|model| model.is_merged) {
            if let Some(frame) = model.frame(name, steps + 1)? {
                return Ok(Some(self.placed(model, steps)? * frame));
            }
        }
        Ok(None)
    }
}

/// The first child of that name.
pub(super) fn child<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Option<Node<'a, 'i>> {
    children(node, name).next()
}

/// The children of that name.
pub(super) fn children<'a, 'i>(node: Node<'a, 'i>, name: &str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |child| child.has_tag_name(name))
}

/// The text of the first child of that name.
pub(super) fn text<'a>(node: Node<'a, '_>, name: &str) -> Option<&'a str> {
    child(node, name).and_then(|child| child.text()).map(str::trim).filter(|text| !text.is_empty())
}
