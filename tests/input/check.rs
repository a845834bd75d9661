//! `check`: what it says of a study, of its rays, and of all that is wrong with it at once.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::program::{self, Edit, Folder, Outcome, perirobot, text};

const STUDY: &str = "study.toml";
const SCENE: &str = "cell.toml";

fn check(folder: &Folder, more: &[&str]) -> Outcome {
    let study = folder.path(STUDY);
    perirobot(&[&["check", text(&study), "--backend", "cpu"], more].concat())
}

#[test]
fn check_says_what_a_study_contains() {
    let folder = Folder::new();
    let outcome = check(&folder, &[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    for line in [
        "scene \"cell\"",
        "  grid 25 × 19 × 17 = 8075 voxels, 2.50 × 1.90 × 1.70 m",
        "  crate     environment  0.40 × 0.40 × 0.40 m",
        "  floor at z 0.00 m: the largest level surface near the people's feet",
        "  panel     environment  0.00 × 0.60 × 0.40 m",
        "  operator  human        0.30 × 0.30 × 1.20 m",
        "  camera  rgbd         144 rays at each of 8 poses, read as points",
        // 360 / 8 columns of ⌈90 / 12⌉ rays.
        "  lidar   lidar        360 rays at each of 3 poses, read as points",
        "    poses wall/0/0 to wall/2/1, random/0 to random/1",
        "    poses posts/upright to posts/corner",
        "  11 scene-poses, each snapshot and repeat counted; 33 rows of results",
        "rays of \"camera\" at 8 poses: ",
        "rays of \"lidar\" at 3 poses: ",
        "sight of \"camera\": rays hit any object of 119 × 124 mm at 1 m, ",
        "  a body nearer than 0.1 m is not seen: ",
        "sight of \"lidar\": rays hit any object of 140 × 211 mm at 1 m, ",
        "estimate: ",
        "memory: ",
    ] {
        assert!(outcome.stdout.contains(line), "no {line:?} in {}", outcome.stdout);
    }
    let outcome = check(&folder, &["--poses", "0"]);
    assert!(
        !outcome.stdout.contains("rays of") && !outcome.stdout.contains("estimate"),
        "{}",
        outcome.stdout
    );
}

#[test]
fn check_names_the_cure_where_most_rays_do_not_return() {
    for (file, from, to, expected) in [
        (STUDY, "near_ignore_m = 0.05", "", "% return"),
        (STUDY, "range_m = [0.2, 3.0]", "range_m = [2.9, 3.0]", "most rays are blind: something is nearer"),
        (
            STUDY,
            "range_m = [0.2, 3.0]",
            "range_m = [0.01, 0.11]",
            "most rays find nothing within range_m's second number",
        ),
        (
            SCENE,
            "room = { size_m = [2.4, 1.8, 1.6] }",
            "plane = { size_m = [2.4, 1.8] }",
            "most rays leave the grid",
        ),
    ] {
        let folder = Folder::new();
        folder.edit(file, from, to);
        if from.starts_with("room") {
            // A ceiling only, above all that looks.
            folder.edit(SCENE, "position_m = [0, 0, 0.8]", "position_m = [0, 0, 1.59]");
        }
        let outcome = check(&folder, &[]);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        let advice = format!("warning: sensor \"camera\": {expected}");
        assert!(
            expected == "% return" || outcome.stderr.contains(&advice),
            "no {advice:?} in {}",
            outcome.stderr
        );
    }
}

/// "no problems" is said where nothing was said before.
#[test]
fn check_ends_with_what_it_found() {
    let folder = Folder::new();
    let ends = |more: &[&str]| {
        let outcome = check(&folder, more);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        let warnings = outcome.stderr.lines().filter(|line| line.starts_with("warning: ")).count();
        let (told, next) = outcome.stdout.rsplit_once("\nnext: ").unwrap();
        assert_eq!(next, format!("perirobot sweep {}\n", text(&folder.path("study.toml"))));
        (warnings, told.lines().last().unwrap().to_string())
    };
    // That the floor cuts the ball around the arm's foot and the operator's box is none.
    assert_eq!(ends(&[]), (0, "no problems".into()));
    folder.edit(SCENE, "height_m = 1.2", "height_m = 1.1");
    assert_eq!(ends(&[]), (1, "no errors; 1 warning above".into()));
    folder.edit(SCENE, "height_m = 1.1", "height_m = 1.2");
    folder.edit(STUDY, "range_m = [0.2, 3.0]", "range_m = [2.9, 3.0]");
    folder.edit(STUDY, "range_m = [0.1, 5.0]", "range_m = [2.9, 3.0]");
    // Both ranges begin beyond most of the cell, which is told without a backend and explains the dead poses; and of both
    // sensors most rays are blind.
    assert_eq!(ends(&["--poses", "0"]), (2, "no errors; 2 warnings above".into()));
    assert_eq!(ends(&[]), (4, "no errors; 4 warnings above".into()));
}

/// Every error of a study and its scene at once: those of the files' own spelling, and those of what they
/// say.
#[test]
fn check_lists_every_problem() {
    let folder = Folder::new();
    let edits: [Edit; 9] = [
        (STUDY, "voxel_size_m = 0.1", "voxel_size_m = 100"),
        (STUDY, "radius_m = 0.6", "radius_m = -0.6"),
        (STUDY, "max_m = [0.5, 0.5, 1.1]", "max_m = [0.5, -0.5, 1.1]"),
        (STUDY, "orientations_deg = [{ pan = 0, tilt = 0 }", "orientations_deg = [{ pan = 0, tilt = 999 }"),
        (STUDY, "count = 2", "count = 0"),
        (STUDY, "resolution_deg = [8, 12]", "resolution_deg = [8, 0]"),
        (SCENE, "radius_m = 0.12", "radius_m = 0"),
        (SCENE, "radius_m = 0.15, height_m = 1.2", "radius_m = 0.15, height_m = -1.2"),
        (SCENE, "mesh", "mesh"),
    ];
    for (file, from, to) in &edits[..8] {
        folder.edit(file, from, to);
    }
    folder.edit(STUDY, "[[region]]", "[[scene]]\nfile = \"nowhere.toml\"\n[[region]]");
    let outcome = check(&folder, &[]);
    assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(2), ""), "{}", outcome.stderr);
    for expected in [
        "grid.voxel_size_m = 100: must be",
        "object \"ball\".sphere.radius_m = 0: must be",
        "object \"operator\".cylinder.height_m = -1.2: must be",
        "scene[1].file: ",
        "region \"robot\".sphere.radius_m = -0.6: must be",
        "region \"box\".box.max_m = [0.5, -0.5, 1.1]: must be above min_m",
        "sensor \"camera\".poses \"wall\".orientations_deg[0].tilt = 999: must be",
        "sensor \"camera\".poses \"random\".random.count = 0: must be",
        "sensor \"lidar\".resolution_deg = 0: must be",
    ] {
        assert!(outcome.stderr.contains(expected), "no {expected:?} in {}", outcome.stderr);
    }
    assert!(outcome.stderr.ends_with("9 problems\n"), "{}", outcome.stderr);
    // Who sweeps is told the first.
    let swept = folder.sweep(&[]);
    assert_eq!(swept.code, Some(2));
    assert_eq!(swept.stderr.matches("error: ").count(), 1, "{}", swept.stderr);
}

