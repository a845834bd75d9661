//! `perirobot judge`: verdicts on the small study, held against the tables of its sweep.

#[allow(dead_code)]
#[path = "common/program.rs"]
mod program;

use std::collections::BTreeMap;
use std::fs;

use program::{Folder, Outcome, perirobot, refused, text};

/// A row of a table, by its columns.
type Row = BTreeMap<String, String>;

fn table(folder: &Folder, name: &str) -> Vec<Row> {
    let mut csv = csv::Reader::from_path(folder.path("out").join(name)).unwrap();
    csv.deserialize().map(|row| row.unwrap()).collect()
}

fn judge(folder: &Folder, more: &[&str]) -> Outcome {
    let out = folder.path("out");
    perirobot(&[&["judge", text(&out)], more].concat())
}

/// A requirement of a study.
fn require(name: &str, score: &str, region: &str, more: &str) -> String {
    format!("\n[[require]]\nname = \"{name}\"\nscore = \"{score}\"\nregion = \"{region}\"\n{more}\n")
}

const SCORES: [&str; 8] = [
    "f1",
    "kappa",
    "human_seen",
    "human_claimed",
    "people_detected",
    "parts_detected",
    "unknown",
    "false_alarm",
];

#[test]
fn values_are_those_of_the_tables() {
    let folder = Folder::noisy();
    for score in SCORES {
        for over in ["worst", "mean", "pooled"] {
            // What is better when less has its worst value on the other side of the limit.
            let limit =
                if ["unknown", "false_alarm"].contains(&score) { "at_most = 1" } else { "at_least = 0" };
            let more = format!("over = \"{over}\"\n{limit}");
            folder.edit("study.toml", "", &require(&format!("{score} {over}"), score, "human", &more));
        }
    }
    assert_eq!(folder.sweep(&[]).code, Some(0));
    let scores = table(&folder, "scores.csv");
    for pose in ["posts/upright", "wall/1/1"] {
        let outcome = judge(&folder, &["--pose", pose]);
        assert!(matches!(outcome.code, Some(0 | 4)), "{}", outcome.stderr);
        let (rows, mut compared) = (table(&folder, "requirements.csv"), 0);
        assert_eq!(rows.len(), 24);
        for row in &rows {
            let same = |of: &&Row| {
                let keys = ["combination", "poses", "representation", "region"];
                of["scene"] == "*" && keys.iter().all(|key| of[*key] == row[*key])
            };
            let expected = &scores.iter().find(same).unwrap()[&format!("{}_{}", row["score"], row["over"])];
            assert_eq!(&row["value"], expected, "{pose}: {row:?}");
            assert_eq!(row["verdict"], if expected.is_empty() { "FAIL" } else { "PASS" }, "{row:?}");
            compared += usize::from(!expected.is_empty());
        }
        assert!(compared > 15, "{pose}: {compared} with a value");
    }
}

#[test]
fn the_choice_that_meets_most_requirements_is_judged() {
    let folder = Folder::new();
    assert_eq!(folder.sweep(&[]).code, Some(0));
    let asked = [("f1", "robot", 0.15), ("kappa", "box", 0.1), ("human_seen", "human", 0.05)];
    for (score, region, least) in asked {
        // Requirements change no count: the folder stays the study's.
        folder.edit("study.toml", "", &require(score, score, region, &format!("at_least = {least}")));
    }
    let mut met: BTreeMap<[String; 3], usize> = BTreeMap::new();
    for row in table(&folder, "results.csv") {
        let key = ["combination", "poses", "representation"].map(|key| row[key].clone());
        let is_met = |(score, region, least): &(&str, &str, f64)| {
            row["region"] == *region && row[*score].parse().is_ok_and(|value: f64| value >= *least)
        };
        *met.entry(key).or_default() += asked.iter().filter(|one| is_met(one)).count();
    }
    let most = *met.values().max().unwrap();
    assert!(most > 0 && met.values().any(|count| *count < most), "{met:?}");
    let outcome = judge(&folder, &["--best", "3"]);
    assert_eq!(outcome.code, Some(if most == 3 { 0 } else { 4 }), "{}", outcome.stderr);
    let rows = table(&folder, "requirements.csv");
    assert_eq!(rows.len(), 9);
    let mut before = usize::MAX;
    for set in rows.chunks(3) {
        let key = ["combination", "poses", "representation"].map(|key| set[0][key].clone());
        let passed = set.iter().filter(|row| row["verdict"] == "PASS").count();
        assert_eq!(passed, met[&key], "{key:?}");
        assert!(passed <= before, "the best come first");
        before = passed;
    }
    assert_eq!(rows.iter().filter(|row| row["poses"] == rows[0]["poses"]).count(), 3);
    assert_eq!(met[&["combination", "poses", "representation"].map(|key| rows[0][key].clone())], most);
}

