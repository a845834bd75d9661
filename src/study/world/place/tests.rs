use std::fs;

use super::*;
use crate::input::Overrides;

/// A room of 6 m x 4 m x 3 m whose floor is 0.5 m below the world's origin, with a bench, a beam and a column
/// in it.
const SCENE: &str = r#"interior = "free"
[[object]]
name = "hall"
room = { size_m = [6, 4, 3] }
position_m = [0, 0, 1]
[[object]]
name = "bench"
box = { size_m = [1, 1, 0.8] }
position_m = [1, 0, -0.1]
[[object]]
name = "beam"
box = { size_m = [0.2, 2, 0.2] }
position_m = [-1, 0, 1.5]
[[object]]
name = "column"
box = { size_m = [0.4, 0.4, 2.8] }
position_m = [-2, 0.5, 1]
[[object]]
name = "robot"
urdf = "robot.urdf"
position_m = [1, 0, 0.5]
[[object]]
name = "operator"
role = "human"
box = { size_m = [0.4, 0.4, 1.7] }
position_m = [-0.5, -1, 0.45]
"#;

const ROBOT: &str = r#"<robot name="robot"><link name="wrist_3"><collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision>
</link></robot>"#;

const HEAD: &str = r#"[grid]
voxel_size_m = 0.1
[[scene]]
file = "cell.toml"
[[region]]
name = "all"
box = { min_m = [-1, -1, 0], max_m = [1, 1, 1] }
"#;

/// The places of a camera's poses, or of another sensor that comes first in the text.
fn places_of(sensor: &str) -> Vec<String> {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    write("cell.toml", SCENE);
    write("robot.urdf", ROBOT);
    write("study.toml", &format!("{HEAD}{sensor}"));
    let study = Study::load(&folder.path().join("study.toml"), &Overrides::default()).unwrap();
    let worlds = World::prepare_all(&study).unwrap();
    let places = Places::new(&study, &worlds[0]);
    (0..study.sensors[0].candidates.len()).map(|candidate| places.words(0, candidate)).collect()
}

/// A camera with some keys and poses.
fn camera(keys: &str, poses: &str) -> Vec<String> {
    places_of(&format!(
        "[[sensor]]\nname = \"camera\"\nkind = \"rgbd\"\nfov_deg = [87, 58]\nresolution_px = [4, 3]\nrange_m = [0.2, 3]\n{keys}\n\
         [[sensor.poses]]\n{poses}"
    ))
}

#[test]
fn a_wall_is_called_as_its_group() {
    let words = camera(
        "",
        "name = \"South wall\"\nx_m = [-1, 0.25]\ny_m = -1.8\nz_m = 1.75\nfacing = [0, 1, 0]\n\
         orientations_deg = [{ pan = 0, tilt = -30 }, { pan = 20, tilt = 0 }]",
    );
    assert_eq!(
        words,
        [
            "south wall, x -1.0 m, 2.25 m high, 30° down",
            "south wall, x -1.0 m, 2.25 m high, pan 110°, level",
            "south wall, x 0.25 m, 2.25 m high, 30° down",
            "south wall, x 0.25 m, 2.25 m high, pan 110°, level",
        ]
    );
    // In the corner of two walls the group still says which it is; a wall across x is told by y.
    let west = camera(
        "",
        "name = \"west wall\"\nx_m = -2.9\ny_m = [-1.9, 1.0]\nz_m = 1.5\nfacing = [1, 0, 0]\n\
         orientations_deg = [{ pan = 0, tilt = 12.25 }]",
    );
    assert_eq!(
        west,
        ["west wall, y -1.9 m, 2.0 m high, 12.2° up", "west wall, y 1.0 m, 2.0 m high, 12.2° up"]
    );
}

#[test]
fn ceilings_and_floors_are_called_as_their_group() {
    let words = camera(
        "",
        "name = \"ceiling\"\nx_m = 0.5\ny_m = [-1, 0]\nz_m = 2.4\nfacing = [0, 0, -1]\n\
         orientations_deg = [{ pan = 0, tilt = 0 }, { pan = 90, tilt = 0 }]",
    );
    assert_eq!(words[0], "ceiling, x 0.5 m, y -1.0 m, 2.9 m high, straight down");
    assert_eq!(words[1], "ceiling, x 0.5 m, y -1.0 m, 2.9 m high, pan 90°, straight down");
    let pads = places_of(
        "[[sensor]]\nname = \"pads\"\nkind = \"pad\"\nsize_m = [0.5, 0.5]\nheight_m = 1\n[[sensor.poses]]\nname = \"floor\"\n\
         list = [{ position_m = [0, 1, -0.5] }, { position_m = [0, 1, -0.5], pan_deg = 30 }]\n",
    );
    assert_eq!(pads, ["floor, x 0.0 m, y 1.0 m, 0.0 m high", "floor, x 0.0 m, y 1.0 m, 0.0 m high, pan 30°"]);
}

