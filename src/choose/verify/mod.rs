//! A proof checked by other code than the one that found it: nothing is shared with the search but what each
//! candidate says. The sets are counted again by a backend of the caller's choice (`counted`), whether they are
//! allowed is judged from the study (`allowed`), that none is better is searched again in a plain way (`plain`),
//! and what no set is above is added up again (`cuts`).

mod allowed;
mod counted;
pub(super) mod cuts;
mod plain;
mod refined;

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::Value;

use self::allowed::{clash, name, named, not_allowed, thousandths};
pub(super) use self::counted::recounted;
use self::counted::{exact, value, value_reaches};
use self::plain::Plain;
pub use self::refined::verify_refined;
use super::evidence::CandidateEvidence;
use super::files::{PROOF, asked, fingerprint};
use super::told::ToldCuts;
use crate::backend::Backend;
use crate::error::Issue;
use crate::metrics::Confusion;
use crate::results::files::read_regular;
use crate::sensor::Cost;
use crate::study::{Choose, Study};
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
    #[serde(default)]
    shown_by: Vec<ToldCuts>,
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
    /// Steps for which the score that no set is above was added up again.
    pub bounded: usize,
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
    let mut verified = Verified { sets: sets.len(), proven: 0, bounded: 0, open: 0 };
    for (number, (step, counts)) in steps.iter().zip(&counts).enumerate() {
        let place = format!("steps[{number}]");
        let exact =
            holds(choose, &step.best, counts, &format!("{place}.best")).map_err(|issue| issue.at(path))?;
        let Some(claimed) = exact.filter(|_| step.proven) else {
            if step.proven {
                return wrong(format!("{place}.proven"), "a mean of scores has no proof".into());
            }
            match (&step.shown_by[..], step.no_set_is_above) {
                ([], None) => verified.open += 1,
                ([_, ..], Some(above)) => match shows(study, choose, worlds, evidence, step, above) {
                    Ok(()) => verified.bounded += 1,
                    Err(why) => return Err(why.at(format!("{place}.shown_by")).at(path).into()),
                },
                _ => return wrong(format!("{place}.no_set_is_above"), "is not shown by cuts".into()),
            }
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

/// Checks the set at a place by what was counted again of it. Returns its score as a fraction, if it is one.
fn holds(
    choose: &Choose,
    set: &ClaimedSet,
    counts: &[Confusion],
    place: &str,
) -> Result<Option<(i128, i128)>, Issue> {
    let value = value(choose.objective, choose.over, counts);
    if value != Some(set.score) {
        let what = format!("{} is {}, and counted again it is {value:?}", choose.objective.name(), set.score);
        return Err(Issue::says(what).at(format!("{place}.score")));
    }
    if let Some(require) = choose
        .require
        .iter()
        .find(|require| !value_reaches(counted::value(require.score, require.over, counts), require.at_least))
    {
        let (name, least) = (require.score.name(), require.at_least);
        return Err(Issue::says(format!("does not reach {name} {least}")).at(place));
    }
    let exact = exact(choose.objective, choose.over, counts);
    let claimed = set.exactly.as_ref().map(|[n, d]| (n.parse::<i128>(), d.parse::<i128>()));
    let claimed = claimed.and_then(|(n, d)| Some((n.ok()?, d.ok()?)));
    match exact {
        Some((n, d))
            if claimed.is_none_or(|(claimed_n, claimed_d)| {
                let [left, right] = [claimed_n.checked_mul(d), claimed_d.checked_mul(n)];
                claimed_d == 0 || left.is_none() || left != right
            }) =>
        {
            Err(Issue::says(format!("counted again it is {n}/{d}")).at(format!("{place}.exactly")))
        }
        _ => Ok(exact),
    }
}

/// Whether cuts show what no set of a step is above.
fn shows(
    study: &Study,
    choose: &Choose,
    worlds: &[World],
    evidence: &CandidateEvidence,
    step: &ClaimedStep,
    above: f64,
) -> Result<(), Issue> {
    let items = &evidence.items;
    let budget = step.budget.and_then(Cost::new).map(Cost::thousandths);
    let joins = |row: usize| {
        let set = [&choose.always[..], &[items[row]]].concat();
        let cost: u64 = set.iter().map(|&[sensor, _]| thousandths(study, sensor)).sum();
        budget.is_none_or(|budget| cost <= budget) && clash(study, choose, worlds, &set).is_none()
    };
    let asked = cuts::CutLimits {
        evidence,
        objective: choose.objective,
        over: choose.over,
        at_most: step.at_most,
        budget,
        cost: items.iter().map(|&[sensor, _]| thousandths(study, sensor)).collect(),
        always: (0..items.len()).filter(|&row| choose.always.contains(&items[row])).collect(),
        joins: &joins,
        named: &|wanted: &str| items.iter().position(|&item| name(study, item) == wanted),
    };
    cuts::check(&asked, &step.shown_by, above)
}
