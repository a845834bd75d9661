//! Requirements on how near bodies come: each verdict is held against `perirobot approach` of the same case, the limit
//! is met at its value and no nearer, and what cannot be asked is refused.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::common::program::{self, Folder, Outcome, perirobot, refused, text};

const BOTH: &str = "camera:wall/front;camera:wall/back";

/// A requirement of a study.
fn require(name: &str, score: &str, more: &str) -> String {
    format!("\n[[require]]\nname = \"{name}\"\nscore = \"{score}\"\n{more}\n")
}

/// The shelf's cell with voxels of 10 cm.
fn shelf() -> Folder {
    let folder = program::shelf();
    folder.edit("study.toml", "voxel_size_m = 0.05", "voxel_size_m = 0.1");
    folder.edit("study.toml", "resolution_px = [320, 240]", "resolution_px = [160, 120]");
    folder
}

type Row = BTreeMap<String, String>;

fn table(path: &Path) -> Vec<Row> {
    let mut csv = csv::Reader::from_path(path).unwrap();
    csv.deserialize().map(|row| row.unwrap()).collect()
}

fn judge(folder: &Folder, pose: &str, more: &[&str]) -> Outcome {
    let out = folder.path("out");
    perirobot(&[&["judge", text(&out), "--pose", pose, "--backend", "cpu"], more].concat())
}

/// The rows of `perirobot approach` of a case.
fn approach(folder: &Folder, pose: &str, more: &[&str]) -> Vec<Row> {
    let (out, near) = (folder.path("out"), folder.path("near"));
    let outcome =
        perirobot(&[&["approach", text(&out), "--pose", pose, "--out", text(&near)], more].concat());
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    table(&near.join("approach.csv"))
}

/// The worst of a column in rows that are asked: the least distance, the largest area.
fn worst(rows: &[Row], column: &str, asked: impl Fn(&Row) -> bool) -> f64 {
    let number = |row: &Row, column: &str| row[column].parse::<f64>().ok();
    let rows = rows.iter().filter(|row| asked(row));
    let nearest =
        |row: &Row| number(row, column).into_iter().chain(number(row, "noticed_m")).reduce(f64::min);
    let values = rows.map(|row| if column == "deepest_m" { nearest(row) } else { number(row, column) });
    match column {
        "deepest_m" | "margin_m" => {
            values.map(|value| value.unwrap_or(f64::INFINITY)).fold(f64::INFINITY, f64::min)
        }
        _ => values.flatten().fold(0.0, f64::max),
    }
}

const ERROR: &str = "\n[mounting_error]\ndraws = 3\nposition_m = 0.05\nangle_deg = 6.0\n";
const UNDER: &str = "under = [\"as_planned\", \"one_sensor_dead\", \"two_sensors_dead\", \"mounting_error\"]";

