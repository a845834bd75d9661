//! Objects of scene files that are moved: saved with the study, counted as a sweep counts them, and refused in words.

use std::fs;
use std::path::PathBuf;

use serde_json::{Value, json};

use crate::common::program::{Folder, perirobot, text};
use crate::planner::Planner;
use crate::saved::{shown, swept};

const PERSON: &str = "\n[[object]]\nname = \"visitor\"            # walks by\nrole = \"human\"\n\
                      cylinder = { radius_m = 0.1, height_m = 1.0 }\n[object.snapshots]\n\
                      position_m = [[-0.6, 0.5, 0.55], [-0.6, -0.5, 0.55]]\n";

/// The study with its scene twice, in two moments.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.edit("cell.toml", "", PERSON);
    folder.edit(
        "study.toml",
        "[[region]]",
        "[[scene]]\nfile = \"./cell.toml\"\nname = \"again\"\n\n[[region]]",
    );
    folder
}

fn object<'a>(state: &'a Value, name: &str) -> &'a Value {
    let objects = state["scene_files"][0]["objects"].as_array().unwrap();
    objects.iter().find(|object| object["name"] == name).unwrap_or_else(|| panic!("no {name}: {objects:?}"))
}

fn go(object: &str, more: Value) -> Value {
    let mut edit = json!({ "edit": "move_object", "file": "cell.toml", "object": object });
    edit.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    edit
}

