//! An upper bound for all sets, where the search is long, with a proof that a few numbers state.
//!
//! # Theory
//! Take any set H of voxels. A set of sensors covers at most all of H and, for each sensor, the voxels that it
//! sees outside H. That is a *cut*: an upper bound for the value of an inequality that is linear in the sensors.
//! Multiply cuts by weights and add them. If even the best sensors, each taken alone, leave the sum below what
//! the inequalities ask for, no set passes.
//!
//! Good cuts come from the linear program in which a candidate may be taken in part, as a share between 0 and 1:
//! H is then the voxels whose shares add up to one or more (Benders 1962). Each cut is made between the program's
//! optimum and the best shares so far (Ben-Ameur and Neto 2007). `game` solves the program in floating point,
//! which proves nothing: shares are rounded to 256ths and weights to whole numbers, and the proof is checked with
//! these.

use fearless_simd::{Level, Simd, dispatch};
use rayon::prelude::*;

use super::evidence::CandidateEvidence;
use super::game::Game;
use super::layout::ones;
use super::problem::{Problem, SetLimits};
use super::question::{Inequality, Segment, question};
use super::worth::{Ratio, Worth};

/// Into how many parts a candidate is divided.
pub(super) const SHARES: u64 = 256;
/// Into how many parts a score is divided.
const SCORES: i128 = 1_000_000;
/// The search for a bound ends when it is known to so many parts.
const CLOSE: i128 = 100;
/// Rounds of cuts that are made for one score before it is given up.
const ROUNDS: usize = 60;
/// Rounds without progress after which a score is given up.
const PATIENCE: usize = 3;
/// How far from the optimum towards the best shares so far each cut is made, in turn.
const NEARER: [f64; 4] = [0.5, 0.25, 0.1, 0.0];
/// The least heat: where weights are to prove something.
const COLD: f64 = 1e-7;
/// The most heat: where little is known.
const WARM: f64 = 1e-3;
/// The largest weight of the budget.
const MOST_BUDGETS: u64 = 1 << 60;
/// The largest weight of a cut.
const HEAVIEST: f64 = 1048576.0;

/// A proof that no allowed set is worth more than a bound.
#[derive(Clone, Debug, PartialEq)]
pub struct Gap {
    /// A proved upper bound for the worth of every set.
    pub(super) above: Ratio,
    pub(super) cuts: Vec<WeightedCut>,
    /// The weight of the budget.
    pub(super) budget: u64,
}

impl Gap {
    /// A proved upper bound for the worth of every set.
    pub fn above(&self) -> f64 {
        self.above.value()
    }
}

/// A cut with its weight.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct WeightedCut {
    /// The moment whose score it is about, if the worst one counts; else 0.
    pub(super) moment: usize,
    pub(super) times: u64,
    /// Candidates and their shares, in 256ths.
    pub(super) shares: Vec<(usize, u64)>,
}

/// A cut: counts of bits, segment by segment of an inequality.
struct CountedCut {
    inequality: usize,
    shares: Vec<(usize, u64)>,
    /// How many bits are in H.
    inside: Vec<u64>,
    /// How many bits of each candidate are not in H, candidate by candidate.
    outside: Vec<u32>,
}

impl CountedCut {
    /// The value without candidates less the threshold, and what each candidate adds, both divided by the threshold.
    fn of(&self, one: &Inequality) -> (f64, Vec<f64>) {
        let weights: Vec<f64> =
            one.segments().map(|segment| segment.weight as f64 / one.least.max(1) as f64).collect();
        let inside: f64 =
            weights.iter().zip(&self.inside).map(|(weight, &count)| weight * count as f64).sum();
        let weigh =
            |row: &[u32]| weights.iter().zip(row).map(|(weight, &count)| weight * f64::from(count)).sum();
        (inside - 1.0, self.outside.chunks(weights.len()).map(weigh).collect())
    }
}

