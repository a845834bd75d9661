//! `perirobot choose` as it is used: what it prints and writes, which proofs hold, and what is refused.

use crate::common;
use std::collections::HashSet;
use std::fs;
use std::path::Path;

use crate::common::program::{self, Edit, Folder, choose, perirobot, priced, refused, rows, text};

const STUDY: &str = "study.toml";

const CHOOSE: &str = r#"
[choose]
objective = "f1"
region = "robot"
at_most = 3
budget = 1000.0
apart_m = 0.1
"#;

fn folder() -> Folder {
    priced(CHOOSE)
}

#[test]
fn all_backends_write_the_same_bytes_however_many_threads() {
    let folder = folder();
    let first = choose(&folder, "oracle", &["--backend", "oracle"]);
    assert_eq!(first.code, Some(0), "{}", first.stderr);
    let files = ["front.csv", "sets.csv", "choose.json", "results.csv", "scores.csv", "poses.csv"];
    let read = |out: &str| files.map(|file| fs::read_to_string(folder.path(out).join(file)).unwrap());
    let expected = read("oracle");
    assert!(expected[0].starts_with("at_most,sensors,cost,f1,bound,proven,gain,poses\n"), "{}", expected[0]);
    assert!(expected[0].lines().skip(1).all(|line| line.contains(",true,")), "{}", expected[0]);
    assert!(expected[0].lines().count() >= 5, "{}", expected[0]);
    let best = " in region robot; no allowed set has more, which is proven\n\n  sensor ";
    assert!(first.stdout.contains(best), "{}", first.stdout);
    assert!(first.stdout.ends_with(&format!("next: perirobot report {}\n", text(&folder.path("oracle")))));
    let mut others =
        vec![vec!["--backend", "cpu", "--threads", "1"], vec!["--backend", "cpu", "--threads", "2"]];
    others.extend(common::on_adapter().map(Vec::from));
    for (number, options) in others.iter().enumerate() {
        let out = format!("out{number}");
        let outcome = choose(&folder, &out, options);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        assert_eq!(read(&out), expected, "{options:?}");
        assert_eq!(outcome.stdout.replace(&out, "oracle"), first.stdout, "{options:?}");
    }
}

