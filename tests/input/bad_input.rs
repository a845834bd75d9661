//! Everything a user can get wrong: each is refused with exit code 2 before any ray is cast, in a message
//! that names the file, the key and, where there is one, the value; and nothing is left behind.

use crate::common::program::{self, Edit, Folder, perirobot, refused, text};

const STUDY: &str = "study.toml";
const SCENE: &str = "cell.toml";

/// The good study with these edits must be refused in words that hold all of `expected`.
#[track_caller]
fn check(edits: &[Edit], expected: &[&str]) {
    refused(&Folder::new(), edits, expected);
}

/// A value in place of another, in a file.
#[track_caller]
fn wrong(file: &str, from: &str, to: &str, expected: &[&str]) {
    check(&[(file, from, to)], &[&[file], expected].concat());
}

#[test]
fn the_study_they_start_from_is_good() {
    let outcome = Folder::new().sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
}

#[test]
fn unknown_keys_and_wrong_types() {
    for (file, from, to, key) in [
        (STUDY, "seed = 7", "sed = 7", "sed"),
        (STUDY, "voxel_size_m = 0.1", "voxel_size = 0.1", "voxel_size"),
        (STUDY, "radius_m = 0.6", "radius_m = 0.6, diameter_m = 1", "diameter_m"),
        (STUDY, "kind = \"rgbd\"", "kind = \"rgbd\"\nfow_deg = 3", "fow_deg"),
        (STUDY, "step = 1.0", "step = 1.0, steps = 2", "steps"),
        (STUDY, "{ pan = 0, tilt = 0 }", "{ pan = 0, roll = 0 }", "roll"),
        (STUDY, "count = 2", "count = 2, number = 2", "number"),
        (STUDY, "z = 0 }", "z = 0, v = 0 }", "v"),
        (SCENE, "interior = \"free\"", "inside = \"free\"", "inside"),
        (SCENE, "role = \"robot\"", "rolle = \"robot\"", "rolle"),
        (SCENE, "radius_m = 0.12", "radius_mm = 120", "radius_mm"),
        (STUDY, "seed = 7", "seed = \"7\"", "seed"),
        (STUDY, "seed = 7", "seed = -7", "seed"),
        (STUDY, "resolution_px = [16, 9]", "resolution_px = [16.5, 9]", "resolution_px"),
        (STUDY, "resolution_px = [16, 9]", "resolution_px = [-16, 9]", "resolution_px"),
        (STUDY, "resolution_px = [16, 9]", "resolution_px = [16]", "resolution_px"),
        (STUDY, "kind = \"rgbd\"", "kind = \"rgb\"", "missing field `zone`, as in zone = {"),
        (STUDY, "kind = \"rgbd\"", "kind = \"rgbb\"", "expected one of `rgbd`, `rgb`, `lidar`"),
        (STUDY, "kind = \"rgbd\"", "", "kind"),
        (STUDY, "fov_deg = [87, 58]", "fov_deg = []", "fov_deg"),
        (STUDY, "fov_deg = [87, 58]", "fov_deg = [87, 58, 3]", "fov_deg"),
        (STUDY, "fov_deg = [87, 58]", "fov_deg = true", "fov_deg"),
        (STUDY, "range_m = [0.2, 3.0]", "", "range_m"),
        (STUDY, "y_m = -0.75", "y_m = \"-0.75\"", "y_m"),
        (STUDY, "facing = [0, 1, 0]", "facing = [0, 1]", "facing"),
        (STUDY, "count = 2", "count = -2", "count"),
        (STUDY, "seed = 7", "seed = ", "seed"),
        (SCENE, "role = \"robot\"", "role = \"Robot\"", "role"),
        (SCENE, "interior = \"free\"", "interior = \"solid\"", "interior"),
        (SCENE, "size_m = [0.4, 0.6]", "size_m = [0.4, 0.6, 1]", "size_m"),
        // A value too many must not be passed over.
        (STUDY, "facing = [0, 1, 0]", "facing = [0, 1, 0, 1]", "facing"),
        (STUDY, "range_m = [0.2, 3.0]", "range_m = [0.2, 3.0, 6.0]", "range_m"),
        (STUDY, "resolution_px = [16, 9]", "resolution_px = [16, 9, 3]", "resolution_px"),
        (SCENE, "position_m = [0.7, 0.4, 0.25]", "position_m = [0.7, 0.4, 0.25, 1]", "position_m"),
    ] {
        wrong(file, from, to, &[key]);
    }
}

