//! The part of a sweep's results in tables and figures.

use super::series::{Series, series};
use perirobot_march::Result;
use perirobot_march::error::{Argument, Issue, Site};
use perirobot_march::metrics::Score;
use perirobot_sweep::results::Results;

/// The part of the results in a report.
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
    pub fn resolve(
        results: &Results,
        region: Option<&str>,
        combination: Option<&str>,
        scores: &[Score],
    ) -> Result<ReportSelection> {
        let regions: Vec<&str> = results.regions.iter().map(String::as_str).collect();
        let combinations: Vec<&str> = results.combinations.iter().map(|c| c.name.as_str()).collect();
        Ok(ReportSelection {
            regions: resolve_name(Argument("region"), region, &regions)?,
            combinations: resolve_name(Argument("combination"), combination, &combinations)?,
            scores: scores.to_vec(),
        })
    }

    /// Every pair of a score and a region, in the order of the tables.
    pub(super) fn parts(&self) -> impl Iterator<Item = (Score, usize)> + '_ {
        self.regions.iter().flat_map(|&region| self.scores.iter().map(move |&score| (score, region)))
    }

    /// Every representation of every combination.
    pub(super) fn series(&self, results: &Results) -> Vec<Series> {
        series(results, self.combinations.iter().copied())
    }
}

fn resolve_name(argument: Argument, name: Option<&str>, known: &[&str]) -> Result<Vec<usize>> {
    let Some(name) = name else { return Ok((0..known.len()).collect()) };
    match known.iter().position(|k| *k == name) {
        Some(index) => Ok(vec![index]),
        None => {
            let rule = Issue::says("must be one of those of the sweep").with_advice(format!("{known:?}"));
            Err(rule.with_place(Site::Argument(argument, name.into())).into())
        }
    }
}
