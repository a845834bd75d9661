//! The cheapest set that passes a test, by branch and bound over cost.
//!
//! # Theory
//! Two kinds of facts bound the search. A *demand* names candidates of which every passing set has at least so many:
//! disjoint demands that a set does not meet yet say what it still costs at least. They are not known in advance; the
//! test of a set that fails may answer with some, and the search goes on with them (an implicit hitting set; Chandrasekaran,
//! Karp and others 2011). A *share* is a score that a set must reach, also without any one or two of its members: an
//! inequality of weighted coverage (`question`), which bounds what the remaining money can add.
//!
//! Without a member means: if a set must reach a score with any `dead` members left out, then what is left is a part of
//! the set that is chosen so far, less some of it, and of what is added, less the rest of the `dead`. Each such part is
//! bounded by itself.
//!
//! # Practice
//! A node is a set and the candidates that may still join it. It is left if what it costs at least is too much, or if a
//! share is out of reach. If a demand is not met, the search branches over its candidates; else over all, those first
//! that add most to the share that lacks most. A set that meets all demands and, as far as inequalities tell, all shares
//! is tested. A test is exact, and decides; so scores that no inequality bounds only take longer. The order of the
//! search does not depend on threads.

mod demand;
mod greedy;
mod search;
mod share;

pub use demand::Demand;
pub use search::{CheapestAnswer, FoundPurchase};
pub use share::Share;

use super::rules::{SetLimits, SetRules};
use super::worth::Worth;
use perirobot_march::Result;
use perirobot_march::progress::Progress;

/// Of which sets the cheapest is looked for.
#[derive(Debug)]
pub struct CheapestProblem<'a> {
    /// Which candidates a set may have together, and what they cost.
    pub rules: &'a SetRules,
    /// How large a set may be, and what it may cost.
    pub limits: SetLimits,
    /// Scores that a passing set reaches.
    pub shares: Vec<Share<'a>>,
    /// What of several sets of the same cost is to be high: a share whose limit and whose number of dead are not looked at.
    pub then: Option<Share<'a>>,
}

/// What a test says of a set.
#[derive(Clone, Debug, PartialEq)]
pub enum TestAnswer {
    /// It passes.
    Passes,
    /// It fails, and so does every set that does not meet all of these demands, of which the set does not meet at least
    /// one.
    Lacks(Vec<Demand>),
    /// It fails; nothing is said of others.
    Fails,
}

/// Decides whether a set passes.
pub trait SetTest {
    /// Tests a set; its members come in ascending order.
    ///
    /// # Errors
    /// When it cannot be tested; `Error::Stopped`.
    fn test(&mut self, set: &[usize]) -> Result<TestAnswer>;
}

/// Searches for the cheapest set that passes. `demands` are those that are known from before; those that are found are
/// added.
///
/// # Errors
/// Those of the test.
pub fn cheapest(
    problem: &CheapestProblem,
    demands: &mut Vec<Demand>,
    test: &mut dyn SetTest,
    progress: &dyn Progress,
) -> Result<CheapestAnswer> {
    let mut search = search::Search::new(problem, demands, test, progress);
    if !search.is_any_allowed() {
        return Ok(CheapestAnswer::NONE);
    }
    let known = greedy::passing_set(&mut search)?;
    search.run(known)
}

/// What a set is worth by the score that decides among sets of the same cost.
pub(super) fn worth_of(then: &Share, set: &[usize]) -> Option<Worth> {
    Worth::from_counts(then.score, then.over, &then.evidence.counts(set))
}

#[cfg(test)]
mod tests;
