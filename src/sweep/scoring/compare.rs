//! Compares every integer of every backend on the same poses: counts, all bit planes over the whole grid, and the end
//! of each ray. The oracle is correct by definition; the first difference is explained.

mod explain;

use std::time::{Duration, Instant};

use super::Row;
use super::order::run_some;
use crate::results::PoseChoice;
use crate::results::columns::{BETWEEN_MEMBERS, pose_names, representation_names};
use perirobot_march::backend::oracle::Oracle;
use perirobot_march::backend::{Backend, Evidence, Fusion, GridPose, Rays, Reading, Shot, VoxelScene};
use perirobot_march::metrics::Confusion;
use perirobot_march::voxel::BitGrid;
use perirobot_march::{Error, Result};
use perirobot_scene::truth::region::window_of;
use perirobot_study::input::{Combination, Study};
use perirobot_study::sensor::Sensor;
use perirobot_study::world::{World, ray_table};

/// The compared poses.
#[derive(Clone, Debug)]
pub enum PoseSelection {
    /// This many of each scene and sensor, evenly spaced in the study's order; another turn selects others.
    Spread {
        /// Their number.
        number: usize,
        /// The place of the first one.
        turn: usize,
    },
    /// The pose of this name.
    Named(String),
    /// All poses.
    All,
}

/// The result of one backend on one scene and sensor or combination.
#[derive(Clone, Debug)]
pub struct ComparedLine {
    /// The scene's name.
    pub scene: String,
    /// The sensor's name, or "= " and the combination's.
    pub what: String,
    /// The backend's name.
    pub backend: &'static str,
    /// Poses or choices compared.
    pub poses: usize,
    /// Rays cast; 0 for a combination, whose evidence is shared by many.
    pub rays: u64,
    /// Voxels of the compared window.
    pub voxels: u64,
    /// Counts, plane bits and ray ends that differ from the oracle's.
    pub differences: u64,
    /// Time to score: cast, carve, fuse and count.
    pub time: Duration,
}

/// The outcome of a comparison.
#[derive(Clone, Debug, Default)]
pub struct Comparison {
    /// One line for each scene, sensor or combination, and backend.
    pub lines: Vec<ComparedLine>,
    /// The first difference in study order, explained.
    pub first_difference: Option<String>,
}

/// The indices of a sensor's selected poses.
pub fn select(selection: &PoseSelection, sensor: &Sensor) -> Vec<usize> {
    let count = sensor.candidates.len();
    match selection {
        PoseSelection::All => (0..count).collect(),
        PoseSelection::Spread { number, turn } => rotate(*number, *turn, count),
        PoseSelection::Named(name) => {
            // As in poses.csv, or with its sensor as in results.csv.
            let own = name.strip_prefix(&format!("{}:", sensor.name)).unwrap_or(name);
            (0..count).filter(|&i| sensor.candidates[i].name == own).collect()
        }
    }
}

/// The selected choices of a combination. A pose's name suffices if the combination is one sensor; else all of its
/// poses are named, as in results.csv.
pub fn select_choices(selection: &PoseSelection, study: &Study, combination: &Combination) -> Vec<usize> {
    let count = combination.choices();
    match selection {
        PoseSelection::All => (0..count).collect(),
        PoseSelection::Spread { number, turn } => rotate(*number, *turn, count),
        PoseSelection::Named(name) => match &combination.members[..] {
            [alone] => {
                let named = select(selection, &study.sensors[alone.sensor]);
                (0..count).filter(|&choice| named.contains(&combination.choice(choice)[0])).collect()
            }
            _ if !name.contains(BETWEEN_MEMBERS) => Vec::new(),
            _ => (0..count).filter(|&choice| pose_names(study, combination, choice) == *name).collect(),
        },
    }
}

