//! Files that can be read and files that cannot, maps laid into grids, and clouds that carve.

use std::io::Write;
use std::path::Path;

use glam::{DMat3, DVec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rawzip::{CompressionMethod, ZipArchiveWriter};

use super::cloud::Cloud;
use super::voxels::{VoxelKnowledge, VoxelMap};
use super::*;
use crate::objects::octomap::{Leaf, Tree};
use perirobot_march::voxel::{BitGrid, Window};

const HERE: DVec3 = DVec3::ZERO;

fn grid(voxel_size_m: f64, size: [u32; 3]) -> Grid {
    Grid { voxel_size_m, origin: [-3, 2, 0], size }
}

/// A map whose voxels are occupied, free or unknown by chance, a third each.
fn speckle(random: &mut ChaCha8Rng, voxel_size_m: f64, corner_m: DVec3, size: [u32; 3]) -> VoxelMap {
    let window = Window { min: [0; 3], size };
    let mut planes = Planes::blank(window);
    for voxel in BitGrid::full(window).voxels() {
        match random.random_range(0..8) {
            0 => planes.occupied.set(voxel),
            1..7 => planes.free.set(voxel),
            _ => {}
        }
    }
    let known = VoxelKnowledge::Planes { planes, knows_hits: false };
    VoxelMap { voxel_size_m, corner_m, sensor_m: None, known }
}

fn planes_of(map: &VoxelMap) -> &Planes {
    match &map.known {
        VoxelKnowledge::Planes { planes, .. } => planes,
        VoxelKnowledge::Leaves(_) => unreachable!("tests make arrays"),
    }
}

#[test]
fn a_map_on_the_grid_of_a_study_comes_back_as_it_is() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    for voxel_size_m in [0.05, 0.1, 0.02, 1.0 / 3.0] {
        let grid = grid(voxel_size_m, [40, 7, 33]);
        let map = speckle(&mut random, voxel_size_m, grid.corner_m([0; 3]), grid.size);
        let said = Recording::Map(Box::new(map.clone())).planes(&Anchor::new(HERE, 0.0), &grid).planes;
        assert_eq!(said.occupied, planes_of(&map).occupied, "{voxel_size_m}");
        assert_eq!(said.free, planes_of(&map).free, "{voxel_size_m}");
    }
}

#[test]
fn a_quarter_turn_moves_each_voxel_to_its_place() {
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let grid = Grid { voxel_size_m: 0.1, origin: [0; 3], size: [12, 9, 4] };
    let map = speckle(&mut random, 0.1, HERE, [9, 12, 4]);
    // x of the map goes along the world's y, its y against the world's x.
    let anchor = Anchor::new(DVec3::new(1.2, 0.0, 0.0), std::f64::consts::FRAC_PI_2);
    let said = Recording::Map(Box::new(map.clone())).planes(&anchor, &grid).planes;
    for [x, y, z] in BitGrid::full(grid.window()).voxels() {
        let of_map = [y, 11 - x, z];
        assert_eq!(said.occupied.get([x, y, z]), planes_of(&map).occupied.get(of_map), "{x} {y} {z}");
        assert_eq!(said.free.get([x, y, z]), planes_of(&map).free.get(of_map), "{x} {y} {z}");
    }
}

/// Area that a square of one voxel, so much smaller on each side, shares with a quadrangle, by clipping.
fn shared_area(square: [f64; 2], corners: [[f64; 2]; 4], by: f64) -> f64 {
    let mut polygon = corners.to_vec();
    for (axis, side) in [(0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)] {
        let limit = if side > 0.0 { square[axis] + by } else { square[axis] + 65536.0 - by };
        let depth = |p: &[f64; 2]| side * (p[axis] - limit);
        let mut clipped = Vec::new();
        for (n, a) in polygon.iter().enumerate() {
            let b = &polygon[(n + 1) % polygon.len()];
            let (da, db) = (depth(a), depth(b));
            if da >= 0.0 {
                clipped.push(*a);
            }
            if (da > 0.0) != (db > 0.0) && da != db {
                let share = da / (da - db);
                clipped.push([a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])]);
            }
        }
        polygon = clipped;
    }
    let twice: f64 = (0..polygon.len())
        .map(|n| {
            let (a, b) = (polygon[n], polygon[(n + 1) % polygon.len()]);
            a[0] * b[1] - a[1] * b[0]
        })
        .sum();
    twice.abs() / 2.0
}

