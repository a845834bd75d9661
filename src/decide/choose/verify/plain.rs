//! A plain search for a better set, without rounding.
//!
//! # Theory
//! With t and f the truly occupied and truly free voxels and s = t + f, F1 > p/q if and only if
//! (2q − p)·TP + p·TN − p·s > 0; κ > p/q only if (f·q + t·p)·TP + (t·q + f·p)·TN − p·s² > 0. The gain of
//! several candidates is at most the sum of their gains. A part is detected only if its best hits together suffice.

use rayon::prelude::*;

use super::ProofInput;
use super::allowed::{AllowedSets, thousandths};
use super::counted::{exact, value, value_reaches};
use perirobot_cover::Ratio;
use perirobot_cover::layout::{CLEAR, FALSE, FELT, HIT, MomentBits, SEEN};
use perirobot_march::metrics::{Across, Score};
use perirobot_study::input::Choose;

/// The plain search for a set that is better than the claimed one.
pub(super) struct Plain<'a> {
    pub(super) given: ProofInput<'a>,
    /// The limits of a set: number of sensors, and cost in thousandths.
    pub(super) at_most: usize,
    pub(super) budget: Option<u64>,
    pub(super) bar: Threshold,
}

/// The score of a wanted set.
#[derive(Clone, Copy, Debug)]
pub(super) enum Threshold {
    /// More than this score, as a fraction.
    Above((i128, i128)),
    /// A mean of scores above this.
    AboveMean(f64),
    /// The requirements themselves, used if no set is claimed. The first limit above zero, unless a mean, guides the
    /// search.
    Required,
}

impl Threshold {
    /// The score and the limit that guide the search.
    fn score(self, choose: &Choose) -> (Score, Across, (i128, i128)) {
        match self {
            Threshold::Above(claimed) => (choose.objective, choose.over, claimed),
            Threshold::AboveMean(_) => unreachable!("a mean is not a fraction"),
            Threshold::Required => {
                let first = choose
                    .require
                    .iter()
                    .find(|require| require.over != Across::Mean && require.at_least > 0.0);
                let first = first.expect("called only with a guiding limit");
                let Ratio { numerator, denominator } = Ratio::from_f64(first.at_least);
                // Equality suffices, so the limit is lowered a little.
                (first.score, first.over, (2 * numerator - 1, 2 * denominator))
            }
        }
    }
}

/// The union of some candidates.
pub(super) type SetPlanes = [Vec<u64>; 6];

