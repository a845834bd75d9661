//! Cameras in the large batches and on the kernels of a GPU, also on a software adapter: every count is the CPU's.

use super::cameras::{counts_alone, dispatched, gpus, room, unwrap};
use crate::common::Random;
use crate::common::cases;
use perirobot_march::backend::cpu::Cpu;
use perirobot_march::backend::{Carving, GridPose, Noise, Rays, Shot, VoxelScene};
use perirobot_march::march::Gates;
use perirobot_march::voxel::{BitGrid, Window};
use perirobot_study::sensor::Camera;

/// As many cameras as a GPU takes at once, in one batch and one dispatch of each kernel.
#[test]
fn a_batch_of_80_cameras_equals_the_cpu() {
    let Some(mut gpu) = gpus().pop() else { return };
    let mut random = Random(0x64);
    let scene = (0..)
        .map(|_| room(&mut random))
        .find(|scene| scene.over_time.is_none() && scene.window.size.iter().all(|&n| (16..60).contains(&n)));
    let scene = scene.expect("some room");
    let camera = Camera { fov_rad: [1.5, 1.0], resolution_px: [170, 113] };
    let gates = Gates { range_max_q16: 300 << 16, ..cases::open_gates() };
    let noise = cases::noise(&mut random);
    let rays = Rays { dirs_q15: camera.dirs_q15().into(), image: Some(camera.image()), gates, noise };
    let shots = (0..80).map(|slot| {
        let around = if slot % 2 == 0 { scene.blockers.window() } else { scene.window };
        let origin_q16 = [0, 1, 2].map(|r| (around.min[r] << 16) + random.below(around.size[r] << 16) as i32);
        let axis_q15 = cases::turned(&mut random);
        Shot::once(slot, GridPose { origin_q16, axis_q15, truly: None, draws: slot })
    });
    let shots: Vec<_> = shots.collect();
    let expected = counts_alone(&mut unwrap(Cpu::new(Some(2))), &scene, &rays, &shots);
    gpu.carve_by(Some(Carving::ByVoxel));
    assert_eq!(counts_alone(&mut gpu, &scene, &rays, &shots), expected, "the GPU's counts, then the CPU's");
    for kernel in ["see_tiles", "cast_tiles", "cast_listed", "pyramid", "carve_boxes"] {
        assert_eq!(dispatched(&gpu, kernel), [1, 80], "{kernel}");
    }
    assert!(expected.iter().filter(|c| c[3] > 100).count() > 20, "many see free voxels: {expected:?}");
}

/// A box of voxels that thousands of tiles see, each of its cubes most of them.
#[test]
fn one_box_in_front_of_a_camera_equals_the_cpu() {
    let mut gpus = gpus();
    let mut cpu = unwrap(Cpu::new(Some(2)));
    let camera = Camera { fov_rad: [1.2, 0.9], resolution_px: [641, 402] };
    let gates = Gates { range_max_q16: 100 << 16, ..cases::open_gates() };
    let image = Some(camera.image());
    let rays = Rays { dirs_q15: camera.dirs_q15().into(), image, gates, noise: Noise::default() };
    for seed in 0..12 {
        let mut random = Random(seed);
        let grid = Window { min: [0; 3], size: [60; 3] };
        let window = Window { min: [26; 3], size: [0; 3].map(|_| random.between(5, 8) as u32) };
        let mut blockers = BitGrid::full(grid);
        blockers.remove(&BitGrid::full(Window { min: [1; 3], size: [58; 3] }).to_window(grid));
        for _ in 0..12 {
            blockers.set([0, 1, 2].map(|r| window.min[r] + random.below(window.size[r]) as i32));
        }
        let scene = VoxelScene {
            shades: None,
            truth: blockers.to_window(window),
            over_time: None,
            window,
            human: BitGrid::new(window),
            robot: BitGrid::new(window),
            regions: vec![BitGrid::full(window)],
            people: Default::default(),
            blockers: blockers.into(),
        };
        let shots = (0..6).map(|slot| {
            // Ahead along an axis, not far beside it.
            let [a, b, c] = [[0, 1, 2], [1, 2, 0], [2, 0, 1]][slot as usize % 3];
            let mut axis_q15 = [[0; 3]; 3];
            (axis_q15[b][0], axis_q15[c][1], axis_q15[a][2]) = (32_768, 32_768, 32_768);
            let mut origin_q16 = [0; 3].map(|_| (30 << 16) + random.between(-5 << 16, 5 << 16));
            origin_q16[a] = (26 << 16) - random.between(3 << 16, 12 << 16);
            Shot::once(slot, GridPose { origin_q16, axis_q15, truly: None, draws: slot })
        });
        let shots: Vec<_> = shots.collect();
        let expected = counts_alone(&mut cpu, &scene, &rays, &shots);
        assert!(expected.iter().all(|c| c[3] > 20), "each sees free voxels: {expected:?}");
        for gpu in &mut gpus {
            gpu.carve_by(Some(Carving::ByVoxel));
            assert_eq!(counts_alone(gpu, &scene, &rays, &shots), expected, "the GPU's counts, seed {seed}");
        }
    }
}