#[test]
fn turned_maps_of_other_sizes_agree_with_shares_of_area() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let grid = grid(0.1, [9, 8, 3]);
    let [mut occupied, mut free, mut close] = [0; 3];
    for _ in 0..40 {
        let voxel_size_m = random.random_range(20..300) as f64 / 1000.0;
        let size =
            [3 + random.random_range(0..12), 3 + random.random_range(0..12), 2 + random.random_range(0..4)];
        let map = speckle(&mut random, voxel_size_m, DVec3::new(0.013, -0.4, 0.02), size);
        let yaw_rad = random.random_range(-314..314) as f64 / 100.0;
        let at = DVec3::new(random.random_range(-60..60) as f64 / 100.0, 0.531, -0.053);
        let anchor = Anchor::new(at, yaw_rad);
        let said = Recording::Map(Box::new(map.clone())).planes(&anchor, &grid).planes;

        let turned = DMat3::from_rotation_z(yaw_rad);
        let corner = |[i, j, k]: [i32; 3]| {
            let local = map.corner_m + DVec3::new(f64::from(i), f64::from(j), f64::from(k)) * voxel_size_m;
            grid.position_q16(at + turned * local).map(|v| v as f64)
        };
        for z in 0..3 {
            for y in 0..8 {
                for x in 0..9 {
                    let (mut is_touched, mut is_free, mut is_occupied, mut is_close) =
                        (false, true, false, false);
                    // Beyond the map all is unknown: what lies partly there meets the ring around it.
                    for [i, j, k] in BitGrid::full(planes_of(&map).occupied.window().grown(1)).voxels() {
                        let low = corner([i, j, k])[2].max(f64::from(z) * 65536.0);
                        let high = corner([i, j, k + 1])[2].min(f64::from(z + 1) * 65536.0);
                        if high - low <= 256.0 {
                            continue;
                        }
                        let around = [[i, j, k], [i + 1, j, k], [i + 1, j + 1, k], [i, j + 1, k]];
                        let flat = around.map(|at| [corner(at)[0], corner(at)[1]]);
                        let square = [f64::from(x) * 65536.0, f64::from(y) * 65536.0];
                        // What is about as deep as a hair is left to integers.
                        let [all, inside] = [0.0, 384.0].map(|by| shared_area(square, flat, by) > 1.0);
                        is_close |= all && !inside;
                        if inside {
                            is_touched = true;
                            is_occupied |= planes_of(&map).occupied.get([i, j, k]);
                            is_free &= planes_of(&map).free.get([i, j, k]);
                        }
                    }
                    is_free &= is_touched;
                    if is_close {
                        close += 1;
                        continue;
                    }
                    let found = (said.occupied.get([x, y, z]), said.free.get([x, y, z]));
                    assert_eq!(found, (is_occupied, is_free), "{x} {y} {z}, yaw {yaw_rad}");
                    occupied += u32::from(is_occupied);
                    free += u32::from(is_free);
                }
            }
        }
    }
    assert!(occupied > 300 && free > 300 && close < 40 * 216 / 5, "{occupied} {free} {close}");
}

#[test]
fn numbers_in_single_precision_move_no_voxel() {
    let mut random = ChaCha8Rng::seed_from_u64(6);
    for (voxel_size_m, origin) in [(0.02, [505, -7, 3]), (0.05, [202, 1, 0])] {
        let grid = Grid { voxel_size_m, origin, size: [700, 3, 2] };
        let single = |v: f64| f64::from(v as f32);
        let corner_m = DVec3::from_array(grid.corner_m([0; 3]).to_array().map(single));
        let map = speckle(&mut random, single(voxel_size_m), corner_m, grid.size);
        let said = Recording::Map(Box::new(map.clone())).planes(&Anchor::new(HERE, 0.0), &grid).planes;
        assert_eq!(said.occupied, planes_of(&map).occupied, "{voxel_size_m}");
        assert_eq!(said.free, planes_of(&map).free, "{voxel_size_m}");
    }
    let fine = Recording::Map(Box::new(speckle(&mut random, 0.001, HERE, [3; 3])));
    let is_too_fine = |voxel_size_m| fine.is_too_fine(&Anchor::new(HERE, 0.0), &grid(voxel_size_m, [9; 3]));
    assert!(is_too_fine(0.07) && !is_too_fine(0.06));
}

