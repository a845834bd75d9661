//! `perirobot judge` of a study with `[postures]`: who stands where the worst case is, the command that shows it, and what
//! cannot be asked.

use crate::common::program::{Folder, Outcome, perirobot, refused, rows, shelf, text};
use perirobot_decide::judge::{Alteration, alter};
use perirobot_decide::view::{ChoiceSelector, find};
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;

/// The small study, with somebody at two spots; one of them is in the crate.
fn cell() -> Folder {
    let folder = Folder::new();
    let asked = "\n[[require]]\nname = \"seen\"\nscore = \"human_seen\"\nregion = \"human\"\nat_least = 0.02\n\
         under = [\"as_planned\", \"postures\"]\n[postures]\npeople = [\"kneeling\", \"bent\"]\n\
         spots = [[-0.2, -0.2, 30], [0.7, 0.4, 0]]\n";
    folder.edit("study.toml", "", asked);
    folder
}

fn judge(folder: &Folder, more: &[&str]) -> Outcome {
    let out = folder.path("out");
    perirobot(&[&["judge", text(&out), "--pose", "wall/1/1"], more].concat())
}

#[test]
fn the_worst_posture_is_told_with_the_command_that_shows_it() {
    let folder = cell();
    assert_eq!(folder.sweep(&[]).code, Some(0));
    let outcome = judge(&folder, &[]);
    assert!(matches!(outcome.code, Some(0 | 4)), "{}", outcome.stderr);
    // Who is in the crate is warned of, and nobody else.
    let warned: Vec<&str> = outcome.stderr.lines().filter(|line| line.contains("person ")).collect();
    let is_of =
        |name: &str| warned.iter().filter(|line| line.contains(&format!("cell: person {name:?} "))).count();
    assert!(is_of("kneeling/1") > 0 && is_of("bent/1") > 0, "{warned:?}");
    assert!(is_of("kneeling/0") + is_of("bent/0") == 0, "{warned:?}");
    let judged = rows(&folder.path("out/requirements.csv"));
    let row = judged.iter().find(|row| row["condition"] == "postures").unwrap();
    assert_eq!([&row["cases"], &row["of"]], ["4", "4"], "{row:?}");
    let worst = row["case"].strip_prefix("posture ").unwrap();
    // Each posture by itself has the value that is told of the best and of the worst.
    let summed = rows(&folder.path("out/conditions.csv"));
    let is_it = |row: &&std::collections::HashMap<String, String>| {
        [&row["condition"], &row["region"], &row["score"]] == ["postures", "human", "human_seen"]
    };
    let spread = summed.iter().find(is_it).unwrap();
    assert_eq!((spread["case"].as_str(), &spread["worst"]), (row["case"].as_str(), &row["value"]));
    assert!(spread["best"].parse::<f64>().unwrap() > spread["worst"].parse::<f64>().unwrap(), "{spread:?}");
    // The command that is printed draws it.
    let command = outcome.stdout.lines().find(|line| line.contains(&format!("--posture {worst}"))).unwrap();
    let picture = folder.path("worst.png");
    let words: Vec<&str> = command.split_whitespace().skip(1).map(|word| word.trim_matches('\'')).collect();
    let words: Vec<&str> =
        words.into_iter().map(|word| if word.ends_with(".png") { text(&picture) } else { word }).collect();
    let drawn = perirobot(&words);
    assert_eq!(drawn.code, Some(0), "{command}: {}", drawn.stderr);
    assert!(picture.exists());
    // On a floor plan the person of the posture stands, and the operator does not.
    let (out, plan) = (folder.path("out"), folder.path("plan.svg"));
    let drawn =
        perirobot(&["render", text(&out), "--pose", "wall/1/1", "--posture", "bent/0", "--out", text(&plan)]);
    assert_eq!(drawn.code, Some(0), "{}", drawn.stderr);
    let plan = std::fs::read_to_string(plan).unwrap();
    assert!(plan.contains("bent/0") && !plan.contains("operator"), "{plan}");
    let told = perirobot(&["why", text(&out), "--pose", "wall/1/1", "--posture", "bent/0"]);
    assert_eq!(told.code, Some(0), "{}", told.stderr);
}

