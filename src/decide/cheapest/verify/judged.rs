//! Sets judged by `judge` itself, with some requirements only.

use super::ProofInput;
use crate::cheapest::remaining::combination;
use crate::judge::judge_alone;
use crate::view::Choice;
use perirobot_march::Result;
use perirobot_march::backend::factory::ChosenBackends;
use perirobot_march::metrics::{Confusion, Ratio};
use perirobot_study::input::{
    ApproachScore, Condition, Limit, Measure, Nearness, Requirement, Stopping, Study,
};

/// What is said of a set.
pub(super) struct Verdict {
    /// The names of the requirements that it misses.
    pub(super) missed_names: Vec<String>,
    /// The first of them in words.
    missed: String,
    /// For each region what it counts as planned, moment by moment.
    pub(super) counts: Vec<Vec<Confusion>>,
    /// How near any body comes by any entry as planned, squared in voxels; none where that is not known, or none has room.
    pub(super) nearest: Option<u32>,
}

impl Verdict {
    /// What it misses first, if it misses more than so many requirements.
    pub(super) fn misses_more_than(&self, most: usize) -> Option<&str> {
        (self.missed_names.len() > most).then_some(&self.missed)
    }
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

/// The same, which also asks how near bodies come, whatever that is.
pub(super) fn asking_nearest(study: Study) -> Study {
    let nearness = Nearness { score: ApproachScore::NearestUnnoticedM, body: None, entry: None };
    let requirement = Requirement {
        name: "any distance".into(),
        measure: Measure::Nearness(nearness),
        limit: Limit::AtLeast(Ratio::from_f64(0.0)),
        under: vec![Condition::AsPlanned],
        safety_function: None,
    };
    let requirements = study.requirements.iter().cloned().chain([requirement]).collect();
    Study { requirements, ..study }
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
    // At each speed of the robot requirements have the same names.
    let is_missed = |name: &String| {
        let asked = study.requirements.iter().filter(|one| one.name == *name).map(|one| one.under.len());
        let met = judged.judgements.iter().filter(|one| one.is_met && one.requirement.name == *name);
        met.count() < asked.sum()
    };
    let mut missed_names: Vec<String> = study.requirements.iter().map(|one| one.name.clone()).collect();
    missed_names.dedup();
    missed_names.retain(is_missed);
    let missed = missed.unwrap_or_else(|| "not all requirements were judged".into());
    let planned = judged.conditions.cases(Condition::AsPlanned).first();
    let nearest = planned.and_then(|case| case.near.iter().filter_map(|near| near.squared).min());
    Ok(Verdict {
        missed,
        missed_names,
        counts: planned.map_or(Vec::new(), |case| case.counts.clone()),
        nearest,
    })
}