/// Each case of each condition is what `approach` says of it, also with noise and a robot that moves.
#[test]
fn each_case_is_what_approach_says_of_it() {
    let folder = shelf();
    folder.edit("study.toml", "range_m = [0.1, 6.0]", "range_m = [0.1, 6.0]\ndropout = 0.05");
    folder.edit("study.toml", "[grid]", "repeats = 2\nseed = 3\n[grid]");
    let robot = "position_m = [-1, 0, 0.6]";
    let cell = fs::read_to_string(folder.path("cell.toml")).unwrap();
    assert!(cell.contains(robot), "{cell}");
    let moves = "[object.snapshots]\nposition_m = [[-1, 0, 0.6], [-0.8, 0.2, 0.6]]";
    folder.edit("cell.toml", robot, moves);
    let asked = [
        ("far enough", "nearest_unnoticed_m", "at_least = 0.4", "deepest_m", None),
        (
            "trolleys",
            "nearest_unnoticed_m",
            "body = \"trolley\"\nentry = \"door\"\nat_least = 0.4",
            "deepest_m",
            Some("trolley"),
        ),
        ("margin", "approach_margin_m", "at_least = 0", "margin_m", None),
        ("floor", "unnoticed_m2", "at_most = 1", "unnoticed_m2", None),
        ("ways", "joined_m2", "at_most = 1\nbody = \"standing\"", "joined_m2", Some("standing")),
    ];
    folder.edit("study.toml", "", ERROR);
    for (name, score, more, _, _) in asked {
        folder.edit("study.toml", "", &require(name, score, &format!("{more}\n{UNDER}")));
    }
    let swept = folder.sweep(&[]);
    assert_eq!(swept.code, Some(0), "{}", swept.stderr);
    // Nothing that a sweep counts is required: which choice is good is not known.
    let out = folder.path("out");
    let unnamed = perirobot(&["judge", text(&out)]);
    assert_eq!(unnamed.code, Some(2));
    assert!(unnamed.stderr.contains("choose one with --pose"), "{}", unnamed.stderr);

    let outcome = judge(&folder, BOTH, &["--combination", "both"]);
    assert!(matches!(outcome.code, Some(0 | 4)), "{}", outcome.stderr);
    let judged = table(&out.join("requirements.csv"));
    let (dead, draws) = (["camera:wall/front", "camera:wall/back"], ["0", "1", "2"]);
    let mut cases: Vec<(&str, Vec<Vec<&str>>)> = vec![("as_planned", vec![vec![]])];
    cases.push(("one_sensor_dead", dead.iter().map(|one| vec!["--dead", one]).collect()));
    cases.push(("mounting_error", draws.iter().map(|draw| vec!["--draw", draw]).collect()));
    let (mut compared, mut near) = (0, 0);
    for (condition, cases) in cases {
        let rows: Vec<Vec<Row>> = cases
            .iter()
            .map(|case| {
                let repeat = |n| {
                    approach(&folder, BOTH, &[&["--combination", "both", "--repeat", n], &case[..]].concat())
                };
                [repeat("0"), repeat("1")].concat()
            })
            .collect();
        for (name, _, _, column, body) in asked {
            let is_asked = |row: &Row| body.is_none_or(|body| row["body"] == body);
            let each: Vec<f64> = rows.iter().map(|rows| worst(rows, column, is_asked)).collect();
            let worst_case = match column {
                "deepest_m" | "margin_m" => each.iter().copied().fold(f64::INFINITY, f64::min),
                _ => each.iter().copied().fold(0.0, f64::max),
            };
            let row = judged
                .iter()
                .find(|row| row["requirement"] == name && row["condition"] == condition)
                .unwrap();
            let value: f64 = row["value"].parse().unwrap();
            assert!(value == worst_case || (value - worst_case).abs() < 1e-5, "{row:?}: {each:?}");
            let failed = each.iter().filter(|&&value| match column {
                "deepest_m" => value < 0.4,
                "margin_m" => value < 0.0,
                _ => value > 1.0,
            });
            assert_eq!(row["failed"], failed.count().to_string(), "{row:?}: {each:?}");
            // Where that is said to be, it is.
            if value.is_finite() {
                let of_case = &rows[each.iter().position(|value| *value == worst_case).unwrap()];
                let there =
                    |of: &Row| ["scene", "people", "body", "entry"].iter().all(|key| of[*key] == row[*key]);
                assert!((worst(of_case, column, there) - worst_case).abs() < 1e-5, "{row:?}");
                near += 1;
            }
            compared += 1;
        }
    }
    assert!(compared == 15 && near > 10, "{compared}, {near}");
    // Of two sensors nothing is left: whoever comes, comes to the robot.
    let blind = judged
        .iter()
        .find(|row| row["condition"] == "two_sensors_dead" && row["requirement"] == "far enough");
    let blind = blind.unwrap();
    assert_eq!([&blind["verdict"], &blind["cases"]], ["FAIL", "1"]);
    assert!(blind["value"].parse::<f64>().unwrap() < 0.3, "{blind:?}");

    // The command that is printed finds the same.
    let command = outcome.stdout.lines().find(|line| line.contains("perirobot approach")).unwrap();
    let words: Vec<&str> = command.split_whitespace().skip(1).map(|word| word.trim_matches('\'')).collect();
    let near = folder.path("again");
    let again = perirobot(&[&words[..], &["--out", text(&near)]].concat());
    assert_eq!(again.code, Some(0), "{command}: {}", again.stderr);
}

#[test]
fn a_limit_is_met_at_its_value_and_no_nearer() {
    let folder = shelf();
    folder.edit("study.toml", "voxel_size_m = 0.1", "voxel_size_m = 0.05");
    folder.edit("study.toml", "resolution_px = [160, 120]", "resolution_px = [320, 240]");
    // 21 voxels of 5 cm, as tests/judge/approach.rs has it worked out by hand.
    for (name, least) in [("met", "1.05"), ("missed", "1.050000001")] {
        folder.edit(
            "study.toml",
            "",
            &require(name, "nearest_unnoticed_m", &format!("at_least = {least}\nbody = \"standing\"")),
        );
    }
    folder.edit(
        "study.toml",
        "",
        &require("at the door", "nearest_unnoticed_m", "at_least = 2.2\nbody = \"standing\""),
    );
    assert_eq!(folder.sweep(&[]).code, Some(0));
    let one = judge(&folder, "camera:wall/front", &[]);
    assert_eq!(one.code, Some(4), "{}", one.stderr);
    for said in [
        "PASS  met (as planned): nearest_unnoticed_m is 1.050, at least 1.05 is required (the worst of all bodies and entries); \
         worst of standing from door; between centres of voxels, with sizes rounded: the gap may be 0.12 m less\n",
        "FAIL  missed (as planned): nearest_unnoticed_m is 1.050, at least 1.050000001 is required",
        "perirobot approach ",
    ] {
        assert!(one.stdout.contains(said), "{said}: {}", one.stdout);
    }
    // The second camera notices everybody at the door: 44 voxels of 5 cm from the robot, and that is not endless.
    let both = judge(&folder, BOTH, &["--combination", "both"]);
    assert_eq!(both.code, Some(0), "{}{}", both.stdout, both.stderr);
    let said = "PASS  at the door (as planned): nearest_unnoticed_m is 2.200, at least 2.2 is required";
    assert!(both.stdout.contains(said), "{}", both.stdout);
    assert!(!both.stderr.contains("log-odds"), "{}", both.stderr);
    // Sensors may outvote each other, and whoever asks how near is told.
    folder.edit("study.toml", "name = \"both\"", "name = \"both\"\nfusion = \"octomap\"");
    folder.edit("study.toml", "at_least = 2.2", "at_least = 2.201");
    assert_eq!(folder.sweep(&["--restart"]).code, Some(0));
    let missed = judge(&folder, BOTH, &["--combination", "both"]);
    assert_eq!(missed.code, Some(4), "{}{}", missed.stdout, missed.stderr);
    assert!(missed.stderr.contains("log-odds may outvote a single sensor's hits"), "{}", missed.stderr);
}

