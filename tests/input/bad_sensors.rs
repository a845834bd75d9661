//! What a user can get wrong about sensors, combinations and noise: each is refused with exit code 2 before
//! any ray is cast, in a message that names the file, the key and, where there is one, the value and the
//! cure.

use crate::common::program::{self, Edit, Folder, refused};

const STUDY: &str = "study.toml";
const SCENE: &str = "cell.toml";

/// A study of all kinds of sensors in the small scene, whose arm is a robot with a link and whose operator
/// has joints.
const SENSORS: &str = r#"repeats = 2
[grid]
voxel_size_m = 0.1
[[scene]]
file = "cell.toml"
[[region]]
name = "robot"
sphere = { center_m = [0.2, 0.3, 0.4], radius_m = 0.6 }
[[sensor]]
name = "camera"
kind = "rgbd"
fov_deg = [87, 58]
resolution_px = [16, 9]
range_m = [0.2, 3.0]
noise = { std_m = 0.01 }
representations = ["points", "spheres", "cylinders", "box"]
spheres_radius_m = 0.2
cylinders_radius_m = 0.25
keypoint_tolerance_m = 0.15
[[sensor.poses]]
name = "wall"
x_m = [-1.0, 0, 1]
y_m = -0.75
z_m = 1.2
facing = [0, 1, 0]
[[sensor]]
name = "watch"
kind = "rgb"
fov_deg = [80, 60]
resolution_px = [16, 9]
range_m = [0.2, 4.0]
zone = { min_m = [-1, -1, 0], max_m = [1, 1, 1] }
min_keypoints = 2
otherwise = "free"
same_poses_as = "camera"
[[sensor]]
name = "scanner"
kind = "lidar"
rings_deg = [0]
resolution_deg = 4
range_m = [0.1, 4.5]
noise = { std_m = 0.02 }
representations = ["points", "field"]
field = { polygon_m = [[0, -0.5], [1, -0.5], [1, 0.5], [0, 0.5]], height_m = 1.0 }
[[sensor.poses]]
name = "post"
list = [{ position_m = [-0.9, 0, 0.35], facing = [1, 0, 0] }]
[[sensor]]
name = "ring"
kind = "rays"
directions = "ring.csv"
range_m = [0.1, 2.5]
on = { object = "machine", link = "flange" }
[[sensor.poses]]
name = "ring"
list = [{ position_m = [0, 0, 0.2], facing = [1, 0, 0] }]
[[sensor]]
name = "pads"
kind = "pad"
size_m = [0.4, 0.3]
height_m = 1.5
[[sensor.poses]]
name = "floor"
x_m = [-0.5, 0]
y_m = -0.6
z_m = 0
[[sensor]]
name = "gate"
kind = "gate"
box = { min_m = [-0.8, -0.8, 0.1], max_m = [-0.6, 0.8, 1] }
zone = { min_m = [-0.6, -0.8, 0.15], max_m = [1, 0.8, 1] }
[[sensor]]
name = "cover"
kind = "cover"
inflation_m = [0.1, 0.2]
noise = { std_m = 0.03 }
[[sensor]]
name = "known"
kind = "known_robot"
[[combination]]
name = "both"
sensors = ["camera", "pads", "cover", "known"]
fusion = "octomap"
poses = { camera = ["wall/?/0"], cover = ["0.1"] }
"#;

const RING: &str = "x,y,z\n1,0,0\n0,0.5,0\n";

/// 17 rows, the first of which is known.
fn joints() -> String {
    "0,0,0.6\n".to_string() + &",,\n".repeat(16)
}

const ROBOT: &str = r#"<robot name="machine"><link name="base"><collision><geometry><box size="0.2 0.2 0.2"/></geometry>
</collision></link><link name="flange"/><joint name="turn" type="fixed"><parent link="base"/><child link="flange"/>
<origin xyz="0 0 0.3"/></joint></robot>"#;

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write(STUDY, SENSORS);
    folder.write("ring.csv", RING);
    folder.write("joints.csv", joints());
    folder.write("machine.urdf", ROBOT);
    folder.edit(SCENE, "role = \"human\"", "role = \"human\"\nkeypoints = \"joints.csv\"");
    folder.edit(
        SCENE,
        "",
        "[[object]]\nname = \"machine\"\nurdf = \"machine.urdf\"\nposition_m = [-0.4, -0.3, 0.4]\n",
    );
    folder
}

