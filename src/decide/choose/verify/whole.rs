//! Checks that no size and no step of cost is missing.
//!
//! # Theory
//! The best set of a step is the best of all sets that cost as much as it does, up to the budget of the step. Below
//! it the next step begins, or no set is better than one of fewer sensors at that cost, which is searched. If larger
//! sets are reported, smaller ones are missing only if none meets the requirements.

use super::ProofInput;
use super::allowed::{pose_name, thousandths};
use super::plain::{Plain, Threshold};
use crate::choose::report::{FrontReport, StepReport};
use perirobot_march::error::Issue;
use perirobot_march::metrics::Across;
use perirobot_study::input::SetRequirement;
use perirobot_study::sensor::Cost;

/// A front.
pub(super) struct Whole<'a> {
    pub(super) report: &'a FrontReport,
    /// For each step the score of its best set as a fraction, if it is one.
    pub(super) fractions: &'a [Option<(i128, i128)>],
    pub(super) given: ProofInput<'a>,
    /// Whether a plain search can prove anything.
    pub(super) is_provable: bool,
}

impl Whole<'_> {
    /// Checks that all steps are present.
    ///
    /// # Errors
    /// A missing step, with its set.
    pub(super) fn check(&self) -> Result<(), Issue> {
        let sizes = self.given.choose.always.len().max(1)..=self.given.choose.at_most;
        let steps = &self.report.steps;
        if !steps.is_sorted_by_key(|step| step.at_most) {
            return Err(Issue::says("sizes are out of order").with_place("steps"));
        }
        let of_size =
            |size: usize| steps.iter().filter(move |step| step.at_most == size).collect::<Vec<&StepReport>>();
        for size in sizes {
            let own = of_size(size);
            let Some(first) = own.first() else {
                self.has_no_set(size)?;
                continue;
            };
            if first.budget != self.given.choose.budget {
                return Err(missing(size, "the whole budget"));
            }
            self.costs(size, &own)?;
        }
        Ok(())
    }

    /// Checks that no set of this size meets the requirements.
    fn has_no_set(&self, size: usize) -> Result<(), Issue> {
        let larger = self.report.steps.iter().any(|step| step.at_most < size);
        if larger || self.given.choose.require.is_empty() {
            return Err(missing(size, "the whole budget"));
        }
        let budget = self.given.choose.budget.map(|budget| budget.thousandths());
        self.none_meets((size, budget), "the whole budget")
    }

    /// Checks that no set within some limits meets the requirements, as far as that can be proven.
    fn none_meets(&self, (at_most, budget): (usize, Option<u64>), cost: &str) -> Result<(), Issue> {
        let asks = |one: &SetRequirement| one.over != Across::Mean && one.at_least > 0.0;
        let is_asked = self.given.choose.require.iter().any(asks);
        // Without a proof, the search may have missed a set of few sensors.
        let is_proven = self.report.steps.iter().all(|step| step.proven);
        match self.is_provable && is_asked && is_proven {
            true => self.not_better((at_most, budget, Threshold::Required), cost),
            false => Ok(()),
        }
    }

    /// Checks that all steps of cost of one size are present.
    fn costs(&self, size: usize, own: &[&StepReport]) -> Result<(), Issue> {
        let fewer = || self.report.steps.iter().zip(self.fractions).filter(|(step, _)| step.at_most < size);
        let cost = |step: &StepReport| step.best.cost.map_or(0, |cost| cost.thousandths());
        let mut left = own.iter().skip(1).peekable();
        let Some(mut spent) = own.first().map(|first| cost(first)) else { return Ok(()) };
        while spent > self.cheapest() {
            let below = spent - 1;
            if let Some(next) = left.next_if(|next| cost(next) <= below && self.covers(next, below)) {
                spent = cost(next);
                continue;
            }
            let known = fewer().filter(|(step, _)| cost(step) <= below);
            let known = known.max_by(|(a, _), (b, _)| a.best.score.total_cmp(&b.best.score));
            let place = format!("less than {}", Cost::from_thousandths(spent));
            match known {
                Some((known, fraction)) => {
                    if self.is_provable && own.iter().all(|step| step.proven) {
                        let bar = fraction.map_or(Threshold::AboveMean(known.best.score), Threshold::Above);
                        self.not_better((size, Some(below), bar), &place)?;
                    }
                    spent = cost(known);
                }
                None if self.given.choose.require.is_empty() => return Err(missing(size, &place)),
                None => return self.none_meets((size, Some(below)), &place),
            }
        }
        Ok(())
    }

    /// Whether a step covers all sets of at most this cost: no set costs between its budget and that.
    fn covers(&self, step: &StepReport, cost: u64) -> bool {
        let budget = step.budget.map_or(u64::MAX, |budget| budget.thousandths());
        let common = self.costs_of_sensors().fold(0, greatest_common_divisor).max(1);
        budget >= cost / common * common
    }

    /// Lower bound of the cost of an allowed set.
    fn cheapest(&self) -> u64 {
        match &self.given.choose.always[..] {
            [] => self.costs_of_sensors().min().unwrap_or(0),
            always => always.iter().map(|&[sensor, _]| thousandths(self.given.study, sensor)).sum(),
        }
    }

    fn costs_of_sensors(&self) -> impl Iterator<Item = u64> {
        (0..self.given.study.sensors.len()).map(|sensor| thousandths(self.given.study, sensor))
    }

    fn not_better(
        &self,
        (at_most, budget, bar): (usize, Option<u64>, Threshold),
        cost: &str,
    ) -> Result<(), Issue> {
        let Some(better) = (Plain { given: self.given, at_most, budget, bar }).better() else {
            return Ok(());
        };
        let name = |&item: &usize| pose_name(self.given.study, self.given.evidence.items[item]);
        let better: Vec<String> = better.iter().map(name).collect();
        let what = format!(
            "the best set of at most {at_most} for {cost} is missing: {} belongs there",
            better.join(";")
        );
        Err(Issue::says(what).with_place("steps"))
    }
}

fn missing(size: usize, cost: &str) -> Issue {
    Issue::says(format!("the best set of at most {size} for {cost} is missing")).with_place("steps")
}

fn greatest_common_divisor(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}
