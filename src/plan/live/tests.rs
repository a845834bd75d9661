//! What is counted of plans beside sweeps, judge and plain loops over voxels.

use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};
use perirobot_decide::judge::Judging;
use perirobot_decide::view::{Choice, Viewer};
use perirobot_march::backend::Fusion;
use perirobot_march::backend::cpu::Cpu;
use perirobot_march::backend::factory::{BackendChoice, BackendKind, ChosenBackends};
use perirobot_march::backend::oracle::Oracle;
use perirobot_march::march;
use perirobot_march::metrics::Confusion;
use perirobot_page::report::terminal::judge::line;
use perirobot_scene::pose::Pose;
use perirobot_study::input::{Combination, Member, Overrides, PLANNED, Planned, PlannedAt, Study};
use perirobot_study::world::{World, ray_table};
use perirobot_sweep::results::Results;
use perirobot_sweep::results::journal::Shard;
use perirobot_sweep::scoring;
use perirobot_sweep::scoring::session::Session;
use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};

use super::*;

pub(super) fn scenes(file: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenes").join(file)
}

fn read(file: &str, voxel_size_m: Option<f64>) -> Study {
    Study::load(&scenes(file), &Overrides { voxel_size_m, noiseless: false }).unwrap()
}

pub(super) fn live(kind: BackendKind, study: Study) -> Live {
    let choice = BackendChoice { kind, threads: Some(2), ..BackendChoice::default() };
    let mut live = Live::new(ChosenBackends::open(&choice).unwrap().0);
    live.set_study(study, None, &|| None).unwrap();
    live
}

fn listed(sensor: usize, candidate: usize) -> Planned {
    Planned { sensor, at: PlannedAt::Listed(candidate) }
}

pub(super) fn ask(plan: &[Planned], moment: usize, repeat: usize) -> ScoreRequest {
    let resolution = Resolution::Fine;
    ScoreRequest { plan: plan.to_vec(), moment, repeat, resolution, dead: None }
}

/// Some sensors of a study at listed poses, no two at the same.
fn some_listed(study: &Study, most: usize, random: &mut SmallRng) -> Vec<Planned> {
    let mut plan: Vec<Planned> = Vec::new();
    for _ in 0..random.random_range(1..=most) {
        let sensor = random.random_range(0..study.sensors.len());
        let one = listed(sensor, random.random_range(0..study.sensors[sensor].candidates.len()));
        if !plan.contains(&one) {
            plan.push(one);
        }
    }
    plan
}

/// Listed sensors as the only combination of a study, as a person would write it.
fn written(study: &Study, plan: &[Planned], fusion: Fusion) -> Study {
    let mut all: Vec<[usize; 2]> = plan
        .iter()
        .map(|one| match one.at {
            PlannedAt::Listed(candidate) => [one.sensor, candidate],
            PlannedAt::Pose(_) => panic!("a listed pose"),
        })
        .collect();
    all.sort_by_key(|&[sensor, candidate]| (study.sensors[sensor].kind.speaks_last(), sensor, candidate));
    let member = |[sensor, candidate]: [usize; 2]| Member { sensor, candidates: vec![candidate] };
    let combination =
        Combination { name: PLANNED.into(), fusion, members: all.into_iter().map(member).collect() };
    Study { combinations: vec![combination], ..study.clone() }
}

/// The rows of a sweep by moment, repeat and region, of the first representation of each sensor.
fn swept(study: &Study, worlds: &[World], first: usize) -> Vec<Vec<Vec<Confusion>>> {
    let mut all = vec![vec![Vec::new(); study.repeats as usize]; worlds.len()];
    for row in scoring::run(study, worlds, &mut Oracle::default()).unwrap() {
        let here = |world: &World| (world.scene, world.snapshot) == (row.scene, row.snapshot);
        if row.combination == 0 && row.choice == 0 && row.representation == first {
            all[worlds.iter().position(here).unwrap()][row.repeat].push(row.counts);
        }
    }
    all
}

