//! Proofs of the cheapest set that passes: those that hold, and what is refused.

use std::collections::BTreeMap;
use std::fs;

use serde_json::{Value, json};

use super::cheapest::json;
use crate::common::program::{Folder, Outcome, choose, perirobot, text};
use crate::common::purchase::folder;

fn verify(folder: &Folder, out: &str) -> Outcome {
    let (study, out) = (folder.path("study.toml"), folder.path(out));
    perirobot(&["choose", text(&study), "--verify", text(&out), "--backend", "cpu", "--progress", "none"])
}

#[track_caller]
fn holds(folder: &Folder, out: &str) -> String {
    let outcome = verify(folder, out);
    assert_eq!(outcome.code, Some(0), "{}{}", outcome.stdout, outcome.stderr);
    assert!(outcome.stdout.contains("all claims hold"), "{}", outcome.stdout);
    outcome.stdout
}

#[track_caller]
fn fails(folder: &Folder, out: &str, words: &[&str]) {
    let outcome = verify(folder, out);
    assert_eq!(outcome.code, Some(2), "{words:?}: {}{}", outcome.stdout, outcome.stderr);
    for word in words {
        assert!(outcome.stderr.contains(word), "no {word:?} in {}", outcome.stderr);
    }
}

/// Writes the answer with something changed.
fn rewrite(folder: &Folder, file: &str, change: impl FnOnce(&mut Value)) {
    let mut report = json(folder, "out", file);
    change(&mut report);
    fs::write(folder.path("out").join(file), serde_json::to_vec_pretty(&report).unwrap()).unwrap();
}

#[test]
fn answers_of_all_kinds_hold() {
    let cases = [
        ("[choose]\nthen = \"f1\"\nregion = \"robot\"\n", "at_most = 0.9", Some(0)),
        ("[choose]\nfront = \"speed\"\n", "at_most = 0.9", Some(0)),
        (
            "[choose]\nfront = \"requirements\"\nthen = \"unknown\"\nregion = \"robot\"\n",
            "at_most = 0.8",
            Some(0),
        ),
        ("[choose]\nat_most = 2\n", "at_most = 0.01", Some(4)),
    ];
    for (asked, limit, code) in cases {
        let folder = folder();
        folder.edit("study.toml", "", asked);
        folder.edit("study.toml", "at_most = 0.9", limit);
        let outcome = choose(&folder, "out", &[]);
        assert_eq!(outcome.code, code, "{asked}: {}{}", outcome.stdout, outcome.stderr);
        let said = holds(&folder, "out");
        assert!(!said.contains("0 claims searched again"), "{said}");
        // The study need not be named.
        let out = folder.path("out");
        let unnamed = perirobot(&["choose", "--verify", text(&out), "--progress", "none"]);
        assert_eq!(unnamed.code, Some(0), "{}", unnamed.stderr);
        assert_eq!(unnamed.stdout, said);
    }
    // An entry beside the robot: no set comes near, so that there is no table of sets.
    let folder = folder();
    folder.edit("study.toml", "min_m = [1.2, -1.2, 0]", "min_m = [-0.6, -1.2, 0]");
    folder.edit("study.toml", "at_most = 0.9", "at_most = 0.001");
    assert_eq!(choose(&folder, "out", &[]).code, Some(4));
    holds(&folder, "out");
}

/// A screen hides a way in at the second moment only.
#[test]
fn the_object_before_a_way_is_that_of_all_moments() {
    let folder = Folder::new();
    folder.write(
        "cell.toml",
        "[[object]]\nname = \"floor\"\nplane = { size_m = [4, 3] }\n\
         [[object]]\nname = \"robot\"\nrole = \"robot\"\ncylinder = { radius_m = 0.2, height_m = 1.2 }\n\
         position_m = [-1.3, 0, 0.6]\n\
         [[object]]\nname = \"screen\"\nbox = { size_m = [3.8, 0.1, 1.0] }\n\
         [object.snapshots]\nposition_m = [[0, 1.4, 0.55], [0, 0.8, 0.55]]\n",
    );
    folder.write(
        "study.toml",
        "currency = \"EUR\"\n[grid]\nvoxel_size_m = 0.1\nbounds_m = { min = [-2, -1.5, 0], max = [2, 1.5, 2.2] }\n\
         [[scene]]\nfile = \"cell.toml\"\n\
         [[region]]\nname = \"all\"\nbox = { min_m = [-2, -1.5, 0], max_m = [2, 1.5, 2.2] }\n\
         [[sensor]]\nname = \"scanner\"\nkind = \"lidar\"\nrings_deg = [0]\nresolution_deg = 1\nfov_deg = 180\n\
         range_m = [0.05, 6]\ncost = 100\n\
         [[sensor.poses]]\nname = \"wall\"\nlist = [{ position_m = [0, 1.15, 0.35], facing = [0, -1, 0] }]\n\
         [[require]]\nname = \"far\"\nscore = \"nearest_unnoticed_m\"\nat_least = 0.5\n\
         [approach]\n[[approach.body]]\nname = \"standing\"\n\
         [[approach.entry]]\nname = \"east\"\nbox = { min_m = [1.2, -1.2, 0], max_m = [2, 0.4, 2.2] }\n",
    );
    let outcome = choose(&folder, "out", &[]);
    assert_eq!(outcome.code, Some(4), "{}{}", outcome.stdout, outcome.stderr);
    assert!(outcome.stdout.contains("of the hazard behind \"screen\", over"), "{}", outcome.stdout);
    holds(&folder, "out");
}

