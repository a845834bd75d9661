//! Evidence is read from the folder, the rest is cast and stored there, and what the question needs is held in memory if
//! it fits.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;

use super::super::check::count_again;
use super::super::planes::{SaidPlanes, join, pack, unpack};
use super::super::problem::candidates_of;
use super::deciding::deciding;
use super::file::{EvidenceFile, PackedPlanes, RecordKey};
use super::region::{CandidateWords, RegionRows};
use super::rows::{FiledRecords, FiledRows, RecordPlace};
use perirobot_cover::CandidateEvidence;
use perirobot_cover::layout::WantedCounts;
use perirobot_march::backend::Backend;
use perirobot_march::backend::factory::{BackendFactory, Fallback};
use perirobot_march::error::{Argument, Issue, Words, catch_panic};
use perirobot_march::progress::Progress;
use perirobot_march::voxel::{BitGrid, Window};
use perirobot_march::{Error, Result};
use perirobot_scene::source::sha256;
use perirobot_scene::truth::region::window_of;
use perirobot_study::input::{Combination, Member, Study};
use perirobot_study::sensor::Sensor;
use perirobot_study::world::World;
use perirobot_sweep::results::PoseChoice;
use perirobot_sweep::results::files::write_whole;
use perirobot_sweep::scoring::{EvidenceReader, Failover, ReadPlan, SensorSays};

/// Partly complete evidence.
pub struct Casting<'a> {
    study: &'a Study,
    worlds: &'a [World],
    /// The representation of each sensor.
    representations: &'a [usize],
    /// The voxels of each world that evidence covers.
    windows: Vec<Window>,
    /// Sensor and candidate of each row, in study order.
    items: Vec<[usize; 2]>,
    /// The regions, with their wanted counts.
    regions: Vec<(usize, WantedCounts)>,
    /// The rows of each region.
    rows: Vec<RegionRows>,
    is_filed: bool,
    /// The place of each record of each row in the file.
    places: Vec<Vec<RecordPlace>>,
    /// For each row the finished repeats of each world, and the number of the others.
    done: Vec<Vec<bool>>,
    left: Vec<u64>,
    /// Memory limit of the rows of all regions, in bytes.
    memory_bytes: u64,
    file: Option<EvidenceFile>,
    /// Damaged records of the file; their evidence is cast again.
    pub damaged: usize,
}

/// The evidence of all candidates.
pub struct CastEvidence {
    /// The evidence of each requested region, in that order; the same candidates in all.
    pub of_regions: Vec<CandidateEvidence>,
    /// The file that it is read from, if it exceeds the memory limit.
    pub file: Option<PathBuf>,
    /// The number of poses of a device that the CPU recounted.
    pub checked: Option<u64>,
}

/// The marker file next to evidence of a device. It lists the regions in which the CPU has recounted some of it.
fn doubt_marker(evidence: &Path) -> PathBuf {
    evidence.with_extension("unchecked")
}

/// The first line of the marker file.
const DOUBT: &str = "a device cast these poses; regions in which the CPU counted some of them again:\n";

/// A region with its wanted counts, as the marker file lists it: a study may change the meaning of a name.
fn checked_region(worlds: &[World], (region, wanted): (usize, WantedCounts)) -> String {
    let voxels = worlds.iter().map(|world| &world.regions[region].voxels);
    let words = voxels.flat_map(|voxels| voxels.words()).flat_map(|word| word.to_le_bytes());
    let windows: Vec<Window> = worlds.iter().map(|world| world.regions[region].voxels.window()).collect();
    let question = format!("{wanted:?} {windows:?}");
    let name = &worlds[0].regions[region].name;
    format!("{} {name}", sha256([question.as_bytes(), &words.collect::<Vec<u8>>()]))
}

/// The number of different repeats of a sensor.
fn repeats(study: &Study, sensor: &Sensor) -> usize {
    if sensor.kind.is_noisy() { study.repeats as usize } else { 1 }
}

