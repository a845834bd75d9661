//! A small integrator's cell: a hall of 12 m x 10 m x 6 m on a slab of 0.3 m, cameras of three models, nine verdicts. It is
//! chosen, judged and reported: heights, verdicts and the recommended set are those of one set wherever they are told.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use crate::common::program::{Folder, choose, perirobot, rows, text};

/// Four cameras of three models, which no combination of the study lists.
const FOUR: &str = "wall:north-wall/0/0;roof:ceiling/4/0;near:posts/east;near:posts/south";

/// A folder with the hall and its study.
fn hall() -> Folder {
    let folder = Folder::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    for file in
        ["tests/fixtures/hall/study.toml", "tests/fixtures/hall/cell.toml", "scenes/people/standing.csv"]
    {
        let from = root.join(file);
        folder.write(from.file_name().unwrap().to_str().unwrap(), fs::read(&from).unwrap());
    }
    folder
}

/// Runs a command on a folder, with some exit code; what it prints.
#[track_caller]
fn on(folder: &Folder, code: i32, words: &[&str]) -> String {
    let out = folder.path("out");
    let outcome = perirobot(&[&[words[0], text(&out)], &words[1..], &["--backend", "cpu"]].concat());
    assert_eq!(outcome.code, Some(code), "{words:?}: {}{}", outcome.stdout, outcome.stderr);
    outcome.stdout
}

/// The verdicts on each judged set, by its combination and poses, in the order of the table.
fn verdicts(folder: &Folder) -> Vec<((String, String), Vec<bool>)> {
    let mut sets: Vec<((String, String), Vec<bool>)> = Vec::new();
    for row in rows(&folder.path("out/requirements.csv")) {
        let set = (row["combination"].clone(), row["poses"].clone());
        if sets.last().is_none_or(|(last, _)| *last != set) {
            sets.push((set, Vec::new()));
        }
        sets.last_mut().unwrap().1.push(row["verdict"] == "PASS");
    }
    sets
}

/// What a set costs, by the prices in the study.
fn cost(poses: &str) -> u32 {
    let prices = HashMap::from([("wall", 900), ("roof", 1500), ("near", 450)]);
    poses.split(';').map(|pose| prices[pose.split_once(':').unwrap().0]).sum()
}

