//! Moving scenes through the program: a result a snapshot, warnings once a scene, and what a user can get
//! wrong.

use std::fs;

use crate::common::program::{Edit, Folder, perirobot, refused, text};

const SCENE: &str = "cell.toml";
/// The robot's arm is held level in the second snapshot, and the operator steps aside.
const MOVING: [Edit; 2] = [
    (
        SCENE,
        "quaternion = { w = 1, x = 0, y = 0, z = 0 }",
        "[object.snapshots]\nrpy_deg = [[0, 0, 0], [90, 0, 0]]\ncycle = true",
    ),
    (
        SCENE,
        "",
        "[object.snapshots]\nposition_m = [[0.1, -0.45, 0.65], [-0.4, -0.45, 0.65], [0.1, -0.45, 0.65]]\n",
    ),
];

fn moving() -> Folder {
    let folder = Folder::new();
    for (file, from, to) in MOVING {
        folder.edit(file, from, to);
    }
    folder
}

/// Rows of results.csv with the snapshot's column taken out, by that column.
fn by_snapshot(folder: &Folder) -> Vec<Vec<String>> {
    let table = fs::read_to_string(folder.path("out/results.csv")).unwrap();
    let mut lines = table.lines();
    assert!(lines.next().unwrap().starts_with("scene,snapshot,"), "{table}");
    let mut snapshots: Vec<Vec<String>> = Vec::new();
    for line in lines {
        let (scene, rest) = line.split_once(',').unwrap();
        let (snapshot, rest) = rest.split_once(',').unwrap();
        let snapshot: usize = snapshot.parse().unwrap();
        snapshots.resize(snapshots.len().max(snapshot + 1), Vec::new());
        snapshots[snapshot].push(format!("{scene},{rest}"));
    }
    snapshots
}

#[test]
fn every_snapshot_has_its_results() {
    let still = Folder::new();
    assert_eq!(still.sweep(&[]).code, Some(0));
    let folder = moving();
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let (still, moving) = (by_snapshot(&still), by_snapshot(&folder));
    assert_eq!((still.len(), moving.len()), (1, 3));
    assert_eq!(moving[0], still[0], "the first snapshot is the scene as it was");
    assert_ne!(moving[1], moving[0]);
    assert_eq!(moving[2], moving[0], "both are back");
    assert_eq!(moving[1].len(), moving[0].len());
}

#[test]
fn a_warning_is_given_once_for_all_snapshots() {
    let folder = moving();
    folder.edit(SCENE, "role = \"human\"", "");
    folder.edit(
        "study.toml",
        "human_box = { object = \"operator\", margin_m = 0.2 }",
        "sphere = { center_m = [0, 0, 0], radius_m = 0.5 }",
    );
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let warning = "no object has role = \"human\"";
    assert_eq!(outcome.stderr.matches(warning).count(), 1, "{}", outcome.stderr);
    // A pose that the arm reaches in one snapshot only says in which.
    let folder = moving();
    folder.edit("study.toml", "position_m = [0.1, 0.1, 1.3]", "position_m = [0.2, 0.58, 0.45]");
    let outcome = folder.sweep(&[]);
    let expected = "sensor \"lidar\": 1 poses (first posts/corner: at crate, x 0.2 m, y 0.58 m, 0.45 m high, level) stand in an occupied voxel (move them out of it): their rays start behind \
                    its surface (in snapshot 1, where it is most)";
    assert!(outcome.stderr.contains(expected), "{}", outcome.stderr);
}

#[test]
fn one_snapshot_is_written_as_a_map() {
    let folder = moving();
    let write = |snapshot: &str, name: &str| {
        let (scene, out) = (folder.path(SCENE), folder.path(name));
        perirobot(&[
            "voxelize",
            text(&scene),
            "--out",
            text(&out),
            "--voxel-size",
            "0.1",
            "--snapshot",
            snapshot,
        ])
    };
    for (snapshot, name) in [("0", "a.bt"), ("1", "b.bt"), ("2", "c.bt")] {
        let outcome = write(snapshot, name);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    }
    let bytes = |name: &str| fs::read(folder.path(name)).unwrap();
    assert_ne!(bytes("a.bt"), bytes("b.bt"));
    assert_eq!(bytes("a.bt"), bytes("c.bt"));
    let outcome = write("3", "d.bt");
    assert_eq!(outcome.code, Some(2));
    assert!(
        outcome.stderr.contains("--snapshot 3") && outcome.stderr.contains("has 3"),
        "{}",
        outcome.stderr
    );
}

#[test]
fn what_is_wrong_is_refused() {
    let longer = "position_m = [[0.1, -0.45, 0.65], [-0.4, -0.45, 0.65], [0.1, -0.45, 0.65]]";
    for (from, to, expected) in [
        (
            "\ncycle = true",
            "",
            "object \"operator\".snapshots: position_m has 3 entries, but object \"arm\".snapshots.",
        ),
        (longer, "position_m = []", "object \"operator\".snapshots.position_m = []"),
        (longer, "", "object \"operator\".snapshots: no list"),
        (longer, "keypoints = [\"a.csv\", \"b.csv\"]", "object \"operator\": keypoints = "),
        (longer, "animation = { times_s = [0] }", "animation belongs to"),
        (
            "cylinder = { radius_m = 0.15, height_m = 1.2 }",
            "mesh = \"gone.glb\"",
            "object \"operator\": mesh = ",
        ),
        (
            "role = \"human\"",
            "role = \"human\"\nkeypoints = \"gone.csv\"",
            "object \"operator\": keypoints = ",
        ),
        (
            "role = \"robot\"",
            "role = \"robot\"\nkeypoints = \"gone.csv\"",
            "object \"arm\": keypoints are a human's",
        ),
    ] {
        refused(&moving(), &[(SCENE, from, to)], &[SCENE, expected]);
    }
    // Rows are counted for joints as for a mannequin, and one joint at least must be known.
    for (rows, expected) in [
        (",,\n".repeat(17), "all joints are empty"),
        (",,\n".repeat(16), "has 16 joints: layout \"coco-17\" has 17"),
    ] {
        let folder = moving();
        folder.write("a.csv", rows);
        let edit = (SCENE, "role = \"human\"", "role = \"human\"\nkeypoints = \"a.csv\"");
        refused(&folder, &[edit], &["object \"operator\": keypoints = ", "a.csv", expected]);
    }
    // A pose outside bounds_m, and an object that leaves them, are as in a scene that stands still.
    let folder = moving();
    folder.edit(SCENE, "[-0.4, -0.45, 0.65]", "[-0.4, -4.5, 0.65]");
    folder.edit("study.toml", "[grid]", "[grid]\nbounds_m = { min = [-1.3, -1, -0.1], max = [1.3, 1, 1.7] }");
    let outcome = folder.sweep(&[]);
    let expected =
        "scene \"cell\", snapshot 1: region \"human\": human_box: no voxel of a human lies in the grid";
    assert!(outcome.code == Some(2) && outcome.stderr.contains(expected), "{}", outcome.stderr);
}
