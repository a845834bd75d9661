//! The voxels of people that presence sensors feel: where the people truly are, and only while the sensor is
//! on.

use super::detection::{DetectionRandom, VOXEL_M, camera, random_cell};
use super::people::{CAMERA, RANGE, person};
use super::*;
use crate::sensor::kinds::cover::Cover;
use crate::sensor::kinds::gate::Gate;
use crate::sensor::kinds::lidar::{Lidar, LidarMount, ProtectiveField};
use crate::sensor::kinds::pad::Pad;
use crate::sensor::kinds::rgb::Rgb;
use crate::sensor::prism::Prism;
use crate::sensor::range::Range;
use crate::sensor::{Extent, RayScale};
use perirobot_march::backend::{Backend, GridPose, Rays, VoxelScene, oracle::Oracle};
use perirobot_march::voxel::People;

/// What a presence sensor feels.
#[track_caller]
fn feels(kind: &dyn Kind, representation: usize, at: &Station) -> Vec<[i32; 3]> {
    assert!(kind.feels_presence(representation));
    let claim = kind.claims(at).swap_remove(representation);
    claim.planes.map_or_else(Vec::new, |planes| planes.hits.voxels().collect())
}

#[test]
fn a_pad_feels_feet() {
    let mut truth = empty([10, 10, 6], 1.0);
    put(&mut truth, Role::Robot, &[[2, 2, 1]], None);
    put(&mut truth, Role::Human, &[[1, 2, 1], [1, 2, 2], [5, 5, 1]], None);
    let column = Prism::from_corners(DVec3::ZERO, DVec3::new(2.0, 3.0, 3.0));
    let pad = Pad { column, tare: true, otherwise_free: true };
    let at = facing(&truth, [1.0, 2.0, 0.5], [1.0, 0.0, 0.0]);
    assert_eq!(feels(&pad, 0, &at), [[1, 2, 1]], "nothing above the first layer, and not the robot");
    let part = Station { window: Window::from_corners([2, 0, 0], [9, 9, 5]), ..at };
    assert_eq!(feels(&pad, 0, &part), [[0; 3]; 0], "what is felt is felt inside the window");
}

#[test]
fn a_gate_feels_what_is_in_its_box() {
    let mut truth = empty([8, 8, 4], 1.0);
    let between = |low: [f64; 3], high: [f64; 3]| Prism::from_corners(low.into(), high.into());
    let gate = Gate {
        gate: between([0.0, 0.0, 0.0], [1.0, 4.0, 2.0]),
        zone: between([1.0, 0.0, 0.0], [3.0, 4.0, 2.0]),
        otherwise_free: true,
        latches: false,
        muted_by: Vec::new(),
        muted_at: Vec::new(),
    };
    put(&mut truth, Role::Human, &[[1, 1, 0]], None);
    assert_eq!(feels(&gate, 0, &station(&truth, Setting::Fixed)), [[0; 3]; 0], "off");
    put(&mut truth, Role::Environment, &[[0, 0, 0]], None);
    put(&mut truth, Role::Human, &[[0, 1, 0]], None);
    assert_eq!(feels(&gate, 0, &station(&truth, Setting::Fixed)), [[0, 1, 0]]);
}

#[test]
fn a_cover_feels_people_where_they_are_however_noisy() {
    let mut truth = empty([17, 17, 17], 0.05);
    put(&mut truth, Role::Robot, &[[8, 8, 8]], None);
    put(&mut truth, Role::Environment, &[[10, 8, 8]], None);
    // Near, too far, and too far across the corner of the box around what is near.
    put(&mut truth, Role::Human, &[[11, 8, 8], [16, 8, 8], [13, 13, 13]], None);
    for noise_std_m in [0.0, 0.2] {
        let cover = Cover { inflation_m: vec![0.3], noise_std_m };
        assert_eq!(feels(&cover, 0, &station(&truth, Setting::Inflation(0.3))), [[11, 8, 8]]);
    }
}

#[test]
fn a_field_feels_whom_its_returns_hit() {
    let field = ProtectiveField {
        volume: Prism::from_corners(DVec3::ZERO, DVec3::new(3.0, 2.0, 2.0)),
        otherwise_free: true,
    };
    let range = Range { range_m: [0.0, 9.0], ..RANGE };
    let lidar = Lidar {
        azimuths_rad: [0.0, 90.0].map(f64::to_radians).to_vec(),
        elevations_rad: vec![0.0],
        mount: LidarMount::Upright,
        range,
        points: true,
        field: Some(field.into()),
    };
    assert!(!lidar.feels_presence(0), "points feel nobody");
    let felt = |human: &[[i32; 3]], environment: &[[i32; 3]]| {
        let mut truth = empty([11, 11, 5], 1.0);
        put(&mut truth, Role::Human, human, None);
        put(&mut truth, Role::Environment, environment, None);
        let rays = lidar.rays(&RayScale::new(1.0, true));
        let pose = Pose::upright(DVec3::new(5.0, 5.5, 1.2), DVec3::X, 0.0);
        feels(&lidar, 1, &Station { rays: rays.as_ref(), ..station(&truth, Setting::Pose(pose)) })
    };
    // Behind the first is nobody seen; beyond the field nobody is guarded; a post switches it, and is nobody.
    assert_eq!(felt(&[[6, 5, 1], [7, 5, 1]], &[]), [[6, 5, 1]]);
    assert_eq!(felt(&[[9, 5, 1]], &[]), [[0; 3]; 0]);
    assert_eq!(felt(&[[9, 5, 1], [5, 6, 1]], &[[6, 5, 1]]), [[5, 6, 1]]);
}