#[test]
fn points_that_are_infinitely_far_away_keep_their_direction() {
    let grid = Grid { voxel_size_m: 0.001, origin: [0; 3], size: [40, 40, 1] };
    for scale in [1.0, 1e4, 1e30] {
        let cloud = Cloud::new(DVec3::splat(0.0005), vec![DVec3::new(2.0, 1.0, 0.0) * scale]).unwrap();
        let said = Recording::Clouds(vec![cloud]).planes(&Anchor::new(HERE, 0.0), &grid).planes;
        assert!(
            said.occupied.is_empty() && said.free.get([39, 19, 0]) && !said.free.get([30, 30, 0]),
            "{scale}"
        );
        assert_eq!(said.free.count(), 60, "{scale}");
    }
}

#[test]
fn leaves_of_a_tree_are_cubes() {
    let leaves = vec![
        Leaf { key: [-4, 4, 0], edge: 4, occupied: false },
        Leaf { key: [0, 4, 0], edge: 1, occupied: true },
    ];
    let map = VoxelMap::from_tree(Tree { resolution_m: 0.1, leaves });
    let grid = grid(0.1, [8, 8, 3]);
    let said = Recording::Map(Box::new(map)).planes(&Anchor::new(HERE, 0.0), &grid).planes;
    assert_eq!(said.occupied.voxels().collect::<Vec<_>>(), [[3, 2, 0]]);
    assert_eq!(said.free.count(), 3 * 4 * 3, "what lies inside the grid: keys -3 to -1, 4 to 7, 0 to 2");
}

#[test]
fn a_point_marks_its_voxel_and_frees_the_way_to_it() {
    let grid = Grid { voxel_size_m: 0.1, origin: [0; 3], size: [10, 4, 4] };
    let cloud = |sensor: [f64; 3], points: &[[f64; 3]]| {
        let points = points.iter().map(|point| DVec3::from_array(*point)).collect();
        let cloud = Cloud::new(DVec3::from_array(sensor), points).unwrap();
        Recording::Clouds(vec![cloud]).planes(&Anchor::new(HERE, 0.0), &grid).planes
    };
    let voxels = |plane: &BitGrid| plane.voxels().collect::<Vec<_>>();
    let along_x = |from: i32, to: i32| (from..to).map(|x| [x, 1, 1]).collect::<Vec<_>>();

    let said = cloud([0.05, 0.15, 0.15], &[[0.45, 0.15, 0.15]]);
    assert_eq!((voxels(&said.occupied), voxels(&said.free)), (vec![[4, 1, 1]], along_x(0, 4)));
    let said = cloud([0.95, 0.15, 0.15], &[[0.45, 0.15, 0.15]]);
    assert_eq!((voxels(&said.occupied), voxels(&said.free)), (vec![[4, 1, 1]], along_x(5, 10)));
    let said = cloud([0.45, 0.15, 0.15], &[[0.46, 0.15, 0.15]]);
    assert_eq!((voxels(&said.occupied), voxels(&said.free)), (vec![[4, 1, 1]], vec![]));
    let said = cloud([0.45, 0.15, 0.15], &[[1.75, 0.15, 0.15]]);
    assert_eq!((voxels(&said.occupied), voxels(&said.free)), (vec![], along_x(4, 10)), "a point outside");
    let said = cloud([-2.0, 0.15, 0.15], &[[0.45, 0.15, 0.15]]);
    assert_eq!(
        (voxels(&said.occupied), voxels(&said.free)),
        (vec![[4, 1, 1]], along_x(0, 4)),
        "a sensor outside"
    );
    let said = cloud([-2.0, 5.0, 0.15], &[[-1.0, 0.15, 0.15]]);
    assert!(said.occupied.is_empty() && said.free.is_empty(), "a ray past the grid");
    let said = cloud([5.0, 5.0, 0.15], &[[5.0, 7.0, 0.15]]);
    assert!(said.occupied.is_empty() && said.free.is_empty());
}

#[test]
fn an_anchor_turns_a_cloud_with_its_sensor() {
    let grid = Grid { voxel_size_m: 0.1, origin: [0; 3], size: [10, 10, 4] };
    let cloud = Cloud::new(HERE, vec![DVec3::new(0.4, 0.0, 0.0)]).unwrap();
    let anchor = Anchor::new(DVec3::new(0.25, 0.15, 0.15), std::f64::consts::FRAC_PI_2);
    let said = Recording::Clouds(vec![cloud]).planes(&anchor, &grid).planes;
    assert_eq!(said.occupied.voxels().collect::<Vec<_>>(), [[2, 5, 1]]);
    assert_eq!(said.free.voxels().collect::<Vec<_>>(), (1..5).map(|y| [2, y, 1]).collect::<Vec<_>>());
}

