//! `[[require]]` and `[mounting_error]` of a study, checked: what scores a choice of sensors must reach, and
//! also when something is not as planned.

mod scores;

use std::ops::RangeInclusive;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::approach::Approach;
use super::choose::Across;
use super::stopping::EXAMPLE;
use super::{Place, Problems, RegionSpec, only_one};
use crate::error::Issue;
use crate::metrics::{Ratio, Score};
use crate::sensor::Calibration;
use crate::{Error, Result};
pub use scores::{ApproachScore, ControllerScore};

/// How many draws of mounts there may be.
const DRAWS: RangeInclusive<u32> = 1..=10_000;

/// The farthest and largest that a limit on approaches may be, in metres and square metres.
const FARTHEST: f64 = 1e4;

/// What `perirobot judge` decides: a score that a choice of sensors must reach.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(super) struct RequirementFile {
    /// Its name in verdicts.
    name: String,
    /// The score: one of results.csv, of how near bodies come unnoticed, or of what a controller would measure.
    #[schemars(with = "AnyScore")]
    score: String,
    /// The name of the region in which it is counted; none for scores that results.csv does not have.
    region: Option<String>,
    /// Of bodies that come near: only this one of `[approach]`. Default all.
    body: Option<String>,
    /// Of bodies that come near: only by this entry of `[approach]`. Default all.
    entry: Option<String>,
    /// Of which counts: the worst or the mean of all scenes, snapshots and repeats, or their counts added up.
    /// Default "worst"; of "needless_stops" it is "mean", the share of moments.
    over: Option<Across>,
    /// What it must be at least.
    at_least: Option<f64>,
    /// What it may be at most, instead of at_least.
    at_most: Option<f64>,
    /// Under which conditions. Default ["as_planned"].
    #[serde(default = "as_planned")]
    under: Vec<Condition>,
}

/// A score that may be required, to the schema.
#[derive(JsonSchema)]
#[serde(untagged)]
#[schemars(inline)]
#[allow(dead_code)]
enum AnyScore {
    Counted(Score),
    Approach(ApproachScore),
    Controller(ControllerScore),
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
    pub(crate) fn name(self) -> &'static str {
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
    pub(crate) fn is_of_highest_speed(&self) -> bool {
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
}

impl Requirement {
    /// The score, if it is one of counts.
    pub fn counted(&self) -> Option<&Counted> {
        match &self.measure {
            Measure::Counted(counted) => Some(counted),
            Measure::Nearness(_) | Measure::Controller(_) => None,
        }
    }

    /// Whether it is about bodies that come near.
    pub(crate) fn is_of_nearness(&self) -> bool {
        matches!(self.measure, Measure::Nearness(_))
    }

    /// Whether it is about what a controller would measure.
    pub(crate) fn is_of_controller(&self) -> bool {
        matches!(self.measure, Measure::Controller(_))
    }

    /// The score's name.
    pub(crate) fn score_name(&self) -> &'static str {
        match &self.measure {
            Measure::Counted(counted) => counted.score.name(),
            Measure::Nearness(nearness) => nearness.score.name(),
            Measure::Controller(score) => score.name(),
        }
    }

    /// Of which counts, approaches or moments.
    pub(crate) fn over(&self) -> Across {
        match &self.measure {
            Measure::Counted(counted) => counted.over,
            Measure::Nearness(_) | Measure::Controller(ControllerScore::MissedM) => Across::Worst,
            Measure::Controller(ControllerScore::NeedlessStops) => Across::Mean,
        }
    }

    /// Index of the region in which is counted, if it is about one.
    pub fn region(&self) -> Option<usize> {
        self.counted().map(|counted| counted.region)
    }

