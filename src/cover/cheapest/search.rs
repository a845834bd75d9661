//! The search: a growing budget, and for each budget a walk over all sets that it pays for.

use super::super::rules::SetLimits;
use super::super::worth::Worth;
use super::demand::{self, Demand, DemandState};
use super::share::{OutOfReach, ShareBound, ShareStates};
use super::{CheapestKnown, CheapestProblem, SetTest, TestAnswer, TieRule};
use perirobot_march::progress::Progress;
use perirobot_march::{Error, Result};

/// A set that passes.
#[derive(Clone, Debug, PartialEq)]
pub struct FoundPurchase {
    /// Its members in ascending order.
    pub set: Vec<usize>,
    /// What it costs, in thousandths.
    pub cost: u64,
    /// What it is worth by the score that decides among sets of the same cost, if that has a value.
    pub worth: Option<Worth>,
}

/// What a search found.
#[derive(Clone, Debug, PartialEq)]
pub struct CheapestAnswer {
    /// The cheapest set that passes, as far as is known; none if no allowed set passes, or none was found yet.
    pub best: Option<FoundPurchase>,
    /// No set that passes costs less, in thousandths; none if no allowed set passes.
    pub no_set_below: Option<u64>,
    /// Whether no set that passes costs less than the best, or none passes.
    pub is_proven: bool,
    /// Whether also no set of the same cost is better by what decides among them.
    pub is_best_of_cost: bool,
    /// How many passing sets of the best one's cost were compared by that.
    pub compared: u64,
    /// How many other sets of the same cost pass, as far as they were to be counted; none if they were not.
    pub ties: Option<usize>,
    /// How many sets were tested.
    pub tested: u64,
}

impl CheapestAnswer {
    /// No allowed set passes.
    pub const NONE: CheapestAnswer = CheapestAnswer {
        best: None,
        no_set_below: None,
        is_proven: true,
        is_best_of_cost: true,
        compared: 0,
        ties: None,
        tested: 0,
    };
}

/// How a walk ended.
#[derive(Clone, Copy, PartialEq)]
enum WalkEnd {
    /// All sets were looked at.
    Complete,
    /// It was stopped.
    Stopped,
    /// As many ties as were to be counted were found.
    Enough,
}

/// Most sets that are tested to count ties, and most that are looked at.
const MOST_TIE_TESTS: u64 = 30;
const MOST_TIE_LOOKS: u64 = 1000;

/// What a walk looks for.
#[derive(Clone, Copy, PartialEq)]
enum Goal {
    /// Cheaper sets than the best.
    Cheaper,
    /// Better sets of the best one's cost.
    Better,
    /// Other sets of the best one's cost, by no more than so many tests in all.
    Ties { last_test: u64 },
}

/// Shows what is known.
type Show<'s> = &'s dyn Fn(CheapestKnown);

/// A search.
pub(super) struct Search<'s, 'a> {
    pub(super) problem: &'s CheapestProblem<'a>,
    pub(super) bounds: Vec<ShareBound<'a>>,
    /// How many of them are of what is required; the others are of the score that decides among sets of the same cost.
    required: usize,
    /// The number of the one that was out of reach last, which often is again.
    pub(super) first: usize,
    pub(super) demands: &'s mut Vec<Demand>,
    test: &'s mut dyn SetTest,
    progress: &'s dyn Progress,
    /// Shows what is known.
    show: Show<'s>,
    tested: u64,
    /// Only sets that cost no more are looked at.
    limits: SetLimits,
    /// No set that passes costs less.
    no_set_below: u64,
    best: Option<FoundPurchase>,
    goal: Goal,
    /// How many sets were looked at for ties.
    tie_looks: u64,
    /// How many passing sets of the best one's cost were compared; of ties only the others.
    compared: u64,
}

