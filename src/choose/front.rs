//! The best set of each size and each step of cost.

use std::collections::BTreeMap;

use super::problem::{Found, Problem, SetLimits};
use super::within::{Bound, FrontStep, SearchWatch, best_within, overlaps};
use super::worth::Worth;
use crate::error::Issue;
use crate::{Error, Result};

/// The answer to a study's question.
#[derive(Clone, Debug, Default)]
pub struct Answer {
    /// The steps by size, and of each size from the whole budget down.
    pub steps: Vec<FrontStep>,
    /// Every set that was judged on the way to one of them, with its worth.
    pub others: Vec<Found>,
    /// Whether the search ended by itself.
    pub complete: bool,
}

/// The best set of each size, and of each step of cost below the budget where there are costs. When it is
/// stopped, the steps that were not begun are left out.
///
/// # Errors
/// When no set meets the requirements.
pub fn answer(problem: &Problem, watch: &dyn SearchWatch) -> Result<Answer> {
    let stop = || watch.stops();
    let mut known: BTreeMap<Vec<usize>, Worth> = BTreeMap::new();
    let mut steps: Vec<FrontStep> = Vec::new();
    let kept = overlaps(problem);
    for size in problem.always.len().max(1)..=problem.limits.at_most {
        let mut limits = SetLimits { at_most: size, ..problem.limits };
        let mut last: Option<Worth> = None;
        while limits.afford(problem.cost_of(&problem.always)) {
            let step = best_within(problem, limits, kept.as_ref(), &mut known, watch);
            let cost = step.best.as_ref().map(|best| problem.cost_of(&best.set));
            let is_last = size == problem.limits.at_most && limits == problem.limits;
            if is_last && step.best.is_none() && !stop() {
                return Err(no_set(problem, watch));
            }
            let worth = step.best.as_ref().map(|best| best.worth);
            match steps.last_mut().filter(|_| worth.is_some() && worth == last) {
                // This set costs less and is worth as much.
                Some(dearer) => dearer.best = step.best,
                None => steps.push(step),
            }
            last = worth;
            // A cheaper set of the same worth would have been taken, so all cheaper ones are worth less.
            let next = cost.filter(|&cost| cost > 0 && !stop()).map(|cost| cost - 1);
            match next {
                Some(budget) => limits.budget = Some(budget),
                None => break,
            }
        }
        if stop() {
            break;
        }
    }
    steps.retain(|step| step.best.is_some());
    let others = known.into_iter().map(|(set, worth)| Found { set, worth }).collect();
    Ok(Answer { steps, others, complete: !stop() })
}

/// What helps where no set is good enough.
const CURE: &str = "ask for less, or allow more sensors";

/// Why there is no set: the first requirement that none can meet, with the best that can be had.
fn no_set(problem: &Problem, watch: &dyn SearchWatch) -> Error {
    for (number, &(score, over, least)) in problem.require.iter().enumerate() {
        let alone = problem.asking(score, over);
        let FrontStep { best, bound, .. } =
            best_within(&alone, problem.limits, overlaps(&alone).as_ref(), &mut BTreeMap::new(), watch);
        if watch.stops() {
            return Error::Stopped(Issue::says("no set was found that meets the requirements so far"));
        }
        if !best.as_ref().is_some_and(|best| best.worth.reaches(least)) {
            let (name, over, least) = (score.name(), over.name(), least.value());
            let most = best.map_or("has no value".into(), |best| {
                let known = if bound == Bound::Proven { "at most" } else { "in the best set found" };
                format!("is {:.4} {known}", best.worth.value())
            });
            return Error::input(
                format!("choose.require[{number}]"),
                format!("no allowed set reaches {name} {least} ({over}): it {most}"),
            )
            .cure(CURE);
        }
    }
    let what = match problem.require.is_empty() {
        true => "no allowed set has a value of the objective",
        false => "each of them can be met, but no allowed set meets all of them",
    };
    let key = if problem.require.is_empty() { "choose.objective" } else { "choose.require" };
    Error::input(key, what).cure(CURE)
}
