//! `[choose]` of a study, checked: which set of sensors is the best, and which sets are allowed.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::{RegionSpec, region};
use crate::diagnostics::{Place, Problems};
use crate::sensor::{Cost, Sensor};
use perirobot_march::backend::Fusion;
use perirobot_march::metrics::{Across, Ratio, Score};
use perirobot_march::{Error, Result};

/// Most sensors of a set.
const MOST_SENSORS: u32 = 16;

/// What `perirobot choose` looks for: the best set of sensors.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct ChooseFile {
    /// The score that is to be as high as it can be.
    objective: Objective,
    /// The name of the region in which it is counted.
    region: String,
    /// Of which counts it is the score: of those of all scenes, snapshots and repeats together, or the worst or
    /// the mean of theirs. Default "pooled".
    #[serde(default)]
    over: AcrossName,
    /// How many sensors a set may have, at most 16.
    at_most: u32,
    /// What a set may cost; all sensors then need a cost.
    budget: Option<f64>,
    /// How far two sensors of a set must be from each other, in metres. Default 0.
    #[serde(default)]
    apart_m: f64,
    /// What hangs there already and is in every set: names of sensors and poses, as in "camera:wall/1/0".
    #[serde(default)]
    always: Vec<String>,
    /// Scores that every set must reach.
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
    score: Objective,
    /// Of which counts, as of the objective. Default "pooled".
    #[serde(default)]
    over: AcrossName,
    /// What it must be at least.
    at_least: f64,
}

/// A score that a set can be chosen by.
#[derive(Clone, Copy, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
enum Objective {
    F1,
    Kappa,
    HumanSeen,
    PeopleDetected,
    PartsDetected,
}

impl Objective {
    fn score(self) -> Score {
        match self {
            Objective::F1 => Score::F1,
            Objective::Kappa => Score::Kappa,
            Objective::HumanSeen => Score::HumanSeen,
            Objective::PeopleDetected => Score::PeopleDetected,
            Objective::PartsDetected => Score::PartsDetected,
        }
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
    pub(super) regions: &'a [(String, RegionSpec)],
    pub(super) sensors: &'a [Sensor],
}

pub(super) fn check(at: &Place, file: ChooseFile, known: &ChooseNames) -> Result<Choose, Vec<Error>> {
    let (at, mut problems) = (at.key("choose"), Problems::default());
    let sensors = known.sensors;
    let region = problems.keep(region::index(&at, &file.region, known.regions));
    if !(1..=MOST_SENSORS).contains(&file.at_most) {
        let rule = format!("must be from 1 to {MOST_SENSORS}");
        problems.keep::<()>(Err(at.wrong("at_most", file.at_most, &rule)));
    }
    problems.keep(at.number("apart_m", file.apart_m, 0.0..1e6, "a distance in metres, 0 or more"));
    let require = file.require.iter().enumerate().map(|(i, entry)| {
        let at = at.key(&format!("require[{i}]"));
        let least = if matches!(entry.score, Objective::Kappa) { -1.0 } else { 0.0 };
        let rule = format!("a number from {least} to 1");
        let at_least = at.number("at_least", entry.at_least, least..=1.0, &rule)?;
        if Ratio::from_f64(at_least).value() != at_least {
            return Err(at.wrong("at_least", at_least, "must have at most nine digits after the point"));
        }
        Ok(SetRequirement { score: entry.score.score(), over: entry.over.to_across(), at_least })
    });
    let require: Vec<SetRequirement> = require.filter_map(|one| problems.keep(one)).collect();
    let representations = problems.keep(representations(&at, &file.representation, sensors));
    let always = problems.keep(always(&at, &file, sensors));
    let budget = file.budget.map(|budget| Cost::check(&at, "budget", budget)).transpose();
    let budget = problems.keep(budget);
    if budget == Some(None) {
        problems.keep(all_or_none_priced(&at, sensors));
    }
    if let (Some(Some(budget)), Some(always)) = (budget, &always) {
        problems.keep(affordable(&at, budget, always, sensors));
    }
    problems.none()?;
    let (Some(region), Some(representations), Some(always), Some(budget)) =
        (region, representations, always, budget)
    else {
        return Err(Vec::new());
    };
    Ok(Choose {
        objective: file.objective.score(),
        over: file.over.to_across(),
        region,
        at_most: file.at_most as usize,
        budget,
        apart_m: file.apart_m,
        always,
        require,
        representations,
        refine: file.refine,
        fusion: known.fusion,
    })
}

/// Which representation each sensor is taken in.
fn representations(at: &Place, named: &BTreeMap<String, String>, sensors: &[Sensor]) -> Result<Vec<usize>> {
    let at = at.key("representation");
    if let Some(stranger) = named.keys().find(|name| !sensors.iter().any(|sensor| sensor.name == **name)) {
        return Err(at.says(format!("{stranger:?} must be a sensor of the study: {:?}", names(sensors))));
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
    if found.len() > file.at_most as usize {
        let rule = format!("is more than at_most = {} allows", file.at_most);
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
fn affordable(at: &Place, budget: Cost, always: &[[usize; 2]], sensors: &[Sensor]) -> Result<()> {
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
            &format!("is below the {fixed} that the sensors in always cost"),
        ));
    }
    let cheapest = sensors.iter().map(cost).min().unwrap_or_default();
    if always.is_empty() && cheapest > budget {
        return Err(at.wrong(
            "budget",
            budget,
            &format!("is below the {cheapest} that the cheapest sensor costs"),
        ));
    }
    Ok(())
}
