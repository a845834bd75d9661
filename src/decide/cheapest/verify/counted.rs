//! Scores of counts in a plain way: of a set, and the best possible of sets with given members.
//!
//! # Theory
//! More members never label fewer voxels, nor hit fewer of a person, and if one labels a free voxel wrongly, no
//! later one corrects it. So a set scores no better than the union of its members with all candidates that may
//! join, of which only the members make errors: F1 and κ of 0 or more rise with TP and TN, and fall with FP and FN.
//! With t and f the truly occupied and truly free voxels and s = t + f, F1 ≥ p/q if and only if (2q − p)·TP + p·TN ≥ p·s;
//! κ ≥ p/q ≥ 0 only if (f·q + t·p)·TP + (t·q + f·p)·TN ≥ p·s²; at most p/q is unknown if and only if q·(voxels with a
//! label) ≥ (q − p)·s. The gain of several candidates is at most the sum of their gains.
//!
//! Under log-odds others may outvote a wrong member, so no false alarm is certain.

use std::ops::Range;

use crate::judge::{Value, dead_members};
use perirobot_cover::CandidateEvidence;
use perirobot_cover::layout::{
    CLEAR, FALSE, FELT, HIT, MISSED, MomentBits, PLANES, SEEN, SPACE_OF, WantedCounts,
};
use perirobot_march::metrics::{Across, Confusion, Ratio, Score};
use perirobot_march::voxel::{Joined, Ones};
use perirobot_study::input::Limit;

/// Largest difference of two means of scores by rounding.
const ROUNDING: f64 = 1e-9;

/// A score that a set must have, also without `dead` of its members.
pub(super) struct Reach<'a> {
    pub(super) evidence: &'a CandidateEvidence,
    /// Index of the region of its counts.
    pub(super) region: usize,
    pub(super) score: Score,
    pub(super) over: Across,
    pub(super) bar: Bar,
    pub(super) dead: usize,
    /// Whether the fusion adds up evidence, so that unions only bound the labels.
    pub(super) adds_up: bool,
}

/// The limit of a score.
#[derive(Clone, Copy, Debug)]
pub(super) enum Bar {
    /// It meets a limit.
    Keeps(Limit),
    /// It is better than a limit.
    Beats(Limit),
    /// Its mean is better than a number.
    BeatsMean(f64),
    /// It has a value.
    HasValue,
}

/// The deficit of a part of a set in an inequality, and the largest gain of each candidate.
pub(super) struct Tally {
    pub(super) lacks: i128,
    pub(super) gains: Vec<i128>,
    /// The number of added members that are dead.
    dead_later: usize,
}

/// Six planes of bits.
type SetPlanes = [Vec<u64>; PLANES];

/// Planes whose bits count once, however many have them.
type Group = &'static [usize];

/// An inequality: weighted counts of bits sum up to at least `least`.
struct Line {
    words: [Range<usize>; 3],
    groups: Vec<(Group, i128)>,
    least: i128,
}

/// A score over moments, as in the tables.
pub(super) fn value(score: Score, over: Across, counts: &[Confusion]) -> Option<f64> {
    let values: Vec<f64> = counts.iter().filter_map(|counts| score.evaluate(counts)).collect();
    match over {
        Across::Pooled => score.evaluate(&counts.iter().fold(Confusion::default(), |all, one| all.plus(one))),
        Across::Worst if score.less_is_better() => values.into_iter().reduce(f64::max),
        Across::Worst => values.into_iter().reduce(f64::min),
        Across::Mean if values.is_empty() => None,
        Across::Mean => Some(values.iter().sum::<f64>() / values.len() as f64),
    }
}

/// Whether a score depends on labels, which sums decide under log-odds.
pub(super) fn is_of_labels(score: Score) -> bool {
    !matches!(score, Score::HumanSeen | Score::PeopleDetected | Score::PartsDetected)
}

