//! How evidence comes to be: what the folder has is read, the rest is cast and kept, and what the question needs of
//! both is held in memory if it fits.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::super::check::count_again;
use super::super::layout::{RegionPlaces, layout_of, may_have_bits};
use super::file::{CandidateWords, EvidenceFile, RecordKey, deciding};
use super::rows::{FiledRows, RecordPlace};
use perirobot_cover::CandidateEvidence;
use perirobot_cover::layout::{BitLayout, PLANES, SPACE_OF, WantedCounts};
use perirobot_march::backend::Backend;
use perirobot_march::backend::factory::{BackendFactory, Fallback};
use perirobot_march::error::{Argument, Issue, Words, catch_panic};
use perirobot_march::progress::Progress;
use perirobot_march::{Error, Result};
use perirobot_study::sensor::Sensor;
use perirobot_study::study::{Choose, Combination, Member, Study};
use perirobot_study::world::World;
use perirobot_sweep::results::PoseChoice;
use perirobot_sweep::results::files::write_whole;
use perirobot_sweep::sweep::{EvidenceReader, Failover, ReadPlan, SensorSays};

/// Evidence that is there in part.
pub struct Casting<'a> {
    study: &'a Study,
    worlds: &'a [World],
    /// The representation of each sensor.
    representations: &'a [usize],
    layout: BitLayout,
    /// For each world where its voxels are in the planes of a backend.
    regions: Vec<RegionPlaces>,
    /// Sensor and candidate of each row, in study order.
    items: Vec<[usize; 2]>,
    /// What is held in memory: bits of all moments, nothing of a plane without a bit; nothing once that does not fit.
    rows: Vec<[Box<[u64]>; PLANES]>,
    is_filed: bool,
    /// Where each record of each row is in the file.
    places: Vec<Vec<RecordPlace>>,
    /// Of each row which planes have a bit.
    has: Vec<[bool; PLANES]>,
    /// Of each row which repeats of which worlds are there, and how many are not.
    done: Vec<Vec<bool>>,
    left: Vec<u64>,
    /// Of each sensor the planes that the question needs and that may have a bit.
    needed: Vec<[bool; PLANES]>,
    /// Bytes that planes take, and may take.
    bytes: u64,
    memory_bytes: u64,
    file: Option<EvidenceFile>,
    /// Records of the file that are damaged; their evidence is cast again.
    pub damaged: usize,
}

/// The file that stands beside evidence of a device until the CPU has counted some of it again.
fn doubt_marker(evidence: &Path) -> PathBuf {
    evidence.with_extension("unchecked")
}

/// How many repeats of a sensor differ.
fn repeats(study: &Study, sensor: &Sensor) -> usize {
    if sensor.kind.is_noisy() { study.repeats as usize } else { 1 }
}

