//! The usual cells that `init --template` writes: they are right as they are, what is planned in them misses a requirement,
//! and the listed places hold a set that meets all.

use std::fs;

use crate::common::program::{self, perirobot, text};

const NAMES: [&str; 5] = ["assembly", "palletiser", "welding", "handover", "laboratory"];

/// The template is written, checked, planned and bought; `cost` is that of the cheapest set that passes.
#[track_caller]
fn check(name: &str, cost: &str) {
    let folder = tempfile::tempdir().unwrap();
    let home = folder.path().join("new/cell");
    let outcome = perirobot(&["init", "--template", name, text(&home)]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    for next in ["check", "sweep", "judge", "choose", "report"] {
        assert!(outcome.stdout.contains(&format!("\n  perirobot {next} ")), "{}", outcome.stdout);
    }
    assert_eq!(program::names(&home), ["cell.toml", "people", "robot.urdf", "schemas", "study.toml"]);
    let study = home.join("study.toml");
    // Every file of a person is used.
    let cell = fs::read_to_string(home.join("cell.toml")).unwrap();
    for person in program::names(&home.join("people")) {
        assert!(cell.contains(&format!("\"people/{person}\"")), "{person}");
    }
    let outcome = perirobot(&["check", text(&study), "--backend", "cpu"]);
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "no warnings");
    assert!(outcome.stdout.contains("\nno problems\nnext: perirobot "), "{}", outcome.stdout);
    let planned = home.join("planned");
    let outcome = perirobot(&["sweep", text(&study), "--out", text(&planned), "--backend", "cpu"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let outcome = perirobot(&["judge", text(&planned)]);
    assert_eq!(outcome.code, Some(4), "what is planned misses a requirement: {}", outcome.stdout);
    let out = home.join("out");
    let outcome = perirobot(&["choose", text(&study), "--out", text(&out), "--backend", "cpu"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    for expected in [&format!(" for {cost} EUR meet "), "the robot may run at ", "proven: no cheaper set"] {
        assert!(outcome.stdout.contains(expected), "{}", outcome.stdout);
    }
    assert!(!outcome.stdout.contains("none of the listed speeds"), "{}", outcome.stdout);
}

#[test]
fn an_assembly_table() {
    check("assembly", "1,950");
}

#[test]
fn a_palletiser() {
    check("palletiser", "2,600");
}

#[test]
fn a_welding_cell() {
    check("welding", "2,200");
}

#[test]
fn a_handover() {
    check("handover", "3,080");
}

#[test]
fn a_laboratory_bench() {
    check("laboratory", "1,380");
}

#[test]
fn templates_are_listed_by_help_and_by_a_wrong_name() {
    let help = perirobot(&["init", "--help"]).stdout;
    let lines: Vec<&str> = help.lines().filter_map(|line| line.trim().strip_prefix("- ")).collect();
    for name in NAMES {
        assert!(lines.iter().any(|line| line.starts_with(&format!("{name}:"))), "{name}: {help}");
    }
    let folder = tempfile::tempdir().unwrap();
    let outcome = perirobot(&["init", "--template", "weldin", text(&folder.path().join("cell"))]);
    assert_eq!(outcome.code, Some(2));
    assert!(NAMES.iter().all(|name| outcome.stderr.contains(name)), "{}", outcome.stderr);
    assert_eq!(program::names(folder.path()), [""; 0], "nothing is written");
}

#[test]
fn a_template_overwrites_nothing() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("people")).unwrap();
    fs::write(folder.path().join("people/bent.csv"), "mine").unwrap();
    let outcome = perirobot(&["init", "--template", "assembly", text(folder.path())]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("bent.csv: exists and would be overwritten"), "{}", outcome.stderr);
    assert_eq!(program::names(folder.path()), ["people"], "nothing else was written");
}