impl Reach<'_> {
    /// Whether a set has the score, if unions decide.
    pub(super) fn holds(&self, set: &[usize]) -> bool {
        let is_met = |part: &Vec<usize>| self.is_met(&self.counts_of_set(part));
        self.parts(set).iter().all(is_met)
    }

    /// The counts of a set, moment by moment, if unions decide.
    pub(super) fn counts_of_set(&self, set: &[usize]) -> Vec<Confusion> {
        self.counts(&self.union(set))
    }

    /// Whether counts have the score.
    pub(super) fn is_met(&self, counts: &[Confusion]) -> bool {
        self.is_nearly_met(counts, 0.0)
    }

    /// Whether no set with some members, and otherwise only some others, has the score.
    pub(super) fn is_out_of_reach(&self, chosen: &[usize], later: &[usize]) -> bool {
        if !self.is_bounded() {
            return false;
        }
        let all_later = self.union(later);
        let is_unknown = self.score == Score::Unknown;
        self.parts(chosen).iter().any(|part| {
            let mut planes = self.union(part);
            let may_add = |&plane: &usize| is_unknown || ![MISSED, FALSE].contains(&plane);
            for plane in (0..PLANES).filter(may_add) {
                planes[plane].iter_mut().zip(&all_later[plane]).for_each(|(to, from)| *to |= from);
            }
            if !is_unknown {
                planes[MISSED].fill(0);
            }
            if !is_unknown && self.adds_up {
                planes[FALSE].fill(0);
            }
            let counts = self.counts(&planes);
            // If the best has no value, the others are unknown.
            let has_value = value(self.score, self.over, &counts).is_some();
            has_value && !self.is_nearly_met(&counts, ROUNDING)
        })
    }

    /// The deficits of the parts of a set, and the largest gain of each candidate.
    pub(super) fn tallies(&self, chosen: &[usize], later: &[usize]) -> Vec<Tally> {
        let (lines, dead_later) = (self.lines(), self.dead.saturating_sub(chosen.len()));
        let mut tallies = Vec::new();
        for part in if lines.is_empty() { Vec::new() } else { self.parts(chosen) } {
            let union = self.union(&part);
            for line in &lines {
                let gains = later.iter().map(|&item| self.count(line, &union, Some(item))).collect();
                let lacks = line.least - self.count(line, &union, None);
                tallies.push(Tally { lacks, gains, dead_later });
            }
        }
        tallies
    }

    /// The left side of an inequality for a union, or the largest gain of a candidate.
    fn count(&self, line: &Line, union: &SetPlanes, item: Option<usize>) -> i128 {
        let ones = Ones::plain();
        let of_group = |&(planes, weight): &(Group, i128)| {
            let words = line.words[SPACE_OF[planes[0]]].clone();
            let mut has = vec![0u64; words.len()];
            for &plane in planes {
                has.iter_mut().zip(&union[plane][words.clone()]).for_each(|(to, from)| *to |= from);
            }
            let nothing = vec![0u64; words.len()];
            let is_certain = planes == [CLEAR] && !self.adds_up;
            let wrong = if is_certain { &union[FALSE][words.clone()] } else { &nothing[..] };
            let adds = |item: usize, plane: usize| {
                let row = self.evidence.plane(item, plane);
                row.get(words.clone()).map_or(0, |row| ones.count_minus_two(row, [&has, wrong]))
            };
            let bits: u64 = match item {
                None => ones.count_minus(&has, wrong),
                Some(item) => planes.iter().map(|&plane| adds(item, plane)).sum(),
            };
            weight * i128::from(bits)
        };
        line.groups.iter().map(of_group).sum()
    }

    /// Whether the bounds hold: the score must be good, and only correct labels improve it.
    fn is_bounded(&self) -> bool {
        let (is_natural, is_negative) = match self.bar {
            Bar::Keeps(limit) | Bar::Beats(limit) => {
                let is_upper = matches!(limit, Limit::AtMost(_));
                (is_upper == self.score.less_is_better(), limit.ratio().numerator < 0)
            }
            Bar::BeatsMean(mean) => (true, mean < 0.0),
            Bar::HasValue => (false, false),
        };
        is_natural && self.score != Score::FalseAlarm && !(self.score == Score::Kappa && is_negative)
    }

    fn is_nearly_met(&self, counts: &[Confusion], rounding: f64) -> bool {
        let exactly = |limit: &Limit| Value::from_counts(self.score, self.over, limit, counts);
        let number = || value(self.score, self.over, counts);
        match self.bar {
            Bar::Keeps(limit) => exactly(&limit).is_some_and(|value| value.meets(&limit)),
            Bar::Beats(limit) => exactly(&limit).is_some_and(|value| {
                let order = value.cmp_ratio(limit.ratio());
                if matches!(limit, Limit::AtMost(_)) { order.is_lt() } else { order.is_gt() }
            }),
            Bar::BeatsMean(mean) => number().is_some_and(|value| {
                let better = if self.score.less_is_better() { mean - value } else { value - mean };
                better + rounding > 0.0
            }),
            Bar::HasValue => number().is_some(),
        }
    }

    /// The rest of a set in each case with as many dead members as allowed.
    fn parts(&self, set: &[usize]) -> Vec<Vec<usize>> {
        if set.is_empty() {
            return vec![Vec::new()];
        }
        let alive = |dead: Vec<usize>| {
            let alive = set.iter().enumerate().filter(|(place, _)| !dead.contains(place));
            alive.map(|(_, &item)| item).collect()
        };
        dead_members(set.len(), self.dead).into_iter().map(alive).collect()
    }

    fn union(&self, set: &[usize]) -> SetPlanes {
        let widths = self.evidence.layout.words;
        let mut union: SetPlanes = std::array::from_fn(|plane| vec![0; widths[SPACE_OF[plane]]]);
        for &item in set {
            for (plane, union) in union.iter_mut().enumerate() {
                let row = self.evidence.plane(item, plane);
                union.iter_mut().zip(&*row).for_each(|(to, from)| *to |= from);
            }
        }
        union
    }

    fn counts(&self, planes: &SetPlanes) -> Vec<Confusion> {
        let planes: [Joined; PLANES] = std::array::from_fn(|plane| Joined::new(&planes[plane], &[]));
        let layout = &self.evidence.layout;
        let count = |moment| layout.counts(Ones::plain(), moment, &planes, WantedCounts::ALL);
        layout.moments.iter().map(count).collect()
    }

    /// The inequalities of a set with the score.
    fn lines(&self) -> Vec<Line> {
        let (Bar::Keeps(limit) | Bar::Beats(limit)) = self.bar else { return Vec::new() };
        if !self.is_bounded() {
            return Vec::new();
        }
        let moments = &self.evidence.layout.moments;
        let each: Vec<&[MomentBits]> = match self.over {
            Across::Pooled => vec![moments],
            Across::Worst => moments.chunks(1).collect(),
            Across::Mean => Vec::new(),
        };
        each.into_iter().filter_map(|moments| line(self.score, limit.ratio(), moments)).collect()
    }
}

