//! A proof checked by other code than the one that found it: nothing is shared with the search but what each candidate
//! says. The sets are counted again by a backend of the caller's choice, whether they are allowed is judged from the
//! study, and that none is better is searched again in a plain way, without rounding.
//!
//! # Theory
//! With t and f the truly occupied and truly free voxels and s = t + f, F1 > p/q just if (2q − p)·TP + p·TN − p·s > 0;
//! κ > p/q only if (f·q + t·p)·TP + (t·q + f·p)·TN − p·s² > 0. What several candidates add to a union is no more than
//! the sum of what each adds. A part is detected only if its best hits together are enough.

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::Deserialize;
use serde_json::Value;

use super::evidence::CandidateEvidence;
use super::files::{PROOF, asked, fingerprint};
use super::layout::{CLEAR, FALSE, FELT, HIT, MomentBits, SEEN, ones};
use crate::backend::{Backend, Fusion};
use crate::error::Issue;
use crate::metrics::{Confusion, Score};
use crate::results::files::read_regular;
use crate::sensor::{Cost, Setting};
use crate::study::{Across, Choose, Combination, Member, Study};
use crate::sweep::run;
use crate::world::World;
use crate::{Error, Result};

/// What a proof says, as far as it is checked.
#[derive(Deserialize)]
struct Proof {
    fingerprint: String,
    asked: Value,
    steps: Vec<ClaimedStep>,
}

#[derive(Deserialize)]
struct ClaimedStep {
    at_most: usize,
    budget: Option<f64>,
    best: ClaimedSet,
    no_set_is_above: Option<f64>,
    proven: bool,
}

#[derive(Deserialize)]
struct ClaimedSet {
    poses: Vec<String>,
    cost: Option<f64>,
    score: f64,
    exactly: Option<[String; 2]>,
}

/// What was checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Verified {
    /// Sets that were counted again.
    pub sets: usize,
    /// Steps for which it was shown again that no set is better.
    pub proven: usize,
    /// Steps that claim no such thing.
    pub open: usize,
}

/// A proof that was read, of the sets that a study asks for.
pub struct Claims {
    path: PathBuf,
    steps: Vec<ClaimedStep>,
    /// Sensor and candidate of each in the best set of each step.
    sets: Vec<Vec<[usize; 2]>>,
}

impl Claims {
    /// Reads the proof in a folder, and judges whether its sets are allowed.
    ///
    /// # Errors
    /// `Error::Input` that names what is wrong.
    pub fn read(folder: &Path, study: &Study, choose: &Choose, worlds: &[World]) -> Result<Claims> {
        let path = folder.join(PROOF);
        let wrong = |place: &str, what: &str| Err(Error::input(place, what).at(&path));
        let proof: Proof = serde_json::from_slice(&read_regular(&path)?)
            .map_err(|e| Error::from(Issue::damaged(format!("is no proof of choose: {e}")).at(&path)))?;
        if proof.fingerprint != fingerprint(study, worlds) {
            return wrong("fingerprint", "the study is not what was searched: choose again");
        }
        if proof.asked != asked(study, choose) {
            return wrong("asked", "the study asks for something else now: choose again");
        }
        let mut sets = Vec::new();
        for (number, step) in proof.steps.iter().enumerate() {
            let set = named(study, &step.best.poses).and_then(|set| {
                match not_allowed(study, choose, worlds, step, &set) {
                    Some(why) => Err(Issue::says(why)),
                    None => Ok(set),
                }
            });
            sets.push(set.map_err(|issue| issue.at(format!("steps[{number}].best")).at(&path))?);
        }
        Ok(Claims { path, steps: proof.steps, sets })
    }
}