/// Searches for the lowest bound that cuts can prove.
pub(super) struct GapSearch<'a> {
    /// Without requirements, which only leave fewer sets.
    problem: Problem<'a>,
    limits: SetLimits,
    /// The candidates that can be in a set.
    items: Vec<usize>,
    cuts: Vec<CountedCut>,
    /// The best shares so far.
    best: Vec<f64>,
    level: Level,
    stop: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> GapSearch<'a> {
    pub(super) fn new(
        problem: &'a Problem<'a>,
        limits: SetLimits,
        stop: &'a (dyn Fn() -> bool + Sync),
    ) -> Self {
        let fits = |item: &usize| {
            problem.always.contains(item)
                || limits.afford(problem.cost_of(&problem.always) + problem.cost[*item])
                    && problem.may_join(&problem.always, *item)
        };
        let items = (0..problem.evidence.count()).filter(fits).collect();
        GapSearch {
            problem: problem.asking(problem.goal.0, problem.goal.1),
            limits,
            items,
            cuts: Vec::new(),
            best: Vec::new(),
            level: Level::new(),
            stop,
        }
    }

    /// The proof of the lowest bound that is found.
    pub(super) fn run(mut self, known: Worth) -> Option<Gap> {
        let first = (known.value() * SCORES as f64).ceil() as i128;
        let (mut low, mut high, mut best) = (first, SCORES, None);
        // Most bounds are near the best known score.
        let mut next = low + 10 * CLOSE;
        while high - low > CLOSE && !(self.stop)() {
            let tried = next.clamp(low + 1, high - 1);
            match self.prove(Ratio { numerator: tried, denominator: SCORES }) {
                Some(gap) => (high, best) = (tried, Some(gap)),
                None => low = tried,
            }
            next = if best.is_some() { (low + high) / 2 } else { tried + 2 * (tried - first) };
        }
        best
    }

    /// A proof that no set is worth more than a score, if cuts give one.
    fn prove(&mut self, above: Ratio) -> Option<Gap> {
        let all = question(&self.problem, Some(Worth::Exact(above))).all;
        // The first of several is the sum of the others.
        let all = &all[usize::from(all.len() > 1)..];
        if all.is_empty() || !all.iter().all(Inequality::is_plain) {
            return None;
        }
        let (count, left) = (self.items.len(), self.limits.at_most);
        if self.cuts.is_empty() {
            self.best = vec![0.0; count];
        }
        // The best value that shares have so far, and the lowest that cuts allow.
        let mut had = self.cut(all, &self.best.clone());
        let (mut allowed, mut patience, mut weights) = (f64::INFINITY, PATIENCE, Vec::new());
        for round in 0..ROUNDS {
            if (self.stop)() {
                return None;
            }
            let game = self.game(all);
            if round % NEARER.len() == 0 {
                let (cold, _) = game.settle(left, COLD, &mut weights);
                let most = game.most(&cold, left);
                if most < 0.0
                    && let Some(gap) = self.checked(all, above, &cold)
                {
                    return Some(gap);
                }
                if most > allowed - (most - had).abs() / 20.0 {
                    patience -= 1;
                    if patience == 0 {
                        return None;
                    }
                }
                allowed = allowed.min(most);
            }
            let heat = ((allowed - had) / (10 * self.cuts.len()) as f64).clamp(COLD, WARM);
            let (_, shares) = game.settle(left, heat, &mut weights);
            let near = NEARER[round % NEARER.len()];
            let tried: Vec<f64> = self
                .best
                .iter()
                .zip(&shares)
                .map(|(best, share)| near * best + (1.0 - near) * share)
                .collect();
            let cuts = self.cuts.len();
            let has = self.cut(all, &tried);
            if self.cuts.len() == cuts && round % NEARER.len() == NEARER.len() - 1 {
                // No cut is new, so the bound does not get lower.
                return self.checked(all, above, &self.game(all).settle(left, COLD, &mut weights).0);
            }
            if has > had {
                (had, self.best) = (has, tried);
            }
            // These shares pass, so no cuts can exclude all sets.
            if had >= 0.0 {
                return None;
            }
        }
        None
    }

    /// The linear program of all cuts, each divided by its threshold.
    fn game(&self, all: &[Inequality]) -> Game {
        let (mut constant, mut added) = (Vec::new(), Vec::new());
        for cut in &self.cuts {
            let (inside, outside) = cut.of(&all[cut.inequality]);
            constant.push(inside);
            added.push(outside);
        }
        if let Some(budget) = self.limits.budget.filter(|&budget| budget > 0) {
            let part = |&item: &usize| -(self.problem.cost[item] as f64) / budget as f64;
            constant.push(1.0);
            added.push(self.items.iter().map(part).collect());
        }
        Game { constant, added, cuts: self.cuts.len() }
    }

    /// Adds the cut of each inequality at some shares, and returns the lowest value that these have in any.
    fn cut(&mut self, all: &[Inequality], shares: &[f64]) -> f64 {
        let share_of = rounded(shares);
        let shares: Vec<(usize, u64)> = self
            .items
            .iter()
            .copied()
            .zip(share_of.iter().copied())
            .filter(|&(_, share)| share > 0)
            .collect();
        let evidence = self.problem.evidence;
        let of = |(inequality, one): (usize, &Inequality)| {
            let (mut inside, mut outside) = (Vec::new(), vec![Vec::new(); one.segments().count()]);
            for (segment, outside) in one.segments().zip(&mut outside) {
                let hidden = full(evidence, segment, &shares);
                inside.push(ones(hidden.iter().copied()));
                let level = self.level;
                *outside = self
                    .items
                    .par_iter()
                    .map(|&item| {
                        let row = evidence.plane(item, segment.plane);
                        if row.is_empty() {
                            0
                        } else {
                            dispatch!(level, simd => beyond(simd, &row[segment.words.clone()], &hidden))
                        }
                    })
                    .collect::<Vec<u32>>();
            }
            let count = self.items.len();
            let outside = (0..count).flat_map(|i| outside.iter().map(move |of| of[i])).collect();
            CountedCut { inequality, shares: shares.clone(), inside, outside }
        };
        let cuts: Vec<CountedCut> = all.iter().enumerate().map(of).collect();
        let share = |place: &usize| share_of[*place] as f64 / SHARES as f64;
        let has = |cut: &CountedCut| {
            let (inside, outside) = cut.of(&all[cut.inequality]);
            inside + (0..outside.len()).map(|i| outside[i] * share(&i)).sum::<f64>()
        };
        let least = cuts.iter().map(has).fold(f64::INFINITY, f64::min);
        for cut in cuts {
            let is_same = |other: &CountedCut| {
                (other.inequality, &other.inside, &other.outside)
                    == (cut.inequality, &cut.inside, &cut.outside)
            };
            if !self.cuts.iter().any(is_same) {
                self.cuts.push(cut);
            }
        }
        least
    }

    /// The proof with weights rounded to whole numbers, if it still holds.
    fn checked(&self, all: &[Inequality], above: Ratio, weights: &[f64]) -> Option<Gap> {
        // Weights are for cuts divided by their thresholds; these are for whole ones.
        let (cuts, budget) = weights.split_at(self.cuts.len());
        let often = |(cut, weight): (&CountedCut, &f64)| weight / all[cut.inequality].exact.1.max(1) as f64;
        let often: Vec<f64> = self.cuts.iter().zip(cuts).map(often).collect();
        let factor = HEAVIEST / often.iter().copied().fold(0.0, f64::max);
        let times: Vec<u64> = often.iter().map(|often| (often * factor).round() as u64).collect();
        let spent = self.limits.budget.unwrap_or(0);
        let budget =
            budget.first().map_or(0, |&weight| (weight / spent as f64 * factor) as u64).min(MOST_BUDGETS);
        let mut most = i128::from(budget) * i128::from(spent);
        let mut added = vec![0i128; self.items.len()];
        for (added, &item) in added.iter_mut().zip(&self.items) {
            *added = -i128::from(budget) * i128::from(self.problem.cost[item]);
        }
        for (cut, &times) in self.cuts.iter().zip(&times).filter(|(_, times)| **times > 0) {
            let (weights, wanted) = &all[cut.inequality].exact;
            let weigh = |counts: &mut dyn Iterator<Item = u64>| -> i128 {
                weights.iter().zip(counts).map(|(weight, count)| weight * i128::from(count)).sum()
            };
            let times = i128::from(times);
            most += times * (weigh(&mut cut.inside.iter().copied()) - wanted);
            let wide = cut.inside.len();
            for (added, row) in added.iter_mut().zip(cut.outside.chunks(wide)) {
                *added += times * weigh(&mut row.iter().map(|&count| u64::from(count)));
            }
        }
        let always = &self.problem.always;
        let is_fixed = |i: &usize| always.contains(&self.items[*i]);
        most += (0..added.len()).filter(is_fixed).map(|i| added[i]).sum::<i128>();
        let mut free: Vec<i128> =
            (0..added.len()).filter(|i| !is_fixed(i)).map(|i| added[i].max(0)).collect();
        free.sort_unstable_by_key(|&added| std::cmp::Reverse(added));
        most += free.iter().take(self.limits.at_most - always.len()).sum::<i128>();
        let cuts = self.cuts.iter().zip(&times).filter(|(_, times)| **times > 0);
        let weighted = |(cut, &times): (&CountedCut, &u64)| WeightedCut {
            moment: all[cut.inequality].moment,
            times,
            shares: cut.shares.clone(),
        };
        (most < 0).then(|| Gap { above, cuts: cuts.map(weighted).collect(), budget })
    }
}

