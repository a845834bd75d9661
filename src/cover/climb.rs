//! A good set, quickly: starting from nothing and from random sets, candidates are added and swapped one at a time
//! as long as that helps. Nothing is proven.

use std::cmp::Reverse;

use rand::SeedableRng;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use perirobot_march::metrics::Across;

use super::mean::bounds_means;
use super::problem::{FoundSet, JointCandidates, Merit, Problem};
use super::rules::SetLimits;

/// Random sets to start from, where the search is long; a short search finds what they lead to itself.
const RESTARTS: u64 = 12;
/// So few sensors besides the fixed ones are searched at once, without random starts.
const FEW: usize = 2;

/// The local optima reached from the fixed sensors and from random sets. Those that meet every
/// requirement, the best first.
pub(super) fn climbs(
    problem: &Problem,
    limits: SetLimits,
    stop: &(dyn Fn() -> bool + Sync),
) -> Vec<FoundSet> {
    let mut ends: Vec<FoundSet> =
        climb(problem, limits, problem.rules.always.clone(), stop).into_iter().collect();
    let is_short = limits.at_most - problem.rules.always.len() <= FEW
        && (problem.goal.1 != Across::Mean || bounds_means(problem))
        && !problem.adds_up();
    // Reading all rows from a file again and again takes too long.
    let restarts = if is_short || problem.evidence.is_filed() { 0 } else { RESTARTS };
    for restart in 0..restarts {
        if stop() {
            break;
        }
        let mut random = ChaCha8Rng::seed_from_u64(restart);
        let mut set = problem.rules.always.clone();
        while set.len() < limits.at_most {
            let Some(&item) = joining(problem, limits, &set).choose(&mut random) else { break };
            set.push(item);
        }
        ends.extend(climb(problem, limits, set, stop));
    }
    ends.sort_by(|a, b| {
        b.worth.cmp(&a.worth).then(cost(problem, a).cmp(&cost(problem, b))).then(a.set.cmp(&b.set))
    });
    ends.dedup();
    ends
}

fn cost(problem: &Problem, found: &FoundSet) -> u64 {
    problem.rules.cost_of(&found.set)
}

/// The candidates that may join a set.
fn joining(problem: &Problem, limits: SetLimits, set: &[usize]) -> Vec<usize> {
    let cost = problem.rules.cost_of(set);
    let may =
        |&item: &usize| limits.afford(cost + problem.rules.cost[item]) && problem.rules.may_join(set, item);
    (0..problem.rules.cost.len()).filter(may).collect()
}

/// Adds and swaps as long as that helps.
pub(super) fn climb(
    problem: &Problem,
    limits: SetLimits,
    mut set: Vec<usize>,
    stop: &(dyn Fn() -> bool + Sync),
) -> Option<FoundSet> {
    let mut merit = problem.merit(&problem.joint(&set), None);
    while !stop() {
        let Some((better, item, out)) = best_step(problem, limits, &set).filter(|step| step.0 > merit) else {
            break;
        };
        merit = better;
        out.map(|out| set.remove(out));
        set.push(item);
    }
    set.sort_unstable();
    merit.worth.filter(|_| merit.meets_all() && !set.is_empty()).map(|worth| FoundSet { set, worth })
}

/// The best candidate to join a set, or to stand for one of its sensors that is not fixed: how good the set then
/// is, and which place is taken out. What a candidate says is looked up once for all of them.
fn best_step(problem: &Problem, limits: SetLimits, set: &[usize]) -> Option<(Merit, usize, Option<usize>)> {
    let may_go = (0..set.len()).filter(|&place| !problem.rules.always.contains(&set[place])).map(Some);
    let outs = std::iter::once(None).filter(|_| set.len() < limits.at_most).chain(may_go);
    let base = |out: Option<usize>| {
        let mut rest = set.to_vec();
        out.map(|out| rest.remove(out));
        let mut may_join = vec![false; problem.rules.cost.len()];
        joining(problem, limits, &rest).into_iter().for_each(|item| may_join[item] = true);
        (out, problem.joint(&rest), may_join)
    };
    let bases: Vec<_> = outs.map(base).collect();
    let of = |item: usize| {
        let mut open = bases.iter().filter(|(.., may_join)| may_join[item]).peekable();
        open.peek()?;
        let row = problem.evidence.row(item);
        // Of equally good ones the last place, then the cheapest and the first candidate.
        let key = |(out, base, _): &(Option<usize>, JointCandidates, Vec<bool>)| {
            (problem.merit(base, Some((item, &row))), *out, Reverse(problem.rules.cost[item]), Reverse(item))
        };
        open.map(key).max()
    };
    let best = (0..problem.rules.cost.len()).into_par_iter().filter_map(of).max();
    best.map(|(merit, out, _, Reverse(item))| (merit, item, out))
}
