//! Curtains, mats and fields that are moved and resized: counted as a sweep of the saved study counts them.

use std::fs;

use serde_json::json;

use crate::common::program::{Folder, perirobot, text};
use crate::planner::Planner;
use crate::saved::{shown, swept};

const SENSORS: &str = r#"
[[sensor]]
name = "curtain"
kind = "gate"
box = { min_m = [-0.3, -0.8, 0], max_m = [0.5, -0.6, 1.4] }   # in the south
zone = { min_m = [-0.3, -0.6, 0], max_m = [0.5, 0, 1.4] }

[[sensor]]
name = "mat"
model = "safety-mat"
size_m = [0.4, 0.3]
[[sensor.poses]]
name = "floor"
list = [{ position_m = [-0.9, -0.7, 0], facing = [1, 0, 0] }]

[[sensor]]
name = "scanner"
model = "sick-nanoscan3"
field = { polygon_m = [[0, -0.2], [0.5, -0.2], [0.5, 0.2], [0, 0.2]], height_m = 1 }
[[sensor.poses]]
name = "wall"
list = [{ position_m = [-0.9, 0.5, 0.3], facing = [1, 0, 0] }]
"#;

#[test]
fn a_sweep_of_the_saved_study_counts_shapes_as_the_page_did() {
    let folder = Folder::new();
    folder.edit("study.toml", "", SENSORS);
    let study = folder.path("study.toml");
    let planner = Planner::start(text(&study), &["--backend", "cpu"]);
    let state = planner.get("/state");
    assert_eq!(state["problems"], json!([]));
    let sensors = state["sensors"].as_array().unwrap();
    let sensor = |name: &str| sensors.iter().find(|sensor| sensor["name"] == name).unwrap();
    let corners = |min_m: [f64; 3], max_m: [f64; 3]| json!({ "min_m": min_m, "max_m": max_m });
    assert_eq!(
        sensor("curtain")["shape"],
        json!({ "shape": "gate", "box": corners([-0.3, -0.8, 0.0], [0.5, -0.6, 1.4]),
                "zone": corners([-0.3, -0.6, 0.0], [0.5, 0.0, 1.4]) })
    );
    assert_eq!((&sensor("curtain")["is_fixed"], &sensor("mat")["is_fixed"]), (&json!(true), &json!(false)));
    assert_eq!(sensor("mat")["shape"], json!({ "shape": "pad", "size_m": [0.4, 0.3] }));
    let field = [[0.0, -0.2], [0.5, -0.2], [0.5, 0.2], [0.0, 0.2]];
    assert_eq!(sensor("scanner")["shape"], json!({ "shape": "field", "polygon_m": field }));
    assert_eq!(sensor("camera")["shape"], json!(null));
    for (sensor, pose) in [("curtain", "here"), ("mat", "floor/0"), ("scanner", "wall/0")] {
        planner.post("/edit", json!({ "edit": "place", "sensor": sensor, "pose": pose }));
    }
    let mut before = shown(&planner, &planner.get("/state"));
    for (edit, worlds) in [
        (
            json!({ "sensor": "curtain", "shape": "gate", "box": corners([-0.15, -0.75, 0.0], [0.45, -0.4, 1.4]),
                    "zone": corners([-0.3, -0.4, 0.0], [0.4, 0.1, 1.3]) }),
            0,
        ),
        (json!({ "sensor": "mat", "shape": "pad", "size_m": [0.7, 0.4496] }), 0),
        (
            json!({ "sensor": "scanner", "shape": "field",
                    "polygon_m": [[0.0, -0.2], [0.7, -0.3], [0.5, 0.2], [0.0, 0.2]] }),
            0,
        ),
    ] {
        let known = planner.get("/state")["worlds"].as_u64().unwrap();
        let mut edit = edit;
        edit["edit"] = json!("set_sensor_shape");
        let state = planner.post("/edit", edit);
        assert_eq!(state["worlds"], known + worlds, "the scene is as it was");
        let now = shown(&planner, &state);
        assert_ne!(now, before, "{}", state["version"]);
        before = now;
    }
    planner.post("/save", json!({ "overwrite": false }));
    planner.end();
    let saved = fs::read_to_string(&study).unwrap();
    for line in [
        "box = { min_m = [-0.15, -0.75, 0], max_m = [0.45, -0.4, 1.4] }   # in the south",
        "zone = { min_m = [-0.3, -0.4, 0], max_m = [0.4, 0.1, 1.3] }",
        "size_m = [0.7, 0.45]",
        "field = { polygon_m = [[0, -0.2], [0.7, -0.3], [0.5, 0.2], [0, 0.2]], height_m = 1 }",
    ] {
        assert!(saved.contains(line), "{line}\n{saved}");
    }
    let out = folder.path("out");
    let outcome = perirobot(&["sweep", text(&study), "--out", text(&out), "--backend", "oracle"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert_eq!(before, swept(&out));
}
