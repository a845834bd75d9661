//! A light curtain that latches, in the only opening of a fence: whom it counts as detected, and whether approach proves it.

use std::fs;

use crate::common::program::{Folder, perirobot, refused, rows, text};

/// A robot behind a fence with one opening 1 m wide at y = 0, and a person who has come in beside it.
const CELL: &str = "\
[[object]]
name = \"floor\"
plane = { size_m = [4, 3] }
[[object]]
name = \"robot\"
role = \"robot\"
cylinder = { radius_m = 0.2, height_m = 1.2 }
position_m = [-1.3, 0, 0.6]
[[object]]
name = \"left\"
box = { size_m = [0.1, 1.0, 2.3] }
position_m = [0.05, 1.0, 1.15]
[[object]]
name = \"right\"
box = { size_m = [0.1, 1.0, 2.3] }
position_m = [0.05, -1.0, 1.15]
[[object]]
name = \"carton\"
box = { size_m = [0.3, 0.3, 0.3] }
position_m = [1.5, 1.2, 0.15]
[object.snapshots]
position_m = [[1.5, 1.2, 0.15], [1.5, 0, 0.15]]
[[object]]
name = \"person\"
role = \"human\"
cylinder = { radius_m = 0.2, height_m = 1.7 }
position_m = [-0.6, 0.9, 0.9]
";

const STUDY: &str = "\
min_hits = 1
[grid]
voxel_size_m = 0.1
bounds_m = { min = [-2, -1.5, 0], max = [2, 1.5, 2.2] }
[[scene]]
file = \"cell.toml\"
[[region]]
name = \"inside\"
box = { min_m = [-2, -1.5, 0], max_m = [-0.1, 1.5, 2.2] }
[[sensor]]
name = \"curtain\"
kind = \"gate\"
box = { min_m = [0, -0.4, 0.1], max_m = [0.1, 0.5, 2.2] }
zone = { min_m = [-2, -1.5, 0], max_m = [0, 1.5, 2.2] }
latch = true
[[require]]
name = \"whoever is inside is detected\"
score = \"people_detected\"
region = \"inside\"
at_least = 1.0
[approach]
[[approach.body]]
name = \"standing\"
[[approach.entry]]
name = \"outside\"
box = { min_m = [1.0, -1.5, 0], max_m = [2.0, 1.5, 2.2] }
";

/// At the second moment the carton is in the curtain.
const CARTON_IN: (&str, &str, &str) = ("cell.toml", "[1.5, 0, 0.15]]", "[0.05, 0, 0.35]]");

/// The left part of the fence ends 60 cm from the wall.
const GAP: (&str, &str, &str) = (
    "cell.toml",
    "size_m = [0.1, 1.0, 2.3] }\nposition_m = [0.05, 1.0, 1.15]",
    "size_m = [0.1, 0.4, 2.3] }\nposition_m = [0.05, 0.7, 1.15]",
);

fn folder(edits: &[(&str, &str, &str)]) -> Folder {
    let folder = Folder::new();
    folder.write("study.toml", STUDY);
    folder.write("cell.toml", CELL);
    edits.iter().for_each(|(file, from, to)| folder.edit(file, from, to));
    folder
}

