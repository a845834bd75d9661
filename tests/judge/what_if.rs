//! What sets of sensors count when something is not as planned is what a sweep counts of a study in which that was
//! changed by hand: every kind of sensor, two snapshots, noise in two repeats, both rules of fusion, all backends.

use std::fs;
use std::path::Path;

use crate::common;
use perirobot_decide::controller::MeasuredSurroundings;
use perirobot_decide::judge::{
    Alteration, Case, Conditions, Draws, WhatIf, alter, count_cases, measure_cases,
};
use perirobot_decide::view::{Choice, ChoiceSelector, View, find};
use perirobot_march::Error;
use perirobot_march::backend::factory::{
    BackendChoice, BackendFactory, BackendKind, ChosenBackends, Fallback,
};
use perirobot_march::backend::{Backend, oracle::Oracle};
use perirobot_march::metrics::Confusion;
use perirobot_study::input::{Condition, Overrides, Study};
use perirobot_study::world::World;
use perirobot_sweep::results::files::DRAWS;
use perirobot_sweep::scoring::run;
use toml::{Table, Value};

const DEAD: [Condition; 2] = [Condition::OneSensorDead, Condition::TwoSensorsDead];

/// A folder with the study of every kind of sensor, changed.
struct Cell(tempfile::TempDir);

impl Cell {
    fn new() -> Cell {
        let cell = Cell(tempfile::tempdir().unwrap());
        copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes"), cell.0.path());
        cell
    }

    fn text(&self) -> Table {
        toml::from_str(&fs::read_to_string(self.0.path().join("sensors.toml")).unwrap()).unwrap()
    }

    fn load(&self, study: &Table) -> (Study, Vec<World>) {
        let path = self.0.path().join("changed.toml");
        fs::write(&path, toml::to_string(study).unwrap()).unwrap();
        let study = Study::load(&path, &Overrides::default()).unwrap();
        let worlds = World::prepare_all(&study).unwrap();
        (study, worlds)
    }
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy(&path, &target);
        } else if ["toml", "csv", "urdf"].iter().any(|end| path.extension().is_some_and(|own| own == *end)) {
            fs::copy(&path, &target).unwrap();
        }
    }
}

/// For each region the counts of each moment of a choice, in a sweep of the study: repeat by repeat.
fn swept(study: &Study, worlds: &[World], choice: &Choice, backend: &mut dyn Backend) -> Vec<Vec<Confusion>> {
    let combinations = vec![study.combinations[choice.combination].clone()];
    let mut rows = run(&Study { combinations, ..study.clone() }, worlds, backend).unwrap();
    rows.sort_by_key(|row| row.repeat);
    let of = |region| {
        let own = rows.iter().filter(|row| {
            (row.choice, row.representation, row.region) == (choice.choice, choice.representation, region)
        });
        own.map(|row| row.counts).collect()
    };
    (0..study.regions.len()).map(of).collect()
}

/// A combination of these sensors, each in the poses that fit a pattern.
fn combination(name: &str, fusion: &str, members: &[(String, String)]) -> Value {
    let (mut entry, mut poses) = (Table::new(), Table::new());
    for (sensor, pattern) in members {
        poses.insert(sensor.clone(), vec![pattern.clone()].into());
    }
    let sensors: Vec<String> = members.iter().map(|member| member.0.clone()).collect();
    entry.insert("name".into(), name.into());
    entry.insert("fusion".into(), fusion.into());
    entry.insert("sensors".into(), sensors.into());
    entry.insert("poses".into(), poses.into());
    entry.into()
}

/// Sensors and poses of a set: `camera:corners/0/0;pads:floor/1/0`.
fn members(poses: &str) -> Vec<(String, String)> {
    poses.split(';').map(|one| one.split_once(':').unwrap()).map(|(a, b)| (a.into(), b.into())).collect()
}

const SETS: [(&str, &str, &str); 3] = [
    (
        "occupied_wins",
        "gate:here;pads:floor/1/0;camera:corners/0/0;wrist:hand/along;lidar:posts/leaning;ring:forearm/wrist;cover:0.3;robot:known",
        "box",
    ),
    (
        "octomap",
        "pads:turned/0;camera:corners/1/1;cover:0.2;watch:corners/0/0;scanner:floor/hanging;robot:known",
        "points",
    ),
    ("octomap", "lidar:posts/standing", "points"),
];

