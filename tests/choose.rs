//! The best set of sensors: its evidence is a sweep's, its answer is that of trying every set, and what
//! cannot be chosen is refused.

mod common;
#[allow(dead_code)]
#[path = "common/program.rs"]
mod program;

use std::fs;
use std::path::Path;

use common::Random;
use perirobot::Result;
use perirobot::backend::gpu::Gpu;
use perirobot::backend::{Backend, Fusion, cpu::Cpu, oracle::Oracle};
use perirobot::choose::{Answer, CandidateEvidence, CastingWatch, MEMORY_BYTES, Problem, answer};
use perirobot::metrics::{Confusion, Score};
use perirobot::study::{Across, Choose, Combination, Member, Overrides, Study};
use perirobot::sweep::run;
use perirobot::world::World;
use program::{Edit, Folder, Outcome, perirobot, refused, text};

/// Nobody looks, and nobody stops it.
struct Alone;

impl CastingWatch for Alone {
    fn cast(&mut self, _: u64) {}

    fn stop(&mut self) -> Option<String> {
        None
    }
}

fn shipped(name: &str) -> (Study, Vec<World>) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(name);
    let study = Study::load(&path, &Overrides::default()).unwrap();
    let worlds = World::prepare_all(&study).unwrap();
    (study, worlds)
}

fn cast(
    study: &Study,
    worlds: &[World],
    of: (usize, &[usize]),
    backend: &mut dyn Backend,
) -> CandidateEvidence {
    CandidateEvidence::cast(study, worlds, of, MEMORY_BYTES, backend, &mut Alone).unwrap()
}

/// Sensor and candidate of every row of evidence.
fn items(study: &Study) -> Vec<[usize; 2]> {
    let sensors = study.sensors.iter().enumerate();
    sensors.flat_map(|(sensor, spec)| (0..spec.candidates.len()).map(move |c| [sensor, c])).collect()
}

/// What a sweep counts for some sets, each with its counts in a region: repeat by repeat, and in each world
/// by world.
fn swept(
    study: &Study,
    worlds: &[World],
    (region, ways): (usize, &[usize]),
    sets: &[Vec<usize>],
    backend: &mut dyn Backend,
) -> Vec<Vec<Confusion>> {
    let items = items(study);
    let combination = |(number, set): (usize, &Vec<usize>)| Combination {
        name: number.to_string(),
        fusion: Fusion::OccupiedWins,
        members: set
            .iter()
            .map(|&item| Member { sensor: items[item][0], candidates: vec![items[item][1]] })
            .collect(),
    };
    let combinations = sets.iter().enumerate().map(combination).collect();
    let study = Study { combinations, ..study.clone() };
    let mut found = vec![Vec::new(); sets.len()];
    let mut rows = run(&study, worlds, backend).unwrap();
    rows.sort_by_key(|row| row.repeat);
    for row in rows {
        let combination = &study.combinations[row.combination];
        let wanted: Vec<usize> = combination.members.iter().map(|member| ways[member.sensor]).collect();
        let said = &combination.representations(&study.sensors)[row.representation];
        if row.region == region && *said == wanted {
            found[row.combination].push(row.counts);
        }
    }
    found
}

fn random_sets(random: &mut Random, of: usize, count: usize) -> Vec<Vec<usize>> {
    let one = |_| {
        let mut set: Vec<usize> =
            (0..1 + random.below(4)).map(|_| random.below(of as u32) as usize).collect();
        set.sort_unstable();
        set.dedup();
        set
    };
    (0..count).map(one).collect()
}

