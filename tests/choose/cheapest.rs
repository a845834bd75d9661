//! The cheapest set that passes as it is asked for: what is printed and written, what is proven, and what is refused.

use std::fs;

use serde_json::Value;

use crate::common;
use crate::common::program::{Edit, Folder, choose, perirobot, refused, rows, text};
use crate::common::purchase::{STUDY, folder};

pub(super) fn json(folder: &Folder, out: &str, file: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.path(out).join(file)).unwrap()).unwrap()
}

#[test]
fn a_study_with_requirements_and_costs_needs_no_more() {
    let folder = folder();
    folder.edit("study.toml", "", "[choose]\nfront = \"speed\"\nthen = \"f1\"\nregion = \"robot\"\n");
    let first = choose(&folder, "oracle", &["--backend", "oracle"]);
    assert_eq!(first.code, Some(0), "{}{}", first.stdout, first.stderr);
    let files =
        ["cheapest.json", "cheapest.csv", "results.csv", "requirements.csv", "judge.json", "speeds.csv"];
    let read = |out: &str| files.map(|file| fs::read_to_string(folder.path(out).join(file)).unwrap());
    let expected = read("oracle");
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
    // The sentence, then what proves it.
    let sentence = first.stdout.lines().next().unwrap();
    assert!(sentence.contains(" requirements; the robot may run at "), "{sentence}");
    assert!(sentence.contains("4 m/s is impossible with these places: entry \"door\" begins "), "{sentence}");
    assert!(first.stdout.contains("proven: no cheaper set of the 6 listed poses passes"), "{}", first.stdout);
    // Slower robots need no dearer sets.
    let points = rows(&folder.path("oracle").join("cheapest.csv"));
    assert_eq!(
        points.iter().map(|row| row["aim"].as_str()).collect::<Vec<_>>(),
        ["all", "speed", "speed", "speed"]
    );
    assert!(points.iter().all(|row| row["proven"] == "1"), "{points:?}");
    let cost = |row: usize| points[row]["cost"].parse::<f64>().ok();
    assert!(cost(1).unwrap() <= cost(2).unwrap() && cost(3).is_none(), "{points:?}");
    assert!(points[3]["reasons"].contains("comes nearer"), "{points:?}");
    // judge of the folder says the same again, byte for byte.
    let out = folder.path("oracle");
    let again = perirobot(&["judge", text(&out), "--backend", "cpu", "--progress", "none"]);
    assert_eq!(again.code, Some(0), "{}{}", again.stdout, again.stderr);
    let sets = serde_json::from_str::<Value>(&expected[4]).unwrap();
    // What is met with the least to spare is told.
    let margin = |verdict: &Value| {
        let limit = verdict["at_least"].as_f64().or(verdict["at_most"].as_f64())?;
        Some(((verdict["value"].as_f64()? - limit) / limit).abs())
    };
    let met = sets["sets"][0]["requirements"].as_array().unwrap().iter().filter(|one| margin(one).is_some());
    let least = met.min_by(|a, b| margin(a).unwrap().total_cmp(&margin(b).unwrap())).unwrap();
    let told = format!("\nsmallest margin: {} (", least["requirement"]);
    assert!(first.stdout.contains(&told), "{told} in {}", first.stdout);
    // Every set of the answer, as choose judged them.
    assert_eq!(json(&folder, "oracle", "judge.json"), sets);
    assert!(again.stdout.contains("recommended: cheapest ("), "{}", again.stdout);
    let best =
        perirobot(&["judge", text(&out), "--set", "cheapest", "--backend", "cpu", "--progress", "none"]);
    assert_eq!(best.code, Some(0), "{}{}", best.stdout, best.stderr);
    let judged = json(&folder, "oracle", "judge.json");
    assert_eq!(judged["sets"][0], sets["sets"][0]);
    assert_eq!(judged["sets"][0]["allowed_speed"]["m_s"], 0.5);
}

