//! What a report says of a choice of poses: the scores of the paper, and beside them what a safety review asks first. The
//! formulas are `metrics`'.

use std::ops::Range;

use crate::metrics::Confusion;
use crate::report::{Key, Over, Results, Score, over};

/// A number about some counts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measure {
    /// As in the columns of results.csv.
    pub(super) name: &'static str,
    /// As in headings.
    pub(super) title: &'static str,
    /// Whether less of it is better.
    pub(super) less_is_better: bool,
    /// Its value, if the counts have one.
    of: fn(&Confusion) -> Option<f64>,
}

impl Measure {
    /// Whether its worst value is told beside its mean: of what names a best.
    pub(super) fn has_worst(&self) -> bool {
        matches!(self.name, "f1" | "human_seen")
    }
}

/// How many there are.
pub(super) const MEASURES: usize = 5;

/// All of them, in the order of every table.
pub(super) const ALL: [Measure; MEASURES] = [
    Measure { name: "f1", title: "F1", less_is_better: false, of: Confusion::f1 },
    Measure { name: "kappa", title: "κ", less_is_better: false, of: Confusion::kappa },
    Measure { name: "human_seen", title: "human seen", less_is_better: false, of: Confusion::human_seen },
    Measure { name: "unknown", title: "unknown", less_is_better: true, of: Confusion::unknown },
    Measure { name: "false_alarm", title: "false alarm", less_is_better: true, of: Confusion::false_alarm },
];

/// As in headings: a score that is among them.
pub(super) fn title(score: Score) -> &'static str {
    ALL.iter().find(|measure| measure.name == score.name()).map_or(score.title(), |measure| measure.title)
}

/// How many answers need no sensor; the upper bound stands behind them.
const TRIVIAL: usize = 3;

/// What an answer without a sensor is called, and its mean of each measure.
pub(super) type Baseline = (&'static str, [Option<f64>; MEASURES]);

/// Each measure of a choice over some moments and all repeats.
pub(super) fn of_choice(results: &Results, moments: Range<usize>, key: Key) -> [Option<Over>; MEASURES] {
    let repeat = |repeat| moments.clone().map(move |moment| results.counts(moment, repeat, &key)).collect();
    let counts: Vec<Vec<Confusion>> = (0..results.repeats).map(repeat).collect();
    ALL.map(|measure| over::over(counts.iter().map(|repeat| repeat.iter().copied()), measure.of))
}

/// The mean of each measure over some moments, for each answer that needs no sensor, and last for the best that any
/// sensor of the study could give.
pub(super) fn of_baselines(results: &Results, moments: Range<usize>, region: usize) -> Vec<Baseline> {
    let all = ALL.map(|measure| results.baselines_by(moments.clone(), region, measure.of));
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