#[test]
fn check_goes_on_after_keys_that_are_wrong() {
    let folder = Folder::new();
    for (file, from, to) in [
        (STUDY, "seed = 7", "sed = 7\nrepeats = \"five\"\nfused = true"),
        (STUDY, "voxel_size_m = 0.1", "voxel_size_m = 0.1\noutsides = \"backdrop\""),
        (STUDY, "margin_m = 0.2", "margin = 0.2, margins_m = 0.2"),
        (STUDY, "radius_m = 0.6", "radius_m = -0.6"),
    ] {
        folder.edit(file, from, to);
    }
    let outcome = check(&folder, &[]);
    assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(2), ""), "{}", outcome.stderr);
    for expected in [
        "unknown field `sed`",
        "unknown field `fused`",
        "found \"five\", wanted a whole number from 0 to 4294967295",
        "unknown field `outsides`",
        "unknown field `margin`",
        "unknown field `margins_m`",
        "region \"robot\".sphere.radius_m = -0.6: must be",
    ] {
        assert_eq!(outcome.stderr.matches(expected).count(), 1, "{expected:?} in {}", outcome.stderr);
    }
    assert!(outcome.stderr.ends_with("7 problems\n"), "{}", outcome.stderr);
}

#[test]
fn check_goes_on_after_what_cannot_be_read() {
    let folder = Folder::new();
    for (file, from, to) in [
        (STUDY, "radius_m = 0.6", "radius = 0.6"),
        (STUDY, "margin_m = 0.2", "margins_m = 0.2"),
        (STUDY, "range_m = [0.2, 3.0]", "range_m = [3.0, 0.2]"),
        (SCENE, "size_m = [0.4, 0.4, 0.4]", "sizes_m = [0.4, 0.4, 0.4]"),
        (SCENE, "radius_m = 0.15", "radius_m = 0"),
    ] {
        folder.edit(file, from, to);
    }
    let outcome = check(&folder, &[]);
    assert_eq!(outcome.code, Some(2));
    for expected in [
        "unknown field `radius`",
        "region \"human\": unknown field `margins_m`",
        "sensor \"camera\".range_m = [3.0, 0.2]: must be",
        "unknown field `sizes_m`",
        "object \"operator\".cylinder.radius_m = 0: must be",
    ] {
        assert!(outcome.stderr.contains(expected), "no {expected:?} in {}", outcome.stderr);
    }
    assert!(outcome.stderr.ends_with("5 problems\n"), "{}", outcome.stderr);
}