#[test]
fn what_stands_in_the_way_is_named() {
    let folder = folder();
    folder.edit("study.toml", "at_most = 0.9", "at_most = 0.01\nfor = \"SF2: what is around the robot\"");
    let outcome = choose(&folder, "out", &[]);
    assert_eq!(outcome.code, Some(4), "{}{}", outcome.stdout, outcome.stderr);
    let text = &outcome.stdout;
    assert!(text.starts_with("no allowed set passes all; "), "{text}");
    assert!(
        text.contains("the robot's surroundings are known: all listed poses together have unknown 0."),
        "{text}"
    );
    assert!(text.contains("\n      for SF2: what is around the robot\n"), "{text}");
    let report = json(&folder, "out", "cheapest.json");
    assert_eq!(report["asked"]["require"][1]["for"], "SF2: what is around the robot");
    let points = report["points"].as_array().unwrap();
    assert!(points[0]["set"].is_null() && points[0]["proven"] == true, "{report}");
    assert_eq!(points[1]["aim"]["nearest"][0], "the robot's surroundings are known");
    assert!(points[1]["set"]["cost"].as_f64().unwrap() > 0.0);
    // An entry beside the robot is too near for any sensor.
    folder.edit("study.toml", "at_most = 0.01", "at_most = 1");
    folder.edit("study.toml", "min_m = [1.2, -1.2, 0]", "min_m = [-0.6, -1.2, 0]");
    let outcome = choose(&folder, "near", &[]);
    assert_eq!(outcome.code, Some(4), "{}", outcome.stderr);
    assert!(outcome.stdout.contains("m are needed: no sensor helps; move the entry "), "{}", outcome.stdout);
}

