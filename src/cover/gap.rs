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

use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::evidence::CandidateEvidence;
use super::lp::Lp;
use super::problem::Problem;
use super::question::{Inequality, Segment, question};
use super::rules::SetLimits;
use super::worth::{Ratio, Worth};
use perirobot_march::metrics::Across;

/// Into how many parts a candidate is divided.
pub(super) const SHARES: u64 = 256;
/// Into how many parts a score is divided.
const SCORES: i128 = 1_000_000;
/// The search for a bound ends when it is known to so many parts.
const CLOSE: i128 = 100;
/// How far from the best known score cuts are made until there is a bound.
const NEAR: i128 = SCORES / 100;
/// The time after which a bound is taken as it is; several share it.
const LONG: Duration = Duration::from_secs(6);
/// Each has so long at least.
const SHORTEST: Duration = Duration::from_millis(500);
/// So many times that where evidence is read from a file.
const SLOWER: u32 = 20;
/// Most rounds of cuts.
const ROUNDS: usize = 200;
/// How often in turn the bound may come nearer by less than one part in so many.
const PATIENCE: usize = 6;
const SLOW: i128 = 50;
/// Cuts of no more weight than this are forgotten, but for so many of the last.
const LIGHT: f64 = 1e-6;
const FRESH: usize = 12;
/// Bits of the largest number that candidates add to a sum of cuts.
const SUM_BITS: u32 = 50;
/// How far from the optimum towards the best shares so far each cut is made, in turn.
const NEARER: [f64; 4] = [0.5, 0.25, 0.1, 0.0];
/// The least temperature: where weights are to prove something.
const COLD: f64 = 1e-7;
/// The most temperature: where little is known.
const WARM: f64 = 1e-3;
/// By which factor the temperature falls where it makes no new cut.
const COOLER: f64 = 0.1;
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
    pub fn upper_bound(&self) -> f64 {
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
#[derive(Clone)]
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
    fn coefficients(&self, one: &Inequality) -> (f64, Vec<f64>) {
        let weights: Vec<f64> =
            one.segments().map(|segment| segment.weight as f64 / one.least.max(1) as f64).collect();
        let inside: f64 =
            weights.iter().zip(&self.inside).map(|(weight, &count)| weight * count as f64).sum();
        let weigh =
            |row: &[u32]| weights.iter().zip(row).map(|(weight, &count)| weight * f64::from(count)).sum();
        (inside - 1.0, self.outside.chunks(weights.len()).map(weigh).collect())
    }
}

/// Cuts with whole weights.
pub(super) struct WeighedCuts {
    cuts: Vec<(u64, CountedCut)>,
    /// The weight of the budget.
    budget: u64,
    /// The candidates that can be in a set.
    items: Vec<usize>,
}

/// What every set that is worth more than a score has: the numbers of its candidates add up to so much.
#[derive(Clone, Debug)]
pub(super) struct CutSum {
    pub(super) least: i64,
    /// Candidate by candidate.
    pub(super) added: Vec<i64>,
}

impl WeighedCuts {
    /// What every set has that is worth more than a known one. A requirement is one more thing that it must
    /// meet.
    pub(super) fn sum(&self, problem: &Problem, limits: SetLimits, known: Worth) -> Option<CutSum> {
        let Worth::Exact(known) = known else { return None };
        // In millionths, so that sums of κ stay within 128 bits.
        let numerator = (known.numerator * SCORES).div_euclid(known.denominator);
        let known = Worth::Exact(Ratio { numerator, denominator: SCORES });
        let all = inequalities(&problem.asking(problem.goal.0, problem.goal.1), known)?;
        let (constant, added) = self.added_up(problem, limits, &all);
        let largest = added.iter().map(|added| added.abs()).max().unwrap_or(0).max(constant.abs());
        let shift = (128 - largest.leading_zeros()).saturating_sub(SUM_BITS);
        let up = |n: i128| (n >> shift) as i64 + i64::from(n & ((1 << shift) - 1) != 0);
        let mut all = vec![0; problem.evidence.count()];
        self.items.iter().zip(&added).for_each(|(&item, &added)| all[item] = up(added));
        Some(CutSum { least: -up(constant), added: all })
    }