/// Every kind of sensor, with noise, at two moments, on a robot's link, equal ones, in both ways of fusing.
#[test]
fn scores_are_the_rows_of_a_sweep() {
    let mut random = SmallRng::seed_from_u64(57);
    let mut met = std::collections::BTreeSet::new();
    for (file, voxel, cases) in [("sensors.toml", None, 14), ("tiny.toml", None, 6)] {
        let mut study = read(file, voxel);
        let worlds = World::prepare_all(&study).unwrap();
        for fusion in [Fusion::OccupiedWins, Fusion::Octomap] {
            let members = (0..study.sensors.len()).map(|sensor| Member { sensor, candidates: vec![0] });
            let known = Combination { name: PLANNED.into(), fusion, members: members.collect() };
            study.combinations.retain(|combination| combination.name != PLANNED);
            study.combinations.push(known);
            let mut both = [BackendKind::Cpu, BackendKind::Oracle].map(|kind| live(kind, study.clone()));
            for case in 0..cases {
                let mut plan = some_listed(&study, 5, &mut random);
                if case == 0 {
                    // Two of one, and whatever speaks last.
                    plan = vec![listed(0, 3), listed(study.sensors.len() - 1, 0), listed(0, 1)];
                }
                met.extend(plan.iter().map(|one| study.sensors[one.sensor].kind.name()));
                let expected = swept(&written(&study, &plan, fusion), &worlds, 0);
                for live in &mut both {
                    for (moment, of_moment) in expected.iter().enumerate() {
                        for (repeat, counts) in of_moment.iter().enumerate() {
                            let answer = live.score(&ask(&plan, moment, repeat)).unwrap();
                            assert_eq!(answer.counts, *counts, "{file}, {fusion:?}, {plan:?}");
                            assert!(answer.problems.iter().all(|problem| !problem.is_left_out));
                        }
                    }
                    let moments = live.moments(&plan, None, &|| None).unwrap();
                    for MomentCounts { moment, repeat, counts } in moments {
                        assert_eq!(counts, expected[moment][repeat], "{file}, {fusion:?}, {plan:?}");
                    }
                }
            }
        }
    }
    assert_eq!(met.len(), 9, "{met:?}");
}

/// A pose somewhere near a listed one.
pub(super) fn near(pose: Pose, random: &mut SmallRng) -> Pose {
    let mut off = || random.random_range(-0.1..0.1);
    let moved = pose.position_m + DVec3::new(off(), off(), off());
    let turned = DQuat::from_euler(glam::EulerRot::XYZ, off(), off(), 3.0 * off());
    Pose { position_m: moved, rotation: (turned * pose.rotation).normalize() }
}

/// Dragged sensors, one step after the other on what is warm, beside the sweep of exactly those poses.
#[test]
fn a_drag_counts_what_a_sweep_of_its_poses_counts() {
    let mut random = SmallRng::seed_from_u64(3);
    for (file, sensors) in [("sensors.toml", vec![0, 0, 1, 3]), ("tiny.toml", vec![0, 1, 0])] {
        let study = read(file, None);
        let worlds = World::prepare_all(&study).unwrap();
        let mut both = [BackendKind::Cpu, BackendKind::Oracle].map(|kind| live(kind, study.clone()));
        let start = |sensor: usize| study.sensors[sensor].candidates[0].setting.pose();
        let mut poses: Vec<(usize, Pose)> = sensors.iter().map(|&sensor| (sensor, start(sensor))).collect();
        poses.iter_mut().for_each(|(_, pose)| *pose = near(*pose, &mut random));
        for step in 0..12 {
            let moved = random.random_range(0..poses.len());
            let before = poses[moved].1;
            poses[moved].1 = near(start(poses[moved].0), &mut random);
            let lists: Vec<(usize, Vec<Pose>)> = poses.iter().map(|&(one, pose)| (one, vec![pose])).collect();
            let elsewhere = study.elsewhere(&lists).unwrap();
            if worlds.iter().any(|world| world.examine_sensors(&elsewhere).is_err()) {
                poses[moved].1 = before;
                continue;
            }
            let there: Vec<World> =
                worlds.iter().map(|world| world.with_sensors(&elsewhere.sensors)).collect();
            let expected = swept(&elsewhere, &there, 0);
            let plan: Vec<Planned> =
                poses.iter().map(|&(sensor, pose)| Planned { sensor, at: PlannedAt::Pose(pose) }).collect();
            let moment = random.random_range(0..worlds.len());
            for live in &mut both {
                let answer = live.score(&ask(&plan, moment, step % study.repeats as usize)).unwrap();
                assert_eq!(answer.counts, expected[moment][step % study.repeats as usize], "{file}, {step}");
                // Something else is done with the backend now and then.
                if step % 5 == 4 {
                    live.why(&plan, moment, DVec3::new(0.0, 0.0, 0.5)).unwrap();
                }
            }
        }
    }
}