/// The good study with these edits must be refused in words that hold all of `expected`.
#[track_caller]
fn check(edits: &[Edit], expected: &[&str]) {
    refused(&folder(), edits, expected);
}

#[test]
fn the_study_they_start_from_is_good() {
    let folder = folder();
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    for word in ["both", "points;volume;naive;volume", "box;volume"] {
        let results = std::fs::read_to_string(folder.path("out/results.csv")).unwrap();
        assert!(results.contains(word), "{word}");
    }
}

#[test]
fn each_kind_has_keys_of_its_own() {
    for (key, sensor) in [
        ("resolution_deg = 1", "camera"),
        ("noise = { std_m = 0.1 }", "watch"),
        ("representations = [\"zone\"]", "watch"),
        ("resolution_px = [8, 8]", "scanner"),
        ("fov_deg = [80, 60]", "ring"),
        ("range_m = [0, 1]", "pads"),
        ("noise = { std_m = 0.1 }", "gate"),
        ("tare = true", "gate"),
        ("size_m = [1, 1]", "cover"),
        ("range_m = [0, 1]", "cover"),
        ("noise = { std_m = 0.1 }", "known"),
        ("pose = []", "known"),
        ("calibration = { angle_deg = 1 }", "pads"),
        ("dropout = 0.1", "cover"),
        ("dropout = 0.1", "watch"),
    ] {
        let name = format!("name = \"{sensor}\"\n");
        let unknown = format!("unknown field `{}`", key.split(' ').next().unwrap());
        let edit = format!("{name}{key}\n");
        check(
            &[(STUDY, &name, &edit)],
            &[STUDY, &format!("sensor \"{sensor}\""), &unknown, "poses with every sensor"],
        );
    }
    for (from, to, expected) in [
        (
            "kind = \"gate\"",
            "kind = \"curtain\"",
            "unknown variant `curtain`, expected one of `rgbd`, `rgb`, `lidar`, `rays`",
        ),
        ("kind = \"gate\"", "", "missing field `kind`, as in kind = \"rgbd\""),
        ("size_m = [0.4, 0.3]", "", "sensor \"pads\": missing field `size_m`, as in size_m = [1, 0.75]"),
        (
            "inflation_m = [0.1, 0.2]",
            "inflation_m = 0.1",
            "`inflation_m` (line 75), as in inflation_m = [0.1, 0.2]",
        ),
        ("directions = \"ring.csv\"", "", "missing field `directions`, as in directions = \"rays.csv\""),
        (
            "box = { min_m = [-0.8, -0.8, 0.1], max_m = [-0.6, 0.8, 1] }",
            "",
            "missing field `box`, as in box = {",
        ),
        ("zone = { min_m = [-1, -1, 0], max_m = [1, 1, 1] }", "", "missing field `zone`, as in zone = {"),
    ] {
        check(&[(STUDY, from, to)], &[STUDY, expected]);
    }
    check(
        &[(STUDY, "size_m = [0.4, 0.3]", "size_m = [0.4, 0.3]\ntare = 1")],
        &[STUDY, "sensor \"pads\": found 1, wanted true or false in `tare`"],
    );
}

#[test]
fn sensors_of_unknown_noise_are_not_compared_with_others_unasked() {
    let unknown = (STUDY, "noise = { std_m = 0.01 }", "noise = \"unknown\"");
    let told = "the noise of sensor \"camera\" is unknown and that of sensor \"scanner\" is not, so they cannot be compared: \
                give \"camera\" noise = { std_m = ... }, or write mixed_noise = true at the top of the study";
    check(&[unknown], &[STUDY, told]);
    // A device of the catalogue whose noise nobody knows.
    let device = (STUDY, "kind = \"lidar\"\nrings_deg = [0]\n", "model = \"sick-s300\"\nrings_deg = [0]\n");
    let own = (STUDY, "noise = { std_m = 0.02 }\nrepresentations", "representations");
    check(
        &[device, own],
        &[STUDY, "the noise of sensor \"scanner\" is unknown and that of sensor \"camera\" is not"],
    );
    for (edits, arguments) in [
        (vec![unknown], vec!["--noiseless"]),
        (vec![unknown, (STUDY, "repeats = 2", "repeats = 2\nmixed_noise = true")], vec![]),
        (
            vec![unknown, (STUDY, "noise = { std_m = 0.02 }", ""), (STUDY, "noise = { std_m = 0.03 }", "")],
            vec![],
        ),
    ] {
        let folder = folder();
        edits.iter().for_each(|(file, from, to)| folder.edit(file, from, to));
        let outcome = folder.sweep(&arguments);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    }
}

