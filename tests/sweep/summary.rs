//! From a sweep to its folder and back: the results read are those that were written, the tables are printed
//! from them, and a folder that is not whole is refused.

use std::fs;

use crate::common::program::{Folder, names, perirobot, text};
use crate::common::watch::Onlooker;
use perirobot_march::backend::factory::{BackendFactory, Fallback};
use perirobot_march::backend::{Backend, cpu::Cpu};
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;
use perirobot_sweep::results::journal::{Journal, JournalHeader, Locked, Shard};
use perirobot_sweep::results::manifest::Manifest;
use perirobot_sweep::results::table::TableFormat;
use perirobot_sweep::results::{Results, Subject, scores};
use perirobot_sweep::scoring::run;
use perirobot_sweep::scoring::session::Session;

/// The files of a finished sweep.
const FILES: [&str; 5] = ["counts.journal", "manifest.json", "poses.csv", "results.csv", "scores.csv"];

/// What is appended to the small study: a sensor without poses, representations to choose from, a combination
/// of two posed sensors and one in which a single one is posed.
const MORE: &str = r#"
[[sensor]]
name = "cover"
kind = "cover"
inflation_m = [0.1, 0.2]
noise = { std_m = 0.02 }
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
    let folder = Folder::noisy();
    folder.edit("study.toml", "", MORE);
    folder
}

/// Sweeps on the CPU.
struct OnCpu;

impl BackendFactory for OnCpu {
    fn open(&mut self, _: Fallback) -> perirobot_march::Result<Box<dyn Backend + Send>> {
        Ok(Box::new(Cpu::new(None)?))
    }

    fn needs_check(&self) -> bool {
        false
    }
}