/// Random rays agree with a march in small steps, wherever the step is not within a hair of a boundary.
#[test]
fn what_a_cloud_frees_lies_on_its_rays() {
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let grid = Grid { voxel_size_m: 0.1, origin: [0; 3], size: [30, 25, 20] };
    let mut place = |spread: i32| {
        DVec3::from_array(std::array::from_fn(|_| {
            f64::from(random.random_range(-spread..3000 + spread)) / 1000.0
        }))
    };
    let mut freed = 0;
    for _ in 0..300 {
        let (sensor, point) = (place(500), place(500));
        let cloud = Cloud::new(sensor, vec![point]).unwrap();
        let said = Recording::Clouds(vec![cloud]).planes(&Anchor::new(HERE, 0.0), &grid).planes;
        let end = Grid::voxel_of(grid.position_q16(point));
        assert_eq!(said.occupied.get(end), grid.window().contains(end));
        let distance = |voxel: [i32; 3]| {
            let centre = DVec3::from_array(voxel.map(|v| (f64::from(v) + 0.5) * 0.1));
            let way = point - sensor;
            let share = ((centre - sensor).dot(way) / way.length_squared()).clamp(0.0, 1.0);
            (centre - sensor - way * share).length()
        };
        for voxel in said.free.voxels() {
            // Half of a voxel's diagonal.
            assert!(distance(voxel) < 0.0867, "{voxel:?} of {sensor} {point}");
            assert!(voxel != end);
        }
        freed += said.free.count();
        // What the segment crosses for sure is freed.
        for step in 0..4000 {
            let at = sensor + (point - sensor) * f64::from(step) / 4000.0;
            let voxel = Grid::voxel_of(grid.position_q16(at));
            let from_boundary = (at / 0.1 - (at / 0.1).round()).abs().min_element();
            if from_boundary > 1e-3 && grid.window().contains(voxel) && voxel != end {
                assert!(said.free.get(voxel), "{voxel:?} at {at} of {sensor} {point}");
            }
        }
    }
    assert!(freed > 3000, "{freed}");
}

const POINTS: [[f32; 3]; 3] = [[1.0, 2.5, -0.25], [f32::NAN, 0.0, 0.0], [0.0, -7.0, 3.0]];

fn points_of(parsed: Result<Cloud, perirobot_march::error::Issue>) -> Vec<[f64; 3]> {
    let cloud = parsed.unwrap();
    assert_eq!(cloud.without_point, 1);
    cloud.points_m.iter().map(|point| point.to_array()).collect()
}

#[test]
fn the_points_of_every_kind_of_ply() {
    let expected = vec![[1.0, 2.5, -0.25], [0.0, -7.0, 3.0]];
    let header = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\ncomment by hand\nelement vertex 3\nproperty uchar ring\nproperty float x\n\
             property float y\nproperty float32 z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        )
        .into_bytes()
    };
    let text = POINTS.map(|[x, y, z]| format!("7 {x} {y} {z}\n")).concat();
    let text = [header("ascii"), text.into_bytes(), b"3 0 1 2\n".to_vec()].concat();
    assert_eq!(points_of(ply::parse(&text)), expected);
    for is_big in [false, true] {
        let bytes = |v: f32| if is_big { v.to_be_bytes() } else { v.to_le_bytes() };
        let records = POINTS.iter().flat_map(|point| [vec![7], point.map(bytes).concat()].concat());
        let order = if is_big { "binary_big_endian" } else { "binary_little_endian" };
        let file = [header(order), records.collect()].concat();
        assert_eq!(points_of(ply::parse(&file)), expected);
        let cut = ply::parse(&file[..file.len() - 1]).unwrap_err();
        assert!(format!("{cut:?}").contains("has 2 of the 3 points"), "{cut:?}");
    }
}

#[test]
fn entries_without_a_point_are_written_in_many_ways() {
    for nothing in ["nan", "-nan", "NaN", "-nan(ind)", "nan(snan)", "1.#QNAN", "-1.#IND", "inf", "-1.#INF"] {
        let text = format!("1 2 3\n{nothing} {nothing} {nothing}\n");
        let mut file =
            b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 2\nVIEWPOINT 0 0 0 0 0 0 0\nDATA ascii\n".to_vec();
        file.extend(text.as_bytes());
        assert_eq!(points_of(pcd::parse(&file)), [[1.0, 2.0, 3.0]], "{nothing}");
        let mut file = b"ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float z\nend_header\n".to_vec();
        file.extend(text.as_bytes());
        assert_eq!(points_of(ply::parse(&file)), [[1.0, 2.0, 3.0]], "{nothing}");
    }
}