#[test]
fn a_mount_that_is_off_may_not_leave_bounds_that_are_given() {
    let bounds = (STUDY, "[grid]", "[grid]\nbounds_m = { min = [-1.3, -0.9, 0], max = [1.3, 0.9, 1.4] }");
    let off = (STUDY, "noise = { std_m = 0.01 }", "calibration = { position_m = 1 }");
    check(
        &[bounds, off],
        &[
            STUDY,
            "sensor \"camera\": pose wall/",
            "(where its calibration puts it",
            "is outside grid.bounds_m",
        ],
    );
}

#[test]
fn numbers_and_choices() {
    for (from, to, expected) in [
        ("repeats = 2", "repeats = 0", "repeats = 0: must be from 1 to 10000"),
        ("repeats = 2", "repeats = 10001", "repeats = 10001: must be from 1 to 10000"),
        ("repeats = 2", "repeats = -1", "repeats"),
        (
            "noise = { std_m = 0.01 }",
            "noise = { std_m = -0.01 }",
            "sensor \"camera\".noise.std_m = -0.01: must be a length",
        ),
        (
            "noise = { std_m = 0.01 }",
            "noise = { std_m = nan }",
            "sensor \"camera\".noise.std_m = NaN: must be a length",
        ),
        (
            "noise = { std_m = 0.01 }",
            "noise = { std_m = inf }",
            "sensor \"camera\".noise.std_m = inf: must be a length",
        ),
        (
            "noise = { std_m = 0.03 }",
            "noise = { std_m = -1 }",
            "sensor \"cover\".noise.std_m = -1: must be a length",
        ),
        (
            "noise = { std_m = 0.02 }",
            "noise = { std_m = -1 }",
            "sensor \"scanner\".noise.std_m = -1: must be a length",
        ),
        (
            "range_m = [0.1, 2.5]",
            "range_m = [0.1, 2.5]\nnoise = { std_m = nan }",
            "sensor \"ring\".noise.std_m = NaN",
        ),
        (
            "noise = { std_m = 0.01 }",
            "noise_std_m = 0.01",
            "sensor \"camera\".noise_std_m = 0.01: is written noise = { std_m = 0.01 } now",
        ),
        (
            "noise = { std_m = 0.03 }",
            "noise_std_m = 0.03",
            "sensor \"cover\".noise_std_m = 0.03: is written noise = { std_m = 0.03 } now",
        ),
        (
            "noise = { std_m = 0.01 }",
            "noise = {}",
            "sensor \"camera\".noise: give at least one of std_m, per_m and per_m2, as in noise = { std_m = 0.02 }",
        ),
        (
            "noise = { std_m = 0.01 }",
            "noise = { std = 0.01 }",
            "sensor \"camera\": unknown field `std`, expected one of `std_m`, `per_m`, `per_m2`",
        ),
        (
            "noise = { std_m = 0.01 }",
            "noise = 0.01",
            "found 0.01, wanted { std_m, per_m, per_m2 }, as in noise = { std_m = 0.02 }, or \"unknown\"",
        ),
        ("noise = { std_m = 0.01 }", "noise = \"none\"", "found \"none\", wanted { std_m"),
        (
            "noise = { std_m = 0.01 }",
            "noise = { per_m = -0.1 }",
            "sensor \"camera\".noise.per_m = -0.1: must be metres of deviation for a metre of distance, from 0 to 1",
        ),
        (
            "noise = { std_m = 0.01 }",
            "noise = { per_m2 = 2 }",
            "sensor \"camera\".noise.per_m2 = 2: must be metres of deviation for a square metre, from 0 to 1",
        ),
        (
            "noise = { std_m = 0.01 }",
            "noise = { std_m = 1, per_m2 = 0.5 }",
            "sensor \"camera\".noise: is 5.5 m at 3 m, which must be at most the distance itself",
        ),
        (
            "noise = { std_m = 0.03 }",
            "noise = { std_m = 0.03, per_m = 0.1 }",
            "sensor \"cover\".noise: a cover has the same noise at all distances: give std_m only",
        ),
        (
            "noise = { std_m = 0.01 }",
            "dropout = 1",
            "sensor \"camera\".dropout = 1: must be the share of returns that is lost, from 0 to below 1",
        ),
        ("noise = { std_m = 0.01 }", "dropout = -0.1", "sensor \"camera\".dropout = -0.1: must be the share"),
        (
            "noise = { std_m = 0.01 }",
            "calibration = {}",
            "sensor \"camera\".calibration: give position_m, angle_deg or both, as in calibration = { position_m = 0.01",
        ),
        (
            "min_keypoints = 2",
            "calibration = { position_m = -1 }",
            "sensor \"watch\".calibration.position_m = -1: must be a standard deviation in metres, from 0 to 1",
        ),
        (
            "range_m = [0.1, 2.5]",
            "range_m = [0.1, 2.5]\ncalibration = { angle_deg = 90 }",
            "sensor \"ring\".calibration.angle_deg = 90: must be a standard deviation in degrees, from 0 to 30",
        ),
        (
            "[\"points\", \"spheres\", \"cylinders\", \"box\"]",
            "[]",
            "sensor \"camera\": no representations: add",
        ),
        (
            "\"cylinders\", \"box\"]",
            "\"box\", \"spheres\"]",
            "sensor \"camera\": representations[3] is there already",
        ),
        (
            "\"cylinders\", \"box\"]",
            "\"cubes\"]",
            "unknown variant `cubes`, expected one of `points`, `spheres`",
        ),
        ("[\"points\", \"field\"]", "[]", "sensor \"scanner\": no representations: add"),
        (
            "rings_deg = [0]\nresolution_deg = 4",
            "rings_deg = [0]",
            "sensor \"scanner\": neither resolution_deg nor beams: give the step",
        ),
        (
            "resolution_deg = 4",
            "resolution_deg = 4\nbeams = 90",
            "sensor \"scanner\".beams = 90: and resolution_deg: give one of them",
        ),
        (
            "resolution_deg = 4",
            "resolution_deg = 4\nrings = 3",
            "\"scanner\".rings = 3: and rings_deg: give one",
        ),
        (
            "rings_deg = [0]\nresolution_deg = 4",
            "elevation_deg = [-5, 5]\nresolution_deg = [4, 1]\nrings = 3",
            "\"scanner\".rings = 3: and a vertical resolution_deg",
        ),
        (
            "rings_deg = [0]\nresolution_deg = 4",
            "elevation_deg = [-5, 5]\nbeams = 90",
            "\"scanner\": neither rings nor a vertical step",
        ),
        (
            "rings_deg = [0]\nresolution_deg = 4",
            "elevation_deg = [-5, 5]\nbeams = 90\nrings = 1",
            "\"scanner\".rings = 1: must be from 2 to",
        ),
        (
            "keypoint_tolerance_m = 0.15",
            "range_along = \"depth\"",
            "unknown variant `depth`, expected `ray` or `axis`",
        ),
        (
            "[\"points\", \"field\"]",
            "[\"field\", \"field\"]",
            "representations[1] is there already: name each once",
        ),
        ("field = {", "#", "sensor \"scanner\": representation \"field\" needs field = { polygon_m"),
        (
            "spheres_radius_m = 0.2",
            "spheres_radius_m = 0",
            "sensor \"camera\".spheres_radius_m = 0: must be a length",
        ),
        (
            "cylinders_radius_m = 0.25",
            "cylinders_radius_m = nan",
            "sensor \"camera\".cylinders_radius_m = NaN",
        ),
        (
            "keypoint_tolerance_m = 0.15",
            "keypoint_tolerance_m = -1",
            "sensor \"camera\".keypoint_tolerance_m = -1",
        ),
        (
            "min_keypoints = 2",
            "min_keypoints = 0",
            "sensor \"watch\".min_keypoints = 0: must be from 1 to 17",
        ),
        (
            "min_keypoints = 2",
            "min_keypoints = 18",
            "sensor \"watch\".min_keypoints = 18: must be from 1 to 17",
        ),
        (
            "max_m = [1, 1, 1]",
            "max_m = [1, -1, 1]",
            "sensor \"watch\".zone.max_m = [1.0, -1.0, 1.0]: must be above min_m",
        ),
        (
            "max_m = [-0.6, 0.8, 1]",
            "max_m = [-0.9, 0.8, 1]",
            "sensor \"gate\".box.max_m = [-0.9, 0.8, 1.0]: must be above",
        ),
        (
            "max_m = [1, 0.8, 1]",
            "max_m = [1, 0.8, 0]",
            "sensor \"gate\".zone.max_m = [1.0, 0.8, 0.0]: must be above",
        ),
        (
            "max_m = [1, 0.8, 1]",
            "max_m = [1, nan, 1]",
            "sensor \"gate\".zone.max_m = [1.0, NaN, 1.0]: must be three numbers",
        ),
        ("max_m = [1, 0.8, 1]", "max_m = [1, 1]", "a list of 3 numbers"),
        (
            "inflation_m = [0.1, 0.2]",
            "inflation_m = []",
            "sensor \"cover\": no inflation_m: add at least one",
        ),
        (
            "inflation_m = [0.1, 0.2]",
            "inflation_m = [0.1, 0]",
            "sensor \"cover\".inflation_m = 0: must be lengths above 0",
        ),
        (
            "inflation_m = [0.1, 0.2]",
            "inflation_m = [0.1, nan]",
            "sensor \"cover\".inflation_m = NaN: must be lengths",
        ),
        (
            "inflation_m = [0.1, 0.2]",
            "inflation_m = [0.1, 0.1]",
            "sensor \"cover\".inflation_m = 0.1: stands twice",
        ),
        (
            "inflation_m = [0.1, 0.2]",
            "inflation_m = [0.1, 100]",
            "sensor \"cover\".inflation_m = 100: must be lengths",
        ),
        ("size_m = [0.4, 0.3]", "size_m = [0.4, 0]", "sensor \"pads\".size_m = 0: must be a length"),
        ("height_m = 1.5", "height_m = -1", "sensor \"pads\".height_m = -1: must be a length"),
        ("height_m = 1.0", "height_m = 0", "sensor \"scanner\".field.height_m = 0: must be a length"),
        (
            "otherwise = \"free\"",
            "otherwise = \"safe\"",
            "unknown variant `safe`, expected `unknown` or `free`",
        ),
        (
            "range_m = [0.1, 2.5]",
            "range_m = [2.5, 0.1]",
            "sensor \"ring\".range_m = [2.5, 0.1]: must be [nearest, farthest]",
        ),
    ] {
        check(&[(STUDY, from, to)], &[STUDY, expected]);
    }
}

