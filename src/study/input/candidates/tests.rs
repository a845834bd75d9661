use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::input::{Overrides, Study};

const SCENE: &str = r#"
[[object]]
name = "table"
box = { size_m = [1, 1, 0.1] }
position_m = [2, 0, 0.7]
[[object]]
name = "robot"
role = "robot"
box = { size_m = [0.2, 0.2, 0.8] }
position_m = [1, 0, 0.4]
[[object]]
name = "hand"
box = { size_m = [0.1, 0.1, 0.1] }
position_m = [1.5, 0.2, 1.0]
rpy_deg = [0, 0, 30]
[object.snapshots]
position_m = [[1.5, 0.2, 1.0], [1.5, 0.2, 1.2]]
dwell_s = [30, 10]
[[object]]
name = "operator"
role = "human"
cylinder = { radius_m = 0.2, height_m = 1.7 }
position_m = [0, 1, 0.85]
"#;

const STUDY: &str = r#"
[[scene]]
file = "a.toml"
[[scene]]
file = "b.toml"
[[candidate]]
object = "robot"
with = ["hand"]
x_m = [0, 1]
y_m = 3
turn_deg = { start = 0, stop = 90, step = 90 }
[[candidate]]
object = "operator"
x_m = [5.25]
y_m = -1
z_m = [0.85, 1.85]
[[region]]
name = "human"
human_box = { object = "operator", margin_m = 0.2 }
[[region]]
name = "fixed"
sphere = { center_m = [0, 0, 0], radius_m = 1 }
[[sensor]]
name = "camera"
kind = "rgbd"
fov_deg = [87, 58]
resolution_px = [16, 9]
range_m = [0.2, 3.0]
[[sensor.poses]]
name = "one"
list = [{ name = "a", position_m = [0, 0, 2], facing = [1, 0, 0] }]
"#;

fn read(study: &str) -> Result<Study, perirobot_march::Error> {
    let folder: TempDir = tempfile::tempdir().unwrap();
    let mapped = "[[object]]\nname = \"operator\"\nrole = \"human\"\noctomap = \"map.bt\"\n[[object]]\nname = \"robot\"\nbox = { size_m = [1, 1, 1] }\n";
    for (name, scene) in [
        ("a.toml", SCENE),
        ("b.toml", SCENE),
        ("empty.toml", SCENE.split("[[object]]\nname = \"hand\"").next().unwrap()),
        ("map.toml", mapped),
    ] {
        fs::write(folder.path().join(name), scene).unwrap();
    }
    fs::write(folder.path().join("study.toml"), study).unwrap();
    Study::load(&folder.path().join(Path::new("study.toml")), &Overrides::default())
}

#[test]
fn each_choice_of_places_is_a_scene() {
    let study = read(STUDY).unwrap();
    let names: Vec<&str> = study.scenes.iter().map(|scene| scene.name.as_str()).collect();
    // Two x, one y, two turns; times two heights of the operator; in two scenes.
    assert_eq!(names.len(), 16);
    assert_eq!(names[0], "a@robot/0/3/0+operator/5.25/-1/0.85/0");
    assert_eq!(names[7], "a@robot/1/3/90+operator/5.25/-1/1.85/0");
    assert_eq!(names[8], "b@robot/0/3/0+operator/5.25/-1/0.85/0");
    let object = |scene: usize, name: &str| {
        study.scenes[scene].objects.iter().find(|o| o.name == name).unwrap().clone()
    };
    let near =
        |a: glam::DVec3, b: [f64; 3]| assert!((a - glam::DVec3::from_array(b)).length() < 1e-12, "{a} {b:?}");
    near(object(0, "robot").position_m, [0.0, 3.0, 0.4]);
    near(object(7, "robot").position_m, [1.0, 3.0, 0.4]);
    near(object(1, "operator").position_m, [5.25, -1.0, 1.85]);
    near(object(0, "table").position_m, [2.0, 0.0, 0.7]);
    // The hand is at (0.5, 0.2) beside the robot; a quarter turn puts it at (−0.2, 0.5).
    near(object(0, "hand").position_m, [0.5, 3.2, 1.0]);
    near(object(7, "hand").position_m, [0.8, 3.5, 1.0]);
    near(object(7, "hand").motion.position_m[1], [0.8, 3.5, 1.2]);
    let turned = object(7, "hand").rotation * glam::DVec3::X;
    let (sin, cos) = 120f64.to_radians().sin_cos();
    near(turned, [cos, sin, 0.0]);
    // And it lasts as long as before.
    assert_eq!(study.scenes[7].dwell_s, Some(vec![30.0, 10.0]));
    let stays: Vec<&String> =
        study.warnings.iter().filter(|text| text.contains("stays where it is")).collect();
    assert!(stays.len() == 1 && stays[0].contains("region \"fixed\""), "{:?}", study.warnings);
}

#[test]
fn what_cannot_be_placed_is_refused_by_key() {
    let cases = [
        (
            "object = \"robot\"",
            "object = \"robo\"",
            "candidate \"robo\".object = \"robo\": must be an object of a scene",
        ),
        ("with = [\"hand\"]", "with = [\"foot\"]", "with = \"foot\": must be an object"),
        ("object = \"operator\"\nx_m", "object = \"robot\"\nx_m", "candidate objects"),
        ("x_m = [0, 1]", "x_m = []", "candidate \"robot\".x_m = []: must be at least one number"),
        ("x_m = [0, 1]", "x_m = [0, 0]", "two places are named \"robot/0/3/0\""),
        ("x_m = [0, 1]", "x_m = { start = 0, stop = 200, step = 0.01 }", "more than 10000 places"),
        ("x_m = [0, 1]", "x_m = { start = 0, stop = 40, step = 0.01 }", "more than 10000 scenes"),
        ("b.toml", "empty.toml", "scene \"empty\" has no object \"operator\""),
        ("b.toml", "map.toml", "\"operator\" is an octomap"),
        ("y_m = 3\n", "", "y_m"),
    ];
    for (from, to, expected) in cases {
        assert!(STUDY.contains(from), "{from}");
        let said = read(&STUDY.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(said.contains(expected) && said.contains("study.toml"), "no {expected:?} in {said}");
    }
}
