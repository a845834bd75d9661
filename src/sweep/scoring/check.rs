//! Recounts a part of a device's counts on the CPU, its first poses and then a small share: a faulty driver is found
//! while the sweep can still be stopped.

use std::collections::HashMap;

use serde_json::{Value, json};

use super::{BatchSize, Ledger, Row, run_choices};
use crate::results::{PoseChoice, columns};
use perirobot_march::backend::Backend;
use perirobot_march::metrics::BodyPart;
use perirobot_march::{Error, Result};
use perirobot_study::input::Study;
use perirobot_study::world::World;

/// The number of choices checked at the start, and the least number if there are that many.
pub const AT_LEAST: u64 = 3;

/// Default share of checked choices after that: one in this many.
pub const ONE_IN: u64 = 500;

/// The most picked choices that wait, so that a scene is prepared once for several.
const MOST_WAITING: usize = 16;

/// Choices picked for a recount.
#[derive(Debug)]
pub(super) struct Picked {
    every: u64,
    seen: u64,
    /// Whether any were checked.
    begun: bool,
    /// The rows of each, until they are checked.
    waiting: Vec<Vec<Row>>,
}

/// A choice with two different counts.
#[derive(Debug)]
pub(super) struct Difference {
    /// Its place in words.
    pub(super) place: String,
    /// All details, for the file.
    pub(super) evidence: Value,
}

impl Picked {
    /// Picks the first ones and then one in `every`.
    pub(super) fn one_in(every: u64) -> Picked {
        Picked { every, seen: 0, begun: false, waiting: Vec::new() }
    }

    /// Picks only these rows, one per choice: their run was killed.
    pub(super) fn from_rows(waiting: Vec<Vec<Row>>) -> Picked {
        Picked { every: u64::MAX, seen: AT_LEAST, begun: false, waiting }
    }

    /// Also picks these rows.
    pub(super) fn with_rows(mut self, waiting: Vec<Vec<Row>>) -> Picked {
        self.waiting.extend(waiting);
        self
    }

    /// Considers the rows of one choice.
    pub(super) fn pick(&mut self, rows: &[Row]) {
        if self.seen < AT_LEAST || self.seen.is_multiple_of(self.every) {
            self.waiting.push(rows.to_vec());
        }
        self.seen += 1;
    }

    /// Whether the waiting ones should be checked now.
    pub(super) fn are_due(&self) -> bool {
        let many = if self.begun { MOST_WAITING } else { 1 };
        self.waiting.len() >= many
    }

    /// Recounts all waiting choices on the CPU. Returns their number, or the difference.
    pub(super) fn check(
        &mut self,
        study: &Study,
        worlds: &[World],
        backend: &mut dyn Backend,
    ) -> Result<Result<u64, Difference>> {
        let mut waiting = std::mem::take(&mut self.waiting);
        self.begun = true;
        waiting.sort_by_key(|rows| rows[0].place());
        let at = |rows: &Vec<Row>| (rows[0].scene, rows[0].snapshot);
        for of_world in waiting.chunk_by(|a, b| at(a) == at(b)) {
            let (scene, snapshot) = at(&of_world[0]);
            let here = |world: &World| (world.scene, world.snapshot) == (scene, snapshot);
            let Some(i) = worlds.iter().position(here) else { continue };
            let mut again = Again { asked: of_world, found: Vec::new() };
            let mut pose_choices: Vec<PoseChoice> =
                of_world.iter().map(|rows| pose_choice(&rows[0])).collect();
            // Repeats of a choice were picked separately, so they may not be adjacent.
            pose_choices.sort_by_key(|pose_choice| (pose_choice.combination, pose_choice.choice));
            pose_choices.dedup();
            run_choices(study, &worlds[i..=i], &pose_choices, BatchSize::SMALL, backend, &mut again)?;
            let (wanted, found) = (of_world.iter().map(Vec::len).sum::<usize>(), again.found.len());
            let ours: HashMap<_, _> = again.found.iter().map(|row| (row.place(), row)).collect();
            for theirs in of_world.iter().flatten() {
                match ours.get(&theirs.place()) {
                    Some(ours) if *ours == theirs => {}
                    Some(ours) => return Ok(Err(difference(study, theirs, ours))),
                    None => return Err(uneven(wanted, found)),
                }
            }
            if found != wanted {
                return Err(uneven(wanted, found));
            }
        }
        Ok(Ok(waiting.len() as u64))
    }
}

