//! The volumes around detected joints, in voxels of a metre.

use super::people::{CAMERA, RANGE, person};
use super::*;
use crate::sensor::kinds::rgbd::{KeypointShape, Rgbd};
use crate::sensor::range::{Along, Range};
use crate::sensor::{Camera, Claim, MEASURES, RayScale, look};

const SHAPES: [KeypointShape; 4] = [
    KeypointShape::Points,
    KeypointShape::Spheres { radius_m: 1.5 },
    KeypointShape::Cylinders { radius_m: 1.5 },
    KeypointShape::Box,
];

/// The voxels added in each representation, seen from x = 0.5 along x.
fn added_voxels(truth: &Truth) -> [Vec<[i32; 3]>; 4] {
    let camera = rgbd();
    let rays = camera.rays(&RayScale::new(1.0, false));
    let at = Station { rays: rays.as_ref(), ..facing(truth, [0.5, 8.5, 8.5], [1.0, 0.0, 0.0]) };
    [0, 1, 2, 3].map(|representation| {
        let Claim { cast, planes } = camera.claims(&at).swap_remove(representation);
        assert!(cast, "the points always belong to it");
        planes.map_or(Vec::new(), |planes| {
            assert!(planes.free.is_empty() && !planes.occupied.is_empty());
            let mut beyond = planes.occupied.clone();
            beyond.remove(&camera.wherever_it_stands(truth).unwrap());
            assert_eq!(
                beyond.voxels().next(),
                None,
                "{}: outside what it may speak of",
                SHAPES[representation].name()
            );
            planes.occupied.voxels().collect()
        })
    })
}

fn rgbd() -> Rgbd {
    Rgbd { camera: CAMERA, range: RANGE, shapes: SHAPES.to_vec(), keypoint_tolerance_m: 1.0 }
}

/// The voxels of a grid of 20 × 17 × 17 where something holds.
fn all(is: impl Fn([i32; 3]) -> bool) -> Vec<[i32; 3]> {
    block([0; 3], [19, 16, 16]).into_iter().filter(|&voxel| is(voxel)).collect()
}

fn squared_distance(a: [i32; 3], b: [i32; 3]) -> i32 {
    (0..3).map(|r| (a[r] - b[r]).pow(2)).sum()
}

#[test]
fn both_shoulders() {
    let mut truth = empty([20, 17, 17], 1.0);
    let (left, right) = ([9, 10, 8], [9, 6, 8]);
    person(&mut truth, &[(5, left), (6, right)]);
    let [points, spheres, cylinders, cuboid] = added_voxels(&truth);
    assert_eq!(points, Vec::<[i32; 3]>::new());
    // d² < 2.25: the voxel, its 6 neighbours by faces and 12 by edges.
    assert_eq!(spheres.len(), 2 * 19);
    assert_eq!(spheres, all(|voxel| squared_distance(voxel, left).min(squared_distance(voxel, right)) <= 2));
    // Bone (5, 6): 5 slices of 3 × 3, with flat ends.
    assert_eq!(cylinders, block([8, 6, 7], [10, 10, 9]));
    assert_eq!(cuboid, block([9, 6, 8], [9, 10, 8]));
}

#[test]
fn a_joint_that_is_not_known_or_not_seen_leaves_its_limbs_out() {
    let (shoulder, elbow, wrist) = ([9, 4, 8], [9, 8, 8], [9, 12, 8]);
    let mut known = empty([20, 17, 17], 1.0);
    person(&mut known, &[(5, shoulder), (7, elbow), (9, wrist)]);
    assert_eq!(added_voxels(&known)[2], block([8, 4, 7], [10, 12, 9]));
    let mut unknown = empty([20, 17, 17], 1.0);
    person(&mut unknown, &[(5, shoulder), (9, wrist)]);
    let mut hidden = known.clone();
    put(&mut hidden, Role::Environment, &[[4, 8, 8]], None);
    for truth in [unknown, hidden] {
        let [_, spheres, cylinders, cuboid] = added_voxels(&truth);
        assert_eq!(
            spheres,
            all(|voxel| squared_distance(voxel, shoulder).min(squared_distance(voxel, wrist)) <= 2)
        );
        assert!(cylinders.is_empty(), "no bone has both its ends");
        assert_eq!(cuboid, block(shoulder, wrist));
    }
}

