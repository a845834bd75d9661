//! Warns of meshes with holes smaller than a voxel: a fence or a grating becomes a wall. How much of its
//! voxels such a surface fills is sampled on straight lines, and the user is asked whether it is see-through.

use glam::DVec3;
use rayon::prelude::*;

use super::World;
use super::sizes::Surfaces;
use crate::input::Study;
use perirobot_march::voxel::{BitGrid, Grid, Window};
use perirobot_scene::objects::spec::SurfaceSpec;
use perirobot_scene::objects::{Mesh, Optical, Role, Scene, Surface};

/// Voxels of an object that are sampled, spread evenly; fewer of a sheet tell nothing.
const MOST_VOXELS: usize = 48;
const LEAST_VOXELS: usize = 12;
/// Lines through each of them on each axis, squared.
const LINES: usize = 12;
/// A surface that leans passes through several voxels of a column.
const DEPTH: f64 = 2.0;
/// Below this share of filled space, rays would pass.
const FILLED: f64 = 0.5;

/// The opaque meshes of the first snapshot that are thin, with what they fill.
pub(super) fn warnings(study: &Study, scenes: &[Scene], worlds: &[World]) -> Vec<String> {
    let (world, truth) = (&worlds[0], worlds[0].truth());
    let surfaces = Surfaces::new(&study.scenes[world.scene]);
    let objects = scenes[0].objects.iter().zip(&truth.objects);
    let thin = objects.filter_map(|(object, voxels)| {
        let counts = object.role == Role::Environment && object.optical == Optical::Opaque && !object.tag_only;
        let Surface::Mesh(mesh) = &object.surface else { return None };
        if !counts || surfaces.get(&object.name).and_then(SurfaceSpec::mesh_file).is_none() {
            return None;
        }
        let share = fill_share(mesh, &voxels.voxels, &world.grid)?;
        (share < FILLED).then(|| {
            format!(
                "object {:?} is a sheet that fills {:.0} % of its voxels, and stops all rays as if it filled them: if it is a \
                 fence or a grating, write optical = \"see_through\"",
                object.name,
                100.0 * share
            )
        })
    });
    thin.collect()
}

/// The share of straight lines through its voxels that meet a sheet, on the axis where most do; `None` for
/// what is no sheet: of the voxels of a sheet, a fourth at least have as many around them, two to each side,
/// as a plane has.
fn fill_share(mesh: &Mesh, voxels: &BitGrid, grid: &Grid) -> Option<f64> {
    let in_sheet = |&voxel: &[i32; 3]| {
        let mut around = 0;
        voxels.each_in(&Window::from_corners(voxel, voxel).grown(2), |_| around += 1);
        around >= 25
    };
    let all = voxels.count() as usize;
    let sheet: Vec<[i32; 3]> = voxels.voxels().filter(in_sheet).collect();
    if sheet.len() < LEAST_VOXELS || 4 * sheet.len() < all {
        return None;
    }
    let corner = |i: u32| {
        let key = mesh.vertices[i as usize] / grid.voxel_size_m;
        key - DVec3::from_array(grid.origin.map(f64::from))
    };
    let triangles: Vec<[DVec3; 3]> = mesh.triangles.iter().map(|t| t.map(corner)).collect();
    let step = sheet.len().div_ceil(MOST_VOXELS);
    let some: Vec<[i32; 3]> = sheet.into_iter().step_by(step).collect();
    let shares = some
        .par_iter()
        .map(|voxel| (0..3).map(|axis| met_share(&triangles, *voxel, axis)).fold(0.0, f64::max));
    Some(shares.sum::<f64>() / some.len() as f64)
}

