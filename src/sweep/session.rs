//! One run of the program on the folder of a sweep: what an earlier run finished is kept, what fails is done by somebody
//! else, what a device says is doubted, and nothing is lost when it is stopped.
//!
//! # Theory
//! A row is finished when the journal has it, and only then. Everything that can happen (a signal, a device that is
//! lost, a crash) leaves some rows finished and the others not; going on means to do the others. So a device that fails
//! within a run is treated as a run that ended: the same loop is entered again, and finds what is left.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use super::book::{Book, Done, Watch};
use super::check::{DISAGREEMENT, Picked};
use super::files::{OutputFolder, TABLES, write_whole};
use super::journal::{Header, Journal, Locked, Pages, Shard};
use super::manifest::{Fault, MANIFEST, Manifest, Run};
use super::{Ask, Batch, Layout, Ledger, World, layout_of, run_asks, table};
use crate::backend::Backend;
use crate::study::Study;
use crate::{Error, Result};

/// How many choices are done by somebody else before a device that failed is tried again.
const STRETCH: usize = 64;

/// How often a device may fail, with little done between, before it is left alone.
const MOST_STRIKES: u32 = 3;

/// A device that does so many choices between two failures starts again with a clean record.
const CLEAN_AFTER: u64 = 1000;

/// How a backend is worked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gear {
    /// The backend of the user's choice.
    Full,
    /// The same, opened anew, with less memory and small batches.
    Small,
    /// The CPU.
    Cpu,
}

/// Who can do the work.
pub trait Crew {
    /// Opens a backend.
    fn open(&mut self, gear: Gear) -> Result<Box<dyn Backend>>;

    /// Whether the backend of the user's choice is one that may fail or lie: a GPU. Then the CPU steps in, and checks.
    fn is_doubted(&self) -> bool;
}

/// A sweep whose folder is open.
pub struct Session<'a> {
    study: &'a Study,
    worlds: &'a [World],
    folder: OutputFolder,
    layout: Layout,
    asks: Vec<Ask>,
    journal: Journal,
    manifest: Manifest,
    done: Done,
    /// Places of the journal that were damaged; what was there is done again.
    pub damaged: u64,
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
pub enum Ending {
    /// All is done.
    Finished,
    /// It was stopped, for this reason.
    Stopped(String),
}

