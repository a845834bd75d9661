//! The best set within some limits: local search, improvement by two sensors at a time, then branch and bound.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::climb::{climb, climbs};
use super::gap::{Gap, GapSearch};
use super::pairs::PairCounts;
use super::problem::{Found, Problem, SetLimits};
use super::question::question;
use super::search::{Ahead, complete, search};
use super::worth::{Ratio, Worth};
use crate::study::Across;

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
#[derive(Clone, Debug, PartialEq)]
pub enum Bound {
    /// The best set: all others were searched.
    Proven,
    /// A bound by cuts; the search was stopped.
    AtMost(Gap),
    /// Nothing is known.
    Unknown,
}

/// Is told how a search proceeds, and may stop it.
pub trait SearchWatch: Sync {
    /// Whether the search is to end.
    fn stops(&self) -> bool;

    /// The best worth found so far within some limits.
    fn finds(&self, _: &SetLimits, _: Option<f64>) {}
}

/// Only stops a search; progress is ignored.
impl<F: Fn() -> bool + Sync> SearchWatch for F {
    fn stops(&self) -> bool {
        self()
    }
}

/// The time of branch and bound before a bound by cuts is computed.
const SHORT: Duration = Duration::from_secs(3);

/// How many of the best results of climbing are improved by changing two sensors at a time.
const POLISHED: usize = 3;

/// The overlaps of all candidates, as far as a problem needs them, if they can be kept.
pub(super) fn overlaps(problem: &Problem) -> Option<PairCounts> {
    let anything = Worth::Exact(Ratio { numerator: 1, denominator: 2 });
    PairCounts::new(problem.evidence, &question(problem, Some(anything)).all)
}

/// The best set within some limits. What is known is begun from, and what is found is added.
pub(super) fn best_within(
    problem: &Problem,
    limits: SetLimits,
    kept: Option<&PairCounts>,
    known: &mut BTreeMap<Vec<usize>, Worth>,
    watch: &dyn SearchWatch,
) -> FrontStep {
    let (begin, stop) = (Instant::now(), &|| watch.stops());
    watch.finds(&limits, None);
    let mut ends = climbs(problem, limits, stop);
    ends.truncate(POLISHED);
    for found in ends {
        let found = polished(problem, limits, kept, found, stop);
        known.insert(found.set, found.worth);
    }
    let fits = |set: &Vec<usize>| set.len() <= limits.at_most && limits.afford(problem.cost_of(set));
    let better = |a: &Found, b: &Found| {
        let key = |found: &Found| (found.worth, std::cmp::Reverse(problem.cost_of(&found.set)));
        key(a).cmp(&key(b)).then(b.set.len().cmp(&a.set.len())).then(b.set.cmp(&a.set))
    };
    let all =
        known.iter().filter(|(set, _)| fits(set)).map(|(set, &worth)| Found { set: set.clone(), worth });
    let best = all.max_by(better);
    if problem.goal.1 == Across::Mean {
        return FrontStep { limits, best, bound: Bound::Unknown };
    }
    let told = |best: Option<&Found>, what: &str| {
        let (most, seconds) = (limits.at_most, begin.elapsed().as_secs_f64());
        let worth = best.map(|best| best.worth.value());
        watch.finds(&limits, worth);
        let worth = worth.unwrap_or(f64::NAN);
        tracing::info!("choose: sets of at most {most}: {worth:.6} {what} after {seconds:.1} s");
    };
    told(best.as_ref(), "is to be beaten");
    let mut improve = |found: Found| {
        known.insert(found.set.clone(), found.worth);
        let further = polished(problem, limits, kept, found, stop);
        known.insert(further.set.clone(), further.worth);
        told(Some(&further), "is to be beaten");
        further
    };
    // A long search may be stopped by the user, so a bound is computed before it goes on.
    let (mut ahead, searching) = (Ahead::default(), Instant::now());
    let pause = || stop() || searching.elapsed() > SHORT;
    let (mut best, mut is_proven) = search(problem, limits, best, kept, &mut ahead, &pause, &mut improve);
    let mut bound = Bound::Unknown;
    if !is_proven && !stop() {
        if let Some(best) = &best
            && let Some(gap) = GapSearch::new(problem, limits, stop).run(best.worth)
        {
            tracing::info!("choose: no set of at most {} is above {:.6}", limits.at_most, gap.above());
            bound = Bound::AtMost(gap);
        }
        (best, is_proven) = search(problem, limits, best, kept, &mut ahead, stop, &mut improve);
    }
    told(best.as_ref(), if is_proven { "is proven" } else { "is not proven" });
    FrontStep { limits, best, bound: if is_proven { Bound::Proven } else { bound } }
}

/// Changes one or two sensors of a set as long as that helps.
pub(super) fn polished(
    problem: &Problem,
    limits: SetLimits,
    kept: Option<&PairCounts>,
    mut best: Found,
    stop: &(dyn Fn() -> bool + Sync),
) -> Found {
    loop {
        best = climb(problem, limits, best.set.clone(), stop)
            .filter(|other| other.worth > best.worth)
            .unwrap_or(best);
        let places: Vec<usize> =
            (0..best.set.len()).filter(|&i| !problem.always.contains(&best.set[i])).collect();
        let pairs = places.iter().flat_map(|&a| places.iter().filter(move |&&b| b > a).map(move |&b| [a, b]));
        let without = |out: [usize; 2]| -> Vec<usize> {
            (0..best.set.len()).filter(|i| !out.contains(i)).map(|i| best.set[i]).collect()
        };
        let better =
            pairs.into_iter().find_map(|out| complete(problem, limits, &without(out), &best, kept, stop));
        match better {
            Some(better) => best = better,
            None => return best,
        }
    }
}