    /// The weighted sum of cuts less their thresholds: what it is without candidates, and what each adds.
    fn added_up(&self, problem: &Problem, limits: SetLimits, all: &[Inequality]) -> (i128, Vec<i128>) {
        let spent = limits.budget.unwrap_or(0);
        let mut constant = i128::from(self.budget) * i128::from(spent);
        let cost = |&item: &usize| -i128::from(self.budget) * i128::from(problem.rules.cost[item]);
        let mut added: Vec<i128> = self.items.iter().map(cost).collect();
        for (times, cut) in &self.cuts {
            let (weights, wanted) = &all[cut.inequality].exact;
            let weigh = |counts: &mut dyn Iterator<Item = u64>| -> i128 {
                weights.iter().zip(counts).map(|(weight, count)| weight * i128::from(count)).sum()
            };
            let times = i128::from(*times);
            constant += times * (weigh(&mut cut.inside.iter().copied()) - wanted);
            for (added, row) in added.iter_mut().zip(cut.outside.chunks(cut.inside.len())) {
                *added += times * weigh(&mut row.iter().map(|&count| u64::from(count)));
            }
        }
        (constant, added)
    }
}

impl CutSum {
    /// What some candidates lack of what every set has.
    pub(super) fn lacks(&self, chosen: &[usize]) -> i64 {
        self.least - chosen.iter().map(|&item| self.added[item]).sum::<i64>()
    }
}

/// Searches for the lowest bound that cuts can prove.
pub(super) struct GapSearch<'a> {
    /// Without requirements, which only leave fewer sets.
    problem: Problem<'a>,
    limits: SetLimits,
    /// The only moment whose score counts, if there is one.
    moment: Option<usize>,
    /// The time after which the bound is taken as it is.
    longest: Duration,
    /// The candidates that can be in a set.
    items: Vec<usize>,
    cuts: Vec<CountedCut>,
    /// The best shares so far.
    best: Vec<f64>,
    /// What proves the lowest bound so far.
    shown: Option<WeighedCuts>,
    stop: &'a (dyn Fn() -> bool + Sync),
}

impl<'a> GapSearch<'a> {
    pub(super) fn new(
        problem: &'a Problem<'a>,
        limits: SetLimits,
        stop: &'a (dyn Fn() -> bool + Sync),
    ) -> Self {
        let fits = |item: &usize| {
            problem.rules.always.contains(item)
                || limits.afford(problem.rules.cost_of(&problem.rules.always) + problem.rules.cost[*item])
                    && problem.rules.may_join(&problem.rules.always, *item)
        };
        let items = (0..problem.evidence.count()).filter(fits).collect();
        GapSearch {
            problem: problem.asking(problem.goal.0, problem.goal.1),
            limits,
            moment: None,
            longest: if problem.evidence.is_filed() { LONG * SLOWER } else { LONG },
            items,
            cuts: Vec::new(),
            best: Vec::new(),
            shown: None,
            stop,
        }
    }

    /// A bound for the scores of each moment that has one, for sets whose mean is to be high; the scores of a
    /// known set are begun from. A score that has no value, or is zero, makes no mean higher.
    pub(super) fn moment_bounds(
        problem: &'a Problem<'a>,
        limits: SetLimits,
        known: &[usize],
        stop: &'a (dyn Fn() -> bool + Sync),
    ) -> Option<Vec<Gap>> {
        let each = problem.asking(problem.goal.0, Across::Worst);
        let anything = Worth::Exact(Ratio { numerator: 1, denominator: 2 });
        let moments: Vec<usize> = inequalities(&each, anything)?.iter().map(|one| one.moment).collect();
        let counts = problem.counts(known);
        let of = |&moment: &usize| {
            let known = Worth::from_counts(problem.goal.0, Across::Worst, &counts[moment..=moment])?;
            let whole = GapSearch::new(problem, limits, stop);
            let longest = (whole.longest / moments.len() as u32).max(SHORTEST);
            let search = GapSearch { problem: each.clone(), moment: Some(moment), longest, ..whole };
            Some(search.run(known)?.0)
        };
        moments.iter().map(of).collect()
    }

