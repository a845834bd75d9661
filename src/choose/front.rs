//! The best set of each size and each step of cost.

use std::collections::BTreeMap;
use std::time::Instant;

use super::climb::{climb, climbs};
use super::problem::{Found, Problem, SetLimits};
use super::search::{Outcome, search};
use super::worth::Worth;
use crate::error::Issue;
use crate::study::Across;
use crate::{Error, Result};

/// What is known of all sets within some limits.
#[derive(Clone, Debug)]
pub struct FrontStep {
    /// The limits.
    pub limits: SetLimits,
    /// The best set that was found; none is worth more if that is proven.
    pub best: Option<Found>,
    /// What no set is worth more than.
    pub bound: Bound,
}

/// What no set is worth more than.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// The best set: all others were searched.
    Proven,
    /// This; the search was stopped.
    AtMost(f64),
    /// Nothing is known.
    Unknown,
}

/// The answer to a study's question.
#[derive(Clone, Debug, Default)]
pub struct Answer {
    /// The steps by size, and of each size from the whole budget down.
    pub steps: Vec<FrontStep>,
    /// Every set that was judged on the way to one of them, with its worth.
    pub others: Vec<Found>,
    /// Whether the search was not stopped.
    pub complete: bool,
}

/// The best set of each size, and of each step of cost below the budget where there are costs. When it is
/// stopped, the steps that were not begun are left out.
///
/// # Errors
/// When no set meets the requirements.
pub fn answer(problem: &Problem, stop: &(dyn Fn() -> bool + Sync)) -> Result<Answer> {
    let mut known: BTreeMap<Vec<usize>, Worth> = BTreeMap::new();
    let mut steps: Vec<FrontStep> = Vec::new();
    for size in problem.always.len().max(1)..=problem.limits.at_most {
        let mut limits = SetLimits { at_most: size, ..problem.limits };
        let mut last: Option<Worth> = None;
        while limits.afford(problem.cost_of(&problem.always)) {
            let step = best_within(problem, limits, &mut known, stop);
            let cost = step.best.as_ref().map(|best| problem.cost_of(&best.set));
            let is_last = size == problem.limits.at_most && limits == problem.limits;
            if is_last && step.best.is_none() && !stop() {
                return Err(no_set(problem, stop));
            }
            let worth = step.best.as_ref().map(|best| best.worth);
            match steps.last_mut().filter(|_| worth.is_some() && worth == last) {
                // As good for less.
                Some(dearer) => dearer.best = step.best,
                None => steps.push(step),
            }
            last = worth;
            // Any set that costs less is worth less, or it would have been taken.
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

/// The best set within some limits. What is known is begun from, and what is found is added.
fn best_within(
    problem: &Problem,
    limits: SetLimits,
    known: &mut BTreeMap<Vec<usize>, Worth>,
    stop: &(dyn Fn() -> bool + Sync),
) -> FrontStep {
    let begin = Instant::now();
    for found in climbs(problem, limits, stop) {
        known.insert(found.set, found.worth);
    }
    let fits = |set: &Vec<usize>| set.len() <= limits.at_most && limits.afford(problem.cost_of(set));
    let better = |a: &Found, b: &Found| {
        let key = |found: &Found| (found.worth, std::cmp::Reverse(problem.cost_of(&found.set)));
        key(a).cmp(&key(b)).then(b.set.len().cmp(&a.set.len())).then(b.set.cmp(&a.set))
    };
    let all =
        known.iter().filter(|(set, _)| fits(set)).map(|(set, &worth)| Found { set: set.clone(), worth });
    let mut best = all.max_by(better);
    if problem.goal.1 == Across::Mean {
        return FrontStep { limits, best, bound: Bound::Unknown };
    }
    loop {
        let seconds = begin.elapsed().as_secs_f64();
        let (most, worth) = (limits.at_most, best.as_ref().map_or(f64::NAN, |best| best.worth.value()));
        tracing::info!(
            "choose: sets of at most {most}: {worth:.6} is to be beaten, {seconds:.1} s after its begin"
        );
        match search(problem, limits, best.as_ref().map(|best| best.worth), stop) {
            Outcome::Better(found) => {
                let further = climb(problem, limits, found.set.clone(), stop);
                known.insert(found.set.clone(), found.worth);
                let found = further.filter(|further| further.worth > found.worth).unwrap_or(found);
                known.insert(found.set.clone(), found.worth);
                best = Some(found);
            }
            Outcome::None => {
                let seconds = begin.elapsed().as_secs_f64();
                tracing::info!("choose: sets of at most {most}: proven after {seconds:.1} s");
                return FrontStep { limits, best, bound: Bound::Proven };
            }
            Outcome::Stopped(bound) => {
                let bound = bound.map_or(Bound::Unknown, Bound::AtMost);
                return FrontStep { limits, best, bound };
            }
        }
    }
}

/// What helps where no set is good enough.
const CURE: &str = "ask for less, or allow more sensors";

/// Why there is no set: the first requirement that none can meet, with the best that can be had.
fn no_set(problem: &Problem, stop: &(dyn Fn() -> bool + Sync)) -> Error {
    for (number, &(score, over, least)) in problem.require.iter().enumerate() {
        let alone = problem.asking(score, over);
        let FrontStep { best, bound, .. } = best_within(&alone, problem.limits, &mut BTreeMap::new(), stop);
        if stop() {
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
