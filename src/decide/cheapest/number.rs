//! The cheapest set that meets at least N requirements, any of them.
//!
//! # Theory
//! A node is a family of sets: all that meet some requirements, while others are not counted. The cheapest set that meets
//! the former bounds the family from below. If it meets enough requirements, it is the family's cheapest. Otherwise every
//! set that meets enough also meets one of those that it misses: each of these leads to a smaller family, which does not
//! count the ones before it. The family with the lowest bound is next, so that the first bound that is not below a known
//! answer ends the search.

use perirobot_cover::cheapest::{Better, CheapestAnswer, FoundPurchase};
use perirobot_march::{Error, Result};

/// Requirements, by their places among all of them.
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

    /// Reports these bounds together with those of the next search.
    fn show(&mut self, _: FamiliesKnown) {}
}

/// Bounds besides those of the search of one family.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FamiliesKnown {
    /// The cheapest set found that meets enough requirements.
    pub(super) best: Option<FoundPurchase>,
    /// Lower bound of the cost in the family.
    pub(super) family: u64,
    /// Lower bound of the cost in the other families and of the best set.
    pub(super) others: u64,
    /// The number of tested sets.
    pub(super) tested: u64,
}

/// The question.
#[derive(Clone, Copy)]
pub(super) struct NumberQuestion {
    /// The number of requirements.
    pub(super) count: usize,
    /// The number that a set must meet.
    pub(super) least: usize,
    /// The better of two sets of the same cost, if a score decides.
    pub(super) then: Option<Better>,
}

/// A family of sets.
#[derive(Default)]
struct Family {
    /// Lower bound of the cost.
    bound: u64,
    /// The requirements that its sets meet.
    required: Vec<usize>,
    /// The requirements that are not counted.
    left_out: Vec<usize>,
}

