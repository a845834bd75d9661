//! Every number of a study and its scene, made not-a-number, infinite, absurdly large and out of its range:
//! each is refused by file, key and value before any ray is cast.

use crate::common::program::{Folder, refused};

const STUDY: &str = "study.toml";
const SCENE: &str = "cell.toml";

/// The good study with `to` in place of `from` in a file must be refused in words that hold all of
/// `expected`.
#[track_caller]
fn wrong(file: &str, from: &str, to: &str, expected: &[&str]) {
    refused(&Folder::new(), &[(file, from, to)], &[&[file], expected].concat());
}

/// Every key that holds a number: not-a-number, infinities and absurd sizes are refused by its name.
#[test]
fn numbers_that_are_none() {
    for (file, from, to, key) in [
        (STUDY, "voxel_size_m = 0.1", "voxel_size_m = @", "voxel_size_m"),
        (STUDY, "[grid]", "[grid]\nbounds_m = { min = [@, -2, -2], max = [2, 2, 2] }", "bounds_m.min"),
        (STUDY, "[grid]", "[grid]\nbounds_m = { min = [-2, -2, -2], max = [2, @, 2] }", "bounds_m.max"),
        (STUDY, "center_m = [0.2,", "center_m = [@,", "sphere.center_m"),
        (STUDY, "radius_m = 0.6", "radius_m = @", "sphere.radius_m"),
        (STUDY, "min_m = [-0.5,", "min_m = [@,", "box.min_m"),
        (STUDY, "max_m = [0.5,", "max_m = [@,", "box.max_m"),
        (STUDY, "margin_m = 0.2", "margin_m = @", "human_box.margin_m"),
        (STUDY, "margin_m = 0.2", "margin_min_m = [0, 0, @]", "human_box.margin_min_m"),
        (STUDY, "margin_m = 0.2", "margin_max_m = [0, @, 0]", "human_box.margin_max_m"),
        (STUDY, "fov_deg = [87,", "fov_deg = [@,", "fov_deg"),
        (STUDY, "58]", "@]", "fov_deg"),
        (STUDY, "range_m = [0.2,", "range_m = [@,", "range_m"),
        (STUDY, "3.0]", "@]", "range_m"),
        (STUDY, "near_ignore_m = 0.05", "near_ignore_m = @", "near_ignore_m"),
        (STUDY, "start = -1.0", "start = @", "x_m"),
        (STUDY, "stop = 1.0", "stop = @", "x_m"),
        (STUDY, "step = 1.0", "step = @", "x_m"),
        (STUDY, "y_m = -0.75", "y_m = @", "y_m"),
        (STUDY, "z_m = [1.2]", "z_m = [1.2, @]", "z_m"),
        (STUDY, "facing = [0, 1, 0]", "facing = [0, @, 0]", "facing"),
        (STUDY, "pan = -20", "pan = @", "orientations_deg[1].pan"),
        (STUDY, "tilt = -30", "tilt = @", "orientations_deg[1].tilt"),
        (STUDY, "min_m = [-0.9,", "min_m = [@,", "random.min_m"),
        (STUDY, "max_m = [0.9,", "max_m = [@,", "random.max_m"),
        (STUDY, "pan_deg = [-180, 180]", "pan_deg = [-180, @]", "random.pan_deg"),
        (STUDY, "tilt_deg = [-30, 30]", "tilt_deg = [@, 30]", "random.tilt_deg"),
        (STUDY, "[360, 90]", "[@, 90]", "fov_deg"),
        (STUDY, "[360, 90]", "[360, @]", "fov_deg"),
        (STUDY, "resolution_deg = [8,", "resolution_deg = [@,", "resolution_deg"),
        (STUDY, "12]", "@]", "resolution_deg"),
        (STUDY, "fov_deg = [360, 90]", "elevation_deg = [@, 90]", "elevation_deg"),
        (STUDY, "fov_deg = [360, 90]", "elevation_deg = [0, @]", "elevation_deg"),
        (STUDY, "fov_deg = [360, 90]", "rings_deg = [0, @]", "rings_deg"),
        (STUDY, "position_m = [-0.9,", "position_m = [@,", "list[0].position_m"),
        (STUDY, "facing = [1, -0.5, 0]", "facing = [1, @, 0]", "list[0].facing"),
        (STUDY, "pan_deg = 10", "pan_deg = @", "list[0].pan_deg"),
        (STUDY, "rpy_deg = [0,", "rpy_deg = [@,", "list[1].rpy_deg"),
        (STUDY, "w = 1", "w = @", "list[2].quaternion"),
        (SCENE, "room = { size_m = [2.4,", "room = { size_m = [@,", "room.size_m"),
        (SCENE, "box = { size_m = [0.4,", "box = { size_m = [@,", "box.size_m"),
        (SCENE, "plane = { size_m = [0.4,", "plane = { size_m = [@,", "plane.size_m"),
        (SCENE, "sphere = { radius_m = 0.12", "sphere = { radius_m = @", "sphere.radius_m"),
        (SCENE, "capsule = { radius_m = 0.1", "capsule = { radius_m = @", "capsule.radius_m"),
        (SCENE, "length_m = 0.6", "length_m = @", "capsule.length_m"),
        (SCENE, "cylinder = { radius_m = 0.15", "cylinder = { radius_m = @", "cylinder.radius_m"),
        (SCENE, "height_m = 1.2", "height_m = @", "cylinder.height_m"),
        (SCENE, "position_m = [0.7,", "position_m = [@,", "\"crate\".position_m"),
        (SCENE, "rpy_deg = [0,", "rpy_deg = [@,", "\"panel\".rpy_deg"),
        (SCENE, "w = 1", "w = @", "\"arm\".quaternion"),
    ] {
        for value in ["nan", "-nan", "inf", "-inf", "1e300", "-1e300"] {
            wrong(file, from, &to.replace('@', value), &[key, " must "]);
        }
    }
}