#[test]
fn compressed_points_that_are_stored_are_read() {
    let columns = [1.0f32, f32::NAN, 2.5, 0.0, -0.25, 0.0].map(f32::to_le_bytes).concat();
    let mut file = b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 2\nDATA binary_compressed\n".to_vec();
    file.extend([24, 0, 0, 0, 24, 0, 0, 0]);
    file.extend(columns);
    assert_eq!(points_of(pcd::parse(&file)), [[1.0, 2.5, -0.25]]);
}

#[test]
fn thin_labels_are_refused_before_their_planes_are_made() {
    // A row of one voxel takes the room of 32: 2^20 x 70 rows would be three planes of 280 MB.
    let begun = std::time::Instant::now();
    let each: &dyn Fn([usize; 3]) -> u8 = &|_| panic!("nothing is read");
    let error = Recording::from_labels([1, 1 << 20, 70], each, DVec3::ZERO, 0.1).unwrap_err().to_string();
    assert!(error.contains("with x filled up to 32: cut the map to the cell"), "{error}");
    assert!(begun.elapsed().as_secs() < 5);
}

#[test]
fn maps_of_a_country_are_moved_to_the_cell() {
    let numbers = [-500_000.0, -5_700_000.0, 0.0, 0.0];
    let anchor = Anchor::from_numbers(&numbers).unwrap();
    assert_eq!(anchor.world(DVec3::new(500_001.5, 5_700_000.25, 1.0)), DVec3::new(1.5, 0.25, 1.0));
    assert_eq!(Anchor::from_numbers(&[1.1e8, 0.0, 0.0, 0.0]), None);
}

fn pcd(data: &str, fields: &str, viewpoint: &str) -> Vec<u8> {
    format!(
        "# .PCD v0.7\nVERSION 0.7\nFIELDS {fields}\nSIZE 1 4 4 4\nTYPE U F F F\nCOUNT 2 1 1 1\nWIDTH 3\nHEIGHT 1\n\
         VIEWPOINT {viewpoint}\nPOINTS 3\nDATA {data}\n"
    )
    .into_bytes()
}

#[test]
fn the_points_of_every_kind_of_pcd() {
    let expected = vec![[1.0, 2.5, -0.25], [0.0, -7.0, 3.0]];
    let header = |data: &str| pcd(data, "ring x y z", "0 0 0 1 0 0 0");
    // As older programs write it.
    let older =
        String::from_utf8(header("ascii")).unwrap().replace("POINTS 3\n", "").replace("FIELDS", "COLUMNS");
    let text = POINTS.map(|[x, y, z]| format!("7 8 {x} {y} {z}\n")).concat();
    assert_eq!(points_of(pcd::parse(format!("{older}{text}").as_bytes())), expected);
    assert_eq!(points_of(pcd::parse(&[header("ascii"), text.into_bytes()].concat())), expected);
    let records = POINTS.iter().flat_map(|point| [vec![7, 8], point.map(f32::to_le_bytes).concat()].concat());
    assert_eq!(points_of(pcd::parse(&[header("binary"), records.collect()].concat())), expected);

    // The columns, after two bytes of each point that are all alike: a literal, and a run into itself.
    let columns: Vec<u8> =
        (0..3).flat_map(|axis| POINTS.map(|point| point[axis].to_le_bytes()).concat()).collect();
    let mut packed = vec![0, 9, 3 << 5, 0];
    for literal in columns.chunks(32) {
        packed.push(literal.len() as u8 - 1);
        packed.extend(literal);
    }
    let lengths = [(packed.len() as u32).to_le_bytes(), 42u32.to_le_bytes()].concat();
    let file = [header("binary_compressed"), lengths, packed].concat();
    assert_eq!(points_of(pcd::parse(&file)), expected);
    assert!(pcd::parse(&file[..file.len() - 1]).is_err());
}

