//! Schemas of names that the marcher's crate reads, which does not depend on schemars.

use schemars::JsonSchema;

use perirobot_march::backend::Fusion;
use perirobot_march::metrics::Score;

/// The names of [`Fusion`].
#[derive(JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(inline)]
#[allow(dead_code)]
pub(crate) enum FusionName {
    /// Occupied if any sensor says so, else free if any does, else unknown.
    OccupiedWins,
    /// Log-odds summed in the order of the sensors, clamped after each; above zero is occupied, below is free.
    Octomap,
}

/// A score of a choice of sensors.
#[derive(JsonSchema)]
#[serde(rename_all = "snake_case")]
#[schemars(inline)]
#[allow(dead_code)]
pub(crate) enum ScoreName {
    /// Agreement with the truth over the region: 2TP / (2TP + FP + FN + UF + UO).
    F1,
    /// Cohen's kappa: agreement with the truth beyond chance.
    Kappa,
    /// Share of people's voxels that are hit or felt.
    HumanSeen,
    /// Share of people's voxels that are called occupied.
    HumanClaimed,
    /// Share of people that are detected.
    PeopleDetected,
    /// Share of body parts that are detected.
    PartsDetected,
    /// Share of the region without a label; less is better.
    Unknown,
    /// Share of labelled free space that is called occupied; less is better.
    FalseAlarm,
    /// Share of the region that at least two sensors label, whatever they say.
    SeenTwice,
}

/// The names in a schema of alternatives.
fn names<T: JsonSchema>() -> Vec<String> {
    let schema = schemars::schema_for!(T);
    let alternatives = schema.get("oneOf").and_then(|list| list.as_array()).unwrap();
    alternatives.iter().map(|one| one["const"].as_str().unwrap().into()).collect()
}

#[test]
fn names_are_those_that_are_read() {
    assert_eq!(names::<ScoreName>(), Score::ALL.map(Score::name));
    assert_eq!(names::<FusionName>(), [Fusion::OccupiedWins, Fusion::Octomap].map(Fusion::name));
}
