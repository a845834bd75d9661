//! `[choose]` of a study, checked: which set of sensors is the best, and which sets are allowed.

use std::collections::BTreeMap;

use serde::Deserialize;

mod purchase;

use super::disturb::{self, Disturb};
use super::require::ApproachScore;
use super::{RegionSpec, region};
use crate::diagnostics::{Place, Problems};
use crate::sensor::{Cost, Sensor};
use perirobot_march::backend::Fusion;
use perirobot_march::error::Issue;
use perirobot_march::metrics::{Across, Ratio, Score};
use perirobot_march::{Error, Result};
use perirobot_scene::spelling::nearest;
pub(super) use purchase::usual;
pub use purchase::{Purchase, PurchaseFront, ThenScore};

/// Most sensors of a set.
const MOST_SENSORS: u32 = 16;

/// What `perirobot choose` looks for: the best set of sensors.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct ChooseFile {
    /// What is looked for: the set with the highest score of so many sensors, or with "cost" the cheapest set that passes
    /// all `[[require]]`. Default "cost" if the study has `[[require]]` and costs.
    objective: Option<ObjectiveName>,
    /// With "cost": the score that decides among sets that pass and cost the same, as the set has it as planned.
    then: Option<ObjectiveName>,
    /// With "cost": of what else the cheapest set is looked for: of each speed of `[stopping]`, or of all requirements but
    /// one, and of each number of them.
    front: Option<PurchaseFront>,
    /// The name of the region in which the score is counted.
    region: Option<String>,
    /// Of which counts it is the score: of those of all scenes, snapshots and repeats together, or the worst or
    /// the mean of theirs. Default "pooled".
    over: Option<AcrossName>,
    /// How many sensors a set may have, at most 16. With "cost" the default is 16.
    at_most: Option<u32>,
    /// What a set may cost; all sensors then need a cost.
    budget: Option<f64>,
    /// How far two sensors of a set must be from each other, in metres. Default 0.
    #[serde(default)]
    apart_m: f64,
    /// Sensors that emit one kind of light may not disturb each other: when they do, as in
    /// `{ apart_deg = 30, overlap = 0.2 }`. Default: they may.
    disturb: Option<Disturb>,
    /// What hangs there already and is in every set: names of sensors and poses, as in "camera:wall/1/0".
    #[serde(default)]
    always: Vec<String>,
    /// Scores that every set must reach; with "cost" these are the study's `[[require]]`.
    #[serde(default)]
    require: Vec<RequireFile>,
    /// Of some sensors, what they are taken to say, as in camera = "points". Default: the first that each has.
    #[serde(default)]
    representation: BTreeMap<String, String>,
    /// Whether finer positions and angles are looked for around the poses of the best set of each size. Default false.
    #[serde(default)]
    refine: bool,
}

/// A score that every set must reach.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct RequireFile {
    /// The score.
    score: ObjectiveName,
    /// Of which counts, as of the objective. Default "pooled".
    #[serde(default)]
    over: AcrossName,
    /// What it must be at least.
    at_least: f64,
}

/// What a set can be chosen by.
#[derive(Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
enum ObjectiveName {
    F1,
    Kappa,
    HumanSeen,
    PeopleDetected,
    PartsDetected,
    /// The cheapest set that passes all requirements.
    Cost,
    /// Only of sets that pass and cost the same: less is better.
    Unknown,
    /// Only of sets that pass and cost the same.
    SeenTwice,
    /// Only of sets that pass and cost the same, the worst of all bodies and entries; without a region.
    NearestUnnoticedM,
    /// The same, beyond what people must keep.
    ApproachMarginM,
}

