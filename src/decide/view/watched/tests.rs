//! A body put into a watched voxel is hit or felt, and a body without a watched voxel is not: random cells and every
//! kind of sensor, with bodies put into the truth and cast again.

use super::*;
use crate::view::why::Reason;
use crate::view::why::tests::proof::{CaseRandom, random_ring, random_scene, random_study};
use crate::view::why::tests::ready;
use perirobot_march::backend::cpu::Cpu;
use perirobot_march::backend::oracle::Oracle;
use perirobot_march::backend::{Backend, Shades, VoxelScene};
use perirobot_march::voxel::Window;
use perirobot_scene::truth::RadarTruth;
use perirobot_study::input::{Member, Overrides};

/// How often each case occurred.
#[derive(Debug, Default)]
struct MetCounts {
    voxels_hit: u64,
    voxels_missed: u64,
    bodies_hit: u64,
    bodies_missed: u64,
    blinded: u64,
}

/// The voxels of a body in a world that are hit or felt.
fn hits(
    watchers: &Watchers,
    world: &World,
    truth: &Truth,
    body: &BitGrid,
    backend: &mut dyn Backend,
) -> BitGrid {
    let with = |plane: &BitGrid| {
        let mut plane = plane.to_window(truth.grid.window());
        plane.add(body);
        plane
    };
    // It is as dark as people are.
    let person = watchers.study.person_shade();
    let bit = |number: usize| match &truth.shades {
        Some(shades) if person >> number & 1 == 0 => {
            let mut plane = shades.bits[number].clone();
            plane.remove(body);
            plane
        }
        Some(shades) => with(&shades.bits[number]),
        None if person >> number & 1 == 0 => BitGrid::new(truth.grid.window()),
        None => with(&BitGrid::nowhere()),
    };
    let shades =
        (truth.shades.is_some() || person > 0).then(|| Arc::new(Shades { bits: [0, 1, 2].map(bit) }));
    let truth = Truth {
        occupied: Arc::new(with(&truth.occupied)),
        blockers: Arc::new(with(&truth.blockers)),
        radar: RadarTruth { blockers: Arc::new(with(&truth.radar.blockers)), ..truth.radar.clone() },
        shades: shades.clone(),
        human: with(&truth.human),
        ..truth.clone()
    };
    let window = truth.grid.window();
    let scene =
        VoxelScene { blockers: truth.blockers.clone(), shades, over_time: None, ..world.scene(window) };
    backend.load(&scene).unwrap();
    let mut hits = BitGrid::new(window);
    for &Watcher { sensor, candidate, representation } in &watchers.each {
        let kind = &*watchers.study.sensors[sensor].kind;
        let rays = watchers.tables[sensor].as_ref();
        let station =
            Station { rays, ..world.station(watchers.study, &truth, [sensor, candidate, watchers.repeat]) };
        // A sensor that is always on has the same evidence with and without the body.
        if watch::is_always_on(kind, representation, &station) {
            continue;
        }
        let claim = kind.claims(&station).swap_remove(representation);
        if claim.cast && rays.is_some() {
            let table = watchers.tables[..sensor].iter().flatten().count();
            hits.add(&backend.read(table, &station.placement(kind)).unwrap().planes.hits);
        }
        claim.planes.iter().for_each(|planes| hits.add(&planes.hits));
    }
    hits.keep(body);
    hits
}