#[test]
fn fields_bound_one_area() {
    let square = "[[0, -0.5], [1, -0.5], [1, 0.5], [0, 0.5]]";
    for (polygon, expected) in [
        (
            "[[0, -0.5], [1, 0.5], [1, -0.5], [0, 0.5]]",
            "edges that begin at corners 0 and 2 (counted from 0) cross or touch",
        ),
        ("[[0, -0.5], [1, -0.5], [1, -0.5], [0, 0.5]]", "cross or touch: go around the area once"),
        ("[[0, -0.5], [1, -0.5]]", "2 corners bound no area: give at least 3"),
        ("[]", "0 corners bound no area"),
        ("[[0, -0.5], [1, -0.5], [nan, 0.5]]", "field.polygon_m = NaN: must be [x, y] in metres"),
        (
            "[[0, -500], [1, -5000], [1, 0.5]]",
            "field.polygon_m = -5000: must be [x, y] in metres within 1000",
        ),
        ("[[0, -0.5, 0], [1, -0.5, 0], [1, 0.5, 0]]", "polygon_m"),
    ] {
        check(&[(STUDY, square, polygon)], &[STUDY, "sensor \"scanner\"", "polygon_m", expected]);
    }
    check(
        &[(STUDY, square, "[[0.01, 0.01], [0.02, 0.01], [0.02, 0.02]]")],
        &[STUDY, "scene \"cell\"", "sensor \"scanner\": post/0 has a field without a voxel"],
    );
}

