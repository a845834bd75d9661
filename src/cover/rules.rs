//! Which candidates a set may have together, what it costs, and how large it may be.

use super::problem::FoundSet;
use perirobot_march::progress::SearchState;

/// Which candidates a set may have together, and what they cost.
#[derive(Clone, Debug, Default)]
pub struct SetRules {
    /// The number of each candidate's sensor.
    pub sensor: Vec<usize>,
    /// What each candidate costs, in thousandths.
    pub cost: Vec<u64>,
    /// Candidates that are in every set.
    pub always: Vec<usize>,
    /// For each candidate the others that may not be in a set with it, a bit each; empty if there are none.
    pub near: Vec<Vec<u64>>,
    /// How many of each sensor a set may have.
    pub most: Vec<usize>,
}

/// How large a set may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SetLimits {
    /// How many candidates it may have.
    pub at_most: usize,
    /// What it may cost, in thousandths.
    pub budget: Option<u64>,
}

impl SetLimits {
    /// Whether a set may cost so much.
    pub fn afford(&self, cost: u64) -> bool {
        self.budget.is_none_or(|budget| cost <= budget)
    }

    /// What a search within these limits reports of the best set that it found.
    pub fn state(&self, best: Option<&FoundSet>) -> SearchState {
        let SetLimits { at_most, budget } = *self;
        let set = best.map_or(Vec::new(), |best| best.set.clone());
        let best = best.map(|best| best.worth.value());
        SearchState { at_most, budget, best, set, bound: None, seconds: None }
    }
}

impl SetRules {
    /// Whether a candidate may join some others, whatever it costs.
    pub fn may_join(&self, chosen: &[usize], item: usize) -> bool {
        let sensor = self.sensor[item];
        let of_it = || chosen.iter().filter(|&&other| self.sensor[other] == sensor).count();
        chosen.iter().all(|&other| other != item && !self.are_near(other, item))
            && of_it() < self.most[sensor]
    }

    fn are_near(&self, a: usize, b: usize) -> bool {
        self.near.get(a).is_some_and(|near| near[b / 64] >> (b % 64) & 1 == 1)
    }

    /// What a set costs, in thousandths.
    pub fn cost_of(&self, set: &[usize]) -> u64 {
        set.iter().map(|&item| self.cost[item]).sum()
    }

    /// The largest amount below some cost, above zero, that a set may cost: all of them are multiples of one amount.
    pub fn largest_cost_below(&self, cost: u64) -> u64 {
        let common = self.common_amount();
        (cost - 1) / common * common
    }

    /// The least amount above some cost that a set may cost, by the same reason.
    pub fn least_cost_above(&self, cost: u64) -> u64 {
        let common = self.common_amount();
        (cost / common + 1) * common
    }

    fn common_amount(&self) -> u64 {
        self.cost.iter().fold(0, |a, &b| greatest_common_divisor(a, b)).max(1)
    }

    /// How many sensors a budget pays for at most.
    pub fn most_affordable(&self, limits: SetLimits) -> usize {
        let rest = limits.budget.map(|budget| budget.saturating_sub(self.cost_of(&self.always)));
        let free = (0..self.cost.len()).filter(|item| !self.always.contains(item));
        match (rest, free.map(|item| self.cost[item]).min()) {
            (Some(rest), Some(least @ 1..)) => self.always.len() + (rest / least) as usize,
            _ => usize::MAX,
        }
    }
}

fn greatest_common_divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}
