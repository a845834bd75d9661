//! Checks a proof by other code than the search. They share only the evidence of each candidate, and the loops that
//! count bits, here without vector instructions. A backend of the caller's choice counts the sets again (`counted`);
//! the study decides whether they are allowed (`allowed`); a plain search looks for better ones (`plain`, `mean`);
//! bounds are added up again (`check_cuts` of `perirobot-cover`); no size or step of cost may be missing (`whole`); the
//! other values must follow from the scores (`beside`). Refining is repeated (`refined`), and the sets are swept again
//! for the tables (`tables`).

mod allowed;
mod beside;
mod counted;
mod disturbed;
mod if_disturbed;
mod mean;
mod plain;
mod refined;
mod tables;
mod whole;

use std::path::{Path, PathBuf};

pub(crate) use self::allowed::{AllowedSets, find_named, pose_name, thousandths};
pub(super) use self::counted::recount;
use self::counted::{exact, value, value_reaches};
pub(crate) use self::disturbed::DisturbedPairs;
use self::plain::{Plain, Threshold};
use self::refined::{refine_again, verify_refined};
use self::tables::verify_tables;
pub(crate) use self::tables::{SweptSets, is_written, sweep_again};
use super::files::{ChooseQuestion, Chosen, PROOF, fingerprint};
use super::problem::candidates_of;
use super::report::{SetReport, StepReport};
use perirobot_cover::layout::{FALSE, MISSED};
use perirobot_cover::{CandidateEvidence, CutLimits, check_cuts};
use perirobot_march::backend::factory::BackendFactory;
use perirobot_march::backend::oracle::Oracle;
use perirobot_march::backend::{Backend, Fusion};
use perirobot_march::error::Issue;
use perirobot_march::metrics::{Across, Confusion, Score};
use perirobot_march::progress::Progress;
use perirobot_march::voxel::Ones;
use perirobot_march::{Error, Result};
use perirobot_study::input::{Choose, Study};
use perirobot_study::sensor::Cost;
use perirobot_study::world::World;

/// Counts of checked claims.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Verified {
    /// Sets counted again.
    pub sets: usize,
    /// Steps whose best set was proven again.
    pub proven: usize,
    /// Steps whose upper bound was added up again.
    pub bounded: usize,
    /// Steps without such a claim.
    pub open: usize,
    /// Whether the search was stopped, so that sizes and steps of cost may be missing.
    pub stopped: bool,
    /// Whether refining was stopped, so that it was not repeated.
    pub refining_stopped: bool,
}

/// The inputs of a proof.
#[derive(Clone, Copy)]
struct ProofInput<'a> {
    study: &'a Study,
    choose: &'a Choose,
    worlds: &'a [World],
    disturbed: &'a DisturbedPairs,
    evidence: &'a CandidateEvidence,
    /// Counts bits without the vector instructions of the search.
    ones: Ones,
    progress: &'a dyn Progress,
}

/// A proof of a study's sets, to verify.
pub struct Claims {
    folder: PathBuf,
    chosen: Chosen,
    /// The poses of the study that disturb each other.
    disturbed: DisturbedPairs,
    /// Sensor and candidate indices of the best set of each step, and then of the nearly best ones.
    sets: Vec<Vec<[usize; 2]>>,
}

impl Claims {
    /// Reads the proof in a folder, and checks that its sets are allowed.
    ///
    /// # Errors
    /// `Error::Input` that names what is wrong.
    pub fn read(folder: &Path, study: &Study, choose: &Choose, worlds: &[World]) -> Result<Claims> {
        let path = folder.join(PROOF);
        let wrong = |place: &str, what: &str| Err(Error::input(place, what).with_place(&path));
        let Some(chosen) = Chosen::read(folder)? else {
            return Err(Issue::says("is missing")
                .with_advice("name a folder of choose")
                .with_place(&path)
                .into());
        };
        if chosen.fingerprint != fingerprint(study, worlds) {
            return wrong("fingerprint", "the study has changed since the search: choose again");
        }
        if chosen.asked != ChooseQuestion::new(study, choose) {
            return wrong("asked", "the study's question has changed: choose again");
        }
        let report = &chosen.report;
        let steps = report.steps.iter().enumerate();
        let steps =
            steps.map(|(i, step)| (format!("steps[{i}].best"), (step.at_most, step.budget, &step.best)));
        let ties = report.ties.iter().enumerate();
        let ties =
            ties.map(|(i, tie)| (format!("nearly_as_good[{i}]"), (choose.at_most, choose.budget, tie)));
        let disturbed = DisturbedPairs::from_items(&candidates_of(study), (study, worlds), choose.disturb);
        let allowed = AllowedSets::from_choose(study, (choose, &disturbed), worlds);
        let read = |(place, limits): (String, (usize, Option<Cost>, &SetReport))| {
            let set = find_named(study, &limits.2.poses).and_then(|set| {
                match allowed.not_allowed((limits.0, limits.1), limits.2.cost, &set) {
                    Some(why) => Err(Issue::says(why)),
                    None => Ok(set),
                }
            });
            set.map_err(|issue| issue.with_place(place).with_place(&path).into())
        };
        let sets = steps.chain(ties).map(read).collect::<Result<_>>()?;
        Ok(Claims { folder: folder.into(), chosen, disturbed, sets })
    }