/// The share of the lines through a voxel along an axis that meet a triangle there.
fn met_share(triangles: &[[DVec3; 3]], voxel: [i32; 3], axis: usize) -> f64 {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let low = DVec3::from_array(voxel.map(f64::from));
    let (mut least, mut most) = (low, low + 1.0);
    least[axis] -= DEPTH;
    most[axis] += DEPTH;
    let mut lines = [false; LINES * LINES];
    for corners in triangles {
        let meets = |r: usize| {
            let of = corners.map(|corner| corner[r]);
            of.iter().any(|x| *x <= most[r]) && of.iter().any(|x| *x >= least[r])
        };
        if !(0..3).all(meets) {
            continue;
        }
        let [a, b, c] = corners.map(|corner| [corner[u], corner[v]]);
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if area.abs() < 1e-12 {
            continue;
        }
        for (number, line) in lines.iter_mut().enumerate().filter(|(_, line)| !**line) {
            let at = |n: usize| (n as f64 + 0.5) / LINES as f64;
            let p = [low[u] + at(number % LINES), low[v] + at(number / LINES)];
            let weight = |from: [f64; 2], to: [f64; 2]| {
                ((to[0] - from[0]) * (p[1] - from[1]) - (to[1] - from[1]) * (p[0] - from[0])) / area
            };
            let [of_c, of_a, of_b] = [weight(a, b), weight(b, c), weight(c, a)];
            let depth = of_a * corners[0][axis] + of_b * corners[1][axis] + of_c * corners[2][axis];
            *line =
                [of_a, of_b, of_c].iter().all(|w| *w >= 0.0) && (least[axis]..=most[axis]).contains(&depth);
        }
    }
    lines.iter().filter(|line| **line).count() as f64 / lines.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;
    use perirobot_scene::objects::{Object, primitive};
    use perirobot_scene::truth::voxelize_all;
    use std::sync::Arc;

    /// The share that a mesh fills of the voxels of 5 cm that it touches.
    fn filled_share(mesh: Mesh) -> Option<f64> {
        let object = Object {
            name: "part".into(),
            role: Role::Environment,
            interior: perirobot_scene::objects::Interior::Free,
            optical: Optical::Opaque,
            radar: Default::default(),
            shade: 0,
            tag_only: false,
            takes_unit: false,
            surface: Surface::Mesh(mesh.clone()),
            frame: perirobot_scene::pose::Pose::ORIGIN,
            keypoints: None,
            linkage: None,
            warnings: Vec::new(),
        };
        let grid = Grid { voxel_size_m: 0.05, origin: [-40; 3], size: [80; 3] };
        let scene =
            Scene { name: "s".into(), snapshot: 0, objects: vec![Arc::new(object)], speeds_mm_s: Vec::new() };
        let truth = voxelize_all(&[scene], grid).unwrap().remove(0);
        fill_share(&mesh, &truth.objects[0].voxels, &grid)
    }

    /// Bars of 4 mm every 4 cm, in both directions.
    fn fence() -> Mesh {
        let mut all = Mesh::default();
        for i in -20..=20 {
            let at = f64::from(i) * 0.04;
            let up = primitive::cuboid(DVec3::new(0.004, 0.004, 1.6));
            all.append(&up.transform(DQuat::IDENTITY, DVec3::new(at, 0.013, 0.0)));
            let across = primitive::cuboid(DVec3::new(1.6, 0.004, 0.004));
            all.append(&across.transform(DQuat::IDENTITY, DVec3::new(0.0, 0.013, at)));
        }
        all
    }

    #[test]
    fn a_fence_fills_little_and_a_plate_all() {
        // 1 − 0.9² of a wall of bars that leave nine tenths open each way.
        let share = filled_share(fence()).unwrap();
        assert!((0.1..0.3).contains(&share), "{share}");
        let leaning = fence().transform(DQuat::from_rotation_x(0.6), DVec3::ZERO);
        let share = filled_share(leaning).unwrap();
        assert!(share < 0.45, "{share}");
        for plate in [DVec3::new(1.0, 0.002, 1.0), DVec3::new(1.0, 0.3, 1.0), DVec3::splat(1.0)] {
            for turn in [0.0, 0.3, 0.785, 1.2] {
                let plate =
                    primitive::cuboid(plate).transform(DQuat::from_rotation_x(turn), DVec3::splat(0.013));
                let share = filled_share(plate).unwrap_or(1.0);
                assert!(share > 0.85, "{turn}: {share}");
            }
        }
        let tilted = DQuat::from_rotation_x(0.785) * DQuat::from_rotation_y(0.6);
        let plate = primitive::cuboid(DVec3::new(1.0, 0.002, 1.0)).transform(tilted, DVec3::ZERO);
        assert!(filled_share(plate).unwrap_or(1.0) > 0.7);
        // A lone bar is no sheet.
        assert_eq!(filled_share(primitive::cuboid(DVec3::new(0.004, 0.004, 1.6))), None);
    }
}