impl<'a> Casting<'a> {
    /// What a study asks for. What the folder has is read; what is cast will be kept there. With `restart` the folder's
    /// evidence is lost.
    ///
    /// # Errors
    /// When it does not fit so many bytes; those of the file.
    pub fn begin(
        study: &'a Study,
        choose: &'a Choose,
        worlds: &'a [World],
        memory_bytes: u64,
        kept: Option<(&Path, bool)>,
    ) -> Result<Casting<'a>> {
        let scores =
            std::iter::once(choose.objective).chain(choose.require.iter().map(|require| require.score));
        Casting::new(
            study,
            worlds,
            (choose.region, &choose.representations),
            WantedCounts::from_scores(scores),
            memory_bytes,
            kept,
        )
    }

    pub(crate) fn new(
        study: &'a Study,
        worlds: &'a [World],
        (region, representations): (usize, &'a [usize]),
        wanted: WantedCounts,
        memory_bytes: u64,
        kept: Option<(&Path, bool)>,
    ) -> Result<Casting<'a>> {
        let (layout, regions) = layout_of(study, worlds, region);
        let items = study.sensors.iter().enumerate();
        let items: Vec<[usize; 2]> =
            items.flat_map(|(sensor, spec)| (0..spec.candidates.len()).map(move |c| [sensor, c])).collect();
        let blocks = |&[sensor, _]: &[usize; 2]| repeats(study, &study.sensors[sensor]) * worlds.len();
        let needed = study.sensors.iter().zip(representations).map(|(sensor, &way)| {
            let may = may_have_bits(&*sensor.kind, way);
            std::array::from_fn(|plane| wanted.needs(plane) && may[plane])
        });
        let file = match kept {
            Some((folder, restart)) => Some(EvidenceFile::open(
                folder,
                study,
                &deciding(study, worlds, region, representations),
                restart,
            )?),
            None => None,
        };
        let mut casting = Casting {
            rows: vec![Default::default(); items.len()],
            is_filed: false,
            places: items.iter().map(|item| vec![RecordPlace::default(); blocks(item)]).collect(),
            has: vec![[false; PLANES]; items.len()],
            done: items.iter().map(|item| vec![false; blocks(item)]).collect(),
            left: items.iter().map(|item| blocks(item) as u64).collect(),
            needed: needed.collect(),
            bytes: 0,
            memory_bytes,
            file: None,
            damaged: 0,
            study,
            worlds,
            representations,
            layout,
            regions,
            items,
        };
        if let Some(mut file) = file {
            casting.read(&mut file)?;
            casting.file = Some(file);
        }
        casting.fits()?;
        Ok(casting)
    }

    /// Takes what a file has.
    fn read(&mut self, file: &mut EvidenceFile) -> Result<()> {
        let blocks: Vec<usize> = self.done.iter().map(Vec::len).collect();
        let of_world: Vec<[usize; PLANES]> =
            (0..self.worlds.len()).map(|world| self.layout.words_of(world)).collect();
        let worlds = self.worlds.len();
        let words = |key: RecordKey, plane: usize| {
            let is_there = *blocks.get(key.item)? > key.repeat.checked_mul(worlds)? && key.world < worlds;
            is_there.then(|| of_world[key.world][plane])
        };
        let found = file.read(words, |key, at, said| self.put(key, at, &said))?;
        let lost = found.damaged.iter().filter(|&&key| !self.done[key.item][self.block(key)]).count();
        self.damaged = lost + usize::from(found.is_cut && self.remaining() > 0);
        Ok(())
    }

    /// How many candidates there are to cast, in each scene, snapshot and repeat for itself.
    pub fn total(&self) -> u64 {
        self.done.iter().map(|done| done.len() as u64).sum()
    }

    /// How many of them are not there yet.
    pub fn remaining(&self) -> u64 {
        self.left.iter().sum()
    }

    /// Whether it takes more memory than it may, so that it is read from the file where it is needed.
    pub fn is_filed(&self) -> bool {
        self.is_filed
    }

    /// Where evidence is kept.
    pub fn path(&self) -> Option<&Path> {
        self.file.as_ref().map(|file| file.path.as_path())
    }

    /// Casts what is left.
    ///
    /// # Errors
    /// When the backend fails; when the disk does; `Error::Stopped`. What was cast before is kept.
    pub fn run(&mut self, backend: &mut dyn Backend, progress: &dyn Progress) -> Result<()> {
        self.run_by(progress, |plan, taking| plan.read(backend, taking))
    }

    /// The same on the backend of a user's choice; others step in where a device fails. What is kept of a device is in doubt
    /// until [`Casting::check`] says otherwise: whoever goes on checks it, even where another one goes on, or none.
    ///
    /// # Errors
    /// Those of [`Casting::run`].
    pub fn run_on(&mut self, failover: &mut Failover) -> Result<()> {
        if let Some(doubt) = self.doubt().filter(|_| self.remaining() > 0 && failover.needs_check()) {
            write_whole(&doubt, b"a device cast poses that were not counted again yet\n")?;
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
        // Poses that were cast before a panic are kept as well.
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
                format!("; what is cast is kept in {}, and the same command goes on", path.display())
            }
            _ => String::new(),
        };
        format!("{why}: {left} of {total} scene-poses are left to cast{kept}")
    }

    /// All evidence, when nothing is left. Where a device cast some of it, the CPU counts one pose in `every` again, and
    /// with the evidence comes of how many.
    ///
    /// # Errors
    /// `Error::Disagreement`: what was kept is removed, since what a device said wrongly must not be searched later.
    pub fn check(
        self,
        choose: &Choose,
        backends: &mut dyn BackendFactory,
        every: u64,
    ) -> Result<(CandidateEvidence, Option<u64>)> {
        let (study, worlds, kept) = (self.study, self.worlds, self.path().map(Path::to_path_buf));
        let doubt = self.doubt().filter(|doubt| doubt.exists());
        let evidence = self.evidence();
        if !backends.needs_check() && doubt.is_none() {
            return Ok((evidence, None));
        }
        let mut cpu = backends.open(Fallback::Cpu)?;
        let checked = count_again(&evidence, study, choose, worlds, cpu.as_mut(), every);
        if let (Err(Error::Disagreement(_)), Some(path)) = (&checked, &kept) {
            let _ = std::fs::remove_file(path);
        }
        let is_judged = matches!(checked, Ok(_) | Err(Error::Disagreement(_)));
        if let Some(doubt) = doubt.filter(|_| is_judged) {
            std::fs::remove_file(&doubt).map_err(|e| Error::io(&doubt, "cannot be removed", e))?;
        }
        checked.map(|count| (evidence, Some(count)))
    }

    /// The file that says that what is kept is in doubt.
    fn doubt(&self) -> Option<PathBuf> {
        self.path().map(doubt_marker)
    }

    /// All evidence, when nothing is left.
    pub fn evidence(self) -> CandidateEvidence {
        assert_eq!(self.remaining(), 0, "everything was cast");
        let (layout, items, memory_bytes) = (self.layout, self.items, self.memory_bytes);
        match self.file.filter(|_| self.is_filed) {
            Some(file) => {
                let needed = items.iter().map(|&[sensor, _]| self.needed[sensor]).collect();
                let rows =
                    FiledRows { path: file.path, places: self.places, needed, failed: Default::default() };
                CandidateEvidence::from_source(layout, items, Box::new(rows), memory_bytes)
            }
            None => CandidateEvidence::from_memory(layout, items, self.rows, memory_bytes),
        }
    }

    fn block(&self, key: RecordKey) -> usize {
        key.repeat * self.worlds.len() + key.world
    }

    /// Takes what a candidate says, once.
    fn put(&mut self, key: RecordKey, at: u64, said: &CandidateWords) {
        let block = self.block(key);
        if std::mem::replace(&mut self.done[key.item][block], true) {
            return;
        }
        self.places[key.item][block] = RecordPlace::new(at, said);
        self.left[key.item] -= 1;
        let sensor = self.items[key.item][0];
        // What has no noise says the same in all repeats.
        let all = self.layout.moments.len() / self.worlds.len();
        let repeats = match repeats(self.study, &self.study.sensors[sensor]) {
            1 => 0..all,
            _ => key.repeat..key.repeat + 1,
        };
        let mut row = self.rows.get_mut(key.item);
        for (plane, words) in said.iter().enumerate() {
            if words.is_empty() || !self.needed[sensor][plane] {
                continue;
            }
            let length = self.layout.words[SPACE_OF[plane]];
            if !std::mem::replace(&mut self.has[key.item][plane], true) {
                self.bytes += 8 * length as u64;
                // Beyond what is allowed it is only counted, to tell how much there is.
                if self.bytes <= self.memory_bytes && !self.is_filed {
                    row.iter_mut().for_each(|row| row[plane] = vec![0; length].into());
                }
            }
            let Some(row) = row.as_mut().filter(|row| !row[plane].is_empty()) else { continue };
            for repeat in repeats.clone() {
                let moment = &self.layout.moments[repeat * self.worlds.len() + key.world];
                row[plane][moment.words[SPACE_OF[plane]].clone()].copy_from_slice(words);
            }
        }
    }

    /// Whether all of it will fit. If it does not, it is read from the file where it is needed.
    ///
    /// # Errors
    /// When there is no file.
    fn fits(&mut self) -> Result<()> {
        if self.is_filed {
            return Ok(());
        }
        let missing = (0..self.items.len()).filter(|&item| self.left[item] > 0);
        let of_row = |item: usize| -> u64 {
            let needed = &self.needed[self.items[item][0]];
            let more = (0..PLANES).filter(|&plane| needed[plane] && !self.has[item][plane]);
            more.map(|plane| 8 * self.layout.words[SPACE_OF[plane]] as u64).sum()
        };
        let needed = self.bytes + missing.map(of_row).sum::<u64>();
        if needed <= self.memory_bytes {
            return Ok(());
        }
        if self.file.is_some() {
            self.is_filed = true;
            self.rows = Vec::new();
            return Ok(());
        }
        let mib = |bytes: u64| bytes.div_ceil(1 << 20);
        let what = format!(
            "the evidence of {} poses in {} scenes, snapshots and repeats takes {} MiB, and {} MiB are allowed",
            self.items.len(),
            self.layout.moments.len(),
            mib(needed),
            self.memory_bytes >> 20
        );
        let cure = Words::from("give ")
            + Argument("memory").with_value(format!("{}MiB", mib(needed)))
            + ", or use larger voxels, a smaller region, or fewer poses";
        Err(Issue::too_large(what).with_advice(cure).into())
    }
}

