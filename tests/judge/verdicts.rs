//! `perirobot judge`: verdicts on the small study, held against the tables of its sweep.

use std::collections::BTreeMap;
use std::fs;

use crate::common::program::{Folder, Outcome, perirobot, refused, text};

/// A row of a table, by its columns.
type Row = BTreeMap<String, String>;

fn table(folder: &Folder, name: &str) -> Vec<Row> {
    let mut csv = csv::Reader::from_path(folder.path("out").join(name)).unwrap();
    csv.deserialize().map(|row| row.unwrap()).collect()
}

fn judge(folder: &Folder, more: &[&str]) -> Outcome {
    let out = folder.path("out");
    perirobot(&[&["judge", text(&out)], more].concat())
}

/// A requirement of a study.
fn require(name: &str, score: &str, region: &str, more: &str) -> String {
    format!("\n[[require]]\nname = \"{name}\"\nscore = \"{score}\"\nregion = \"{region}\"\n{more}\n")
}

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

#[test]
fn values_are_those_of_the_tables() {
    let folder = Folder::noisy();
    for score in SCORES {
        for over in ["worst", "mean", "pooled"] {
            // What is better when less has its worst value on the other side of the limit.
            let limit =
                if ["unknown", "false_alarm"].contains(&score) { "at_most = 1" } else { "at_least = 0" };
            let more = format!("over = \"{over}\"\n{limit}");
            folder.edit("study.toml", "", &require(&format!("{score} {over}"), score, "human", &more));
        }
    }
    assert_eq!(folder.sweep(&[]).code, Some(0));
    let scores = table(&folder, "scores.csv");
    for pose in ["posts/upright", "wall/1/1"] {
        let outcome = judge(&folder, &["--pose", pose]);
        assert!(matches!(outcome.code, Some(0 | 4)), "{}", outcome.stderr);
        let (rows, mut compared) = (table(&folder, "requirements.csv"), 0);
        assert_eq!(rows.len(), 27);
        for row in &rows {
            let same = |of: &&Row| {
                let keys = ["combination", "poses", "representation", "region"];
                of["scene"] == "*" && keys.iter().all(|key| of[*key] == row[*key])
            };
            let expected = &scores.iter().find(same).unwrap()[&format!("{}_{}", row["score"], row["over"])];
            assert_eq!(&row["value"], expected, "{pose}: {row:?}");
            assert_eq!(row["verdict"], if expected.is_empty() { "FAIL" } else { "PASS" }, "{row:?}");
            compared += usize::from(!expected.is_empty());
        }
        assert!(compared > 15, "{pose}: {compared} with a value");
    }
}

#[test]
fn the_choice_that_meets_most_requirements_is_judged() {
    let folder = Folder::new();
    assert_eq!(folder.sweep(&[]).code, Some(0));
    let asked = [("f1", "robot", 0.15), ("kappa", "box", 0.1), ("human_seen", "human", 0.05)];
    for (score, region, least) in asked {
        // Requirements change no count: the folder stays the study's.
        folder.edit("study.toml", "", &require(score, score, region, &format!("at_least = {least}")));
    }
    let mut met: BTreeMap<[String; 3], usize> = BTreeMap::new();
    for row in table(&folder, "results.csv") {
        let key = ["combination", "poses", "representation"].map(|key| row[key].clone());
        let is_met = |(score, region, least): &(&str, &str, f64)| {
            row["region"] == *region && row[*score].parse().is_ok_and(|value: f64| value >= *least)
        };
        *met.entry(key).or_default() += asked.iter().filter(|one| is_met(one)).count();
    }
    let most = *met.values().max().unwrap();
    assert!(most > 0 && met.values().any(|count| *count < most), "{met:?}");
    let outcome = judge(&folder, &["--best", "3"]);
    assert_eq!(outcome.code, Some(if most == 3 { 0 } else { 4 }), "{}", outcome.stderr);
    let rows = table(&folder, "requirements.csv");
    assert_eq!(rows.len(), 9);
    let mut before = usize::MAX;
    for set in rows.chunks(3) {
        let key = ["combination", "poses", "representation"].map(|key| set[0][key].clone());
        let passed = set.iter().filter(|row| row["verdict"] == "PASS").count();
        assert_eq!(passed, met[&key], "{key:?}");
        assert!(passed <= before, "the best come first");
        before = passed;
    }
    assert_eq!(rows.iter().filter(|row| row["poses"] == rows[0]["poses"]).count(), 3);
    assert_eq!(met[&["combination", "poses", "representation"].map(|key| rows[0][key].clone())], most);
}

