//! `[[require]]` and `[mounting_error]` of a study, checked: what scores a choice of sensors must reach, and
//! also when something is not as planned.

use std::ops::RangeInclusive;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::choose::Across;
use super::{Place, Problems, RegionSpec, only_one};
use crate::metrics::{Ratio, Score};
use crate::sensor::Calibration;
use crate::{Error, Result};

/// How many draws of mounts there may be.
const DRAWS: RangeInclusive<u32> = 1..=10_000;

/// What `perirobot judge` decides: a score that a choice of sensors must reach.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RequirementFile {
    /// Its name in verdicts.
    name: String,
    /// The score.
    score: Score,
    /// The name of the region in which it is counted.
    region: String,
    /// Of which counts: the worst or the mean of all scenes, snapshots and repeats, or their counts added up.
    /// Default "worst".
    #[serde(default = "worst")]
    over: Across,
    /// What it must be at least.
    at_least: Option<f64>,
    /// What it may be at most, instead of at_least.
    at_most: Option<f64>,
    /// Under which conditions. Default ["as_planned"].
    #[serde(default = "as_planned")]
    under: Vec<Condition>,
}

fn worst() -> Across {
    Across::Worst
}

fn as_planned() -> Vec<Condition> {
    vec![Condition::AsPlanned]
}

/// How far mounts may be from where they are planned, for requirements under "mounting_error".
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct MountingErrorFile {
    /// How many times the mounts of all sensors are drawn, at most 10000.
    draws: u32,
    /// Seed of the draws. Default 0.
    #[serde(default)]
    seed: u64,
    /// Standard deviation of the position along each of a sensor's own axes, in metres. Default 0.
    #[serde(default)]
    position_m: f64,
    /// Standard deviation of the rotation about each of them, in degrees. Default 0.
    #[serde(default)]
    angle_deg: f64,
}

/// What may not be as planned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
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
}

impl Condition {
    /// All of them, in the order of the tables.
    pub const ALL: [Condition; 4] =
        [Condition::AsPlanned, Condition::OneSensorDead, Condition::TwoSensorsDead, Condition::MountingError];

    /// As in a study.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Condition::AsPlanned => "as_planned",
            Condition::OneSensorDead => "one_sensor_dead",
            Condition::TwoSensorsDead => "two_sensors_dead",
            Condition::MountingError => "mounting_error",
        }
    }
}

/// A score that a choice of sensors must reach. Numbers are those of the study.
#[derive(Clone, Debug)]
pub struct Requirement {
    /// Unique in the study.
    pub name: String,
    /// The score.
    pub score: Score,
    /// Index of the region in which is counted.
    pub region: usize,
    /// Of which counts.
    pub over: Across,
    /// What it must be.
    pub limit: Limit,
    /// Under which conditions, each once, in the order of [`Condition::ALL`].
    pub under: Vec<Condition>,
}

/// What a score must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// This or more.
    AtLeast(Ratio),
    /// This or less.
    AtMost(Ratio),
}

/// How far mounts may be from where they are planned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MountingError {
    /// How many times they are drawn.
    pub draws: u32,
    /// Seed of the draws.
    pub seed: u64,
    /// Standard deviations.
    pub off: Calibration,
}

/// The requirements that are right. `has_draws` says whether the study has a mounting error.
pub(super) fn check(
    at: &Place,
    entries: Vec<RequirementFile>,
    regions: &[(String, RegionSpec)],
    has_draws: bool,
) -> Result<Vec<Requirement>, Vec<Error>> {
    let mut problems = Problems::default();
    let one = |entry| one(at, entry, regions, has_draws);
    let all: Vec<Requirement> = entries.into_iter().filter_map(|entry| problems.keep(one(entry))).collect();
    problems.keep(at.unique("requirement", all.iter().map(|requirement| requirement.name.as_str())));
    problems.none().map(|()| all)
}

fn one(
    at: &Place,
    entry: RequirementFile,
    regions: &[(String, RegionSpec)],
    has_draws: bool,
) -> Result<Requirement> {
    let RequirementFile { name, score, region, over, at_least, at_most, under } = entry;
    let at = at.key(&format!("require {name:?}"));
    let region = super::region::index(&at, &region, regions)?;
    let limit = only_one(
        &at,
        "limit",
        vec![
            ("at_least", at_least.map(|value| ("at_least", value))),
            ("at_most", at_most.map(|value| ("at_most", value))),
        ],
    );
    let (key, value) = limit?;
    let least = if score == Score::Kappa { -1.0 } else { 0.0 };
    at.number(key, value, least..=1.0, &format!("a number from {least} to 1"))?;
    let ratio = Ratio::of(value);
    if ratio.value() != value {
        return Err(at.wrong(key, value, "must have at most nine digits after the point"));
    }
    at.some("under", &under, "under = [\"as_planned\"]")?;
    if under.contains(&Condition::MountingError) && !has_draws {
        let example = "[mounting_error] draws = 20, position_m = 0.01, angle_deg = 0.5";
        let rule =
            format!("needs to know how far mounts may be off: add a table to the study, as in {example}");
        return Err(at.wrong("under", "\"mounting_error\"", &rule));
    }
    let limit = if key == "at_least" { Limit::AtLeast(ratio) } else { Limit::AtMost(ratio) };
    let under = Condition::ALL.into_iter().filter(|condition| under.contains(condition)).collect();
    Ok(Requirement { name, score, region, over, limit, under })
}

impl MountingErrorFile {
    pub(super) fn check(self, at: &Place) -> Result<MountingError> {
        let at = at.key("mounting_error");
        let MountingErrorFile { draws, seed, position_m, angle_deg } = self;
        if !DRAWS.contains(&draws) {
            let rule = format!("must be from {} to {}", DRAWS.start(), DRAWS.end());
            return Err(at.wrong("draws", draws, &rule));
        }
        at.number("position_m", position_m, 0.0..=1.0, "a standard deviation in metres, from 0 to 1")?;
        at.number("angle_deg", angle_deg, 0.0..=30.0, "a standard deviation in degrees, from 0 to 30")?;
        if position_m == 0.0 && angle_deg == 0.0 {
            let example = "as in position_m = 0.01 and angle_deg = 0.5";
            return Err(at.says(format!("give position_m, angle_deg or both, above 0, {example}")));
        }
        Ok(MountingError { draws, seed, off: Calibration { position_m, angle_rad: angle_deg.to_radians() } })
    }
}