impl<'s, 'a> Search<'s, 'a> {
    pub(super) fn new(
        problem: &'s CheapestProblem<'a>,
        demands: &'s mut Vec<Demand>,
        test: &'s mut dyn SetTest,
        (progress, show): (&'s dyn Progress, Show<'s>),
    ) -> Search<'s, 'a> {
        let covered = problem.coverages.iter().map(|coverage| coverage.bound());
        let bounds: Vec<ShareBound> =
            problem.shares.iter().flat_map(|share| share.bounds()).chain(covered).collect();
        let (limits, no_set_below) = (problem.limits, problem.rules.cost_of(&problem.rules.always));
        let (required, best, goal, tested, compared) = (bounds.len(), None, Goal::Cheaper, 0, 0);
        let tie_looks = 0;
        Search {
            problem,
            bounds,
            required,
            first: 0,
            demands,
            test,
            progress,
            show,
            tested,
            limits,
            no_set_below,
            best,
            goal,
            tie_looks,
            compared,
        }
    }

    /// Whether any set is allowed.
    pub(super) fn is_any_allowed(&self) -> bool {
        let limits = self.problem.limits;
        limits.afford(self.no_set_below) && self.problem.rules.always.len() <= limits.at_most
    }

    /// Searches on from a set that passes, if one is known; some set is allowed.
    pub(super) fn run(mut self, known: Option<Vec<usize>>) -> Result<CheapestAnswer> {
        let rules = self.problem.rules;
        known.into_iter().for_each(|set| self.take(set));
        // Budgets grow from what any set costs to what the best one does.
        let total: u64 = rules.cost.iter().sum();
        let mut step = rules.cost.iter().copied().filter(|&cost| cost > 0).min().unwrap_or(1);
        while !self.is_cheapest_known() {
            let most = match &self.best {
                Some(best) => rules.largest_cost_below(best.cost),
                None => self.problem.limits.budget.map_or(total, |budget| budget.min(total)),
            };
            let tried = (self.no_set_below + step).min(most);
            if tried >= self.no_set_below {
                self.limits = SetLimits { budget: Some(tried), ..self.problem.limits };
                if self.walk(&mut rules.always.clone(), self.candidates())? == WalkEnd::Stopped {
                    return Ok(self.answer(false));
                }
            }
            // A set that was found has left no cheaper one.
            match self.best.as_ref().map(|best| best.cost) {
                Some(cost) if tried == most || cost <= tried => self.no_set_below = cost,
                None if tried == most => return Ok(self.answer(true)),
                _ => self.no_set_below = rules.least_cost_above(tried),
            }
            self.tell();
            step *= 2;
        }
        self.limits = SetLimits { budget: Some(self.no_set_below), ..self.problem.limits };
        match self.problem.then {
            Some(_) => self.find_best_of_cost(),
            None => self.count_ties(),
        }
    }

    /// Searches the sets of the best one's cost for the best of them; none is cheaper.
    fn find_best_of_cost(mut self) -> Result<CheapestAnswer> {
        (self.goal, self.compared) = (Goal::Better, 1);
        if let Some(best) = self.best.clone() {
            self.ask_more(&best.set);
        }
        let end = self.walk(&mut self.problem.rules.always.clone(), self.candidates())?;
        Ok(CheapestAnswer { is_best_of_cost: end == WalkEnd::Complete, ..self.answer(true) })
    }

    /// Counts other passing sets of the best one's cost; none is cheaper.
    fn count_ties(mut self) -> Result<CheapestAnswer> {
        let answer = self.answer(true);
        if self.problem.most_ties == 0 {
            return Ok(answer);
        }
        (self.goal, self.compared) = (Goal::Ties { last_test: self.tested + MOST_TIE_TESTS }, 0);
        let end = self.walk(&mut self.problem.rules.always.clone(), self.candidates())?;
        let ties = (end != WalkEnd::Stopped).then_some(self.compared as usize);
        Ok(CheapestAnswer { ties, ..answer })
    }

    fn answer(&self, is_complete: bool) -> CheapestAnswer {
        let is_proven = is_complete || self.is_cheapest_known();
        CheapestAnswer {
            best: self.best.clone(),
            no_set_below: (self.best.is_some() || !is_proven).then_some(self.no_set_below),
            is_proven,
            is_best_of_cost: is_proven && (self.problem.then.is_none() || self.best.is_none()),
            compared: self.compared,
            ties: None,
            tested: self.tested,
        }
    }

    /// Whether no set costs less than the best.
    fn is_cheapest_known(&self) -> bool {
        self.best.as_ref().is_some_and(|best| best.cost <= self.no_set_below)
    }