#[test]
fn exit_codes_and_words_say_what_was_decided() {
    let folder = Folder::new();
    assert_eq!(folder.sweep(&[]).code, Some(0));
    let none = judge(&folder, &[]);
    assert_eq!(none.code, Some(2), "{}", none.stderr);
    let wanted = ["study.toml: ", "require", "[[require]] name = ", "region = \"robot\", at_least = 0.9"];
    assert!(wanted.iter().all(|part| none.stderr.contains(part)), "{}", none.stderr);

    folder.edit("study.toml", "", &require("anything", "f1", "robot", "at_least = 0"));
    let passed = judge(&folder, &["--pose", "wall/0/0"]);
    assert_eq!(passed.code, Some(0), "{}", passed.stderr);
    assert!(
        passed.stdout.contains("PASS  anything (as planned): F1 in region robot is 0."),
        "{}",
        passed.stdout
    );

    folder.edit("study.toml", "", &require("all of it", "f1", "robot", "at_least = 1"));
    let missed = judge(&folder, &["--pose", "wall/0/0"]);
    assert_eq!(missed.code, Some(4), "{}", missed.stderr);
    let words = [
        "PASS  anything",
        "FAIL  all of it",
        "no choice of the listed poses can meet it: their upper bound is 0.",
    ];
    assert!(words.iter().all(|part| missed.stdout.contains(part)), "{}", missed.stdout);

    // Both have the same worst moment, and its picture is drawn once.
    assert_eq!(drawn(&folder, &missed.stdout), 1);

    let moved = folder.path("moved.toml");
    fs::rename(folder.path("study.toml"), &moved).unwrap();
    let missed = judge(&folder, &["--pose", "wall/0/0", "--study", text(&moved)]);
    assert_eq!(missed.code, Some(4), "{}", missed.stderr);
    // Both have the same worst moment, and its picture is drawn once.
    assert_eq!(drawn(&folder, &missed.stdout), 1);
    let picture = folder.path("worst.png");
    let of_study = perirobot(&["render", text(&moved), "--study", text(&moved), "--out", text(&picture)]);
    assert!(
        of_study.code == Some(2) && of_study.stderr.contains("needs a folder of results"),
        "{}",
        of_study.stderr
    );
}

/// Runs the commands of pictures that were printed; how many there are.
#[track_caller]
fn drawn(folder: &Folder, printed: &str) -> usize {
    let commands: Vec<&str> =
        printed.lines().filter_map(|line| line.trim().strip_prefix("perirobot ")).collect();
    for command in &commands {
        let picture = folder.path("worst.png");
        let words: Vec<&str> = command.split_whitespace().map(|word| word.trim_matches('\'')).collect();
        let words: Vec<&str> = words
            .into_iter()
            .map(|word| if word.ends_with(".png") { text(&picture) } else { word })
            .collect();
        let drawn = perirobot(&words);
        assert_eq!(drawn.code, Some(0), "{command}: {}", drawn.stderr);
        assert!(fs::metadata(&picture).unwrap().len() > 1000);
        fs::remove_file(picture).unwrap();
    }
    commands.len()
}

const UNDER: &str = "under = [\"as_planned\", \"one_sensor_dead\", \"two_sensors_dead\", \"mounting_error\"]\nover = \"mean\"\n";

