//! Scores under a condition: best, mean, 5 % quantile, worst.

use super::cases::{Case, Conditions};
use super::verdict::{CasePart, Where, approach_value, controller_value};
use perirobot_march::metrics::{Ratio, Score};
use perirobot_study::input::{ApproachScore, Condition, ControllerScore, Counted, Measure};

/// A summarised score.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Summed {
    /// A score in a region, by its index.
    Counted(Score, usize),
    /// A score of approaching bodies, over all bodies and ways.
    Nearness(ApproachScore),
    /// A score of a controller's measurements.
    Controller(ControllerScore),
}

impl Summed {
    /// The score of a requirement.
    pub fn from_measure(measure: &Measure) -> Summed {
        match measure {
            Measure::Counted(Counted { score, region, .. }) => Summed::Counted(*score, *region),
            Measure::Nearness(nearness) => Summed::Nearness(nearness.score),
            Measure::Controller(score) => Summed::Controller(*score),
        }
    }

    /// The score with this name, if it is counted, in a region.
    pub fn from_name(score: &str, region: usize) -> Option<Summed> {
        let counted = Score::ALL.into_iter().map(|score| Summed::Counted(score, region));
        let near = ApproachScore::ALL.into_iter().map(Summed::Nearness);
        let controller = ControllerScore::ALL.into_iter().map(Summed::Controller);
        counted.chain(near).chain(controller).find(|known| known.name() == score)
    }

    /// The score's name.
    pub fn name(self) -> &'static str {
        match self {
            Summed::Counted(score, _) => score.name(),
            Summed::Nearness(score) => score.name(),
            Summed::Controller(score) => score.name(),
        }
    }

    /// The region, if it has one.
    pub fn region(self) -> Option<usize> {
        match self {
            Summed::Counted(_, region) => Some(region),
            Summed::Nearness(_) | Summed::Controller(_) => None,
        }
    }
}

/// A score over all parts of all cases of a condition. Numbers are infinite for bodies that never come near.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScoreSpread {
    /// The condition.
    pub condition: Condition,
    /// The score.
    pub of_what: Summed,
    /// The best value.
    pub best: f64,
    /// The mean of all values.
    pub mean: f64,
    /// The best of the worst twentieth of the values, rounded up: the 5 % quantile by nearest rank.
    pub twentieth: f64,
    /// The worst value.
    pub worst: f64,
    /// The place of the worst value; the first of several.
    pub at: Where,
    /// The number of values.
    pub values: usize,
    /// The number if every moment of every case had one.
    pub of: usize,
}

impl ScoreSpread {
    /// Whether there are several values and all are equal, so that none is the worst.
    pub fn is_even(&self) -> bool {
        self.of > 1 && self.values == self.of && self.best == self.worst
    }
}

/// Each score in each region under each condition, and the approaches; scores without a value are left out.
pub fn spreads(conditions: &Conditions) -> Vec<ScoreSpread> {
    let regions = |cases: &[Case]| cases.first().map_or(0, |case| case.counts.len());
    let scores = |(condition, cases): &(Condition, Vec<Case>)| {
        let parts = (0..regions(cases)).flat_map(|region| Score::ALL.map(|score| (region, score)));
        let counted = parts.filter_map(|(region, score)| spread(*condition, cases, region, score));
        let near = ApproachScore::ALL.into_iter();
        let near = near.filter_map(|score| approach_spread(*condition, cases, conditions, score));
        let measured = ControllerScore::ALL.into_iter();
        let measured = measured.filter_map(|score| controller_spread(*condition, cases, conditions, score));
        counted.chain(near).chain(measured).collect::<Vec<_>>()
    };
    conditions.cases.iter().flat_map(scores).collect()
}