    /// Only sets that are better than the best are looked for from now on; `set` passes, and is not.
    fn ask_more(&mut self, set: &[usize]) {
        self.bounds.truncate(self.required);
        match (&self.problem.then, self.best.as_ref().and_then(|best| best.worth)) {
            (Some(TieRule::Score(tie)), Some(Worth::Exact(worth))) => {
                self.bounds.extend(tie.bounds_above(worth));
            }
            (Some(TieRule::Tested), Some(worth)) => {
                let demands = self.test.demands_above(set, worth);
                demands.into_iter().for_each(|demand| demand::add(self.demands, demand));
            }
            _ => {}
        }
    }

    /// Takes a set that passes, if it is better than the best. Only still better ones are looked for from now on.
    fn take_passing(&mut self, chosen: &[usize]) {
        let mut set = chosen.to_vec();
        set.sort_unstable();
        self.compared += u64::from(self.best.as_ref().is_none_or(|best| best.set != set));
        match self.goal {
            Goal::Ties { .. } => {}
            Goal::Better => {
                self.take(set.clone());
                self.ask_more(&set);
            }
            Goal::Cheaper => {
                self.take(set);
                if let Some(best) = self.best.as_ref().filter(|best| best.cost > 0) {
                    self.limits.budget = Some(self.problem.rules.largest_cost_below(best.cost));
                }
            }
        }
    }

    fn candidates(&self) -> Vec<usize> {
        let mut all: Vec<usize> = (0..self.problem.rules.cost.len()).collect();
        // What is cheap first, so that equal sets come in the same order whatever is known.
        all.sort_by_key(|&item| (self.problem.rules.cost[item], item));
        all
    }

    /// Takes a set that passes, if it is better than the best.
    fn take(&mut self, mut set: Vec<usize>) {
        set.sort_unstable();
        let cost = self.problem.rules.cost_of(&set);
        let worth = match &self.problem.then {
            Some(TieRule::Score(tie)) => tie.worth_of(&set),
            Some(TieRule::Tested) => self.test.worth(&set),
            None => None,
        };
        let is_better = match &self.best {
            None => true,
            Some(best) if cost != best.cost => cost < best.cost,
            Some(best) => self.problem.then.is_some_and(|then| then.better().is_better(worth, best.worth)),
        };
        if is_better {
            self.best = Some(FoundPurchase { set, cost, worth });
            self.tell();
        }
    }

    /// Shows what is known.
    fn tell(&self) {
        let Search { best, no_set_below, tested, .. } = self;
        (self.show)(CheapestKnown { best: best.as_ref(), no_set_below: *no_set_below, tested: *tested });
    }

    /// Whether there is a reason to stop.
    pub(super) fn is_stopped(&self) -> bool {
        self.progress.stops()
    }

    /// Tests a set.
    pub(super) fn test(&mut self, set: &[usize]) -> Result<TestAnswer> {
        let mut set = set.to_vec();
        set.sort_unstable();
        self.tested += 1;
        let answer = self.test.test(&set)?;
        self.tell();
        if let TestAnswer::Lacks(new) = &answer {
            assert!(new.iter().any(|demand| demand.lacks(&set) > 0), "a new demand, or no end");
            new.iter().for_each(|demand| demand::add(self.demands, demand.clone()));
        }
        Ok(answer)
    }

    /// Those of some candidates that may join a set, in their order.
    pub(super) fn may_join(&self, chosen: &[usize], items: &[usize]) -> Vec<usize> {
        let rules = self.problem.rules;
        let cost = rules.cost_of(chosen);
        let fits =
            |&item: &usize| self.limits.afford(cost + rules.cost[item]) && rules.may_join(chosen, item);
        if chosen.len() >= self.limits.at_most {
            return Vec::new();
        }
        items.iter().copied().filter(fits).collect()
    }

