//! Measures how fast each backend scores poses, as a sweep does: the oracle first, then every other on the same poses,
//! repeated until the time is long enough to be measured. All counts are compared with the oracle's. The command line
//! selects backends, poses and tables.

use std::cell;
use std::collections::HashMap;
use std::time::{Duration, Instant};

use super::{BatchSize, Ledger, Row, compare};
use crate::results::PoseChoice;
use perirobot_march::backend::cpu::SimdLevel;
use perirobot_march::backend::factory::{BackendChoice, BackendKind};
use perirobot_march::backend::oracle::Oracle;
use perirobot_march::backend::{
    Backend, Evidence, Fusion, GridPose, Planes, Rays, Reading, Shot, Slot, VoxelScene,
};
use perirobot_march::metrics::Confusion;
use perirobot_march::{Error, Result};
use perirobot_study::input::Study;
use perirobot_study::world::{World, ray_table};

/// Fewest rounds of a measurement: a slow backend with a single round would look slower next to the best of many rounds
/// of a fast one.
const ROUNDS: u32 = 3;

/// A backend to be measured.
pub struct Contender {
    /// Its name in the table.
    pub name: String,
    /// The backend.
    pub backend: Box<dyn Backend + Send>,
    /// Threads for the host's work: placements, and the volumes around detections.
    pub threads: usize,
}

impl Contender {
    /// The oracle, the reference.
    pub(crate) fn oracle() -> Self {
        Contender { name: "oracle, 1 thread".into(), backend: Box::new(Oracle::default()), threads: 1 }
    }
}

/// The backends of a user's choice, without the oracle: the CPU on one thread with each available set of vector
/// instructions, and on all threads with none (for comparison with a software adapter) and with the most, and the GPU,
/// if there is one. A software adapter counts as one.
pub fn contenders(choice: &BackendChoice) -> Result<Vec<Contender>> {
    let all = std::thread::available_parallelism().map_or(1, |n| n.get());
    let mut contenders = Vec::new();
    if matches!(choice.kind, BackendKind::Auto | BackendKind::Cpu) {
        let most = choice.threads.unwrap_or(all);
        let cpu = |threads: usize| BackendChoice { threads: Some(threads), ..choice.clone() }.cpu();
        let levels = SimdLevel::all();
        let ends = levels.iter().enumerate().filter(|(i, _)| *i == 0 || i + 1 == levels.len());
        let on_all = ends.filter(|_| most > 1).map(|(_, &simd)| (most, simd));
        for (threads, simd) in levels.iter().map(|&simd| (1, simd)).chain(on_all) {
            let cpu = cpu(threads)?.simd(simd);
            let name = format!("cpu, {}, {}", cpu.device(), simd.name());
            contenders.push(Contender { name, backend: Box::new(cpu), threads });
        }
    }
    if matches!(choice.kind, BackendKind::Auto | BackendKind::Gpu)
        && let Some(gpu) = choice.any_gpu()?
    {
        let name = format!("gpu, {}", gpu.device());
        contenders.push(Contender { name, backend: gpu, threads: all });
    }
    Ok(contenders)
}

/// The measurement of one backend.
#[derive(Clone, Debug)]
pub struct BenchLine {
    /// The contender's name.
    pub name: String,
    /// Time to prepare ray tables and a scene at first use, the mean of all snapshots.
    pub load: Duration,
    /// Time to cast, carve, fuse and count all poses: the shortest of all rounds.
    pub work: Duration,
    /// The number of rounds.
    pub rounds: u32,
}

/// The same poses of one combination on several backends.
#[derive(Clone, Debug)]
pub struct Race {
    /// The combination's name.
    pub combination: String,
    /// Choices of poses, in each snapshot.
    pub poses: usize,
    /// Rays cast in a round.
    pub rays: u64,
    /// One line per backend, the oracle's first.
    pub lines: Vec<BenchLine>,
    /// The first counts that differ from the oracle's, explained.
    pub first_difference: Option<String>,
}

/// Whether a combination casts rays.
pub fn casts(study: &Study, combination: usize) -> bool {
    rays(study, combination).iter().any(|&rays| rays > 0)
}

/// Rays per pose of each member of a combination.
fn rays(study: &Study, combination: usize) -> Vec<usize> {
    let members = study.combinations[combination].members.iter();
    let tables = members.map(|member| ray_table(study, member.sensor));
    tables.map(|table| table.map_or(0, |rays| rays.dirs_q15.len())).collect()
}

/// Scores `poses` evenly spaced choices of a combination in each world, on the oracle and on each contender: at least
/// three rounds, until a contender's rounds took `long_enough` together. A zero `long_enough` means one round.
pub fn race(
    study: &Study,
    worlds: &[World],
    combination: usize,
    poses: usize,
    long_enough: Duration,
    contenders: &mut [Contender],
) -> Result<Race> {
    let spec = &study.combinations[combination];
    let choices = compare::spread(poses, spec.choices());
    let pose_choices: Vec<PoseChoice> =
        choices.iter().map(|&choice| PoseChoice { combination, choice }).collect();
    let each = rays(study, combination);
    let cast = |&choice: &usize| {
        let members = spec.members.iter().zip(spec.choice(choice)).zip(&each);
        members.map(|((member, candidate), rays)| ((member.sensor, candidate), *rays)).collect::<Vec<_>>()
    };
    // Evidence shared by several choices is cast once.
    let rays: usize = choices.iter().flat_map(cast).collect::<HashMap<_, _>>().into_values().sum();
    let (expected, line) = measure(study, worlds, &pose_choices, long_enough, &mut Contender::oracle())?;
    let mut race = Race {
        combination: spec.name.clone(),
        poses: pose_choices.len() * worlds.len(),
        rays: (rays * worlds.len()) as u64,
        lines: vec![line],
        first_difference: None,
    };
    for contender in contenders {
        let (found, line) = measure(study, worlds, &pose_choices, long_enough, contender)?;
        let first = || compare::first_unequal(study, worlds, &contender.name, &expected, &found);
        race.first_difference = race.first_difference.take().or_else(first);
        race.lines.push(line);
    }
    Ok(race)
}