/// The inequality of a score over some moments together; `None` if the score may have no value.
fn line(score: Score, limit: Ratio, moments: &[MomentBits]) -> Option<Line> {
    let Ratio { numerator: p, denominator: q } = limit;
    let sum = |of: &dyn Fn(&MomentBits) -> u64| i128::from(moments.iter().map(of).sum::<u64>());
    let [t, f] = [0, 1].map(|truth: usize| sum(&|moment| moment.voxels[truth]));
    let (s, people) = (t + f, sum(&|moment| moment.parts.iter().map(|part| part.voxels).sum()));
    let (groups, least): (Vec<(Group, i128)>, i128) = match score {
        Score::F1 if t > 0 => (vec![(&[HIT], (2 * q - p).max(0)), (&[CLEAR], p.max(0))], p * s),
        Score::Kappa if t > 0 && f > 0 => {
            (vec![(&[HIT], f * q + t * p), (&[CLEAR], t * q + f * p)], p * s * s)
        }
        Score::HumanSeen if people > 0 => (vec![(&[SEEN, FELT], q)], p * people),
        Score::Unknown if s > 0 => (vec![(&[HIT, MISSED], q), (&[FALSE, CLEAR], q)], (q - p) * s),
        _ => return None,
    };
    let begin = |space: usize| moments.first().map_or(0, |one| one.words[space].start);
    let end = |space: usize| moments.last().map_or(0, |one| one.words[space].end);
    Some(Line { words: [0, 1, 2].map(|space| begin(space)..end(space)), groups, least })
}

impl Tally {
    /// The same for candidates in another order.
    pub(super) fn in_order(self, order: &[usize]) -> Tally {
        Tally { gains: order.iter().map(|&place| self.gains[place]).collect(), ..self }
    }

    /// Whether the candidates from a place on can add enough within `count` and the remaining budget.
    pub(super) fn may_reach(&self, from: usize, left: usize, (costs, money): (&[u64], Option<u64>)) -> bool {
        let mut gains: Vec<(i128, u64)> =
            self.gains[from..].iter().copied().zip(costs[from..].iter().copied()).collect();
        gains.retain(|(gain, _)| *gain > 0);
        gains.sort_unstable_by_key(|(gain, _)| std::cmp::Reverse(*gain));
        let best = gains.iter().take(left.saturating_sub(self.dead_later));
        if best.map(|(gain, _)| gain).sum::<i128>() < self.lacks {
            return false;
        }
        let Some(money) = money else { return true };
        // Fractional knapsack: best ratio of gain to cost first, the last one in part.
        let per_cost = |(gain, cost): &(i128, u64)| *gain as f64 / *cost as f64;
        gains.sort_by(|a, b| per_cost(b).total_cmp(&per_cost(a)));
        let (mut money, mut sum) = (money as f64, 0.0);
        for (gain, cost) in gains {
            let share = if cost as f64 <= money { 1.0 } else { money / cost as f64 };
            sum += share * gain as f64;
            money -= share * cost as f64;
        }
        sum * (1.0 + ROUNDING) >= self.lacks as f64
    }
}