#[test]
fn the_viewpoint_of_a_pcd_moves_sensor_and_points() {
    let turned = std::f64::consts::FRAC_1_SQRT_2;
    let mut file = pcd("ascii", "ring x y z", &format!("1 2 3 {turned} 0 0 {turned}"));
    file.extend(b"7 8 1 0 0\n7 8 nan 0 0\n7 8 0 0 1\n");
    let cloud = pcd::parse(&file).unwrap();
    assert_eq!(cloud.sensor_m, DVec3::new(1.0, 2.0, 3.0));
    let expected = [DVec3::new(1.0, 3.0, 3.0), DVec3::new(1.0, 2.0, 4.0)];
    assert!(cloud.points_m.iter().zip(expected).all(|(a, b)| a.distance(b) < 1e-12), "{:?}", cloud.points_m);
    let elsewhere = cloud.seen_from(Some(DVec3::X));
    assert_eq!(elsewhere.sensor_m, DVec3::X);
}

/// An array with its header.
fn array(descr: &str, shape: &str, is_fortran: bool, bytes: &[u8]) -> Vec<u8> {
    let order = if is_fortran { "True" } else { "False" };
    let header = format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}\n");
    let length = (header.len() as u16).to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), bytes].concat()
}

/// An archive of arrays, each with its header and its bytes, not packed.
fn npz(arrays: &[(&str, &str, &str, bool, &[u8])]) -> Vec<u8> {
    let files = arrays.iter().map(|(name, descr, shape, is_fortran, bytes)| {
        (format!("{name}.npy"), array(descr, shape, *is_fortran, bytes))
    });
    let mut archive = ZipArchiveWriter::new(Vec::new());
    for (name, bytes) in files {
        let (mut entry, summed) = archive.new_file(&name).start().unwrap();
        let mut file = summed.wrap(&mut entry);
        file.write_all(&bytes).unwrap();
        let (_, sums) = file.finish().unwrap();
        entry.finish(sums).unwrap();
    }
    archive.finish().unwrap()
}

#[test]
fn labels_come_in_either_order_and_any_whole_type() {
    let origin: Vec<u8> = [0.5f64, 0.0, -1.0].iter().flat_map(|v| v.to_le_bytes()).collect();
    let size = 0.25f64.to_le_bytes();
    let rest =
        [("origin_m", "<f8", "(3,)", false, &origin[..]), ("voxel_size_m", "<f8", "()", false, &size[..])];
    // [x, y, z] = [1, 0, 0] is occupied, [0, 0, 1] free, all else unknown.
    let fortran = [-1i8, 1, -1, -1, 0, -1, -1, -1].map(|v| v as u8);
    let in_c: Vec<u8> = [-1i64, 0, -1, -1, 1, -1, -1, -1].iter().flat_map(|v| v.to_be_bytes()).collect();
    for labels in
        [("labels", "|i1", "(2, 2, 2)", true, &fortran[..]), ("labels", ">i8", "(2, 2, 2)", false, &in_c[..])]
    {
        let map = npz::parse(&npz(&[&[labels], &rest[..]].concat())).unwrap();
        assert_eq!((map.voxel_size_m, map.corner_m), (0.25, DVec3::new(0.5, 0.0, -1.0)));
        assert_eq!(planes_of(&map).occupied.voxels().collect::<Vec<_>>(), [[1, 0, 0]]);
        assert_eq!(planes_of(&map).free.voxels().collect::<Vec<_>>(), [[0, 0, 1]]);
    }
    let bytes = [255u8, 1, 255, 255, 0, 255, 255, 255];
    let map =
        npz::parse(&npz(&[&[("labels", "|u1", "(2, 2, 2)", true, &bytes[..])], &rest[..]].concat())).unwrap();
    assert_eq!((planes_of(&map).occupied.count(), planes_of(&map).free.count()), (1, 1));
    let two = [2u8; 8];
    let long = vec![0; 1 << 23];
    let wrong = |labels| {
        let parsed = npz::parse(&npz(&[&[labels], &rest[..]].concat()));
        format!("{:?}", parsed.unwrap_err())
    };
    assert!(wrong(("labels", "|i1", "(2, 2, 2)", true, &two[..])).contains("must be 1 (occupied)"));
    assert!(wrong(("labels", "|i1", "(4, 2)", true, &two[..])).contains("must be (x, y, z)"));
    assert!(wrong(("labels", "<f8", "(2, 2, 2)", true, &two[..])).contains("truncated"));
    assert!(wrong(("voxels", "|i1", "(2, 2, 2)", true, &two[..])).contains("labels"));
    assert!(wrong(("labels", "|i1", "(2, 2, 2097152)", true, &long[..])).contains("has the shape"));
    assert!(wrong(("labels", "<U4", "(2, 2, 2)", true, &two[..])).contains("<U4"));
}

