//! The task of a sweep: scores the rows that the journal lacks, and lets the CPU check a device's counts.

use std::path::Path;

use super::checkpoint::{Checkpoint, Record};
use super::evidence::Store;
use super::failover::{Resumable, TaskChoices};
use super::order::{Ledger, Task, score};
use crate::results::PoseChoice;
use crate::results::files::{DISAGREED, DISAGREEMENT, write_whole};
use perirobot_march::backend::Backend;
use perirobot_march::backend::factory::{BackendFactory, Fallback};
use perirobot_march::error::{Argument, Issue, Words};
use perirobot_march::{Error, Result};
use perirobot_study::world::World;

/// The work of one device in a run.
pub(super) struct Sweeping<'a> {
    /// The device in words, if several work.
    pub(super) device: Option<String>,
    pub(super) choices: TaskChoices<'a>,
    pub(super) folder: &'a Path,
    pub(super) checkpoint: Checkpoint<'a>,
    /// The number of checked choices.
    pub(super) verified: u64,
    /// The backend that checks: the CPU.
    pub(super) checker: Option<Box<dyn Backend + Send>>,
}

impl Task for Sweeping<'_> {
    fn wants(&self, world: &World, repeat: usize, pose_choice: &PoseChoice) -> bool {
        self.checkpoint.wants(world, repeat, pose_choice)
    }

    fn work(&mut self, store: Store, pose_choices: &[PoseChoice], backend: &mut dyn Backend) -> Result<()> {
        score(store, pose_choices, backend, &mut self.checkpoint)
    }

    fn enough(&mut self) -> bool {
        self.checkpoint.enough()
    }
}

impl Resumable for Sweeping<'_> {
    fn finished(&self) -> u64 {
        self.checkpoint.finished
    }

    fn begin(&mut self, fallback: Fallback) {
        // The CPU does not check itself.
        self.checkpoint.is_trusted = fallback == Fallback::Cpu;
    }

    /// Checks the picked choices. A difference ends the run, with the evidence in a file.
    fn check(&mut self, backends: &mut dyn BackendFactory) -> Result<()> {
        let Some(picked) = &mut self.checkpoint.unchecked else { return Ok(()) };
        if self.checker.is_none() {
            self.checker = Some(backends.open(Fallback::Cpu)?);
        }
        let Some(checker) = &mut self.checker else { return Ok(()) };
        match picked.check(self.choices.study, self.choices.worlds, checker.as_mut())? {
            Ok(number) => {
                self.verified += number;
                Ok(())
            }
            Err(difference) => {
                // A later run or a merge would accept rows of a device that counts wrongly as finished.
                let mut record = self.checkpoint.record();
                let kept = match std::mem::replace(&mut record.is_set_aside, true) {
                    false => set_aside(&mut record, self.folder, &difference.evidence),
                    true => format!("Both counts: {}. Another device disagreed before", difference.evidence),
                };
                let device = self.device.as_deref().unwrap_or("the device");
                let what = format!("{device} and the CPU disagree: {}. {kept}", difference.place);
                let cure = Words::from("run again with ")
                    + Argument("backend").with_value("cpu")
                    + ", and `perirobot verify-backends` to see more";
                Err(Error::Disagreement(Issue::says(what).cure(cure)))
            }
        }
    }

    fn is_over(&self, pose_choices: &[PoseChoice]) -> bool {
        let Checkpoint { layout, .. } = &self.checkpoint;
        self.is_stopped() || self.checkpoint.record().done.has_all(layout, pose_choices)
    }

    fn is_stopped(&self) -> bool {
        self.checkpoint.stopped.is_some() || self.checkpoint.parts.is_halted()
    }
}

/// Sets all rows aside, and writes both counts of a difference into a file; returns a message with their places.
fn set_aside(record: &mut Record, folder: &Path, evidence: &serde_json::Value) -> String {
    let cleared = match record.journal.set_aside(DISAGREED) {
        Ok(()) => format!("All rows of this folder are set aside in {DISAGREED}"),
        Err(e) => format!("Its rows could not be set aside ({e}): remove the folder"),
    };
    let path = folder.join(DISAGREEMENT);
    match write_whole(&path, &format!("{evidence:#}\n").into_bytes()) {
        Ok(()) => format!("Both counts are in {}. {cleared}", path.display()),
        Err(e) => format!("Both counts: {evidence} ({e}). {cleared}"),
    }
}
