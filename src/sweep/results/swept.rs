//! The results of a sweep, by name: every count of every scene, snapshot, repeat and choice of poses, with the
//! baselines. Names are in memory, counts are read from the journal when needed. Results come from a sweep or, through
//! `read`, from its folder, and are equal.

use std::ops::Range;
use std::sync::Arc;

use crate::results::journal::Pages;
use crate::results::{CombinationSize, Over, RowKey, RowLayout, columns, over};
use perirobot_march::Result;
use perirobot_march::metrics::{Confusion, Score};
use perirobot_scene::objects::spec::SceneVariant;
use perirobot_study::input::{self, Choices, Combination, Study};
use perirobot_study::sensor::{Candidate, Setting};
use perirobot_study::world::place::{self, Places};
use perirobot_study::world::{Baselines, World};

/// The results of a sweep. Indices of scenes, combinations, choices, representations and regions are those of the
/// study; a moment is a snapshot of a scene, counted through all scenes.
#[derive(Debug)]
pub struct Results {
    /// The subject.
    pub subject: Subject,
    pub(super) layout: RowLayout,
    pub(super) pages: Pages,
}

/// The subject of a sweep, by name.
#[derive(Clone, Debug, PartialEq)]
pub struct Subject {
    /// Scenes in study order.
    pub scenes: Vec<SceneResults>,
    /// Names of the regions.
    pub regions: Vec<String>,
    /// The number of repeats.
    pub repeats: usize,
    /// Combinations in study order.
    pub combinations: Vec<CombinationResults>,
    /// For each moment and region, the scores of the simplest answers.
    pub baselines: Vec<Vec<Baselines>>,
    /// The duration of each moment in seconds, if a scene has durations; one second for other scenes.
    pub dwell_s: Option<Vec<f64>>,
}

/// A swept scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneResults {
    /// Its name.
    pub name: String,
    /// Its snapshots among the moments of all scenes.
    pub moments: Range<usize>,
    /// The scene of which it is a variant, if any.
    pub variant: Option<SceneVariant>,
}

/// Swept places of objects: one of each object with candidates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlaceResults {
    /// As in the names of its scenes, after the `@`.
    pub name: String,
    /// The number of scenes with their objects there.
    pub(crate) scenes: usize,
    /// Their moments.
    pub moments: Vec<usize>,
}

/// A swept combination.
#[derive(Clone, Debug, PartialEq)]
pub struct CombinationResults {
    /// Its name.
    pub name: String,
    /// Its sensors in the order of precedence; equal ones are consecutive.
    pub members: Vec<MemberResults>,
    /// The scored representations of each choice, as in the column `representation` of results.csv.
    pub representations: Vec<String>,
}

/// A sensor of a combination.
#[derive(Clone, Debug, PartialEq)]
pub struct MemberResults {
    /// Its name.
    pub sensor: String,
    /// All of its poses, in study order.
    pub poses: Arc<Vec<PoseResults>>,
    /// Those in the combination, in their order.
    pub candidates: Vec<usize>,
}

/// A pose of a sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseResults {
    /// Its name.
    pub name: String,
    /// The group of poses that it belongs to, a wall or the ceiling; `None` without a pose.
    pub group: Option<String>,
    /// The place in words, as in the column `place` of poses.csv.
    pub place: String,
}

impl Subject {
    /// The subject of a study's sweep. `worlds` are those of [`World::prepare_all`].
    pub fn from_study(study: &Study, worlds: &[World]) -> Subject {
        let mut end = 0;
        let scenes = study.scenes.iter().map(|spec| {
            let begin = end;
            end += spec.snapshots;
            SceneResults { name: spec.name.clone(), moments: begin..end, variant: spec.variant.clone() }
        });
        let each_lasts = study.scenes.iter().flat_map(|scene| {
            (0..scene.snapshots).map(|snapshot| scene.dwell_s.as_ref().map(|dwell_s| dwell_s[snapshot]))
        });
        let poses: Vec<Arc<Vec<PoseResults>>> = {
            let places = Places::new(study, &worlds[0]);
            (0..study.sensors.len()).map(|sensor| Arc::new(poses(study, &places, sensor))).collect()
        };
        let member = |member: &input::Member| MemberResults {
            sensor: study.sensors[member.sensor].name.clone(),
            poses: poses[member.sensor].clone(),
            candidates: member.candidates.clone(),
        };
        let combination = |combination: &Combination| CombinationResults {
            name: combination.name.clone(),
            members: combination.members.iter().map(member).collect(),
            representations: columns::representation_names(study, combination),
        };
        Subject {
            scenes: scenes.collect(),
            regions: study.regions.iter().map(|(name, _)| name.clone()).collect(),
            repeats: study.repeats as usize,
            combinations: study.combinations.iter().map(combination).collect(),
            baselines: worlds.iter().map(|world| world.baselines.clone()).collect(),
            dwell_s: dwell_s(each_lasts.collect()),
        }
    }