/// Takes what sensors say as it comes.
struct Taking<'c, 'a> {
    casting: &'c mut Casting<'a>,
    /// The row of each sensor's first candidate.
    first: Vec<usize>,
    progress: &'c dyn Progress,
    stopped: Option<String>,
}

impl Taking<'_, '_> {
    fn key(&self, world: &World, repeat: usize, pose_choice: &PoseChoice) -> RecordKey {
        let here = |other: &World| (other.scene, other.snapshot) == (world.scene, world.snapshot);
        let world = self.casting.worlds.iter().position(here).expect("worlds are those that are cast");
        RecordKey { item: self.first[pose_choice.combination] + pose_choice.choice, world, repeat }
    }
}

impl EvidenceReader for Taking<'_, '_> {
    fn wants(&self, world: &World, repeat: usize, pose_choice: &PoseChoice) -> bool {
        let key = self.key(world, repeat, pose_choice);
        // What has no noise is cast in the first repeat.
        self.casting.done[key.item].get(self.casting.block(key)).is_some_and(|done| !done)
    }

    fn take(&mut self, world: &World, repeat: usize, said: Vec<(PoseChoice, Vec<SensorSays>)>) -> Result<()> {
        let keys = said.iter().map(|(pose_choice, _)| self.key(world, repeat, pose_choice));
        let keys: Vec<RecordKey> = keys.collect();
        let regions = &self.casting.regions;
        let pick =
            |(key, (_, said)): (RecordKey, &(_, Vec<SensorSays>))| (key, regions[key.world].pick(said));
        let records: Vec<(RecordKey, CandidateWords)> = keys.into_par_iter().zip(&said).map(pick).collect();
        let places = match &mut self.casting.file {
            Some(file) => file.append(&records)?,
            None => vec![0; records.len()],
        };
        records.iter().zip(places).for_each(|((key, said), at)| self.casting.put(*key, at, said));
        if self.casting.bytes > self.casting.memory_bytes {
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
