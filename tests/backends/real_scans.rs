//! Maps and a scan that real sensors recorded, end to end, where they are at hand: `PERIROBOT_REAL_SCANS` names a folder with
//! `geb079.bt` (a building) and `scan.dat` (a laser scan, 88,206 points), both of OctoMap's `share/data`, as the source
//! distribution of PyPI's `octomap-python` has them. The scan is carved by OctoMap's own programs, too.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common;
use crate::common::program::{Folder, perirobot, text};

const SCENE: &str = "[[object]]\nname = \"building\"\noctomap = \"map.bt\"\n";

const STUDY: &str = r#"[grid]
voxel_size_m = 0.1
bounds_m = [[-8, -8, -1], [8, 8, 3]]
[[scene]]
file = "cell.toml"
[[region]]
name = "all"
box = { min_m = [-8, -8, -1], max_m = [8, 8, 3] }
[[sensor]]
name = "lidar"
kind = "lidar"
fov_deg = [360, 30]
resolution_deg = [10, 10]
range_m = [0.1, 5]
[[sensor.poses]]
name = "here"
list = [{ name = "a", position_m = [0, 0, 0], facing = [1, 0, 0] }]
"#;

fn real(name: &str) -> Option<PathBuf> {
    match std::env::var_os("PERIROBOT_REAL_SCANS") {
        Some(folder) => Some(Path::new(&folder).join(name)),
        None => {
            common::say(&format!(
                "SKIPPED: PERIROBOT_REAL_SCANS names no folder with {name}, so no real scan is read"
            ));
            None
        }
    }
}

/// What a recording is worth against a map of voxels of a size.
fn scored(voxel_size_m: &str, map: &Path, recording: &Path) -> HashMap<String, u64> {
    let folder = Folder::new();
    fs::copy(map, folder.path("map.bt")).unwrap();
    folder.write("cell.toml", SCENE);
    folder.write("study.toml", STUDY.replacen("0.1", voxel_size_m, 1));
    let (study, out) = (folder.path("study.toml"), folder.path("scored.csv"));
    let outcome = perirobot(&["score", text(recording), text(&study), "--out", text(&out)]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let mut table = csv::Reader::from_path(out).unwrap();
    let row: HashMap<String, String> = table.deserialize().next().unwrap().unwrap();
    ["tp", "fp", "fn", "tn", "uo", "uf"].map(|name| (name.to_string(), row[name].parse().unwrap())).into()
}

#[test]
fn the_map_of_a_building_is_right_about_itself() {
    let Some(map) = real("geb079.bt") else { return };
    let counts = scored("0.08", &map, &map);
    println!("{counts:?}");
    assert!(counts["tp"] > 10_000 && counts["tn"] > 10_000, "{counts:?}");
    assert_eq!(["fp", "fn", "uo"].map(|name| counts[name]), [0; 3], "{counts:?}");
}

#[test]
fn a_laser_scan_is_carved_as_octomap_does() {
    let Some(scan) = real("scan.dat") else { return };
    let folder = Folder::new();
    let points = fs::read_to_string(scan).unwrap();
    folder.write("scan.log", format!("NODE 0 0 0 0 0 0\n{points}"));
    let run = |program: &str, arguments: &[&str]| {
        let output = Command::new(program).args(arguments).output();
        let output = output.unwrap_or_else(|e| panic!("{program} (Debian's octomap-tools): {e}"));
        assert!(output.status.success(), "{program}: {}", String::from_utf8_lossy(&output.stderr));
    };
    let [log, graph, tree] = ["scan.log", "scan.graph", "scan.bt"].map(|name| folder.path(name));
    run("log2graph", &[text(&log), text(&graph)]);
    run("graph2tree", &["-i", text(&graph), "-o", text(&tree), "-res", "0.1"]);
    let count = points.lines().count();
    let header = format!(
        "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {count}\nHEIGHT 1\n\
         VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA ascii\n"
    );
    folder.write("scan.pcd", header + &points);
    let ours = scored("0.1", &tree, &folder.path("scan.pcd"));
    let theirs = scored("0.1", &tree, &tree);
    println!("{ours:?}\n{theirs:?}");
    // OctoMap reads the points as float32 and we as text, which moves some across a voxel's side; no more may differ.
    let beside = ours["fp"] + ours["fn"] + ours["uo"];
    assert!(ours["tp"] > 10_000 && beside * 1000 < ours["tp"], "{ours:?}");
    assert!(
        ours["tn"] > 100_000 && ours["tn"].abs_diff(theirs["tn"]) * 1000 < theirs["tn"],
        "{ours:?} {theirs:?}"
    );
}