#[test]
fn heights_are_above_the_floor_and_not_above_the_slab() {
    let folder = hall();
    let outcome = choose(&folder, "out", &[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(
        outcome.stdout.contains("ceiling, x 2.0 m, y -2.0 m, 5.8 m high, straight down"),
        "{}",
        outcome.stdout
    );
    let of_poses = rows(&folder.path("out/poses.csv"));
    assert_eq!(of_poses.len(), 12);
    let height = |place: &str| place.split_once(" m high").unwrap().0.rsplit_once(' ').unwrap().1.to_string();
    for row in &of_poses {
        assert_eq!(height(&row["place"]).parse::<f64>(), row["z_m"].parse::<f64>(), "{row:?}");
    }
    for row in rows(&folder.path("out/sets.csv")) {
        let pose = of_poses.iter().find(|pose| pose["pose"] == row["pose"]).unwrap();
        assert_eq!(row["place"], pose["place"]);
    }
    // A floor that the study gives is taken.
    folder.edit("study.toml", "[approach]\n", "[approach]\nfloor_m = 0.5\n");
    let outcome = choose(&folder, "other", &[]);
    assert!(outcome.stdout.contains("5.3 m high, straight down"), "{}", outcome.stdout);
    assert!(outcome.stderr.contains("floor_m = 0.5: the floor is at z 0.00 m"), "{}", outcome.stderr);
    let check = perirobot(&["check", text(&folder.path("study.toml")), "--poses", "0"]);
    assert!(check.stdout.contains("  floor at z 0.50 m: floor_m of the study"), "{}", check.stdout);
}

#[test]
fn all_sets_are_judged_and_the_cheapest_that_passes_is_recommended() {
    let folder = hall();
    assert_eq!(choose(&folder, "out", &[]).code, Some(0));
    let printed = on(&folder, 0, &["judge", "--progress", "none"]);
    let judged = verdicts(&folder);
    assert!(judged.len() >= 5 && judged.iter().all(|(_, all)| all.len() == 9), "{judged:?}");
    let passing = judged.iter().filter(|(_, all)| all.iter().all(|pass| *pass)).map(|(set, _)| set);
    let (name, poses) = passing.clone().min_by_key(|(_, poses)| cost(poses)).expect("a set passes");
    assert!(
        passing.clone().any(|(_, other)| cost(other) > cost(poses)),
        "a dearer one passes, too: {judged:?}"
    );
    let best = &rows(&folder.path("out/front.csv")).pop().unwrap()["poses"];
    assert_ne!(best, poses, "the best set by its score is another");
    let line = format!("recommended: {name} ({poses}), the cheapest set that meets all requirements\n");
    assert!(printed.contains(&line), "no {line:?} in {printed}");
    // The page recommends it, and has the verdicts of every set, each under its name.
    on(&folder, 0, &["report", "--best", "1"]);
    let page = fs::read_to_string(folder.path("out/report.html")).unwrap();
    let said = page.split_once("<div class=\"said\">").unwrap().1;
    let (first, rest) = said.split_once("<section id=\"good\">").unwrap();
    assert!(first.contains(&format!("<p>{name} ({poses})</p>")), "the set is named");
    assert!(first.contains(&format!("The numbers are those of {name}; ")), "whose numbers they are");
    assert!(first.contains("yes: 5 of 5 requirements met (9 of 9 verdicts are PASS)"), "its verdict");
    assert!(first.contains(&format!("<strong>{}</strong>", cost(poses))), "its cost");
    let good = rest.split_once("</section>").unwrap().0;
    assert!(good.contains(&format!("of this section are of {name} ({poses}).")), "{good}");
    for ((name, poses), all) in &judged {
        let met = all.iter().filter(|pass| **pass).count();
        let named = good.split_once(&format!("{name} · {poses} · ")).expect("a judged set is named").1;
        let summary = named.split_once("</summary>").unwrap().0;
        assert!(summary.contains(&format!("({met} of 9 verdicts are PASS)")), "{name}: {summary}");
    }
    // One set alone.
    let front = &judged[0].0.0;
    on(&folder, 4, &["judge", "--set", front, "--progress", "none"]);
    assert_eq!(verdicts(&folder).iter().map(|(set, _)| &set.0).collect::<Vec<_>>(), [front]);
    on(&folder, 0, &["report", "--best", "1"]);
    let page = fs::read_to_string(folder.path("out/report.html")).unwrap();
    assert!(page.contains("the one choice that was judged misses a requirement"), "the best set, and why");
}

#[test]
fn four_cameras_of_three_models_need_no_combination() {
    let folder = hall();
    let study = folder.path("study.toml");
    let [out, png] = ["near", "set.png"].map(|name| folder.path(name));
    let on_study = |words: &[&str]| {
        let outcome = perirobot(&[&[words[0], text(&study), "--pose", FOUR], &words[1..]].concat());
        assert_eq!(outcome.code, Some(0), "{words:?}: {}", outcome.stderr);
        outcome.stdout
    };
    let near = on_study(&["approach", "--out", text(&out)]);
    assert!(near.contains("standing from door: "), "{near}");
    assert!(
        rows(&out.join("approach.csv")).iter().all(|row| row["poses"] == FOUR && row["combination"] == "set")
    );
    on_study(&["render", "--out", text(&png), "--size", "320x200", "--backend", "cpu"]);
    assert!(fs::read(&png).unwrap().starts_with(b"\x89PNG"));
    // In the folder of a sweep of each camera alone.
    let swept = folder.sweep(&[]);
    assert_eq!(swept.code, Some(0), "{}", swept.stderr);
    let printed = on(&folder, 0, &["judge", "--pose", FOUR, "--progress", "none"]);
    assert!(printed.contains(&format!("{FOUR} · set · points;points;points;points")), "{printed}");
    let [(set, all)] = &verdicts(&folder)[..] else { panic!("one set is judged") };
    assert_eq!((set.1.as_str(), all.len()), (FOUR, 9));
    assert!(all.iter().all(|passes| *passes));
    for (number, name) in ["render", "approach"].into_iter().enumerate() {
        let printed = printed.lines().find(|line| line.contains(&format!("perirobot {name} "))).unwrap();
        let words = printed.split_whitespace().map(|word| word.trim_matches('\''));
        let words: Vec<&str> =
            words.skip_while(|word| *word != name).take_while(|word| *word != "--out").collect();
        let again =
            perirobot(&[&words[..], &["--out", text(&folder.path(&format!("again-{number}.png")))]].concat());
        assert_eq!(again.code, Some(0), "{printed}: {}", again.stderr);
    }
    on(&folder, 0, &["report", "--best", "1"]);
    let page = fs::read_to_string(folder.path("out/report.html")).unwrap();
    assert!(page.contains(&format!("{FOUR}, which was judged, meets all requirements, but was not swept")));
    assert!(on(&folder, 0, &["why", "--pose", FOUR]).contains(&format!("{FOUR} · set")));
    on(&folder, 0, &["export", "--pose", FOUR, "--out", text(&folder.path("files"))]);
    assert!(folder.path("files/cell.glb").exists());
    // The same set counts the same where it was chosen.
    assert_eq!(choose(&folder, "chosen", &[]).code, Some(0));
    let verdict = |out: &str| {
        let of_set = |row: &HashMap<String, String>| row["poses"] == FOUR;
        let judged = rows(&folder.path(out).join("requirements.csv")).into_iter().filter(of_set);
        judged.map(|row| [row["verdict"].clone(), row["value"].clone()]).collect::<Vec<_>>()
    };
    let outcome = perirobot(&["judge", text(&folder.path("chosen")), "--pose", FOUR, "--progress", "none"]);
    assert!(matches!(outcome.code, Some(0 | 4)), "{}", outcome.stderr);
    assert_eq!(verdict("out"), verdict("chosen"));
    // What is no set is refused as before.
    for wrong in ["wall:north-wall/0/0;roof:nowhere", "wall:north-wall/0/0;wall:north-wall/0/0"] {
        let outcome = perirobot(&["approach", text(&study), "--pose", wrong, "--out", text(&out)]);
        assert_eq!(outcome.code, Some(2), "{wrong}: {}", outcome.stderr);
        assert!(outcome.stderr.contains("no such choice of poses"), "{wrong}: {}", outcome.stderr);
    }
}