    /// The number of steps; [`verify`] reports progress per step.
    pub fn steps(&self) -> usize {
        self.chosen.report.steps.len()
    }
}

/// Checks all files in a folder of chosen sets: the proof, refined poses, which are searched again with at most this
/// much evidence in memory, and every table.
///
/// # Errors
/// `Error::Input` that names the wrong claim; `Error::Stopped`.
pub(super) fn verify(
    claims: &Claims,
    asked: (&Study, &Choose, &[World]),
    evidence: &CandidateEvidence,
    (backends, memory_bytes): (&mut dyn BackendFactory, u64),
    progress: &dyn Progress,
) -> Result<Verified> {
    let mut oracle = Oracle::default();
    let mut verified = verify_steps(claims, asked, evidence, &mut oracle, progress)?;
    verified.sets += verify_refined(&claims.folder, asked, &mut oracle, progress)?;
    if asked.1.refine && !verified.stopped && !verified.refining_stopped {
        refine_again(claims, asked, evidence, (backends, memory_bytes), progress)?;
    }
    verify_tables(&claims.folder, asked, &mut oracle, progress)?;
    Ok(verified)
}

/// Checks the steps of a proof.
fn verify_steps(
    claims: &Claims,
    (study, choose, worlds): (&Study, &Choose, &[World]),
    evidence: &CandidateEvidence,
    recounter: &mut dyn Backend,
    progress: &dyn Progress,
) -> Result<Verified> {
    let Claims { folder, chosen, disturbed, sets } = claims;
    let (path, steps) = (folder.join(PROOF), &chosen.report.steps);
    let given = ProofInput { study, choose, worlds, disturbed, evidence, ones: Ones::plain(), progress };
    let wrong = |place: String, what: &str| Err(Error::input(place, what).with_place(&path));
    let counts = recount(study, choose, worlds, sets, recounter, progress)?;
    let mut verified = Verified {
        sets: sets.len(),
        proven: 0,
        bounded: 0,
        open: 0,
        stopped: chosen.report.stopped,
        refining_stopped: choose.refine && chosen.report.refining_stopped,
    };
    let is_provable = given.is_provable();
    let mut fractions = Vec::new();
    for (number, (step, counts)) in steps.iter().zip(&counts).enumerate() {
        let place = format!("steps[{number}]");
        let exact = holds(choose, &step.best, counts, &format!("{place}.best"))
            .map_err(|issue| issue.with_place(&path))?;
        fractions.push(exact);
        let bar = match exact {
            Some(claimed) => Threshold::Above(claimed),
            None => Threshold::AboveMean(step.best.score),
        };
        if !step.proven {
            match (&step.shown_by[..], step.no_set_is_above) {
                ([], None) => verified.open += 1,
                ([_, ..], Some(above)) => match given.shows(step, above) {
                    Ok(()) => verified.bounded += 1,
                    Err(why) => {
                        return Err(why.with_place(format!("{place}.shown_by")).with_place(&path).into());
                    }
                },
                ([], Some(above)) => match given.is_above_all(step, above) {
                    true => verified.bounded += 1,
                    false => {
                        return wrong(format!("{place}.no_set_is_above"), "a set is above that, or may be");
                    }
                },
                _ => return wrong(format!("{place}.no_set_is_above"), "is not shown by cuts"),
            }
            progress.check_stop()?;
            progress.advance(1);
            continue;
        }
        if step.no_set_is_above != Some(step.best.score) {
            return wrong(
                format!("{place}.no_set_is_above"),
                "differs from the score of the best set, which is proven",
            );
        }
        // No score is above one.
        if exact.map_or(step.best.score >= 1.0, |(n, d)| n >= d) {
            verified.proven += 1;
            progress.advance(1);
            continue;
        }
        if !is_provable {
            let what = "sensors with errors may outvote each other, so there is no proof";
            return wrong(format!("{place}.proven"), what);
        }
        let budget = step.budget.map(Cost::thousandths);
        let plain = Plain { given, at_most: step.at_most, budget, bar };
        if choose.over == Across::Mean && !plain.bounds_means() {
            return wrong(format!("{place}.proven"), "this mean of scores has no proof");
        }
        if let Some(better) = plain.better() {
            let names: Vec<String> =
                better.iter().map(|&item| pose_name(study, evidence.items[item])).collect();
            return wrong(format!("{place}.best"), &format!("this set is better: {}", names.join(";")));
        }
        progress.check_stop()?;
        verified.proven += 1;
        progress.advance(1);
    }
    if !chosen.report.stopped {
        whole::Whole { report: &chosen.report, fractions: &fractions, given, is_provable }
            .check()
            .map_err(|why| why.with_place(&path))?;
        progress.check_stop()?;
    }
    if_disturbed::check(&chosen.report, given, recounter).map_err(|error| error.with_place(&path))?;
    beside::check(claims, given, &counts, recounter)?;
    Ok(verified)
}