    /// Looks at all sets that have some members and some others besides.
    fn walk(&mut self, chosen: &mut Vec<usize>, among: Vec<usize>) -> Result<WalkEnd> {
        loop {
            if self.progress.stops() {
                return Ok(WalkEnd::Stopped);
            }
            self.tell();
            match self.goal {
                Goal::Cheaper if self.is_cheapest_known() => return Ok(WalkEnd::Complete),
                Goal::Ties { last_test } if self.tested >= last_test || self.tie_looks >= MOST_TIE_LOOKS => {
                    return Ok(WalkEnd::Stopped);
                }
                Goal::Ties { .. } if self.compared >= self.problem.most_ties as u64 => {
                    return Ok(WalkEnd::Enough);
                }
                _ => {}
            }
            self.tie_looks += u64::from(matches!(self.goal, Goal::Ties { .. }));
            let rules = self.problem.rules;
            let allowed = self.may_join(chosen, &among);
            let narrowest = match demand::state(self.demands, rules, chosen, &allowed) {
                DemandState::OutOfReach => return Ok(WalkEnd::Complete),
                DemandState::Open { cost, members, narrowest } => {
                    if !self.limits.afford(rules.cost_of(chosen) + cost)
                        || chosen.len() + members > self.limits.at_most
                    {
                        return Ok(WalkEnd::Complete);
                    }
                    narrowest
                }
            };
            let asked = (&self.bounds[..], &self.demands[..], self.first);
            let states = match ShareStates::new(asked, (rules, self.limits), chosen, &allowed) {
                Ok(states) => states,
                Err(OutOfReach(number)) => {
                    self.first = number.unwrap_or(self.first);
                    return Ok(WalkEnd::Complete);
                }
            };
            if let Some(first) = narrowest {
                return self.branch(chosen, &allowed, &first, &states);
            }
            if !states.surely_fails() {
                let answer = match self.test(chosen) {
                    Err(Error::Stopped(_)) => return Ok(WalkEnd::Stopped),
                    answer => answer?,
                };
                match answer {
                    TestAnswer::Lacks(_) => continue,
                    TestAnswer::Fails => {}
                    TestAnswer::Passes => {
                        self.take_passing(chosen);
                        // What is added to a set that passes does not make it cheaper.
                        if self.goal == Goal::Cheaper {
                            return Ok(WalkEnd::Complete);
                        }
                        // Better sets have what it misses.
                        if self.demands.iter().any(|demand| demand.lacks(chosen) > 0) {
                            continue;
                        }
                    }
                }
            }
            return self.extend(chosen, &allowed, &states);
        }
    }

    /// Looks at all sets with at least one of some candidates, `first`.
    fn branch(
        &mut self,
        chosen: &mut Vec<usize>,
        allowed: &[usize],
        first: &[usize],
        states: &ShareStates,
    ) -> Result<WalkEnd> {
        let mut is_open = vec![true; allowed.len()];
        for item in first {
            let Some(place) = allowed.iter().position(|other| other == item) else { continue };
            is_open[place] = false;
            let end = self.join(chosen, allowed, place, states, &|place| is_open[place])?;
            if end != WalkEnd::Complete {
                return Ok(end);
            }
        }
        Ok(WalkEnd::Complete)
    }

    /// Looks at all sets with some more candidates.
    fn extend(
        &mut self,
        chosen: &mut Vec<usize>,
        allowed: &[usize],
        states: &ShareStates,
    ) -> Result<WalkEnd> {
        let mut is_open = vec![true; allowed.len()];
        for place in states.best_first() {
            if !states.may_reach(self.limits, chosen, None, &|place| is_open[place]) {
                break;
            }
            is_open[place] = false;
            let end = self.join(chosen, allowed, place, states, &|place| is_open[place])?;
            if end != WalkEnd::Complete {
                return Ok(end);
            }
        }
        Ok(WalkEnd::Complete)
    }

    /// Looks at all sets with one more candidate, at a place among those that are allowed, and those that `may_join` it.
    fn join(
        &mut self,
        chosen: &mut Vec<usize>,
        allowed: &[usize],
        place: usize,
        states: &ShareStates,
        may_join: &dyn Fn(usize) -> bool,
    ) -> Result<WalkEnd> {
        if !states.may_reach(self.limits, chosen, Some(place), may_join) {
            return Ok(WalkEnd::Complete);
        }
        let rest = (0..allowed.len()).filter(|&place| may_join(place)).map(|place| allowed[place]).collect();
        chosen.push(allowed[place]);
        let end = self.walk(chosen, rest);
        chosen.pop();
        end
    }
}