fn spread(condition: Condition, cases: &[Case], region: usize, score: Score) -> Option<ScoreSpread> {
    let each = cases.iter().enumerate().flat_map(|(case, of)| {
        let moments = of.counts[region].iter().enumerate();
        moments.filter_map(move |(moment, counts)| {
            Some((Ratio::from_score(score, counts)?, Where { case, part: Some(CasePart::Moment(moment)) }))
        })
    });
    let total = cases.iter().map(|case| case.counts[region].len()).sum();
    let is_better_less = score.less_is_better();
    sum(condition, Summed::Counted(score, region), each.collect(), total, is_better_less, |ratio| {
        ratio.value()
    })
}

fn approach_spread(
    condition: Condition,
    cases: &[Case],
    conditions: &Conditions,
    score: ApproachScore,
) -> Option<ScoreSpread> {
    let each = cases.iter().enumerate().flat_map(|(case, of)| {
        let passages = conditions.passages.iter().zip(&of.near).enumerate();
        let relevant = passages.filter(|(_, (passage, _))| passage.on_floor || !score.is_area());
        relevant.filter_map(move |(number, (_, near))| {
            let value = approach_value(score, near, conditions)?;
            Some((value, Where { case, part: Some(CasePart::Passage(number)) }))
        })
    });
    let values: Vec<_> = each.collect();
    let total = values.len();
    sum(condition, Summed::Nearness(score), values, total, score.is_area(), |value| value.number())
}

fn controller_spread(
    condition: Condition,
    cases: &[Case],
    conditions: &Conditions,
    score: ControllerScore,
) -> Option<ScoreSpread> {
    let each = cases.iter().enumerate().flat_map(|(case, of)| {
        let moments = of.measured.iter().enumerate();
        moments.filter_map(move |(moment, separation)| {
            let value = controller_value(score, separation, conditions)?;
            Some((value, Where { case, part: Some(CasePart::Moment(moment)) }))
        })
    });
    let total = cases.iter().map(|case| case.measured.len()).sum();
    sum(condition, Summed::Controller(score), each.collect(), total, true, |value| value.number())
}

fn sum<V: Ord>(
    condition: Condition,
    of_what: Summed,
    mut values: Vec<(V, Where)>,
    of: usize,
    is_better_less: bool,
    number: impl Fn(&V) -> f64,
) -> Option<ScoreSpread> {
    // Worst first. The sort is stable, so the first of equal ones stays first.
    values.sort_by(|a, b| if is_better_less { b.0.cmp(&a.0) } else { a.0.cmp(&b.0) });
    let ((worst, at), (best, _)) = (values.first()?, values.last()?);
    let sum: f64 = values.iter().map(|(value, _)| number(value)).sum();
    Some(ScoreSpread {
        condition,
        of_what,
        best: number(best),
        mean: sum / values.len() as f64,
        twentieth: number(&values[values.len().div_ceil(20) - 1].0),
        worst: number(worst),
        at: *at,
        values: values.len(),
        of,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use perirobot_march::metrics::Confusion;

    /// A case with this many unknown voxels of 100 at its moments.
    fn case(unknown: impl Iterator<Item = u64>) -> Case {
        let counts = |uf| Confusion { tn: 100 - uf, uf, ..Default::default() };
        Case { counts: vec![unknown.map(counts).collect()], ..Case::default() }
    }

    #[test]
    fn one_in_twenty_is_no_better() {
        let cases = vec![case((0..20).rev()), case(20..40)];
        let conditions =
            Conditions { cases: vec![(Condition::OneSensorDead, cases)], ..Conditions::default() };
        let all = spreads(&conditions);
        let unknown = all.iter().find(|spread| spread.of_what == Summed::Counted(Score::Unknown, 0)).unwrap();
        assert_eq!((unknown.best, unknown.worst), (0.0, 0.39));
        assert!((unknown.mean - 0.195).abs() < 1e-12, "{}", unknown.mean);
        // Two of forty: 39 and 38.
        assert_eq!((unknown.twentieth, unknown.values, unknown.of), (0.38, 40, 40));
        assert_eq!(unknown.at, Where { case: 1, part: Some(CasePart::Moment(19)) });
        // Nothing is occupied, so there is no person to see.
        assert!(all.iter().all(|spread| spread.of_what.name() != "human_seen"));
    }
}
