//! Lists that are right, and every way in which they can be wrong.

use std::path::Path;

use super::*;
use crate::scene::spec::SceneSpec;

const BOX: &str = "box = { size_m = [1, 1, 1] }";

/// A scene of objects, each with its surface and its `[object.snapshots]`.
fn scene(objects: &[(&str, &str, &str)]) -> Result<SceneSpec> {
    let text = objects.iter().map(|(name, surface, lists)| {
        format!("[[object]]\nname = {name:?}\n{surface}\n[object.snapshots]\n{lists}\n")
    });
    SceneSpec::parse(Path::new("cell.toml"), text.collect()).map_err(crate::Error::first)
}

#[track_caller]
fn refused(objects: &[(&str, &str, &str)], expected: &str) {
    let error = scene(objects).expect_err(expected).to_string();
    assert!(error.starts_with("cell.toml: ") && error.contains(expected), "no {expected:?} in {error}");
}

#[test]
fn a_scene_has_as_many_snapshots_as_its_lists() {
    let count = |objects: &[(&str, &str, &str)]| scene(objects).unwrap().snapshots;
    let still = "[[object]]\nname = \"a\"\nbox = { size_m = [1, 1, 1] }\n";
    assert_eq!(SceneSpec::parse(Path::new("cell.toml"), still.into()).unwrap().snapshots, 1);
    let three = "rpy_deg = [[0, 0, 0], [0, 0, 1], [0, 0, 2]]";
    let two = "cycle = true\nposition_m = [[0, 0, 0], [1, 0, 0]]";
    assert_eq!(count(&[("a", BOX, three)]), 3);
    assert_eq!(count(&[("b", BOX, two), ("a", BOX, three)]), 3);
    assert_eq!(count(&[("b", BOX, two)]), 2);
    assert_eq!(count(&[("b", BOX, two), ("c", BOX, &format!("cycle = true\n{three}"))]), 3);
    let times = "animation = { times_s = { start = 0, stop = 0.3, step = 0.1 } }";
    assert_eq!(count(&[("walk", "mesh = \"walk.glb\"", times)]), 4);
}

/// Against the same scene with its lists written by hand.
#[test]
fn crossed_lists_meet_every_moment_of_the_rest() {
    let (arm, light) =
        ("rpy_deg = [[0, 0, 0], [0, 0, 9], [0, 0, 5]]", "cycle = true\nrpy_deg = [[0, 0, 1], [0, 0, 2]]");
    let person = "cross = true\nposition_m = [[0, 0, 0], [1, 0, 0]]\nrpy_deg = [[0, 0, 7], [0, 0, 8]]";
    let door = "cross = true\nposition_m = [[0, 0, 0], [0, 2, 0]]";
    let crossed = scene(&[("a", BOX, arm), ("p", BOX, person), ("l", BOX, light), ("d", BOX, door)]).unwrap();
    let times = |entries: &[&str], each: usize| {
        let all: Vec<&str> = entries.iter().flat_map(|entry| vec![*entry; each]).collect();
        all.join(", ")
    };
    let arm = format!("rpy_deg = [{}]", [times(&["[0, 0, 0], [0, 0, 9], [0, 0, 5]"], 4)].concat());
    let light = format!("rpy_deg = [{}]", times(&["[0, 0, 1], [0, 0, 2], [0, 0, 1]"], 4));
    let of_person = |one: &str, other: &str| {
        let half = times(&[one, other], 3);
        format!("[{half}, {half}]")
    };
    let person = format!(
        "position_m = {}\nrpy_deg = {}",
        of_person("[0, 0, 0]", "[1, 0, 0]"),
        of_person("[0, 0, 7]", "[0, 0, 8]")
    );
    let door = format!("position_m = [{}]", times(&["[0, 0, 0]", "[0, 2, 0]"], 6));
    let by_hand =
        scene(&[("a", BOX, &arm), ("p", BOX, &person), ("l", BOX, &light), ("d", BOX, &door)]).unwrap();
    assert_eq!((crossed.snapshots, by_hand.snapshots), (12, 12));
    for snapshot in 0..12 {
        for (crossed, by_hand) in crossed.objects.iter().zip(&by_hand.objects) {
            assert_eq!(crossed.at(snapshot), by_hand.at(snapshot), "snapshot {snapshot} of {}", by_hand.name);
        }
    }
    // Alone it is a list like any other.
    assert_eq!(
        scene(&[("d", BOX, "cross = true\nposition_m = [[0, 0, 0], [0, 2, 0]]")]).unwrap().snapshots,
        2
    );
}

#[test]
fn lists_that_cannot_be_crossed_are_told() {
    let two = "position_m = [[0, 0, 0], [1, 0, 0]]";
    let unequal = format!("cross = true\n{two}\nrpy_deg = [[0, 0, 0]]");
    refused(
        &[("a", BOX, &unequal)],
        "object \"a\".snapshots: rpy_deg or quaternion has 1 entries, but position_m has 2: all lists of an object \
         that is crossed",
    );
    refused(&[("a", BOX, &format!("cross = true\ncycle = true\n{two}"))], "both cycle and cross");
    let many = |key: &str| format!("{key}position_m = [{}]", vec!["[0, 0, 0]"; 200].join(", "));
    refused(
        &[("a", BOX, &many("")), ("b", BOX, &many("cross = true\n"))],
        "object \"b\".snapshots: its 200 entries make 40000 snapshots with the rest: at most 10000 can be",
    );
}