#[test]
fn unions_of_evidence_are_what_a_sweep_counts_on_every_backend() {
    let mut random = Random(1);
    let mut all = Confusion::default();
    for name in ["scenes/tiny.toml", "scenes/sensors.toml"] {
        let (study, worlds) = shipped(name);
        for region in 0..study.regions.len() {
            let way = |sensor: &perirobot::sensor::Sensor| {
                random.below(sensor.kind.representations().len() as u32) as usize
            };
            let ways: Vec<usize> = study.sensors.iter().map(way).collect();
            let of = (region, ways.as_slice());
            let sets = random_sets(&mut random, items(&study).len(), 25);
            let expected = swept(&study, &worlds, of, &sets, &mut Cpu::new(Some(2)).unwrap());
            assert!(expected.iter().all(|counts| counts.len() == worlds.len() * study.repeats as usize));
            all = expected.iter().flatten().fold(all, |all, counts| all.plus(counts));
            let mut backends: Vec<Box<dyn Backend>> =
                vec![Box::new(Oracle::default()), Box::new(Cpu::new(Some(1)).unwrap())];
            if let Some(adapter) = common::adapter() {
                backends.push(Box::new(Gpu::new(&adapter).unwrap()));
            }
            for mut backend in backends {
                let evidence = cast(&study, &worlds, of, backend.as_mut());
                assert_eq!(evidence.count(), items(&study).len());
                for (set, expected) in sets.iter().zip(&expected) {
                    assert_eq!(evidence.counts(set), *expected, "{name}, {}, {set:?}", backend.name());
                }
            }
        }
    }
    let told = [&all.counts()[..], &all.detection.counts()].concat();
    assert!(told.iter().all(|&count| count > 0), "every counter has something: {told:?}");
}

#[test]
fn evidence_that_does_not_fit_is_refused_before_anything_is_cast() {
    /// A backend that must not be asked.
    struct Progressless;
    impl CastingWatch for Progressless {
        fn cast(&mut self, _: u64) {
            panic!("cast");
        }
        fn stop(&mut self) -> Option<String> {
            panic!("asked whether to stop");
        }
    }
    let (study, worlds) = shipped("scenes/tiny.toml");
    let ways = vec![0; study.sensors.len()];
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let refused: Result<CandidateEvidence> =
        CandidateEvidence::cast(&study, &worlds, (0, &ways), 1000, &mut cpu, &mut Progressless);
    let told = refused.unwrap_err().to_string();
    assert!(told.contains("13 poses in 1 scenes, snapshots and repeats takes 1 MiB"), "{told}");
}

/// What a study would ask for that asks for the best single sensor.
fn one(study: &Study, objective: Score, over: Across, region: usize, ways: Vec<usize>) -> Choose {
    assert_eq!(ways.len(), study.sensors.len());
    Choose {
        objective,
        over,
        region,
        at_most: 1,
        budget: None,
        apart_m: 0.0,
        always: Vec::new(),
        require: Vec::new(),
        ways,
    }
}

#[test]
fn the_best_single_sensor_is_the_best_of_the_sweep() {
    let mut cpu = Cpu::new(Some(2)).unwrap();
    let mut compared = 0;
    for name in ["scenes/tiny.toml", "scenes/sensors.toml"] {
        let (study, worlds) = shipped(name);
        let all: Vec<Vec<usize>> = (0..items(&study).len()).map(|item| vec![item]).collect();
        let most = study.sensors.iter().map(|sensor| sensor.kind.representations().len()).max().unwrap();
        for region in 0..study.regions.len() {
            for way in 0..most {
                let last = |sensor: &perirobot::sensor::Sensor| sensor.kind.representations().len() - 1;
                let ways: Vec<usize> = study.sensors.iter().map(|sensor| way.min(last(sensor))).collect();
                let evidence = cast(&study, &worlds, (region, &ways), &mut cpu);
                let counts = swept(&study, &worlds, (region, &ways), &all, &mut cpu);
                for score in [Score::F1, Score::Kappa, Score::HumanSeen, Score::PartsDetected] {
                    for over in [Across::Pooled, Across::Worst, Across::Mean] {
                        let choose = one(&study, score, over, region, ways.clone());
                        let problem = Problem::new(&study, &choose, &worlds, &evidence).unwrap();
                        let values = counts.iter().filter_map(|counts| value(counts, score, over));
                        let expected = values.reduce(f64::max);
                        let found = answer(&problem, &|| false).ok();
                        let best = found.as_ref().and_then(best).map(|(_, value)| value);
                        assert_eq!(best, expected, "{name}, region {region}, way {way}, {score:?} {over:?}");
                        compared += usize::from(expected.is_some());
                    }
                }
            }
        }
    }
    assert!(compared > 50, "{compared}");
}

/// The best set of the largest size, and what it is worth.
fn best(answer: &Answer) -> Option<(Vec<usize>, f64)> {
    let best = answer.steps.last()?.best.as_ref()?;
    Some((best.set.clone(), best.worth.value()))
}

