//! What scores a choice of sensors must reach, and also when something is not as planned. `entry` is how a study
//! says it, in `[[require]]`.

mod entry;
mod mounting_error;
mod scores;

use serde::{Deserialize, Serialize};

pub(super) use entry::{RequirementFile, RequirementNames, check};
pub use mounting_error::MountingError;
pub(super) use mounting_error::MountingErrorFile;
use perirobot_march::metrics::{Across, Ratio, Score};
pub use scores::{ApproachScore, ControllerScore};

/// What may not be as planned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Condition {
    /// Nothing: every sensor works and is mounted where it should be.
    AsPlanned,
    /// Any one sensor says nothing.
    OneSensorDead,
    /// Any two sensors say nothing.
    TwoSensorsDead,
    /// Every sensor is mounted a little off, and known to be there.
    MountingError,
    /// In the place of the people of the scenes each person of `[postures]` stands at each spot.
    Postures,
}

impl Condition {
    /// All of them, in the order of the tables.
    pub const ALL: [Condition; 5] = [
        Condition::AsPlanned,
        Condition::OneSensorDead,
        Condition::TwoSensorsDead,
        Condition::MountingError,
        Condition::Postures,
    ];

    /// As in a study.
    pub fn name(self) -> &'static str {
        match self {
            Condition::AsPlanned => "as_planned",
            Condition::OneSensorDead => "one_sensor_dead",
            Condition::TwoSensorsDead => "two_sensors_dead",
            Condition::MountingError => "mounting_error",
            Condition::Postures => "postures",
        }
    }
}

/// A score of what is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counted {
    /// The score.
    pub score: Score,
    /// Index of the region in which is counted.
    pub region: usize,
    /// Of which counts.
    pub over: Across,
}

/// A score of bodies that come near, the worst of all that are asked.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Nearness {
    /// The score.
    pub score: ApproachScore,
    /// Only of this body.
    pub body: Option<String>,
    /// Only by this entry.
    pub entry: Option<String>,
}

/// What is required of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Measure {
    /// A score of counts.
    Counted(Counted),
    /// A score of bodies that come near.
    Nearness(Nearness),
    /// A score of what a controller would measure, over all scenes, snapshots and repeats.
    Controller(ControllerScore),
}

impl Measure {
    /// Whether it is about the robot at the highest of its speeds.
    pub fn is_of_highest_speed(&self) -> bool {
        match self {
            Measure::Counted(_) => false,
            Measure::Nearness(nearness) => nearness.score == ApproachScore::ApproachMarginM,
            Measure::Controller(score) => *score == ControllerScore::NeedlessStops,
        }
    }
}

/// A score that a choice of sensors must reach. Numbers are those of the study.
#[derive(Clone, Debug)]
pub struct Requirement {
    /// Unique in the study.
    pub name: String,
    /// The score.
    pub measure: Measure,
    /// What it must be.
    pub limit: Limit,
    /// Under which conditions, each once, in the order of [`Condition::ALL`].
    pub under: Vec<Condition>,
    /// The safety function that it stands for, in the words of a risk assessment. It decides nothing.
    pub safety_function: Option<String>,
}

impl Requirement {
    /// The score, if it is one of counts.
    pub fn counted_score(&self) -> Option<&Counted> {
        match &self.measure {
            Measure::Counted(counted) => Some(counted),
            Measure::Nearness(_) | Measure::Controller(_) => None,
        }
    }

    /// Whether it is about bodies that come near.
    pub fn is_of_nearness(&self) -> bool {
        matches!(self.measure, Measure::Nearness(_))
    }

    /// Whether it is about what a controller would measure.
    pub fn is_of_controller(&self) -> bool {
        matches!(self.measure, Measure::Controller(_))
    }

    /// The score's name.
    pub fn score_name(&self) -> &'static str {
        match &self.measure {
            Measure::Counted(counted) => counted.score.name(),
            Measure::Nearness(nearness) => nearness.score.name(),
            Measure::Controller(score) => score.name(),
        }
    }

    /// Of which counts, approaches or moments.
    pub fn scope(&self) -> Across {
        match &self.measure {
            Measure::Counted(counted) => counted.over,
            Measure::Nearness(_) | Measure::Controller(ControllerScore::MissedM) => Across::Worst,
            Measure::Controller(ControllerScore::NeedlessStops) => Across::Mean,
        }
    }

    /// Index of the region in which is counted, if it is about one.
    pub fn region(&self) -> Option<usize> {
        self.counted_score().map(|counted| counted.region)
    }

    /// The same in another region, if it is about one.
    pub fn with_region(&self, region: usize) -> Requirement {
        let measure = match &self.measure {
            Measure::Counted(counted) => Measure::Counted(Counted { region, ..*counted }),
            other => other.clone(),
        };
        Requirement { measure, ..self.clone() }
    }
}

/// What a score must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// This or more.
    AtLeast(Ratio),
    /// This or less.
    AtMost(Ratio),
}

impl Limit {
    /// The limit itself.
    pub fn ratio(&self) -> Ratio {
        match self {
            Limit::AtLeast(ratio) | Limit::AtMost(ratio) => *ratio,
        }
    }

    /// Whether the first of two is nearer to missing it.
    pub fn is_worse<T: Ord>(&self, first: &T, second: &T) -> bool {
        match self {
            Limit::AtLeast(_) => first < second,
            Limit::AtMost(_) => first > second,
        }
    }
}