/// Labels, dead sensors, the map of the floor, reasons at a place and ends of rays beside plain loops.
#[test]
fn labels_and_floor_are_those_of_the_view() {
    let study = read("tiny.toml", None);
    let worlds = World::prepare_all(&study).unwrap();
    let mut live = live(BackendKind::Cpu, study.clone());
    let plan = [listed(0, 1), listed(1, 0), listed(0, 4)];
    let one = written(&study, &plan, study.fusion);
    let choice = Choice { combination: 0, choice: 0, representation: 0, repeat: 0 };
    let mut oracle = Oracle::default();
    let view = Viewer::new(&one, &mut oracle).unwrap().view_regions(&worlds[0], &[choice]).unwrap().remove(0);
    let answer = live.score(&ask(&plan, 0, 0)).unwrap();
    let regions = worlds[0].region_voxels();
    let (truth, grid) = (worlds[0].truth(), worlds[0].grid);
    for voxel in regions.voxels() {
        assert_eq!(answer.labels.occupied.get(voxel), view.labels.occupied.get(voxel), "{voxel:?}");
        assert_eq!(answer.labels.free.get(voxel), view.labels.free.get(voxel), "{voxel:?}");
    }
    // Column by column.
    let FloorMap { min, size, sensors, counted } = &answer.floor;
    assert_eq!(&**counted, "From the floor to 2 m:");
    let mut seen = [0; 4];
    for y in 0..size[1] as i32 {
        for x in 0..size[0] as i32 {
            let [x, y] = [min[0] + x, min[1] + y];
            let column = (0..grid.size[2] as i32).map(|z| [x, y, z]).filter(|&voxel| {
                let height_m = grid.corner_m(voxel).z + grid.voxel_size_m / 2.0 - worlds[0].floor.z_m;
                regions.get(voxel) && !truth.occupied.get(voxel) && height_m < PERSON_M
            });
            let labels = |voxel: [i32; 3]| {
                let says = view.members.iter().map(|member| &member.says);
                says.filter(|says| says.occupied.get(voxel) || says.free.get(voxel)).count().min(2) as u8
            };
            let expected = column.map(labels).min().unwrap_or(NOT_COUNTED);
            let at = (y - min[1]) as usize * size[0] as usize + (x - min[0]) as usize;
            assert_eq!(sensors[at], expected, "{x}, {y}");
            seen[usize::from(expected.min(3))] += 1;
        }
    }
    assert!(seen.iter().all(|&columns| columns > 0), "{seen:?}");
    // Of one sensor alone.
    let mut random = SmallRng::seed_from_u64(4);
    let all: Vec<[i32; 3]> = regions.voxels().collect();
    for _ in 0..40 {
        let voxel = all[random.random_range(0..all.len())];
        let at_m = grid.corner_m(voxel) + grid.voxel_size_m / 2.0;
        let why = live.why(&plan, 0, at_m).unwrap();
        assert_eq!(why.voxel, voxel);
        for (place, told) in why.sensors.iter().enumerate() {
            let alone = written(&study, &[plan[place]], study.fusion);
            let mut cpu = Cpu::new(Some(1)).unwrap();
            let view =
                Viewer::new(&alone, &mut cpu).unwrap().view_grid(&worlds[0], &[choice]).unwrap().remove(0);
            let labelled = view.labels.occupied.get(voxel) || view.labels.free.get(voxel);
            assert_eq!((told.index, told.sees), (place, labelled), "{voxel:?}: {told:?}");
        }
    }
    // A dead one is as one that is not there.
    let without = live.score(&ask(&[plan[0], plan[2]], 0, 0)).unwrap();
    let dead = live.score(&ScoreRequest { dead: Some(1), ..ask(&plan, 0, 0) }).unwrap();
    assert_eq!((dead.counts, dead.labels), (without.counts, without.labels));
    assert!(dead.frustums[0].is_some() && dead.frustums[1].is_none());
    let nobody = live.score(&ask(&[], 0, 0)).unwrap();
    let baselines: Vec<Confusion> = worlds[0].baselines.iter().map(|region| region.nothing_seen).collect();
    assert_eq!(nobody.counts, baselines);
    // The first pixel's ray, crossing by crossing.
    let frustum = answer.frustums[0].as_ref().unwrap();
    assert_eq!(frustum.ends_m.len(), frustum.rows * frustum.columns);
    let (rays, placement) = (ray_table(&study, 0).unwrap(), worlds[0].placement(&study, 0, 1, 0));
    let mut crossings = march::crossings(placement.launch(rays.dirs_q15[0]));
    let hit = crossings.find(|crossing| {
        !truth.blockers.window().contains(crossing.voxel) || truth.blockers.get(crossing.voxel)
    });
    let far_m = f64::from(hit.unwrap().t_q16) / 65_536.0 * grid.voxel_size_m;
    let drawn_m = frustum.from_m.distance(frustum.ends_m[0]);
    assert!((drawn_m - far_m.min(3.0)).abs() < 0.01, "{drawn_m} {far_m}");
}