#[test]
fn people_read_costs_in_the_currency_of_the_study() {
    let folder = folder();
    folder.edit(STUDY, "cost = 499.5", "cost = 1499.5");
    folder.edit(STUDY, "budget = 1000.0", "budget = 1750.0");
    let plain = choose(&folder, "plain", &[]);
    assert_eq!(plain.code, Some(0), "{}", plain.stderr);
    assert!(plain.stdout.contains("by at most 3 sensors for 1750 together"), "{}", plain.stdout);
    folder.edit(STUDY, "seed = 7", "seed = 7\ncurrency = \"kEUR\"");
    let outcome = choose(&folder, "out", &[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    for words in
        ["by at most 3 sensors for 1,750 kEUR together", " 250 kEUR  ", "3 sensors for 750 kEUR have F1 "]
    {
        assert!(outcome.stdout.contains(words), "no {words:?} in {}", outcome.stdout);
    }
    // Tables hold numbers, the answer says in which unit.
    let [plain, out] = ["plain", "out"].map(|name| folder.path(name));
    for name in ["front.csv", "sets.csv", "results.csv"] {
        assert_eq!(fs::read(plain.join(name)).unwrap(), fs::read(out.join(name)).unwrap(), "{name}");
    }
    let answer: serde_json::Value =
        serde_json::from_slice(&fs::read(out.join("choose.json")).unwrap()).unwrap();
    assert_eq!(answer["asked"]["currency"], "kEUR");
    let report = perirobot(&["report", text(&out), "--progress", "none"]);
    assert_eq!(report.code, Some(0), "{}", report.stderr);
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    for words in [">cost, kEUR<", "of a budget of 1,750 kEUR", "· cost 250 kEUR", "cost = 250 kEUR"] {
        assert!(page.contains(words), "no {words:?} in the page");
    }
}

#[test]
fn programs_are_told_how_the_search_proceeds() {
    let folder = folder();
    let quiet = choose(&folder, "quiet", &["--backend", "cpu"]);
    assert!(!quiet.stderr.contains("event"), "{}", quiet.stderr);
    let (study, out) = (folder.path(STUDY), folder.path("out"));
    let told = perirobot(&["choose", text(&study), "--out", text(&out), "--progress", "json"]);
    let lines = told.stderr.lines().filter(|line| line.starts_with('{'));
    let lines: Vec<serde_json::Value> = lines.map(|line| serde_json::from_str(line).unwrap()).collect();
    let search: Vec<_> = lines.iter().filter(|line| line["event"] == "search").collect();
    // The last word on each step is what stands in the front.
    for step in rows(&out.join("front.csv")) {
        let (at_most, score): (u64, f64) = (step["at_most"].parse().unwrap(), step["f1"].parse().unwrap());
        let is_of = |line: &&&serde_json::Value| line["at_most"] == at_most;
        let is_told = |line: &&serde_json::Value| line["best"] == score && line["above"] == score;
        assert!(search.iter().filter(is_of).any(is_told), "{step:?}: {search:?}");
    }
    let first = &search[0];
    assert_eq!((&first["at_most"], &first["budget"]), (&1.into(), &1000.0.into()), "{first}");
    // All sums of costs are multiples of a half.
    assert!(search.iter().all(|line| (2.0 * line["budget"].as_f64().unwrap()).fract() == 0.0), "{search:?}");
    assert_eq!(lines.last().unwrap()["event"], "done");
}

#[test]
fn every_set_is_a_row_that_the_other_commands_take() {
    let folder = folder();
    let outcome = choose(&folder, "out", &["--backend", "cpu"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let out = folder.path("out");
    let found: Vec<_> =
        rows(&out.join("results.csv")).into_iter().filter(|row| row["region"] == "robot").collect();
    let front = rows(&out.join("front.csv"));
    assert!(front.len() >= 4 && found.len() >= front.len(), "{} steps, {} rows", front.len(), found.len());
    for step in &front {
        let row = found.iter().find(|row| row["poses"] == step["poses"]).expect("every set is a row");
        assert_eq!(row["f1"], step["f1"], "{step:?}");
    }
    let on = |command: &str, more: &[&str]| {
        let outcome = perirobot(&[&[command, text(&out)], more].concat());
        assert_eq!(outcome.code, Some(0), "{command} {more:?}: {}", outcome.stderr);
        outcome.stdout
    };
    let sets = [&front[front.len() - 1], &front[1]].map(|step| step["poses"].as_str());
    let [png, files] = ["set.png", "set"].map(|name| folder.path(name));
    for set in sets {
        assert!(set.contains(';'), "{set} has several sensors");
        assert!(on("why", &["--pose", set]).contains(&format!("{set} · best ")));
        on("render", &["--pose", set, "--size", "320x200", "--out", text(&png)]);
        assert!(fs::read(&png).unwrap().starts_with(b"\x89PNG"));
        on("export", &["--pose", set, "--out", text(&files)]);
        assert!(files.join("cell.glb").exists());
    }
    assert!(on("compare", &["--pose", sets[0], "--pose", sets[1]]).contains("Region robot"));
    let summary = on("summary", &["--score", "f1"]);
    assert!(summary.contains("best 3 for ") && summary.starts_with("asked: the highest F1"), "{summary}");
    assert!(
        summary.contains("\nAll are proven: no set of as many sensors or fewer "),
        "the front is told: {summary}"
    );
    on("report", &["--best", "1"]);
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert_eq!(page.matches("<circle class=\"proven\"").count(), front.len());
    assert!(page.contains(&format!(">{}</td>", sets[0])), "the front is a table, too");
    // What was chosen is no sweep of the study, and a sweep is not given up for it.
    let study = folder.path(STUDY);
    let swept = perirobot(&["sweep", text(&study), "--out", text(&out)]);
    assert_eq!(swept.code, Some(2));
    assert!(swept.stderr.contains("contains another sweep: "), "{}", swept.stderr);
    assert_eq!(folder.sweep(&["--restart"]).code, Some(0));
    fs::remove_file(out.join("choose.json")).unwrap();
    let journal = fs::read(out.join("counts.journal")).unwrap();
    let refused = choose(&folder, "out", &[]);
    assert_eq!(refused.code, Some(2));
    assert!(
        refused.stderr.contains("contains a sweep, which would be lost: name another"),
        "{}",
        refused.stderr
    );
    assert_eq!(fs::read(out.join("counts.journal")).unwrap(), journal);
    // The study of a folder is looked at as it was.
    folder.edit(STUDY, "seed = 7", "seed = 8");
    assert_eq!(choose(&folder, "other", &["--backend", "cpu"]).code, Some(0));
    folder.edit(STUDY, "seed = 8", "seed = 9");
    let changed = perirobot(&["why", text(&folder.path("other"))]);
    assert_eq!(changed.code, Some(2));
    assert!(
        changed.stderr.contains("has changed since the sweep: study.seed was 8, is 9"),
        "{}",
        changed.stderr
    );
}

#[test]
fn sets_of_sensors_of_every_kind_are_swept_as_they_were_taken() {
    let folder = Folder::new();
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let study = fs::read_to_string(scenes.join("sensors.toml")).unwrap();
    let asked = "[choose]\nobjective = \"parts_detected\"\nover = \"worst\"\nregion = \"human\"\nat_most = 2\n\
                 representation = { camera = \"box\", scanner = \"field\" }\nalways = [\"scanner:floor/bench\"]\n";
    let here = format!("\"{}/", scenes.join("sensors").display());
    folder.write(STUDY, study.replace("\"sensors/", &here) + asked);
    let outcome = choose(&folder, "out", &["--backend", "cpu", "--allow-outside"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let out = folder.path("out");
    let found = rows(&out.join("results.csv"));
    let said: HashSet<(&str, &str)> = found
        .iter()
        .flat_map(|row| row["poses"].split(';').zip(row["representation"].split(';')))
        .map(|(pose, way)| (pose.split(':').next().unwrap(), way))
        .collect();
    assert!(said.contains(&("scanner", "field")) && said.len() > 1, "{said:?}");
    assert!(!said.contains(&("scanner", "points")) && !said.contains(&("camera", "points")), "{said:?}");
    let set = rows(&out.join("front.csv")).pop().unwrap()["poses"].clone();
    let looked = perirobot(&["why", text(&out), "--pose", &set, "--allow-outside"]);
    assert_eq!(looked.code, Some(0), "{}", looked.stderr);
}

/// The proof of the small study with something changed, as `--verify` takes it.
#[track_caller]
fn verified(folder: &Folder, change: impl Fn(&mut serde_json::Value), expected: &[&str]) {
    let path = folder.path("out/choose.json");
    let written = fs::read_to_string(&path).unwrap();
    let mut proof = serde_json::from_str(&written).unwrap();
    change(&mut proof);
    fs::write(&path, proof.to_string()).unwrap();
    let outcome = perirobot(&["choose", "--verify", text(path.parent().unwrap()), "--progress", "none"]);
    fs::write(&path, written).unwrap();
    let code = if expected.is_empty() { 0 } else { 2 };
    assert_eq!(outcome.code, Some(code), "{}{}", outcome.stdout, outcome.stderr);
    for fragment in expected {
        assert!(outcome.stderr.contains(fragment), "no {fragment:?} in {}", outcome.stderr);
    }
}

#[test]
fn a_proof_holds_until_it_is_altered() {
    let folder = folder();
    let outcome = choose(&folder, "out", &["--backend", "cpu"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    verified(&folder, |_| {}, &[]);
    verified(
        &folder,
        |proof| proof["fingerprint"] = "00".into(),
        &["choose.json: fingerprint: the study has changed"],
    );
    verified(
        &folder,
        |proof| proof["asked"]["budget"] = 900.into(),
        &["asked: the study's question has changed"],
    );
    let (study, moved, out) = (folder.path(STUDY), folder.path("moved.toml"), folder.path("out"));
    fs::rename(&study, &moved).unwrap();
    let gone = perirobot(&["choose", "--verify", text(&out)]);
    assert_eq!(gone.code, Some(2), "{}", gone.stderr);
    assert!(
        gone.stderr.contains("or name the study: perirobot choose STUDY --verify DIR"),
        "{}",
        gone.stderr
    );
    let named = perirobot(&["choose", text(&moved), "--verify", text(&out)]);
    assert_eq!(named.code, Some(0), "{}", named.stderr);
    fs::rename(&moved, &study).unwrap();
    // Every step is missed.
    let steps =
        serde_json::from_str::<serde_json::Value>(&fs::read_to_string(out.join("choose.json")).unwrap());
    let steps = steps.unwrap()["steps"].as_array().unwrap().clone();
    for (number, step) in steps.iter().enumerate() {
        let expected = format!("steps: the best set of at most {} for ", step["at_most"]);
        let without = |proof: &mut serde_json::Value| {
            proof["steps"].as_array_mut().unwrap().remove(number);
        };
        verified(&folder, without, &[&expected, " is missing"]);
    }
    let last = |proof: &mut serde_json::Value| proof["steps"].as_array_mut().unwrap().pop().unwrap();
    // What stands beside the scores is part of it.
    let one = |place: &'static str, value: serde_json::Value| {
        move |proof: &mut serde_json::Value| *proof.pointer_mut(place).expect(place) = value.clone()
    };
    verified(&folder, one("/steps/1/gain", 0.5.into()), &["steps[1].gain: is 0.5, but the scores give"]);
    let worth = one("/steps/1/best/sensors/0/score_without", 0.1.into());
    verified(
        &folder,
        worth,
        &["steps[1].best.sensors: score_without of camera:", "is 0.1, but counted again"],
    );
    let place = one("/steps/1/best/sensors/0/place", "in the middle".into());
    verified(&folder, place, &["steps[1].best.sensors: cost and place of camera differ"]);
    let cost = one("/steps/1/best/sensors/0/cost", 1.into());
    verified(&folder, cost, &["steps[1].best.sensors: cost and place of camera differ"]);
    verified(&folder, one("/nearly_as_good/0/score", 0.9.into()), &["nearly_as_good[0].score: f1 is 0.9"]);
    let itself = |proof: &mut serde_json::Value| {
        let steps = proof["steps"].as_array().unwrap();
        let best = steps.iter().find(|step| step["at_most"] == 3).unwrap()["best"].clone();
        proof["nearly_as_good"][0] = best;
    };
    verified(
        &folder,
        itself,
        &["nearly_as_good[0]: is not nearly as good as the best set, from mounts that no"],
    );
    let twice = |proof: &mut serde_json::Value| {
        let ties = proof["nearly_as_good"].as_array_mut().unwrap();
        ties.push(ties[0].clone());
    };
    verified(&folder, twice, &["is not nearly as good as the best set, from mounts that no other has"]);
    verified(
        &folder,
        one("/steps/1/best/cost", serde_json::Value::Null),
        &["steps[1].best: costs 500, not the stated amount"],
    );
    verified(&folder, one("/semantics_version", 99.into()), &["semantics_version: differs from the study"]);
    verified(&folder, one("/certified", "everything".into()), &["certified: differs from the study"]);
    verified(&folder, one("/candidates", 1.into()), &["candidates: differs from the study"]);
    for file in ["front.csv", "sets.csv"] {
        let path = out.join(file);
        let written = fs::read_to_string(&path).unwrap();
        fs::write(&path, written.replacen("0.", "0.9", 1)).unwrap();
        verified(&folder, |_| {}, &[&format!("{file}: row 1: column "), ", but made again it is"]);
        fs::write(&path, written).unwrap();
    }
    verified(&folder, |_| {}, &[]);
    // A bound that was searched for is searched for again.
    let bound = |above: f64| {
        move |proof: &mut serde_json::Value| {
            proof["steps"][1]["proven"] = false.into();
            proof["steps"][1]["no_set_is_above"] = above.into();
        }
    };
    let score = steps[1]["best"]["score"].as_f64().unwrap();
    let above = ((score * 1e6).floor() + 2000.0) / 1e6;
    let not_written = ["front.csv: row ", ": column bound is "];
    verified(&folder, bound(above), &not_written);
    verified(&folder, bound(above + 1e-9), &["steps[1].no_set_is_above: a set is above that, or may be"]);
    verified(&folder, bound(score - 0.001), &["steps[1].no_set_is_above: a set is above that, or may be"]);
    let poorer_bound = |proof: &mut serde_json::Value| {
        bound(above)(proof);
        proof["steps"][1]["best"] = proof["steps"][0]["best"].clone();
        proof["steps"][1]["no_set_is_above"] = ((score * 1e6).floor() / 1e6).into();
    };
    verified(&folder, poorer_bound, &["steps[1].no_set_is_above: a set is above that, or may be"]);
    // The best pair in the place of the best three is allowed, and not the best.
    let poorer = |proof: &mut serde_json::Value| {
        let pair = proof["steps"][1].clone();
        proof["steps"][2]["best"] = pair["best"].clone();
        proof["steps"][2]["no_set_is_above"] = pair["no_set_is_above"].clone();
    };
    verified(&folder, poorer, &["steps[2].best: this set is better: "]);
    verified(
        &folder,
        |proof| proof["steps"][1]["best"]["score"] = 0.9.into(),
        &["steps[1].best.score: f1 is 0.9, but counted again it is"],
    );
    verified(
        &folder,
        |proof| proof["steps"][1]["best"]["exactly"][0] = "1".into(),
        &["steps[1].best.exactly: counted again it is"],
    );
    verified(
        &folder,
        |proof| proof["steps"][1]["best"]["cost"] = 1.into(),
        &["steps[1].best: costs 500, not the stated amount"],
    );
    verified(
        &folder,
        |proof| proof["steps"][1]["no_set_is_above"] = 1.into(),
        &["no_set_is_above: differs from the score of the best set"],
    );
    let name =
        |proof: &mut serde_json::Value| proof["steps"][0]["best"]["poses"][0] = "camera:nowhere/1".into();
    verified(&folder, name, &["steps[0].best: \"camera:nowhere/1\" is not a pose of the study"]);
    let twice = |proof: &mut serde_json::Value| {
        let first = proof["steps"][1]["best"]["poses"][0].clone();
        proof["steps"][1]["best"]["poses"][1] = first;
    };
    verified(&folder, twice, &["steps[1].best: has camera:", " twice"]);
    verified(
        &folder,
        |proof| proof["steps"][1]["at_most"] = 1.into(),
        &["has 2 sensors, but at most 1 are allowed"],
    );
    let cut = |proof: &mut serde_json::Value| {
        last(proof);
        *proof = serde_json::json!({ "steps": proof["steps"] });
    };
    verified(&folder, cut, &["choose.json: is not as it was written: missing field"]);
}

/// Every table is made again: what is false, cut or gone is named by file, row and column.
#[test]
fn the_tables_of_a_proof_hold_until_they_are_altered() {
    let folder = folder();
    let outcome = choose(&folder, "out", &["--backend", "cpu"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    verified(&folder, |_| {}, &[]);
    let refused = |file: &str, change: &dyn Fn(&str) -> Option<String>, expected: &str| {
        let path = folder.path("out").join(file);
        let before = fs::read_to_string(&path).unwrap();
        match change(&before) {
            Some(after) => {
                assert_ne!(after, before, "{file}: {expected}");
                fs::write(&path, after).unwrap();
            }
            None => fs::remove_file(&path).unwrap(),
        }
        let outcome = perirobot(&["choose", "--verify", text(&folder.path("out")), "--backend", "cpu"]);
        fs::write(&path, before).unwrap();
        assert_eq!(outcome.code, Some(2), "{file}: {}{}", outcome.stdout, outcome.stderr);
        for part in [file, expected] {
            assert!(outcome.stderr.contains(part), "{file}: no {part:?} in {}", outcome.stderr);
        }
    };
    // The last field of the second row below the header.
    let field = |text: &str| {
        let mut csv = csv::ReaderBuilder::new().has_headers(false).from_reader(text.as_bytes());
        let mut all = csv::Writer::from_writer(Vec::new());
        for (number, record) in csv.records().enumerate() {
            let mut fields: Vec<String> = record.unwrap().iter().map(String::from).collect();
            if number == 2 {
                *fields.last_mut().unwrap() = "0.123".into();
            }
            all.write_record(&fields).unwrap();
        }
        Some(String::from_utf8(all.into_inner().unwrap()).unwrap())
    };
    let cut = |text: &str| Some(text.lines().take(2).map(|line| format!("{line}\n")).collect());
    for (file, column) in [
        ("results.csv", "hit_human_twice"),
        ("scores.csv", "seen_twice_n"),
        ("poses.csv", "place"),
        ("sets.csv", "f1_without"),
        ("front.csv", "poses"),
    ] {
        refused(file, &field, &format!("row 2: column {column} is \"0.123\", but made again it is"));
        refused(file, &cut, "row 2: is missing: the file ends before it");
        refused(file, &|_| None, "is missing");
    }
}

/// Means are proven, too, in another way.
#[test]
fn the_proof_of_a_mean_holds_until_it_is_altered() {
    let folder = folder();
    folder.edit(STUDY, "at_most = 3", "over = \"mean\"\nat_most = 3");
    let outcome = choose(&folder, "out", &["--backend", "cpu"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(rows(&folder.path("out/front.csv")).iter().all(|row| row["proven"] == "true"));
    verified(&folder, |_| {}, &[]);
    let poorer = |proof: &mut serde_json::Value| {
        let tie = proof["nearly_as_good"][0].clone();
        let steps = proof["steps"].as_array_mut().unwrap();
        let step = steps.iter_mut().find(|step| step["at_most"] == 3).unwrap();
        step["no_set_is_above"] = tie["score"].clone();
        step["best"] = tie;
    };
    verified(&folder, poorer, &[".best: this set is better: "]);
    let fraction = |proof: &mut serde_json::Value| {
        proof["steps"][0]["best"]["exactly"] = serde_json::json!(["1", "1"]);
    };
    verified(&folder, fraction, &["steps[0].best.exactly: a mean of scores is not a fraction"]);
}

/// With requirements, too, no step of cost may be missing; and a search that was stopped says that some may be.
#[test]
fn the_proof_of_what_is_required_holds_until_it_is_altered() {
    let folder = folder();
    folder.edit(
        STUDY,
        "apart_m = 0.1",
        "apart_m = 0.1\nrequire = [{ score = \"human_seen\", at_least = 0.001 }]",
    );
    let outcome = choose(&folder, "out", &["--backend", "cpu"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    verified(&folder, |_| {}, &[]);
    let text = fs::read_to_string(folder.path("out/choose.json")).unwrap();
    let steps =
        serde_json::from_str::<serde_json::Value>(&text).unwrap()["steps"].as_array().unwrap().clone();
    for (number, step) in steps.iter().enumerate() {
        let without = |proof: &mut serde_json::Value| {
            proof["steps"].as_array_mut().unwrap().remove(number);
        };
        verified(&folder, without, &[&format!("steps: the best set of at most {} for ", step["at_most"])]);
    }
    let path = folder.path("out/choose.json");
    fs::write(&path, text.replace("\"steps\"", "\"stopped\": true,\n  \"steps\"")).unwrap();
    let outcome = perirobot(&["choose", "--verify", program::text(&folder.path("out"))]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(outcome.stdout.contains("; the search was stopped, so sizes and"), "{}", outcome.stdout);
}

/// Without noise no two sensors disagree, so that sums decide as unions do; with it there is no proof.
#[test]
fn log_odds_have_an_answer_too() {
    let folder = folder();
    folder.edit(STUDY, "seed = 7", "seed = 7\nfusion = \"octomap\"");
    let outcome = choose(&folder, "out", &["--backend", "cpu"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let told = fs::read_to_string(folder.path("out/choose.json")).unwrap();
    assert!(told.contains("in these scenes, under \\\"octomap\\\""), "{told}");
    assert!(rows(&folder.path("out/front.csv")).iter().all(|row| row["proven"] == "true"));
    verified(&folder, |_| {}, &[]);
    let other = |proof: &mut serde_json::Value| proof["asked"]["fusion"] = "occupied_wins".into();
    verified(&folder, other, &["asked: the study's question has changed"]);
    folder.edit(STUDY, "range_m = [0.1, 5.0]", "range_m = [0.1, 5.0]\nnoise = { std_m = 0.1 }");
    let outcome = choose(&folder, "noisy", &["--backend", "cpu"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    for row in rows(&folder.path("noisy/front.csv")) {
        assert_eq!(row["proven"], "false", "{row:?}");
        assert!(row["bound"].parse::<f64>().unwrap() >= row["f1"].parse::<f64>().unwrap(), "{row:?}");
    }
    let outcome = perirobot(&["choose", "--verify", text(&folder.path("noisy"))]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let path = folder.path("noisy/choose.json");
    let mut proof: serde_json::Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    proof["steps"][0]["proven"] = true.into();
    proof["steps"][0]["no_set_is_above"] = proof["steps"][0]["best"]["score"].clone();
    fs::write(&path, proof.to_string()).unwrap();
    let outcome = perirobot(&["choose", "--verify", text(&folder.path("noisy"))]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    assert!(
        outcome.stderr.contains("steps[0].proven: sensors with errors may outvote"),
        "{}",
        outcome.stderr
    );
}

#[test]
fn a_search_that_is_stopped_says_so() {
    let folder = folder();
    let outcome = choose(&folder, "out", &["--max-time", "0s", "--backend", "cpu"]);
    assert_eq!(outcome.code, Some(75), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("stopped by --max-time"), "{}", outcome.stderr);
    assert!(!folder.names().contains(&"out".to_string()), "nothing was found, and nothing is written");
}

/// The study with these edits is refused by `choose` alone. These files stay: where nothing was cast none, else what
/// was.
#[track_caller]
fn not_chosen(edits: &[Edit], stays: &[&str], expected: &str) {
    let folder = folder();
    for (file, from, to) in edits {
        folder.edit(file, from, to);
    }
    let outcome = choose(&folder, "out", &[]);
    assert_eq!(outcome.code, Some(2), "{edits:?}: {}", outcome.stderr);
    assert!(outcome.stderr.contains(expected), "no {expected:?} in {}", outcome.stderr);
    assert!(!outcome.stderr.contains("panicked"), "{}", outcome.stderr);
    assert_eq!(outcome.stdout, "");
    let mut left = folder.names();
    left.retain(|name| ![STUDY, "cell.toml"].contains(&name.as_str()));
    match stays {
        [] => assert_eq!(left, [""; 0]),
        _ => assert_eq!(program::names(&folder.path("out")), stays),
    }
}

#[test]
fn what_cannot_be_chosen_is_refused() {
    not_chosen(&[(STUDY, CHOOSE, "")], &[], "study.toml: no [choose]: add [choose]");
    let region =
        "[[region]]\nname = \"empty\"\nbox = { min_m = [-0.1, 0.1, 0.8], max_m = [0.0, 0.2, 0.9] }\n[choose]";
    let empty = (STUDY, "region = \"robot\"\nat_most", "region = \"empty\"\nat_most");
    let with = |objective| (STUDY, "objective = \"f1\"", objective);
    let added = (STUDY, "[choose]", region);
    not_chosen(
        &[added, empty],
        &[],
        "choose.objective = \"f1\": region \"empty\" has no occupied voxel in any scene",
    );
    let seen = with("objective = \"human_seen\"");
    not_chosen(&[added, empty, seen], &[], "= \"human_seen\": region \"empty\" has no voxel of a person");
    let people = with("objective = \"people_detected\"");
    not_chosen(&[added, empty, people], &[], "has no part of a person with min_hits voxels");
    let require = |entry: &str| format!("apart_m = 0.1\nrequire = [{entry}]");
    let apart = "apart_m = 0.1";
    let high = require("{ score = \"f1\", at_least = 0.99 }");
    not_chosen(
        &[(STUDY, apart, &high)],
        &["evidence.journal"],
        "choose.require[0]: no allowed set reaches f1 0.99 (pooled): it is 0.",
    );
    let seen = require(
        "{ score = \"f1\", at_least = 0 }, { score = \"human_seen\", over = \"worst\", at_least = 1 }",
    );
    not_chosen(
        &[(STUDY, apart, &seen)],
        &["evidence.journal"],
        "choose.require[1]: no allowed set reaches human_seen 1 (worst): it is 0.",
    );
}

#[test]
fn wrong_keys_are_refused_even_by_a_sweep() {
    for (from, to, expected) in [
        ("objective = \"f1\"", "objective = \"f2\"", &["unknown variant `f2`", "`parts_detected`"][..]),
        (
            "region = \"robot\"\nat",
            "region = \"rob\"\nat",
            &["choose.region = \"rob\": must be a region of the study"],
        ),
        ("at_most = 3", "at_most = 0", &["choose.at_most = 0: must be from 1 to 16"]),
        ("at_most = 3", "at_most = 17", &["choose.at_most = 17: must be from 1 to 16"]),
        ("at_most = 3", "", &["no at_most: say how many sensors a set may have"]),
        ("at_most = 3", "at_most = 3\nover = \"all\"", &["unknown variant `all`"]),
        ("at_most = 1", "at_most = 0", &["sensor \"lidar\".at_most = 0: must be 1 or more"]),
        ("cost = 250.0", "cost = -1", &["sensor \"camera\".cost = -1: must be a number from 0"]),
        ("seed = 7", "seed = 7\ncurrency = \"\"", &["currency = \"\": must be a word of 1 to 8 characters"]),
        ("seed = 7", "seed = 7\ncurrency = \"US dollar\"", &["currency = \"US dollar\"", "without spaces"]),
        ("seed = 7", "seed = 7\ncurrency = \"thousands\"", &["currency = \"thousands\": must be a word"]),
        ("seed = 7", "seed = 7\ncurrency = 1", &["currency = 1", "wanted text in quotes"]),
        ("cost = 250.0", "cost = 0.0001", &["at most three digits after the point"]),
        (
            "cost = 250.0",
            "",
            &["choose.budget = 1000: sensor \"camera\" has no cost: give it one, as in cost = 450.0"],
        ),
        (
            "budget = 1000.0",
            "budget = 249.9",
            &["choose.budget = 249.9: is below the 250 that the cheapest sensor costs"],
        ),
        ("budget = 1000.0", "budget = nan", &["choose.budget = NaN: must be a number from 0"]),
        (
            "apart_m = 0.1",
            "apart_m = -0.1",
            &["choose.apart_m = -0.1: must be a distance in metres, 0 or more"],
        ),
        (
            "apart_m = 0.1",
            "disturb = { apart_deg = 30 }",
            &["choose: disturb is about sensors that emit light, and no sensor does: add emits = \"tof\""],
        ),
        (
            "apart_m = 0.1",
            "disturb = { apart_deg = 181 }",
            &["choose.disturb.apart_deg = 181: must be an angle from 0 to 180 degrees"],
        ),
        (
            "apart_m = 0.1",
            "disturb = { overlap = 1.5 }",
            &["choose.disturb.overlap = 1.5: must be a share from 0 to 1"],
        ),
        (
            "apart_m = 0.1",
            "disturb = { apart_deg = 0 }",
            &["choose.disturb.apart_deg = 0: forbids nothing: ask for more than 0, or add overlap = 0.2"],
        ),
        ("apart_m = 0.1", "disturb = { apart = 30 }", &["unknown field `apart`", "`apart_deg` or `overlap`"]),
        (
            "cost = 250.0",
            "cost = 250.0\nemits = \"ToF\"",
            &["sensor \"camera\".emits = \"ToF\": must name a kind of light by small letters"],
        ),
        ("cost = 250.0", "cost = 250.0\nemits = \"\"", &["\"none\" if it emits none"]),
        (
            "apart_m = 0.1",
            "always = [\"camera\"]",
            &["always = \"camera\": must be a sensor and one of its poses"],
        ),
        (
            "apart_m = 0.1",
            "always = [\"cam:wall/0/0\"]",
            &["must begin with a sensor of the study: [\"camera\", \"lidar\"]"],
        ),
        (
            "apart_m = 0.1",
            "always = [\"camera:wall/9/9\"]",
            &["has no such pose; its poses are like \"wall/0/0\""],
        ),
        ("apart_m = 0.1", "always = [\"lidar:posts/upright\", \"lidar:posts/upright\"]", &["stands twice"]),
        (
            "apart_m = 0.1",
            "always = [\"lidar:posts/upright\", \"lidar:posts/corner\"]",
            &["one more of \"lidar\" than its at_most = 1 allows"],
        ),
        (
            "at_most = 3",
            "at_most = 1\nalways = [\"camera:wall/0/0\", \"camera:wall/1/0\"]",
            &["choose.always = 2 sensors: is more than at_most = 1 allows"],
        ),
        (
            "budget = 1000.0",
            "budget = 400.0\nalways = [\"camera:wall/0/0\", \"camera:wall/1/0\"]",
            &["is below the 500 that the sensors in always cost"],
        ),
        (
            "apart_m = 0.1",
            "require = [{ score = \"f1\", at_least = 1.1 }]",
            &["choose.require[0].at_least = 1.1: must be a number from 0 to 1"],
        ),
        (
            "apart_m = 0.1",
            "representation = { cam = \"points\" }",
            &["choose.representation: \"cam\" must be a sensor of the study"],
        ),
        (
            "apart_m = 0.1",
            "representation = { camera = \"box\" }",
            &[
                "choose.representation.camera = \"box\": must be a representation of that sensor: [\"points\"]",
            ],
        ),
    ] {
        refused(&folder(), &[(STUDY, from, to)], expected);
    }
    refused(
        &folder(),
        &[(STUDY, "budget = 1000.0\n", ""), (STUDY, "cost = 499.5\n", "")],
        &["study.toml: choose: sensor \"camera\" has a cost and \"lidar\" has none: give each sensor one"],
    );
}
