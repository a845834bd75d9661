//! How long answers take. Prints times, asserts none:
//! `PERIROBOT_TIMES=tutorial cargo test --release -p perirobot-plan --lib -- --ignored --nocapture times`; without the
//! variable, of all cells. The least is what an idle machine takes.

use std::time::{Duration, Instant};

use glam::DVec3;
use perirobot_march::backend::factory::{BackendChoice, BackendKind, ChosenBackends, KeptBackends};
use perirobot_scene::pose::Pose;
use perirobot_scene::source::Sources;
use perirobot_study::input::{Overrides, Planned, PlannedAt, Study};
use perirobot_study::world::World;
use perirobot_sweep::scoring;
use rand::SeedableRng;
use rand::rngs::SmallRng;

use super::tests::{ask, live, near, scenes};
use super::*;

/// Studies, with what is replaced in their text.
const CELLS: [(&str, &str, [&str; 2]); 3] = [
    ("tutorial", "tutorial/study.toml", ["", ""]),
    (
        "tutorial 1280 x 720",
        "tutorial/study.toml",
        ["resolution_px = [212, 120]", "resolution_px = [1280, 720]"],
    ),
    ("palletiser", "palletiser/study.toml", ["", ""]),
];

/// Prints the least and the median of some times.
fn show(what: &str, mut took: Vec<Duration>) {
    took.sort();
    let ms = |one: Duration| one.as_secs_f64() * 1e3;
    println!("| {what} | {:.2} | {:.2} |", ms(took[0]), ms(took[took.len() / 2]));
}

fn time<T>(job: impl FnOnce() -> T) -> (Duration, T) {
    let begin = Instant::now();
    let done = job();
    (begin.elapsed(), done)
}

#[test]
#[ignore = "it prints times"]
fn times() {
    let only = std::env::var("PERIROBOT_TIMES").unwrap_or_default();
    for (name, file, [from, to]) in CELLS.into_iter().filter(|(name, ..)| name.contains(&only)) {
        let folder = scenes(file).parent().unwrap().to_path_buf();
        let path = folder.join("live.toml");
        let text = std::fs::read_to_string(scenes(file)).unwrap();
        let text = if from.is_empty() { text } else { text.replace(from, to) };
        let sources = Sources::from_main(&path).with_file(&path, text.into_bytes());
        let load = |voxel_size_m: Option<f64>| {
            Study::read(&path, &Overrides { voxel_size_m, noiseless: false }, sources.clone()).unwrap()
        };
        let (read, study) = time(|| load(None));
        let coarse = load(Some(coarse_voxel_m(study.voxel_size_m)));
        println!("\n| {name} | least ms | median ms |\n|---|---:|---:|");
        show("read the study", vec![read]);
        let (ready, mut live) = time(|| live(BackendKind::Cpu, study.clone()));
        show("prepare worlds", vec![ready]);
        let (again, _) = time(|| live.set_study(load(None), Some(coarse), &|| None).unwrap());
        show("read and take the study again", vec![again]);
        live.worlds(Resolution::Coarse).unwrap();
        let poses = (0..study.sensors.len()).filter(|&sensor| study.sensors[sensor].kind.takes_poses());
        let sensors: Vec<usize> = poses.collect();
        let pose = |sensor: usize| study.sensors[sensor].candidates[0].setting.pose();
        let mut random = SmallRng::seed_from_u64(1);
        let plan: Vec<Planned> =
            sensors.iter().map(|&sensor| Planned { sensor, at: PlannedAt::Pose(pose(sensor)) }).collect();
        let moments = live.worlds(Resolution::Fine).unwrap().len();
        let (first, _) = time(|| live.score(&ask(&plan, 0, 0)).unwrap());
        show("first score", vec![first]);
        for (place, &sensor) in sensors.iter().enumerate() {
            for resolution in [Resolution::Fine, Resolution::Coarse] {
                let took = (0..25).map(|_| {
                    let position_m = near(pose(sensor), &mut random).position_m;
                    let mut plan = plan.clone();
                    plan[place].at = PlannedAt::Pose(Pose { position_m, ..pose(sensor) });
                    live.score(&ScoreRequest { resolution, ..ask(&plan, 0, 0) }).unwrap().took
                });
                show(&format!("drag {}, {resolution:?}", study.sensors[sensor].name), took.collect());
            }
        }
        for round in ["first", "second"] {
            let took = (0..moments).map(|moment| live.score(&ask(&plan, moment, 0)).unwrap().took);
            show(&format!("another moment, {round} time"), took.collect());
        }
        let took = (0..5).map(|_| time(|| live.moments(&plan, None, &|| None).unwrap()).0);
        show(&format!("all {moments} moments"), took.collect());
        let took = (0..5).map(|_| time(|| live.why(&plan, 0, DVec3::new(0.3, 0.2, 1.0)).unwrap()).0);
        show("why", took.collect());
        show("eye", (0..5).map(|_| time(|| live.eye(&plan, 0, 0).unwrap()).0).collect());
        show("scenery", vec![time(|| live.scenery(0).unwrap()).0]);
        // As Python's evaluate does: one pose of one sensor at all moments.
        let worlds = World::prepare_all(&study).unwrap();
        let choice = BackendChoice { kind: BackendKind::Cpu, threads: Some(2), ..BackendChoice::default() };
        let open = || KeptBackends::new(ChosenBackends::open(&choice).unwrap().0);
        let mut kept = open();
        for (what, is_cold) in [("nothing is ready", true), ("warm", false)] {
            let evaluate = |_| {
                let mut study = study.clone();
                let mut fresh = is_cold.then(&open);
                let backends = fresh.as_mut().unwrap_or(&mut kept);
                if is_cold {
                    study.kept_rays = Default::default();
                }
                let begin = Instant::now();
                let moved = study.elsewhere(&[(sensors[0], vec![pose(sensors[0])])]).unwrap();
                worlds.iter().for_each(|world| world.examine_sensors(&moved).unwrap());
                let there: Vec<World> =
                    worlds.iter().map(|world| world.with_sensors(&moved.sensors)).collect();
                scoring::run_on(&moved, &there, backends, &|| None).unwrap();
                begin.elapsed()
            };
            show(&format!("evaluate one pose, {what}"), (0..6).map(evaluate).collect());
        }
        if !only.is_empty() {
            let took = (0..2).map(|_| time(|| live.judge(&plan, None, &|| None).unwrap()).0);
            show("judge", took.collect());
        }
    }
}