/// The error if the CPU counted other rows, so that a check is impossible.
fn uneven(wanted: usize, found: usize) -> Error {
    Error::device(format!(
        "the check of {wanted} rows on the CPU came back with {found}, and not all of them match: please report this"
    ))
}

fn pose_choice(row: &Row) -> PoseChoice {
    PoseChoice { combination: row.combination, choice: row.choice }
}

/// Requests the same choices again.
struct Again<'a> {
    asked: &'a [Vec<Row>],
    found: Vec<Row>,
}

impl Ledger for Again<'_> {
    fn wants(&self, _: &World, repeat: usize, wanted: &PoseChoice) -> bool {
        self.asked.iter().any(|rows| pose_choice(&rows[0]) == *wanted && rows[0].repeat == repeat)
    }

    fn take(&mut self, rows: &[Row]) -> Result<()> {
        self.found.extend(rows);
        Ok(())
    }
}

fn difference(study: &Study, theirs: &Row, ours: &Row) -> Difference {
    let combination = &study.combinations[theirs.combination];
    let scene = &study.scenes[theirs.scene].name;
    let poses = columns::pose_names(study, combination, theirs.choice);
    let representation = &columns::representation_names(study, combination)[theirs.representation];
    let region = &study.regions[theirs.region].0;
    let place = format!(
        "scene {scene}, snapshot {}, repeat {}, poses {poses}, {representation} in region {region}",
        theirs.snapshot, theirs.repeat
    );
    let missed = BodyPart::ALL.map(BodyPart::name);
    let columns =
        [&columns::COUNT_COLUMNS[..], &columns::DETECTION_COLUMNS, &missed, &columns::OVERLAP_COLUMNS]
            .concat();
    let evidence = json!({
        "scene": scene,
        "snapshot": theirs.snapshot,
        "repeat": theirs.repeat,
        "combination": combination.name,
        "poses": poses,
        "representation": representation,
        "region": region,
        "columns": columns,
        "counted_by_device": theirs.counts.numbers(),
        "counted_by_cpu": ours.counts.numbers(),
    });
    Difference { place, evidence }
}

#[cfg(test)]
mod tests {
    use super::*;
    use perirobot_march::backend::cpu::Cpu;
    use perirobot_study::input::Overrides;

    #[test]
    fn rows_too_few_or_too_many_are_an_error_of_their_own() {
        let path =
            std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenes/tiny.toml");
        let study = Study::load(&path, &Overrides::default()).unwrap();
        let worlds = World::prepare_all(&study).unwrap();
        let mut cpu = Cpu::new(Some(1)).unwrap();
        let all = crate::scoring::run(&study, &worlds, &mut cpu).unwrap();
        let first: Vec<Row> = all
            .iter()
            .filter(|row| row.repeat == 0 && pose_choice(row) == pose_choice(&all[0]))
            .copied()
            .collect();
        let mut check = |rows: Vec<Row>| Picked::from_rows(vec![rows]).check(&study, &worlds, &mut cpu);
        assert!(matches!(check(first.clone()), Ok(Ok(1))));
        let mut lied = first.clone();
        lied[1].counts.tp += 1;
        assert!(matches!(check(lied), Ok(Err(_))));
        let foreign = Row { region: study.regions.len(), ..first[0] };
        let many = [&first[..], &[foreign]].concat();
        for rows in [first[1..].to_vec(), many.clone(), many[1..].to_vec()] {
            let beginning =
                format!("the check of {} rows on the CPU came back with {}", rows.len(), first.len());
            let error = check(rows);
            assert!(
                matches!(&error, Err(Error::Device(what)) if what.to_string().starts_with(&beginning)),
                "{error:?}"
            );
        }
    }
}
