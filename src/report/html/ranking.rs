//! Which choices of poses a report describes in detail: the best ones of each region and representation.

use std::collections::HashMap;

use crate::Result;
use crate::metrics::Score;
use crate::report::Series;
use crate::report::series;
use crate::results::Results;

/// The scores that name a best: F1, as in the paper, and what a safety review asks first.
pub(super) const BESTS: [Score; 3] = [Score::F1, Score::HumanSeen, Score::PartsDetected];

/// The choices of one representation of one combination, the best first.
#[derive(Debug)]
pub(super) struct Ranking {
    /// Whose choices they are.
    pub(super) series: Series,
    /// By each of [`BESTS`], for each region, the choices that have a value over all scenes, the largest mean
    /// first; equal ones by F1, then in study order.
    by: [Vec<Vec<(usize, f64)>>; BESTS.len()],
}

/// A ranking for every representation of every combination.
pub(super) fn rankings(results: &Results) -> Result<Vec<Ranking>> {
    let ranked = |series: Series, region, score| {
        // The sort is stable, so that F1 decides between equal ones; all that have a value have an F1.
        let by_f1 = series.best(results, &results.moments(), region, Score::F1)?.into_iter();
        let means: HashMap<usize, f64> =
            series.best(results, &results.moments(), region, score)?.into_iter().collect();
        let mut all: Vec<_> = by_f1.filter_map(|(choice, _)| Some((choice, *means.get(&choice)?))).collect();
        all.sort_by(|a, b| b.1.total_cmp(&a.1));
        Ok(all)
    };
    let all = series(results, 0..results.combinations.len()).into_iter();
    let by = |series, score| {
        (0..results.regions.len()).map(|region| ranked(series, region, score)).collect::<Result<_>>()
    };
    let [f1, seen, parts] = BESTS;
    all.map(|series| Ok(Ranking { series, by: [by(series, f1)?, by(series, seen)?, by(series, parts)?] }))
        .collect()
}

/// The first choice of each ranking in a region by one of [`BESTS`], the best first: the ranking's number,
/// the choice, and its score.
pub(super) fn firsts(rankings: &[Ranking], region: usize, best: usize) -> Vec<(usize, (usize, f64))> {
    let first = |(number, ranking): (usize, &Ranking)| Some((number, *ranking.by(best)[region].first()?));
    let mut firsts: Vec<_> = rankings.iter().enumerate().filter_map(first).collect();
    // The sort is stable: equal ones keep study order.
    firsts.sort_by(|a, b| b.1.1.total_cmp(&a.1.1));
    firsts
}

impl Ranking {
    /// The choices of each region by one of [`BESTS`].
    pub(super) fn by(&self, best: usize) -> &[Vec<(usize, f64)>] {
        &self.by[best]
    }

    /// At most so many choices, each once: the best of each region by each of [`BESTS`], then the second best
    /// of each, and so on; those without a score last.
    pub(super) fn first(&self, most: usize, choices: usize) -> Vec<usize> {
        let mut taken = vec![false; choices];
        let mut first = Vec::new();
        let lists = || self.by.iter().flatten();
        let ranks = lists().map(Vec::len).max().unwrap_or(0);
        let best = (0..ranks).flat_map(|rank| lists().filter_map(move |best| best.get(rank)));
        for choice in best.map(|&(choice, _)| choice).chain(0..choices) {
            if first.len() == most {
                break;
            }
            if !std::mem::replace(&mut taken[choice], true) {
                first.push(choice);
            }
        }
        first
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regions_take_turns() {
        let by_f1 = vec![vec![(3, 0.9), (1, 0.8), (0, 0.1)], vec![(3, 0.7), (4, 0.6)]];
        let by = [by_f1, vec![Vec::new(); 2], vec![Vec::new(); 2]];
        let series = Series { combination: 0, representation: 0 };
        let ranking = Ranking { series, by };
        assert_eq!(ranking.first(10, 6), [3, 1, 4, 0, 2, 5]);
        assert_eq!(ranking.first(2, 6), [3, 1]);
    }
}
