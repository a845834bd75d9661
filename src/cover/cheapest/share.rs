//! A score that a set must reach, also without some of its members, and what its inequalities say of a set.

use rayon::prelude::*;

use super::super::budget::Budget;
use super::super::evidence::{CandidateEvidence, Union};
use super::super::layout::{FALSE, PLANES};
use super::super::problem::Problem;
use super::super::question::{Inequality, UnionState, score_inequalities};
use super::super::rules::{SetLimits, SetRules};
use super::super::worth::Ratio;
use super::demand::Demand;
use perirobot_march::metrics::{Across, Score};

/// A score that a set must reach, also with some of its members dead.
#[derive(Clone, Copy, Debug)]
pub struct Share<'a> {
    /// What the candidates say in the region in which it is counted.
    pub problem: &'a Problem<'a>,
    /// The score.
    pub score: Score,
    /// How the counts of several moments are combined.
    pub over: Across,
    /// What it must be: at least this, or at most this if less is better.
    pub limit: Ratio,
    /// The number of members that may be dead, whichever they are.
    pub dead: usize,
}

/// A number of bits of one moment that a passing set covers at least, also with some of its members dead.
#[derive(Clone, Copy, Debug)]
pub struct Coverage<'a> {
    /// What each candidate covers: its bits in the plane [`HIT`](super::super::layout::HIT).
    pub evidence: &'a CandidateEvidence,
    /// The moment.
    pub moment: usize,
    /// How many bits are covered.
    pub least: u64,
    /// The number of members that may be dead, whichever they are.
    pub dead: usize,
}

impl<'a> Coverage<'a> {
    pub(super) fn bound(&self) -> ShareBound<'a> {
        let Coverage { evidence, moment, least, dead } = *self;
        let inequality = Inequality::covered(&evidence.layout, moment, least);
        ShareBound { evidence, inequality, dead, may_be_wrong: false }
    }
}

/// An inequality that holds for every set that reaches a share.
pub(super) struct ShareBound<'a> {
    evidence: &'a CandidateEvidence,
    inequality: Inequality,
    dead: usize,
    /// Whether a member may make a set worse.
    may_be_wrong: bool,
}

impl<'a> Share<'a> {
    /// The inequalities of a set that reaches it.
    pub(super) fn bounds(&self) -> Vec<ShareBound<'a>> {
        bounds(self.problem, (self.score, self.over), (self.limit, false), self.dead)
    }
}

/// The inequalities of a set that reaches a score or, with `beat`, exceeds it. There are none if the score is of labels
/// that are sums of what sensors say; a union has no fewer labels than such a sum, and so it bounds the unknown share.
pub(super) fn bounds<'a>(
    problem: &'a Problem<'a>,
    (score, over): (Score, Across),
    (limit, beat): (Ratio, bool),
    dead: usize,
) -> Vec<ShareBound<'a>> {
    if problem.asking(score, over).adds_up() {
        return Vec::new();
    }
    let evidence = problem.evidence;
    let only_gains =
        matches!(score, Score::HumanSeen | Score::Unknown | Score::PeopleDetected | Score::PartsDetected);
    let may_be_wrong = !only_gains && (0..evidence.count()).any(|item| evidence.has_bits(item, FALSE));
    let all = score_inequalities(&evidence.layout, (score, over), limit, beat);
    all.into_iter().map(|inequality| ShareBound { evidence, inequality, dead, may_be_wrong }).collect()
}

/// A part of a set: without members that are dead.
struct SetPart {
    union: Union,
    /// How many of the members that may be added are dead.
    dead_later: usize,
}

/// What shares say of a node: for each inequality and each part of the set what it has and what it lacks.
pub(super) struct ShareStates<'s> {
    rules: &'s SetRules,
    /// The candidates that may join.
    allowed: &'s [usize],
    entries: Vec<Entry>,
    joint: Joint,
}

/// Everything that a set lacks, as one covering inequality. Each unmet inequality or demand counts as one lack, and a
/// candidate contributes to it the part of the lack that it gains, at most 1. The members that are added to a passing set
/// contribute at least the number of lacks.
#[derive(Default)]
struct Joint {
    /// The number of lacks, in units.
    lacks: i64,
    /// What each candidate that may join adds at most, in units, rounded up.
    adds: Vec<i64>,
    /// The places of those that add something, who adds most first.
    order: Vec<usize>,
}

/// The units of a lack.
const UNITS: i64 = 1 << 24;

/// An inequality of a part of the set.
struct Entry {
    value: i64,
    least: i64,
    dead_later: usize,
    /// What each candidate that may join adds at most.
    gains: Vec<i64>,
    /// The places of those that add something, who adds most first.
    order: Vec<usize>,
}

/// Ends a look at shares: this one is out of reach, by its number, or all together are.
pub(super) struct OutOfReach(pub(super) Option<usize>);

/// What else a set may have: with each number of members that may be dead.
struct Budgets(Vec<Budget>);

