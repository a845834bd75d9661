//! Whose draws are whose, and what a noisy sensor measures of a flat wall.

use super::*;
use crate::sensor::kinds::rays::RaySet;
use crate::sensor::noise::{self, Deviation};
use crate::sensor::range::{Along, Range, ReflectanceRanges};
use crate::sensor::{RayScale, draws, look, placement};
use perirobot_march::march;

#[test]
fn the_words_are_folded_in_their_order() {
    let seed = 0x0123_4567_89ab_cdef;
    let [scene, snapshot, sensor, pose, repeat] = [3, 1, 4, 1_000_000, 9];
    let words = [0x89ab_cdef, 0x0123_4567, scene, snapshot, sensor, pose, repeat];
    let expected = words.iter().fold(0, |hash, &word| pcg(hash ^ word));
    assert_eq!(u64::from(draws(seed, [3, 1, 4, 1_000_000, 9])), expected);
    let ray = 77;
    let drawn = march::draw(draws(seed, [3, 1, 4, 1_000_000, 9]), ray);
    assert_eq!(u64::from(drawn), pcg(expected ^ u64::from(ray)));
    // Each word counts, and so does its place.
    let all: std::collections::HashSet<u32> = [
        draws(seed, [3, 1, 4, 1_000_000, 9]),
        draws(seed ^ 1 << 63, [3, 1, 4, 1_000_000, 9]),
        draws(seed ^ 1, [3, 1, 4, 1_000_000, 9]),
        draws(seed, [1, 3, 4, 1_000_000, 9]),
        draws(seed, [3, 4, 1, 1_000_000, 9]),
        draws(seed, [3, 1, 1_000_000, 4, 9]),
        draws(seed, [3, 1, 4, 9, 1_000_000]),
        draws(seed, [3, 1, 4, 1_000_000, 8]),
    ]
    .into();
    assert_eq!(all.len(), 8);
}

const RAYS: usize = 20_000;
const STD_VOXELS: f64 = 3.0;

#[test]
fn a_flat_wall_is_measured_with_the_tables_mean_and_deviation() {
    let mut truth = empty([100, 1, 1], 0.02);
    put(&mut truth, Role::Environment, &[[50, 0, 0]], None);
    let range = Range {
        reflectance: ReflectanceRanges::NONE,
        range_m: [0.0, 2.0],
        along: Along::Ray,
        near_ignore_m: 0.0,
        no_return_is_free: false,
        noise: Deviation { std_m: STD_VOXELS * 0.02, ..Deviation::NONE },
        dropout: 0.0,
        calibration: None,
    };
    let kind = RaySet { dirs_q15: vec![[32_768, 0, 0]; RAYS], range };
    let rays = kind.rays(&RayScale::new(0.02, false)).unwrap();
    let pose = Pose::upright(DVec3::splat(0.01), DVec3::X, 0.0);
    let from = placement(&kind, &pose, &truth.grid, draws(1, [0; 5]));
    let found: Vec<_> = look::returns(look::Obstacles::of(&truth), &rays, &from).collect();
    assert!(found.iter().all(|f| f.hit == [50, 0, 0] && f.distance_q16 == 49 * 65_536 + 32_768));
    let read: Vec<f64> = found.iter().map(|f| f64::from(f.read[0] - 50)).collect();
    // The wall is met on the boundary of its voxel, and a voxel is read for all distances inside it.
    let told: Vec<f64> = noise::unit_q12().iter().map(|&z| f64::from((48 * z) >> 16)).collect();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let std = |values: &[f64]| {
        let m = mean(values);
        mean(&values.iter().map(|v| (v - m).powi(2)).collect::<Vec<_>>()).sqrt()
    };
    assert_eq!(read.len(), RAYS);
    // Four standard errors.
    let close = 4.0 * STD_VOXELS / (RAYS as f64).sqrt();
    assert!((mean(&read) - mean(&told)).abs() < close && (mean(&told) + 0.5).abs() < 0.01, "{}", mean(&read));
    assert!((std(&read) - std(&told)).abs() < close && (std(&told) - 3.014).abs() < 0.01, "{}", std(&read));
    // Neighbours draw for themselves: how much one tells of the next is what chance leaves.
    let m = mean(&read);
    let products: Vec<f64> = read.windows(2).map(|w| (w[0] - m) * (w[1] - m)).collect();
    assert!(mean(&products).abs() < 4.0 * 9.0 / (RAYS as f64).sqrt(), "{}", mean(&products));
}

