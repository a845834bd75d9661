//! Cameras in the middle of what matters: voxels so near that most of an image may see them, before blockers and behind them.
//! Every count is the oracle's. `PERIROBOT_CASE=<seed>` runs one case.

use super::cameras::{counts_alone, gpus, unwrap};
use crate::common::Random;
use crate::common::cases;
use perirobot_march::backend::cpu::Cpu;
use perirobot_march::backend::gpu::Gpu;
use perirobot_march::backend::oracle::Oracle;
use perirobot_march::backend::{Backend, Carving, GridPose, Noise, Rays, Shot, VoxelScene};
use perirobot_march::march::{FULL_RANGE, Gates};
use perirobot_march::voxel::{BitGrid, Window};
use perirobot_study::sensor::Camera;

/// A scene of blockers of which all matters that is in a window.
fn scene(blockers: BitGrid, window: Window) -> VoxelScene {
    VoxelScene {
        shades: None,
        truth: blockers.to_window(window),
        over_time: None,
        window,
        human: BitGrid::new(window),
        robot: BitGrid::new(window),
        regions: vec![BitGrid::full(window)],
        people: Default::default(),
        blockers: blockers.into(),
    }
}

/// A wall through a grid, with or without a hole, and where a camera stands before it or in it: each camera has a few blockers
/// about it.
fn walled(random: &mut Random) -> (VoxelScene, Vec<[i32; 3]>) {
    let grid = Window { min: [0; 3], size: [34, 30, 26].map(|n| n + random.below(12)) };
    let axis = random.below(3) as usize;
    let mut wall = grid;
    wall.min[axis] = random.between(6, grid.size[axis] as i32 - 8);
    wall.size[axis] = 1 + random.below(2);
    let mut blockers = BitGrid::full(wall).to_window(grid);
    if random.one_in(2) {
        blockers.remove(&BitGrid::full(cases::inner(random, wall)).to_window(grid));
    }
    let stands = (0..4).map(|_| {
        let mut stand = grid.size.map(|n| random.between(4, n as i32 - 5));
        // Right before the wall or behind it, or in it.
        stand[axis] = wall.min[axis] + random.between(-1, wall.size[axis] as i32);
        for _ in 0..random.below(6) {
            blockers.set([0, 1, 2].map(|r| stand[r] + random.between(-4, 4)));
        }
        stand
    });
    let stands = stands.collect();
    let window = if random.one_in(2) {
        grid
    } else {
        let margin = [0; 3].map(|_| random.below(4));
        Window {
            min: margin.map(|n| n as i32),
            size: std::array::from_fn(|r| grid.size[r] - margin[r] - random.below(3)),
        }
    };
    (scene(blockers, window), stands)
}

/// A camera of few or many pixels, as wide as a half sphere or as narrow as a slit.
fn camera(random: &mut Random, seed: u64) -> Rays {
    let camera = Camera {
        fov_rad: random.of(&[[1.5, 1.0], [0.2, 0.3], [2.6, 2.4], [2.8, 0.1], [0.05, 1.7]]),
        // More than may be near on nearly all places once in a while.
        resolution_px: match seed % 12 {
            5 => [470, 410],
            7 => [3, 9],
            _ => random.of(&[[97, 66], [160, 121], [2, 301], [333, 5], [64, 64]]),
        },
    };
    let noise = if random.one_in(2) { Noise::default() } else { cases::noise(random) };
    // More than that overflows along slanted rays; no sensor has it.
    let is_moderate = noise.unit_q12.iter().all(|unit| unit.abs() < 6 << 16);
    let gates = Gates {
        range_min_q16: random.of(&[0, 0, 1 << 15, 2 << 16]),
        range_max_q16: random.of(&[2047 << 16, 12 << 16, 2 << 16]),
        shade_ranges_q16: FULL_RANGE,
        along_axis: random.one_in(2) && is_moderate,
        near_ignore_q16: random.of(&[0, 0, 1 << 15, 2 << 16]),
        no_return_is_free: random.one_in(2),
        backdrop: random.one_in(3),
    };
    Rays { dirs_q15: camera.dirs_q15().into(), image: Some(camera.image()), gates, noise }
}

/// Workgroups of the kernel of near voxels so far.
fn groups_of_near(gpu: &Gpu) -> u64 {
    gpu.timings().iter().filter(|timing| timing.stage == "carve_near").map(|timing| timing.lanes / 64).sum()
}

