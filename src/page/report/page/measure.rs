//! The measures of a choice of poses in a report: the scores of the paper, and those that a safety review asks first.
//! The formulas are in `metrics`.

use std::ops::Range;

use crate::report::table::number;
use perirobot_march::Result;
use perirobot_march::metrics::{SCORES, Score};
use perirobot_sweep::results::{Over, Results, RowKey, over};

/// The scores that name a best: F1, as in the paper, and those of a safety review.
pub(super) const BESTS: [Score; 3] = [Score::F1, Score::HumanSeen, Score::PartsDetected];

/// Whether its worst value is shown next to its mean: for scores that name a best.
pub(super) fn has_worst(score: Score) -> bool {
    BESTS.contains(&score)
}

/// The name in headings.
pub(super) fn title(score: Score) -> String {
    match score {
        Score::Kappa => "κ".into(),
        _ => score.title().replace('_', " "),
    }
}

/// Whether it is a share, which the page writes as percent.
pub(super) fn is_share(score: Score) -> bool {
    !matches!(score, Score::F1 | Score::Kappa)
}

/// A score in a table or chart of the page: a share as percent, F1 and κ as numbers, as in the paper.
pub(super) fn shown(score: Score, value: Option<f64>) -> String {
    match value {
        Some(value) if is_share(score) => percent(value, 1),
        _ => number(value),
    }
}

/// A share with this many digits, rounded to 0 % or 100 % only if exact.
pub(super) fn percent(share: f64, digits: usize) -> String {
    let least = 0.1f64.powi(digits as i32);
    // Halves are rounded up.
    let written = |value: f64| format!("{:.digits$}\u{a0}%", (value / least).round() * least);
    match written(share * 100.0) {
        _ if share == 0.0 || share == 1.0 => format!("{}\u{a0}%", share * 100.0),
        text if share > 0.0 && text == written(0.0) => format!("<{}", written(least)),
        text if share < 1.0 && text == written(100.0) => format!(">{}", written(100.0 - least)),
        text => text,
    }
}

/// The number of baselines without sensors; the upper bound follows them.
const TRIVIAL: usize = 3;

/// The name of a baseline without sensors, and its mean of each measure.
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

/// The mean of each measure over some moments, for each baseline without sensors, and last the upper bound of any
/// sensor of the study.
pub(super) fn baseline_measures(results: &Results, moments: Range<usize>, region: usize) -> Vec<Baseline> {
    let all = Score::ALL.map(|score| results.baselines_over(moments.clone(), region, score));
    let one = |n: usize| (all[0][n].0, all.each_ref().map(|answers| answers[n].1.map(|over| over.mean)));
    let mut found: Vec<Baseline> = (0..=TRIVIAL).map(one).collect();
    // The upper bound comes first there.
    found.rotate_left(1);
    found
}

/// The best baseline without sensors, by a measure's index.
pub(super) fn to_beat(baselines: &[Baseline], measure: usize) -> Option<(&'static str, f64)> {
    let with_value = baselines[..TRIVIAL].iter().filter_map(|(name, values)| Some((*name, values[measure]?)));
    with_value.reduce(|best, next| if next.1 > best.1 { next } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_percent_and_not_rounded_to_nothing_or_all() {
        let written =
            |share: f64| [percent(share, 0), percent(share, 1)].map(|text| text.replace('\u{a0}', " "));
        assert_eq!(written(0.0), ["0 %", "0 %"]);
        assert_eq!(written(0.0004), ["<1 %", "<0.1 %"]);
        assert_eq!(written(0.3333), ["33 %", "33.3 %"]);
        assert_eq!(written(0.9996), [">99 %", ">99.9 %"]);
        assert_eq!(written(1.0), ["100 %", "100 %"]);
        let both = [Score::F1, Score::Unknown].map(|score| shown(score, Some(0.1234)));
        assert_eq!(both, ["0.123", "12.3\u{a0}%"]);
        assert_eq!(shown(Score::Unknown, None), "–");
    }
}
