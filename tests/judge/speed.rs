//! `perirobot judge` of a study with `[stopping]`: how fast the robot may run, and what a controller would measure,
//! found again voxel by voxel and the same on every backend.

use std::collections::HashMap;
use std::fs;

use crate::common;
use crate::common::program::{Folder, Outcome, STOPPING, perirobot, refused, rows, text};
use perirobot_decide::view::{ChoiceSelector, View, find};
use perirobot_march::backend::cpu::Cpu;
use perirobot_march::voxel::BitGrid;
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;

/// As `STOPPING` says, in micrometres.
const NEEDED_UM: [u64; 3] = [321_250, 445_000, 730_000];
const POSES: [&str; 3] = ["posts/upright", "wall/1/1", "random/0"];

fn require(name: &str, score: &str, region: &str, limit: &str) -> String {
    format!("\n[[require]]\nname = \"{name}\"\nscore = \"{score}\"\nregion = \"{region}\"\n{limit}\n")
}

/// The small study in two scenes with noise; insides are ignored, and the person comes nearer.
fn cell(more: &str) -> Folder {
    let folder = Folder::noisy();
    for scene in ["cell.toml", "second.toml"] {
        folder.edit(scene, "interior = \"free\"", "");
    }
    let at = "position_m = [0.1, -0.45, 0.65]";
    folder.edit(
        "cell.toml",
        at,
        &format!("{at}\n[object.snapshots]\nposition_m = [[0.1, -0.45, 0.65], [0.2, 0.0, 0.65]]"),
    );
    folder.edit("study.toml", "[[sensor]]", "[[region]]\nname = \"near\"\nseparation = {}\n[[sensor]]");
    folder.edit("study.toml", "", &format!("{STOPPING}{more}"));
    folder
}

#[track_caller]
fn swept(folder: &Folder) {
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
}

fn judge(folder: &Folder, more: &[&str]) -> Outcome {
    let out = folder.path("out");
    perirobot(&[&["judge", text(&out)], more].concat())
}

/// The least squared distance between two sets, one by one.
fn least(robot: &BitGrid, voxels: &BitGrid) -> Option<u64> {
    let squared =
        |a: [i32; 3], b: [i32; 3]| (0..3).map(|r| u64::from(a[r].abs_diff(b[r])).pow(2)).sum::<u64>();
    let each = voxels.voxels().flat_map(|a| robot.voxels().map(move |b| squared(a, b)));
    each.min()
}

