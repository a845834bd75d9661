//! What a sweep found, by name: every count of every scene, snapshot, repeat and choice of poses, and the baselines
//! beside them. It comes from a finished sweep or, by way of `read`, from its folder, and is the same either way.

use std::ops::Range;

use glam::DVec3;

use super::{Over, Score, over};
use crate::metrics::Confusion;
use crate::sensor::Setting;
use crate::study::{Combination, Study};
use crate::sweep::world::Baselines;
use crate::sweep::{Row, World, table};

/// What a sweep found. Indices of scenes, combinations, choices, representations and regions are those of the study; a
/// moment is a snapshot of a scene, counted through all scenes.
#[derive(Clone, Debug, PartialEq)]
pub struct Results {
    /// Scenes in study order.
    pub scenes: Vec<SceneResults>,
    /// Names of the regions.
    pub regions: Vec<String>,
    /// How often everything was scored.
    pub repeats: usize,
    /// Combinations in study order.
    pub combinations: Vec<CombinationResults>,
    /// For each moment and region, what the simplest answers would score.
    pub baselines: Vec<Vec<Baselines>>,
    /// In study order: moment, repeat, combination, choice, representation, region.
    pub(super) counts: Vec<Confusion>,
}

/// A scene that was swept.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneResults {
    /// Its name.
    pub name: String,
    /// Its snapshots among the moments of all scenes.
    pub moments: Range<usize>,
}

/// A combination that was swept.
#[derive(Clone, Debug, PartialEq)]
pub struct CombinationResults {
    /// Its name.
    pub name: String,
    /// Names of its sensors in the order they speak.
    pub sensors: Vec<String>,
    /// What is scored of each choice, as in the column `representation` of results.csv.
    pub representations: Vec<String>,
    /// Choices of poses in study order.
    pub choices: Vec<Choice>,
}

/// One choice of poses.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// As in the column `poses` of results.csv.
    pub name: String,
    /// Where its sensor is, if exactly one of them has a pose.
    pub place: Option<ChoicePlace>,
}

/// Where the one posed sensor of a choice is.
#[derive(Clone, Debug, PartialEq)]
pub struct ChoicePlace {
    /// The set of poses it belongs to: a wall, the ceiling.
    pub group: String,
    /// Position in metres, in the world or, for a sensor that a robot carries, on its link.
    pub position_m: DVec3,
}

/// Which counts: one choice of poses in one representation and region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    /// Index of the combination.
    pub combination: usize,
    /// Number of the choice.
    pub choice: usize,
    /// Number of the choice of representations.
    pub representation: usize,
    /// Index of the region.
    pub region: usize,
}

impl Results {
    /// The results of a finished sweep. `worlds` are those of [`World::prepare_all`], `rows` all that the sweep gave.
    pub fn of_sweep(study: &Study, worlds: &[World], rows: &[Row]) -> Results {
        let mut end = 0;
        let scenes = study.scenes.iter().enumerate().map(|(scene, spec)| {
            let begin = end;
            end += worlds.iter().filter(|world| world.scene == scene).count();
            SceneResults { name: spec.name.clone(), moments: begin..end }
        });
        let mut results = Results {
            scenes: scenes.collect(),
            regions: study.regions.iter().map(|(name, _)| name.clone()).collect(),
            repeats: study.repeats as usize,
            combinations: study.combinations.iter().map(|c| combination(study, c)).collect(),
            baselines: worlds.iter().map(|world| world.baselines.clone()).collect(),
            counts: Vec::new(),
        };
        results.counts =
            vec![Confusion::default(); results.moments().len() * results.repeats * results.block()];
        for row in rows {
            let moment = results.scenes[row.scene].moments.start + row.snapshot;
            let key = Key {
                combination: row.combination,
                choice: row.choice,
                representation: row.interpretation,
                region: row.region,
            };
            let at = results.index(moment, row.repeat, &key);
            results.counts[at] = row.counts;
        }
        results
    }

