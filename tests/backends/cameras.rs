//! Cameras on the GPU, whose free voxels are found from their pixels: every count, plane and end is the
//! oracle's, whichever way they are found. `PERIROBOT_CASE=<seed>` runs one case.

use crate::common::cases::{self, Case, case};
use crate::common::{self, Random};
use perirobot_march::backend::cpu::Cpu;
use perirobot_march::backend::gpu::{Gpu, open, shader_source};
use perirobot_march::backend::oracle::Oracle;
use perirobot_march::backend::{
    Backend, Carving, Evidence, Fusion, GridPose, Noise, OverTime, Rays, Reading, Shot, VoxelScene,
};
use perirobot_march::march::{FULL_RANGE, Gates};
use perirobot_march::metrics::{COUNTERS, Confusion};
use perirobot_march::voxel::{BitGrid, Window};
use perirobot_study::sensor::Camera;

/// A camera of few or many pixels, wide or narrow, with or without noise.
fn camera(random: &mut Random) -> Rays {
    let resolution_px = match random.below(4) {
        0 => [1 + random.below(9), 1 + random.below(9)],
        1 => [200, 130],
        _ => [20 + random.below(100), 20 + random.below(70)],
    };
    let fov_rad = random.of(&[[1.5, 1.0], [0.6, 0.5], [2.2, 1.9], [0.2, 0.3]]);
    let camera = Camera { fov_rad, resolution_px };
    let [near, far, housing] = [20, 60, 8].map(|voxels| random.below(voxels << 16));
    let gates = Gates {
        range_min_q16: random.of(&[0, 0, 3 << 16, near]),
        range_max_q16: random.of(&[2047 << 16, 40 << 16, far]),
        shade_ranges_q16: FULL_RANGE,
        along_axis: random.one_in(2),
        near_ignore_q16: random.of(&[0, 0, housing]),
        no_return_is_free: random.one_in(2),
        backdrop: random.one_in(2),
    };
    let lost_below = random.of(&[0, 0, 1 << 29]);
    let noise = match random.below(3) {
        0 => cases::steps((0..4096).map(|step| (step - 2048) * 50).collect(), lost_below),
        1 => cases::steps((0..4096).map(|step| (step - 2048) / 1800 * 65_536).collect(), lost_below),
        _ => Noise { lost_below, ..Noise::default() },
    };
    Rays { dirs_q15: camera.dirs_q15().into(), image: Some(camera.image()), gates, noise }
}

/// A random cell, seen by cameras from anywhere; every other one is open but for a wall, so that boxes of
/// voxels are free whole, or would be if pixels were closer.
fn seen(seed: u64) -> Case {
    let mut case = case(seed);
    let mut random = Random(seed ^ 0xca3e7a);
    if seed % 2 == 1 {
        let mut wall = case.scene.blockers.window();
        let axis = random.below(3) as usize;
        wall.min[axis] = random.below(wall.size[axis]) as i32;
        wall.size[axis] = 1;
        case.scene.blockers = BitGrid::full(wall).to_window(case.scene.blockers.window()).into();
    }
    case.tables = (0..case.tables.len()).map(|_| camera(&mut random)).collect();
    case
}

fn gpu() -> Option<Gpu> {
    Some(Gpu::new(&common::adapter()?).unwrap_or_else(|e| panic!("{e}")))
}

/// The adapter as it is, and with the large batches and the kernels of a GPU.
pub(super) fn gpus() -> Vec<Gpu> {
    let Some(adapter) = common::adapter() else { return Vec::new() };
    let open = || unwrap(open(&adapter));
    [open(), open().treat_as_gpu()].map(|device| unwrap(Gpu::from_device(device, &shader_source))).into()
}

/// How often a kernel was dispatched so far, and over how many placements.
pub(super) fn dispatched(gpu: &Gpu, kernel: &str) -> [u64; 2] {
    let timing = gpu.timings().into_iter().find(|timing| timing.stage == kernel);
    timing.map_or([0; 2], |timing| [timing.dispatches, timing.rows])
}

