//! Casts the rays of a picture on a backend like those of any sensor: the voxel, point and face at which each ends.

use glam::DVec3;
use rayon::prelude::*;

use super::eye::PictureCamera;
use perirobot_march::Result;
use perirobot_march::backend::{Backend, GridPose, Noise, Rays, VoxelScene};
use perirobot_march::error::{Argument, Issue, Words};
use perirobot_march::march::{self, FULL_RANGE, Gates, MAX_RANGE_VOXELS, RETURN};
use perirobot_march::voxel::grid::MAX_VOXELS_PER_AXIS;
use perirobot_march::voxel::{BitGrid, Grid, People, Window};
use perirobot_study::sensor::quantise_q15;

/// Rays per cast, so that a large picture fits any device.
const MOST_RAYS: usize = 1 << 20;

/// The end of a picture's ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Hit {
    /// The voxel, in the grid of the scene.
    pub(super) voxel: [i32; 3],
    /// The axis of the entered face.
    pub(super) axis: usize,
    /// −1 or 1: the direction of the ray along it; the face looks the other way.
    pub(super) step: i32,
    /// The distance.
    pub(super) distance_q16: u32,
}

/// Casts every ray of a picture at a plane of voxels of a grid.
pub(super) fn cast(
    plane: &BitGrid,
    grid: &Grid,
    camera: &PictureCamera,
    backend: &mut dyn Backend,
) -> Result<Vec<Option<Hit>>> {
    let (scene, shift, around) = enclose_eye(plane, grid, camera.eye_m)?;
    let row = |r: usize| std::array::from_fn(|a| quantise_q15(camera.rotation.col(a)[r]));
    let placement = GridPose {
        origin_q16: around.position_q16(camera.eye_m).map(|x| x as i32),
        axis_q15: std::array::from_fn(row),
        truly: None,
        draws: 0,
    };
    let [width, height] = camera.size;
    let pixels = (0..height).flat_map(|v| (0..width).map(move |u| [u, v]));
    let dirs: Vec<[i32; 3]> =
        pixels.map(|pixel| camera.direction(pixel).normalize().to_array().map(quantise_q15)).collect();
    let mut hits = Vec::with_capacity(dirs.len());
    for dirs_q15 in dirs.chunks(MOST_RAYS) {
        backend.tables(&[rays(dirs_q15)])?;
        backend.load(&scene)?;
        let ends = backend.read(0, &placement)?.ends;
        hits.par_extend(ends.par_iter().zip(dirs_q15).map(|(end, dir_q15)| {
            (end.kind == RETURN).then(|| hit(&placement, *dir_q15, end.crossings, shift))
        }));
    }
    Ok(hits)
}

/// The plane in a grid that also contains the eye, the shift of its voxels there, and that grid.
fn enclose_eye(plane: &BitGrid, grid: &Grid, eye_m: DVec3) -> Result<(VoxelScene, [i32; 3], Grid)> {
    let eye = Grid::voxel_of(grid.position_q16(eye_m));
    let window = plane.window().union(&Window::from_corners(eye, eye));
    if let Some(axis) = (0..3).find(|&r| window.size[r] > MAX_VOXELS_PER_AXIS) {
        let DVec3 { x, y, z } = eye_m;
        let what = format!(
            "the eye at {x:.2}, {y:.2}, {z:.2} and the cell span {} voxels along {}, at \
                    most {MAX_VOXELS_PER_AXIS} fit",
            window.size[axis],
            ["x", "y", "z"][axis]
        );
        let cure = Words::from("move the eye closer (a wider ")
            + Argument("fov deg")
            + " also helps), or use larger voxels ("
            + Argument("voxel size")
            + ")";
        return Err(Issue::too_large(what).with_advice(cure).with_place(Argument("from")).into());
    }
    let shift = window.min.map(|low| -low);
    let whole = Window { min: [0; 3], size: window.size };
    let moved = BitGrid::from_words(plane.window().shift(shift), plane.words().to_vec())
        .expect("a plane has the words of its window");
    let one = Window::from_corners([0; 3], [0; 3]);
    let none = BitGrid::new(one);
    let scene = VoxelScene {
        shades: None,
        blockers: moved.to_window(whole).into(),
        over_time: None,
        // Only the ends of rays are used.
        window: one,
        truth: none.clone(),
        human: none.clone(),
        robot: none.clone(),
        regions: vec![none],
        people: People::default(),
    };
    let origin = std::array::from_fn(|r| grid.origin[r] - shift[r]);
    Ok((scene, shift, Grid { origin, size: window.size, ..*grid }))
}

/// Rays of the greatest length, without noise.
fn rays(dirs_q15: &[[i32; 3]]) -> Rays {
    let gates = Gates {
        range_min_q16: 0,
        range_max_q16: MAX_RANGE_VOXELS << 16,
        shade_ranges_q16: FULL_RANGE,
        along_axis: false,
        near_ignore_q16: 0,
        no_return_is_free: false,
        backdrop: false,
    };
    Rays { dirs_q15: dirs_q15.to_vec().into(), image: None, gates, noise: Noise::default() }
}

/// Follows a returned ray to its end again.
fn hit(from: &GridPose, dir_q15: [i32; 3], crossings: u32, shift: [i32; 3]) -> Hit {
    let ray = from.launch(dir_q15);
    let at_start = march::Crossing { t_q16: 0, axis: 0, voxel: ray.voxel };
    let march::Crossing { t_q16: distance_q16, axis, voxel } =
        march::last_crossing(ray, crossings).unwrap_or(at_start);
    let voxel = std::array::from_fn(|r| voxel[r] - shift[r]);
    Hit { voxel, axis, step: ray.step[axis], distance_q16 }
}
