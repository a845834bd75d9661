//! In which order a study is cast and scored: scene, group of choices, snapshot, repeat, batch. What rows come out does
//! not depend on it.
//!
//! # Theory
//! What a ray meets first in what does not move is the same in all snapshots, whatever is drawn for noise: the sooner of
//! that and of what it meets in the rest is its first hit. So it is cast once for a scene, where the backend keeps it.
//!
//! # Practice
//! A group has as many choices as the backend has places for first hits; all of them if there is one snapshot, or no
//! such place. Two batches are under way: the host prepares one while the backend works on the other.

use std::collections::VecDeque;
use std::sync::Arc;

use super::evidence::{HitSlots, Store};
use super::{Ask, Row, World, asks, tables};
use crate::backend::{Backend, Cell, Rays};
use crate::study::Study;
use crate::voxel::region::window_of;
use crate::{Error, Result};

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
pub(super) fn run_asks(
    study: &Study,
    worlds: &[World],
    asks: &[Ask],
    backend: &mut dyn Backend,
    mut done: impl FnMut(u64),
) -> Result<Vec<Row>> {
    let tables = tables(study);
    backend.tables(&tables.iter().flatten().cloned().collect::<Vec<_>>())?;
    let mut rows = Vec::new();
    for snapshots in worlds.chunk_by(|a, b| a.scene == b.scene) {
        let mut left = asks;
        while !left.is_empty() {
            // To a backend, other numbers for first hits are another layer.
            let still = snapshots[0].still.as_ref().map(|still| Arc::new(still.as_ref().clone()));
            let (mut group, mut hits) = (left, HitSlots::new());
            for (snapshot, world) in snapshots.iter().enumerate() {
                let cell = world.cell(window_of(&world.regions));
                backend.load(&Cell { still: still.clone(), ..cell })?;
                if snapshot == 0 {
                    (group, hits) = first_group(study, snapshots, &tables, left, backend.hit_slots());
                }
                let store = Store::new(study, world, &tables, &hits, backend.slots());
                score(store, group, backend, &mut rows, &mut done)?;
            }
            left = &left[group.len()..];
        }
    }
    rows.sort_by_key(Row::place);
    Ok(rows)
}

/// The first of some choices whose sensors' first hits fit so many places, and those places. Nothing is kept of a sensor
/// that moves, nor where there is one snapshot.
fn first_group<'a>(
    study: &Study,
    snapshots: &[World],
    tables: &[Option<Rays>],
    asks: &'a [Ask],
    places: usize,
) -> (&'a [Ask], HitSlots) {
    let mut hits = HitSlots::new();
    if places == 0 || snapshots.len() < 2 {
        return (asks, hits);
    }
    let stays = |&(sensor, candidate): &(usize, usize)| {
        let setting = |world: &World| world.settings[sensor][candidate];
        tables[sensor].is_some() && snapshots.iter().all(|world| setting(world) == setting(&snapshots[0]))
    };
    for (count, ask) in asks.iter().enumerate() {
        let combination = &study.combinations[ask.combination];
        let members = combination.members.iter().map(|member| member.sensor);
        let all = members.zip(combination.choice(ask.choice)).filter(stays);
        let new: Vec<_> = all.filter(|key| !hits.contains_key(key)).collect();
        if count > 0 && hits.len() + new.len() > places {
            return (&asks[..count], hits);
        }
        // More than fit even for one choice are cast each time.
        for key in new {
            if hits.len() < places {
                hits.insert(key, hits.len() as u32);
            }
        }
    }
    (asks, hits)
}

/// Choices of one combination whose counts are asked for.
struct Question<'a> {
    repeat: usize,
    asks: &'a [Ask],
    jobs: usize,
}

/// Scores choices in one world, in every repeat, as many at a time as their evidence fits the backend.
fn score(
    mut store: Store,
    asks: &[Ask],
    backend: &mut dyn Backend,
    rows: &mut Vec<Row>,
    done: &mut impl FnMut(u64),
) -> Result<()> {
    let study = store.study;
    let ways: Vec<_> =
        study.combinations.iter().map(|combination| combination.interpretations(&study.sensors)).collect();
    let mut open: VecDeque<Question> = VecDeque::new();
    for repeat in 0..study.repeats as usize {
        let mut left = asks;
        while !left.is_empty() {
            let batch;
            (batch, left) = left.split_at(store.gather(left, repeat, backend)?);
            let before = open.len();
            // One rule of fusion a question; combinations follow each other, so this rarely cuts a batch.
            for of_one in batch.chunk_by(|a, b| a.combination == b.combination) {
                let combination = of_one[0].combination;
                let ways = ways[combination].iter();
                let jobs = of_one.iter().flat_map(|ask| ways.clone().map(move |way| (ask, way)));
                let jobs: Vec<_> = jobs.map(|(ask, way)| store.readings(ask, repeat, way)).collect();
                backend.ask(study.combinations[combination].fusion, &jobs)?;
                open.push_back(Question { repeat, asks: of_one, jobs: jobs.len() });
            }
            for question in open.drain(..before) {
                answer(&store, &question, backend, rows, done)?;
            }
        }
    }
    open.iter().try_for_each(|question| answer(&store, question, backend, rows, done))
}

/// Adds the rows of the oldest open question.
fn answer(
    store: &Store,
    question: &Question,
    backend: &mut dyn Backend,
    rows: &mut Vec<Row>,
    done: &mut impl FnMut(u64),
) -> Result<()> {
    let (world, regions) = (store.world, store.world.regions.len());
    let scored = backend.answer()?;
    if scored.len() != question.jobs || scored.iter().any(|of_regions| of_regions.len() != regions) {
        let what = format!("answered for {} of {} choices", scored.len(), question.jobs);
        return Err(Error::Device(format!("backend {}: {what}", backend.name())));
    }
    let ways = question.jobs / question.asks.len();
    let named = question.asks.iter().flat_map(|ask| (0..ways).map(move |way| (ask, way)));
    for ((ask, interpretation), of_regions) in named.zip(scored) {
        rows.extend(of_regions.into_iter().enumerate().map(|(region, counts)| Row {
            scene: world.scene,
            snapshot: world.snapshot,
            repeat: question.repeat,
            combination: ask.combination,
            choice: ask.choice,
            interpretation,
            region,
            counts,
        }));
    }
    done(question.asks.len() as u64);
    Ok(())
}
