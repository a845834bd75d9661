//! That no set is above a score, added up again from cuts.
//!
//! # Theory
//! Whatever voxels H are, what a set sees of the voxels that count is no more than those of H and, pose by pose,
//! those that are not in H. A set above p/q has, with t and f the truly occupied and truly free voxels and
//! s = t + f, at F1 (2q − p)·TP + p·TN > p·s, and at κ (f·q + t·p)·TP + (t·q + f·p)·TN > p·s². If many such
//! sums, each of another H, are together too small even for the best poses one by one, there is no such set.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::evidence::CandidateEvidence;
use super::gap::{Gap, WeightedCut};
use super::layout::{CLEAR, HIT, MomentBits, SEEN};
use perirobot_march::error::Issue;
use perirobot_march::metrics::{Across, Score};

/// Shares of poses that make a voxel part of the inside.
const WHOLE: u64 = 256;
/// Parts of a score, and how many times a cut may count, at most: sums then stay within 128 bits.
const MOST_PARTS: i128 = 1_000_000;
const MOST_TIMES: u64 = 1 << 20;
const MOST_BUDGETS: u64 = 1 << 60;

/// Weighted cuts that prove that no set is above a score.
///
/// A cut is made of shares of poses. Voxels that poses see whose shares add up to 256 or more are its inside. A
/// set sees no more than the inside, and what each of its poses sees outside.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CutProof {
    /// The score, as a fraction.
    pub above: [u64; 2],
    /// How many times it counts that a set costs no more than the budget, in thousandths.
    pub budget_times: u64,
    /// The cuts.
    pub cuts: Vec<ProofCut>,
}

/// A cut of the voxels of one score.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProofCut {
    /// The moment whose score it bounds, unless counts are pooled; then 0.
    pub moment: usize,
    /// How many times it counts.
    pub times: u64,
    /// Poses and their shares.
    pub shares: BTreeMap<String, u64>,
}

impl CutProof {
    /// Cuts with the names of poses.
    pub fn new(gap: &Gap, name: impl Fn(usize) -> String) -> CutProof {
        let cut = |cut: &WeightedCut| ProofCut {
            moment: cut.moment,
            times: cut.times,
            shares: cut.shares.iter().map(|&(item, share)| (name(item), share)).collect(),
        };
        CutProof {
            above: [gap.above.numerator as u64, gap.above.denominator as u64],
            budget_times: gap.budget,
            cuts: gap.cuts.iter().map(cut).collect(),
        }
    }
}

/// What is asked, as far as cuts need to know.
pub struct CutLimits<'a> {
    /// What the candidates say.
    pub evidence: &'a CandidateEvidence,
    /// The score.
    pub objective: Score,
    /// How the scores of several moments are combined.
    pub over: Across,
    /// How many poses a set may have.
    pub at_most: usize,
    /// What it may cost, in thousandths.
    pub budget: Option<u64>,
    /// What each candidate costs, in thousandths.
    pub cost: Vec<u64>,
    /// Poses that are in every set.
    pub always: Vec<usize>,
    /// Whether a pose may be in a set with those.
    pub joins: &'a dyn Fn(usize) -> bool,
    /// Which pose has a name.
    pub named: &'a dyn Fn(&str) -> Option<usize>,
}

/// Whether cuts show that no set is above what is claimed.
///
/// # Errors
/// Why they do not.
pub fn check_cuts(asked: &CutLimits, proofs: &[CutProof], claimed: f64) -> Result<(), Issue> {
    if asked.over == Across::Mean {
        // Scores without a value are left out of a mean, and those of moments without a truth are zero at best.
        let moments = &asked.evidence.layout.moments;
        let has = |&moment: &usize| weights(asked.objective, &moments[moment..=moment], 1, 2).is_some();
        let scored: Vec<usize> = (0..moments.len()).filter(has).collect();
        let of = |cuts: &CutProof| cuts.cuts.first().map(|cut| cut.moment);
        if !proofs.iter().map(of).eq(scored.into_iter().map(Some)) {
            return Err(Issue::says("is not about each score of the mean once, in their order"));
        }
    } else if proofs.len() > 1 {
        return Err(Issue::says("is about more than one score"));
    }
    for (number, proof) in proofs.iter().enumerate() {
        verify_exclusion(asked, proof).map_err(|why| why.with_place(format!("[{number}]")))?;
    }
    let above = proofs.iter().map(|proof| proof.above[0] as f64 / proof.above[1] as f64);
    let mean = above.sum::<f64>() / proofs.len() as f64;
    match mean == claimed {
        true => Ok(()),
        false => Err(Issue::says(format!("above is {mean}, which is not the {claimed} of no_set_is_above"))),
    }
}