/// The study with one combination, and what a set counts under some conditions.
fn what_if(
    study: &(Study, Vec<World>),
    poses: &str,
    representation: &str,
    asked: &[Condition],
    backends: &mut dyn BackendFactory,
) -> (Conditions, Option<Draws>, String) {
    let (study, worlds) = study;
    let names = perirobot_sweep::results::columns::representation_names(study, &study.combinations[0]);
    // One that has the representation anywhere.
    let wanted = names.iter().rfind(|name| name.split(';').any(|one| one == representation)).unwrap();
    let names = ChoiceSelector {
        poses: poses.into(),
        representation: Some(wanted.clone()),
        ..ChoiceSelector::default()
    };
    let (_, choice) = find(study, worlds, &names).unwrap();
    let counts = swept(study, worlds, &choice, backends.open(Fallback::Cpu).unwrap().as_mut());
    let case = Case { counts, ..Case::default() };
    let mut conditions =
        [Conditions { cases: vec![(Condition::AsPlanned, vec![case])], ..Conditions::default() }];
    let what_if = [WhatIf::new(study, worlds, &choice)];
    let draws = count_cases(&what_if, asked, &mut conditions, backends, &|| None).unwrap();
    let [conditions] = conditions;
    (conditions, draws, wanted.clone())
}

/// Each case as a study of its own counts the same.
#[track_caller]
fn alone((study, worlds): &(Study, Vec<World>), poses: &str, ways: &str, found: &Conditions) {
    let names = ChoiceSelector {
        poses: poses.into(),
        representation: Some(ways.into()),
        ..ChoiceSelector::default()
    };
    let (_, choice) = find(study, worlds, &names).unwrap();
    for case in found.cases.iter().flat_map(|(_, cases)| cases) {
        let nothing_left =
            matches!(&case.alteration, Alteration::Dead(dead) if dead.len() == poses.split(';').count());
        if nothing_left {
            continue;
        }
        let (study, worlds, choice) = alter(study, worlds, &choice, &case.alteration).unwrap();
        let counts =
            swept(&study, &worlds, &choice, &mut perirobot_march::backend::cpu::Cpu::new(Some(2)).unwrap());
        assert_eq!(case.counts, counts, "{:?} of {poses}", case.alteration);
    }
}

/// Backends by name.
fn backends() -> Vec<(&'static str, ChosenBackends)> {
    let open = |choice: BackendChoice| ChosenBackends::open(&choice).unwrap().0;
    let of = |kind| BackendChoice { kind, threads: Some(2), ..BackendChoice::default() };
    let mut all = vec![("oracle", open(of(BackendKind::Oracle))), ("cpu", open(of(BackendKind::Cpu)))];
    if let Some(adapter) = common::adapter() {
        all.push(("gpu", open(BackendChoice { adapter: Some(adapter), ..of(BackendKind::Gpu) })));
    }
    all
}

