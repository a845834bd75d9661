//! Which choices of poses a report says more of than others: the best ones, fairly from each region and representation.
//! Scores come from elsewhere.

use crate::report::{Results, Score, Series, ranked, series};

/// The choices of one representation of one combination, the best first.
#[derive(Debug)]
pub(super) struct Ranking {
    /// Whose choices they are.
    pub(super) series: Series,
    /// For each region, the choices that have an F1 over all scenes, the largest mean first; equal ones in study order.
    pub(super) by_region: Vec<Vec<(usize, f64)>>,
}

/// A ranking for every representation of every combination.
pub(super) fn rankings(results: &Results) -> Vec<Ranking> {
    let of_region = |series: Series, region| {
        let values = series.over(results, &results.moments(), region, Score::F1);
        ranked(values.iter().map(|over| Some(over.as_ref()?.mean)))
    };
    let all = series(results, 0..results.combinations.len()).into_iter();
    let regions = || 0..results.regions.len();
    all.map(|series| Ranking {
        series,
        by_region: regions().map(|region| of_region(series, region)).collect(),
    })
    .collect()
}

/// The first choice of each ranking in a region, the best first: the ranking's number, the choice, and its score.
pub(super) fn firsts(rankings: &[Ranking], region: usize) -> Vec<(usize, (usize, f64))> {
    let first = |(number, ranking): (usize, &Ranking)| Some((number, *ranking.by_region[region].first()?));
    let mut firsts: Vec<_> = rankings.iter().enumerate().filter_map(first).collect();
    // The sort is stable: equal ones keep study order.
    firsts.sort_by(|a, b| b.1.1.total_cmp(&a.1.1));
    firsts
}

impl Ranking {
    /// At most so many choices, each once: the best of each region, then the second best of each, and so on; those without
    /// a score last.
    pub(super) fn first(&self, most: usize, choices: usize) -> Vec<usize> {
        let mut taken = vec![false; choices];
        let mut first = Vec::new();
        let ranks = self.by_region.iter().map(Vec::len).max().unwrap_or(0);
        let best = (0..ranks).flat_map(|rank| self.by_region.iter().filter_map(move |best| best.get(rank)));
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
        let by_region = vec![vec![(3, 0.9), (1, 0.8), (0, 0.1)], vec![(3, 0.7), (4, 0.6)]];
        let ranking = Ranking { series: Series { combination: 0, representation: 0 }, by_region };
        assert_eq!(ranking.first(10, 6), [3, 1, 4, 0, 2, 5]);
        assert_eq!(ranking.first(2, 6), [3, 1]);
    }
}
