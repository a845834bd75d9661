//! Whether any set beats a worth, as inequalities of weighted coverage in whole numbers.
//!
//! # Theory
//! With t and f the truly occupied and truly free voxels of a region and s = t + f,
//!
//! * F1 > p/q just if (2q − p)·TP + p·TN > p·s,
//! * κ > p/q just if (f·q + t·p)·TP + (t·q + f·p)·TN − (q − p)·(t·FP + f·FN) > p·s².
//!
//! * at most p/q of the voxels are unknown just if q·(TP + FN + FP + TN) ≥ (q − p)·s.
//!
//! TP is a count of a union; TN is one of the voxels that some call free and none occupied. FN is
//! left out, which can only let more sets pass. A set passes the worst of several scores if it passes each, and
//! then their sum, too. Where parts or people are detected, each is worth at most `min_hits` hits, all of
//! which it needs.
//!
//! # Practice
//! Weights are scaled to 45 bits and rounded up, thresholds down, so a set that beats the worth always
//! passes. What passes is judged by its exact worth.

use std::ops::Range;

use super::evidence::{CandidateEvidence, Union};
use super::layout::{BitLayout, CLEAR, FALSE, FELT, HIT, MISSED, MomentBits, SEEN, SPACE_OF};
use super::problem::Problem;
use super::worth::{Ratio, Worth};
use perirobot_march::metrics::{Across, Score};
use perirobot_march::voxel::Ones;

/// Bits of the largest value that an inequality can reach.
const BITS: u32 = 45;

/// Bits of a plane with one weight.
#[derive(Clone, Debug)]
pub(super) struct Segment {
    pub(super) plane: usize,
    pub(super) words: Range<usize>,
    pub(super) weight: u64,
}

/// Segments whose values count together up to a cap.
#[derive(Clone, Debug)]
struct Group {
    segments: Vec<Segment>,
    cap: u64,
}

/// What the value of a set must reach.
#[derive(Clone, Debug)]
pub(super) struct Inequality {
    groups: Vec<Group>,
    /// What false alarms subtract.
    charges: Vec<Segment>,
    /// The moment it is about; the first, if it is about several.
    pub(super) moment: usize,
    pub(super) least: i64,
    /// The weights of the segments and the threshold before rounding; empty if it is a sum or has caps.
    pub(super) exact: (Vec<i128>, i128),
}

/// A union as an inequality sees it.
#[derive(Clone, Debug)]
pub(super) struct UnionState {
    /// Never below what it truly has.
    pub(super) value: i64,
    /// What each group has.
    filled: Vec<u64>,
}

/// One inequality before it is scaled: weights of planes in moments.
#[derive(Default)]
struct WeightedTerms {
    /// Plane, words, weight, and how many bits there are.
    gains: Vec<(usize, Range<usize>, i128, u64)>,
    charges: Vec<(Range<usize>, i128)>,
    /// Where the score is what is to be reached.
    par: i128,
    /// Whether it must be exceeded.
    beat: bool,
}

/// The inequalities that a set must pass to be worth more than what is known, and to meet all requirements.
#[derive(Clone, Debug)]
pub(super) struct Question {
    /// The first is the one by which candidates are ordered; none if everything passes.
    pub(super) all: Vec<Inequality>,
    /// The worth to be exceeded.
    pub(super) beaten: Option<Worth>,
}

/// The question whether any set is worth more than what is known.
pub(super) fn question(problem: &Problem, beaten: Option<Worth>) -> Question {
    let layout = &problem.evidence.layout;
    let mut all = Vec::new();
    if let Some(Worth::Exact(ratio)) = beaten {
        all.extend(score_inequalities(layout, problem.goal, ratio, true));
    }
    for &(score, over, least) in &problem.require {
        if over != Across::Mean {
            all.extend(score_inequalities(layout, (score, over), least, false));
        }
    }
    if all.len() > 1 {
        all.insert(0, Inequality::sum(&all));
    }
    Question { all, beaten }
}

/// What a score must reach, or beat. Of a mean there is one only if no set changes what its scores are divided by.
pub(super) fn score_inequalities(
    layout: &BitLayout,
    (score, over): (Score, Across),
    ratio: Ratio,
    beat: bool,
) -> Vec<Inequality> {
    let each: Vec<&[MomentBits]> = match over {
        Across::Pooled => vec![&layout.moments],
        Across::Worst => layout.moments.chunks(1).collect(),
        Across::Mean => return mean_inequality(layout, score, ratio).into_iter().collect(),
    };
    let of = |(moment, moments)| {
        let one = inequality(layout, moments, score, ratio, beat)?;
        Some(Inequality { moment, ..one })
    };
    each.into_iter().enumerate().filter_map(of).collect()
}

