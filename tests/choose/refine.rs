//! `refine = true` of `choose`: what is found between the listed poses is better, stands where its group may, and counts
//! as a sweep of a study that lists it, whatever casts.

use std::cell::Cell;
use std::collections::HashMap;
use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::faults::Devices;
use crate::common;
use crate::common::program::{Folder, Outcome, choose, perirobot, priced, rows, text};
use crate::common::watch::Onlooker;
use perirobot_decide::choose::{
    self, Casting, Chosen, FrontReport, MEMORY_BYTES, Refinement, problem_of, wanted_counts,
};
use perirobot_march::backend::Backend;
use perirobot_march::backend::cpu::Cpu;
use perirobot_march::backend::factory::{BackendFactory, Fallback};
use perirobot_march::progress::{Progress, SearchState};
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;

const STUDY: &str = "study.toml";

const CHOOSE: &str = r#"
[choose]
objective = "f1"
region = "robot"
at_most = 2
budget = 1000.0
apart_m = 0.1
require = [{ score = "f1", over = "worst", at_least = 0.01 }]
refine = true
"#;

fn folder() -> Folder {
    priced(CHOOSE)
}

#[track_caller]
fn chosen(folder: &Folder, out: &str, more: &[&str]) -> (Outcome, Chosen) {
    let outcome = choose(folder, out, more);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let chosen = Chosen::read(&folder.path(out)).unwrap().unwrap();
    (outcome, chosen)
}

/// The counts of a set in every region, snapshot and repeat, by the names of the columns that do not name it.
fn counts(folder: &Path, poses: &str) -> Vec<Vec<(String, String)>> {
    let named = ["combination", "poses"];
    let row = |row: HashMap<String, String>| {
        let mut row: Vec<_> =
            row.into_iter().filter(|(column, _)| !named.contains(&column.as_str())).collect();
        row.sort();
        row
    };
    rows(&folder.join("results.csv")).into_iter().filter(|found| found["poses"] == poses).map(row).collect()
}

/// Lists what was found in the study, as its page says, and sweeps its sets.
#[track_caller]
fn listed_and_swept(folder: &Folder, chosen: &Chosen) {
    folder.write("refined.csv", fs::read(folder.path("out/refined.csv")).unwrap());
    let listing = "[[sensor.poses]]\nname = \"refined\"\ncsv = \"refined.csv\"\n";
    folder.edit(STUDY, "[[sensor]]\nname = \"lidar\"", &format!("{listing}[[sensor]]\nname = \"lidar\""));
    let sets: Vec<_> = chosen.report.refined.iter().flatten().filter_map(|one| one.best.as_ref()).collect();
    assert!(!sets.is_empty());
    for set in &sets {
        let mut members: HashMap<&str, Vec<&str>> = HashMap::new();
        set.sensors.iter().for_each(|one| members.entry(&one.sensor).or_default().push(&one.pose));
        let of = |(sensor, poses): (&&str, &Vec<&str>)| format!("{sensor} = {poses:?}");
        let poses: Vec<String> = members.iter().map(of).collect();
        let count: Vec<String> =
            members.iter().map(|(name, all)| format!("{name} = {}", all.len())).collect();
        let mut sensors: Vec<&str> = members.keys().copied().collect();
        sensors.sort();
        let combination = format!(
            "[[combination]]\nname = \"set of {}\"\nsensors = {sensors:?}\nposes = {{ {} }}\ncount = {{ {} }}\n",
            set.sensors.len(),
            poses.join(", "),
            count.join(", ")
        );
        folder.edit(STUDY, "", &combination);
    }
    let swept = perirobot(&["sweep", text(&folder.path(STUDY)), "--out", text(&folder.path("swept"))]);
    assert_eq!(swept.code, Some(0), "{}", swept.stderr);
    let in_order = |name: &str| {
        let mut poses: Vec<&str> = name.split(';').collect();
        poses.sort();
        poses.join(";")
    };
    for set in sets {
        let name = set.poses.join(";");
        let swept = rows(&folder.path("swept/results.csv"));
        let same = swept.iter().find(|row| in_order(&row["poses"]) == in_order(&name)).expect("it was swept");
        let (here, there) =
            (counts(&folder.path("out"), &name), counts(&folder.path("swept"), &same["poses"]));
        assert!(!here.is_empty());
        assert_eq!(here, there, "{name}");
    }
}

