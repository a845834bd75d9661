//! A set that passes, not much dearer than it must be: candidates are added where they help most for what they cost, and
//! those that turn out not to be needed are dropped, the dearest first.

use super::TestAnswer;
use super::search::Search;
use super::share::ShareStates;
use perirobot_march::{Error, Result};

/// A set that passes, if it is found so.
pub(super) fn passing_set(search: &mut Search) -> Result<Option<Vec<usize>>> {
    let rules = search.problem.rules;
    let all: Vec<usize> = (0..rules.cost.len()).collect();
    let mut set = rules.always.clone();
    loop {
        if search.is_stopped() {
            return Ok(None);
        }
        let allowed = search.may_join(&set, &all);
        let asked = (&search.bounds[..], &search.demands[..], search.first);
        let Ok(states) = ShareStates::new(asked, (rules, search.problem.limits), &set, &allowed) else {
            return Ok(None);
        };
        let lacks_demands = search.demands.iter().any(|demand| demand.lacks(&set) > 0);
        if !lacks_demands && !states.surely_fails() {
            let answer = match search.test(&set) {
                Err(Error::Stopped(_)) => return Ok(None),
                answer => answer?,
            };
            match answer {
                TestAnswer::Passes => return drop_needless(search, set).map(Some),
                TestAnswer::Lacks(_) => continue,
                TestAnswer::Fails => {}
            }
        }
        let per_cost = |place: usize| states.helps(place) / (rules.cost[allowed[place]] as f64 + 1.0);
        let best = (0..allowed.len()).max_by(|&a, &b| per_cost(a).total_cmp(&per_cost(b)).then(b.cmp(&a)));
        match best {
            Some(place) => set.push(allowed[place]),
            None => return Ok(None),
        }
    }
}

/// The set without members that it passes without, the dearest first.
fn drop_needless(search: &mut Search, mut set: Vec<usize>) -> Result<Vec<usize>> {
    let rules = search.problem.rules;
    let mut order: Vec<usize> = set.iter().copied().filter(|item| !rules.always.contains(item)).collect();
    order.sort_by_key(|&item| std::cmp::Reverse((rules.cost[item], item)));
    for item in order {
        let without: Vec<usize> = set.iter().copied().filter(|&other| other != item).collect();
        let fits = search.demands.iter().all(|demand| demand.lacks(&without) == 0);
        if !fits {
            continue;
        }
        let answer = match search.test(&without) {
            Err(Error::Stopped(_)) => break,
            answer => answer?,
        };
        if answer == TestAnswer::Passes {
            set = without;
        }
    }
    Ok(set)
}
