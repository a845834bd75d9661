//! Casts and scores a study in this order: scene, group of choices, snapshot, repeat, batch. The rows do not
//! depend on the order. A [`Ledger`] says which rows are wanted, and takes them.
//!
//! # Theory
//! A ray's first hit in the objects that stand still is the same in all snapshots, whatever noise is drawn.
//! It is cast once for a scene, where the backend can keep it. In each snapshot the ray is then cast against
//! the moving objects only, and the nearer of the two hits is its first hit.
//!
//! # Practice
//! A group has as many choices as the backend has places for first hits; all of them if there is one
//! snapshot, or no such place. Two batches are under way: the host prepares one while the backend works on
//! the other.

use std::collections::{HashSet, VecDeque};
use std::sync::Arc;

use super::Row;
use super::ahead::Ahead;
use super::evidence::{BatchSize, FirstHitSlots, Store};
use crate::results::{PoseChoice, layout_of};
use perirobot_march::backend::{Backend, Rays, VoxelScene};
use perirobot_march::error::Issue;
use perirobot_march::progress::Progress;
use perirobot_march::voxel::Window;
use perirobot_march::{Error, Result};
use perirobot_scene::truth::region::window_of;
use perirobot_study::input::Study;
use perirobot_study::world::{World, ray_tables_of};

/// Selects the wanted rows, and receives them.
pub trait Ledger {
    /// Whether the rows of a choice are wanted, in one repeat of a world.
    fn wants(&self, world: &World, repeat: usize, pose_choice: &PoseChoice) -> bool;

    /// Receives the rows of some choices in one repeat of a world: choice by choice, representation by representation,
    /// region by region.
    fn take(&mut self, rows: &[Row]) -> Result<()>;

    /// Whether no more work may start.
    fn enough(&mut self) -> bool {
        false
    }
}

/// A ledger that wants all rows and stores them in memory.
impl Ledger for Vec<Row> {
    fn wants(&self, _: &World, _: usize, _: &PoseChoice) -> bool {
        true
    }

    fn take(&mut self, rows: &[Row]) -> Result<()> {
        self.extend(rows);
        Ok(())
    }
}

/// Scores every choice of every combination in every scene, rows in study order: scene, snapshot, repeat, combination,
/// choice, representation, region. For studies whose rows fit into memory.
pub fn run(study: &Study, worlds: &[World], backend: &mut dyn Backend) -> Result<Vec<Row>> {
    let pose_choices: Vec<PoseChoice> = layout_of(study).all_choices().collect();
    run_some(study, worlds, &pose_choices, backend)
}

/// [`run`] with a stop; reports no progress.
///
/// # Errors
/// If the backend fails; `Error::Stopped`.
pub fn run_unless(
    study: &Study,
    worlds: &[World],
    backend: &mut dyn Backend,
    progress: &dyn Progress,
) -> Result<Vec<Row>> {
    let pose_choices: Vec<PoseChoice> = layout_of(study).all_choices().collect();
    let mut taken = UntilStopped { rows: Vec::new(), progress, why: None };
    run_choices(study, worlds, &pose_choices, BatchSize::FULL, backend, &mut taken)?;
    if let Some(why) = taken.why {
        return Err(Error::Stopped(Issue::says(why)));
    }
    taken.rows.sort_by_key(Row::place);
    Ok(taken.rows)
}

/// A ledger that wants all rows, until there is a reason to stop.
struct UntilStopped<'a> {
    rows: Vec<Row>,
    progress: &'a dyn Progress,
    why: Option<String>,
}

impl Ledger for UntilStopped<'_> {
    fn wants(&self, _: &World, _: usize, _: &PoseChoice) -> bool {
        true
    }

    fn take(&mut self, rows: &[Row]) -> Result<()> {
        self.rows.extend(rows);
        Ok(())
    }

    fn enough(&mut self) -> bool {
        self.why = self.why.take().or_else(|| self.progress.stop_reason());
        self.why.is_some()
    }
}

/// [`run`] for some choices.
pub(super) fn run_some(
    study: &Study,
    worlds: &[World],
    pose_choices: &[PoseChoice],
    backend: &mut dyn Backend,
) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    run_choices(study, worlds, pose_choices, BatchSize::FULL, backend, &mut rows)?;
    rows.sort_by_key(Row::place);
    Ok(rows)
}

/// Scores the wanted rows of some choices, and passes them on as soon as they are counted.
pub fn run_choices(
    study: &Study,
    worlds: &[World],
    pose_choices: &[PoseChoice],
    batch: BatchSize,
    backend: &mut dyn Backend,
    ledger: &mut dyn Ledger,
) -> Result<()> {
    each_world(study, worlds, pose_choices, batch, backend, &mut Scoring(ledger))
}