#[test]
fn exit_codes_and_words_say_what_was_decided() {
    let folder = Folder::new();
    assert_eq!(folder.sweep(&[]).code, Some(0));
    let none = judge(&folder, &[]);
    assert_eq!(none.code, Some(2), "{}", none.stderr);
    let wanted = ["study.toml: ", "require", "[[require]] name = ", "region = \"robot\", at_least = 0.9"];
    assert!(wanted.iter().all(|part| none.stderr.contains(part)), "{}", none.stderr);

    folder.edit("study.toml", "", &require("anything", "f1", "robot", "at_least = 0"));
    let passed = judge(&folder, &["--pose", "wall/0/0"]);
    assert_eq!(passed.code, Some(0), "{}", passed.stderr);
    assert!(
        passed.stdout.contains("PASS  anything (as planned): F1 in region robot is 0."),
        "{}",
        passed.stdout
    );

    folder.edit("study.toml", "", &require("all of it", "f1", "robot", "at_least = 1"));
    let missed = judge(&folder, &["--pose", "wall/0/0"]);
    assert_eq!(missed.code, Some(4), "{}", missed.stderr);
    let words = [
        "PASS  anything",
        "FAIL  all of it",
        "no choice of the listed poses can meet it: their upper bound is 0.",
    ];
    assert!(words.iter().all(|part| missed.stdout.contains(part)), "{}", missed.stdout);

    // The picture's command is one that runs.
    let command = missed.stdout.lines().find_map(|line| line.trim().strip_prefix("perirobot ")).unwrap();
    let picture = folder.path("worst.png");
    let words: Vec<&str> = command.split_whitespace().collect();
    let words: Vec<&str> =
        words.iter().map(|word| if *word == "worst.png" { text(&picture) } else { word }).collect();
    let drawn = perirobot(&words);
    assert_eq!(drawn.code, Some(0), "{command}: {}", drawn.stderr);
    assert!(fs::metadata(picture).unwrap().len() > 1000);
}

/// The error of a study with these requirements.
#[track_caller]
fn wrong(more: &str, expected: &[&str]) {
    refused(&Folder::new(), &[("study.toml", "", more)], expected);
}

#[test]
fn bad_requirements_are_refused_by_name() {
    let one = |more: &str| require("seen", "f1", "robot", more);
    wrong(&one("at_least = 0.5\nat_most = 0.7"), &["require \"seen\"", "both at_least and at_most"]);
    wrong(&one(""), &["require \"seen\": no limit: give one of at_least, at_most"]);
    wrong(&one("at_least = 1.5"), &["require \"seen\".at_least = 1.5: must be a number from 0 to 1"]);
    wrong(&one("at_most = nan"), &["require \"seen\".at_most = NaN: must be a number from 0 to 1"]);
    wrong(&one("at_least = 0.12345678901"), &["at_least = 0.12345678901: must have at most nine digits"]);
    wrong(&one("at_least = 0.5\nunder = []"), &["require \"seen\"", "under"]);
    wrong(&one("at_least = 0.5\nunder = [\"flood\"]"), &["under = [\"flood\"]", "one_sensor_dead"]);
    let draws =
        &["require \"seen\".under = \"mounting_error\": needs to know", "[mounting_error] draws = 20"];
    wrong(&one("at_least = 0.5\nunder = [\"mounting_error\"]"), draws);
    wrong(&require("seen", "f2", "robot", "at_least = 0.5"), &["score = \"f2\"", "kappa"]);
    let region = "region = \"cellar\": must be a region of the study: [\"robot\", \"box\", \"human\"]";
    wrong(&require("seen", "f1", "cellar", "at_least = 0.5"), &["require \"seen\"", region]);
    wrong(&[one("at_least = 0.5"), one("at_least = 0.6")].concat(), &["two requirements are named \"seen\""]);
    wrong(
        "\n[mounting_error]\ndraws = 0\nposition_m = 0.01\n",
        &["mounting_error.draws = 0: must be from 1"],
    );
    wrong("\n[mounting_error]\ndraws = 5\n", &["mounting_error: give position_m, angle_deg or both"]);
    wrong("\n[mounting_error]\ndraws = 5\nangle_deg = 99\n", &["mounting_error.angle_deg = 99: must be"]);
}