impl Family {
    /// The families that each meet one more requirement.
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
            let others = families.iter().map(|family| family.bound).chain(cost).min().unwrap_or(u64::MAX);
            let (known, tested) = (best.as_ref().map(|(best, _)| best.clone()), answer.tested);
            subsets.show(FamiliesKnown { best: known, family: family.bound, others, tested });
            let mut found = subsets.cheapest_of(&family.required)?;
            answer.tested += found.tested;
            answer.compared += found.compared;
            answer.is_best_of_cost &= found.is_best_of_cost;
            let missed = match &found.best {
                Some(best) => match subsets.missed_by(&best.set) {
                    // It may not meet enough.
                    Err(Error::Stopped(_)) => {
                        (found.best, found.is_proven) = (None, false);
                        Vec::new()
                    }
                    missed => missed?,
                },
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
                // The rest of this family costs no less than the searched set, and the others no less than their
                // bounds.
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
        let is_worth_more = self.then.is_some_and(|then| then.is_better(one.worth, other.worth));
        one.cost < other.cost || (one.cost == other.cost && is_worth_more)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use perirobot_cover::{Ratio, Worth};
    use perirobot_march::march::pcg;

    /// Sets with their costs, the requirements that they meet as bits, and their worth.
    struct Table {
        sets: Vec<(u64, u32, i128)>,
        count: usize,
        then: Option<Better>,
        /// After this many searches, each returns only half of the cost, as a bound.
        most_searches: u64,
        searches: u64,
    }

    impl Table {
        fn new(seed: u32, then: Option<Better>, most_searches: u64) -> Table {
            let mut state = seed;
            let mut below = |n: u32| {
                state = state.wrapping_add(0x9e37_79b9);
                pcg(state) % n
            };
            let count = 2 + below(4) as usize;
            let mut set = || {
                let met = (0..count).map(|place| u32::from(below(3) == 0) << place).sum();
                (u64::from(below(8)), met, i128::from(below(4)))
            };
            let sets = (0..30).map(|_| set()).collect();
            Table { sets, count, then, most_searches, searches: 0 }
        }

        fn purchase(&self, number: usize) -> FoundPurchase {
            let (cost, _, numerator) = self.sets[number];
            let worth = self.then.map(|_| Worth::Exact(Ratio { numerator, denominator: 4 }));
            FoundPurchase { set: vec![number], cost, worth }
        }

        /// Cost and worth of the cheapest set that fits, by trying every set.
        fn cheapest(&self, fits: &dyn Fn(u32) -> bool) -> Option<usize> {
            let less_is_better = self.then == Some(Better::Less);
            let fitting = (0..self.sets.len()).filter(|&number| fits(self.sets[number].1));
            fitting.min_by_key(|&number| {
                let (cost, _, worth) = self.sets[number];
                let rank = if less_is_better { worth } else { -worth };
                (cost, if self.then.is_some() { rank } else { 0 }, number)
            })
        }
    }

    impl Subsets for Table {
        fn cheapest_of(&mut self, places: &[usize]) -> Result<CheapestAnswer> {
            let required: u32 = places.iter().map(|place| 1 << place).sum();
            let Some(best) = self.cheapest(&|met| met & required == required) else {
                return Ok(CheapestAnswer::NONE);
            };
            self.searches += 1;
            let is_proven = self.searches <= self.most_searches;
            let best = self.purchase(best);
            let bound = if is_proven { best.cost } else { best.cost / 2 };
            let no_set_below = Some(bound);
            Ok(CheapestAnswer {
                best: Some(best).filter(|_| is_proven || self.searches.is_multiple_of(2)),
                no_set_below,
                is_proven,
                is_best_of_cost: is_proven,
                compared: 0,
                ties: None,
                tested: 1,
            })
        }

        fn missed_by(&mut self, set: &[usize]) -> Result<Vec<usize>> {
            let met = self.sets[set[0]].1;
            Ok((0..self.count).filter(|place| met >> place & 1 == 0).collect())
        }
    }

    #[test]
    fn the_answer_is_that_of_looking_at_every_set() {
        let (mut some, mut none) = (0, 0);
        for seed in 0..3000 {
            let then = [None, Some(Better::More), Some(Better::Less)][seed as usize % 3];
            let mut table = Table::new(seed, then, u64::MAX);
            for least in 1..table.count {
                let question = NumberQuestion { count: table.count, least, then };
                let (found, missed) = question.answer(&mut table).unwrap();
                let right = table.cheapest(&|met| met.count_ones() as usize >= least);
                let right = right.map(|number| table.purchase(number));
                let cost_and_worth = |one: &FoundPurchase| (one.cost, one.worth);
                assert_eq!(
                    found.best.as_ref().map(cost_and_worth),
                    right.as_ref().map(cost_and_worth),
                    "{seed}, {least}"
                );
                assert_eq!(found.no_set_below, right.as_ref().map(|right| right.cost), "{seed}, {least}");
                assert!(found.is_proven && found.is_best_of_cost, "{seed}, {least}");
                let own = found.best.as_ref().map(|best| table.missed_by(&best.set).unwrap());
                assert_eq!(own.unwrap_or_default(), missed, "{seed}, {least}");
                if right.is_some() { some += 1 } else { none += 1 }
            }
        }
        assert!(some > 1000 && none > 100, "{some} found, {none} not");
    }

    #[test]
    fn a_search_that_is_stopped_bounds_what_is_left() {
        let (mut open, mut found_some) = (0, 0);
        for seed in 0..3000 {
            let then = [None, Some(Better::More)][seed as usize % 2];
            let mut table = Table::new(seed, then, u64::from(seed % 5));
            let least = table.count - 1;
            let (found, _) = NumberQuestion { count: table.count, least, then }.answer(&mut table).unwrap();
            let right = table.cheapest(&|met| met.count_ones() as usize >= least);
            let right = right.map(|number| table.purchase(number).cost);
            let cost = found.best.as_ref().map(|best| best.cost);
            assert!(
                right.is_none_or(|right| found.no_set_below.is_some_and(|below| below <= right)),
                "{seed}"
            );
            assert!(cost.is_none_or(|cost| right.is_some_and(|right| right <= cost)), "{seed}");
            assert!(!found.is_proven || cost == right, "{seed}");
            assert!(!found.is_best_of_cost || found.is_proven, "{seed}");
            open += usize::from(!found.is_proven);
            found_some += usize::from(!found.is_proven && cost.is_some());
        }
        assert!(open > 500 && found_some > 20, "{open} open, {found_some} with a set");
    }
}
