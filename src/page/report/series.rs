//! The choices of poses of one representation of one combination, with their scores and ranking.

use perirobot_decide::view::names::ChoiceNames;
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use perirobot_sweep::results::swept::{CombinationResults, SceneResults};
use perirobot_sweep::results::{Over, Results, RowKey};

/// One representation of one combination; its choices of poses compete with each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Series {
    pub(super) combination: usize,
    pub(super) representation: usize,
}

/// Every representation of some combinations.
pub(super) fn series(results: &Results, combinations: impl Iterator<Item = usize>) -> Vec<Series> {
    let to_series = |combination: usize| {
        let representations = 0..results.combinations[combination].representations.len();
        representations.map(move |representation| Series { combination, representation })
    };
    combinations.flat_map(to_series).collect()
}

impl Series {
    /// One of its choices in one region.
    pub(super) fn key(self, choice: usize, region: usize) -> RowKey {
        let Series { combination, representation } = self;
        RowKey { combination, choice, representation, region }
    }

    /// `camera · points`; for several sensors with a single representation, that is left out.
    pub(super) fn title(self, results: &Results) -> String {
        let combination = &results.combinations[self.combination];
        match (combination.members.len(), combination.representations.as_slice()) {
            (2.., [_]) => combination.name.clone(),
            (_, all) => format!("{} · {}", combination.name, all[self.representation]),
        }
    }

    /// A score of each of its choices over some moments.
    pub(super) fn summarize(
        self,
        results: &Results,
        moments: &(impl Iterator<Item = usize> + Clone),
        region: usize,
        score: Score,
    ) -> Result<Vec<Option<Over>>> {
        let choices = 0..results.combinations[self.combination].choices();
        choices.map(|choice| results.summarize(moments.clone(), self.key(choice, region), score)).collect()
    }

    /// The weighted mean of a score of each of its choices over some moments.
    pub(super) fn weighted_mean(
        self,
        results: &Results,
        moments: &(impl Iterator<Item = usize> + Clone),
        region: usize,
        score: Score,
    ) -> Result<Vec<Option<f64>>> {
        let choices = 0..results.combinations[self.combination].choices();
        choices
            .map(|choice| results.weighted_mean(moments.clone(), &self.key(choice, region), score))
            .collect()
    }

    /// Its choices with a mean of a score over some moments, best first; equal ones keep study order.
    pub(super) fn best(
        self,
        results: &Results,
        moments: &(impl Iterator<Item = usize> + Clone),
        region: usize,
        score: Score,
    ) -> Result<Vec<(usize, f64)>> {
        let values = self.summarize(results, moments, region, score)?;
        Ok(rank(score, values.iter().map(|over| Some(over.as_ref()?.mean))))
    }
}

/// Choices with a value, best first; equal ones keep study order.
pub(super) fn rank(score: Score, values: impl Iterator<Item = Option<f64>>) -> Vec<(usize, f64)> {
    let mut best: Vec<(usize, f64)> =
        values.enumerate().filter_map(|(choice, value)| Some((choice, value?))).collect();
    best.sort_by(|a, b| score.merit(b.1).total_cmp(&score.merit(a.1)));
    best
}

/// The best value and its first choice.
pub(super) fn first_best(score: Score, values: impl Iterator<Item = Option<f64>>) -> Option<(usize, f64)> {
    let with_value = values.enumerate().filter_map(|(choice, value)| Some((choice, value?)));
    with_value.reduce(|best, next| if score.merit(next.1) > score.merit(best.1) { next } else { best })
}

/// The snapshot of a scene, counted from 0, with a choice's worst score in any repeat; the first of several.
pub(super) fn worst_snapshot(
    results: &Results,
    scene: &SceneResults,
    key: RowKey,
    score: Score,
) -> Result<Option<usize>> {
    let mut worst: Option<(usize, f64)> = None;
    for (snapshot, moment) in scene.moments.clone().enumerate() {
        let Some(over) = results.summarize(moment..moment + 1, key, score)? else { continue };
        if worst.is_none_or(|(_, value)| score.merit(over.worst) < score.merit(value)) {
            worst = Some((snapshot, over.worst));
        }
    }
    Ok(worst.map(|(snapshot, _)| snapshot))
}

/// The names of a combination's choices.
pub(super) fn choice_names(combination: &CombinationResults) -> ChoiceNames<'_> {
    let members = combination.members.iter().map(|member| {
        let poses = member.candidates.iter().map(|&candidate| member.poses[candidate].name.as_str());
        (member.sensor.as_str(), poses.collect())
    });
    ChoiceNames { combination: &combination.name, members: members.collect() }
}
