//! The cheapest set that meets at least so many requirements, whichever they are.
//!
//! # Theory
//! A node is a family of sets: all that meet some requirements, while others are not counted. The cheapest set that meets
//! the former bounds the family from below. If it meets enough requirements, it is the family's cheapest. Otherwise every
//! set that meets enough also meets one of those that it misses: each of these leads to a smaller family, which does not
//! count the ones before it. The family with the lowest bound is next, so that the first bound that is not below a known
//! answer ends the search.

use perirobot_cover::cheapest::{CheapestAnswer, FoundPurchase};
use perirobot_march::Result;
use perirobot_march::metrics::Score;

/// Some requirements, by their places among all of them.
pub(super) trait Subsets {
    /// The cheapest set that meets the requirements at some places.
    ///
    /// # Errors
    /// Those of a search.
    fn cheapest_of(&mut self, places: &[usize]) -> Result<CheapestAnswer>;

    /// The places of the requirements that a set misses.
    ///
    /// # Errors
    /// Those of a test.
    fn missed_by(&mut self, set: &[usize]) -> Result<Vec<usize>>;
}

/// What is looked for.
#[derive(Clone, Copy)]
pub(super) struct NumberQuestion {
    /// How many requirements there are.
    pub(super) count: usize,
    /// How many of them a set meets at least.
    pub(super) least: usize,
    /// The score that decides among sets of the same cost.
    pub(super) then: Option<Score>,
}

/// A family of sets.
#[derive(Default)]
struct Family {
    /// No set of it costs less.
    bound: u64,
    /// What its sets meet.
    required: Vec<usize>,
    /// What is not counted.
    left_out: Vec<usize>,
}

impl Family {
    /// The families that each meet one more of some requirements.
    fn split(&self, bound: u64, missed: &[usize], most_left_out: usize) -> Vec<Family> {
        let open: Vec<usize> =
            missed.iter().copied().filter(|place| !self.left_out.contains(place)).collect();
        let child = |number: usize| Family {
            bound,
            required: [&self.required[..], &[open[number]]].concat(),
            left_out: [&self.left_out[..], &open[..number]].concat(),
        };
        let families = (0..open.len()).map(child);
        families.filter(|family| family.left_out.len() <= most_left_out).collect()
    }
}

impl NumberQuestion {
    /// The cheapest set that meets enough requirements, and the places of those that it misses.
    ///
    /// # Errors
    /// Those of a search or test.
    pub(super) fn answer(self, subsets: &mut dyn Subsets) -> Result<(CheapestAnswer, Vec<usize>)> {
        let NumberQuestion { count, least, then } = self;
        let most_missed = count - least;
        let all: Vec<usize> = (0..count).collect();
        let mut families = Family::default().split(0, &all, most_missed);
        let mut answer = CheapestAnswer::NONE;
        let mut best: Option<(FoundPurchase, Vec<usize>)> = None;
        while let Some(next) = (0..families.len()).min_by_key(|&place| (families[place].bound, place)) {
            let family = families.remove(next);
            let cost = best.as_ref().map(|(best, _)| best.cost);
            if cost.is_some_and(|cost| family.bound > cost || (family.bound == cost && then.is_none())) {
                break;
            }
            let found = subsets.cheapest_of(&family.required)?;
            answer.tested += found.tested;
            answer.is_best_of_cost &= found.is_best_of_cost;
            let missed = match &found.best {
                Some(found) => subsets.missed_by(&found.set)?,
                None => Vec::new(),
            };
            if let Some(purchase) = found.best {
                let is_better = |(best, _): &(FoundPurchase, _)| self.is_better(&purchase, best);
                if missed.len() > most_missed {
                    let bound = found.no_set_below.unwrap_or(purchase.cost);
                    families.extend(family.split(bound, &missed, most_missed));
                } else if best.as_ref().is_none_or(is_better) {
                    best = Some((purchase, missed));
                }
            }
            if !found.is_proven {
                // What is left of this family costs no less than what was searched, and the others no less than their bounds.
                let bound = found.no_set_below.unwrap_or(0).max(family.bound);
                let cost = best.as_ref().map(|(best, _)| best.cost);
                let bound = families.iter().map(|family| family.bound).chain(cost).fold(bound, u64::min);
                answer.is_proven = cost == Some(bound);
                answer.no_set_below = Some(bound);
                break;
            }
        }
        let (best, missed) = best.unzip();
        if answer.is_proven {
            answer.no_set_below = best.as_ref().map(|best| best.cost);
        }
        answer.is_best_of_cost = answer.is_proven && (then.is_none() || answer.is_best_of_cost);
        Ok((CheapestAnswer { best, ..answer }, missed.unwrap_or_default()))
    }

    fn is_better(self, one: &FoundPurchase, other: &FoundPurchase) -> bool {
        let is_worth_more = match (self.then, one.worth, other.worth) {
            (Some(then), Some(one), Some(other)) if then.less_is_better() => one < other,
            (_, one, other) => one > other,
        };
        one.cost < other.cost || (one.cost == other.cost && is_worth_more)
    }
}
