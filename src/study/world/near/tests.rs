//! Against plain loops over all voxels of a region, with the geometry of the one camera and the one scanner written out.

use std::path::Path;

use glam::DVec3;

use super::*;
use crate::input::Overrides;

const STUDY: &str = r#"
[grid]
voxel_size_m = 0.05
[[scene]]
file = "cell.toml"
[[region]]
name = "all"
box = { min_m = [-1, -1, 0], max_m = [1, 1, 2] }
[[region]]
name = "far"
box = { min_m = [0.5, -1, 0], max_m = [1, 1, 2] }
[[sensor]]
name = "depth"
kind = "rgbd"
fov_deg = [90, 60]
resolution_px = [32, 24]
range_m = [0.5, 4]
range_along = "axis"
poses = [{ name = "p", list = [{ position_m = [-0.8, 0.02, 1.01], facing = [1, 0, 0] }] }]
[[sensor]]
name = "distance"
kind = "rgbd"
fov_deg = [90, 60]
resolution_px = [32, 24]
range_m = [0.5, 4]
same_poses_as = "depth"
[[sensor]]
name = "scanner"
kind = "lidar"
fov_deg = 180
beams = 181
elevation_deg = [-30, 30]
rings = 7
range_m = [0.4, 4]
poses = [{ name = "p", list = [{ position_m = [0.01, 0.02, 1.01], facing = [1, 0, 0] }] }]
[[sensor]]
name = "mat"
kind = "pad"
size_m = [1, 1]
poses = [{ name = "p", list = [{ position_m = [0, 0, 0] }] }]
"#;

const SCENE: &str =
    "[[object]]\nname = \"hall\"\nroom = { size_m = [2.4, 2.4, 2.2] }\nposition_m = [0, 0, 1.1]\n";

fn study() -> (Study, Vec<World>) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cell.toml"), SCENE).unwrap();
    let path = folder.path().join("study.toml");
    std::fs::write(&path, STUDY).unwrap();
    let study = Study::load(Path::new(&path), &Overrides::default()).unwrap();
    let worlds = World::prepare_all(&study).unwrap();
    (study, worlds)
}

/// How many voxels of each region have their middle where `is_blind` says.
fn plain(world: &World, is_blind: impl Fn(DVec3) -> bool) -> Vec<[u64; 2]> {
    let middle = |voxel| world.grid.corner_m(voxel) + world.grid.voxel_size_m / 2.0;
    let blind = |voxels: &perirobot_march::voxel::BitGrid| {
        voxels.voxels().filter(|voxel| is_blind(middle(*voxel))).count() as u64
    };
    world.regions.iter().map(|region| [blind(&region.voxels), region.voxels.count()]).collect()
}

/// How many columns of the grid have a voxel whose middle is where `is_blind` says, and how many there are.
fn plain_floor(world: &World, is_blind: impl Fn(DVec3) -> bool) -> [u64; 2] {
    let middle = |voxel| world.grid.corner_m(voxel) + world.grid.voxel_size_m / 2.0;
    let [width, depth, height] = world.grid.size.map(|count| count as i32);
    let mut blind = 0;
    for x in 0..width {
        for y in 0..depth {
            blind += u64::from((0..height).filter(|z| is_blind(middle([x, y, *z]))).count() > 0);
        }
    }
    [blind, (width * depth) as u64]
}

#[test]
fn what_is_too_near_is_what_a_plain_loop_finds() {
    let (study, worlds) = study();
    let world = &worlds[0];
    let found = |sensor: usize| near_blindness(&study, world, [sensor, 0]);
    let eye = DVec3::new(-0.8, 0.02, 1.01);
    // The tangents of 45° and 30°.
    let in_image = |at: DVec3| {
        let DVec3 { x, y, z } = at - eye;
        x > 0.0 && y.abs() < x && z.abs() < x * 30f64.to_radians().tan()
    };
    let depth = found(0).unwrap();
    assert_eq!(depth.regions, plain(world, |at| in_image(at) && at.x - eye.x < 0.5));
    assert_eq!(depth.floor, plain_floor(world, |at| in_image(at) && at.x - eye.x < 0.5));
    assert!(depth.floor[0] > 50, "{depth:?}");
    assert!(depth.regions[0][0] > 400 && depth.regions[1][0] == 0, "{depth:?}");
    assert_eq!(depth.describe_distance(), "nearer than 0.5 m (depth)");
    let distance = found(1).unwrap();
    assert_eq!(distance.regions, plain(world, |at| in_image(at) && at.distance(eye) < 0.5));
    assert!(distance.regions[0][0] < depth.regions[0][0]);
    let eye = DVec3::new(0.01, 0.02, 1.01);
    // Half a step of 10° beyond the rings at 30°, half a step of 1° beyond the ends of the half turn.
    let in_turn = |at: DVec3| {
        let DVec3 { x, y, z } = at - eye;
        y.atan2(x).abs() <= 90.5f64.to_radians() && z.atan2(x.hypot(y)).abs() <= 35f64.to_radians()
    };
    let scanner = found(2).unwrap();
    assert_eq!(scanner.regions, plain(world, |at| in_turn(at) && at.distance(eye) < 0.4));
    assert_eq!(scanner.floor, plain_floor(world, |at| in_turn(at) && at.distance(eye) < 0.4));
    let floor = 100.0 * scanner.floor[0] as f64 / scanner.floor[1] as f64;
    assert_eq!(scanner.describe_floor().unwrap(), format!("{floor:.2} % of the floor (seen from above)"));
    assert!(scanner.regions[0][0] > 400, "{scanner:?}");
    assert_eq!(scanner.describe_distance(), "nearer than 0.4 m");
    let share = scanner.regions[0][0] as f64 / scanner.regions[0][1] as f64;
    assert_eq!(scanner.largest_share(), share);
    assert_eq!(
        scanner.describe_regions(&study).unwrap(),
        format!("{:.2} % of region \"all\"", 100.0 * share)
    );
    let nothing = NearBlindness { regions: vec![[0, 9], [0, 1]], floor: [0, 9], ..scanner.clone() };
    assert_eq!((nothing.describe_regions(&study), nothing.describe_floor()), (None, None));
    let little = NearBlindness { regions: vec![[1, 20_000], [0, 1]], ..scanner };
    assert_eq!(little.describe_regions(&study).unwrap(), "under 0.01 % of region \"all\"");
    assert_eq!(found(3), None, "a mat has no lens");
}

#[test]
fn parts_reach_as_far_as_what_is_too_near() {
    let (study, worlds) = study();
    for sensor in 0..3 {
        let lens = lens_of(&study.sensors[sensor], &worlds[0].settings[sensor][0]).unwrap();
        let parts = lens.near_parts_m();
        assert_eq!(parts.len() > 1, sensor == 2, "a turn is in parts");
        let middle = parts[parts.len() / 2].iter().sum::<DVec3>() / parts[parts.len() / 2].len() as f64;
        assert!(lens.is_too_near(lens.position_m.lerp(middle, 0.9)));
        for place in parts.iter().flatten() {
            let outside = lens.position_m.lerp(*place, 1.01);
            assert!(place.distance(lens.position_m) <= lens.near_reach_m() + 1e-9);
            assert!(!lens.is_too_near(outside), "{place}");
        }
    }
}
