//! The voxelizer on bodies whose voxels can be counted by hand.

use super::*;
use crate::truth::voxelize_all;

/// The surface of a box in metres, as twelve triangles that face outward.
fn cuboid(low: DVec3, high: DVec3) -> Mesh {
    let vertices = (0..8)
        .map(|i| {
            let pick = |r: usize| if i >> r & 1 == 1 { high[r] } else { low[r] };
            DVec3::new(pick(0), pick(1), pick(2))
        })
        .collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Mesh { vertices, triangles }
}

fn object(name: &str, role: Role, interior: Interior, mesh: Mesh) -> Object {
    let surface = Surface::Mesh(mesh);
    Object {
        name: name.into(),
        role,
        interior,
        optical: Optical::Opaque,
        radar: Default::default(),
        shade: 0,
        tag_only: false,
        takes_unit: true,
        surface,
        frame: crate::pose::Pose::ORIGIN,
        keypoints: None,
        linkage: None,
        warnings: Vec::new(),
    }
}

/// Voxels of 0.1 m; a box from 0.15 to 0.85 touches voxels 1 to 8 on each axis.
fn truth_of(objects: Vec<Object>) -> Truth {
    voxelize_all(&[scene(0, objects.into_iter().map(Arc::new).collect())], GRID).unwrap().remove(0)
}

const GRID: Grid = Grid { voxel_size_m: 0.1, origin: [0; 3], size: [10; 3] };

fn scene(snapshot: usize, objects: Vec<Arc<Object>>) -> Scene {
    Scene { name: "test".into(), snapshot, objects, speeds_mm_s: Vec::new() }
}

fn test_box() -> Mesh {
    cuboid(DVec3::splat(0.15), DVec3::splat(0.85))
}

const SHELL: u64 = 8 * 8 * 8 - 6 * 6 * 6;

/// A robot's inside is its own wherever the grid cuts it, and whatever its interior is to the cell.
#[test]
fn a_cut_robot_keeps_its_inside() {
    let whole = Grid { voxel_size_m: 0.1, origin: [0; 3], size: [10; 3] };
    let cut = Grid { size: [10, 10, 5], ..whole };
    for interior in [Interior::Free, Interior::Ignored, Interior::Occupied] {
        let body = object("arm", Role::Robot, interior, cuboid(DVec3::splat(0.15), DVec3::splat(0.85)));
        let scene = Scene {
            name: "cell".into(),
            snapshot: 0,
            objects: vec![Arc::new(body)],
            speeds_mm_s: Vec::new(),
        };
        let volume = |grid| voxelize_all(std::slice::from_ref(&scene), grid).unwrap().remove(0).robot_volume;
        assert_eq!(volume(whole).count(), 8 * 8 * 8, "{interior:?}");
        assert_eq!(volume(cut), volume(whole).to_window(cut.window()).trim(), "{interior:?}");
    }
}

#[test]
fn interiors_are_ignored_free_or_occupied() {
    let check = |interior, occupied, ignored| {
        let truth = truth_of(vec![object("body", Role::Human, interior, test_box())]);
        assert_eq!((truth.occupied.count(), truth.ignored.count()), (occupied, ignored), "{interior:?}");
        assert_eq!(truth.human.count(), occupied);
        assert_eq!(truth.objects[0].watertight, Some(true));
        assert_eq!(truth.objects[0].voxels.bounds(), Window::from_corners([1; 3], [8; 3]));
        assert!(truth.objects[0].warnings.is_empty());
    };
    check(Interior::Free, SHELL, 0);
    check(Interior::Ignored, SHELL, 216);
    check(Interior::Occupied, 512, 0);
}

#[test]
fn a_leaky_body_stays_a_shell_and_says_so() {
    let mut mesh = test_box();
    mesh.triangles.pop();
    let truth = truth_of(vec![object("leaky", Role::Robot, Interior::Occupied, mesh)]);
    assert!(truth.occupied.count() <= SHELL && truth.robot.count() > 0);
    assert_eq!(truth.objects[0].watertight, Some(false));
    assert!(truth.objects[0].warnings[0].contains("not watertight"), "{:?}", truth.objects[0].warnings);
}