#[test]
fn the_safety_function_of_a_requirement_is_repeated_and_decides_nothing() {
    let folder = Folder::new();
    folder.edit("study.toml", "", &require("much", "f1", "box", "at_least = 0.001"));
    assert_eq!(folder.sweep(&[]).code, Some(0));
    let junit = folder.path("verdicts.xml");
    let words = || judge(&folder, &["--junit", text(&junit), "--backend", "cpu"]);
    let plain = words();
    assert!(!plain.stdout.contains("      for "), "{}", plain.stdout);
    let verdict = |row: &Row| ["verdict", "value", "for"].map(|key| row[key].clone());
    let before = verdict(&table(&folder, "requirements.csv")[0]);
    assert_eq!(before[2], "");
    let said = "SF3: stop <before> a person reaches the gripper";
    folder.edit("study.toml", "name = \"much\"\n", &format!("name = \"much\"\nfor = \"{said}\"\n"));
    let told = words();
    assert_eq!(told.code, plain.code, "{}", told.stderr);
    assert_eq!(told.stdout.replace(&format!("      for {said}\n"), ""), plain.stdout);
    assert_ne!(told.stdout, plain.stdout);
    let after = verdict(&table(&folder, "requirements.csv")[0]);
    assert_eq!(after, [&before[0], &before[1], said]);
    let json = fs::read_to_string(folder.path("out/judge.json")).unwrap();
    assert!(json.contains(&format!("\"for\": \"{said}\"")), "{json}");
    let junit = fs::read_to_string(&junit).unwrap();
    let document = roxmltree::Document::parse(&junit).unwrap();
    let property = document.descendants().find(|node| node.has_tag_name("property")).unwrap();
    assert_eq!(["name", "value"].map(|key| property.attribute(key)), [Some("for"), Some(said)]);
    let report = perirobot(&["report", text(&folder.path("out")), "--progress", "none"]);
    assert_eq!(report.code, Some(0), "{}", report.stderr);
    let page = fs::read_to_string(folder.path("out/report.html")).unwrap();
    let shown = format!("<em>for {}</em>", said.replace('<', "&lt;").replace('>', "&gt;"));
    assert!(page.contains(&shown), "no {shown} in the page");
}

#[test]
fn conditions_are_told_drawn_and_written_for_build_servers() {
    let folder = Folder::noisy();
    let more = "\n[[combination]]\nname = \"both\"\nsensors = [\"camera\", \"lidar\"]\n\
                [mounting_error]\ndraws = 4\nposition_m = 0.02\nangle_deg = 1.0\n";
    folder.edit("study.toml", "", more);
    folder.edit(
        "study.toml",
        "",
        &require(
            "most <&> \"of\" it".replace('"', "'").as_str(),
            "f1",
            "box",
            &format!("{UNDER}at_least = 0.001"),
        ),
    );
    let swept = folder.sweep(&["--package", "spare=/spare"]);
    assert_eq!(swept.code, Some(0), "{}", swept.stderr);
    let said = [
        "Requirements, as planned, of the choice that meets most of them\n",
        "PASS  most <&> 'of' it (as planned): F1 in region box is 0.",
        "next: perirobot judge ",
        " --package 'spare=/spare' --pose ",
    ];
    assert!(said.iter().all(|part| swept.stdout.contains(part)), "{}", swept.stdout);
    let open = "\nnot decided here: most <&> 'of' it (one sensor dead, two sensors dead, mounting error)\n";
    assert!(swept.stdout.contains(open), "{}", swept.stdout);
    assert_eq!(swept.stdout.matches("one sensor dead").count(), 1, "{}", swept.stdout);

    let junit = folder.path("verdicts.xml");
    let outcome = judge(&folder, &["--junit", text(&junit), "--backend", "cpu"]);
    assert_eq!(outcome.code, Some(4), "{}", outcome.stderr);
    // Of two sensors that are dead nothing is left to draw.
    assert_eq!(drawn(&folder, &outcome.stdout), 3, "{}", outcome.stdout);
    let rows = table(&folder, "requirements.csv");
    let cases: Vec<[&str; 4]> = rows
        .iter()
        .map(|row| ["condition", "verdict", "cases", "failed"].map(|key| row[key].as_str()))
        .collect();
    assert_eq!(cases[0], ["as_planned", "PASS", "1", "0"]);
    assert_eq!(cases[1][0..1], ["one_sensor_dead"]);
    assert_eq!(cases[1][2], "2");
    assert_eq!(cases[2], ["two_sensors_dead", "FAIL", "1", "1"]);
    assert_eq!([cases[3][0], cases[3][2]], ["mounting_error", "4"]);
    assert!(rows[3]["case"].starts_with("draw "), "{:?}", rows[3]);

    let text_of_file = fs::read_to_string(&junit).unwrap();
    let document = roxmltree::Document::parse(&text_of_file).unwrap();
    let tests: Vec<_> = document.descendants().filter(|node| node.has_tag_name("testcase")).collect();
    let failed =
        tests.iter().filter(|test| test.children().any(|child| child.has_tag_name("failure"))).count();
    assert_eq!(tests.len(), 4);
    assert_eq!(failed, rows.iter().filter(|row| row["verdict"] == "FAIL").count());
    assert_eq!(tests[0].attribute("name"), Some("most <&> 'of' it (as_planned)"));
    let suite = document.root_element();
    let counts = ["tests", "failures"].map(|key| suite.attribute(key).unwrap().parse::<usize>().unwrap());
    assert_eq!(counts, [4, failed]);

    // What is 5 %, mean and so on of the cases is held by the library's tests; here that all are there.
    let conditions = table(&folder, "conditions.csv");
    for (condition, values) in
        [("as_planned", 4), ("one_sensor_dead", 8), ("two_sensors_dead", 4), ("mounting_error", 16)]
    {
        let of = |row: &&Row| row["condition"] == condition && row["region"] == "box" && row["score"] == "f1";
        let row = conditions.iter().find(of).unwrap();
        assert_eq!(row["values"], values.to_string(), "{row:?}");
        let [best, mean, worst] = ["best", "mean", "worst"].map(|key| row[key].parse::<f64>().unwrap());
        assert!(best >= mean && mean >= worst, "{row:?}");
    }
    // The same from the plain reference, but for the words of the run.
    let before = ["requirements.csv", "conditions.csv", "draws.csv", "judge.json"]
        .map(|name| fs::read(folder.path("out").join(name)).unwrap());
    assert_eq!(judge(&folder, &["--backend", "oracle"]).code, Some(4));
    let after = ["requirements.csv", "conditions.csv", "draws.csv", "judge.json"]
        .map(|name| fs::read(folder.path("out").join(name)).unwrap());
    assert!(before == after);
    // Draws are of one choice.
    assert_eq!(judge(&folder, &["--best", "2", "--backend", "cpu"]).code, Some(4));
    assert!(!folder.path("out/draws.csv").exists());
}

