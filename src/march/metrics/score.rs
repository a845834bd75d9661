//! The scores by name, and which way each is better.

use serde::{Deserialize, Serialize};

use super::Confusion;

/// A score of a choice of sensors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Score {
    /// Agreement with the truth over the region: 2TP / (2TP + FP + FN + UF + UO).
    F1,
    /// Cohen's kappa: agreement with the truth beyond chance.
    Kappa,
    /// Share of people's voxels that are hit or felt.
    HumanSeen,
    /// Share of people's voxels that are called occupied.
    HumanClaimed,
    /// Share of people that are detected.
    PeopleDetected,
    /// Share of body parts that are detected.
    PartsDetected,
    /// Share of the region without a label; less is better.
    Unknown,
    /// Share of labelled free space that is called occupied; less is better.
    FalseAlarm,
    /// Share of the region that at least two sensors label, whatever they say.
    SeenTwice,
}

/// How many scores there are.
pub const SCORES: usize = 9;

impl Score {
    /// All of them, in the order of every table.
    pub const ALL: [Score; SCORES] = [
        Score::F1,
        Score::Kappa,
        Score::HumanSeen,
        Score::HumanClaimed,
        Score::PeopleDetected,
        Score::PartsDetected,
        Score::Unknown,
        Score::FalseAlarm,
        Score::SeenTwice,
    ];

    /// As in the columns of results.csv and scores.csv.
    pub fn name(self) -> &'static str {
        match self {
            Score::F1 => "f1",
            Score::Kappa => "kappa",
            Score::HumanSeen => "human_seen",
            Score::HumanClaimed => "human_claimed",
            Score::PeopleDetected => "people_detected",
            Score::PartsDetected => "parts_detected",
            Score::Unknown => "unknown",
            Score::FalseAlarm => "false_alarm",
            Score::SeenTwice => "seen_twice",
        }
    }

    /// As in headings.
    pub fn title(self) -> &'static str {
        match self {
            Score::F1 => "F1",
            _ => self.name(),
        }
    }

    /// The score of counts, if they have one.
    pub fn evaluate(self, counts: &Confusion) -> Option<f64> {
        match self {
            Score::F1 => counts.f1(),
            Score::Kappa => counts.kappa(),
            Score::HumanSeen => counts.human_seen(),
            Score::HumanClaimed => counts.human_claimed(),
            Score::PeopleDetected => counts.people_detected(),
            Score::PartsDetected => counts.parts_detected(),
            Score::Unknown => counts.unknown(),
            Score::FalseAlarm => counts.false_alarm(),
            Score::SeenTwice => counts.seen_twice(),
        }
    }

    /// Whether less of it is better.
    pub fn less_is_better(self) -> bool {
        matches!(self, Score::Unknown | Score::FalseAlarm)
    }

    /// How good a value is: more is always better.
    pub fn merit(self, value: f64) -> f64 {
        if self.less_is_better() { -value } else { value }
    }

    /// The worse of two values.
    pub fn worse(self, a: f64, b: f64) -> f64 {
        if self.less_is_better() { a.max(b) } else { a.min(b) }
    }
}