/// The task of scoring a ledger's wanted rows.
struct Scoring<'a>(&'a mut dyn Ledger);

impl Task for Scoring<'_> {
    fn wants(&self, world: &World, repeat: usize, pose_choice: &PoseChoice) -> bool {
        self.0.wants(world, repeat, pose_choice)
    }

    fn work(&mut self, store: Store, pose_choices: &[PoseChoice], backend: &mut dyn Backend) -> Result<()> {
        score(store, pose_choices, backend, self.0)
    }

    fn enough(&mut self) -> bool {
        self.0.enough()
    }
}

/// A task on the evidence of choices, world by world.
pub(super) trait Task {
    /// Work on a world starts.
    fn begins(&mut self, _: &World) {}

    /// The part of a world that evidence covers.
    fn window(&self, world: &World) -> Window {
        window_of(&world.regions)
    }

    /// Whether a choice is needed, in one repeat of a world.
    fn wants(&self, world: &World, repeat: usize, pose_choice: &PoseChoice) -> bool;

    /// Does the work on some choices, in every repeat, with a store for a world that the backend has loaded.
    fn work(&mut self, store: Store, pose_choices: &[PoseChoice], backend: &mut dyn Backend) -> Result<()>;

    /// Whether no more work may start.
    fn enough(&mut self) -> bool;
}

/// Loads one world after the other, and runs a task on the choices that are needed there.
pub(super) fn each_world(
    study: &Study,
    worlds: &[World],
    pose_choices: &[PoseChoice],
    batch: BatchSize,
    backend: &mut dyn Backend,
    task: &mut dyn Task,
) -> Result<()> {
    let mut members = HashSet::new();
    for of_one in pose_choices.chunk_by(|a, b| a.combination == b.combination) {
        members.extend(study.combinations[of_one[0].combination].members.iter().map(|member| member.sensor));
    }
    let tables = ray_tables_of(study, |sensor| members.contains(&sensor));
    backend.tables(&tables.iter().flatten().cloned().collect::<Vec<_>>())?;
    let mut ahead = Ahead::default();
    let mut after = 0;
    for snapshots in worlds.chunk_by(|a, b| a.scene == b.scene) {
        after += snapshots.len();
        let wanted = |world: &World, pose_choice: &PoseChoice, task: &dyn Task| {
            (0..study.repeats as usize).any(|repeat| task.wants(world, repeat, pose_choice))
        };
        let mut left: Vec<PoseChoice> = pose_choices.to_vec();
        left.retain(|pose_choice| snapshots.iter().any(|world| wanted(world, pose_choice, task)));
        let mut left = left.as_slice();
        while !left.is_empty() {
            // A backend allocates anew for a new layer, and forgets first hits under the old indices.
            let over_time = snapshots[0].over_time.as_ref().map(|all| Arc::new(all.as_ref().clone()));
            let mut group: Option<(&[PoseChoice], FirstHitSlots)> = None;
            for (number, world) in snapshots.iter().enumerate() {
                let some = group.as_ref().map_or(left, |(group, _)| *group);
                if !some.iter().any(|pose_choice| wanted(world, pose_choice, task)) {
                    continue;
                }
                task.begins(world);
                let window = task.window(world);
                let (scene, made) = ahead.take(world, window);
                backend.load_made(&VoxelScene { over_time: over_time.clone(), ..scene }, made)?;
                let first = || first_group(study, snapshots, &tables, left, backend.first_hit_slots());
                let (group, first_hits) = group.get_or_insert_with(first);
                let store = Store::new(study, (world, window), &tables, first_hits, backend.slots(), batch);
                // The next world, of this scene or the next, that needs any of these choices.
                let is_wanted = |world: &&World, some: &[PoseChoice]| {
                    some.iter().any(|pose_choice| wanted(world, pose_choice, task))
                };
                let here = snapshots[number + 1..].iter().find(|world| is_wanted(world, group));
                let is_last = group.len() == left.len();
                let next = here.or_else(|| {
                    worlds[after..].iter().filter(|_| is_last).find(|world| is_wanted(world, pose_choices))
                });
                let next = next.map(|world| (world, task.window(world), backend.scene_maker()));
                ahead.make_while(next, || task.work(store, group, backend))?;
                if task.enough() {
                    return Ok(());
                }
            }
            left = &left[group.map_or(left.len(), |(group, _)| group.len())..];
        }
    }
    Ok(())
}

