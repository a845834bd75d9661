//! What a report says of a choice of poses: the scores of the paper, and beside them what a safety review
//! asks first. The formulas are `metrics`'.

use std::ops::Range;

use perirobot_march::Result;
use perirobot_march::metrics::{SCORES, Score};
use perirobot_sweep::results::{Over, Results, RowKey, over};

/// The scores that name a best: F1, as in the paper, and what a safety review asks first.
pub(super) const BESTS: [Score; 3] = [Score::F1, Score::HumanSeen, Score::PartsDetected];

/// Whether its worst value is shown beside its mean: so for scores by which a best is named.
pub(super) fn has_worst(score: Score) -> bool {
    BESTS.contains(&score)
}

/// As in headings of the page.
pub(super) fn title(score: Score) -> String {
    match score {
        Score::Kappa => "κ".into(),
        _ => score.title().replace('_', " "),
    }
}

/// Whether it is a share of something, which is told as percent.
pub(super) fn is_share(score: Score) -> bool {
    !matches!(score, Score::F1 | Score::Kappa)
}

/// How many answers need no sensor; the upper bound stands behind them.
const TRIVIAL: usize = 3;

/// The name of an answer without a sensor, and its mean of each measure.
pub(super) type Baseline = (&'static str, [Option<f64>; SCORES]);

/// Each measure of a choice over some moments and all repeats.
pub(super) fn choice_measures(
    results: &Results,
    moments: Range<usize>,
    key: RowKey,
) -> Result<[Option<Over>; SCORES]> {
    let readings = results.readings(moments, &key)?;
    Ok(Score::ALL.map(|score| over::summarize(&readings, score)))
}

/// The mean of each measure over some moments, for each answer that needs no sensor, and last for the best
/// that any sensor of the study could give.
pub(super) fn baseline_measures(results: &Results, moments: Range<usize>, region: usize) -> Vec<Baseline> {
    let all = Score::ALL.map(|score| results.baselines_over(moments.clone(), region, score));
    let one = |n: usize| (all[0][n].0, all.each_ref().map(|answers| answers[n].1.map(|over| over.mean)));
    let mut found: Vec<Baseline> = (0..=TRIVIAL).map(one).collect();
    // The upper bound is the first there.
    found.rotate_left(1);
    found
}

/// The best of the answers that need no sensor, by the measure of this number.
pub(super) fn to_beat(baselines: &[Baseline], measure: usize) -> Option<(&'static str, f64)> {
    let with_value = baselines[..TRIVIAL].iter().filter_map(|(name, values)| Some((*name, values[measure]?)));
    with_value.reduce(|best, next| if next.1 > best.1 { next } else { best })
}