#[test]
fn what_cannot_be_looked_at_is_told() {
    let folder = Folder::new();
    assert_eq!(folder.sweep(&[]).code, Some(0));
    let out = folder.path("out");
    let why = |more: &[&str]| perirobot(&[&["why", text(&out), "--pose", "wall/0/0"], more].concat());
    for (arguments, expected) in [
        (["--dead", "lidar:posts/upright"], "--dead lidar:posts/upright: "),
        (["--dead", "camera:wall/0/0"], "--dead camera:wall/0/0: no sensor is left"),
        (["--draw", "0"], "[mounting_error] draws = 20"),
    ] {
        let outcome = why(&arguments);
        assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
        assert!(outcome.stderr.contains(expected), "{expected}: {}", outcome.stderr);
    }
    folder.edit("study.toml", "", "\n[mounting_error]\ndraws = 4\nposition_m = 0.02\n");
    let outcome = why(&["--draw", "4"]);
    assert!(
        outcome.code == Some(2) && outcome.stderr.contains("--draw 4: must be from 0 to 3"),
        "{}",
        outcome.stderr
    );
    let [planned, drawn] = [why(&[]), why(&["--draw", "3"])];
    assert_eq!([planned.code, drawn.code], [Some(0); 2], "{}", drawn.stderr);
    assert_ne!(planned.stdout, drawn.stdout);
}