/// What is wrong with a sensor is told of it, and the others are counted.
#[test]
fn problems_are_of_single_sensors() {
    let study = read("tiny.toml", None);
    let mut live = live(BackendKind::Cpu, study.clone());
    let pose = study.sensors[0].candidates[0].setting.pose();
    let at = |position_m: DVec3| Planned { sensor: 0, at: PlannedAt::Pose(Pose { position_m, ..pose }) };
    let plan = [at(DVec3::new(50.0, 0.0, 1.0)), listed(0, 1), listed(0, 1)];
    let answer = live.score(&ask(&plan, 0, 0)).unwrap();
    let told: Vec<(usize, bool)> =
        answer.problems.iter().map(|problem| (problem.index, problem.is_left_out)).collect();
    assert_eq!(told, [(0, true), (2, true)]);
    assert!(answer.problems[0].words.contains("outside of the voxels"), "{:?}", answer.problems);
    assert!(answer.problems[1].words.contains("this very pose"), "{:?}", answer.problems);
    assert_eq!(answer.counts, live.score(&ask(&[listed(0, 1)], 0, 0)).unwrap().counts);
    let judged = live.judge(&plan, None, &|| None).unwrap();
    assert_eq!(judged.problems, answer.problems);
    // Inside of something solid it is counted, and told.
    let world = &live.worlds(Resolution::Fine).unwrap()[0];
    let solid = world.truth().blockers.voxels().next().unwrap();
    let inside = world.grid.corner_m(solid) + world.grid.voxel_size_m / 2.0;
    let answer = live.score(&ask(&[at(inside)], 0, 0)).unwrap();
    assert!(answer.problems[0].words.contains("occupied voxel"), "{:?}", answer.problems);
    assert!(!answer.problems[0].is_left_out);
    for wrong in [ask(&[listed(7, 0)], 0, 0), ask(&[listed(0, 99)], 0, 0), ask(&[], 9, 0)] {
        live.score(&wrong).unwrap_err();
    }
    assert!(live.eye(&[listed(0, 1)], 0, 0).unwrap().starts_with(b"\x89PNG"));
    assert!(live.scenery(0).unwrap().things.iter().all(|thing| !thing.faces.is_empty()));
}

