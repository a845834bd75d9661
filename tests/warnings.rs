//! Input that is accepted with an assumption: the program runs, exits with 0, and says what it assumed of what.

#[allow(dead_code)]
#[path = "common/program.rs"]
mod program;

use program::{Folder, STUDY};

/// The good study with these edits, `(file, from, to)`, must run and warn in words that hold all of `expected`.
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
    let expected =
        ["sensor \"lidar\": 1 poses (first posts/corner) stand in an occupied voxel", "behind its surface"];
    check(&Folder::new(), &[edit], &expected);
}

#[test]
fn a_sensor_inside_an_ignored_body() {
    let edits = [
        ("study.toml", "position_m = [0.1, 0.1, 1.3]", "position_m = [0.7, 0.4, 0.25]"),
        ("cell.toml", "box = {", "interior = \"ignored\"\nbox = {"),
    ];
    check(&Folder::new(), &edits, &["posts/corner", "inside a body whose interior is ignored"]);
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
        !warnings(&folder).iter().any(|w| w.contains("is its unit right?"))
    };
    assert!(quiet("box = { size_m = [30, 30, 20] }", ""));
    assert!(quiet("mesh = \"knob.stl\"", "[[object]]\nname = \"rail\"\nbox = { size_m = [7, 0.3, 0.3] }"));
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
    let share = "% of it lies outside the grid (towards +x) and is not counted";
    let cure =
        ": no loss if the cell ends there; if not, set bounds_m of [grid], or make the region smaller there";
    check(&Folder::new(), &[edit], &["region \"box\"", share, cure]);
    // A person's box has a margin, and the bounds are there already.
    let margin = ("study.toml", "margin_m = 0.2", "margin_m = 0.4");
    let cure = "; if not, widen bounds_m of [grid], or take a smaller margin_m";
    check(&Folder::new(), &[BOUNDS, margin], &["region \"human\"", "grid (below, towards -y) and", cure]);
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
    assert!(!warnings(&folder).iter().any(|w| w.contains("operator")));
}

#[test]
fn a_hull_whose_inside_is_ignored() {
    let edits = [
        ("cell.toml", "interior = \"free\"", ""),
        ("cell.toml", "room = {", "interior = \"ignored\"\nbox = {"),
    ];
    check(
        &Folder::new(),
        &edits,
        &["% of the grid is inside bodies whose interior is ignored", "interior = \"free\""],
    );
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
    check(&Folder::new(), &edits, &["no object has role = \"human\"", "human_seen has no value"]);
}

#[test]
fn a_scanner_whose_field_holds_a_wall_is_told() {
    let scanner = "[[sensor]]\nname = \"scanner\"\nkind = \"lidar\"\nrings_deg = [0]\nresolution_deg = 4\nrange_m = [0.1, 9]\n\
                   noise_std_m = 0.02\nfield = { polygon_m = [[0, -0.2], [FAR, -0.2], [FAR, 0.2], [0, 0.2]], height_m = 1 }\n\
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
    let told = |low: &str| {
        let folder = Folder::new();
        folder.write("study.toml", format!("{STUDY}{}", gate.replace("LOW", low)));
        warnings(&folder).iter().any(|w| w.contains("sensor \"gate\": the environment alone trips 1 of 1"))
    };
    assert!(told("0"), "the floor is in it");
    assert!(!told("0.6"), "nothing is");
}
