//! What the planner shows is what a sweep of the saved file counts; comments stay; verdicts are those of `judge`.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::common::program::{Folder, perirobot, text};
use crate::planner::Planner;

/// The columns that the page shows as integers.
const COUNTED: [&str; 6] = ["tp", "fp", "fn", "tn", "uo", "uf"];

/// The counts of the plan that a sweep wrote: of each scene, snapshot and region.
pub(crate) fn swept(out: &Path) -> HashMap<(String, usize, String), Vec<u64>> {
    let mut reader = csv::Reader::from_path(out.join("results.csv")).unwrap();
    let head = reader.headers().unwrap().clone();
    let column = |name: &str| head.iter().position(|one| one == name).unwrap_or_else(|| panic!("no {name}"));
    let [scene, snapshot, region, combination] = ["scene", "snapshot", "region", "combination"].map(column);
    let columns = COUNTED.map(column);
    let mut all = HashMap::new();
    for row in reader.records() {
        let row = row.unwrap();
        if &row[combination] != "planned" {
            continue;
        }
        let counts = columns.iter().map(|&column| row[column].parse().unwrap()).collect();
        let key = (row[scene].to_string(), row[snapshot].parse().unwrap(), row[region].to_string());
        assert!(all.insert(key, counts).is_none(), "one row each: {row:?}");
    }
    all
}

/// The counts that the planner shows of each moment and region.
pub(crate) fn shown(planner: &Planner, state: &Value) -> HashMap<(String, usize, String), Vec<u64>> {
    let mut all = HashMap::new();
    for scene in state["scenes"].as_array().unwrap() {
        let [begin, end] = [0, 1].map(|i| scene["moments"][i].as_u64().unwrap());
        for moment in begin..end {
            let ask =
                json!({ "n": moment + 1, "moment": moment, "voxel": "fine", "move": null, "dead": null });
            let answer = planner.post("/score", ask);
            assert_eq!(answer["n"], moment + 1);
            for counts in answer["counts"].as_array().unwrap() {
                let key = (
                    scene["name"].as_str().unwrap().to_string(),
                    (moment - begin) as usize,
                    counts["region"].as_str().unwrap().to_string(),
                );
                all.insert(key, COUNTED.iter().map(|&name| counts[name].as_u64().unwrap()).collect());
            }
        }
    }
    all
}

#[test]
fn a_sweep_of_the_saved_file_counts_what_the_page_showed() {
    let folder = Folder::new();
    let study = folder.path("study.toml");
    let before = fs::read_to_string(&study).unwrap();
    fs::write(&study, format!("# a comment that stays\n{before}")).unwrap();
    let planner = Planner::start(text(&study), &["--backend", "cpu"]);
    let state = planner.get("/state");
    assert_eq!(state["placed"], json!([]), "nothing is planned yet");
    planner.post("/edit", json!({ "edit": "place", "sensor": "camera", "pose": "wall/0/1", "gesture": 1 }));
    let at = json!({ "position_m": [-0.8124, 0.5, 1.0], "pan_deg": -33.33, "tilt_deg": -20, "roll_deg": 0 });
    planner.post("/edit", json!({ "edit": "add", "sensor": "camera", "at": at, "gesture": 2 }));
    let at = json!({ "position_m": [0.8, -0.6, 1.1], "pan_deg": 100, "tilt_deg": 5, "roll_deg": 10.04 });
    let state = planner.post("/edit", json!({ "edit": "add", "sensor": "lidar", "at": at, "gesture": 3 }));
    assert_eq!(state["placed"].as_array().unwrap().len(), 3, "{}", state["placed"]);
    // Dragged, one step a gesture.
    let score = |x: f64| {
        let at = json!({ "position_m": [x, 0.45, 1.2], "pan_deg": 160.0, "tilt_deg": -35.5, "roll_deg": 0 });
        let ask =
            json!({ "n": 9, "moment": 0, "voxel": "fine", "move": { "index": 1, "at": at }, "dead": null });
        (planner.post("/score", ask), at)
    };
    let (_, _) = score(0.2);
    let (dragged, at) = score(0.3337);
    let state = planner.post("/edit", json!({ "edit": "move", "index": 1, "at": at, "gesture": 4 }));
    let shown = shown(&planner, &state);
    let first = &state["scenes"][0]["name"];
    for counts in dragged["counts"].as_array().unwrap() {
        let key = (first.as_str().unwrap().into(), 0, counts["region"].as_str().unwrap().to_string());
        let of: Vec<u64> = COUNTED.iter().map(|&name| counts[name].as_u64().unwrap()).collect();
        assert_eq!(shown[&key], of, "what was shown while dragging is what the edit gives");
    }
    let state = planner.post("/save", json!({ "overwrite": false }));
    assert_eq!((&state["changed"], &state["problems"]), (&json!(false), &json!([])));
    let ended = planner.end();
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), "the planner ends\n"));
    let saved = fs::read_to_string(&study).unwrap();
    assert!(saved.starts_with("# a comment that stays\n"), "{saved}");
    let out = folder.path("out");
    let outcome = perirobot(&["sweep", text(&study), "--out", text(&out), "--backend", "oracle"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let swept = swept(&out);
    assert!(!swept.is_empty());
    assert_eq!(shown, swept);
}

#[test]
fn undo_takes_back_a_gesture_and_redo_makes_it_again() {
    let folder = Folder::new();
    let study = folder.path("study.toml");
    let before = fs::read_to_string(&study).unwrap();
    let planner = Planner::start(text(&study), &["--backend", "cpu"]);
    planner
        .post("/edit", json!({ "edit": "place", "sensor": "lidar", "pose": "posts/upright", "gesture": 1 }));
    for x in [0.1, 0.2, 0.3] {
        let at = json!({ "position_m": [x, 0.5, 1.0], "pan_deg": 0, "tilt_deg": 0, "roll_deg": 0 });
        planner.post("/edit", json!({ "edit": "move", "index": 0, "at": at, "gesture": 2 }));
    }
    let text_of = |planner: &Planner| planner.get("/text")["text"].as_str().unwrap().to_string();
    let moved = text_of(&planner);
    planner.post("/undo", json!({}));
    let placed = text_of(&planner);
    assert!(placed.contains("[\"posts/upright\"]") && !placed.contains("planned/"), "{placed}");
    assert!(moved.contains("planned/") && moved.contains("[0.3, 0.5, 1]"), "{moved}");
    let state = planner.post("/undo", json!({}));
    assert_eq!(
        (text_of(&planner), &state["changed"], &state["can_undo"]),
        (before, &json!(false), &json!(false))
    );
    planner.post("/redo", json!({}));
    planner.post("/redo", json!({}));
    assert_eq!(text_of(&planner), moved);
    let lines = planner.get("/difference");
    assert!(lines.as_array().unwrap().iter().any(|line| line["kind"] == "new"), "{lines}");
    let ended = planner.end();
    assert!(ended.stderr.contains("changes were not saved"), "{}", ended.stderr);
}
