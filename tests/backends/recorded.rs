//! Maps and clouds that were recorded: what `export` writes, read back, scores as the sweep did, alone and fused
//! with sensors that are cast, on every backend; and what a user can get wrong about them.

use crate::common::{self, python};
use std::collections::HashMap;
use std::path::Path;
use std::process::Command;

use crate::common::program::{Folder, Outcome, perirobot, refused, text};
use perirobot_march::backend::{Backend, cpu::Cpu, gpu::Gpu, oracle::Oracle};
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;
use perirobot_sweep::scoring::run;

const POSE: &str = "lidar:posts/upright";

/// A sweep of the small study, and one of its poses as files.
fn exported() -> Folder {
    let folder = Folder::new();
    let swept = folder.sweep(&[]);
    assert_eq!(swept.code, Some(0), "{}", swept.stderr);
    let out = folder.path("out");
    let files = folder.path("files");
    let export = ["export", text(&out), "--backend", "cpu", "--pose", POSE, "--out", text(&files)];
    let outcome = perirobot(&export);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    folder
}

fn score(folder: &Folder, map: &str, more: &[&str]) -> Outcome {
    let (map, study, out) = (folder.path(map), folder.path("study.toml"), folder.path("scored.csv"));
    let outcome = perirobot(&[&["score", text(&map), text(&study), "--out", text(&out)], more].concat());
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    outcome
}

/// The rows of a table by region, each as its columns by name.
fn rows(
    table: &Path,
    of: impl Fn(&HashMap<String, String>) -> bool,
) -> HashMap<String, HashMap<String, String>> {
    let mut reader = csv::Reader::from_path(table).unwrap();
    let rows = reader.deserialize().map(|row: Result<HashMap<String, String>, _>| row.unwrap());
    rows.filter(of).map(|row| (row["region"].clone(), row)).collect()
}

const NAMES: [&str; 3] = ["combination", "poses", "representation"];

/// All columns but the names and some others.
fn counts(row: &HashMap<String, String>, but: &[&str]) -> Vec<(String, String)> {
    let mut all: Vec<_> = row.iter().map(|(name, value)| (name.clone(), value.clone())).collect();
    all.retain(|(name, _)| !NAMES.contains(&name.as_str()) && !but.contains(&name.as_str()));
    all.sort();
    all
}

#[test]
fn what_export_writes_scores_as_the_sweep_did() {
    let folder = exported();
    let swept = rows(&folder.path("out/results.csv"), |row| row["poses"] == POSE);
    assert_eq!(swept.len(), 3);
    let scored = |folder: &Folder| rows(&folder.path("scored.csv"), |_| true);
    for map in ["files/view.npz", "files/labels.bt", "files/evidence-lidar.bt"] {
        score(&folder, map, &[]);
        for (region, row) in scored(&folder) {
            assert_eq!(counts(&row, &[]), counts(&swept[&region], &[]), "{map}, region {region}");
            assert_ne!(row["tp"], "0");
        }
    }
    // A cloud holds the returns, not the rays that came to nothing: what it calls occupied is the same.
    let sensor = ["--sensor", "-0.9,0.6,0.9"];
    for (map, more) in [("files/points-lidar.ply", &sensor[..]), ("files/points-lidar.pcd", &[])] {
        score(&folder, map, more);
        for (region, row) in scored(&folder) {
            for column in ["tp", "fp", "hit_human", "parts_detected"] {
                assert_eq!(row[column], swept[&region][column], "{map}, {column} of region {region}");
            }
            assert_ne!(row["tn"], "0");
        }
    }
    // The truth, scored, is right about all that it knows.
    score(&folder, "files/truth.bt", &[]);
    assert!(scored(&folder).values().all(|row| row["fp"] == "0" && row["fn"] == "0" && row["uo"] == "0"));
    score(&folder, "files/truth.bt", &["--at", "0.1,0,0,0"]);
    assert!(scored(&folder).values().any(|row| row["fp"] != "0" && row["fn"] != "0"), "moved by a voxel");
}

