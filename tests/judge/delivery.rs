//! `scenes/delivery.toml`: a gripper and a carton on a robot's link, a forklift with a driver that mutes a latching curtain, and
//! dark cloth. What is wrong with the curtain alone, and what mends it.

use std::collections::HashMap;
use std::path::Path;

use crate::common::program::{perirobot, rows, text};

const STUDY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/delivery.toml");

/// The rows of a table of a command on the study.
fn run(arguments: &[&str], folder: &Path, table: &str) -> Vec<HashMap<String, String>> {
    let outcome = perirobot(&[arguments, &["--out", text(folder)]].concat());
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    rows(&folder.join(table))
}

#[test]
fn the_muted_curtain_needs_a_camera() {
    let folder = tempfile::tempdir().unwrap();
    let all = run(&["sweep", STUDY, "--backend", "cpu"], folder.path(), "results.csv");
    let detected = |poses: &str| -> Vec<[u32; 2]> {
        let of_set = all.iter().filter(|row| row["region"] == "cell" && row["poses"] == poses);
        of_set.map(|row| ["people_detected", "people"].map(|column| row[column].parse().unwrap())).collect()
    };
    // The operator is in the cell throughout; the driver from the sixth moment on, of eight.
    let two = detected("curtain:here;scanner:foot/back");
    assert_eq!(two.iter().map(|[_, people]| *people).collect::<Vec<_>>(), [1, 1, 1, 1, 1, 1, 2, 2]);
    // While the forklift is in the curtain, the scanner alone finds one of the two.
    assert_eq!(two.iter().map(|[found, _]| *found).collect::<Vec<_>>(), [1, 1, 1, 1, 1, 1, 1, 2]);
    let three = detected("curtain:here;scanner:foot/back;camera:wall/left");
    assert!(three.iter().all(|[found, people]| found == people), "{three:?}");
}

#[test]
fn the_latch_holds_at_every_moment_and_not_over_all() {
    let folder = tempfile::tempdir().unwrap();
    let set = ["--pose", "curtain:here;scanner:foot/back", "--combination", "curtain and scanner"];
    let all = run(&[&["approach", STUDY], &set[..]].concat(), folder.path(), "approach.csv");
    let passed = |entry: &str| -> Vec<(&str, &str)> {
        let of_entry = all.iter().filter(|row| row["entry"] == entry && row["people"] == "absent");
        of_entry.map(|row| (row["snapshot"].as_str(), row["latches_passed"].as_str())).collect()
    };
    let [gangway, inside] = ["gangway", "inside"].map(passed);
    assert_eq!(gangway.len(), 9);
    // Whoever waits until the forklift mutes the curtain gets in.
    let moments = gangway.iter().filter(|(snapshot, _)| *snapshot != "*");
    assert!(moments.clone().all(|(_, passed)| passed.is_empty()), "{gangway:?}");
    assert!(gangway.contains(&("*", "curtain")));
    // Nobody trips it who is inside already; at the two moments when it is muted it has no latch.
    let names: Vec<&str> = inside.iter().map(|(_, passed)| *passed).collect();
    let c = "curtain";
    assert_eq!(names, [c, c, c, c, c, "", "", c, c]);
}
