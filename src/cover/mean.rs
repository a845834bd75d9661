//! Whether any set has a better mean of scores.
//!
//! # Theory
//! No inequality says which sets have a mean above another. But each score of the mean only rises with the voxels that
//! are called rightly, and of these a set has no more than the sum of what its sensors add one by one. So what some
//! candidates have, with the most that any others add at each moment, bounds the mean of all sets they are part of. False alarms
//! are left out, which makes no score lower.
//!
//! Scores are quotients of whole numbers that floating point holds, rounded once, and sums are rounded in one order: so
//! the rounded bound is never below the rounded mean.
//!
//! # Practice
//! First what candidates add is taken from the smaller set, which is too much and at hand; only for what is left is it
//! counted.

use rayon::prelude::*;

use super::evidence::Union;
use super::layout::{CLEAR, FALSE, HIT, MomentBits, SEEN, SPACE_OF};
use super::problem::{FoundSet, JointCandidates, Problem};
use super::rules::SetLimits;
use perirobot_march::metrics::{Confusion, Score};

/// The largest whole number below which floating point holds all.
const EXACT: u64 = 1 << 53;

/// Looks for a set with a better mean.
pub(super) struct MeanSearch<'a> {
    problem: &'a Problem<'a>,
    limits: SetLimits,
    best: &'a FoundSet,
    /// The planes whose bits count.
    planes: &'static [usize],
    stop: &'a (dyn Fn() -> bool + Sync),
}

/// For each moment how many bits of each plane that counts.
type Bits = Vec<[u32; 2]>;

/// Candidates that may join, each with what it adds at most.
type Open = Vec<(usize, Bits)>;

/// The planes whose bits a score counts; `None` of who is detected.
fn planes(score: Score) -> Option<&'static [usize]> {
    match score {
        Score::F1 | Score::Kappa => Some(&[HIT, CLEAR]),
        Score::HumanSeen => Some(&[SEEN]),
        _ => None,
    }
}

/// Whether a bound of means is known: not of who is detected, nor where numbers are too large.
pub(super) fn bounds_means(problem: &Problem) -> bool {
    let voxels = |moment: &MomentBits| moment.voxels.iter().sum::<u64>();
    let largest = problem.evidence.layout.moments.iter().map(voxels).max().unwrap_or(0);
    let is_exact = largest.checked_mul(largest).is_some_and(|largest| largest < EXACT);
    is_exact && problem.is_searchable() && planes(problem.goal.0).is_some()
}

impl<'a> MeanSearch<'a> {
    /// Of a problem that [`bounds_means`].
    pub(super) fn new(
        problem: &'a Problem<'a>,
        limits: SetLimits,
        best: &'a FoundSet,
        stop: &'a (dyn Fn() -> bool + Sync),
    ) -> Self {
        let planes = planes(problem.goal.0).expect("the score is one of voxels");
        MeanSearch { problem, limits, best, planes, stop }
    }

    /// The first better set, if there is one.
    pub(super) fn better(&self) -> Option<FoundSet> {
        let always = &self.problem.rules.always;
        if let Some(found) = self.evaluate(always) {
            return Some(found);
        }
        let left = self.limits.at_most - always.len();
        if left == 0 {
            return None;
        }
        let union = self.union(always);
        let all = (0..self.problem.evidence.count()).collect::<Vec<_>>();
        let open = self
            .count_candidates(&union, all.into_par_iter().filter(|&item| self.fits(always, item)).collect());
        let open = self.prune(&union, open, left);
        (0..open.len()).into_par_iter().find_map_first(|i| self.search_children(always, &open, i, left))
    }

    /// A better set that has one more candidate, the first of those in order from a place on.
    fn search_children(&self, chosen: &[usize], open: &Open, i: usize, left: usize) -> Option<FoundSet> {
        let set = [chosen, &[open[i].0]].concat();
        if let Some(found) = self.evaluate(&set) {
            return Some(found);
        }
        if left == 1 || (self.stop)() {
            return None;
        }
        let union = self.union(&set);
        let fits = |(item, _): &&(usize, Bits)| self.fits(&set, *item);
        let inherited: Open = open[i + 1..].iter().filter(fits).cloned().collect();
        let inherited = self.prune(&union, inherited, left - 1);
        let open = self.count_candidates(&union, inherited.into_iter().map(|(item, _)| item).collect());
        let open = self.prune(&union, open, left - 1);
        (0..open.len()).find_map(|i| self.search_children(&set, &open, i, left - 1))
    }

    fn evaluate(&self, set: &[usize]) -> Option<FoundSet> {
        self.problem.evaluate(set).filter(|found| !set.is_empty() && found.worth > self.best.worth)
    }

