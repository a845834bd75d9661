//! `perirobot compare`: placements stand side by side with the scores of scores.csv, of one sweep and of two,
//! and what cannot be compared is refused.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use crate::common::program::{Folder, Outcome, perirobot, text};

const SCORES: [&str; 9] = [
    "f1",
    "kappa",
    "human_seen",
    "human_claimed",
    "people_detected",
    "parts_detected",
    "unknown",
    "false_alarm",
    "seen_twice",
];

/// The small study in two scenes with noise and repeats: its sensors alone, and one pose of each together.
fn swept() -> Folder {
    let folder = Folder::noisy();
    let both = "name = \"both\"\nsensors = [\"camera\", \"lidar\"]\nposes = { camera = [\"wall/0/0\"] }";
    folder.edit(
        "study.toml",
        "",
        &format!("[[combination]]\nsensors = [\"camera\"]\n[[combination]]\nsensors = [\"lidar\"]\n[[combination]]\n{both}\n"),
    );
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    folder
}

fn compare(folders: &[&Path], more: &[&str]) -> Outcome {
    let folders: Vec<&str> = folders.iter().map(|folder| text(folder)).collect();
    perirobot(&[&["compare"], &folders[..], more].concat())
}

/// Every score of scores.csv: by scene, poses and region, then by column.
fn scores(out: &Path) -> HashMap<[String; 3], HashMap<String, String>> {
    let mut table = csv::Reader::from_path(out.join("scores.csv")).unwrap();
    let rows = table.deserialize().map(|row| row.unwrap());
    let key = |row: &HashMap<String, String>| ["scene", "poses", "region"].map(|column| row[column].clone());
    rows.map(|row| (key(&row), row)).collect()
}

/// A number as it stands in tables.
fn number(value: &str) -> String {
    match value.parse::<f64>() {
        Ok(value) if value.abs() < 0.0005 => "0.000".into(),
        Ok(value) => format!("{value:.3}"),
        Err(_) => "–".into(),
    }
}

/// The rows of a region in the order that they are printed, each in cells; of what is printed for no letter,
/// the last.
#[track_caller]
fn rows(outcome: &Outcome, region: &str) -> Vec<Vec<String>> {
    assert_eq!((outcome.code, outcome.stdout.contains("panicked")), (Some(0), false), "{}", outcome.stderr);
    let head = format!("\nRegion {region}\n");
    let (_, rest) =
        outcome.stdout.split_once(&head).unwrap_or_else(|| panic!("no {head:?} in {}", outcome.stdout));
    let lines = rest.lines().take_while(|line| line.starts_with(' ') || line.starts_with('['));
    let cells =
        |line: &str| line.split("  ").map(str::trim).filter(|c| !c.is_empty()).map(String::from).collect();
    lines.map(cells).collect()
}

#[test]
fn two_placements_have_the_scores_of_the_sweep() {
    let folder = swept();
    let out = folder.path("out");
    let outcome = compare(&[&out], &["--pose", "camera:wall/1/0", "--pose", "posts/leaning"]);
    for shown in [
        "\nA  wall, x 0.0 m, 1.2 m high, level\n   camera:wall/1/0 · camera · points\n",
        "\n   lidar:posts/leaning · lidar · points\n",
        "\nOnly the near side of a body can be hit",
    ] {
        assert!(outcome.stdout.contains(shown), "no {shown:?} in {}", outcome.stdout);
    }
    let known = scores(&out);
    for region in ["robot", "box", "human"] {
        let rows = rows(&outcome, region);
        let mut rows = rows.iter().skip_while(|row| row[0] != "A");
        let header = rows.next().unwrap();
        assert_eq!(header[..], ["A", "B", "B − A", "upper bound"]);
        for (scene, kind) in
            [("*", "mean"), ("*", "worst"), ("*", "pooled"), ("cell", "mean"), ("second", "mean")]
        {
            for score in SCORES {
                let row = rows.next().unwrap_or_else(|| panic!("no {scene} {kind} {score}"));
                let label = row.iter().position(|cell| cell == score);
                let label = label.unwrap_or_else(|| panic!("{scene} {kind} {score}: {row:?}"));
                let each = ["camera:wall/1/0", "lidar:posts/leaning"].map(|poses| {
                    known[&[scene, poses, region].map(String::from)][&format!("{score}_{kind}")].clone()
                });
                let shown: Vec<&str> =
                    row[label + 1..].iter().map(|c| c.rsplit("] ").next().unwrap()).collect();
                assert_eq!(shown[..2], each.clone().map(|v| number(&v)), "{region} {scene} {kind} {score}");
                let difference = match each.map(|v| v.parse::<f64>()) {
                    [Ok(a), Ok(b)] if (b - a).abs() < 0.0005 => "0.000".into(),
                    [Ok(a), Ok(b)] => format!("{:+.3}", b - a),
                    _ => "–".into(),
                };
                assert_eq!(shown[2], difference, "{region} {scene} {kind} {score}");
            }
        }
        assert_eq!(rows.next(), None);
    }
}