#[test]
fn sensors_that_do_not_fit_the_scene() {
    let floor = "x_m = [-0.5, 0]";
    check(
        &[(STUDY, floor, "x_m = [-0.5, 0.95]")],
        &[
            STUDY,
            "scene \"cell\"",
            "sensor \"pads\": floor/1/0 lies partly outside the floor",
            "make it smaller",
        ],
    );
    check(
        &[(STUDY, "height_m = 1.5", "height_m = 0.01")],
        &[STUDY, "sensor \"pads\": floor/0/0 has no layer", "height_m"],
    );
    check(
        &[(STUDY, "max_m = [1, 1, 1]", "max_m = [-0.99, 1, 1]")],
        &[STUDY, "sensor \"watch\": wall/0/0 zone: its volume holds no voxel of the grid: make it larger"],
    );
    check(
        &[(STUDY, "max_m = [-0.6, 0.8, 1]", "max_m = [-0.79, 0.8, 1]")],
        &[STUDY, "sensor \"gate\": here box: its volume holds no voxel of the grid: make it larger"],
    );
    // Coordinates as far as a file may say overflow nothing.
    let far = "min_m = [-1000000, -1000000, -1000000], max_m = [1000000, 1000000, 1000000]";
    let folder = folder();
    folder.edit(STUDY, "min_m = [-0.6, -0.8, 0.15], max_m = [1, 0.8, 1]", far);
    folder.edit(STUDY, "min_m = [-1, -1, 0], max_m = [1, 1, 1]", far);
    assert_eq!(folder.sweep(&[]).code, Some(0));
    let nobody: [Edit; 2] = [
        (SCENE, "role = \"robot\"", ""),
        (SCENE, "name = \"machine\"", "name = \"machine\"\nrole = \"environment\""),
    ];
    let cure = "no voxel of the scene is the robot's: give its object role = \"robot\"";
    check(&nobody, &[STUDY, "scene \"cell\"", "sensor \"cover\": 0.1", cure]);
    let known = [
        &nobody[..],
        &[(
            STUDY,
            "kind = \"cover\"\ninflation_m = [0.1, 0.2]\nnoise = { std_m = 0.03 }",
            "kind = \"known_robot\"",
        )],
    ]
    .concat();
    check(
        &[&known[..], &[(STUDY, ", cover = [\"0.1\"]", "")]].concat(),
        &[STUDY, "sensor \"cover\": known", cure],
    );
}