#[test]
fn a_chosen_set_is_judged() {
    let folder = Folder::new();
    folder.edit("study.toml", "", "\n[choose]\nobjective = \"f1\"\nregion = \"robot\"\nat_most = 2\n");
    let one =
        require("seen", "f1", "robot", "at_least = 0.15\nunder = [\"as_planned\", \"one_sensor_dead\"]");
    folder.edit("study.toml", "", &one);
    let (study, out) = (folder.path("study.toml"), folder.path("out"));
    let chosen = perirobot(&["choose", text(&study), "--out", text(&out), "--backend", "cpu"]);
    assert_eq!(chosen.code, Some(0), "{}", chosen.stderr);
    let (_, verdicts) = chosen.stdout.split_once("\nRequirements, as planned, of the best set\n").unwrap();
    let rows = table(&folder, "results.csv");
    let of_robot = rows.iter().filter(|row| row["region"] == "robot");
    let best =
        of_robot.max_by(|a, b| a["f1"].parse::<f64>().unwrap().total_cmp(&b["f1"].parse().unwrap())).unwrap();
    assert!(best["poses"].contains(';') && verdicts.starts_with(&best["poses"]), "{best:?}: {verdicts}");
    assert!(verdicts.contains("PASS  seen (as planned)"), "{verdicts}");
    assert!(verdicts.contains("\nnot decided here: seen (one sensor dead)\n"), "{verdicts}");

    let (_, more) = chosen.stdout.split_once("\nnext: perirobot ").unwrap();
    assert!(more.contains(&format!("--pose '{}'", best["poses"])), "{more}");
    // Every other part stands between quotation marks.
    let parts = more.lines().next().unwrap().split('\'').enumerate();
    let words = parts.flat_map(|(number, part)| match number % 2 {
        0 => part.split_whitespace().collect(),
        _ => vec![part],
    });
    assert!(matches!(perirobot(&words.collect::<Vec<_>>()).code, Some(0 | 4)), "{more}");
    assert_eq!(table(&folder, "requirements.csv")[0]["poses"], best["poses"]);

    let judged = judge(&folder, &["--backend", "cpu"]);
    assert!(matches!(judged.code, Some(0 | 4)), "{}", judged.stderr);
    // All sets, each with as many verdicts; the best one is among them.
    let all = table(&folder, "requirements.csv");
    let sets = table(&folder, "results.csv").into_iter().filter(|row| row["region"] == "robot").count();
    assert_eq!((sets, all.len()), (2, 4));
    let verdicts: Vec<_> = all.iter().filter(|row| row["poses"] == best["poses"]).collect();
    assert_eq!([&verdicts[0]["poses"], &verdicts[0]["value"]], [&best["poses"], &best["f1"]]);
    assert_eq!([verdicts[1]["condition"].as_str(), &verdicts[1]["cases"]], ["one_sensor_dead", "2"]);
    assert!(verdicts[1]["value"].parse::<f64>().unwrap() < best["f1"].parse().unwrap());
}

/// A pad as large as the floor has no place but its own.
const PAD: &str = r#"
[[sensor]]
name = "pad"
kind = "pad"
size_m = [2.5, 1.9]
[[sensor.poses]]
name = "floor"
x_m = -1.2
y_m = -0.9
z_m = 0
[[combination]]
name = "both"
sensors = ["camera", "pad"]
poses = { camera = ["wall/0/0"] }
[[combination]]
name = "alone"
sensors = ["pad"]
[mounting_error]
draws = 4
position_m = 0.02
"#;

#[test]
fn draws_that_are_not_possible_are_told_and_nothing_is_left_of_a_judgement_that_failed() {
    let folder = Folder::new();
    let required = require("seen", "f1", "robot", "at_least = 0\nunder = [\"mounting_error\"]");
    folder.edit("study.toml", "", &[PAD, &required].concat());
    assert_eq!(folder.sweep(&[]).code, Some(0));
    let junit = folder.path("verdicts.xml");
    let both = || judge(&folder, &["--combination", "both", "--backend", "cpu", "--junit", text(&junit)]);
    let files = || {
        let written = ["requirements.csv", "conditions.csv", "draws.csv", "judge.json"];
        written
            .map(|name| folder.path("out").join(name))
            .iter()
            .chain([&junit])
            .filter(|file| file.exists())
            .count()
    };
    let told = "; in 4 of 4 draws, no place but the planned one was found for pad:floor/0/0; the same in all 4 cases";
    let outcome = both();
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(outcome.stdout.contains(told), "{}", outcome.stdout);
    assert!(fs::read_to_string(&junit).unwrap().contains(told));
    assert_eq!(table(&folder, "requirements.csv")[0]["draws_as_planned"], "4");
    assert_eq!(files(), 5);

    // A name that is wrong is found before anything is removed.
    assert_eq!(judge(&folder, &["--pose", "nowhere", "--junit", text(&junit)]).code, Some(2));
    assert_eq!(files(), 5);
    let alone = judge(&folder, &["--combination", "alone", "--backend", "cpu", "--junit", text(&junit)]);
    let expected = "study.toml: mounting_error: no draw of pad:floor/0/0 is possible";
    assert!(alone.code == Some(2) && alone.stderr.contains(expected), "{}", alone.stderr);
    assert_eq!(files(), 0);

    assert_eq!(both().code, Some(0));
    folder.edit("study.toml", &required, "");
    assert_eq!(judge(&folder, &["--junit", text(&junit)]).code, Some(2));
    assert_eq!(files(), 0);
}