    /// The same in another region, if it is about one.
    pub(crate) fn in_region(&self, region: usize) -> Requirement {
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

/// What requirements may name.
pub(super) struct Known<'a> {
    pub(super) regions: &'a [(String, RegionSpec)],
    pub(super) approach: &'a Approach,
    /// Whether the study has a mounting error.
    pub(super) has_draws: bool,
    /// Whether the study says who stands where.
    pub(super) has_postures: bool,
    /// Whether it says how far people must be.
    pub(super) has_stopping: bool,
}

/// The requirements that are right.
pub(super) fn check(
    at: &Place,
    entries: Vec<RequirementFile>,
    known: &Known,
) -> Result<Vec<Requirement>, Vec<Error>> {
    let mut problems = Problems::default();
    let all: Vec<Requirement> =
        entries.into_iter().filter_map(|entry| problems.keep(one(at, entry, known))).collect();
    problems.keep(at.unique("requirement", all.iter().map(|requirement| requirement.name.as_str())));
    problems.none().map(|()| all)
}

fn one(at: &Place, mut entry: RequirementFile, known: &Known) -> Result<Requirement> {
    let at = &at.key(&format!("require {:?}", entry.name));
    let score = entry.score.as_str();
    let counted = Score::ALL.into_iter().find(|one| one.name() == score);
    let approach = ApproachScore::ALL.into_iter().find(|one| one.name() == score);
    let controller = ControllerScore::ALL.into_iter().find(|one| one.name() == score);
    let (measure, limit) = match (counted, approach, controller) {
        (Some(score), ..) => {
            (Measure::Counted(counted_in(at, &entry, score, known)?), limit(at, &entry, score)?)
        }
        (_, Some(score), _) => {
            (Measure::Nearness(nearness(at, &entry, score, known)?), near_limit(at, &entry, score)?)
        }
        (.., Some(score)) => {
            (Measure::Controller(controlled(at, &entry, score)?), controller_limit(at, &entry, score)?)
        }
        (None, None, None) => {
            let names = Score::ALL.map(Score::name).into_iter();
            let names = names.chain(ApproachScore::ALL.map(ApproachScore::name));
            let names = names.chain(ControllerScore::ALL.map(ControllerScore::name));
            let rule = format!("must be one of {}", names.collect::<Vec<_>>().join(", "));
            return Err(at.wrong("score", format!("{score:?}"), &rule));
        }
    };
    let asks_distance = matches!(approach, Some(ApproachScore::ApproachMarginM)) || controller.is_some();
    if asks_distance && !known.has_stopping {
        let rule = format!("needs to know how far people must be: add a table to the study, as in {EXAMPLE}");
        return Err(at.wrong("score", format!("{score:?}"), &rule));
    }
    let under = std::mem::take(&mut entry.under);
    at.some("under", &under, "under = [\"as_planned\"]")?;
    if under.contains(&Condition::MountingError) && !known.has_draws {
        let example = "[mounting_error] draws = 20, position_m = 0.01, angle_deg = 0.5";
        let rule =
            format!("needs to know how far mounts may be off: add a table to the study, as in {example}");
        return Err(at.wrong("under", "\"mounting_error\"", &rule));
    }
    if under.contains(&Condition::Postures) {
        if let Measure::Nearness(nearness) = &measure {
            let rule = format!(
                "{} is of bodies that come in, beside whom only people of the scenes stand: leave it out, and put people into a scene",
                nearness.score.name()
            );
            return Err(at.wrong("under", "\"postures\"", &rule));
        }
        if !known.has_postures {
            let example = "[postures] people = [\"standing\"], spots = [[1.0, 0.5, 90]]";
            let rule = format!("needs to know who stands where: add a table to the study, as in {example}");
            return Err(at.wrong("under", "\"postures\"", &rule));
        }
    }
    let under = Condition::ALL.into_iter().filter(|condition| under.contains(condition)).collect();
    Ok(Requirement { name: entry.name, measure, limit, under })
}

fn counted_in(at: &Place, entry: &RequirementFile, score: Score, known: &Known) -> Result<Counted> {
    for (key, name) in [("body", &entry.body), ("entry", &entry.entry)] {
        if let Some(name) = name {
            let rule =
                format!("{} is counted in a region, whoever comes by which way: leave it out", score.name());
            return Err(at.wrong(key, format!("{name:?}"), &rule));
        }
    }
    let Some(region) = &entry.region else {
        let names: Vec<&str> = known.regions.iter().map(|(name, _)| name.as_str()).collect();
        return Err(at
            .around(Issue::missing("region"))
            .wanted(format!("say in which region of the study {} is counted: {names:?}", score.name())));
    };
    let region = super::region::index(at, region, known.regions)?;
    Ok(Counted { score, region, over: entry.over.unwrap_or(Across::Worst) })
}

fn nearness(at: &Place, entry: &RequirementFile, score: ApproachScore, known: &Known) -> Result<Nearness> {
    if let Some(region) = &entry.region {
        let rule = format!(
            "{} is of what bodies must not come near to, which [approach] says: leave it out",
            score.name()
        );
        return Err(at.wrong("region", format!("{region:?}"), &rule));
    }
    if let Some(over @ (Across::Mean | Across::Pooled)) = entry.over {
        let rule = "must be \"worst\": who is noticed at the entry never comes near, and never has no mean";
        return Err(at.wrong("over", format!("{:?}", over.name()), rule));
    }
    let bodies = &known.approach.bodies;
    let names: Vec<&str> = bodies.iter().map(|body| body.name.as_str()).collect();
    named(at, "body", &entry.body, &names, "a body")?;
    let entries: Vec<&str> = known.approach.entries.iter().map(|entry| entry.name.as_str()).collect();
    named(at, "entry", &entry.entry, &entries, "an entry")?;
    let is_asked = |name: &str| entry.body.as_deref().is_none_or(|asked| asked == name);
    let stands = bodies.iter().any(|body| body.on_floor && is_asked(&body.name));
    if score.is_area() && !stands {
        let rule = "is an area of floor, and no body that is asked stands on the floor";
        return Err(at.wrong("score", format!("{:?}", score.name()), rule));
    }
    Ok(Nearness { score, body: entry.body.clone(), entry: entry.entry.clone() })
}

/// Fails unless a name is among those of `[approach]`, or none is given.
fn named(at: &Place, key: &str, name: &Option<String>, known: &[&str], what: &str) -> Result<()> {
    match name {
        Some(name) if !known.contains(&name.as_str()) => {
            let rule = format!("must be {what} of [approach]: {known:?}");
            Err(at.wrong(key, format!("{name:?}"), &rule))
        }
        _ => Ok(()),
    }
}

fn limit(at: &Place, entry: &RequirementFile, score: Score) -> Result<Limit> {
    let (key, value) = given(at, entry)?;
    let least = if score == Score::Kappa { -1.0 } else { 0.0 };
    at.number(key, value, least..=1.0, &format!("a number from {least} to 1"))?;
    exact(at, key, value)
}

fn near_limit(at: &Place, entry: &RequirementFile, score: ApproachScore) -> Result<Limit> {
    let (key, value) = given(at, entry)?;
    let (wanted, unit) = match score.is_area() {
        true => ("at_most", "square metres"),
        false => ("at_least", "metres"),
    };
    given_as(at, wanted, key, value, score.name())?;
    at.number(key, value, 0.0..=FARTHEST, &format!("a number of {unit} from 0 to {FARTHEST}"))?;
    exact(at, key, value)
}

/// Checks what is asked of a controller besides the limit.
fn controlled(at: &Place, entry: &RequirementFile, score: ControllerScore) -> Result<ControllerScore> {
    for (key, name) in [("region", &entry.region), ("body", &entry.body), ("entry", &entry.entry)] {
        if let Some(name) = name {
            let rule = format!("{} is of all people in all of the grid: leave it out", score.name());
            return Err(at.wrong(key, format!("{name:?}"), &rule));
        }
    }
    let (over, why) = match score {
        ControllerScore::MissedM => (Across::Worst, "one person who is missed is one too many"),
        ControllerScore::NeedlessStops => (Across::Mean, "it is a share of moments"),
    };
    match entry.over {
        Some(other) if other != over => {
            let rule = format!("must be {:?}: {why}", over.name());
            Err(at.wrong("over", format!("{:?}", other.name()), &rule))
        }
        _ => Ok(score),
    }
}

fn controller_limit(at: &Place, entry: &RequirementFile, score: ControllerScore) -> Result<Limit> {
    let (key, value) = given(at, entry)?;
    given_as(at, "at_most", key, value, score.name())?;
    let (most, what) = match score {
        ControllerScore::MissedM => (FARTHEST, "a number of metres"),
        ControllerScore::NeedlessStops => (1.0, "a share of moments"),
    };
    at.number(key, value, 0.0..=most, &format!("{what} from 0 to {most}"))?;
    exact(at, key, value)
}

/// Fails unless a limit is given by the key that fits the score.
fn given_as(at: &Place, wanted: &str, key: &str, value: f64, score: &str) -> Result<()> {
    match key == wanted {
        true => Ok(()),
        false => Err(at.wrong(key, value, &format!("of {score} the limit is given as {wanted}"))),
    }
}

/// The limit that is given, by its key.
fn given(at: &Place, entry: &RequirementFile) -> Result<(&'static str, f64)> {
    let limits = vec![
        ("at_least", entry.at_least.map(|value| ("at_least", value))),
        ("at_most", entry.at_most.map(|value| ("at_most", value))),
    ];
    only_one(at, "limit", limits)
}

fn exact(at: &Place, key: &str, value: f64) -> Result<Limit> {
    let ratio = Ratio::of(value);
    if ratio.value() != value {
        return Err(at.wrong(key, value, "must have at most nine digits after the point"));
    }
    Ok(if key == "at_least" { Limit::AtLeast(ratio) } else { Limit::AtMost(ratio) })
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