#[test]
fn a_stopped_search_claims_less() {
    let folder = folder();
    assert_eq!(choose(&folder, "out", &[]).code, Some(0));
    let point = |report: &mut Value| {
        let point = &mut report["points"][0];
        point["proven"] = json!(false);
        point["best_of_cost"] = json!(false);
        point["no_set_below"] = json!(300.0);
        point.as_object_mut().unwrap().remove("ties");
    };
    rewrite(&folder, "cheapest.json", |report| {
        point(report);
        report["stopped"] = json!(true);
    });
    let path = folder.path("out").join("cheapest.csv");
    let table = fs::read_to_string(&path).unwrap();
    let cost = json(&folder, "out", "cheapest.json")["points"][0]["set"]["cost"].to_string();
    let cost = cost.trim_end_matches(".0");
    let changed = table.replace(&format!("{cost},{cost},1"), &format!("{cost},300,0"));
    assert_ne!(table, changed, "{cost}");
    fs::write(&path, changed).unwrap();
    assert!(holds(&folder, "out").contains("the search was stopped"));
    // That it was stopped must be said.
    rewrite(&folder, "cheapest.json", |report| report["stopped"] = json!(false));
    fails(&folder, "out", &["stopped"]);
}

/// A value that is not another one.
fn alter(value: &Value) -> Value {
    match value {
        Value::Bool(is) => json!(!is),
        Value::Number(number) if number.is_u64() => json!(number.as_u64().unwrap() + 1),
        Value::Number(number) if number.is_i64() => json!(number.as_i64().unwrap() - 1),
        Value::Number(number) => json!(number.as_f64().unwrap() + 0.5),
        Value::String(text) => json!(format!("{text}x")),
        _ => json!(3),
    }
}

/// The places of all values of a file, as JSON pointers.
fn find_leaves(value: &Value, at: String, all: &mut Vec<String>) {
    let escaped = |key: &String| key.replace('~', "~0").replace('/', "~1");
    match value {
        Value::Array(each) if !each.is_empty() => {
            each.iter().enumerate().for_each(|(i, one)| find_leaves(one, format!("{at}/{i}"), all));
        }
        Value::Object(each) => {
            each.iter().for_each(|(key, one)| find_leaves(one, format!("{at}/{}", escaped(key)), all));
        }
        Value::Array(_) => {}
        _ => all.push(at),
    }
}

#[test]
fn every_single_alteration_is_refused() {
    alter_each_value("speed");
}

#[test]
fn every_single_alteration_of_numbers_of_requirements_is_refused() {
    alter_each_value("requirements");
}

