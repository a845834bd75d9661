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
mod path;
mod plan;
mod pose;
mod source;
mod span;
mod uses;
mod values;

#[cfg(test)]
mod tests;

use perirobot_march::Result;

pub use difference::{DiffLine, LineKind};
pub use edit::{BoxTable, Device, Edit, EditRequest, ShapeEdit};
pub use known::{Known, KnownModel, KnownSensor};
pub use plan::{PLANNED, PlacedName};
pub use pose::{Pose6, rounded};
use source::Source;

/// Most steps that can be undone, and most bytes of texts that are kept for it.
const MOST_STEPS: usize = 1000;
const MOST_BYTES: usize = 64 << 20;

/// A study file that is edited.
#[derive(Clone, Debug)]
pub struct Document {
    text: String,
    /// The text on the disk.
    saved: String,
    /// Texts before the steps that were done, the latest last.
    done: Vec<String>,
    /// Texts after the steps that were undone, the next last.
    undone: Vec<String>,
    /// The gesture to which the latest step belongs, if it may go on.
    gesture: Option<u64>,
}

impl Document {
    /// A text as it is on the disk, TOML or not. Of one that is not TOML only the whole can be changed.
    pub fn new(text: String) -> Document {
        Document { saved: text.clone(), text, done: Vec::new(), undone: Vec::new(), gesture: None }
    }

    /// The text, with all edits.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Whether it differs from what is on the disk.
    pub fn is_changed(&self) -> bool {
        self.text != self.saved
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
        plan::read(&Source::new(self.text.clone())?, known)
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
        let (text, changed) = match edit {
            Edit::SetText { text } => (text.clone(), None),
            edit => {
                let mut source = Source::new(self.text.clone())?;
                let changed = apply::apply(&mut source, edit, known)?;
                (source.into_text(), changed)
            }
        };
        if text == self.text {
            // The next edit begins a step of its own, unless it goes on with the one that was changed last.
            self.gesture = self.gesture.filter(|own| Some(*own) == gesture);
            return Ok(changed);
        }
        let before = std::mem::replace(&mut self.text, text);
        if gesture.is_none() || gesture != self.gesture {
            self.done.push(before);
            self.forget();
        }
        self.undone.clear();
        self.gesture = gesture;
        Ok(changed)
    }

    /// Takes back the latest step. Whether there was one.
    pub fn undo(&mut self) -> bool {
        self.gesture = None;
        let Some(before) = self.done.pop() else { return false };
        self.undone.push(std::mem::replace(&mut self.text, before));
        true
    }

    /// Does the latest step again that was taken back. Whether there was one.
    pub fn redo(&mut self) -> bool {
        self.gesture = None;
        let Some(after) = self.undone.pop() else { return false };
        self.done.push(std::mem::replace(&mut self.text, after));
        true
    }

    /// Says that the text is now the one on the disk.
    pub fn saved(&mut self) {
        self.saved.clone_from(&self.text);
        self.gesture = None;
    }

    /// What differs from the text on the disk.
    pub fn difference(&self) -> Vec<DiffLine> {
        difference::difference(&self.saved, &self.text)
    }

    /// Drops the oldest steps of very many.
    fn forget(&mut self) {
        let mut bytes = 0;
        let kept = self.done.iter().rev().take(MOST_STEPS).take_while(|text| {
            bytes += text.len();
            bytes <= MOST_BYTES
        });
        let gone = self.done.len() - kept.count().max(1);
        self.done.drain(..gone);
    }
}
