//! What the program says on standard error while it works: nothing but what it must, lines with `-v`, more
//! with `-vv`, and JSON for machines. None of it changes the results.

use crate::common::program::{Folder, Outcome, perirobot, text};
use serde_json::Value;

/// A sweep that must succeed.
#[track_caller]
fn sweep(folder: &Folder, more: &[&str]) -> Outcome {
    let outcome = folder.sweep(more);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    outcome
}

/// The lines of a level, without their time.
fn lines<'a>(outcome: &'a Outcome, level: &str) -> Vec<&'a str> {
    let after = |line: &'a str| line.split_once(&format!(" {level} ")).map(|(_, said)| said.trim());
    outcome.stderr.lines().filter_map(after).collect()
}

#[track_caller]
fn says(lines: &[&str], all: &[&str]) {
    assert!(lines.iter().any(|line| all.iter().all(|part| line.contains(part))), "{all:?} in {lines:#?}");
}

/// The lines for machines.
fn events(outcome: &Outcome) -> Vec<Value> {
    let lines = outcome.stderr.lines().filter(|line| line.starts_with('{'));
    lines.map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn without_v_only_warnings_and_the_backend_are_named() {
    let outcome = sweep(&Folder::new(), &[]);
    let said: Vec<_> = outcome.stderr.lines().filter(|line| !line.starts_with("warning: ")).collect();
    assert!(matches!(said[..], [line] if line.starts_with("running on cpu: ")), "{said:#?}");
}

#[test]
fn v_names_files_scenes_and_devices() {
    let folder = Folder::new();
    let outcome = sweep(&folder, &["-v", "--threads", "1"]);
    let said = lines(&outcome, "INFO");
    for file in ["study.toml", "cell.toml"] {
        let path = folder.path(file);
        let bytes = std::fs::metadata(&path).unwrap().len().to_string();
        says(&said, &["read", text(&path), &bytes]);
    }
    says(&said, &["scene \"cell\": voxelizing at 0.1 m"]);
    says(&said, &["scene \"cell\": ", " voxels", "(snapshot 0 of 1), ready in"]);
    says(&said, &["opened cpu: 1 thread, 512 MiB"]);
    says(&said, &["wrote", "results.csv"]);
    assert_eq!(lines(&outcome, "DEBUG"), [""; 0]);
}

#[test]
fn vv_names_each_batch() {
    let outcome = sweep(&Folder::new(), &["-vv"]);
    let said = lines(&outcome, "DEBUG");
    says(&said, &["cpu: scene loaded"]);
    // The study's camera has 8 poses, its LIDAR 3.
    says(&said, &["cpu: casts table of rays 0 from 8 poses"]);
    says(&said, &["cpu: casts table of rays 1 from 3 poses"]);
    says(&said, &["cpu: scores"]);
    assert!(!lines(&outcome, "INFO").is_empty());
}

#[test]
fn v_works_before_and_after_the_subcommand() {
    let folder = Folder::new();
    let study = folder.path("study.toml");
    for arguments in [["-v", "verify-backends", text(&study)], ["verify-backends", text(&study), "--verbose"]]
    {
        let outcome = perirobot(&[&arguments[..], &["--poses", "1", "--backend", "cpu"]].concat());
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        says(&lines(&outcome, "INFO"), &["read", "cell.toml"]);
    }
}

#[test]
fn warnings_and_errors_stand_as_they_are() {
    let folder = Folder::new();
    folder.edit("study.toml", "position_m = [0.1, 0.1, 1.3]", "position_m = [0.75, 0.4, 0.45]");
    let said = |outcome: &Outcome| -> Vec<String> {
        outcome.stderr.lines().filter(|line| line.starts_with("warning: ")).map(String::from).collect()
    };
    let plain = said(&sweep(&folder, &[]));
    assert!(plain.iter().any(|line| line.contains("posts/corner")), "{plain:?}");
    assert_eq!(said(&sweep(&folder, &["-vv", "--progress", "json"])), plain);

    folder.edit("study.toml", "range_m = [0.2, 3.0]", "range_m = [3.0, 0.2]");
    let outcome = folder.sweep(&["-vv", "--progress", "json"]);
    assert_eq!(outcome.code, Some(2));
    assert!(outcome.stderr.lines().last().unwrap().starts_with("error: "), "{}", outcome.stderr);
}

#[test]
fn json_has_a_line_at_the_start_and_at_the_end() {
    let folder = Folder::new();
    let events = events(&sweep(&folder, &["--progress", "json"]));
    let names: Vec<_> = events.iter().map(|event| event["event"].as_str().unwrap()).collect();
    let (first, last) = (names.first().unwrap(), names.last().unwrap());
    assert_eq!((*first, *last), ("start", "done"), "{names:?}");
    assert!(names[1..names.len() - 1].iter().all(|name| *name == "progress"), "{names:?}");
    // 8 poses of the camera and 3 of the LIDAR.
    assert!(events.iter().all(|event| event["what"] == "poses" && event["of"] == 11), "{events:#?}");
    let done: Vec<_> = events.iter().map(|event| event["done"].as_u64().unwrap()).collect();
    assert!(done.is_sorted() && done[0] == 0 && done[done.len() - 1] == 11, "{done:?}");
    let last = &events[events.len() - 1];
    assert_eq!(last["left_s"], 0.0);
    assert!(last["per_s"].as_f64().unwrap() > 0.0 && last["elapsed_s"].is_f64(), "{last}");
    assert!(events[0]["per_s"].is_null());
}

#[test]
fn compare_tells_its_progress_too() {
    let study = Folder::new();
    let study = study.path("study.toml");
    let fixed = ["verify-backends", text(&study), "--poses", "1", "--backend", "cpu", "--progress"];
    let outcome = perirobot(&[&fixed[..], &["json"]].concat());
    let last = events(&outcome).pop().unwrap();
    assert_eq!((&last["event"], &last["what"]), (&"done".into(), &"sensors and combinations".into()));
    for how in ["none", "bar"] {
        assert!(events(&perirobot(&[&fixed[..], &[how]].concat())).is_empty());
    }
}

#[test]
fn progress_and_logs_do_not_change_the_results() {
    let folder = Folder::new();
    let results = || std::fs::read(folder.path("out").join("results.csv")).unwrap();
    sweep(&folder, &[]);
    let plain = results();
    std::fs::remove_dir_all(folder.path("out")).unwrap();
    sweep(&folder, &["-vv", "--progress", "json"]);
    assert!(results() == plain);
}

#[test]
fn unknown_ways_of_progress_are_refused() {
    let outcome = Folder::new().sweep(&["--progress", "yaml"]);
    assert_eq!(outcome.code, Some(2));
    assert!(outcome.stderr.contains("bar, json, none"), "{}", outcome.stderr);
}
