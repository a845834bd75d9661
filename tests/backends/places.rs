//! Where an object should stand, and which moments weigh more: places of `[[candidate]]` are scenes as if the scene files had
//! been written so, and weighted means are those that the rows of results.csv give.

use std::collections::HashMap;
use std::path::Path;

use crate::common::program::{self, Folder, SCENE, perirobot, text};

const CANDIDATE: &str = r#"
[[candidate]]
object = "operator"
x_m = [0.1, -0.4]
y_m = -0.45
turn_deg = [0, 40]
"#;

type Row = HashMap<String, String>;

fn rows(table: &Path) -> Vec<Row> {
    csv::Reader::from_path(table).unwrap().deserialize().map(|row| row.unwrap()).collect()
}

fn run(arguments: &[&str]) -> program::Outcome {
    let outcome = perirobot(arguments);
    assert_eq!(outcome.code, Some(0), "{arguments:?}: {}", outcome.stderr);
    outcome
}

/// A sweep of the small study with the cell in two versions: the second has no crate.
fn swept(more: &str) -> (Folder, program::Outcome) {
    let folder = Folder::new();
    let second = SCENE.replacen("[0.7, 0.4, 0.25]", "[-0.9, 0.4, 0.25]", 1);
    folder.write("second.toml", &second);
    folder.edit(
        "study.toml",
        "file = \"cell.toml\"",
        &format!("file = \"cell.toml\"\n[[scene]]\nfile = \"second.toml\"{more}"),
    );
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    (folder, outcome)
}

#[test]
fn a_place_counts_as_if_the_scene_had_been_written_so() {
    let (folder, outcome) = swept(CANDIDATE);
    let all = rows(&folder.path("out/results.csv"));
    let scenes: Vec<&str> = {
        let mut names: Vec<&str> = all.iter().map(|row| row["scene"].as_str()).collect();
        names.dedup();
        names
    };
    assert_eq!(scenes.len(), 8);
    assert_eq!((scenes[0], scenes[7]), ("cell@operator/0.1/-0.45/0", "second@operator/-0.4/-0.45/40"));
    // By hand: the operator at the second x in both files.
    let by_hand = Folder::new();
    let moved = |scene: &str| {
        scene.replacen(
            "position_m = [0.1, -0.45, 0.65]",
            "position_m = [-0.4, -0.45, 0.65]\nrpy_deg = [0, 0, 40]",
            1,
        )
    };
    for name in ["cell.toml", "second.toml"] {
        let scene = std::fs::read_to_string(folder.path(name)).unwrap();
        assert_ne!(moved(&scene), scene);
        by_hand.write(name, moved(&scene));
    }
    by_hand.edit(
        "study.toml",
        "file = \"cell.toml\"",
        "file = \"cell.toml\"\n[[scene]]\nfile = \"second.toml\"",
    );
    assert_eq!(by_hand.sweep(&[]).code, Some(0));
    let numbers = |row: &Row| {
        let mut row = row.clone();
        row.remove("scene");
        row.into_iter().collect::<std::collections::BTreeMap<_, _>>()
    };
    for (place, name) in
        [("cell@operator/-0.4/-0.45/40", "cell"), ("second@operator/-0.4/-0.45/40", "second")]
    {
        let placed: Vec<_> = all.iter().filter(|row| row["scene"] == place).map(numbers).collect();
        let expected = rows(&by_hand.path("out/results.csv"));
        let expected: Vec<_> = expected.iter().filter(|row| row["scene"] == name).map(numbers).collect();
        assert!(expected.len() > 20);
        assert_eq!(placed, expected, "{place}");
    }
    // Over both cells: a row for each place, with the mean of its two scenes; the table names the best of the four.
    let scores = rows(&folder.path("out/scores.csv"));
    let place = "*@operator/-0.4/-0.45/40";
    let of = |scene: &str, poses: &str| {
        let row = scores
            .iter()
            .find(|row| row["scene"] == scene && row["poses"] == poses && row["region"] == "human");
        row.unwrap()["f1_mean"].parse::<f64>().unwrap()
    };
    let poses = "lidar:posts/upright";
    let [one, other] =
        ["cell@operator/-0.4/-0.45/40", "second@operator/-0.4/-0.45/40"].map(|scene| of(scene, poses));
    assert!((of(place, poses) - (one + other) / 2.0).abs() < 1e-15 && one != other);
    let of_lidar = scores.iter().filter(|row| {
        row["scene"].starts_with("*@") && row["combination"] == "lidar" && row["region"] == "human"
    });
    let best = of_lidar
        .max_by(|a, b| a["f1_mean"].parse::<f64>().unwrap().total_cmp(&b["f1_mean"].parse().unwrap()))
        .unwrap();
    let summary = run(&[
        "summary",
        text(&folder.path("out")),
        "--region",
        "human",
        "--score",
        "f1",
        "--combination",
        "lidar",
    ])
    .stdout;
    let table = summary.split("PLACES of").nth(1).unwrap_or_else(|| panic!("no places in {summary}"));
    let first = table.lines().find(|line| line.contains("lidar · points")).unwrap();
    assert!(
        first.contains(&best["scene"][2..]) && first.contains(&best["poses"]["lidar:".len()..]),
        "{first} {best:?}"
    );
    assert!(outcome.stdout.contains("PLACES of [[candidate]]"), "{}", outcome.stdout);
    // What else reads a sweep takes such scenes.
    let out = folder.path("out");
    run(&["report", text(&out)]);
    run(&["export", text(&out), "--pose", poses, "--scene", "second@operator/-0.4/-0.45/40"]);
    let again = folder.sweep(&[]);
    assert_eq!(again.code, Some(0), "{}", again.stderr);
}