#[test]
fn things_that_are_missing_or_twice() {
    for (file, from, to, expected) in [
        (STUDY, program::STUDY, "", "no scene"),
        (STUDY, "[[scene]]\nfile = \"cell.toml\"", "", "no scene: add at least one"),
        (STUDY, "file = \"cell.toml\"", "file = \"gone.toml\"", "scene[0].file"),
        (STUDY, "file = \"cell.toml\"", "file = \"\"", "scene[0].file"),
        (
            STUDY,
            "file = \"cell.toml\"",
            "file = \"cell.toml\"\n[[scene]]\nfile = \"cell.toml\"",
            "two scenes are named \"cell\"",
        ),
        (
            STUDY,
            "file = \"cell.toml\"",
            "file = \"cell.toml\"\nname = \"\"",
            "one of the scenes has an empty name",
        ),
        (STUDY, "name = \"box\"", "name = \"robot\"", "two regions are named \"robot\""),
        (STUDY, "name = \"box\"", "name = \"\"", "one of the regions has an empty name"),
        (
            STUDY,
            "sphere = {",
            "box = { min_m = [0, 0, 0], max_m = [1, 1, 1] }\nsphere = {",
            "region \"robot\": both sphere and box",
        ),
        (
            STUDY,
            "object = \"operator\"",
            "object = \"nobody\"",
            "human_box.object = \"nobody\": the scene's humans are [\"operator\"]",
        ),
        (
            STUDY,
            "margin_m = 0.2",
            "margin_m = 0.2, margin_min_m = [0, 0, 0]",
            "human_box: margin_m is for all sides",
        ),
        (STUDY, "name = \"lidar\"", "name = \"camera\"", "two sensors are named \"camera\""),
        (STUDY, "name = \"lidar\"", "name = \"\"", "one of the sensors has an empty name"),
        (
            STUDY,
            "name = \"lidar\"",
            "name = \"a\\u001b[2J\"",
            "sensor \"a\\u{1b}[2J\" has control characters",
        ),
        (
            STUDY,
            "name = \"lidar\"",
            "name = \"a\\uFEFFb\"",
            "sensor \"a\\u{feff}b\" has control characters or others that are not seen (\\u{feff}): name it with",
        ),
        (
            STUDY,
            "name = \"random\"",
            "name = \"Wall\"\nlist = []",
            "sensor \"camera\".poses \"Wall\": give one of",
        ),
        (STUDY, "name = \"random\"", "name = \"?\"", "sensor \"camera\".poses \"?\": the name needs"),
        (STUDY, "name = \"leaning\"", "name = \"upright\"", "two poses are named \"posts/upright\""),
        (STUDY, "name = \"leaning\"", "name = \"\"", "list[1].name"),
        (STUDY, "y_m = -0.75", "", "poses \"wall\": y_m is missing"),
        (STUDY, "facing = [0, 1, 0]", "", "poses \"wall\": facing is missing"),
        (
            STUDY,
            "orientations_deg = [{ pan = 0, tilt = 0 }, { pan = -20, tilt = -30 }]",
            "orientations_deg = []",
            "no orientations_deg",
        ),
        (STUDY, "facing = [0, 1, 0]", "facing = [0, 1, 0]\nframe = \"link\"", "frame does not belong here"),
        (
            STUDY,
            "rpy_deg = [0, 30, 135]",
            "rpy_deg = [0, 30, 135], facing = [1, 0, 0]",
            "list[1]: give one of",
        ),
        (STUDY, "rpy_deg = [0, 30, 135]", "", "list[1]: give one of"),
        (STUDY, "pan_deg = 10", "tilt_deg = 10", "list[0].tilt_deg = 10: an upright lidar"),
        (
            STUDY,
            "fov_deg = [87, 58]",
            "",
            "sensor \"camera\": missing field `fov_deg`, as in fov_deg = [87, 58], horizontal and vertical",
        ),
        (
            STUDY,
            "fov_deg = [87, 58]",
            "fov_deg = [87, 58]\nrings_deg = [1]",
            "unknown field `rings_deg`, expected one of `fov_deg`",
        ),
        (
            STUDY,
            "fov_deg = [87, 58]",
            "fov_deg = [87, 58]\nmount = \"facing\"",
            "unknown field `mount`, expected one of `fov_deg`",
        ),
        (STUDY, "resolution_deg = [8, 12]", "", "neither resolution_deg nor beams: give the step"),
        (
            STUDY,
            "resolution_deg = [8, 12]",
            "resolution_deg = 8\nresolution_px = [8, 8]",
            "unknown field `resolution_px`, expected one of",
        ),
        (STUDY, "resolution_deg = [8, 12]", "resolution_deg = 8\nrings_deg = [1]", "elevations given twice"),
        (STUDY, "fov_deg = [360, 90]", "fov_deg = 360", "no elevations"),
        (STUDY, "fov_deg = [360, 90]", "fov_deg = [270, 0]", "as in fov_deg = 270 and rings_deg = [0]"),
        (SCENE, program::SCENE, "", "no object"),
        (SCENE, "name = \"ball\"", "name = \"arm\"", "two objects are named \"arm\""),
        (SCENE, "name = \"ball\"", "name = \"\"", "one of the objects has an empty name"),
        (SCENE, "sphere = { radius_m = 0.12 }", "", "object \"ball\": no surface: give one of"),
        (SCENE, "sphere = {", "box = { size_m = [1, 1, 1] }\nsphere = {", "object \"ball\": both"),
        (SCENE, "sphere = {", "unit = \"mm\"\nsphere = {", "object \"ball\": unit and up belong"),
        (
            SCENE,
            "sphere = {",
            "mesh = \"cell.IGS\"\n#",
            "mesh = \"cell.IGS\": must be a .glb, .gltf, .stl, .obj, .dae or .step file; a .igs file is not read: IGES holds curved",
        ),
        (
            SCENE,
            "sphere = {",
            "unit = \"mm\"\nmesh = \"a.dae\"\n#",
            "unit and up do not belong to a .dae mesh: COLLADA says both itself",
        ),
        (SCENE, "sphere = {", "nodes = [{ match = \"*\" }]\nsphere = {", "object \"ball\": nodes belong"),
        (SCENE, "room = {", "interior = \"free\"\nroom = {", "object \"walls\": interior does not belong"),
        (
            SCENE,
            "w = 1, x = 0, y = 0, z = 0 }",
            "w = 1, x = 0, y = 0, z = 0 }\nrpy_deg = [0, 0, 1]",
            "both rpy_deg and quaternion",
        ),
    ] {
        let expected = if from == program::STUDY { "no scene" } else { expected };
        check(&[(file, from, to)], &[file, expected]);
    }
    let before_poses = program::STUDY.split("[[sensor.poses]]").next().unwrap();
    let before_sensor = program::STUDY.split("[[sensor]]").next().unwrap();
    let before_region = program::STUDY.split("[[region]]").next().unwrap();
    check(&[(STUDY, program::STUDY, before_poses)], &[STUDY, "sensor \"camera\": no poses"]);
    check(&[(STUDY, program::STUDY, before_sensor)], &[STUDY, "no sensor: add at least one"]);
    check(&[(STUDY, program::STUDY, before_region)], &[STUDY, "no region: add at least one"]);
}

