//! Scenes that move, on the CPU: what is kept of a pose from snapshot to snapshot changes no plane and no count.
//! `PERIROBOT_CASE=<seed>` runs one case.

use std::sync::Arc;

use crate::common::Random;
use crate::common::cases::{self, case};
use crate::common::thorough::cases;
use perirobot_march::backend::cpu::{Cpu, SimdLevel};
use perirobot_march::backend::oracle::Oracle;
use perirobot_march::backend::{Backend, Carving, Fusion, GridPose, OverTime, Shot, VoxelScene};
use perirobot_march::voxel::{BitGrid, Window};

/// A scene with other blockers, looked at through another window.
fn snapshot(scene: &VoxelScene, blockers: BitGrid, window: Window, over_time: &Arc<OverTime>) -> VoxelScene {
    VoxelScene {
        shades: scene.shades.clone(),
        blockers: blockers.into(),
        over_time: Some(over_time.clone()),
        window,
        truth: scene.truth.to_window(window),
        human: scene.human.to_window(window),
        robot: scene.robot.to_window(window),
        regions: scene.regions.iter().map(|region| region.to_window(window)).collect(),
        people: scene.people.crop(window),
    }
}

/// A part of a window: some layers less on one side.
fn part(window: Window, random: &mut Random) -> Window {
    let axis = random.below(3) as usize;
    let less = random.below(window.size[axis].div_ceil(2));
    let (mut min, mut size) = (window.min, window.size);
    size[axis] -= less;
    if random.one_in(2) {
        min[axis] += less as i32;
    }
    Window { min, size }
}

#[test]
fn what_is_kept_of_a_pose_changes_nothing() {
    let chosen = std::env::var("PERIROBOT_CASE").ok().and_then(|seed| seed.parse().ok());
    let seeds = chosen.map_or(0..cases(120, 400), |seed: u64| seed..seed + 1);
    let mut freed = 0;
    for seed in seeds {
        let case = case(seed);
        let mut random = Random(seed ^ 0x6d6f_7665);
        let moving = random.of(&[2, 5, 40]);
        let mut always = BitGrid::clone(&case.scene.blockers);
        let moving: Vec<_> = always.voxels().filter(|_| random.one_in(moving)).collect();
        let mut moves = BitGrid::new(always.window());
        moving.iter().for_each(|&voxel| moves.set(voxel));
        always.remove(&moves);
        let ever = BitGrid::clone(&case.scene.blockers);
        let over_time = Arc::new(OverTime { always: always.clone().into(), ever: ever.into() });
        let by_ray = random.one_in(2);
        let cpu = || {
            let cpu = Cpu::new(Some(1)).unwrap();
            if by_ray { cpu.carving(Carving::ByRay) } else { cpu }
        };
        let mut backends: Vec<_> = SimdLevel::all().into_iter().map(|simd| cpu().simd(simd)).collect();
        let mut oracle = Oracle::default();
        backends.iter_mut().for_each(|backend| backend.tables(&case.tables).unwrap());
        oracle.tables(&case.tables).unwrap();
        let whole = case.scene.window;
        for number in 0..5 {
            let mut blockers = always.clone();
            moving.iter().filter(|_| random.one_in(2)).for_each(|&voxel| blockers.set(voxel));
            // People walk, and the window around them with them.
            let window = if random.one_in(4) { part(whole, &mut random) } else { whole };
            let scene = snapshot(&case.scene, blockers, window, &over_time);
            let draws = random.bits() as u32;
            let slots: Vec<u32> = case.shots.iter().map(|shot| shot.slot).collect();
            let sensed = |backend: &mut dyn Backend| {
                backend.load(&scene).unwrap();
                for (first_hits, shot) in (0..).zip(&case.shots) {
                    let placement = GridPose { draws: shot.placement.draws ^ draws, ..shot.placement };
                    let first_hits = placement.truly.is_none().then_some(first_hits);
                    backend.sense(shot.table, &[Shot { slot: shot.slot, placement, first_hits }]).unwrap();
                }
                // The first jobs are of one shot each; others read what is uploaded, too.
                let counts = backend.score(Fusion::OccupiedWins, &case.jobs[..case.shots.len()]).unwrap();
                (backend.planes(&slots).unwrap(), counts)
            };
            let (planes, counts) = sensed(&mut oracle);
            freed += planes.iter().map(|planes| planes.free.count()).sum::<u64>();
            for backend in &mut backends {
                let (found, found_counts) = sensed(backend);
                for (shot, (found, expected)) in found.iter().zip(&planes).enumerate() {
                    // What no region has need not be known.
                    let mut wanted = BitGrid::new(window);
                    scene.regions.iter().for_each(|region| wanted.add(region));
                    let of = |plane: &BitGrid| {
                        let mut plane = plane.to_window(window);
                        plane.keep(&wanted);
                        plane.voxels().collect::<Vec<_>>()
                    };
                    let place = format!("case {seed}, snapshot {number}, shot {shot}");
                    assert_eq!(of(&found.free), of(&expected.free), "free, {place}");
                    assert_eq!(of(&found.occupied), of(&expected.occupied), "occupied, {place}");
                    assert_eq!(of(&found.hits), of(&expected.hits), "hits, {place}");
                }
                assert_eq!(
                    format!("{found_counts:?}"),
                    format!("{counts:?}"),
                    "case {seed}, snapshot {number}"
                );
            }
        }
    }
    assert!(chosen.is_some() || freed > cases(30_000, 100_000), "only {freed} voxels were freed");
}

/// Two small parts of a grid move, mostly far from each other: rays that pass by both keep what they hit in the still layer.
#[test]
fn rays_that_pass_by_what_moves_hit_what_stands_still() {
    let Some(mut gpu) = crate::random_cells::gpu() else { return };
    let mut freed = 0;
    for seed in 0..cases(200, 800) {
        let case = case(seed);
        let mut random = Random(seed ^ 0x7061_7373);
        let grid = case.scene.blockers.window();
        let mut always = BitGrid::new(grid);
        case.scene.blockers.voxels().filter(|_| random.one_in(20)).for_each(|voxel| always.set(voxel));
        let mut ever = always.clone();
        for _ in 0..random.below(4) {
            let size = grid.size.map(|n| 1 + random.below(n.div_ceil(4)));
            let min = std::array::from_fn(|r| random.below(grid.size[r] - size[r] + 1) as i32);
            ever.add(&BitGrid::full(Window { min, size }));
        }
        let blockers = Arc::new(ever);
        let over_time = Arc::new(OverTime { always: always.into(), ever: blockers.clone() });
        let regions = vec![BitGrid::full(case.scene.window)];
        let scene = VoxelScene { blockers, over_time: Some(over_time), regions, ..case.scene };
        let slots: Vec<u32> = case.shots.iter().map(|shot| shot.slot).collect();
        let mut oracle = Oracle::default();
        let [found, expected] = [&mut gpu as &mut dyn Backend, &mut oracle].map(|backend| {
            backend.tables(&case.tables).unwrap();
            backend.load(&scene).unwrap();
            for (number, &cases::Shot { table, slot, placement }) in (0..).zip(&case.shots) {
                backend.sense(table, &[Shot { slot, placement, first_hits: Some(number) }]).unwrap();
            }
            backend.planes(&slots).unwrap()
        });
        freed += expected.iter().map(|planes| planes.free.count()).sum::<u64>();
        for (shot, (found, expected)) in found.iter().zip(&expected).enumerate() {
            assert_eq!(found, expected, "case {seed}, shot {shot}");
        }
    }
    assert!(freed > cases(30_000, 100_000), "only {freed} voxels were freed");
}
