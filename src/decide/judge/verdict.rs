//! Whether a requirement is met under a condition, and where it is closest to being missed.

use super::cases::{Case, Conditions};
use super::value::Value;
use crate::approach::NearestApproach;
use crate::controller::{Decision, Excess, Separation};
use perirobot_march::metrics::{Confusion, Ratio};
use perirobot_study::input::{
    ApproachScore, Condition, ControllerScore, Counted, Limit, Measure, Requirement,
};
use perirobot_study::world::Baselines;

/// A requirement under a condition.
#[derive(Clone, Debug)]
pub struct Judgement<'a> {
    /// The requirement.
    pub requirement: &'a Requirement,
    /// The condition.
    pub condition: Condition,
    /// Whether all cases meet the limit.
    pub is_met: bool,
    /// The number of cases that miss it.
    pub failed: usize,
    /// The number of cases.
    pub cases: usize,
    /// The number of moments (or passages) of all cases with a value; the others are left out.
    pub values: usize,
    /// The number of moments (or passages) of all cases.
    pub of: usize,
    /// The number of cases with mounts that stay as planned because no draw was possible.
    pub kept: usize,
    /// The value of the case closest to missing the limit, or farthest beyond it; `None` if a case has no value, which
    /// counts as missed.
    pub value: Option<Value>,
    /// The worst case and its worst part.
    pub worst: Where,
    /// Whether there are several cases, and all moments of all have the same value, so that none is the worst.
    pub all_equal: bool,
    /// Upper bound over all choices of the listed poses, if it misses the limit.
    pub out_of_reach: Option<Value>,
}

/// A part of a case, by index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Where {
    /// Index of the case among those of its condition.
    pub case: usize,
    /// The part; `None` if the case has no value, or no body comes near.
    pub part: Option<CasePart>,
}

/// A part of a case, by index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CasePart {
    /// A moment.
    Moment(usize),
    /// A passage.
    Passage(usize),
}

impl Judgement<'_> {
    /// The verdict in a word.
    pub fn word(&self) -> &'static str {
        word(self.is_met)
    }
}

/// A verdict in a word.
pub(super) fn word(is_met: bool) -> &'static str {
    if is_met { "PASS" } else { "FAIL" }
}

/// Decides each requirement under each of its known conditions. `baselines` are those of each snapshot and region.
pub fn judgements<'a>(
    requirements: &'a [Requirement],
    baselines: &[Vec<Baselines>],
    conditions: &Conditions,
) -> Vec<Judgement<'a>> {
    let judge = |requirement: &'a Requirement| {
        let is_known = move |condition: &&Condition| {
            conditions.cases(**condition).first().is_some_and(|case| match requirement.measure {
                Measure::Counted(_) => true,
                Measure::Nearness(_) => !case.near.is_empty(),
                Measure::Controller(_) => !case.measured.is_empty(),
            })
        };
        let known = requirement.under.iter().filter(is_known);
        known.map(move |&condition| judgement(requirement, baselines, condition, conditions))
    };
    requirements.iter().flat_map(judge).collect()
}

fn judgement<'a>(
    requirement: &'a Requirement,
    baselines: &[Vec<Baselines>],
    condition: Condition,
    conditions: &Conditions,
) -> Judgement<'a> {
    let cases = conditions.cases(condition);
    let parts = |case: &Case| part_values(requirement, case, conditions);
    let values: Vec<Option<Value>> =
        cases.iter().map(|case| case_value(requirement, case, conditions)).collect();
    let is_met = |value: &Option<Value>| value.as_ref().is_some_and(|value| value.meets(&requirement.limit));
    let failed = values.iter().filter(|value| !is_met(value)).count();
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
    let part = worst_part(requirement, parts(&cases[worst]));
    let all: Vec<_> = cases.iter().flat_map(parts).map(|(_, value)| value).collect();
    let is_as_bad = |value: &Option<Value>| match (value, &all[0]) {
        (Some(one), Some(first)) => {
            !requirement.limit.is_worse(one, first) && !requirement.limit.is_worse(first, one)
        }
        (one, first) => one.is_none() && first.is_none(),
    };
    // Shifted mounts may see what no listed pose sees, and other people may be easier to see.
    let is_bound = !matches!(condition, Condition::MountingError | Condition::Postures);
    let bound = is_bound.then(|| best_possible(requirement, baselines)).flatten();
    Judgement {
        requirement,
        condition,
        is_met: failed == 0,
        failed,
        cases: cases.len(),
        values: all.iter().filter(|value| value.is_some()).count(),
        of: all.len(),
        kept: cases.iter().filter(|case| !case.kept.is_empty()).count(),
        value: values[worst].clone(),
        worst: Where { case: worst, part },
        all_equal: cases.len() > 1 && requirement.counted_score().is_some() && all.iter().all(is_as_bad),
        out_of_reach: bound.filter(|bound| !bound.meets(&requirement.limit)),
    }
}

/// The value of a case for a requirement.
fn case_value(requirement: &Requirement, case: &Case, conditions: &Conditions) -> Option<Value> {
    match &requirement.measure {
        Measure::Counted(counted) => counted_value(requirement, counted, &case.counts[counted.region]),
        Measure::Controller(ControllerScore::NeedlessStops) => needless_share(&case.measured, conditions),
        Measure::Nearness(_) | Measure::Controller(ControllerScore::MissedM) => {
            let each = part_values(requirement, case, conditions).into_iter().filter_map(|(_, value)| value);
            each.reduce(|old, new| if requirement.limit.is_worse(&new, &old) { new } else { old })
        }
    }
}

