//! The tree of models of a world, and where the frames of each are: a pose may be relative to any frame beside it.

use std::cell::RefCell;
use std::collections::HashMap;

use glam::DAffine3;

use super::File;
use super::geometry::SdfShape;
use super::pose::SdfPose;
use perirobot_march::error::Issue;

/// The name of a model's own frame.
pub(super) const OWN: &str = "__model__";
/// More frames in a row than any file has; a ring has no end.
const LONGEST_CHAIN: usize = 256;

/// A model, or the whole world, which has no name.
#[derive(Clone, Debug)]
pub(super) struct Model {
    pub(super) name: Option<String>,
    /// The file that it is in.
    pub(super) file: File,
    pub(super) pose: SdfPose,
    /// The frame that its pose places; its own if there is none.
    pub(super) placement_frame: Option<String>,
    /// Whether its frames are those of the model around it, too.
    pub(super) is_merged: bool,
    pub(super) links: Vec<SdfLink>,
    /// Joints and frames: name, pose, and what that is relative to by default.
    pub(super) frames: Vec<(String, SdfPose, String)>,
    pub(super) models: Vec<Model>,
    /// Empty until [`Model::index`] was called.
    pub(super) names: ModelNames,
}

/// What a model has, by its names.
#[derive(Clone, Debug, Default)]
pub(super) struct ModelNames {
    models: HashMap<String, usize>,
    frames: HashMap<String, FrameOwner>,
    /// Where frames are in the model's own, as far as that was asked for.
    placed: RefCell<HashMap<String, DAffine3>>,
}

/// Of what a frame is that of.
#[derive(Clone, Copy, Debug)]
enum FrameOwner {
    Link(usize),
    /// A joint, or a frame of its own.
    Own(usize),
    Model(usize),
}

/// A link with the bodies that count.
#[derive(Clone, Debug)]
pub(super) struct SdfLink {
    pub(super) name: String,
    pub(super) pose: SdfPose,
    pub(super) bodies: Vec<SdfShape>,
}

impl Model {
    /// Indexes the names of its frames and of those of the models in it, so that each is found at once. Of several of a
    /// name a link comes first, then a joint or a frame, then a model; of each the first.
    pub(super) fn index(&mut self) {
        let models = self.models.iter().enumerate().rev();
        let models: Vec<(String, usize)> =
            models.filter_map(|(i, model)| Some((model.name.clone()?, i))).collect();
        let own =
            self.frames.iter().enumerate().rev().map(|(i, (name, ..))| (name.clone(), FrameOwner::Own(i)));
        let links =
            self.links.iter().enumerate().rev().map(|(i, link)| (link.name.clone(), FrameOwner::Link(i)));
        let frames =
            models.iter().map(|(name, i)| (name.clone(), FrameOwner::Model(*i))).chain(own).chain(links);
        // What comes later takes the place of what came before.
        self.names.frames = frames.collect();
        self.names.models = models.into_iter().collect();
        self.models.iter_mut().for_each(Model::index);
    }

    /// How many models there are from this one down to the deepest in it.
    pub(super) fn height(&self) -> usize {
        1 + self.models.iter().map(Model::height).max().unwrap_or(0)
    }

    /// Its place in a message.
    pub(super) fn place(&self) -> String {
        self.name.as_ref().map_or("world".into(), |name| format!("model {name:?}"))
    }

    /// Where a pose of one of its elements is in its own frame.
    pub(super) fn pose(&self, pose: &SdfPose, default: &str) -> Result<DAffine3, Issue> {
        self.resolve_pose(pose, default, 0)
    }

    /// Where the frame of a model in it is in its own.
    pub(super) fn place_of(&self, inner: &Model) -> Result<DAffine3, Issue> {
        self.inner_pose(inner, 0)
    }

    fn resolve_pose(&self, pose: &SdfPose, default: &str, steps: usize) -> Result<DAffine3, Issue> {
        let name = pose.relative_to.as_deref().unwrap_or(default);
        if steps > LONGEST_CHAIN {
            let what = format!(
                "poses relative to {name:?} lead back to themselves, or are over {LONGEST_CHAIN} in a row"
            );
            return Err(Issue::says(what).with_advice("write the last of them relative to its model"));
        }
        let frame = self.frame(name, steps + 1)?;
        let frame = frame.ok_or_else(|| {
            Issue::says(format!("a pose is relative to {name:?}"))
                .with_advice("there is no such link, joint, frame or model")
        })?;
        Ok(frame * pose.parent_from_own)
    }

    fn inner_pose(&self, inner: &Model, steps: usize) -> Result<DAffine3, Issue> {
        let placed = self.resolve_pose(&inner.pose, OWN, steps)?;
        let Some(name) = &inner.placement_frame else { return Ok(placed) };
        let frame = inner.frame(name, steps + 1)?;
        let frame = frame.ok_or_else(|| {
            Issue::value("placement_frame", format!("{name:?}"), "there is no such link, joint or frame")
                .with_place(inner.place())
        })?;
        Ok(placed * frame.inverse())
    }

    /// Where a frame is in the model's own, if there is one of that name: a link, a joint, a frame, a model, or, behind
    /// a model's name and `::`, one of that.
    fn frame(&self, name: &str, steps: usize) -> Result<Option<DAffine3>, Issue> {
        if name == OWN || (self.name.is_none() && name == "world") {
            return Ok(Some(DAffine3::IDENTITY));
        }
        let placed = self.names.placed.borrow().get(name).copied();
        if placed.is_some() {
            return Ok(placed);
        }
        let found = match self.names.frames.get(name) {
            Some(FrameOwner::Link(link)) => Some(self.resolve_pose(&self.links[*link].pose, OWN, steps)?),
            Some(FrameOwner::Own(frame)) => {
                let (_, pose, default) = &self.frames[*frame];
                Some(self.resolve_pose(pose, default, steps)?)
            }
            Some(FrameOwner::Model(model)) => Some(self.inner_pose(&self.models[*model], steps)?),
            None => self.frame_within(name, steps)?,
        };
        if let Some(place) = found {
            self.names.placed.borrow_mut().insert(name.into(), place);
        }
        Ok(found)
    }

    /// The same of a frame that has its name within a model of this one: behind that model's name and `::`, or in one
    /// that is merged.
    fn frame_within(&self, name: &str, steps: usize) -> Result<Option<DAffine3>, Issue> {
        if let Some((outer, rest)) = name.split_once("::") {
            let Some(model) = self.names.models.get(outer).map(|&i| &self.models[i]) else { return Ok(None) };
            let frame = model.frame(rest, steps + 1)?;
            return frame.map(|frame| Ok(self.inner_pose(model, steps)? * frame)).transpose();
        }
        for model in self.models.iter().filter(|model| model.is_merged) {
            if let Some(frame) = model.frame(name, steps + 1)? {
                return Ok(Some(self.inner_pose(model, steps)? * frame));
            }
        }
        Ok(None)
    }
}
