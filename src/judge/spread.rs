//! How good scores are under a condition: best, mean, the value that one in twenty is no better than, worst.

use super::cases::{Case, Conditions};
use super::verdict::Where;
use crate::metrics::{Ratio, Score};
use crate::study::Condition;

/// A score in a region over all cases and moments of a condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// The condition.
    pub condition: Condition,
    /// Index of the region.
    pub region: usize,
    /// The score.
    pub score: Score,
    /// The best value.
    pub best: f64,
    /// The mean of all values.
    pub mean: f64,
    /// The best of the worst twentieth of the values, rounded up: the 5 % quantile by nearest rank.
    pub twentieth: f64,
    /// The worst value.
    pub worst: f64,
    /// Where the worst value is; the first of several.
    pub at: Where,
    /// How many values there are.
    pub values: usize,
    /// How many there would be if every moment of every case had one.
    pub of: usize,
}

/// What each score is in each region under each condition; scores without a value are left out.
pub fn spreads(conditions: &Conditions) -> Vec<Spread> {
    let regions = |cases: &[Case]| cases.first().map_or(0, |case| case.counts.len());
    let of = |(condition, cases): &(Condition, Vec<Case>)| {
        let parts = (0..regions(cases)).flat_map(|region| Score::ALL.map(|score| (region, score)));
        parts.filter_map(|(region, score)| spread(*condition, cases, region, score)).collect::<Vec<_>>()
    };
    conditions.cases.iter().flat_map(of).collect()
}

fn spread(condition: Condition, cases: &[Case], region: usize, score: Score) -> Option<Spread> {
    let each = cases.iter().enumerate().flat_map(|(case, of)| {
        let moments = of.counts[region].iter().enumerate();
        moments.filter_map(move |(moment, counts)| {
            Some((Ratio::of_score(score, counts)?, Where { case, moment: Some(moment) }))
        })
    });
    let mut values: Vec<(Ratio, Where)> = each.collect();
    // The worst first. The sort is stable, so that of equal ones the first is kept.
    values.sort_by(|a, b| if score.less_is_better() { b.0.cmp(&a.0) } else { a.0.cmp(&b.0) });
    let (&(worst, at), &(best, _)) = (values.first()?, values.last()?);
    let sum: f64 = values.iter().map(|(value, _)| value.value()).sum();
    Some(Spread {
        condition,
        region,
        score,
        best: best.value(),
        mean: sum / values.len() as f64,
        twentieth: values[values.len().div_ceil(20) - 1].0.value(),
        worst: worst.value(),
        at,
        values: values.len(),
        of: cases.iter().map(|case| case.counts[region].len()).sum(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::judge::Alteration;
    use crate::metrics::Confusion;

    /// A case with so many unknown voxels of 100 at its moments.
    fn case(unknown: impl Iterator<Item = u64>) -> Case {
        let counts = |uf| Confusion { tn: 100 - uf, uf, ..Default::default() };
        Case { alteration: Alteration::None, kept: Vec::new(), counts: vec![unknown.map(counts).collect()] }
    }

    #[test]
    fn one_in_twenty_is_no_better() {
        let cases = vec![case((0..20).rev()), case(20..40)];
        let conditions = Conditions { moments: Vec::new(), cases: vec![(Condition::OneSensorDead, cases)] };
        let all = spreads(&conditions);
        let unknown = all.iter().find(|spread| spread.score == Score::Unknown).unwrap();
        assert_eq!((unknown.best, unknown.worst), (0.0, 0.39));
        assert!((unknown.mean - 0.195).abs() < 1e-12, "{}", unknown.mean);
        // Two of forty: 39 and 38.
        assert_eq!((unknown.twentieth, unknown.values, unknown.of), (0.38, 40, 40));
        assert_eq!(unknown.at, Where { case: 1, moment: Some(19) });
        // Nothing is occupied, so there is nobody to be seen.
        assert!(all.iter().all(|spread| spread.score != Score::HumanSeen));
    }
}
