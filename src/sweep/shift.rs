//! Who does the work of one run: the backend of the user's choice, the same with less at a time, or the CPU,
//! which also checks what a device counted.
//!
//! # Theory
//! A device that fails within a run is treated as a run that ended: its finished rows are in the journal, the
//! others are not, and the same loop is entered again by somebody else, who finds what is left. So no failure
//! needs a way back of its own.

use std::path::Path;
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

use super::Batch;
use super::Ledger;
use super::book::Book;
use super::run_asks;
use crate::backend::Backend;
use crate::results::Ask;
use crate::results::files::{DISAGREED, DISAGREEMENT, write_whole};
use crate::results::manifest::Fault;
use crate::study::Study;
use crate::world::World;
use crate::{Error, Result};

/// How many choices are done in another way before a device that failed is tried again.
const STRETCH: usize = 64;

/// How often a device may fail, with little done between, before it is left alone.
const MOST_STRIKES: u32 = 3;

/// A device that does so many choices between two failures starts again with a clean record.
const CLEAN_AFTER: u64 = 1000;

/// How long a device that failed may take to be closed.
const LET_GO_WITHIN: Duration = Duration::from_secs(10);

/// Which backend works, and with how much at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gear {
    /// The backend of the user's choice.
    Full,
    /// The same, opened anew, with less memory and small batches.
    Small,
    /// The CPU.
    Cpu,
}

/// Opens the backends that a run may use.
pub trait Crew {
    /// Opens a backend.
    fn open(&mut self, gear: Gear) -> Result<Box<dyn Backend + Send>>;

    /// Whether the backend of the user's choice is one that may fail or count wrongly: a GPU. Then the CPU
    /// takes over, and checks.
    fn is_doubted(&self) -> bool;
}

/// What the stages of a backend's work took, in the order they run.
pub(super) type Timings = Vec<(&'static str, Duration)>;

/// The work of one run, by whichever backend.
pub(super) struct Shift<'a> {
    pub(super) study: &'a Study,
    pub(super) worlds: &'a [World],
    pub(super) asks: &'a [Ask],
    pub(super) folder: &'a Path,
    pub(super) crew: &'a mut dyn Crew,
    pub(super) faults: Vec<Fault>,
    pub(super) verified: u64,
    /// The backend that checks: the CPU.
    pub(super) checker: Option<Box<dyn Backend + Send>>,
}

