//! Sets judged by `judge` itself, with some requirements only.

use super::ProofInput;
use crate::cheapest::remaining::combination;
use crate::judge::judge_alone;
use crate::view::Choice;
use perirobot_march::Result;
use perirobot_march::backend::factory::ChosenBackends;
use perirobot_march::metrics::Confusion;
use perirobot_study::input::{Condition, Requirement, Stopping, Study};

/// What is said of a set.
pub(super) struct Verdict {
    /// What it misses, if it misses anything.
    pub(super) missed: Option<String>,
    /// For each region what it counts as planned, moment by moment.
    pub(super) counts: Vec<Vec<Confusion>>,
}

/// A study that requires only this.
pub(super) fn restricted_study(
    study: &Study,
    requirements: Vec<Requirement>,
    stopping: Option<Stopping>,
) -> Study {
    let is_under = |condition| requirements.iter().any(|one| one.under.contains(&condition));
    let [is_off, others_stand] = [Condition::MountingError, Condition::Postures].map(is_under);
    Study {
        mounting_error: study.mounting_error.filter(|_| is_off),
        postures: if others_stand { study.postures.clone() } else { Vec::new() },
        stopping,
        requirements,
        ..study.clone()
    }
}

/// Judges a set by the requirements of a study.
///
/// # Errors
/// When a backend fails; `Error::Stopped`.
pub(super) fn judge(
    input: ProofInput,
    restricted: &Study,
    set: &[usize],
    open: &dyn Fn() -> Result<ChosenBackends>,
) -> Result<Verdict> {
    let ProofInput { purchase, worlds, items, progress, .. } = input;
    let combination = combination(restricted, purchase, items, String::new(), set);
    let study = restricted.with_combinations(&purchase.representations, vec![combination]);
    let choice = Choice { combination: 0, choice: 0, representation: 0, repeat: 0 };
    let judged = judge_alone(&study, worlds, &choice, open, progress)?;
    let missed = judged.judgements.iter().find(|one| !one.is_met);
    let missed =
        missed.map(|one| format!("{:?} is missed under {}", one.requirement.name, one.condition.name()));
    let asked: usize = study.requirements.iter().map(|one| one.under.len()).sum();
    let is_judged = judged.judgements.len() == asked;
    let missed = missed.or_else(|| (!is_judged).then(|| "not all requirements were judged".into()));
    let planned = judged.conditions.cases(Condition::AsPlanned);
    Ok(Verdict { missed, counts: planned.first().map_or(Vec::new(), |case| case.counts.clone()) })
}
