//! The page in a real browser, used as a person uses it: `browser/planner.py` drags and types. Not run by default, as it needs
//! Debian's chromium and chromium-driver, python3, and minutes: `cargo test --test plan browser -- --ignored`.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::program::{perirobot, text};
use crate::planner::Planner;

/// A usual cell in a folder; its study.
pub(crate) fn cell(folder: &Path, template: &str) -> PathBuf {
    let cell = folder.join("cell");
    let outcome = perirobot(&["init", "--template", template, text(&cell)]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    cell.join("study.toml")
}

/// What a part of the script prints.
pub(crate) fn script(part: &str, arguments: &[&str]) -> String {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/browser/planner.py");
    let output = Command::new("python3").arg(script).arg(part).args(arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "tests/browser/planner.py {part}: {said}");
    String::from_utf8(output.stdout).unwrap()
}

/// The counts of the first region at the first moment, of the planned sensors, by the names of the page.
fn swept(study: &Path) -> HashMap<String, u64> {
    let out = study.with_file_name("out");
    let outcome = perirobot(&["sweep", text(study), "--out", text(&out), "--backend", "oracle"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let mut reader = csv::Reader::from_path(out.join("results.csv")).unwrap();
    let rows: Vec<HashMap<String, String>> = reader.deserialize().collect::<Result<_, _>>().unwrap();
    let row = rows.iter().find(|row| row["combination"] == "planned").expect("the plan was swept");
    let count = |names: &[&str]| names.iter().map(|&name| row[name].parse::<u64>().unwrap()).sum();
    [("unknown", &["uo", "uf"][..]), ("seen", &["tp"]), ("missed", &["fn"]), ("false", &["fp"])]
        .map(|(name, of)| (name.to_string(), count(of)))
        .into()
}

#[test]
#[ignore = "needs chromium, chromium-driver and python3"]
fn a_sweep_counts_what_the_page_showed_after_a_drag() {
    let folder = tempfile::tempdir().unwrap();
    let study = cell(folder.path(), "assembly");
    let files = [study.clone(), study.with_file_name("cell.toml")];
    let before = files.clone().map(|path| fs::read_to_string(path).unwrap());
    let planner = Planner::start(text(&study), &["--backend", "cpu"]);
    let shown: HashMap<String, u64> = serde_json::from_str(&script("used", &[&planner.address()])).unwrap();
    planner.end();
    let comments = |text: &str| text.matches('#').count();
    for (path, before) in files.iter().zip(before) {
        let after = fs::read_to_string(path).unwrap();
        assert!(after != before && comments(&after) == comments(&before), "{after}");
    }
    assert_eq!(swept(&study), shown);
}

#[test]
#[ignore = "needs chromium, chromium-driver and python3"]
fn sets_are_found_and_bad_places_told() {
    let folder = tempfile::tempdir().unwrap();
    let planner = Planner::start(text(&cell(folder.path(), "palletiser")), &["--backend", "cpu"]);
    script("found", &[&planner.address()]);
    planner.end();
}

#[test]
#[ignore = "needs chromium, chromium-driver and python3"]
fn each_template_opens() {
    for template in ["assembly", "palletiser", "welding", "handover", "laboratory"] {
        let folder = tempfile::tempdir().unwrap();
        let planner = Planner::start(text(&cell(folder.path(), template)), &["--backend", "cpu"]);
        script("opened", &[&planner.address()]);
        planner.end();
    }
}

#[test]
#[ignore = "needs chromium, chromium-driver and python3"]
fn a_click_writes_a_template_and_goes_on_to_its_planner() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("palletiser")).unwrap();
    fs::write(folder.path().join("palletiser/study.toml"), "# mine").unwrap();
    let planner = Planner::start_in(folder.path(), &["--backend", "cpu"]);
    script("chosen", &[&planner.address()]);
    planner.end();
    assert_eq!(fs::read_to_string(folder.path().join("palletiser/study.toml")).unwrap(), "# mine");
    assert!(folder.path().join("second/study.toml").exists());
}

#[test]
#[ignore = "needs chromium, chromium-driver and python3"]
fn a_click_makes_a_report_and_mounting_sheets() {
    let folder = tempfile::tempdir().unwrap();
    let planner = Planner::start(text(&cell(folder.path(), "assembly")), &["--backend", "cpu"]);
    script("left", &[&planner.address()]);
    planner.end();
}

#[test]
#[ignore = "needs chromium, chromium-driver and python3"]
fn two_windows_do_not_overwrite_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let planner = Planner::start(text(&cell(folder.path(), "assembly")), &["--backend", "cpu"]);
    script("shared", &[&planner.address()]);
    planner.end();
}

#[test]
#[ignore = "needs chromium, chromium-driver and python3"]
fn the_page_says_that_its_planner_has_ended() {
    let folder = tempfile::tempdir().unwrap();
    let study = cell(folder.path(), "laboratory");
    let before = fs::read_to_string(&study).unwrap();
    // The oracle is slow: the page does not wait for it to be used.
    let planner = Planner::start(text(&study), &["--backend", "oracle"]);
    script("ended", &[&planner.address(), &planner.process().to_string()]);
    assert_eq!(fs::read_to_string(&study).unwrap(), before);
}

#[test]
#[ignore = "needs chromium, chromium-driver and python3"]
fn pages_of_other_origins_reach_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let planner = Planner::start(text(&cell(folder.path(), "handover")), &["--backend", "cpu"]);
    script("strangers", &[&planner.address()]);
    planner.end();
}