#[test]
fn places_that_do_not_fit_the_grid() {
    let bounds = |corners: &str| format!("[grid]\nbounds_m = {{ {corners} }}");
    let small = bounds("min = [-1.2, -0.9, 0], max = [1.2, 0.9, 1.0]");
    wrong(
        STUDY,
        "[grid]",
        &small,
        &["sensor \"camera\": pose wall/0/0 at [-1, -0.75, 1.2] is outside grid.bounds_m"],
    );
    let outside = "center_m = [9, 9, 9]";
    wrong(
        STUDY,
        "center_m = [0.2, 0.3, 0.4]",
        outside,
        &["scene \"cell\"", "region \"robot\"", "outside the grid"],
    );
    wrong(STUDY, "radius_m = 0.6", "radius_m = 0.0001", &["region \"robot\"", "holds no voxel's centre"]);
    wrong(
        STUDY,
        "radius_m = 0.6",
        "radius_m = 900",
        &["region \"robot\"", "radius_m = 900", "at most 2047 voxels"],
    );
    wrong(STUDY, "max_m = [0.5,", "max_m = [900,", &["region \"box\"", "millimetres"]);
    wrong(STUDY, "margin_m = 0.2", "margin_m = -0.9", &["region \"human\"", "holds no voxel's centre"]);
    let far = "sensor \"camera\": pose wall/0/0 at [-1, 800, 1.2] stretches the grid";
    wrong(STUDY, "y_m = -0.75", "y_m = 800", &[far, "set voxel_size_m ="]);
    wrong(
        STUDY,
        "y_m = -0.75",
        "y_m = 900000",
        &["stretches the grid", "is a length in millimetres or centimetres?"],
    );
    wrong(SCENE, "position_m = [0.7,", "position_m = [900000,", &["object \"crate\"", "a corner at"]);
    let all = "interior = \"ignored\"\nbox = { size_m = [3, 3, 3] }\n#";
    check(
        &[
            (SCENE, "interior = \"free\"", ""),
            (SCENE, "room = {", all),
            (
                STUDY,
                "min_m = [-0.5, -0.5, 0.1], max_m = [0.5, 0.5, 1.1]",
                "min_m = [-0.4, -0.2, 0.9], max_m = [-0.2, 0, 1.1]",
            ),
        ],
        &[STUDY, "region \"box\"", "interior = \"free\""],
    );
}