/// What a run did.
#[derive(Clone, Debug)]
pub struct Report {
    /// How it ended.
    pub ending: Ending,
    /// What the manifest says of it.
    pub run: Run,
    /// What the stages of the last backend's work took.
    pub timings: Vec<(&'static str, Duration)>,
}

/// The choices of a shard, by their places among all. Every choice is in one shard.
pub fn places_of(layout: &Layout, shard: Shard) -> std::ops::Range<usize> {
    let at = |number: u32| (layout.asks() as u128 * u128::from(number) / u128::from(shard.of)) as usize;
    at(shard.number)..at(shard.number + 1)
}

/// The folder of a shard below the folder of the sweep; the sweep's own if there is only one.
pub fn folder_of(out: &Path, shard: Shard) -> PathBuf {
    match shard {
        Shard::WHOLE => out.into(),
        Shard { number, of } => out.join(format!("shard-{number}-of-{of}")),
    }
}

impl<'a> Session<'a> {
    /// Opens a folder, and takes up what was begun there: the same sweep, or, with `restart`, whatever it was.
    /// `command` is what the user typed.
    pub fn open(
        study: &'a Study,
        worlds: &'a [World],
        path: &Path,
        shard: Shard,
        restart: bool,
        command: &str,
    ) -> Result<Session<'a>> {
        let layout = layout_of(study);
        let places = places_of(&layout, shard);
        if places.is_empty() {
            return Err(Error::Input(format!(
                "--shard {}/{}: the study has {} choices of poses, at most so many shards have work",
                shard.number,
                shard.of,
                layout.asks()
            )));
        }
        let folder = OutputFolder::open(path)?;
        let mut manifest = Manifest::new(study, worlds, shard, command);
        let header = Header {
            fingerprint: manifest.fingerprint(),
            shard,
            blocks: layout.blocks() as u64,
            block_rows: layout.block_rows(),
            kept: layout.rows_of_asks(&places),
        };
        let locked = Locked::open(path)?;
        folder.tidy();
        let (journal, done, damaged) = match (restart, &locked.header) {
            (false, Ok(Some(found))) if *found == header => {
                if path.join(DISAGREEMENT).exists() {
                    return Err(Error::input(
                        path.join(DISAGREEMENT).display(),
                        "says that a device counted wrongly here: its rows cannot be trusted; --restart begins anew",
                    ));
                }
                if let Ok(earlier) = Manifest::read(path) {
                    manifest.keep_runs(&earlier);
                }
                let journal = locked.go_on(header);
                let (done, damaged) = Done::of_journal(&layout, places.clone(), &journal)?;
                (journal, done, damaged)
            }
            (false, Ok(Some(found))) => return Err(another(path, found, &header, &manifest)),
            (false, Err(e)) => return Err(Error::Input(e.to_string())),
            (true, _) | (false, Ok(None)) => {
                // What an earlier sweep left would soon be beside a manifest that it does not belong to.
                for name in TABLES.iter().chain([&DISAGREEMENT]) {
                    let _ = std::fs::remove_file(path.join(name));
                }
                (locked.begin(header)?, Done::new(&layout, places.clone()), 0)
            }
        };
        folder.write("poses.csv", &table::poses_csv(study))?;
        folder.write(MANIFEST, &manifest.bytes())?;
        let asks = layout.all_asks().skip(places.start).take(places.len()).collect();
        Ok(Session { study, worlds, folder, layout, asks, journal, manifest, done, damaged })
    }

    /// How many choices there are to score, each snapshot of a scene and each repeat for itself.
    pub fn total(&self) -> u64 {
        (self.layout.blocks() * self.asks.len()) as u64
    }

    /// How many of them are finished.
    pub fn done(&self) -> u64 {
        self.done.count()
    }

    /// Scores what is left. One choice in `verify` is checked where the crew is doubted; none if it is 0.
    pub fn run(
        &mut self,
        crew: &mut dyn Crew,
        verify: u64,
        prepare_s: f64,
        watch: &mut dyn Watch,
    ) -> Result<Report> {
        let begin = Instant::now();
        let began_unix_s = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        let mut backend = crew.open(Gear::Full)?;
        let (name, device) = (backend.name(), backend.device());
        let doubts = crew.is_doubted();
        let mut book = Book {
            layout: &self.layout,
            moments: moments(self.study),
            journal: &mut self.journal,
            done: &mut self.done,
            watch,
            stopped: None,
            entered: None,
            doubted: (doubts && verify > 0).then(|| Picked::one_in(verify)),
            finished: 0,
        };
        let mut shift = Shift {
            study: self.study,
            worlds: self.worlds,
            asks: &self.asks,
            folder: self.folder.path(),
            crew,
            faults: Vec::new(),
            verified: 0,
            checker: None,
        };
        let ended = shift.work(&mut backend, &mut book);
        let (stopped, finished) = (book.stopped.take(), book.finished);
        let synced = self.journal.sync();
        let sweep_s = begin.elapsed().as_secs_f64();
        let run = Run {
            shard: self.journal.header().shard,
            backend: name,
            device,
            began_unix_s,
            prepare_s,
            sweep_s,
            poses: finished,
            poses_per_s: finished as f64 / sweep_s.max(1e-9),
            verified: shift.verified,
            faults: shift.faults,
            ended: match (&ended, &stopped) {
                (Err(e), _) => e.to_string(),
                (Ok(()), Some(why)) => why.clone(),
                (Ok(()), None) => "finished".into(),
            },
        };
        self.manifest.add_run(&run);
        // What the run did is worth less than why it failed.
        let written = self.folder.write(MANIFEST, &self.manifest.bytes());
        ended.and(synced).and(written)?;
        let ending = if self.done() == self.total() {
            Ending::Finished
        } else {
            Ending::Stopped(stopped.unwrap_or_default())
        };
        Ok(Report { ending, run, timings: backend.timings() })
    }