#[test]
fn what_is_measured_is_what_a_plain_search_finds() {
    let folder = cell(&require("seen", "human_seen", "near@1", "at_least = 0"));
    swept(&folder);
    // What the controller knows: the same scenes without anybody.
    let alone = cell("");
    for scene in ["cell.toml", "second.toml"] {
        let text = fs::read_to_string(alone.path(scene)).unwrap();
        let person = text.split_once("[[object]]\nname = \"operator\"").unwrap();
        assert!(!person.1.contains("[[object]]"));
        alone.write(scene, person.0);
    }
    alone.edit(
        "study.toml",
        "[[region]]\nname = \"human\"\nhuman_box = { object = \"operator\", margin_m = 0.2 }\n",
        "",
    );
    let load = |folder: &Folder| {
        let study = Study::load(&folder.path("study.toml"), &Overrides::default()).unwrap();
        let worlds = World::prepare_all(&study).unwrap();
        (study, worlds)
    };
    let ((study, worlds), (_, empty)) = (load(&folder), load(&alone));
    let mut decisions: HashMap<String, usize> = HashMap::new();
    let (mut missed, mut ignored) = (0, 0);
    for pose in POSES {
        let outcome = judge(&folder, &["--pose", pose]);
        assert!(matches!(outcome.code, Some(0 | 4)), "{}", outcome.stderr);
        let table = rows(&folder.path("out").join("separation.csv"));
        assert_eq!(table.len(), 3 * 2 * 3, "moments, repeats and speeds");
        for row in &table {
            let number = |key: &str| row[key].parse::<usize>().unwrap();
            let (snapshot, repeat) = (number("snapshot"), number("repeat"));
            let names = ChoiceSelector {
                poses: pose.into(),
                repeat,
                scene: Some(row["scene"].clone()),
                snapshot,
                ..ChoiceSelector::default()
            };
            let (world, choice) = find(&study, &worlds, &names).unwrap();
            let nobody = empty.iter().find(|empty| empty.name == world.name).unwrap();
            assert_eq!(nobody.grid, world.grid);
            let view = View::new(&study, world, choice, &mut Cpu::new(Some(1)).unwrap()).unwrap();
            let (truth, nobody) = (world.truth(), nobody.truth());
            ignored += nobody.ignored.count();
            let robot = &truth.robot_volume;
            let is_known =
                |voxel| nobody.occupied.get(voxel) || nobody.ignored.get(voxel) || robot.get(voxel);
            let mut measured = [(); 2].map(|()| BitGrid::new(world.grid.window()));
            for voxel in BitGrid::full(world.grid.window()).voxels().filter(|&voxel| !is_known(voxel)) {
                let (occupied, free) = (view.labels.occupied.get(voxel), view.labels.free.get(voxel));
                if occupied {
                    measured[0].set(voxel);
                }
                if occupied || !free {
                    measured[1].set(voxel);
                }
            }
            let truly = least(robot, &truth.human);
            let [free, occupied] = measured.map(|voxels| least(robot, &voxels));
            let shown = |squared: Option<u64>| squared.map_or(String::new(), |squared| squared.to_string());
            for (column, squared) in [("true", truly), ("unknown_free", free), ("unknown_occupied", occupied)]
            {
                assert_eq!(row[&format!("{column}_squared")], shown(squared), "{column} of {row:?}");
                let metres = squared.map(|squared| (squared as f64).sqrt() * 0.1);
                let told = row[&format!("{column}_m")].parse::<f64>().ok();
                assert_eq!(told.is_some(), metres.is_some());
                assert!(told.zip(metres).is_none_or(|(a, b)| (a - b).abs() < 1e-12), "{column} of {row:?}");
            }
            let needed_um =
                NEEDED_UM[["0.25", "0.5", "1"].iter().position(|v| *v == row["speed_m_s"]).unwrap()];
            // A voxel is 100,000 micrometres.
            let near = |squared: Option<u64>| {
                squared.is_some_and(|squared| squared * 10_000_000_000 < needed_um.pow(2))
            };
            for (column, squared) in [("unknown_free", free), ("unknown_occupied", occupied)] {
                let expected = match (near(squared), near(truly)) {
                    (true, true) => "stops",
                    (false, false) => "runs",
                    (true, false) => "needless_stop",
                    (false, true) => "missed_stop",
                };
                assert_eq!(row[column], expected, "{column} of {row:?}");
                *decisions.entry(expected.into()).or_default() += 1;
            }
            let too_far = free.zip(truly).map(|(free, truly)| (free as f64).sqrt() - (truly as f64).sqrt());
            let told = row["missed_m"].parse::<f64>().ok();
            assert_eq!(told.is_some(), too_far.is_some(), "{row:?}");
            let too_far = too_far.unwrap_or(0.0).max(0.0) * 0.1;
            assert!((told.unwrap_or(0.0) - too_far).abs() < 1e-12, "{row:?}");
            missed += usize::from(too_far > 0.0);
        }
        // In words, of all moments.
        let of = |column: &str, decision: &str| {
            let own = |row: &&HashMap<String, String>| row["speed_m_s"] == "1" && row[column] == decision;
            table.iter().filter(own).count().to_string()
        };
        for (column, words) in [("unknown_free", "taken as free"), ("unknown_occupied", "taken as occupied")]
        {
            let line =
                outcome.stdout.lines().find(|line| line.contains(words) && line.contains("0.73 m")).unwrap();
            let told: Vec<&str> = line.split_whitespace().rev().take(4).collect();
            let expected =
                ["needless_stop", "missed_stop", "runs", "stops"].map(|decision| of(column, decision));
            assert_eq!(told, expected, "{line}");
        }
        assert!(outcome.stdout.contains("0.730 m at 1 m/s"), "{}", outcome.stdout);
    }
    assert!(decisions.len() == 4 && missed > 0 && ignored > 0, "{decisions:?}, {missed}, {ignored}");
}

