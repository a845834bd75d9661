//! `perirobot plan` without a study: the templates, and the planner of the one that is chosen.

use std::fs;

use serde_json::json;

use crate::planner::Planner;

const ALL: [&str; 5] = ["assembly", "palletiser", "welding", "handover", "laboratory"];

#[test]
fn a_template_is_written_and_opened() {
    let folder = tempfile::tempdir().unwrap();
    let planner = Planner::start_in(folder.path(), &["--backend", "cpu"]);
    let (status, page) = planner.send("GET", "/", "");
    assert!(status == 200 && String::from_utf8(page).unwrap().contains("Begin with a cell"));
    let shown = planner.get("/templates");
    let names: Vec<&str> =
        shown["templates"].as_array().unwrap().iter().map(|one| one["name"].as_str().unwrap()).collect();
    assert_eq!(names, ALL);
    let (status, sketch) = planner.send("GET", "/sketch?template=laboratory", "");
    let sketch = String::from_utf8(sketch).unwrap();
    assert!(status == 200 && sketch.starts_with("<svg") && sketch.contains("class=\"badge\""), "{sketch}");
    assert_eq!(planner.send("GET", "/state", "").0, 404, "no study is open");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is written unasked");

    let opened = planner.post("/open", json!({ "template": "laboratory", "folder": "./bench" }));
    assert_eq!(opened["study"], "./bench/study.toml");
    let state = planner.get("/state");
    assert_eq!(state["placed"].as_array().unwrap().len(), 1, "{state}");
    assert!(folder.path().join("bench/cell.toml").exists());
    // It is the planner of that study only.
    planner.refused("/open", json!({ "template": "welding", "folder": "other" }), 409);
    assert!(!folder.path().join("other").exists());
    planner.post("/edit", json!({ "edit": "remove", "index": 0, "gesture": 1 }));
    planner.post("/save", json!({ "overwrite": false }));
    let said = planner.end();
    assert_eq!(said.code, Some(0), "{}", said.stderr);
}

#[test]
fn what_cannot_be_written_is_refused_in_words() {
    let folder = tempfile::tempdir().unwrap();
    let planner = Planner::start_in(folder.path(), &["--backend", "cpu"]);
    fs::create_dir(folder.path().join("mine")).unwrap();
    fs::write(folder.path().join("mine/cell.toml"), "# mine").unwrap();
    let words = planner.refused("/open", json!({ "template": "welding", "folder": "mine" }), 400);
    assert!(words.contains("cell.toml") && words.contains("exists and would be overwritten"), "{words}");
    assert_eq!(fs::read_dir(folder.path().join("mine")).unwrap().count(), 1);
    let words = planner.refused("/open", json!({ "template": "kitchen", "folder": "new" }), 400);
    assert!(words.contains("\"kitchen\"") && words.contains("palletiser"), "{words}");
    let words = planner.refused("/open", json!({ "template": "welding", "folder": "" }), 400);
    assert!(words.contains("name a folder"), "{words}");
    planner.refused("/open", json!({ "folder": "new" }), 400);
    assert!(!folder.path().join("new").exists());
    planner.end();
}
