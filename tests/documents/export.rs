//! What `perirobot export` writes is what other programs take it for: OctoMap's own tools count the same
//! voxels, numpy finds the counts of the sweep. What cannot be looked at is refused.

use std::path::Path;
use std::process::Command;

use crate::common::program::{self, Folder, names, perirobot, text};
use crate::common::python;

/// A sensor whose volume comes from the host, and a combination of two.
const MORE: &str = r#"
[[sensor]]
name = "pad"
kind = "pad"
size_m = [0.6, 0.6]
height_m = 1.0
otherwise = "free"
[[sensor.poses]]
name = "floor"
x_m = [0.1]
y_m = -0.45
z_m = 0.0
[[combination]]
sensors = ["camera"]
[[combination]]
name = "both"
sensors = ["lidar", "pad"]
"#;

fn swept() -> Folder {
    let folder = Folder::new();
    folder.edit("study.toml", "range_m = [0.1, 5.0]", "range_m = [0.1, 5.0]\nnoise = { std_m = 0.05 }");
    folder.edit("study.toml", "", MORE);
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    folder
}

fn export(folder: &Folder, more: &[&str]) -> program::Outcome {
    let out = folder.path("out");
    perirobot(&[&["export", text(&out), "--backend", "cpu"], more].concat())
}

const POSES: &str = "lidar:posts/upright;pad:floor/0/0";

#[test]
fn octomap_counts_the_same_voxels() {
    let folder = swept();
    let outcome = export(&folder, &["--pose", POSES]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let out = folder.path("out/export/lidar-posts-upright-pad-floor-0-0.cell.points-volume");
    let expected = [
        "cell.glb",
        "evidence-lidar.bt",
        "evidence-pad.bt",
        "labels.bt",
        "points-lidar.pcd",
        "points-lidar.ply",
        "sensors.urdf",
        "transforms.sh",
        "truth.bt",
        "view.mcap",
        "view.npz",
    ];
    assert_eq!(names(&out), expected);
    let Some(convert) = tool("convert_octree") else { return };
    for name in ["labels", "truth", "evidence-lidar", "evidence-pad"] {
        let (from, to) = (out.join(name).with_extension("bt"), folder.path("tree.ot"));
        python::run(&convert, &[text(&from), text(&to)]).unwrap();
        let counted = leaves(&std::fs::read(&to).unwrap());
        let line = outcome.stdout.lines().find(|line| line.starts_with(&format!("{name}.bt "))).unwrap();
        let said = format!("{} voxels occupied, {} free", counted[1], counted[0]);
        assert!(line.ends_with(&said) && counted.iter().sum::<u64>() > 0, "{line}: the tool says {said}");
    }
}

/// A tool of OctoMap's; `None` and a note where it is not installed, a failure where
/// `PERIROBOT_REQUIRE_OCTOMAP=1` promises it.
fn tool(name: &str) -> Option<std::path::PathBuf> {
    // Without arguments it says how it is used, and fails.
    if Command::new(name).output().is_ok() {
        return Some(name.into());
    }
    let promised = std::env::var("PERIROBOT_REQUIRE_OCTOMAP").is_ok_and(|v| v == "1");
    assert!(!promised, "PERIROBOT_REQUIRE_OCTOMAP=1, but there is no {name} (Debian's octomap-tools)");
    eprintln!("SKIPPED: no {name} (Debian's octomap-tools)");
    None
}

/// How many voxels of an `.ot` file are free, and occupied: nodes are a log-odd and a byte of children each,
/// depth first.
fn leaves(file: &[u8]) -> [u64; 2] {
    let data = file.windows(6).position(|window| window == b"\ndata\n").unwrap() + 6;
    let mut counts = [0; 2];
    let rest = node(&file[data..], 16, &mut counts);
    assert!(rest.is_empty(), "{} bytes are left", rest.len());
    counts
}

fn node<'b>(bytes: &'b [u8], level: u32, counts: &mut [u64; 2]) -> &'b [u8] {
    let (value, rest) = bytes.split_first_chunk::<4>().unwrap();
    let (children, mut rest) = rest.split_first().unwrap();
    if *children == 0 {
        counts[usize::from(f32::from_le_bytes(*value) > 0.0)] += 8u64.pow(level);
    }
    for _ in 0..children.count_ones() {
        rest = node(rest, level - 1, counts);
    }
    rest
}

#[test]
fn numpy_finds_the_counts_of_the_sweep() {
    let Some(interpreter) = python::python() else { return };
    let folder = swept();
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/pandas/view.py");
    for poses in ["camera:wall/1/0", POSES] {
        let out = folder.path("view");
        let outcome = export(&folder, &["--pose", poses, "--out", text(&out)]);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        let results = folder.path("out/results.csv");
        python::run(&interpreter, &[script, text(&out), text(&results)]).unwrap();
        std::fs::remove_dir_all(&out).unwrap();
    }
}

#[test]
fn files_of_others_stay_and_ours_are_replaced() {
    let folder = swept();
    let out = folder.path("view");
    std::fs::create_dir(&out).unwrap();
    folder.write("view/notes.txt", "mine");
    folder.write("view/labels.bt", "old");
    let outcome = export(&folder, &["--pose", "wall/0/1", "--combination", "camera", "--out", text(&out)]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert_eq!(std::fs::read(out.join("notes.txt")).unwrap(), b"mine");
    assert!(std::fs::read(out.join("labels.bt")).unwrap().starts_with(b"# Octomap"));
    assert!(names(&out).iter().all(|name| !name.ends_with(".part")), "{:?}", names(&out));
}

#[test]
fn what_is_not_there_is_refused() {
    let folder = swept();
    folder.write("file", "");
    let file = folder.path("file");
    let cases: [(&[&str], &[&str]); 7] = [
        (
            &["--pose", "camera:nowhere/0/0"],
            &["--pose camera:nowhere/0/0", "column `poses`", "camera:wall/0/0"],
        ),
        (&["--pose", "wall/0/0", "--combination", "all"], &["--combination all", "there are camera, both"]),
        (&["--pose", "wall/0/0", "--representation", "box"], &["--representation box", "there are points"]),
        (&["--pose", "wall/0/0", "--scene", "hall"], &["--scene hall", "there are cell"]),
        (&["--pose", "wall/0/0", "--snapshot", "1"], &["--snapshot 1", "must be from 0 to 0"]),
        (&["--pose", "wall/0/0", "--out", ""], &["--out"]),
        (&["--pose", "wall/0/0", "--out", text(&file)], &["file", "(--out)"]),
    ];
    let refused = |more: &[&str], expected: &[&str]| {
        let outcome = export(&folder, more);
        assert_eq!(outcome.code, Some(2), "{more:?}: {}", outcome.stderr);
        for fragment in expected {
            assert!(outcome.stderr.contains(fragment), "{more:?}: no {fragment:?} in {}", outcome.stderr);
        }
        assert!(!folder.path("out/export").exists(), "{more:?}");
    };
    cases.iter().for_each(|(more, expected)| refused(more, expected));
    // A study that is no longer what was swept.
    folder.edit("study.toml", "fov_deg = [87, 58]", "fov_deg = [80, 58]");
    refused(&["--pose", "wall/0/0"], &["study.toml has changed since the sweep", "sweep again"]);
    let gone = perirobot(&["export", text(Path::new("/nowhere")), "--pose", "wall/0/0"]);
    assert_eq!(gone.code, Some(2), "{}", gone.stderr);
}