/// The first choices whose sensors' first hits fit this many slots, and those slots. First hits of a moving sensor are
/// not stored, nor those of a scene with one snapshot.
fn first_group<'a>(
    study: &Study,
    snapshots: &[World],
    tables: &[Option<Rays>],
    pose_choices: &'a [PoseChoice],
    places: usize,
) -> (&'a [PoseChoice], FirstHitSlots) {
    let mut first_hits = FirstHitSlots::new();
    if places == 0 || snapshots.len() < 2 {
        return (pose_choices, first_hits);
    }
    let stays = |&(sensor, candidate): &(usize, usize)| {
        let setting = |world: &World| world.settings[sensor][candidate];
        tables[sensor].is_some()
            && study.sensors[sensor].kind.calibration().is_none()
            && snapshots.iter().all(|world| setting(world) == setting(&snapshots[0]))
    };
    for (count, pose_choice) in pose_choices.iter().enumerate() {
        let combination = &study.combinations[pose_choice.combination];
        let members = combination.members.iter().map(|member| member.sensor);
        let all = members.zip(combination.choice(pose_choice.choice)).filter(stays);
        let new: Vec<_> = all.filter(|key| !first_hits.contains_key(key)).collect();
        if count > 0 && first_hits.len() + new.len() > places {
            return (&pose_choices[..count], first_hits);
        }
        // If even one choice has more than fit, the rest is cast each time.
        for key in new {
            if first_hits.len() < places {
                first_hits.insert(key, first_hits.len() as u32);
            }
        }
    }
    (pose_choices, first_hits)
}

/// Choices whose counts are requested, with the same number of representations each.
struct CountRequest {
    repeat: usize,
    pose_choices: Vec<PoseChoice>,
    jobs: usize,
}

/// Scores the wanted rows of some choices in one world, in every repeat, as many at a time as their evidence fits the
/// backend.
pub(super) fn score(
    mut store: Store,
    pose_choices: &[PoseChoice],
    backend: &mut dyn Backend,
    ledger: &mut dyn Ledger,
) -> Result<()> {
    let study = store.study;
    let representations: Vec<_> =
        study.combinations.iter().map(|combination| combination.representations(&study.sensors)).collect();
    let fusion = |pose_choice: &PoseChoice| study.combinations[pose_choice.combination].fusion;
    let ways = |pose_choice: &PoseChoice| representations[pose_choice.combination].len();
    let mut open: VecDeque<CountRequest> = VecDeque::new();
    for repeat in 0..study.repeats as usize {
        let mut wanted = pose_choices.to_vec();
        wanted.retain(|pose_choice| ledger.wants(store.world, repeat, pose_choice));
        let mut left = wanted.as_slice();
        while !left.is_empty() && !ledger.enough() {
            let batch;
            (batch, left) = left.split_at(store.make_ready(left, repeat, backend)?);
            let before = open.len();
            // One rule of fusion per request, and the same number of representations of each choice; combinations are
            // consecutive, so this rarely cuts a batch.
            for of_one in batch.chunk_by(|a, b| fusion(a) == fusion(b) && ways(a) == ways(b)) {
                let jobs = of_one.iter().flat_map(|pose_choice| {
                    representations[pose_choice.combination].iter().map(move |way| (pose_choice, way))
                });
                let jobs: Vec<_> =
                    jobs.map(|(pose_choice, way)| store.readings(pose_choice, repeat, way)).collect();
                backend.submit(fusion(&of_one[0]), &jobs)?;
                open.push_back(CountRequest { repeat, pose_choices: of_one.to_vec(), jobs: jobs.len() });
            }
            for request in open.drain(..before) {
                answer(store.world, &request, backend, ledger)?;
            }
        }
    }
    open.iter().try_for_each(|request| answer(store.world, request, backend, ledger))
}

/// Passes the rows of the oldest open request to the ledger.
fn answer(
    world: &World,
    request: &CountRequest,
    backend: &mut dyn Backend,
    ledger: &mut dyn Ledger,
) -> Result<()> {
    let scored = backend.receive()?;
    let regions = world.regions.len();
    if scored.len() != request.jobs || scored.iter().any(|of_regions| of_regions.len() != regions) {
        let what = format!("answered for {} of {} choices", scored.len(), request.jobs);
        return Err(Error::device(format!("backend {}: {what}", backend.name())));
    }
    let representations = request.jobs / request.pose_choices.len();
    let named = request
        .pose_choices
        .iter()
        .flat_map(|pose_choice| (0..representations).map(move |way| (pose_choice, way)));
    let rows = named.zip(scored).flat_map(|((pose_choice, representation), of_regions)| {
        of_regions.into_iter().enumerate().map(move |(region, counts)| Row {
            scene: world.scene,
            snapshot: world.snapshot,
            repeat: request.repeat,
            combination: pose_choice.combination,
            choice: pose_choice.choice,
            representation,
            region,
            counts,
        })
    });
    ledger.take(&rows.collect::<Vec<_>>())
}