/// The inequality of some moments together; `None` where it may have no value, and then is no obstacle.
fn inequality(
    layout: &BitLayout,
    moments: &[MomentBits],
    score: Score,
    ratio: Ratio,
    beat: bool,
) -> Option<Inequality> {
    let Ratio { numerator: p, denominator: q } = ratio;
    let sum = |of: fn(&MomentBits) -> u64| moments.iter().map(of).sum::<u64>();
    let [t, f] = [sum(|moment| moment.voxels[0]), sum(|moment| moment.voxels[1])];
    let joined = |space: usize| {
        moments.first().map_or(0, |m| m.words[space].start)..moments.last().map_or(0, |m| m.words[space].end)
    };
    let (truly, falsely, s) = (i128::from(t), i128::from(f), i128::from(t + f));
    match score {
        Score::F1 | Score::Kappa => {
            let (hit, clear, charge, par) = match score {
                Score::F1 => (2 * q - p, p, 0, p * s),
                _ => (
                    (falsely * q + truly * p).max(0),
                    (truly * q + falsely * p).max(0),
                    (q - p) * truly,
                    p * s * s,
                ),
            };
            if t == 0 || (f == 0 && score == Score::Kappa) {
                return None;
            }
            let gains = vec![(HIT, joined(0), hit, t), (CLEAR, joined(1), clear, f)];
            let charges = vec![(joined(1), charge)];
            Some(WeightedTerms { gains, charges, par, beat }.scale())
        }
        Score::HumanSeen => {
            let parts = moments.iter().flat_map(|moment| &moment.parts);
            let people: u64 = parts.map(|part| part.voxels).sum();
            let gains = vec![(SEEN, joined(2), q, people)];
            let par = p * i128::from(people);
            (people > 0).then(|| WeightedTerms { gains, charges: Vec::new(), par, beat }.scale())
        }
        Score::Unknown => {
            // Of the voxels at most p/q are unknown, so the others have a label.
            let labelled = [(HIT, 0, t), (MISSED, 0, t), (FALSE, 1, f), (CLEAR, 1, f)];
            let gains = labelled.map(|(plane, space, bits)| (plane, joined(space), q, bits)).to_vec();
            let par = (q - p) * s;
            (s > 0).then(|| WeightedTerms { gains, charges: Vec::new(), par, beat }.scale())
        }
        // No inequality says how people's voxels are labelled, which labels are wrong, or what two sensors label.
        Score::HumanClaimed | Score::FalseAlarm | Score::SeenTwice => None,
        Score::PeopleDetected | Score::PartsDetected => {
            let groups: Vec<Group> = moments.iter().flat_map(|moment| who(layout, moment, score)).collect();
            let (count, whole) = (groups.len() as i128, i128::from(layout.min_hits()));
            // The number that must be detected.
            let detected = match beat {
                true => (p * count).div_euclid(q) + 1,
                false => (p * count + q - 1).div_euclid(q),
            };
            let least = i64::try_from(detected * whole).unwrap_or(i64::MAX);
            (count > 0).then_some(Inequality {
                groups,
                charges: Vec::new(),
                moment: 0,
                least,
                exact: Default::default(),
            })
        }
    }
}

/// The inequality of a mean of scores: what each moment has, in units of the whole score. Rounding lets more sets pass.
fn mean_inequality(
    layout: &BitLayout,
    score: Score,
    Ratio { numerator: p, denominator: q }: Ratio,
) -> Option<Inequality> {
    let unit = (1u64 << BITS) / layout.moments.len().max(1) as u64;
    let all_of = |moment: &MomentBits, planes: &[usize], whole: u64| -> Option<Vec<Group>> {
        let weight = unit.div_ceil(whole.max(1));
        let segment =
            |&plane: &usize| Segment { plane, words: moment.words[SPACE_OF[plane]].clone(), weight };
        let segments = planes.iter().map(segment).collect();
        (whole > 0).then(|| vec![Group { segments, cap: u64::MAX }])
    };
    let detected = |moment: &MomentBits| {
        let groups = who(layout, moment, score);
        let weight = unit.div_ceil(groups.len().max(1) as u64 * layout.min_hits().max(1));
        let group = |group: Group| {
            let segment = |segment: Segment| Segment { weight: segment.weight * weight, ..segment };
            Group { segments: group.segments.into_iter().map(segment).collect(), cap: group.cap * weight }
        };
        (!groups.is_empty()).then(|| groups.into_iter().map(group).collect())
    };
    let of_moment = |moment: &MomentBits| match score {
        Score::HumanSeen => all_of(moment, &[SEEN], moment.parts.iter().map(|part| part.voxels).sum()),
        Score::Unknown => all_of(moment, &[HIT, MISSED, FALSE, CLEAR], moment.voxels.iter().sum()),
        Score::PeopleDetected | Score::PartsDetected => detected(moment),
        Score::F1 | Score::Kappa | Score::HumanClaimed | Score::FalseAlarm | Score::SeenTwice => None,
    };
    let valued: Vec<Vec<Group>> = layout.moments.iter().filter_map(of_moment).collect();
    let share = if score.less_is_better() { q - p } else { p };
    let least = valued.len() as i128 * i128::from(unit) * share / q;
    // A mean of rounded scores may reach what the exact one misses by a little.
    let slack = i128::from(unit >> 20);
    (!valued.is_empty()).then(|| Inequality {
        groups: valued.concat(),
        charges: Vec::new(),
        moment: 0,
        least: (least - slack) as i64,
        exact: Default::default(),
    })
}