#[test]
fn bags_are_what_other_code_takes_them_for_and_writes() {
    let Some(interpreter) = python::python() else { return };
    let folder = exported();
    let files = folder.path("files");
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/pandas/bag.py");
    python::run(&interpreter, &[script, text(&files)]).unwrap();
    let scored = |map: &str, more: &[&str]| {
        score(&folder, map, more);
        rows(&folder.path("scored.csv"), |_| true)
    };
    let cloud = scored("files/points-lidar.ply", &["--sensor", "-0.9,0.6,0.9"]);
    let called = |rows: &HashMap<String, HashMap<String, String>>, region: &str| {
        let of = |column: &str| rows[region][column].parse::<u64>().unwrap();
        of("tp") + of("fp")
    };
    for bag in ["view", "none", "lz4", "zstd"].map(|name| format!("files/{name}.mcap")) {
        let first = scored(
            &bag,
            &["--topic", if bag.contains("view") { "/lidar/points" } else { "/points" }, "--message", "0"],
        );
        for (region, row) in &first {
            for column in ["tp", "fp", "hit_human", "parts_detected"] {
                assert_eq!(row[column], cloud[region][column], "{bag}, {column} of region {region}");
            }
        }
        if bag.contains("view") {
            continue;
        }
        let (second, both) = (scored(&bag, &["--message", "1"]), scored(&bag, &[]));
        for region in cloud.keys() {
            let [one, other, all] = [&first, &second, &both].map(|rows| called(rows, region));
            assert!(
                all >= one.max(other) && all <= one + other,
                "{bag}, region {region}: {one} {other} {all}"
            );
        }
        assert_ne!(first["box"], second["box"], "{bag}");
    }
    let refused = |map: &str, more: &[&str], expected: &str| {
        let (map, study) = (folder.path(map), folder.path("study.toml"));
        let outcome = perirobot(&[&["score", text(&map), text(&study)], more].concat());
        assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
        assert!(outcome.stderr.contains(expected), "no {expected:?} in {}", outcome.stderr);
    };
    refused("files/zstd.mcap", &["--topic", "/cloud"], "must be of [\"/points\"]");
    refused("files/zstd.mcap", &["--message", "2"], "must be from 0 to 1");
    refused("files/labels.bt", &["--topic", "/points"], "asked of .mcap files only");
}

#[test]
fn the_two_trees_of_octomap_are_one_map() {
    if Command::new("convert_octree").output().is_err() {
        let promised = std::env::var("PERIROBOT_REQUIRE_OCTOMAP").is_ok_and(|v| v == "1");
        assert!(!promised, "PERIROBOT_REQUIRE_OCTOMAP=1, but there is no convert_octree");
        return common::say("SKIPPED: no convert_octree (Debian's octomap-tools)");
    }
    let folder = exported();
    let binary = score(&folder, "files/labels.bt", &[]);
    let (from, to) = (folder.path("files/labels.bt"), folder.path("files/labels.ot"));
    python::run(Path::new("convert_octree"), &[text(&from), text(&to)]).unwrap();
    let full = score(&folder, "files/labels.ot", &[]);
    let below = |outcome: &Outcome| outcome.stdout.split_once('\n').unwrap().1.to_string();
    assert_eq!(below(&full), below(&binary));
}

/// A recorded map as a sensor of the study, alone and with a camera.
const RECORDED: &str = r#"
[[sensor]]
name = "map"
kind = "recorded"
[[sensor.recording]]
file = "files/labels.bt"
[[combination]]
sensors = ["map"]
[[combination]]
sensors = ["lidar"]
[[combination]]
name = "map and camera"
sensors = ["map", "camera"]
[[combination]]
name = "lidar and camera"
sensors = ["lidar", "camera"]
[[combination]]
name = "map and camera by odds"
sensors = ["map", "camera"]
fusion = "octomap"
[[combination]]
name = "lidar and camera by odds"
sensors = ["lidar", "camera"]
fusion = "octomap"
"#;

