//! From a sweep to its folder and back: the results read are those that were written, the tables are printed from them,
//! and a folder that is not whole is refused.

#[allow(dead_code)]
#[path = "common/program.rs"]
mod program;

use std::fs;

use perirobot::backend::cpu::Cpu;
use perirobot::report::{Results, scores};
use perirobot::study::{Overrides, Study};
use perirobot::sweep::files::RESULT_FILES;
use perirobot::sweep::manifest::{Timings, manifest};
use perirobot::sweep::{World, run, table};
use program::{Folder, names, perirobot, text};

/// What is appended to the small study: a sensor without poses, representations to choose from, a combination of two
/// posed sensors and one in which a single one is posed.
const MORE: &str = r#"
[[sensor]]
name = "cover"
kind = "cover"
inflation_m = [0.1, 0.2]
noise_std_m = 0.02
[[combination]]
sensors = ["camera"]
[[combination]]
name = "both"
sensors = ["camera", "lidar"]
poses = { camera = ["wall/0/*"], lidar = ["posts/up*"] }
[[combination]]
name = "skin"
sensors = ["lidar", "cover"]
"#;

/// The small study with noise, repeats, a second scene, representations and combinations.
fn rich() -> Folder {
    let folder = Folder::new();
    folder.write("second.toml", fs::read(folder.path("cell.toml")).unwrap());
    folder.edit("second.toml", "position_m = [0.1, -0.45, 0.65]", "position_m = [0.3, -0.4, 0.65]");
    folder.edit("study.toml", "seed = 7", "seed = 7\nrepeats = 2");
    folder.edit("study.toml", "[[region]]", "[[scene]]\nfile = \"second.toml\"\n[[region]]");
    folder.edit("study.toml", "range_m = [0.1, 5.0]", "range_m = [0.1, 5.0]\nnoise_std_m = 0.1");
    folder.edit("study.toml", "", MORE);
    folder
}

#[test]
fn results_read_back_are_those_of_the_sweep() {
    let folder = rich();
    let mut study = Study::load(&folder.path("study.toml"), &Overrides::default()).unwrap();
    // The first scene at two moments: what stands still differs by its noise.
    let mut worlds = World::prepare(&study, 0).unwrap();
    worlds.extend(World::prepare(&study, 0).unwrap().into_iter().map(|world| World { snapshot: 1, ..world }));
    worlds.extend(World::prepare(&study, 1).unwrap());
    study.scenes[0].snapshots = 2;
    let mut cpu = Cpu::new(None).unwrap();
    let rows = run(&study, &worlds, &mut cpu, |_| ()).unwrap();
    let results = Results::of_sweep(&study, &worlds, &rows);
    assert_eq!(results.scenes.iter().map(|scene| scene.moments.clone()).collect::<Vec<_>>(), [0..2, 2..3]);

    let timings = Timings { prepare_s: 0.0, sweep_s: 1.0 };
    let files = [
        table::poses_csv(&study),
        table::results_csv(&study, &rows),
        manifest(&study, &worlds, &cpu, timings),
    ];
    fs::create_dir(folder.path("out")).unwrap();
    for (name, bytes) in ["poses.csv", "results.csv", "manifest.json"].into_iter().zip(files) {
        folder.write(&format!("out/{name}"), bytes);
    }
    let (read, warnings) = Results::read(&folder.path("out")).unwrap();
    assert!(read == results, "{read:?}\n{results:?}");
    assert_eq!(warnings, [""; 0]);

    // Every row of the sweep is found under its own name.
    for row in &rows {
        let moment = read.scenes[row.scene].moments.start + row.snapshot;
        let key = perirobot::report::Key {
            combination: row.combination,
            choice: row.choice,
            representation: row.interpretation,
            region: row.region,
        };
        assert_eq!(read.counts(moment, row.repeat, &key), &row.counts, "{row:?}");
    }
    let placed =
        |combination: usize| read.combinations[combination].choices.iter().all(|c| c.place.is_some());
    assert_eq!([placed(0), placed(1), placed(2)], [true, false, true]);
}

