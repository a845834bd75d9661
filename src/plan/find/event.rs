//! What a search reports to the page.

use perirobot_march::progress::PurchaseState;
use perirobot_study::sensor::Cost;
use serde::Serialize;

/// What a search reports, a line each.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FindEvent {
    /// This many things of a stage are done.
    Stage {
        /// What they are.
        words: &'static str,
        /// How many are done.
        done: u64,
        /// Of how many.
        total: u64,
    },
    /// What is known of the search now, in words.
    Search(String),
    /// What no set is beyond.
    Bound {
        /// No set that passes costs less.
        cost: Option<f64>,
        /// No set of any cost scores more.
        score: Option<f64>,
    },
    /// A set.
    Point(FoundPoint),
    /// All sets of the answer, in place of those that were reported on the way.
    Front(Vec<FoundPoint>),
    /// The end, in words.
    Done(String),
    /// It was stopped before its end: what is known so far, in words.
    Stopped(String),
    /// What is wrong.
    Error(String),
}

/// A set that was found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FoundPoint {
    /// Of several searches the number of the one that found it: it takes the place of what that one found before.
    pub(super) part: Option<usize>,
    /// What it costs.
    pub(super) cost: Option<f64>,
    /// Its score, if a score decided.
    pub(super) score: Option<f64>,
    /// What it is the best for, and where its sensors are.
    pub(super) words: String,
    /// Its sensors.
    pub(super) placed: Vec<FoundSensor>,
    /// Whether it is proven that no other is better for that.
    pub(super) is_proven: bool,
}

/// A sensor of a set, by the names of the study.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FoundSensor {
    sensor: String,
    pose: String,
}

impl FoundPoint {
    /// The cheapest set so far of a search; none if it has not found any.
    pub(super) fn from_purchase(state: &PurchaseState) -> Option<FoundPoint> {
        let best = state.best.as_ref()?;
        let sensors = best.sensors.iter().map(|one| [&one.sensor, &one.pose, &one.place]);
        let (placed, places) = placed_in(sensors);
        Some(FoundPoint {
            part: Some(state.part),
            cost: Some(Cost::from_thousandths(best.cost).amount()),
            score: best.score,
            words: format!("{}: {places}", state.title),
            placed,
            is_proven: state.is_proven,
        })
    }
}

/// Sensors by their names, and in words where they are; of each its name, its pose and its place.
pub(super) fn placed_in<'s>(sensors: impl Iterator<Item = [&'s String; 3]>) -> (Vec<FoundSensor>, String) {
    let named = |[sensor, pose, place]: [&String; 3]| {
        (FoundSensor { sensor: sensor.clone(), pose: pose.clone() }, format!("{sensor} {place}"))
    };
    let (placed, places): (Vec<FoundSensor>, Vec<String>) = sensors.map(named).unzip();
    (placed, places.join("; "))
}