#[test]
fn every_backend_measures_the_same() {
    let folder = cell(&require("seen", "human_seen", "near@1", "at_least = 0"));
    swept(&folder);
    let mut backends = vec![vec!["--backend", "oracle"], vec!["--backend", "cpu"]];
    backends.extend(common::on_adapter().map(Vec::from));
    let tables = backends.iter().map(|backend| {
        let outcome = judge(&folder, &[&["--best", "3"], &backend[..]].concat());
        assert!(matches!(outcome.code, Some(0 | 4)), "{}", outcome.stderr);
        ["separation.csv", "speeds.csv"].map(|name| fs::read(folder.path("out").join(name)).unwrap())
    });
    let tables: Vec<_> = tables.collect();
    assert!(tables.iter().all(|table| *table == tables[0]), "{backends:?}");
}

/// The values of `unknown` in the region of each speed, as the sweep has them, of all moments the one that is worst.
fn worst(folder: &Folder, pose: &str, worse: fn(f64, f64) -> f64) -> [f64; 3] {
    REGIONS.map(|region| values(folder, pose, region).into_iter().reduce(worse).unwrap())
}

const REGIONS: [&str; 3] = ["near@0.25", "near@0.5", "near@1"];

fn values(folder: &Folder, pose: &str, region: &str) -> Vec<f64> {
    let table = rows(&folder.path("out").join("results.csv"));
    let own = table.iter().filter(|row| row["poses"].ends_with(pose) && row["region"] == region);
    own.map(|row| row["unknown"].parse().unwrap()).collect()
}

/// What the grid cuts off in the open is named again by `judge`: of regions that requirements name, not of others.
#[test]
fn regions_that_the_grid_cuts_off_in_the_open_are_named_again() {
    let folder = cell("");
    // The room goes on beyond y = 0.75 m.
    let bounds = "voxel_size_m = 0.1\nbounds_m = { min = [-1.2, -0.9, 0], max = [1.2, 0.75, 1.6] }";
    folder.edit("study.toml", "voxel_size_m = 0.1", bounds);
    folder.edit("study.toml", "", &require("known", "unknown", REGIONS[2], "at_most = 1"));
    swept(&folder);
    let said = judge(&folder, &["--pose", POSES[0]]).stderr;
    let line =
        said.lines().find(|line| line.contains("region \"near@1\": ")).unwrap_or_else(|| panic!("{said}"));
    assert!(line.contains("towards +y") && line.contains("take what is said of it as a bound"), "{line}");
    assert!(!said.contains("region \"robot\": "), "{said}");
}