/// A study that says which bodies come and how far people must be: nobody may come nearer unnoticed than is needed.
#[test]
fn a_speed_is_fast_enough_only_if_nobody_comes_too_near_unnoticed() {
    let folder = shelf();
    folder.edit("study.toml", "voxel_size_m = 0.1", "voxel_size_m = 0.05");
    folder.edit("study.toml", "resolution_px = [160, 120]", "resolution_px = [320, 240]");
    for other in [
        "[[approach.body]]\nname = \"crawling\"\n",
        "[[approach.body]]\nname = \"trolley\"\nbox = { size_m = [0.4, 0.4, 0.9] }\n",
    ] {
        folder.edit("study.toml", other, "");
    }
    folder.edit("study.toml", "", &require("known", "unknown", "region = \"near@1\"\nat_most = 1"));
    folder.edit("study.toml", "", &require("much", "unknown", "region = \"robot\"\nat_least = 1"));
    // Who is standing comes to 1.05 m. 1.003125 m are needed at 0.25 m/s, but for the robot's uncertainty of 0.01.
    for (uncertainty, fastest, verdict) in
        [("0.056875", "up to 0.25 m/s,", "PASS"), ("0.056875001", "at none", "FAIL")]
    {
        let text = fs::read_to_string(folder.path("study.toml")).unwrap();
        let key = "robot_uncertainty_m = ";
        let old = text.lines().find(|line| line.starts_with(key)).unwrap();
        folder.edit("study.toml", old, &format!("{key}{uncertainty}"));
        assert_eq!(folder.sweep(&["--restart"]).code, Some(0));
        let outcome = judge(&folder, "camera:wall/front", &[]);
        assert_eq!(outcome.code, Some(4), "{}", outcome.stderr);
        let asked = "by the requirements in separation regions and by how near a person gets unnoticed";
        let line = format!("how fast may it run, {asked}: {fastest} of the listed 0.25, 0.5, 1 m/s\n");
        assert!(outcome.stdout.contains(&line), "{line}: {}", outcome.stdout);
        assert!(
            outcome.stdout.contains("also missed, whatever the speed: much (as planned)\n"),
            "{}",
            outcome.stdout
        );
        let told = "m/s missed: nobody comes nearer unnoticed than is needed (as planned)\n";
        assert_eq!(outcome.stdout.matches(told).count(), 1, "{}", outcome.stdout);
        let rows = table(&folder.path("out/speeds.csv"));
        let regions: Vec<&str> = rows.iter().map(|row| row["region"].as_str()).collect();
        assert_eq!(regions, ["near@0.25", "near@0.5", "near@1", "", "", ""]);
        let verdicts: Vec<&str> = rows.iter().map(|row| row["verdict"].as_str()).collect();
        assert_eq!(verdicts, ["PASS", "PASS", "PASS", verdict, "FAIL", "FAIL"]);
        let is_enough = |row: &Row| row["fast_enough"] == "1";
        let slow = |row: &Row| row["speed_m_s"] == "0.25" && verdict == "PASS";
        assert!(rows.iter().all(|row| is_enough(row) == slow(row)), "{rows:?}");
        assert!(rows[3..].iter().all(|row| row["value"].parse::<f64>().unwrap() == 1.05), "{rows:?}");
    }
}