impl<'a> Casting<'a> {
    /// The wanted counts of some regions, whose rows may take `memory_bytes` together; `representations` is the
    /// representation of each sensor. The folder's evidence is read, and new evidence is stored there; `restart`
    /// discards the old.
    ///
    /// # Errors
    /// If it does not fit into memory; those of the file.
    pub fn begin(
        study: &'a Study,
        regions: &[(usize, WantedCounts)],
        representations: &'a [usize],
        worlds: &'a [World],
        memory_bytes: u64,
        kept: Option<(&Path, bool)>,
    ) -> Result<Casting<'a>> {
        let items = candidates_of(study);
        let blocks = |&[sensor, _]: &[usize; 2]| repeats(study, &study.sensors[sensor]) * worlds.len();
        // Stored evidence serves any region of a later study.
        let window = |world: &World| match kept {
            Some(_) => world.grid.window(),
            None => window_of(&world.regions),
        };
        let windows: Vec<Window> = worlds.iter().map(window).collect();
        let file = match kept {
            Some((folder, restart)) => {
                Some(EvidenceFile::open(folder, study, &deciding(study, worlds, representations), restart)?)
            }
            None => None,
        };
        let rows = |&region| RegionRows::new(study, (worlds, &windows), region, representations, items.len());
        let mut casting = Casting {
            rows: regions.iter().map(rows).collect(),
            is_filed: false,
            places: items.iter().map(|item| vec![RecordPlace::default(); blocks(item)]).collect(),
            done: items.iter().map(|item| vec![false; blocks(item)]).collect(),
            left: items.iter().map(|item| blocks(item) as u64).collect(),
            memory_bytes,
            file: None,
            damaged: 0,
            regions: regions.to_vec(),
            study,
            worlds,
            representations,
            windows,
            items,
        };
        if let Some(mut file) = file {
            casting.read(&mut file)?;
            casting.file = Some(file);
        }
        casting.fits()?;
        Ok(casting)
    }

    /// Reads the records of a file.
    fn read(&mut self, file: &mut EvidenceFile) -> Result<()> {
        let blocks: Vec<usize> = self.done.iter().map(Vec::len).collect();
        let worlds = self.worlds.len();
        let is_known = |key: RecordKey| {
            key.world < worlds && blocks.get(key.item).is_some_and(|blocks| key.repeat < blocks / worlds)
        };
        let found = file.read(is_known, |key, at, packed| {
            let window = self.windows[key.world];
            let planes: Option<Vec<BitGrid>> = packed.iter().map(|plane| unpack(plane, window)).collect();
            let Some(said) = planes.and_then(|planes| SaidPlanes::try_from(planes).ok()) else {
                return false;
            };
            let words = self.pick(key, &said);
            self.put(key, RecordPlace::new(at, &packed), &words);
            true
        })?;
        let lost = found.damaged.iter().filter(|&&key| !self.done[key.item][self.block(key)]).count();
        self.damaged = lost + usize::from(found.is_cut && self.remaining() > 0);
        Ok(())
    }

    /// The number of candidates, in each scene, snapshot and repeat.
    pub fn total(&self) -> u64 {
        self.done.iter().map(|done| done.len() as u64).sum()
    }

    /// The number that is not finished.
    pub fn remaining(&self) -> u64 {
        self.left.iter().sum()
    }

    /// Whether it exceeds the memory limit, so that it is read from the file when needed.
    pub fn is_filed(&self) -> bool {
        self.is_filed
    }

    /// The file of the evidence.
    pub fn path(&self) -> Option<&Path> {
        self.file.as_ref().map(|file| file.path.as_path())
    }

    /// Casts the rest.
    ///
    /// # Errors
    /// If the backend fails; if the disk does; `Error::Stopped`. Finished evidence is kept.
    pub fn run(&mut self, backend: &mut dyn Backend, progress: &dyn Progress) -> Result<()> {
        self.run_by(progress, |plan, taking| plan.read(backend, taking))
    }

    /// The same on the user's backend, with fallbacks for a failing device. Evidence of a device is marked as unchecked
    /// until [`Casting::check`] succeeds; a later run checks it even if it uses another backend or casts nothing.
    ///
    /// # Errors
    /// Those of [`Casting::run`].
    pub fn run_on(&mut self, failover: &mut Failover) -> Result<()> {
        if let Some(doubt) = self.doubt().filter(|_| self.remaining() > 0 && failover.needs_check()) {
            write_whole(&doubt, DOUBT.as_bytes())?;
        }
        self.run_by(failover.progress(), |plan, taking| plan.read_on(failover, taking))
    }

    fn run_by(
        &mut self,
        progress: &dyn Progress,
        read: impl FnOnce(ReadPlan, &mut dyn EvidenceReader) -> Result<()>,
    ) -> Result<()> {
        let alone = |(sensor, spec): (usize, &Sensor)| Combination {
            name: spec.name.clone(),
            fusion: Default::default(),
            members: vec![Member { sensor, candidates: (0..spec.candidates.len()).collect() }],
        };
        let combinations = self.study.sensors.iter().enumerate().map(alone).collect();
        let study = Study { combinations, ..self.study.clone() };
        let (worlds, representations) = (self.worlds, self.representations);
        let choices = self.items.iter().map(|&[combination, choice]| PoseChoice { combination, choice });
        let choices: Vec<PoseChoice> = choices.collect();
        let first = |sensor| self.items.partition_point(|item| item[0] < sensor);
        let first = (0..study.sensors.len()).map(first).collect();
        let mut taking = Taking { casting: self, first, progress, stopped: None };
        let plan = ReadPlan { study: &study, worlds, pose_choices: &choices, representations };
        // Poses cast before a panic are stored as well.
        let cast = catch_panic(|| read(plan, &mut taking));
        let stopped = taking.stopped;
        let synced = self.file.as_mut().map_or(Ok(()), EvidenceFile::sync);
        cast.and(synced)?;
        match stopped {
            Some(why) if self.remaining() > 0 => Err(Error::Stopped(Issue::says(self.stop_message(&why)))),
            _ => Ok(()),
        }
    }

    fn stop_message(&self, why: &str) -> String {
        let (left, total) = (self.remaining(), self.total());
        let kept = match self.path() {
            Some(path) if left < total => {
                format!("; the work so far is kept in {}, and the same command continues", path.display())
            }
            _ => String::new(),
        };
        format!("{why}: {left} of {total} scene-poses are left to cast{kept}")
    }

    /// Casts the rest. On a device, one pose in `verify` is checked on the CPU.
    ///
    /// # Errors
    /// Those of [`Casting::run_on`] and [`Casting::check`].
    pub fn finish(
        mut self,
        backends: &mut dyn BackendFactory,
        verify: u64,
        progress: &dyn Progress,
    ) -> Result<CastEvidence> {
        if self.remaining() > 0 {
            self.run_on(&mut Failover::new(backends, progress))?;
        }
        let file = self.path().filter(|_| self.is_filed()).map(Path::to_path_buf);
        let (of_regions, checked) = self.check(backends, verify)?;
        Ok(CastEvidence { of_regions, file, checked })
    }

    /// All evidence, when it is complete. If a device cast some of it, the CPU recounts one pose in `every`; returns
    /// their number as well.
    ///
    /// # Errors
    /// `Error::Disagreement`: stored evidence is removed, since wrong evidence must not be searched later.
    pub fn check(
        self,
        backends: &mut dyn BackendFactory,
        every: u64,
    ) -> Result<(Vec<CandidateEvidence>, Option<u64>)> {
        let (study, worlds, kept) = (self.study, self.worlds, self.path().map(Path::to_path_buf));
        let (representations, regions) = (self.representations, self.regions.clone());
        let doubt = self.doubt().and_then(|path| Some((std::fs::read_to_string(&path).ok()?, path)));
        let required: Vec<String> = regions.iter().map(|&asked| checked_region(worlds, asked)).collect();
        let is_known = |listed: &str| required.iter().all(|region| listed.lines().any(|line| line == region));
        let doubt = doubt.filter(|(said, _)| !is_known(said));
        let evidence = self.evidence();
        if !backends.needs_check() && doubt.is_none() {
            return Ok((evidence, None));
        }
        let mut cpu = backends.open(Fallback::Cpu)?;
        let regions: Vec<_> = regions.into_iter().zip(&evidence).collect();
        let checked = count_again(&regions, (study, worlds), representations, cpu.as_mut(), every);
        match (&checked, doubt) {
            (Ok(_), Some((said, path))) => {
                write_whole(&path, format!("{said}{}\n", required.join("\n")).as_bytes())?;
            }
            (Err(Error::Disagreement(_)), doubt) => {
                let wrong = kept.into_iter().chain(doubt.map(|(_, path)| path));
                wrong.for_each(|path| _ = std::fs::remove_file(path));
            }
            _ => {}
        }
        checked.map(|count| (evidence, Some(count)))
    }

    /// The marker file of unchecked evidence.
    fn doubt(&self) -> Option<PathBuf> {
        self.path().map(doubt_marker)
    }

    /// All evidence of each region, in their order and with the same candidates, when it is complete. The search of a
    /// region may use the memory that all regions leave.
    pub fn evidence(self) -> Vec<CandidateEvidence> {
        assert_eq!(self.remaining(), 0, "everything was cast");
        let (bytes, memory_bytes) = (self.bytes(), self.memory_bytes);
        let Casting { items, places, windows, rows, file, is_filed, .. } = self;
        let records = file.filter(|_| is_filed).map(|file| {
            Arc::new(FiledRecords { path: file.path, places, windows, failed: Default::default() })
        });
        let of_region = |of: RegionRows| match &records {
            Some(records) => {
                let rows = FiledRows { records: records.clone(), region: of.places, has: of.has };
                CandidateEvidence::from_source(of.layout, items.clone(), Box::new(rows), memory_bytes)
            }
            None => {
                let of_others = bytes - of.bytes;
                CandidateEvidence::from_memory(of.layout, items.clone(), of.rows, memory_bytes - of_others)
            }
        };
        rows.into_iter().map(of_region).collect()
    }

    fn block(&self, key: RecordKey) -> usize {
        key.repeat * self.worlds.len() + key.world
    }

    /// Bytes of the rows of all regions, in memory or not.
    fn bytes(&self) -> u64 {
        self.rows.iter().map(|of| of.bytes).sum()
    }

    /// The evidence of a candidate in each region.
    fn pick(&self, key: RecordKey, said: &SaidPlanes) -> Vec<CandidateWords> {
        let sensor = self.items[key.item][0];
        self.rows.iter().map(|of| of.pick(sensor, key.world, said)).collect()
    }

    /// Stores the evidence of a candidate in each region, once.
    fn put(&mut self, key: RecordKey, place: RecordPlace, words: &[CandidateWords]) {
        let block = self.block(key);
        if std::mem::replace(&mut self.done[key.item][block], true) {
            return;
        }
        self.places[key.item][block] = place;
        self.left[key.item] -= 1;
        let (worlds, sensor) = (self.worlds.len(), self.items[key.item][0]);
        // Sensors without noise have the same evidence in all repeats.
        let repeats = match repeats(self.study, &self.study.sensors[sensor]) {
            1 => 0..self.study.repeats as usize,
            _ => key.repeat..key.repeat + 1,
        };
        let moments = repeats.map(|repeat| repeat * worlds + key.world);
        let (bytes, most) = (self.bytes(), if self.is_filed { 0 } else { self.memory_bytes });
        for (of, words) in self.rows.iter_mut().zip(words) {
            let of_others = bytes - of.bytes;
            of.put(key.item, moments.clone(), words, most.saturating_sub(of_others));
        }
    }

    /// Whether all of it will fit. If not, it is read from the file when needed.
    ///
    /// # Errors
    /// If there is no file.
    fn fits(&mut self) -> Result<()> {
        if self.is_filed {
            return Ok(());
        }
        let missing = (0..self.items.len()).filter(|&item| self.left[item] > 0);
        let to_come = |item: usize| -> u64 {
            self.rows.iter().map(|of| of.bytes_to_come(self.items[item][0], item)).sum()
        };
        let needed = self.bytes() + missing.map(to_come).sum::<u64>();
        if needed <= self.memory_bytes {
            return Ok(());
        }
        if self.file.is_some() {
            self.is_filed = true;
            self.rows.iter_mut().for_each(|of| of.rows = Vec::new());
            return Ok(());
        }
        let mib = |bytes: u64| bytes.div_ceil(1 << 20);
        let what = format!(
            "the evidence of {} poses in {} scenes, snapshots and repeats takes {} MiB, but {} MiB are allowed",
            self.items.len(),
            self.worlds.len() * self.study.repeats as usize,
            mib(needed),
            self.memory_bytes >> 20
        );
        let cure = Words::from("give ")
            + Argument("memory").with_value(format!("{}MiB", mib(needed)))
            + ", or use larger voxels, a smaller region, or fewer poses";
        Err(Issue::too_large(what).with_advice(cure).into())
    }
}

