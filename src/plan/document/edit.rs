//! What a person can change in a study, as the page sends it.

use serde::{Deserialize, Serialize};

use super::objects::ObjectMove;
use super::plan::PlacedName;
use super::pose::Pose6;
use super::shapes::SensorShape;

/// A change of the study. Numbers are those of the plan, in its order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "edit", rename_all = "snake_case")]
pub enum Edit {
    /// One of a sensor's listed poses joins the plan.
    Place {
        /// The sensor.
        sensor: String,
        /// The pose: `wall/1/0`.
        pose: String,
    },
    /// A sensor of the study, or one of the catalogue that the study gets, joins the plan anywhere.
    Add {
        /// Which.
        #[serde(flatten)]
        device: Device,
        /// Where.
        at: Pose6,
        /// What one costs, if it is new in the study.
        #[serde(default)]
        cost: Option<f64>,
    },
    /// A placed sensor goes anywhere.
    Move {
        /// Which of the plan.
        index: usize,
        /// Where.
        at: Pose6,
    },
    /// A placed sensor goes to one of its listed poses.
    Snap {
        /// Which of the plan.
        index: usize,
        /// The pose.
        pose: String,
    },
    /// Another sensor like a placed one joins the plan.
    Copy {
        /// Which of the plan.
        index: usize,
        /// Where the new one is.
        at: Pose6,
    },
    /// A placed sensor leaves the plan.
    Remove {
        /// Which of the plan.
        index: usize,
    },
    /// Another sensor stands where a placed one stood.
    SetSensor {
        /// Which of the plan.
        index: usize,
        /// The other.
        #[serde(flatten)]
        device: Device,
        /// What one costs, if it is new in the study.
        #[serde(default)]
        cost: Option<f64>,
    },
    /// Other sensors at listed poses are the plan.
    SetPlan {
        /// All of them.
        placed: Vec<PlacedName>,
    },
    /// What one of a sensor costs.
    SetCost {
        /// The sensor.
        sensor: String,
        /// Its cost.
        cost: f64,
    },
    /// Sensors of known and of unknown noise may be in the study together.
    MixNoise,
    /// What a set of sensors may cost.
    SetBudget {
        /// The budget; none takes it away.
        budget: Option<f64>,
    },
    /// A box or a ball is moved or made larger.
    SetBox {
        /// What it belongs to.
        table: BoxTable,
        /// The name of the region or the entry.
        name: String,
        /// Its new shape.
        #[serde(flatten)]
        shape: ShapeEdit,
    },
    /// What a sensor guards is moved or made larger: the box and the zone of a curtain, a mat, the field of a scanner.
    SetSensorShape {
        /// The sensor.
        sensor: String,
        /// Its new shape.
        #[serde(flatten)]
        shape: SensorShape,
    },
    /// An object of a scene file is moved or turned.
    MoveObject {
        /// The scene file, by the name that the state gives.
        file: String,
        /// The object's name.
        object: String,
        /// Where to.
        #[serde(flatten)]
        to: ObjectMove,
    },
    /// The whole file, as a person wrote it.
    SetText {
        /// The text.
        text: String,
    },
}

/// A sensor that can join the plan.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Device {
    /// A sensor of the study, by its name.
    Sensor(String),
    /// A device of the catalogue, by its name there. The study gets a sensor of its own for it.
    Model(String),
}

/// What a box belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BoxTable {
    /// An entry of `[approach]`.
    Entry,
    /// A region.
    Region,
}

/// Another shape of a region or an entry, of the same sort.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ShapeEdit {
    /// A box by its corners, in metres.
    Box {
        /// Lowest corner.
        min_m: [f64; 3],
        /// Highest corner.
        max_m: [f64; 3],
    },
    /// A ball, or the half of one, in metres.
    Sphere {
        /// Its centre.
        center_m: [f64; 3],
        /// Its radius.
        radius_m: f64,
    },
}

/// An edit as the page sends it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EditRequest {
    /// What is changed.
    #[serde(flatten)]
    pub edit: Edit,
    /// Edits of one gesture, as of a drag, are undone together.
    #[serde(default)]
    pub gesture: Option<u64>,
    /// The moment that the page shows: places are in the world, also of sensors that links carry.
    #[serde(default)]
    pub moment: Option<usize>,
}