impl Plain<'_> {
    /// A better set, if any.
    pub(super) fn better(&self) -> Option<Vec<usize>> {
        let items = &self.given.evidence.items;
        let fixed: Vec<usize> =
            (0..items.len()).filter(|&i| self.given.choose.always.contains(&items[i])).collect();
        let others: Vec<usize> = (0..items.len()).filter(|i| !fixed.contains(i)).collect();
        if self.is_better(&fixed) {
            return Some(fixed);
        }
        let left = self.at_most - fixed.len();
        let order = self.open(&fixed, &others, left);
        (0..order.len()).into_par_iter().find_map_first(|i| self.search_children(&fixed, &order, i, left))
    }

    /// A better set among those with one more candidate, the first of those in order from a place on.
    fn search_children(
        &self,
        chosen: &[usize],
        order: &[usize],
        i: usize,
        left: usize,
    ) -> Option<Vec<usize>> {
        let set = [chosen, &order[i..=i]].concat();
        if self.is_better(&set) {
            return Some(set);
        }
        if left == 1 || self.given.progress.stops() {
            return None;
        }
        let order = self.open(&set, &order[i + 1..], left - 1);
        (0..order.len()).find_map(|i| self.search_children(&set, &order, i, left - 1))
    }

    fn is_better(&self, set: &[usize]) -> bool {
        let counts = self.given.evidence.counts(set);
        let (objective, over) = (self.given.choose.objective, self.given.choose.over);
        let is_above = match self.bar {
            Threshold::Above((n, d)) => exact(objective, over, &counts).is_some_and(|(a, b)| a * d > n * b),
            Threshold::AboveMean(claimed) => {
                value(objective, over, &counts).is_some_and(|value| value > claimed)
            }
            Threshold::Required => value(objective, over, &counts).is_some(),
        };
        let reaches = |r: &perirobot_study::input::SetRequirement| {
            value_reaches(value(r.score, r.over, &counts), r.at_least)
        };
        !set.is_empty() && is_above && self.given.choose.require.iter().all(reaches)
    }

    /// The candidates that may join a set and lead to a better one, largest gain first.
    fn open(&self, chosen: &[usize], candidates: &[usize], left: usize) -> Vec<usize> {
        if left == 0 {
            return Vec::new();
        }
        let poses =
            |set: &[usize]| set.iter().map(|&item| self.given.evidence.items[item]).collect::<Vec<_>>();
        let budget = self.budget.unwrap_or(u64::MAX);
        let cost = |set: &[usize]| {
            poses(set).iter().map(|&[sensor, _]| thousandths(self.given.study, sensor)).sum::<u64>()
        };
        let ProofInput { study, choose, worlds, disturbed, .. } = self.given;
        let allowed = AllowedSets::from_choose(study, (choose, disturbed), worlds);
        let joins = |&&item: &&usize| {
            let set = [chosen, &[item]].concat();
            cost(&set) <= budget && allowed.clash(&poses(&set)).is_none()
        };
        let candidates: Vec<usize> = candidates.iter().filter(joins).copied().collect();
        let union = self.union(chosen);
        if let Threshold::AboveMean(claimed) = self.bar {
            let means = self.means(&union, &candidates, left);
            let mut kept: Vec<(f64, usize)> =
                means.into_iter().zip(candidates).filter(|(mean, _)| *mean > claimed).collect();
            kept.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
            return kept.into_iter().map(|(_, item)| item).collect();
        }
        let mut worth: Vec<(i128, usize)> = candidates.iter().map(|&item| (0, item)).collect();
        let mut may = vec![true; candidates.len()];
        let moments = &self.given.evidence.layout.moments;
        let (score, over, par) = self.bar.score(self.given.choose);
        let groups: Vec<&[MomentBits]> = match over {
            Across::Pooled => vec![moments],
            _ => moments.chunks(1).collect(),
        };
        for moments in groups {
            let Some((value, gains)) = self.gains((score, par), (moments, &union), &candidates, left) else {
                continue;
            };
            let mut best: Vec<i128> = gains.clone();
            best.sort_unstable_by(|a, b| b.cmp(a));
            let others: i128 = best.iter().take(left - 1).sum();
            for ((may, worth), gain) in may.iter_mut().zip(&mut worth).zip(&gains) {
                *may &= value + gain + others > 0;
                worth.0 += gain;
            }
        }
        let mut kept: Vec<(i128, usize)> =
            worth.into_iter().zip(may).filter(|(_, may)| *may).map(|(w, _)| w).collect();
        kept.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(&b.1)));
        kept.into_iter().map(|(_, item)| item).collect()
    }

    fn union(&self, set: &[usize]) -> SetPlanes {
        let widths = self.given.evidence.layout.words;
        let mut union: SetPlanes = std::array::from_fn(|plane| vec![0; widths[plane / 2]]);
        for &item in set {
            for (plane, union) in union.iter_mut().enumerate() {
                union
                    .iter_mut()
                    .zip(&*self.given.evidence.plane(item, plane))
                    .for_each(|(to, from)| *to |= from);
            }
        }
        union
    }

    /// The margin of some moments together over the claim, and the largest gain of each candidate; `None` if the score
    /// may have no value.
    fn gains(
        &self,
        (score, (p, q)): (Score, (i128, i128)),
        (moments, union): (&[MomentBits], &SetPlanes),
        items: &[usize],
        left: usize,
    ) -> Option<(i128, Vec<i128>)> {
        let sum =
            |of: fn(&MomentBits) -> u64| moments.iter().map(|moment| i128::from(of(moment))).sum::<i128>();
        let [t, f] = [sum(|moment| moment.voxels[0]), sum(|moment| moment.voxels[1])];
        let s = t + f;
        match score {
            Score::F1 | Score::Kappa if t == 0 || f == 0 && score == Score::Kappa => None,
            Score::F1 => Some(self.correct_voxels(moments, union, items, [2 * q - p, p], p * s)),
            Score::Kappa => {
                let weights = [(f * q + t * p).max(0), (t * q + f * p).max(0)];
                Some(self.correct_voxels(moments, union, items, weights, p * s * s))
            }
            Score::HumanSeen => {
                let fresh = |item: Option<usize>| {
                    self.part_counts(moments, union, item).into_iter().map(|(h, _)| h).sum::<i128>()
                };
                let people =
                    i128::from(moments.iter().flat_map(|m| &m.parts).map(|part| part.voxels).sum::<u64>());
                let gains = items.iter().map(|&item| q * fresh(Some(item))).collect();
                (people > 0).then(|| (q * fresh(None) - p * people, gains))
            }
            score => {
                let people = score == Score::PeopleDetected;
                self.detectable_parts((moments, union), items, left, (people, (p, q)))
            }
        }
    }

    /// Counts of correctly labelled voxels.
    fn correct_voxels(
        &self,
        moments: &[MomentBits],
        union: &SetPlanes,
        items: &[usize],
        weights: [i128; 2],
        claimed: i128,
    ) -> (i128, Vec<i128>) {
        let ones = self.given.ones;
        let count = |item: Option<usize>| {
            let mut sum = 0;
            for moment in moments {
                for (plane, weight) in [HIT, CLEAR].into_iter().zip(weights) {
                    let words = moment.words[plane / 2].clone();
                    let has = &union[plane][words.clone()];
                    // A free voxel labelled occupied by one sensor is never labelled correctly.
                    let wrong = (plane == CLEAR).then(|| &union[FALSE][words.clone()]);
                    let row = item.map(|item| self.given.evidence.plane(item, plane));
                    let count = match (row.as_deref(), wrong) {
                        (None, None) => ones.count(has),
                        (None, Some(wrong)) => ones.count_minus(has, wrong),
                        (Some([]), _) => 0,
                        (Some(row), None) => ones.count_minus(&row[words], has),
                        (Some(row), Some(wrong)) => ones.count_minus_two(&row[words], [has, wrong]),
                    };
                    sum += weight * i128::from(count);
                }
            }
            sum
        };
        (count(None) - claimed, items.iter().map(|&item| count(Some(item))).collect())
    }

    /// For each body part the hits and the felt voxels of a union, or the gain of a candidate.
    fn part_counts(
        &self,
        moments: &[MomentBits],
        union: &SetPlanes,
        item: Option<usize>,
    ) -> Vec<(i128, i128)> {
        let ones = self.given.ones;
        let count = |plane: usize, words: &std::ops::Range<usize>| {
            let has = &union[plane][words.clone()];
            let row = item.map(|item| self.given.evidence.plane(item, plane));
            i128::from(match row.as_deref() {
                None => ones.count(has),
                Some([]) => 0,
                Some(row) => ones.count_minus(&row[words.clone()], has),
            })
        };
        let parts = moments.iter().flat_map(|moment| &moment.parts);
        parts.map(|part| (count(SEEN, &part.words), count(FELT, &part.words))).collect()
    }

    /// For parts or people that may be detected: those whose best hits together suffice. Either all remaining
    /// candidates may lead there, or none.
    fn detectable_parts(
        &self,
        (moments, union): (&[MomentBits], &SetPlanes),
        items: &[usize],
        left: usize,
        (people, (p, q)): (bool, (i128, i128)),
    ) -> Option<(i128, Vec<i128>)> {
        let least = i128::from(self.given.evidence.layout.min_hits());
        let has = self.part_counts(moments, union, None);
        let more: Vec<Vec<(i128, i128)>> =
            items.iter().map(|&item| self.part_counts(moments, union, Some(item))).collect();
        let parts =
            moments.iter().enumerate().flat_map(|(m, moment)| moment.parts.iter().map(move |part| (m, part)));
        let (mut counting, mut possible) = (Vec::new(), Vec::new());
        for (number, (moment, part)) in parts.enumerate() {
            let mut best: Vec<i128> = more.iter().map(|gains| gains[number].0).collect();
            best.sort_unstable_by(|a, b| b.cmp(a));
            let counts = i128::from(part.voxels) >= least;
            let hit = counts && has[number].0 + best.iter().take(left).sum::<i128>() >= least;
            let felt = has[number].1 > 0 || more.iter().any(|gains| gains[number].1 > 0);
            let who = if people { (moment, part.person) } else { (moment, number) };
            counting.extend(counts.then_some(who));
            possible.extend((hit || people && felt).then_some(who));
        }
        for all in [&mut counting, &mut possible] {
            all.sort_unstable();
            all.dedup();
        }
        possible.retain(|who| counting.contains(who));
        let value = q * possible.len() as i128 - p * counting.len() as i128;
        (!counting.is_empty()).then(|| (value, vec![0; items.len()]))
    }
}
