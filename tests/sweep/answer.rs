//! What a sweep answers on the screen: the best choice of poses of each sensor by what the study asks, as its own tables
//! have it.

use std::collections::BTreeMap;

use crate::common::program::{Folder, perirobot, text};

type Row = BTreeMap<String, String>;

fn number(row: &Row, column: &str) -> f64 {
    row[column].parse().unwrap_or(f64::NEG_INFINITY)
}

/// What a sweep with these requirements tells, and its scores over all scenes and repeats.
fn sweep(require: &str) -> (String, Vec<Row>) {
    let folder = Folder::noisy();
    folder.edit("study.toml", "", require);
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let mut csv = csv::Reader::from_path(folder.path("out/scores.csv")).unwrap();
    let rows = csv.deserialize().map(|row| row.unwrap());
    (outcome.stdout, rows.filter(|row: &Row| row["scene"] == "*").collect())
}

/// The cells of a table's row that begins with a title; two spaces or more are between them.
fn cells(told: &str, title: &str) -> Vec<String> {
    let line = told.lines().find_map(|line| line.strip_prefix(&format!("  {title}  ")));
    let line = line.unwrap_or_else(|| panic!("no {title:?} in {told}"));
    line.split("  ").map(str::trim).filter(|cell| !cell.is_empty()).map(String::from).collect()
}

fn check(told: &str, rows: &[Row], [score, region]: [&str; 2]) {
    let rows: Vec<&Row> = rows.iter().filter(|row| row["region"] == region).collect();
    let mut titles: Vec<[&str; 2]> =
        rows.iter().map(|row| [&*row["combination"], &*row["representation"]]).collect();
    titles.dedup();
    assert!(titles.len() > 1, "several sensors: {titles:?}");
    for [combination, representation] in titles {
        let of = rows.iter().filter(|row| {
            [row["combination"].as_str(), row["representation"].as_str()] == [combination, representation]
        });
        let merit = |row: &Row| [number(row, &format!("{score}_mean")), number(row, "f1_mean")];
        let best =
            of.copied().reduce(|best, next| if merit(next) > merit(best) { next } else { best }).unwrap();
        let cells = cells(told, &format!("{combination} · {representation}"));
        let three = |over: &str| format!("{:.3}", number(best, &format!("{score}_{over}")));
        assert_eq!(cells[..2], [three("mean"), three("worst")], "{combination}: {told}");
        let pose = best["poses"].split_once(':').unwrap().1;
        assert!(cells.contains(&pose.to_string()), "{pose} in {cells:?}");
    }
}

#[test]
fn without_a_question_body_parts_are_compared() {
    let (told, rows) = sweep("");
    assert!(told.contains("\nBest poses by parts_detected in region robot; 2 scenes, 2 repeats\n"), "{told}");
    check(&told, &rows, ["parts_detected", "robot"]);
    // How many are worse than a useless sensor.
    let stuck = cells(&told, "stuck at \"occupied\"").last().unwrap().clone();
    let f1: Vec<f64> = rows.iter().filter(|r| r["region"] == "robot").map(|r| number(r, "f1_mean")).collect();
    let below = f1.iter().filter(|f1| **f1 < stuck.parse().unwrap()).count();
    let expected = format!("has F1 {stuck}, and {below} of {} placements have less:", f1.len());
    assert!(below > 0 && told.contains(&expected), "{expected} in {told}");
}

#[test]
fn a_requirement_is_the_question() {
    let require = "\n[[require]]\nname = \"known\"\nscore = \"kappa\"\nregion = \"robot\"\nat_least = 0.01\n";
    let (told, rows) = sweep(require);
    assert!(told.contains("\nBest poses by kappa in region robot, from [[require]]; "), "{told}");
    check(&told, &rows, ["kappa", "robot"]);
    let words = ["next: perirobot judge ", "--pose "];
    let last = told.lines().last().unwrap();
    assert!(words.iter().all(|word| last.contains(word)), "{last}");
}

#[test]
fn all_scores_are_printed_on_request() {
    let folder = Folder::noisy();
    let outcome = folder.sweep(&["--all"]);
    assert!(
        !outcome.stdout.contains("Best poses by ") && outcome.stdout.contains("best F1"),
        "{}",
        outcome.stdout
    );
    // A sweep that is finished already tells the rest of it without casting anything.
    let (study, out) = (folder.path("study.toml"), folder.path("out"));
    let again = perirobot(&["sweep", text(&study), "--out", text(&out)]);
    assert!(again.stdout.contains("Best poses by ") && !again.stdout.contains("poses/s"), "{}", again.stdout);
    assert!(again.stdout.ends_with(&format!("next: perirobot report {}\n", text(&out))), "{}", again.stdout);
}

/// Scores that have no value anywhere are no columns.
#[test]
fn without_people_f1_is_compared() {
    let folder = Folder::new();
    folder.edit("cell.toml", "role = \"human\"", "role = \"environment\"");
    folder.edit(
        "study.toml",
        "human_box = { object = \"operator\", margin_m = 0.2 }",
        "sphere = { center_m = [0.2, 0.3, 0.4], radius_m = 0.4 }",
    );
    let told = folder.sweep(&[]);
    assert_eq!(told.code, Some(0), "{}", told.stderr);
    assert!(told.stdout.contains("\nBest poses by F1 in region "), "{}", told.stdout);
    let of_people = ["parts_detected  ", "human_seen", "near side"];
    assert!(of_people.iter().all(|words| !told.stdout.contains(words)), "{}", told.stdout);
}