/// Who comes near comes beside the person of the posture, as if that were in the scene.
#[test]
fn an_approach_has_the_person_of_the_posture_as_cover() {
    let folder = shelf();
    let asked = "\n[postures]\npeople = [\"small\"]\nspots = [[0.3, 0.6, 0], [0.9, 0.4, 90]]\n";
    folder.edit("study.toml", "", asked);
    let near = |more: &[&str]| {
        let (study, out) = (folder.path("study.toml"), folder.path("near"));
        let fixed = ["approach", text(&study), "--pose", "wall/front", "--out", text(&out)];
        let outcome = perirobot(&[&fixed, more].concat());
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        let mut found = rows(&out.join("approach.csv"));
        let case = found[0]["case"].clone();
        found.iter_mut().for_each(|row| drop(row.remove("case")));
        (case, found)
    };
    let (case, found) = near(&["--posture", "small/1"]);
    assert_eq!((case.as_str(), found.len()), ("posture small/1", 6));
    assert_ne!(found, near(&["--posture", "small/0"]).1);
    // By hand.
    let joints = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/people/small.csv");
    folder.write("small.csv", std::fs::read(joints).unwrap());
    let colleague =
        "role = \"human\"\ncylinder = { radius_m = 0.2, height_m = 1.7 }\nposition_m = [0.1, 0.55, 0.9]";
    folder.edit(
        "cell.toml",
        colleague,
        "mannequin = \"small.csv\"\nposition_m = [0.9, 0.4, 0]\nrpy_deg = [0, 0, 90]",
    );
    folder.edit("cell.toml", "name = \"colleague\"", "name = \"small/1\"");
    let (case, by_hand) = near(&[]);
    assert_eq!((case.as_str(), &found), ("", &by_hand));
}

#[test]
fn what_cannot_stand_anywhere_is_refused_before_anything_is_removed() {
    let folder = cell();
    assert_eq!(folder.sweep(&[]).code, Some(0));
    judge(&folder, &[]);
    let judged = |folder: &Folder| folder.path("out/requirements.csv").exists();
    assert!(judged(&folder));
    let wrong = |from: &str, to: &str, expected: &[&str]| {
        let before = std::fs::read_to_string(folder.path("study.toml")).unwrap();
        folder.edit("study.toml", from, to);
        let check = perirobot(&["check", text(&folder.path("study.toml")), "--poses", "0"]);
        for outcome in [judge(&folder, &[]), check] {
            assert_eq!(outcome.code, Some(2), "{to}: {}", outcome.stderr);
            assert!(expected.iter().all(|part| outcome.stderr.contains(part)), "{to}: {}", outcome.stderr);
        }
        assert!(judged(&folder), "{to}");
        folder.write("study.toml", before);
    };
    wrong(
        "[[-0.2, -0.2, 30]",
        "[[1.4, -0.2, 30]",
        &["postures.spots[0] = [1.4, -0.2]: must be in the grid", "scene \"cell\""],
    );
    wrong(
        "\"bent\"",
        "\"bend\"",
        &["postures.people[1] = \"bend\": must be one of standing, reaching, bent"],
    );
    // Nothing of the person is in the grid: above it, or stretched out beside it. Heights in poses.csv are above the
    // floor, so a new floor needs a new sweep.
    let before = std::fs::read_to_string(folder.path("study.toml")).unwrap();
    folder.edit("study.toml", "\n[postures]", "\n[approach]\nfloor_m = 3\n[postures]");
    let above =
        "postures.spots[0] = [-0.2, -0.2] on a floor at 3 m: must place person \"kneeling/0\" in the grid";
    let check = perirobot(&["check", text(&folder.path("study.toml")), "--poses", "0"]);
    assert!(check.code == Some(2) && check.stderr.contains(above), "{}", check.stderr);
    assert!(judge(&folder, &[]).stderr.contains("sweep again") && judged(&folder));
    folder.write("study.toml", before);
    let none = |joints| ",,\n".repeat(joints);
    let arms = "5,0,0.9\n5,0.2,0.9\n5,0,0.6\n5,0.2,0.6\n";
    folder.write("aside.csv", format!("{}{arms}{}", none(5), none(8)));
    wrong("\"bent\"", "\"aside.csv\"", &["postures.spots[0]", "place person \"aside/0\" in the grid"]);
    wrong("\"bent\"", "\"mine.csv\"", &["postures.people", "mine.csv", "cannot be read"]);
    folder.write("mine.csv", "x_m,y_m,z_m\n1,2,3\n");
    wrong("\"bent\"", "\"mine.csv\"", &["postures.people", "mine.csv", "has 1 joints"]);
    // A posture that the study does not have.
    let (out, picture) = (folder.path("out"), folder.path("none.png"));
    let named = |name: &str| {
        perirobot(&["render", text(&out), "--pose", "wall/1/1", "--posture", name, "--out", text(&picture)])
    };
    let outcome = named("bent/2");
    assert_eq!(outcome.code, Some(2));
    assert!(
        outcome.stderr.contains("--posture bent/2") && outcome.stderr.contains("kneeling/0"),
        "{}",
        outcome.stderr
    );
    let plain = Folder::new();
    assert_eq!(plain.sweep(&[]).code, Some(0));
    let (out, picture) = (plain.path("out"), plain.path("none.png"));
    let outcome = perirobot(&[
        "render",
        text(&out),
        "--pose",
        "wall/1/1",
        "--posture",
        "bent/0",
        "--out",
        text(&picture),
    ]);
    assert_eq!(outcome.code, Some(2));
    assert!(
        outcome.stderr.contains("study.toml has no [postures]: add them to the study"),
        "{}",
        outcome.stderr
    );
    let asked = "\n[[require]]\nname = \"seen\"\nscore = \"human_seen\"\nregion = \"human\"\nat_least = 0.02\nunder = [\"postures\"]\n";
    refused(&plain, &[("study.toml", "", asked)], &["under = \"postures\": needs to know who stands where"]);
}

