//! A scanner with four level rays in the middle of 11 × 11 × 5 voxels, guarding 3 voxels ahead and 2 to its
//! left.

use super::*;
use crate::sensor::kinds::lidar::{CaseRule, FieldCase, Lidar, LidarMount, ProtectiveField};
use crate::sensor::noise::Deviation;
use crate::sensor::prism::Prism;
use crate::sensor::range::{Along, Range, ReflectanceRanges};
use crate::sensor::{Extent, MEASURES, RayScale, SWITCHES};
use glam::DVec2;

fn scanner(points: bool, otherwise_free: bool) -> Lidar {
    let corner = DVec2::new;
    let polygon_m = vec![corner(0.0, 0.0), corner(3.0, 0.0), corner(3.0, 2.0), corner(0.0, 2.0)];
    Lidar {
        azimuths_rad: [0.0, 90.0, 180.0, 270.0].map(f64::to_radians).to_vec(),
        elevations_rad: vec![0.0],
        mount: LidarMount::Upright,
        range: Range {
            reflectance: ReflectanceRanges::NONE,
            range_m: [0.0, 9.0],
            along: Along::Ray,
            near_ignore_m: 0.0,
            no_return_is_free: false,
            noise: Deviation::NONE,
            dropout: 0.0,
            calibration: None,
        },
        points,
        field: Some(ProtectiveField { volume: Prism { polygon_m, z_m: [0.0, 2.0] }, otherwise_free }.into()),
    }
}

/// What a scanner's field says of a cell with one occupied voxel.
#[track_caller]
fn field_says(lidar: &Lidar, pose: Pose, occupied: [i32; 3]) -> Says {
    let mut truth = empty([11, 11, 5], 1.0);
    put(&mut truth, Role::Environment, &[occupied], None);
    let rays = lidar.rays(&RayScale::new(1.0, true));
    let at = Station { rays: rays.as_ref(), ..station(&truth, Setting::Pose(pose)) };
    says(lidar, lidar.representations().len() - 1, &at)
}

fn level(z_m: f64) -> Pose {
    Pose::upright(DVec3::new(5.0, 5.5, z_m), DVec3::X, 0.0)
}

#[test]
fn a_return_in_the_field_switches_it() {
    // y 5.5 to 7.5: the centres of rows 5 and 6.
    let field = block([5, 5, 1], [7, 6, 2]);
    for (voxel, on) in
        [([6, 5, 1], true), ([7, 5, 1], true), ([8, 5, 1], false), ([3, 5, 1], false), ([5, 6, 1], true)]
    {
        let expected = if on { Says::Occupied(field.clone()) } else { Says::Free(field.clone()) };
        assert_eq!(field_says(&scanner(false, true), level(1.2), voxel), expected, "{voxel:?}");
    }
    assert_eq!(field_says(&scanner(false, false), level(1.2), [8, 5, 1]), Says::Nothing);
    // The scanner sees nothing in between its four rays.
    assert_eq!(field_says(&scanner(false, true), level(1.2), [7, 6, 1]), Says::Free(field));
}

/// A scanner knows its field in its own frame: what it returns from is in it or not by where it is believed
/// to stand.
#[test]
fn a_scanner_whose_mount_is_off_switches_for_things_elsewhere() {
    let field = block([5, 5, 1], [7, 6, 2]);
    let says_from = |truly_x: f64, occupied: [i32; 3]| {
        let mut truth = empty([11, 11, 5], 1.0);
        put(&mut truth, Role::Environment, &[occupied], None);
        let lidar = scanner(false, true);
        let rays = lidar.rays(&RayScale::new(1.0, true));
        let truly = Some(Pose::upright(DVec3::new(truly_x, 5.5, 1.2), DVec3::X, 0.0));
        says(&lidar, 0, &Station { rays: rays.as_ref(), truly, ..station(&truth, Setting::Pose(level(1.2))) })
    };
    assert_eq!(says_from(5.0, [8, 5, 1]), Says::Free(field.clone()));
    // A metre and a half ahead of it, though three from where it is believed to be.
    assert_eq!(says_from(6.5, [8, 5, 1]), Says::Occupied(field.clone()));
    assert_eq!(says_from(5.0, [6, 5, 1]), Says::Occupied(field.clone()));
    assert_eq!(says_from(1.0, [6, 5, 1]), Says::Free(field));
}

#[test]
fn a_level_scanner_switches_wherever_in_a_voxel_it_stands() {
    for (z, top) in [(1.0, 2), (1.2, 2), (1.5, 2), (1.51, 3), (1.99, 3)] {
        let field = block([5, 5, 1], [7, 6, top]);
        assert_eq!(field_says(&scanner(false, true), level(z), [7, 5, 1]), Says::Occupied(field), "{z}");
    }
}

