//! An upper bound of the mean of a set's scores, added up in a plain way.
//!
//! # Theory
//! With t and f the truly occupied and truly free voxels of a moment and s = t + f, F1 is at most
//! 2·TP / (s + TP − TN), and κ at most (f·TP + t·TN) / (s² − t·TP − f·TN): both rise with TP and TN. A moment without a
//! truth scores zero, or not at all.

use super::plain::{Plain, SetPlanes};
use perirobot_cover::layout::{CLEAR, FALSE, HIT, MomentBits, SEEN};
use perirobot_march::metrics::Score;

/// Numbers below this are exact in floating point.
const EXACT: f64 = 9_007_199_254_740_992.0;

impl Plain<'_> {
    /// Whether these bounds of means apply: for scores of voxels, if all numbers are exact.
    pub(super) fn bounds_means(&self) -> bool {
        let moments = &self.given.evidence.layout.moments;
        let is_exact = |moment: &MomentBits| {
            let s = (moment.voxels[0] + moment.voxels[1]) as f64;
            s * s < EXACT
        };
        matches!(self.given.choose.objective, Score::F1 | Score::Kappa | Score::HumanSeen)
            && moments.iter().all(is_exact)
    }

    /// For each candidate the upper bound of the mean of a set with it, a union and others.
    pub(super) fn means(&self, union: &SetPlanes, items: &[usize], left: usize) -> Vec<f64> {
        let (mut sums, mut count) = (vec![0.0; items.len()], 0.0);
        for moment in &self.given.evidence.layout.moments {
            let [t, f] = moment.voxels.map(|voxels| voxels as f64);
            let people: u64 = moment.parts.iter().map(|part| part.voxels).sum();
            let s = t + f;
            let has_value = match self.given.choose.objective {
                Score::HumanSeen => people > 0,
                Score::F1 => t > 0.0,
                _ => t > 0.0 && f > 0.0,
            };
            if !has_value {
                continue;
            }
            count += 1.0;
            let [hit, clear, seen] =
                [HIT, CLEAR, SEEN].map(|plane| self.most(moment, plane, union, items, left));
            for (number, sum) in sums.iter_mut().enumerate() {
                let (tp, tn) = (hit[number].min(t), clear[number].min(f));
                *sum += match self.given.choose.objective {
                    Score::HumanSeen => seen[number].min(people as f64) / people as f64,
                    Score::F1 => 2.0 * tp / (s + tp - tn),
                    _ => (f * tp + t * tn) / (s * s - t * tp - f * tn),
                };
            }
        }
        sums.iter().map(|sum| if count > 0.0 { f64::max(sum / count, 0.0) } else { 0.0 }).collect()
    }

    /// For each candidate the bits of a plane at a moment, together with a union and the largest gain of the others.
    fn most(
        &self,
        moment: &MomentBits,
        plane: usize,
        union: &SetPlanes,
        items: &[usize],
        left: usize,
    ) -> Vec<f64> {
        let words = moment.words[plane / 2].clone();
        let has = &union[plane][words.clone()];
        let ones = self.given.ones;
        let own = if plane == CLEAR {
            ones.count_minus(has, &union[FALSE][words.clone()])
        } else {
            ones.count(has)
        };
        let adds = |&item: &usize| {
            let row = self.given.evidence.plane(item, plane);
            row.get(words.clone()).map_or(0, |row| ones.count_minus(row, has))
        };
        let adds: Vec<u64> = items.iter().map(adds).collect();
        let mut best = adds.clone();
        best.sort_unstable_by(|a, b| b.cmp(a));
        let others: u64 = best.iter().take(left - 1).sum();
        adds.into_iter().map(|adds| (own + others + adds) as f64).collect()
    }
}