/// Whether cuts exclude all sets above the score that they are for.
fn verify_exclusion(asked: &CutLimits, proof: &CutProof) -> Result<(), Issue> {
    let CutLimits { evidence, objective, over, .. } = *asked;
    let [p, q] = proof.above.map(i128::from);
    if q == 0 || q > MOST_PARTS || p > q {
        return Err(Issue::says(format!("above is {p}/{q}, which is no score")));
    }
    let moments = &evidence.layout.moments;
    let mut most = 0i128;
    let mut added = vec![0i128; evidence.items.len()];
    for (number, cut) in proof.cuts.iter().enumerate() {
        let place = |why: String| Issue::says(why).with_place(format!("cuts[{number}]"));
        let moments = match over {
            Across::Pooled if cut.moment == 0 => &moments[..],
            Across::Worst if cut.moment < moments.len() => &moments[cut.moment..=cut.moment],
            Across::Mean if cut.moment < moments.len() && cut.moment == proof.cuts[0].moment => {
                &moments[cut.moment..=cut.moment]
            }
            _ => return Err(place(format!("no score is of moment {}", cut.moment))),
        };
        let Some((weights, wanted)) = weights(objective, moments, p, q) else {
            return Err(place("there is no such score".into()));
        };
        let mut shares = Vec::new();
        for (name, &share) in &cut.shares {
            let item =
                (asked.named)(name).ok_or_else(|| place(format!("{name:?} is not a pose of the study")))?;
            shares.push((item, share.min(WHOLE)));
        }
        let times = i128::from(cut.times.min(MOST_TIMES));
        most -= times * wanted;
        for (plane, weight) in weights {
            let (inside, outside) = count_bits(evidence, moments, plane, &shares);
            most += times * weight * inside;
            added.iter_mut().zip(outside).for_each(|(added, outside)| *added += times * weight * outside);
        }
    }
    if let Some(budget) = asked.budget {
        let times = i128::from(proof.budget_times.min(MOST_BUDGETS));
        most += times * i128::from(budget);
        added.iter_mut().zip(&asked.cost).for_each(|(added, &cost)| *added -= times * i128::from(cost));
    }
    most += asked.always.iter().map(|&item| added[item]).sum::<i128>();
    let is_free = |item: &usize| !asked.always.contains(item) && (asked.joins)(*item);
    let mut free: Vec<i128> = (0..added.len()).filter(is_free).map(|item| added[item]).collect();
    free.sort_unstable_by_key(|added| std::cmp::Reverse(*added));
    let left = asked.at_most.saturating_sub(asked.always.len());
    most += free.iter().take(left).map(|added| (*added).max(0)).sum::<i128>();
    match most < 0 {
        true => Ok(()),
        false => Err(Issue::says(format!("sets above {p}/{q} are not excluded"))),
    }
}

/// What a bit of each plane counts, and what is asked for, so that a set is above p/q; one more than not.
fn weights(score: Score, moments: &[MomentBits], p: i128, q: i128) -> Option<(Vec<(usize, i128)>, i128)> {
    let sum = |of: fn(&MomentBits) -> u64| i128::from(moments.iter().map(of).sum::<u64>());
    let (t, f) = (sum(|moment| moment.voxels[0]), sum(|moment| moment.voxels[1]));
    let s = t + f;
    match score {
        Score::F1 if t > 0 => Some((vec![(HIT, 2 * q - p), (CLEAR, p)], p * s + 1)),
        Score::Kappa if t > 0 && f > 0 => {
            Some((vec![(HIT, f * q + t * p), (CLEAR, t * q + f * p)], p * s * s + 1))
        }
        Score::HumanSeen => {
            let people = sum(|moment| moment.parts.iter().map(|part| part.voxels).sum());
            (people > 0).then(|| (vec![(SEEN, q)], p * people + 1))
        }
        _ => None,
    }
}

/// How many bits of a plane are inside, and for each candidate how many of its bits are not.
fn count_bits(
    evidence: &CandidateEvidence,
    moments: &[MomentBits],
    plane: usize,
    shares: &[(usize, u64)],
) -> (i128, Vec<i128>) {
    let space = plane / 2;
    let first = moments.first().map_or(0, |moment| moment.words[space].start);
    let last = moments.last().map_or(0, |moment| moment.words[space].end);
    let width = last - first;
    let mut sums = vec![[0u64; 64]; width];
    for &(item, share) in shares {
        let row = evidence.plane(item, plane);
        for (sums, word) in sums.iter_mut().zip(row.get(first..last).unwrap_or_default()) {
            for (bit, sum) in sums.iter_mut().enumerate() {
                *sum += (word >> bit & 1) * share;
            }
        }
    }
    let is_in = |sums: &[u64; 64]| -> u64 {
        sums.iter().enumerate().map(|(bit, &sum)| u64::from(sum >= WHOLE) << bit).sum()
    };
    let hidden: Vec<u64> = sums.iter().map(is_in).collect();
    let count = |words: &mut dyn Iterator<Item = u64>| words.map(|word| i128::from(word.count_ones())).sum();
    let inside = count(&mut hidden.iter().copied());
    let beyond = |item: usize| -> i128 {
        let row = evidence.plane(item, plane);
        let own = row.get(first..last).unwrap_or_default();
        count(&mut own.iter().zip(&hidden).map(|(word, hidden)| word & !hidden))
    };
    let outside = (0..evidence.items.len()).map(beyond).collect();
    (inside, outside)
}
