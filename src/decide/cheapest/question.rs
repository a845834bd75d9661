//! The question of a study, as in `cheapest.json`: a later change of the study is noticed.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::choose::AskedSensor;
use crate::judge::deciding_tables_sha256;
use perirobot_march::backend::Fusion;
use perirobot_march::metrics::{Across, Score};
use perirobot_study::input::{
    Condition, Counted, Disturb, Limit, Measure, Purchase, PurchaseFront, Requirement, Study, ThenScore,
};
use perirobot_study::sensor::{Cost, Sensor};

/// What a study asks for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PurchaseQuestion {
    /// How many sensors a set may have.
    pub at_most: usize,
    /// What a set may cost.
    pub budget: Option<Cost>,
    /// The unit of all costs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub currency: Option<String>,
    /// How far two sensors must be from each other.
    pub apart_m: f64,
    /// When sensors disturb each other that may not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disturb: Option<Disturb>,
    /// What is in every set.
    pub always: Vec<String>,
    /// What is to be high among sets that pass and cost the same.
    pub then: Option<AskedThen>,
    /// Of what else the cheapest set is looked for.
    pub front: Option<PurchaseFront>,
    /// How what sensors say becomes one label.
    pub fusion: Fusion,
    /// By its name, what was said of each sensor.
    pub sensors: BTreeMap<String, AskedSensor>,
    /// What every set must pass.
    pub require: Vec<AskedRequirement>,
    /// The hash of the tables of the study that decide requirements besides the counts: `approach`, `stopping`,
    /// `mounting_error` and `postures`.
    pub tables_sha256: String,
}

/// The score that decides among sets of the same cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AskedThen {
    /// The score, by its name.
    pub score: String,
    /// Of which counts or approaches.
    pub over: Across,
    /// In which region is counted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<String>,
}

impl AskedThen {
    /// The score and its region, if it is one of counts.
    pub fn counted(&self) -> Option<(Score, &str)> {
        let score = Score::ALL.into_iter().find(|score| score.name() == self.score)?;
        Some((score, self.region.as_deref()?))
    }
}

/// A requirement of the study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AskedRequirement {
    /// Its name.
    pub name: String,
    /// The score, by its name.
    pub score: String,
    /// Of which counts, approaches or moments.
    pub over: Across,
    /// In which region is counted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<String>,
    /// Only of this body.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub body: Option<String>,
    /// Only by this entry.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub entry: Option<String>,
    /// The limit, if the score must be this or more.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_least: Option<f64>,
    /// The limit, if the score must be this or less.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_most: Option<f64>,
    /// Under which conditions.
    pub under: Vec<Condition>,
    /// The safety function that it stands for.
    #[serde(rename = "for", default, skip_serializing_if = "Option::is_none")]
    pub safety_function: Option<String>,
}

impl PurchaseQuestion {
    /// What a study asks for.
    pub(super) fn new(study: &Study, purchase: &Purchase) -> PurchaseQuestion {
        let pose = |&[sensor, candidate]: &[usize; 2]| {
            let sensor = &study.sensors[sensor];
            format!("{}:{}", sensor.name, sensor.candidates[candidate].name)
        };
        let sensor = |(sensor, &way): (&Sensor, &usize)| (sensor.name.clone(), AskedSensor::new(sensor, way));
        let then = |then: &ThenScore| match then {
            ThenScore::Counted(Counted { score, over, region }) => AskedThen {
                score: score.name().into(),
                over: *over,
                region: Some(study.regions[*region].0.clone()),
            },
            ThenScore::Nearness(score) => {
                AskedThen { score: score.name().into(), over: Across::Worst, region: None }
            }
        };
        PurchaseQuestion {
            at_most: purchase.at_most,
            budget: purchase.budget,
            currency: study.currency.clone(),
            apart_m: purchase.apart_m,
            disturb: purchase.disturb,
            always: purchase.always.iter().map(pose).collect(),
            then: purchase.then.as_ref().map(then),
            front: purchase.front,
            fusion: purchase.fusion,
            sensors: study.sensors.iter().zip(&purchase.representations).map(sensor).collect(),
            require: AskedRequirement::from_study(study),
            tables_sha256: deciding_tables_sha256(study),
        }
    }

    /// Whether a study requires the same now, and its sensors cost the same.
    pub(super) fn is_current(&self, study: &Study) -> bool {
        let cost_of = |sensor: &Sensor| self.sensors.get(&sensor.name).map(|asked| asked.cost);
        self.require.iter().eq(&AskedRequirement::from_study(study))
            && self.tables_sha256 == deciding_tables_sha256(study)
            && study.sensors.iter().all(|sensor| cost_of(sensor) == Some(sensor.terms.cost))
    }
}

impl AskedRequirement {
    /// All that a study requires.
    fn from_study(study: &Study) -> Vec<AskedRequirement> {
        study.requirements.iter().map(|one| AskedRequirement::new(study, one)).collect()
    }

    fn new(study: &Study, requirement: &Requirement) -> AskedRequirement {
        let (body, entry) = match &requirement.measure {
            Measure::Nearness(nearness) => (nearness.body.clone(), nearness.entry.clone()),
            Measure::Counted(_) | Measure::Controller(_) => (None, None),
        };
        let (at_least, at_most) = match requirement.limit {
            Limit::AtLeast(limit) => (Some(limit.value()), None),
            Limit::AtMost(limit) => (None, Some(limit.value())),
        };
        AskedRequirement {
            name: requirement.name.clone(),
            score: requirement.score_name().into(),
            over: requirement.scope(),
            region: requirement.region().map(|region| study.regions[region].0.clone()),
            body,
            entry,
            at_least,
            at_most,
            under: requirement.under.clone(),
            safety_function: requirement.safety_function.clone(),
        }
    }
}