#[test]
fn numbers_out_of_range() {
    for (file, from, to, expected) in [
        (STUDY, "seed = 7", "seed = 7\nmin_hits = 0", "study.toml: min_hits = 0: must be 1 or more"),
        (STUDY, "voxel_size_m = 0.1", "voxel_size_m = 0", "grid.voxel_size_m = 0: must be"),
        (STUDY, "voxel_size_m = 0.1", "voxel_size_m = -0.1", "grid.voxel_size_m = -0.1: must be"),
        (STUDY, "voxel_size_m = 0.1", "voxel_size_m = 50", "grid.voxel_size_m = 50: must be"),
        (STUDY, "[grid]", "[grid]\nbounds_m = { min = [0, 0, 0], max = [1, 1, 0] }", "grid.bounds_m.max"),
        (STUDY, "radius_m = 0.6", "radius_m = 0", "region \"robot\".sphere.radius_m = 0"),
        (STUDY, "radius_m = 0.6", "radius_m = -1", "region \"robot\".sphere.radius_m = -1"),
        (STUDY, "max_m = [0.5, 0.5, 1.1]", "max_m = [0.5, 0.5, 0.1]", "region \"box\".box.max_m"),
        (
            STUDY,
            "[87, 58]",
            "[190, 58]",
            "sensor \"camera\".fov_deg = 190: must be angles from 0.001 and below 180",
        ),
        (STUDY, "[87, 58]", "[87, 0]", "sensor \"camera\".fov_deg = 0"),
        (STUDY, "[87, 58]", "[-87, 58]", "sensor \"camera\".fov_deg = -87"),
        (STUDY, "[87, 58]", "180", "`fov_deg` (line 18), as in fov_deg = [87, 58], horizontal and vertical"),
        (STUDY, "[16, 9]", "[0, 9]", "sensor \"camera\".resolution_px = [0, 9]"),
        (STUDY, "[16, 9]", "[1000000, 1000000]", "sensor \"camera\".resolution_px"),
        (STUDY, "[16, 9]", "[4294967295, 4294967295]", "sensor \"camera\".resolution_px"),
        (STUDY, "[0.2, 3.0]", "[3.0, 0.2]", "sensor \"camera\".range_m = [3.0, 0.2]"),
        (STUDY, "[0.2, 3.0]", "[-1, 3.0]", "sensor \"camera\".range_m"),
        (STUDY, "[0.2, 3.0]", "[1, 1]", "sensor \"camera\".range_m"),
        (STUDY, "near_ignore_m = 0.05", "near_ignore_m = -1", "near_ignore_m = -1"),
        (STUDY, "near_ignore_m = 0.05", "near_ignore_m = 3", "near_ignore_m = 3"),
        (STUDY, "step = 1.0", "step = 0", "poses \"wall\".x_m = { start = -1, stop = 1, step = 0 }"),
        (STUDY, "step = 1.0", "step = -1", "poses \"wall\".x_m"),
        (STUDY, "stop = 1.0", "stop = -2", "poses \"wall\".x_m"),
        (STUDY, "step = 1.0", "step = 1e-9", "poses \"wall\".x_m"),
        (STUDY, "y_m = -0.75", "y_m = { start = 0, stop = 1, step = 5e-7 }", "more than 4000000 poses"),
        (STUDY, "z_m = [1.2]", "z_m = []", "poses \"wall\".z_m = []"),
        (STUDY, "facing = [0, 1, 0]", "facing = [0, 0, 0]", "poses \"wall\".facing = [0.0, 0.0, 0.0]"),
        (STUDY, "pan = -20", "pan = -400", "orientations_deg[1].pan = -400"),
        (STUDY, "tilt = -30", "tilt = -200", "orientations_deg[1].tilt = -200"),
        (STUDY, "count = 2", "count = 0", "random.count = 0"),
        (STUDY, "count = 2", "count = 4000000000", "random.count = 4000000000"),
        (STUDY, "max_m = [0.9,", "max_m = [-1,", "random.max_m"),
        (STUDY, "tilt_deg = [-30, 30]", "tilt_deg = [30, -30]", "random.tilt_deg"),
        // Refused whatever the seed draws from it.
        (STUDY, "tilt_deg = [-30, 30]", "tilt_deg = [-30, 180.001]", "random.tilt_deg = 180.001"),
        (STUDY, "[360, 90]", "[361, 90]", "sensor \"lidar\".fov_deg = 361"),
        (STUDY, "[360, 90]", "[0, 90]", "sensor \"lidar\".fov_deg = 0"),
        (STUDY, "[360, 90]", "[360, 181]", "sensor \"lidar\".fov_deg = 181"),
        (STUDY, "[8, 12]", "[0, 12]", "sensor \"lidar\".resolution_deg = 0"),
        (STUDY, "[8, 12]", "[8, -1]", "sensor \"lidar\".resolution_deg = -1"),
        (STUDY, "[8, 12]", "0.001", "sensor \"lidar\".resolution_deg = 0.001: gives"),
        (STUDY, "fov_deg = [360, 90]", "elevation_deg = [0, 91]", "sensor \"lidar\".elevation_deg = 91"),
        (STUDY, "fov_deg = [360, 90]", "elevation_deg = [50, 40]", "sensor \"lidar\".elevation_deg"),
        (STUDY, "fov_deg = [360, 90]", "rings_deg = [0, 95]", "sensor \"lidar\".rings_deg = 95"),
        (STUDY, "fov_deg = [360, 90]", "rings_deg = []", "rings_deg"),
        (STUDY, "pan_deg = 10", "pan_deg = 361", "list[0].pan_deg = 361"),
        (STUDY, "w = 1", "w = 0", "list[2].quaternion"),
        (SCENE, "size_m = [2.4,", "size_m = [-2.4,", "object \"walls\".room.size_m = -2.4"),
        (SCENE, "radius_m = 0.12", "radius_m = 0", "object \"ball\".sphere.radius_m = 0"),
        (SCENE, "height_m = 1.2", "height_m = -1.2", "object \"operator\".cylinder.height_m = -1.2"),
        (SCENE, "w = 1", "w = 0", "object \"arm\".quaternion"),
    ] {
        wrong(file, from, to, &[expected]);
    }
}
