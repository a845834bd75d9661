//! `perirobot why`: its table adds up to what the sweep counted, its words name what stands in the way, and
//! wrong input is refused.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use crate::common::program::{Folder, names, perirobot, text};

/// Sums of some columns of a table, for each scene, snapshot, repeat, combination, poses, representation and
/// region.
fn sums(path: &Path, columns: [&str; 3]) -> BTreeMap<String, [u64; 3]> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    let header = reader.headers().unwrap().clone();
    let at = columns.map(|name| header.iter().position(|column| column == name).unwrap());
    let mut sums = BTreeMap::new();
    for row in reader.records().map(Result::unwrap) {
        let key = (0..7).map(|column| row[column].to_string()).collect::<Vec<_>>().join("|");
        let sum: &mut [u64; 3] = sums.entry(key).or_default();
        (0..3).for_each(|i| sum[i] += row[at[i]].parse::<u64>().unwrap());
    }
    sums
}

/// Every row of reasons.csv is of one of results.csv, and those of one add up to its unknown voxels; how many
/// rows of results were met.
#[track_caller]
fn adds_up(out: &Path) -> usize {
    let expected = sums(&out.join("results.csv"), ["uo", "uf", "uo_human"]);
    let found = sums(&out.join("reasons.csv"), ["voxels_occupied", "voxels_free", "voxels_human"]);
    for (key, sum) in &found {
        assert_eq!(Some(sum), expected.get(key), "{key}");
    }
    found.len()
}

#[track_caller]
fn done(arguments: &[&str]) -> String {
    let outcome = perirobot(arguments);
    assert_eq!(outcome.code, Some(0), "{arguments:?}: {}", outcome.stderr);
    outcome.stdout
}

/// A shipped study, swept into a folder, coarse.
fn swept(study: &str, voxel_size: &str) -> Folder {
    let folder = Folder::new();
    let out = folder.path("out");
    done(&[
        "sweep",
        study,
        "--voxel-size",
        voxel_size,
        "--backend",
        "cpu",
        "--progress",
        "none",
        "--out",
        text(&out),
    ]);
    folder
}

#[test]
fn the_reasons_of_the_tiny_study_add_up_in_every_row() {
    let folder = swept("scenes/tiny.toml", "0.1");
    let out = folder.path("out");
    done(&["why", text(&out), "--all", "--progress", "none"]);
    let rows = sums(&out.join("results.csv"), ["uo", "uf", "uo_human"]);
    let unknown = rows.values().filter(|[uo, uf, _]| uo + uf > 0).count();
    assert_eq!((adds_up(&out), unknown), (rows.len(), rows.len()), "all rows have unknown voxels");
    // On any number of threads the same bytes.
    let first = fs::read(out.join("reasons.csv")).unwrap();
    done(&["why", text(&out), "--all", "--threads", "1", "--backend", "oracle"]);
    assert!(fs::read(out.join("reasons.csv")).unwrap() == first);
    // A sweep that begins anew takes the table away.
    done(&["sweep", "scenes/tiny.toml", "--backend", "cpu", "--restart", "--out", text(&out)]);
    assert!(!names(&out).contains(&"reasons.csv".into()));
}

#[test]
fn the_best_of_a_study_with_pads_and_covers_add_up() {
    let folder = swept("scenes/paper/exp2.toml", "0.2");
    let out = folder.path("out");
    let printed = done(&["why", text(&out), "--best", "1"]);
    assert!(adds_up(&out) >= 7 * 3 * 2, "seven combinations, three scenes, two regions");
    assert!(printed.contains("robot region: ") && printed.contains("human region: "), "{printed}");
    done(&["why", text(&out), "--best", "1", "--table", "parquet"]);
    assert!(names(&out).contains(&"reasons.parquet".into()));
}

