//! What *Find* streams, against the command that finds the same.

use std::collections::BTreeMap;
use std::path::Path;

use serde_json::{Value, json};

use crate::common::program::{perirobot, text};
use crate::planner::Planner;

/// The cheapest set of each speed of the robot.
const STUDY: &str = "scenes/cheapest.toml";

/// The lines of an answer that grows.
fn lines(planner: &Planner, question: &Value) -> Vec<Value> {
    let (status, body) = planner.send("POST", "/choose", &question.to_string());
    let body = String::from_utf8(body).unwrap();
    assert_eq!(status, 200, "{body}");
    body.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// Cost and poses of each set of `perirobot choose`, in the order of the question.
fn chosen(out: &Path) -> Vec<(f64, Vec<String>)> {
    let outcome = perirobot(&["choose", STUDY, "--out", text(out), "--backend", "cpu"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let mut reader = csv::Reader::from_path(out.join("cheapest.csv")).unwrap();
    let rows: Vec<BTreeMap<String, String>> = reader.deserialize().collect::<Result<_, _>>().unwrap();
    let own = rows.iter().filter(|row| !row["cost"].is_empty());
    own.map(|row| (row["cost"].parse().unwrap(), row["poses"].split(';').map(String::from).collect()))
        .collect()
}

#[test]
fn sets_and_bounds_come_while_it_searches() {
    let folder = tempfile::tempdir().unwrap();
    let planner = Planner::start(STUDY, &["--read-only", "--backend", "cpu"]);
    let all = lines(&planner, &json!({ "ask": "cheapest" }));
    planner.end();
    let done = all.iter().position(|line| line.get("done").is_some()).expect("an end");
    assert_eq!(done, all.len() - 1, "{all:?}");
    let said: Vec<&str> = all.iter().filter_map(|line| line["search"].as_str()).collect();
    assert!(said[0].starts_with("cheapest: ") && said[0].contains(" tested"), "{said:?}");
    let expected = chosen(&folder.path().join("out"));
    let bounds: Vec<f64> = all.iter().filter_map(|line| line["bound"]["cost"].as_f64()).collect();
    assert!(bounds.is_sorted() && bounds.len() > 1, "{bounds:?}");
    assert_eq!(bounds.last(), Some(&expected[0].0), "the cheapest is proven");
    // The newest set of each part.
    let mut sets = BTreeMap::new();
    for point in all.iter().map(|line| &line["point"]).filter(|point| !point.is_null()) {
        let part = point["part"].as_u64().unwrap();
        let before = sets.insert(part, point);
        assert!(before.is_none_or(|before| before["cost"].as_f64() >= point["cost"].as_f64()), "{before:?}");
    }
    let pose = |one: &Value| format!("{}:{}", one["sensor"].as_str().unwrap(), one["pose"].as_str().unwrap());
    let named = |point: &Value| point["placed"].as_array().unwrap().iter().map(pose).collect::<Vec<_>>();
    let found: Vec<_> = sets.values().map(|point| (point["cost"].as_f64().unwrap(), named(point))).collect();
    assert_eq!(found, expected);
    assert!(sets.values().all(|point| point["is_proven"] == true), "{sets:?}");
}

/// A study that asks for the best score.
const BEST: &str = "scenes/choose.toml";

#[test]
fn sets_come_while_the_best_score_is_searched() {
    let planner = Planner::start(BEST, &["--read-only", "--backend", "cpu"]);
    let all = lines(&planner, &json!({ "ask": "score", "score": "f1", "region": "robot", "at_most": 3 }));
    planner.end();
    let front = all.iter().position(|line| line.get("front").is_some()).expect("the answer");
    let score = |point: &Value| point["score"].as_f64().unwrap();
    // The best so far within some limits only gets better.
    let mut parts: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
    for point in all[..front].iter().map(|line| &line["point"]).filter(|point| !point.is_null()) {
        assert_eq!(point["is_proven"], false);
        parts.entry(point["part"].as_u64().unwrap()).or_default().push(score(point));
    }
    assert!(parts.len() >= 3 && parts.values().all(|scores| scores.is_sorted()), "{parts:?}");
    // What no set is above is of the whole question, from the first on.
    let bounds: Vec<f64> = all.iter().filter_map(|line| line["bound"]["score"].as_f64()).collect();
    let answer = all[front]["front"].as_array().unwrap();
    let best = answer.iter().map(score).fold(0.0, f64::max);
    let found = parts.values().map(|scores| scores[scores.len() - 1]).fold(0.0, f64::max);
    assert!(answer.iter().all(|point| point["is_proven"] == true) && best == found, "{answer:?}");
    assert!(!bounds.is_empty() && bounds.iter().all(|&bound| bound >= best), "{bounds:?} {best}");
    assert!(answer.iter().all(|point| (1..=3).contains(&point["placed"].as_array().unwrap().len())));
}