#[test]
fn a_sweep_of_the_saved_files_counts_what_the_page_showed() {
    let folder = folder();
    let [study, cell] = ["study.toml", "cell.toml"].map(|name| folder.path(name));
    let before = [&study, &cell].map(|path| fs::read_to_string(path).unwrap());
    let planner = Planner::start(text(&study), &["--backend", "cpu"]);
    let state = planner.get("/state");
    assert_eq!(state["scene_files"].as_array().unwrap().len(), 1, "{}", state["scene_files"]);
    assert_eq!(state["scene_files"][0]["scenes"], json!(["cell", "again"]));
    let visitor = object(&state, "visitor");
    assert_eq!(visitor["positions_m"], json!([[-0.6, 0.5, 0.55], [-0.6, -0.5, 0.55]]));
    assert_eq!((&visitor["position_of"], &visitor["yaw_of"]), (&json!([0, 1]), &json!([0])));
    planner.post("/edit", json!({ "edit": "place", "sensor": "camera", "pose": "wall/0/1", "gesture": 1 }));
    let state = planner
        .post("/edit", json!({ "edit": "place", "sensor": "lidar", "pose": "posts/upright", "gesture": 2 }));
    let still = shown(&planner, &state);
    let moves = [
        go("visitor", json!({ "position_m": [-0.31249, 0.4, 0.55], "position_entry": 0, "gesture": 3 })),
        go("visitor", json!({ "position_m": [-0.3, -0.25, 0.55], "position_entry": 1, "gesture": 4 })),
        go("crate", json!({ "position_m": [0.5, 0.15, 0.25], "yaw_deg": 30.04, "gesture": 5 })),
        go("arm", json!({ "position_m": [0.35, 0.2, 0.45], "gesture": 6 })),
    ];
    let mut state = Value::Null;
    for edit in moves {
        let worlds = planner.get("/state")["worlds"].as_u64().unwrap();
        state = planner.post("/edit", edit);
        assert_eq!(state["worlds"], worlds + 1, "its voxels are made anew");
    }
    assert_eq!(object(&state, "crate")["yaws_deg"], json!([30.0]));
    let moved = shown(&planner, &state);
    assert!(moved.iter().all(|(key, counts)| still[key] != *counts), "all scenes and moments differ");
    let lines = planner.get("/difference");
    let titles = lines.as_array().unwrap().iter().filter(|line| line["kind"] == "file");
    assert_eq!(titles.map(|line| &line["text"]).collect::<Vec<_>>(), ["study.toml", "cell.toml"]);
    let scenes = &planner.get("/text")["scenes"];
    assert!(scenes["cell.toml"].as_str().unwrap().contains("[-0.312, 0.4, 0.55]"), "{scenes}");
    assert_eq!(
        [&study, &cell].map(|path| fs::read_to_string(path).unwrap()),
        before,
        "nothing is written yet"
    );
    let state = planner.post("/save", json!({ "overwrite": false }));
    assert_eq!((&state["changed"], &state["problems"]), (&json!(false), &json!([])));
    planner.end();
    let mut expected = before[1].clone();
    for (from, to) in [
        ("[-0.6, 0.5, 0.55]", "[-0.312, 0.4, 0.55]"),
        ("[-0.6, -0.5, 0.55]", "[-0.3, -0.25, 0.55]"),
        ("[0.7, 0.4, 0.25]\n", "[0.5, 0.15, 0.25]\nrpy_deg = [0, 0, 30]\n"),
        ("[0.2, 0.3, 0.45]", "[0.35, 0.2, 0.45]"),
    ] {
        assert!(expected.contains(from), "{from}");
        expected = expected.replacen(from, to, 1);
    }
    assert_eq!(fs::read_to_string(&cell).unwrap(), expected);
    let out = folder.path("out");
    let outcome = perirobot(&["sweep", text(&study), "--out", text(&out), "--backend", "oracle"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert_eq!(moved, swept(&out));
}

#[test]
fn one_undo_takes_back_a_gesture_in_any_file() {
    let folder = folder();
    let study = folder.path("study.toml");
    let planner = Planner::start(text(&study), &["--backend", "cpu"]);
    let state = planner.get("/state");
    planner
        .post("/edit", json!({ "edit": "place", "sensor": "lidar", "pose": "posts/upright", "gesture": 1 }));
    for x in [0.1, 0.2, 0.3] {
        planner.post("/edit", go("arm", json!({ "position_m": [x, 0.3, 0.45], "gesture": 2 })));
    }
    let undone = planner.post("/undo", json!({}));
    assert_eq!(object(&undone, "arm"), object(&state, "arm"));
    assert_eq!((&undone["changed"], undone["placed"].as_array().unwrap().len()), (&json!(true), 1));
    let undone = planner.post("/undo", json!({}));
    assert_eq!((&undone["changed"], &undone["can_undo"]), (&json!(false), &json!(false)));
    planner.post("/redo", json!({}));
    let redone = planner.post("/redo", json!({}));
    assert_eq!(object(&redone, "arm")["positions_m"], json!([[0.3, 0.3, 0.45]]));
    planner.end();
}

#[test]
fn scene_files_that_others_change_are_not_lost() {
    let folder = folder();
    let [study, cell] = ["study.toml", "cell.toml"].map(|name| folder.path(name));
    let planner = Planner::start(text(&study), &["--backend", "cpu"]);
    let before = fs::read_to_string(&cell).unwrap();
    let theirs = before.replace("[0.2, 0.3, 0.45]", "[0.25, 0.3, 0.45]");
    // One that was not changed here is followed.
    fs::write(&cell, &theirs).unwrap();
    assert_eq!(planner.get("/state")["disk_changed"], false);
    let state = planner
        .post("/edit", json!({ "edit": "place", "sensor": "lidar", "pose": "posts/upright", "gesture": 1 }));
    assert_eq!(object(&state, "arm")["positions_m"], json!([[0.25, 0.3, 0.45]]));
    planner.post("/save", json!({ "overwrite": false }));
    assert_eq!(fs::read_to_string(&cell).unwrap(), theirs, "what was not changed here is not written");
    // Of one that was, Save asks.
    planner.post("/edit", go("arm", json!({ "position_m": [0.1, 0.3, 0.45], "gesture": 2 })));
    fs::write(&cell, &before).unwrap();
    assert_eq!(planner.get("/state")["disk_changed"], true);
    let words = planner.refused("/save", json!({ "overwrite": false }), 409);
    assert_eq!(words, "another program has changed cell.toml since the study was opened");
    assert_eq!(fs::read_to_string(&cell).unwrap(), before);
    planner.post("/save", json!({ "overwrite": true }));
    assert_eq!(fs::read_to_string(&cell).unwrap(), theirs.replace("[0.25, 0.3, 0.45]", "[0.1, 0.3, 0.45]"));
    fs::write(&cell, &before).unwrap();
    planner.post("/edit", go("arm", json!({ "position_m": [0.1, 0.1, 0.45], "gesture": 3 })));
    let state = planner.post("/reload", json!({}));
    assert_eq!(
        (object(&state, "arm")["positions_m"].clone(), &state["changed"]),
        (json!([[0.2, 0.3, 0.45]]), &json!(false))
    );
    planner.end();
}

#[test]
fn what_cannot_be_moved_says_why() {
    let folder = folder();
    fs::create_dir(folder.path("own")).unwrap();
    let study = fs::read_to_string(folder.path("study.toml")).unwrap().replace("cell.toml", "../cell.toml");
    folder.write("own/study.toml", study);
    let own = folder.path("own/study.toml");
    let planner = Planner::start(text(&own), &["--backend", "cpu", "--allow-outside"]);
    let state = planner.get("/state");
    let file = &state["scene_files"][0];
    assert!(
        file["reason"]
            .as_str()
            .unwrap()
            .ends_with("is outside the folder of the study, which is all that the planner writes to"),
        "{file}"
    );
    assert_eq!(object(&state, "crate")["can_move"], false);
    let words = planner.refused("/edit", go("crate", json!({ "position_m": [0, 0, 0.3] })), 400);
    assert!(words.contains("cannot be edited here"), "{words}");
    planner.end();
    let study = folder.path("study.toml");
    let planner = Planner::start(text(&study), &["--backend", "cpu", "--read-only"]);
    assert_eq!(planner.get("/state")["scene_files"][0]["reason"], "the study is open to be read only");
    planner.refused("/edit", go("crate", json!({ "position_m": [0, 0, 0.3] })), 403);
    planner.end();
    folder.edit("study.toml", "", "\n[[candidate]]\nobject = \"arm\"\nx_m = [0.2, 0.3]\ny_m = 0.3\n");
    let planner = Planner::start(text(&study), &["--backend", "cpu"]);
    let state = planner.get("/state");
    assert_eq!(state["problems"], json!([]));
    for (name, words) in [("walls", "It is the room itself"), ("arm", "It is where a [[candidate]]")] {
        let object = object(&state, name);
        assert!(
            object["words"].as_str().unwrap().starts_with(words) && object["can_move"] == false,
            "{object}"
        );
    }
    // Where no study would load it stays as it was.
    let words = planner.refused("/edit", go("crate", json!({ "position_m": [900000, 0, 0.3] })), 400);
    assert!(!words.is_empty());
    assert_eq!(planner.get("/state")["changed"], false);
    planner.end();
}

/// Files of a study in a planner, before anything was changed.
struct Opened {
    folder: Folder,
    planner: Planner,
    study: PathBuf,
    cell: PathBuf,
    before: String,
}

impl Opened {
    fn new() -> Opened {
        let folder = folder();
        let [study, cell] = ["study.toml", "cell.toml"].map(|name| folder.path(name));
        let planner = Planner::start(text(&study), &["--backend", "cpu"]);
        let before = fs::read_to_string(&cell).unwrap();
        Opened { folder, planner, study, cell, before }
    }

    fn place_lidar(&self, gesture: u64) -> Value {
        json!({ "edit": "place", "sensor": "lidar", "pose": "posts/upright", "gesture": gesture })
    }

    #[track_caller]
    fn asks(&self) {
        let words = self.planner.refused("/save", json!({ "overwrite": false }), 409);
        assert_eq!(words, "another program has changed cell.toml since the study was opened");
    }
}

#[test]
fn a_scene_file_that_cannot_be_read_is_not_overwritten_unasked() {
    let opened = Opened::new();
    let latin = b"# caf\xe9\n";
    fs::write(&opened.cell, latin).unwrap();
    opened.planner.post("/edit", opened.place_lidar(1));
    opened.asks();
    assert_eq!(fs::read(&opened.cell).unwrap(), latin);
    fs::remove_file(&opened.cell).unwrap();
    opened.asks();
    assert!(!opened.cell.exists(), "one that is gone is not made again, either");
    opened.planner.end();
}

#[test]
fn an_undone_step_does_not_take_back_what_others_wrote() {
    let opened = Opened::new();
    opened.planner.post("/edit", go("arm", json!({ "position_m": [0.1, 0.3, 0.45], "gesture": 1 })));
    opened.planner.post("/save", json!({ "overwrite": false }));
    let theirs = fs::read_to_string(&opened.cell).unwrap() + "# theirs\n";
    fs::write(&opened.cell, &theirs).unwrap();
    opened.planner.post("/undo", json!({}));
    opened.asks();
    assert_eq!(fs::read_to_string(&opened.cell).unwrap(), theirs);
    opened.planner.end();
}

#[test]
fn a_scene_file_under_another_name_is_read_with_the_study() {
    let opened = Opened::new();
    opened.planner.post("/edit", opened.place_lidar(1));
    fs::rename(&opened.cell, opened.folder.path("hall.toml")).unwrap();
    let theirs = fs::read_to_string(&opened.study).unwrap().replace("cell.toml", "hall.toml");
    fs::write(&opened.study, &theirs).unwrap();
    let state = opened.planner.post("/reload", json!({}));
    assert_eq!((&state["changed"], &state["problems"]), (&json!(false), &json!([])));
    assert_eq!(state["scene_files"][0]["name"], "hall.toml");
    opened.planner.post("/save", json!({ "overwrite": false }));
    assert_eq!(fs::read_to_string(&opened.study).unwrap(), theirs);
    assert!(!opened.cell.exists());
    opened.planner.end();
}

#[test]
fn a_reload_that_fails_leaves_the_question_open() {
    let opened = Opened::new();
    opened.planner.post("/edit", opened.place_lidar(1));
    let theirs = fs::read_to_string(&opened.study).unwrap() + "# theirs\n";
    fs::write(&opened.study, &theirs).unwrap();
    fs::write(&opened.cell, b"\xff").unwrap();
    opened.planner.refused("/reload", json!({}), 400);
    opened.planner.refused("/save", json!({ "overwrite": false }), 409);
    assert_eq!(fs::read_to_string(&opened.study).unwrap(), theirs);
    opened.planner.end();
}

#[test]
fn a_scene_file_that_others_break_and_repair_is_followed() {
    let opened = Opened::new();
    fs::write(&opened.cell, format!("bogus = 1\n{}", opened.before)).unwrap();
    let words = opened.planner.refused("/edit", opened.place_lidar(1), 400);
    assert!(words.contains("bogus"), "{words}");
    let moved = opened.before.replace("[0.2, 0.3, 0.45]", "[0.25, 0.3, 0.45]");
    fs::write(&opened.cell, &moved).unwrap();
    // An edit that is refused shows the new scene, too.
    opened.planner.refused("/edit", json!({ "edit": "remove", "index": 99, "gesture": 2 }), 400);
    let state = opened.planner.get("/state");
    assert_eq!(object(&state, "arm")["positions_m"], json!([[0.25, 0.3, 0.45]]));
    assert_eq!(state["problems"], json!([]));
    opened.planner.post("/edit", opened.place_lidar(3));
    opened.planner.end();
}

#[cfg(unix)]
#[test]
fn a_link_that_leads_elsewhere_is_not_written() {
    let opened = Opened::new();
    let outside = Folder::new();
    let other = outside.path("cell.toml");
    fs::write(&other, &opened.before).unwrap();
    fs::remove_file(&opened.cell).unwrap();
    std::os::unix::fs::symlink(&other, &opened.cell).unwrap();
    opened.planner.post("/edit", go("arm", json!({ "position_m": [0.1, 0.3, 0.45], "gesture": 1 })));
    let words = opened.planner.refused("/save", json!({ "overwrite": false }), 400);
    assert!(words.starts_with("cell.toml is another file now"), "{words}");
    assert_eq!(fs::read_to_string(&other).unwrap(), opened.before);
    opened.planner.end();
}