impl ObjectiveName {
    /// The score of counts, if it is one.
    fn score(self) -> Option<Score> {
        match self {
            ObjectiveName::F1 => Some(Score::F1),
            ObjectiveName::Kappa => Some(Score::Kappa),
            ObjectiveName::HumanSeen => Some(Score::HumanSeen),
            ObjectiveName::PeopleDetected => Some(Score::PeopleDetected),
            ObjectiveName::PartsDetected => Some(Score::PartsDetected),
            ObjectiveName::Unknown => Some(Score::Unknown),
            ObjectiveName::SeenTwice => Some(Score::SeenTwice),
            ObjectiveName::Cost | ObjectiveName::NearestUnnoticedM | ObjectiveName::ApproachMarginM => None,
        }
    }

    /// As in a study.
    fn name(self) -> &'static str {
        match (self.score(), self.nearness()) {
            (Some(score), _) => score.name(),
            (_, Some(score)) => score.name(),
            (None, None) => "cost",
        }
    }

    /// The score of bodies that come near, if it is one.
    fn nearness(self) -> Option<ApproachScore> {
        match self {
            ObjectiveName::NearestUnnoticedM => Some(ApproachScore::NearestUnnoticedM),
            ObjectiveName::ApproachMarginM => Some(ApproachScore::ApproachMarginM),
            _ => None,
        }
    }

    /// Whether a search for the best set maximises it.
    fn is_maximised(self) -> bool {
        let counted = self.score().filter(|score| !score.less_is_better());
        counted.is_some_and(|score| score != Score::SeenTwice)
    }
}

/// Of which counts a score is, where there are several scenes, snapshots and repeats.
#[derive(Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema, serde::Serialize))]
#[cfg_attr(test, schemars(rename = "Across"))]
#[serde(rename_all = "snake_case")]
pub(super) enum AcrossName {
    /// Of all of them added up.
    #[default]
    Pooled,
    /// The worst of theirs.
    Worst,
    /// The mean of theirs.
    Mean,
}

impl AcrossName {
    pub(super) fn to_across(self) -> Across {
        match self {
            AcrossName::Pooled => Across::Pooled,
            AcrossName::Worst => Across::Worst,
            AcrossName::Mean => Across::Mean,
        }
    }
}

/// Which set of sensors is looked for. Numbers are those of the study.
#[derive(Clone, Debug)]
pub struct Choose {
    /// The score that is to be as high as it can be.
    pub objective: Score,
    /// Of which counts.
    pub over: Across,
    /// Index of the region in which is counted.
    pub region: usize,
    /// How many sensors a set may have.
    pub at_most: usize,
    /// What a set may cost.
    pub budget: Option<Cost>,
    /// How far two sensors must be from each other.
    pub apart_m: f64,
    /// When sensors disturb each other that may not.
    pub disturb: Option<Disturb>,
    /// Sensor and candidate of what is in every set.
    pub always: Vec<[usize; 2]>,
    /// What every set must reach.
    pub require: Vec<SetRequirement>,
    /// The representation in which each sensor is scored.
    pub representations: Vec<usize>,
    /// Whether finer positions and angles are looked for around the best set of each size.
    pub refine: bool,
    /// How the evidence of a set becomes one label a voxel: as the study says.
    pub fusion: Fusion,
}

/// What `perirobot choose` looks for.
#[derive(Clone, Debug)]
pub enum Wanted {
    /// The best sets by a score.
    Best(Choose),
    /// The cheapest set that passes.
    Cheapest(Purchase),
}

impl Wanted {
    /// The question for the best sets by a score, if that is what is looked for.
    pub fn best(&self) -> Option<&Choose> {
        match self {
            Wanted::Best(choose) => Some(choose),
            Wanted::Cheapest(_) => None,
        }
    }
}

/// A score that a set must reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SetRequirement {
    /// The score.
    pub score: Score,
    /// Of which counts.
    pub over: Across,
    /// What it must be at least.
    pub at_least: f64,
}

