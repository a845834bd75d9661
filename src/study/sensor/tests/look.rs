//! Rays from a table, and single rays.

use super::*;
use crate::sensor::kinds::rays::RaySet;
use crate::sensor::look::{self, Return};
use crate::sensor::noise::Deviation;
use crate::sensor::range::{Along, Range, ReflectanceRanges};
use crate::sensor::{RayScale, placement};
use perirobot_march::march;

fn ring(range_m: [f64; 2], near_ignore_m: f64) -> RaySet {
    let range = Range {
        reflectance: ReflectanceRanges::NONE,
        range_m,
        along: Along::Ray,
        near_ignore_m,
        no_return_is_free: false,
        noise: Deviation::NONE,
        dropout: 0.0,
        calibration: None,
    };
    // Forward, left, up.
    RaySet { dirs_q15: vec![[32_768, 0, 0], [0, 32_768, 0], [0, 0, 32_768]], range }
}

#[test]
fn directions_are_in_the_frame_of_the_sensor() {
    let truth = empty([9, 9, 9], 1.0);
    let kind = ring([0.0, 9.0], 0.0);
    let rays = kind.rays(&RayScale::new(1.0, false)).unwrap();
    let ways = |pose: Pose| {
        let from = placement(&kind, &pose, &truth.grid, 0);
        [0, 1, 2].map(|ray| {
            from.axis_q15.map(|axis| march::direction_q16(axis, rays.dirs_q15[ray])).map(|d| d / 65_536)
        })
    };
    let at = DVec3::splat(4.5);
    assert_eq!(ways(Pose::facing(at, DVec3::X, 0.0, 0.0)), [[1, 0, 0], [0, 1, 0], [0, 0, 1]]);
    assert_eq!(ways(Pose::facing(at, DVec3::Y, 0.0, 0.0)), [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]);
    // Facing down, up is +x: so left is where right was not.
    assert_eq!(ways(Pose::facing(at, -DVec3::Z, 0.0, 0.0)), [[0, 0, -1], [0, 1, 0], [1, 0, 0]]);
    assert_eq!((kind.representations(), kind.adds(0)), (vec!["points"], false));
}

#[test]
fn a_ray_returns_within_its_gates() {
    let mut truth = empty([9, 9, 9], 1.0);
    put(&mut truth, Role::Environment, &[[6, 4, 4], [4, 8, 4]], None);
    let returns = |kind: &RaySet| -> Vec<_> {
        let rays = kind.rays(&RayScale::new(1.0, true)).unwrap();
        let from = placement(kind, &Pose::upright(DVec3::splat(4.5), DVec3::X, 0.0), &truth.grid, 0);
        look::returns(look::Obstacles::of(&truth), &rays, &from).collect()
    };
    let hit = |hit: [i32; 3], half_voxels: u32| Return { hit, distance_q16: half_voxels << 15, read: hit };
    let [ahead, left] = [hit([6, 4, 4], 3), hit([4, 8, 4], 7)];
    assert_eq!(returns(&ring([0.0, 9.0], 0.0)), [ahead, left], "the ray up leaves the grid");
    assert_eq!(returns(&ring([0.0, 3.5], 0.0)), [ahead, left]);
    assert_eq!(returns(&ring([0.0, 3.4], 0.0)), [ahead]);
    assert_eq!(returns(&ring([1.6, 9.0], 0.0)), [left], "too near to be measured");
    assert_eq!(returns(&ring([0.0, 9.0], 1.6)), [left], "its own housing");
}

/// Believed in the middle, truly a voxel behind, or turned to the left by a quarter.
#[test]
fn what_a_true_ray_hits_is_read_on_the_believed_one() {
    let mut truth = empty([9, 9, 9], 1.0);
    put(&mut truth, Role::Environment, &[[6, 4, 4], [4, 8, 4]], None);
    let kind = ring([0.0, 9.0], 0.0);
    let rays = kind.rays(&RayScale::new(1.0, false)).unwrap();
    let believed = Pose::upright(DVec3::splat(4.5), DVec3::X, 0.0);
    let returns = |truly: Pose| -> Vec<Return> {
        let at = Station { truly: Some(truly), ..station(&truth, Setting::Pose(believed)) };
        look::returns(look::Obstacles::of(&truth), &rays, &at.placement(&kind)).collect()
    };
    let found = |hit: [i32; 3], half_voxels: u32, read: [i32; 3]| Return {
        hit,
        distance_q16: half_voxels << 15,
        read,
    };
    let behind = Pose::upright(DVec3::new(3.5, 4.5, 4.5), DVec3::X, 0.0);
    assert_eq!(returns(behind), [found([6, 4, 4], 5, [7, 4, 4])], "to its left nothing is there");
    let turned = Pose::upright(DVec3::splat(4.5), DVec3::Y, 0.0);
    assert_eq!(returns(turned), [found([4, 8, 4], 7, [8, 4, 4])], "ahead; to its left nothing is");
    let same = [found([6, 4, 4], 3, [6, 4, 4]), found([4, 8, 4], 7, [4, 8, 4])];
    assert_eq!(returns(believed), same);
}