#[test]
fn check_lists_what_is_wrong_with_each_scene() {
    let folder = Folder::new();
    folder.edit(
        SCENE,
        "",
        "[[object]]\nname = \"one\"\nmesh = \"one.stl\"\n[[object]]\nname = \"two\"\nmesh = \"two.stl\"\n",
    );
    folder.write("other.toml", program::SCENE.replace("name = \"operator\"", "name = \"visitor\""));
    folder.edit(STUDY, "[[region]]", "[[scene]]\nfile = \"other.toml\"\n[[region]]");
    let outcome = check(&folder, &[]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stdout);
    for expected in
        ["object \"one\": mesh = ", "object \"two\": mesh = ", "scene \"other\": region \"human\""]
    {
        assert!(outcome.stderr.contains(expected), "no {expected:?} in {}", outcome.stderr);
    }
    assert!(outcome.stderr.ends_with("3 problems\n"), "{}", outcome.stderr);
    assert!(outcome.stdout.contains("sensors\n"), "what is right is listed: {}", outcome.stdout);
}

/// Copies a folder, with a mesh that is missing in each scene, and gives the studies in it.
fn copy_without_mesh(from: &Path, to: &Path) -> Vec<PathBuf> {
    fs::create_dir_all(to).unwrap();
    let copy = |path: PathBuf| {
        let copy = to.join(path.file_name().unwrap());
        if path.is_dir() {
            return copy_without_mesh(&path, &copy);
        }
        let keys = fs::read_to_string(&path).unwrap_or_default();
        if keys.starts_with("#:schema") && keys.contains("scene.schema.json") {
            fs::write(copy, keys + "\n[[object]]\nname = \"gone\"\nmesh = \"gone.stl\"\n").unwrap();
            return Vec::new();
        }
        fs::copy(&path, &copy).unwrap();
        if keys.starts_with("#:schema") { vec![copy] } else { Vec::new() }
    };
    fs::read_dir(from).unwrap().flat_map(|entry| copy(entry.unwrap().path())).collect()
}

