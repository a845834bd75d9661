//! Insides against two other ways to tell them: the solid angle that the surface takes up, and hand-counted
//! boxes.

use glam::{DQuat, DVec3};

use super::*;
use crate::objects::primitive;

/// The voxels inside, from the world's origin.
fn voxels_inside(mesh: &Mesh, voxel_size_m: f64) -> Vec<[i64; 3]> {
    let rows = MeshRows::new(mesh, voxel_size_m, [0; 3]).unwrap();
    let [ys, zs] = rows.span();
    let rows = &rows;
    zs.flat_map(|z| {
        ys.clone().flat_map(move |y| rows.runs(y, z).into_iter().flatten().map(move |x| [x, y, z]))
    })
    .collect()
}

/// How often the surface winds about a point: its solid angle over a full one (Van Oosterom & Strackee 1983).
fn winding(mesh: &Mesh, point: DVec3) -> f64 {
    let angle = mesh.triangles.iter().map(|t| {
        let [a, b, c] = t.map(|i| mesh.vertices[i as usize] - point);
        let [l, m, n] = [a, b, c].map(DVec3::length);
        let below = l * m * n + a.dot(b) * n + b.dot(c) * l + c.dot(a) * m;
        2.0 * a.dot(b.cross(c)).atan2(below)
    });
    angle.sum::<f64>() / (4.0 * std::f64::consts::PI)
}

fn turn(mesh: Mesh, seed: f64) -> Mesh {
    let axis = DVec3::new(0.3 + seed, 0.5 - seed, 0.7).normalize();
    mesh.transform(DQuat::from_axis_angle(axis, 1.0 + 2.0 * seed), DVec3::new(0.4, -0.3, seed) * 3.0)
}

/// The mesh as its corners are after rounding, in voxels.
fn round(mesh: &Mesh, voxel_size_m: f64) -> Mesh {
    let corner =
        |&v| DVec3::from_array(overlap::corner(v, voxel_size_m).unwrap().map(|x| x as f64 / VOXEL as f64));
    Mesh { vertices: mesh.vertices.iter().map(corner).collect(), triangles: mesh.triangles.clone() }
}

#[test]
fn insides_are_where_the_surface_winds_around() {
    let mut torn = primitive::cylinder(3.0, 6.0, 0.01);
    torn.append(&turn(primitive::sphere(3.0, 0.02), 0.2));
    let mut hollow = primitive::sphere(4.0, 0.02);
    let mut within = primitive::cuboid(DVec3::new(3.0, 4.0, 2.5));
    within.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    hollow.append(&within);
    let mut inward = primitive::capsule(1.5, 4.0, 0.02);
    inward.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let mut seen = 0;
    for (i, mesh) in
        [torn, hollow, inward, primitive::cuboid(DVec3::new(7.0, 5.0, 0.9))].into_iter().enumerate()
    {
        let mesh = turn(mesh, 0.1 * i as f64);
        let found = voxels_inside(&mesh, 0.7);
        let exact = round(&mesh, 0.7);
        let (low, high) = exact.bounds().unwrap();
        let mut expected = Vec::new();
        let voxels = |r: usize| low[r].floor() as i64 - 1..high[r].ceil() as i64 + 1;
        for z in voxels(2) {
            for y in voxels(1) {
                for x in voxels(0) {
                    let centre = DVec3::new(x as f64, y as f64, z as f64) + 0.5;
                    if winding(&exact, centre).abs() > 0.5 {
                        expected.push([x, y, z]);
                    }
                }
            }
        }
        assert_eq!(found, expected, "mesh {i}");
        seen += found.len();
    }
    assert!(seen > 1000, "{seen}");
}

#[test]
fn a_box_is_the_box_moved_by_the_lattice() {
    // 0.3 … 0.8 m at 0.1 m is voxels 3 to 7, however the quads are cut in two.
    let mesh = primitive::cuboid(DVec3::splat(0.5)).transform(DQuat::IDENTITY, DVec3::splat(0.55));
    let voxels = voxels_inside(&mesh, 0.1);
    assert_eq!((voxels.len(), voxels[0], voxels[124]), (125, [3; 3], [7; 3]));
    // From another origin the same voxels have other numbers.
    let rows = MeshRows::new(&mesh, 0.1, [-5, 1, 2]).unwrap();
    assert_eq!((rows.span(), rows.runs(2, 1)), ([2..8, 1..7], vec![8..13]));
    assert_eq!((rows.runs(1, 1), rows.runs(7, 1), rows.runs(2, 0)), (vec![], vec![], vec![]));
}

/// Two prisms that make up a box, with centres exactly on the plane between them, share no voxel and leave
/// none out.
#[test]
fn centres_on_edges_and_in_planes_belong_to_one_side() {
    // Counting 1/512 voxel the corners are at −769 and 3329, so that their middle, 1280, is a centre.
    let (low, high) = (-1.5 - 1.0 / 512.0, 6.5);
    let pick = |i: usize, bit: usize| if i & bit == 0 { low } else { high };
    let vertices: Vec<DVec3> = (0..8).map(|i| DVec3::new(pick(i, 1), pick(i, 2), pick(i, 4))).collect();
    let voxels =
        |triangles: Vec<[u32; 3]>| voxels_inside(&Mesh { vertices: vertices.clone(), triangles }, 1.0);
    // Below and above the plane x = y, through corners 0, 3, 7 and 4.
    let below = [[0, 3, 1], [4, 5, 7], [0, 1, 5], [0, 5, 4], [1, 3, 7], [1, 7, 5], [0, 4, 7], [0, 7, 3]];
    let above = [[0, 2, 3], [4, 7, 6], [0, 4, 6], [0, 6, 2], [2, 6, 7], [2, 7, 3], [0, 7, 4], [0, 3, 7]];
    let (below, above) = (voxels(below.to_vec()), voxels(above.to_vec()));
    let shared = below.iter().filter(|voxel| above.contains(voxel)).count();
    // Nine centres on each axis, −1.5 … 6.5; those on the plane go to the side behind it on x.
    assert_eq!((below.len(), above.len(), shared), (9 * 45, 9 * 36, 0));
    assert_eq!(voxels(primitive::cuboid(DVec3::ONE).triangles).len(), 9 * 81);
}

#[test]
fn open_and_endless_meshes_have_no_inside() {
    let error = |mesh: &Mesh, size| MeshRows::new(mesh, size, [0; 3]).err().unwrap();
    let mut open = primitive::cuboid(DVec3::ONE);
    open.triangles.pop();
    assert!(error(&open, 0.1).to_string().contains("not watertight"));
    let mut turned = primitive::cuboid(DVec3::ONE);
    turned.triangles[0].swap(0, 1);
    assert!(error(&turned, 0.1).to_string().contains("not watertight"));
    let long = primitive::cuboid(DVec3::new(500.0, 1.0, 1.0));
    assert!(error(&long, 0.1).to_string().contains("over 4092 voxels long"));
    let far = primitive::cuboid(DVec3::ONE).transform(DQuat::IDENTITY, DVec3::splat(1e6));
    assert!(error(&far, 0.1).to_string().contains("too far away"));
}