/// Limits between what is there at one speed and at the next.
#[test]
fn the_fastest_speed_is_the_last_before_one_that_is_missed() {
    let pose = POSES[0];
    let folder = cell("");
    swept(&folder);
    let values = worst(&folder, pose, f64::min);
    assert!(
        values.is_sorted_by(|slower, faster| slower > faster),
        "{values:?}: less is unknown far from the robot"
    );
    let between = |a: f64, b: f64| ((a + b) / 2.0 * 1e6).round() / 1e6;
    let limits = [1.0, between(values[0], values[1]), between(values[1], values[2]), 0.0];
    let text = fs::read_to_string(folder.path("study.toml")).unwrap();
    for (fastest, limit) in limits.into_iter().enumerate() {
        let limit = (limit * 1e6).round() / 1e6;
        folder.write("study.toml", &text);
        // Named at whatever speed.
        let region = REGIONS[fastest % 3];
        folder.edit("study.toml", "", &require("known", "unknown", region, &format!("at_least = {limit}")));
        // Not about a speed, and missed.
        folder.edit("study.toml", "", &require("other", "unknown", "box", "at_most = 0"));
        let outcome = judge(&folder, &["--pose", pose]);
        assert_eq!(outcome.code, Some(4), "{}", outcome.stderr);
        let table = rows(&folder.path("out").join("speeds.csv"));
        let found: Vec<[&str; 4]> = table
            .iter()
            .map(|row| ["speed_m_s", "region", "verdict", "fast_enough"].map(|key| row[key].as_str()))
            .collect();
        let expected: Vec<[&str; 4]> = (0..3)
            .map(|speed| {
                let [verdict, enough] = if speed < fastest { ["PASS", "1"] } else { ["FAIL", "0"] };
                [["0.25", "0.5", "1"][speed], REGIONS[speed], verdict, enough]
            })
            .collect();
        assert_eq!(found, expected, "at least {limit}");
        for (row, value) in table.iter().zip(values) {
            assert_eq!(row["value"].parse::<f64>().unwrap(), value);
        }
        let up_to = ["at none", "up to 0.25 m/s,", "up to 0.5 m/s,", "up to 1 m/s,"][fastest];
        // It is said of which requirements, and which others are missed.
        let line =
            format!("how fast may it run, by the requirements in separation regions: {up_to} of the listed");
        assert!(outcome.stdout.contains(&line), "{line}: {}", outcome.stdout);
        let other = "\n  also missed, whatever the speed: other (as planned)\n";
        assert!(outcome.stdout.contains(other), "{}", outcome.stdout);
        // Walls close the cell where the grid cuts the regions off.
        let cut = |name: &str| outcome.stderr.contains(&format!("region \"{name}\": "));
        assert!(!cut("near@1") && !cut("robot"), "{}", outcome.stderr);
        let next = ["0.25", "0.5", "1"].get(fastest);
        let missed = next.map(|next| format!("  at {next} m/s missed: known (as planned)\n"));
        assert_eq!(outcome.stdout.matches(" m/s missed: ").count(), usize::from(missed.is_some()));
        assert!(missed.is_none_or(|line| outcome.stdout.contains(&line)), "{}", outcome.stdout);
    }
    // A requirement that is met at a higher speed again is not enough there.
    folder.write("study.toml", &text);
    let [_, medium, fast] = worst(&folder, pose, f64::max);
    let limit = format!("at_most = {}", between(medium, fast));
    folder.edit("study.toml", "", &require("known", "unknown", "near@1", &limit));
    let outcome = judge(&folder, &["--pose", pose]);
    assert!(outcome.stdout.contains("regions: at none of the listed"), "{}", outcome.stdout);
    assert!(!outcome.stdout.contains("whatever the speed"), "{}", outcome.stdout);
    let table = rows(&folder.path("out").join("speeds.csv"));
    let found: Vec<_> =
        table.iter().map(|row| [row["verdict"].as_str(), row["fast_enough"].as_str()]).collect();
    assert_eq!(found, [["FAIL", "0"], ["FAIL", "0"], ["PASS", "0"]]);
}

