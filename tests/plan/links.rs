//! A sensor on a robot's link: moved in the world at a moment, written on the link, counted as a sweep counts it.

use std::fs;

use serde_json::{Value, json};

use crate::common::program::{Folder, perirobot, text};
use crate::planner::Planner;
use crate::saved::{shown, swept};

const HAND_CAMERA: &str = r#"
[[sensor]]
name = "hand camera"
model = "realsense-d455"
resolution_px = [32, 24]
noise = { std_m = 0 }
cost = 500
on = { object = "robot", link = "tool0" }
[[sensor.poses]]
name = "flange"
list = [{ name = "ahead", position_m = [0, 0, 0.1], facing = [0, 0, 1] }]
"#;

/// Where the second sensor of the plan is at a moment.
fn place(planner: &Planner, moment: usize) -> Value {
    let ask = json!({ "n": 1, "moment": moment, "voxel": "fine", "move": null, "dead": null });
    planner.post("/score", ask)["places"][1].clone()
}

#[track_caller]
fn assert_near(place: &Value, at: &Value) {
    let turned = ["pan_deg", "tilt_deg", "roll_deg"].map(|key| at[key].as_f64().unwrap());
    for axis in 0..3 {
        let off_m = place["at_m"][axis].as_f64().unwrap() - at["position_m"][axis].as_f64().unwrap();
        let off_deg =
            (place["turned_deg"][axis].as_f64().unwrap() - turned[axis] + 180.0).rem_euclid(360.0) - 180.0;
        // Rounded on the link: a millimetre's half on each axis, a tenth of a degree's half about each.
        assert!(off_m.abs() < 1e-3 && off_deg.abs() < 0.2, "{place} {at}");
    }
}

#[test]
fn a_sweep_of_the_saved_study_counts_the_pose_on_the_link() {
    let folder = Folder::new();
    let cell = folder.path("cell");
    let outcome = perirobot(&["init", "--template", "assembly", text(&cell)]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    folder.edit("cell/study.toml", "", HAND_CAMERA);
    let study = cell.join("study.toml");
    let planner = Planner::start(text(&study), &["--backend", "cpu"]);
    let state =
        planner.post("/edit", json!({ "edit": "place", "sensor": "hand camera", "pose": "flange/ahead" }));
    let sensors = state["sensors"].as_array().unwrap();
    let sensor = sensors.iter().find(|sensor| sensor["name"] == "hand camera").unwrap();
    assert_eq!(
        (&sensor["on"], &sensor["carried"]),
        (&json!({ "object": "robot", "link": "tool0" }), &json!(false))
    );
    let [first, third] = [0, 2].map(|moment| place(&planner, moment));
    assert_ne!(first, third, "the arm moves");
    assert_eq!(first["at_m"], state["placed"][1]["at_m"]);
    let at = json!({ "position_m": [0.2, 0.1, 1.3], "pan_deg": -80.0, "tilt_deg": -35.5, "roll_deg": 12.0 });
    let ask = json!({ "n": 2, "moment": 2, "voxel": "fine", "move": { "index": 1, "at": at }, "dead": null });
    let dragged = planner.post("/score", ask);
    assert_near(&dragged["places"][1], &at);
    let state =
        planner.post("/edit", json!({ "edit": "move", "index": 1, "at": at, "moment": 2, "gesture": 1 }));
    assert_eq!(state["placed"][1]["pose"], "planned/0");
    assert_eq!(place(&planner, 2), dragged["places"][1]);
    assert_ne!(place(&planner, 0), place(&planner, 2));
    let shown = shown(&planner, &state);
    for counts in dragged["counts"].as_array().unwrap() {
        let key = ("cell".to_string(), 2, counts["region"].as_str().unwrap().to_string());
        let of = ["tp", "fp", "fn", "tn", "uo", "uf"].map(|name| counts[name].as_u64().unwrap());
        assert_eq!(shown[&key], of, "what was shown while dragging is what the edit gives");
    }
    // Moved by nothing it stays where it is.
    let here = place(&planner, 2);
    let [pan, tilt, roll] = [0, 1, 2].map(|axis| here["turned_deg"][axis].clone());
    let same = json!({ "position_m": here["at_m"], "pan_deg": pan, "tilt_deg": tilt, "roll_deg": roll });
    let again =
        planner.post("/edit", json!({ "edit": "move", "index": 1, "at": same, "moment": 2, "gesture": 2 }));
    assert_eq!(again["placed"], state["placed"]);
    let unsaid = json!({ "edit": "move", "index": 1, "at": at });
    let words = planner.refused("/edit", unsaid, 400);
    assert_eq!(words, "robot/tool0 carries the sensor: say at which moment it is moved");
    let words =
        planner.refused("/edit", json!({ "edit": "set_sensor", "index": 1, "sensor": "camera" }), 400);
    assert_eq!(
        words,
        "\"hand camera\" is on robot/tool0 and \"camera\" in the world: delete the one and add the other"
    );
    planner.post("/save", json!({ "overwrite": false }));
    planner.end();
    let saved = fs::read_to_string(&study).unwrap();
    assert!(saved.contains("on = { object = \"robot\", link = \"tool0\" }"), "{saved}");
    let out = folder.path("out");
    let outcome = perirobot(&["sweep", text(&study), "--out", text(&out), "--backend", "oracle"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert_eq!(shown, swept(&out));
}
