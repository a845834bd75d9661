//! The best set of each size and each step of cost.

use super::pairs::PairCounts;
use super::problem::{FoundSet, Problem};
use super::rules::SetLimits;
use super::step::{Bound, FrontStep, KnownSets, StepSearch, best_within, overlaps};
use super::worth::Worth;
use perirobot_march::Error;
use perirobot_march::progress::Progress;

/// The answer to a study's question.
#[derive(Clone, Debug, Default)]
pub struct FrontAnswer {
    /// The steps by size, and of each size from the whole budget down.
    pub steps: Vec<FrontStep>,
    /// Every set that was judged on the way to one of them, with its worth.
    pub others: Vec<FoundSet>,
    /// Whether the search ended by itself.
    pub complete: bool,
}

/// Why there is no answer.
#[derive(Debug)]
pub enum NoAnswer {
    /// The search was stopped before a set was found.
    Stopped,
    /// No set meets this requirement, by its number.
    Required {
        /// Which of the requirements.
        number: usize,
        /// The best worth by its score, if any set has a value.
        best: Option<Worth>,
        /// Whether no set is worth more.
        is_proven: bool,
    },
    /// Each requirement can be met, but no set was found that meets all and has a value of the goal.
    Together,
    /// Evidence could not be read.
    Unread(Error),
}

/// The best set of each size, and of each step of cost below the budget where there are costs. First each gets
/// a good set and a bound, then all are searched to the end. When it is stopped, the steps that were not begun
/// are left out.
///
/// # Errors
/// When no set meets the requirements; when evidence in a file cannot be read.
pub fn answer(problem: &Problem, progress: &dyn Progress) -> Result<FrontAnswer, NoAnswer> {
    let stop = || progress.stops();
    let kept = overlaps(problem);
    let mut known = KnownSets::new();
    let mut steps: Vec<StepSearch> = Vec::new();
    for size in problem.rules.always.len().max(1)..=problem.limits.at_most {
        let limits = SetLimits { at_most: size, ..problem.limits };
        let of_size = descend(Vec::new(), problem, limits, kept.as_ref(), &mut known, progress);
        let is_last = size == problem.limits.at_most;
        if is_last && !stop() && of_size.first().is_none_or(|first| first.step.best.is_none()) {
            return Err(no_set(problem, progress));
        }
        steps.extend(of_size);
        if stop() {
            break;
        }
    }
    let mut at = 0;
    while at < steps.len() && !stop() {
        if steps[at].is_open() {
            let before = steps[at].cost();
            steps[at].end(&mut known);
            if steps[at].cost() != before && !stop() {
                // The steps of lower cost begin elsewhere.
                let limits = steps[at].step.limits;
                let after = steps[at + 1..].iter().position(|s| s.step.limits.at_most != limits.at_most);
                let end = after.map_or(steps.len(), |after| at + 1 + after);
                let own = steps.drain(at..end).next().into_iter().collect();
                let anew = descend(own, problem, limits, kept.as_ref(), &mut known, progress);
                steps.splice(at..at, anew);
            }
        }
        at += 1;
    }
    problem.evidence.was_read().map_err(NoAnswer::Unread)?;
    // What one search has found may be the best within the limits of another.
    steps.iter_mut().for_each(|search| search.refresh(&known));
    steps.retain(|search| search.step.best.is_some());
    steps.dedup_by(|cheaper, dearer| merge(dearer, cheaper));
    let steps = steps.into_iter().map(|search| search.step).collect();
    let others = known.into_iter().map(|(set, worth)| FoundSet { set, worth }).collect();
    Ok(FrontAnswer { steps, others, complete: !stop() })
}

/// The steps of one size, from the limits down, after one that is there already, if any.
fn descend<'a>(
    mut steps: Vec<StepSearch<'a>>,
    problem: &'a Problem<'a>,
    mut limits: SetLimits,
    kept: Option<&'a PairCounts>,
    known: &mut KnownSets,
    progress: &'a dyn Progress,
) -> Vec<StepSearch<'a>> {
    loop {
        if let Some(best) = steps.last().map(|last| &last.step.best) {
            // A cheaper set of the same worth would have been taken, so all cheaper ones are worth less.
            let cost = best.as_ref().map(|best| problem.rules.cost_of(&best.set));
            match cost.filter(|&cost| cost > 0 && !progress.stops()) {
                Some(cost) => limits.budget = Some(problem.rules.largest_cost_below(cost)),
                None => return steps,
            }
        }
        if !limits.afford(problem.rules.cost_of(&problem.rules.always)) {
            return steps;
        }
        // What pays for fewer sensors only is a step of theirs.
        if !steps.is_empty() && problem.rules.most_affordable(limits) < limits.at_most {
            return steps;
        }
        let mut next = StepSearch::begun(problem, limits, kept, known, progress);
        if next.step.best.is_none() && next.is_open() && !progress.stops() {
            next.end(known);
        }
        if !steps.last_mut().is_some_and(|last| merge(last, &mut next)) {
            steps.push(next);
        }
    }
}

/// Gives a step the best set of the next one of its size, if that costs less and is worth as much.
fn merge(dearer: &mut StepSearch, cheaper: &mut StepSearch) -> bool {
    let is_same = dearer.step.limits.at_most == cheaper.step.limits.at_most
        && dearer.worth().is_some()
        && dearer.worth() == cheaper.worth();
    if is_same {
        dearer.step.best = cheaper.step.best.take();
    }
    is_same
}

/// Why there is no set: the first requirement that none can meet, with the best that can be had.
fn no_set(problem: &Problem, progress: &dyn Progress) -> NoAnswer {
    for (number, &(score, over, least)) in problem.require.iter().enumerate() {
        let alone = problem.asking(score, over);
        let (kept, mut known) = (overlaps(&alone), KnownSets::new());
        let FrontStep { best, bound, .. } =
            best_within(&alone, problem.limits, kept.as_ref(), &mut known, progress);
        if progress.stops() {
            return NoAnswer::Stopped;
        }
        if !best.as_ref().is_some_and(|best| best.worth.reaches(least)) {
            let (best, is_proven) = (best.map(|best| best.worth), bound == Bound::Proven);
            return NoAnswer::Required { number, best, is_proven };
        }
    }
    NoAnswer::Together
}
