//! A camera at x = 0.5 that looks along x at a nose 10 m ahead, behind a face whose voxel begins 8.5 m ahead.

use super::people::{CAMERA, RANGE, person};
use super::*;
use crate::sensor::kinds::rgb::Rgb;
use crate::sensor::prism::Prism;
use crate::sensor::range::Range;

const NOSE_M: DVec3 = DVec3::new(10.5, 5.5, 5.5);

fn rgb() -> Rgb {
    Rgb {
        camera: CAMERA,
        range: RANGE,
        zone: Prism::from_corners(DVec3::ZERO, DVec3::new(2.0, 1.0, 1.0)),
        min_keypoints: 1,
        keypoint_tolerance_m: 1.5,
        otherwise_free: true,
    }
}

fn cell(wall: &[[i32; 3]]) -> Truth {
    let mut truth = empty([20, 11, 11], 1.0);
    let mut keypoints = [None; 17];
    keypoints[0] = Some(NOSE_M);
    put(&mut truth, Role::Human, &[[9, 5, 5]], Some(keypoints));
    put(&mut truth, Role::Environment, wall, None);
    truth
}

fn sees(rgb: &Rgb, truth: &Truth, pan_deg: f64) -> bool {
    let pose = Pose::facing(DVec3::new(0.5, 5.5, 5.5), DVec3::X, pan_deg.to_radians(), 0.0);
    let zone = block([0, 0, 0], [1, 0, 0]);
    match says(rgb, 0, &station(truth, Setting::Pose(pose))) {
        Says::Occupied(voxels) => voxels == zone,
        Says::Free(voxels) => {
            assert_eq!(voxels, zone);
            false
        }
        Says::Nothing => panic!("silence was to say free"),
    }
}

#[test]
fn a_nose_is_seen_unless_something_hides_it() {
    // Whatever it hits is near enough.
    let anywhere = &Rgb { keypoint_tolerance_m: 9.0, ..rgb() };
    assert!(sees(anywhere, &cell(&[]), 0.0));
    assert!(!sees(anywhere, &cell(&[[4, 5, 5]]), 0.0), "behind a wall");
    assert!(sees(anywhere, &cell(&[[11, 5, 5], [4, 6, 5]]), 0.0), "walls behind and beside it");
    let mut hidden = cell(&[]);
    put(&mut hidden, Role::Human, &[[8, 5, 5]], Some([None; 17]));
    assert!(!sees(anywhere, &hidden, 0.0), "behind another person");
    // The first voxel is never tested.
    assert!(sees(anywhere, &cell(&[[0, 5, 5]]), 0.0));
    // A see-through fence stops nothing.
    let mut fenced = cell(&[[4, 5, 5]]);
    Arc::make_mut(&mut fenced.blockers).remove(&fenced.objects[1].voxels.clone());
    assert!(sees(anywhere, &fenced, 0.0));
}

#[test]
fn an_image_has_edges() {
    let seen = |pan| sees(&rgb(), &cell(&[]), pan);
    assert_eq!([-46.0, -44.0, 44.0, 46.0, 180.0].map(seen), [false, true, true, false, false]);
}

#[test]
fn a_return_counts_near_the_joint_and_within_the_range() {
    for (tolerance_m, seen) in [(1.5, true), (1.4999, false), (9.0, true)] {
        let rgb = Rgb { keypoint_tolerance_m: tolerance_m, ..rgb() };
        assert_eq!(sees(&rgb, &cell(&[]), 0.0), seen, "{tolerance_m}");
    }
    for (range_m, near_ignore_m, seen) in [
        ([0.0, 8.5], 0.0, true),
        ([0.0, 8.4999], 0.0, false),
        ([8.5, 30.0], 0.0, true),
        ([8.5001, 30.0], 0.0, false),
        ([0.0, 30.0], 8.5, true),
        ([0.0, 30.0], 8.5001, false),
    ] {
        let rgb = Rgb { range: Range { range_m, near_ignore_m, ..RANGE }, ..rgb() };
        assert_eq!(sees(&rgb, &cell(&[]), 0.0), seen, "{range_m:?} {near_ignore_m}");
    }
}

#[test]
fn the_joints_of_one_person_are_counted() {
    let mut truth = empty([20, 11, 11], 1.0);
    person(&mut truth, &[(0, [9, 5, 5]), (9, [9, 3, 5])]);
    person(&mut truth, &[(0, [9, 7, 5])]);
    let sees = |min_keypoints| sees(&Rgb { min_keypoints, ..rgb() }, &truth, 0.0);
    assert_eq!([1, 2, 3].map(sees), [true, true, false], "two of one person, not three of two");
}

#[test]
fn a_silent_camera_may_certify_nothing() {
    let rgb = Rgb { otherwise_free: false, ..rgb() };
    let truth = cell(&[[4, 5, 5]]);
    assert_eq!(says(&rgb, 0, &facing(&truth, [0.5, 5.5, 5.5], [1.0, 0.0, 0.0])), Says::Nothing);
    assert_eq!((rgb.log_odds(0), rgb.is_noisy()), ([3511, -405], false));
}

#[test]
fn everybody_has_keypoints() {
    let mut truth = cell(&[]);
    let check = |truth: &Truth| rgb().check(&facing(truth, [0.5, 5.5, 5.5], [1.0, 0.0, 0.0]));
    assert_eq!(check(&truth), Ok(()));
    put(&mut truth, Role::Human, &[[1, 1, 1]], None);
    let error = check(&truth).unwrap_err();
    assert!(error.to_string().contains("human \"object 2\" has none: give it keypoints ="), "{error}");
}
