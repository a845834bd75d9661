//! The question of a study, as in `cheapest.json`, which shows later changes of the study.

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

/// The question of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PurchaseQuestion {
    /// The most sensors of a set.
    pub at_most: usize,
    /// The budget.
    pub budget: Option<Cost>,
    /// The currency of all costs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub currency: Option<String>,
    /// Least distance between two sensors.
    pub apart_m: f64,
    /// When two sensors disturb each other; such pairs are excluded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disturb: Option<Disturb>,
    /// The sensors of every set.
    pub always: Vec<String>,
    /// The score to maximise among passing sets of the same cost.
    pub then: Option<AskedThen>,
    /// Further questions about the cheapest set.
    pub front: Option<PurchaseFront>,
    /// How the sensors' evidence is fused into one label.
    pub fusion: Fusion,
    /// The terms of each sensor, by its name.
    pub sensors: BTreeMap<String, AskedSensor>,
    /// The requirements of every set.
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
    /// The counts or approaches that it covers.
    pub over: Across,
    /// The region of its counts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<String>,
}

impl AskedThen {
    /// The score and its region, if it is a score of counts.
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
    /// The counts, approaches or moments that it covers.
    pub over: Across,
    /// The region of its counts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub region: Option<String>,
    /// Only this body.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub body: Option<String>,
    /// Only this entry.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub entry: Option<String>,
    /// Lower limit, if any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_least: Option<f64>,
    /// Upper limit, if any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at_most: Option<f64>,
    /// Its conditions.
    pub under: Vec<Condition>,
    /// The safety function that it represents.
    #[serde(rename = "for", default, skip_serializing_if = "Option::is_none")]
    pub safety_function: Option<String>,
}

impl PurchaseQuestion {
    /// The question of a study.
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

    /// Whether the study's requirements and costs are unchanged.
    pub(super) fn is_current(&self, study: &Study) -> bool {
        let cost_of = |sensor: &Sensor| self.sensors.get(&sensor.name).map(|asked| asked.cost);
        self.require.iter().eq(&AskedRequirement::from_study(study))
            && self.tables_sha256 == deciding_tables_sha256(study)
            && study.sensors.iter().all(|sensor| cost_of(sensor) == Some(sensor.terms.cost))
    }
}

impl AskedRequirement {
    /// All requirements of a study.
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
