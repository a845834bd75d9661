//! The choices of poses of one representation of one combination, with their scores and ranking.

use std::cmp::Ordering;

use perirobot_decide::view::names::ChoiceNames;
use perirobot_march::Result;
use perirobot_march::metrics::Score;
use perirobot_sweep::results::over::summarize;
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

    /// The mean F1 of each of its choices over some moments, which decides between equal ones.
    pub(super) fn f1_means(
        self,
        results: &Results,
        moments: &(impl Iterator<Item = usize> + Clone),
        region: usize,
    ) -> Result<Vec<Option<f64>>> {
        let f1 = self.summarize(results, moments, region, Score::F1)?;
        Ok(f1.into_iter().map(|over| Some(over?.mean)).collect())
    }

    /// Its choices with a mean of a score over some moments, as [`rank`] orders them.
    pub(super) fn best(
        self,
        results: &Results,
        moments: &(impl Iterator<Item = usize> + Clone),
        region: usize,
        score: Score,
    ) -> Result<Vec<(usize, f64)>> {
        let (mut values, mut f1) = (Vec::new(), Vec::new());
        for choice in 0..results.combinations[self.combination].choices() {
            let readings = results.readings(moments.clone(), &self.key(choice, region))?;
            let mean = |score: Score| Some(summarize(&readings, score)?.mean);
            values.push(mean(score));
            f1.push(mean(Score::F1));
        }
        Ok(rank(score, values.into_iter(), &f1))
    }
}

/// Choices with a value, best first. This is the rule for ties of all commands: of equal choices the one with the higher
/// F1 comes first, then the one that is first in the study.
pub(super) fn rank(
    score: Score,
    values: impl Iterator<Item = Option<f64>>,
    f1: &[Option<f64>],
) -> Vec<(usize, f64)> {
    let mut best: Vec<(usize, f64)> =
        values.enumerate().filter_map(|(choice, value)| Some((choice, value?))).collect();
    best.sort_by(|a, b| compare_merit(score, (b.1, f1[b.0]), (a.1, f1[a.0])));
    best
}

/// The first of [`rank`].
pub(super) fn first_best(
    score: Score,
    values: impl Iterator<Item = Option<f64>>,
    f1: &[Option<f64>],
) -> Option<(usize, f64)> {
    let with_value = values.enumerate().filter_map(|(choice, value)| Some((choice, value?)));
    with_value.reduce(|best, next| {
        match compare_merit(score, (next.1, f1[next.0]), (best.1, f1[best.0])).is_gt() {
            true => next,
            false => best,
        }
    })
}

/// A value by which choices are ranked, and the F1 that decides between equal ones.
pub(super) type ValueAndF1 = (f64, Option<f64>);

/// Compares a value and its F1 with those of another choice; the better one is the greater.
pub(super) fn compare_merit(
    score: Score,
    (own, own_f1): ValueAndF1,
    (other, other_f1): ValueAndF1,
) -> Ordering {
    let f1 = |f1: Option<f64>| f1.unwrap_or(f64::NEG_INFINITY);
    let by_score = score.merit(own).total_cmp(&score.merit(other));
    by_score.then_with(|| f1(own_f1).total_cmp(&f1(other_f1)))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn f1_decides_between_equal_ones_and_then_the_order() {
        let values = [Some(0.5), Some(0.8), Some(0.8), None, Some(0.8), Some(0.8)];
        let f1 = [Some(0.9), Some(0.2), None, Some(1.0), Some(0.3), Some(0.3)];
        let ranked = rank(Score::PartsDetected, values.into_iter(), &f1);
        assert_eq!(ranked.iter().map(|(choice, _)| *choice).collect::<Vec<_>>(), [4, 5, 1, 2, 0]);
        assert_eq!(first_best(Score::PartsDetected, values.into_iter(), &f1), Some((4, 0.8)));
        // Where less is better, a higher F1 still is.
        let ranked = rank(Score::Unknown, values.into_iter(), &f1);
        assert_eq!(ranked.iter().map(|(choice, _)| *choice).collect::<Vec<_>>(), [0, 4, 5, 1, 2]);
    }
}