/// What a backend counts of placements alone, all cast at once.
pub(super) fn counts_alone(
    backend: &mut dyn Backend,
    scene: &VoxelScene,
    rays: &Rays,
    shots: &[Shot],
) -> Vec<[u64; COUNTERS]> {
    unwrap(backend.tables(std::slice::from_ref(rays)));
    unwrap(backend.load(scene));
    assert!(backend.slots() >= shots.len());
    unwrap(backend.sense(0, shots));
    let job =
        |shot: &Shot| vec![Reading { slot: shot.slot, volume: None, hit: 847, miss: -405, presence: false }];
    let counts = unwrap(backend.score(Fusion::OccupiedWins, &shots.iter().map(job).collect::<Vec<_>>()));
    counts.iter().flatten().map(Confusion::counts).collect()
}

#[track_caller]
pub(super) fn unwrap<T>(result: perirobot_march::Result<T>) -> T {
    result.unwrap_or_else(|e| panic!("{e}"))
}

/// All that a backend says of a case: evidence, and counts.
fn said(backend: &mut dyn Backend, case: &Case) -> (Vec<Evidence>, Vec<Vec<[u64; COUNTERS]>>) {
    unwrap(backend.tables(&case.tables));
    unwrap(backend.load(&case.scene));
    let shots = case.shots.iter();
    let evidence = shots.map(|shot| unwrap(backend.read(shot.table, &shot.placement))).collect();
    for table in 0..case.tables.len() {
        let shots = case.shots.iter().filter(|shot| shot.table == table);
        let shots: Vec<_> = shots.map(|shot| Shot::once(shot.slot, shot.placement)).collect();
        unwrap(backend.sense(table, &shots));
    }
    unwrap(backend.upload(case.uploads.clone()));
    let counts = unwrap(backend.score(Fusion::OccupiedWins, &case.jobs));
    (evidence, counts.iter().map(|regions| regions.iter().map(Confusion::counts).collect()).collect())
}

#[track_caller]
fn same(case: &Case, expected: &(Vec<Evidence>, Vec<Vec<[u64; COUNTERS]>>), gpu: &mut Gpu, how: &str) {
    let rerun = format!(
        "case {}, {how}\nrerun: PERIROBOT_CASE={} cargo test --test backends cameras",
        case.seed, case.seed
    );
    let found = said(gpu, case);
    for (shot, (left, right)) in case.shots.iter().zip(found.0.iter().zip(&expected.0)) {
        let rays = &case.tables[shot.table];
        let place =
            format!("{shot:?} of {:?} {:?} in {:?}\n{rerun}", rays.image, rays.gates, case.scene.window);
        let ray = (0..left.ends.len()).find(|&ray| left.ends[ray] != right.ends[ray]);
        if let Some(ray) = ray {
            panic!("ray {ray}: {:?}, expected {:?}, {place}", left.ends[ray], right.ends[ray]);
        }
        for ((plane, left), (_, right)) in
            left.planes.planes_with_names().into_iter().zip(right.planes.planes_with_names())
        {
            let differs = |&voxel: &[i32; 3]| left.get(voxel) != right.get(voxel);
            let first = left.voxels().chain(right.voxels()).find(differs);
            assert!(first.is_none(), "{plane} {first:?}: {}, {place}", left.get(first.unwrap_or_default()));
            assert_eq!(left, right, "padding, {place}");
        }
    }
    assert_eq!(found.1, expected.1, "counts, {rerun}");
}

#[test]
fn cameras_equal_the_oracle_either_way() {
    let mut gpus = gpus();
    let one = std::env::var("PERIROBOT_CASE").ok().and_then(|seed| seed.parse().ok());
    let seeds = one.map_or(0..80, |seed: u64| seed..seed + 1);
    for seed in seeds {
        let case = seen(seed);
        let expected = said(&mut Oracle::default(), &case);
        for (gpu, number) in gpus.iter_mut().zip(0..) {
            for carving in [Some(Carving::ByVoxel), Some(Carving::ByRay), None] {
                gpu.carve_by(carving);
                same(&case, &expected, gpu, &format!("{carving:?}, as a GPU: {}", number == 1));
            }
        }
    }
}