/// A score of several moments, in the plain way.
fn value(counts: &[Confusion], score: Score, over: Across) -> Option<f64> {
    let values: Vec<f64> = counts.iter().filter_map(|counts| score.of(counts)).collect();
    match over {
        Across::Pooled => score.of(&counts.iter().fold(Confusion::default(), |all, one| all.plus(one))),
        Across::Worst => values.into_iter().reduce(f64::min),
        Across::Mean if values.is_empty() => None,
        Across::Mean => Some(values.iter().sum::<f64>() / values.len() as f64),
    }
}

const STUDY: &str = "study.toml";

const CHOOSE: &str = r#"
[choose]
objective = "f1"
region = "robot"
at_most = 3
budget = 1000.0
apart_m = 0.1
"#;

/// The small study with costs, and what is looked for.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.edit(STUDY, "name = \"camera\"", "name = \"camera\"\ncost = 250.0");
    folder.edit(STUDY, "name = \"lidar\"", "name = \"lidar\"\ncost = 499.5\nat_most = 1");
    folder.edit(STUDY, "", CHOOSE);
    folder
}

fn choose(folder: &Folder, out: &str, more: &[&str]) -> Outcome {
    let (study, out) = (folder.path(STUDY), folder.path(out));
    perirobot(&[&["choose", text(&study), "--out", text(&out), "--progress", "none"], more].concat())
}

#[test]
fn all_backends_write_the_same_bytes_however_many_threads() {
    let folder = folder();
    let first = choose(&folder, "oracle", &["--backend", "oracle"]);
    assert_eq!(first.code, Some(0), "{}", first.stderr);
    let files = ["front.csv", "sets.csv", "choose.json"];
    let read = |out: &str| files.map(|file| fs::read_to_string(folder.path(out).join(file)).unwrap());
    let expected = read("oracle");
    assert!(expected[0].starts_with("at_most,sensors,cost,f1,bound,proven,gain,poses\n"), "{}", expected[0]);
    assert!(expected[0].lines().skip(1).all(|line| line.contains(",true,")), "{}", expected[0]);
    assert!(expected[0].lines().count() >= 5, "{}", expected[0]);
    assert!(first.stdout.contains("best set, F1 "), "{}", first.stdout);
    let mut others =
        vec![vec!["--backend", "cpu", "--threads", "1"], vec!["--backend", "cpu", "--threads", "2"]];
    if common::adapter().is_some() {
        others.push(vec!["--backend", "gpu", "--adapter", "software"]);
    }
    for (number, options) in others.iter().enumerate() {
        let out = format!("out{number}");
        let outcome = choose(&folder, &out, options);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        assert_eq!(read(&out), expected, "{options:?}");
        assert_eq!(outcome.stdout.replace(&out, "oracle"), first.stdout, "{options:?}");
    }
}

/// The proof of the small study with something changed, as `--verify` takes it.
#[track_caller]
fn verified(folder: &Folder, change: impl Fn(&mut serde_json::Value), expected: &[&str]) {
    let path = folder.path("out/choose.json");
    let written = fs::read_to_string(&path).unwrap();
    let mut proof = serde_json::from_str(&written).unwrap();
    change(&mut proof);
    fs::write(&path, proof.to_string()).unwrap();
    let study = folder.path(STUDY);
    let outcome =
        perirobot(&["choose", text(&study), "--verify", text(path.parent().unwrap()), "--progress", "none"]);
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
        &["choose.json: fingerprint: the study is not"],
    );
    verified(
        &folder,
        |proof| proof["asked"]["budget"] = 900.into(),
        &["asked: the study asks for something else"],
    );
    let last = |proof: &mut serde_json::Value| proof["steps"].as_array_mut().unwrap().pop().unwrap();
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
        &["steps[1].best.score: f1 is 0.9, and counted again it is"],
    );
    verified(
        &folder,
        |proof| proof["steps"][1]["best"]["exactly"][0] = "1".into(),
        &["steps[1].best.exactly: counted again it is"],
    );
    verified(
        &folder,
        |proof| proof["steps"][1]["best"]["cost"] = 1.into(),
        &["steps[1].best: costs 500, not what is said"],
    );
    verified(
        &folder,
        |proof| proof["steps"][1]["no_set_is_above"] = 1.into(),
        &["no_set_is_above: is not the score of the best set"],
    );
    let name =
        |proof: &mut serde_json::Value| proof["steps"][0]["best"]["poses"][0] = "camera:nowhere/1".into();
    verified(&folder, name, &["steps[0].best: \"camera:nowhere/1\" is no pose of the study"]);
    let twice = |proof: &mut serde_json::Value| {
        let first = proof["steps"][1]["best"]["poses"][0].clone();
        proof["steps"][1]["best"]["poses"][1] = first;
    };
    verified(&folder, twice, &["steps[1].best: has camera:", " twice"]);
    verified(
        &folder,
        |proof| proof["steps"][1]["at_most"] = 1.into(),
        &["has 2 sensors, and at most 1 are allowed"],
    );
    let cut = |proof: &mut serde_json::Value| {
        last(proof);
        *proof = serde_json::json!({ "steps": proof["steps"] });
    };
    verified(&folder, cut, &["choose.json: is no proof of choose: missing field"]);
}