#[test]
fn cameras_before_walls_equal_the_oracle() {
    let mut gpus = gpus();
    let one = std::env::var("PERIROBOT_CASE").ok().and_then(|seed| seed.parse().ok());
    for seed in one.map_or(0..72, |seed: u64| seed..seed + 1) {
        let mut random = Random(seed ^ 0x2ea2);
        let (scene, stands) = walled(&mut random);
        let rays = camera(&mut random, seed);
        let shots = (0..).zip(stands).map(|(slot, stand)| {
            // Anywhere in its voxel, or on its faces.
            let inside = stand.map(|_| random.of(&[0, 1, 1 << 15, 65_535]));
            let anywhere = stand.map(|_| random.below(1 << 16) as i32);
            let within = if random.one_in(2) { inside } else { anywhere };
            let origin_q16 = std::array::from_fn(|r| (stand[r] << 16) + within[r]);
            let axis_q15 =
                if random.one_in(2) { cases::quarter_turns(&mut random) } else { cases::turned(&mut random) };
            let truly =
                random.one_in(4).then(|| cases::standpoint(&mut random, &scene, origin_q16, axis_q15));
            Shot::once(slot, GridPose { origin_q16, axis_q15, truly, draws: slot })
        });
        let shots: Vec<_> = shots.collect();
        let expected = counts_alone(&mut Oracle::default(), &scene, &rays, &shots);
        let rerun = format!("rerun: PERIROBOT_CASE={seed} cargo test --test backends near");
        assert_eq!(
            counts_alone(&mut unwrap(Cpu::new(Some(1))), &scene, &rays, &shots),
            expected,
            "the CPU, {rerun}"
        );
        for (gpu, number) in gpus.iter_mut().zip(0..) {
            gpu.carve_by(Some(Carving::ByVoxel));
            let found = counts_alone(gpu, &scene, &rays, &shots);
            let image = rays.image;
            assert_eq!(found, expected, "{image:?} {shots:?}, as a GPU: {}, {rerun}", number == 1);
        }
    }
    if one.is_none() {
        assert!(gpus.iter().all(|gpu| groups_of_near(gpu) > 10_000), "most cases have near voxels");
    }
}

/// An image of more tiles than a workgroup goes through, of which voxels behind the camera and before it are near.
#[test]
fn large_images_share_their_near_voxels() {
    let mut gpus = gpus();
    let mut random = Random(0x2ea2);
    let grid = Window { min: [0; 3], size: [40, 30, 30] };
    let mut blockers = BitGrid::full(Window { min: [12, 0, 0], size: [1, 30, 30] }).to_window(grid);
    for _ in 0..60 {
        blockers.set([15, 15, 15].map(|n| n + random.between(-3, 3)));
    }
    let scene = scene(blockers, Window { min: [9, 8, 8], size: [20, 14, 14] });
    let camera = Camera { fov_rad: [1.7, 1.1], resolution_px: [1900, 1300] };
    let gates = cases::open_gates();
    let image = Some(camera.image());
    let rays = Rays { dirs_q15: camera.dirs_q15().into(), image, gates, noise: cases::noise(&mut random) };
    let shots = (0..3).map(|slot| {
        let origin_q16 = [(13 << 16) + 900, 15 << 16, 15 << 16].map(|n| n + random.below(1 << 14) as i32);
        // Along x, or turned anywhere.
        let along_x = [[0, 0, 32_768], [32_768, 0, 0], [0, 32_768, 0]];
        let axis_q15 = if slot == 0 { along_x } else { cases::turned(&mut random) };
        Shot::once(slot, GridPose { origin_q16, axis_q15, truly: None, draws: slot })
    });
    let shots: Vec<_> = shots.collect();
    let expected = counts_alone(&mut unwrap(Cpu::new(Some(2))), &scene, &rays, &shots);
    assert!(expected.iter().all(|c| c[3] > 20), "each sees free voxels: {expected:?}");
    for gpu in &mut gpus {
        gpu.carve_by(Some(Carving::ByVoxel));
        assert_eq!(counts_alone(gpu, &scene, &rays, &shots), expected, "the GPU's counts, then the CPU's");
        // Three share each.
        assert!(groups_of_near(gpu) >= 3 * 128 && groups_of_near(gpu).is_multiple_of(3 * 128));
    }
}
