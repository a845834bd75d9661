//! The library's front: a cell that is made without any file scores as the study that says the same, on every
//! device, and says what is wrong with it.

use crate::common;
use perirobot::{Cell, DepthCamera, Device, Study};
use perirobot_march::metrics::Confusion;
use perirobot_scene::{objects::Role, pose::Pose};
use perirobot_study::world::World;

const STUDY: &str = r#"
seed = 1

[grid]
voxel_size_m = 0.1

[[scene]]
file = "cell.toml"

[[region]]
name = "arm"
sphere = { center_m = [0.2, 0.3, 0.4], radius_m = 0.6 }

[[region]]
name = "operator"
human_box = { object = "operator", margin_m = 0.3 }

[[sensor]]
name = "camera"
kind = "rgbd"
fov_deg = [87, 58]
resolution_px = [64, 36]
range_m = [0.2, 3.0]

[[sensor.poses]]
name = "wall"
x_m = [-1.0, 0.05, 1.0]
y_m = -0.7
z_m = 1.2
facing = [0, 1, 0]
orientations_deg = [{ pan = 0, tilt = 0 }, { pan = -20, tilt = -30 }]
"#;

const SCENE: &str = r#"
interior = "occupied"

[[object]]
name = "walls"
room = { size_m = [2.4, 1.8, 1.6] }
position_m = [0, 0, 0.8]

[[object]]
name = "arm"
role = "robot"
capsule = { radius_m = 0.1, length_m = 0.6 }
position_m = [0.2, 0.3, 0.45]

[[object]]
name = "operator"
role = "human"
cylinder = { radius_m = 0.15, height_m = 1.2 }
position_m = [0.1, -0.2, 0.65]
"#;

#[test]
fn a_cell_without_files_scores_as_its_study_on_every_device() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cell.toml"), SCENE).unwrap();
    std::fs::write(folder.path().join("study.toml"), STUDY).unwrap();
    let path = folder.path().join("study.toml");
    let from_files = Study::load(&path, &Default::default()).unwrap().score(Device::Oracle).unwrap();

    let study = perirobot_study::input::Study::load(&path, &Default::default()).unwrap();
    let world = World::prepare_all(&study).unwrap().remove(0);
    let (grid, truth) = (world.grid, world.truth());
    assert_eq!(truth.blockers.to_window(grid.window()), truth.occupied.to_window(grid.window()));
    let role = |voxel: [u32; 3]| match () {
        () if has(&truth.human, voxel) => Some(Role::Human),
        () if has(&truth.robot, voxel) => Some(Role::Robot),
        () => has(&truth.occupied, voxel).then_some(Role::Environment),
    };
    let mut cell = Cell::from_fn(grid.size, grid.voxel_size_m, role).unwrap();
    let mut array = Vec::new();
    for z in 0..grid.size[2] {
        for y in 0..grid.size[1] {
            array.extend((0..grid.size[0]).map(|x| role([x, y, z])));
        }
    }
    let mut from_array = Cell::from_array(grid.size, grid.voxel_size_m, &array).unwrap();
    for region in &world.regions {
        cell = cell.region(|voxel| has(&region.voxels, voxel));
        from_array = from_array.region(|voxel| has(&region.voxels, voxel));
    }
    // A cell begins at the world's origin.
    let poses = world.settings[0].iter().map(|setting| {
        let Pose { position_m, rotation } = setting.pose();
        Pose { position_m: position_m - grid.corner_m([0; 3]), rotation }
    });
    let poses: Vec<Pose> = poses.collect();
    let camera = DepthCamera { fov_deg: [87.0, 58.0], resolution_px: [64, 36], range_m: [0.2, 3.0] };
    let mut devices = vec![Device::Oracle, Device::Cpu];
    devices.extend(common::adapter().map(|_| Device::SoftwareGpu));
    for device in devices {
        for cell in [&cell, &from_array] {
            let counts: Vec<Confusion> = cell.score(&camera, &poses, device).unwrap().concat();
            assert_eq!(counts.len(), from_files.len(), "{device:?}");
            for (counts, row) in counts.iter().zip(&from_files) {
                assert_eq!(counts, &row.counts, "{device:?}: {} in {}", row.poses, row.region);
            }
        }
    }
    assert!(from_files.iter().any(|row| row.counts.f1() > Some(0.2)), "something is seen");
    assert_eq!(from_files[0].poses, "camera:wall/0/0");
}

