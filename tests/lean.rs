//! A program with all features, and one without any: the same counts, and what was left out is named before
//! anything is done. `cargo test --no-default-features --test lean` tests the latter.

#[allow(dead_code)]
#[path = "common/program.rs"]
mod program;

use program::{Folder, Outcome, names, perirobot, text};

/// Whether a command is refused for the want of a feature; else it must have done what was asked.
#[track_caller]
fn asks_for(feature: &str, is_there: bool, outcome: &Outcome) {
    if is_there {
        return assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    }
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    let wanted = format!("was built without the feature \"{feature}\": build it with cargo's defaults");
    assert!(outcome.stderr.contains(&wanted), "{}", outcome.stderr);
}

#[test]
fn what_was_left_out_is_named() {
    let folder = Folder::new();
    let (study, out) = (folder.path("study.toml"), folder.path("out"));
    let sweep = ["sweep", text(&study), "--out", text(&out)];
    let outcome = perirobot(&[&sweep[..], &["--backend", "gpu", "--adapter", "software"]].concat());
    let has_gpu = cfg!(feature = "gpu") && !perirobot_march::backend::factory::adapters().is_empty();
    if has_gpu || !cfg!(feature = "gpu") {
        asks_for("gpu", has_gpu, &outcome);
        assert_eq!(out.exists(), has_gpu);
    }
    let devices = perirobot(&["devices"]);
    assert_eq!(devices.code, Some(0), "{}", devices.stderr);
    assert_eq!(devices.stdout.contains("without the feature \"gpu\""), !cfg!(feature = "gpu"));

    let outcome = perirobot(&[&sweep[..], &["--backend", "cpu", "--table", "parquet"]].concat());
    match cfg!(feature = "parquet") {
        true => assert!(names(&out).contains(&"results.parquet".into()), "{}", outcome.stderr),
        false => assert!(outcome.code == Some(2) && outcome.stderr.contains("[possible values: csv]")),
    }
    assert_eq!(perirobot(&sweep).code, Some(0), "auto takes what is there");
    let drawn = folder.path("figures");
    for command in [&["report", text(&out)][..], &["figures", text(&out), "--out", text(&drawn)]] {
        asks_for("report", cfg!(feature = "report"), &perirobot(command));
    }
    assert_eq!(drawn.exists(), cfg!(feature = "report"));
    assert_eq!(names(&out).contains(&"report.html".into()), cfg!(feature = "report"));

    let (map, rows) = (folder.path("map"), folder.path("rows.parquet"));
    let export = ["export", text(&out), "--pose", "lidar:posts/upright", "--out", text(&map)];
    assert_eq!(perirobot(&export).code, Some(0));
    let labels = map.join("labels.bt");
    let score = ["score", text(&labels), text(&study), "--out", text(&rows)];
    asks_for("parquet", cfg!(feature = "parquet"), &perirobot(&score));
    assert_eq!(rows.exists(), cfg!(feature = "parquet"));
}

#[test]
fn the_counts_are_those_of_the_oracle() {
    let folder = Folder::noisy();
    let study = folder.path("study.toml");
    let [found, expected] = ["auto", "oracle"].map(|backend| {
        let out = folder.path(backend);
        let sweep = ["sweep", text(&study), "--out", text(&out), "--backend", backend];
        assert_eq!(perirobot(&sweep).code, Some(0), "{backend}");
        std::fs::read_to_string(out.join("results.csv")).unwrap()
    });
    assert!(found.lines().count() > 100);
    assert_eq!(found, expected);
}
