//! One run of the program on the folder of a sweep: finished rows are kept, failed work goes to another
//! backend, a device's counts are checked, and nothing is lost when the run is stopped.
//!
//! # Theory
//! A row is finished when the journal has it, and only then. Whatever happens (a signal, a device that is
//! lost, a crash), some rows are finished and the others are not; resuming means to do the others.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use super::Row;
use super::check::{AT_LEAST, Picked};
use super::checkpoint::{Checkpoint, Done, Record};
use super::devices::{Parts, add_timings, devices, on_each};
use super::failover::{Failover, TaskChoices, Timings};
use super::sweeping::Sweeping;
use crate::results::files::{JOURNAL, MANIFEST, OutputFolder};
use crate::results::journal::{Journal, JournalHeader, Locked, Pages, Shard, Unfit};
use crate::results::manifest::{KILLED, Manifest, Run};
use crate::results::{PoseChoice, RowLayout, columns, layout_of, places_of};
use perirobot_march::backend::factory::{BackendFactory, Fallback, KeptBackends};
use perirobot_march::error::{Argument, Issue, Site, Words, catch_panic};
use perirobot_march::progress::{Fault, Progress};
use perirobot_march::{Error, Result};
use perirobot_study::input::Study;
use perirobot_study::world::World;

/// A sweep with an open folder.
pub struct Session<'a> {
    study: &'a Study,
    worlds: &'a [World],
    folder: OutputFolder,
    layout: RowLayout,
    pose_choices: Vec<PoseChoice>,
    journal: Journal,
    manifest: Manifest,
    done: Done,
    /// Damaged places of the journal; their rows are counted again.
    pub damaged: u64,
}

/// The end of a run.
#[derive(Clone, Debug, PartialEq)]
pub enum Ending {
    /// All rows are finished.
    Finished,
    /// The run was stopped, for this reason.
    Stopped(String),
}

/// The report of a run.
#[derive(Clone, Debug)]
pub struct RunReport {
    /// Its end.
    pub ending: Ending,
    /// Its entry in the manifest.
    pub run: Run,
    /// Stage times of the last backend.
    pub timings: Timings,
}

/// The folder of a shard below the folder of the sweep; the sweep's own folder for a single one.
pub fn folder_of(out: &Path, Shard { number, of }: Shard) -> PathBuf {
    out.join(format!("shard-{number}-of-{of}"))
}