    /// All moments of all scenes.
    pub fn moments(&self) -> Range<usize> {
        0..self.baselines.len()
    }

    /// How many counts one repeat of one moment has.
    pub(super) fn block(&self) -> usize {
        self.combinations.iter().map(|c| c.choices.len() * c.representations.len() * self.regions.len()).sum()
    }

    /// What was counted at a moment.
    pub fn counts(&self, moment: usize, repeat: usize, key: &Key) -> &Confusion {
        &self.counts[self.index(moment, repeat, key)]
    }

    fn index(&self, moment: usize, repeat: usize, key: &Key) -> usize {
        let regions = self.regions.len();
        let size = |c: &CombinationResults| c.choices.len() * c.representations.len() * regions;
        let before: usize = self.combinations[..key.combination].iter().map(size).sum();
        let ways = self.combinations[key.combination].representations.len();
        let within = (key.choice * ways + key.representation) * regions + key.region;
        (moment * self.repeats + repeat) * self.block() + before + within
    }

    /// A score of one choice over some moments and all repeats; `None` if it has no value in any.
    pub fn over(&self, moments: Range<usize>, key: Key, score: Score) -> Option<Over> {
        let (block, first) = (self.block(), self.index(0, 0, &key));
        let at = move |moment, repeat| &self.counts[first + (moment * self.repeats + repeat) * block];
        let repeats = (0..self.repeats).map(|repeat| moments.clone().map(move |moment| at(moment, repeat)));
        over::over(repeats, score)
    }

    /// The names of the baselines and their score over some moments.
    pub fn baselines_over(
        &self,
        moments: Range<usize>,
        region: usize,
        score: Score,
    ) -> [(&'static str, Option<Over>); 4] {
        let of = |pick: fn(&Baselines) -> &Confusion| {
            let counts = moments.clone().map(move |moment| pick(&self.baselines[moment][region]));
            over::over(std::iter::once(counts), score)
        };
        [
            ("upper bound", of(|b| &b.ceiling)),
            ("all occupied", of(|b| &b.all_occupied)),
            ("all free", of(|b| &b.all_free)),
            ("nothing seen", of(|b| &b.nothing_seen)),
        ]
    }
}

fn combination(study: &Study, combination: &Combination) -> CombinationResults {
    let sensor = |member: &crate::study::Member| &study.sensors[member.sensor];
    let choices = (0..combination.choices()).map(|number| {
        let chosen = combination.members.iter().zip(combination.choice(number));
        let places = chosen.filter_map(|(member, candidate)| {
            let candidate = &sensor(member).candidates[candidate];
            match candidate.setting {
                Setting::Pose(pose) => Some((candidate.group.as_str(), pose.position_m)),
                _ => None,
            }
        });
        let place = only(places);
        Choice { name: table::pose_names(study, combination, number), place }
    });
    CombinationResults {
        name: combination.name.clone(),
        sensors: combination.members.iter().map(|member| sensor(member).name.clone()).collect(),
        representations: table::representation_names(study, combination),
        choices: choices.collect(),
    }
}

/// The place of a choice, from the groups and positions of its posed sensors.
pub(super) fn only<'a>(mut places: impl Iterator<Item = (&'a str, DVec3)>) -> Option<ChoicePlace> {
    let (group, position_m) = places.next()?;
    places.next().is_none().then(|| ChoicePlace { group: group.into(), position_m })
}

impl CombinationResults {
    /// A choice as it stands in tables: without the sensor's name where there is only one, and with its position.
    pub(super) fn label(&self, choice: usize) -> String {
        let Choice { name, place } = &self.choices[choice];
        let own = format!("{}:", self.sensors[0]);
        let short = if self.sensors.len() == 1 { name.strip_prefix(&own).unwrap_or(name) } else { name };
        match place {
            Some(ChoicePlace { position_m: p, .. }) => {
                format!("{short} ({:.2}, {:.2}, {:.2})", p.x, p.y, p.z)
            }
            None => short.to_string(),
        }
    }
}
