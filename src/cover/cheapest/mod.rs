//! The cheapest set that passes a test, by branch and bound over cost; of several that cost the same, the best by a score.
//!
//! # Theory
//! Two kinds of facts bound the search. A *demand* lists candidates and how many of them every passing set has at least:
//! disjoint demands that a set does not meet yet add up to a lower bound of what it still costs. They are not known in
//! advance; the test of a set that fails may answer with some, and the search continues with them (an implicit hitting
//! set; Chandrasekaran, Karp and others 2011). A *share* is a score that a set must reach, also without any one or two of
//! its members: an inequality of weighted coverage (`question`), which bounds what the remaining money can add. A *coverage*
//! is such an inequality of bits that stand for anything else.
//!
//! If a set must reach a score without any `dead` of its members, some of these are among the members chosen so far and
//! the others are added later. Each choice of chosen members that are dead leaves a part of the set with a bound of its
//! own.
//!
//! Among sets of the lowest cost, those that are better than the best so far are searched in the same way, by what every
//! better set has: inequalities of the score, or demands that the test knows.
//!
//! # Practice
//! A node is a set and the candidates that may still join it. It is pruned if its lower bound exceeds the budget, or if a
//! share, or everything that it lacks together, is out of reach. If a demand is not met, the search branches over its
//! candidates; else over all candidates, those first that add most to what is lacking. A set that meets all demands and
//! all inequalities is tested. The test is exact and decides, so scores without an inequality only take longer. The
//! order of the search does not depend on threads.

mod demand;
mod greedy;
mod search;
mod share;
mod tie;

pub use demand::Demand;
pub use search::{CheapestAnswer, FoundPurchase};
pub use share::{Coverage, Share};
pub use tie::{Better, TieRule, TieScore};

use super::rules::{SetLimits, SetRules};
use super::worth::Worth;
use perirobot_march::Result;
use perirobot_march::progress::Progress;

/// The problem: allowed sets, what a passing set reaches, and what decides among sets of the same cost.
#[derive(Debug)]
pub struct CheapestProblem<'a> {
    /// Which candidates a set may have together, and what they cost.
    pub rules: &'a SetRules,
    /// How large a set may be, and what it may cost.
    pub limits: SetLimits,
    /// Scores that a passing set reaches.
    pub shares: Vec<Share<'a>>,
    /// What a passing set covers at least, beside its shares.
    pub coverages: Vec<Coverage<'a>>,
    /// By what sets of the same cost are compared.
    pub then: Option<TieRule<'a>>,
    /// Up to how many other passing sets of the lowest cost are counted, if nothing decides among them.
    pub most_ties: usize,
}

/// What a test says of a set.
#[derive(Clone, Debug, PartialEq)]
pub enum TestAnswer {
    /// It passes.
    Passes,
    /// It fails, and so does every set that misses one of these demands; the tested set misses at least one.
    Lacks(Vec<Demand>),
    /// It fails; other sets may pass.
    Fails,
}

/// Decides whether a set passes.
pub trait SetTest {
    /// Tests a set; its members come in ascending order.
    ///
    /// # Errors
    /// When it cannot be tested; `Error::Stopped`.
    fn test(&mut self, set: &[usize]) -> Result<TestAnswer>;

    /// What a set that passes is worth, with [`TieRule::Tested`]; `None` if it has no value.
    fn worth(&mut self, set: &[usize]) -> Option<Worth> {
        let _ = set;
        None
    }

    /// Demands of every set that is worth more than `worth`, with [`TieRule::Tested`]. The passing set `set` is not; if
    /// more is known of it, it misses one of them.
    fn demands_above(&mut self, set: &[usize], worth: Worth) -> Vec<Demand> {
        let _ = (set, worth);
        Vec::new()
    }
}

/// What a search knows while it runs.
#[derive(Clone, Copy, Debug)]
pub struct CheapestKnown<'k> {
    /// The cheapest set that passes, of those found so far.
    pub best: Option<&'k FoundPurchase>,
    /// No set that passes costs less, in thousandths.
    pub no_set_below: u64,
    /// How many sets were tested.
    pub tested: u64,
}

/// Searches for the cheapest set that passes. `demands` are those that are known from before; those that are found are
/// added. What is known is shown often, so `show` takes little time. A test that is stopped ends the search as any other stop
/// does.
///
/// # Errors
/// Those of the test.
pub fn cheapest(
    problem: &CheapestProblem,
    demands: &mut Vec<Demand>,
    test: &mut dyn SetTest,
    progress: &dyn Progress,
    show: &dyn Fn(CheapestKnown),
) -> Result<CheapestAnswer> {
    let mut search = search::Search::new(problem, demands, test, (progress, show));
    if !search.is_any_allowed() {
        return Ok(CheapestAnswer::NONE);
    }
    let known = greedy::passing_set(&mut search)?;
    search.run(known)
}

#[cfg(test)]
mod tests;