#[test]
fn a_zone_camera_feels_where_its_rays_to_joints_end() {
    let rgb = |min_keypoints| Rgb {
        camera: CAMERA,
        range: RANGE,
        zone: Prism::from_corners(DVec3::ZERO, DVec3::new(2.0, 1.0, 1.0)),
        min_keypoints,
        keypoint_tolerance_m: 1.5,
        otherwise_free: true,
    };
    let mut truth = empty([20, 11, 11], 1.0);
    person(&mut truth, &[(0, [9, 5, 5]), (5, [9, 7, 5])]);
    put(&mut truth, Role::Human, &[[12, 5, 8]], None);
    let pose = Pose::facing(DVec3::new(0.5, 5.5, 5.5), DVec3::X, 0.0, 0.0);
    let felt = |min| feels(&rgb(min), 0, &station(&truth, Setting::Pose(pose)));
    assert_eq!(felt(1), [[9, 5, 5], [9, 7, 5]]);
    // Where the people are, not where a camera takes them to be whose mount is a voxel off.
    let truly = Some(Pose::facing(DVec3::new(0.5, 4.5, 5.5), DVec3::X, 0.0, 0.0));
    let off = Station { truly, ..station(&truth, Setting::Pose(pose)) };
    assert_eq!(feels(&rgb(1), 0, &off), [[9, 5, 5], [9, 7, 5]]);
    assert_eq!(felt(3), [[0; 3]; 0], "two joints are too few to switch it");
}

/// Somewhere in a random cell, level, and where the mount truly is: there, or near by.
fn stands(random: &mut DetectionRandom) -> (Pose, Option<Pose>) {
    let (low, high) = ([0.05; 3], [3.35, 1.95, 1.65]);
    let (position_m, ahead) = (random.point(low, high), random.point([-1.0, -1.0, 0.0], [1.0, 1.0, 0.0]));
    let off = position_m + random.point([-0.2; 3], [0.2; 3]);
    let off = Pose::facing(off.clamp(low.into(), high.into()), ahead, random.number_between(-0.1, 0.1), 0.03);
    (Pose::facing(position_m, ahead, 0.0, 0.0), (random.number_below(3) > 0).then_some(off))
}

/// The oracle casts the rays of a scanner one by one: where each is read, and what it hits.
#[test]
fn in_random_cells_a_field_feels_whom_rays_hit_that_are_read_in_it() {
    let mut random = DetectionRandom(13);
    let (mut felt, mut silent, mut elsewhere) = (0, 0, 0);
    for case in 0..200 {
        let truth = random_cell(&mut random);
        let corners = [random.point([-1.5, -1.5, -0.2], [0.0; 3]), random.point([0.0; 3], [1.5, 1.5, 0.4])];
        let lidar = Lidar {
            azimuths_rad: (0..40).map(|i| f64::from(i) * 0.157).collect(),
            elevations_rad: vec![-0.1, 0.0],
            mount: LidarMount::Upright,
            range: camera(&mut random).range,
            points: false,
            field: Some(
                ProtectiveField { volume: Prism::from_corners(corners[0], corners[1]), otherwise_free: true }
                    .into(),
            ),
        };
        let rays = lidar.rays(&RayScale::new(VOXEL_M, case % 2 == 0)).unwrap();
        let (pose, truly) = stands(&mut random);
        let draws = random.bits() as u32;
        let at = Station { rays: Some(&rays), truly, draws, ..station(&truth, Setting::Pose(pose)) };
        let Extent::Only(field) = lidar.reach(&at) else { panic!("a field") };
        let mut oracle = Oracle::default();
        let alone = |&dir| Rays { dirs_q15: vec![dir].into(), ..rays.clone() };
        oracle.tables(&rays.dirs_q15.iter().map(alone).collect::<Vec<_>>()).unwrap();
        let blank = BitGrid::new(truth.grid.window());
        let [occupied, blockers] = [&truth.occupied, &truth.blockers].map(Arc::clone);
        let scene = VoxelScene {
            shades: None,
            blockers,
            over_time: None,
            window: truth.grid.window(),
            truth: BitGrid::clone(&occupied),
            human: truth.human.clone(),
            robot: blank.clone(),
            regions: Vec::new(),
            people: People::default(),
        };
        oracle.load(&scene).unwrap();
        let (from, mut expected) = (at.placement(&lidar), blank);
        for ray in 0..rays.dirs_q15.len() {
            // Of one ray alone, the number is 0.
            let said = oracle.read(ray, &GridPose { draws: draws ^ ray as u32, ..from }).unwrap().planes;
            if said.occupied.intersects(&field) {
                elsewhere += u32::from(said.hits != said.occupied);
                expected.add(&said.hits);
            }
        }
        expected.keep(&truth.human);
        let expected: Vec<_> = expected.voxels().collect();
        assert_eq!(feels(&lidar, 0, &at), expected, "case {case}");
        felt += u32::from(!expected.is_empty());
        silent += u32::from(expected.is_empty());
    }
    assert!(felt > 50 && silent > 20 && elsewhere > 100, "{felt} {silent} {elsewhere}");
}