fn has(plane: &perirobot_march::voxel::BitGrid, voxel: [u32; 3]) -> bool {
    plane.get(voxel.map(|n| n as i32))
}

#[test]
fn a_cell_without_regions_is_counted_whole() {
    let cell = Cell::from_fn([8, 9, 10], 0.1, |voxel| (voxel[2] == 0).then_some(Role::Environment)).unwrap();
    let camera = DepthCamera { fov_deg: [60.0, 60.0], resolution_px: [40, 40], range_m: [0.1, 2.0] };
    let down = Pose::facing([0.4, 0.4, 0.9].into(), [0.0, 0.0, -1.0].into(), 0.0, 0.0);
    let counts = cell.score(&camera, &[down, down], Device::Cpu).unwrap();
    assert_eq!((counts.len(), counts[0].len(), counts[0][0].total()), (2, 1, 720));
    assert_eq!(counts[0], counts[1]);
    assert!(counts[0][0].tp > 0 && counts[0][0].tn > 0);
}

#[test]
fn what_cannot_be_is_named_with_what_would_be_right() {
    let empty = |size, edge| Cell::from_fn(size, edge, |_| None);
    let refused = |result: perirobot_march::Result<Cell>, expected: &str| {
        assert_eq!(result.unwrap_err().to_string(), expected);
    };
    refused(empty([4, 0, 4], 0.1), "size: is [4, 0, 4], must be 1 to 1023 voxels along y");
    refused(empty([4, 4, 1024], 0.1), "size: is [4, 4, 1024], must be 1 to 1023 voxels along z");
    refused(empty([4; 3], f64::NAN), "voxel_size_m: is NaN, must be a length above 0, in metres");
    refused(Cell::from_array([2; 3], 0.1, &[None; 7]), "roles: has 7 entries, [2, 2, 2] voxels are 8");

    let cell = empty([4; 3], 0.5).unwrap();
    let right = DepthCamera { fov_deg: [90.0; 2], resolution_px: [4; 2], range_m: [0.0, 2.0] };
    let refused = |cell: &Cell, camera: DepthCamera, at: [f64; 3], expected: &str| {
        let pose = Pose::facing(at.into(), [1.0, 0.0, 0.0].into(), 0.0, 0.0);
        assert_eq!(cell.score(&camera, &[pose], Device::Cpu).unwrap_err().to_string(), expected);
    };
    let angles = "camera.fov_deg: is [90.0, 180.0], must be two angles from 0.001 and below 180 degrees";
    refused(&cell, DepthCamera { fov_deg: [90.0, 180.0], ..right }, [1.0; 3], angles);
    let pixels = "camera.resolution_px: is [0, 4], must be at least 1 each and 11184810 together";
    refused(&cell, DepthCamera { resolution_px: [0, 4], ..right }, [1.0; 3], pixels);
    let range = "camera.range_m: is [2.0, 2.0], must be a nearest distance and a farther one, in metres";
    refused(&cell, DepthCamera { range_m: [2.0; 2], ..right }, [1.0; 3], range);
    let outside = "poses[0]: is at [1, 2.5, 1] m, outside the cell of 2 × 2 × 2 m";
    refused(&cell, right, [1.0, 2.5, 1.0], outside);
    refused(&cell.clone().region(|_| false), right, [1.0; 3], "regions[0]: has no voxel");
}