/// As many pixels as real cameras have, before and inside a region, several placements at once: voxels that a
/// hundred thousand pixels may see, and more work an invocation than a software adapter's loops have turns.
#[test]
fn large_cameras_equal_the_cpu() {
    let Some(mut gpu) = gpu() else { return };
    let mut random = Random(7);
    let grid = Window::from_corners([0; 3], [99, 79, 59]);
    let mut truth = BitGrid::new(grid);
    for _ in 0..60 {
        let at = grid.size.map(|n| random.below(n) as i32);
        (0..6).for_each(|y| (0..9).for_each(|z| truth.set_run(at[0], at[0] + 5, at[1] + y, at[2] + z)));
    }
    // Its last boxes are cut off, and there is room behind them.
    let window = Window::from_corners([4, 3, 2], [72, 73, 57]);
    let mut region = BitGrid::new(window);
    (10..70).for_each(|z| (12..70).for_each(|y| region.set_run(20, 71, y, z)));
    let blank = || BitGrid::new(window);
    let (human, robot, blockers) = (blank(), blank(), truth.clone());
    let truth = truth.to_window(window);
    let scene = VoxelScene {
        shades: None,
        blockers: blockers.into(),
        over_time: None,
        window,
        truth,
        human,
        robot,
        regions: vec![region],
        people: Default::default(),
    };
    let camera = Camera { fov_rad: [1.5184, 1.0123], resolution_px: [1280, 720] };
    let gates = Gates {
        range_min_q16: 12 << 16,
        range_max_q16: 120 << 16,
        shade_ranges_q16: FULL_RANGE,
        along_axis: true,
        near_ignore_q16: 0,
        no_return_is_free: false,
        backdrop: true,
    };
    let noise = cases::steps((0..4096).map(|step| (step - 2048) * 80).collect(), 0);
    let rays = Rays { dirs_q15: camera.dirs_q15().into(), image: Some(camera.image()), gates, noise };
    // In front of the region, beside it, and inside.
    let origins = [[50, 2, 30], [55, 5, 35], [21, 40, 30], [5, 40, 30], [60, 40, 20], [97, 77, 57]];
    let mut shots = Vec::new();
    for (slot, origin) in (0..).zip(origins) {
        let origin_q16 = origin.map(|x| (x << 16) + random.below(1 << 16) as i32);
        // Along y, or turned by quarters.
        let along_y = [[32_768, 0, 0], [0, 0, 32_768], [0, -32_768, 0]];
        let axis_q15 = if slot % 2 == 0 { along_y } else { cases::quarter_turns(&mut random) };
        shots.push(Shot::once(slot, GridPose { origin_q16, axis_q15, truly: None, draws: slot }));
    }
    let job =
        |shot: &Shot| vec![Reading { slot: shot.slot, volume: None, hit: 847, miss: -405, presence: false }];
    let jobs: Vec<_> = shots.iter().map(job).collect();
    let mut cpu = Cpu::new(Some(2)).unwrap_or_else(|e| panic!("{e}"));
    let counts = [&mut cpu as &mut dyn Backend, &mut gpu].map(|backend| {
        unwrap(backend.tables(std::slice::from_ref(&rays)));
        unwrap(backend.load(&scene));
        unwrap(backend.sense(0, &shots));
        let counts = unwrap(backend.score(Fusion::OccupiedWins, &jobs));
        let counts: Vec<_> = counts.iter().map(|regions| regions[0].counts()).collect();
        let whole = [0, 3].map(|i: usize| unwrap(backend.read(0, &shots[i].placement)).planes);
        (counts, whole)
    });
    assert!(counts[1].1 == counts[0].1, "planes over the whole window");
    let counts = counts.map(|(counts, _)| counts);
    assert_eq!(counts[1], counts[0], "the GPU's counts, then the CPU's");
    assert!(counts[0].iter().filter(|c| c[3] > 5000).count() >= 3, "many voxels are free: {:?}", counts[0]);
}