/// An archive of numpy's: labels (4, 3, 2), of which [1, 0, 0] is occupied and hit, [0, 0, 1] free, all else unknown.
fn numpy_file(name: &str) -> Vec<u8> {
    std::fs::read(
        Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("tests/fuzz/corpus/npz").join(name),
    )
    .unwrap()
}

#[test]
fn what_numpy_stores_and_packs_is_read() {
    let [stored, packed] = ["stored.npz", "packed.npz"].map(numpy_file);
    assert!(packed.len() < stored.len());
    for bytes in [stored, packed] {
        let map = npz::parse(&bytes).unwrap();
        assert_eq!((map.voxel_size_m, map.corner_m), (0.25, DVec3::new(0.5, 0.0, -1.0)));
        let planes = planes_of(&map);
        assert_eq!(planes.occupied.voxels().collect::<Vec<_>>(), [[1, 0, 0]]);
        assert_eq!(planes.hits.voxels().collect::<Vec<_>>(), [[1, 0, 0]]);
        assert_eq!(planes.free.voxels().collect::<Vec<_>>(), [[0, 0, 1]]);
    }
}

#[test]
fn of_arrays_of_one_name_the_last_is_read() {
    let size = 0.25f64.to_le_bytes();
    let labels = ("labels", "|i1", "(2, 2, 2)", true, &[1, 0, 0, 0, 0, 0, 0, 0][..]);
    let rest =
        [("origin_m", "<f8", "(3,)", false, &[0; 24][..]), ("voxel_size_m", "<f8", "()", false, &size)];
    let flat = ("labels", "|i1", "(1,)", true, &[1][..]);
    assert!(npz::parse(&npz(&[&[flat, labels], &rest[..]].concat())).is_ok());
    assert!(npz::parse(&npz(&[&[labels, flat], &rest[..]].concat())).is_err());
}

#[test]
fn a_small_archive_of_many_voxels_is_refused() {
    use flate2::{Compression, write::DeflateEncoder};
    let mut archive = ZipArchiveWriter::new(Vec::new());
    for (name, bytes) in [
        ("labels.npy", array("|i1", "(1, 1048576, 30)", false, &vec![0; 30 << 20])),
        ("origin_m.npy", array("<f8", "(3,)", false, &[0; 24])),
        ("voxel_size_m.npy", array("<f8", "()", false, &0.1f64.to_le_bytes())),
    ] {
        let file = archive.new_file(name).compression_method(CompressionMethod::DEFLATE);
        let (mut entry, summed) = file.start().unwrap();
        let mut packed = summed.wrap(DeflateEncoder::new(&mut entry, Compression::fast()));
        packed.write_all(&bytes).unwrap();
        let (packed, sums) = packed.finish().unwrap();
        packed.finish().unwrap();
        entry.finish(sums).unwrap();
    }
    let said = format!("{:?}", npz::parse(&archive.finish().unwrap()).unwrap_err());
    assert!(said.contains("unfolds to far more than its size"), "{said}");
}

/// The parts of an archive that are turned stand where the format has them: in the first entry of the directory,
/// flags at 8, method at 10, packed size at 20, size at 24, and the local header's place at 42.
#[test]
fn archives_that_are_damaged_or_packed_otherwise_are_refused() {
    let refused = |bytes: &[u8]| format!("{:?}", npz::parse(bytes).unwrap_err());
    for name in ["stored.npz", "packed.npz"] {
        let good = numpy_file(name);
        let directory = good.windows(4).position(|bytes| bytes == b"PK\x01\x02").unwrap();
        let name_begins = directory + 46;
        assert!(good[name_begins..].starts_with(b"labels.npy"));
        for (at, to, expected) in [
            (directory, 0, "is not an archive of arrays"),
            (directory + 8, 1, "is encrypted"),
            (directory + 10, 12, "BZIP2"),
            (directory + 10, 99, "numpy.savez_compressed"),
            (directory + 16, good[directory + 16] ^ 1, "is damaged in the archive"),
            (directory + 20, 0, "labels"),
            (directory + 24, good[directory + 24] ^ 1, "is damaged in the archive"),
            (directory + 27, 0x7f, "unfolds to far more than its size: over the 256 MiB"),
            (directory + 44, 0x7f, "labels"),
            (name_begins, b'L', "labels"),
        ] {
            let mut bytes = good.clone();
            assert_ne!(bytes[at], to);
            bytes[at] = to;
            assert!(refused(&bytes).contains(expected), "{name}, {at}: {}", refused(&bytes));
        }
        for cut in [0, 10, good.len() / 2, good.len() - 1] {
            assert!(refused(&good[..cut]).contains("is not an archive of arrays"), "{name}, {cut}");
        }
    }
}