/// Checks a proof.
///
/// # Errors
/// `Error::Input` that names what does not hold; `Error::Stopped` when it is stopped.
pub fn verify(
    claims: &Claims,
    study: &Study,
    choose: &Choose,
    worlds: &[World],
    evidence: &CandidateEvidence,
    recounter: &mut dyn Backend,
    stop: &(dyn Fn() -> Option<String> + Sync),
) -> Result<Verified> {
    let Claims { path, steps, sets } = claims;
    let wrong = |place: String, what: String| Err(Error::input(place, what).at(path));
    let counts = recounted(study, choose, worlds, sets, recounter)?;
    let mut verified = Verified { sets: sets.len(), proven: 0, open: 0 };
    for (number, (step, counts)) in steps.iter().zip(&counts).enumerate() {
        let place = format!("steps[{number}]");
        let value = value(choose.objective, choose.over, counts);
        if value != Some(step.best.score) {
            let what = format!(
                "{} is {}, and counted again it is {value:?}",
                choose.objective.name(),
                step.best.score
            );
            return wrong(format!("{place}.best.score"), what);
        }
        if let Some(require) = choose.require.iter().find(|require| {
            !value_reaches(self::value(require.score, require.over, counts), require.at_least)
        }) {
            return wrong(
                format!("{place}.best"),
                format!("does not reach {} {}", require.score.name(), require.at_least),
            );
        }
        let exact = exact(choose.objective, choose.over, counts);
        let claimed = step.best.exactly.as_ref().map(|[n, d]| (n.parse::<i128>(), d.parse::<i128>()));
        let claimed = claimed.and_then(|(n, d)| Some((n.ok()?, d.ok()?)));
        if let Some((n, d)) = exact
            && claimed.is_none_or(|(claimed_n, claimed_d)| {
                let [left, right] = [claimed_n.checked_mul(d), claimed_d.checked_mul(n)];
                claimed_d == 0 || left.is_none() || left != right
            })
        {
            return wrong(format!("{place}.best.exactly"), format!("counted again it is {n}/{d}"));
        }
        let Some(claimed) = exact.filter(|_| step.proven) else {
            if step.proven {
                return wrong(format!("{place}.proven"), "a mean of scores has no proof".into());
            }
            verified.open += 1;
            continue;
        };
        if step.no_set_is_above != Some(step.best.score) {
            return wrong(
                format!("{place}.no_set_is_above"),
                "is not the score of the best set, which is proven".into(),
            );
        }
        let plain = Plain { study, choose, worlds, evidence, step, claimed, stop };
        if let Some(better) = plain.better() {
            let names: Vec<String> = better.iter().map(|&item| name(study, evidence.items[item])).collect();
            return wrong(format!("{place}.best"), format!("this set is better: {}", names.join(";")));
        }
        if let Some(why) = stop() {
            return Err(Error::Stopped(Issue::says(why)));
        }
        verified.proven += 1;
    }
    Ok(verified)
}

fn name(study: &Study, [sensor, candidate]: [usize; 2]) -> String {
    let sensor = &study.sensors[sensor];
    format!("{}:{}", sensor.name, sensor.candidates[candidate].name)
}

/// Sensors and candidates by their names.
fn named(study: &Study, poses: &[String]) -> Result<Vec<[usize; 2]>, Issue> {
    let one = |pose: &String| {
        let all = study.sensors.iter().enumerate();
        let mut all = all.flat_map(|(sensor, spec)| (0..spec.candidates.len()).map(move |c| [sensor, c]));
        all.find(|&item| name(study, item) == *pose)
            .ok_or_else(|| Issue::says(format!("{pose:?} is no pose of the study")))
    };
    poses.iter().map(one).collect()
}

/// Why a set is not allowed.
fn not_allowed(
    study: &Study,
    choose: &Choose,
    worlds: &[World],
    step: &ClaimedStep,
    set: &[[usize; 2]],
) -> Option<String> {
    let cost: u64 = set.iter().map(|&[sensor, _]| thousandths(study, sensor)).sum();
    let amount = |amount: f64| Cost::new(amount).map(Cost::thousandths);
    if step.best.cost.is_some_and(|claimed| amount(claimed) != Some(cost)) {
        return Some(format!("costs {}, not what is said", Cost::from_thousandths(cost)));
    }
    if step.budget.is_some_and(|budget| amount(budget).is_none_or(|budget| cost > budget)) {
        return Some("costs more than the budget of its step".into());
    }
    if step.at_most > choose.at_most || choose.budget.is_some_and(|budget| cost > budget.thousandths()) {
        return Some("is beyond what the study allows".into());
    }
    if set.len() > step.at_most || set.is_empty() {
        return Some(format!("has {} sensors, and at most {} are allowed", set.len(), step.at_most));
    }
    if let Some(missing) = choose.always.iter().find(|always| !set.contains(always)) {
        return Some(format!("lacks {}, which is in every set", name(study, *missing)));
    }
    clash(study, choose, worlds, set)
}

fn thousandths(study: &Study, sensor: usize) -> u64 {
    study.sensors[sensor].terms.cost.map_or(0, Cost::thousandths)
}

