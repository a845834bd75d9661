//! What decides among passing sets of the same cost.

use super::super::problem::Problem;
use super::super::worth::{Ratio, Worth};
use super::share::{ShareBound, bounds};
use perirobot_march::metrics::{Across, Score};

/// By what sets of the same cost are compared.
#[derive(Clone, Copy, Debug)]
pub enum TieRule<'a> {
    /// A score of counts.
    Score(TieScore<'a>),
    /// What the test says that a set is worth; more is better.
    Tested,
}

/// A score of counts by which sets are compared.
#[derive(Clone, Copy, Debug)]
pub struct TieScore<'a> {
    /// What the candidates say in the region in which it is counted.
    pub problem: &'a Problem<'a>,
    /// The score.
    pub score: Score,
    /// How the counts of several moments are combined.
    pub over: Across,
}

/// Which of two sets of the same cost is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Better {
    /// The one that is worth more.
    More,
    /// The one that is worth less.
    Less,
}

impl Better {
    /// The better side of a score.
    pub fn from_score(score: Score) -> Better {
        if score.less_is_better() { Better::Less } else { Better::More }
    }

    /// Whether one is better than another; what has no value is the worst.
    pub fn is_better(self, one: Option<Worth>, other: Option<Worth>) -> bool {
        match (self, one, other) {
            (Better::Less, Some(one), Some(other)) => one < other,
            (_, one, other) => one > other,
        }
    }
}

impl TieRule<'_> {
    pub(super) fn better(&self) -> Better {
        match self {
            TieRule::Score(tie) => Better::from_score(tie.score),
            TieRule::Tested => Better::More,
        }
    }
}

impl<'a> TieScore<'a> {
    /// What a set is worth by it, if it has a value.
    pub(super) fn worth_of(&self, set: &[usize]) -> Option<Worth> {
        let counts = match self.score {
            Score::SeenTwice => self.problem.evidence.counts_with_overlap(set),
            _ => self.problem.counts(set),
        };
        Worth::from_counts(self.score, self.over, &counts)
    }

    /// The inequalities of a set that is better. What two sensors see one of them still sees without the other, so that a
    /// share that is seen twice bounds the unknown share of the set without any one member.
    pub(super) fn bounds_above(&self, worth: Ratio) -> Vec<ShareBound<'a>> {
        let Ratio { numerator, denominator } = worth;
        let (score, limit, dead) = match self.score {
            Score::SeenTwice => {
                (Score::Unknown, Ratio { numerator: denominator - numerator, denominator }, 1)
            }
            score => (score, worth, 0),
        };
        bounds(self.problem, (score, self.over), (limit, true), dead)
    }
}