#[test]
fn each_speed_is_impossible_by_its_own_distance() {
    let folder = folder();
    folder.edit("study.toml", "[0.25, 0.5, 4.0]", "[0.25, 4.0, 6.0]");
    folder.edit("study.toml", "", "[choose]\nfront = \"speed\"\n");
    let outcome = choose(&folder, "out", &[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let report = json(&folder, "out", "cheapest.json");
    let points = report["points"].as_array().unwrap();
    let speeds = rows(&folder.path("out").join("speeds.csv"));
    for speed in ["4", "6"] {
        let needed = speeds.iter().find(|row| row["speed_m_s"] == speed).unwrap()["needed_m"].clone();
        let needed = (needed.parse::<f64>().unwrap() * 100.0).ceil() / 100.0;
        let aim = speed.parse::<f64>().unwrap();
        let point = points.iter().find(|point| point["aim"]["speed"].as_f64() == Some(aim)).unwrap();
        let why = point["reasons"][0]["why"].as_str().unwrap();
        assert!(why.contains(&format!("and {needed} m are needed")), "{why}");
    }
    // What no set passes at any speed is no matter of a speed.
    folder.edit("study.toml", "at_most = 0.9", "at_most = 0.01");
    let outcome = choose(&folder, "none", &[]);
    assert_eq!(outcome.code, Some(4), "{}", outcome.stderr);
    let sentence = outcome.stdout.lines().next().unwrap();
    assert!(sentence.starts_with("no allowed set") && !sentence.contains("is impossible"), "{sentence}");
}

#[test]
fn without_a_requirement_sets_cost_no_more() {
    let folder = folder();
    folder.edit("study.toml", "", "[choose]\nfront = \"requirements\"\n");
    let outcome = choose(&folder, "out", &[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let points = rows(&folder.path("out").join("cheapest.csv"));
    let cost = |row: usize| points[row]["cost"].parse::<f64>().unwrap();
    assert_eq!(points[1]["value"], "nobody comes near");
    assert!(cost(1) < cost(0) && cost(2) <= cost(0), "{points:?}");
    // Meeting one of both costs as much as the cheaper of them.
    assert_eq!([&points[3]["aim"], &points[3]["value"]], ["number", "1"]);
    assert_eq!(cost(3), cost(1).min(cost(2)), "{points:?}");
    assert_eq!(points[3]["missed"], "nobody comes near");
    let row = outcome.stdout.lines().find(|line| line.trim_start().starts_with("1 of 2 ")).unwrap();
    assert!(row.contains(" proven ") && row.contains("nobody comes near"), "{row}");
}

#[test]
fn costs_are_told_in_the_currency_of_the_study() {
    let folder = folder();
    folder.edit("study.toml", "[grid]", "currency = \"EUR\"\n[grid]");
    folder.edit("study.toml", "cost = 450", "cost = 1450");
    folder.edit("study.toml", "cost = 250.5", "cost = 1250.5");
    let outcome = choose(&folder, "out", &[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let report = json(&folder, "out", "cheapest.json");
    let cost = report["points"][0]["set"]["cost"].as_f64().unwrap();
    assert!(cost > 1000.0 && cost < 1e6, "{cost}");
    let grouped = format!(" for {},{:05.1} EUR meet", (cost / 1e3).floor(), cost % 1e3);
    assert!(outcome.stdout.contains(&grouped.replace(".0 ", " ")), "{grouped} {}", outcome.stdout);
    assert_eq!(report["asked"]["currency"], "EUR");
    let row = &rows(&folder.path("out").join("cheapest.csv"))[0];
    assert_eq!(row["cost"].parse::<f64>().unwrap(), cost);
}

#[test]
fn a_search_that_is_stopped_tells_its_bound() {
    let folder = folder();
    let outcome = choose(&folder, "out", &["--max-time", "0.001s"]);
    assert_eq!(outcome.code, Some(75), "{}{}", outcome.stdout, outcome.stderr);
}

#[test]
fn an_answer_of_the_other_kind_leaves_nothing_behind() {
    let folder = folder();
    assert_eq!(choose(&folder, "out", &[]).code, Some(0));
    assert!(folder.path("out").join("cheapest.json").exists());
    let best = "[choose]\nobjective = \"f1\"\nregion = \"robot\"\nat_most = 1\n";
    folder.edit("study.toml", "", best);
    let outcome = choose(&folder, "out", &[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(!folder.path("out").join("cheapest.json").exists());
    folder.edit("study.toml", best, "");
    assert_eq!(choose(&folder, "out", &[]).code, Some(0));
    assert!(!folder.path("out").join("choose.json").exists());
}

#[test]
fn what_cannot_be_asked_is_refused() {
    let cost = "[choose]\nobjective = \"cost\"\n";
    let f1 = "[choose]\nobjective = \"f1\"\nregion = \"robot\"\nat_most = 2\n";
    let cases: [(&str, &str, &str, &[&str]); 19] = [
        (cost, "cost = 450\n", "", &["\"camera\" has none"]),
        (cost, "[choose]", "[choose]\nrefine = true", &["refine", "the listed poses"]),
        (cost, "[choose]", "[choose]\nregion = \"robot\"", &["region", "then = \"f1\""]),
        (cost, "[choose]", "[choose]\nthen = \"f1\"", &["region", "f1 is counted"]),
        (cost, "[choose]", "[choose]\nthen = \"cost\"\nregion = \"robot\"", &["then"]),
        (cost, "[choose]", "[choose]\nrequire = [{ score = \"f1\", at_least = 0.5 }]", &["[[require]]"]),
        (cost, "objective = \"cost\"", "objective = \"unknown\"", &["then = \"unknown\""]),
        (f1, "[choose]", "[choose]\nthen = \"f1\"", &["then belongs to"]),
        (f1, "\"f1\"", "\"seen_twice\"", &["objective", "then = \"seen_twice\""]),
        (f1, "\"f1\"", "\"approach_margin_m\"", &["objective", "then = \"approach_margin_m\""]),
        (
            cost,
            "[choose]",
            "[choose]\nthen = \"nearest_unnoticed_m\"\nregion = \"robot\"",
            &["region", "leave it out"],
        ),
        (
            cost,
            "[choose]",
            "[choose]\nthen = \"nearest_unnoticed_m\"\nover = \"mean\"",
            &["over", "must be \"worst\" of nearest_unnoticed_m"],
        ),
        (cost, "score = \"unknown\"", "score = \"unknwon\"", &["score", "did you mean \"unknown\"?"]),
        (cost, "region = \"robot\"", "region = \"robto\"", &["region", "did you mean \"robot\"?"]),
        (
            f1,
            "region = \"robot\"\nat_most = 2",
            "region = \"robto\"\nat_most = 2",
            &["did you mean \"robot\"?"],
        ),
        (
            cost,
            "[choose]",
            "[choose]\nthen = \"nearest_unnoticed\"",
            &["did you mean `nearest_unnoticed_m`?"],
        ),
        (cost, "at_most = 0.9", "at_least = 9000", &["at_least = 9000", "a number from 0 to 1"]),
        (
            "currency = \"EUR\"\n",
            "[approach]",
            "[choose]\nbudget = 1\n[approach]",
            &["budget", "is below the 250.5 EUR that the cheapest sensor costs"],
        ),
        (
            "[choose]\nat_most = 3\n",
            "cost = 450\n",
            "",
            &["no objective", "objective = \"cost\"", "\"camera\" has no cost"],
        ),
    ];
    for (choose, from, to, words) in cases {
        let folder = folder();
        match choose.starts_with('[') {
            true => folder.edit("study.toml", "", choose),
            false => folder.edit("study.toml", "[grid]", &format!("{choose}[grid]")),
        }
        let edits: [Edit; 1] = [("study.toml", from, to)];
        refused(&folder, &edits, words);
    }
    // Nothing that sets must pass, and no speeds.
    let part = |from: &str, to: &str| -> String {
        let (begin, end) = (STUDY.find(from).unwrap(), STUDY.find(to).unwrap());
        STUDY[begin..end].into()
    };
    let (required, stopping) = (part("[[require]]", "[stopping]"), part("[stopping]", "[approach]"));
    for (left_out, choose, words) in [
        (required, cost, "has none: add one"),
        (stopping.clone(), "[choose]\nfront = \"speed\"\n", "needs the speeds of the robot"),
        (stopping, "[choose]\nthen = \"approach_margin_m\"\n", "how far people must be"),
    ] {
        let folder = folder();
        folder.write("study.toml", STUDY.replace(&left_out, "") + choose);
        refused(&folder, &[], &[words]);
    }
}

/// What sets have in common is done once, and changes nothing: with dead sensors, mounts that are off and other people.
#[test]
fn each_set_is_judged_as_if_it_were_alone() {
    let folder = folder();
    folder.edit("study.toml", "\"one_sensor_dead\"]", "\"one_sensor_dead\", \"mounting_error\"]");
    let more = "under = [\"as_planned\", \"mounting_error\", \"postures\"]\n[stopping]";
    folder.edit("study.toml", "[stopping]", more);
    let tables = "[mounting_error]\ndraws = 3\nposition_m = 0.1\nangle_deg = 5.0\n\
                  [postures]\npeople = [\"kneeling\", \"standing\"]\nspots = [[0.6, -0.9, 90]]\n\
                  [choose]\nfront = \"requirements\"\n";
    folder.edit("study.toml", "", tables);
    let found = choose(&folder, "out", &[]);
    assert!(matches!(found.code, Some(0 | 4)), "{}", found.stderr);
    let out = folder.path("out");
    let judge = |more: &[&str]| {
        let judged = ["judge", text(&out), "--backend", "cpu", "--progress", "none"];
        let judged = perirobot(&[&judged[..], more].concat());
        assert!(matches!(judged.code, Some(0 | 4)), "{}", judged.stderr);
        json(&folder, "out", "judge.json")["sets"].as_array().unwrap().clone()
    };
    let all = judge(&[]);
    assert!(all.len() > 1, "{all:?}");
    for set in &all {
        assert_eq!(judge(&["--set", set["combination"].as_str().unwrap()]), std::slice::from_ref(set));
    }
}

/// Among sets of the same cost a distance or what two sensors see decides, as judge has it.
#[test]
fn what_decides_among_sets_of_the_same_cost_is_that_of_judge() {
    let folder = folder();
    folder.edit("study.toml", "cost = 250.5", "cost = 450");
    folder.edit("study.toml", "at_least = 1.2", "at_least = 0.7");
    let ask = |asked: &str| {
        folder.edit("study.toml", "", &format!("[choose]\n{asked}\n"));
        let found = choose(&folder, "out", &[]);
        let (study, out) = (folder.path("study.toml"), folder.path("out"));
        let verified = perirobot(&["choose", text(&study), "--verify", text(&out), "--progress", "none"]);
        folder.edit("study.toml", &format!("[choose]\n{asked}\n"), "");
        assert_eq!(found.code, Some(0), "{asked}: {}", found.stderr);
        assert!(verified.stdout.contains("all claims hold"), "{asked}: {}", verified.stderr);
        let point = json(&folder, "out", "cheapest.json")["points"][0].clone();
        (found.stdout, point["set"]["score"].as_f64(), point["ties"].as_u64())
    };
    let (words, score, ties) = ask("at_most = 4");
    let ties = ties.unwrap();
    assert!(score.is_none() && ties > 0, "{words}");
    assert!(words.contains("; ") && words.contains(" the same and pass"), "{words}");
    let (words, nearest, ties) = ask("then = \"nearest_unnoticed_m\"");
    assert!(
        ties.is_none() && words.contains("; no set of this cost has a better nearest_unnoticed_m"),
        "{words}"
    );
    let told = rows(&folder.path("out").join("requirements.csv"));
    let value = told.iter().find(|row| row["score"] == "nearest_unnoticed_m").unwrap()["value"].clone();
    assert_eq!(value.parse::<f64>().ok(), nearest, "{told:?}");
    let (_, margin, _) = ask("then = \"approach_margin_m\"");
    assert!(margin < nearest, "{margin:?}");
    let (_, twice, _) = ask("then = \"seen_twice\"\nregion = \"robot\"");
    let swept = rows(&folder.path("out").join("results.csv"));
    let swept = swept.iter().find(|row| row["region"] == "robot").unwrap()["seen_twice"].clone();
    assert_eq!(swept.parse::<f64>().ok(), twice);
}

/// The two narrow cameras pass together, and see much of the same.
#[test]
fn sensors_that_disturb_each_other_are_not_bought_together_and_named() {
    let folder = folder();
    folder.edit("study.toml", "cost = 250.5", "cost = 250.5\nemits = \"tof\"");
    let ask = |asked: &str| {
        folder.edit("study.toml", "", &format!("[choose]\n{asked}\n"));
        let found = choose(&folder, "out", &[]);
        let (study, out) = (folder.path("study.toml"), folder.path("out"));
        let verified = ["choose", text(&study), "--verify", text(&out), "--progress", "none"];
        let verified = perirobot(&verified);
        folder.edit("study.toml", &format!("[choose]\n{asked}\n"), "");
        assert_eq!(found.code, Some(0), "{asked}: {}", found.stderr);
        assert!(verified.stdout.contains("all claims hold"), "{asked}: {}", verified.stderr);
        found.stdout
    };
    let free = ask("at_most = 4");
    assert!(
        free.starts_with("2 sensors for 501 meet 2 of 2 requirements") && !free.contains("disturb"),
        "{free}"
    );
    // Neither is in the other's field of view, but they see the same.
    let loose = ask("disturb = {}");
    assert!(loose.starts_with("2 sensors for 501 meet 2 of 2 requirements"), "{loose}");
    assert!(loose.contains("disturb does not bind: no set that it forbids is better"), "{loose}");
    let bound = ask("disturb = { overlap = 0.3 }");
    assert!(bound.starts_with("2 sensors for 700.5 meet"), "{bound}");
    let named = "disturb binds: if sensors might disturb each other, narrow:corner/ne;narrow:corner/se for 501 would \
                 pass; in it narrow:corner/ne and narrow:corner/se do";
    assert!(bound.contains(named), "{bound}");
    let points = &json(&folder, "out", "cheapest.json")["points"];
    assert_eq!(points[1]["aim"], "disturbed");
    assert_eq!(points[1]["disturbed"], serde_json::json!([["narrow:corner/ne", "narrow:corner/se"]]));
    assert_eq!(rows(&folder.path("out").join("cheapest.csv"))[1]["aim"], "disturbed");
    // By a score the same is told.
    let best = ask("objective = \"f1\"\nregion = \"robot\"\nat_most = 2\ndisturb = {}");
    assert!(best.contains("disturb does not bind: no set that it forbids is better"), "{best}");
    // By a score the pair is named, too, and verified.
    folder.edit("study.toml", "cost = 450", "cost = 450\nemits = \"tof\"");
    let f1 = "objective = \"f1\"\nregion = \"robot\"\nat_most = 2\ndisturb = { overlap = 0.1 }";
    let best = ask(f1);
    let named = "disturb binds: if sensors might disturb each other, camera:wall/west;camera:wall/south would have F1 0.6882, \
                 cost 900; in it camera:wall/west and camera:wall/south do";
    assert!(best.contains(named), "{best}");
    folder.edit("study.toml", "", &format!("[choose]\n{f1}\n"));
    let (path, study, out) =
        (folder.path("out").join("choose.json"), folder.path("study.toml"), folder.path("out"));
    let right = fs::read_to_string(&path).unwrap();
    for (place, value) in [
        ("/if_disturbed", Value::Null),
        ("/if_disturbed/score", 0.9.into()),
        ("/if_disturbed/cost", 450.0.into()),
        ("/if_disturbed/disturbed", serde_json::json!([])),
        ("/if_disturbed/poses", serde_json::json!(["camera:wall/west", "camera:wall/east"])),
    ] {
        let mut proof: Value = serde_json::from_str(&right).unwrap();
        *proof.pointer_mut(place).unwrap() = value;
        fs::write(&path, proof.to_string()).unwrap();
        let refused = perirobot(&["choose", text(&study), "--verify", text(&out), "--progress", "none"]);
        assert_eq!(refused.code, Some(2), "{place}: {}", refused.stdout);
        assert!(refused.stderr.contains("choose.json: if_disturbed"), "{place}: {}", refused.stderr);
    }
    folder.edit("study.toml", &format!("[choose]\n{f1}\n"), "");
    folder.edit("study.toml", "cost = 450\nemits = \"tof\"", "cost = 450");
    // What hangs there already may.
    let there = ask("disturb = { overlap = 0.3 }\nalways = [\"narrow:corner/ne\", \"narrow:corner/se\"]");
    assert!(there.starts_with("2 sensors for 501 meet 2 of 2 requirements"), "{there}");
}