/// The size that the message proposes is one that works, and the next finer is not.
#[test]
fn a_voxel_size_that_fits_is_proposed() {
    let folder = Folder::new();
    folder.write(SCENE, "[[object]]\nname = \"beam\"\nbox = { size_m = [150, 0.5, 0.5] }\n");
    refused(&folder, &[], &[STUDY, "1501 voxels on an axis (150.10 m"]);
    let stderr = folder.sweep(&[]).stderr;
    let proposed = stderr.split("set voxel_size_m = ").nth(1).unwrap().split(' ').next().unwrap();
    let voxelize = |size: &str| {
        let (scene, out) = (folder.path(SCENE), folder.path("cell.bt"));
        perirobot(&["voxelize", text(&scene), "--out", text(&out), "--voxel-size", size]).code
    };
    assert_eq!((voxelize(proposed), voxelize("0.1")), (Some(0), Some(2)), "{proposed}");
    // The proposal keeps two layers for surfaces that begin inside a voxel, so a little finer may still do.
    let finer = (proposed.parse::<f64>().unwrap() * 0.995).to_string();
    assert_eq!(voxelize(&finer), Some(2), "{finer}");
}

#[test]
fn pose_tables() {
    const HEADER: &str = "pose,x_m,y_m,z_m,qw,qx,qy,qz\n";
    let good = "a,0,0,1,1,0,0,0\n";
    for (table, expected) in [
        (format!("{HEADER}{good}b,0,0,x,1,0,0,0\n"), "line 3"),
        (format!("{HEADER}{good}# note\nb,0,0,1,1,0,0\n"), "line 4: has 7 fields"),
        (format!("{HEADER}{good}b,0,0,1,0,0,0,0\n"), "line 3: qw, qx, qy, qz must not be zero"),
        (
            format!("{HEADER}{good}b,0,0,1,0.6,0,0,0.9\n"),
            "line 3: qw, qx, qy, qz must have a length of 1 within 0.001, and has 1.0817: of length 1 it is w = 0.5547",
        ),
        (
            HEADER.replace(',', ";") + "a;0;0;1;1;0;0;0\n",
            "wall.csv: line 1: columns are separated by semicolons",
        ),
        (
            format!("{HEADER}b,0,5,0,5,1,5,1,0,0,0,0,0,0,0\n"),
            "line 2: has 15 fields, the header 8: numbers have a decimal comma: write 1.5, not 1,5",
        ),
        (format!("{HEADER}b,\"0,5\",0,1,1,0,0,0\n"), "line 2: numbers have a decimal comma"),
        (format!("{HEADER}{good}b,0,0,1,nan,0,0,0\n"), "line 3: qw, qx, qy, qz"),
        (format!("{HEADER}{good}b,0,inf,1,1,0,0,0\n"), "line 3: x_m, y_m, z_m"),
        (format!("{HEADER}{good}b,0,1e300,1,1,0,0,0\n"), "line 3: x_m, y_m, z_m"),
        (format!("{HEADER}{good}{good}"), "two poses are named \"wall/a\""),
        (HEADER.into(), "holds no pose for sensor \"camera\""),
        (String::new(), "holds no pose"),
        (
            "1,0.5,2,1,0,0,0\n".into(),
            "wall.csv: has no header: write x_m,y_m,z_m,qw,qx,qy,qz as its first line",
        ),
        ("x_m,y_m,z_m\n0,0,1\n".into(), "line 2: a number is missing; the columns are x_m,y_m,z_m,qw"),
        (format!("sensor,{HEADER}lidar,{good}"), "holds no pose for sensor \"camera\""),
    ] {
        let folder = Folder::new();
        folder.write("wall.csv", table);
        let lattice =
            "x_m = { start = -1.0, stop = 1.0, step = 1.0 }\ny_m = -0.75\nz_m = [1.2]\nfacing = [0, 1, 0]\n";
        let edits = [
            (STUDY, lattice, "csv = \"wall.csv\"\n"),
            (STUDY, "orientations_deg = [{ pan = 0, tilt = 0 }, { pan = -20, tilt = -30 }]\n", ""),
        ];
        refused(&folder, &edits, &[STUDY, "sensor \"camera\"", expected]);
    }
    let edits = [(
        STUDY,
        "name = \"random\"\nfacing = [0, 0, -1]\nrandom = {",
        "name = \"t\"\ncsv = \"gone.csv\"\n#",
    )];
    check(&edits, &[STUDY, "poses \"t\": csv", "gone.csv", "cannot be read"]);
}