impl<'a> Session<'a> {
    /// Opens a folder, and resumes the same sweep there or, with `restart`, replaces any sweep. `command` is the
    /// command of the sweep, word by word.
    ///
    /// # Errors
    /// `Error::Input` if the folder contains anything else, with the differences, or is not writable; `Error::Busy` if
    /// another run uses it; `Error::Storage` if the disk fails.
    pub fn open(
        study: &'a Study,
        worlds: &'a [World],
        path: &Path,
        shard: Shard,
        restart: bool,
        command: &[String],
    ) -> Result<Session<'a>> {
        let layout = layout_of(study);
        let places = places_of(&layout, shard);
        if places.is_empty() {
            let choices = layout.pose_choices();
            let what = format!(
                "has no work: the study has only {choices} choices of poses, enough for {choices} shards"
            );
            let place = Site::Argument(Argument("shard"), format!("{}/{}", shard.number, shard.of));
            return Err(Issue::says(what).with_place(place).into());
        }
        let folder = OutputFolder::open(path)?;
        folder.spare(&study.sources, &[])?;
        let poses_csv = columns::poses_csv(study, &worlds[0]);
        let mut manifest = Manifest::with_poses(study, worlds, &poses_csv, shard, command);
        let header = JournalHeader {
            fingerprint: manifest.fingerprint(),
            shard,
            blocks: layout.blocks() as u64,
            block_rows: layout.block_rows(),
            kept: layout.rows_of_choices(&places),
        };
        let locked = Locked::open(path)?;
        folder.tidy();
        let (journal, done, damaged) = match (restart, &locked.header) {
            (false, Ok(Some(found))) if *found == header => {
                if let Ok(earlier) = Manifest::read(path) {
                    manifest.provenance.runs = earlier.provenance.runs;
                }
                let journal = locked.go_on(header);
                let (done, damaged) = Done::from_journal(&layout, places.clone(), &journal)?;
                (journal, done, damaged)
            }
            (false, Ok(Some(found))) => return Err(another(path, found, &header, &manifest)),
            (false, Err(unfit)) => {
                let cure = match unfit {
                    Unfit::Damaged => Words::from(Argument("restart")) + " starts over",
                    Unfit::Format(_) => "name another folder".into(),
                    Unfit::Foreign => "name another folder, or move it away".into(),
                };
                return Err(Issue::damaged(unfit.to_string())
                    .cure(cure)
                    .with_place(path.join(JOURNAL))
                    .into());
            }
            (false, Ok(None)) if folder.table().is_some() => {
                let table = folder.table().unwrap_or_default();
                let what = format!(
                    "belongs to an earlier sweep whose {JOURNAL} is missing, so it cannot be resumed"
                );
                let cure = Words::from("name another folder, or ") + Argument("restart") + " to discard it";
                return Err(Error::input(path.join(table), what).with_advice(cure));
            }
            (true, _) | (false, Ok(None)) => {
                folder.clear(false);
                (locked.begin(header)?, Done::new(&layout, places.clone()), 0)
            }
        };
        folder.write("poses.csv", &poses_csv)?;
        folder.write(MANIFEST, &manifest.bytes())?;
        let pose_choices = layout.all_choices().skip(places.start).take(places.len()).collect();
        Ok(Session { study, worlds, folder, layout, pose_choices, journal, manifest, done, damaged })
    }

    /// The number of choices to score, in each snapshot and repeat.
    pub fn total(&self) -> u64 {
        (self.layout.blocks() * self.pose_choices.len()) as u64
    }

    /// The number of finished ones.
    pub fn finished_count(&self) -> u64 {
        self.done.count()
    }

    /// Scores the rest. For a device, one choice in `verify` is checked on the CPU; none if it is 0.
    ///
    /// # Errors
    /// `Error::Disagreement` if a device and the CPU count differently; `Error::Storage` if the disk fails;
    /// `Error::Device` if no backend can do the work; `Error::Bug` after a panic. Except for the first, finished rows
    /// are kept.
    pub fn run(
        &mut self,
        backends: &mut dyn BackendFactory,
        verify: u64,
        prepare_s: f64,
        progress: &dyn Progress,
    ) -> Result<RunReport> {
        let begin = Instant::now();
        let began_unix_s = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
        let mut devices = devices(backends);
        let (mut name, mut labels) = ("", Vec::new());
        for device in &mut devices {
            let backend = device.open(Fallback::None)?;
            name = backend.name();
            labels.push(backend.device());
            device.take_back(backend);
        }
        let mut unchecked = self.unchecked_rows(verify)?;
        let mut run = Run {
            shard: self.journal.header().shard,
            backend: name.into(),
            device: labels.join("; "),
            began_unix_s,
            prepare_s,
            sweep_s: None,
            poses: None,
            poses_per_s: None,
            verified: None,
            faults: None,
            ended: KILLED.into(),
        };
        self.manifest.provenance.runs.push(run.clone());
        self.folder.write(MANIFEST, &self.manifest.bytes())?;
        let choices =
            TaskChoices { study: self.study, worlds: self.worlds, pose_choices: &self.pose_choices };
        let parts = Parts::new(&self.pose_choices, devices.len());
        let record =
            Mutex::new(Record { journal: &mut self.journal, done: &mut self.done, is_set_aside: false });
        let several = devices.len() > 1;
        let with_tasks = devices.iter_mut().zip(labels).map(|(device, label)| {
            // Rows of a killed run are checked in parallel with the first device.
            let earlier = std::mem::take(&mut unchecked);
            let unchecked = match (device.needs_check() && verify > 0, earlier.is_empty()) {
                (true, _) => Some(Picked::one_in(verify).with_rows(earlier)),
                (false, false) => Some(Picked::from_rows(earlier)),
                (false, true) => None,
            };
            let checkpoint = Checkpoint {
                layout: &self.layout,
                moments: moments(self.study),
                record: &record,
                parts: &parts,
                progress,
                stopped: None,
                unchecked,
                is_trusted: false,
                finished: 0,
            };
            let (device_name, folder) = (several.then_some(label), self.folder.path());
            let sweeping =
                Sweeping { device: device_name, choices, folder, checkpoint, verified: 0, checker: None };
            (device, sweeping)
        });
        let worked = on_each(with_tasks.collect(), &parts, |(device, mut sweeping)| {
            let mut failover = Failover::new(device, progress);
            let ended = catch_panic(|| parts.work(&mut failover, choices, &mut sweeping));
            let Sweeping { checkpoint: Checkpoint { stopped, finished, .. }, verified, .. } = sweeping;
            Ok(DeviceReport { ended, stopped, finished, verified, faults: failover.faults })
        })?;
        devices.iter_mut().for_each(KeptBackends::give_back);
        let finished = worked.iter().map(|device| device.finished).sum();
        let verified = worked.iter().map(|device| device.verified).sum();
        let stopped = worked.iter().find_map(|device| device.stopped.clone());
        let (ended, faults): (Vec<_>, Vec<_>) =
            worked.into_iter().map(|device| (device.ended, device.faults)).unzip();
        let ended = ended.into_iter().collect::<Result<Vec<_>>>().map(add_timings);
        let synced = self.journal.sync();
        let sweep_s = begin.elapsed().as_secs_f64();
        (run.sweep_s, run.poses) = (Some(sweep_s), Some(finished));
        run.poses_per_s = Some(finished as f64 / sweep_s.max(1e-9));
        (run.verified, run.faults) = (Some(verified), Some(faults.concat()));
        run.ended = match (&ended, &stopped) {
            (Err(e), _) => e.to_string(),
            (Ok(_), Some(why)) => why.clone(),
            (Ok(_), None) => "finished".into(),
        };
        self.manifest.end_run(run.clone());
        if ended.is_ok() && verify > 0 {
            self.manifest.runs_are_checked();
        }
        // An error of the final record matters less than the reason for the failure.
        let written = self.folder.write(MANIFEST, &self.manifest.bytes());
        let timings = ended.and_then(|timings| synced.and(written).map(|()| timings))?;
        let ending = if self.finished_count() == self.total() {
            Ending::Finished
        } else {
            Ending::Stopped(stopped.unwrap_or_default())
        };
        Ok(RunReport { ending, run, timings })
    }

    /// Whether there may be unchecked rows of a device: its run was killed.
    pub fn is_unchecked(&self) -> bool {
        self.manifest.has_unchecked_run()
    }

    /// Of the unchecked rows, those of the first choices and of one in `verify`.
    fn unchecked_rows(&self, verify: u64) -> Result<Vec<Vec<Row>>> {
        let mut picked = Vec::new();
        if verify == 0 || !self.is_unchecked() {
            return Ok(picked);
        }
        let mut seen = 0;
        for world in self.worlds {
            let moment = moments(self.study)[world.scene] + world.snapshot;
            for (repeat, pose_choice) in
                (0..self.study.repeats as usize).flat_map(|r| self.pose_choices.iter().map(move |a| (r, a)))
            {
                let block = self.layout.block(moment, repeat);
                if !self.done.has(block, self.layout.place(pose_choice)) {
                    continue;
                }
                if seen < AT_LEAST || seen % verify == 0 {
                    picked.push(self.rows(world, repeat, pose_choice)?);
                }
                seen += 1;
            }
        }
        Ok(picked)
    }

    /// The rows of a finished choice.
    fn rows(&self, world: &World, repeat: usize, pose_choice: &PoseChoice) -> Result<Vec<Row>> {
        let moment = moments(self.study)[world.scene] + world.snapshot;
        let first = self.layout.block(moment, repeat) as u64 * self.layout.block_rows();
        let within = self.layout.rows_of_choice(pose_choice);
        let counts = self.journal.counts(first + within.start..first + within.end)?;
        let regions = self.study.regions.len();
        let row = |(number, counts)| Row {
            scene: world.scene,
            snapshot: world.snapshot,
            repeat,
            combination: pose_choice.combination,
            choice: pose_choice.choice,
            representation: number / regions,
            region: number % regions,
            counts,
        };
        Ok(counts.into_iter().enumerate().map(row).collect())
    }

    /// The finished rows, for reading.
    pub fn into_pages(self) -> Pages {
        Pages::new(vec![self.journal])
    }
}

