//! That no size and no step of cost is missing.
//!
//! # Theory
//! The best set of a step is the best of all sets that cost as much as it does, up to the budget of the step. Below,
//! the next step begins, or no set is better than one of fewer sensors that costs as little: that is searched. If
//! larger sets are told, smaller ones are missing only where none meets what is required.

use super::Given;
use super::allowed::{name, thousandths};
use super::plain::{Bar, Plain};
use crate::choose::told::{Told, ToldStep};
use crate::error::Issue;
use crate::sensor::Cost;
use crate::study::Across;

/// A front.
pub(super) struct Whole<'a> {
    pub(super) told: &'a Told,
    pub(super) given: Given<'a>,
    /// Whether a plain search proves anything.
    pub(super) is_provable: bool,
}

impl Whole<'_> {
    /// Whether all steps are there.
    ///
    /// # Errors
    /// Why they are not, with the set that should have been told.
    pub(super) fn check(&self) -> Result<(), Issue> {
        let sizes = self.given.choose.always.len().max(1)..=self.given.choose.at_most;
        let steps = &self.told.steps;
        if !steps.is_sorted_by_key(|step| step.at_most) {
            return Err(Issue::says("sizes are out of order").at("steps"));
        }
        let of_size =
            |size: usize| steps.iter().filter(move |step| step.at_most == size).collect::<Vec<&ToldStep>>();
        for size in sizes {
            let own = of_size(size);
            let Some(first) = own.first() else {
                self.has_no_set(size)?;
                continue;
            };
            if first.budget != self.given.choose.budget {
                return Err(missing(size, "the whole budget"));
            }
            if first.best.cost.is_some() {
                self.costs(size, &own)?;
            }
        }
        Ok(())
    }

    /// Whether there is no set of so many sensors that meets what is required.
    fn has_no_set(&self, size: usize) -> Result<(), Issue> {
        let asks = self.given.choose.require.iter().any(|require| require.over != Across::Mean);
        let larger = self.told.steps.iter().any(|step| step.at_most < size);
        if larger || self.given.choose.require.is_empty() {
            return Err(missing(size, "the whole budget"));
        }
        let budget = self.given.choose.budget.map(|budget| budget.thousandths());
        match self.is_provable && asks {
            true => self.not_better((size, budget, Bar::Required), "the whole budget"),
            false => Ok(()),
        }
    }

    /// Whether the steps of cost of one size are all there.
    fn costs(&self, size: usize, own: &[&ToldStep]) -> Result<(), Issue> {
        let fewer = || self.told.steps.iter().filter(|step| step.at_most < size);
        let cost = |step: &&ToldStep| step.best.cost.map(|cost| cost.thousandths());
        let mut left = own.iter().skip(1).peekable();
        let Some(mut spent) = own.first().and_then(cost) else { return Ok(()) };
        while spent > self.cheapest() {
            let below = spent - 1;
            if let Some(next) = left.next_if(|next| cost(next) <= Some(below) && self.covers(next, below)) {
                spent = cost(next).unwrap_or(0);
                continue;
            }
            let known = fewer().filter(|step| cost(step).is_some_and(|cost| cost <= below));
            let known = known.max_by(|a, b| a.best.score.total_cmp(&b.best.score));
            let place = format!("less than {}", Cost::from_thousandths(spent));
            match known.and_then(|known| Some((cost(&known)?, &known.best))) {
                Some((cost, best)) if self.is_provable && own.iter().all(|step| step.proven) => {
                    let bar = best.fraction().map_or(Bar::AboveMean(best.score), Bar::Above);
                    self.not_better((size, Some(below), bar), &place)?;
                    spent = cost;
                }
                Some((cost, _)) => spent = cost,
                None if self.given.choose.require.is_empty() => return Err(missing(size, &place)),
                None => return Ok(()),
            }
        }
        Ok(())
    }

    /// Whether a step is about all sets that cost no more than this: between its budget and that no set costs.
    fn covers(&self, step: &ToldStep, cost: u64) -> bool {
        let budget = step.budget.map_or(u64::MAX, |budget| budget.thousandths());
        let common = self.costs_of_sensors().fold(0, greatest_common_divisor).max(1);
        budget >= cost / common * common
    }

    /// What the cheapest allowed set costs at least.
    fn cheapest(&self) -> u64 {
        match &self.given.choose.always[..] {
            [] => self.costs_of_sensors().min().unwrap_or(0),
            always => always.iter().map(|&[sensor, _]| thousandths(self.given.study, sensor)).sum(),
        }
    }

    fn costs_of_sensors(&self) -> impl Iterator<Item = u64> {
        (0..self.given.study.sensors.len()).map(|sensor| thousandths(self.given.study, sensor))
    }

    fn not_better(&self, (at_most, budget, bar): (usize, Option<u64>, Bar), cost: &str) -> Result<(), Issue> {
        let Some(better) = (Plain { given: self.given, at_most, budget, bar }).better() else {
            return Ok(());
        };
        let name = |&item: &usize| name(self.given.study, self.given.evidence.items[item]);
        let better: Vec<String> = better.iter().map(name).collect();
        let what = format!(
            "the best set of at most {at_most} for {cost} is missing: {} belongs there",
            better.join(";")
        );
        Err(Issue::says(what).at("steps"))
    }
}

fn missing(size: usize, cost: &str) -> Issue {
    Issue::says(format!("the best set of at most {size} for {cost} is missing")).at("steps")
}

fn greatest_common_divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}