/// What the rest of the study says.
pub(super) struct ChooseNames<'a> {
    pub(super) fusion: Fusion,
    /// The unit of all costs.
    pub(super) currency: Option<&'a str>,
    pub(super) regions: &'a [(String, RegionSpec)],
    pub(super) sensors: &'a [Sensor],
    /// Whether anything is required.
    pub(super) has_requirements: bool,
    /// Whether it is said how far people must be at which speed of the robot.
    pub(super) has_stopping: bool,
}

pub(super) fn check(at: &Place, file: ChooseFile, known: &ChooseNames) -> Result<Wanted, Vec<Error>> {
    let (at, mut problems) = (at.key("choose"), Problems::default());
    let sensors = known.sensors;
    let objective = problems.keep(objective(&at, &file, known));
    let score = objective.and_then(ObjectiveName::score);
    let is_cheapest = objective.is_some() && score.is_none();
    let region = problems.keep(score_region(&at, &file, known, score));
    let then = problems.keep(purchase::then(&at, &file, region.flatten(), known));
    let at_most = problems.keep(at_most(&at, file.at_most, is_cheapest));
    problems.keep(at.number("apart_m", file.apart_m, 0.0..1e6, "a distance in metres, 0 or more"));
    let disturb = file.disturb.map(|disturb| disturb::check(&at, disturb, sensors)).transpose();
    let disturb = problems.keep_all(disturb);
    let require = file.require.iter().enumerate();
    let require = require.map(|(i, entry)| set_requirement(&at.key(&format!("require[{i}]")), entry));
    let require: Vec<SetRequirement> = require.filter_map(|one| problems.keep(one)).collect();
    let representations = problems.keep(representations(&at, &file.representation, sensors));
    let always = problems.keep(always(&at, &file, sensors));
    let budget = file.budget.map(|budget| Cost::check(&at, "budget", budget)).transpose();
    let budget = problems.keep(budget);
    if budget == Some(None) {
        problems.keep(all_or_none_priced(&at, sensors));
    }
    if let (Some(Some(budget)), Some(always)) = (budget, &always) {
        problems.keep(affordable(&at, (budget, known.currency), always, sensors));
    }
    problems.keep(match is_cheapest {
        true => purchase::check(&at, &file, known),
        false => purchase::refuse(&at, &file),
    });
    problems.none()?;
    let (Some(region), Some(at_most), Some(disturb), Some(representations), Some(always), Some(budget)) =
        (region, at_most, disturb, representations, always, budget)
    else {
        return Err(Vec::new());
    };
    let (apart_m, fusion, over) = (file.apart_m, known.fusion, file.over.unwrap_or_default().to_across());
    Ok(match (score, region) {
        (Some(objective), Some(region)) => Wanted::Best(Choose {
            objective,
            over,
            region,
            at_most,
            budget,
            apart_m,
            disturb,
            always,
            require,
            representations,
            refine: file.refine,
            fusion,
        }),
        _ => {
            let front = file.front;
            Wanted::Cheapest(Purchase {
                then: then.flatten(),
                front,
                at_most,
                budget,
                apart_m,
                disturb,
                always,
                representations,
                fusion,
            })
        }
    })
}

/// What is looked for.
fn objective(at: &Place, file: &ChooseFile, known: &ChooseNames) -> Result<ObjectiveName> {
    match file.objective {
        Some(name) if name != ObjectiveName::Cost && !name.is_maximised() => {
            let name = name.name();
            let why = match name {
                "unknown" => "is a score of which less is better, which",
                _ => "is not searched by itself: it",
            };
            let rule =
                format!("{why} decides only among sets that pass: objective = \"cost\", then = {name:?}");
            Err(at.wrong("objective", format!("{name:?}"), &rule))
        }
        Some(objective) => Ok(objective),
        None if known.asks_for_cheapest() => Ok(ObjectiveName::Cost),
        None => {
            let cure = "say what is looked for, as in objective = \"f1\", region = \"robot\", at_most = 3; \
                        or, with [[require]] and the cost of each sensor, objective = \"cost\"";
            let mut unpriced = known.sensors.iter().filter(|sensor| sensor.terms.cost.is_none());
            let cure = match unpriced.next().filter(|_| known.has_requirements) {
                Some(sensor) => format!("{cure}: {:?} has no cost", sensor.name),
                None => cure.into(),
            };
            Err(at.wrap(Issue::missing("objective")).with_advice(cure))
        }
    }
}

