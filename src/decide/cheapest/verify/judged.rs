//! Sets judged by `judge` itself, with only some requirements.

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

/// The verdict on a set.
pub(super) struct Verdict {
    /// The missed requirements, by name.
    pub(super) missed_names: Vec<String>,
    /// The first of them in words.
    missed: String,
    /// The counts of each region as planned, moment by moment.
    pub(super) counts: Vec<Vec<Confusion>>,
    /// The closest distance of any body by any entry as planned, squared in voxels; `None` if unknown or if none fits.
    pub(super) nearest: Option<u32>,
}

impl Verdict {
    /// The first miss, if there are more than `most`.
    pub(super) fn misses_more_than(&self, most: usize) -> Option<&str> {
        (self.missed_names.len() > most).then_some(&self.missed)
    }
}

/// The study with only these requirements.
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

/// The same with a requirement on the closest distance that is always met.
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
/// If a backend fails; `Error::Stopped`.
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
    // Requirements at different robot speeds have the same names.
    let is_missed = |name: &String| {
        let cases = study.requirements.iter().filter(|one| one.name == *name).map(|one| one.under.len());
        let met = judged.judgements.iter().filter(|one| one.is_met && one.requirement.name == *name);
        met.count() < cases.sum()
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