#[test]
fn damaged_files_are_refused_in_words() {
    let said = |parsed: Result<Cloud, perirobot_march::error::Issue>| format!("{:?}", parsed.unwrap_err());
    for (file, expected) in [
        (&b"plx\n"[..], "`ply`"),
        (b"ply\nformat ascii 1.0\n", "end_header"),
        (&[&b"ply\nformat ascii 1.0\ncomment"[..], &[b' '; 70_000]].concat(), "line 3 has more than 65536 bytes"),
        (b"ply\nformat ascii 1.0\nelement vertex ten\n", "must be a whole number"),
        (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n", "no y"),
        (b"ply\nformat ascii 1.0\nelement face 1\nelement vertex 1\nend_header\n", "before its vertices"),
        (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty list uchar int i\nend_header\n", "list"),
        (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\nend_header\n", "half"),
        (b"ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\nend_header\n", "no point"),
        (b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 x\n", "place 3"),
    ] {
        let said = said(ply::parse(file));
        assert!(said.contains(expected), "{said}");
    }
    for (file, expected) in [
        (&b"FIELDS x y z\n"[..], "DATA"),
        (b"FIELDS x y z\nSIZE 4 4\nTYPE F F F\nPOINTS 1\nDATA ascii\n", "as many entries"),
        (b"FIELDS x y z\nSIZE 4 4 3\nTYPE F F F\nPOINTS 1\nDATA ascii\n", "3 bytes"),
        (b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 1\nDATA zipped\n", "zipped"),
        (b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nDATA ascii\n", "POINTS"),
        (b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nVIEWPOINT 0 0 0 9 0 0 0\nPOINTS 1\nDATA ascii\n1 2 3\n", "unit quaternion"),
        (b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 2\nDATA binary_compressed\n\x02\0\0\0\x0c\0\0\0\xe0\x00", "are 12 bytes, and its header makes them 24"),
        (b"FIELDS x y z\nSIZE 1 1 1\nTYPE I I I\nPOINTS 99999999\nDATA binary_compressed\n\x02\0\0\0\xfd\xa2\xe1\x11\xe0\x00", "unfolds to far more than its size"),
        (b"FIELDS x y z\nSIZE 1 1 1\nTYPE I I I\nPOINTS 100000001\nDATA binary\n", "has 100000001 points"),
        (b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 1\nDATA ascii\n1,5 2 3\n", "must be numbers with a decimal point"),
        (b"FIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nPOINTS 1\nDATA binary_compressed\n\x02\0\0\0\x0c\0\0\0\xe0\x00", "too early"),
    ] {
        let said = said(pcd::parse(file));
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn damaged_files_never_panic() {
    let mut random = ChaCha8Rng::seed_from_u64(12);
    let labels = [0u8; 8];
    let size = 0.25f64.to_le_bytes();
    let archive = npz(&[
        ("labels", "|i1", "(2, 2, 2)", true, &labels[..]),
        ("origin_m", "<f8", "(1,)", false, &size[..]),
        ("voxel_size_m", "<f8", "()", false, &size[..]),
    ]);
    let mut text = pcd("ascii", "ring x y z", "0 0 0 1 0 0 0");
    text.extend(b"7 8 1 0 0\n7 8 nan 0 0\n7 8 0 0 1\n");
    let mut binary = pcd("binary_compressed", "ring x y z", "0 0 0 1 0 0 0");
    binary.extend([4, 0, 0, 0, 42, 0, 0, 0, 0, 9, 0xe0, 30, 0]);
    let points = b"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 3\n";
    for good in [&archive[..], &text, &binary, points] {
        for _ in 0..5_000 {
            let mut bytes = good.to_vec();
            for _ in 0..random.random_range(1..4) {
                let at = random.random_range(0..bytes.len());
                bytes[at] = random.random();
            }
            bytes.truncate(random.random_range(0..2 * good.len()));
            let _ = (npz::parse(&bytes), pcd::parse(&bytes).is_ok(), ply::parse(&bytes).is_ok());
        }
    }
}