#[test]
fn people_and_their_joints() {
    let none = (SCENE, "keypoints = \"joints.csv\"", "");
    let human = "human \"operator\" has none: give it keypoints = \"joints.csv\" in the scene file";
    check(
        &[none],
        &[
            STUDY,
            "scene \"cell\"",
            "sensor \"camera\": wall/0/0 representation \"spheres\" needs keypoints",
            human,
        ],
    );
    let points = (STUDY, "\"points\", \"spheres\", \"cylinders\", \"box\"", "\"points\"");
    check(&[none, points], &[STUDY, "sensor \"watch\": wall/0/0 needs keypoints", human]);
    for (rows, expected) in [(16, "16"), (18, "18"), (0, "0")] {
        let folder = folder();
        folder.write("joints.csv", "0,0,0.6\n".repeat(rows));
        refused(&folder, &[], &["joints.csv", expected, "17"]);
    }
    check(&[(SCENE, "joints.csv", "gone.csv")], &["gone.csv", "cannot be read"]);
}

#[test]
fn where_sensors_stand() {
    for (from, to, expected) in [
        (
            "same_poses_as = \"camera\"",
            "same_poses_as = \"camra\"",
            "sensor \"watch\".same_poses_as = \"camra\": must be a sensor above it that has poses: [\"camera\"]",
        ),
        (
            "same_poses_as = \"camera\"",
            "same_poses_as = \"scanner\"",
            "same_poses_as = \"scanner\": must be a sensor above it",
        ),
        (
            "same_poses_as = \"camera\"",
            "same_poses_as = \"watch\"",
            "same_poses_as = \"watch\": must be a sensor above it",
        ),
        ("same_poses_as = \"camera\"", "", "sensor \"watch\": no poses: add at least one"),
        (
            "same_poses_as = \"camera\"",
            "same_poses_as = \"camera\"\n[[sensor.poses]]\nname = \"x\"",
            "both poses and same_poses_as",
        ),
        (
            "kind = \"cover\"",
            "kind = \"cover\"\nsame_poses_as = \"camera\"",
            "sensor \"cover\": poses do not belong to a cover: take them away",
        ),
        (
            "kind = \"known_robot\"",
            "kind = \"known_robot\"\n[[sensor.poses]]\nname = \"x\"",
            "sensor \"known\": poses do not belong to a known_robot",
        ),
        (
            "kind = \"cover\"",
            "kind = \"cover\"\non = { object = \"machine\", link = \"base\" }",
            "sensor \"cover\": on does not belong to a cover",
        ),
        (
            "object = \"machine\"",
            "object = \"arm\"",
            "sensor \"ring\": on: object = \"arm\": must be a robot with links, an object with urdf = ...; scene \"cell\" has [\"machine\"]",
        ),
        (
            "object = \"machine\"",
            "object = \"gone\"",
            "sensor \"ring\": on: object = \"gone\": must be a robot with links",
        ),
        ("link = \"flange\"", "link = \"hand\"", "sensor \"ring\": on: link = \"hand\""),
        (", link = \"flange\"", "", "missing field `link`"),
    ] {
        check(&[(STUDY, from, to)], &[STUDY, expected]);
    }
    check(&[(STUDY, "link = \"flange\"", "link = \"hand\"")], &["base", "flange"]);
    // A gate that stands nowhere has no poses to take over.
    let last = "kind = \"rgbd\"\nfov_deg = [9, 9]\nresolution_px = [1, 1]\nrange_m = [0, 1]\nsame_poses_as = \"gate\"\n";
    check(
        &[(STUDY, "[[combination]]", &format!("[[sensor]]\nname = \"late\"\n{last}[[combination]]"))],
        &[
            STUDY,
            "same_poses_as = \"gate\": must be a sensor above it that has poses: [\"camera\", \"watch\"",
        ],
    );
}

