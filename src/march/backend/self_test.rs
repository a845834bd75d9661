//! Tests whether a device counts correctly: a camera of many pixels in a cluttered scene, a whole batch of
//! poses, compared with the CPU. Some poses stand so close to what they see that every kernel has long loops.

use super::cpu::Cpu;
use super::{Backend, Fusion, GridPose, Image, Noise, Rays, Reading, Shot, VoxelScene};
use crate::error::Issue;
use crate::march::{FULL_RANGE, Gates, pcg};
use crate::metrics::{BodyPart, Confusion};
use crate::voxel::{BitGrid, BodyVoxel, People, Window};
use crate::{Error, Result};

/// Poses of the camera, a batch of them.
pub const POSES: u32 = 8;

/// Compares all counts of the test with those of the CPU.
///
/// # Errors
/// `Error::Device` if the device fails, or finds out itself that it did not do all of its work;
/// `Error::Disagreement` if it counts otherwise than the CPU.
pub fn self_test(backend: &mut dyn Backend) -> Result<()> {
    let (found, expected) = (counts(backend)?, counts(&mut Cpu::new(None)?)?);
    if let Some(i) = (0..expected.len()).find(|&i| found.get(i) != Some(&expected[i])) {
        let of = |counts: &[Vec<u64>]| counts.get(i).cloned().unwrap_or_default();
        return Err(Error::Disagreement(Issue::says(format!(
            "{}: of {} lists of counts, number {i} is {:?}, on the CPU {:?}",
            backend.device(),
            expected.len(),
            of(&found),
            of(&expected)
        ))));
    }
    Ok(())
}

/// The counts of each pose alone and of all together, in both rules of fusion and each region.
fn counts(backend: &mut dyn Backend) -> Result<Vec<Vec<u64>>> {
    backend.tables(&[camera()])?;
    backend.load(&scene())?;
    // As many at once as there is room for: a few poses of a camera always fit.
    let slots = POSES.min(backend.slots() as u32);
    let shots: Vec<_> = (0..slots).map(|slot| Shot::once(slot, placement(slot))).collect();
    backend.sense(0, &shots)?;
    let reading = |slot| Reading { slot, volume: None, hit: 847, miss: -405, presence: slot % 2 == 0 };
    let alone = (0..slots).map(|slot| vec![reading(slot)]);
    let jobs: Vec<_> = alone.chain([(0..slots).map(reading).collect()]).collect();
    let mut all = Vec::new();
    for fusion in [Fusion::OccupiedWins, Fusion::Octomap] {
        let scored = backend.score(fusion, &jobs)?;
        all.extend(scored.iter().flatten().map(Confusion::numbers));
    }
    Ok(all)
}

/// 800 × 600 pixels, narrow enough for many of them to see the same voxel.
pub(super) fn camera() -> Rays {
    let (size_px, focal_px) = ([800u32, 600u32], [700.0, 700.0]);
    let pixel = |i: u32| {
        let (u, v) = (i % size_px[0], i / size_px[0]);
        let along =
            |at: u32, axis: usize| (f64::from(at) + 0.5 - f64::from(size_px[axis]) / 2.0) / focal_px[axis];
        let ray = [along(u, 0), along(v, 1), 1.0];
        let length = libm::sqrt(ray.iter().map(|x| x * x).sum());
        ray.map(|x| libm::round(x / length * 32_768.0) as i32)
    };
    let gates = Gates {
        range_min_q16: 0,
        range_max_q16: 150 << 16,
        shade_ranges_q16: FULL_RANGE,
        along_axis: true,
        near_ignore_q16: 0,
        no_return_is_free: false,
        backdrop: false,
    };
    let dirs_q15 = (0..size_px[0] * size_px[1]).map(pixel).collect::<Vec<_>>().into();
    Rays { dirs_q15, image: Some(Image { size_px, focal_px }), gates, noise: Noise::default() }
}

/// A room of columns and clutter, 140 × 120 × 60 voxels, with a person and a robot in it.
pub(super) fn scene() -> VoxelScene {
    let grid = Window::from_corners([0; 3], [139, 119, 59]);
    let block = |min: [i32; 3], max: [i32; 3]| BitGrid::full(Window::from_corners(min, max)).to_window(grid);
    let mut truth = block([0, 0, 0], [139, 119, 0]);
    truth.add(&block([139, 0, 0], [139, 119, 59]));
    for column in 0..14u32 {
        let at = |salt: u32, n: u32| (pcg(column * 3 + salt) % n) as i32;
        let (x, y) = (15 + at(0, 110), 10 + at(1, 100));
        truth.add(&block([x, y, 1], [x + 3, y + 3, 10 + at(2, 49)]));
    }
    for voxel in 0..400u32 {
        let at = |salt: u32, n: u32| (pcg(1000 + voxel * 3 + salt) % n) as i32;
        truth.set([at(0, 140), at(1, 120), at(2, 60)]);
    }
    let (human, robot) = (block([60, 50, 1], [67, 60, 35]), block([90, 70, 1], [96, 76, 24]));
    truth.add(&human);
    truth.add(&robot);
    let blockers = truth.clone().into();
    let window = Window::from_corners([20, 20, 0], [119, 99, 54]);
    let near = Window::from_corners([50, 40, 0], [100, 80, 40]);
    let regions = vec![BitGrid::full(window), BitGrid::full(near).to_window(window)];
    let [truth, human, robot] = [truth, human, robot].map(|plane| plane.to_window(window));
    // A part every five layers.
    let part = |[.., z]: [i32; 3]| BodyPart::ALL[z as usize / 5 % BodyPart::ALL.len()];
    let voxels = human.voxels().map(|voxel| BodyVoxel { voxel, person: 0, part: part(voxel) }).collect();
    let people = People { min_hits: 3, voxels };
    VoxelScene { shades: None, blockers, over_time: None, window, truth, human, robot, regions, people }
}

/// Around the room and amid the clutter, turned by eighths of a circle, level or tilted down.
pub(super) fn placement(number: u32) -> GridPose {
    let corners = [[5, 5, 40], [130, 6, 50], [10, 110, 30], [128, 112, 45]];
    let amid = [[40, 50, 20], [75, 45, 15], [105, 60, 25], [70, 90, 10]];
    let voxel = if number.is_multiple_of(2) {
        corners[number as usize / 2 % 4]
    } else {
        amid[number as usize / 2 % 4]
    };
    let yaw = f64::from(number) * std::f64::consts::FRAC_PI_4 + 0.3;
    let pitch = if number.is_multiple_of(3) { 0.0 } else { 0.5 };
    let forward = [libm::cos(yaw) * libm::cos(pitch), libm::sin(yaw) * libm::cos(pitch), -libm::sin(pitch)];
    let right = [libm::sin(yaw), -libm::cos(yaw), 0.0];
    let down = std::array::from_fn::<f64, 3, _>(|r| {
        let (a, b) = ((r + 1) % 3, (r + 2) % 3);
        forward[a] * right[b] - forward[b] * right[a]
    });
    let q15 = |x: f64| libm::round(x * 32_768.0) as i32;
    GridPose {
        origin_q16: voxel.map(|c: i32| (c << 16) + 0x6789),
        axis_q15: std::array::from_fn(|r| [q15(right[r]), q15(down[r]), q15(forward[r])]),
        truly: None,
        draws: 0,
    }
}
