//! What a verdict rests on besides its requirement and the sweep: tables of the study, as a hash by which a report
//! notices that they have changed since.

use crate::source::sha256;
use crate::study::{ApproachScore, Condition, Measure, Requirement, Study};

/// Digits of the hash that tell tables apart.
const DIGITS: usize = 16;

/// The hash of what the study says in tables that decide a requirement under a condition; empty where none does.
pub fn tables_sha256(study: &Study, requirement: &Requirement, condition: Condition) -> String {
    let of_condition: &[&str] = match condition {
        Condition::AsPlanned | Condition::OneSensorDead | Condition::TwoSensorsDead => &[],
        Condition::MountingError => &["mounting_error"],
        // Where the floor is.
        Condition::Postures => &["postures", "approach"],
    };
    let of_measure: &[&str] = match &requirement.measure {
        Measure::Counted(_) => &[],
        Measure::Nearness(near) if near.score == ApproachScore::ApproachMarginM => &["approach", "stopping"],
        Measure::Nearness(_) => &["approach"],
        Measure::Controller(_) => &["stopping"],
    };
    let names: Vec<&str> = of_condition.iter().chain(of_measure).copied().collect();
    if names.is_empty() {
        return String::new();
    }
    let said: toml::Table = toml::from_str(&study.text).unwrap_or_default();
    let each = names.iter().map(|name| format!("{name} {}\n", serde_json::json!(said.get(*name))));
    let mut hash = sha256([each.collect::<String>().as_bytes()]);
    hash.truncate(DIGITS);
    hash
}