/// A sweep decides what it counts, and says what else is required.
#[test]
fn a_sweep_says_what_it_does_not_decide() {
    let folder = shelf();
    let near = require("far", "nearest_unnoticed_m", "at_least = 1");
    folder.edit("study.toml", "", &near);
    let swept = |folder: &Folder| {
        let outcome = folder.sweep(&[]);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        outcome.stdout.split_once("\nRequirements").expect("what is required").1.to_string()
    };
    let told = swept(&folder);
    assert!(told.starts_with("\nnot decided here: far (as planned)\n"), "{told}");
    assert!(told.contains("\nnext: perirobot judge "), "{told}");
    assert!(told.contains(" --pose POSES\n"), "{told}");
    let both = "under = [\"as_planned\", \"one_sensor_dead\"]";
    let dead = "under = [\"one_sensor_dead\"]";
    for (name, under) in [("known", both), ("hurt", dead)] {
        let more = format!("region = \"robot\"\nat_most = 1\n{under}");
        folder.edit("study.toml", "", &require(name, "unknown", &more));
    }
    let told = swept(&folder);
    let open = "\nnot decided here: far (as planned), known (one sensor dead), hurt (one sensor dead)\n";
    assert!(told.contains(open), "{told}");
    assert!(told.contains("PASS  known (as planned)") && !told.contains("hurt (as planned)"), "{told}");
}

#[test]
fn what_cannot_be_required_of_approaches_is_refused_by_name() {
    let wrong = |score: &str, more: &str, expected: &[&str]| {
        refused(&shelf(), &[("study.toml", "", &require("far", score, more))], expected);
    };
    let near = "nearest_unnoticed_m";
    wrong(
        near,
        "at_least = 1\nregion = \"robot\"",
        &["require \"far\".region = \"robot\": nearest_unnoticed_m is of what"],
    );
    wrong(
        near,
        "at_least = 1\nover = \"pooled\"",
        &["over = \"pooled\": must be \"worst\"", "never has no mean"],
    );
    wrong(near, "at_least = 1\nover = \"mean\"", &["over = \"mean\": must be \"worst\""]);
    wrong(near, "at_most = 1", &["at_most = 1: of nearest_unnoticed_m the limit is given as at_least"]);
    wrong("joined_m2", "at_least = 1", &["of joined_m2 the limit is given as at_most"]);
    wrong(near, "at_least = -1", &["at_least = -1: must be a number of metres from 0 to 10000"]);
    wrong(
        near,
        "at_least = 1\nbody = \"dog\"",
        &["body = \"dog\": must be a body of [approach]", "\"crawling\""],
    );
    wrong(
        near,
        "at_least = 1\nentry = \"roof\"",
        &["entry = \"roof\": must be an entry of [approach]", "\"door\""],
    );
    wrong(
        "f1",
        "at_least = 1\nregion = \"robot\"\nbody = \"standing\"",
        &["body = \"standing\": f1 is counted in a region"],
    );
    wrong("f1", "at_least = 1", &["require \"far\": no region: say in which region", "[\"robot\", "]);
    wrong(
        "f2",
        "at_least = 1",
        &[
            "score = \"f2\": must be one of f1, kappa",
            "nearest_unnoticed_m, approach_margin_m, unnoticed_m2, joined_m2, missed_m",
        ],
    );
    wrong("approach_margin_m", "at_most = 1", &["of approach_margin_m the limit is given as at_least"]);
    let postures = "at_least = 1\nunder = [\"postures\"]";
    wrong(near, postures, &["under = \"postures\": nearest_unnoticed_m is of bodies that come in"]);
    wrong(
        "unknown",
        "at_most = 1\nregion = \"robot\"\nunder = [\"postures\"]",
        &["needs to know who stands where"],
    );
    let arm = [
        ("study.toml", "name = \"standing\"", "name = \"standing\"\non_floor = false"),
        ("study.toml", "", &require("floor", "unnoticed_m2", "at_most = 1\nbody = \"standing\"")),
    ];
    refused(
        &shelf(),
        &arm,
        &["score = \"unnoticed_m2\": is an area of floor, and no body that is asked stands"],
    );
}

/// What is found only in the scene is told before anything of an earlier judgement is removed.
#[test]
fn a_cell_without_a_robot_is_refused() {
    let folder = shelf();
    folder.edit("study.toml", "", &require("far", "nearest_unnoticed_m", "at_least = 0"));
    assert_eq!(folder.sweep(&[]).code, Some(0));
    assert_eq!(judge(&folder, "camera:wall/front", &[]).code, Some(0));
    folder.edit(
        "study.toml",
        "box = { min_m = [1.4, -1.0, 0], max_m = [2.0, 1.0, 2.0] }",
        "box = { min_m = [7, 7, 0], max_m = [8, 8, 2] }",
    );
    let outcome = judge(&folder, "camera:wall/front", &[]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stdout);
    assert!(outcome.stderr.contains("entry \"door\": lies outside the grid"), "{}", outcome.stderr);
    assert!(folder.path("out/requirements.csv").exists());
}