/// A room with things in it and before its walls, and with windows and small holes in them, or none.
pub(super) fn room(random: &mut Random) -> VoxelScene {
    let more = random.of(&[40, 40, 200]);
    let grid = Window { min: [0; 3], size: [50, 40, 30].map(|n| n + random.below(more)) };
    let mut blockers = BitGrid::full(grid);
    let thickness = [1, 1, 1].map(|n| n + random.below(2) as i32);
    let inside =
        Window::from_corners(thickness, [0, 1, 2].map(|r| grid.size[r] as i32 - 1 - random.between(1, 2)));
    blockers.remove(&BitGrid::full(inside).to_window(grid));
    for _ in 0..random.below(5) {
        let thing = cases::inner(random, Window { size: inside.size.map(|n| n / 3), ..inside });
        let min = [0, 1, 2].map(|r| thing.min[r] + random.below(2 * inside.size[r] / 3) as i32);
        blockers.add(&BitGrid::full(Window { min, ..thing }).to_window(grid));
    }
    let any = |random: &mut Random| grid.size.map(|n| random.below(n) as i32);
    let mut holes = BitGrid::new(grid);
    for _ in 0..random.of(&[0, 20, 400]) {
        blockers.set(any(random));
        holes.set(any(random));
    }
    for _ in 0..random.below(8) {
        let size = [0; 3].map(|_| 2 + random.below(8));
        holes.add(&BitGrid::full(Window { min: any(random), size }).to_window(grid));
    }
    blockers.remove(&holes);
    // All that stands still, or all but a part of it.
    let over_time = random.one_in(3).then(|| {
        let mut always = blockers.clone();
        always.remove(&BitGrid::full(cases::inner(random, grid)).to_window(grid));
        std::sync::Arc::new(OverTime { always: always.into(), ever: blockers.clone().into() })
    });
    let window = cases::inner(random, inside);
    let region = |random: &mut Random| BitGrid::full(cases::inner(random, window)).to_window(window);
    VoxelScene {
        shades: None,
        truth: blockers.to_window(window),
        over_time,
        window,
        human: BitGrid::new(window),
        robot: BitGrid::new(window),
        regions: vec![region(random), region(random)],
        people: Default::default(),
        blockers: blockers.into(),
    }
}

/// Cameras in rooms, where most tiles are before a wall: whether it is behind a region or in it, whole or not, and near voxels
/// before it. Some have many pixels a voxel, and some few; some are off, and what stands still may be known.
#[test]
fn rooms_equal_the_oracle() {
    let mut gpus = gpus();
    let one = std::env::var("PERIROBOT_CASE").ok().and_then(|seed| seed.parse().ok());
    for seed in one.map_or(0..60, |seed: u64| seed..seed + 1) {
        let mut random = Random(seed ^ 0x4003);
        let scene = room(&mut random);
        let camera = Camera {
            fov_rad: random.of(&[[1.5, 1.0], [0.9, 0.7], [0.3, 0.2]]),
            // As many as real cameras have once in a while: much is near then.
            resolution_px: match seed % 20 {
                9 => [641, 402],
                _ => [24, 16].map(|n| random.of(&[n, 2 * n, 6 * n]) + random.below(9)),
            },
        };
        let gates = Gates {
            range_max_q16: random.of(&[2047 << 16, 2047 << 16, 60 << 16]),
            shade_ranges_q16: FULL_RANGE,
            range_min_q16: random.of(&[0, 0, 5 << 16]),
            along_axis: random.one_in(2),
            near_ignore_q16: random.of(&[0, 0, 5 << 16]),
            no_return_is_free: random.one_in(2),
            backdrop: random.one_in(3),
        };
        let noise = if random.one_in(2) { Noise::default() } else { cases::noise(&mut random) };
        let rays = Rays { dirs_q15: camera.dirs_q15().into(), image: Some(camera.image()), gates, noise };
        // In the room, more often than not where it matters.
        let shots = (0..6).map(|slot| {
            let around = if random.one_in(3) { scene.blockers.window() } else { scene.window };
            let origin_q16 =
                [0, 1, 2].map(|r| (around.min[r] << 16) + random.below(around.size[r] << 16) as i32);
            let axis_q15 =
                if random.one_in(3) { cases::quarter_turns(&mut random) } else { cases::turned(&mut random) };
            let truly =
                random.one_in(5).then(|| cases::standpoint(&mut random, &scene, origin_q16, axis_q15));
            let placement = GridPose { origin_q16, axis_q15, truly, draws: slot };
            Shot { slot, placement, first_hits: scene.over_time.as_ref().map(|_| slot) }
        });
        let shots: Vec<_> = shots.collect();
        let alone = |shot: &Shot| {
            vec![Reading { slot: shot.slot, volume: None, hit: 847, miss: -405, presence: false }]
        };
        let jobs: Vec<_> = shots.iter().map(alone).collect();
        let counts = |backend: &mut dyn Backend| {
            unwrap(backend.tables(std::slice::from_ref(&rays)));
            unwrap(backend.load(&scene));
            unwrap(backend.sense(0, &shots));
            let counts = unwrap(backend.score(Fusion::OccupiedWins, &jobs));
            counts.iter().flatten().map(Confusion::counts).collect::<Vec<_>>()
        };
        let expected = counts(&mut Oracle::default());
        let rerun = format!("rerun: PERIROBOT_CASE={seed} cargo test --test backends cameras::rooms");
        assert_eq!(counts(&mut unwrap(Cpu::new(Some(1)))), expected, "the CPU's counts, {rerun}");
        for (gpu, number) in gpus.iter_mut().zip(0..) {
            for carving in [Some(Carving::ByVoxel), None] {
                gpu.carve_by(carving);
                let how = format!("{carving:?}, as a GPU: {}", number == 1);
                assert_eq!(counts(gpu), expected, "the GPU's counts, {how}, {rerun}");
            }
        }
    }
    if one.is_none() {
        gpus.iter().skip(1).for_each(|gpu| assert!(dispatched(gpu, "cast_listed")[1] > 100));
    }
}

