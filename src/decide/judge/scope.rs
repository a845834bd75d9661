//! The conditions of a study for counts, for approaches, and for measurements of a controller.

use perirobot_study::input::{Condition, Measure, Requirement, Study};

/// The conditions besides the plan with counts: those of requirements, mounting error if the study has it, and postures
/// if the study has them.
pub(super) fn counted_conditions(study: &Study) -> Vec<Condition> {
    let is_asked = |condition: &Condition| match condition {
        Condition::AsPlanned => false,
        Condition::MountingError => study.mounting_error.is_some(),
        Condition::Postures => !study.postures.is_empty(),
        _ => study.requirements.iter().any(|requirement| requirement.under.contains(condition)),
    };
    Condition::ALL.into_iter().filter(is_asked).collect()
}

/// The conditions with approaches: those of requirements, and the plan if approaches are judged at each speed.
pub(super) fn approach_conditions(study: &Study) -> Vec<Condition> {
    conditions_of(study, Requirement::is_of_nearness, asks_how_near_at_speeds(study))
}

/// The conditions with measurements: those of requirements on the controller, and the plan if the study has a needed
/// distance of people.
pub(super) fn controller_conditions(study: &Study) -> Vec<Condition> {
    conditions_of(study, Requirement::is_of_controller, study.stopping.is_some())
}

/// Whether approaches are judged at each speed: if the study lists bodies that approach, or requires a distance.
pub(super) fn asks_how_near_at_speeds(study: &Study) -> bool {
    let is_near = |one: &Requirement| match &one.measure {
        Measure::Nearness(nearness) => !nearness.score.is_area(),
        Measure::Counted(_) | Measure::Controller(_) => false,
    };
    study.stopping.is_some() && (study.has_approach || study.requirements.iter().any(is_near))
}

/// The conditions of some requirements, and the plan if it is needed anyway.
fn conditions_of(study: &Study, is_meant: fn(&Requirement) -> bool, with_plan: bool) -> Vec<Condition> {
    let is_asked = |condition: &Condition| {
        let mut own = study.requirements.iter().filter(|one| is_meant(one));
        own.any(|requirement| requirement.under.contains(condition))
            || (*condition == Condition::AsPlanned && with_plan)
    };
    Condition::ALL.into_iter().filter(is_asked).collect()
}