impl ProofInput<'_> {
    /// Whether unions decide the scores of sets. Under log-odds sensors with errors may outvote others; detection does
    /// not depend on labels.
    fn is_provable(self) -> bool {
        let ProofInput { choose, evidence, .. } = self;
        let scores = choose.require.iter().map(|require| require.score).chain([choose.objective]);
        let has_labels = scores.into_iter().any(|score| matches!(score, Score::F1 | Score::Kappa));
        let is_right =
            |item: usize| [MISSED, FALSE].iter().all(|&plane| evidence.plane(item, plane).is_empty());
        choose.fusion == Fusion::OccupiedWins || !has_labels || (0..evidence.items.len()).all(is_right)
    }

    /// Whether a plain search finds no set of a step above a score, in millionths.
    fn is_above_all(self, step: &StepReport, above: f64) -> bool {
        let millionths = (above * 1e6).round();
        let budget = step.budget.map(Cost::thousandths);
        let bar = Threshold::Above((millionths as i128, 1_000_000));
        let is_told = millionths / 1e6 == above && above >= step.best.score;
        is_told
            && self.choose.over != Across::Mean
            && self.is_provable()
            && (Plain { given: self, at_most: step.at_most, budget, bar }).better().is_none()
    }

    /// Whether cuts prove the upper bound of a step.
    fn shows(self, step: &StepReport, above: f64) -> Result<(), Issue> {
        let ProofInput { study, choose, worlds, disturbed, evidence, .. } = self;
        let items = &evidence.items;
        let budget = step.budget.map(Cost::thousandths);
        let allowed = AllowedSets::from_choose(study, (choose, disturbed), worlds);
        let joins = |row: usize| {
            let set = [&choose.always[..], &[items[row]]].concat();
            let cost: u64 = set.iter().map(|&[sensor, _]| thousandths(study, sensor)).sum();
            budget.is_none_or(|budget| cost <= budget) && allowed.clash(&set).is_none()
        };
        let limits = CutLimits {
            evidence,
            objective: choose.objective,
            over: choose.over,
            at_most: step.at_most,
            budget,
            cost: items.iter().map(|&[sensor, _]| thousandths(study, sensor)).collect(),
            always: (0..items.len()).filter(|&row| choose.always.contains(&items[row])).collect(),
            joins: &joins,
            named: &|wanted: &str| items.iter().position(|&item| pose_name(study, item) == wanted),
        };
        check_cuts(&limits, &step.shown_by, above)
    }
}

/// Checks a set against its recount. Returns its score as a fraction, if it is one.
fn holds(
    choose: &Choose,
    set: &SetReport,
    counts: &[Confusion],
    place: &str,
) -> Result<Option<(i128, i128)>, Issue> {
    let value = value(choose.objective, choose.over, counts);
    if value != Some(set.score) {
        let value = value.map_or("none".into(), |value| value.to_string());
        let what = format!("{} is {}, but counted again it is {value}", choose.objective.name(), set.score);
        return Err(Issue::says(what).with_place(format!("{place}.score")));
    }
    if let Some(require) = choose
        .require
        .iter()
        .find(|require| !value_reaches(counted::value(require.score, require.over, counts), require.at_least))
    {
        let (name, least) = (require.score.name(), require.at_least);
        return Err(Issue::says(format!("does not reach {name} {least}")).with_place(place));
    }
    let exact = exact(choose.objective, choose.over, counts);
    let claimed = set.fraction();
    match exact {
        Some((n, d))
            if claimed.is_none_or(|(claimed_n, claimed_d)| {
                let [left, right] = [claimed_n.checked_mul(d), claimed_d.checked_mul(n)];
                claimed_d == 0 || left.is_none() || left != right
            }) =>
        {
            Err(Issue::says(format!("counted again it is {n}/{d}")).with_place(format!("{place}.exactly")))
        }
        None if set.exactly.is_some() => {
            Err(Issue::says("a mean of scores is not a fraction").with_place(format!("{place}.exactly")))
        }
        _ => Ok(exact),
    }
}
