//! Does the work of one run with the backend of the user's choice, the same with less at a time, or the CPU,
//! which also checks what a device counted.
//!
//! # Theory
//! A device that fails within a run is treated as a run that ended: its finished rows are in the journal, the
//! others are not, and the same loop is entered again with another backend, which does what is left. So no
//! kind of failure needs its own recovery.

use std::path::Path;
use std::time::Duration;

use super::checkpoint::Checkpoint;
use super::{BatchSize, Ledger, run_choices};
use crate::results::PoseChoice;
use crate::results::files::{DISAGREED, DISAGREEMENT, write_whole};
use crate::results::manifest::Fault;
use perirobot_march::backend::Backend;
use perirobot_march::backend::factory::{BackendFactory, Fallback};
use perirobot_march::error::{Argument, Issue, Words, catch_panic};
use perirobot_march::{Error, Result};
use perirobot_study::study::Study;
use perirobot_study::world::World;

/// How many choices a fallback does before a device that failed is tried again.
const CHUNK: usize = 64;

/// How often a device may fail, with little done between, before it is given up.
const MOST_FAILURES: u32 = 3;

/// A device that does so many choices between two failures starts again with a clean record.
const CLEAN_AFTER: u64 = 1000;

/// What the stages of a backend's work took, in the order they run.
pub(super) type Timings = Vec<(&'static str, Duration)>;

/// The work of one run, by whichever backend.
pub(super) struct Worker<'a> {
    pub(super) study: &'a Study,
    pub(super) worlds: &'a [World],
    pub(super) pose_choices: &'a [PoseChoice],
    pub(super) folder: &'a Path,
    pub(super) backends: &'a mut dyn BackendFactory,
    pub(super) faults: Vec<Fault>,
    pub(super) verified: u64,
    /// The backend that checks: the CPU.
    pub(super) checker: Option<Box<dyn Backend + Send>>,
}