/// Where nobody is so near, what nobody could miss decides nothing, and no speed is called fast enough by it; without
/// [stopping] nothing is said, and files of before are gone.
#[test]
fn without_people_or_without_distances_nothing_is_decided() {
    let folder = cell("");
    // Far from the robot, in the corner.
    for (scene, at) in [
        ("cell.toml", "position_m = [[0.1, -0.45, 0.65], [0.2, 0.0, 0.65]]"),
        ("second.toml", "position_m = [0.3, -0.4, 0.65]"),
    ] {
        let to = if scene == "cell.toml" {
            "position_m = [[-0.9, -0.5, 0.65], [-0.8, -0.5, 0.65]]"
        } else {
            "position_m = [-0.9, -0.5, 0.65]"
        };
        folder.edit(scene, at, to);
    }
    folder.edit("study.toml", "", &require("seen", "human_seen", "near@0.25", "at_least = 1"));
    swept(&folder);
    let outcome = judge(&folder, &["--pose", POSES[0]]);
    assert_eq!(outcome.code, Some(4), "a requirement without a value is missed: {}", outcome.stderr);
    let table = rows(&folder.path("out").join("speeds.csv"));
    assert_eq!(table[0]["verdict"], "not decided", "{table:?}");
    assert!(table.iter().all(|row| row["fast_enough"] == "0"), "{table:?}");
    assert!(outcome.stdout.contains("regions: at none of the listed"), "{}", outcome.stdout);
    assert!(
        outcome.stdout.contains("at 0.25 m/s not decided: seen (as planned) has no"),
        "{}",
        outcome.stdout
    );
    let written = |name: &str| folder.path("out").join(name).exists();
    assert!(written("speeds.csv") && written("separation.csv"));
    // The region stays what it was, in a sphere's place.
    folder.edit("study.toml", STOPPING, "");
    folder.edit("study.toml", "separation = {}", "sphere = { center_m = [0.2, 0.3, 0.4], radius_m = 0.5 }");
    folder.edit("study.toml", "near@0.25", "near");
    assert_eq!(folder.sweep(&["--restart"]).code, Some(0));
    let outcome = judge(&folder, &["--pose", POSES[0]]);
    assert!(matches!(outcome.code, Some(0 | 4)), "{}", outcome.stderr);
    assert!(
        !outcome.stdout.contains("how fast") && !outcome.stdout.contains("controller"),
        "{}",
        outcome.stdout
    );
    assert!(!written("speeds.csv") && !written("separation.csv"));
}

/// Requirements on what a controller measures are decided by what separation.csv has.
#[test]
fn what_is_required_of_a_controller_is_what_it_measures() {
    let under = "under = [\"as_planned\", \"one_sensor_dead\"]";
    let asked = |name: &str, score: &str, most: f64| {
        format!("\n[[require]]\nname = \"{name}\"\nscore = \"{score}\"\nat_most = {most}\n{under}\n")
    };
    let more = [asked("missed", "missed_m", 0.1), asked("needless", "needless_stops", 0.25)].concat();
    let folder = cell(&more);
    swept(&folder);
    let (mut passed, mut missed) = (0, 0);
    for pose in POSES {
        let outcome = judge(&folder, &["--pose", pose, "--junit", text(&folder.path("verdicts.xml"))]);
        assert!(matches!(outcome.code, Some(0 | 4)), "{}", outcome.stderr);
        let measured = rows(&folder.path("out/separation.csv"));
        let measured: Vec<_> = measured.iter().filter(|row| row["speed_m_s"] == "1").collect();
        let verdicts = rows(&folder.path("out/requirements.csv"));
        let of = |name: &str, condition: &str| {
            let own =
                |row: &&HashMap<String, String>| row["requirement"] == name && row["condition"] == condition;
            verdicts.iter().find(own).unwrap()
        };
        let too_far =
            measured.iter().filter(|row| !row["true_m"].is_empty()).map(|row| {
                match row["missed_m"].as_str() {
                    "" => f64::INFINITY,
                    metres => metres.parse().unwrap(),
                }
            });
        let worst = too_far.fold(0.0, f64::max);
        let row = of("missed", "as_planned");
        assert_eq!(row["value"].parse::<f64>().unwrap(), worst, "{pose}: {row:?}");
        let needless = measured.iter().filter(|row| row["unknown_occupied"] == "needless_stop").count();
        let share = needless as f64 / measured.len() as f64;
        let other = of("needless", "as_planned");
        assert_eq!(
            (other["value"].parse::<f64>().unwrap(), other["over"].as_str()),
            (share, "mean"),
            "{pose}: {other:?}"
        );
        for (row, is_met) in [(row, worst <= 0.1), (other, share <= 0.25)] {
            assert_eq!(row["verdict"], if is_met { "PASS" } else { "FAIL" }, "{pose}: {row:?}");
            passed += usize::from(is_met);
            missed += usize::from(!is_met);
        }
        // Of nobody anything is measured without a sensor, and everything may be somebody.
        let dead = of("missed", "one_sensor_dead");
        assert_eq!((dead["value"].as_str(), dead["verdict"].as_str()), ("inf", "FAIL"), "{dead:?}");
        assert!(
            outcome.stdout.contains("missed_m is infinite, since a person is present but not measured"),
            "{}",
            outcome.stdout
        );
        let far = |row: &&&HashMap<String, String>| {
            row["true_m"].is_empty() || row["true_m"].parse::<f64>().unwrap() >= 0.73
        };
        let far = measured.iter().filter(far).count() as f64 / measured.len() as f64;
        assert_eq!(of("needless", "one_sensor_dead")["value"].parse::<f64>().unwrap(), far, "{pose}");
        let junit = fs::read_to_string(folder.path("verdicts.xml")).unwrap();
        assert!(
            junit.contains("missed (as_planned)") && junit.contains("needless (one_sensor_dead)"),
            "{junit}"
        );
        let summed = rows(&folder.path("out/conditions.csv"));
        for score in ["missed_m", "needless_stops"] {
            assert_eq!(summed.iter().filter(|row| row["score"] == score).count(), 2, "{score}");
        }
    }
    assert!(passed > 0 && missed > 0, "{passed} met, {missed} missed");
}

