//! A minimum number of members from a list of candidates, which every passing set has.

use super::super::rules::SetRules;

/// Every passing set has at least `least` of some candidates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Demand {
    /// The list: a bit for each candidate.
    pub among: Vec<u64>,
    /// The minimum number of members from it.
    pub least: usize,
}

impl Demand {
    /// At least `least` of the candidates with the numbers `among`; `count` is the number of all candidates.
    pub fn new(count: usize, among: impl IntoIterator<Item = usize>, least: usize) -> Demand {
        let mut bits = vec![0u64; count.div_ceil(64)];
        among.into_iter().for_each(|item| bits[item / 64] |= 1 << (item % 64));
        Demand { among: bits, least }
    }

    /// Whether a candidate is among them.
    pub fn has(&self, item: usize) -> bool {
        self.among[item / 64] >> (item % 64) & 1 == 1
    }

    /// How many more of them a set needs.
    pub fn lacks(&self, set: &[usize]) -> usize {
        self.least.saturating_sub(set.iter().filter(|&&item| self.has(item)).count())
    }

    /// Whether every set that meets this one meets another.
    fn implies(&self, other: &Demand) -> bool {
        self.least >= other.least && self.among.iter().zip(&other.among).all(|(own, more)| own & !more == 0)
    }
}

/// Adds a demand, unless a known one is as strong; those that it replaces are dropped.
pub(super) fn add(demands: &mut Vec<Demand>, new: Demand) {
    if !demands.iter().any(|known| known.implies(&new)) {
        demands.retain(|known| !new.implies(known));
        demands.push(new);
    }
}

/// What demands say of the sets that a node leads to.
pub(super) enum DemandState {
    /// No set meets them all.
    OutOfReach,
    /// Lower bounds of what is missing.
    Open {
        /// The additional cost.
        cost: u64,
        /// The number of additional members.
        members: usize,
        /// The candidates that may join of the demand with the fewest choices; none if all demands are met.
        narrowest: Option<Vec<usize>>,
    },
}

/// The lower bounds of sets that contain `chosen` and otherwise only candidates from `allowed`, which is in order.
pub(super) fn state(
    demands: &[Demand],
    rules: &SetRules,
    chosen: &[usize],
    allowed: &[usize],
) -> DemandState {
    let mut open: Vec<(usize, usize, Vec<usize>)> = Vec::new();
    for (number, demand) in demands.iter().enumerate() {
        let lacks = demand.lacks(chosen);
        if lacks == 0 {
            continue;
        }
        let among: Vec<usize> = allowed.iter().copied().filter(|&item| demand.has(item)).collect();
        if among.len() < lacks {
            return DemandState::OutOfReach;
        }
        open.push((number, lacks, among));
    }
    // Disjoint ones add up; those with few candidates leave most room for others.
    open.sort_by_key(|(number, lacks, among)| (among.len() + 1 - lacks, *number));
    let (mut cost, mut members, mut used) = (0, 0, vec![0u64; rules.cost.len().div_ceil(64)]);
    for (_, lacks, among) in &open {
        if among.iter().all(|&item| used[item / 64] >> (item % 64) & 1 == 0) {
            let mut prices: Vec<u64> = among.iter().map(|&item| rules.cost[item]).collect();
            prices.sort_unstable();
            cost += prices[..*lacks].iter().sum::<u64>();
            members += lacks;
            among.iter().for_each(|&item| used[item / 64] |= 1 << (item % 64));
        }
    }
    let narrowest = open.into_iter().next().map(|(.., among)| among);
    DemandState::Open { cost, members, narrowest }
}