/// Alters each value of an answer with a front.
#[track_caller]
fn alter_each_value(front: &str) {
    let folder = folder();
    folder.edit("study.toml", "cost = 250.5", "cost = 250.5\nemits = \"tof\"");
    let disturb = "disturb = { apart_deg = 40, overlap = 0.3 }";
    let asked = format!("[choose]\n{disturb}\nfront = \"{front}\"\nthen = \"f1\"\nregion = \"robot\"\n");
    folder.edit("study.toml", "", &asked);
    folder.edit("study.toml", "at_most = 0.9", "at_most = 0.9\nfor = \"SF2: what is around the robot\"");
    folder.edit("study.toml", "[grid]", "currency = \"EUR\"\n[grid]");
    assert_eq!(choose(&folder, "out", &[]).code, Some(0));
    holds(&folder, "out");
    let path = folder.path("out").join("cheapest.json");
    let (text, right) = (fs::read_to_string(&path).unwrap(), json(&folder, "out", "cheapest.json"));
    let mut all = Vec::new();
    find_leaves(&right, String::new(), &mut all);
    // Of values that have the same names the first and the last one. How many sets were tested is not checked.
    let mut by_name: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for place in all.into_iter().filter(|place| !place.ends_with("/tested")) {
        let name: Vec<&str> = place.split('/').filter(|key| key.parse::<usize>().is_err()).collect();
        by_name.entry(name.join("/")).or_default().push(place);
    }
    let mut count = 0;
    for places in by_name.values() {
        let last = places.last().filter(|last| **last != places[0]);
        for place in places.first().into_iter().chain(last) {
            let mut report = right.clone();
            let value = report.pointer_mut(place).unwrap();
            *value = alter(value);
            fs::write(&path, serde_json::to_vec_pretty(&report).unwrap()).unwrap();
            let outcome = verify(&folder, "out");
            assert_eq!(outcome.code, Some(2), "{place}: {}{}", outcome.stdout, outcome.stderr);
            assert!(outcome.stderr.contains("cheapest.json"), "{place}: {}", outcome.stderr);
            count += 1;
        }
    }
    assert!(count >= 60, "{count} alterations");
    fs::write(&path, text).unwrap();
    holds(&folder, "out");
}

#[test]
fn proofs_that_are_altered_with_care_are_refused_where_they_do_not_hold() {
    let folder = folder();
    folder.edit("study.toml", "", "[choose]\nthen = \"f1\"\nregion = \"robot\"\n");
    assert_eq!(choose(&folder, "out", &[]).code, Some(0));
    let path = folder.path("out").join("cheapest.json");
    let text = fs::read_to_string(&path).unwrap();
    let right = json(&folder, "out", "cheapest.json");
    let ways = right["ways_in"].as_array().unwrap().len();
    assert!(ways > 0 && right["points"][0]["set"]["sensors"].as_array().unwrap().len() > 1, "{right}");
    let all = |report: &mut Value, change: &dyn Fn(&mut Value)| {
        report["ways_in"].as_array_mut().unwrap().iter_mut().for_each(change);
    };
    type Change<'c> = &'c dyn Fn(&mut Value);
    let pop = |way: &mut Value| drop(way["noticed_by"].as_array_mut().unwrap().pop());
    let cases: [(Change, &[&str]); 12] = [
        (&|report| drop(report["points"].as_array_mut().unwrap().pop()), &["points"]),
        (
            &|report| report["points"].as_array_mut().unwrap().push(right["points"][0].clone()),
            &["points[1].aim"],
        ),
        (&|report| report["points"][0]["aim"] = json!({ "speed": 0.25 }), &["points[0].aim"]),
        (
            &|report| drop(report["points"][0]["set"]["sensors"].as_array_mut().unwrap().pop()),
            &["points[0].set"],
        ),
        (
            &|report| report["points"][0]["set"]["sensors"].as_array_mut().unwrap().reverse(),
            &["set.sensors", "order"],
        ),
        (&|report| report["points"][0]["set"] = Value::Null, &["points[0]"]),
        (&|report| all(report, &pop), &["ways_in[0].places[", "notice the body"]),
        (&|report| all(report, &|way| way["noticed_by"] = json!(["camera:wall/west"])), &["ways_in[0]"]),
        (&|report| drop(report["ways_in"][0]["places"].as_array_mut().unwrap().pop()), &["ways_in[0]"]),
        (
            &|report| drop(report["ways_in"][0]["places"].as_array_mut().unwrap().remove(0)),
            &["ways_in[0].places[0]"],
        ),
        (&|report| report["ways_in"][0]["places"] = json!([]), &["ways_in[0].places"]),
        (&|report| report["ways_in"][0]["repeat"] = json!(1), &["ways_in[0]"]),
    ];
    for (change, words) in cases {
        rewrite(&folder, "cheapest.json", change);
        fails(&folder, "out", words);
        fs::write(&path, &text).unwrap();
    }
    // Without a way in its proof is still one, if the plain search judges what is left.
    rewrite(&folder, "cheapest.json", |report| report["ways_in"] = json!([]));
    assert!(holds(&folder, "out").contains(" 0 ways in"));
    fs::write(&path, &text).unwrap();
    // Tables.
    for (file, from, to) in [
        ("cheapest.csv", ",1,", ",0,"),
        ("results.csv", "cheapest,", "cheapestx,"),
        ("scores.csv", "cheapest,", "cheapestx,"),
        ("poses.csv", "camera", "cam"),
        ("requirements.csv", "PASS", "FAIL"),
        ("conditions.csv", "as_planned", "postures"),
        ("speeds.csv", "PASS", "FAIL"),
        ("judge.json", "true", "false"),
    ] {
        let path = folder.path("out").join(file);
        let own = fs::read_to_string(&path).unwrap();
        assert!(own.contains(from), "{file}: {own}");
        fs::write(&path, own.replacen(from, to, 1)).unwrap();
        fails(&folder, "out", &[file]);
        fs::write(&path, own).unwrap();
    }
    holds(&folder, "out");
}