/// `wanted` of `count`, evenly spaced, starting elsewhere in each turn; in ascending order.
fn rotate(number: usize, turn: usize, count: usize) -> Vec<usize> {
    let mut all: Vec<usize> = spread(number, count).into_iter().map(|i| (i + turn) % count).collect();
    all.sort_unstable();
    all
}

/// `wanted` of `count`, evenly spaced.
pub(super) fn spread(wanted: usize, count: usize) -> Vec<usize> {
    let wanted = wanted.min(count);
    (0..wanted).map(|i| i * count / wanted).collect()
}

/// Casts selected poses of one sensor in one world on the oracle and on each backend, and adds to the report. A sensor
/// without rays adds nothing.
pub fn compare(
    study: &Study,
    world: &World,
    sensor: usize,
    selection: &PoseSelection,
    backends: &mut [Box<dyn Backend>],
    report: &mut Comparison,
) -> Result<()> {
    let spec = &study.sensors[sensor];
    let scene = world.scene(world.grid.window());
    let poses = select(selection, spec);
    let Some(rays) = ray_table(study, sensor).filter(|_| !poses.is_empty()) else {
        return Ok(());
    };
    let placements: Vec<GridPose> =
        poses.iter().map(|&pose| world.placement(study, sensor, pose, 0)).collect();
    let mut oracle = Oracle::default();
    let (counts, time) = run_timed(&mut oracle, &scene, &rays, &placements)?;
    let line = ComparedLine {
        scene: world.title(study),
        what: spec.name.clone(),
        backend: oracle.name(),
        poses: poses.len(),
        rays: (poses.len() * rays.dirs_q15.len()) as u64,
        voxels: world.grid.window().volume(),
        differences: 0,
        time,
    };
    report.lines.push(line.clone());
    for backend in backends {
        let (found, time) = run_timed(backend.as_mut(), &scene, &rays, &placements)?;
        if found.len() != placements.len() {
            let what = format!("answered for {} of {} poses", found.len(), placements.len());
            return Err(Error::device(format!("backend {}: {what}", backend.name())));
        }
        let mut differences = 0;
        for (i, placement) in placements.iter().enumerate() {
            let expected = (&oracle.read(0, placement)?, &counts[i]);
            let got = (&backend.read(0, placement)?, &found[i]);
            let here = count_differences(expected, got);
            if here > 0 && report.first_difference.is_none() {
                let place = format!(
                    "scene {}, pose {}:{}, {} against the oracle",
                    line.scene,
                    spec.name,
                    spec.candidates[poses[i]].name,
                    backend.name()
                );
                let why = explain::explain(&scene, &rays, placement, expected, got)?;
                report.first_difference = Some(format!("{place}: {why}"));
            }
            differences += here;
        }
        report.lines.push(ComparedLine { backend: backend.name(), differences, time, ..line.clone() });
    }
    Ok(())
}

/// Scores selected choices of one combination in all snapshots of a scene, in every repeat, representation and region,
/// as a sweep does, on the oracle and on each backend, and adds to the report.
pub fn compare_combination(
    study: &Study,
    worlds: &[World],
    combination: usize,
    selection: &PoseSelection,
    backends: &mut [Box<dyn Backend>],
    report: &mut Comparison,
) -> Result<()> {
    let spec = &study.combinations[combination];
    let choices = select_choices(selection, study, spec);
    let pose_choices: Vec<PoseChoice> =
        choices.iter().map(|&choice| PoseChoice { combination, choice }).collect();
    let Some(first) = worlds.first().filter(|_| !pose_choices.is_empty()) else { return Ok(()) };
    let timed = |backend: &mut dyn Backend| -> Result<(Vec<Row>, Duration)> {
        let begin = Instant::now();
        Ok((run_some(study, worlds, &pose_choices, backend)?, begin.elapsed()))
    };
    let mut oracle = Oracle::default();
    let (expected, time) = timed(&mut oracle)?;
    let line = ComparedLine {
        scene: first.name.clone(),
        what: format!("= {}", spec.name),
        backend: oracle.name(),
        poses: pose_choices.len() * worlds.len(),
        rays: 0,
        voxels: window_of(&first.regions).volume(),
        differences: 0,
        time,
    };
    report.lines.push(line.clone());
    for backend in backends {
        let (found, time) = timed(backend.as_mut())?;
        let differences = unequal(&expected, &found);
        let first = || first_unequal(study, worlds, backend.name(), &expected, &found);
        report.first_difference = report.first_difference.take().or_else(first);
        report.lines.push(ComparedLine { backend: backend.name(), differences, time, ..line.clone() });
    }
    Ok(())
}

