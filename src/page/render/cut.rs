//! Cuts a cell for a picture: to a region, below a height, and without the walls and the ceiling between the
//! cell and the eye.

use glam::DVec3;

use super::Wish;
use perirobot_march::voxel::grid::{ONE_Q16, length_q16};
use perirobot_march::voxel::{BitGrid, Grid, Window};
use perirobot_study::world::World;

/// Noise may put returns this many voxels beside a wall.
const BESIDE: i32 = 3;

/// The omitted parts.
pub(super) struct Cut {
    pub(super) only_region: Option<usize>,
    pub(super) above_m: Option<f64>,
    pub(super) open_m: f64,
}

impl Cut {
    pub(super) fn new(wish: &Wish) -> Cut {
        Cut { only_region: wish.only_region, above_m: wish.cut_above_m, open_m: wish.open_m }
    }

    /// The occupied voxels that are drawn.
    pub(super) fn solid(&self, world: &World, eye_m: DVec3) -> BitGrid {
        let truth = &world.truth();
        let mut solid = self.plane(world, BitGrid::clone(&truth.occupied));
        for side in self.open_sides(world, eye_m) {
            let mut walls = BitGrid::full(side);
            walls.remove(&truth.human);
            walls.remove(&truth.robot);
            solid.remove(&walls);
        }
        solid
    }

    /// Whether a return may be drawn: not near a removed side.
    pub(super) fn dots(&self, world: &World, eye_m: DVec3) -> BitGrid {
        let mut dots = self.plane(world, BitGrid::full(world.grid.window()));
        let sides = self.open_sides(world, eye_m).into_iter();
        sides.for_each(|side| dots.remove(&BitGrid::full(side.grown(BESIDE))));
        dots
    }

    /// The sides of the cell between it and the eye, with their removed thickness.
    fn open_sides(&self, world: &World, eye_m: DVec3) -> Vec<Window> {
        let truth = &world.truth();
        let thick = (self.open_m / truth.grid.voxel_size_m).ceil().clamp(0.0, 1023.0) as i32;
        let eye = Grid::voxel_of(truth.grid.position_q16(eye_m));
        let bounds = truth.occupied.bounds();
        let (low, end) = (bounds.min, bounds.end());
        let mut sides = Vec::new();
        for axis in (0..3).filter(|_| thick > 0) {
            let mut side = bounds;
            if eye[axis] >= end[axis] {
                side.min[axis] = low[axis].max(end[axis] - thick);
            } else if eye[axis] >= low[axis] {
                continue;
            }
            side.size[axis] = bounds.size[axis].min(thick as u32);
            sides.push(side);
        }
        sides
    }

    /// The rest of a plane, independent of the viewing direction.
    pub(super) fn plane(&self, world: &World, mut plane: BitGrid) -> BitGrid {
        let grid = &world.grid;
        if let Some(region) = self.only_region {
            plane.keep(&world.regions[region].voxels);
        }
        if let Some(above_m) = self.above_m {
            let above_q16 = length_q16(above_m, grid.voxel_size_m) - i64::from(grid.origin[2]) * ONE_Q16;
            // The first layer with centres above.
            let first = (above_q16 + ONE_Q16 / 2).div_euclid(ONE_Q16).clamp(0, grid.size[2].into()) as i32;
            let [x, y, z] = grid.size;
            plane.remove(&BitGrid::full(Window { min: [0, 0, first], size: [x, y, z - first as u32] }));
        }
        plane
    }
}