#[test]
fn scores_csv_is_the_same_from_the_sweep_and_from_its_folder() {
    let folder = rich();
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let out = folder.path("out");
    let written = fs::read(out.join("scores.csv")).unwrap();
    let (results, _) = Results::read(&out).unwrap();
    assert!(scores::render(&results) == written);
    let mut expected = RESULT_FILES.map(String::from);
    expected.sort();
    assert_eq!(names(&out), expected);
    let header = String::from_utf8(written).unwrap();
    assert!(header.contains("\n*,skin,lidar:posts/corner;cover:"), "{header}");
    // Nine blocks would flood the screen.
    for shown in ["Region human: the best choice of poses, 2 scenes, 2 repeats", "best F1", "  skin "] {
        assert!(outcome.stdout.contains(shown), "no {shown:?} in {}", outcome.stdout);
    }
}

#[test]
fn the_summary_has_the_tables_that_apply() {
    let folder = rich();
    folder.sweep(&[]);
    let out = folder.path("out");
    let outcome = perirobot(&["summary", text(&out)]);
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "{}", outcome.stdout);
    for shown in
        ["DISTRIBUTION", "MAXIMA", "BEST POSE OF EACH GROUP", "F1 in region box", "kappa in region human"]
    {
        assert!(outcome.stdout.contains(shown), "no {shown:?} in {}", outcome.stdout);
    }
    for not in ["SNAPSHOTS", "human_seen in region", "Relative"] {
        assert!(!outcome.stdout.contains(not), "{not:?} in {}", outcome.stdout);
    }
    let arguments = ["--region", "human", "--combination", "camera", "--score", "human_seen"];
    let one = perirobot(&[&["summary", text(&out)], &arguments[..]].concat());
    assert!(one.stdout.contains("human_seen in region human"), "{}", one.stdout);
    for not in ["F1 in", "region box", "skin", "both"] {
        assert!(!one.stdout.contains(not), "{not:?} in {}", one.stdout);
    }
}

#[test]
fn the_shipped_tiny_study_has_a_summary() {
    let folder = Folder::new();
    let out = folder.path("out");
    perirobot(&["sweep", "scenes/tiny.toml", "--backend", "cpu", "--out", text(&out)]);
    let outcome = perirobot(&["summary", text(&out)]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    assert!(
        outcome.stdout.contains("random                 0.605  *  random/3 (-0.32, 0.35, 1.48)"),
        "{}",
        outcome.stdout
    );
}

/// The folder with one edit must be refused in words that hold all of `expected`.
#[track_caller]
fn refused(folder: &Folder, (file, from, to): (&str, &str, &str), expected: &[&str]) {
    let path = format!("out/{file}");
    let before = fs::read(folder.path(&path)).unwrap();
    folder.edit(&path, from, to);
    let outcome = perirobot(&["summary", text(&folder.path("out"))]);
    let what = format!("{file}: {from:?} to {to:?}: {:?}\n{}", outcome.code, outcome.stderr);
    assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(2), ""), "{what}");
    for fragment in expected.iter().chain(&["error: ", "sweep again"]) {
        assert!(outcome.stderr.contains(fragment), "no {fragment:?} in {what}");
    }
    assert!(!outcome.stderr.contains("panicked"), "{what}");
    folder.write(&path, before);
}