#[test]
fn see_through_is_truth_but_stops_no_ray_and_tags_add_no_truth() {
    let mut fence = object("fence", Role::Environment, Interior::Free, test_box());
    fence.optical = Optical::SeeThrough;
    let truth = truth_of(vec![fence]);
    assert_eq!((truth.occupied.count(), truth.blockers.count()), (SHELL, 0));
    let mut tag = object("tag", Role::Human, Interior::Free, test_box());
    tag.tag_only = true;
    let truth = truth_of(vec![tag]);
    assert_eq!((truth.occupied.count(), truth.human.count()), (0, SHELL));
}

#[test]
fn a_body_cut_by_the_grid_keeps_its_inside() {
    let mesh = cuboid(DVec3::splat(0.55), DVec3::splat(1.25));
    let truth = truth_of(vec![object("cut", Role::Environment, Interior::Ignored, mesh)]);
    // Surface at voxel 5 on each axis, inside 6…9.
    assert_eq!(truth.ignored.count(), 4 * 4 * 4);
    assert_eq!(truth.occupied.count(), 5 * 5 * 5 - 4 * 4 * 4);
}

#[test]
fn grids_hold_both_ends_and_refuse_too_many_voxels() {
    let room = cuboid(DVec3::new(-3.0, -2.0, 0.0), DVec3::new(3.0, 2.0, 3.0));
    let room = object("room", Role::Environment, Interior::Free, room);
    let snapshots = [scene(0, vec![Arc::new(room)])];
    let extent = scene_extent(&snapshots, 0.05).unwrap();
    assert_eq!((extent.min, extent.size), ([-60, -40, 0], [121, 81, 61]));
    assert!(grid_over(&extent, 0.05).is_ok());
    let fine = scene_extent(&snapshots, 0.001).unwrap();
    let message = grid_over(&fine, 0.001).unwrap_err().to_string();
    assert!(message.contains("6001 voxels") && message.contains("= 0.0059 or more"), "{message}");
    let fits = scene_extent(&snapshots, 0.0059).unwrap();
    assert!(grid_over(&fits, 0.0059).is_ok());
}

/// Whom the message blames that a grid of 5 cm voxels is too large.
#[track_caller]
fn blame(objects: &[(&str, DVec3, DVec3)], voxel_size_m: f64) -> String {
    let objects = objects.iter().map(|(name, low, high)| {
        Arc::new(object(name, Role::Environment, Interior::Free, cuboid(*low, *high)))
    });
    let snapshots = [scene(0, objects.collect())];
    let extent = scene_extent(&snapshots, voxel_size_m).unwrap();
    grid_over_all(&extent, voxel_size_m, &snapshots).unwrap_err().to_string()
}

#[test]
fn a_grid_is_too_large_because_of_whom() {
    let room = ("room", DVec3::new(-3.0, -2.0, 0.0), DVec3::new(3.0, 2.0, 3.0));
    let at = |x: f64, size: f64| (DVec3::new(x, 0.0, 0.0), DVec3::new(x + size, size, size));
    let crate_at = |name: &'static str, x: f64, size: f64| (name, at(x, size).0, at(x, size).1);
    let far = blame(&[room, crate_at("arm", 800.0, 1.0)], 0.05);
    let expected = "at most 1023: object \"arm\" reaches from x = 800.00 to 801.00 m, far from all others (-3.00 to 3.00 \
                    m): is its position_m right? If that is right, set voxel_size_m = ";
    assert!(far.contains(expected), "{far}");
    // Those that are fewer stand wrong, wherever the origin is.
    let two = blame(&[crate_at("a", 400.0, 1.0), crate_at("b", 403.0, 1.0), crate_at("c", 0.0, 1.0)], 0.05);
    assert!(two.contains("object \"c\" reaches from x = 0.00 to 1.00 m, far"), "{two}");
    let both = blame(
        &[
            room,
            crate_at("a", -403.0, 1.0),
            crate_at("b", -400.0, 1.0),
            crate_at("c", 0.0, 1.0),
            crate_at("d", 0.0, 1.0),
        ],
        0.05,
    );
    assert!(both.contains("objects \"a\", \"b\" reach from x = -403.00 to -399.00 m, far"), "{both}");
    let large = blame(&[room, crate_at("knob", -15.0, 60.0)], 0.05);
    assert!(
        large.contains("object \"knob\" is 60.00 × 60.00 × 60.00 m: is its file in millimetres (unit = \"mm\" beside mesh makes it 0.06 m) or in centimetres (unit = \"cm\": 0.60 m)?"),
        "{large}"
    );
    let small_voxels = blame(&[room, crate_at("crate", 0.0, 1.0)], 0.002);
    assert!(small_voxels.contains("at most 1023: set voxel_size_m = 0.0059 or more"), "{small_voxels}");
    assert!(!small_voxels.contains("millimetres") && !small_voxels.contains("object"), "{small_voxels}");
}