#[test]
fn finer_poses_are_better_stay_on_their_wall_and_count_as_a_sweep_of_them() {
    let folder = folder();
    let (outcome, chosen) = chosen(&folder, "out", &[]);
    let refined = chosen.report.refined.as_ref().unwrap();
    assert_eq!(refined.len(), 2, "{refined:?}");
    assert!(refined.iter().any(|one| one.gain.is_some_and(|gain| gain > 0.0)), "{refined:?}");
    assert!(outcome.stdout.contains(" by finer poses, not proven"), "{}", outcome.stdout);
    for one in refined {
        let step = chosen.report.steps.iter().find(|step| step.at_most == one.at_most).unwrap();
        assert_eq!((step.best.score, &step.best.poses), (one.score_before, &one.around));
        assert!(step.proven, "what is certified stays certified");
        let Some(best) = &one.best else { continue };
        assert_eq!(one.gain, Some(best.score - one.score_before));
        for fine in &one.poses {
            let [x, y, z] = fine.position_m;
            match fine.near.split('/').next() {
                // Where the study has its lattice: x by steps, y and z as they are, pan and tilt between the two turns.
                Some("wall") => {
                    assert!((-1.0..=1.0).contains(&x) && y == -0.75 && z == 1.2, "{fine:?}");
                    assert!((70.0..=90.0).contains(&fine.pan_deg), "{fine:?}");
                    assert!((-30.0..=0.0).contains(&fine.tilt_deg), "{fine:?}");
                }
                Some("random") => {
                    let inside = x.abs() <= 0.9 && y.abs() <= 0.6 && (1.3..=1.5).contains(&z);
                    assert!(inside, "{fine:?}");
                }
                _ => panic!("{fine:?} is around a pose that is listed alone"),
            }
        }
    }
    let out = text(&folder.path("out")).to_string();
    for set in refined.iter().filter_map(|one| one.best.as_ref()) {
        let (poses, png) = (set.poses.join(";"), folder.path("set.png"));
        for command in [vec!["why"], vec!["render", "--size", "320x200", "--out", text(&png)]] {
            let outcome = perirobot(&[&command[..1], &[&out, "--pose", &poses], &command[1..]].concat());
            assert_eq!(outcome.code, Some(0), "{command:?}: {}", outcome.stderr);
        }
    }
    let report = perirobot(&["report", &out, "--best", "1"]);
    assert_eq!(report.code, Some(0), "{}", report.stderr);
    let page = fs::read_to_string(folder.path("out/report.html")).unwrap();
    assert!(page.contains("refined, at most 1: F1 "), "the page tells what was gained");
    listed_and_swept(&folder, &chosen);
    // A study that reads the poses is not refined over them.
    folder.edit(STUDY, "csv = \"refined.csv\"", "csv = \"out/refined.csv\"");
    let refused = choose(&folder, "out", &[]);
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    assert!(refused.stderr.contains("refined.csv: is a file of the study"), "{}", refused.stderr);
}

#[test]
fn with_noise_the_counts_are_those_of_a_sweep_too() {
    let folder = folder();
    folder.edit(STUDY, "near_ignore_m = 0.05", "near_ignore_m = 0.05\nnoise = { std_m = 0.02 }");
    folder.edit(STUDY, "seed = 7", "seed = 7\nrepeats = 2\nmixed_noise = true");
    let (_, chosen) = chosen(&folder, "out", &[]);
    let verify = perirobot(&["choose", "--verify", text(&folder.path("out")), "--backend", "cpu"]);
    assert_eq!(verify.code, Some(0), "{}", verify.stderr);
    listed_and_swept(&folder, &chosen);
}

#[test]
fn all_backends_write_the_same_bytes_however_many_threads() {
    let folder = folder();
    let files = ["front.csv", "choose.json", "refined.csv", "results.csv", "poses.csv"];
    let read = |out: &str| files.map(|file| fs::read_to_string(folder.path(out).join(file)).unwrap());
    let (first, _) = chosen(&folder, "oracle", &["--backend", "oracle"]);
    let expected = read("oracle");
    let mut others =
        vec![vec!["--backend", "cpu", "--threads", "1"], vec!["--backend", "cpu", "--threads", "2"]];
    others.extend(common::on_adapter().map(Vec::from));
    for (number, options) in others.iter().enumerate() {
        let out = format!("out{number}");
        let (outcome, _) = chosen(&folder, &out, options);
        assert_eq!(read(&out), expected, "{options:?}");
        assert_eq!(outcome.stdout.replace(&out, "oracle"), first.stdout, "{options:?}");
    }
}