    /// The proof of the lowest bound that is found.
    pub(super) fn run(mut self, known: Worth) -> Option<(Gap, WeighedCuts)> {
        // A bound is told as a fraction of numbers without a sign.
        let first = ((known.value() * SCORES as f64).ceil() as i128).max(0);
        // Cuts that are made for a score near the best known one are of use for those above it.
        let mut all = self.score_inequalities((first + NEAR).min(SCORES))?;
        self.best = vec![0.0; self.items.len()];
        let (mut high, mut weights, mut patience, mut cooled) = (SCORES, Vec::new(), PATIENCE, 1.0);
        // The best value that shares have so far.
        let mut had = self.cut(&all, &self.best.clone());
        let begin = Instant::now();
        for round in 0..ROUNDS {
            if (self.stop)() || begin.elapsed() > self.longest {
                break;
            }
            if round % NEARER.len() == 0 {
                let before = high;
                loop {
                    let cold = self.lp(&all).solve_at(self.limits.at_most, COLD, &mut weights).0;
                    let weighed = self.weigh(&all, &cold);
                    let Some(score) = self.lowest(first, high, &weighed) else { break };
                    let lower = high - score;
                    (high, self.shown) = (score, Some(weighed));
                    all = self.score_inequalities(high)?;
                    if lower < CLOSE {
                        break;
                    }
                }
                let is_slow = self.shown.is_some() && before - high < CLOSE.max((high - first) / SLOW);
                patience = if is_slow { patience - 1 } else { PATIENCE };
                if patience == 0 || high - first <= CLOSE {
                    break;
                }
                self.forget(&mut weights);
                had = self.cut(&all, &self.best.clone());
            }
            let temperature = (had.abs() / (10 * self.cuts.len()) as f64).min(WARM) * cooled;
            let (_, shares) =
                self.lp(&all).solve_at(self.limits.at_most, temperature.max(COLD), &mut weights);
            let near = NEARER[round % NEARER.len()];
            let between = |(best, share): (&f64, &f64)| near * best + (1.0 - near) * share;
            let tried: Vec<f64> = self.best.iter().zip(&shares).map(between).collect();
            let cuts = self.cuts.len();
            let has = self.cut(&all, &tried);
            if self.cuts.len() == cuts && round % NEARER.len() == NEARER.len() - 1 {
                cooled *= COOLER;
            }
            if has > had {
                (had, self.best) = (has, tried);
            }
        }
        let weighed = self.shown?;
        let told = |(times, cut): &(u64, CountedCut)| WeightedCut {
            moment: all[cut.inequality].moment,
            times: *times,
            shares: cut.shares.clone(),
        };
        let above = Ratio { numerator: high, denominator: SCORES };
        let gap = Gap { above, cuts: weighed.cuts.iter().map(told).collect(), budget: weighed.budget };
        Some((gap, weighed))
    }

    /// Leaves out cuts of next to no weight, but for the last ones.
    fn forget(&mut self, weights: &mut Vec<f64>) {
        let count = self.cuts.len();
        let stays: Vec<bool> = (0..count).map(|cut| cut + FRESH >= count || weights[cut] > LIGHT).collect();
        let mut of_cut = stays.iter().copied();
        self.cuts.retain(|_| of_cut.next() == Some(true));
        let mut of_weight = stays.into_iter().chain(std::iter::once(true));
        weights.retain(|_| of_weight.next() == Some(true));
    }

    /// The inequalities of sets that are worth more than some millionths.
    fn score_inequalities(&self, score: i128) -> Option<Vec<Inequality>> {
        let mut all =
            inequalities(&self.problem, Worth::Exact(Ratio { numerator: score, denominator: SCORES }))?;
        all.retain(|one| self.moment.is_none_or(|moment| one.moment == moment));
        Some(all)
    }

    /// The lowest score above the first and not above the last for which cuts are a proof.
    fn lowest(&self, first: i128, last: i128, weighed: &WeighedCuts) -> Option<i128> {
        let proves =
            |score: i128| self.score_inequalities(score).is_some_and(|all| self.proves(&all, weighed));
        let (mut low, mut high) = (first, proves(last).then_some(last)?);
        while high - low > 1 {
            let tried = (low + high) / 2;
            *(if proves(tried) { &mut high } else { &mut low }) = tried;
        }
        Some(high)
    }

