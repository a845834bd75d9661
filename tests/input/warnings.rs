//! Input that is accepted with an assumption: the program runs, exits with 0, and says what it assumed of
//! what.

use crate::common::program::{Folder, STUDY, perirobot, refused, text};

/// The good study with these edits, `(file, from, to)`, must run and warn in words that hold all of
/// `expected`.
#[track_caller]
fn check(folder: &Folder, edits: &[(&str, &str, &str)], expected: &[&str]) {
    let before = warnings(folder);
    for (file, from, to) in edits {
        folder.edit(file, from, to);
    }
    let after = warnings(folder);
    let new: Vec<_> = after.iter().filter(|line| !before.contains(line)).collect();
    let holds = |line: &&&String| expected.iter().all(|fragment| line.contains(fragment));
    assert!(new.iter().any(|line| holds(&line)), "no line with {expected:?} in {new:#?}");
}

/// The warnings of a sweep that succeeds, which the manifest must hold too.
#[track_caller]
fn warnings(folder: &Folder) -> Vec<String> {
    let outcome = folder.sweep(&["--restart"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let warnings: Vec<_> = outcome.stderr.lines().filter_map(|line| line.strip_prefix("warning: ")).collect();
    let manifest = std::fs::read(folder.path("out").join("manifest.json")).unwrap();
    let manifest: serde_json::Value = serde_json::from_slice(&manifest).unwrap();
    let recorded = manifest["about"]["warnings"].as_array().unwrap();
    let recorded: Vec<_> = recorded.iter().map(|w| w.as_str().unwrap().to_string()).collect();
    assert_eq!(warnings, recorded);
    recorded
}

/// A closed box of text STL, ± half on each axis, less its first `left_out` triangles.
fn stl_box(half: [f64; 3], left_out: usize) -> String {
    let corner =
        |i: usize| -> [f64; 3] { std::array::from_fn(|r| if i >> r & 1 == 1 { half[r] } else { -half[r] }) };
    let faces = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = faces.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let mut text = String::from("solid box\n");
    for triangle in triangles.skip(left_out) {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in triangle.map(corner) {
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    text + "endsolid box\n"
}

const BOUNDS: (&str, &str, &str) =
    ("study.toml", "[grid]", "[grid]\nbounds_m = { min = [-1.2, -0.9, 0], max = [1.2, 0.9, 1.6] }");

#[test]
fn a_sensor_inside_an_occupied_voxel() {
    let edit = ("study.toml", "position_m = [0.1, 0.1, 1.3]", "position_m = [0.75, 0.4, 0.45]");
    let expected = [
        "sensor \"lidar\": 1 poses (first posts/corner: on crate, x 0.75 m, y 0.4 m, 0.45 m high, ",
        ") stand in an occupied voxel",
        "behind its surface",
    ];
    check(&Folder::new(), &[edit], &expected);
}

#[test]
fn a_mount_that_is_drawn_once() {
    let off = "range_m = [0.1, 5.0]\ncalibration = { position_m = 0.01 }";
    let edit = ("study.toml", "range_m = [0.1, 5.0]", off);
    let expected = ["sensor \"lidar\": of its calibration one mount is drawn for each pose", "repeats = 10"];
    check(&Folder::new(), &[edit], &expected);
    let folder = Folder::new();
    folder.edit("study.toml", "range_m = [0.1, 5.0]", off);
    folder.edit("study.toml", "seed = 7", "seed = 7\nrepeats = 2");
    let outcome = folder.sweep(&[]);
    assert!(outcome.code == Some(0) && !outcome.stderr.contains("of its calibration"), "{}", outcome.stderr);
}

#[test]
fn a_sensor_inside_a_closed_body_is_dead() {
    let edits = [
        ("study.toml", "position_m = [0.1, 0.1, 1.3]", "position_m = [0.7, 0.4, 0.25]"),
        ("cell.toml", "box = {", "interior = \"ignored\"\nbox = {"),
    ];
    let expected = ") is dead: it stands inside \"crate\", in a hollow of";
    check(
        &Folder::new(),
        &edits,
        &["sensor \"lidar\": pose posts/corner (", expected, "that no ray leaves: move it out"],
    );
    // Whatever its inside is.
    check(&Folder::new(), &edits[..1], &[expected]);
    let solid = ("cell.toml", "box = {", "interior = \"occupied\"\nbox = {");
    let nowhere = ") is dead: it stands inside \"crate\", where no ray goes";
    check(&Folder::new(), &[edits[0], solid], &[nowhere]);
}

/// Whether the LIDAR's last pose, at this place, is called dead beside these objects.
fn corner_is_dead(place: &str, study: [&str; 2], scene: [&str; 2]) -> bool {
    let folder = Folder::new();
    folder.edit("study.toml", "position_m = [0.1, 0.1, 1.3]", &format!("position_m = {place}"));
    // In a group of its own, so that no line is about several poses.
    let alone = "]\n[[sensor.poses]]\nname = \"alone\"\nlist = [\n    { name = \"corner\"";
    folder.edit("study.toml", "    { name = \"corner\"", alone);
    folder.edit("study.toml", study[0], study[1]);
    folder.edit("cell.toml", scene[0], scene[1]);
    warnings(&folder).iter().any(|w| w.contains("pose alone/corner (") && w.contains(") is dead: "))
}

#[test]
fn what_looks_out_of_a_closed_body_or_at_somebody_in_it_is_not_dead() {
    let (in_crate, as_it_is) = ("[0.7, 0.4, 0.25]", ["", ""]);
    assert!(corner_is_dead(in_crate, as_it_is, as_it_is));
    // The crate is its housing.
    let range = "range_m = [0.1, 5.0]";
    assert!(!corner_is_dead(in_crate, [range, "range_m = [0.1, 5.0]\nnear_ignore_m = 0.4"], as_it_is));
    // The crate is not always there.
    let goes = "snapshots = { position_m = [[0.7, 0.4, 0.25], [-0.3, 0.4, 0.25]] }";
    assert!(!corner_is_dead(in_crate, as_it_is, ["position_m = [0.7, 0.4, 0.25]", goes]));
    let stays = "snapshots = { position_m = [[0.7, 0.4, 0.25], [0.7, 0.45, 0.25]] }";
    assert!(corner_is_dead(in_crate, as_it_is, ["position_m = [0.7, 0.4, 0.25]", stays]));
    // A cabinet with a person in it, or the robot, or nobody.
    let cabinet = |at: &str| {
        format!("[[object]]\nname = \"cabinet\"\nbox = {{ size_m = [0.6, 0.6, 1.4] }}\nposition_m = {at}\n")
    };
    for (lidar, cabinet_at, dead) in [
        ("[0.3, -0.25, 1.0]", "[0.1, -0.45, 0.75]", false),
        ("[0.35, 0.45, 1.0]", "[0.2, 0.3, 0.75]", false),
        ("[-0.7, 0.5, 1.0]", "[-0.7, 0.5, 0.75]", true),
    ] {
        assert_eq!(corner_is_dead(lidar, as_it_is, ["", &cabinet(cabinet_at)]), dead, "{cabinet_at}");
    }
}

#[test]
fn a_sensor_inside_a_person_is_dead() {
    let (chest, as_it_is) = ("[0.1, -0.45, 0.7]", ["", ""]);
    for range in ["range_m = [0.1, 5.0]", "range_m = [0, 5.0]"] {
        assert!(corner_is_dead(chest, ["range_m = [0.1, 5.0]", range], as_it_is), "{range}");
    }
}

/// People go away; whoever stands before a sensor kills no pose.
#[test]
fn a_person_before_a_sensor_is_something_in_range() {
    let range = ["range_m = [0.1, 5.0]", "range_m = [0.24, 0.25]"];
    let before_the_operator = "[0.35, -0.45, 1.0]";
    assert!(!corner_is_dead(before_the_operator, range, ["", ""]));
    assert!(corner_is_dead(
        before_the_operator,
        range,
        ["position_m = [0.1, -0.45,", "position_m = [-0.6, 0.3,"]
    ));
}

#[test]
fn lengths_beyond_all_reason_are_told() {
    let edit = ("study.toml", "near_ignore_m = 0.05", "near_ignore_m = 2.5");
    check(&Folder::new(), &[edit], &["sensor \"camera\": near_ignore_m = 2.5: is more than 2 m meant?"]);
}

#[test]
fn a_mesh_in_millimetres() {
    let folder = Folder::new();
    folder.write("crate.stl", stl_box([200.0, 200.0, 200.0], 0));
    let ball = "sphere = { radius_m = 0.12 }";
    let edits = [BOUNDS, ("cell.toml", ball, "mesh = \"crate.stl\"")];
    check(&folder, &edits, &["object \"ball\" is 400 m long", "unit = \"mm\""]);
    // The cure works.
    folder.edit("cell.toml", "mesh =", "unit = \"mm\"\nmesh =");
    assert!(!warnings(&folder).iter().any(|w| w.contains("ball")));
}

#[test]
fn an_object_of_less_than_a_voxel() {
    let edit = |mm: &str| {
        let folder = Folder::new();
        folder.edit(
            "cell.toml",
            "sphere = { radius_m = 0.12 }",
            &format!("box = {{ size_m = [{mm}, 0.01, 0.01] }}"),
        );
        warnings(&folder).into_iter().filter(|w| w.contains("ball")).collect::<Vec<_>>()
    };
    let [told] = &edit("0.0812")[..] else { panic!("one warning") };
    assert!(
        told.contains("object \"ball\" is 81.2 mm long, less than a voxel: is its unit right?"),
        "{told}"
    );
    assert_eq!(edit("0.101"), Vec::<String>::new());
}

#[test]
fn a_part_beside_which_all_others_are_tiny() {
    let folder = Folder::new();
    folder.write("knob.stl", stl_box([15.0, 15.0, 10.0], 0));
    let ball = "sphere = { radius_m = 0.12 }";
    let edits = [BOUNDS, ("cell.toml", ball, "mesh = \"knob.stl\"")];
    let expected = ["object \"ball\" is 30.0 m long, and no other is longer than 2.4 m", "unit = \"mm\""];
    check(&folder, &edits, &expected);
    folder.edit("cell.toml", "mesh =", "unit = \"mm\"\nmesh =");
    assert!(!warnings(&folder).iter().any(|w| w.contains("is 30.0 m long")));
    // What is written in metres is meant so, and a hall may stand beside something long.
    let quiet = |surface: &str, more: &str| {
        let folder = Folder::new();
        folder.write("knob.stl", stl_box([15.0, 15.0, 10.0], 0));
        folder.edit(BOUNDS.0, BOUNDS.1, BOUNDS.2);
        folder.edit("cell.toml", ball, &format!("{surface}\n{more}"));
        !warnings(&folder).iter().any(|w| w.contains("is its file in millimetres"))
    };
    assert!(quiet("box = { size_m = [30, 30, 20] }", ""));
    assert!(quiet("mesh = \"knob.stl\"", "[[object]]\nname = \"rail\"\nbox = { size_m = [7, 0.3, 0.3] }"));
}

/// A forklift of 2.4 m in centimetres: both cures are told with their lengths, and the wrong one is noticed.
#[test]
fn a_mesh_in_centimetres() {
    let folder = Folder::new();
    folder.write("forklift.stl", stl_box([120.0, 60.0, 60.0], 0));
    let ball = "sphere = { radius_m = 0.12 }";
    let hall = ("cell.toml", "room = { size_m = [2.4, 1.8, 1.6] }", "room = { size_m = [12, 12, 1.6] }");
    folder.edit(hall.0, hall.1, hall.2);
    folder.edit("cell.toml", ball, "mesh = \"forklift.stl\"");
    folder.edit("cell.toml", "position_m = [-0.7, -0.5, 0.3]", "position_m = [-4, -4, 0.65]");
    let told = |folder: &Folder| {
        let said = folder.sweep(&["--restart"]).stderr;
        said.lines().filter(|line| line.contains("\"ball\"")).map(String::from).collect::<Vec<_>>()
    };
    let both = "(unit = \"mm\" beside mesh makes it 0.24 m) or in centimetres (unit = \"cm\": 2.40 m)?";
    let [line] = &told(&folder)[..] else { panic!("{:?}", told(&folder)) };
    assert!(line.contains(both), "{line}");
    folder.edit("cell.toml", "mesh =", "unit = \"mm\"\nmesh =");
    let [line] = &told(&folder)[..] else { panic!("{:?}", told(&folder)) };
    let trifle = "object \"ball\" is 0.24 m long by unit = \"mm\", in a cell of 12.0 m: is its file in centimetres (unit = \"cm\": 2.40 m)?";
    assert!(line.contains(trifle), "{line}");
    folder.edit("cell.toml", "unit = \"mm\"", "unit = \"cm\"");
    assert_eq!(told(&folder), [""; 0]);
}

#[test]
fn a_pose_in_centimetres() {
    let high = ("study.toml", "position_m = [0.1, 0.1, 1.3]", "position_m = [0.1, 0.1, 90]");
    let told = "are outside all surfaces of the scene: its position looks like centimetres, and metres are wanted: \
                z 90 cm are 0.9 m, which is inside the cell";
    check(&Folder::new(), &[high], &["sensor \"lidar\": 1 poses (first posts/corner: ", told]);
    // One pose, one line.
    let folder = Folder::new();
    folder.edit(high.0, high.1, high.2);
    assert_eq!(warnings(&folder).iter().filter(|line| line.contains("posts/corner")).count(), 1);
    // Where it is too far for a grid, the error says so.
    let far = ("study.toml", "position_m = [0.1, 0.1, 1.3]", "position_m = [0.1, 0.1, 130]");
    refused(
        &Folder::new(),
        &[far],
        &["stretches the grid", "it looks like centimetres", "z 130 cm are 1.3 m"],
    );
}

#[test]
fn a_leaky_mesh_asked_to_be_solid() {
    let folder = Folder::new();
    let ball = "sphere = { radius_m = 0.12 }";
    folder.write("crate.stl", stl_box([0.25; 3], 1));
    let edit = ("cell.toml", ball, "interior = \"occupied\"\nmesh = \"crate.stl\"");
    check(&folder, &[edit], &["object \"ball\" is not watertight", "kept as a shell, not filled"]);
    // The whole box is filled without a word.
    folder.write("crate.stl", stl_box([0.25; 3], 0));
    assert!(!warnings(&folder).iter().any(|w| w.contains("ball")));
}

#[test]
fn a_region_that_the_grid_cuts() {
    let edit = ("study.toml", "max_m = [0.5,", "max_m = [2.9,");
    // What is behind a wall, or below the floor, is no loss.
    let closed = Folder::new();
    closed.edit(edit.0, edit.1, edit.2);
    assert_eq!(warnings(&closed), [""; 0]);
    let floor = [
        ("cell.toml", "room = { size_m = [2.4, 1.8, 1.6] }", "plane = { size_m = [2.4, 1.8] }"),
        ("cell.toml", "position_m = [0, 0, 0.8]", "position_m = [0, 0, 0]"),
    ];
    let share = "% of it lies outside the grid (towards +x) and is not counted";
    let cure = ": if nobody can be there, leave it as it is; else set bounds_m of [grid], or make the region smaller there";
    check(&Folder::new(), &[&floor[..], &[edit]].concat(), &["region \"box\"", share, cure]);
    // A person's box has a margin, and the bounds are there already.
    let margin = ("study.toml", "margin_m = 0.2", "margin_m = 0.4");
    let cure = "; else widen bounds_m of [grid], or take a smaller margin_m";
    let expected = ["region \"human\"", "grid (towards -y) and", cure];
    check(&Folder::new(), &[&floor[..], &[BOUNDS, margin]].concat(), &expected);
}

#[test]
fn an_object_outside_the_bounds() {
    let edits = [BOUNDS, ("cell.toml", "position_m = [-0.7, -0.5, 0.3]", "position_m = [9, 0, 0]")];
    check(&Folder::new(), &edits, &["object \"ball\" lies outside the grid"]);
}

#[test]
fn a_person_lying_along_y() {
    let folder = Folder::new();
    folder.write("person.stl", stl_box([0.2, 0.8, 0.2], 0));
    let cylinder = "cylinder = { radius_m = 0.15, height_m = 1.2 }\nposition_m = [0.1, -0.45, 0.65]";
    let edit = ("cell.toml", cylinder, "mesh = \"person.stl\"\nposition_m = [0.1, 0, 0.8]");
    check(&folder, &[edit], &["object \"operator\" is 1.60 m along y and 0.40 m high", "up = \"y\""]);
    folder.edit("cell.toml", "mesh =", "up = \"y\"\nmesh =");
    // The LIDAR is inside a person of that size.
    let of_operator = |w: &&String| w.contains("operator") && !w.contains("it stands inside \"operator\"");
    assert_eq!(warnings(&folder).iter().find(of_operator), None);
}

#[test]
fn a_hull_whose_inside_is_ignored() {
    let edits = [
        ("cell.toml", "interior = \"free\"", ""),
        ("cell.toml", "room = {", "interior = \"ignored\"\nbox = {"),
    ];
    let cure = "a hull that is the room itself needs interior = \"free\"";
    let alone = |edits: &[(&str, &str, &str)], expected: &str| {
        let folder = Folder::new();
        // A pose in a body, and nobody in the cell, which would be told without the hull.
        folder.edit("study.toml", "position_m = [0.1, 0.1, 1.3]", "position_m = [0.75, 0.4, 0.45]");
        edits.iter().for_each(|(file, from, to)| folder.edit(file, from, to));
        let stderr = folder.sweep(&[]).stderr;
        let said: Vec<&str> = stderr.lines().filter(|line| line.contains("warning: ")).collect();
        assert!(said.len() == 1 && said[0].contains(expected) && said[0].contains(cure), "{said:#?}");
        let outcome = perirobot(&["check", text(&folder.path("study.toml")), "--backend", "cpu"]);
        assert!(outcome.stdout.contains("\nno errors; 1 warning above\nnext: "), "{}", outcome.stdout);
    };
    // The regions are outside the hull, since all else would belong to none.
    let outside =
        |from: &'static str| ("study.toml", from, "min_m = [-1.2, -0.9, 0], max_m = [-1.1, -0.8, 0.1]");
    let occupied = ("cell.toml", "room = {", "interior = \"occupied\"\nbox = {");
    alone(&[edits[0], occupied], "object \"walls\" fills 100 % of the grid by interior = \"occupied\": ");
    let regions = [
        outside("min_m = [-0.5, -0.5, 0.1], max_m = [0.5, 0.5, 1.1]"),
        (
            "study.toml",
            "sphere = { center_m = [0.2, 0.3, 0.4], radius_m = 0.6 }",
            "box = { min_m = [-2, -2, -1], max_m = [2, 2, 2] }",
        ),
    ];
    alone(&[&edits[..], &regions].concat(), "object \"walls\" is around ");
}

#[test]
fn nobody_in_the_cell() {
    let edits = [
        ("cell.toml", "role = \"human\"", ""),
        (
            "study.toml",
            "human_box = { object = \"operator\", margin_m = 0.2 }",
            "sphere = { center_m = [0, 0, 1], radius_m = 0.3 }",
        ),
    ];
    check(
        &Folder::new(),
        &edits,
        &[
            "no object has role = \"human\"",
            "human_seen, human_claimed, people_detected and parts_detected have no value",
        ],
    );
}

#[test]
fn a_scanner_whose_field_holds_a_wall_is_told() {
    let scanner = "[[sensor]]\nname = \"scanner\"\nkind = \"lidar\"\nrings_deg = [0]\nresolution_deg = 4\nrange_m = [0.1, 9]\n\
                   noise = { std_m = 0.02 }\nfield = { polygon_m = [[0, -0.2], [FAR, -0.2], [FAR, 0.2], [0, 0.2]], height_m = 1 }\n\
                   [[sensor.poses]]\nname = \"post\"\nlist = [{ position_m = [0.3, 0.3, 0.7], facing = [0, 1, 0] }]\n";
    let told = |far: &str| {
        let folder = Folder::new();
        folder.write("study.toml", format!("{STUDY}{}", scanner.replace("FAR", far)));
        warnings(&folder).iter().any(|w| w.contains("sensor \"scanner\": the environment alone trips 1 of 1"))
    };
    assert!(told("4"), "the wall is in it");
    assert!(!told("0.2"), "nothing is");
}

#[test]
fn poses_outside_the_cell_are_told() {
    let folder = Folder::new();
    assert!(!warnings(&folder).iter().any(|w| w.contains("outside all surfaces")), "none is");
    folder.edit("study.toml", "y_m = -0.75", "y_m = -3");
    assert!(warnings(&folder).iter().any(|w| w.contains("are outside all surfaces of the scene")));
}

#[test]
fn a_gate_that_the_floor_trips_is_told() {
    let gate = "[[sensor]]\nname = \"gate\"\nkind = \"gate\"\nbox = { min_m = [-0.2, -0.5, LOW], max_m = [0, 0.5, 0.9] }\n\
                zone = { min_m = [0, -0.5, 0], max_m = [0.5, 0.5, 1] }\n";
    let told = |low: &str, scene: &str| {
        let folder = Folder::new();
        folder.write("study.toml", format!("{STUDY}{}", gate.replace("LOW", low)));
        folder.edit("cell.toml", "position_m = [-0.7, -0.5, 0.3]", scene);
        let trips = "sensor \"gate\": the environment alone trips 1 of 1 pose";
        warnings(&folder).into_iter().find(|w| w.contains(trips)).unwrap_or_default()
    };
    let still = "position_m = [-0.7, -0.5, 0.3]";
    let floor = told("0", still);
    assert!(floor.contains("\"walls\" does at x -0.15, y -0.45, z 0.05 m)"), "{floor}");
    assert_eq!(told("0.6", still), "", "nothing is");
    // The ball comes at the second of three moments.
    let moves = "[object.snapshots]\nposition_m = [[-0.7, -0.5, 0.3], [-0.1, 0.3, 0.75], [-0.7, -0.5, 0.3]]";
    let ball = told("0.6", moves);
    assert!(ball.contains("\"ball\" does at x "), "{ball}");
    assert!(
        ball.contains("trips 1 of 1 pose in 1 of 3 snapshots (the first is 1): occupied is reported then"),
        "{ball}"
    );
}

#[test]
fn a_robot_that_nothing_holds_floats() {
    let floats = |position: &str| {
        let folder = Folder::new();
        folder.edit("cell.toml", "position_m = [0.2, 0.3, 0.45]", &format!("position_m = {position}"));
        warnings(&folder).into_iter().find(|w| w.contains("floats")).unwrap_or_default()
    };
    assert_eq!(floats("[0.2, 0.3, 0.45]"), "", "it lies near the floor");
    assert_eq!(floats("[0.2, 0.3, 1.15]"), "", "it hangs from the ceiling");
    let said = floats("[-0.1, 0.1, 0.9]");
    assert!(said.contains("robot \"arm\" floats: it begins 0.50 m above the floor"), "{said}");
    assert!(said.contains("position_m"), "{said}");
}

#[test]
fn bodies_that_would_stand_beside_the_floor_are_told() {
    let told = |floor: &str| {
        let folder = Folder::new();
        folder.edit("cell.toml", "position_m = [0, 0, 0.8]", "position_m = [0, 0, 0.6]");
        folder.edit("cell.toml", "position_m = [0.1, -0.45, 0.65]", "position_m = [0.1, -0.45, 0.4]");
        folder.edit("study.toml", "", floor);
        let warning = "[approach], [postures] and [stopping] take z 0 for the floor";
        warnings(&folder).into_iter().find(|w| w.contains(warning)).unwrap_or_default()
    };
    let said = told("[approach]\nmin_voxels = 2\n");
    assert!(
        said.contains("the floor is at z -0.20 m (the largest level surface near the people's feet)"),
        "{said}"
    );
    assert!(said.contains("write floor_m = -0.20"), "{said}");
    assert_eq!(told("[approach]\nmin_voxels = 2\nfloor_m = -0.2\n"), "");
    assert_eq!(told(""), "", "nobody stands, and no distance is asked for");
    // A floor in another unit, or that of another cell.
    let folder = Folder::new();
    folder.edit("study.toml", "", "[approach]\nfloor_m = 2.5\n");
    let said = "[approach] floor_m = 2.5: the floor is at z 0.00 m (the largest level surface near the people's feet)";
    assert!(warnings(&folder).iter().any(|w| w.contains(said)), "{:?}", warnings(&folder));
}

#[test]
fn a_gltf_in_millimetres() {
    let folder = Folder::new();
    // One triangle of 400 by 400 units, upright.
    let corners: [f32; 9] = [0.0, 0.0, 0.0, 400.0, 0.0, 0.0, 0.0, 400.0, 0.0];
    folder.write("sign.bin", corners.map(f32::to_le_bytes).concat());
    folder.write(
        "sign.gltf",
        r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
            "meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
            "bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"uri":"sign.bin","byteLength":36}]}"#,
    );
    let ball = "sphere = { radius_m = 0.12 }";
    let edits = [BOUNDS, ("cell.toml", ball, "mesh = \"sign.gltf\"")];
    check(&folder, &edits, &["object \"ball\" is 400 m long", "unit = \"mm\""]);
    folder.edit("cell.toml", "mesh =", "unit = \"mm\"\nmesh =");
    assert!(!warnings(&folder).iter().any(|w| w.contains("ball")));
}

#[test]
fn angles_in_radians_and_ranges_in_millimetres() {
    let radians = ("study.toml", "rpy_deg = [0, 30, 135]", "rpy_deg = [0, 0.5236, 2.3562]");
    let told = "study.toml: line 43: rpy_deg = [0, 0.5236, 2.3562] looks like radians";
    check(&Folder::new(), &[radians], &[told, "0.5236 rad are 30.0001°"]);
    let range = ("study.toml", "range_m = [0.2, 3.0]", "range_m = [0.2, 3000]");
    check(&Folder::new(), &[range], &["line 20: range_m = [0.2, 3000]", "3000 mm are 3 m"]);
    let scene = ("cell.toml", "rpy_deg = [0, 90, 0]", "rpy_deg = [0, 1.5708, 0]");
    check(&Folder::new(), &[scene], &["cell.toml: line 14: rpy_deg = [0, 1.5708, 0] looks like radians"]);
}

#[test]
fn a_pose_before_a_wall_is_dead() {
    let turned = ("study.toml", "facing = [0, 1, 0]", "facing = [0, -1, 0]");
    let group =
        "sensor \"camera\": group \"wall\" faces its own wall: 6 of its 6 poses are dead (first wall/0/0: ";
    let pose = "): 100 % of its rays end at \"walls\" ";
    let blind = [group, pose, "nearer than the 0.2 m from which it measures: turn it"];
    check(&Folder::new(), &[turned], &blind);
    let near = ("study.toml", "range_m = [0.2, 3.0]", "range_m = [0.01, 6.1]");
    check(&Folder::new(), &[turned, near], &[group, pose, "within 0.30 m: turn it"]);
    // One of them alone, and one that is dead whichever way it is turned.
    let one = ("study.toml", "x_m = { start = -1.0, stop = 1.0, step = 1.0 }", "x_m = 0");
    let straight =
        ("study.toml", "[{ pan = 0, tilt = 0 }, { pan = -20, tilt = -30 }]", "[{ pan = 0, tilt = 0 }]");
    let alone = "sensor \"camera\": pose wall/0/0 (";
    let own = ") is dead: 100 % of its rays end at \"walls\" nearer than the 0.2 m from which it measures: turn it round";
    check(&Folder::new(), &[turned, one, straight], &[alone, own]);
    let boxed =
        "[[object]]\nname = \"niche\"\nbox = { size_m = [0.6, 0.02, 0.6] }\nposition_m = [0, -0.62, 1.2]\n";
    let cure = "m from which it measures: move it away, or, if that is its own housing, write near_ignore_m";
    check(&Folder::new(), &[turned, one, straight, ("cell.toml", "", boxed)], &[alone, cure]);
}

#[test]
fn poses_with_nothing_in_range_are_dead_and_counted() {
    let folder = Folder::new();
    assert!(!warnings(&folder).iter().any(|w| w.contains("dead")), "none is");
    folder.edit("study.toml", "range_m = [0.2, 3.0]", "range_m = [0.01, 0.02]");
    folder.edit("study.toml", "near_ignore_m = 0.05", "");
    folder.edit("study.toml", "range_m = [0.1, 5.0]", "range_m = [0.01, 0.02]");
    let told: Vec<_> = warnings(&folder).into_iter().filter(|w| w.contains("dead")).collect();
    let why = "): its rays meet nothing from 0.01 to 0.02 m: turn it towards the cell";
    for (line, group) in told.iter().zip(["6 of the 6 poses of group \"wall\"", "2 of the 2", "3 of the 3"]) {
        assert!(line.contains(group) && line.contains(why), "{told:#?}");
    }
    assert_eq!(told.len(), 3, "{told:#?}");
    // Of many groups the first are told.
    for number in 0..9 {
        let group = format!(
            "[[sensor.poses]]\nname = \"{number}\"\nlist = [{{ position_m = [0, 0, 1], facing = [1, 0, 0] }}]\n"
        );
        folder.edit("study.toml", "", &group);
    }
    let told: Vec<_> = warnings(&folder).into_iter().filter(|w| w.contains("dead")).collect();
    assert_eq!((told.len(), told[10].as_str()), (11, "cell: 2 more poses are dead, 20 of 20 in all"));
    // Who certifies what is empty says enough.
    folder.edit("study.toml", "range_m = [0.01, 0.02]", "range_m = [0.01, 0.02]\nno_return = \"free\"");
    let told: Vec<_> = warnings(&folder).into_iter().filter(|w| w.contains("dead")).collect();
    assert_eq!(told.len(), 10, "the LIDAR's: {told:#?}");
}

/// COCO's joints of somebody who stands at the origin, looks along x and lets the arms hang.
const JOINTS: &str = "0.1,0,1.65\n0.08,0.03,1.7\n0.08,-0.03,1.7\n0,0.08,1.68\n0,-0.08,1.68\n0,0.2,1.45\n0,-0.2,1.45\n\
                      0,0.25,1.15\n0,-0.25,1.15\n0.05,0.25,0.9\n0.05,-0.25,0.9\n0,0.12,0.95\n0,-0.12,0.95\n0.02,0.12,0.5\n\
                      0.02,-0.12,0.5\n0,0.12,0.08\n0,-0.12,0.08\n";

/// What is said of the operator, a mannequin at this place in a room of 2.4 m, beside these objects.
fn said_of_a_person_at(place: &str, more: &str) -> Vec<String> {
    said_of_joints(JOINTS, place, more)
}

/// The same of a person with these joints.
fn said_of_joints(joints: &str, place: &str, more: &str) -> Vec<String> {
    let folder = Folder::new();
    folder.write("joints.csv", joints);
    folder.edit("cell.toml", "room = { size_m = [2.4, 1.8, 1.6] }", "room = { size_m = [2.4, 1.8, 2.4] }");
    folder.edit("cell.toml", "position_m = [0, 0, 0.8]", "position_m = [0, 0, 1.2]");
    folder.edit("cell.toml", "cylinder = { radius_m = 0.15, height_m = 1.2 }", "mannequin = \"joints.csv\"");
    folder.edit("cell.toml", "position_m = [0.1, -0.45, 0.65]", &format!("position_m = {place}"));
    folder.edit("cell.toml", "", more);
    let said =
        warnings(&folder).into_iter().filter_map(|w| Some(w.strip_prefix("cell: person ")?.to_string()));
    said.collect()
}

#[test]
fn a_person_where_nobody_can_be() {
    let here = "[0.1, -0.3, 0]";
    assert_eq!(said_of_a_person_at(here, ""), [""; 0]);
    // A table at the height of the hanging hands, beside the left arm.
    let table = |at: &str| {
        format!("[[object]]\nname = \"bench\"\nbox = {{ size_m = [0.6, 0.4, 0.04] }}\nposition_m = {at}\n")
    };
    let said = said_of_a_person_at(here, &table("[0.3, 0.1, 1.0]"));
    assert_eq!(said.len(), 1, "{said:?}");
    let arm = "\"operator\" is in \"bench\": left forearm goes through its surface: move one of them";
    assert!(said[0].starts_with(arm), "{said:?}");
    assert_eq!(said_of_a_person_at(here, &table("[0.3, 0.28, 1.0]")), [""; 0], "a hand's breadth away");
    let one = |place: &str, more: &str, expected: &str| {
        let said = said_of_a_person_at(place, more);
        assert!(said.len() == 1 && said[0].contains(expected), "{expected:?} in {said:?}");
    };
    one("[0.1, -0.3, -0.4]", "", "\"operator\" is cut by \"walls\": 0.");
    one("[0.1, -0.3, 0.4]", "", "\"operator\" floats 0.");
    one("[0.7, 0.4, 0]", "", "\"crate\"");
    let chest = "[[object]]\nname = \"chest\"\ninterior = \"ignored\"\nbox = { size_m = [0.6, 0.4, 1.6] }\nposition_m = [0.1, -0.1, 0.9]\n";
    one(here, chest, "is inside \"chest\" with ");
    one("[0.2, 0.2, 0]", "", "\"arm\": left thigh");
    let cabinet = "[[object]]\nname = \"cabinet\"\nbox = { size_m = [0.5, 0.8, 2.05] }\nposition_m = [0.1, -0.3, 1.05]\n";
    one(here, cabinet, "is shut up in a closed body");
}

/// Each joint with its coordinates changed.
fn changed(change: impl Fn([f64; 3]) -> [f64; 3]) -> String {
    let row = |row: &str| {
        let numbers: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
        change([numbers[0], numbers[1], numbers[2]]).map(|x| x.to_string()).join(",") + "\n"
    };
    JOINTS.lines().map(row).collect()
}

/// One line each, which also explains where such a person is.
#[test]
fn joints_that_are_no_persons() {
    let here = "[0.1, -0.3, 0]";
    for (joints, place, expected) in [
        (
            changed(|[x, y, z]| [y, z, x]),
            here,
            "lies in the floor: are its joints y up? Turn it with rpy_deg = [90, 0, 0]",
        ),
        (changed(|p| p.map(|x| 2.0 * x)), here, "m tall by its joints, and people are 1.2 to 2.2 m"),
        (changed(|p| p.map(|x| 0.5 * x)), here, "m tall by its joints, and people are 1.2 to 2.2 m"),
        (
            changed(|[x, y, z]| [x, -y, z]),
            here,
            "has its nose where its back is: left and right are exchanged",
        ),
        (changed(|[x, y, z]| [x, -y, -z]), "[0.1, -0.3, 1.9]", "stands on its head"),
    ] {
        let said = said_of_joints(&joints, place, "");
        assert!(
            said.len() == 1 && said[0].starts_with("\"operator\" ") && said[0].contains(expected),
            "{said:?}"
        );
    }
    // A body without joints is looked at by its size.
    let tall = ("cell.toml", "height_m = 1.2", "height_m = 2.4");
    let high = ("cell.toml", "room = { size_m = [2.4, 1.8, 1.6] }", "room = { size_m = [2.4, 1.8, 4] }");
    check(
        &Folder::new(),
        &[tall, high],
        &["person \"operator\" is 0.30 × 0.30 × 2.40 m, and people are 1.2 to 2.2 m tall"],
    );
    let short = ("cell.toml", "height_m = 1.2", "height_m = 0.6");
    check(&Folder::new(), &[short], &["person \"operator\" is 0.30 × 0.30 × 0.60 m, and people are"]);
}

#[test]
fn a_fence_that_voxels_make_solid() {
    // Upright strips of 5 mm every 5 cm, 80 cm high and wide.
    let mut fence = String::from("solid fence\n");
    for i in 0..17 {
        let [low, high] = [0.0, 0.005].map(|x| x + 0.05 * f64::from(i) - 0.4);
        for corners in [[[low, 0.0], [high, 0.0], [high, 0.8]], [[low, 0.0], [high, 0.8], [low, 0.8]]] {
            fence += "facet normal 0 0 0\nouter loop\n";
            corners.iter().for_each(|[x, z]| fence += &format!("vertex {x} 0.013 {z}\n"));
            fence += "endloop\nendfacet\n";
        }
    }
    let folder = Folder::new();
    folder.write("fence.stl", fence + "endsolid fence\n");
    let edit = ("cell.toml", "sphere = { radius_m = 0.12 }", "mesh = \"fence.stl\"");
    check(
        &folder,
        &[edit],
        &["object \"ball\" is a sheet that fills ", "% of its voxels", "optical = \"see_through\""],
    );
    folder.edit("cell.toml", "mesh = \"fence.stl\"", "optical = \"see_through\"\nmesh = \"fence.stl\"");
    assert!(!warnings(&folder).iter().any(|w| w.contains("sheet")));
}

#[test]
fn a_body_in_centimetres_is_asked_for_its_unit() {
    let bar = |size: &str| {
        format!("[[object]]\nname = \"bar\"\nbox = {{ size_m = {size} }}\nposition_m = [0.5, -0.5, 0.3]\n")
    };
    let told = "object \"bar\" is 60.0 m long, and no other is longer than 2.4 m: are its lengths in centimetres (divided by \
                100: 0.60 m) or in millimetres (by 1000: 0.06 m)?";
    check(&Folder::new(), &[("cell.toml", "", &bar("[40, 60, 30]"))], &[told]);
    let folder = Folder::new();
    folder.edit("cell.toml", "", &bar("[40, 60, 0.1]"));
    assert!(!warnings(&folder).iter().any(|w| w.contains("centimetres")), "a floor is long and thin");
}

#[test]
fn a_range_in_centimetres_is_asked_for_its_unit() {
    let folder = Folder::new();
    folder.edit("study.toml", "range_m = [0.2, 3.0]", "range_m = [20, 300]");
    let told: Vec<_> = warnings(&folder).into_iter().filter(|w| w.contains("\"camera\"")).collect();
    assert_eq!(told.len(), 1, "no pose is called dead: {told:?}");
    let line = "range_m = [20, 300] begins 20 m from it, and the cell is ";
    assert!(told[0].contains(line) && told[0].ends_with("write [0.2, 3]"), "{told:?}");
}

#[test]
fn robots_that_hold_each_other_up_float_together() {
    let folder = Folder::new();
    folder.edit("cell.toml", "position_m = [0.2, 0.3, 0.45]", "position_m = [-0.1, 0.1, 0.9]");
    folder.edit(
        "cell.toml",
        "",
        "[[object]]\nname = \"gripper\"\nrole = \"robot\"\nbox = { size_m = [0.1, 0.1, 0.1] }\nposition_m = [-0.1, 0.1, 0.5]\n",
    );
    let said: Vec<_> = warnings(&folder).into_iter().filter(|w| w.contains("floats")).collect();
    assert_eq!(said.len(), 2, "{said:?}");
    assert!(
        said[0].contains("robot \"arm\" floats") && said[0].contains("only \"gripper\" is near it"),
        "{said:?}"
    );
    // A gripper on an arm that stands is held.
    folder.edit("cell.toml", "position_m = [-0.1, 0.1, 0.9]", "position_m = [-0.1, 0.1, 0.5]");
    assert!(!warnings(&folder).iter().any(|w| w.contains("floats")));
}

#[test]
fn a_person_on_a_platform_stands() {
    // The platform's top is on a border of voxels, at 0.3 m, and its inside is free.
    let platform = "[[object]]\nname = \"platform\"\nbox = { size_m = [0.8, 0.8, 0.3] }\nposition_m = [0.1, -0.3, 0.15]\n";
    for height in ["0.3", "0.2200001"] {
        assert_eq!(said_of_a_person_at(&format!("[0.1, -0.3, {height}]"), platform), [""; 0], "{height}");
    }
}

#[test]
fn a_cabinet_before_a_pose_is_no_wall_of_its_own() {
    let folder = Folder::new();
    let cabinet =
        "[[object]]\nname = \"cabinet\"\nbox = { size_m = [2.2, 0.1, 0.8] }\nposition_m = [0, 0.2, 1.2]\n";
    folder.edit("cell.toml", "", cabinet);
    folder.edit("study.toml", "y_m = -0.75", "y_m = 0.05");
    folder.edit("study.toml", "name = \"wall\"", "name = \"posts\"");
    let told = warnings(&folder);
    let dead: Vec<_> = told.iter().filter(|w| w.contains("end at \"cabinet\"")).collect();
    assert!(
        !dead.is_empty() && dead.iter().all(|w| w.contains("turn it round") && !w.contains("own wall")),
        "{told:?}"
    );
}

#[test]
fn only_open_sides_of_a_cut_region_are_named() {
    let folder = Folder::new();
    folder.edit("cell.toml", "room = { size_m = [2.4, 1.8, 1.6] }", "plane = { size_m = [2.4, 1.8] }");
    folder.edit("cell.toml", "position_m = [0, 0, 0.8]", "position_m = [0, 0, 0]");
    folder.edit(
        "study.toml",
        "min_m = [-0.5, -0.5, 0.1], max_m = [0.5,",
        "min_m = [-0.5, -0.5, -0.4], max_m = [2.9,",
    );
    let told = warnings(&folder);
    assert!(
        told.iter().any(|w| w.contains("region \"box\"") && w.contains("grid (towards +x) and")),
        "{told:?}"
    );
}

#[test]
fn a_body_without_a_nose_is_measured_by_its_length() {
    let without_nose = |scale: f64| {
        let joints = changed(|place| place.map(|x| scale * x));
        said_of_joints(&format!(",,\n{}", joints.split_once('\n').unwrap().1), "[0.1, -0.3, 0]", "")
    };
    assert_eq!(without_nose(1.0), [""; 0]);
    let said = without_nose(2.0);
    assert!(said.len() == 1 && said[0].contains(" m, and people are 1.2 to 2.2 m tall"), "{said:?}");
}