/// The verdicts of a set of a sweep, under all conditions that the tutorial asks for.
#[test]
fn verdicts_are_those_of_judge() {
    let study = read("tutorial/study.toml", Some(0.2));
    let worlds = World::prepare_all(&study).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let choice = BackendChoice { kind: BackendKind::Cpu, ..BackendChoice::default() };
    let open = || ChosenBackends::open(&choice).map(|(backends, _)| backends);
    let command = ["perirobot".into()];
    Session::open(&study, &worlds, folder.path(), Shard::WHOLE, true, &command)
        .unwrap()
        .run(&mut open().unwrap(), 0, 0.0, &|| None)
        .unwrap();
    let (results, _) = Results::read(folder.path()).unwrap();
    let mut live = live(BackendKind::Cpu, study.clone());
    for number in [0, 16] {
        let choices = [Choice { combination: 2, choice: number, representation: 0, repeat: 0 }];
        let judging = Judging::new(&study, &worlds, &results, &choices).unwrap();
        let judged = judging.judge(&open, &|| None).unwrap();
        let set = &judged.sets[0];
        let plan = [listed(1, 0), listed(0, number)];
        let answer = live.judge(&plan, None, &|| None).unwrap();
        let expected: Vec<String> = set.judgements.iter().map(|one| line(&results, set, one)).collect();
        let found: Vec<&String> = answer.verdicts.iter().map(|one| &one.words).collect();
        assert_eq!(found, expected.iter().collect::<Vec<_>>());
        assert!(expected.len() >= 4, "{expected:?}");
        for (verdict, judgement) in answer.verdicts.iter().zip(&set.judgements) {
            assert_eq!(verdict.passes, judgement.is_met);
            assert_eq!(verdict.value, judgement.value.as_ref().map(|value| value.number()));
        }
        let nearest = answer.nearest.unwrap();
        let least = set.conditions.cases(perirobot_study::input::Condition::AsPlanned)[0].near.iter();
        let least = least.filter_map(|near| near.squared).min().unwrap();
        assert_eq!(nearest.metres, f64::from(least).sqrt() * study.voxel_size_m);
        assert_eq!(answer.moments, live.moments(&plan, None, &|| None).unwrap());
        assert_eq!(answer.cost.unwrap().thousandths(), 3_650_000);
    }
    let stopped = live.judge(&[listed(0, 0)], None, &|| Some("a newer request".into()));
    assert!(matches!(stopped, Err(Error::Stopped(_))), "{stopped:?}");
}

/// Worlds stay if only sensors change, and what is counted is that of worlds that are prepared anew.
#[test]
fn worlds_stay_where_only_sensors_change() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("tiny")).unwrap();
    std::fs::copy(scenes("tiny/cell.toml"), folder.path().join("tiny/cell.toml")).unwrap();
    let text = std::fs::read_to_string(scenes("tiny.toml")).unwrap();
    let path = folder.path().join("study.toml");
    let load = |text: &str| {
        std::fs::write(&path, text).unwrap();
        Study::load(&path, &Overrides::default()).unwrap()
    };
    let mut live = live(BackendKind::Cpu, load(&text));
    let counts = |live: &mut Live| live.score(&ask(&[listed(0, 0), listed(1, 1)], 0, 0)).unwrap().counts;
    let before = counts(&mut live);
    let far = text.replace("[-1.0, 0.05, 1.0]", "[-9.0, 0.05, 1.0]");
    let sphere = text.replace("radius_m = 0.6", "radius_m = 0.5");
    let planned = r#"list = [{ name = "upright", position_m = [-0.85, 0.6, 0.9], facing = [1, -0.5, 0] },"#;
    let start = text.find("list = [\n    { name = \"upright\"").unwrap();
    let end = start + text[start..].find("},").unwrap() + 2;
    let moved = [&text[..start], planned, &text[end..]].concat();
    let required = text.clone()
        + "\n[[require]]\nname = \"seen\"\nscore = \"parts_detected\"\nregion = \"human\"\nat_least = 0.5\n";
    let another = text.clone()
        + "\n[[sensor]]\nname = \"second\"\nmodel = \"realsense-d455\"\n[[sensor.poses]]\nname = \"high\"\n\
                                  list = [{ position_m = [0, -0.7, 1.2], facing = [0, 1, 0] }]\n";
    let edits = [(moved, false), (required, false), (another, false), (far, true), (sphere, true)];
    for (number, (edited, is_new)) in edits.into_iter().enumerate() {
        let study = load(&edited);
        assert_eq!(live.set_study(study.clone(), None, &|| None).unwrap(), is_new, "edit {number}");
        let mut fresh = self::live(BackendKind::Cpu, study);
        assert_eq!(counts(&mut live), counts(&mut fresh), "edit {number}");
        live.set_study(load(&text), None, &|| None).unwrap();
        assert_eq!(counts(&mut live), before, "after edit {number}");
    }
    // In larger voxels, too, made in the background.
    let coarse = |text: &str| {
        let overrides = Overrides { voxel_size_m: Some(coarse_voxel_m(0.1)), noiseless: false };
        std::fs::write(&path, text).unwrap();
        Study::load(&path, &overrides).unwrap()
    };
    assert!(live.score(&ScoreRequest { resolution: Resolution::Coarse, ..ask(&[], 0, 0) }).is_err());
    for _ in 0..2 {
        live.set_study(load(&text), Some(coarse(&text)), &|| None).unwrap();
        let plan = [listed(0, 0), listed(1, 1)];
        let request = ScoreRequest { resolution: Resolution::Coarse, ..ask(&plan, 0, 0) };
        let answer = live.score(&request).unwrap();
        assert_eq!(answer.grid.voxel_size_m, 0.2);
        let expected = self::live(BackendKind::Cpu, coarse(&text)).score(&ask(&plan, 0, 0)).unwrap();
        assert_eq!(answer.counts, expected.counts);
    }
}

