//! Reports of the paper's three experiments, with fewer poses and coarse, one of ten thousand poses, one of
//! 262,144 choices, and the fronts of sets that were chosen, in a real browser: `browser/reports.py` opens and uses
//! them, and holds them to three megabytes. Not run by default, as it needs Debian's chromium
//! and chromium-driver, python3, and minutes: `cargo test --test documents browser -- --ignored`.
//! `PERIROBOT_PICTURES=FOLDER` keeps pictures of every section.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::program::{perirobot, text};
use crate::common::purchase;

/// Fewer rays and poses: what to look for, and what stands there instead.
const FEWER: [(&str, &str); 4] = [
    ("resolution_px = [1280, 720]", "resolution_px = [160, 90]"),
    ("step = 0.5 }", "step = 1.5 }"),
    ("resolution_deg = 0.7", "resolution_deg = 4"),
    ("z_m = [1.5, 2.0, 2.5]", "z_m = [1.5, 2.5]"),
];

/// More poses: 3,876 on the wall of the quick study and 6,561 on its ceiling.
const MORE: [(&str, &str); 5] = [
    ("resolution_px = [640, 360]", "resolution_px = [64, 36]"),
    (
        "x_m = { start = -2, stop = 2, step = 1 }\ny_m = -1.9",
        "x_m = { start = -2, stop = 2, step = 0.08 }\ny_m = -1.9",
    ),
    ("z_m = [1.5, 2.5]", "z_m = { start = 1, stop = 2.5, step = 0.04 }"),
    ("x_m = { start = -2, stop = 2, step = 1 }", "x_m = { start = -2, stop = 2, step = 0.05 }"),
    ("y_m = [-1, 0, 1]", "y_m = { start = -1.8, stop = 1.8, step = 0.045 }"),
];

/// Three sensors at 64 poses each, together: 262,144 choices.
fn three_at_64() -> String {
    let sensor = |name: &str| {
        format!(
            "[[sensor]]\nname = \"{name}\"\nkind = \"rgbd\"\nfov_deg = [87, 58]\nresolution_px = [64, 36]\nrange_m = [0.2, 3]\n\
             [[sensor.poses]]\nname = \"above\"\nfacing = [0, 0, -1]\nrandom = {{ count = 64, min_m = [-0.9, -0.6, 1.3], \
             max_m = [0.9, 0.6, 1.5], pan_deg = [-180, 180], tilt_deg = [-30, 30] }}\n"
        )
    };
    let sensors = ["a", "b", "c"].map(sensor).concat();
    format!(
        "seed = 7\n[grid]\nvoxel_size_m = 0.2\n[[scene]]\nfile = \"tiny/cell.toml\"\nname = \"tiny\"\n[[region]]\nname = \"robot\"\n\
         sphere = {{ center_m = [0.2, 0.3, 0.4], radius_m = 0.6 }}\n{sensors}\
         [[combination]]\nname = \"three\"\nsensors = [\"a\", \"b\", \"c\"]\n"
    )
}

/// The paper's studies in a folder, thinned out; the quick one with ten thousand poses; and that of many choices.
fn studies(folder: &Path) {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    for entry in fs::read_dir(scenes.join("paper")).unwrap() {
        let path = entry.unwrap().path();
        fs::copy(&path, folder.join(path.file_name().unwrap())).unwrap();
    }
    for name in ["exp1.toml", "exp2.toml", "exp3.toml"] {
        let whole = fs::read_to_string(folder.join(name)).unwrap();
        let thin = FEWER.iter().fold(whole, |text, (from, to)| text.replace(from, to));
        fs::write(folder.join(name), thin).unwrap();
    }
    let choose = fs::read_to_string(scenes.join("choose.toml")).unwrap();
    fs::write(folder.join("choose.toml"), choose.replace("paper/", "")).unwrap();
    let mut quick = fs::read_to_string(scenes.join("quick.toml")).unwrap().replace("paper/", "");
    for (from, to) in MORE {
        assert!(quick.contains(from), "{from}");
        quick = quick.replacen(from, to, 1);
    }
    fs::write(folder.join("many.toml"), quick).unwrap();
    fs::create_dir(folder.join("tiny")).unwrap();
    for entry in fs::read_dir(scenes.join("tiny")).unwrap() {
        let path = entry.unwrap().path();
        fs::copy(&path, folder.join("tiny").join(path.file_name().unwrap())).unwrap();
    }
    fs::write(folder.join("three.toml"), three_at_64()).unwrap();
    let purchase = purchase::STUDY.replace("\"cell.toml\"", "\"buy/cell.toml\"");
    for front in ["speed", "requirements"] {
        let study = format!("{purchase}[choose]\nfront = \"{front}\"\n");
        fs::write(folder.join(format!("cheapest-{front}.toml")), study).unwrap();
    }
    fs::create_dir(folder.join("buy")).unwrap();
    fs::copy(scenes.join("approach/cell.toml"), folder.join("buy/cell.toml")).unwrap();
}

/// Sweeps a study, or chooses its sets, and reports it; the page.
fn page(folder: &Path, command: &str, name: &str) -> PathBuf {
    let (study, out) = (folder.join(format!("{name}.toml")), folder.join(name));
    let coarse = ["--voxel-size", "0.1", "--backend", "cpu"];
    for arguments in [
        [&[command, text(&study), "--out", text(&out)][..], &coarse].concat(),
        vec!["report", text(&out), "--backend", "cpu", "--best", "5"],
    ] {
        let outcome = perirobot(&arguments);
        assert_eq!(outcome.code, Some(0), "{arguments:?}: {}", outcome.stderr);
    }
    out.join("report.html")
}

#[test]
#[ignore = "needs chromium, chromium-driver and python3"]
fn reports_of_the_paper_open_and_are_used_offline() {
    let folder = tempfile::tempdir().unwrap();
    studies(folder.path());
    let swept = ["exp1", "exp2", "exp3", "many", "three"].map(|name| page(folder.path(), "sweep", name));
    let chosen =
        ["choose", "cheapest-speed", "cheapest-requirements"].map(|name| page(folder.path(), "choose", name));
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/browser/reports.py");
    let mut command = Command::new("python3");
    command.arg(script).args(swept).args(chosen);
    if let Some(pictures) = std::env::var_os("PERIROBOT_PICTURES") {
        command.arg("--pictures").arg(pictures);
    }
    // Sensors alone: 10,437 poses of the camera and 12 of the LIDAR.
    let poses = fs::read_to_string(folder.path().join("many/poses.csv")).unwrap().lines().count() - 1;
    assert!(poses >= 10_000, "{poses}");
    let status = command.status().unwrap();
    assert!(status.success(), "tests/browser/reports.py: {status}; what it said is above");
}