#[test]
fn a_search_that_is_stopped_says_so() {
    let folder = folder();
    let outcome = choose(&folder, "out", &["--max-time", "0s", "--backend", "cpu"]);
    assert_eq!(outcome.code, Some(75), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("stopped by --max-time"), "{}", outcome.stderr);
    assert!(!folder.names().contains(&"out".to_string()), "nothing was found, and nothing is written");
}

/// The study with these edits is refused before anything is cast, by `choose` alone.
#[track_caller]
fn not_chosen(edits: &[Edit], more: &[&str], expected: &str) {
    let folder = folder();
    for (file, from, to) in edits {
        folder.edit(file, from, to);
    }
    let before = folder.names();
    let outcome = choose(&folder, "out", more);
    assert_eq!(outcome.code, Some(2), "{edits:?}: {}", outcome.stderr);
    assert!(outcome.stderr.contains(expected), "no {expected:?} in {}", outcome.stderr);
    assert!(!outcome.stderr.contains("panicked"), "{}", outcome.stderr);
    assert_eq!((outcome.stdout.as_str(), folder.names()), ("", before));
}

#[test]
fn what_cannot_be_chosen_is_refused() {
    not_chosen(
        &[(STUDY, CHOOSE, "")],
        &[],
        "study.toml: no [choose]: say what is looked for, as in [choose]",
    );
    let region =
        "[[region]]\nname = \"empty\"\nbox = { min_m = [-0.1, 0.1, 0.8], max_m = [0.0, 0.2, 0.9] }\n[choose]";
    let empty = (STUDY, "region = \"robot\"\nat_most", "region = \"empty\"\nat_most");
    let with = |objective| (STUDY, "objective = \"f1\"", objective);
    let added = (STUDY, "[choose]", region);
    not_chosen(
        &[added, empty],
        &[],
        "choose.objective = \"f1\": region \"empty\" is without an occupied voxel in any scene",
    );
    let seen = with("objective = \"human_seen\"");
    not_chosen(
        &[added, empty, seen],
        &[],
        "= \"human_seen\": region \"empty\" is without a voxel of a person",
    );
    let people = with("objective = \"people_detected\"");
    not_chosen(&[added, empty, people], &[], "is without min_hits voxels of a part of a person");
    let require = |entry: &str| format!("apart_m = 0.1\nrequire = [{entry}]");
    let apart = "apart_m = 0.1";
    let high = require("{ score = \"f1\", at_least = 0.99 }");
    not_chosen(
        &[(STUDY, apart, &high)],
        &[],
        "choose.require[0]: no allowed set reaches f1 0.99 (pooled): it is 0.",
    );
    let seen = require(
        "{ score = \"f1\", at_least = 0 }, { score = \"human_seen\", over = \"worst\", at_least = 1 }",
    );
    not_chosen(
        &[(STUDY, apart, &seen)],
        &[],
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
        ("at_most = 3", "", &["missing field `at_most`"]),
        ("at_most = 3", "at_most = 3\nover = \"all\"", &["unknown variant `all`"]),
        ("at_most = 1", "at_most = 0", &["sensor \"lidar\".at_most = 0: must be 1 or more"]),
        ("cost = 250.0", "cost = -1", &["sensor \"camera\".cost = -1: must be a number from 0"]),
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
        (
            "seed = 7",
            "seed = 7\nfusion = \"octomap\"",
            &["sets are chosen under fusion = \"occupied_wins\" only"],
        ),
    ] {
        refused(&folder(), &[(STUDY, from, to)], expected);
    }
}
