//! The choices of poses detailed in a report: the best ones of each region and representation; and summaries of all
//! choices. Every count of a sweep is read here once.

use std::ops::Range;

use super::measure::{self, BESTS};
use crate::report::maximum::{Maxima, Maximum};
use crate::report::quartiles::{Distribution, distribution};
use crate::report::series::{Series, compare_merit, first_best, rank, series};
use perirobot_march::Result;
use perirobot_march::metrics::{SCORES, Score};
use perirobot_sweep::results::Results;

/// The choices of one representation of one combination, best first.
#[derive(Debug)]
pub(super) struct Ranking {
    /// Its series.
    pub(super) series: Series,
    /// By each of [`BESTS`], for each region, the choices that have a value over all scenes, largest mean first; equal
    /// ones by F1, then in study order.
    by: [Vec<Vec<(usize, f64)>>; BESTS.len()],
    /// For each region and scene, each score of all choices.
    scenes: Vec<Vec<[Option<MeanSpread>; SCORES]>>,
}

/// The means of all choices of a series by one score in one scene and region.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MeanSpread {
    /// Its five numbers.
    pub(super) distribution: Distribution,
    /// Their numbers in each of [`BINS`] equal parts from the smallest to the largest.
    pub(super) bins: Vec<u32>,
    /// All means, if they are few.
    pub(super) single: Vec<f64>,
    /// The first of the best.
    best: (usize, f64),
}

/// The most choices drawn one by one; for more, a histogram is drawn.
const MOST_SINGLE: usize = 300;

/// Parts of a histogram.
const BINS: usize = 48;

impl MeanSpread {
    fn new(score: Score, means: &[Option<f64>], f1: &[Option<f64>]) -> Option<MeanSpread> {
        let values: Vec<f64> = means.iter().copied().flatten().collect();
        let best = first_best(score, means.iter().copied(), f1)?;
        let mut bins = vec![0; BINS];
        let distribution = distribution(values.clone())?;
        let Distribution { min, max, .. } = distribution;
        for value in &values {
            let part = if max > min { (value - min) / (max - min) } else { 0.0 };
            bins[((part * BINS as f64) as usize).min(BINS - 1)] += 1;
        }
        let single = if values.len() <= MOST_SINGLE { values } else { Vec::new() };
        Some(MeanSpread { distribution, bins, single, best })
    }
}

/// A ranking for every representation of every combination.
pub(super) fn rankings(results: &Results) -> Result<Vec<Ranking>> {
    series(results, 0..results.combinations.len()).into_iter().map(|one| ranking(results, one)).collect()
}

fn ranking(results: &Results, series: Series) -> Result<Ranking> {
    let mut by: [Vec<_>; BESTS.len()] = Default::default();
    let mut scenes: Vec<Vec<_>> = Vec::new();
    let spreads = |means: &Means| {
        Score::ALL.map(|score| MeanSpread::new(score, &means[score as usize], &means[Score::F1 as usize]))
    };
    for region in 0..results.regions.len() {
        let over_all = means(results, series, region, results.moments())?;
        for (by, score) in by.iter_mut().zip(BESTS) {
            by.push(rank(score, over_all[score as usize].iter().copied(), &over_all[Score::F1 as usize]));
        }
        scenes.push(match &results.scenes[..] {
            [_] => vec![spreads(&over_all)],
            each => each
                .iter()
                .map(|scene| Ok(spreads(&means(results, series, region, scene.moments.clone())?)))
                .collect::<Result<_>>()?,
        });
    }
    Ok(Ranking { series, by, scenes })
}

/// For each score, the mean of each choice.
type Means = [Vec<Option<f64>>; SCORES];

fn means(results: &Results, series: Series, region: usize, moments: Range<usize>) -> Result<Means> {
    let mut means = Means::default();
    for choice in 0..results.combinations[series.combination].choices() {
        let each = measure::choice_measures(results, moments.clone(), series.key(choice, region))?;
        means.iter_mut().zip(each).for_each(|(means, over)| means.push(over.map(|over| over.mean)));
    }
    Ok(means)
}

/// The maxima of a combination by one score in one region, as in `maxima`.
pub(super) fn maxima_of(
    results: &Results,
    rankings: &[Ranking],
    combination: usize,
    (region, score): (usize, Score),
) -> Maxima {
    let own = || rankings.iter().filter(move |ranking| ranking.series.combination == combination);
    let of_scene = |scene: usize| {
        let each = own().filter_map(|ranking| {
            let (choice, value) = ranking.spread(region, scene, score)?.best;
            Some(Maximum { value, choice, representation: ranking.series.representation })
        });
        each.reduce(|best, next| if score.merit(next.value) > score.merit(best.value) { next } else { best })
    };
    Maxima::new(combination, (0..results.scenes.len()).map(of_scene).collect())
}

/// The first choice of each ranking in a region by one of [`BESTS`], best first: the ranking's index, the choice, and
/// its score.
pub(super) fn firsts(rankings: &[Ranking], region: usize, best: usize) -> Vec<(usize, (usize, f64))> {
    let first =
        |(number, ranking): (usize, &Ranking)| Some((number, *ranking.choices_by(best)[region].first()?));
    let mut firsts: Vec<_> = rankings.iter().enumerate().filter_map(first).collect();
    let with_f1 = |&(number, (choice, value)): &(usize, (usize, f64))| {
        let mut by_f1 = rankings[number].choices_by(0)[region].iter();
        (value, by_f1.find(|(known, _)| *known == choice).map(|(_, f1)| *f1))
    };
    // The sort is stable: equal ones keep study order.
    firsts.sort_by(|a, b| compare_merit(BESTS[best], with_f1(b), with_f1(a)));
    firsts
}

impl Ranking {
    /// A score of all choices in a region and scene; `None` if no choice has a value.
    pub(super) fn spread(&self, region: usize, scene: usize, score: Score) -> Option<&MeanSpread> {
        self.scenes[region][scene][score as usize].as_ref()
    }

    /// The choices of each region by one of [`BESTS`].
    pub(super) fn choices_by(&self, best: usize) -> &[Vec<(usize, f64)>] {
        &self.by[best]
    }

    /// At most `most` choices, each once: the best of each region by each of [`BESTS`], then the second best of each,
    /// and so on; those without a score last.
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
    fn values_are_counted_part_by_part() {
        let spread =
            MeanSpread::new(Score::Unknown, &[Some(0.5), None, Some(0.25), Some(0.75)], &[None; 4]).unwrap();
        let filled: Vec<usize> = (0..BINS).filter(|&bin| spread.bins[bin] > 0).collect();
        assert_eq!((filled, spread.bins.iter().sum()), (vec![0, BINS / 2, BINS - 1], 3));
        // The smallest is the best if less is better.
        assert_eq!(spread.best, (2, 0.25));
        assert_eq!(MeanSpread::new(Score::F1, &[Some(0.5); 3], &[Some(0.5); 3]).unwrap().bins[0], 3);
        assert_eq!(MeanSpread::new(Score::F1, &[None], &[None]), None);
    }

    #[test]
    fn regions_take_turns() {
        let by_f1 = vec![vec![(3, 0.9), (1, 0.8), (0, 0.1)], vec![(3, 0.7), (4, 0.6)]];
        let by = [by_f1, vec![Vec::new(); 2], vec![Vec::new(); 2]];
        let series = Series { combination: 0, representation: 0 };
        let ranking = Ranking { series, by, scenes: Vec::new() };
        assert_eq!(ranking.first(10, 6), [3, 1, 4, 0, 2, 5]);
        assert_eq!(ranking.first(2, 6), [3, 1]);
    }
}