    /// All moments of all scenes.
    pub fn moments(&self) -> Range<usize> {
        0..self.baselines.len()
    }

    /// Every row of a block in study order: names of combination, poses, representation and region, and its
    /// key.
    pub(crate) fn each_key(&self, mut row: impl FnMut([&str; 4], RowKey) -> Result<()>) -> Result<()> {
        for (combination, combined) in self.combinations.iter().enumerate() {
            for choice in 0..combined.choices() {
                let poses = combined.name_of(choice);
                for (representation, as_what) in combined.representations.iter().enumerate() {
                    for (region, place) in self.regions.iter().enumerate() {
                        let key = RowKey { combination, choice, representation, region };
                        row([&combined.name, &poses, as_what, place], key)?;
                    }
                }
            }
        }
        Ok(())
    }

    /// The swept places of objects, in their order; empty if no object has candidates.
    pub fn places(&self) -> Vec<PlaceResults> {
        let mut places: Vec<PlaceResults> = Vec::new();
        for (variant, scene) in self.scenes.iter().filter_map(|scene| Some((scene.variant.as_ref()?, scene)))
        {
            let known = places.iter().position(|place| place.name == variant.place);
            let place = known.unwrap_or_else(|| {
                places.push(PlaceResults { name: variant.place.clone(), scenes: 0, moments: Vec::new() });
                places.len() - 1
            });
            places[place].scenes += 1;
            places[place].moments.extend(scene.moments.clone());
        }
        places
    }

    /// The numbering of its rows.
    pub fn layout(&self) -> RowLayout {
        let size = |c: &CombinationResults| CombinationSize {
            choices: c.choices(),
            representations: c.representations.len(),
        };
        let sizes = self.combinations.iter().map(size).collect();
        RowLayout::new(self.moments().len(), self.repeats, sizes, self.regions.len())
    }
}

/// The duration of each moment, if any is given.
pub(super) fn dwell_s(said: Vec<Option<f64>>) -> Option<Vec<f64>> {
    let any = said.iter().any(Option::is_some);
    any.then(|| said.into_iter().map(|seconds| seconds.unwrap_or(1.0)).collect())
}

fn poses(study: &Study, places: &Places, sensor: usize) -> Vec<PoseResults> {
    let named = |(index, candidate): (usize, &Candidate)| PoseResults {
        name: candidate.name.clone(),
        group: matches!(candidate.setting, Setting::Pose(_)).then(|| candidate.group.clone()),
        place: places.words(sensor, index),
    };
    study.sensors[sensor].candidates.iter().enumerate().map(named).collect()
}

impl std::ops::Deref for Results {
    type Target = Subject;

    fn deref(&self) -> &Subject {
        &self.subject
    }
}

impl Results {
    /// The counts in some journals, which together contain every row of the sweep.
    pub fn new(subject: Subject, pages: Pages) -> Results {
        Results { layout: subject.layout(), subject, pages }
    }

    /// The counts of all rows of a sweep, in the order of [`crate::scoring::run_on`], without a folder.
    ///
    /// # Panics
    /// If their number does not match the subject.
    pub fn from_counts(subject: Subject, counts: impl IntoIterator<Item = Confusion>) -> Results {
        let layout = subject.layout();
        let mut counts = counts.into_iter();
        let block = |_| counts.by_ref().take(layout.block_rows() as usize).collect();
        let blocks: Vec<Vec<Confusion>> = (0..layout.blocks()).map(block).collect();
        let rows: usize = blocks.iter().map(Vec::len).sum();
        assert!(
            rows as u64 == layout.rows() && counts.next().is_none(),
            "each row of a sweep is counted once"
        );
        Results { layout, subject, pages: Pages::in_memory(blocks) }
    }

    /// The counts of a moment.
    ///
    /// # Errors
    /// `Error::Storage` if the journal cannot be read any more.
    pub fn counts(&self, moment: usize, repeat: usize, key: &RowKey) -> Result<Confusion> {
        self.pages.counts(self.layout.row(moment, repeat, key))
    }

    /// The counts of one choice at some moments, for each repeat.
    ///
    /// # Errors
    /// Those of [`Results::counts`].
    pub fn readings(
        &self,
        moments: impl Iterator<Item = usize> + Clone,
        key: &RowKey,
    ) -> Result<Vec<Vec<Confusion>>> {
        let repeat = |repeat| moments.clone().map(|moment| self.counts(moment, repeat, key)).collect();
        (0..self.repeats).map(repeat).collect()
    }

