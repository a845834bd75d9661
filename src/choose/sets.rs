//! The sets of an answer as combinations of their study, so that they are swept, and looked at afterwards, like any
//! others.

use super::told::{Told, ToldSensor, ToldSet};
use super::worth::Worth;
use crate::backend::Fusion;
use crate::error::Issue;
use crate::results::{Results, RowKey};
use crate::study::{Choose, Combination, Member, Study};
use crate::{Error, Result};

impl Told {
    /// The study of the sets that were found, each a combination with one choice of poses; sensors say what the
    /// search took them to say.
    pub fn study_of_sets(&self, study: &Study, choose: &Choose) -> Study {
        let combinations = self.sets().map(|set| combination(study, self.title(set), set)).collect();
        study.of_sets(&choose.representations, combinations)
    }

    /// Fails unless a sweep of the sets counted what their scores were made of.
    pub fn agrees(&self, choose: &Choose, results: &Results) -> Result<()> {
        for (combination, set) in self.sets().enumerate() {
            let key = RowKey { combination, choice: 0, representation: 0, region: choose.region };
            let counts = results.readings(results.moments(), &key)?.concat();
            let swept = Worth::of(choose.objective, choose.over, &counts).map(Worth::value);
            if swept != Some(set.score) {
                let (name, score, set) = (choose.objective.name(), set.score, set.name());
                let what =
                    format!("{set} was chosen for {name} {score}, and swept it has {swept:?}: report this");
                return Err(Error::Disagreement(Issue::says(what)));
            }
        }
        Ok(())
    }

    /// `best 2`, `best 2 for 900`, `tie 1`: the step that a set is the best of first, or its place among the ties.
    fn title(&self, set: &ToldSet) -> String {
        let is_set = |other: &ToldSet| other.poses == set.poses;
        if let Some(step) = self.steps.iter().find(|step| is_set(&step.best)) {
            let cost = set.cost.map_or(String::new(), |cost| format!(" for {cost}"));
            return format!("best {}{cost}", step.at_most);
        }
        let number = self.ties.iter().position(is_set).unwrap_or_default();
        format!("tie {}", number + 1)
    }
}

fn combination(study: &Study, name: String, set: &ToldSet) -> Combination {
    let member = |one: &ToldSensor| {
        let sensor = study.sensors.iter().position(|known| known.name == one.sensor);
        let sensor = sensor.expect("an answer names the study's sensors");
        let candidates = &study.sensors[sensor].candidates;
        let candidate = candidates.iter().position(|known| known.name == one.pose);
        Member { sensor, candidates: vec![candidate.expect("an answer names the study's poses")] }
    };
    Combination { name, fusion: Fusion::OccupiedWins, members: set.sensors.iter().map(member).collect() }
}
