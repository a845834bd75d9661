//! What a user meets first: `init`, `check`, `sensors`, a device by its name, a camera by its calibration, completions and
//! manual pages.

#[allow(dead_code)]
#[path = "common/program.rs"]
mod program;

use std::fs;

use program::{Edit, Folder, Outcome, perirobot, refused, text};
use serde_json::Value;

const STUDY: &str = "study.toml";
const SCENE: &str = "cell.toml";

/// The keys of the camera of the small study that a device or a calibration may give instead.
const CAMERA: &str = "kind = \"rgbd\"\nfov_deg = [87, 58]\nresolution_px = [16, 9]\nrange_m = [0.2, 3.0]\n";

const INFO: &str =
    "image_width: 16\nimage_height: 8\ncamera_matrix: { data: [8, 0, 7.5, 0, 8, 3.5, 0, 0, 1] }\n";

fn check(folder: &Folder, more: &[&str]) -> Outcome {
    let study = folder.path(STUDY);
    perirobot(&[&["check", text(&study), "--backend", "cpu"], more].concat())
}

fn manifest(folder: &Folder) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.path("out/manifest.json")).unwrap()).unwrap()
}

#[test]
fn init_writes_a_study_that_is_checked_and_swept() {
    let folder = tempfile::tempdir().unwrap();
    let home = folder.path().join("new/cell");
    let outcome = perirobot(&["init", text(&home)]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    for next in ["check", "sweep", "summary", "why", "report"] {
        let next = format!("\n  perirobot {next} ");
        assert!(outcome.stdout.contains(&next), "{}", outcome.stdout);
    }
    assert_eq!(program::names(&home), ["cell.toml", "operator.csv", "robot.urdf", "schemas", "study.toml"]);
    for (file, schema) in [("study.toml", "study"), ("cell.toml", "scene")] {
        let first = format!("#:schema schemas/{schema}.schema.json\n");
        assert!(fs::read_to_string(home.join(file)).unwrap().starts_with(&first), "{file}");
        assert!(home.join(format!("schemas/{schema}.schema.json")).exists());
    }
    let study = home.join("study.toml");
    let outcome = perirobot(&["check", text(&study), "--backend", "cpu"]);
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "no warnings in a first study");
    assert!(outcome.stdout.ends_with("no problems\n"), "{}", outcome.stdout);
    let out = home.join("out");
    let outcome = perirobot(&["sweep", text(&study), "--out", text(&out), "--backend", "cpu"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    // 39 poses of the camera, 2 of the lidar, 39 with the mat; two snapshots, two regions.
    assert_eq!(fs::read_to_string(out.join("results.csv")).unwrap().lines().count(), 1 + 80 * 2 * 2);
}

#[test]
fn init_overwrites_nothing() {
    for name in ["study.toml", "robot.urdf"] {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(name), "mine").unwrap();
        let outcome = perirobot(&["init", text(folder.path())]);
        assert_eq!(outcome.code, Some(2));
        let what = format!("{name}: is there already and would be lost: name another folder");
        assert!(outcome.stderr.contains(&what), "{}", outcome.stderr);
        assert_eq!(program::names(folder.path()), [name], "nothing else was written");
        assert_eq!(fs::read_to_string(folder.path().join(name)).unwrap(), "mine");
    }
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("file"), "").unwrap();
    let outcome = perirobot(&["init", text(&folder.path().join("file"))]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
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
        "  panel     environment  0.00 × 0.60 × 0.40 m",
        "  operator  human        0.30 × 0.30 × 1.20 m",
        "  camera  rgbd         144 rays at each of 8 poses, read as points",
        // 360 / 8 columns of ⌈90 / 12⌉ rays.
        "  lidar   lidar        360 rays at each of 3 poses, read as points",
        "    poses wall/0/0 to wall/2/1, random/0 to random/1",
        "    poses posts/upright to posts/corner",
        "  11 scene-poses, each snapshot and repeat for itself; 33 rows of results",
        "rays of \"camera\" at 8 poses: ",
        "rays of \"lidar\" at 3 poses: ",
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
        (
            STUDY,
            "range_m = [0.2, 3.0]",
            "range_m = [2.9, 3.0]",
            "most rays are blind: something stands nearer",
        ),
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
        (warnings, outcome.stdout.lines().last().unwrap().to_string())
    };
    // The floor cuts the ball around the arm's foot and the operator's box.
    assert_eq!(ends(&[]), (2, "no errors; 2 warnings above".into()));
    folder.edit(STUDY, "margin_m = 0.2", "margin_m = 0.02");
    assert_eq!(ends(&[]), (1, "no errors; 1 warning above".into()));
    folder.edit(
        STUDY,
        "center_m = [0.2, 0.3, 0.4], radius_m = 0.6",
        "center_m = [0.2, 0.3, 0.7], radius_m = 0.5",
    );
    assert_eq!(ends(&[]), (0, "no problems".into()));
    folder.edit(STUDY, "range_m = [0.2, 3.0]", "range_m = [2.9, 3.0]");
    folder.edit(STUDY, "range_m = [0.1, 5.0]", "range_m = [2.9, 3.0]");
    assert_eq!(ends(&[]), (2, "no errors; 2 warnings above".into()), "both see nothing");
    assert_eq!(ends(&["--poses", "0"]), (0, "no problems".into()), "nothing is cast");
}