/// Why some candidates cannot be in a set together.
fn clash(study: &Study, choose: &Choose, worlds: &[World], set: &[[usize; 2]]) -> Option<String> {
    for (number, &a) in set.iter().enumerate() {
        let most = study.sensors[a[0]].terms.at_most.map_or(usize::MAX, |most| most as usize);
        if set.iter().filter(|other| other[0] == a[0]).count() > most {
            return Some(format!("has more of {:?} than the sensor's at_most", study.sensors[a[0]].name));
        }
        for &b in &set[number + 1..] {
            if a == b {
                return Some(format!("has {} twice", name(study, a)));
            }
            if choose.always.contains(&a) && choose.always.contains(&b) {
                continue;
            }
            let near = worlds.iter().any(|world| {
                let setting = |[sensor, candidate]: [usize; 2]| world.settings[sensor][candidate];
                match (setting(a), setting(b)) {
                    (Setting::Pose(a), Setting::Pose(b)) => {
                        a.position_m.distance(b.position_m) < choose.apart_m - 1e-9
                    }
                    _ => false,
                }
            });
            if near {
                return Some(format!("has {} and {} nearer than apart_m", name(study, a), name(study, b)));
            }
        }
    }
    None
}

/// What a sweep counts for some sets, repeat by repeat, and in each world by world.
fn recounted(
    study: &Study,
    choose: &Choose,
    worlds: &[World],
    sets: &[Vec<[usize; 2]>],
    backend: &mut dyn Backend,
) -> Result<Vec<Vec<Confusion>>> {
    let combination = |(number, set): (usize, &Vec<[usize; 2]>)| Combination {
        name: number.to_string(),
        fusion: Fusion::OccupiedWins,
        members: set.iter().map(|&[sensor, c]| Member { sensor, candidates: vec![c] }).collect(),
    };
    let combinations = sets.iter().enumerate().map(combination).collect();
    let study = Study { combinations, ..study.clone() };
    let mut rows = run(&study, worlds, backend)?;
    rows.sort_by_key(|row| row.repeat);
    let mut counts = vec![Vec::new(); sets.len()];
    let ways: Vec<_> = study.combinations.iter().map(|one| one.representations(&study.sensors)).collect();
    for row in rows.iter().filter(|row| row.region == choose.region) {
        let wanted =
            study.combinations[row.combination].members.iter().map(|member| choose.ways[member.sensor]);
        if wanted.eq(ways[row.combination][row.representation].iter().copied()) {
            counts[row.combination].push(row.counts);
        }
    }
    Ok(counts)
}

/// A score over moments, as tables have it.
fn value(score: Score, over: Across, counts: &[Confusion]) -> Option<f64> {
    let values: Vec<f64> = counts.iter().filter_map(|counts| score.of(counts)).collect();
    match over {
        Across::Pooled => score.of(&sum(counts)),
        Across::Worst => values.into_iter().reduce(f64::min),
        Across::Mean if values.is_empty() => None,
        Across::Mean => Some(values.iter().sum::<f64>() / values.len() as f64),
    }
}

fn value_reaches(value: Option<f64>, least: f64) -> bool {
    value.is_some_and(|value| value >= least)
}

fn sum(counts: &[Confusion]) -> Confusion {
    counts.iter().fold(Confusion::default(), |all, one| all.plus(one))
}

/// Numerator and denominator of a score that is no mean.
fn exact(score: Score, over: Across, counts: &[Confusion]) -> Option<(i128, i128)> {
    let one = |c: &Confusion| -> Option<(i128, i128)> {
        let [tp, fp, fn_, tn, uo, uf] = [c.tp, c.fp, c.fn_, c.tn, c.uo, c.uf].map(i128::from);
        let (n, d) = match score {
            Score::F1 => (2 * tp, 2 * tp + fp + fn_ + uo + uf),
            Score::Kappa => {
                let s = tp + fp + fn_ + tn + uo + uf;
                let chance = (tp + fp) * (tp + fn_ + uo) + (fn_ + tn) * (fp + tn + uf);
                (s * (tp + tn) - chance, s * s - chance)
            }
            Score::HumanSeen => (c.detection.hit_human.into(), c.people_voxels().into()),
            Score::PeopleDetected => (c.detection.people_detected.into(), c.detection.people.into()),
            _ => (c.detection.parts_detected.into(), c.detection.parts.into()),
        };
        (d != 0).then_some((n, d))
    };
    match over {
        Across::Pooled => one(&sum(counts)),
        Across::Worst => counts.iter().filter_map(one).min_by(|a, b| (a.0 * b.1).cmp(&(b.0 * a.1))),
        Across::Mean => None,
    }
}