/// Whatever a study asks, it is refused in words if none of its scenes can be read.
#[test]
fn check_survives_scenes_that_cannot_be_read() {
    let folder = tempfile::tempdir().unwrap();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let studies = copy_without_mesh(&scenes, folder.path());
    assert!(studies.len() > 14, "{studies:?}");
    for study in studies {
        let outcome = perirobot(&["check", text(&study), "--backend", "cpu", "--all"]);
        let said = format!("{}: {}", study.display(), outcome.stderr);
        assert_eq!(outcome.code, Some(2), "{said}");
        assert!(outcome.stderr.contains("object \"gone\""), "{said}");
    }
}

/// Poses in millimetres make a grid that cannot be; the cure is not a larger voxel.
#[test]
fn check_takes_positions_in_millimetres_for_the_cause() {
    let folder = Folder::new();
    folder.edit(STUDY, "position_m = [-0.9, 0.6, 0.9]", "position_m = [-90000, 600, 900]");
    let outcome = check(&folder, &[]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    for expected in [
        "pose posts/upright at [-90000, 600, 900] stretches the grid",
        "line 42: position_m = [-90000, 600, 900] looks like millimetres, and metres are wanted: -90000 mm are -90 m",
    ] {
        assert!(outcome.stderr.contains(expected), "no {expected:?} in {}", outcome.stderr);
    }
}

#[test]
fn check_says_what_may_be_meant_and_where() {
    let told = |file: &str, from: &str, to: &str, expected: &[&str]| {
        let folder = Folder::new();
        folder.edit(file, from, to);
        let outcome = check(&folder, &[]);
        assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
        for part in expected {
            assert!(outcome.stderr.contains(part), "no {part:?} in {}", outcome.stderr);
        }
    };
    told(STUDY, "seed = 7", "sed = 7", &["line 1, column 1", "did you mean `seed`?"]);
    // The keys of a sensor and of its poses are read apart from the file.
    let line = "sensor \"camera\": unknown field `range`";
    told(
        STUDY,
        "range_m = [0.2, 3.0]",
        "range = [0.2, 3.0]",
        &[line, "(line 20)", "did you mean `range_m`?"],
    );
    let line = "sensor \"camera\": unknown field `orientation_deg`";
    told(
        STUDY,
        "orientations_deg =",
        "orientation_deg =",
        &[line, "(line 28)", "did you mean `orientations_deg`?"],
    );
    told(STUDY, "kind = \"lidar\"", "kind = \"lida\"", &["unknown variant `lida`", "did you mean `lidar`?"]);
    told(SCENE, "position_m = [-0.7", "positon_m = [-0.7", &["did you mean `position_m`?"]);
    // Where two are wrong, the second is read apart, too.
    told(
        STUDY,
        "margin_m = 0.2 }",
        "margins = 0.2 }\n[[region]]\nname = \"more\"\nbal = 1",
        &["line 14", "region \"more\": unknown field `bal`", "(line 17)"],
    );
    told(
        STUDY,
        "\"cell.toml\"",
        "\"cel.toml\"",
        &["scene[0].file: ", "there is \"cell.toml\": is that meant?"],
    );
}

#[test]
fn check_keeps_to_a_screen_unless_all_is_wished_for() {
    let folder = Folder::new();
    for number in 0..60 {
        folder.edit(
            STUDY,
            "[[region]]",
            &format!("[[scene]]\nfile = \"cell.toml\"\nname = \"cell {number}\"\n[[region]]"),
        );
    }
    folder.edit(STUDY, "position_m = [0.1, 0.1, 1.3]", "position_m = [0.75, 0.4, 0.45]");
    let lines = |outcome: &Outcome| outcome.stdout.lines().count() + outcome.stderr.lines().count();
    let short = check(&folder, &["--poses", "0"]);
    assert_eq!(short.code, Some(0), "{}", short.stderr);
    assert!(lines(&short) <= 50, "{} lines: {}{}", lines(&short), short.stdout, short.stderr);
    for expected in ["and 60 more scenes (--all)", "and 3 more objects (--all)"] {
        assert!(short.stdout.contains(expected), "no {expected:?} in {}", short.stdout);
    }
    assert!(short.stderr.contains("warning: cell, cell 0, cell 1 and 58 more scenes: "), "{}", short.stderr);
    let whole = check(&folder, &["--poses", "0", "--all"]);
    assert!(
        whole.stdout.contains("scene \"cell 7\"") && !whole.stdout.contains("(--all)"),
        "{}",
        whole.stdout
    );
    assert!(whole.stderr.contains(", cell 31, "), "{}", whole.stderr);
    // Of sensors of which most rays are blind, a few are named.
    let sensors = Folder::new();
    for number in 0..60 {
        let blind = format!(
            "[[sensor]]\nname = \"blind {number}\"\nkind = \"rgbd\"\nfov_deg = [60, 40]\nresolution_px = [8, 6]\n\
             range_m = [2.9, 3.0]\n[[sensor.poses]]\nname = \"here\"\nlist = [{{ position_m = [0, 0, 1], facing = [1, 0, 0] }}]\n"
        );
        sensors.edit(STUDY, "", &blind);
    }
    let few = check(&sensors, &[]);
    assert_eq!(few.code, Some(0), "{}", few.stderr);
    assert!(lines(&few) <= 75, "{} lines: {}{}", lines(&few), few.stdout, few.stderr);
    assert!(few.stderr.contains("more sensors do not return either (--all)"), "{}", few.stderr);
    // What is wrong with all of them, too.
    folder.edit(SCENE, "sphere = { radius_m = 0.12 }", "mesh = \"gone.stl\"");
    let wrong = check(&folder, &[]);
    assert!(lines(&wrong) <= 50, "{} lines: {}", lines(&wrong), wrong.stderr);
    assert!(
        wrong.stderr.contains("and 41 more (--all)") && wrong.stderr.ends_with("61 problems\n"),
        "{}",
        wrong.stderr
    );
}

/// What `approach` and `judge` would refuse, and entries that begin too near, are found before anything is swept.
#[test]
fn check_finds_what_approach_refuses() {
    let folder = program::shelf();
    let door = "box = { min_m = [1.4, -1.0, 0], max_m = [2.0, 1.0, 2.0] }";
    // 1.95 m are needed, and the door is farther out.
    let outcome = check(&folder, &[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(!outcome.stderr.contains("no sensor can help"), "{}", outcome.stderr);
    let near = "box = { min_m = [0.4, -1.0, 0], max_m = [2.0, 1.0, 2.0] }";
    folder.edit(STUDY, door, near);
    let outcome = check(&folder, &[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let said = "entry \"door\", body \"standing\": no sensor can help at 1 m/s: the entry begins 1.20 m from the hazard, and \
                has to begin 1.95 m from it or farther, 0.75 m farther out";
    assert!(outcome.stderr.contains(said), "{}", outcome.stderr);
    folder.edit(STUDY, near, "box = { min_m = [-1.2, -0.3, 0], max_m = [-0.79, 0.3, 2.0] }");
    folder.edit(SCENE, "radius_m = 0.2, height_m = 1.2", "radius_m = 0.3, height_m = 2.1");
    let outcome = check(&folder, &[]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("entry \"door\": lies inside something solid"), "{}", outcome.stderr);
}

/// A finger is 2 cm thick. Of 16 × 9 pixels on 87° × 58° gaps are 0.119 × 0.123 m at 1 m, diagonally 0.171 m: 2 cm at 0.11 m.
#[test]
fn bodies_that_pass_between_rays_are_told() {
    let folder = Folder::new();
    let bodies = "{ name = \"chest\", ball = { diameter_m = 0.6 } }, { name = \"finger\", min_voxels = 1 }";
    let entry = "{ name = \"door\", box = { min_m = [-1, -0.7, 0.1], max_m = [1, 0.7, 1.5] } }";
    folder.edit(STUDY, "", &format!("\n[approach]\nbody = [{bodies}]\nentry = [{entry}]\n"));
    let outcome = check(&folder, &["--all"]);
    let expected =
        "sensor \"camera\", body \"finger\": it may pass between the rays farther than 0.11 m away";
    assert!(outcome.stderr.contains(expected), "{}", outcome.stderr);
    assert!(!outcome.stderr.contains("sensor \"camera\", body \"chest\": it may pass"), "{}", outcome.stderr);
}

const STOPPING: &str = "\n[stopping]\nformula = \"iso13855\"\nedition = 2010\nrobot_speeds_m_s = [0.5]\nsensor_reaction_s = 0.1\n\
                        control_reaction_s = 0.1\nrobot_stopping_s = 0.2\n";
const SCANNER: &str = "\n[[sensor]]\nname = \"scanner\"\nkind = \"lidar\"\nresolution_deg = 4\nrings_deg = [0]\n\
                       range_m = [0.1, 5]\n[[sensor.poses]]\nname = \"post\"\n\
                   list = [{ name = \"low\", position_m = [-0.9, 0.6, 0.2], facing = [1, -0.5, 0] }]\n";

/// C is that of the sensors in some set, and a scanner is coarse only where it is used.
#[test]
fn sensors_of_no_set_change_no_distance() {
    let set = |name: &str| format!("\n[[combination]]\nsensors = [\"{name}\"]\n");
    for (sets, intrusion, is_coarse) in [
        (String::new(), "1.12", true),
        (set("camera"), "0.85", false),
        ([set("camera"), set("scanner")].concat(), "1.12", true),
    ] {
        let folder = Folder::new();
        let text = std::fs::read_to_string(folder.path(STUDY)).unwrap();
        folder.write(STUDY, [&text, SCANNER, STOPPING, &sets].concat());
        let outcome = check(&folder, &["--poses", "1", "--all"]);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        let told = format!("intrusion_m = {intrusion} is a default");
        assert!(outcome.stdout.contains(&told), "{told} in {}", outcome.stdout);
        let coarse = "sensor \"scanner\": at ";
        let needs = "needs a detection capability of 0.063 m for a plane 0.20 m above the floor";
        let said = outcome.stderr.contains(coarse) && outcome.stderr.contains(needs);
        assert_eq!(said, is_coarse, "{}", outcome.stderr);
        assert!(outcome.stdout.contains("rays of \"scanner\" at 1 pose: "), "{}", outcome.stdout);
        assert!(outcome.stdout.contains(" rays at 1 pose, read as"), "{}", outcome.stdout);
    }
    // A field that ends where 4° still resolve a leg; then one that goes on.
    for (end, is_coarse) in [("0.4", false), ("1.4", true)] {
        let folder = Folder::new();
        let field = format!(
            "range_m = [0.1, 5]\nfield = {{ polygon_m = [[0, -0.3], [{end}, -0.3], [{end}, 0.3], [0, 0.3]], height_m = 1 }}"
        );
        let text = std::fs::read_to_string(folder.path(STUDY)).unwrap();
        let scanner = SCANNER.replace("range_m = [0.1, 5]", &field);
        folder.write(STUDY, [&text, &scanner, STOPPING].concat());
        let outcome = check(&folder, &["--poses", "1", "--all"]);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        let said = outcome.stderr.contains("needs a detection capability of 0.063 m");
        assert_eq!(said, is_coarse, "{}", outcome.stderr);
    }
}