/// Receives the evidence of sensors during the cast.
struct Taking<'c, 'a> {
    casting: &'c mut Casting<'a>,
    /// The row of each sensor's first candidate.
    first: Vec<usize>,
    progress: &'c dyn Progress,
    stopped: Option<String>,
}

impl Taking<'_, '_> {
    /// The index of a world.
    fn world(&self, world: &World) -> usize {
        let here = |other: &World| (other.scene, other.snapshot) == (world.scene, world.snapshot);
        self.casting.worlds.iter().position(here).expect("worlds are those that are cast")
    }

    fn key(&self, world: &World, repeat: usize, pose_choice: &PoseChoice) -> RecordKey {
        let item = self.first[pose_choice.combination] + pose_choice.choice;
        RecordKey { item, world: self.world(world), repeat }
    }
}

impl EvidenceReader for Taking<'_, '_> {
    fn window(&self, world: &World) -> Window {
        self.casting.windows[self.world(world)]
    }

    fn wants(&self, world: &World, repeat: usize, pose_choice: &PoseChoice) -> bool {
        let key = self.key(world, repeat, pose_choice);
        // Sensors without noise are cast in the first repeat only.
        self.casting.done[key.item].get(self.casting.block(key)).is_some_and(|done| !done)
    }

    fn take(&mut self, world: &World, repeat: usize, said: Vec<(PoseChoice, Vec<SensorSays>)>) -> Result<()> {
        let keys = said.iter().map(|(pose_choice, _)| self.key(world, repeat, pose_choice));
        let keys: Vec<RecordKey> = keys.collect();
        let (casting, is_kept) = (&*self.casting, self.casting.file.is_some());
        let take = |(key, (_, said)): (RecordKey, &(_, Vec<SensorSays>))| {
            let joined = join(casting.windows[key.world], said);
            let packed = if is_kept { joined.each_ref().map(pack) } else { Default::default() };
            (key, packed, casting.pick(key, &joined))
        };
        let records: Vec<(RecordKey, PackedPlanes, Vec<CandidateWords>)> =
            keys.into_par_iter().zip(&said).map(take).collect();
        let places = match &mut self.casting.file {
            Some(file) => file.append(records.iter().map(|(key, packed, _)| (*key, packed)))?,
            None => vec![0; records.len()],
        };
        for ((key, packed, words), at) in records.iter().zip(places) {
            self.casting.put(*key, RecordPlace::new(at, packed), words);
        }
        if self.casting.bytes() > self.casting.memory_bytes {
            self.casting.fits()?;
        }
        self.progress.advance(said.len() as u64);
        Ok(())
    }

    fn enough(&mut self) -> bool {
        self.stopped = self.stopped.take().or_else(|| self.progress.stop_reason());
        self.stopped.is_some()
    }
}