/// Measures a contender until its rounds took long enough; returns its rows.
fn measure(
    study: &Study,
    worlds: &[World],
    pose_choices: &[PoseChoice],
    long_enough: Duration,
    contender: &mut Contender,
) -> Result<(Vec<Row>, BenchLine)> {
    let Contender { name, backend, threads } = contender;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(*threads).build();
    let pool = pool.map_err(|e| Error::device(format!("cannot start {threads} threads: {e}")))?;
    let mut one = || pool.install(|| round(study, worlds, pose_choices, backend.as_mut()));
    let (rows, load, mut work) = one()?;
    let (mut rounds, mut spent) = (1, work);
    while !long_enough.is_zero() && (rounds < ROUNDS || spent < long_enough) {
        let (_, _, again) = one()?;
        work = work.min(again);
        spent += again;
        rounds += 1;
    }
    Ok((rows, BenchLine { name: name.clone(), load: load / worlds.len().max(1) as u32, work, rounds }))
}

/// All choices once: the rows, the time to load, and the time of the work itself.
fn round(
    study: &Study,
    worlds: &[World],
    pose_choices: &[PoseChoice],
    backend: &mut dyn Backend,
) -> Result<(Vec<Row>, Duration, Duration)> {
    let clock = Clock::default();
    let mut watched = Timed { backend, clock: &clock };
    let mut timed = TimedRows { rows: Vec::new(), clock: &clock };
    super::run_choices(study, worlds, pose_choices, BatchSize::FULL, &mut watched, &mut timed)?;
    timed.rows.sort_by_key(Row::place);
    Ok((timed.rows, clock.load.get(), clock.work.get()))
}

/// Stores all rows, with their time.
struct TimedRows<'a> {
    rows: Vec<Row>,
    clock: &'a Clock,
}

impl Ledger for TimedRows<'_> {
    fn wants(&self, _: &World, _: usize, _: &PoseChoice) -> bool {
        true
    }

    fn take(&mut self, rows: &[Row]) -> Result<()> {
        self.rows.extend(rows);
        self.clock.count_batch();
        Ok(())
    }
}

/// Separates loading from work. Preparation on the host between two scenes counts as neither.
#[derive(Default)]
struct Clock {
    load: cell::Cell<Duration>,
    work: cell::Cell<Duration>,
    since: cell::Cell<Option<Instant>>,
}

impl Clock {
    /// Ends loading and starts work.
    fn begin_work(&self, begin: Instant) {
        self.load.set(self.load.get() + begin.elapsed());
        self.since.set(Some(Instant::now()));
    }

    /// A batch was scored.
    fn count_batch(&self) {
        let now = Instant::now();
        let since = self.since.replace(Some(now)).unwrap_or(now);
        self.work.set(self.work.get() + (now - since));
    }
}

/// A backend whose loading is timed.
struct Timed<'a> {
    backend: &'a mut dyn Backend,
    clock: &'a Clock,
}

impl Backend for Timed<'_> {
    fn name(&self) -> &'static str {
        self.backend.name()
    }

    fn device(&self) -> String {
        self.backend.device()
    }

    fn tables(&mut self, tables: &[Rays]) -> Result<()> {
        let begin = Instant::now();
        self.backend.tables(tables)?;
        self.clock.begin_work(begin);
        Ok(())
    }

    fn load(&mut self, scene: &VoxelScene) -> Result<()> {
        let begin = Instant::now();
        self.backend.load(scene)?;
        self.clock.begin_work(begin);
        Ok(())
    }

    fn slots(&self) -> usize {
        self.backend.slots()
    }

    fn first_hit_slots(&self) -> usize {
        self.backend.first_hit_slots()
    }

    fn sense(&mut self, table: usize, shots: &[Shot]) -> Result<()> {
        self.backend.sense(table, shots)
    }

    fn upload(&mut self, evidence: Vec<(Slot, Planes)>) -> Result<()> {
        self.backend.upload(evidence)
    }

    fn submit(&mut self, fusion: Fusion, jobs: &[Vec<Reading>]) -> Result<()> {
        self.backend.submit(fusion, jobs)
    }

    fn receive(&mut self) -> Result<Vec<Vec<Confusion>>> {
        self.backend.receive()
    }

    fn planes(&mut self, slots: &[Slot]) -> Result<Vec<Planes>> {
        self.backend.planes(slots)
    }

    fn read(&mut self, table: usize, placement: &GridPose) -> Result<Evidence> {
        self.backend.read(table, placement)
    }
}

#[cfg(test)]
mod tests;
