//! A radar behind a plastic cover in front of a robot: who moves is detected, who stands still is not.

use std::path::PathBuf;

use crate::common::program::{Folder, perirobot, refused, rows, text};

/// A robot, a plate beside it with a radar behind it, and a person before it.
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
name = \"plate\"
box = { size_m = [0.1, 0.6, 2.0] }
position_m = [-0.85, 1.0, 1.0]
radar = \"passes\"
[[object]]
name = \"person\"
role = \"human\"
cylinder = { radius_m = 0.2, height_m = 1.7 }
position_m = [0.5, 0.5, 0.9]
speed_m_s = 0.5
";

const STUDY: &str = "\
min_hits = 1
[grid]
voxel_size_m = 0.1
bounds_m = { min = [-2, -1.5, 0], max = [2, 1.5, 2.2] }
[[scene]]
file = \"cell.toml\"
[[region]]
name = \"before\"
box = { min_m = [-0.7, -1.5, 0], max_m = [2, 1.5, 2.2] }
[[sensor]]
name = \"radar\"
kind = \"radar\"
fov_deg = [100, 30]
range_m = [0, 4]
min_speed_m_s = 0.1
[[sensor.poses]]
name = \"post\"
list = [{ name = \"left\", position_m = [-1.25, 1.0, 1.15], facing = [1, 0, 0], pan_deg = -20 }]
[[require]]
name = \"whoever comes is detected\"
score = \"people_detected\"
region = \"before\"
at_least = 1.0
[approach]
[[approach.body]]
name = \"standing\"
[[approach.entry]]
name = \"outside\"
box = { min_m = [1.6, -1.5, 0], max_m = [2.0, 1.5, 2.2] }
";

fn folder(edits: &[(&str, &str, &str)]) -> Folder {
    let folder = Folder::new();
    folder.write("study.toml", STUDY);
    folder.write("cell.toml", CELL);
    edits.iter().for_each(|(file, from, to)| folder.edit(file, from, to));
    folder
}

/// Its only pose.
const POSE: &str = "radar:post/left";

/// A study with these edits, and the folder of its sweep.
fn swept(edits: &[(&str, &str, &str)]) -> (Folder, PathBuf) {
    let folder = folder(edits);
    let out = folder.path("out");
    let outcome =
        perirobot(&["sweep", text(&folder.path("study.toml")), "--backend", "cpu", "--out", text(&out)]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    (folder, out)
}

/// Whether the person is detected, by `judge`.
#[track_caller]
fn is_detected(edits: &[(&str, &str, &str)]) -> bool {
    let (_folder, out) = swept(edits);
    let outcome = perirobot(&["judge", text(&out), "--pose", POSE]);
    assert!(matches!(outcome.code, Some(0 | 4)), "{}", outcome.stderr);
    outcome.code == Some(0)
}

#[test]
fn who_moves_fast_enough_is_detected_through_plastic() {
    assert!(is_detected(&[]));
    assert!(is_detected(&[("cell.toml", "speed_m_s = 0.5", "speed_m_s = 0.1")]));
    assert!(!is_detected(&[("cell.toml", "speed_m_s = 0.5", "speed_m_s = 0.09")]), "too slow");
    assert!(!is_detected(&[("cell.toml", "speed_m_s = 0.5", "speed_m_s = 0")]), "still");
    assert!(!is_detected(&[("cell.toml", "radar = \"passes\"\n", "")]), "behind an opaque plate");
    let see_through = ("cell.toml", "radar = \"passes\"", "optical = \"see_through\"");
    assert!(!is_detected(&[see_through]), "what light passes stops radar all the same");
    let still_too =
        [("study.toml", "min_speed_m_s = 0.1", "min_speed_m_s = 0"), ("cell.toml", "speed_m_s = 0.5\n", "")];
    assert!(is_detected(&still_too), "no speed is needed");
}

/// A walk contains its speed, and a list has one for each snapshot.
#[test]
fn speeds_come_from_walks_and_lists() {
    let person = "position_m = [0.5, 0.5, 0.9]\nspeed_m_s = 0.5\n";
    let with = |speed: &str| {
        let walk = format!(
            "[object.snapshots]\nwalk = {{ path_m = [[0.5, 0.5, 0.9], [1.0, 0.5, 0.9]], step_m = 0.25{speed} }}\n"
        );
        is_detected(&[("cell.toml", person, &walk)])
    };
    assert!(with("") && with(", speed_m_s = 0.1") && !with(", speed_m_s = 0.05"));
    let list = |speeds: &str| {
        let list = format!(
            "[object.snapshots]\nposition_m = [[0.5, 0.5, 0.9], [1.0, 0.5, 0.9]]\nspeed_m_s = {speeds}\n"
        );
        is_detected(&[("cell.toml", person, &list)])
    };
    assert!(list("[0.2, 0.2]") && !list("[0.2, 0]"));
}

#[test]
fn bodies_that_come_are_detected_where_the_field_is() {
    let row = |edits: &[(&str, &str, &str)]| {
        let folder = folder(edits);
        let (study, out) = (folder.path("study.toml"), folder.path("out"));
        let outcome = perirobot(&["approach", text(&study), "--pose", POSE, "--out", text(&out)]);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        let row = rows(&out.join("approach.csv")).into_iter().find(|row| row["people"] == "absent").unwrap();
        (row["at_entry"].clone(), row["deepest_m"].parse::<f64>().ok())
    };
    assert_eq!(row(&[]), ("noticed".into(), None), "its field reaches the entry");
    let short = row(&[("study.toml", "range_m = [0, 4]", "range_m = [0, 1.5]")]);
    let opaque = row(&[("cell.toml", "radar = \"passes\"\n", "")]);
    for (at_entry, deepest_m) in [short, opaque] {
        assert!(at_entry == "open" && deepest_m.unwrap() < 1.0, "{at_entry} {deepest_m:?}");
    }
}

/// People who stand around are labelled free by a radar that does not detect them, or not labelled.
#[test]
fn who_stands_still_is_a_false_negative() {
    let counts = |edits: &[(&str, &str, &str)]| {
        let (_folder, out) = swept(edits);
        let row = rows(&out.join("results.csv")).remove(0);
        ["tp_human", "fn_human", "uo_human"].map(|key| row[key].parse::<u64>().unwrap())
    };
    let [moving, still, unknown] = [
        counts(&[]),
        counts(&[("cell.toml", "speed_m_s = 0.5", "speed_m_s = 0")]),
        counts(&[
            ("cell.toml", "speed_m_s = 0.5", "speed_m_s = 0"),
            ("study.toml", "min_speed_m_s = 0.1", "min_speed_m_s = 0.1\notherwise = \"unknown\""),
        ]),
    ];
    assert!(moving[0] > 0 && moving[1] == 0, "{moving:?}");
    assert_eq!(still, [0, moving[0], moving[2]]);
    assert_eq!(unknown, [0, 0, moving[0] + moving[2]]);
}

#[test]
fn mistakes_are_named_with_what_to_write() {
    for (edits, expected) in [
        (
            vec![("cell.toml", "speed_m_s = 0.5\n", "")],
            vec![
                "study.toml: sensor \"radar\".min_speed_m_s = 0.1: needs the speed of people, and object \"person\" of scene \"cell\"",
                "write speed_m_s = 1.6 in that object (0 if it stands still), a list snapshots.speed_m_s, or snapshots.walk",
            ],
        ),
        (
            vec![("study.toml", "min_speed_m_s = 0.1", "min_speed_m_s = 2")],
            vec!["sensor \"radar\".min_speed_m_s = 2: must be from 0.001 to 1.6 m/s"],
        ),
        (
            vec![("study.toml", "min_speed_m_s = 0.1", "min_speed_m_s = -1")],
            vec!["min_speed_m_s = -1: must be from"],
        ),
        (
            vec![("study.toml", "min_speed_m_s = 0.1\n", "")],
            vec!["missing field `min_speed_m_s`, as in min_speed_m_s = 0.1"],
        ),
        (
            vec![(
                "study.toml",
                "min_speed_m_s = 0.1",
                "min_speed_m_s = 0.1\nreflectance_ranges_m = [[0.1, 3]]",
            )],
            vec!["reflectance_ranges_m does not belong to a radar: reflectance is of light"],
        ),
        (
            vec![("study.toml", "min_speed_m_s = 0.1", "min_speed_m_s = 0.1\nnoise = { std_m = 0.1 }")],
            vec!["noise, dropout and calibration do not belong to a radar"],
        ),
        (
            vec![("study.toml", "fov_deg = [100, 30]", "fov_deg = [100, 190]")],
            vec!["sensor \"radar\".fov_deg = 190: must be [horizontal, vertical]"],
        ),
        (
            vec![("study.toml", "range_m = [0, 4]", "range_m = [4, 0]")],
            vec!["sensor \"radar\".range_m = [4.0, 0.0]: must be [nearest, farthest]"],
        ),
        (
            vec![("cell.toml", "role = \"human\"", "role = \"human\"\nradar = \"passes\"")],
            vec!["cell.toml: object \"person\".radar = \"passes\": does not belong to a person"],
        ),
        (
            vec![("cell.toml", "radar = \"passes\"", "radar = \"glass\"")],
            vec!["cell.toml", "unknown variant `glass`"],
        ),
        (
            vec![("cell.toml", "speed_m_s = 0.5", "speed_m_s = -0.5")],
            vec![
                "cell.toml: object \"person\".speed_m_s = -0.5: must be a speed in metres a second from 0 to 100",
            ],
        ),
        (
            vec![(
                "cell.toml",
                "speed_m_s = 0.5",
                "[object.snapshots]\nspeed_m_s = [1]\nwalk = { path_m = [[0, 0, 1], [1, 0, 1]], step_m = 0.5 }",
            )],
            vec!["both walk and a list of positions, rotations, dwell_s or speed_m_s"],
        ),
    ] {
        refused(&folder(&[]), &edits, &expected);
    }
}

/// What `check` warns of.
#[track_caller]
fn warned(edits: &[(&str, &str, &str)], expected: &str) {
    let folder = folder(edits);
    let outcome = perirobot(&["check", text(&folder.path("study.toml"))]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let said = outcome.stdout + &outcome.stderr;
    let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
    match expected {
        "" => assert!(!said.contains("sensor \"radar\": "), "{said}"),
        expected => assert!(said.contains(expected), "{said}"),
    }
}

#[test]
fn check_reports_what_a_radar_cannot_do() {
    warned(&[], "");
    warned(
        &[("cell.toml", "speed_m_s = 0.5", "speed_m_s = 0.05")],
        "min_speed_m_s = 0.1 is faster than all people of the scenes (at most 0.05 m/s)",
    );
    // In the plate, which radar passes, and then does not.
    let in_plate = ("study.toml", "[-1.25, 1.0, 1.15]", "[-0.85, 1.0, 1.15]");
    warned(&[in_plate], "");
    warned(&[in_plate, ("cell.toml", "radar = \"passes\"\n", "")], "in an occupied voxel");
    // Before a wall.
    warned(
        &[
            ("cell.toml", "radar = \"passes\"\n", ""),
            ("study.toml", "[-1.25, 1.0, 1.15]", "[-0.95, 1.0, 1.15]"),
        ],
        "\"plate\"",
    );
    let conveyor = "[[object]]\nname = \"conveyor\"\nbox = { size_m = [0.5, 0.5, 0.8] }\nposition_m = [1, -0.5, 0.9]\nspeed_m_s = 0.3\n";
    let person = "[[object]]\nname = \"person\"";
    warned(
        &[("cell.toml", person, &format!("{conveyor}{person}"))],
        "turn it away from what moves there, or shorten range_m",
    );
}

/// The other commands take a radar like any sensor.
#[test]
fn reasons_renders_reports_and_exports_have_it() {
    let (folder, out) = swept(&[("study.toml", "kind = \"radar\"", "kind = \"radar\"\ncost = 100")]);
    let study = folder.path("study.toml");
    let [picture, view, chosen] = ["view.png", "view", "chosen"].map(|name| folder.path(name));
    for command in [
        vec!["why", text(&out), "--pose", POSE],
        vec!["render", text(&study), "--pose", POSE, "--out", text(&picture)],
        vec!["export", text(&out), "--pose", POSE, "--out", text(&view)],
        vec!["report", text(&out)],
        vec!["choose", text(&study), "--out", text(&chosen)],
        vec!["report", text(&chosen)],
        vec!["verify-backends", text(&study)],
    ] {
        let outcome = perirobot(&command);
        assert_eq!(outcome.code, Some(0), "{command:?}\n{}", outcome.stderr);
    }
    let reasons = perirobot(&["why", text(&out), "--pose", POSE]).stdout;
    assert!(reasons.contains("out_of_view"), "{reasons}");
}