/// The value of counts for a requirement, moment by moment.
pub(super) fn counted_value(
    requirement: &Requirement,
    counted: &Counted,
    counts: &[Confusion],
) -> Option<Value> {
    Value::from_counts(counted.score, counted.over, &requirement.limit, counts)
}

/// The parts of a case that a requirement covers, with the value of each.
fn part_values(
    requirement: &Requirement,
    case: &Case,
    conditions: &Conditions,
) -> Vec<(CasePart, Option<Value>)> {
    match &requirement.measure {
        Measure::Counted(Counted { score, region, .. }) => {
            let moments = case.counts[*region].iter().enumerate();
            let value = |counts| Ratio::from_score(*score, counts).map(Value::from_ratio);
            moments.map(|(moment, counts)| (CasePart::Moment(moment), value(counts))).collect()
        }
        Measure::Nearness(nearness) => {
            let each = conditions.passages.iter().zip(&case.near).enumerate();
            let relevant = each.filter(|(_, (passage, _))| passage.is_asked(nearness));
            let value = |near| approach_value(nearness.score, near, conditions);
            relevant.map(|(number, (_, near))| (CasePart::Passage(number), value(near))).collect()
        }
        Measure::Controller(score) => {
            let moments = case.measured.iter().enumerate();
            let value = |separation| controller_value(*score, separation, conditions);
            moments.map(|(moment, separation)| (CasePart::Moment(moment), value(separation))).collect()
        }
    }
}

/// The worst part for a requirement; the first of several.
fn worst_part(requirement: &Requirement, parts: Vec<(CasePart, Option<Value>)>) -> Option<CasePart> {
    let each = parts.into_iter().filter_map(|(part, value)| Some((part, value?)));
    let worst = each.reduce(|old, new| if requirement.limit.is_worse(&new.1, &old.1) { new } else { old });
    // A body that never comes near has no way.
    let is_nowhere = |value: &Value| requirement.is_of_nearness() && matches!(value, Value::Endless);
    worst.filter(|(_, value)| !is_nowhere(value)).map(|(part, _)| part)
}

/// The best possible value over all choices of the listed poses.
fn best_possible(requirement: &Requirement, baselines: &[Vec<Baselines>]) -> Option<Value> {
    let counted = requirement.counted_score()?;
    let best: Vec<Confusion> = baselines.iter().map(|snapshot| snapshot[counted.region].ceiling).collect();
    // The ceiling maximises the score: for a limit on the other side the bound is unknown.
    let is_bound = matches!(requirement.limit, Limit::AtMost(_)) == counted.score.less_is_better();
    is_bound.then(|| counted_value(requirement, counted, &best)).flatten()
}

/// An approach score of a body; the edge of a voxel is rounded to nine decimals. `None` for a margin without a needed
/// distance.
pub(crate) fn approach_value(
    score: ApproachScore,
    near: &NearestApproach,
    conditions: &Conditions,
) -> Option<Value> {
    let edge = Ratio::from_f64(conditions.voxel_size_m);
    let in_m2 = |voxels: u64| Ratio {
        numerator: i128::from(voxels) * edge.numerator.pow(2),
        denominator: edge.denominator.pow(2),
    };
    let square = near.squared.map(|squared| in_m2(squared.into()));
    Some(match score {
        ApproachScore::NearestUnnoticedM => square.map_or(Value::Endless, Value::Root),
        ApproachScore::ApproachMarginM => {
            let needed = conditions.needed?.needed_distance();
            square.map_or(Value::Endless, |square| Value::Beyond(square, needed))
        }
        ApproachScore::UnnoticedM2 => Value::from_ratio(in_m2(near.unnoticed)),
        ApproachScore::JoinedM2 => Value::from_ratio(in_m2(near.joined)),
    })
}

/// A score of a controller's measurement at a moment, if defined.
pub(super) fn controller_value(
    score: ControllerScore,
    separation: &Separation,
    conditions: &Conditions,
) -> Option<Value> {
    let voxel_size_m = conditions.voxel_size_m;
    match score {
        ControllerScore::MissedM => {
            let truly = separation.truly?;
            let excess = |measured: u32| Excess { measured: measured.max(truly), truly, voxel_size_m };
            Some(separation.unknown_free.map_or(Value::Endless, |measured| Value::Excess(excess(measured))))
        }
        ControllerScore::NeedlessStops => {
            let Separation { truly, unknown_occupied, has_robot, .. } = *separation;
            if !has_robot {
                return None;
            }
            let decision = Decision::new(unknown_occupied, truly, conditions.needed?.needed_m, voxel_size_m);
            let numerator = i128::from(decision == Decision::NeedlessStop);
            Some(Value::from_ratio(Ratio { numerator, denominator: 1 }))
        }
    }
}

/// The share of moments with a robot in which it is stopped needlessly.
fn needless_share(measured: &[Separation], conditions: &Conditions) -> Option<Value> {
    let at = |separation| controller_value(ControllerScore::NeedlessStops, separation, conditions);
    let values: Vec<Value> = measured.iter().filter_map(at).collect();
    let stops = values.iter().filter(|value| value.cmp_ratio(Ratio::from_f64(0.0)).is_gt()).count();
    let denominator = values.len() as i128;
    (denominator > 0).then(|| Value::from_ratio(Ratio { numerator: stops as i128, denominator }))
}