#[test]
fn outputs_and_arguments() {
    let out_is_refused = |folder: &Folder, out: &str, more: &[&str], expected: &str| {
        let (study, out) = (
            folder.path(STUDY),
            if out.is_empty() { String::new() } else { folder.path(out).display().to_string() },
        );
        let fixed = ["sweep", text(&study), "--out", &out, "--backend", "cpu"];
        let outcome = perirobot(&[&fixed, more].concat());
        assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
        assert!(outcome.stderr.contains(expected), "no {expected:?} in {}", outcome.stderr);
        assert!(!outcome.stderr.contains("running on"), "{}", outcome.stderr);
    };
    let folder = Folder::new();
    folder.write("file", "mine");
    out_is_refused(&folder, "file", &[], "file: cannot be made a folder for results (--out)");
    out_is_refused(&folder, "file/below", &[], "(--out)");
    out_is_refused(&folder, "", &[], "--out");
    for size in ["0", "-0.1", "nan", "inf", "1e300", "small"] {
        out_is_refused(&folder, "out", &[&format!("--voxel-size={size}")], "--voxel-size");
    }
    for more in [["--threads", "0"], ["--threads", "many"], ["--backend", "abacus"], ["--adapter", "0"]] {
        out_is_refused(&folder, "out", &more, more[0].trim_start_matches("--"));
    }
    assert_eq!(folder.names(), ["cell.toml", "file", "study.toml"]);
    for arguments in [
        &["sweep"][..],
        &["sing"],
        &[],
        &["verify-backends", "scenes/tiny.toml", "--pose", "none", "--backend", "cpu"],
    ] {
        assert_eq!(perirobot(arguments).code, Some(2), "{arguments:?}");
    }
    let gone = perirobot(&["sweep", "scenes/gone.toml", "--out", "out"]);
    assert_eq!(gone.code, Some(2));
    assert!(gone.stderr.contains("scenes/gone.toml: cannot be read"), "{}", gone.stderr);
    let (scene, below) = (folder.path(SCENE), folder.path("no/cell.bt"));
    let outcome = perirobot(&["voxelize", text(&scene), "--out", text(&below)]);
    assert_eq!(outcome.code, Some(2));
    assert!(outcome.stderr.contains("no/cell.bt: cannot be written"), "{}", outcome.stderr);
}