/// The report of a device.
struct DeviceReport {
    ended: Result<Timings>,
    stopped: Option<String>,
    finished: u64,
    verified: u64,
    faults: Vec<Fault>,
}

/// The first moment of each scene.
fn moments(study: &Study) -> Vec<usize> {
    let mut next = 0;
    let first = |scene: &perirobot_scene::objects::spec::SceneSpec| {
        next += scene.snapshots;
        next - scene.snapshots
    };
    study.scenes.iter().map(first).collect()
}

/// The error for a folder with a sweep that cannot be resumed.
fn another(path: &Path, found: &JournalHeader, header: &JournalHeader, manifest: &Manifest) -> Error {
    let cure = Words::from("name another folder, or start over with ")
        + Argument("restart")
        + " (which discards its finished rows)";
    if found.fingerprint == header.fingerprint {
        let Shard { number, of } = found.shard;
        let what = format!("contains shard {number}/{of} of this sweep");
        return Issue::says(what).with_advice(cure).with_place(path).into();
    }
    let changes = Manifest::read(path).map(|earlier| earlier.changes(manifest)).unwrap_or_default();
    let what = if changes.is_empty() { "unknown differences".into() } else { changes.join("; ") };
    Error::input(path, Words::from(format!("contains another sweep: {what}. ")) + cure)
}