#[test]
fn a_dearer_set_is_not_the_cheapest() {
    let folder = folder();
    assert_eq!(choose(&folder, "out", &[]).code, Some(0));
    // All sensors pass, too, and a cheaper set does.
    let all = ["west", "east", "north", "south"].map(|name| format!("camera:wall/{name}")).join("\", \"");
    folder.edit("study.toml", "", &format!("[choose]\nalways = [\"{all}\"]\n"));
    assert_eq!(choose(&folder, "dear", &[]).code, Some(0));
    folder.edit("study.toml", &format!("[choose]\nalways = [\"{all}\"]\n"), "");
    let dear = json(&folder, "dear", "cheapest.json");
    rewrite(&folder, "cheapest.json", |report| report["points"] = dear["points"].clone());
    fails(&folder, "out", &["points[0].no_set_below", "this set passes"]);
}

/// A set that comes nearest passes all but the reasons, whatever else an answer leaves out.
#[test]
fn a_set_that_leaves_out_more_than_the_reasons_is_not_the_nearest() {
    let folder = folder();
    folder.edit("study.toml", "", "[choose]\nfront = \"requirements\"\n");
    assert_eq!(choose(&folder, "cheap", &[]).code, Some(0));
    let cheap = json(&folder, "cheap", "cheapest.json")["points"][1].clone();
    folder.edit("study.toml", "at_most = 0.9", "at_most = 0.01");
    folder.edit("study.toml", "front = \"requirements\"\n", "");
    assert_eq!(choose(&folder, "out", &[]).code, Some(4));
    holds(&folder, "out");
    rewrite(&folder, "cheapest.json", |report| {
        let nearest = &mut report["points"][1];
        nearest["aim"]["nearest"].as_array_mut().unwrap().push(json!("nobody comes near"));
        nearest["no_set_below"] = cheap["no_set_below"].clone();
        for key in ["cost", "sensors"] {
            nearest["set"][key] = cheap["set"][key].clone();
        }
    });
    fails(&folder, "out", &["points", "comes nearest: this one passes all but the reasons"]);
}

#[test]
fn a_study_that_asks_for_something_else_is_noticed() {
    let folder = folder();
    folder.edit("study.toml", "cost = 250.5", "cost = 250.5\nemits = \"tof\"");
    assert_eq!(choose(&folder, "out", &[]).code, Some(0));
    for (from, to, words) in [
        ("emits = \"tof\"", "emits = \"laser\"", "asked.sensors.narrow.emits"),
        ("at_most = 0.9", "at_most = 0.91", "asked.require[1].at_most"),
        ("at_most = 0.9", "at_most = 0.9\nfor = \"SF2\"", "asked.require[1]"),
        ("[grid]", "currency = \"EUR\"\n[grid]", "asked.currency"),
        ("at_least = 1.2", "at_least = 1.1", "asked.require[0].at_least"),
        ("cost = 450", "cost = 451", "asked.sensors.camera.cost"),
        ("min_voxels = 3", "min_voxels = 4", "asked.tables_sha256"),
        ("intrusion_m = 0.1", "intrusion_m = 0.2", "asked.tables_sha256"),
        ("position_m = [-1.9, 0, 2.1]", "position_m = [-1.9, 0.1, 2.1]", "fingerprint"),
    ] {
        folder.edit("study.toml", from, to);
        fails(&folder, "out", &[words]);
        folder.edit("study.toml", to, from);
    }
    for asked in [
        "front = \"speed\"",
        "apart_m = 0.5",
        "disturb = { overlap = 0.5 }",
        "at_most = 3",
        "budget = 2000",
        "then = \"f1\"\nregion = \"robot\"",
    ] {
        let asked = format!("[choose]\n{asked}\n");
        folder.edit("study.toml", "", &asked);
        fails(&folder, "out", &["asked."]);
        folder.edit("study.toml", &asked, "");
    }
    holds(&folder, "out");
}