#[test]
fn weighted_means_are_those_of_the_rows() {
    let moves = r#"
[object.snapshots]
position_m = [[0.1, -0.45, 0.65], [-0.4, -0.45, 0.65], [0.5, 0.2, 0.65]]
dwell_s = [60, 0.5, 9.5]
"#;
    let folder = Folder::new();
    folder.edit(
        "cell.toml",
        "position_m = [0.1, -0.45, 0.65]",
        &format!("position_m = [0.1, -0.45, 0.65]{moves}"),
    );
    let swept = folder.sweep(&[]);
    assert_eq!(swept.code, Some(0), "{}", swept.stderr);
    let counted = rows(&folder.path("out/results.csv"));
    let scores = rows(&folder.path("out/scores.csv"));
    let same = |a: &Row, b: &Row| {
        ["combination", "poses", "representation", "region"].iter().all(|key| a[*key] == b[*key])
    };
    let (mut checked, mut differ) = (0, 0);
    for row in scores.iter().filter(|row| row["scene"] == "cell") {
        for score in ["f1", "kappa", "human_seen"] {
            let moments: Vec<(f64, f64)> = counted
                .iter()
                .filter(|counted| same(row, counted) && !counted[score].is_empty())
                .map(|counted| {
                    (
                        counted[score].parse().unwrap(),
                        [60.0, 0.5, 9.5][counted["snapshot"].parse::<usize>().unwrap()],
                    )
                })
                .collect();
            let (sum, all) = moments
                .iter()
                .fold((0.0, 0.0), |(sum, all), (value, seconds)| (sum + value * seconds, all + seconds));
            let told = &row[&format!("{score}_weighted")];
            match moments.is_empty() {
                true => assert!(told.is_empty(), "{told}"),
                false => {
                    let told: f64 = told.parse().unwrap();
                    assert!((told - sum / all).abs() < 1e-9, "{score} {told} {}", sum / all);
                    differ += u32::from(
                        (told - row[&format!("{score}_mean")].parse::<f64>().unwrap()).abs() > 1e-3,
                    );
                    checked += 1;
                }
            }
        }
    }
    assert!(checked > 50 && differ > 20, "{checked} {differ}");
    let summary = run(&["summary", text(&folder.path("out"))]).stdout;
    assert!(summary.contains("weighted") && summary.contains("dwell_s"), "{summary}");
    // Where the crate should be is told by weighted means.
    folder.edit(
        "study.toml",
        "",
        "[[candidate]]\nobject = \"crate\"\nx_m = [0.7, 0.1, -0.6]\ny_m = [0.4, -0.3]\n\
             [[require]]\nname = \"seen\"\nscore = \"human_seen\"\nregion = \"human\"\nover = \"mean\"\nat_least = 0.1\n\
             [choose]\nobjective = \"human_seen\"\nregion = \"human\"\nover = \"mean\"\nat_most = 1\n",
    );
    let again = folder.sweep(&["--restart"]);
    assert_eq!(again.code, Some(0), "{}", again.stderr);
    let scores = rows(&folder.path("out/scores.csv"));
    let mut differ = 0;
    for combination in ["camera", "lidar"] {
        let here = |row: &&Row| {
            let is_place = row["scene"].contains("@crate/") && !row["scene"].starts_with('*');
            is_place
                && row["combination"] == combination
                && row["representation"] == "points"
                && row["region"] == "human"
        };
        let by = |column: &str| {
            let value = |row: &Row| row[column].parse::<f64>().unwrap();
            scores.iter().filter(here).reduce(|a, b| if value(b) > value(a) { b } else { a }).unwrap()
        };
        let (best, plain) = (by("f1_weighted"), by("f1_mean"));
        differ += u32::from(best["scene"] != plain["scene"] || best["poses"] != plain["poses"]);
        let of = ["--region", "human", "--score", "f1", "--combination", combination];
        let summary = run(&[&["summary", text(&folder.path("out"))], &of[..]].concat()).stdout;
        let table = summary.split("PLACES of").nth(1).unwrap_or_else(|| panic!("no places in {summary}"));
        let first = table.lines().find(|line| line.contains(&format!("{combination} · points"))).unwrap();
        let number = |column: &str| format!(" {:.3} ", best[column].parse::<f64>().unwrap());
        for expected in [
            format!(" {} ", best["scene"].split('@').nth(1).unwrap()),
            number("f1_weighted"),
            number("f1_mean"),
            format!(" {} ", &best["poses"][combination.len() + 1..]),
        ] {
            assert!(first.contains(&expected), "no {expected:?} in {first}");
        }
        assert!(table.contains("Weighted: the mean in which"), "{table}");
    }
    assert!(differ > 0, "weights tell nothing apart");
    // Where means are plain all the same it is said.
    let said = "Means count each snapshot once, however long it lasts (dwell_s)";
    let (study, out, chosen) = (folder.path("study.toml"), folder.path("out"), folder.path("chosen"));
    let judged = perirobot(&["judge", text(&out)]);
    assert!(judged.stdout.contains(said), "{} {}", judged.stdout, judged.stderr);
    let choose = run(&["choose", text(&study), "--out", text(&chosen), "--backend", "cpu"]);
    assert!(choose.stdout.contains(said), "{}", choose.stdout);
    run(&["report", text(&out)]);
    assert!(std::fs::read_to_string(out.join("report.html")).unwrap().contains(said));
    // Whoever passes through the same moments may not say it twice, and somebody must move.
    let refused = |from: &str, to: &str, expected: &str| {
        let scene = std::fs::read_to_string(folder.path("cell.toml")).unwrap();
        assert!(scene.contains(from));
        folder.write("cell.toml", scene.replacen(from, to, 1));
        let outcome = perirobot(&["check", text(&folder.path("study.toml"))]);
        folder.write("cell.toml", &scene);
        assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
        assert!(
            outcome.stderr.contains(expected) && outcome.stderr.contains("cell.toml"),
            "no {expected:?} in {}",
            outcome.stderr
        );
    };
    let arm = "position_m = [0.2, 0.3, 0.45]";
    let twice = format!(
        "{arm}\nsnapshots = {{ rpy_deg = [[0, 0, 0], [0, 10, 0], [0, 20, 0]], dwell_s = [1, 1, 1] }}"
    );
    let twice = twice.as_str();
    let without = "quaternion = { w = 1, x = 0, y = 0, z = 0 }\n";
    refused(&format!("{arm}\n{without}"), &format!("{twice}\n"), "both have snapshots.dwell_s");
    refused("dwell_s = [60, 0.5, 9.5]", "dwell_s = [0, 0, 0]", "is 0 for every snapshot");
    refused("dwell_s = [60, 0.5, 9.5]", "dwell_s = [60, 0.5]", "dwell_s has 2 entries");
    refused("dwell_s = [60, 0.5, 9.5]", "dwell_s = [60, -1, 3]", "dwell_s[1] = -1");
    refused("position_m = [[0.1, -0.45, 0.65], [-0.4, -0.45, 0.65], [0.5, 0.2, 0.65]]\n", "", "no list");
}

#[test]
fn weights_of_crossed_lists_are_multiplied() {
    let folder = Folder::new();
    let person = "position_m = [0.1, -0.45, 0.65]";
    folder.edit("cell.toml", person, &format!("{person}\nsnapshots = {{ position_m = [[0.1, -0.45, 0.65], [0.5, 0.2, 0.65]], dwell_s = [3, 1], cross = true }}"));
    let ball = "position_m = [-0.7, -0.5, 0.3]";
    folder.edit("cell.toml", ball, &format!("{ball}\nsnapshots = {{ position_m = [[-0.7, -0.5, 0.3], [-0.7, -0.2, 0.3]], dwell_s = [10, 40] }}"));
    let swept = folder.sweep(&[]);
    assert_eq!(swept.code, Some(0), "{}", swept.stderr);
    let manifest: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.path("out/manifest.json")).unwrap()).unwrap();
    let lasting: Vec<f64> = manifest["scenes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|scene| scene["dwell_s"].as_f64().unwrap())
        .collect();
    // The rest of the scene goes through its moments for each entry that is crossed.
    assert_eq!(lasting, [30.0, 120.0, 10.0, 40.0]);
}