#[test]
fn millimetres_and_maps_of_another_size_are_caught() {
    let big = object("crate", Role::Environment, Interior::Free, cuboid(DVec3::ZERO, DVec3::splat(700.0)));
    let truth = truth_of(vec![big]);
    assert!(truth.objects[0].warnings[0].contains("millimetres"));
    let huge = object("crate", Role::Environment, Interior::Free, cuboid(DVec3::ZERO, DVec3::splat(1e7)));
    let snapshots = [scene(0, vec![Arc::new(huge)])];
    assert!(scene_extent(&snapshots, 0.05).unwrap_err().to_string().contains("unit = \"mm\""));
    let mut map = object("map", Role::Environment, Interior::Free, Mesh::default());
    map.surface = Surface::Voxels { resolution_m: 0.05, keys: vec![[1, 2, 3]] };
    let snapshots = [scene(0, vec![Arc::new(map)])];
    let message = scene_extent(&snapshots, 0.02).unwrap_err().to_string();
    assert!(message.contains("voxel_size_m = 0.05"), "{message}");
    assert_eq!(scene_extent(&snapshots, 0.05).unwrap(), Window::from_corners([1, 2, 3], [1, 2, 3]));
}

#[test]
fn what_stands_still_is_voxelized_once_and_what_moves_moves() {
    let small = |x: f64| cuboid(DVec3::new(x, 0.15, 0.15), DVec3::new(x + 0.02, 0.17, 0.17));
    let wall = Arc::new(object("wall", Role::Environment, Interior::Free, small(0.95)));
    let mut keypoints = [None; 17];
    keypoints[3] = Some(DVec3::splat(0.15));
    let walker = |x, keypoints| {
        Arc::new(Object { keypoints, ..object("walker", Role::Human, Interior::Free, small(x)) })
    };
    let snapshots =
        [0.15, 0.25].map(|x| scene(0, vec![wall.clone(), walker(x, (x < 0.2).then_some(keypoints))]));
    assert_eq!(distinct_objects(&snapshots).len(), 3, "the wall once, the walker twice");
    let truths = voxelize_all(&snapshots, GRID).unwrap();
    assert!(Arc::ptr_eq(&truths[0].objects[0], &truths[1].objects[0]));
    assert!(!Arc::ptr_eq(&truths[0].objects[1], &truths[1].objects[1]));
    for (truth, x) in truths.iter().zip([1, 2]) {
        assert_eq!((truth.occupied.count(), truth.human.count()), (2, 1));
        assert!(truth.occupied.get([9, 1, 1]) && truth.human.get([x, 1, 1]));
    }
    assert_eq!(truths[0].objects[1].keypoints, Some(keypoints));
    assert_eq!(truths[1].objects[1].keypoints, None);
    // The common grid holds every snapshot.
    let extent = scene_extent(&snapshots, 0.1).unwrap();
    assert_eq!(extent, Window::from_corners([1, 1, 1], [9, 1, 1]));
}

#[test]
fn only_what_a_ray_could_reach_counts_for_the_ceiling() {
    let truth = truth_of(vec![object("body", Role::Human, Interior::Free, test_box())]);
    let reached = reachable(&truth, [([0; 3], 0)]);
    // The space around the box and its shell; the 6 × 6 × 6 voxels inside stay hidden.
    assert_eq!(reached.count(), 1000 - 216);
    // A housing that reaches through the shell lets rays inside.
    assert_eq!(reachable(&truth, [([0; 3], 2)]).count(), 1000);
}
