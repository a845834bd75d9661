//! Speeds on pages are those of `benches/measured.csv`. `PERIROBOT_REGENERATE=1` writes the table of RESULTS.md again.

use std::fs;

use serde::Deserialize;

use crate::common::place::{read, root};

const RESULTS: &str = "benches/RESULTS.md";
const BEGIN: &str = "<!-- measured.csv -->\n";
const END: &str = "<!-- end -->\n";

/// A row of the file: the best of some runs.
#[derive(Deserialize)]
struct Measurement {
    name: String,
    what: String,
    device: String,
    seconds: f64,
    runs: u32,
    date: String,
    command: String,
}

fn measurements() -> Vec<Measurement> {
    let mut table = csv::Reader::from_path(root("benches/measured.csv")).unwrap();
    let all: Vec<Measurement> = table.deserialize().map(|row| row.unwrap()).collect();
    assert!(all.len() >= 8, "{} measurements", all.len());
    all
}

/// Seconds as pages have them: two digits.
fn seconds(seconds: f64) -> String {
    if seconds < 10.0 { format!("{seconds:.1} s") } else { format!("{seconds:.0} s") }
}

#[test]
fn the_table_of_results_is_the_file() {
    let mut table = String::from("| what | device | time | runs | date |\n|---|---|---:|---:|---|\n");
    let mut commands = String::from("```sh\n");
    for Measurement { what, device, seconds: s, runs, date, command, .. } in measurements() {
        table += &format!("| {what} | {device} | {} | {runs} | {date} |\n", seconds(s));
        if !commands.contains(&command) {
            commands += &format!("{command}\n");
        }
    }
    let expected = format!("{table}\n{commands}```\n");
    let page = read(RESULTS);
    let (before, rest) = page.split_once(BEGIN).expect("RESULTS.md marks where its table begins");
    let (shown, after) = rest.split_once(END).expect("and where it ends");
    if std::env::var_os("PERIROBOT_REGENERATE").is_some() {
        fs::write(root(RESULTS), format!("{before}{BEGIN}{expected}{END}{after}")).unwrap();
        return;
    }
    assert_eq!(shown, expected, "PERIROBOT_REGENERATE=1 cargo test --test documents measured::");
}

#[test]
fn the_speeds_of_the_readme_are_in_the_file() {
    let all = measurements();
    let of = |name: &str| {
        let found = all.iter().find(|m| m.name == name);
        seconds(found.unwrap_or_else(|| panic!("measured.csv has no {name}")).seconds)
    };
    let expected = format!(
        "On two cores and no GPU the paper's Experiment 1 (2,580 cameras of 921,600 rays) takes {} at 5 cm, {} at 2 cm; on \
         16 cores {} and {}, on an H100 beside them {} and {} (`--verify 0`).",
        of("exp1-5cm-2-cores"),
        of("exp1-2cm-2-cores"),
        of("exp1-5cm-16-cores"),
        of("exp1-2cm-16-cores"),
        of("exp1-5cm-h100"),
        of("exp1-2cm-h100"),
    );
    let readme = read("README.md").split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(readme.contains(&expected), "README.md must say: {expected}");
}