/// The region of the score, if there is one.
fn score_region(
    at: &Place,
    file: &ChooseFile,
    known: &ChooseNames,
    score: Option<Score>,
) -> Result<Option<usize>> {
    match (&file.region, score.or(file.then.and_then(ObjectiveName::score))) {
        (Some(name), Some(_)) => region::index(at, name, known.regions).map(Some),
        (Some(name), None) => {
            let rule = match file.then.and_then(ObjectiveName::nearness) {
                Some(score) => format!(
                    "is not of {}, which is of what bodies must not come near to: leave it out",
                    score.name()
                ),
                None => {
                    "is of a score: name one by then, as in then = \"f1\", or leave the region out, since \
                         [[require]] has its own"
                        .into()
                }
            };
            Err(at.wrong("region", format!("{name:?}"), &rule))
        }
        (None, Some(score)) => {
            let names: Vec<&str> = known.regions.iter().map(|(name, _)| name.as_str()).collect();
            let cure = format!("say in which region of the study {} is counted: {names:?}", score.name());
            Err(at.wrap(Issue::missing("region")).with_advice(cure))
        }
        (None, None) => Ok(None),
    }
}

/// How many sensors a set may have.
fn at_most(at: &Place, at_most: Option<u32>, is_cheapest: bool) -> Result<usize> {
    match at_most {
        Some(most) if (1..=MOST_SENSORS).contains(&most) => Ok(most as usize),
        Some(most) => Err(at.wrong("at_most", most, &format!("must be from 1 to {MOST_SENSORS}"))),
        None if is_cheapest => Ok(MOST_SENSORS as usize),
        None => Err(at
            .wrap(Issue::missing("at_most"))
            .with_advice("say how many sensors a set may have, as in at_most = 3")),
    }
}

/// A score that every set must reach.
fn set_requirement(at: &Place, entry: &RequireFile) -> Result<SetRequirement> {
    let score = entry.score.score().filter(|_| entry.score.is_maximised()).ok_or_else(|| {
        let rule = "must be f1, kappa, human_seen, people_detected or parts_detected: what else sets must pass is said \
                    by [[require]], with objective = \"cost\"";
        at.says(format!("score {rule}"))
    })?;
    let least = if score == Score::Kappa { -1.0 } else { 0.0 };
    let rule = format!("a number from {least} to 1");
    let at_least = at.number("at_least", entry.at_least, least..=1.0, &rule)?;
    if Ratio::from_f64(at_least).value() != at_least {
        return Err(at.wrong("at_least", at_least, "must have at most nine digits after the point"));
    }
    Ok(SetRequirement { score, over: entry.over.to_across(), at_least })
}

/// Which representation each sensor is taken in.
fn representations(at: &Place, named: &BTreeMap<String, String>, sensors: &[Sensor]) -> Result<Vec<usize>> {
    let at = at.key("representation");
    if let Some(stranger) = named.keys().find(|name| !sensors.iter().any(|sensor| sensor.name == **name)) {
        let near = nearest(stranger, names(sensors).into_iter());
        let near = near.map_or(String::new(), |near| format!(" (did you mean {near:?}?)"));
        let known = names(sensors);
        return Err(at.says(format!("{stranger:?} must be a sensor of the study: {known:?}{near}")));
    }
    let way = |sensor: &Sensor| match named.get(&sensor.name) {
        None => Ok(0),
        Some(name) => {
            let known = sensor.kind.representations();
            known.iter().position(|known| known == name).ok_or_else(|| {
                let rule = format!("must be a representation of that sensor: {known:?}");
                at.wrong(&sensor.name, format!("{name:?}"), &rule)
            })
        }
    };
    sensors.iter().map(way).collect()
}