#[test]
fn tables_of_rays() {
    for (table, expected) in [
        ("x,y,z\n1,0,0\n0,0,0\n", "row 2: 0,0,0: must be a direction, finite and not zero"),
        ("x,y,z\n1,nan,0\n", "row 1: 1,NaN,0: must be a direction"),
        ("x,y,z\n1,inf,0\n", "row 1: 1,inf,0: must be a direction"),
        ("x,y\n1,0\n", "missing field `z`"),
        ("x,y,z\n1,0\n", "the columns are x,y,z"),
        ("x,y,z\n1,0,up\n", "the columns are x,y,z"),
        ("1,0,0\n0,1,0\n", "missing field `x`"),
        ("x,y,z\n", "holds 0 rays"),
        ("", "holds 0 rays"),
    ] {
        let folder = folder();
        folder.write("ring.csv", table);
        refused(&folder, &[], &[STUDY, "sensor \"ring\": directions: ", "ring.csv: ", expected]);
    }
    check(
        &[(STUDY, "ring.csv", "gone.csv")],
        &[STUDY, "sensor \"ring\": directions", "gone.csv", "cannot be read"],
    );
}

#[test]
fn combinations() {
    let sensors = "sensors = [\"camera\", \"pads\", \"cover\", \"known\"]";
    for (from, to, expected) in [
        (sensors, "sensors = []", "combination \"both\": no sensors: add at least one"),
        (
            sensors,
            "sensors = [\"camera\", \"cover\", \"pad\"]",
            "combination \"both\".sensors = \"pad\": must be sensors of the study: [\"camera\", \"watch\"",
        ),
        (
            sensors,
            "sensors = [\"camera\", \"cover\", \"camera\"]",
            "combination \"both\".sensors = \"camera\": stands twice",
        ),
        (sensors, "", "missing field `sensors`"),
        (
            "camera = [\"wall/?/0\"]",
            "camera = [\"ceiling/*\"]",
            "combination \"both\".poses.camera = \"ceiling/*\": names no pose; those of \"camera\" are like \"wall/0/0\"",
        ),
        (
            "camera = [\"wall/?/0\"]",
            "camera = [\"wall/0/0\", \"wall/9/0\"]",
            "poses.camera = \"wall/9/0\": names no pose",
        ),
        ("camera = [\"wall/?/0\"]", "camera = []", "combination \"both\".poses: no camera: add at least one"),
        (
            "camera = [\"wall/?/0\"]",
            "watch = [\"wall/?/0\"]",
            "combination \"both\".poses = \"watch\": is not among its sensors",
        ),
        (
            "cover = [\"0.1\"]",
            "cover = [\"0.3\"]",
            "poses.cover = \"0.3\": names no pose; those of \"cover\" are like \"0.1\"",
        ),
        (
            "fusion = \"octomap\"",
            "fusion = \"vote\"",
            "unknown variant `vote`, expected `occupied_wins` or `octomap`",
        ),
        ("fusion = \"octomap\"", "fuse = \"octomap\"", "unknown field `fuse`"),
        ("repeats = 2", "repeats = 2\nfusion = \"vote\"", "unknown variant `vote`"),
        (
            "[[combination]]",
            "[[combination]]\nname = \"both\"\nsensors = [\"pads\"]\n[[combination]]",
            "two combinations are named \"both\"",
        ),
        ("name = \"both\"\n", "name = \"\"\n", "one of the combinations has an empty name"),
    ] {
        check(&[(STUDY, from, to)], &[STUDY, expected]);
    }
}