/// Two cameras that look at each other are told, by the pairs of `choose`; if they emit nothing, or one is dead, they are not.
#[test]
fn cameras_that_disturb_each_other_are_told() {
    let text = std::fs::read_to_string(scenes("tiny.toml")).unwrap();
    let mut study = read("tiny.toml", None);
    assert!(text.contains("kind = \"rgbd\""));
    let camera = study.sensors.iter().position(|sensor| sensor.kind.name() == "rgbd").unwrap();
    let at = |x: f64, towards: f64| Planned {
        sensor: camera,
        at: PlannedAt::Pose(Pose::facing(DVec3::new(x, 0.0, 1.0), DVec3::X * towards, 0.0, 0.0)),
    };
    let facing = [at(-0.5, 1.0), at(0.5, -1.0), at(0.5, 1.0)];
    let judge = |study: &Study, dead: Option<usize>| {
        live(BackendKind::Cpu, study.clone()).judge(&facing, dead, &|| None).unwrap().disturbed
    };
    assert_eq!(judge(&study, None), []);
    study.sensors[camera].emits = Some("tof".into());
    let told = judge(&study, None);
    let pairs: Vec<([usize; 2], bool)> = told.iter().map(|one| (one.indexes, one.is_forbidden)).collect();
    assert_eq!(pairs, [([0, 1], false)]);
    let words = "A and B may disturb each other: both emit \"tof\", and each is in the other's field of view";
    assert!(told[0].words.starts_with(words), "{}", told[0].words);
    assert_eq!(judge(&study, Some(1)), []);
}

/// A floor, two steps up to a platform 40 cm high, and a table that nobody climbs, in voxels of 10 cm: along x from 0 up.
const FLOORS: &str = r#"[grid]
voxel_size_m = 0.1
bounds_m = { min = [0, 0, -0.1], max = [5, 2, 3] }
[[scene]]
file = "cell.toml"
[[region]]
name = "cell"
box = { min_m = [0, 0, 0], max_m = [5, 2, 3] }
[[sensor]]
name = "camera"
kind = "rgbd"
fov_deg = [60, 40]
resolution_px = [32, 24]
range_m = [0.1, 4]
[[sensor.poses]]
name = "wall"
list = [{ name = "left", position_m = [0.05, 1.05, 1.65], facing = [1, 0, -0.2] }]
[approach]
floor = "auto"
step_m = 0.2
[[approach.body]]
name = "dog"
box = { size_m = [0.3, 0.3, 0.5] }
on_floor = true
[[approach.entry]]
name = "door"
box = { min_m = [0, 0, -0.5], max_m = [0.8, 2, 2] }
"#;