impl Budgets {
    fn new(rules: &SetRules, limits: SetLimits, chosen: &[usize], most_dead: usize) -> Budgets {
        let cost = rules.cost_of(chosen);
        let left = |dead| limits.at_most.saturating_sub(chosen.len() + dead);
        Budgets((0..=most_dead).map(|dead| Budget::new(rules, limits, chosen, cost, left(dead))).collect())
    }
}

impl<'s> ShareStates<'s> {
    /// What inequalities and demands say of a set; as soon as one, or all together, are out of reach with all candidates
    /// that may join, that is the answer. The inequality with the number `first` is looked at first.
    pub(super) fn new(
        (bounds, demands, first): (&[ShareBound], &[Demand], usize),
        (rules, limits): (&'s SetRules, SetLimits),
        chosen: &[usize],
        allowed: &'s [usize],
    ) -> Result<ShareStates<'s>, OutOfReach> {
        let most_dead = bounds.iter().map(|bound| bound.dead).max().unwrap_or(0);
        let mut states = ShareStates { rules, allowed, entries: Vec::new(), joint: Joint::default() };
        let budgets = Budgets::new(rules, limits, chosen, most_dead);
        // Parts of sets are made once for inequalities of the same evidence.
        let mut known: Vec<(&CandidateEvidence, usize, Vec<SetPart>)> = Vec::new();
        let others = (0..bounds.len()).filter(|&number| number != first);
        for number in (first..bounds.len()).take(1).chain(others) {
            let bound = &bounds[number];
            let is_same = |&(evidence, dead, _): &(&CandidateEvidence, usize, Vec<SetPart>)| {
                std::ptr::eq(evidence, bound.evidence) && dead == bound.dead
            };
            if !known.iter().any(is_same) {
                let parts = parts(bound.evidence, chosen, bound.dead, planes(bounds, bound.evidence));
                known.push((bound.evidence, bound.dead, parts));
            }
            let parts = known.iter().find(|one| is_same(one)).map_or(&[][..], |(.., parts)| parts);
            // A set to which fewer are added than may be dead can be better than its part without the dead.
            for part in parts.iter().filter(|part| part.dead_later == 0 || !bound.may_be_wrong) {
                let entry = Entry::new(bound, part, allowed);
                if !states.reaches(&entry, entry.least - entry.value, &budgets.0[entry.dead_later], &|_| true)
                {
                    return Err(OutOfReach(Some(number)));
                }
                states.entries.push(entry);
            }
        }
        states.joint = states.join(demands, chosen);
        match states.joint.may_reach(&states, states.joint.lacks, &budgets.0[0], &|_| true) {
            true => Ok(states),
            false => Err(OutOfReach(None)),
        }
    }

    /// Everything that a set lacks. Parts that lose members later are left out: what joins may be dead there.
    fn join(&self, demands: &[Demand], chosen: &[usize]) -> Joint {
        let mut joint = Joint { adds: vec![0; self.allowed.len()], ..Joint::default() };
        for entry in self.entries.iter().filter(|entry| entry.dead_later == 0 && entry.value < entry.least) {
            let lacks = i128::from(entry.least - entry.value);
            joint.lacks += UNITS;
            for (adds, &gain) in joint.adds.iter_mut().zip(&entry.gains) {
                let gain = i128::from(gain).min(lacks) * i128::from(UNITS);
                *adds += ((gain + lacks - 1) / lacks) as i64;
            }
        }
        for demand in demands {
            let lacks = demand.lacks(chosen) as i64;
            if lacks > 0 {
                joint.lacks += UNITS;
                let each = (UNITS + lacks - 1) / lacks;
                let among = joint.adds.iter_mut().zip(self.allowed).filter(|(_, item)| demand.has(**item));
                among.for_each(|(adds, _)| *adds += each);
            }
        }
        joint.order = largest_first(&joint.adds);
        joint
    }

    /// Whether a set with some more candidates can reach all shares: with the one at a place, if there is one, and others
    /// that `may_join`, by their places. By what is known without that one: what the others add beside it is not more.
    pub(super) fn may_reach(
        &self,
        limits: SetLimits,
        chosen: &[usize],
        with: Option<usize>,
        may_join: &dyn Fn(usize) -> bool,
    ) -> bool {
        let most_dead = self.entries.iter().map(|entry| entry.dead_later).max().unwrap_or(0);
        let more: Vec<usize> = chosen.iter().copied().chain(with.map(|place| self.allowed[place])).collect();
        let budgets = Budgets::new(self.rules, limits, &more, most_dead);
        let gain = |gains: &[i64]| with.map_or(0, |place| gains[place]);
        let reaches = |entry: &Entry| {
            let (lacks, dead) = (entry.least - entry.value, entry.dead_later);
            let alive = self.reaches(entry, lacks - gain(&entry.gains), &budgets.0[dead], may_join);
            // The one that joins may be dead itself.
            alive
                && (with.is_none() || dead == 0 || self.reaches(entry, lacks, &budgets.0[dead - 1], may_join))
        };
        let lacks = self.joint.lacks - gain(&self.joint.adds);
        self.joint.may_reach(self, lacks, &budgets.0[0], may_join) && self.entries.iter().all(reaches)
    }