/// The plain search for a set that is better than the best of a step.
struct Plain<'a> {
    study: &'a Study,
    choose: &'a Choose,
    worlds: &'a [World],
    evidence: &'a CandidateEvidence,
    step: &'a ClaimedStep,
    claimed: (i128, i128),
    stop: &'a (dyn Fn() -> Option<String> + Sync),
}

/// What some candidates say together.
type SetPlanes = [Vec<u64>; 6];

impl Plain<'_> {
    /// A better set, if there is one.
    fn better(&self) -> Option<Vec<usize>> {
        let items = &self.evidence.items;
        let fixed: Vec<usize> =
            (0..items.len()).filter(|&i| self.choose.always.contains(&items[i])).collect();
        let others: Vec<usize> = (0..items.len()).filter(|i| !fixed.contains(i)).collect();
        if self.is_better(&fixed) {
            return Some(fixed);
        }
        let left = self.step.at_most - fixed.len();
        let order = self.open(&fixed, &others, left);
        (0..order.len()).into_par_iter().find_map_first(|i| self.below(&fixed, &order, i, left))
    }

    /// A better set among those that have one more candidate, the first of those in order from a place on.
    fn below(&self, chosen: &[usize], order: &[usize], i: usize, left: usize) -> Option<Vec<usize>> {
        let set = [chosen, &order[i..=i]].concat();
        if self.is_better(&set) {
            return Some(set);
        }
        if left == 1 || (self.stop)().is_some() {
            return None;
        }
        let order = self.open(&set, &order[i + 1..], left - 1);
        (0..order.len()).find_map(|i| self.below(&set, &order, i, left - 1))
    }

    fn is_better(&self, set: &[usize]) -> bool {
        let counts = self.evidence.counts(set);
        let (n, d) = self.claimed;
        let exact = exact(self.choose.objective, self.choose.over, &counts);
        let reaches =
            |r: &crate::study::Requirement| value_reaches(value(r.score, r.over, &counts), r.at_least);
        !set.is_empty()
            && exact.is_some_and(|(a, b)| a * d > n * b)
            && self.choose.require.iter().all(reaches)
    }

    /// The candidates that may join a set and lead to a better one, those that add most first.
    fn open(&self, chosen: &[usize], candidates: &[usize], left: usize) -> Vec<usize> {
        if left == 0 {
            return Vec::new();
        }
        let poses = |set: &[usize]| set.iter().map(|&item| self.evidence.items[item]).collect::<Vec<_>>();
        let budget = self.step.budget.and_then(Cost::new).map_or(u64::MAX, Cost::thousandths);
        let cost = |set: &[usize]| {
            poses(set).iter().map(|&[sensor, _]| thousandths(self.study, sensor)).sum::<u64>()
        };
        let joins = |&&item: &&usize| {
            let set = [chosen, &[item]].concat();
            cost(&set) <= budget && clash(self.study, self.choose, self.worlds, &poses(&set)).is_none()
        };
        let candidates: Vec<usize> = candidates.iter().filter(joins).copied().collect();
        let union = self.union(chosen);
        let mut worth: Vec<(i128, usize)> = candidates.iter().map(|&item| (0, item)).collect();
        let mut may = vec![true; candidates.len()];
        let moments = &self.evidence.layout.moments;
        let asked: Vec<&[MomentBits]> = match self.choose.over {
            Across::Pooled => vec![moments],
            _ => moments.chunks(1).collect(),
        };
        for moments in asked {
            let Some((value, gains)) = self.gains(moments, &union, &candidates, left) else { continue };
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
        let widths = self.evidence.layout.words;
        let mut union: SetPlanes = std::array::from_fn(|plane| vec![0; widths[plane / 2]]);
        for &item in set {
            for (plane, union) in union.iter_mut().enumerate() {
                union.iter_mut().zip(self.evidence.plane(item, plane)).for_each(|(to, from)| *to |= from);
            }
        }
        union
    }

    /// By how much some moments together are above what is claimed, or below, and what each candidate adds at most;
    /// nothing where the score may have no value.
    fn gains(
        &self,
        moments: &[MomentBits],
        union: &SetPlanes,
        items: &[usize],
        left: usize,
    ) -> Option<(i128, Vec<i128>)> {
        let (p, q) = self.claimed;
        let sum =
            |of: fn(&MomentBits) -> u64| moments.iter().map(|moment| i128::from(of(moment))).sum::<i128>();
        let [t, f] = [sum(|moment| moment.voxels[0]), sum(|moment| moment.voxels[1])];
        let s = t + f;
        match self.choose.objective {
            Score::F1 | Score::Kappa if t == 0 || f == 0 && self.choose.objective == Score::Kappa => None,
            Score::F1 => Some(self.covered(moments, union, items, [2 * q - p, p], p * s)),
            Score::Kappa => {
                let weights = [(f * q + t * p).max(0), (t * q + f * p).max(0)];
                Some(self.covered(moments, union, items, weights, p * s * s))
            }
            Score::HumanSeen => {
                let fresh = |item: Option<usize>| {
                    self.of_parts(moments, union, item).into_iter().map(|(h, _)| h).sum::<i128>()
                };
                let people =
                    i128::from(moments.iter().flat_map(|m| &m.parts).map(|part| part.voxels).sum::<u64>());
                let gains = items.iter().map(|&item| q * fresh(Some(item))).collect();
                (people > 0).then(|| (q * fresh(None) - p * people, gains))
            }
            score => self.detected(moments, union, items, left, score == Score::PeopleDetected),
        }
    }

    /// Of voxels that are called rightly.
    fn covered(
        &self,
        moments: &[MomentBits],
        union: &SetPlanes,
        items: &[usize],
        weights: [i128; 2],
        claimed: i128,
    ) -> (i128, Vec<i128>) {
        let count = |item: Option<usize>| {
            let mut sum = 0;
            for moment in moments {
                for (plane, weight) in [HIT, CLEAR].into_iter().zip(weights) {
                    let words = moment.words[plane / 2].clone();
                    let has = &union[plane][words.clone()];
                    let wrong = if plane == CLEAR {
                        union[FALSE][words.clone()].to_vec()
                    } else {
                        vec![0; has.len()]
                    };
                    let right = has.iter().zip(&wrong);
                    let count = match item {
                        None => ones(right.map(|(has, wrong)| has & !wrong)),
                        Some(item) => match self.evidence.plane(item, plane) {
                            [] => 0,
                            row => ones(
                                row[words].iter().zip(right).map(|(row, (has, wrong))| row & !has & !wrong),
                            ),
                        },
                    };
                    sum += weight * i128::from(count);
                }
            }
            sum
        };
        (count(None) - claimed, items.iter().map(|&item| count(Some(item))).collect())
    }

    /// For each part of somebody's body what is hit and felt of it by a union, or what a candidate adds.
    fn of_parts(&self, moments: &[MomentBits], union: &SetPlanes, item: Option<usize>) -> Vec<(i128, i128)> {
        let count = |plane: usize, words: &std::ops::Range<usize>| {
            let has = &union[plane][words.clone()];
            i128::from(match item.map(|item| self.evidence.plane(item, plane)) {
                None => ones(has.iter().copied()),
                Some([]) => 0,
                Some(row) => ones(row[words.clone()].iter().zip(has).map(|(row, has)| row & !has)),
            })
        };
        let parts = moments.iter().flat_map(|moment| &moment.parts);
        parts.map(|part| (count(SEEN, &part.words), count(FELT, &part.words))).collect()
    }

    /// Of parts or people that may be detected: those for which the best hits together are enough. All candidates that
    /// are left may lead there, or none.
    fn detected(
        &self,
        moments: &[MomentBits],
        union: &SetPlanes,
        items: &[usize],
        left: usize,
        people: bool,
    ) -> Option<(i128, Vec<i128>)> {
        let least = i128::from(self.evidence.layout.min_hits());
        let has = self.of_parts(moments, union, None);
        let more: Vec<Vec<(i128, i128)>> =
            items.iter().map(|&item| self.of_parts(moments, union, Some(item))).collect();
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
        let (p, q) = self.claimed;
        let value = q * possible.len() as i128 - p * counting.len() as i128;
        (!counting.is_empty()).then(|| (value, vec![0; items.len()]))
    }
}