    /// A score of one choice over some moments and all repeats; `None` if it has no value in any.
    ///
    /// # Errors
    /// Those of [`Results::counts`].
    pub fn summarize(
        &self,
        moments: impl Iterator<Item = usize> + Clone,
        key: RowKey,
        score: Score,
    ) -> Result<Option<Over>> {
        Ok(over::summarize(&self.readings(moments, &key)?, score))
    }

    /// The mean of a score of one choice over some moments and all repeats, weighted by the moments' durations; `None`
    /// if no scene has durations, or no value has one.
    ///
    /// # Errors
    /// Those of [`Results::counts`].
    pub fn weighted_mean(
        &self,
        moments: impl Iterator<Item = usize> + Clone,
        key: &RowKey,
        score: Score,
    ) -> Result<Option<f64>> {
        let Some(dwell_s) = &self.dwell_s else { return Ok(None) };
        let lasting: Vec<f64> = moments.clone().map(|moment| dwell_s[moment]).collect();
        Ok(over::weighted_mean(&self.readings(moments, key)?, &lasting, score))
    }

    /// The names of the baselines and their score over some moments.
    pub fn baselines_over(
        &self,
        moments: impl Iterator<Item = usize> + Clone,
        region: usize,
        score: Score,
    ) -> [(&'static str, Option<Over>); 4] {
        let summary = |pick: fn(&Baselines) -> &Confusion| {
            let counts = moments.clone().map(|moment| *pick(&self.baselines[moment][region]));
            over::summarize(&[counts.collect()], score)
        };
        [
            ("upper bound", summary(|b| &b.ceiling)),
            ("all occupied", summary(|b| &b.all_occupied)),
            ("all free", summary(|b| &b.all_free)),
            ("nothing seen", summary(|b| &b.nothing_seen)),
        ]
    }
}

impl CombinationResults {
    /// The number of its choices of poses.
    pub fn choices(&self) -> usize {
        self.all_choices().count()
    }

    fn all_choices(&self) -> Choices {
        Choices::from_sensors(
            self.members.iter().map(|member| (&member.sensor, member.candidates.as_slice())),
        )
    }

    /// The poses of a choice.
    pub fn poses(&self, choice: usize) -> impl Iterator<Item = (&MemberResults, &PoseResults)> {
        let chosen = self.all_choices().nth(choice);
        self.members.iter().zip(chosen).map(|(member, i)| (member, &member.poses[member.candidates[i]]))
    }

    /// A choice, as in the column `poses` of results.csv: `camera:right-wall/8/1;pads:floor/3/0`.
    pub fn name_of(&self, choice: usize) -> String {
        let names = self.poses(choice).map(|(member, pose)| format!("{}:{}", member.sensor, pose.name));
        names.collect::<Vec<_>>().join(columns::BETWEEN_MEMBERS)
    }

    /// The places of a choice's sensors, in words: `left wall, x 0.5 m, 2.2 m high, 30° down`, with the names of
    /// several sensors.
    pub fn place_of(&self, choice: usize) -> String {
        let places = self.poses(choice).map(|(member, pose)| (member.sensor.as_str(), &pose.place));
        place::join(&places.collect::<Vec<_>>())
    }

    /// The group of a choice's poses, if exactly one of its sensors has a pose.
    pub fn group_of(&self, choice: usize) -> Option<&str> {
        let mut groups = self.poses(choice).filter_map(|(_, pose)| pose.group.as_deref());
        let group = groups.next()?;
        groups.next().is_none().then_some(group)
    }

    /// The name of a choice in tables: without the sensor's if there is only one.
    pub fn label(&self, choice: usize) -> String {
        match self.members.as_slice() {
            [_] => self.poses(choice).map(|(_, pose)| pose.name.clone()).collect(),
            _ => self.name_of(choice),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::{example, rows, scores};

    #[test]
    fn results_in_memory_are_those_of_a_journal() {
        let counts_at = |moment: usize, repeat: usize, key: &RowKey| {
            example::counts((7 * moment + 5 * repeat + 3 * key.choice + key.representation) as u64)
        };
        let read = example::results_in(&["robot", "human"], 2, counts_at);
        let mut counts = Vec::new();
        for (moment, repeat) in read.moments().flat_map(|moment| [(moment, 0), (moment, 1)]) {
            let take = |_: [&str; 4], key: RowKey| {
                counts.push(counts_at(moment, repeat, &key));
                Ok(())
            };
            read.each_key(take).unwrap();
        }
        let kept = Results::from_counts(read.subject.clone(), counts);
        assert_eq!(rows::csv(&kept).unwrap(), rows::csv(&read).unwrap());
        assert_eq!(scores::csv(&kept).unwrap(), scores::csv(&read).unwrap());
        let unswept = Subject { combinations: Vec::new(), ..read.subject.clone() };
        assert_eq!(Results::from_counts(unswept, []).layout.rows(), 0);
    }
}
