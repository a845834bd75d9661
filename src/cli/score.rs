//! `--score`: the scores by name, for commands that print or rank by one.

use clap::ValueEnum;
use perirobot_march::metrics::Score;

#[derive(Clone, Copy, PartialEq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub(super) enum ScoreArg {
    /// 2TP / (2TP + FP + FN + UF + UO)
    F1,
    /// Cohen's kappa over occupied, free, unknown
    Kappa,
    /// Share of people's voxels that are hit, or detected by a presence sensor
    HumanSeen,
    /// Share of people's voxels that are labelled occupied, correctly or by noise; printed with false_alarm
    HumanClaimed,
    /// Share of people with a detected body part, or detected by a presence sensor
    PeopleDetected,
    /// Share of people's body parts that are detected
    PartsDetected,
    /// Share of the region that stays unknown
    Unknown,
    /// Share of the labelled free voxels that are labelled occupied
    FalseAlarm,
    /// Share of the region that at least two sensors label, with any label
    SeenTwice,
}

impl ScoreArg {
    /// The score itself.
    pub(super) fn score(self) -> Score {
        self.scores()[0]
    }

    /// The tables to print: a claimed share is misleading without its false alarms.
    pub(super) fn scores(self) -> &'static [Score] {
        match self {
            ScoreArg::F1 => &[Score::F1],
            ScoreArg::Kappa => &[Score::Kappa],
            ScoreArg::HumanSeen => &[Score::HumanSeen],
            ScoreArg::HumanClaimed => &[Score::HumanClaimed, Score::FalseAlarm],
            ScoreArg::PeopleDetected => &[Score::PeopleDetected],
            ScoreArg::PartsDetected => &[Score::PartsDetected],
            ScoreArg::Unknown => &[Score::Unknown],
            ScoreArg::FalseAlarm => &[Score::FalseAlarm],
            ScoreArg::SeenTwice => &[Score::SeenTwice],
        }
    }
}