/// Half a body may be seen whole: who the grid cuts off is told before anything is judged, and how much of the region
/// around that person there is.
#[test]
fn who_is_cut_off_by_the_grid_is_warned_of() {
    let folder = cell();
    folder.edit("study.toml", "[[-0.2, -0.2, 30], [0.7, 0.4, 0]]", "[[1.19, -0.2, 0], [0.2, -0.2, 0]]");
    assert_eq!(folder.sweep(&[]).code, Some(0));
    let check = perirobot(&["check", text(&folder.path("study.toml")), "--poses", "0"]);
    let judged = judge(&folder, &[]);
    assert!(matches!(judged.code, Some(0 | 4)) && check.code == Some(0), "{}", judged.stderr);
    for said in [&check.stderr, &judged.stderr] {
        let cut: Vec<&str> = said.lines().filter(|line| line.contains("is cut off by the grid")).collect();
        let is_of = |line: &&str, name: &str| line.starts_with(&format!("warning: cell: person {name:?} "));
        assert!(cut.len() == 2 && is_of(&cut[0], "kneeling/0") && is_of(&cut[1], "bent/0"), "{cut:?}");
        let percent = cut[0].split_once("grid: ").unwrap().1.split_once(" %").unwrap().0;
        assert!((20.0..80.0).contains(&percent.parse::<f64>().unwrap()), "{cut:?}");
    }
    // A wall closes the side on which the region around that person is cut off.
    assert!(!judged.stderr.contains("region \"human\": "), "{}", judged.stderr);
    assert!(!judged.stderr.contains("posture \"kneeling/1\""), "{}", judged.stderr);
}

/// Who is taller than all that stands there stretches no grid: regions have the same voxels as planned.
#[test]
fn a_posture_is_judged_on_the_grid_as_planned() {
    let folder = cell();
    folder.edit("study.toml", "\"kneeling\", \"bent\"", "\"tall\"");
    folder.edit("study.toml", "radius_m = 0.6", "radius_m = 2.4");
    let study = Study::load(&folder.path("study.toml"), &Overrides::default()).unwrap();
    let planned = World::prepare_all(&study).unwrap();
    let names = ChoiceSelector { poses: "wall/1/1".into(), ..ChoiceSelector::default() };
    let (_, choice) = find(&study, &planned, &names).unwrap();
    let (own, worlds, _) = alter(&study, &planned, &choice, &Alteration::Posture("tall/0".into())).unwrap();
    assert_eq!((own.bounds_m, worlds.len()), (None, 1));
    assert_eq!(worlds[0].grid, planned[0].grid);
    // All but the one around the person, which is elsewhere.
    let of = |world: &World| [0, 1].map(|region| world.regions[region].voxels.clone());
    assert_eq!(of(&worlds[0]), of(&planned[0]));
    assert!(planned[0].regions[0].cut_share > 0.0);
    // In the scene, this person would stretch it.
    let above = planned[0].grid.corner_m(planned[0].grid.window().end()).z;
    assert!((1.6..1.8).contains(&above), "{above}");
}

/// What a file of joints says decides a verdict under postures, and none as planned.
#[test]
fn another_person_in_a_file_makes_other_tables() {
    let folder = cell();
    folder.edit("study.toml", "\"bent\"", "\"mine.csv\"");
    let people = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/people");
    let tables = |person: &str| {
        folder.write("mine.csv", std::fs::read(people.join(person)).unwrap());
        let outcome = judge(&folder, &[]);
        assert!(matches!(outcome.code, Some(0 | 4)), "{}", outcome.stderr);
        let judged = rows(&folder.path("out/requirements.csv"));
        let of = |condition: &str| {
            judged.iter().find(|row| row["condition"] == condition).unwrap()["tables_sha256"].clone()
        };
        [of("as_planned"), of("postures")]
    };
    folder.write("mine.csv", std::fs::read(people.join("bent.csv")).unwrap());
    assert_eq!(folder.sweep(&[]).code, Some(0));
    let ([planned, bent], [same, small]) = (tables("bent.csv"), tables("small.csv"));
    assert_eq!(planned, same);
    assert_ne!(bent, small);
    assert_eq!(tables("bent.csv")[1], bent);
}