/// Random voxels and bodies in a world, each put into it alone.
fn check(
    study: &Study,
    world: &World,
    choice: Choice,
    backend: &mut dyn Backend,
    random: &mut CaseRandom,
    met: &mut MetCounts,
    rerun: &str,
) {
    let watchers = Watchers::new(study, choice);
    backend.tables(&watchers.tables.iter().flatten().cloned().collect::<Vec<_>>()).unwrap();
    for truth in [world.truth(), Arc::new(world.truth_without_people())] {
        let watch = watchers.watch(world, truth.clone());
        let mut followed = BitGrid::new(world.grid.window());
        watchers
            .each()
            .iter()
            .for_each(|one| followed.add(&watchers.watched_step_by_step(one, world, &truth)));
        assert_eq!(watch.voxels, followed, "{choice:?}\n{rerun}");
        let may_be_blind = |rays: &Rays| rays.gates.range_min_q16 > rays.gates.near_ignore_q16;
        let is_blind_near = |one: &Watcher| {
            let range = study.sensors[one.sensor].kind.range();
            range.is_some_and(|range| range.range_m[0] > range.near_ignore_m)
        };
        let may_be_blind =
            watchers.tables.iter().flatten().any(may_be_blind) || watchers.each().iter().any(is_blind_near);
        // Half of them start in a watched voxel, if there is a free one.
        let mut free = watch.voxels.clone();
        free.remove(&truth.occupied);
        let free: Vec<_> = free.voxels().collect();
        for number in 0..12 {
            let at = match free.len() as u32 {
                count if number % 2 == 0 && count > 0 => free[random.number_below(count) as usize],
                _ => world.grid.size.map(|n| random.number_below(n) as i32),
            };
            let large = if number < 6 { 1 } else { 5 };
            let to: [i32; 3] = std::array::from_fn(|r| at[r] + random.number_below(large) as i32);
            let mut body = BitGrid::full(Window::from_corners(at, to)).to_window(world.grid.window());
            body.remove(&truth.occupied);
            let watched = body.voxels().filter(|&voxel| watch.voxels.get(voxel)).count();
            let hit = hits(&watchers, world, &truth, &body, backend).count() as usize;
            let what = format!("{watched} watched, {hit} hit, {at:?} to {to:?} of {choice:?}\n{rerun}");
            assert!(hit <= watched, "{what}");
            match (body.count(), watched, hit) {
                (1, 0, _) => met.voxels_missed += 1,
                (1, _, hit) => {
                    assert!(hit == 1, "{what}");
                    met.voxels_hit += 1;
                }
                (_, 0, _) => met.bodies_missed += 1,
                (_, _, 0) => {
                    assert!(may_be_blind, "{what}");
                    met.blinded += 1;
                }
                _ => met.bodies_hit += 1,
            }
        }
    }
}

fn check_all(study: &Study, worlds: &[World], every: usize, seed: u32, met: &mut MetCounts, rerun: &str) {
    let random = &mut CaseRandom(seed);
    let backends: [Box<dyn Backend>; 2] = [Box::new(Cpu::new(Some(1)).unwrap()), Box::new(Oracle::default())];
    let mut turn = 0;
    let mut backends = backends;
    for world in worlds {
        for (number, combination) in study.combinations.iter().enumerate() {
            for choice in (0..combination.choices()).step_by(every) {
                for representation in 0..combination.representation_count(&study.sensors) {
                    turn += 1;
                    let repeat = study.repeats as usize - 1;
                    let choice = Choice { combination: number, choice, representation, repeat };
                    check(study, world, choice, &mut *backends[turn % 2], random, met, rerun);
                }
            }
        }
    }
}

#[test]
fn in_random_cells_bodies_are_noticed_where_they_are_watched() {
    let only_seed = std::env::var("PERIROBOT_CASE").ok().and_then(|seed| seed.parse().ok());
    let mut met = MetCounts::default();
    for seed in only_seed.map_or(0..24, |seed: u32| seed..seed + 1) {
        let random = &mut CaseRandom(seed);
        let (scene, ring) = (random_scene(random), random_ring(random));
        let (study, worlds) = ready(&random_study(random), &scene, &[("ring.csv", ring)]);
        let rerun = format!("rerun: PERIROBOT_CASE={seed} cargo test --lib view::watched");
        check_all(&study, &worlds, 1, seed, &mut met, &rerun);
    }
    let MetCounts { voxels_hit, voxels_missed, bodies_hit, bodies_missed, blinded } = met;
    let least = [voxels_hit, voxels_missed, bodies_hit, bodies_missed].into_iter().min();
    assert!(only_seed.is_some() || (least > Some(100) && blinded * 20 < bodies_hit), "{met:?}");
}