#[test]
fn the_best_are_those_of_the_score() {
    let folder = swept();
    let out = folder.path("out");
    let outcome = compare(&[&out], &["--best", "3", "--score", "unknown", "--region", "box"]);
    assert!(
        !outcome.stdout.contains("Region robot") && !outcome.stdout.contains("B − A"),
        "{}",
        outcome.stdout
    );
    let mut best: Vec<(f64, String)> = scores(&out)
        .into_iter()
        .filter(|([scene, _, region], _)| scene == "*" && region == "box")
        .map(|([_, poses, _], row)| (row["unknown_mean"].parse().unwrap(), poses))
        .collect();
    best.sort_by(|a, b| a.0.total_cmp(&b.0));
    for ((letter, (value, poses)), next) in ["A", "B", "C"].into_iter().zip(&best).zip(&best[1..]) {
        assert!(*value < next.0, "no ties, for a test that is clear: {best:?}");
        let name = outcome.stdout.split_once(&format!("\n{letter}  ")).unwrap().1.lines().nth(1).unwrap();
        assert!(name.trim().starts_with(&format!("{poses} · ")), "{letter}: {name}, not {poses}");
    }
}

#[test]
fn two_sweeps_stand_side_by_side_with_what_differs() {
    let folder = swept();
    fs::rename(folder.path("out"), folder.path("before")).unwrap();
    folder.edit("study.toml", "resolution_px = [16, 9]", "resolution_px = [64, 36]");
    assert_eq!(folder.sweep(&[]).code, Some(0));
    let (before, after) = (folder.path("before"), folder.path("out"));
    let pose = ["--pose", "wall/1/0", "--combination", "camera", "--scene", "second"];
    let outcome = compare(&[&before, &after], &pose);
    assert!(outcome.stderr.contains("resolution_px was [16,9], is [64,36]"), "{}", outcome.stderr);
    for folder in [&before, &after] {
        let shown = format!("camera:wall/1/0 · camera · points · {}\n", folder.display());
        assert!(outcome.stdout.contains(&shown), "no {shown:?} in {}", outcome.stdout);
        assert!(outcome.stdout.contains(&format!("upper bound, {}", folder.display())), "{}", outcome.stdout);
    }
    let known = [&before, &after].map(|out| scores(out));
    let f1 = known.map(|known| {
        number(&known[&["second", "camera:wall/1/0", "human"].map(String::from)]["f1_mean"].clone())
    });
    let row = rows(&outcome, "human").into_iter().find(|row| row.contains(&"f1".to_string())).unwrap();
    assert_eq!((row[0].as_str(), &row[3..5]), ("second", &f1[..]));
    assert_ne!(f1[0], f1[1]);
    // The same sweep under another name.
    fs::remove_dir_all(&before).unwrap();
    fs::create_dir(&before).unwrap();
    for name in ["manifest.json", "poses.csv", "counts.journal"] {
        fs::copy(after.join(name), before.join(name)).unwrap();
    }
    let same = compare(&[&before, &after], &pose);
    assert!(same.stderr.contains("are sweeps of the same study"), "{}", same.stderr);
}

