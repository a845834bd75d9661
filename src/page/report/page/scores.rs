//! The scores of a report's choices of poses as numbers for its script: over all scenes, over each, and at each moment
//! of moving scenes.

use std::ops::Range;

use serde::Serialize;

use super::measure;
use super::packed::NumberTable;
use super::ranking::Ranking;
use crate::report::series::Series;
use perirobot_march::Result;
use perirobot_march::metrics::SCORES;
use perirobot_sweep::results::Results;

/// Most scores in a report: 4 MB before compression and encoding.
const MOST_SCORES: usize = 1_000_000;

/// Most scores at single moments.
const MOST_AT_MOMENTS: usize = 400_000;

/// The places of the scores of some choices.
#[derive(Debug, Serialize)]
pub(super) struct ScoresAt {
    /// The choices, if not all.
    choices: Option<Vec<usize>>,
    /// Their number.
    count: usize,
    /// Index of the first number. They are ordered by region, extent, measure and choice, the last fastest.
    begin: usize,
}

/// The scores of one representation of one combination.
#[derive(Debug, Serialize)]
pub(super) struct Scores {
    /// Over all scenes (extent 0), then over each, if there are several.
    over: ScoresAt,
    /// At each moment of all scenes; `None` if none moves.
    at_moments: Option<ScoresAt>,
    /// The least of them.
    #[serde(skip)]
    pub(super) least_at_moments: f64,
}

/// The scores of every ranking's best choices, as many as fit.
pub(super) fn scores(
    results: &Results,
    rankings: &[Ranking],
    numbers: &mut NumberTable,
) -> Result<Vec<Scores>> {
    let several = results.scenes.len() > 1;
    let scenes = results.scenes.iter().filter(|_| several).map(|scene| scene.moments.clone());
    let extents: Vec<Range<usize>> = [results.moments()].into_iter().chain(scenes).collect();
    let moments: Vec<Range<usize>> = results.moments().map(|moment| moment..moment + 1).collect();
    let moves = moments.len() > results.scenes.len();
    let [of_extents, of_moments] = [(&extents, MOST_SCORES), (&moments, MOST_AT_MOMENTS)]
        .map(|(extents, most)| share(results, rankings, extents, most));
    let of_one = |ranking: &Ranking| {
        let over = block(results, ranking, of_extents, &extents, numbers)?;
        let begin = numbers.len();
        let at_moments = moves.then(|| block(results, ranking, of_moments, &moments, numbers)).transpose()?;
        let least_at_moments = at_moments.as_ref().map_or(f64::INFINITY, |_| numbers.least_from(begin));
        Ok(Scores { over, at_moments, least_at_moments })
    };
    rankings.iter().map(of_one).collect()
}

/// How many choices of each ranking fit: all, or an equal share.
fn share(results: &Results, rankings: &[Ranking], extents: &[Range<usize>], most: usize) -> usize {
    let each = results.regions.len() * extents.len() * SCORES;
    let choices = rankings.iter().map(|r| results.combinations[r.series.combination].choices());
    let all = choices.fold(0usize, usize::saturating_add);
    if all.saturating_mul(each) <= most { usize::MAX } else { (most / each / rankings.len()).max(1) }
}

fn block(
    results: &Results,
    ranking: &Ranking,
    most: usize,
    extents: &[Range<usize>],
    numbers: &mut NumberTable,
) -> Result<ScoresAt> {
    let all = results.combinations[ranking.series.combination].choices();
    let choices: Vec<usize> = match most >= all {
        true => (0..all).collect(),
        false => ranking.first(most, all),
    };
    let begin = numbers.len();
    for region in 0..results.regions.len() {
        for extent in extents {
            put(results, ranking.series, &choices, (region, extent), numbers)?;
        }
    }
    Ok(ScoresAt { count: choices.len(), choices: (most < all).then_some(choices), begin })
}

/// Each measure of each choice, in one region over one extent.
fn put(
    results: &Results,
    series: Series,
    choices: &[usize],
    (region, extent): (usize, &Range<usize>),
    numbers: &mut NumberTable,
) -> Result<()> {
    let means = |&choice: &usize| {
        let measures = measure::choice_measures(results, extent.clone(), series.key(choice, region))?;
        Ok(measures.map(|over| Some(over?.mean)))
    };
    let all: Vec<[Option<f64>; SCORES]> = choices.iter().map(means).collect::<Result<_>>()?;
    (0..SCORES).for_each(|measure| all.iter().for_each(|values| numbers.push(values[measure])));
    Ok(())
}