#[test]
fn two_people_are_two_boxes() {
    let mut truth = empty([20, 17, 17], 1.0);
    person(&mut truth, &[(0, [9, 4, 8]), (5, [9, 4, 6])]);
    person(&mut truth, &[(0, [9, 12, 8]), (6, [9, 14, 8])]);
    let [_, _, cylinders, cuboid] = added_voxels(&truth);
    let boxes = [block([9, 4, 6], [9, 4, 8]), block([9, 12, 8], [9, 14, 8])];
    assert_eq!(cuboid, all(|voxel| boxes.iter().any(|voxels| voxels.contains(&voxel))));
    assert!(cylinders.is_empty(), "no bone joins a shoulder to a nose, and none two people");
}

#[test]
fn nobody_detected_leaves_the_points() {
    let mut behind = empty([20, 17, 17], 1.0);
    person(&mut behind, &[(0, [9, 8, 8]), (5, [9, 9, 8])]);
    put(&mut behind, Role::Environment, &block([4, 0, 0], [4, 16, 16]), None);
    for truth in [empty([20, 17, 17], 1.0), behind] {
        assert!(added_voxels(&truth).iter().all(Vec::is_empty));
    }
}

#[test]
fn a_joint_is_detected_where_its_ray_ends() {
    // The nose is 1.4 m behind the face that hides it.
    let mut truth = empty([20, 17, 17], 1.0);
    let mut keypoints = [None; 17];
    keypoints[0] = Some(DVec3::new(10.4, 8.5, 8.5));
    put(&mut truth, Role::Human, &[[9, 8, 8]], Some(keypoints));
    let camera = Rgbd { keypoint_tolerance_m: 1.4, ..rgbd() };
    let rays = camera.rays(&RayScale::new(1.0, false));
    let at = Station { rays: rays.as_ref(), ..facing(&truth, [0.5, 8.5, 8.5], [1.0, 0.0, 0.0]) };
    let cuboid = camera.claims(&at).swap_remove(3).planes.unwrap().occupied;
    assert_eq!(cuboid.voxels().collect::<Vec<_>>(), [[9, 8, 8]]);
}

#[test]
fn only_features_need_keypoints() {
    let mut truth = empty([20, 17, 17], 1.0);
    put(&mut truth, Role::Human, &[[9, 8, 8]], None);
    let check = |shapes: &[KeypointShape]| {
        let camera = Rgbd { shapes: shapes.to_vec(), ..rgbd() };
        camera.check(&facing(&truth, [0.5, 8.5, 8.5], [1.0, 0.0, 0.0]))
    };
    assert_eq!(check(&SHAPES[..1]), Ok(()));
    for shape in &SHAPES[1..] {
        let error = check(&[KeypointShape::Points, *shape]).unwrap_err();
        assert!(
            error.to_string().starts_with(&format!("representation {:?} needs keypoints", shape.name())),
            "{error}"
        );
    }
    assert_eq!(rgbd().representations(), ["points", "spheres", "cylinders", "box"]);
    assert_eq!([0, 1, 2, 3].map(|r| rgbd().adds(r)), [false, true, true, true]);
    assert_eq!(rgbd().log_odds(3), MEASURES);
}

/// A flat wall 3.05 m before a camera of 90 by 60 degrees, in voxels of 0.1 m: how many of its 3072 rays return.
fn returns_from_a_wall(range_m: [f64; 2], along: Along) -> usize {
    let mut truth = empty([34, 72, 48], 0.1);
    put(&mut truth, Role::Environment, &block([31, 0, 0], [33, 71, 47]), None);
    let fov_rad = [90f64, 60.0].map(f64::to_radians);
    let camera = Rgbd {
        camera: Camera { fov_rad, resolution_px: [64, 48] },
        range: Range { range_m, along, ..RANGE },
        ..rgbd()
    };
    let rays = camera.rays(&RayScale::new(0.1, false)).unwrap();
    let at = facing(&truth, [0.05, 3.6, 2.4], [1.0, 0.0, 0.0]);
    look::returns(look::Obstacles::of(&truth), &rays, &at.placement(&camera)).count()
}

#[test]
fn a_flat_wall_within_the_depth_returns_every_ray() {
    assert_eq!(returns_from_a_wall([0.3, 3.5], Along::Axis), 64 * 48);
    assert_eq!(returns_from_a_wall([0.3, 3.0], Along::Axis), 0);
    assert_eq!(returns_from_a_wall([3.0, 3.5], Along::Axis), 64 * 48);
    assert_eq!(returns_from_a_wall([3.1, 3.5], Along::Axis), 0, "all are nearer than 3.1 m of depth");
    // Of distances 43 % are within 3.5 m: a circle of π · ((3.5 / 3.05)² − 1) of 4 · tan 45° · tan 30°.
    let of_distance = returns_from_a_wall([0.3, 3.5], Along::Ray);
    assert!((1300..1350).contains(&of_distance), "{of_distance}");
}