/// Both orders of four numbers are in use.
#[test]
fn a_quaternion_in_a_list_is_shown_in_both_orders() {
    let list = "quaternion = [0, 0, 0.6, 0.8]";
    let both = "found a list, whose order is not known: if it is x, y, z, w, write { w = 0.8, x = 0, y = 0, z = 0.6 }; if it is \
                w, x, y, z, write { w = 0, x = 0, y = 0.6, z = 0.8 }";
    let table = "quaternion = { w = 1, x = 0, y = 0, z = 0 }";
    wrong(STUDY, table, list, &["sensor \"lidar\": ", both]);
    wrong(SCENE, table, list, &[both]);
    wrong(SCENE, table, "quaternion = [1, 0, 0]", &["found 3 entries, wanted a table, as in { w = 1"]);
    let long = "quaternion = { w = 1, x = 0, y = 0, z = 1 }";
    let told = "quaternion = { w = 1, x = 0, y = 0, z = 1 }: must have a length of 1 within 0.001, and has 1.4142: of length 1";
    wrong(STUDY, table, long, &["sensor \"lidar\"", told]);
    wrong(SCENE, table, long, &["object \"arm\"", told]);
}

/// A line of a file may be of any length, that of a message may not.
#[test]
fn no_message_is_a_line_without_end() {
    let long = "a".repeat(2_000_000);
    let folder = Folder::new();
    folder.edit(STUDY, "seed = 7", &format!("seed = \"{long}\""));
    folder.edit(STUDY, "name = \"lidar\"", &format!("name = [\"{long}\" 1]"));
    for edit in [None, Some(("name = [", "name = \"lidar\" # ["))] {
        if let Some((from, to)) = edit {
            folder.edit(STUDY, from, to);
        }
        let outcome = folder.sweep(&[]);
        assert_eq!(outcome.code, Some(2));
        assert!(outcome.stderr.len() < 10_000, "{} bytes", outcome.stderr.len());
        assert!(outcome.stderr.contains("study.toml: "), "{}", outcome.stderr);
    }
}

/// A file of the other kind, or a folder.
#[test]
fn files_of_another_kind_are_known_by_their_keys() {
    let folder = Folder::new();
    let said = |arguments: &[&str]| {
        let outcome = perirobot(arguments);
        assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
        outcome.stderr
    };
    let (study, scene, home) = (folder.path(STUDY), folder.path(SCENE), folder.path(""));
    let (picture, map) = (folder.path("cell.png"), folder.path("cell.bt"));
    let is_scene = "cell.toml: this looks like a scene file: name the study that lists it";
    let is_study = "study.toml: this looks like a study: name a scene file that it lists";
    for (arguments, expected) in [
        (&["check", text(&scene)][..], is_scene),
        (&["render", text(&scene), "--out", text(&picture)], is_scene),
        (&["voxelize", text(&study), "--out", text(&map)], is_study),
        (&["check", text(&home)], "is a folder: name a study (.toml)"),
        (&["render", text(&home), "--out", text(&picture)], "is a folder: name a study (.toml)"),
        (&["voxelize", text(&home), "--out", text(&map)], "is a folder: name a scene file (.toml)"),
    ] {
        let said = said(arguments);
        assert!(said.contains(expected), "{arguments:?}: no {expected:?} in {said}");
        assert!(!said.contains("unknown field"), "{said}");
    }
    wrong(STUDY, "file = \"cell.toml\"", "file = \"study.toml\"", &[is_study]);
}
