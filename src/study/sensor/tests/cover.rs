//! Covers around a robot of one voxel, and of a hollow box.

use super::*;
use crate::sensor::kinds::cover::Cover;
use crate::sensor::{Extent, MEASURES, noise};
use perirobot_march::march::NOISE_STEPS;

const ROBOT: [i32; 3] = [8, 8, 8];

fn cover(noise_std_m: f64) -> Cover {
    Cover { inflation_m: vec![0.3], noise_std_m }
}

/// A robot of one voxel of 5 cm, with things around it.
fn cell(things: &[[i32; 3]]) -> Truth {
    let mut truth = empty([17, 17, 17], 0.05);
    put(&mut truth, Role::Robot, &[ROBOT], None);
    put(&mut truth, Role::Environment, things, None);
    truth
}

fn planes(cover: &Cover, at: &Station) -> Planes {
    let claim = cover.claims(at).swap_remove(0);
    assert!(!claim.cast);
    claim.planes.unwrap()
}

fn squared_length(voxel: [i32; 3]) -> i32 {
    (0..3).map(|r| (voxel[r] - ROBOT[r]).pow(2)).sum()
}

#[test]
fn thirty_centimetres_are_six_voxels_in_a_straight_line() {
    let truth = cell(&[]);
    let Planes { occupied, free, .. } = planes(&cover(0.0), &station(&truth, Setting::Inflation(0.3)));
    let expected: Vec<_> =
        block([0; 3], [16; 3]).into_iter().filter(|&c| (1..=36).contains(&squared_length(c))).collect();
    assert_eq!(free.voxels().collect::<Vec<_>>(), expected);
    assert!(occupied.is_empty());
    // Six along an axis and (4, 4, 2) are 6 voxels away; (5, 4, 0) is √41 away, and a voxel's diagonal does
    // not count.
    for (voxel, inside) in
        [([14, 8, 8], true), ([12, 12, 10], true), ([13, 12, 8], false), ([15, 8, 8], false)]
    {
        assert_eq!(free.get(voxel), inside, "{voxel:?}");
    }
    assert!(!free.get(ROBOT), "outside the robot");
}

#[test]
fn what_is_near_is_occupied_and_the_rest_of_the_shell_free() {
    let (near, far) = ([14, 8, 8], [15, 8, 8]);
    let truth = cell(&[near, far, ROBOT]);
    let at = station(&truth, Setting::Inflation(0.3));
    let Planes { occupied, free, .. } = planes(&cover(0.0), &at);
    assert_eq!(occupied.voxels().collect::<Vec<_>>(), [near]);
    let Extent::Only(shell) = cover(0.0).reach(&at) else { panic!("a cover casts no rays") };
    assert_eq!(shell.count(), free.count() + 1);
    assert!(!free.get(near) && shell.get(near));
    assert_eq!(cover(0.0).log_odds(0), MEASURES);
}

#[test]
fn the_inside_of_the_robot_is_not_around_it() {
    let mut truth = empty([17, 17, 17], 0.05);
    let mut hull = block([6; 3], [10; 3]);
    hull.retain(|voxel| voxel.iter().any(|c| [6, 10].contains(c)));
    put(&mut truth, Role::Robot, &hull, None);
    let Planes { occupied, free, .. } = planes(&cover(0.0), &station(&truth, Setting::Inflation(0.05)));
    // One voxel around 5 × 5 × 5: its six sides.
    assert_eq!((occupied.count(), free.count()), (0, 6 * 25));
    assert!(!free.get([8, 8, 8]));
}

#[test]
fn noise_shifts_each_voxel_by_draws_of_its_own() {
    let things = block([7, 7, 9], [9, 9, 10]);
    let truth = cell(&things);
    let draws = 0x1234_5678;
    let at = Station { draws, ..station(&truth, Setting::Inflation(0.3)) };
    let std_m = 0.1;
    let Planes { occupied, free, .. } = planes(&cover(std_m), &at);
    // Two voxels of deviation.
    let step = |u: u64| (i64::from(noise::unit_q12()[u as usize]) * 2 * 65_536 + 2048) >> 12;
    let mut expected = BitGrid::new(truth.grid.window());
    let mut lost = 0;
    for voxel in things {
        let number = voxel[0] as u64 + 17 * (voxel[1] as u64 + 17 * voxel[2] as u64);
        let moved: [i32; 3] = std::array::from_fn(|axis| {
            let u = (pcg(u64::from(draws) ^ (3 * number + axis as u64)) * u64::from(NOISE_STEPS)) >> 32;
            (f64::from(voxel[axis]) + 0.5 + step(u) as f64 / 65_536.0).floor() as i32
        });
        match truth.grid.window().contains(moved) {
            true => expected.set(moved),
            false => lost += 1,
        }
    }
    assert_eq!(occupied, expected);
    assert_eq!(lost, 0, "two voxels of noise, seven to the wall");
    // What is free stays where it was measured to be: the shell less what was truly near.
    let quiet = planes(&cover(0.0), &at);
    assert_eq!(free, quiet.free);
    assert_ne!(occupied, quiet.occupied);
    assert!(cover(std_m).is_noisy() && !cover(0.0).is_noisy());
    let again = planes(&cover(std_m), &Station { draws: draws + 1, ..at });
    assert_ne!(again.occupied, occupied);
}

#[test]
fn what_noise_takes_out_of_the_grid_marks_nothing() {
    let truth = cell(&block([7, 7, 9], [9, 9, 10]));
    let at = station(&truth, Setting::Inflation(0.3));
    let noise_m = 100.0;
    let Planes { occupied, free, .. } = planes(&cover(noise_m), &at);
    assert!(occupied.count() < 3, "64 voxels of noise in a grid of 17: {}", occupied.count());
    assert_eq!(free, planes(&cover(0.0), &at).free);
}

#[test]
fn a_cover_needs_a_robot() {
    let truth = empty([4, 4, 4], 0.05);
    let error = cover(0.0).check(&station(&truth, Setting::Inflation(0.3))).unwrap_err();
    assert!(error.to_string().contains("role = \"robot\""), "{error}");
    assert_eq!(cover(0.0).check(&station(&cell(&[]), Setting::Inflation(0.3))), Ok(()));
    assert_eq!(
        Cover { inflation_m: vec![0.1, 0.25], noise_std_m: 0.0 }.settings(),
        [("0.1".to_string(), Setting::Inflation(0.1)), ("0.25".to_string(), Setting::Inflation(0.25))]
    );
}