/// Watched voxels against the reasons of `why`: an unknown voxel is watched if nothing stopped its ray; it is neither
/// watched nor known if the ray was stopped before it and no other ray reaches it.
#[test]
fn what_nothing_returns_from_is_watched() {
    let (mut silent, mut hidden) = (0, [0; 2]);
    for seed in 0..90 {
        let random = &mut CaseRandom(seed);
        let (scene, ring) = (random_scene(random), random_ring(random));
        let (study, worlds) = ready(&random_study(random), &scene, &[("ring.csv", ring)]);
        let mut cpu = Cpu::new(Some(1)).unwrap();
        // The camera, the LIDAR and the table of rays, each alone.
        for combination in 0..3 {
            let choice = Choice { combination, choice: 0, representation: 0, repeat: 0 };
            let view = crate::view::View::new(&study, &worlds[0], choice, &mut cpu).unwrap();
            let watchers = Watchers::new(&study, choice);
            let watch = watchers.watch(&worlds[0], worlds[0].truth());
            let rays = watchers.tables.iter().flatten().next().unwrap();
            let is_lossy = rays.noise.lost_below > 0
                || rays.gates.has_shades()
                || view.members[0].placement.truly.is_some();
            if is_lossy {
                continue;
            }
            // A ray gives no evidence for its first voxel, nor below its shortest range.
            let own = view.members[0].placement.origin_q16.map(|x| x >> 16);
            let least = rays.gates.range_min_q16.max(rays.gates.near_ignore_q16) >> 16;
            let apart = |voxel: [i32; 3]| (0..3).map(|r| voxel[r].abs_diff(own[r]).pow(2)).sum::<u32>();
            let is_near = |voxel: [i32; 3]| apart(voxel) <= (least + 3).pow(2);
            for missed in view.why_in_regions() {
                for voxel in missed.voxels.voxels().filter(|&voxel| !is_near(voxel)) {
                    let is_watched = watch.voxels.get(voxel);
                    match missed.cause.reason {
                        Reason::NoReturn => {
                            assert!(is_watched, "{voxel:?} of {combination}, case {seed}");
                            silent += 1;
                        }
                        Reason::Hidden => hidden[usize::from(is_watched)] += 1,
                        _ => {}
                    }
                }
            }
        }
    }
    assert!(silent > 500 && hidden[0] > 1000 && hidden[0] > 10 * hidden[1], "{silent}, {hidden:?}");
}

/// `scenes/sensors.toml`, each sensor by itself.
fn every_kind() -> (Study, Vec<World>) {
    let path =
        std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenes/sensors.toml");
    let overrides = Overrides { voxel_size_m: Some(0.2), noiseless: false };
    let mut study = Study::load(&path, &overrides).unwrap();
    let alone = |sensor: usize| perirobot_study::input::Combination {
        name: study.sensors[sensor].name.clone(),
        fusion: perirobot_march::backend::Fusion::OccupiedWins,
        members: vec![Member { sensor, candidates: (0..study.sensors[sensor].candidates.len()).collect() }],
    };
    study.combinations = (0..study.sensors.len()).map(alone).collect();
    let worlds = World::prepare_all(&study).unwrap();
    (study, worlds)
}

#[test]
fn every_kind_of_sensor_notices_where_it_watches() {
    let (study, worlds) = every_kind();
    for (number, sensor) in study.sensors.iter().enumerate() {
        let mut met = MetCounts::default();
        let mut alone = study.clone();
        alone.combinations = vec![study.combinations[number].clone()];
        check_all(&alone, &worlds, 3, number as u32, &mut met, &sensor.name);
        let is_met = met.voxels_hit + met.bodies_hit > 0;
        let none = ["rgb", "known_robot"].contains(&sensor.kind.name());
        assert_eq!(is_met, !none, "{}: {met:?}", sensor.name);
    }
}

/// Joints trip a zone camera, but a body has none: it watches nothing even in a tripped zone.
#[test]
fn a_zone_camera_watches_nothing() {
    let (study, worlds) = every_kind();
    let mut tripped = 0;
    for (number, sensor) in study.sensors.iter().enumerate().filter(|(_, s)| s.kind.name() == "rgb") {
        for world in &worlds {
            for candidate in 0..sensor.candidates.len() {
                let choice = Choice { combination: number, choice: candidate, representation: 0, repeat: 0 };
                let watchers = Watchers::new(&study, choice);
                let truth = world.truth();
                let station = world.station(&study, &truth, [number, candidate, 0]);
                let claim = sensor.kind.claims(&station).swap_remove(0);
                tripped += usize::from(claim.planes.is_some_and(|planes| !planes.hits.is_empty()));
                assert!(watchers.watch(world, truth).voxels.is_empty(), "{}/{candidate}", sensor.name);
            }
        }
    }
    assert!(tripped > 0, "a zone is tripped somewhere");
}
