//! The study as its TOML text, and what a person changes in it. The text is the state: comments, order and line ends stay,
//! each step can be undone, and what would be written can be compared with what is on the disk. Nothing is read or
//! written here, and no sensor is built: what edits must know of a study is [`Known`].

mod apply;
mod difference;
mod edit;
mod group;
mod known;
mod lists;
mod number;
mod objects;
mod path;
mod plan;
mod pose;
mod shapes;
mod source;
mod span;
mod uses;
mod values;

#[cfg(test)]
mod tests;

use std::sync::Arc;

use perirobot_march::{Error, Result};

pub use difference::{DiffLine, LineKind};
pub use edit::{BoxTable, Device, Edit, EditRequest, ShapeEdit};
pub use known::{Known, KnownModel, KnownSensor};
pub use objects::{ObjectMove, ObjectPlaces, candidate_objects, object_places};
pub use plan::{PLANNED, PlacedName};
pub use pose::{Pose6, rounded};
pub use shapes::{Corners, SensorShape};
use source::Source;

/// Most steps that can be undone, and most bytes of texts that are kept for it.
const MOST_STEPS: usize = 1000;
const MOST_BYTES: usize = 64 << 20;

/// The text of the study, then those of its scene files.
type Texts = Vec<Arc<str>>;

/// A study file that is edited, with the scene files that may be edited, too: one history for all of them.
#[derive(Clone, Debug)]
pub struct Document {
    texts: Texts,
    /// The names of the scene files.
    scenes: Vec<String>,
    /// The texts on the disk.
    saved: Texts,
    /// Texts before the steps that were done, the latest last.
    done: Vec<Texts>,
    /// Texts after the steps that were undone, the next last.
    undone: Vec<Texts>,
    /// The gesture to which the latest step belongs, if it may go on.
    gesture: Option<u64>,
}

impl Document {
    /// A text as it is on the disk, TOML or not. Of one that is not TOML only the whole can be changed.
    pub fn new(text: String) -> Document {
        let texts: Texts = vec![text.into()];
        let (scenes, done, undone) = Default::default();
        Document { saved: texts.clone(), texts, scenes, done, undone, gesture: None }
    }

    /// Takes a scene file of the study, as it is on the disk. Steps before this one did not change it.
    pub fn add_scene(&mut self, name: &str, text: &str) {
        let text: Arc<str> = text.into();
        let Document { texts, saved, done, undone, .. } = self;
        let all = [texts, saved].into_iter().chain(done).chain(undone);
        all.for_each(|texts| texts.push(text.clone()));
        self.scenes.push(name.into());
    }

    /// Whether a text was changed here, now or in a step that can be undone or done again; the number is that of
    /// [`Document::texts`].
    pub fn is_touched(&self, number: usize) -> bool {
        let all = [&self.texts].into_iter().chain(&self.done).chain(&self.undone);
        all.into_iter().any(|texts| texts[number] != self.saved[number])
    }

    /// Takes what another program has written into a scene file that was not touched here.
    pub fn follow_scene(&mut self, number: usize, text: &str) {
        let text: Arc<str> = text.into();
        let Document { texts, saved, done, undone, .. } = self;
        let all = [texts, saved].into_iter().chain(done).chain(undone);
        all.for_each(|texts| texts[number] = text.clone());
    }

    /// The names of the files whose texts differ from what is on the disk; `study` is that of the study.
    pub fn changed_names<'n>(&'n self, study: &'n str) -> impl Iterator<Item = &'n str> {
        let names = std::iter::once(study).chain(self.scenes.iter().map(String::as_str));
        let each = names.zip(self.saved.iter().zip(&self.texts));
        each.filter(|(_, (old, new))| old != new).map(|(name, _)| name)
    }

    /// The text of the study, with all edits.
    pub fn text(&self) -> &str {
        &self.texts[0]
    }

