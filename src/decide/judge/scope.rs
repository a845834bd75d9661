//! The conditions of a study for counts, for approaches, and for what a controller measures.

use perirobot_study::input::{Condition, Measure, Requirement, Study};

/// The conditions besides the plan under which is counted: those that requirements name, mounting error where the study
/// says how large that is, and postures where it says who stands where.
pub(super) fn counted_conditions(study: &Study) -> Vec<Condition> {
    let is_asked = |condition: &Condition| match condition {
        Condition::AsPlanned => false,
        Condition::MountingError => study.mounting_error.is_some(),
        Condition::Postures => !study.postures.is_empty(),
        _ => study.requirements.iter().any(|requirement| requirement.under.contains(condition)),
    };
    Condition::ALL.into_iter().filter(is_asked).collect()
}

/// The conditions under which a study asks how near bodies come: those of its requirements, and the plan where it is
/// asked at each speed.
pub(super) fn approach_conditions(study: &Study) -> Vec<Condition> {
    conditions_of(study, Requirement::is_of_nearness, asks_how_near_at_speeds(study))
}

/// The conditions under which is measured: those of requirements on the controller, and the plan where the study says
/// how far people must be.
pub(super) fn controller_conditions(study: &Study) -> Vec<Condition> {
    conditions_of(study, Requirement::is_of_controller, study.stopping.is_some())
}

/// Whether it is asked at each speed how near bodies come: where the study says which bodies come, or requires
/// something of how near.
pub(super) fn asks_how_near_at_speeds(study: &Study) -> bool {
    let is_near = |one: &Requirement| match &one.measure {
        Measure::Nearness(nearness) => !nearness.score.is_area(),
        Measure::Counted(_) | Measure::Controller(_) => false,
    };
    study.stopping.is_some() && (study.has_approach || study.requirements.iter().any(is_near))
}

/// The conditions of some requirements, and the plan where that is asked anyway.
fn conditions_of(study: &Study, is_meant: fn(&Requirement) -> bool, with_plan: bool) -> Vec<Condition> {
    let is_asked = |condition: &Condition| {
        let mut own = study.requirements.iter().filter(|one| is_meant(one));
        own.any(|requirement| requirement.under.contains(condition))
            || (*condition == Condition::AsPlanned && with_plan)
    };
    Condition::ALL.into_iter().filter(is_asked).collect()
}