impl Shift<'_> {
    /// Does what is left, until it is done or stopped. A device that fails is replaced. Says what the stages
    /// of the last one's work took.
    pub(super) fn work(&mut self, mut backend: Box<dyn Backend + Send>, book: &mut Book) -> Result<Timings> {
        let (mut gear, mut strikes, mut last_fault) = (Gear::Full, 0, 0);
        loop {
            let worked = run_asks(self.study, self.worlds, self.asks, Batch::FULL, backend.as_mut(), book);
            match worked {
                Err(Error::Device(what)) if self.crew.is_doubted() && gear != Gear::Cpu => {
                    let_go(backend);
                    strikes = if book.finished - last_fault > CLEAN_AFTER { 1 } else { strikes + 1 };
                    let instead = self.rescue(book)?;
                    last_fault = book.finished;
                    gear = if strikes < MOST_STRIKES { Gear::Full } else { Gear::Cpu };
                    // It was opened before, so whatever is in the way now is the device's.
                    backend = match self.crew.open(gear) {
                        Err(_) if gear != Gear::Cpu => {
                            gear = Gear::Cpu;
                            self.crew.open(gear)?
                        }
                        other => other?,
                    };
                    let for_good = if gear == Gear::Cpu { ", and from then on the CPU" } else { "" };
                    let scene = self.scene(book);
                    let fault = Fault { what, scene, instead: format!("{instead}{for_good}") };
                    book.watch.failed(&fault);
                    self.faults.push(fault);
                    if gear == Gear::Cpu {
                        self.check(book)?;
                        book.doubted = None;
                    }
                }
                Err(e) => return Err(e),
                Ok(()) => {
                    self.check(book)?;
                    if book.stopped.is_some() || !self.is_anything_left(book) {
                        return Ok(backend.timings());
                    }
                }
            }
        }
    }

    /// Does the next few choices of the world that a device failed in: the device again, with little at a
    /// time, or the CPU. Says which.
    fn rescue(&mut self, book: &mut Book) -> Result<&'static str> {
        // Rows that wait to be checked would keep the next backend from beginning.
        self.check(book)?;
        for (gear, who) in [(Gear::Small, "the same device in small batches"), (Gear::Cpu, "the CPU")] {
            let opened = self.crew.open(gear);
            let done = opened.and_then(|mut backend| {
                // The CPU need not be checked by the CPU.
                let doubted = book.doubted.take_if(|_| gear == Gear::Cpu);
                let done = self.stretch(backend.as_mut(), book);
                let_go(backend);
                book.doubted = book.doubted.take().or(doubted);
                done
            });
            match done {
                // What does not fit in small batches is no fault of the user's.
                Err(Error::Device(_) | Error::Input(_)) if gear != Gear::Cpu => {}
                other => return other.map(|()| who),
            }
        }
        unreachable!("the CPU's outcome was returned")
    }

    /// The next few choices of the world that was worked on last.
    fn stretch(&self, backend: &mut dyn Backend, book: &mut Book) -> Result<()> {
        let here = |world: &World| Some([world.scene, world.snapshot]) == book.entered;
        let Some(i) = self.worlds.iter().position(here) else { return Ok(()) };
        let mut asks = self.asks.to_vec();
        let repeats = 0..self.study.repeats as usize;
        asks.retain(|ask| repeats.clone().any(|repeat| book.wants(&self.worlds[i], repeat, ask)));
        asks.truncate(STRETCH);
        run_asks(self.study, &self.worlds[i..=i], &asks, Batch::SMALL, backend, book)
    }

    /// Counts again what was picked for it. A difference ends the run, with the evidence in a file.
    fn check(&mut self, book: &mut Book) -> Result<()> {
        let Some(picked) = &mut book.doubted else { return Ok(()) };
        if self.checker.is_none() {
            self.checker = Some(self.crew.open(Gear::Cpu)?);
        }
        let Some(checker) = &mut self.checker else { return Ok(()) };
        match picked.check(self.study, self.worlds, checker.as_mut())? {
            Ok(number) => {
                self.verified += number;
                Ok(())
            }
            Err(difference) => {
                // A later run or a merge would take rows of a device that counts wrongly for finished ones.
                let cleared = match book.journal.set_aside(DISAGREED) {
                    Ok(()) => format!("All rows of this folder are set aside in {DISAGREED}"),
                    Err(e) => format!("Its rows could not be set aside ({e}): remove the folder"),
                };
                let path = self.folder.join(DISAGREEMENT);
                let bytes = format!("{:#}\n", difference.evidence).into_bytes();
                let kept = match write_whole(&path, &bytes) {
                    Ok(()) => format!("Both counts are in {}", path.display()),
                    Err(e) => format!("Both counts: {} ({e})", difference.evidence),
                };
                Err(Error::Disagreement(format!(
                    "the device and the CPU disagree: {}. {kept}. {cleared}; run again with --backend cpu, and \
                     `perirobot verify-backends` to see more",
                    difference.place
                )))
            }
        }
    }

    fn is_anything_left(&self, book: &Book) -> bool {
        book.done.count() < (book.layout.blocks() * self.asks.len()) as u64
    }

    /// The world that was worked on last, in words.
    fn scene(&self, book: &Book) -> String {
        let here = |world: &&World| Some([world.scene, world.snapshot]) == book.entered;
        self.worlds.iter().find(here).map_or(String::new(), |world| world.title(self.study))
    }
}

/// Parts with a device that failed, and waits until it has given back its memory; not for ever, since one
/// that hangs may never do.
fn let_go(backend: Box<dyn Backend + Send>) {
    let (gone, wait) = mpsc::channel::<()>();
    // Where no thread can be started, it is waited for.
    let _ = thread::Builder::new().spawn(move || {
        drop(backend);
        drop(gone);
    });
    let _ = wait.recv_timeout(LET_GO_WITHIN);
}