#[test]
fn a_tilted_scanner_keeps_an_upright_field() {
    let field = block([5, 5, 1], [7, 6, 2]);
    let tilted = |pitch: f64| {
        let rotation = perirobot_scene::pose::from_rpy([0.0, pitch.to_radians(), 0.0]);
        Pose::from_rotation(DVec3::new(5.0, 5.5, 1.2), rotation, perirobot_scene::pose::RotationFrame::Link)
    };
    // Up by 30°: the ray is in layer 2 from x = 6.39 on. Down by 30°: in layer 0 from x = 5.35 on, below the
    // field.
    assert_eq!(field_says(&scanner(false, true), tilted(-30.0), [7, 5, 2]), Says::Occupied(field.clone()));
    assert_eq!(field_says(&scanner(false, true), tilted(-30.0), [7, 5, 1]), Says::Free(field.clone()));
    assert_eq!(field_says(&scanner(false, true), tilted(30.0), [6, 5, 0]), Says::Free(field));
}

#[test]
fn a_scanner_upside_down_has_its_left_on_the_other_side() {
    let rolled = perirobot_scene::pose::from_rpy([180f64.to_radians(), 0.0, 0.0]);
    let pose =
        Pose::from_rotation(DVec3::new(5.0, 5.5, 1.2), rolled, perirobot_scene::pose::RotationFrame::Link);
    // y 3.5 to 5.5: rows 3 and 4, half-open as the other way round.
    let field = block([5, 3, 1], [7, 4, 2]);
    assert_eq!(field_says(&scanner(false, true), pose, [5, 4, 1]), Says::Occupied(field.clone()));
    assert_eq!(field_says(&scanner(false, true), pose, [5, 6, 1]), Says::Free(field));
}

#[test]
fn a_scanner_mounted_facing_has_its_field_where_its_rays_go() {
    let down = Lidar { mount: LidarMount::Facing, ..scanner(false, true) };
    // Facing down, azimuth 0 looks along −y and azimuth 90° along −x: x 3 to 5, y 2.5 to 5.5.
    let pose = Pose::facing(DVec3::new(5.0, 5.5, 1.2), -DVec3::Z, 0.0, 0.0);
    let field = block([3, 2, 1], [4, 4, 2]);
    assert_eq!(field_says(&down, pose, [4, 5, 1]), Says::Free(field.clone()), "beside the field");
    assert_eq!(field_says(&down, pose, [5, 3, 1]), Says::Free(field), "on the ray, on the field's edge");
    let inward = Pose::facing(DVec3::new(4.5, 5.5, 1.2), -DVec3::Z, 0.0, 0.0);
    // x 2.5 to 4.5: columns 2 and 3; the ray along −y is in column 4, the one along −x in row 5: neither
    // inside.
    assert!(matches!(field_says(&down, inward, [4, 3, 1]), Says::Free(_)));
    let aside = Pose::facing(DVec3::new(4.6, 5.6, 1.2), -DVec3::Z, 0.0, 0.0);
    // x 2.6 to 4.6 and y 2.6 to 5.6: columns 3 and 4, rows 3 to 5.
    assert_eq!(field_says(&down, aside, [4, 3, 1]), Says::Occupied(block([3, 3, 1], [4, 5, 2])));
}

#[test]
fn points_and_field_are_two_representations_of_one_scanner() {
    let truth = empty([11, 11, 5], 1.0);
    let at = station(&truth, Setting::Pose(level(1.2)));
    let (both, field) = (scanner(true, true), scanner(false, true));
    let points = Lidar { field: None, ..scanner(true, true) };
    assert_eq!(both.representations(), ["points", "field"]);
    assert_eq!([both.log_odds(0), both.log_odds(1), field.log_odds(0)], [MEASURES, SWITCHES, SWITCHES]);
    assert_eq!([both.adds(0), both.adds(1), field.adds(0)], [false, true, true]);
    assert!(both.claims(&at).swap_remove(0).cast && points.claims(&at).swap_remove(0).cast);
    assert_eq!(points.reach(&at), Extent::Rays);
    let voxels = |reach| match reach {
        Extent::Only(voxels) | Extent::RaysAnd(voxels) => voxels.count(),
        Extent::Rays => 0,
    };
    assert!(matches!(both.reach(&at), Extent::RaysAnd(_)) && matches!(field.reach(&at), Extent::Only(_)));
    assert_eq!((voxels(both.reach(&at)), voxels(field.reach(&at))), (12, 12));
}

#[test]
fn a_field_holds_a_voxel() {
    let truth = empty([11, 11, 5], 1.0);
    let check = |x| {
        let pose = Pose::upright(DVec3::new(x, 5.5, 1.2), DVec3::X, 0.0);
        scanner(false, true).check(&station(&truth, Setting::Pose(pose)))
    };
    assert_eq!(check(10.4), Ok(()));
    assert!(
        check(10.6)
            .unwrap_err()
            .to_string()
            .contains("without a voxel of the grid: make it larger, or turn it into the grid")
    );
}