#[test]
fn without_a_sensor_counts_are_those_of_a_study_without_it() {
    let cell = Cell::new();
    let mut compared = 0;
    for (fusion, poses, representation) in SETS {
        let all = members(poses);
        let mut text = cell.text();
        text.insert("combination".into(), vec![combination("set", fusion, &all)].into());
        let study = cell.load(&text);
        let mut same: Option<Conditions> = None;
        for (name, mut backends) in backends() {
            let (found, draws, ways) = what_if(&study, poses, representation, &DEAD, &mut backends);
            assert!(draws.is_none());
            assert_eq!(same.get_or_insert_with(|| found.clone()), &found, "{name}: {poses}");
            if name != "cpu" {
                continue;
            }
            alone(&study, poses, &ways, &found);
            let ways: Vec<&str> = ways.split(';').collect();
            for condition in DEAD {
                for case in found.cases(condition) {
                    let Alteration::Dead(dead) = &case.alteration else { panic!("{:?}", case.alteration) };
                    let is_left =
                        |number: &usize| !dead.contains(&format!("{}:{}", all[*number].0, all[*number].1));
                    let left: Vec<usize> = (0..all.len()).filter(is_left).collect();
                    if left.is_empty() {
                        let nothing = |region: usize| {
                            let each: Vec<Confusion> =
                                study.1.iter().map(|world| world.baselines[region].nothing_seen).collect();
                            each.repeat(study.0.repeats as usize)
                        };
                        let expected: Vec<_> = (0..study.0.regions.len()).map(nothing).collect();
                        assert_eq!(case.counts, expected, "{:?}", case.alteration);
                        continue;
                    }
                    // By hand: the combination without it.
                    let own: Vec<(String, String)> = left.iter().map(|&number| all[number].clone()).collect();
                    let mut text = text.clone();
                    text.insert("combination".into(), vec![combination("set", fusion, &own)].into());
                    let (study, worlds) = cell.load(&text);
                    let names: Vec<String> =
                        own.iter().map(|(sensor, pose)| format!("{sensor}:{pose}")).collect();
                    let ways: Vec<&str> = left.iter().map(|&number| ways[number]).collect();
                    let names = ChoiceSelector {
                        poses: names.join(";"),
                        representation: Some(ways.join(";")),
                        ..ChoiceSelector::default()
                    };
                    let (_, choice) = find(&study, &worlds, &names).unwrap();
                    let expected = swept(&study, &worlds, &choice, &mut Oracle::default());
                    assert_eq!(case.counts, expected, "{:?} of {poses}", case.alteration);
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 50, "{compared} cases");
}

#[test]
fn moved_sensors_count_as_in_a_study_with_the_poses_that_are_written() {
    let cell = Cell::new();
    for (fusion, poses, representation) in SETS {
        let all = members(poses);
        let mut text = cell.text();
        text.insert("combination".into(), vec![combination("set", fusion, &all)].into());
        let error = "draws = 3\nseed = 5\nposition_m = 0.05\nangle_deg = 3.0";
        text.insert("mounting_error".into(), toml::from_str::<Table>(error).unwrap().into());
        let study = cell.load(&text);
        let mut same: Option<Conditions> = None;
        for (name, mut backends) in backends() {
            let (found, draws, ways) =
                what_if(&study, poses, representation, &[Condition::MountingError], &mut backends);
            assert_eq!(same.get_or_insert_with(|| found.clone()), &found, "{name}: {poses}");
            if name != "cpu" {
                continue;
            }
            alone(&study, poses, &ways, &found);
            draws.unwrap().write(cell.0.path()).unwrap();
            let moved = fs::read_to_string(cell.0.path().join(DRAWS)).unwrap();
            // By hand: the sensors of the file have its poses, and the combination is one draw of each.
            let mut changed = text.clone();
            let is_moved = |sensor: &str| moved.lines().any(|line| line.starts_with(&format!("{sensor},")));
            let table = |text: &str| -> Value { toml::from_str::<Table>(text).unwrap().into() };
            for sensor in changed["sensor"].as_array_mut().unwrap() {
                let sensor = sensor.as_table_mut().unwrap();
                if is_moved(sensor["name"].as_str().unwrap()) {
                    sensor.remove("same_poses_as");
                    let poses = table(&format!("name = \"draws\"\ncsv = \"{DRAWS}\""));
                    sensor.insert("poses".into(), vec![poses].into());
                } else if sensor.contains_key("same_poses_as") {
                    // It stays where the other sensor was.
                    let corners = text["sensor"].as_array().unwrap()[0]["poses"].clone();
                    sensor.remove("same_poses_as");
                    sensor.insert("poses".into(), corners);
                }
            }
            let cases = found.cases(Condition::MountingError);
            let mut different = 0;
            for (draw, case) in cases.iter().enumerate() {
                let pose = |(sensor, pose): &(String, String)| match is_moved(sensor) {
                    true => (sensor.clone(), format!("draws/{pose}~{draw}")),
                    false => (sensor.clone(), pose.clone()),
                };
                let own: Vec<(String, String)> = all.iter().map(pose).collect();
                changed.insert("combination".into(), vec![combination("set", fusion, &own)].into());
                let (study, worlds) = cell.load(&changed);
                let names: Vec<String> =
                    own.iter().map(|(sensor, pose)| format!("{sensor}:{pose}")).collect();
                let names = ChoiceSelector {
                    poses: names.join(";"),
                    representation: Some(ways.clone()),
                    ..ChoiceSelector::default()
                };
                let (_, choice) = find(&study, &worlds, &names).unwrap();
                let expected = swept(&study, &worlds, &choice, &mut Oracle::default());
                assert_eq!(case.counts, expected, "{:?} of {poses}", case.alteration);
                different += usize::from(case.counts != found.cases(Condition::AsPlanned)[0].counts);
            }
            assert_eq!((cases.len(), different), (3, 3), "{poses}");
        }
    }
}

#[test]
fn postures_count_as_in_a_study_with_that_person_in_the_scene() {
    let cell = Cell::new();
    let (fusion, poses, representation) = SETS[0];
    fs::copy(cell.0.path().join("people/bent.csv"), cell.0.path().join("of mine.csv")).unwrap();
    let mut text = cell.text();
    text.insert("combination".into(), vec![combination("set", fusion, &members(poses))].into());
    let postures = "people = [\"kneeling\", \"of mine.csv\"]\nspots = [[0.7, 0.2, 90], [1.1, -0.6, -155.5]]";
    text.insert("postures".into(), toml::from_str::<Table>(postures).unwrap().into());
    text.insert("approach".into(), toml::from_str::<Table>("floor_m = 0.02").unwrap().into());
    let study = cell.load(&text);
    // By hand: one person in the scene.
    let scene = fs::read_to_string(cell.0.path().join("sensors/cell.toml")).unwrap();
    let mut objects: Table = toml::from_str(&scene).unwrap();
    let all = objects["object"].as_array_mut().unwrap();
    all.retain(|object| !["operator", "visitor"].contains(&object["name"].as_str().unwrap()));
    let mut by_hand = Vec::new();
    for (name, file) in [("kneeling", "../people/kneeling.csv"), ("of-mine", "../of mine.csv")] {
        for (spot, at) in
            ["0.7, 0.2, 0.02]\nrpy_deg = [0, 0, 90]", "1.1, -0.6, 0.02]\nrpy_deg = [0, 0, -155.5]"]
                .into_iter()
                .enumerate()
        {
            let person =
                format!("name = \"operator\"\nmannequin = \"{file}\"\nspeed_m_s = 0\nposition_m = [{at}");
            let mut own = objects.clone();
            own["object"].as_array_mut().unwrap().push(toml::from_str::<Table>(&person).unwrap().into());
            by_hand.push((format!("{name}/{spot}"), toml::to_string(&own).unwrap()));
        }
    }
    let mut same: Option<Conditions> = None;
    for (name, mut backends) in backends() {
        let (found, _, ways) = what_if(&study, poses, representation, &[Condition::Postures], &mut backends);
        assert_eq!(same.get_or_insert_with(|| found.clone()), &found, "{name}: {poses}");
        if name != "cpu" {
            continue;
        }
        alone(&study, poses, &ways, &found);
        let cases = found.cases(Condition::Postures);
        assert_eq!(cases.len(), by_hand.len());
        for (case, (name, scene)) in cases.iter().zip(&by_hand) {
            assert_eq!(case.alteration, Alteration::Posture(name.clone()));
            fs::write(cell.0.path().join("sensors/cell.toml"), scene).unwrap();
            let (study, worlds) = cell.load(&text);
            let names = ChoiceSelector {
                poses: poses.into(),
                representation: Some(ways.clone()),
                ..ChoiceSelector::default()
            };
            let (_, choice) = find(&study, &worlds, &names).unwrap();
            let expected = swept(&study, &worlds, &choice, &mut Oracle::default());
            assert_eq!(case.counts, expected, "{name}");
            assert_ne!(case.counts, found.cases(Condition::AsPlanned)[0].counts, "{name}");
        }
    }
}

/// What a controller would measure in each case is what it measures of a study of its own in which the case is.
#[test]
fn a_controller_measures_each_case_as_a_study_of_its_own() {
    let cell = Cell::new();
    let under =
        Condition::ALL.map(|condition| serde_json::to_value(condition).unwrap().to_string()).join(", ");
    let tables: Table = toml::from_str(&format!(
        "require = [{{ name = \"it\", score = \"needless_stops\", at_most = 1.0, under = [{under}] }}]\n\
         [mounting_error]\ndraws = 2\nposition_m = 0.05\nangle_deg = 3.0\n\
         [postures]\npeople = [\"small\"]\nspots = [[0.9, -0.2, 0], [1.2, 0.5, 45]]\n\
         [stopping]\nformula = \"iso13855\"\nedition = 2010\nrobot_speeds_m_s = 0.5\nsensor_reaction_s = 0.1\n\
         control_reaction_s = 0.1\nrobot_stopping_s = 0.1\nintrusion_m = 0.1\n"
    ))
    .unwrap();
    let (mut cases, mut different, mut repeats_differ) = (0, 0, 0);
    for (fusion, poses, representation) in &SETS[1..] {
        let mut text = cell.text();
        text.insert("combination".into(), vec![combination("set", fusion, &members(poses))].into());
        text.extend(tables.clone());
        let study = cell.load(&text);
        let mut same: Option<Conditions> = None;
        for (name, mut backends) in backends() {
            let (found, draws, ways) = what_if(&study, poses, representation, &Condition::ALL, &mut backends);
            let names = ChoiceSelector {
                poses: (*poses).into(),
                representation: Some(ways),
                ..ChoiceSelector::default()
            };
            let (_, choice) = find(&study.0, &study.1, &names).unwrap();
            let mut backend = backends.open(Fallback::None).unwrap();
            let (what_if, mut found) = ([WhatIf::new(&study.0, &study.1, &choice)], [found]);
            measure_cases(&what_if, &mut found, draws.as_ref(), &mut *backend, &|| None).unwrap();
            let [found] = found;
            assert_eq!(same.get_or_insert_with(|| found.clone()), &found, "{name}");
            if name != "cpu" {
                continue;
            }
            for case in found.cases.iter().flat_map(|(_, cases)| cases) {
                let measured = &case.measured;
                assert_eq!(measured.len(), study.1.len() * study.0.repeats as usize);
                cases += 1;
                different += usize::from(measured != &found.cases(Condition::AsPlanned)[0].measured);
                repeats_differ += usize::from(measured[..study.1.len()] != measured[study.1.len()..]);
                let is_silent = matches!(&case.alteration, Alteration::Dead(dead) if dead.len() == poses.split(';').count());
                if is_silent {
                    let unseen = measured.iter().all(|one| one.unknown_free.is_none());
                    assert!(
                        unseen && measured.iter().all(|one| one.unknown_occupied.is_some()),
                        "{measured:?}"
                    );
                    continue;
                }
                let (own, worlds, choice) = alter(&study.0, &study.1, &choice, &case.alteration).unwrap();
                // Repeat by repeat, and in each snapshot by snapshot.
                for (number, measured) in measured.iter().enumerate() {
                    let (world, repeat) = (&worlds[number % worlds.len()], number / worlds.len());
                    let view =
                        View::new(&own, world, Choice { repeat, ..choice }, &mut Oracle::default()).unwrap();
                    let expected = MeasuredSurroundings::new(world).separation(Some(&view.labels));
                    assert_eq!(*measured, expected, "{:?} at {number}", case.alteration);
                }
            }
        }
    }
    // As planned, six sensors, fifteen pairs, two draws and two postures; then as planned, the one that is dead, alone
    // and as a pair, two draws and two postures.
    assert_eq!(cases, 26 + 7);
    assert!(different > 5 && repeats_differ > 0, "{different} differ, in {repeats_differ} repeats do");
}

#[test]
fn a_plan_that_is_counted_differently_is_told() {
    let cell = Cell::new();
    let (fusion, poses, _) = SETS[2];
    let mut text = cell.text();
    text.insert("combination".into(), vec![combination("set", fusion, &members(poses))].into());
    let (study, worlds) = cell.load(&text);
    let (_, choice) =
        find(&study, &worlds, &ChoiceSelector { poses: poses.into(), ..ChoiceSelector::default() }).unwrap();
    let mut counts = swept(&study, &worlds, &choice, &mut Oracle::default());
    counts[1][2].tp += 1;
    let case = Case { counts, ..Case::default() };
    let mut conditions =
        [Conditions { cases: vec![(Condition::AsPlanned, vec![case])], ..Conditions::default() }];
    let what_if = [WhatIf::new(&study, &worlds, &choice)];
    let (_, mut cpu) = backends().swap_remove(1);
    let error = count_cases(&what_if, &DEAD, &mut conditions, &mut cpu, &|| None).unwrap_err();
    assert!(matches!(error, Error::Disagreement(_)), "{error}");
}