#[test]
fn a_recorded_sensor_fuses_as_the_one_that_recorded_it_on_every_backend() {
    let folder = exported();
    folder.edit("study.toml", "", RECORDED);
    let study = Study::load(&folder.path("study.toml"), &Overrides::default()).unwrap();
    let worlds = World::prepare_all(&study).unwrap();
    let by = |backend: &mut dyn Backend| run(&study, &worlds, backend).unwrap();
    let all = by(&mut Oracle::default());
    assert_eq!(all, by(&mut Cpu::new(None).unwrap()));
    if let Some(adapter) = common::adapter() {
        assert_eq!(all, by(&mut Gpu::new(&adapter).unwrap()));
    }
    // Combination after combination: with the map there is one choice for each of the camera's, with the LIDAR
    // three, of which the first was recorded.
    let cameras = study.combinations[2].choices();
    let of = |combination: usize| all.iter().filter(move |row| row.combination == combination);
    for [map, lidar] in [[0, 1], [2, 3], [4, 5]] {
        let with_map: Vec<_> = of(map).map(|row| (row.choice, row.region, row.counts)).collect();
        let first = if map == 0 { 1 } else { cameras };
        let with_lidar: Vec<_> = of(lidar)
            .filter(|row| row.choice < first)
            .map(|row| (row.choice, row.region, row.counts))
            .collect();
        assert_eq!(with_map.len(), 3 * first);
        assert_eq!(with_map, with_lidar, "combination {map}");
    }
}

#[test]
fn the_screen_tells_what_the_map_makes_of_each_object() {
    let folder = exported();
    let outcome = score(&folder, "files/labels.bt", &[]);
    for expected in
        ["an OctoMap of ", "scene cell", "region human: labels of the map", "operator", "free space"]
    {
        assert!(outcome.stdout.contains(expected), "{expected}:\n{}", outcome.stdout);
    }
    let moved = score(&folder, "files/points-lidar.ply", &["--at", "0,0,0,3"]);
    // 3° about the vertical, as a quaternion.
    let turned = ["--at", "0,0,0,0.9996573249755573,0,0,0.026176948307873153"];
    assert_eq!(score(&folder, "files/points-lidar.ply", &turned).stdout, moved.stdout);
    // A frame on its side calls other voxels occupied.
    let tilted = score(&folder, "files/points-lidar.ply", &["--at", "0,0,0,0.99875,0.04994,0,0"]);
    assert_ne!(tilted.stdout, moved.stdout);
    assert!(moved.stdout.contains("measured from 0.000, 0.000, 0.000 m"), "{}", moved.stdout);
    // Why the rest is not called occupied adds up to it, and where the sensor was changes nothing but that.
    let seen = score(&folder, "files/labels.bt", &["--sensor", "-0.9,0.6,0.9"]);
    for (outcome, is_known) in [(&outcome, false), (&seen, true)] {
        let parts = outcome.stdout.split("\n\n").filter(|part| part.contains(": missed voxels, by reason\n"));
        let lines: Vec<&str> = parts.flat_map(str::lines).collect();
        let missed = rows(&folder.path("scored.csv"), |_| true);
        let missed: u64 =
            missed.values().flat_map(|row| [&row["fn"], &row["uo"]]).map(|n| n.parse::<u64>().unwrap()).sum();
        let all = lines.iter().filter(|line| line.starts_with("  all "));
        let told: u64 =
            all.flat_map(|line| line.split_whitespace().skip(1)).map(|n| n.parse::<u64>().unwrap()).sum();
        assert_eq!(told, missed, "{lines:#?}");
        let hidden = lines.iter().any(|line| line.starts_with("  hidden by "));
        let unknown = lines.iter().any(|line| line.contains("the sensor's position is unknown"));
        assert_eq!((hidden, unknown), (is_known, !is_known), "{lines:#?}");
    }
}