/// The scanner with a wider field at snapshot 2, and another while `object 0` is at 0.5 m/s or faster.
fn switching() -> Lidar {
    let case = |name: &str, when: CaseRule, far: f64, otherwise_free: bool| {
        let polygon_m = [[0.0, 0.0], [far, 0.0], [far, 2.0], [0.0, 2.0]].map(DVec2::from_array).to_vec();
        let field = ProtectiveField { volume: Prism { polygon_m, z_m: [0.0, 1.0] }, otherwise_free };
        FieldCase { name: name.into(), when, field }
    };
    let at = |snapshots: &[usize]| CaseRule { at: Some(snapshots.to_vec()), ..CaseRule::default() };
    let fast = CaseRule { speed_mm_s: Some(("object 0".into(), [500, 2000])), ..CaseRule::default() };
    let elsewhere = CaseRule { scenes: Some(vec![1]), ..at(&[0, 1]) };
    let mut lidar = scanner(false, true);
    let cases = [
        case("turn", at(&[2]), 5.0, true),
        case("fast", fast, 4.0, false),
        case("elsewhere", elsewhere, 2.0, true),
    ];
    lidar.field.as_mut().unwrap().cases = cases.into();
    lidar
}

/// The number of the columns of the field at a moment: 3 usually, 5 in a turn, 4 if fast, 2 in the other scene.
#[test]
fn the_first_case_that_applies_counts() {
    let lidar = switching();
    let mut truth = empty([11, 11, 5], 1.0);
    put(&mut truth, Role::Environment, &[[10, 10, 4]], None);
    let columns = |moment: [usize; 2], speed: Option<u32>| {
        let mut truth = truth.clone();
        truth.radar.speeds_mm_s = vec![speed];
        let rays = lidar.rays(&RayScale::new(1.0, true));
        let at = Station { rays: rays.as_ref(), moment, ..station(&truth, Setting::Pose(level(1.2))) };
        let Extent::Only(reach) = lidar.reach(&at) else { panic!("its points are not scored") };
        let said = match says(&lidar, 0, &at) {
            Says::Free(said) => Some(said),
            Says::Nothing => None,
            Says::Occupied(_) => panic!("nothing is there"),
        };
        let reached: Vec<[i32; 3]> = reach.voxels().collect();
        assert!(said.as_ref().is_none_or(|said| *said == reached), "it labels what it reaches");
        let [low, high] = [reached[0][0], reached[reached.len() - 1][0]];
        let watched = lidar.watches(0, &at).unwrap();
        assert!(watched.get([high, 5, 1]) && !watched.get([high + 1, 5, 1]), "it watches its field");
        let corners = lidar.guarded_now_m(&at);
        assert_eq!(corners.iter().fold(0.0, |far: f64, corner| far.max(corner.x)), f64::from(high + 1));
        (high - low + 1, said.is_some())
    };
    for (moment, speed, expected) in [
        ([0, 0], None, (3, true)),
        ([0, 0], Some(499), (3, true)),
        ([0, 0], Some(500), (4, false)),
        ([0, 1], Some(2000), (4, false)),
        ([0, 1], Some(2001), (3, true)),
        ([0, 2], None, (5, true)),
        ([0, 2], Some(500), (5, true)),
        ([1, 1], Some(499), (2, true)),
        ([1, 1], Some(500), (4, false)),
        ([1, 3], None, (3, true)),
    ] {
        assert_eq!(columns(moment, speed), expected, "{moment:?} {speed:?}");
    }
    assert_eq!(lidar.guarded_m(&level(1.2)).iter().map(|corner| corner.x).fold(0.0, f64::max), 8.0);
}

#[test]
fn a_case_is_tripped_and_checked_at_its_moments() {
    let lidar = switching();
    let mut truth = empty([11, 11, 5], 1.0);
    put(&mut truth, Role::Environment, &[[9, 5, 1]], None);
    let at =
        |snapshot: usize| Station { moment: [0, snapshot], ..station(&truth, Setting::Pose(level(1.2))) };
    assert!(lidar.stuck_by(&at(1)).is_empty());
    assert_eq!(lidar.stuck_by(&at(2)).voxels().collect::<Vec<_>>(), [[9, 5, 1]]);
    let mut narrow = switching();
    narrow.field.as_mut().unwrap().cases[0]
        .field
        .volume
        .polygon_m
        .iter_mut()
        .for_each(|corner| corner.x *= 0.01);
    assert_eq!(narrow.check(&at(1)), Ok(()));
    let said = narrow.check(&at(2)).unwrap_err().to_string();
    assert!(said.starts_with("field case \"turn\": has a field without a voxel"), "{said}");
    // Points alone have no cases.
    let both = Lidar { points: true, ..switching() };
    let alone = |representation| format!("{:?}", both.only(representation).unwrap());
    assert!(!alone(0).contains("FieldCase") && alone(1).contains("FieldCase"));
}