#[test]
fn else_it_is_what_stands_next_to_it() {
    let at = |position: &str, facing: &str| {
        let list = format!("name = \"spots\"\nlist = [{{ position_m = {position}, facing = {facing} }}]");
        camera("", &list).swap_remove(0)
    };
    let words = [
        at("[0, -1.75, 1]", "[0, 1, 0]"),
        at("[2.8, 0, 1]", "[-1, 0, 0]"),
        at("[0.5, 1.5, 2.35]", "[0, 0, -1]"),
        at("[0.5, 1.5, -0.35]", "[0, 0, 1]"),
        at("[1, 0, 0.45]", "[-1, 0, 0]"),
        at("[-1, 0, 1.3]", "[0, 1, 0]"),
        at("[-1.7, 0.5, 1]", "[1, 0, 0]"),
        at("[0, 0.5, 1]", "[1, 1, 0]"),
    ];
    assert_eq!(
        words,
        [
            "wall at -y, x 0.0 m, 1.5 m high, level",
            "wall at +x, y 0.0 m, 1.5 m high, level",
            "ceiling, x 0.5 m, y 1.5 m, 2.85 m high, straight down",
            "floor, x 0.5 m, y 1.5 m, 0.15 m high, straight up",
            "on bench, x 1.0 m, y 0.0 m, 0.95 m high, pan 180°, level",
            "under beam, x -1.0 m, y 0.0 m, 1.8 m high, pan 90°, level",
            "at column, x -1.7 m, y 0.5 m, 1.5 m high, pan 0°, level",
            "free-standing, x 0.0 m, y 0.5 m, 1.5 m high, pan 45°, level",
        ]
    );
}

#[test]
fn on_a_robot_it_is_the_link() {
    let words = camera(
        "on = { object = \"robot\", link = \"wrist_3\" }\nnear_ignore_m = 0.2",
        "name = \"hand\"\nlist = [{ position_m = [0, -0.1, 0.1], facing = [1, 0, 0], tilt_deg = -10 }, \
         { position_m = [0, 0, 0.2], rpy_deg = [90, 0, 0] }]",
    );
    assert_eq!(
        words,
        [
            "on the robot's wrist_3 (in its frame x 0.0 m, y -0.1 m, z 0.1 m, pan 0°, tilt -10°)",
            "on the robot's wrist_3 (in its frame x 0.0 m, y 0.0 m, z 0.2 m, pan 0°, tilt 0°, roll 90°)",
        ]
    );
    let cover = "[[sensor]]\nname = \"skin\"\nkind = \"cover\"\ninflation_m = [0.1, 0.25]\n";
    assert_eq!(places_of(cover), ["on the robot, senses up to 0.1 m", "on the robot, senses up to 0.25 m"]);
    assert_eq!(places_of("[[sensor]]\nname = \"known\"\nkind = \"known_robot\"\n"), [""]);
}

#[test]
fn what_stands_upright_has_no_direction_to_speak_of() {
    let lidar = places_of(
        "[[sensor]]\nname = \"lidar\"\nkind = \"lidar\"\nfov_deg = [360, 30]\nresolution_deg = 10\nrange_m = [0.1, 5]\n\
         [[sensor.poses]]\nname = \"posts\"\nlist = [{ position_m = [0, 0.5, 1], facing = [1, 0, 0] }, \
         { position_m = [0, 0.5, 1], facing = [1, 0, 0], pan_deg = -45 }]\n",
    );
    assert_eq!(
        lidar,
        [
            "free-standing, x 0.0 m, y 0.5 m, 1.5 m high, level",
            "free-standing, x 0.0 m, y 0.5 m, 1.5 m high, pan -45°, level",
        ]
    );
}

#[test]
fn a_surface_of_the_study_is_what_it_is_on() {
    let on = |object: &str, more: &str| {
        camera(
            "",
            &format!("name = \"wall mounts\"\nsurface = {{ object = \"{object}\", spacing_m = 2, {more} }}"),
        )
    };
    assert_eq!(
        on("beam", "off_m = 0.4, sides = [\"-x\", \"-z\"]"),
        [
            "on beam (-x side), x -1.5 m, y 0.0 m, 2.0 m high, pan 180°, level",
            "on beam (underside), x -1.0 m, y 0.0 m, 1.5 m high, straight down",
        ]
    );
    assert_eq!(on("bench", "sides = [\"+z\"]"), ["on bench, x 1.0 m, y 0.0 m, 0.85 m high, straight up"]);
    assert_eq!(
        on("hall", "sides = [\"-x\", \"-z\"], margin_m = 2"),
        [
            "wall at +x, y 0.0 m, 1.5 m high, level",
            "ceiling, x -1.0 m, y 0.0 m, 2.95 m high, straight down",
            "ceiling, x 1.0 m, y 0.0 m, 2.95 m high, straight down",
        ]
    );
}