/// The answer with something changed, as `--verify` takes it.
#[track_caller]
fn not_verified(folder: &Folder, change: impl Fn(&mut serde_json::Value), expected: &str) {
    let path = folder.path("out/choose.json");
    let written = fs::read_to_string(&path).unwrap();
    let mut answer = serde_json::from_str(&written).unwrap();
    change(&mut answer);
    fs::write(&path, answer.to_string()).unwrap();
    let outcome = perirobot(&["choose", "--verify", text(&folder.path("out")), "--backend", "cpu"]);
    fs::write(&path, written).unwrap();
    assert_eq!(outcome.code, Some(2), "{}{}", outcome.stdout, outcome.stderr);
    assert!(outcome.stderr.contains(expected), "no {expected:?} in {}", outcome.stderr);
    assert!(!outcome.stderr.contains("panicked"), "{}", outcome.stderr);
}

#[test]
fn what_was_refined_holds_until_it_is_altered() {
    let folder = folder();
    let (_, chosen) = chosen(&folder, "out", &[]);
    let refined = chosen.report.refined.unwrap();
    let at = refined.iter().position(|one| one.best.is_some()).unwrap();
    let verify = perirobot(&["choose", "--verify", text(&folder.path("out")), "--backend", "cpu"]);
    assert_eq!(verify.code, Some(0), "{}", verify.stderr);
    not_verified(&folder, |json| json["refined"][at]["poses"][0]["position_m"][0] = 0.123.into(), "refined[");
    not_verified(&folder, |json| json["refined"][at]["gain"] = 0.5.into(), "].gain: is not the difference");
    not_verified(
        &folder,
        |json| json["refined"][at]["around"][0] = "camera:wall/9/9".into(),
        "].around: is not the best set of a step",
    );
    not_verified(&folder, |json| json["refined"][at]["best"]["cost"] = 1.into(), "].best: costs ");
    not_verified(
        &folder,
        |json| json["refined"][at]["poses"][0]["near"] = "nowhere/1".into(),
        "is not near a pose of the study",
    );
    not_verified(
        &folder,
        |json| json["refined"][at]["poses"][0]["quaternion_wxyz"] = vec![0; 4].into(),
        "is not near a pose of the study",
    );
    not_verified(
        &folder,
        |json| json["refined"][at]["poses"][0]["position_m"][0] = 1e9.into(),
        "stretches the grid",
    );
    // Asked for otherwise, it is another answer.
    folder.edit(STUDY, "refine = true", "refine = false");
    let outcome = perirobot(&["choose", "--verify", text(&folder.path("out")), "--backend", "cpu"]);
    assert!(outcome.stderr.contains("asked: the study's question has changed"), "{}", outcome.stderr);
    let again = choose(&folder, "out", &[]);
    assert_eq!(again.code, Some(0), "{}", again.stderr);
    assert!(!folder.path("out/refined.csv").exists(), "what nobody asked for is gone");
}

/// Where the numbers, texts and truths of an answer are.
fn leaves(value: &serde_json::Value, at: &str) -> Vec<String> {
    let of = |(key, value): (String, &serde_json::Value)| leaves(value, &format!("{at}/{key}"));
    match value {
        serde_json::Value::Array(all) => {
            all.iter().enumerate().flat_map(|(number, value)| of((number.to_string(), value))).collect()
        }
        serde_json::Value::Object(all) => {
            all.iter().flat_map(|(key, value)| of((key.clone(), value))).collect()
        }
        serde_json::Value::Null => Vec::new(),
        _ => vec![at.to_string()],
    }
}

/// Another value of the same kind.
fn altered(value: &serde_json::Value) -> serde_json::Value {
    match value {
        serde_json::Value::Bool(is_so) => (!is_so).into(),
        serde_json::Value::String(text) => format!("{text}1").into(),
        number => match number.as_u64() {
            Some(count) => (count + 1).into(),
            None => (number.as_f64().unwrap() * 1.001 + 1e-6).into(),
        },
    }
}