/// What `approach` says, and the curtains that are passed at the first moment, the second, and both at once.
fn approach(edits: &[(&str, &str, &str)]) -> (String, [String; 3]) {
    let folder = folder(edits);
    let (study, out) = (folder.path("study.toml"), folder.path("out"));
    let outcome = perirobot(&["approach", text(&study), "--pose", "here", "--out", text(&out)]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let rows = rows(&out.join("approach.csv"));
    let of = |snapshot: &str| {
        let is_asked = |row: &&std::collections::HashMap<String, String>| {
            row["snapshot"] == snapshot && row["people"] == "absent"
        };
        rows.iter().find(is_asked).unwrap()["latches_passed"].clone()
    };
    (outcome.stdout, ["0", "1", "*"].map(of))
}

const HOLDS: &str = "gets into the zone of \"curtain\" only by tripping it";
const FAILS: &str = "gets into the zone of \"curtain\" without";

#[test]
fn a_latch_at_the_only_opening_holds() {
    let (said, passed) = approach(&[]);
    assert!(said.contains(HOLDS) && !said.contains(FAILS), "{said}");
    assert_eq!(passed, ["", "", ""]);
}

#[test]
fn a_latch_beside_a_gap_does_not_hold() {
    let (said, passed) = approach(&[GAP]);
    assert!(said.contains(FAILS) && !said.contains(HOLDS), "{said}");
    assert_eq!(passed, ["curtain"; 3]);
}

#[test]
fn who_is_already_inside_defeats_a_latch() {
    let inside = (
        "study.toml",
        "box = { min_m = [1.0, -1.5, 0], max_m = [2.0, 1.5, 2.2] }",
        "box = { min_m = [-0.9, 0.3, 0], max_m = [-0.2, 1.3, 2.2] }",
    );
    let (said, passed) = approach(&[inside]);
    assert!(said.contains(FAILS), "{said}");
    assert_eq!(passed, ["curtain"; 3]);
}

/// The verdict on whether whoever is inside is detected.
fn verdict(edits: &[(&str, &str, &str)]) -> (Option<i32>, Vec<[String; 2]>) {
    let folder = folder(edits);
    let (study, out) = (folder.path("study.toml"), folder.path("out"));
    let outcome = perirobot(&["sweep", text(&study), "--backend", "cpu", "--out", text(&out)]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let each = rows(&out.join("results.csv"));
    let found = each.iter().map(|row| ["snapshot", "people_detected"].map(|column| row[column].clone()));
    let found = found.collect();
    let judged = perirobot(&["judge", text(&out)]);
    fs::remove_dir_all(out).unwrap();
    (judged.code, found)
}

#[test]
fn a_latch_detects_who_came_in() {
    let at = |values: [&str; 2]| {
        vec![["0", values[0]], ["1", values[1]]]
            .into_iter()
            .map(|row| row.map(String::from))
            .collect::<Vec<_>>()
    };
    assert_eq!(verdict(&[]), (Some(0), at(["1", "1"])));
    // Without a latch nobody is in the curtain, and the person behind it is not detected, though the carton trips it.
    assert_eq!(verdict(&[CARTON_IN]), (Some(0), at(["1", "1"])));
    assert_eq!(verdict(&[("study.toml", "latch = true\n", ""), CARTON_IN]), (Some(4), at(["0", "0"])));
}

/// Before anything is swept `check` says what states whether a latch holds.
#[test]
fn check_tells_what_proves_a_latch() {
    let said = |edits: &[(&str, &str, &str)]| {
        let folder = folder(edits);
        let outcome =
            perirobot(&["check", text(&folder.path("study.toml")), "--backend", "cpu", "--poses", "0"]);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        outcome.stderr
    };
    assert!(
        said(&[]).contains("sensor \"curtain\": latches: people in its zone count as detected on the way in")
    );
    assert!(said(&[]).contains("perirobot approach states whether there is another way in"));
    let approach = STUDY.split_once("[approach]").unwrap().1;
    let without = said(&[("study.toml", &format!("[approach]{approach}"), "")]);
    assert!(
        without.contains("add [approach], with an [[approach.entry]] where people come from"),
        "{without}"
    );
    assert!(!said(&[("study.toml", "latch = true\n", "")]).contains("latches"));
}

/// What speaks against verdicts stands beside them, wherever they are: on the screen, in judge.json, in JUnit and in the report.
#[test]
fn verdicts_tell_what_speaks_against_them() {
    let said = |edits: &[(&str, &str, &str)]| {
        let folder = folder(edits);
        let (study, out, junit) = (folder.path("study.toml"), folder.path("out"), folder.path("junit.xml"));
        let outcome = perirobot(&["sweep", text(&study), "--backend", "cpu", "--out", text(&out)]);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        let page = |out: &std::path::Path| {
            let reported = perirobot(&["report", text(out), "--backend", "cpu"]);
            assert_eq!(reported.code, Some(0), "{}", reported.stderr);
            fs::read_to_string(out.join("report.html")).unwrap()
        };
        let before = page(&out);
        let judged = perirobot(&["judge", text(&out), "--junit", text(&junit)]);
        let found: Vec<&str> = judged.stdout.lines().filter_map(|line| line.strip_prefix("BUT   ")).collect();
        let file: serde_json::Value =
            serde_json::from_slice(&fs::read(out.join("judge.json")).unwrap()).unwrap();
        let filed = file["sets"][0]["caveats"].as_array().map_or(Vec::new(), Vec::clone);
        assert_eq!(filed, found);
        let page = page(&out);
        assert_eq!(
            before.contains("its latch is not proven"),
            edits.iter().all(|edit| !edit.1.contains("latch"))
        );
        assert_eq!(page.contains("yes, but see below"), judged.code == Some(0) && !found.is_empty());
        for caveat in &found {
            let shown = caveat.replace('"', "&quot;");
            assert!(page.contains(&shown), "{caveat}");
            assert!(fs::read_to_string(&junit).unwrap().contains(&shown), "{caveat}");
        }
        found.join("\n")
    };
    let not_proven =
        "sensor \"curtain\": its latch is not proven: verdicts count people in its zone as detected";
    assert!(said(&[]).contains(not_proven));
    let near = (
        "study.toml",
        "[approach]",
        "[[require]]\nname = \"far\"\nscore = \"nearest_unnoticed_m\"\nat_least = 0.1\n[approach]",
    );
    assert_eq!(said(&[near]), "", "it holds");
    assert!(said(&[near, GAP]).contains(
        "its latch does not hold: without tripping it people get into its zone (standing from outside), and verdicts"
    ));
    assert_eq!(said(&[("study.toml", "latch = true\n", "")]), "");
    let low = ("study.toml", "max_m = [0.1, 0.5, 2.2] }\nzone", "max_m = [0.1, 0.5, 0.4] }\nzone");
    assert!(said(&[near, low]).contains("people step over it, since it ends 0.40 m above the floor"));
    // The carton trips the curtain at the second of two moments.
    let stuck = said(&[near, CARTON_IN]);
    assert!(stuck.contains("sensor \"curtain\": \"carton\" trips it at 1 of 2 moments"), "{stuck}");
}

#[test]
fn a_curtain_that_is_always_muted_is_told() {
    let said = |line: &str| {
        let folder = folder(&[("study.toml", "latch = true", line)]);
        let outcome =
            perirobot(&["check", text(&folder.path("study.toml")), "--backend", "cpu", "--poses", "0"]);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        format!("{}{}", outcome.stdout, outcome.stderr)
    };
    let always = said("muted_at = [0, 1]");
    assert!(always.contains("sensor \"curtain\": is muted at every moment of the scene"), "{always}");
    let once = said("muted_at = [1]");
    assert!(!once.contains("is muted at every moment"), "{once}");
}

#[test]
fn muting_that_cannot_be() {
    let wrong = |line: &str, expected: &str| {
        let edit = ("study.toml", "latch = true", line);
        refused(&folder(&[]), &[edit], &["study.toml: sensor \"curtain\"", expected]);
    };
    wrong(
        "muted_by = [\"karton\"]",
        "muted_by = [\"karton\"]: must be objects of a scene: [\"carton\", \"floor\"",
    );
    wrong("muted_at = [2]", "muted_at = [2]: must be snapshots of a scene, from 0 to 1");
    wrong("latch = 1", "latch");
    wrong("muted_by = [\"person\"]", "muted_by = [\"person\"]: must not be a person");
    wrong("latch = true\nmuted_at = [1]", "both latch and muting: people who come in while it is muted");
}
