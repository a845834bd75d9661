//! What sets must pass: the requirements of a study, all of them or some, at the highest of its speeds or a lower one.

use perirobot_march::metrics::Score;
use perirobot_study::input::{
    ApproachScore, Condition, Counted, Limit, RegionSpec, Requirement, Stopping, Study,
};

use crate::approach::NearestApproach;
use crate::judge::{Conditions, approach_value, requirements_at_speeds};

/// What a set is to pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PurchaseAim {
    /// All requirements.
    All,
    /// All requirements, if sensors might disturb each other.
    Disturbed,
    /// All requirements, so that the robot may run at the speed of this number.
    Speed(usize),
    /// All requirements but the one of this number.
    Without(usize),
    /// At least so many requirements, whichever they are.
    Number(usize),
}

/// Requirements that a set must meet, and the speeds of the robot at which it must.
#[derive(Clone, Debug)]
pub(super) struct Terms {
    /// The requirements.
    pub(super) requirements: Vec<Requirement>,
    /// The speeds up to the one at which the robot may run.
    pub(super) stopping: Option<Stopping>,
}

impl Terms {
    /// All that a study requires.
    pub(super) fn from_study(study: &Study) -> Terms {
        Terms { requirements: study.requirements.clone(), stopping: study.stopping.clone() }
    }

    /// What it requires so that the robot may run at one of its speeds, by its number: what belongs to a speed is
    /// required at this one and at all slower ones.
    pub(super) fn at_speed(study: &Study, speed: usize) -> Terms {
        let is_of_speed = |requirement: &Requirement| {
            let region = requirement.region().map(|region| &study.regions[region].1);
            matches!(region, Some(RegionSpec::Separation { .. }))
        };
        let own = study.requirements.iter().filter(|one| !is_of_speed(one)).cloned();
        let at_speeds = requirements_at_speeds(study).into_iter();
        // The fastest first: what fails is told of it.
        let at_speeds = at_speeds.filter(|(at, _)| *at <= speed).map(|(_, requirement)| requirement).rev();
        let stopping = study.stopping.as_ref().map(|stopping| stopping.up_to(speed));
        Terms { requirements: own.chain(at_speeds).collect(), stopping }
    }

    /// The same with some of the requirements only, by their places.
    pub(super) fn only(&self, places: &[usize]) -> Terms {
        let own = self.requirements.iter().enumerate().filter(|(place, _)| places.contains(place));
        Terms { requirements: own.map(|(_, one)| one.clone()).collect(), stopping: self.stopping.clone() }
    }

    /// The places of all requirements but one.
    pub(super) fn others(&self, left_out: usize) -> Vec<usize> {
        (0..self.requirements.len()).filter(|&place| place != left_out).collect()
    }

    /// A score of bodies of which the nearest comes so near, squared in voxels.
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

    /// The requirements with the conditions that have no bound, and are judged; without requirements that have none.
    pub(super) fn remaining(&self) -> Vec<Requirement> {
        let remaining = |one: &Requirement| {
            let under = one.under.iter().copied().filter(|&condition| !is_counted(one, condition)).collect();
            Requirement { under, ..one.clone() }
        };
        self.requirements.iter().map(remaining).filter(|one| !one.under.is_empty()).collect()
    }
}

/// Whether what is cast of each candidate decides a requirement under a condition. Unions of it do not tell what two
/// candidates see.
pub(super) fn is_counted(requirement: &Requirement, condition: Condition) -> bool {
    dead_in(condition).is_some() && !requirement.is_of_controller() && !is_of_overlap(requirement)
}

/// Whether it requires how much at least two sensors see.
pub(super) fn is_of_overlap(requirement: &Requirement) -> bool {
    requirement.counted_score().is_some_and(|counted| counted.score == Score::SeenTwice)
}

/// How many sensors are dead under a condition, if that is all that is different.
pub(super) fn dead_in(condition: Condition) -> Option<usize> {
    match condition {
        Condition::AsPlanned => Some(0),
        Condition::OneSensorDead => Some(1),
        Condition::TwoSensorsDead => Some(2),
        Condition::MountingError | Condition::Postures => None,
    }
}

/// A score of counts that bounds a search, with what it must be: its limit is on the side that less is worse.
pub(super) fn bounding(requirement: &Requirement) -> Option<(&Counted, Limit)> {
    let counted = requirement.counted_score().filter(|_| !is_of_overlap(requirement))?;
    let is_upper = matches!(requirement.limit, Limit::AtMost(_));
    (is_upper == counted.score.less_is_better()).then_some((counted, requirement.limit))
}