    /// The finished rows, to be looked at.
    pub fn into_pages(self) -> Pages {
        Pages::new(vec![self.journal])
    }
}

/// The first moment of each scene.
fn moments(study: &Study) -> Vec<usize> {
    let mut next = 0;
    let first = |scene: &crate::study::SceneSpec| {
        next += scene.snapshots;
        next - scene.snapshots
    };
    study.scenes.iter().map(first).collect()
}

/// Why a folder cannot be gone on with.
fn another(path: &Path, found: &Header, header: &Header, manifest: &Manifest) -> Error {
    let cure = "name another folder, or begin anew with --restart (what is finished there is then lost)";
    if found.fingerprint == header.fingerprint {
        let Shard { number, of } = found.shard;
        return Error::input(path.display(), format!("holds shard {number}/{of} of this sweep: {cure}"));
    }
    let changes = Manifest::read(path).map(|earlier| earlier.changes(manifest)).unwrap_or_default();
    let what = if changes.is_empty() { "which is not known".into() } else { changes.join("; ") };
    Error::input(path.display(), format!("holds a sweep of something else: {what}. {cure}"))
}

/// The work of one run, whoever does it.
struct Shift<'a> {
    study: &'a Study,
    worlds: &'a [World],
    asks: &'a [Ask],
    folder: &'a Path,
    crew: &'a mut dyn Crew,
    faults: Vec<Fault>,
    verified: u64,
    /// Who checks.
    checker: Option<Box<dyn Backend>>,
}

impl Shift<'_> {
    /// Does what is left, until it is done or stopped. A device that fails is replaced.
    fn work(&mut self, backend: &mut Box<dyn Backend>, book: &mut Book) -> Result<()> {
        let (mut gear, mut strikes, mut last_fault) = (Gear::Full, 0, 0);
        loop {
            let worked = run_asks(self.study, self.worlds, self.asks, Batch::FULL, backend.as_mut(), book);
            match worked {
                Err(Error::Device(what)) if self.crew.is_doubted() && gear != Gear::Cpu => {
                    strikes = if book.finished - last_fault > CLEAN_AFTER { 1 } else { strikes + 1 };
                    let instead = self.rescue(book)?;
                    last_fault = book.finished;
                    gear = if strikes < MOST_STRIKES { Gear::Full } else { Gear::Cpu };
                    *backend = match self.crew.open(gear) {
                        Err(Error::Device(_)) => {
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
                        return Ok(());
                    }
                }
            }
        }
    }

    /// Does the next few choices of the world that a device failed in: the device again, with little at a time, or the
    /// CPU. Says who did.
    fn rescue(&mut self, book: &mut Book) -> Result<&'static str> {
        for (gear, who) in [(Gear::Small, "the same device in small batches"), (Gear::Cpu, "the CPU")] {
            let opened = self.crew.open(gear);
            let done = opened.and_then(|mut backend| {
                // The CPU need not be checked by the CPU.
                let doubted = book.doubted.take_if(|_| gear == Gear::Cpu);
                let done = self.stretch(backend.as_mut(), book);
                book.doubted = book.doubted.take().or(doubted);
                done
            });
            match done {
                Err(Error::Device(_)) if gear != Gear::Cpu => {}
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
                let path = self.folder.join(DISAGREEMENT);
                let mut bytes = serde_json::to_vec_pretty(&difference.evidence).unwrap_or_default();
                bytes.push(b'\n');
                write_whole(&path, &bytes)?;
                Err(Error::Disagreement(format!(
                    "the device and the CPU disagree: {}. Both counts are in {}; what the device counted before cannot be \
                     trusted: run again with --backend cpu --restart, and `perirobot compare` to see more",
                    difference.place,
                    path.display()
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
