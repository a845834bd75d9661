//! A pane before a camera, a mirror behind a wall, and a reflector that only a scanner sees.

use std::path::Path;

use super::*;
use crate::input::Overrides;

const STUDY: &str = r#"
[grid]
voxel_size_m = 0.1
[[scene]]
file = "cell.toml"
[[region]]
name = "all"
box = { min_m = [-1, -1, 0], max_m = [1, 1, 2] }
[[sensor]]
name = "camera"
kind = "rgbd"
fov_deg = [60, 40]
resolution_px = [32, 24]
range_m = [0.3, 4]
[[sensor.poses]]
name = "p"
list = [
  { position_m = [-1.5, 0, 1], facing = [1, 0, 0] },
  { position_m = [-1.5, 0, 1], facing = [-1, 0, 0] },
]
[[sensor]]
name = "scanner"
kind = "lidar"
fov_deg = 360
beams = 720
rings_deg = [0]
range_m = [0.1, 5]
poses = [{ name = "p", list = [{ position_m = [0, 1.5, 0.31], facing = [1, 0, 0] }] }]
"#;

const SCENE: &str = r#"
[[object]]
name = "hall"
room = { size_m = [4, 4, 2.4] }
position_m = [0, 0, 1.2]
[[object]]
name = "pane"
surface = "glass"
plane = { size_m = [1, 1] }
position_m = [0, 0, 1]
rpy_deg = [0, 90, 0]
[[object]]
name = "wall"
box = { size_m = [0.1, 4, 2.4] }
position_m = [1, 0, 1.2]
[[object]]
name = "mirror"
surface = "mirror"
plane = { size_m = [1, 1] }
position_m = [1.5, 0, 1]
rpy_deg = [0, 90, 0]
[[object]]
name = "vest"
surface = "retroreflector"
box = { size_m = [0.1, 0.1, 0.5] }
position_m = [-1, 1.6, 0.3]
"#;

fn warnings_of(scene: &str) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cell.toml"), scene).unwrap();
    let path = folder.path().join("study.toml");
    std::fs::write(&path, STUDY).unwrap();
    let study = Study::load(Path::new(&path), &Overrides::default()).unwrap();
    let world = World::prepare(&study, 0).unwrap().swap_remove(0);
    let told = warnings(&study, &world);
    assert!(told.iter().all(|line| world.warnings.contains(line)));
    told
}

#[test]
fn sensors_that_look_at_a_surface_are_named() {
    let told = warnings_of(SCENE);
    for (line, expected) in told.iter().zip([
        "sensor \"camera\": 1 of 2 poses look at \"pane\" (first p/0",
        "sensor \"scanner\": 1 of 1 poses look at \"vest\" (first p/0",
    ]) {
        assert!(line.starts_with(expected), "{line}");
    }
    assert_eq!(told.len(), 2, "{told:?}");
    assert!(told[0].contains("surface = \"glass\": a stereo camera measures"), "{}", told[0]);
    assert!(told[1].contains("surface = \"retroreflector\": people near it"), "{}", told[1]);
    // Glass that rays pass is told, and so is what is behind it.
    let through = SCENE
        .replace("surface = \"glass\"", "surface = \"glass\"\noptical = \"see_through\"")
        .replace("size_m = [0.1, 4, 2.4]", "size_m = [0.1, 0.1, 0.1]");
    let through = warnings_of(&through);
    assert!(
        through.iter().any(|line| line.contains("\"camera\": 1 of 2 poses look at \"mirror\"")),
        "{through:?}"
    );
    assert!(
        through.iter().any(|line| line.contains("\"camera\": 1 of 2 poses look at \"pane\"")),
        "{through:?}"
    );
}

#[test]
fn plain_surfaces_say_nothing() {
    let plain: Vec<&str> = SCENE.lines().filter(|line| !line.starts_with("surface")).collect();
    assert_eq!(warnings_of(&plain.join("\n")), [""; 0]);
}
