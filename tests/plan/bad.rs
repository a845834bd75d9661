//! What goes wrong beside the planner: files that change, studies with errors, a second planner.

use std::fs;

use serde_json::json;

use crate::common::program::{Folder, perirobot, text};
use crate::planner::Planner;

#[test]
fn a_file_that_others_changed_is_not_overwritten_unasked() {
    let folder = Folder::new();
    let study = folder.path("study.toml");
    let planner = Planner::start(text(&study), &["--backend", "cpu"]);
    planner
        .post("/edit", json!({ "edit": "place", "sensor": "lidar", "pose": "posts/upright", "gesture": 1 }));
    let theirs = format!("# theirs\n{}", fs::read_to_string(&study).unwrap());
    fs::write(&study, &theirs).unwrap();
    assert_eq!(planner.get("/state")["disk_changed"], true);
    planner.refused("/save", json!({ "overwrite": false }), 409);
    assert_eq!(fs::read_to_string(&study).unwrap(), theirs);
    planner.post("/save", json!({ "overwrite": true }));
    let saved = fs::read_to_string(&study).unwrap();
    assert!(saved.contains("planned") && !saved.contains("# theirs"), "{saved}");
    planner.end();
}

#[test]
fn a_study_with_errors_opens_and_is_repaired() {
    let folder = Folder::new();
    let study = folder.path("study.toml");
    let good = fs::read_to_string(&study).unwrap();
    for (from, to, line) in [("fov_deg = [87, 58]", "fov_deg = [870, 58]", 18), ("seed = 7", "seed = = 7", 1)]
    {
        assert!(good.contains(from));
        fs::write(&study, good.replacen(from, to, 1)).unwrap();
        let planner = Planner::start(text(&study), &["--backend", "cpu"]);
        let state = planner.get("/state");
        assert_eq!(state["problems"][0]["line"], line, "{}", state["problems"]);
        assert_eq!(state["scenes"], json!([]));
        let words = planner.refused("/edit", json!({ "edit": "remove", "index": 0, "gesture": 1 }), 400);
        assert!(!words.is_empty());
        let state = planner.post("/edit", json!({ "edit": "set_text", "text": good, "gesture": 2 }));
        assert_eq!((&state["problems"], &state["changed"]), (&json!([]), &json!(true)));
        assert!(!state["scenes"].as_array().unwrap().is_empty());
        planner.end();
    }
}

#[test]
fn requests_that_make_no_sense_are_refused_in_words() {
    let folder = Folder::new();
    let study = folder.path("study.toml");
    let before = fs::read_to_string(&study).unwrap();
    let planner = Planner::start(text(&study), &["--backend", "cpu"]);
    let at = json!({ "position_m": [0, 0, 1], "pan_deg": 0, "tilt_deg": 0, "roll_deg": 0 });
    for (path, body, status) in [
        ("/edit", json!({ "edit": "place", "sensor": "nobody", "pose": "posts/upright", "gesture": 1 }), 400),
        ("/edit", json!({ "edit": "place", "sensor": "lidar", "pose": "posts/nowhere", "gesture": 1 }), 400),
        ("/edit", json!({ "edit": "move", "index": 7, "at": at, "gesture": 1 }), 400),
        ("/edit", json!({ "edit": "unheard of", "gesture": 1 }), 400),
        ("/edit", json!({ "edit": "set_cost", "sensor": "lidar", "cost": -1, "gesture": 1 }), 400),
        ("/score", json!({ "n": 1, "moment": 99, "voxel": "fine", "move": null, "dead": null }), 400),
        (
            "/score",
            json!({ "n": 1, "moment": 0, "voxel": "fine", "move": { "index": 5, "at": at }, "dead": null }),
            400,
        ),
        ("/score", json!({ "n": 1, "moment": 0, "voxel": "fine", "move": null, "dead": 3 }), 400),
        ("/score", json!([1, 2]), 400),
        ("/why", json!({ "n": 1, "moment": 0, "at_m": [1e30, 0, 0] }), 400),
        ("/nowhere", json!({}), 404),
    ] {
        let words = planner.refused(path, body.clone(), status);
        assert!(!words.is_empty(), "{path} {body}");
    }
    assert_eq!(planner.get("/text")["text"], before);
    planner.end();
}

#[test]
fn a_second_planner_is_refused_unless_it_only_reads() {
    let folder = Folder::new();
    let study = folder.path("study.toml");
    let first = Planner::start(text(&study), &["--backend", "cpu"]);
    let second = perirobot(&["plan", text(&study), "--no-open"]);
    assert_eq!(second.code, Some(75), "{}", second.stderr);
    assert!(second.stderr.contains("is open in another planner"), "{}", second.stderr);
    let reader = Planner::start(text(&study), &["--backend", "cpu", "--read-only"]);
    assert_eq!(reader.get("/state")["read_only"], true);
    let change = json!({ "edit": "place", "sensor": "lidar", "pose": "posts/upright", "gesture": 1 });
    assert!(reader.refused("/edit", change, 403).contains("read only"));
    reader.refused("/save", json!({ "overwrite": true }), 403);
    reader.end();
    first.end();
}

#[test]
fn a_change_on_an_older_version_is_refused() {
    let folder = Folder::new();
    let study = folder.path("study.toml");
    let planner = Planner::start(text(&study), &["--backend", "cpu"]);
    let begin = planner.get("/state")["version"].as_u64().unwrap();
    let place = |gesture: u64, version: u64| json!({ "edit": "place", "sensor": "lidar", "pose": "posts/upright", "gesture": gesture, "version": version });
    let state = planner.post("/edit", place(1, begin));
    let next = state["version"].as_u64().unwrap();
    assert!(next > begin);
    // Another window, which has not seen that change.
    let words = planner.refused("/edit", place(2, begin), 412);
    assert!(words.contains("another window has changed the study"), "{words}");
    planner.refused("/undo", json!({ "version": begin }), 412);
    planner.refused("/save", json!({ "overwrite": false, "version": begin }), 412);
    assert_eq!(planner.get("/state")["version"], next);
    // A change that is refused for another reason is no new version.
    planner.refused(
        "/edit",
        json!({ "edit": "set_cost", "sensor": "lidar", "cost": -1, "gesture": 3, "version": next }),
        400,
    );
    let state = planner.post("/undo", json!({ "version": next }));
    assert!(state["version"].as_u64().unwrap() > next);
    planner.end();
}

#[test]
fn a_study_that_is_missing_is_an_error() {
    let missing = perirobot(&["plan", "nowhere.toml", "--no-open"]);
    assert_eq!(missing.code, Some(2));
    assert!(missing.stderr.contains("nowhere.toml"), "{}", missing.stderr);
    let unnamed = perirobot(&["plan", "--read-only"]);
    assert_eq!(unnamed.code, Some(2), "{}", unnamed.stdout);
    assert!(
        unnamed.stderr.contains("perirobot plan") && unnamed.stderr.contains("<STUDY>"),
        "{}",
        unnamed.stderr
    );
}