    fn fits(&self, chosen: &[usize], item: usize) -> bool {
        let cost = self.problem.rules.cost_of(chosen) + self.problem.rules.cost[item];
        self.limits.afford(cost) && self.problem.rules.may_join(chosen, item)
    }

    fn union(&self, set: &[usize]) -> Union {
        match self.problem.joint(set) {
            JointCandidates::Union(union) => union,
            JointCandidates::Rows(_) => unreachable!("sums are not searched"),
        }
    }

    /// What candidates add to a union.
    fn count_candidates(&self, union: &Union, items: Vec<usize>) -> Open {
        let adds = |item: usize| (item, self.added_bits(union, item));
        items.into_par_iter().map(adds).collect()
    }

    fn added_bits(&self, union: &Union, item: usize) -> Bits {
        let evidence = self.problem.evidence;
        let of = |moment: &MomentBits| {
            let mut bits = [0; 2];
            for (bits, &plane) in bits.iter_mut().zip(self.planes) {
                let words = moment.words[SPACE_OF[plane]].clone();
                let row = evidence.plane(item, plane);
                let Some(row) = row.get(words.clone()) else { continue };
                *bits = evidence.ones.count_minus(row, &union.plane(plane)[words]) as u32;
            }
            bits
        };
        evidence.layout.moments.iter().map(of).collect()
    }

    /// The candidates that may lead to a better mean with others of the list, the most promising first.
    fn prune(&self, union: &Union, open: Open, left: usize) -> Open {
        let (moments, ones) = (&self.problem.evidence.layout.moments, self.problem.evidence.ones);
        let has = |moment: &MomentBits| {
            let of = |&plane: &usize| {
                let words = moment.words[SPACE_OF[plane]].clone();
                let row = &union.plane(plane)[words.clone()];
                match plane {
                    // Where somebody calls a voxel occupied it is not free.
                    CLEAR => ones.count_minus(row, &union.plane(FALSE)[words]),
                    _ => ones.count(row),
                }
            };
            let mut all = [0; 2];
            all.iter_mut().zip(self.planes).for_each(|(all, plane)| *all = of(plane));
            all
        };
        let mut most: Vec<[u64; 2]> = moments.iter().map(has).collect();
        for (number, most) in most.iter_mut().enumerate() {
            for (plane, most) in most.iter_mut().enumerate() {
                let mut gains: Vec<u32> = open.iter().map(|(_, bits)| bits[number][plane]).collect();
                gains.sort_unstable_by(|a, b| b.cmp(a));
                *most += gains.iter().take(left - 1).map(|&gain| u64::from(gain)).sum::<u64>();
            }
        }
        let bound = |bits: &Bits| {
            let with = most.iter().zip(bits).map(|(most, bits)| [0, 1].map(|i| most[i] + u64::from(bits[i])));
            self.mean_of(&with.collect::<Vec<_>>())
        };
        let is_more = |bound: f64| bound > self.best.worth.value();
        let mut kept: Vec<(f64, (usize, Bits))> =
            open.into_iter().map(|one| (bound(&one.1), one)).filter(|(bound, _)| is_more(*bound)).collect();
        kept.sort_by(|(a, one), (b, other)| b.total_cmp(a).then(one.0.cmp(&other.0)));
        kept.into_iter().map(|(_, one)| one).collect()
    }

    /// The mean of scores where so many voxels are called rightly, and none wrongly. Of a moment without a truth the score is
    /// zero, or there is none, which is better for a mean above zero.
    fn mean_of(&self, right: &[[u64; 2]]) -> f64 {
        let (mut sum, mut count) = (0.0, 0);
        for (moment, right) in self.problem.evidence.layout.moments.iter().zip(right) {
            let [t, f] = moment.voxels;
            let people: u64 = moment.parts.iter().map(|part| part.voxels).sum();
            let mut counts = Confusion::default();
            let has_value = match self.problem.goal.0 {
                Score::HumanSeen => {
                    counts.human.uo = people;
                    counts.detection.hit_human = right[0].min(people);
                    people > 0
                }
                score => {
                    [counts.tp, counts.tn] = [right[0].min(t), right[1].min(f)];
                    [counts.uo, counts.uf] = [t - counts.tp, f - counts.tn];
                    t > 0 && (f > 0 || score == Score::F1)
                }
            };
            if let Some(value) = self.problem.goal.0.evaluate(&counts).filter(|_| has_value) {
                sum += value;
                count += 1;
            }
        }
        if count == 0 { 0.0 } else { f64::max(sum / f64::from(count), 0.0) }
    }
}
