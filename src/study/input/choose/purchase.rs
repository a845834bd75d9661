//! The cheapest set that passes, as `[choose]` asks for it.

use serde::{Deserialize, Serialize};

use super::{AcrossName, ChooseFile, ChooseNames, MOST_SENSORS, Wanted};
use crate::diagnostics::Place;
use crate::input::disturb::Disturb;
use crate::input::stopping::EXAMPLE;
use crate::input::{ApproachScore, Counted};
use crate::sensor::Cost;
use perirobot_march::Result;
use perirobot_march::backend::Fusion;
use perirobot_march::metrics::Across;

/// Of what else than all requirements the cheapest set is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum PurchaseFront {
    /// Of the requirements at each speed of the robot.
    Speed,
    /// Of all requirements but one, for each, and of each number of them.
    Requirements,
}

/// A score that decides among sets that pass and cost the same, as planned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ThenScore {
    /// Of counts.
    Counted(Counted),
    /// Of bodies that come near: the worst of all of them, by all entries. A distance, of which more is better.
    Nearness(ApproachScore),
}

/// The cheapest set that passes all requirements of its study. Numbers are those of the study.
#[derive(Clone, Debug)]
pub struct Purchase {
    /// What decides among sets that pass and cost the same.
    pub then: Option<ThenScore>,
    /// Of what else the cheapest set is looked for.
    pub front: Option<PurchaseFront>,
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
    /// The representation in which each sensor is judged.
    pub representations: Vec<usize>,
    /// How the evidence of a set becomes one label a voxel: as the study says.
    pub fusion: Fusion,
}

/// What a study without `[choose]` asks for: the cheapest set that passes, if it requires something and all sensors have
/// costs.
pub(in crate::input) fn usual(known: &ChooseNames) -> Option<Wanted> {
    known.asks_for_cheapest().then(|| {
        Wanted::Cheapest(Purchase {
            then: None,
            front: None,
            at_most: MOST_SENSORS as usize,
            budget: None,
            apart_m: 0.0,
            disturb: None,
            always: Vec::new(),
            representations: vec![0; known.sensors.len()],
            fusion: known.fusion,
        })
    })
}

impl ChooseNames<'_> {
    /// Whether the cheapest set that passes is what a study asks for that does not say.
    pub(super) fn asks_for_cheapest(&self) -> bool {
        self.has_requirements && self.sensors.iter().all(|sensor| sensor.terms.cost.is_some())
    }
}

/// The score that decides among sets of the same cost, if one does; `region` is the one that is named.
pub(super) fn then(
    at: &Place,
    file: &ChooseFile,
    region: Option<usize>,
    known: &ChooseNames,
) -> Result<Option<ThenScore>> {
    let Some(name) = file.then else { return Ok(None) };
    let over = file.over.map(AcrossName::to_across);
    if let Some(score) = name.score() {
        let counted =
            |region| ThenScore::Counted(Counted { score, region, over: over.unwrap_or(Across::Pooled) });
        return Ok(region.map(counted));
    }
    let Some(score) = name.nearness() else {
        return Err(at.wrong("then", "\"cost\"", "must be a score that decides among sets of the same cost"));
    };
    if score == ApproachScore::ApproachMarginM && !known.has_stopping {
        let rule = format!("needs to know how far people must be: add a table to the study, as in {EXAMPLE}");
        return Err(at.wrong("then", format!("{:?}", score.name()), &rule));
    }
    match over {
        Some(over @ (Across::Mean | Across::Pooled)) => {
            let rule = format!("must be \"worst\" of {}: leave it out", score.name());
            Err(at.wrong("over", format!("{:?}", over.name()), &rule))
        }
        _ => Ok(Some(ThenScore::Nearness(score))),
    }
}

/// Whether nothing is said that belongs to the cheapest set.
pub(super) fn refuse(at: &Place, file: &ChooseFile) -> Result<()> {
    let keys = [("then", file.then.is_some()), ("front", file.front.is_some())];
    match keys.into_iter().find(|(_, is_said)| *is_said) {
        Some((key, _)) => Err(at.says(format!("{key} belongs to objective = \"cost\": leave it out"))),
        None => Ok(()),
    }
}

/// Whether the cheapest set that passes can be asked for.
pub(super) fn check(at: &Place, file: &ChooseFile, known: &ChooseNames) -> Result<()> {
    if !known.has_requirements {
        let rule = "looks for the cheapest set that passes the study's [[require]], and it has none: add one, as in \
                    [[require]] name = \"parts seen\", score = \"parts_detected\", region = \"robot\", at_least = 0.9";
        return Err(at.wrong("objective", "\"cost\"", rule));
    }
    if let Some(without) = known.sensors.iter().find(|sensor| sensor.terms.cost.is_none()) {
        let rule = format!("sensor {:?} has no cost: give it one, as in cost = 450.0", without.name);
        return Err(at.wrong("objective", "\"cost\"", &rule));
    }
    if !file.require.is_empty() {
        return Err(at.wrong(
            "require",
            "[…]",
            "is of a score: the cheapest set passes the study's [[require]]",
        ));
    }
    if file.refine {
        return Err(at.wrong("refine", true, "is of a score: the cheapest set is one of the listed poses"));
    }
    if file.front == Some(PurchaseFront::Speed) && !known.has_stopping {
        let rule = format!("needs the speeds of the robot: add a table to the study, as in {EXAMPLE}");
        return Err(at.wrong("front", "\"speed\"", &rule));
    }
    Ok(())
}
