//! Where some of a sensor's rays end, for drawings of what it looks at.

use glam::DVec3;
use perirobot_march::backend::cpu::BlockerSearch;
use perirobot_march::backend::{GridPose, Rays};
use perirobot_march::voxel::Grid;
use perirobot_study::sensor::look::RayDirection;

/// Rays across a camera's picture.
const ACROSS: u32 = 32;

/// Rays of other tables, evenly spread over it.
const SOME: usize = 256;

/// Where some of a sensor's rays end: in what they hit first, or at the end of their range or of the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Frustum {
    /// Where they begin, in metres.
    pub from_m: DVec3,
    /// Where they end, row by row from the upper left of a camera's picture.
    pub ends_m: Vec<DVec3>,
    /// How many rows and columns there are; one row of other tables.
    pub rows: usize,
    /// The same for columns.
    pub columns: usize,
}

impl Frustum {
    /// Of a sensor's table from where it truly stands.
    pub(super) fn new(rays: &Rays, from: &GridPose, grid: &Grid, search: &BlockerSearch) -> Frustum {
        let (numbers, rows, columns): (Vec<usize>, _, _) = match rays.image {
            Some(image) => {
                let [width, height] = image.size_px;
                let columns = ACROSS.min(width).max(1);
                let rows = (columns * height).div_ceil(width.max(1)).clamp(1, height.max(1));
                // The first and the last pixel are among them.
                let spread =
                    |i: u32, of: u32, px: u32| u64::from(i) * u64::from(px - 1) / u64::from((of - 1).max(1));
                let pixel = |row: u32, column: u32| {
                    spread(row, rows, height) * u64::from(width) + spread(column, columns, width)
                };
                let all =
                    (0..rows).flat_map(|row| (0..columns).map(move |column| pixel(row, column) as usize));
                (all.collect(), rows as usize, columns as usize)
            }
            None => {
                let step = rays.dirs_q15.len().div_ceil(SOME).max(1);
                let all: Vec<usize> = (0..rays.dirs_q15.len()).step_by(step).collect();
                let columns = all.len();
                (all, 1, columns)
            }
        };
        let caster = from.caster();
        let begin = search.rays_from(caster.origin_q16);
        let metres = |q16: f64| q16 / 65_536.0 * grid.voxel_size_m;
        let origin = DVec3::from_array(caster.origin_q16.map(f64::from));
        let corner = grid.corner_m([0; 3]);
        let end = |ray: usize| {
            let way = RayDirection::new(from, rays.dirs_q15[ray]).truly_q16;
            let gates = rays.gates_of(ray);
            let ahead = DVec3::from_array(way.map(f64::from)) / 65_536.0;
            let far_q16 = match search.first(&begin, way, &gates) {
                Some(hit) => f64::from(hit.t_q16),
                None => exit_q16(origin, ahead, grid.size).min(f64::from(gates.range_max_q16)),
            };
            let at = origin + ahead * far_q16;
            corner + DVec3::new(metres(at.x), metres(at.y), metres(at.z))
        };
        let ends_m = numbers.into_iter().map(end).collect();
        let from_m = corner + DVec3::new(metres(origin.x), metres(origin.y), metres(origin.z));
        Frustum { from_m, ends_m, rows, columns }
    }
}

/// How far a ray goes inside of the grid.
fn exit_q16(origin: DVec3, ahead: DVec3, size: [u32; 3]) -> f64 {
    let far = |axis: usize| {
        let high = f64::from(size[axis]) * 65_536.0;
        match ahead[axis] {
            0.0 => f64::INFINITY,
            way if way > 0.0 => (high - origin[axis]) / way,
            way => -origin[axis] / way,
        }
    };
    far(0).min(far(1)).min(far(2)).max(0.0)
}