/// Shares rounded to parts, so that their sum is kept.
fn rounded(shares: &[f64]) -> Vec<u64> {
    let parts: Vec<f64> = shares.iter().map(|share| share * SHARES as f64).collect();
    let mut whole: Vec<u64> = parts.iter().map(|part| *part as u64).collect();
    let rest = parts.iter().sum::<f64>().round() as u64 - whole.iter().sum::<u64>();
    let mut order: Vec<usize> = (0..parts.len()).collect();
    order.sort_by(|&a, &b| (parts[b] - whole[b] as f64).total_cmp(&(parts[a] - whole[a] as f64)));
    order.iter().take(rest as usize).for_each(|&i| whole[i] += 1);
    whole
}

/// The bits whose shares add up to one or more.
fn full(evidence: &CandidateEvidence, segment: &Segment, shares: &[(usize, u64)]) -> Vec<u64> {
    let wide = segment.words.len();
    // For each word the eight binary digits of the sums of its 64 voxels, and which of these overflowed.
    let (mut sums, mut full) = (vec![[0u64; 8]; wide], vec![0u64; wide]);
    for &(item, share) in shares {
        let row = evidence.plane(item, segment.plane);
        if row.is_empty() {
            continue;
        }
        for ((sum, full), &word) in sums.iter_mut().zip(&mut full).zip(&row[segment.words.clone()]) {
            let mut carry = 0;
            for (bit, sum) in sum.iter_mut().enumerate() {
                let add = if share >> bit & 1 == 1 { word } else { 0 };
                (*sum, carry) = (*sum ^ add ^ carry, (*sum & add) | (carry & (*sum ^ add)));
            }
            *full |= carry | if share >= SHARES { word } else { 0 };
        }
    }
    full
}

/// The bits of a row that are not hidden.
#[inline(always)]
fn beyond<S: Simd>(_: S, row: &[u64], hidden: &[u64]) -> u32 {
    ones(row.iter().zip(hidden).map(|(row, hidden)| row & !hidden)) as u32
}
