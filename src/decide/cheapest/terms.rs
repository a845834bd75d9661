//! The terms of sets: all or some requirements of a study, at the highest of its speeds or a lower one.

use perirobot_march::metrics::Score;
use perirobot_study::input::{
    ApproachScore, Condition, Counted, Limit, RegionSpec, Requirement, Stopping, Study,
};

use crate::approach::NearestApproach;
use crate::judge::{Conditions, approach_value, requirements_at_speeds};

/// The terms of a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PurchaseAim {
    /// All requirements.
    All,
    /// All requirements, with sensors that may disturb each other.
    Disturbed,
    /// All requirements at the robot speed of this number.
    Speed(usize),
    /// All requirements except the one of this number.
    Without(usize),
    /// Any group of at least this many requirements.
    Number(usize),
}

/// The requirements of a set, and their robot speeds.
#[derive(Clone, Debug)]
pub(super) struct Terms {
    /// The requirements.
    pub(super) requirements: Vec<Requirement>,
    /// The speeds up to that of the robot.
    pub(super) stopping: Option<Stopping>,
}

impl Terms {
    /// All requirements of a study.
    pub(super) fn from_study(study: &Study) -> Terms {
        Terms { requirements: study.requirements.clone(), stopping: study.stopping.clone() }
    }

    /// The requirements at one of the robot's speeds, by its number: those of a speed apply to this one and to all
    /// slower ones.
    pub(super) fn at_speed(study: &Study, speed: usize) -> Terms {
        let is_of_speed = |requirement: &Requirement| {
            let region = requirement.region().map(|region| &study.regions[region].1);
            matches!(region, Some(RegionSpec::Separation { .. }))
        };
        let own = study.requirements.iter().filter(|one| !is_of_speed(one)).cloned();
        let at_speeds = requirements_at_speeds(study).into_iter();
        // Fastest first: a failure is reported for the fastest speed.
        let at_speeds = at_speeds.filter(|(at, _)| *at <= speed).map(|(_, requirement)| requirement).rev();
        let stopping = study.stopping.as_ref().map(|stopping| stopping.up_to(speed));
        Terms { requirements: own.chain(at_speeds).collect(), stopping }
    }

    /// The same with only some of the requirements, by their places.
    pub(super) fn only(&self, places: &[usize]) -> Terms {
        let own = self.requirements.iter().enumerate().filter(|(place, _)| places.contains(place));
        Terms { requirements: own.map(|(_, one)| one.clone()).collect(), stopping: self.stopping.clone() }
    }

    /// The places of all requirements except one.
    pub(super) fn all_but(&self, left_out: usize) -> Vec<usize> {
        (0..self.requirements.len()).filter(|&place| place != left_out).collect()
    }

    /// The score of a body with this closest distance, squared in voxels.
    pub(super) fn near_value(
        &self,
        study: &Study,
        score: ApproachScore,
        squared: Option<u32>,
    ) -> Option<f64> {
        let needed = self.stopping.as_ref().map(|stopping| *stopping.fastest());
        let scale = Conditions { voxel_size_m: study.voxel_size_m, needed, ..Conditions::default() };
        let near = NearestApproach { squared: Some(squared?), unnoticed: 0, joined: 0 };
        approach_value(score, &near, &scale).map(|value| value.number())
    }

    /// The requirements with the conditions that have no bound and must be judged; requirements without such conditions
    /// are removed.
    pub(super) fn remaining(&self) -> Vec<Requirement> {
        let remaining = |one: &Requirement| {
            let under = one.under.iter().copied().filter(|&condition| !is_counted(one, condition)).collect();
            Requirement { under, ..one.clone() }
        };
        self.requirements.iter().map(remaining).filter(|one| !one.under.is_empty()).collect()
    }
}

/// Whether the evidence of the single candidates decides a requirement under a condition. Their union does not contain
/// the overlap of two candidates.
pub(super) fn is_counted(requirement: &Requirement, condition: Condition) -> bool {
    dead_in(condition).is_some() && !requirement.is_of_controller() && !is_of_overlap(requirement)
}

/// Whether it limits the share seen by at least two sensors.
pub(super) fn is_of_overlap(requirement: &Requirement) -> bool {
    requirement.counted_score().is_some_and(|counted| counted.score == Score::SeenTwice)
}

/// The number of dead sensors of a condition, if that is its only alteration.
pub(super) fn dead_in(condition: Condition) -> Option<usize> {
    match condition {
        Condition::AsPlanned => Some(0),
        Condition::OneSensorDead => Some(1),
        Condition::TwoSensorsDead => Some(2),
        Condition::MountingError | Condition::Postures => None,
    }
}

/// A score of counts that bounds a search, with its limit: the limit is on the side where less is worse.
pub(super) fn bounding(requirement: &Requirement) -> Option<(&Counted, Limit)> {
    let counted = requirement.counted_score().filter(|_| !is_of_overlap(requirement))?;
    let is_upper = matches!(requirement.limit, Limit::AtMost(_));
    (is_upper == counted.score.less_is_better()).then_some((counted, requirement.limit))
}