/// A group for each part or person that counts.
fn who(layout: &BitLayout, moment: &MomentBits, score: Score) -> Vec<Group> {
    let cap = layout.min_hits();
    let counting = || moment.parts.iter().filter(|part| part.voxels >= cap);
    let seen = |words: &Range<usize>| Segment { plane: SEEN, words: words.clone(), weight: 1 };
    if score == Score::PartsDetected {
        return counting().map(|part| Group { segments: vec![seen(&part.words)], cap }).collect();
    }
    let mut people: Vec<usize> = counting().map(|part| part.person).collect();
    people.dedup();
    let person = |person: usize| {
        let seen = counting().filter(|part| part.person == person).map(|part| seen(&part.words));
        let own = moment.parts.iter().filter(|part| part.person == person);
        let felt = own.map(|part| Segment { plane: FELT, words: part.words.clone(), weight: cap });
        Group { segments: seen.chain(felt).collect(), cap }
    };
    people.into_iter().map(person).collect()
}

impl WeightedTerms {
    fn scale(self) -> Inequality {
        let most: i128 = self.gains.iter().map(|&(_, _, weight, bits)| weight * i128::from(bits)).sum();
        let largest = most.max(self.par.abs()).max(1);
        let shift = (128 - largest.leading_zeros()) as i32 - BITS as i32;
        let up = |n: i128| {
            if shift <= 0 { n << -shift } else { (n >> shift) + i128::from(n & ((1 << shift) - 1) != 0) }
        };
        let down = |n: i128| if shift <= 0 { n << -shift } else { n >> shift };
        let exact = (self.gains.iter().map(|gain| gain.2).collect(), self.par + i128::from(self.beat));
        let gain = |(plane, words, weight, _)| Segment { plane, words, weight: up(weight) as u64 };
        let charge = |(words, weight)| Segment { plane: FALSE, words, weight: down(weight) as u64 };
        Inequality {
            groups: vec![Group { segments: self.gains.into_iter().map(gain).collect(), cap: u64::MAX }],
            charges: self.charges.into_iter().map(charge).filter(|charge| charge.weight > 0).collect(),
            moment: 0,
            least: down(self.par + i128::from(self.beat)) as i64,
            exact,
        }
    }
}

impl Inequality {
    /// The sum of several: a set that passes each passes it.
    fn sum(all: &[Inequality]) -> Inequality {
        let mut groups: Vec<Group> = Vec::new();
        for group in all.iter().flat_map(|one| &one.groups) {
            match groups.first_mut().filter(|first| first.cap == u64::MAX && group.cap == u64::MAX) {
                Some(first) => first.segments.extend(group.segments.clone()),
                None => groups.insert(if group.cap == u64::MAX { 0 } else { groups.len() }, group.clone()),
            }
        }
        let charges = all.iter().flat_map(|one| one.charges.clone()).collect();
        Inequality {
            groups,
            charges,
            moment: 0,
            least: all.iter().map(|one| one.least).sum(),
            exact: Default::default(),
        }
    }

    /// At least so many bits of the plane `HIT` at one moment.
    pub(super) fn covered(layout: &BitLayout, moment: usize, least: u64) -> Inequality {
        let words = layout.moments[moment].words[SPACE_OF[HIT]].clone();
        let segments = vec![Segment { plane: HIT, words, weight: 1 }];
        let groups = vec![Group { segments, cap: u64::MAX }];
        let least = i64::try_from(least).unwrap_or(i64::MAX);
        Inequality { groups, charges: Vec::new(), moment, least, exact: Default::default() }
    }

    /// Whether all that counts is how many bits of a union are set.
    pub(super) fn is_plain(&self) -> bool {
        self.groups.len() == 1 && self.groups[0].cap == u64::MAX
    }

    /// All bits that it counts.
    pub(super) fn segments(&self) -> impl Iterator<Item = &Segment> {
        self.groups.iter().flat_map(|group| &group.segments)
    }