#[test]
fn results_read_back_are_those_of_the_sweep() {
    let folder = rich();
    // The first scene at two moments: what stands still differs by its noise.
    let twice = "snapshots = { position_m = [[0.1, -0.45, 0.65], [0.1, -0.45, 0.65]] }";
    folder.edit("cell.toml", "position_m = [0.1, -0.45, 0.65]", twice);
    let study = Study::load(&folder.path("study.toml"), &Overrides::default()).unwrap();
    let worlds = World::prepare_all(&study).unwrap();
    let rows = run(&study, &worlds, &mut Cpu::new(None).unwrap()).unwrap();
    let out = folder.path("out");
    let mut session =
        Session::open(&study, &worlds, &out, Shard::WHOLE, false, &["perirobot".into()]).unwrap();
    session.run(&mut OnCpu, 0, 0.0, &Onlooker::default()).unwrap();
    let results = Results::new(Subject::from_study(&study, &worlds), session.into_pages());
    assert_eq!(results.scenes.iter().map(|scene| scene.moments.clone()).collect::<Vec<_>>(), [0..2, 2..3]);

    let read = |results: Results| {
        for row in &rows {
            let moment = results.scenes[row.scene].moments.start + row.snapshot;
            let key = perirobot_sweep::results::RowKey {
                combination: row.combination,
                choice: row.choice,
                representation: row.representation,
                region: row.region,
            };
            assert_eq!(results.counts(moment, row.repeat, &key).unwrap(), row.counts, "{row:?}");
        }
        results.subject
    };
    // Every row of the sweep is found under its own name, before and after.
    let subject = read(results);
    let (again, warnings) = Results::read(&out).unwrap();
    assert_eq!(read(again), subject);
    assert_eq!(warnings, [""; 0]);
    let placed = |combination: usize| {
        let combination = &subject.combinations[combination];
        (0..combination.choices()).all(|choice| combination.group_of(choice).is_some())
    };
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
    fs::create_dir(folder.path("again")).unwrap();
    scores::write(&results, &folder.path("again"), TableFormat::Csv).unwrap();
    assert!(fs::read(folder.path("again/scores.csv")).unwrap() == written);
    assert_eq!(names(&out), FILES);
    let header = String::from_utf8(written).unwrap();
    assert!(header.contains("\n*,skin,lidar:posts/corner;cover:"), "{header}");
    // Nine blocks would flood the screen.
    drop(results);
    let all = folder.sweep(&["--all"]).stdout;
    for shown in ["Region human: the best choice of poses, 2 scenes, 2 repeats", "best F1", "  skin "] {
        assert!(all.contains(shown), "no {shown:?} in {all}");
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
    assert!(one.stdout.contains("Only the near side of a body can be hit"), "{}", one.stdout);
    let arguments = ["--region", "human", "--combination", "camera", "--score", "human_claimed"];
    let claimed = perirobot(&[&["summary", text(&out)], &arguments[..]].concat());
    let order =
        ["human_claimed in region human", "false_alarm in region human"].map(|t| claimed.stdout.find(t));
    assert!(order[0].is_some() && order[0] < order[1], "{}", claimed.stdout);
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
        outcome
            .stdout
            .contains("random                 0.605  *  random/3  ceiling, x -0.32 m, y 0.35 m, 1.48 m high"),
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
    for (edit, expected) in [
        (("poses.csv", "x_m", "x"), &["line 1", "no column \"x_m\""][..]),
        (("poses.csv", ",place", ",where"), &["line 1", "no column \"place\""]),
        (("poses.csv", "wall/0/1", "wall/0/0"), &["line 3, column pose: \"wall/0/0\" occurs twice"]),
        (
            ("poses.csv", "wall/0/0,wall,-1,", "wall/0/0,wall,-1.5,"),
            &["differs from the table of manifest.json"],
        ),
        (
            ("manifest.json", "\"name\": \"cover\"", "\"name\": \"coat\""),
            &["column sensor: \"cover\" must be \"coat\""],
        ),
        (
            ("poses.csv", "camera,random/1", "lidar,random/1"),
            &["line 9, column sensor: \"lidar\" must be \"camera\""],
        ),
        (
            ("poses.csv", "", "camera,wall/9,wall,0,0,0,1,0,0,0,,,wall\n"),
            &["a row beyond those of manifest.json"],
        ),
        (
            ("manifest.json", "\"repeats\": 2", "\"repeats\": 3"),
            &["counts.journal", "another sweep than manifest.json"],
        ),
        (
            ("manifest.json", "\"seed\": 7", "\"seed\": 8"),
            &["counts.journal", "another sweep than manifest.json"],
        ),
        (
            ("manifest.json", "\"repeats\": 2", "\"repeats\": 0"),
            &["has an impossible number of rows: 0 (repeats = 0)"],
        ),
        (("manifest.json", "\"repeats\": 2", "\"repeats\": 20000000000"), &["(repeats = 20000000000)"]),
        (("manifest.json", "\"repeats\"", "\"repetitions\""), &["missing field `repeats`"]),
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
        (
            "nowhere",
            None,
            "nowhere: is not a folder: name one written by `perirobot sweep` or `perirobot choose`",
        ),
        ("study.toml", None, "study.toml: is not a folder"),
        ("out", Some("counts.journal"), "counts.journal: cannot be read"),
        ("out", Some("poses.csv"), "poses.csv: cannot be read"),
        ("out", Some("manifest.json"), "manifest.json: does not exist"),
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
    let version = format!("\"semantics_version\": {}", perirobot_march::SEMANTICS_VERSION);
    folder.edit("out/manifest.json", &version, "\"semantics_version\": 999");
    // A sweep by those rules would have had their fingerprint from the beginning.
    let out = folder.path("out");
    let old = Journal::read(&out).unwrap();
    let rows: Vec<_> = (0..old.header().blocks).map(|block| old.header().rows_of_block(block)).collect();
    let counts: Vec<_> = rows.iter().map(|rows| old.counts(rows.clone()).unwrap()).collect();
    let fingerprint = Manifest::read(&out).unwrap().fingerprint();
    let header = JournalHeader { fingerprint, ..old.header().clone() };
    drop(old);
    let mut journal = Locked::open(&out).unwrap().begin(header).unwrap();
    rows.iter().zip(&counts).for_each(|(rows, counts)| journal.put(rows.start, counts).unwrap());
    drop(journal);
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