/// The first row of a backend that differs from the oracle's, explained.
pub(super) fn first_unequal(
    study: &Study,
    worlds: &[World],
    backend: &str,
    expected: &[Row],
    found: &[Row],
) -> Option<String> {
    let (a, b) = expected.iter().zip(found).find(|(a, b)| a != b)?;
    let spec = &study.combinations[a.combination];
    let world = worlds.iter().find(|world| (world.scene, world.snapshot) == (a.scene, a.snapshot))?;
    Some(format!(
        "scene {}, repeat {}, poses {}, {} in region {}, {backend} against the oracle: counts {:?}, expected {:?} (tp fp fn \
         tn uo uf, then tp fn uo of people and of the robot, then hits of people, people, people detected, parts, parts detected, each part missed, then voxels labelled twice and hits of people twice)",
        world.title(study),
        a.repeat,
        pose_names(study, spec, a.choice),
        representation_names(study, spec)[a.representation],
        study.regions[a.region].0,
        b.counts.numbers(),
        a.counts.numbers()
    ))
}

/// Loads and scores; returns the time of scoring.
fn run_timed(
    backend: &mut dyn Backend,
    scene: &VoxelScene,
    rays: &Rays,
    placements: &[GridPose],
) -> Result<(Vec<Vec<Confusion>>, Duration)> {
    backend.tables(std::slice::from_ref(rays))?;
    backend.load(scene)?;
    let begin = Instant::now();
    let mut counts = Vec::new();
    for batch in placements.chunks(backend.slots()) {
        let shots: Vec<_> = (0..).zip(batch).map(|(slot, placement)| Shot::once(slot, *placement)).collect();
        backend.sense(0, &shots)?;
        let alone =
            |shot: &Shot| vec![Reading { slot: shot.slot, volume: None, hit: 1, miss: -1, presence: false }];
        let jobs: Vec<_> = shots.iter().map(alone).collect();
        counts.extend(backend.score(Fusion::OccupiedWins, &jobs)?);
    }
    Ok((counts, begin.elapsed()))
}

/// The evidence and the counts of one pose.
type EvidenceAndCounts<'a> = (&'a Evidence, &'a Vec<Confusion>);

/// The number of different counts, bits of planes and ends; one that only one side has counts as different.
fn count_differences((expected, counts): EvidenceAndCounts, (got, found): EvidenceAndCounts) -> u64 {
    let bits = |a: &BitGrid, b: &BitGrid| {
        let (mut only_a, mut only_b) = (a.clone(), b.clone());
        only_a.remove(b);
        only_b.remove(a);
        only_a.count() + only_b.count()
    };
    let flat = |all: &[Confusion]| -> Vec<u64> { all.iter().flat_map(Confusion::numbers).collect() };
    let planes = expected.planes.planes_with_names().into_iter().zip(got.planes.planes_with_names());
    planes.map(|((_, a), (_, b))| bits(a, b)).sum::<u64>()
        + unequal(&expected.ends, &got.ends)
        + unequal(&flat(counts), &flat(found))
}

/// The number of differences of two lists, including those beyond the shorter one.
fn unequal<T: PartialEq>(a: &[T], b: &[T]) -> u64 {
    (a.iter().zip(b).filter(|(a, b)| a != b).count() + a.len().abs_diff(b.len())) as u64
}

#[cfg(test)]
pub(super) mod tests;
