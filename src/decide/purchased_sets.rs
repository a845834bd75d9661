//! The poses of the sets in `cheapest.json`, for modules below the search.

use std::path::Path;

use serde::Deserialize;

use crate::json_file::JsonFile;
use perirobot_march::Result;
use perirobot_sweep::results::Subject;
use perirobot_sweep::results::columns::BETWEEN_MEMBERS;

/// The table of the cheapest sets.
pub const CHEAPEST: &str = "cheapest.csv";

/// The answer of a search for the cheapest set that passes.
pub(crate) const FILE: JsonFile =
    JsonFile { name: "cheapest.json", format: 1, table: CHEAPEST, again: "run `perirobot choose` again" };

/// The parts of the file that are read.
#[derive(Deserialize)]
struct Answer {
    points: Vec<Point>,
}

#[derive(Deserialize)]
struct Point {
    set: Option<Purchased>,
}

#[derive(Deserialize)]
struct Purchased {
    sensors: Vec<Member>,
}

#[derive(Deserialize)]
struct Member {
    sensor: String,
    pose: String,
}

impl Purchased {
    /// The set as in the column `poses` of results.csv.
    fn poses(&self) -> String {
        let each = self.sensors.iter().map(|Member { sensor, pose }| format!("{sensor}:{pose}"));
        each.collect::<Vec<_>>().join(BETWEEN_MEMBERS)
    }
}

/// Whether the results in a folder belong to the sets of a search for the cheapest one: a later sweep may have replaced
/// them.
///
/// # Errors
/// Those of a file that is damaged or of another version.
pub(crate) fn are_results_of_purchase(folder: &Path, results: &Subject) -> Result<bool> {
    let Some(answer) = FILE.read::<Answer>(folder)? else { return Ok(false) };
    let mut found: Vec<String> =
        answer.points.iter().filter_map(|point| point.set.as_ref()).map(Purchased::poses).collect();
    found.sort_unstable();
    found.dedup();
    let is_set = results.combinations.iter().all(|one| one.choices() == 1);
    let mut swept: Vec<String> =
        if is_set { results.combinations.iter().map(|one| one.name_of(0)).collect() } else { Vec::new() };
    swept.sort_unstable();
    Ok(!found.is_empty() && swept == found)
}