/// A wall at 10 m and one at 90 m, a ray each way, over and over.
#[test]
fn distances_scatter_as_much_as_the_model_says_where_they_are_measured() {
    let mut truth = empty([1001, 1, 1], 0.1);
    put(&mut truth, Role::Environment, &[[0, 0, 0], [1000, 0, 0]], None);
    // At 10 m 0.05 + 0.1 + 0.1 = 0.25 m, at 90 m 0.05 + 0.9 + 8.1 = 9.05 m, cut to 64 voxels, which are 6.4
    // m.
    let noise = Deviation { std_m: 0.05, per_m: 0.01, per_m2: 0.001 };
    let range = Range {
        reflectance: ReflectanceRanges::NONE,
        range_m: [0.0, 100.0],
        along: Along::Ray,
        near_ignore_m: 0.0,
        no_return_is_free: false,
        noise,
        dropout: 0.0,
        calibration: None,
    };
    let dirs_q15 = (0..RAYS as i32).map(|ray| [32_768 * (ray % 2 * 2 - 1), 0, 0]).collect();
    let kind = RaySet { dirs_q15, range };
    let rays = kind.rays(&RayScale::new(0.1, false)).unwrap();
    let pose = Pose::upright(DVec3::new(10.05, 0.05, 0.05), DVec3::X, 0.0);
    let from = placement(&kind, &pose, &truth.grid, draws(1, [0; 5]));
    let mut off = [Vec::new(), Vec::new()];
    for (found, ray) in look::returns(look::Obstacles::of(&truth), &rays, &from).zip(0..) {
        let drawn = march::draw(from.draws, ray);
        let step_m =
            0.1 * f64::from(rays.noise.step_q16(rays.gates.slant(0), drawn, found.distance_q16)) / 65_536.0;
        off[(found.hit[0] > 0) as usize].push(step_m);
    }
    for (off, expected) in off.iter().zip([0.25, 6.4]) {
        let std = (off.iter().map(|m| m * m).sum::<f64>() / off.len() as f64).sqrt();
        assert!(off.len() == RAYS / 2 && (std / expected - 1.0).abs() < 0.04, "{std}, not {expected}");
    }
}

#[test]
fn as_many_returns_are_lost_as_the_study_says_whatever_their_noise() {
    let mut truth = empty([100, 1, 1], 0.02);
    put(&mut truth, Role::Environment, &[[50, 0, 0]], None);
    let noise = Deviation { std_m: 0.06, ..Deviation::NONE };
    let range = |dropout| Range {
        reflectance: ReflectanceRanges::NONE,
        range_m: [0.0, 2.0],
        along: Along::Ray,
        near_ignore_m: 0.0,
        no_return_is_free: false,
        noise,
        dropout,
        calibration: None,
    };
    let found = |dropout| {
        let kind = RaySet { dirs_q15: vec![[32_768, 0, 0]; RAYS], range: range(dropout) };
        let rays = kind.rays(&RayScale::new(0.02, false)).unwrap();
        let pose = Pose::upright(DVec3::splat(0.01), DVec3::X, 0.0);
        let from = placement(&kind, &pose, &truth.grid, draws(1, [0; 5]));
        let read: Vec<f64> = look::returns(look::Obstacles::of(&truth), &rays, &from)
            .map(|found| f64::from(found.read[0]))
            .collect();
        read
    };
    let (all, some) = (found(0.0), found(0.3));
    let n = RAYS as f64;
    // Four standard errors.
    assert!((some.len() as f64 / n - 0.7).abs() < 4.0 * (0.21 / n).sqrt(), "{} of {RAYS}", some.len());
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    assert!((mean(&all) - mean(&some)).abs() < 4.0 * STD_VOXELS / n.sqrt(), "{} {}", mean(&all), mean(&some));
}

/// Along a ray at 60 degrees to the axis a metre of depth is two of distance: at a depth of 5 m the deviation of depth is 0.05 + 0.05
/// m, of distance twice that.
#[test]
fn the_noise_of_depth_is_that_of_depth_along_the_ray() {
    let deviation = Deviation { std_m: 0.05, per_m: 0.01, per_m2: 0.0 };
    let range = Range {
        reflectance: ReflectanceRanges::NONE,
        range_m: [0.0, 6.0],
        along: Along::Axis,
        near_ignore_m: 0.0,
        no_return_is_free: false,
        noise: deviation,
        dropout: 0.0,
        calibration: None,
    };
    let rays = range.rays(vec![[28_378, 0, 16_384], [0, 0, 32_768]], &RayScale::new(0.1, false));
    let drawn = 0xc000_0000;
    let [slanted, straight] = [0, 1].map(|ray| {
        let slant = rays.gates.slant(rays.dirs_q15[ray][2]);
        rays.noise.step_q16(slant, drawn, slant.ray_range_q16(50 << 16))
    });
    assert_eq!(rays.gates_of(0).range_max_q16, 120 << 16);
    // 0.1005 m, at the middle of the voxel, are 1.005 voxels.
    let expected = march::step_q16(noise::unit_q12()[3072], 65_864);
    assert!(
        (straight - expected).abs() <= 1 && (slanted - 2 * expected).abs() <= 2,
        "{slanted} {straight} {expected}"
    );
}