    /// The texts of all files: the study's, then those of its scenes as they were added.
    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.texts.iter().map(|text| &**text)
    }

    /// Whether a text differs from what is on the disk.
    pub fn is_changed(&self) -> bool {
        self.texts != self.saved
    }

    /// Whether a step can be undone.
    pub fn can_undo(&self) -> bool {
        !self.done.is_empty()
    }

    /// Whether a step that was undone can be done again.
    pub fn can_redo(&self) -> bool {
        !self.undone.is_empty()
    }

    /// The placed sensors, in the order of the file: those of the combination "planned", or else of `[choose] always`.
    /// Edits count them in this order.
    ///
    /// # Errors
    /// If the text is not TOML, or a combination of this name does not name one pose for each sensor.
    pub fn plan(&self, known: &Known) -> Result<Vec<PlacedName>> {
        plan::read(&Source::new(self.text().to_string())?, known)
    }

    /// The tables that another study needs for this plan, to be copied.
    ///
    /// # Errors
    /// As [`Document::plan`].
    pub fn plan_text(&self, known: &Known) -> Result<String> {
        Ok(plan::text(&self.plan(known)?, known))
    }

    /// Changes the study. Edits of one gesture become one step. Returns which of the placed sensors was changed, if it is
    /// still there.
    ///
    /// # Errors
    /// If the edit does not fit the study, which then stays as it is.
    pub fn apply(&mut self, edit: &Edit, gesture: Option<u64>, known: &Known) -> Result<Option<usize>> {
        let (file, text, changed) = match edit {
            Edit::SetText { text } => (0, text.clone(), None),
            Edit::MoveObject { file, object, to } => {
                let number = self.scene_number(file)?;
                let mut source = Source::new(self.texts[number].to_string())?;
                objects::set(&mut source, object, to)?;
                (number, source.into_text(), None)
            }
            edit => {
                let mut source = Source::new(self.text().to_string())?;
                let changed = apply::apply(&mut source, edit, known)?;
                (0, source.into_text(), changed)
            }
        };
        if *text == *self.texts[file] {
            // The next edit begins a step of its own, unless it goes on with the one that was changed last.
            self.gesture = self.gesture.filter(|own| Some(*own) == gesture);
            return Ok(changed);
        }
        let before = self.texts.clone();
        self.texts[file] = text.into();
        if gesture.is_none() || gesture != self.gesture {
            self.done.push(before);
            self.forget();
        }
        self.undone.clear();
        self.gesture = gesture;
        Ok(changed)
    }

    /// Which of the texts is that of a scene file.
    fn scene_number(&self, name: &str) -> Result<usize> {
        let found = self.scenes.iter().position(|known| known == name).map(|number| number + 1);
        found.ok_or_else(|| {
            Error::input(format!("scene file {name:?}"), "cannot be edited here")
                .with_advice(format!("files that can be: {:?}", self.scenes))
        })
    }

    /// Takes back the latest step. Whether there was one.
    pub fn undo(&mut self) -> bool {
        self.gesture = None;
        let Some(before) = self.done.pop() else { return false };
        self.undone.push(std::mem::replace(&mut self.texts, before));
        true
    }

    /// Does the latest step again that was taken back. Whether there was one.
    pub fn redo(&mut self) -> bool {
        self.gesture = None;
        let Some(after) = self.undone.pop() else { return false };
        self.done.push(std::mem::replace(&mut self.texts, after));
        true
    }

    /// Says that all texts are now those on the disk.
    pub fn saved(&mut self) {
        self.saved.clone_from(&self.texts);
        self.gesture = None;
    }

    /// What differs from the texts on the disk. If a scene file does, the lines of each file follow its name; `study` is
    /// that of the study.
    pub fn difference(&self, study: &str) -> Vec<DiffLine> {
        let names = std::iter::once(study).chain(self.scenes.iter().map(String::as_str));
        let each = names.zip(self.saved.iter().zip(&self.texts)).map(|(name, (old, new))| (name, old, new));
        let changed: Vec<_> = each.filter(|(_, old, new)| old != new).collect();
        let has_names = self.saved[1..] != self.texts[1..];
        let lines = |(name, old, new): (&str, &Arc<str>, &Arc<str>)| {
            let title = has_names.then(|| DiffLine::title(name));
            title.into_iter().chain(difference::difference(old, new)).collect::<Vec<_>>()
        };
        changed.into_iter().flat_map(lines).collect()
    }

    /// Drops the oldest steps of very many.
    fn forget(&mut self) {
        let mut bytes = 0;
        let kept = self.done.iter().rev().take(MOST_STEPS).take_while(|texts| {
            // What is the same as now is held once.
            let own = texts.iter().zip(&self.texts).filter(|(text, now)| !Arc::ptr_eq(text, now));
            bytes += own.map(|(text, _)| text.len()).sum::<usize>();
            bytes <= MOST_BYTES
        });
        let gone = self.done.len() - kept.count().max(1);
        self.done.drain(..gone);
    }
}