#[test]
fn moments_without_a_value_are_told() {
    let folder = Folder::noisy();
    // In the second scene nobody is in the box.
    folder.edit("second.toml", "position_m = [0.3, -0.4, 0.65]", "position_m = [0.95, -0.4, 0.65]");
    for over in ["worst", "mean"] {
        let more = format!("over = \"{over}\"\nat_least = 0");
        folder.edit("study.toml", "", &require(over, "human_seen", "box", &more));
    }
    folder.edit("study.toml", "", &require("all", "unknown", "box", "at_most = 1"));
    assert_eq!(folder.sweep(&[]).code, Some(0));
    let junit = folder.path("verdicts.xml");
    let outcome = judge(&folder, &["--pose", "wall/0/0", "--junit", text(&junit)]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let told = "; only 2 of 4 moments have a value";
    assert_eq!(outcome.stdout.matches(told).count(), 2, "{}", outcome.stdout);
    assert_eq!(fs::read_to_string(&junit).unwrap().matches(told).count(), 2);
    let counted = |row: &Row| ["values", "of"].map(|key| row[key].clone());
    let rows: Vec<[String; 2]> = table(&folder, "requirements.csv").iter().map(counted).collect();
    assert_eq!(rows, [["2", "4"], ["2", "4"], ["4", "4"]]);
    let conditions = table(&folder, "conditions.csv");
    let of =
        |score: &str| conditions.iter().find(|row| row["region"] == "box" && row["score"] == score).unwrap();
    assert_eq!([counted(of("human_seen")), counted(of("unknown"))], [["2", "4"], ["4", "4"]]);
}

/// The error of a study with these requirements.
#[track_caller]
fn wrong(more: &str, expected: &[&str]) {
    refused(&Folder::new(), &[("study.toml", "", more)], expected);
}

#[test]
fn bad_requirements_are_refused_by_name() {
    let one = |more: &str| require("seen", "f1", "robot", more);
    wrong(&one("at_least = 0.5\nat_most = 0.7"), &["require \"seen\"", "both at_least and at_most"]);
    wrong(&one(""), &["require \"seen\": no limit: give one of at_least, at_most"]);
    wrong(&one("at_least = 1.5"), &["require \"seen\".at_least = 1.5: must be a number from 0 to 1"]);
    for words in ["", "  ", "two\\nlines", "x".repeat(201).as_str()] {
        let more = format!("at_least = 0.5\nfor = \"{words}\"");
        wrong(&one(&more), &["require \"seen\".for = \"", "must be a line of 1 to 200 characters"]);
    }
    wrong(&one("at_most = nan"), &["require \"seen\".at_most = NaN: must be a number from 0 to 1"]);
    wrong(&one("at_least = 0.12345678901"), &["at_least = 0.12345678901: must have at most nine digits"]);
    wrong(&one("at_least = 0.5\nunder = []"), &["require \"seen\"", "under"]);
    wrong(&one("at_least = 0.5\nunder = [\"flood\"]"), &["under = [\"flood\"]", "one_sensor_dead"]);
    let draws =
        &["require \"seen\".under = \"mounting_error\": needs to know", "[mounting_error] draws = 20"];
    wrong(&one("at_least = 0.5\nunder = [\"mounting_error\"]"), draws);
    wrong(&require("seen", "f2", "robot", "at_least = 0.5"), &["score = \"f2\"", "kappa"]);
    let region = "region = \"cellar\": must be a region of the study: [\"robot\", \"box\", \"human\"]";
    wrong(&require("seen", "f1", "cellar", "at_least = 0.5"), &["require \"seen\"", region]);
    wrong(&[one("at_least = 0.5"), one("at_least = 0.6")].concat(), &["two requirements are named \"seen\""]);
    wrong(
        "\n[mounting_error]\ndraws = 0\nposition_m = 0.01\n",
        &["mounting_error.draws = 0: must be from 1"],
    );
    wrong("\n[mounting_error]\ndraws = 5\n", &["mounting_error: give position_m, angle_deg or both"]);
    wrong("\n[mounting_error]\ndraws = 5\nangle_deg = 99\n", &["mounting_error.angle_deg = 99: must be"]);
}