    /// What a union has.
    pub(super) fn state(&self, evidence: &CandidateEvidence, union: &Union) -> UnionState {
        let ones = evidence.ones;
        // Sums that are too large are above their cap.
        let filled = |group: &Group| {
            group
                .segments
                .iter()
                .fold(0u64, |sum, segment| sum.saturating_add(segment.count_union(ones, union)))
        };
        let filled: Vec<u64> = self.groups.iter().map(filled).collect();
        let value: u64 = self.groups.iter().zip(&filled).map(|(group, &filled)| filled.min(group.cap)).sum();
        let charged: u64 = self.charges.iter().map(|charge| charge.count_union(ones, union)).sum();
        UnionState { value: value as i64 - charged as i64, filled }
    }

    /// What a candidate adds to a union at most, were nothing it says false.
    pub(super) fn gain(
        &self,
        evidence: &CandidateEvidence,
        union: &Union,
        state: &UnionState,
        item: usize,
    ) -> i64 {
        let mut gain = 0;
        for (group, &filled) in self.groups.iter().zip(&state.filled) {
            let mut fresh = 0u64;
            for segment in &group.segments {
                fresh = fresh.saturating_add(segment.fresh(evidence, union, item));
            }
            gain += filled.saturating_add(fresh).min(group.cap) - filled.min(group.cap);
        }
        gain as i64
    }

    /// What a candidate takes from a union by what it says falsely.
    pub(super) fn loss(&self, evidence: &CandidateEvidence, union: &Union, item: usize) -> i64 {
        let wrong = evidence.plane(item, FALSE);
        if wrong.is_empty() {
            return 0;
        }
        let mut loss = 0;
        let known = union.plane(FALSE);
        for charge in &self.charges {
            let words = charge.words.clone();
            loss += charge.weight * evidence.ones.count_minus(&wrong[words.clone()], &known[words]);
        }
        for segment in self.groups.iter().flat_map(|group| &group.segments).filter(|s| s.plane == CLEAR) {
            let words = segment.words.clone();
            let both = [&wrong[words.clone()], &union.plane(CLEAR)[words.clone()]];
            loss += segment.weight * evidence.ones.count_both_minus(both, &known[words]);
        }
        loss as i64
    }

    /// Whether what two candidates both add to a union is more than so much (not below zero). Only of a plain
    /// inequality.
    pub(super) fn overlap_exceeds(
        &self,
        fresh: &[Vec<u64>],
        evidence: &CandidateEvidence,
        item: usize,
        slack: i64,
    ) -> bool {
        let mut left = slack;
        for (segment, fresh) in self.groups[0].segments.iter().zip(fresh) {
            let row = evidence.plane(item, segment.plane);
            if row.is_empty() {
                continue;
            }
            let most = left as u64 / segment.weight.max(1);
            let both = evidence.ones.count_both_up_to(fresh, &row[segment.words.clone()], most);
            left -= (segment.weight * both) as i64;
            if left < 0 {
                return true;
            }
        }
        false
    }

    /// The voxels that a candidate adds to a union, segment by segment of the first group.
    pub(super) fn added_bits(
        &self,
        evidence: &CandidateEvidence,
        union: &Union,
        item: usize,
    ) -> Vec<Vec<u64>> {
        let of = |segment: &Segment| {
            let row = evidence.plane(item, segment.plane);
            if row.is_empty() { Vec::new() } else { segment.fresh_words(&row, union) }
        };
        self.groups[0].segments.iter().map(of).collect()
    }
}

impl Segment {
    /// What a union has here.
    fn count_union(&self, ones: Ones, union: &Union) -> u64 {
        let words = &union.plane(self.plane)[self.words.clone()];
        match self.plane {
            CLEAR => {
                let bits = ones.count_minus(words, &union.plane(FALSE)[self.words.clone()]);
                self.weight.saturating_mul(bits)
            }
            _ => self.weight.saturating_mul(ones.count(words)),
        }
    }

    /// What a candidate adds here.
    fn fresh(&self, evidence: &CandidateEvidence, union: &Union, item: usize) -> u64 {
        let row = evidence.plane(item, self.plane);
        if row.is_empty() {
            return 0;
        }
        let has = &union.plane(self.plane)[self.words.clone()];
        self.weight.saturating_mul(evidence.ones.count_minus(&row[self.words.clone()], has))
    }

    /// The bits of a row that a union lacks, without voxels that the union wrongly calls occupied.
    fn fresh_words(&self, row: &[u64], union: &Union) -> Vec<u64> {
        let has = &union.plane(self.plane)[self.words.clone()];
        row[self.words.clone()].iter().zip(has).map(|(row, has)| row & !has).collect()
    }
}