/// Where there is no robot nothing is stopped needlessly, and nothing else either: a share of nothing is no value.
#[test]
fn without_a_robot_no_share_of_stops_is_met() {
    let folder = cell("\n[[require]]\nname = \"needless\"\nscore = \"needless_stops\"\nat_most = 1\n");
    folder.edit("study.toml", "[[region]]\nname = \"near\"\nseparation = {}\n", "");
    for scene in ["cell.toml", "second.toml"] {
        folder.edit(scene, "role = \"robot\"", "role = \"environment\"");
    }
    swept(&folder);
    let outcome = judge(&folder, &["--pose", POSES[0]]);
    assert_eq!(outcome.code, Some(4), "{}{}", outcome.stdout, outcome.stderr);
    let verdicts = rows(&folder.path("out/requirements.csv"));
    assert_eq!(
        (verdicts[0]["verdict"].as_str(), verdicts[0]["value"].as_str()),
        ("FAIL", ""),
        "{verdicts:?}"
    );
}

#[test]
fn what_cannot_be_required_of_a_controller_is_refused_by_name() {
    let wrong = |score: &str, more: &str, expected: &[&str]| {
        let asked = format!("\n[[require]]\nname = \"it\"\nscore = \"{score}\"\n{more}\n");
        refused(&cell(""), &[("study.toml", "", &asked)], expected);
    };
    wrong(
        "missed_m",
        "at_least = 1",
        &["require \"it\".at_least = 1: of missed_m the limit is given as at_most"],
    );
    wrong("missed_m", "at_most = 1\nover = \"mean\"", &["over = \"mean\": must be \"worst\""]);
    wrong(
        "needless_stops",
        "at_most = 0.5\nover = \"worst\"",
        &["over = \"worst\": must be \"mean\": it is a share"],
    );
    wrong("needless_stops", "at_most = 2", &["at_most = 2: must be a share of moments from 0 to 1"]);
    wrong(
        "needless_stops",
        "at_most = 0.5\nregion = \"robot\"",
        &["region = \"robot\": needless_stops is of all people"],
    );
    let asked = "\n[[require]]\nname = \"it\"\nscore = \"missed_m\"\nat_most = 1\n";
    let without = [
        ("study.toml", "[[region]]\nname = \"near\"\nseparation = {}\n", ""),
        ("study.toml", STOPPING, asked),
    ];
    refused(
        &cell(""),
        &without,
        &["score = \"missed_m\": needs to know how far people must be: add a table"],
    );
}
