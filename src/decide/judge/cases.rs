//! The cases of a condition: the counts of a choice of sensors in each, and its approaches.

use super::alteration::Alteration;
use crate::approach::{Company, NearestApproach};
use crate::controller::Separation;
use crate::view::Choice;
use perirobot_march::Result;
use perirobot_march::metrics::Confusion;
use perirobot_study::input::{AtSpeed, Condition, Nearness, Study};
use perirobot_sweep::results::{Results, RowKey, Subject};

/// A repeat of a snapshot of a scene; all counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Moment {
    /// Index of the scene.
    pub scene: usize,
    /// The snapshot.
    pub snapshot: usize,
    /// The repeat.
    pub repeat: usize,
}

/// A way in: all snapshots of a scene at once, in which no body is farther than in any of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Passage {
    /// Index of the scene.
    pub scene: usize,
    /// The company.
    pub company: Company,
    /// The repeat, counted from 0.
    pub repeat: usize,
    /// The name of the body.
    pub body: String,
    /// Whether it stands on the floor.
    pub on_floor: bool,
    /// The name of the entry.
    pub entry: String,
}

impl Passage {
    /// Whether a requirement covers it, and its score exists.
    pub(crate) fn is_asked(&self, nearness: &Nearness) -> bool {
        let is_asked = |name: &Option<String>, own: &String| name.as_ref().is_none_or(|name| name == own);
        is_asked(&nearness.body, &self.body)
            && is_asked(&nearness.entry, &self.entry)
            && (self.on_floor || !nearness.score.is_area())
    }
}

/// The sensors in one case of a condition.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Case {
    /// The alteration.
    pub alteration: Alteration,
    /// Mounts that stay as planned because no draw was possible: as in `pads:floor/0/0`.
    pub kept: Vec<String>,
    /// Warnings about the place of a posture, with the scene.
    pub warnings: Vec<String>,
    /// The counts of each moment, for each region.
    pub counts: Vec<Vec<Confusion>>,
    /// The reach of bodies by each passage; empty if unknown.
    pub near: Vec<NearestApproach>,
    /// A controller's measurement at each moment; empty if unknown.
    pub measured: Vec<Separation>,
}

/// Conditions with their cases.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Conditions {
    /// The moments of all counts: repeat by repeat, then scene by scene and snapshot by snapshot, in the order of the
    /// tables.
    pub moments: Vec<Moment>,
    /// The passages of all cases with known approaches.
    pub passages: Vec<Passage>,
    /// The edge of a voxel.
    pub voxel_size_m: f64,
    /// Needed distance of people at the highest robot speed, if the study has it.
    pub needed: Option<AtSpeed>,
    /// The cases of each known condition, at least one.
    pub cases: Vec<(Condition, Vec<Case>)>,
}

impl Conditions {
    /// The counts of a sweep for a choice: everything as planned.
    ///
    /// # Errors
    /// `Error::Storage` if its journal cannot be read any more.
    pub fn from_results(study: &Study, results: &Results, choice: &Choice) -> Result<Conditions> {
        let of_region = |region| counts(results, choice, region);
        let counts: Vec<Vec<Confusion>> = (0..results.regions.len()).map(of_region).collect::<Result<_>>()?;
        Ok(Conditions::from_plan(study, results, counts))
    }

    /// Everything as planned, from the counts of each region at each moment.
    pub(super) fn from_plan(study: &Study, subject: &Subject, counts: Vec<Vec<Confusion>>) -> Conditions {
        let cases = vec![(Condition::AsPlanned, vec![Case { counts, ..Case::default() }])];
        let (moments, passages) = (moments(subject), Vec::new());
        let needed = study.stopping.as_ref().map(|stopping| *stopping.fastest());
        Conditions { moments, passages, voxel_size_m: study.voxel_size_m, needed, cases }
    }

    /// A controller's measurements of the plan at each moment; empty if unknown.
    pub fn measurements(&self) -> impl Iterator<Item = (&Moment, &Separation)> + Clone {
        self.moments.iter().zip(self.cases(Condition::AsPlanned).iter().flat_map(|case| &case.measured))
    }

    /// The cases of a condition; empty if unknown.
    pub fn cases(&self, condition: Condition) -> &[Case] {
        let known = self.cases.iter().find(|(known, _)| *known == condition);
        known.map_or(&[], |(_, cases)| cases.as_slice())
    }
}

/// The counts of a sweep for a choice in a region, moment by moment.
pub(super) fn counts(results: &Results, choice: &Choice, region: usize) -> Result<Vec<Confusion>> {
    let &Choice { combination, choice, representation, .. } = choice;
    let key = RowKey { combination, choice, representation, region };
    let each = (0..results.repeats).flat_map(|repeat| results.moments().map(move |moment| (moment, repeat)));
    each.map(|(moment, repeat)| results.counts(moment, repeat, &key)).collect()
}

fn moments(subject: &Subject) -> Vec<Moment> {
    let scenes = subject.scenes.iter().enumerate();
    let snapshots =
        scenes.flat_map(|(scene, of)| (0..of.moments.len()).map(move |snapshot| (scene, snapshot)));
    let of_repeat =
        |repeat| snapshots.clone().map(move |(scene, snapshot)| Moment { scene, snapshot, repeat });
    (0..subject.repeats).flat_map(of_repeat).collect()
}
