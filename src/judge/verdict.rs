//! Whether a requirement is met under a condition, and where it is nearest to being missed.

use super::cases::{Case, Conditions};
use super::value::Value;
use crate::metrics::{Confusion, Ratio};
use crate::study::{Condition, Limit, Requirement};
use crate::world::Baselines;

/// A requirement under a condition.
#[derive(Clone, Debug)]
pub struct Judgement<'a> {
    /// What is required.
    pub requirement: &'a Requirement,
    /// When.
    pub condition: Condition,
    /// Whether all cases keep to the limit.
    pub is_met: bool,
    /// How many cases do not.
    pub failed: usize,
    /// How many cases there are.
    pub cases: usize,
    /// How many moments of all cases have a value; the others are left out.
    pub values: usize,
    /// How many moments all cases have together.
    pub of: usize,
    /// How many cases have mounts that were to be drawn and are as planned.
    pub kept: usize,
    /// The value in the case that is nearest to missing the limit, or misses it furthest; `None` where a case has
    /// no value, which is then missed.
    pub value: Option<Value>,
    /// Which case and moment that is.
    pub worst: Where,
    /// What no choice of the listed poses can exceed, where that misses the limit.
    pub out_of_reach: Option<Value>,
}

/// A moment of a case, by their numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Where {
    /// Number of the case among those of its condition.
    pub case: usize,
    /// Number of the moment; `None` where the case has no value.
    pub moment: Option<usize>,
}

impl Judgement<'_> {
    /// The verdict in a word.
    pub fn word(&self) -> &'static str {
        if self.is_met { "PASS" } else { "FAIL" }
    }
}

/// Decides each requirement under each of its conditions that is known. `baselines` are those of each snapshot and
/// region.
pub fn judgements<'a>(
    requirements: &'a [Requirement],
    baselines: &[Vec<Baselines>],
    conditions: &Conditions,
) -> Vec<Judgement<'a>> {
    let of = |requirement: &'a Requirement| {
        let known = requirement.under.iter().filter(|condition| !conditions.of(**condition).is_empty());
        known.map(move |&condition| judgement(requirement, baselines, condition, conditions.of(condition)))
    };
    requirements.iter().flat_map(of).collect()
}

fn judgement<'a>(
    requirement: &'a Requirement,
    baselines: &[Vec<Baselines>],
    condition: Condition,
    cases: &[Case],
) -> Judgement<'a> {
    let value = |case: &Case| requirement.value(&case.counts[requirement.region]);
    let values: Vec<Option<Value>> = cases.iter().map(value).collect();
    let is_met = |value: &Option<Value>| value.as_ref().is_some_and(|value| requirement.limit.is_met(value));
    let failed = values.iter().filter(|value| !is_met(value)).count();
    let moments = || cases.iter().flat_map(|case| &case.counts[requirement.region]);
    let mut worst = 0;
    for (case, value) in values.iter().enumerate() {
        let is_worse = match (value, &values[worst]) {
            (Some(new), Some(old)) => requirement.limit.is_worse(new, old),
            (new, old) => new.is_none() && old.is_some(),
        };
        if is_worse {
            worst = case;
        }
    }
    let moment = requirement.worst_moment(&cases[worst].counts[requirement.region]);
    // Mounts that are off may see what no listed pose does.
    let bound = (condition != Condition::MountingError).then(|| requirement.bound(baselines)).flatten();
    Judgement {
        requirement,
        condition,
        is_met: failed == 0,
        failed,
        cases: cases.len(),
        values: moments().filter(|counts| Ratio::of_score(requirement.score, counts).is_some()).count(),
        of: moments().count(),
        kept: cases.iter().filter(|case| !case.kept.is_empty()).count(),
        value: values[worst].clone(),
        worst: Where { case: worst, moment },
        out_of_reach: bound.filter(|bound| !requirement.limit.is_met(bound)),
    }
}

impl Requirement {
    /// What counts are worth, moment by moment.
    pub(super) fn value(&self, counts: &[Confusion]) -> Option<Value> {
        Value::of(self.score, self.over, &self.limit, counts)
    }

    /// The best that any choice of the listed poses could have.
    fn bound(&self, baselines: &[Vec<Baselines>]) -> Option<Value> {
        let best: Vec<Confusion> = baselines.iter().map(|snapshot| snapshot[self.region].ceiling).collect();
        // The ceiling is the best by the score: of a limit on the wrong side nothing is known.
        let is_bound = matches!(self.limit, Limit::AtMost(_)) == self.score.less_is_better();
        is_bound.then(|| self.value(&best)).flatten()
    }

    /// The moment that is worst by the score; the first of several.
    fn worst_moment(&self, counts: &[Confusion]) -> Option<usize> {
        let each = counts.iter().map(|counts| Ratio::of_score(self.score, counts)).enumerate();
        let each = each.filter_map(|(moment, ratio)| Some((moment, ratio?)));
        let worst = each.reduce(|old, new| if self.limit.is_worse(&new.1, &old.1) { new } else { old });
        worst.map(|(moment, _)| moment)
    }
}