#[test]
fn lists_of_unequal_length_name_both_and_the_cure() {
    let (two, three) = ("position_m = [[0, 0, 0], [1, 0, 0]]", "rpy_deg = [[0, 0, 0], [0, 0, 1], [0, 0, 2]]");
    refused(
        &[("a", BOX, two), ("b", BOX, three)],
        "object \"b\".snapshots: rpy_deg or quaternion has 3 entries, but object \"a\".snapshots.position_m has 2: \
         all lists of a scene must be equally long, or those of an object repeat with cycle = true",
    );
    refused(
        &[("a", BOX, &format!("{two}\n{three}"))],
        "object \"a\".snapshots: rpy_deg or quaternion has 3 entries",
    );
    let times = "animation = { times_s = [0.5] }";
    refused(
        &[("a", BOX, two), ("walk", "mesh = \"walk.glb\"", times)],
        "object \"walk\".snapshots: animation.times_s has 1 entries, but",
    );
    refused(
        &[("a", BOX, two), ("b", BOX, &format!("cycle = true\n{three}"))],
        "object \"b\".snapshots: rpy_deg or quaternion has 3 entries, but object \"a\".snapshots.position_m has 2: the \
         rest of a list that repeats would never be seen",
    );
}

#[test]
fn wrong_entries_are_named_by_their_place() {
    for (surface, lists, expected) in [
        (BOX, "position_m = []", "object \"a\".snapshots.position_m = []: must have one entry a snapshot"),
        (BOX, "rpy_deg = []", "snapshots.rpy_deg = []"),
        (BOX, "quaternion = []", "snapshots.quaternion = []"),
        (BOX, "", "object \"a\".snapshots: no list: give at least one of position_m"),
        (BOX, "cycle = true", "object \"a\".snapshots: no list"),
        (BOX, "position_m = [[0, 0, 0], [0, 0]]", "a list of 3 numbers"),
        (BOX, "position_m = [[0, 0, 0, 0]]", "a list of 3 numbers"),
        (BOX, "position_m = [[0, 0, 0], [0, nan, 0]]", "snapshots.position_m[1] = [0.0, NaN, 0.0]"),
        (BOX, "rpy_deg = [[0, 0, inf]]", "snapshots.rpy_deg[0] = [0.0, 0.0, inf]"),
        (
            BOX,
            "quaternion = [{ w = 0, x = 0, y = 0, z = 0 }]",
            "snapshots.quaternion[0] = [0.0, 0.0, 0.0, 0.0]: must",
        ),
        (
            BOX,
            "rpy_deg = [[0, 0, 0]]\nquaternion = [{ w = 1, x = 0, y = 0, z = 0 }]",
            "both rpy_deg and quaternion",
        ),
        (BOX, "positions_m = [[0, 0, 0]]", "positions_m"),
        (BOX, "animation = { times_s = [0] }", "animation belongs to a .glb or .gltf mesh"),
        (BOX, "mannequin = [\"a.csv\"]", "both box and mannequin: give one surface"),
        (BOX, "mannequin = []", "snapshots.mannequin = []"),
        (BOX, "keypoints = [\"a.csv\"]", "keypoints are a human's joints: add role = \"human\""),
        ("mannequin = \"a.csv\"", "keypoints = [\"a.csv\"]", "a mannequin's are its own"),
        ("role = \"human\"\nbox = { size_m = [1, 1, 1] }", "keypoints = []", "snapshots.keypoints = []"),
        ("octomap = \"a.bt\"", "position_m = [[0, 0, 0]]", "an octomap stays where it is"),
        ("octomap = \"a.bt\"", "rpy_deg = [[0, 0, 0]]", "an octomap stays where it is"),
        ("mesh = \"a.glb\"", "animation = { clip = \"walk\" }", "times_s"),
        (
            "mesh = \"a.glb\"",
            "animation = { times_s = [] }",
            "snapshots.animation.times_s = []: must be at least one",
        ),
        ("mesh = \"a.glb\"", "animation = { times_s = [nan] }", "snapshots.animation.times_s = NaN"),
        (
            "mesh = \"a.glb\"",
            "animation = { times_s = { start = 1, stop = 0, step = 0.1 } }",
            "snapshots.animation.times_s = { start = 1, stop = 0, step = 0.1 }: step must be above 0",
        ),
        (
            "mesh = \"a.glb\"",
            "animation = { times_s = { start = 0, stop = 1000, step = 0.01 } }",
            "animation.times_s = (100001 entries): must have at most 10000",
        ),
    ] {
        refused(&[("a", surface, lists)], expected);
    }
}

#[test]
fn an_octomap_of_a_human_may_have_joints_that_move() {
    let lists = "keypoints = [\"a.csv\", \"b.csv\"]";
    let spec = scene(&[("a", "role = \"human\"\noctomap = \"a.bt\"", lists)]).unwrap();
    assert_eq!(spec.objects[0].at(1).keypoints, Some(PathBuf::from("b.csv")));
    assert_eq!(spec.objects[0].at(1).surface, spec.objects[0].surface);
}