impl Worker<'_> {
    /// Does what is left, until it is done or stopped. A device that fails is replaced. Says what the stages
    /// of the last one's work took.
    pub(super) fn work(
        &mut self,
        mut backend: Box<dyn Backend + Send>,
        checkpoint: &mut Checkpoint,
    ) -> Result<Timings> {
        let (mut fallback, mut failures, mut last_fault) = (Fallback::None, 0, 0);
        loop {
            let (worlds, all) = (self.worlds, self.pose_choices);
            let worked = catch_panic(|| {
                run_choices(self.study, worlds, all, BatchSize::FULL, backend.as_mut(), checkpoint)
            });
            match worked {
                Err(error @ (Error::Device(_) | Error::Bug(_)))
                    if self.backends.needs_check() && fallback != Fallback::Cpu =>
                {
                    // Its memory must be free before the next one is opened.
                    drop(backend);
                    failures = if checkpoint.finished - last_fault > CLEAN_AFTER { 1 } else { failures + 1 };
                    let instead = self.fall_back(checkpoint)?;
                    last_fault = checkpoint.finished;
                    fallback = if failures < MOST_FAILURES { Fallback::None } else { Fallback::Cpu };
                    // It was opened before, so a failure to open it now is the device's.
                    backend = match self.backends.open(fallback) {
                        Err(_) if fallback != Fallback::Cpu => {
                            fallback = Fallback::Cpu;
                            self.backends.open(fallback)?
                        }
                        other => other?,
                    };
                    if fallback == Fallback::None {
                        checkpoint.watch.runs_on(backend.as_ref());
                    }
                    let for_good = if fallback == Fallback::Cpu { ", and from then on the CPU" } else { "" };
                    let scene = self.scene(checkpoint);
                    // The fallback has done its part; the device is tried again.
                    let fault = Fault::new(&error, scene, format!("{instead}{for_good}"));
                    checkpoint.watch.failed(&fault);
                    self.faults.push(fault);
                    if fallback == Fallback::Cpu {
                        self.check(checkpoint)?;
                        checkpoint.unchecked = None;
                    }
                }
                Err(e) => return Err(e),
                Ok(()) => {
                    self.check(checkpoint)?;
                    if checkpoint.stopped.is_some() || !self.is_anything_left(checkpoint) {
                        return Ok(backend.timings());
                    }
                }
            }
        }
    }

    /// Does the next few choices of the world that a device failed in: the device again, with little at a
    /// time, or the CPU. Says which.
    fn fall_back(&mut self, checkpoint: &mut Checkpoint) -> Result<&'static str> {
        // Rows that wait to be checked would keep the next backend from beginning.
        self.check(checkpoint)?;
        for (fallback, who) in
            [(Fallback::Small, "the same device in small batches"), (Fallback::Cpu, "the CPU")]
        {
            let opened = self.backends.open(fallback);
            let done = opened.and_then(|mut backend| {
                // The CPU need not be checked by the CPU.
                let unchecked = checkpoint.unchecked.take_if(|_| fallback == Fallback::Cpu);
                let done = catch_panic(|| self.chunk(backend.as_mut(), checkpoint));
                checkpoint.unchecked = checkpoint.unchecked.take().or(unchecked);
                done
            });
            match done {
                // If even small batches do not fit, the input is not to blame.
                Err(Error::Device(_) | Error::Bug(_) | Error::Input(_)) if fallback != Fallback::Cpu => {}
                other => return other.map(|()| who),
            }
        }
        unreachable!("the CPU's outcome was returned")
    }

    /// The next few choices of the world that was worked on last.
    fn chunk(&self, backend: &mut dyn Backend, checkpoint: &mut Checkpoint) -> Result<()> {
        let here = |world: &World| Some([world.scene, world.snapshot]) == checkpoint.entered;
        let Some(i) = self.worlds.iter().position(here) else { return Ok(()) };
        let mut pose_choices = self.pose_choices.to_vec();
        let repeats = 0..self.study.repeats as usize;
        pose_choices.retain(|pose_choice| {
            repeats.clone().any(|repeat| checkpoint.wants(&self.worlds[i], repeat, pose_choice))
        });
        pose_choices.truncate(CHUNK);
        run_choices(self.study, &self.worlds[i..=i], &pose_choices, BatchSize::SMALL, backend, checkpoint)
    }

    /// Checks what was picked. A difference ends the run, with the evidence in a file.
    fn check(&mut self, checkpoint: &mut Checkpoint) -> Result<()> {
        let Some(picked) = &mut checkpoint.unchecked else { return Ok(()) };
        if self.checker.is_none() {
            self.checker = Some(self.backends.open(Fallback::Cpu)?);
        }
        let Some(checker) = &mut self.checker else { return Ok(()) };
        match picked.check(self.study, self.worlds, checker.as_mut())? {
            Ok(number) => {
                self.verified += number;
                Ok(())
            }
            Err(difference) => {
                // A later run or a merge would take rows of a device that counts wrongly for finished ones.
                let cleared = match checkpoint.journal.set_aside(DISAGREED) {
                    Ok(()) => format!("All rows of this folder are set aside in {DISAGREED}"),
                    Err(e) => format!("Its rows could not be set aside ({e}): remove the folder"),
                };
                let path = self.folder.join(DISAGREEMENT);
                let bytes = format!("{:#}\n", difference.evidence).into_bytes();
                let kept = match write_whole(&path, &bytes) {
                    Ok(()) => format!("Both counts are in {}", path.display()),
                    Err(e) => format!("Both counts: {} ({e})", difference.evidence),
                };
                let what =
                    format!("the device and the CPU disagree: {}. {kept}. {cleared}", difference.place);
                let cure = Words::from("run again with ")
                    + Argument("backend").to("cpu")
                    + ", and `perirobot verify-backends` to see more";
                Err(Error::Disagreement(Issue::says(what).cure(cure)))
            }
        }
    }

    fn is_anything_left(&self, checkpoint: &Checkpoint) -> bool {
        checkpoint.done.count() < (checkpoint.layout.blocks() * self.pose_choices.len()) as u64
    }

    /// The world that was worked on last, in words.
    fn scene(&self, checkpoint: &Checkpoint) -> String {
        let here = |world: &&World| Some([world.scene, world.snapshot]) == checkpoint.entered;
        self.worlds.iter().find(here).map_or(String::new(), |world| world.title(self.study))
    }
}