/// Every error of a study and its scene at once: those of the files' own spelling, and those of what they say.
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
        "invalid type: string \"five\", expected u32",
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

#[test]
fn a_device_gives_what_the_study_does_not_say() {
    let folder = Folder::new();
    folder.edit(STUDY, CAMERA, "model = \"azure-kinect-nfov-binned\"\nresolution_px = [16, 9]\n");
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let model = manifest(&folder);
    let sensor = &model["study"]["sensor"][0];
    assert_eq!(sensor["range_m"], serde_json::json!([0.5, 5.46]));
    assert_eq!(sensor["resolution_px"], serde_json::json!([16, 9]));
    assert_eq!(sensor["model"], "azure-kinect-nfov-binned");
    // The same keys, written out, cast the same rays.
    let written = Folder::new();
    let keys = "kind = \"rgbd\"\nfov_deg = [75, 65]\nrange_m = [0.5, 5.46]\nnoise_std_m = 0.017\nresolution_px = [16, 9]\n";
    written.edit(STUDY, CAMERA, keys);
    assert_eq!(written.sweep(&[]).code, Some(0));
    let other = manifest(&written);
    assert_eq!(model["sensors"], other["sensors"]);
    let results = |folder: &Folder| fs::read_to_string(folder.path("out/results.csv")).unwrap();
    assert_eq!(results(&folder), results(&written));
}

#[test]
fn unknown_devices_are_refused() {
    for (keys, expected) in [
        (
            "model = \"realsense-d434\"\n",
            "sensor \"camera\".model = \"realsense-d434\": is no device of the catalogue (did you mean realsense-d435",
        ),
        ("model = 435\n", "sensor \"camera\".model = 435: must be a name, as in model = \"realsense-d435\""),
        (
            "model = \"zed-2\"\nkind = \"pad\"\n",
            "sensor \"camera\".kind = \"pad\": the model \"zed-2\" is of kind",
        ),
        ("model = \"zed-2\"\nrange_m = [3, 1]\n", "sensor \"camera\".range_m = [3.0, 1.0]: must be"),
        ("model = \"zed-2\"\nrings_deg = [0]\n", "sensor \"camera\": unknown field `rings_deg`"),
    ] {
        refused(&Folder::new(), &[(STUDY, CAMERA, keys)], &[STUDY, expected]);
    }
}

#[test]
fn a_camera_info_gives_resolution_and_field_of_view() {
    let folder = Folder::new();
    folder.write("left.yaml", INFO);
    folder.edit(STUDY, CAMERA, "kind = \"rgbd\"\ncamera_info = \"left.yaml\"\nrange_m = [0.2, 3.0]\n");
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(!outcome.stderr.contains("camera_info"), "{}", outcome.stderr);
    let calibrated = manifest(&folder);
    assert_eq!(calibrated["sensors"][0]["rays_per_pose"], 128);
    assert!(calibrated["files"]["left.yaml"].is_string(), "its hash decides the fingerprint");
    // 8 px of focal length across 16 are 90 degrees; down 8 they are 53.13.
    let written = Folder::new();
    let keys =
        "kind = \"rgbd\"\nfov_deg = [90, 53.13010235415598]\nresolution_px = [16, 8]\nrange_m = [0.2, 3.0]\n";
    written.edit(STUDY, CAMERA, keys);
    assert_eq!(written.sweep(&[]).code, Some(0));
    assert_eq!(calibrated["sensors"], manifest(&written)["sensors"]);
}

