//! `judge.json` and `approach.json`: the values of the tables beside them, row by row.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use crate::common::program::{Folder, perirobot, rows, shelf, text};
use perirobot_decide::approach::Approaches;
use perirobot_decide::judge::Verdicts;
use serde_json::Value;

const BOTH: &str = "camera:wall/front;camera:wall/back";

/// A requirement of each kind, under conditions that have several cases, and one that nothing meets.
const REQUIRED: &str = r#"
[[require]]
name = "little is unknown"
score = "unknown"
region = "near@1"
over = "mean"
at_most = 0.58
under = ["as_planned", "one_sensor_dead", "mounting_error", "postures"]
[[require]]
name = "far"
for = "SF1: stop before a person is near"
score = "nearest_unnoticed_m"
body = "standing"
at_least = 1
under = ["as_planned", "one_sensor_dead"]
[[require]]
name = "measured"
score = "missed_m"
at_most = 0.1
under = ["as_planned", "two_sensors_dead"]
[[require]]
name = "all is right"
score = "f1"
region = "robot"
at_least = 1
[mounting_error]
draws = 2
position_m = 0.02
[postures]
people = ["small"]
spots = [[1, 0.5, 0]]
"#;

/// A swept cell with coarse voxels.
fn swept() -> Folder {
    let folder = shelf();
    folder.edit("study.toml", "voxel_size_m = 0.05", "voxel_size_m = 0.1");
    folder.edit("study.toml", "resolution_px = [320, 240]", "resolution_px = [80, 60]");
    folder.edit("study.toml", "", REQUIRED);
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    folder
}

#[track_caller]
fn run(command: &str, folder: &Folder, more: &[&str]) {
    let outcome = perirobot(&[&[command, text(&folder.path("out"))], more].concat());
    assert!(matches!(outcome.code, Some(0 | 4)), "{}", outcome.stderr);
}

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// A value as the tables write it.
fn cell(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) => text.clone(),
        Value::Number(number) if number.is_f64() => number.as_f64().unwrap().to_string(),
        other => other.to_string(),
    }
}

/// Compares a row of a table with an object of JSON. A column without a key of its name is looked up by `otherwise`.
#[track_caller]
fn same_row(row: &HashMap<String, String>, object: &Value, otherwise: &dyn Fn(&str) -> String) {
    for (column, expected) in row {
        let found = object.get(column).map_or_else(|| otherwise(column), cell);
        assert_eq!(&found, expected, "{column} of {object:#}");
    }
}

#[test]
fn judge_json_has_the_values_of_the_tables() {
    let folder = swept();
    let out = folder.path("out");
    run("judge", &folder, &["--pose", BOTH, "--combination", "both"]);
    let written = json(&out.join("judge.json"));
    assert_eq!((&written["format"], &written["perirobot"]), (&1.into(), &env!("CARGO_PKG_VERSION").into()));
    let [set] = written["sets"].as_array().unwrap().as_slice() else { panic!("{written:#}") };
    let mut seen = HashMap::new();
    for (table, key, place) in
        [("requirements.csv", "requirements", "worst"), ("conditions.csv", "conditions", "worst_at")]
    {
        let (rows, objects) = (rows(&out.join(table)), set[key].as_array().unwrap());
        assert_eq!(rows.len(), objects.len(), "{table}");
        for (row, object) in rows.iter().zip(objects) {
            same_row(row, object, &|column| match column {
                "combination" | "poses" | "representation" => cell(&set[column]),
                "verdict" if object["is_met"] == true => "PASS".into(),
                "verdict" => "FAIL".into(),
                _ => cell(&object[place][column]),
            });
            for (column, value) in row {
                seen.entry((table, column.clone())).or_insert_with(Vec::new).push(value.clone());
            }
        }
    }
    // Each column has a value somewhere, some of them none elsewhere, and one is infinite.
    let has = |(table, column): (&'static str, &str), is_meant: &dyn Fn(&String) -> bool| {
        seen[&(table, column.to_string())].iter().any(is_meant)
    };
    for (table, column) in seen.keys() {
        assert!(has((table, column), &|value| !value.is_empty()), "{table}: nothing in {column}");
    }
    for column in ["region", "at_least", "at_most", "body", "case", "snapshot", "tables_sha256", "for"] {
        assert!(has(("requirements.csv", column), &String::is_empty), "{column} is never empty");
    }
    assert!(has(("requirements.csv", "value"), &|value| value == "inf"));
    assert!(has(("requirements.csv", "verdict"), &|value| value == "PASS"));
    assert!(has(("conditions.csv", "worst"), &|value| value == "inf"));

    // What is read is what was written.
    let read = Verdicts::read(&out).unwrap().unwrap();
    assert_eq!(serde_json::to_value(&read).unwrap(), written);
    assert_eq!(read.sets[0].names(), ["both", BOTH, cell(&set["representation"]).as_str()]);
    assert!(
        read.sets[0].requirements.iter().any(|one| one.value.is_some_and(|value| value.0 == f64::INFINITY))
    );

    // Another judgement that fails leaves nothing of this one.
    folder.edit("study.toml", REQUIRED, "");
    assert_eq!(perirobot(&["judge", text(&out)]).code, Some(2));
    assert!(!out.join("judge.json").exists());
    assert_eq!(Verdicts::read(&out).unwrap(), None);
}

#[test]
fn approach_json_has_the_values_of_the_table() {
    let folder = swept();
    let out = folder.path("out");
    for (case, more) in [("", &[][..]), ("without camera:wall/back", &["--dead", "camera:wall/back"])] {
        run("approach", &folder, &[&["--pose", BOTH, "--out", text(&out)], more].concat());
        let written = json(&out.join("approach.json"));
        assert_eq!((&written["format"], cell(&written["case"])), (&1.into(), case.into()));
        let (rows, objects) = (rows(&out.join("approach.csv")), written["rows"].as_array().unwrap());
        assert!(rows.len() == objects.len() && !rows.is_empty(), "{} rows", rows.len());
        for (row, object) in rows.iter().zip(objects) {
            for (column, expected) in row {
                let (list, axis) = match column.strip_suffix("_m").unwrap_or(column) {
                    axis @ ("x" | "y" | "z") => ("middle_m", axis),
                    narrowest => ("narrowest_m", narrowest.strip_prefix("narrowest_").unwrap_or_default()),
                };
                let axis = ["x", "y", "z"].iter().position(|known| *known == axis);
                let value = match (column.as_str(), axis) {
                    ("combination" | "poses" | "representation" | "case", _) => &written[column],
                    (_, Some(axis)) => &object[list][axis],
                    _ => &object[column],
                };
                let found = match value {
                    Value::Number(number) if number.is_f64() => format!("{:.5}", number.as_f64().unwrap()),
                    Value::Array(names) => names.iter().map(cell).collect::<Vec<_>>().join(";"),
                    Value::Null if column == "snapshot" => "*".into(),
                    other => cell(other),
                };
                assert_eq!(&found, expected, "{column} of {object:#}");
            }
        }
        let read = Approaches::read(&out).unwrap().unwrap();
        assert_eq!(serde_json::to_value(&read).unwrap(), written);
        assert_eq!((read.names()[..2].to_vec(), read.case.as_str()), (vec!["both", BOTH], case));
    }
}