#[test]
fn files_that_do_not_fit_together_are_refused() {
    let folder = rich();
    folder.sweep(&[]);
    let results = fs::read_to_string(folder.path("out/results.csv")).unwrap();
    let line = |number: usize| results.lines().nth(number - 1).unwrap();
    let lines = |numbers: [usize; 2]| format!("{}\n", numbers.map(line).join("\n"));
    let tp = line(3).split(',').nth(7).unwrap();
    let with_tp = |tp: &str| line(3).split(',').take(7).chain([tp]).collect::<Vec<_>>().join(",");
    let (last, cut) = (results.lines().count(), results.lines().last().unwrap());
    for (edit, expected) in [
        (("results.csv", ",uf,", ",up,"), &["line 1", "no column \"uf\""][..]),
        (
            ("results.csv", "cell,0,0,camera", "Cell,0,0,camera"),
            &["line 2, column scene: \"Cell\" must be \"cell\""],
        ),
        (
            ("results.csv", &with_tp(tp), &with_tp("many")),
            &["line 3, column tp: \"many\" must be a number of voxels"],
        ),
        (("results.csv", &with_tp(tp), &with_tp("-1")), &["line 3, column tp: \"-1\""]),
        (("results.csv", &with_tp(tp), &with_tp("18446744073709551615")), &["line 3, column tp"]),
        (
            ("results.csv", &with_tp(tp), &with_tp(&format!("{tp}1"))),
            &["line 3, column tp", "the region has"],
        ),
        (("results.csv", &lines([3, 4]), &lines([4, 3])), &["line 3, column region", "order of the sweep"]),
        (("results.csv", "camera:wall/0/0", "camera:wall/0/9"), &["line 2, column poses", "poses.csv lacks"]),
        (("results.csv", cut, ""), &[&*format!("ends after line {}", last - 1), "promises more rows"]),
        (("results.csv", cut, &cut[..30]), &[&*format!("line {last}: has 5 fields, the header 24")]),
        (("results.csv", "", cut), &[&*format!("line {}, column scene", last + 1), "a row more"]),
        (("poses.csv", "x_m", "x"), &["line 1", "no column \"x_m\""]),
        (
            ("poses.csv", "wall/0/0,wall,-1,", "wall/0/0,wall,west,"),
            &["line 2, column x_m: \"west\" must be"],
        ),
        (("poses.csv", "wall/0/0,wall,-1,", "wall/0/0,wall,NaN,"), &["line 2, column x_m: \"NaN\" must be"]),
        (("poses.csv", "wall/0/1", "wall/0/0"), &["line 3, column pose: \"wall/0/0\" stands twice"]),
        (("manifest.json", "\"name\": \"cover\"", "\"name\": \"coat\""), &["a sensor \"cover\" that is not"]),
        (
            ("manifest.json", "\"repeats\": 2", "\"repeats\": 3"),
            &["column scene: \"second\" must be \"cell\""],
        ),
        (("manifest.json", "\"repeats\": 2", "\"repeats\": 0"), &["repeats = 0"]),
        (("manifest.json", "\"repeats\": 2", "\"repeats\": 20000000000"), &["repeats = 20000000000"]),
        (("manifest.json", "\"repeats\"", "\"repetitions\""), &["missing field `repeats`", "line"]),
        (("manifest.json", "\"snapshot\": 0", "\"snapshot\": 1"), &["snapshot 1 is alone"]),
        (("manifest.json", "{", ""), &["line 2 column"]),
    ] {
        refused(&folder, edit, expected);
    }
}

#[test]
fn folders_without_results_are_refused() {
    let folder = rich();
    folder.sweep(&[]);
    for (path, remove, expected) in [
        ("nowhere", None, "nowhere: is not a folder: name one that `perirobot sweep --out` has written"),
        ("study.toml", None, "study.toml: is not a folder"),
        ("out", Some("poses.csv"), "poses.csv: cannot be read"),
        ("out", Some("results.csv"), "poses.csv: cannot be read"),
        ("out", Some("manifest.json"), "manifest.json: cannot be read"),
    ] {
        if let Some(name) = remove {
            fs::remove_file(folder.path("out").join(name)).unwrap();
        }
        let outcome = perirobot(&["summary", text(&folder.path(path))]);
        assert_eq!(outcome.code, Some(2), "{path} without {remove:?}: {}", outcome.stderr);
        assert!(outcome.stderr.contains(expected), "{}", outcome.stderr);
    }
}

#[test]
fn results_of_other_rules_come_with_a_warning() {
    let folder = rich();
    folder.sweep(&[]);
    let version = format!("\"semantics_version\": {}", perirobot::SEMANTICS_VERSION);
    folder.edit("out/manifest.json", &version, "\"semantics_version\": 999");
    let outcome = perirobot(&["summary", text(&folder.path("out"))]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    for shown in ["warning: ", "manifest.json", "version 999 of the rules", "sweep again"] {
        assert!(outcome.stderr.contains(shown), "no {shown:?} in {}", outcome.stderr);
    }
    assert!(outcome.stdout.contains("DISTRIBUTION"), "{}", outcome.stdout);
}

#[test]
fn names_that_are_not_there_are_refused() {
    let folder = rich();
    folder.sweep(&[]);
    for (option, known) in
        [("--region", "\"robot\", \"box\", \"human\""), ("--combination", "\"camera\", \"both\", \"skin\"")]
    {
        let outcome = perirobot(&["summary", text(&folder.path("out")), option, "none"]);
        assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(2), ""), "{}", outcome.stderr);
        assert!(
            outcome.stderr.contains(&format!("{option} none: must be one of those of the sweep: [{known}]"))
        );
    }
    let outcome = perirobot(&["summary", text(&folder.path("out")), "--score", "f2"]);
    assert_eq!(outcome.code, Some(2));
    assert!(outcome.stderr.contains("human_seen"), "{}", outcome.stderr);
}