#[test]
fn a_camera_info_that_is_no_pinhole_is_told_or_refused() {
    let keys = "kind = \"rgbd\"\ncamera_info = \"left.yaml\"\nrange_m = [0.2, 3.0]\n";
    let folder = Folder::new();
    folder.write("left.yaml", INFO.replace("7.5", "8.5"));
    folder.edit(STUDY, CAMERA, keys);
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let warning = "sensor \"camera\": camera_info = \"left.yaml\": the principal point is +1.0 px across";
    assert!(outcome.stderr.contains(warning), "{}", outcome.stderr);
    assert!(manifest(&folder)["about"]["warnings"].to_string().contains("principal point"));
    for (info, more, expected) in [
        (INFO.replace("7.5", "2"), "", "left.yaml: the principal point is -5.5 px across"),
        (INFO.replace("[8, 0, 7.5", "[0, 0, 7.5"), "", "left.yaml: camera_matrix has fx = 0"),
        (INFO.replace("image_width: 16", ""), "", "left.yaml: "),
        (INFO.to_string(), "fov_deg = [90, 60]\n", "both camera_info and fov_deg: the file gives it"),
        (
            INFO.to_string() + "distortion_model: fisheye\n",
            "",
            "distortion_model = \"fisheye\": is no pinhole",
        ),
    ] {
        let folder = Folder::new();
        folder.write("left.yaml", info);
        refused(
            &folder,
            &[(STUDY, CAMERA, &format!("{keys}{more}"))],
            &[STUDY, "sensor \"camera\": ", expected],
        );
    }
    refused(&Folder::new(), &[(STUDY, CAMERA, keys)], &[STUDY, "camera_info: ", "left.yaml: cannot be read"]);
    let outside = keys.replace("left.yaml", "../left.yaml");
    let folder = Folder::new();
    let beside = folder.path("..").join("left.yaml");
    refused(&folder, &[(STUDY, CAMERA, &outside)], &["camera_info: ", "left.yaml"]);
    assert!(!beside.exists());
    refused(
        &Folder::new(),
        &[(STUDY, "kind = \"lidar\"", "kind = \"lidar\"\ncamera_info = \"left.yaml\"")],
        &[STUDY, "unknown field `camera_info`"],
    );
}

#[test]
fn devices_are_listed_with_their_sources() {
    let outcome = perirobot(&["sensors"]);
    assert_eq!(outcome.code, Some(0));
    for model in perirobot::study::catalogue::models() {
        assert!(outcome.stdout.lines().any(|line| line.starts_with(&model.name)), "{}", model.name);
        let one = perirobot(&["sensors", &model.name]);
        for part in [&model.source, &model.url, &model.note] {
            assert!(one.stdout.contains(part.as_str()), "{}", one.stdout);
        }
        // What is printed is TOML, so that it can be pasted.
        let keys: toml::Table =
            toml::from_str(&one.stdout.lines().take(6).collect::<Vec<_>>().join("\n")).unwrap();
        assert!(keys.is_empty() || keys["model"].is_str());
    }
    let outcome = perirobot(&["sensors", "OUSTER", "sick"]);
    assert!(["ouster-os1-128", "sick-nanoscan3"].iter().all(|name| outcome.stdout.contains(name)));
    let outcome = perirobot(&["sensors", "lighthouse"]);
    assert_eq!(outcome.code, Some(2));
    assert!(outcome.stderr.contains("no device has \"lighthouse\" in its name"), "{}", outcome.stderr);
}

#[test]
fn shells_and_man_know_every_subcommand() {
    let help = perirobot(&["--help"]).stdout;
    let commands =
        help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    let words = commands.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let commands: Vec<&str> =
        words.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help").collect();
    assert!(commands.len() >= 14, "{commands:?}");
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let outcome = perirobot(&["completions", shell]);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        for command in &commands {
            assert!(outcome.stdout.contains(command), "{shell}: {command}");
        }
    }
    assert_eq!(perirobot(&["completions", "tcl"]).code, Some(2));
    let folder = tempfile::tempdir().unwrap();
    let outcome = perirobot(&["man", text(&folder.path().join("man1"))]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let pages = program::names(&folder.path().join("man1"));
    assert!(
        outcome.stdout.starts_with(&format!("{} pages in ", pages.len())),
        "{}: {pages:?}",
        outcome.stdout
    );
    for command in &commands {
        let page = format!("perirobot-{command}.1");
        assert!(pages.contains(&page), "{page}");
        let roff = fs::read_to_string(folder.path().join("man1").join(page)).unwrap();
        assert!(roff.contains(".SH NAME"), "{command}");
    }
    fs::write(folder.path().join("file"), "").unwrap();
    let outcome = perirobot(&["man", text(&folder.path().join("file"))]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("file: cannot be made"), "{}", outcome.stderr);
}
