//! Results presented to people: tables for a terminal, and the report as a page.

mod apart;
pub mod best;
pub mod choose;
pub mod distribution;
#[cfg(feature = "report")]
pub mod figures;
pub mod groups;
#[cfg(feature = "report")]
pub mod html;
pub mod judge;
pub mod maxima;
pub mod placements;
pub mod places;
pub mod reasons;
pub mod recorded;
pub mod separation;
pub mod snapshots;
pub mod speed;
mod table;

use perirobot_march::Result;
use perirobot_march::error::{Argument, Issue, Site};
use perirobot_march::metrics::Score;
use perirobot_sweep::results::{Over, Results, RowKey};

/// What stands under tables with an upper bound of human_seen.
const NEAR_SIDE: &str = "Only the near side of a body can be hit: human_seen ends well below 1, while parts_detected can reach it.";

/// What is said of means where snapshots last differently and the means do not know it.
pub const PLAIN_MEANS: &str = "Means count each snapshot once, however long it lasts (dwell_s); weighted means are in scores.csv and in the summary.";

/// The line under the table of a score with an upper bound, if it needs one.
fn near_side(score: Score) -> String {
    if score == Score::HumanSeen { format!("{NEAR_SIDE}\n") } else { String::new() }
}

/// Which part of the results a report is about.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReportSelection {
    /// Indices of regions.
    pub regions: Vec<usize>,
    /// Indices of combinations.
    pub combinations: Vec<usize>,
    /// Scores, in the order of the tables.
    pub scores: Vec<Score>,
}

impl ReportSelection {
    /// The named region and combination, or all of them; an unknown name is an [`Error::Input`](perirobot_march::Error::Input) that lists
    /// the known.
    pub fn named(
        results: &Results,
        region: Option<&str>,
        combination: Option<&str>,
        scores: &[Score],
    ) -> Result<ReportSelection> {
        let regions: Vec<&str> = results.regions.iter().map(String::as_str).collect();
        let combinations: Vec<&str> = results.combinations.iter().map(|c| c.name.as_str()).collect();
        Ok(ReportSelection {
            regions: chosen(Argument("region"), region, &regions)?,
            combinations: chosen(Argument("combination"), combination, &combinations)?,
            scores: scores.to_vec(),
        })
    }

    /// Every pair of a score and a region, in the order of the tables.
    fn parts(&self) -> impl Iterator<Item = (Score, usize)> + '_ {
        self.regions.iter().flat_map(|&region| self.scores.iter().map(move |&score| (score, region)))
    }

    /// Every representation of every combination.
    fn series(&self, results: &Results) -> Vec<Series> {
        series(results, self.combinations.iter().copied())
    }
}

fn chosen(argument: Argument, name: Option<&str>, known: &[&str]) -> Result<Vec<usize>> {
    let Some(name) = name else { return Ok((0..known.len()).collect()) };
    match known.iter().position(|k| *k == name) {
        Some(index) => Ok(vec![index]),
        None => {
            let rule = Issue::says("must be one of those of the sweep").wanted(format!("{known:?}"));
            Err(rule.at(Site::Argument(argument, name.into())).into())
        }
    }
}

/// One representation of one combination; its choices of poses compete with each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Series {
    combination: usize,
    representation: usize,
}

/// Every representation of some combinations.
fn series(results: &Results, combinations: impl Iterator<Item = usize>) -> Vec<Series> {
    let of = |combination: usize| {
        let representations = 0..results.combinations[combination].representations.len();
        representations.map(move |representation| Series { combination, representation })
    };
    combinations.flat_map(of).collect()
}

impl Series {
    /// One of its choices in one region.
    fn key(self, choice: usize, region: usize) -> RowKey {
        let Series { combination, representation } = self;
        RowKey { combination, choice, representation, region }
    }

    /// `camera · points`; of several sensors that are scored in one way only, that way is left out.
    fn title(self, results: &Results) -> String {
        let combination = &results.combinations[self.combination];
        match (combination.members.len(), combination.representations.as_slice()) {
            (2.., [_]) => combination.name.clone(),
            (_, all) => format!("{} · {}", combination.name, all[self.representation]),
        }
    }

    /// A score of each of its choices over some moments.
    fn over(
        self,
        results: &Results,
        moments: &(impl Iterator<Item = usize> + Clone),
        region: usize,
        score: Score,
    ) -> Result<Vec<Option<Over>>> {
        let choices = 0..results.combinations[self.combination].choices();
        choices.map(|choice| results.over(moments.clone(), self.key(choice, region), score)).collect()
    }

    /// The weighted mean of a score of each of its choices over some moments.
    fn weighted(
        self,
        results: &Results,
        moments: &(impl Iterator<Item = usize> + Clone),
        region: usize,
        score: Score,
    ) -> Result<Vec<Option<f64>>> {
        let choices = 0..results.combinations[self.combination].choices();
        choices.map(|choice| results.weighted(moments.clone(), &self.key(choice, region), score)).collect()
    }

    /// Its choices that have a mean of a score over some moments, with it, the best first; equal ones keep
    /// study order.
    fn best(
        self,
        results: &Results,
        moments: &(impl Iterator<Item = usize> + Clone),
        region: usize,
        score: Score,
    ) -> Result<Vec<(usize, f64)>> {
        let values = self.over(results, moments, region, score)?;
        Ok(ranked(score, values.iter().map(|over| Some(over.as_ref()?.mean))))
    }
}

/// Choices that have a value, the best first; equal ones keep study order.
fn ranked(score: Score, values: impl Iterator<Item = Option<f64>>) -> Vec<(usize, f64)> {
    let mut best: Vec<(usize, f64)> =
        values.enumerate().filter_map(|(choice, value)| Some((choice, value?))).collect();
    best.sort_by(|a, b| score.merit(b.1).total_cmp(&score.merit(a.1)));
    best
}

/// The best value and the first choice that has it.
fn first_best(score: Score, values: impl Iterator<Item = Option<f64>>) -> Option<(usize, f64)> {
    let with_value = values.enumerate().filter_map(|(choice, value)| Some((choice, value?)));
    with_value.reduce(|best, next| if score.merit(next.1) > score.merit(best.1) { next } else { best })
}

#[cfg(test)]
mod tests;