#[test]
fn what_only_one_sweep_has_is_told() {
    let folder = swept();
    fs::rename(folder.path("out"), folder.path("before")).unwrap();
    fs::rename(folder.path("second.toml"), folder.path("third.toml")).unwrap();
    folder.edit("study.toml", "second.toml", "third.toml");
    folder.edit("study.toml", "name = \"box\"", "name = \"bench\"");
    folder.edit("study.toml", "name = \"wall\"", "name = \"north\"");
    folder.edit("study.toml", "wall/0/0", "north/0/0");
    let swept = folder.sweep(&[]);
    assert_eq!(swept.code, Some(0), "{}", swept.stderr);
    let (before, after) = (folder.path("before"), folder.path("out"));
    let names = ["--pose", "wall/1/0", "--pose", "north/1/0"];
    let outcome = compare(&[&before, &after], &names);
    for shown in [
        "note: left out, since one sweep has no such scene: second, third\n",
        "note: left out, since one sweep has no such region: box, bench\n",
        &format!("note: left out: {}: --pose wall/1/0: no such choice of poses", after.display()),
        &format!("note: left out: {}: --pose north/1/0: no such choice of poses", before.display()),
    ] {
        assert!(outcome.stderr.contains(shown), "no {shown:?} in {}", outcome.stderr);
    }
    assert!(
        !outcome.stdout.contains("Region box") && !outcome.stdout.contains("third"),
        "{}",
        outcome.stdout
    );
    assert_eq!(rows(&outcome, "human")[0][..3], ["A", "B", "B − A"], "one of each sweep");
}

#[test]
fn a_name_of_several_combinations_is_each_of_them() {
    let folder = Folder::new();
    let twice = "[[combination]]\nname = \"one\"\nsensors = [\"camera\"]\n[[combination]]\nname = \"two\"\nsensors = [\"camera\"]\n";
    folder.edit("study.toml", "", twice);
    assert_eq!(folder.sweep(&[]).code, Some(0));
    let outcome = compare(&[&folder.path("out")], &["--pose", "wall/0/0"]);
    for shown in ["A  wall, ", "camera:wall/0/0 · one · points", "camera:wall/0/0 · two · points"] {
        assert!(outcome.stdout.contains(shown), "no {shown:?} in {}{}", outcome.stdout, outcome.stderr);
    }
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let folder = swept();
    let out = folder.path("out");
    let other = folder.path("study.toml");
    let two = ["--pose", "wall/0/0", "--pose", "wall/1/0"];
    for (folders, more, expected) in [
        (vec![&out], &["--pose", "wall/0/0"][..], "1 placements: must be 2 to 26"),
        (vec![&out], &["--pose", "wall/0/0", "--pose", "camera:wall/0/0"], "1 placements: must be 2 to 26"),
        (vec![&out], &["--best", "1"], "1 placements: must be 2 to 26"),
        (vec![&out], &["--best", "27"], "27 is not in 1..=26"),
        (vec![&out], &[], "--pose <POSES>"),
        (vec![&out], &["--pose", "wal/0/0", "--pose", "wall/1/0"], "did you mean camera:wall/0/0?"),
        (vec![&out], &[&two[..], &["--scene", "third"]].concat(), "does not exist; there are cell, second"),
        (vec![&out], &[&two[..], &["--region", "third"]].concat(), "there are robot, box, human"),
        (vec![&out], &[&two[..], &["--combination", "third"]].concat(), "there are camera, lidar, both"),
        (vec![&out], &["--best", "2", "--combination", "third"], "there are camera, lidar, both"),
        (vec![&out], &[&two[..], &["--representation", "third"]].concat(), "there are points"),
        (vec![&out], &["--best", "2", "--representation", "third"], "there are points"),
        (vec![&out], &[&two[..], &["--score", "f1"]].concat(), "cannot be used with"),
        (vec![&out, &out], &two, "is named twice"),
        (vec![&other], &two, "is not a folder: name one written by `perirobot sweep` or `perirobot choose`"),
        (
            vec![&out, &other],
            &two,
            "is not a folder: name one written by `perirobot sweep` or `perirobot choose`",
        ),
        (vec![&out, &other, &other], &two, "unexpected"),
    ] {
        let folders: Vec<&Path> = folders.into_iter().map(|path| path.as_path()).collect();
        let outcome = compare(&folders, more);
        let what = format!("{more:?}: {}", outcome.stderr);
        assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(2), ""), "{what}");
        assert!(outcome.stderr.contains(expected), "no {expected:?} in {what}");
        assert!(!outcome.stderr.contains("panicked"), "{what}");
    }
}