    fn reaches(&self, entry: &Entry, lacks: i64, budget: &Budget, may_join: &dyn Fn(usize) -> bool) -> bool {
        entry.value >= entry.least || self.add_up((&entry.gains, &entry.order), lacks, budget, may_join)
    }

    /// Whether some candidates, as many as a budget has room for, can add `lacks` together.
    fn add_up(
        &self,
        (gains, order): (&[i64], &[usize]),
        lacks: i64,
        budget: &Budget,
        may_join: &dyn Fn(usize) -> bool,
    ) -> bool {
        if lacks <= 0 {
            return true;
        }
        let places: Vec<usize> = order.iter().copied().filter(|&place| may_join(place)).collect();
        // Whatever they cost.
        let top: i64 = places.iter().take(budget.left()).map(|&place| gains[place]).sum();
        let sorted = places.iter().map(|&place| (self.allowed[place], gains[place]));
        top >= lacks && budget.most(self.rules, sorted, |at| gains[places[at]]) >= lacks
    }

    /// Whether an inequality says that the set itself fails.
    pub(super) fn surely_fails(&self) -> bool {
        self.entries.iter().any(|entry| entry.dead_later == 0 && entry.value < entry.least)
    }

    /// The candidates in the order in which they add most to all that is lacking, by their places.
    pub(super) fn best_first(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.allowed.len()).collect();
        let price = |place: usize| self.rules.cost[self.allowed[place]];
        order.sort_by_key(|&place| (std::cmp::Reverse(self.joint.adds[place]), price(place)));
        order
    }

    /// What a candidate adds to all that is lacking, in lacks.
    pub(super) fn helps(&self, place: usize) -> f64 {
        self.joint.adds[place] as f64 / UNITS as f64
    }
}

impl Joint {
    fn may_reach(
        &self,
        states: &ShareStates,
        lacks: i64,
        budget: &Budget,
        may_join: &dyn Fn(usize) -> bool,
    ) -> bool {
        states.add_up((&self.adds, &self.order), lacks, budget, may_join)
    }
}

/// The places of numbers above zero, the largest first.
fn largest_first(numbers: &[i64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..numbers.len()).filter(|&place| numbers[place] > 0).collect();
    order.sort_unstable_by_key(|&place| (std::cmp::Reverse(numbers[place]), place));
    order
}

impl Entry {
    fn new(bound: &ShareBound, part: &SetPart, allowed: &[usize]) -> Entry {
        let (evidence, one) = (bound.evidence, &bound.inequality);
        let state: UnionState = one.state(evidence, &part.union);
        let gains: Vec<i64> = match state.value >= one.least {
            true => vec![0; allowed.len()],
            false => allowed.par_iter().map(|&item| one.gain(evidence, &part.union, &state, item)).collect(),
        };
        let order = largest_first(&gains);
        Entry { value: state.value, least: one.least, dead_later: part.dead_later, gains, order }
    }
}

/// The planes of some evidence that inequalities look at.
fn planes(bounds: &[ShareBound], evidence: &CandidateEvidence) -> [bool; PLANES] {
    let mut wanted = [false; PLANES];
    for bound in bounds.iter().filter(|bound| std::ptr::eq(bound.evidence, evidence)) {
        bound.inequality.segments().for_each(|segment| wanted[segment.plane] = true);
        wanted[FALSE] |= bound.may_be_wrong;
    }
    wanted
}

/// The parts of a set that are left if `dead` of its present and future members are dead.
fn parts(
    evidence: &CandidateEvidence,
    chosen: &[usize],
    dead: usize,
    planes: [bool; PLANES],
) -> Vec<SetPart> {
    let union = |without: &[usize]| {
        let mut union = evidence.nothing();
        let own = chosen.iter().enumerate().filter(|(place, _)| !without.contains(place));
        own.for_each(|(_, &item)| union.add_planes(evidence, item, planes));
        union
    };
    let all: Vec<usize> = (0..chosen.len()).collect();
    let mut parts = Vec::new();
    for now in 0..=dead.min(chosen.len()) {
        let some = left_out(&all, now);
        parts.extend(some.iter().map(|without| SetPart { union: union(without), dead_later: dead - now }));
    }
    // Those without later losses first: they are the smallest.
    parts.reverse();
    parts
}

/// All combinations of `count` of some numbers.
pub(super) fn left_out(of: &[usize], count: usize) -> Vec<Vec<usize>> {
    match (count, of) {
        (0, _) => vec![Vec::new()],
        (_, []) => Vec::new(),
        (_, [first, rest @ ..]) => {
            let with = left_out(rest, count - 1).into_iter().map(|mut more| {
                more.insert(0, *first);
                more
            });
            with.chain(left_out(rest, count)).collect()
        }
    }
}
