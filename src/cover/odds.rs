//! Sets under log-odds fusion, where sensors may outvote each other.
//!
//! # Theory
//! A voxel is occupied if its sum is above zero, so some reading raises it, and free if the sum is below zero, so
//! some reading lowers it. So no set has more true positives than the union of what is rightly called occupied,
//! nor more true negatives than that of what is rightly called free, and a bound by cuts, which counts these
//! unions, holds here, too. Where no candidate is ever wrong, no two of them disagree about a voxel: then sums
//! decide as "occupied wins" does, and so does everything that is proven. Who is detected is a question of hits,
//! which no sum changes.
//!
//! # Practice
//! Readings are added up in the order in which a sweep adds those of the set. Each set is fused anew.

use super::evidence::{CandidateEvidence, Row};
use super::layout::{CLEAR, FALSE, HIT, MISSED, PLANES, SPACE_OF};
use perirobot_march::backend::{Saying, settle};

/// What is added up.
#[derive(Clone, Debug)]
pub struct Odds {
    /// Of each candidate whether it speaks last, and what it adds to voxels that it calls occupied and free.
    readings: Vec<(bool, [i32; 2])>,
}

impl Odds {
    /// How candidates are added up, if sums may decide otherwise than "occupied wins". Of each candidate whether it speaks
    /// last, and what it adds to voxels that it calls occupied and free.
    pub fn new(readings: Vec<(bool, [i32; 2])>, evidence: &CandidateEvidence) -> Option<Odds> {
        let may_dispute = |(item, &(_, [hit, miss])): (usize, &(bool, [i32; 2]))| {
            evidence.has_bits(item, MISSED)
                || evidence.has_bits(item, FALSE)
                || hit <= 0
                || miss >= 0 && evidence.has_bits(item, CLEAR)
        };
        readings.iter().enumerate().any(may_dispute).then_some(Odds { readings })
    }

    /// The planes of a set: its labels, and the union of its hits.
    pub(super) fn fuse(&self, evidence: &CandidateEvidence, set: &[(usize, &Row)]) -> [Vec<u64>; PLANES] {
        let mut set = set.to_vec();
        set.sort_by_key(|&(item, _)| (self.readings[item].0, item));
        let sayings = Saying::from_readings(set.iter().map(|&(item, _)| self.readings[item].1));
        let mut planes: [Vec<u64>; PLANES] =
            std::array::from_fn(|plane| vec![0; evidence.layout.words[SPACE_OF[plane]]]);
        for (plane, words) in planes.iter_mut().enumerate() {
            for (_, row) in &set {
                words.iter_mut().zip(&*row[plane]).for_each(|(to, from)| *to |= from);
            }
        }
        for [occupied, free] in [[HIT, MISSED], [FALSE, CLEAR]] {
            for word in 0..planes[occupied].len() {
                // Where all agree, a union says it.
                let all = planes[occupied][word] | planes[free][word];
                let disputed = planes[occupied][word] & planes[free][word];
                let settles = if self.all_speak() { disputed } else { all };
                if settles == 0 {
                    continue;
                }
                let said = |row: &Row, plane: usize| row[plane].get(word).copied().unwrap_or(0);
                let heard = |i: usize| {
                    let row = set[i].1;
                    let occupied = said(row, occupied);
                    [occupied, said(row, free) & !occupied]
                };
                let labels = settle(&sayings, &heard, settles);
                for (plane, label) in [occupied, free].into_iter().zip(labels) {
                    planes[plane][word] = planes[plane][word] & !settles | label;
                }
            }
        }
        planes
    }

    /// Whether each reading raises what it calls occupied and lowers what it calls free.
    fn all_speak(&self) -> bool {
        self.readings.iter().all(|&(_, [hit, miss])| hit > 0 && miss < 0)
    }
}