/// The map is counted above the surfaces that bodies get to, and a change of their step is followed.
#[test]
fn the_floor_map_follows_what_carries_bodies() {
    let folder = tempfile::tempdir().unwrap();
    let slab = |name: &str, from: f64, to: f64, high: f64| {
        format!(
            "[[object]]\nname = \"{name}\"\nbox = {{ size_m = [{}, 2, {high}] }}\nposition_m = [{}, 1, {}]\n",
            to - from,
            (from + to) / 2.0,
            high / 2.0
        )
    };
    let objects = [
        slab("floor", 0.0, 4.99, 0.05),
        slab("stair", 1.0, 1.49, 0.25),
        slab("platform", 1.5, 2.99, 0.45),
        slab("table", 4.0, 4.99, 0.85),
    ];
    std::fs::write(folder.path().join("cell.toml"), format!("interior = \"occupied\"\n{}", objects.concat()))
        .unwrap();
    let load = |step_m: &str| {
        let path = folder.path().join("study.toml");
        std::fs::write(&path, FLOORS.replace("step_m = 0.2", step_m)).unwrap();
        Study::load(&path, &Overrides::default()).unwrap()
    };
    let mut live = live(BackendKind::Cpu, load("step_m = 0.2"));
    let nobody = live.score(&ask(&[], 0, 0)).unwrap().floor;
    assert_eq!(&*nobody.counted, "From each floor that bodies walk on to 2 m:");
    let row = |floor: &FloorMap, y: usize| -> Vec<u8> {
        let width = floor.size[0] as usize;
        floor.sensors[y * width..(y + 1) * width].to_vec()
    };
    // From the platform they step down 40 cm nowhere: the floor behind it and the table are not reached.
    let expected = |columns: usize| [vec![0; columns], vec![NOT_COUNTED; 50 - columns]].concat();
    assert_eq!(row(&nobody, 10), expected(30));
    // Up to 2 m above the platform, layer 25 of the grid, and not above.
    let answer = live.score(&ask(&[listed(0, 0)], 0, 0)).unwrap();
    let (regions, truth) =
        (live.fine().unwrap().worlds[0].region_voxels(), live.fine().unwrap().worlds[0].truth());
    for x in 0..30 {
        let surface = match x {
            0..10 => 1,
            10..15 => 3,
            _ => 5,
        };
        let column = (surface + 1..=surface + 20).map(|z| [x, 10, z]).filter(|&voxel| regions.get(voxel));
        let labelled =
            |voxel: [i32; 3]| u8::from(answer.labels.occupied.get(voxel) || answer.labels.free.get(voxel));
        let expected = column.filter(|&voxel| !truth.occupied.get(voxel)).map(labelled).min().unwrap();
        assert_eq!(row(&answer.floor, 10)[x as usize], expected, "{x}");
    }
    // Lower steps end before the stair; with one height everything is counted.
    assert!(!live.set_study(load("step_m = 0.1"), None, &|| None).unwrap());
    assert_eq!(row(&live.score(&ask(&[], 0, 0)).unwrap().floor, 10), expected(10));
    let mut level = load("step_m = 0.1");
    level.approach.step_m = None;
    live.set_study(level, None, &|| None).unwrap();
    let all = live.score(&ask(&[], 0, 0)).unwrap().floor;
    assert_eq!(row(&all, 10), expected(50));
    // An entry that nothing carries: said, not guessed.
    let mut walled = load("step_m = 0.2");
    walled.approach.entries[0].place = perirobot_study::input::EntryPlace::Box {
        min_m: DVec3::new(0.0, 0.0, 1.5),
        max_m: DVec3::new(0.8, 2.0, 2.9),
    };
    live.set_study(walled, None, &|| None).unwrap();
    let counted = live.score(&ask(&[], 0, 0)).unwrap().floor.counted;
    let told = counted.starts_with("Only from z ") && counted.contains("nothing that carries body");
    assert!(told, "{counted}");
}