#[test]
fn too_many_representations_together() {
    // 13 sensors of one pose and 4 representations each: 4¹³ names would have to be kept.
    let names: Vec<String> = (0..13).map(|n| format!("c{n}")).collect();
    let sensor = |name: &String| {
        format!(
            "[[sensor]]\nname = \"{name}\"\nkind = \"rgbd\"\nfov_deg = [60, 40]\nresolution_px = [2, 2]\nrange_m = [0.2, 3]\n\
             representations = [\"points\", \"spheres\", \"cylinders\", \"box\"]\nspheres_radius_m = 0.2\n\
             cylinders_radius_m = 0.2\n\
             [[sensor.poses]]\nname = \"p\"\nlist = [{{ position_m = [0, 0, 1], facing = [1, 0, 0] }}]\n"
        )
    };
    let sensors: String = names.iter().map(sensor).collect();
    let together = format!("[[combination]]\nname = \"crowd\"\nsensors = {names:?}\n");
    program::refused(
        &program::Folder::new(),
        &[("study.toml", "", &(sensors + &together))],
        &["combination \"crowd\": 67108864 choices of a representation for each sensor are too many"],
    );
}

#[test]
fn what_stands_otherwise_or_too_often() {
    for (from, to, expected) in [
        // Far from all surfaces, and not stretching the grid to where it lies.
        ("x_m = [-0.5, 0]", "x_m = [-8, 0]", "sensor \"pads\": floor/0/0 lies partly outside the floor"),
        (
            "x_m = [-0.5, 0]\ny_m = -0.6\nz_m = 0\n",
            "list = [{ position_m = [0, 0, 0], rpy_deg = [180, 0, 0] }]\n",
            "sensor \"pads\": floor/0 is tilted",
        ),
        (
            "[[sensor.poses]]\nname = \"post\"\nlist = [{ position_m = [-0.9, 0, 0.35], facing = [1, 0, 0] }]\n",
            "same_poses_as = \"camera\"\n",
            "sensor \"scanner\": same_poses_as: \"camera\" is not mounted as a lidar is",
        ),
        (
            "representations = [\"points\", \"field\"]",
            "representations = [\"points\"]",
            "sensor \"scanner\": field is given and not among the representations",
        ),
        (
            "facing = [1, 0, 0] }]\n[[sensor]]\nname = \"ring\"",
            "facing = [0, 0, -1] }]\n[[sensor]]\nname = \"ring\"",
            "facing is straight up or down",
        ),
        (
            "noise = { std_m = 0.01 }",
            "noise = { std_m = 10 }",
            "sensor \"camera\".noise.std_m = 10: must be a length in metres from 0 to 3",
        ),
        ("name = \"pads\"", "name = \"pads;2\"", "\"pads;2\": names of sensors and poses hold no semicolon"),
    ] {
        check(&[(STUDY, from, to)], &[STUDY, expected]);
    }
    let all = (STUDY, "wall/?/0", "wall/*");
    let many = (STUDY, "x_m = [-1.0, 0, 1]", "x_m = { start = -1, stop = 1, step = 0.0001 }");
    let often = (STUDY, "repeats = 2", "repeats = 10000");
    check(
        &[all, many, often],
        &[STUDY, "combination \"both\": 40002 choices of poses in 4 representations, each 10000 times"],
    );
    // The camera's 2,000,001 poses are the watch's, too.
    let more = (STUDY, "x_m = [-1.0, 0, 1]", "x_m = { start = -1, stop = 1, step = 0.000001 }");
    check(
        &[more],
        &[STUDY, "sensor \"watch\": same_poses_as: with these, the study has more than 4000000 poses"],
    );
}
