//! The range of a score over some moments: the best with the study's positions, and without any sensor.

use std::ops::Range;

use perirobot_march::metrics::Score;
use perirobot_sweep::results::Results;

/// The mean with all positions of the study together.
pub(super) fn upper_bound(
    results: &Results,
    moments: Range<usize>,
    region: usize,
    score: Score,
) -> Option<f64> {
    let [(_, bound), ..] = results.baselines_over(moments, region, score);
    bound.map(|over| over.mean)
}

/// The best baseline without sensors, and its mean.
pub(super) fn best_without_sensor(
    results: &Results,
    moments: Range<usize>,
    region: usize,
    score: Score,
) -> Option<(&'static str, f64)> {
    let [_, trivial @ ..] = results.baselines_over(moments, region, score);
    let known = trivial.into_iter().filter_map(|(name, over)| Some((name, over?.mean)));
    known.reduce(|best, next| if score.merit(next.1) > score.merit(best.1) { next } else { best })
}
