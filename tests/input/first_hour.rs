//! What a user meets first: `init`, `sensors`, a device by its name, a camera by its calibration, completions
//! and manual pages.

use std::fs;

use crate::common::program::{self, Folder, perirobot, refused, text};
use serde_json::Value;

const STUDY: &str = "study.toml";

/// The keys of the camera of the small study that a device or a calibration may give instead.
const CAMERA: &str = "kind = \"rgbd\"\nfov_deg = [87, 58]\nresolution_px = [16, 9]\nrange_m = [0.2, 3.0]\n";

const INFO: &str =
    "image_width: 16\nimage_height: 8\ncamera_matrix: { data: [8, 0, 7.5, 0, 8, 3.5, 0, 0, 1] }\n";

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
    assert!(outcome.stdout.contains("\nno problems\nnext: perirobot "), "{}", outcome.stdout);
    let out = home.join("out");
    let outcome = perirobot(&["sweep", text(&study), "--out", text(&out), "--backend", "cpu"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    // 39 poses of the camera, 2 of the lidar, 39 with the mat; two snapshots, two regions.
    assert_eq!(fs::read_to_string(out.join("results.csv")).unwrap().lines().count(), 1 + 80 * 2 * 2);
}

/// Files may not grow beyond a limit, as on a full disk: what was written is taken away, so that the same command works
/// when there is room.
#[test]
fn init_on_a_full_disk_leaves_nothing_in_its_own_way() {
    let folder = tempfile::tempdir().unwrap();
    for home in [folder.path().join("new/cell"), folder.path().to_path_buf()] {
        let init = |limit: &str| {
            let script = format!("trap '' XFSZ; {limit} exec \"$@\"");
            let words = ["-c", &script, "sh", env!("CARGO_BIN_EXE_perirobot"), "init", text(&home)];
            std::process::Command::new("sh").args(words).output().unwrap()
        };
        // Room for all files but the last.
        let full = init("ulimit -f 100;");
        let said = String::from_utf8(full.stderr).unwrap();
        assert_eq!(full.status.code(), Some(3), "{said}");
        assert!(said.contains("cannot be written") && said.contains("run the same command again"), "{said}");
        assert_eq!(program::names(folder.path()), [""; 0], "nothing is left");
        assert_eq!(init("").status.code(), Some(0));
        if home != folder.path() {
            fs::remove_dir_all(folder.path().join("new")).unwrap();
        }
    }
}

#[test]
fn init_overwrites_nothing() {
    for name in ["study.toml", "robot.urdf"] {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(name), "mine").unwrap();
        let outcome = perirobot(&["init", text(folder.path())]);
        assert_eq!(outcome.code, Some(2));
        let what = format!("{name}: exists and would be overwritten: name another folder");
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
    let keys = "kind = \"rgbd\"\nfov_deg = [75, 65]\nrange_m = [0.5, 5.46]\nrange_along = \"axis\"\nnoise = { std_m = 0.017 }\nresolution_px = [16, 9]\n";
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
            "sensor \"camera\".model = \"realsense-d434\": is not in the catalogue (did you mean realsense-d435",
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
    for model in perirobot_study::input::catalogue::models() {
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
    // What a device can do stands in its line, in columns.
    for expected in [
        "realsense-d435                rgbd  87 x 58      848 x 480 px   0.3-3      1.4 cm        314 USD",
        "velodyne-vlp-16               lidar 360 x 30     0.2 deg        0.5-100    3.0 cm        3999 USD",
        "sick-s300                     lidar 270 x 0      541 beams      0.05-2     unknown",
        "safety-mat                    pad",
    ] {
        assert!(outcome.stdout.lines().any(|line| line == expected), "{expected}\n{}", outcome.stdout);
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
    let groups = help.lines().skip_while(|line| *line != "Start:").take_while(|line| *line != "Options:");
    let lines = groups.filter(|line| line.starts_with("  "));
    let commands: Vec<&str> = lines.filter_map(|line| line.split_whitespace().next()).collect();
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