fn names(sensors: &[Sensor]) -> Vec<&str> {
    sensors.iter().map(|sensor| sensor.name.as_str()).collect()
}

/// Sensor and candidate of what is in every set.
fn always(at: &Place, file: &ChooseFile, sensors: &[Sensor]) -> Result<Vec<[usize; 2]>> {
    let mut found: Vec<[usize; 2]> = Vec::new();
    for name in &file.always {
        let wrong = |rule: String| at.wrong("always", format!("{name:?}"), &rule);
        let (sensor, pose) = name.split_once(':').ok_or_else(|| {
            wrong("must be a sensor and one of its poses, as in \"camera:wall/1/0\"".into())
        })?;
        let index = sensors.iter().position(|known| known.name == sensor);
        let index = index
            .ok_or_else(|| wrong(format!("must begin with a sensor of the study: {:?}", names(sensors))))?;
        let candidates = &sensors[index].candidates;
        let candidate = candidates.iter().position(|known| known.name == pose).ok_or_else(|| {
            let like = candidates.first().map_or("", |candidate| &candidate.name);
            wrong(format!("{sensor:?} has no such pose; its poses are like {like:?}"))
        })?;
        if found.contains(&[index, candidate]) {
            return Err(wrong("stands twice: name each once".into()));
        }
        found.push([index, candidate]);
        let (of_it, most) =
            (found.iter().filter(|one| one[0] == index).count(), sensors[index].terms.at_most);
        if most.is_some_and(|most| of_it > most as usize) {
            let most = most.unwrap_or_default();
            return Err(wrong(format!("is one more of {sensor:?} than its at_most = {most} allows")));
        }
    }
    if let Some(most) = file.at_most.filter(|&most| found.len() > most as usize) {
        let rule = format!("is more than at_most = {most} allows");
        return Err(at.wrong("always", format!("{} sensors", found.len()), &rule));
    }
    Ok(found)
}

/// Whether all sensors have a cost, or none: one without a cost beside others would be taken for free.
fn all_or_none_priced(at: &Place, sensors: &[Sensor]) -> Result<()> {
    let without = |sensor: &&Sensor| sensor.terms.cost.is_none();
    match (sensors.iter().find(without), sensors.iter().find(|sensor| !without(sensor))) {
        (Some(free), Some(priced)) => Err(at
            .says(format!("sensor {:?} has a cost and {:?} has none", priced.name, free.name))
            .with_advice("give each sensor one (cost = 0 for what is there already), or none")),
        _ => Ok(()),
    }
}

/// Whether all sensors have a cost, and some set is within the budget.
fn affordable(
    at: &Place,
    (budget, currency): (Cost, Option<&str>),
    always: &[[usize; 2]],
    sensors: &[Sensor],
) -> Result<()> {
    let amount = |cost: Cost| cost.to_text(currency);
    if let Some(without) = sensors.iter().find(|sensor| sensor.terms.cost.is_none()) {
        let what = format!("sensor {:?} has no cost: give it one, as in cost = 450.0", without.name);
        return Err(at.wrong("budget", budget, &what));
    }
    let cost = |sensor: &Sensor| sensor.terms.cost.unwrap_or_default();
    let fixed = always.iter().fold(Cost::ZERO, |sum, &[sensor, _]| sum.plus(cost(&sensors[sensor])));
    if fixed > budget {
        return Err(at.wrong(
            "budget",
            budget,
            &format!("is below the {} that the sensors in always cost", amount(fixed)),
        ));
    }
    let cheapest = sensors.iter().map(cost).min().unwrap_or_default();
    if always.is_empty() && cheapest > budget {
        return Err(at.wrong(
            "budget",
            budget,
            &format!("is below the {} that the cheapest sensor costs", amount(cheapest)),
        ));
    }
    Ok(())
}
