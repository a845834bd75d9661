//! The best set of sensors: its evidence is a sweep's, and its answer that of trying every set.

use std::path::Path;

use crate::common::{self, Random};
use perirobot_cover::{Bound, CandidateEvidence, FrontAnswer};
use perirobot_decide::choose::{MEMORY_BYTES, answer, cast_evidence, problem_of};
use perirobot_march::Result;
use perirobot_march::backend::gpu::Gpu;
use perirobot_march::backend::{Backend, Fusion, cpu::Cpu, oracle::Oracle};
use perirobot_march::metrics::{Across, Confusion, Overlap, Score};
use perirobot_march::progress::Progress;
use perirobot_study::input::{Choose, Combination, Member, Overrides, Study};
use perirobot_study::world::World;
use perirobot_sweep::scoring::run;

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
    cast_evidence(study, worlds, of, MEMORY_BYTES, backend, &|| None).unwrap()
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
    of: (usize, &[usize]),
    sets: &[Vec<usize>],
    backend: &mut dyn Backend,
) -> Vec<Vec<Confusion>> {
    swept_under(Fusion::OccupiedWins, (study, worlds), of, sets, backend)
}

fn swept_under(
    fusion: Fusion,
    (study, worlds): (&Study, &[World]),
    (region, representations): (usize, &[usize]),
    sets: &[Vec<usize>],
    backend: &mut dyn Backend,
) -> Vec<Vec<Confusion>> {
    let items = items(study);
    let combination = |(number, set): (usize, &Vec<usize>)| {
        let member = |&item: &usize| Member { sensor: items[item][0], candidates: vec![items[item][1]] };
        let mut members: Vec<Member> = set.iter().map(member).collect();
        members.sort_by_key(|member| study.sensors[member.sensor].kind.speaks_last());
        Combination { name: number.to_string(), fusion, members }
    };
    let combinations = sets.iter().enumerate().map(combination).collect();
    let study = Study { combinations, ..study.clone() };
    let mut found = vec![Vec::new(); sets.len()];
    let mut rows = run(&study, worlds, backend).unwrap();
    rows.sort_by_key(|row| row.repeat);
    for row in rows {
        let combination = &study.combinations[row.combination];
        let wanted: Vec<usize> =
            combination.members.iter().map(|member| representations[member.sensor]).collect();
        let said = &combination.representations(&study.sensors)[row.representation];
        if row.region == region && *said == wanted {
            // Unions of evidence do not tell what two sensors see.
            found[row.combination].push(row.counts.with_overlap(Overlap::default()));
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
            let way = |sensor: &perirobot_study::sensor::Sensor| {
                random.below(sensor.kind.representations().len() as u32) as usize
            };
            let representations: Vec<usize> = study.sensors.iter().map(way).collect();
            let of = (region, representations.as_slice());
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

/// Sensors that are wrong somewhere may outvote each other: then there is a best set that was found, and a bound.
#[test]
fn under_log_odds_sums_decide_and_bounds_hold() {
    let mut random = Random(7);
    let mut cpu = Cpu::new(Some(2)).unwrap();
    let (study, worlds) = shipped("scenes/sensors.toml");
    let representations = vec![0; study.sensors.len()];
    let (mut outvoted, mut detected) = (0, 0);
    for region in 0..study.regions.len() {
        let of = (region, representations.as_slice());
        let evidence = cast(&study, &worlds, of, &mut cpu);
        let sets: Vec<Vec<usize>> = (0..60)
            .map(|_| {
                let mut set: Vec<usize> =
                    (0..9).map(|_| random.below(items(&study).len() as u32) as usize).collect();
                set.sort_unstable();
                set.dedup();
                set
            })
            .collect();
        let expected = swept_under(Fusion::Octomap, (&study, &worlds), of, &sets, &mut cpu);
        let choose = one(&study, Score::F1, Across::Pooled, region, representations.clone());
        let choose = Choose { fusion: Fusion::Octomap, at_most: 9, ..choose };
        let problem = problem_of(&study, &choose, &worlds, &evidence);
        for (set, expected) in sets.iter().zip(&expected) {
            assert_eq!(problem.counts(set), *expected, "{set:?}");
            outvoted += usize::from(evidence.counts(set) != *expected);
        }
        let found = answer(&problem, &|| None).unwrap();
        let step = found.steps.last().unwrap();
        let best = step.best.as_ref().unwrap();
        let again =
            swept_under(Fusion::Octomap, (&study, &worlds), of, std::slice::from_ref(&best.set), &mut cpu);
        assert_eq!(Some(best.worth.value()), value(&again[0], Score::F1, Across::Pooled));
        assert_ne!(step.bound, Bound::Proven);
        let above = step.bound.upper_score(best.worth.value()).expect("cuts give a bound");
        for counts in &expected {
            assert!(value(counts, Score::F1, Across::Pooled).unwrap() <= above);
        }
        assert!(best.worth.value() <= above && above < 1.0, "{} {above}", best.worth.value());
        // Who is detected is no question of labels.
        let people = Choose { objective: Score::PartsDetected, at_most: 2, ..choose };
        if let Ok(sums) = answer(&problem_of(&study, &people, &worlds, &evidence), &|| None) {
            let unions = Choose { fusion: Fusion::OccupiedWins, ..people };
            let unions = answer(&problem_of(&study, &unions, &worlds, &evidence), &|| None).unwrap();
            assert_eq!(best_of(&sums), best_of(&unions));
            assert!(sums.steps.iter().all(|step| step.bound == Bound::Proven));
            detected += 1;
        }
    }
    assert!(outvoted > 10 && detected > 0, "{outvoted} sets in which labels differ, {detected} with people");
    // Where nobody is ever wrong, sums decide as unions do.
    let (study, worlds) = shipped("scenes/tiny.toml");
    let representations = vec![0; study.sensors.len()];
    let evidence = cast(&study, &worlds, (0, &representations), &mut cpu);
    let unions = Choose { at_most: 3, ..one(&study, Score::F1, Across::Pooled, 0, representations) };
    let sums = Choose { fusion: Fusion::Octomap, ..unions.clone() };
    let of = |choose: &Choose| answer(&problem_of(&study, choose, &worlds, &evidence), &|| None).unwrap();
    let (sums, unions) = (of(&sums), of(&unions));
    assert_eq!(best_of(&sums), best_of(&unions));
    assert!(sums.steps.iter().all(|step| step.bound == Bound::Proven));
}

fn best_of(answer: &FrontAnswer) -> Vec<Option<Vec<usize>>> {
    answer.steps.iter().map(|step| step.best.as_ref().map(|best| best.set.clone())).collect()
}

#[test]
fn evidence_that_does_not_fit_is_refused_before_anything_is_cast() {
    /// A job that must not begin.
    struct NotBegun;
    impl Progress for NotBegun {
        fn stop_reason(&self) -> Option<String> {
            panic!("asked whether to stop");
        }

        fn advance(&self, _: u64) {
            panic!("cast");
        }
    }
    let (study, worlds) = shipped("scenes/tiny.toml");
    let representations = vec![0; study.sensors.len()];
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let refused: Result<CandidateEvidence> =
        cast_evidence(&study, &worlds, (0, &representations), 1000, &mut cpu, &NotBegun);
    let told = refused.unwrap_err().to_string();
    assert!(told.contains("13 poses in 1 scenes, snapshots and repeats takes 1 MiB"), "{told}");
}

/// What a study would ask for that asks for the best single sensor.
fn one(study: &Study, objective: Score, over: Across, region: usize, representations: Vec<usize>) -> Choose {
    assert_eq!(representations.len(), study.sensors.len());
    Choose {
        objective,
        over,
        region,
        at_most: 1,
        budget: None,
        apart_m: 0.0,
        disturb: None,
        always: Vec::new(),
        require: Vec::new(),
        representations,
        refine: false,
        fusion: Fusion::OccupiedWins,
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
                let last = |sensor: &perirobot_study::sensor::Sensor| sensor.kind.representations().len() - 1;
                let representations: Vec<usize> =
                    study.sensors.iter().map(|sensor| way.min(last(sensor))).collect();
                let evidence = cast(&study, &worlds, (region, &representations), &mut cpu);
                let counts = swept(&study, &worlds, (region, &representations), &all, &mut cpu);
                for score in [Score::F1, Score::Kappa, Score::HumanSeen, Score::PartsDetected] {
                    for over in [Across::Pooled, Across::Worst, Across::Mean] {
                        let choose = one(&study, score, over, region, representations.clone());
                        let problem = problem_of(&study, &choose, &worlds, &evidence);
                        let values = counts.iter().filter_map(|counts| value(counts, score, over));
                        let expected = values.reduce(f64::max);
                        let found = answer(&problem, &|| None).ok();
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
fn best(answer: &FrontAnswer) -> Option<(Vec<usize>, f64)> {
    let best = answer.steps.last()?.best.as_ref()?;
    Some((best.set.clone(), best.worth.value()))
}

/// A score of several moments, in the plain way.
fn value(counts: &[Confusion], score: Score, over: Across) -> Option<f64> {
    let values: Vec<f64> = counts.iter().filter_map(|counts| score.evaluate(counts)).collect();
    match over {
        Across::Pooled => score.evaluate(&counts.iter().fold(Confusion::default(), |all, one| all.plus(one))),
        Across::Worst => values.into_iter().reduce(f64::min),
        Across::Mean if values.is_empty() => None,
        Across::Mean => Some(values.iter().sum::<f64>() / values.len() as f64),
    }
}
