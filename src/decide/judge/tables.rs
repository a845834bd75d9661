//! The study's tables on which a value depends besides the sweep, as a hash by which a report detects a change.

use super::spread::Summed;
use perirobot_scene::objects::spec::SurfaceSpec;
use perirobot_scene::source::sha256;
use perirobot_study::input::{ApproachScore, Condition, Study};

/// Hexadecimal digits of the hash.
const DIGITS: usize = 16;

/// The hash of the study's tables that decide a score under a condition, and of the files of people in them; empty if
/// none does. A file that cannot be read has no hash, so it counts as changed.
pub fn tables_sha256(study: &Study, score: Summed, condition: Condition) -> String {
    let of_condition: &[&str] = match condition {
        Condition::AsPlanned | Condition::OneSensorDead | Condition::TwoSensorsDead => &[],
        Condition::MountingError => &["mounting_error"],
        // The floor's height.
        Condition::Postures => &["postures", "approach"],
    };
    let of_score: &[&str] = match score {
        Summed::Counted(..) => &[],
        Summed::Nearness(ApproachScore::ApproachMarginM) => &["approach", "stopping"],
        Summed::Nearness(_) => &["approach"],
        Summed::Controller(_) => &["stopping"],
    };
    let names: Vec<&str> = of_condition.iter().chain(of_score).copied().collect();
    if names.is_empty() { String::new() } else { sha256_of_tables(study, &names) }
}

/// The hash of all tables that decide requirements besides counts.
pub(crate) fn deciding_tables_sha256(study: &Study) -> String {
    sha256_of_tables(study, &["approach", "stopping", "mounting_error", "postures"])
}

fn sha256_of_tables(study: &Study, names: &[&str]) -> String {
    let tables: toml::Table = toml::from_str(&study.text).unwrap_or_default();
    let each = names.iter().map(|name| format!("{name} {}\n", serde_json::json!(tables.get(*name))));
    let people = if names.contains(&"postures") { people_sha256(study) } else { String::new() };
    let mut hash = sha256([each.collect::<String>().as_bytes(), people.as_bytes()]);
    hash.truncate(DIGITS);
    hash
}

/// The hash of each file of a person of `[postures]`, in the study's order.
fn people_sha256(study: &Study) -> String {
    let each = study.postures.iter().filter_map(|posture| match (&posture.person, posture.spot) {
        // Each person once.
        (SurfaceSpec::Mannequin(file), 0) => Some(study.sources.table(file.path())),
        _ => None,
    });
    each.map(|text| text.map_or_else(|_| "none\n".into(), |text| sha256([text.as_bytes()]) + "\n")).collect()
}
