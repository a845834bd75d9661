//! Which sets are allowed, and what each is worth.

use super::evidence::{CandidateEvidence, Row, Union};
use super::layout::WantedCounts;
use super::odds::Odds;
use super::rules::{SetLimits, SetRules};
use super::worth::{Ratio, Worth};
use perirobot_march::metrics::{Across, Confusion, Score};

/// What is searched: allowed sets of candidates, by their numbers in the evidence.
#[derive(Clone, Debug)]
pub struct Problem<'a> {
    /// What the candidates say.
    pub evidence: &'a CandidateEvidence,
    /// The score that is to be high, and of which counts.
    pub goal: (Score, Across),
    /// What every set must reach.
    pub require: Vec<(Score, Across, Ratio)>,
    /// How large a set may be.
    pub limits: SetLimits,
    /// Which candidates a set may have together, and what they cost.
    pub rules: SetRules,
    /// How labels come to be, where that is not by unions.
    pub odds: Option<Odds>,
}

/// Some candidates together, which others may join.
pub enum JointCandidates<'a> {
    /// Their union.
    Union(Union),
    /// What each says, where sums decide.
    Rows(Vec<(usize, Row<'a>)>),
}

/// How good a set is: first by what it lacks of the requirements, then by its worth. Larger is better.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Merit {
    /// Zero where all requirements are met, else below.
    lacking: f64,
    /// What it is worth, if it has a value.
    pub worth: Option<Worth>,
}

/// A set and its worth.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundSet {
    /// Candidates by their numbers in the evidence, lowest first.
    pub set: Vec<usize>,
    /// What it is worth.
    pub worth: Worth,
}

impl Eq for Merit {}

impl Ord for Merit {
    fn cmp(&self, other: &Merit) -> std::cmp::Ordering {
        self.lacking.total_cmp(&other.lacking).then(self.worth.cmp(&other.worth))
    }
}

impl PartialOrd for Merit {
    fn partial_cmp(&self, other: &Merit) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl<'a> Problem<'a> {
    /// Sums change labels, and of some scores labels are no part.
    #[must_use]
    pub fn drop_idle_odds(mut self) -> Self {
        self.odds = self.odds.take().filter(|_| self.wanted_counts().labels);
        self
    }

    /// Whether sets can be searched to the end: what any of them sees is a union, and at hand.
    pub fn is_searchable(&self) -> bool {
        self.odds.is_none() && !self.evidence.is_filed()
    }

    /// Whether labels are sums of what sensors say.
    pub fn adds_up(&self) -> bool {
        self.odds.is_some()
    }

    /// The same sets, by another score and without requirements.
    pub fn asking(&self, score: Score, over: Across) -> Problem<'a> {
        Problem { goal: (score, over), require: Vec::new(), ..self.clone() }.drop_idle_odds()
    }

    /// Some candidates together.
    pub fn joint(&self, set: &[usize]) -> JointCandidates<'a> {
        if self.odds.is_some() {
            return JointCandidates::Rows(set.iter().map(|&item| (item, self.evidence.row(item))).collect());
        }
        let mut union = self.evidence.nothing();
        set.iter().for_each(|&item| union.add(self.evidence, item));
        JointCandidates::Union(union)
    }

    /// What a set counts, moment by moment: as [`CandidateEvidence::counts`] has it, unless sums of what its sensors say
    /// decide.
    pub fn counts(&self, set: &[usize]) -> Vec<Confusion> {
        self.counts_with(&self.joint(set), None, WantedCounts::ALL)
    }

    /// What a set is worth, whatever is required; `None` where it has no value.
    pub fn worth_of(&self, set: &[usize]) -> Option<Worth> {
        self.merit(&self.joint(set), None).worth
    }

    /// What counts are asked for.
    pub fn wanted_counts(&self) -> WantedCounts {
        WantedCounts::from_scores(
            std::iter::once(self.goal.0).chain(self.require.iter().map(|require| require.0)),
        )
    }

    /// How good counts are.
    fn merit_of(&self, counts: &[Confusion]) -> Merit {
        let lacking =
            |&(score, over, least): &(Score, Across, Ratio)| match Worth::from_counts(score, over, counts) {
                Some(worth) if worth.reaches(least) => 0.0,
                Some(worth) => (worth.value() - least.value()).min(-1e-12),
                None => -2.0,
            };
        let (score, over) = self.goal;
        Merit {
            lacking: self.require.iter().map(lacking).sum(),
            worth: Worth::from_counts(score, over, counts),
        }
    }

    /// How good some candidates are together, with one more or as they are.
    pub fn merit(&self, joint: &JointCandidates, more: Option<(usize, &Row)>) -> Merit {
        self.merit_of(&self.counts_with(joint, more, self.wanted_counts()))
    }

    fn counts_with(
        &self,
        joint: &JointCandidates,
        more: Option<(usize, &Row)>,
        wanted: WantedCounts,
    ) -> Vec<Confusion> {
        match (joint, &self.odds) {
            (JointCandidates::Union(union), _) => {
                self.evidence.counts_of(union, more.map(|(_, row)| row), wanted)
            }
            (JointCandidates::Rows(rows), Some(odds)) => {
                let rows = rows.iter().map(|(item, row)| (*item, row)).chain(more);
                let planes = odds.fuse(self.evidence, &rows.collect::<Vec<_>>());
                self.evidence.counts_of_planes(&planes, |_| &[], wanted)
            }
            (JointCandidates::Rows(_), None) => unreachable!("rows are kept where they are added up"),
        }
    }

    /// What a set is worth, if it has a value and meets every requirement.
    pub fn evaluate(&self, set: &[usize]) -> Option<FoundSet> {
        let merit = self.merit(&self.joint(set), None);
        let mut set = set.to_vec();
        set.sort_unstable();
        merit.worth.filter(|_| merit.meets_all()).map(|worth| FoundSet { set, worth })
    }
}

impl Merit {
    /// Whether every requirement is met.
    pub fn meets_all(&self) -> bool {
        self.lacking == 0.0
    }
}
