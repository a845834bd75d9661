//! Candidates × scenes → counts: the main job, and the comparison of backends. Files are written by `table` and
//! `manifest`; nothing here draws or searches.

pub mod bench;
pub mod compare;
mod evidence;
pub mod files;
pub mod manifest;
pub mod shapes;
pub mod table;
pub mod world;

use crate::backend::{Backend, Rays};
use crate::metrics::Confusion;
use crate::sensor::Scale;
use crate::study::Study;
use crate::voxel::region::window_of;
use crate::{Error, Result};
use evidence::Store;
pub use world::World;

/// The counts of one choice of poses in one region of one scene; indices are those of the study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    /// Index of the scene.
    pub scene: usize,
    /// Which moment of the scene, counted from 0.
    pub snapshot: usize,
    /// Which repeat, counted from 0.
    pub repeat: usize,
    /// Index of the combination.
    pub combination: usize,
    /// Number of the choice of poses ([`crate::study::Combination::choice`]).
    pub choice: usize,
    /// Number of the choice of representations ([`crate::study::Combination::interpretations`]).
    pub interpretation: usize,
    /// Index of the region.
    pub region: usize,
    /// What was right and wrong.
    pub counts: Confusion,
}

/// A choice of poses to be scored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ask {
    /// Index of the combination.
    pub combination: usize,
    /// Number of the choice of poses.
    pub choice: usize,
}

/// Every choice of every combination of a study, in study order.
pub fn asks(study: &Study) -> impl Iterator<Item = Ask> + '_ {
    study
        .combinations
        .iter()
        .enumerate()
        .flat_map(|(combination, spec)| (0..spec.choices()).map(move |choice| Ask { combination, choice }))
}

/// How many choices are scored in all, each snapshot of a scene and each repeat for itself.
pub fn jobs(study: &Study) -> u64 {
    let choices: usize = study.combinations.iter().map(|combination| combination.choices()).sum();
    let snapshots: usize = study.scenes.iter().map(|scene| scene.snapshots).sum();
    (snapshots * choices) as u64 * u64::from(study.repeats)
}

/// The tables of rays that a study's sensors cast, in study order.
pub fn tables(study: &Study) -> Vec<Option<Rays>> {
    (0..study.sensors.len()).map(|sensor| table(study, sensor)).collect()
}

/// The table of one of them, if it casts.
fn table(study: &Study, sensor: usize) -> Option<Rays> {
    let scale = Scale { voxel_size_m: study.voxel_size_m, backdrop: study.backdrop };
    study.sensors[sensor].kind.rays(&scale)
}

/// Scores every choice of every combination in every scene, rows in study order: scene, snapshot, repeat, combination,
/// choice, interpretation, region. `done` hears how many choices each batch finished.
pub fn run(
    study: &Study,
    worlds: &[World],
    backend: &mut dyn Backend,
    done: impl FnMut(u64),
) -> Result<Vec<Row>> {
    let asks: Vec<Ask> = asks(study).collect();
    run_asks(study, worlds, &asks, backend, done)
}

/// [`run`], of some choices.
fn run_asks(
    study: &Study,
    worlds: &[World],
    asks: &[Ask],
    backend: &mut dyn Backend,
    mut done: impl FnMut(u64),
) -> Result<Vec<Row>> {
    let tables = tables(study);
    backend.tables(&tables.iter().flatten().cloned().collect::<Vec<_>>())?;
    let mut rows = Vec::new();
    for world in worlds {
        backend.load(&world.cell(window_of(&world.regions)))?;
        let mut store = Store::new(study, world, &tables, backend.slots());
        for repeat in 0..study.repeats as usize {
            score(&mut store, asks, repeat, backend, &mut rows, &mut done)?;
        }
    }
    Ok(rows)
}

/// Scores choices in one world, as many at a time as their evidence fits the backend.
fn score(
    store: &mut Store,
    asks: &[Ask],
    repeat: usize,
    backend: &mut dyn Backend,
    rows: &mut Vec<Row>,
    done: &mut impl FnMut(u64),
) -> Result<()> {
    let (study, world) = (store.study, store.world);
    let interpretations: Vec<_> =
        study.combinations.iter().map(|combination| combination.interpretations(&study.sensors)).collect();
    let mut left = asks;
    while !left.is_empty() {
        let batch;
        (batch, left) = left.split_at(store.gather(left, repeat, backend)?);
        // One rule of fusion a call; combinations follow each other, so this rarely cuts a batch.
        for of_one in batch.chunk_by(|a, b| a.combination == b.combination) {
            let combination = of_one[0].combination;
            let ways = &interpretations[combination];
            let jobs: Vec<_> = of_one
                .iter()
                .flat_map(|ask| ways.iter().map(|way| store.readings(ask, repeat, way)))
                .collect();
            let scored = backend.score(study.combinations[combination].fusion, &jobs)?;
            if scored.len() != jobs.len() || scored.iter().any(|r| r.len() != world.regions.len()) {
                let what = format!("answered for {} of {} choices", scored.len(), jobs.len());
                return Err(Error::Device(format!("backend {}: {what}", backend.name())));
            }
            let named = of_one.iter().flat_map(|ask| (0..ways.len()).map(move |way| (ask.choice, way)));
            for ((choice, interpretation), regions) in named.zip(scored) {
                rows.extend(regions.into_iter().enumerate().map(|(region, counts)| Row {
                    scene: world.scene,
                    snapshot: world.snapshot,
                    repeat,
                    combination,
                    choice,
                    interpretation,
                    region,
                    counts,
                }));
            }
        }
        done(batch.len() as u64);
    }
    Ok(())
}