#[test]
fn the_best_are_those_by_the_score_that_is_asked_for() {
    let folder = swept("scenes/tiny.toml", "0.1");
    let out = folder.path("out");
    let printed = done(&["why", text(&out), "--best", "1", "--score", "false_alarm"]);
    let mut results = csv::Reader::from_path(out.join("results.csv")).unwrap();
    let rows = results.deserialize().map(|row| row.unwrap());
    let mut best: BTreeMap<[String; 2], ([f64; 2], String)> = BTreeMap::new();
    for row in rows {
        let row: std::collections::HashMap<String, String> = row;
        let key = ["combination", "region"].map(|column| row[column].clone());
        // What calls nothing free or occupied has no false alarms to count.
        let Ok(value) = row["false_alarm"].parse::<f64>() else { continue };
        // Of equal ones it is that with the higher F1; there is one moment.
        let next = ([value, -row["f1"].parse::<f64>().unwrap()], row["poses"].clone());
        best.entry(key)
            .and_modify(|best| {
                if next.0 < best.0 {
                    *best = next.clone()
                }
            })
            .or_insert(next);
    }
    let expected: BTreeSet<&String> = best.values().map(|(_, poses)| poses).collect();
    let mut reasons = csv::Reader::from_path(out.join("reasons.csv")).unwrap();
    let found: BTreeSet<String> = reasons.records().map(|row| row.unwrap()[4].to_string()).collect();
    assert_eq!(found.iter().collect::<BTreeSet<_>>(), expected);
    // In words the best of all, of whatever sensor.
    for region in ["robot", "human"] {
        let all = best.iter().filter(|([_, of], _)| of == region).map(|(_, best)| best);
        let (_, poses) = all.min_by(|a, b| a.0.partial_cmp(&b.0).unwrap()).unwrap();
        assert!(printed.contains(&format!("\n{poses} · ")), "{poses} in {printed}");
    }
    let both = perirobot(&["why", text(&out), "--all", "--score", "false_alarm"]);
    assert_eq!(both.code, Some(2), "{}", both.stderr);
}

#[test]
fn a_pose_of_the_papers_scene_has_its_shadow_named() {
    let folder = swept("scenes/quick.toml", "0.1");
    let out = folder.path("out");
    let before = names(&out);
    let printed = done(&["why", text(&out), "--pose", "right-wall/8/1"]);
    for shown in ["human region: ", "hidden by table", "look past table", "monitored, but not known: "] {
        assert!(printed.contains(shown), "no {shown:?} in {printed}");
    }
    assert_eq!(names(&out), before, "one pose leaves no table");
}

/// Stopped in the middle: neither a table nor a part of one is left.
#[cfg(unix)]
#[test]
fn a_signal_leaves_no_table() {
    use std::io::{BufRead, BufReader};
    use std::process::{Command, Stdio};

    let folder = swept("scenes/paper/exp2.toml", "0.2");
    let out = folder.path("out");
    let before = names(&out);
    let mut run = Command::new(env!("CARGO_BIN_EXE_perirobot"))
        .args(["why", text(&out), "--all", "--backend", "cpu", "--progress", "json"])
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(run.stderr.take().unwrap()).lines().map(Result::unwrap);
    assert!(lines.any(|line| line.contains("\"start\"")), "it begins");
    let pid = run.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().unwrap().success());
    let rest = lines.collect::<Vec<_>>().join("\n");
    assert_eq!(run.wait().unwrap().code(), Some(75), "{rest}");
    assert!(rest.contains("stopped by Ctrl-C (SIGINT): no table was written"), "{rest}");
    assert_eq!(names(&out), before);
}

#[test]
fn wrong_input_is_refused() {
    let folder = Folder::new();
    folder.sweep(&[]);
    let out = folder.path("out");
    let refused = |arguments: &[&str], expected: &str| {
        let outcome = perirobot(&[&["why"], arguments].concat());
        let what = format!("{arguments:?}: {:?}\n{}", outcome.code, outcome.stderr);
        assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(2), ""), "{what}");
        assert!(
            outcome.stderr.contains(expected) && !outcome.stderr.contains("panicked"),
            "no {expected:?} in {what}"
        );
    };
    refused(&["no/such"], "no/such: is not a folder");
    refused(&[text(&folder.path("."))], "manifest.json: does not exist: name a folder");
    refused(&[text(&out), "--study", "no/such.toml"], "no/such.toml: the study of this sweep is missing");
    refused(&[text(&out), "--pose", "nowhere"], "--pose nowhere: no such choice of poses");
    refused(&[text(&out), "--best", "0"], "0 is not in 1..");
    refused(&[text(&out), "--scene", "cell"], "--pose <POSES>");
    refused(&[text(&out), "--all", "--best", "3"], "cannot be used with");
    folder.edit("cell.toml", "radius_m = 0.12", "radius_m = 0.2");
    refused(&[text(&out)], "has changed since the sweep");
    assert!(!names(&out).contains(&"reasons.csv".into()));
}