    /// The linear program of all cuts, each divided by its threshold.
    fn lp(&self, all: &[Inequality]) -> Lp {
        let (mut constant, mut added) = (Vec::new(), Vec::new());
        for cut in &self.cuts {
            let (inside, outside) = cut.coefficients(&all[cut.inequality]);
            constant.push(inside);
            added.push(outside);
        }
        if let Some(budget) = self.limits.budget.filter(|&budget| budget > 0) {
            let part = |&item: &usize| -(self.problem.rules.cost[item] as f64) / budget as f64;
            constant.push(1.0);
            added.push(self.items.iter().map(part).collect());
        }
        Lp { constant, added, cuts: self.cuts.len() }
    }

    /// Adds the cut of each inequality at some shares, and returns the lowest value that these have in any.
    fn cut(&mut self, all: &[Inequality], shares: &[f64]) -> f64 {
        let share_of = round_shares(shares);
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
                inside.push(evidence.ones.count(&hidden));
                *outside = self
                    .items
                    .par_iter()
                    .map(|&item| {
                        let row = evidence.plane(item, segment.plane);
                        if row.is_empty() {
                            0
                        } else {
                            evidence.ones.count_minus(&row[segment.words.clone()], &hidden) as u32
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
            let (inside, outside) = cut.coefficients(&all[cut.inequality]);
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

    /// The cuts with their weights, rounded to whole numbers.
    fn weigh(&self, all: &[Inequality], weights: &[f64]) -> WeighedCuts {
        // Weights are for cuts divided by their thresholds; these are for whole ones.
        let (cuts, budget) = weights.split_at(self.cuts.len());
        let often = |(cut, weight): (&CountedCut, &f64)| weight / all[cut.inequality].exact.1.max(1) as f64;
        let often: Vec<f64> = self.cuts.iter().zip(cuts).map(often).collect();
        let factor = HEAVIEST / often.iter().copied().fold(0.0, f64::max);
        let times = often.iter().map(|often| (often * factor).round() as u64);
        let cuts = times.zip(self.cuts.iter().cloned()).filter(|(times, _)| *times > 0).collect();
        let spent = self.limits.budget.unwrap_or(0);
        let budget =
            budget.first().map_or(0, |&weight| (weight / spent as f64 * factor) as u64).min(MOST_BUDGETS);
        WeighedCuts { cuts, budget, items: self.items.clone() }
    }

    /// Whether no allowed set passes all inequalities, by some cuts.
    fn proves(&self, all: &[Inequality], weighed: &WeighedCuts) -> bool {
        let (mut most, added) = weighed.added_up(&self.problem, self.limits, all);
        let always = &self.problem.rules.always;
        let is_fixed = |i: &usize| always.contains(&self.items[*i]);
        most += (0..added.len()).filter(is_fixed).map(|i| added[i]).sum::<i128>();
        let mut free: Vec<i128> =
            (0..added.len()).filter(|i| !is_fixed(i)).map(|i| added[i].max(0)).collect();
        free.sort_unstable_by_key(|&added| std::cmp::Reverse(added));
        most += free.iter().take(self.limits.at_most - always.len()).sum::<i128>();
        most < 0
    }
}

/// The inequalities of sets that are worth more; `None` if cuts say nothing about one.
fn inequalities(problem: &Problem, known: Worth) -> Option<Vec<Inequality>> {
    let all = question(problem, Some(known)).all;
    // The first of several is the sum of the others.
    let all = all[usize::from(all.len() > 1)..].to_vec();
    (!all.is_empty() && all.iter().all(Inequality::is_plain)).then_some(all)
}

/// Shares rounded to parts, so that their sum is kept.
fn round_shares(shares: &[f64]) -> Vec<u64> {
    let parts: Vec<f64> = shares.iter().map(|share| share * SHARES as f64).collect();
    let mut whole: Vec<u64> = parts.iter().map(|part| *part as u64).collect();
    let rest = (parts.iter().sum::<f64>().round() as u64).saturating_sub(whole.iter().sum::<u64>());
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