/// Answers come in the order of the questions, each as of when it was asked.
#[test]
fn questions_may_wait() {
    let Some(mut gpu) = gpu() else { return };
    let case = (0..)
        .map(seen)
        .find(|case| case.scene.regions.iter().any(|r| r.count() > 1000))
        .expect("some region");
    let placements: Vec<GridPose> = case.shots.iter().map(|shot| shot.placement).collect();
    let job = |slot| vec![Reading { slot, volume: None, hit: 847, miss: -405, presence: false }];
    unwrap(gpu.tables(&case.tables));
    unwrap(gpu.load(&case.scene));
    let mut alone = Vec::new();
    for &placement in &placements {
        unwrap(gpu.sense(0, &[Shot::once(3, placement)]));
        alone.push(unwrap(gpu.score(Fusion::OccupiedWins, &[job(3)])));
    }
    for &placement in &placements {
        unwrap(gpu.sense(0, &[Shot::once(3, placement)]));
        unwrap(gpu.submit(Fusion::OccupiedWins, &[job(3)]));
    }
    let later: Vec<_> = placements.iter().map(|_| unwrap(gpu.receive())).collect();
    assert_eq!(format!("{later:?}"), format!("{alone:?}"));
    assert!(alone.windows(2).any(|pair| format!("{:?}", pair[0]) != format!("{:?}", pair[1])), "all alike");
    assert!(gpu.receive().is_err(), "no question is open");
}

/// What a still layer stops is found once, and holds for every snapshot.
#[test]
fn hits_are_kept_from_snapshot_to_snapshot() {
    let Some(mut gpu) = gpu() else { return };
    for seed in 0..30 {
        let case = seen(seed);
        let mut random = Random(seed);
        let mut still = BitGrid::clone(&case.scene.blockers);
        let moving: Vec<_> = still.voxels().filter(|_| random.one_in(3)).collect();
        let mut first = BitGrid::new(still.window());
        moving.iter().for_each(|&voxel| first.set(voxel));
        still.remove(&first);
        let ever = BitGrid::clone(&case.scene.blockers);
        let over_time = std::sync::Arc::new(OverTime { always: still.clone().into(), ever: ever.into() });
        for (number, part) in [2, 3, 1].into_iter().enumerate() {
            let mut blockers = BitGrid::clone(&still);
            moving.iter().step_by(part).for_each(|&voxel| blockers.set(voxel));
            let scene = VoxelScene { blockers: blockers.into(), ..case.scene.clone() };
            let snapshot = Case { scene, ..seen(seed) };
            let mut oracle = Oracle::default();
            unwrap(oracle.tables(&case.tables));
            unwrap(oracle.load(&snapshot.scene));
            let with_still = VoxelScene { over_time: Some(over_time.clone()), ..snapshot.scene.clone() };
            if number == 0 {
                unwrap(gpu.tables(&case.tables));
            }
            unwrap(gpu.load(&with_still));
            assert!(gpu.first_hit_slots() > case.shots.len());
            for backend in [&mut gpu as &mut dyn Backend, &mut oracle] {
                for (first_hits, shot) in (0..).zip(&case.shots) {
                    let shots =
                        [Shot { slot: shot.slot, placement: shot.placement, first_hits: Some(first_hits) }];
                    unwrap(backend.sense(shot.table, &shots));
                }
            }
            let [found, expected] = [&mut gpu as &mut dyn Backend, &mut oracle]
                .map(|backend| format!("{:?}", unwrap(backend.score(Fusion::Octomap, &case.jobs))));
            assert_eq!(found, expected, "case {seed}, snapshot {number}");
        }
    }
}