/// Every value is made again and compared: altered, none passes. `every` skips values between those that are tried.
fn no_altered_value_passes(every: usize) {
    let folder = folder();
    let (outcome, _) = chosen(&folder, "out", &[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let path = folder.path("out/choose.json");
    let written = fs::read_to_string(&path).unwrap();
    let answer: serde_json::Value = serde_json::from_str(&written).unwrap();
    let all = leaves(&answer, "");
    assert!(all.len() > 100 && all.iter().any(|at| at.starts_with("/refined/")), "{}", all.len());
    let mut passed = Vec::new();
    for at in all.iter().step_by(every) {
        let mut changed = answer.clone();
        let value = changed.pointer_mut(at).unwrap();
        *value = altered(value);
        fs::write(&path, changed.to_string()).unwrap();
        let outcome = perirobot(&["choose", "--verify", text(&folder.path("out")), "--backend", "cpu"]);
        assert!(!outcome.stderr.contains("panicked"), "{at}: {}", outcome.stderr);
        match outcome.code {
            Some(2) => {}
            _ => passed.push(at),
        }
    }
    assert!(passed.is_empty(), "{} of {} values pass altered: {passed:?}", passed.len(), all.len());
}

#[test]
fn no_altered_value_of_a_sample_passes() {
    no_altered_value_passes(23);
}

#[test]
#[ignore = "minutes: the nightly run does it"]
fn no_altered_value_passes_at_all() {
    no_altered_value_passes(1);
}

#[test]
fn poses_that_are_listed_alone_stay() {
    let folder = folder();
    let wall = "x_m = { start = -1.0, stop = 1.0, step = 1.0 }";
    folder.edit(STUDY, wall, "x_m = [-1.0, 1.0]");
    folder.edit(STUDY, "{ pan = 0, tilt = 0 }, { pan = -20, tilt = -30 }", "{ pan = -20, tilt = -30 }");
    folder.edit(STUDY, "random = { count = 2,", "random = { count = 1,");
    let (outcome, chosen) = chosen(&folder, "out", &[]);
    assert!(outcome.stdout.contains("nothing gained by finer poses"), "{}", outcome.stdout);
    let refined = chosen.report.refined.unwrap();
    assert!(refined.iter().all(|one| one.best.is_none() && one.cast == 0), "{refined:?}");
    assert!(!folder.path("out/refined.csv").exists());
    folder.edit(STUDY, "refine = true", "refine = \"much\"");
    let refused = choose(&folder, "other", &[]);
    assert_eq!(refused.code, Some(2), "{}", refused.stderr);
    assert!(refused.stderr.contains("refine"), "{}", refused.stderr);
}

/// The CPU on one thread, and how often it was opened.
struct Cpus(Cell<usize>);

impl BackendFactory for Cpus {
    fn open(&mut self, _: Fallback) -> perirobot_march::Result<Box<dyn Backend + Send>> {
        self.0.set(self.0.get() + 1);
        Ok(Box::new(Cpu::new(Some(1))?))
    }

    fn needs_check(&self) -> bool {
        false
    }
}

/// Stops refining when it has gained so often.
struct Patience {
    gains: AtomicUsize,
    most: usize,
}

impl Progress for Patience {
    fn stop_reason(&self) -> Option<String> {
        (self.gains.load(Ordering::Relaxed) >= self.most).then(|| "enough".into())
    }

    fn show_search(&self, _: &SearchState) {
        self.gains.fetch_add(1, Ordering::Relaxed);
    }
}

/// Refines the best sets of the study, which the CPU casts, as often as is wanted.
fn refine_listed<T>(
    run: impl FnOnce(&dyn Fn(&mut dyn BackendFactory, &dyn Progress) -> Refinement) -> T,
) -> T {
    let folder = folder();
    let study = Study::load(&folder.path(STUDY), &Overrides::default()).unwrap();
    let (worlds, asked) =
        (World::prepare_all(&study).unwrap(), study.choose.as_ref().unwrap().best().unwrap());
    let ways = &asked.representations;
    let mut casting =
        Casting::begin(&study, &[wanted_counts(asked)], ways, &worlds, MEMORY_BYTES, None).unwrap();
    casting.run(&mut Cpu::new(Some(1)).unwrap(), &|| None).unwrap();
    let evidence = casting.evidence().remove(0);
    let problem = problem_of(&study, asked, &worlds, &evidence);
    let answer = choose::answer(&problem, &|| None).unwrap();
    let told = FrontReport::new(&study, &worlds, &problem, &answer);
    run(&|backends, progress| {
        let (asked, found) = ((&study, asked, &*worlds), (&problem, &answer, &told));
        choose::refine(asked, found, MEMORY_BYTES, backends, progress).unwrap()
    })
}

#[test]
fn a_stop_keeps_what_was_gained_until_then() {
    let patience = |most| Patience { gains: AtomicUsize::new(0), most };
    let mut cpus = Cpus(Cell::new(0));
    let [none, one, whole] =
        refine_listed(|refine| [0, 1, usize::MAX].map(|most| refine(&mut cpus, &patience(most))));
    let gained = |refinement: &Refinement| refinement.told.iter().filter_map(|one| one.gain).sum::<f64>();
    assert!(!none.complete && none.told.is_empty() && none.with_poses.is_none());
    assert!(!one.complete && gained(&one) > 0.0 && one.told.len() == 1, "{:?}", one.told);
    assert!(whole.complete && gained(&whole) > gained(&one), "{:?}", whole.told);
}

#[test]
fn failures_of_a_device_are_counted_over_all_rounds() {
    // The device fails in full batches. One small batch casts all that is around a set: a round has one failure.
    let (mut devices, watch) = (Devices { full: 0, small: usize::MAX, lie: false }, Onlooker::default());
    let [expected, found] = refine_listed(|refine| {
        [refine(&mut Cpus(Cell::new(0)), &|| None), refine(&mut devices, &watch)].map(|refined| refined.told)
    });
    assert_eq!(found, expected);
    let rounds: usize = found.iter().map(|one| one.rounds).sum();
    assert!(rounds > 3, "{rounds}");
    let instead: Vec<String> = watch.heard().faults.into_iter().map(|fault| fault.instead).collect();
    let small = "the same device in small batches";
    let given_up = format!("{small}, and from then on the CPU");
    assert_eq!(instead, [small, small, &given_up], "in {rounds} rounds");
}

/// Of the best sets by a score, and of those that refining finds, no two sensors disturb each other.
#[test]
fn no_two_sensors_of_the_best_sets_disturb_each_other() {
    let folder = folder();
    folder.edit(STUDY, "name = \"camera\"", "name = \"camera\"\nemits = \"tof\"");
    let (_, free) = chosen(&folder, "out", &[]);
    let verify = || {
        let (study, out) = (folder.path(STUDY), folder.path("out"));
        perirobot(&["choose", text(&study), "--verify", text(&out), "--progress", "none"])
    };
    let disturb = "disturb = { overlap = 0.1 }";
    folder.edit(STUDY, "apart_m = 0.1", &format!("apart_m = 0.1\n{disturb}"));
    // An answer to the question without it is not one to the question with it.
    assert_eq!(verify().code, Some(2));
    let proof = folder.path("out").join("choose.json");
    let mut json: serde_json::Value = serde_json::from_str(&fs::read_to_string(&proof).unwrap()).unwrap();
    json["asked"]["disturb"] = serde_json::json!({ "overlap": 0.1 });
    fs::write(&proof, json.to_string()).unwrap();
    let refused = verify();
    assert_eq!(refused.code, Some(2), "{}", refused.stdout);
    assert!(refused.stderr.contains("steps[1].best: has camera:"), "{}", refused.stderr);
    assert!(refused.stderr.contains("which disturb each other"), "{}", refused.stderr);
    let (said, kept) = chosen(&folder, "out", &[]);
    assert!(said.stdout.contains("sees more than 0.1 of what another sees"), "{}", said.stdout);
    let score = |chosen: &Chosen| chosen.report.best().unwrap().best.score;
    assert!(score(&kept) < score(&free), "{} and {}", score(&kept), score(&free));
    assert!(
        kept.report.refined.iter().flatten().any(|refined| refined.best.is_some()),
        "nothing was refined"
    );
    let holds = verify();
    assert_eq!(holds.code, Some(0), "{}", holds.stderr);
}