#[test]
fn wrong_recordings_are_refused() {
    let folder = exported();
    folder.edit("study.toml", "", RECORDED);
    let study = |from: &str, to: &str, expected: &[&str]| {
        let before = std::fs::read_to_string(folder.path("study.toml")).unwrap();
        refused(&folder, &[("study.toml", from, to)], expected);
        folder.write("study.toml", &before);
    };
    let file = "file = \"files/labels.bt\"";
    study(file, "file = \"files/none.bt\"", &["sensor \"map\".recording[0]", "file", "none.bt"]);
    study(
        file,
        "file = \"study.toml\"",
        &["study.toml", "must be a .bt, .ot, .npz, .pcd, .ply or .mcap file"],
    );
    study(
        file,
        &format!("{file}\nscene = \"hall\""),
        &["scene = \"hall\": must be a scene of the study: [\"cell\"]"],
    );
    study(file, &format!("{file}\nsnapshot = 1"), &["snapshot = 1: must be from 0 to 0"]);
    study(file, &format!("{file}\nyaw_deg = 400"), &["yaw_deg = 400: must be an angle"]);
    let turn = |q: &str| format!("{file}\nquaternion = {{ {q} }}");
    let yaw_too = format!("{}\nyaw_deg = 0", turn("w = 1, x = 0, y = 0, z = 0"));
    study(file, &yaw_too, &["both yaw_deg and quaternion", "give one of them"]);
    study(
        file,
        &turn("w = 0, x = 0, y = 0, z = 0"),
        &["quaternion = { w = 0, x = 0, y = 0, z = 0 }: must not be zero"],
    );
    study(file, &turn("w = 0.6, x = 0.8, y = 0, z = 0"), &["is a map", "turned about the vertical only"]);
    study(
        file,
        &format!("{file}\nposition_m = [50, 0, 0]"),
        &["sensor \"map\"", "says nothing inside the grid", "position_m"],
    );
    study(
        file,
        &format!("{file}\nsensor_m = [0, 0, 0]"),
        &["sensor_m = [0.0, 0.0, 0.0]: is asked of point clouds only, and the file is a map"],
    );
    study(
        file,
        &format!("{file}\n[[sensor.recording]]\n{file}"),
        &["recording[1]", "is of a moment that has a recording already"],
    );
    study(&format!("[[sensor.recording]]\n{file}"), "recording = []", &["recording", "add at least one"]);
    study(
        "",
        "[postures]\npeople = [\"standing\"]\nspots = [[0.5, 0.2, 0]]\n",
        &["postures and sensor \"map\"", "take one of them away"],
    );
    study(
        "name = \"map\"",
        "name = \"map\"\non = { object = \"arm\", link = \"hand\" }",
        &["on does not belong to a recorded"],
    );

    let (map, file) = (folder.path("files/labels.bt"), folder.path("study.toml"));
    for (more, expected) in [
        (vec!["--at", "1,2,3"], "must be x,y,z in metres and a yaw in degrees"),
        (vec!["--scene", "hall"], "hall"),
        (vec!["--snapshot", "3"], "must be from 0 to 0"),
        (vec!["--out", "scored.txt"], "must end in .csv or .parquet"),
        (vec!["--at", "0,0,0,0,0,0,0"], "must be x,y,z in metres and a yaw in degrees"),
        (vec!["--at", "0,0,0,0.6,0.8,0,0"], "turned about the vertical only"),
        (vec!["--at", "90,0,0,0"], "says nothing inside the grid"),
    ] {
        let outcome = perirobot(&[&["score", text(&map), text(&file)], &more[..]].concat());
        assert_eq!(outcome.code, Some(2), "{more:?}");
        assert!(outcome.stderr.contains(expected), "{more:?}: {}", outcome.stderr);
    }
}
