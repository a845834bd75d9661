//! An upright volume over a polygon, in a sensor's own frame: a pad's column, a scanner's field, the zone and
//! the box of a light curtain.

use std::ops::Range;

use glam::{DVec2, DVec3};

use perirobot_march::error::Issue;
use perirobot_march::voxel::grid::{ONE_Q16, length_q16};
use perirobot_march::voxel::solid::{column, first_centre};
use perirobot_march::voxel::{BitGrid, Grid, Window};
use perirobot_scene::pose::Pose;

/// A polygon and a span of heights, in metres from the sensor. The sensor's position and heading carry it; it
/// stays upright however the sensor tilts. Under a sensor that hangs upside down, left and right of the
/// heading change places, as they do for the sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct Prism {
    /// Corners in order; the polygon's sides do not meet.
    pub polygon_m: Vec<DVec2>,
    /// Lowest and highest z.
    pub z_m: [f64; 2],
}

impl Prism {
    /// The box between two corners.
    pub fn from_corners(min_m: DVec3, max_m: DVec3) -> Self {
        let corner = |x: f64, y: f64| DVec2::new(x, y);
        let polygon_m = vec![
            corner(min_m.x, min_m.y),
            corner(max_m.x, min_m.y),
            corner(max_m.x, max_m.y),
            corner(min_m.x, max_m.y),
        ];
        Prism { polygon_m, z_m: [min_m.z, max_m.z] }
    }

    /// Corners in world metres, at the sensor's own height.
    fn corners_m(&self, pose: &Pose) -> impl Iterator<Item = DVec3> {
        let (forward, up) = (pose.link().x_axis, pose.link().z_axis);
        let flat = DVec2::new(forward.x, forward.y);
        // A sensor that looks straight up or down has no heading: its volume keeps the world's.
        let x = if flat.length() < 1e-9 { DVec2::X } else { flat.normalize() };
        let y = if up.z < -1e-9 { -x.perp() } else { x.perp() };
        let origin_m = pose.position_m;
        self.polygon_m.iter().map(move |corner| origin_m + (x * corner.x + y * corner.y).extend(0.0))
    }

    /// Corners in the grid, in 1/65536 voxels.
    pub fn corners_q16(&self, pose: &Pose, grid: &Grid) -> Vec<[i64; 2]> {
        let place = |corner: DVec3| {
            let [x, y, _] = grid.position_q16(corner);
            [x, y]
        };
        self.corners_m(pose).map(place).collect()
    }

    /// Where it stands: corners in world metres, at its lowest height.
    pub fn footprint_m(&self, pose: &Pose) -> Vec<DVec3> {
        self.corners_m(pose).map(|corner| corner + DVec3::Z * self.z_m[0]).collect()
    }

    /// The voxels of a window whose centre lies inside, half-open; over the part of it that holds them.
    pub fn voxels(&self, pose: &Pose, grid: &Grid, window: Window) -> BitGrid {
        self.layers(pose, grid, window, self.layers_of(pose, grid))
    }

    fn layers_of(&self, pose: &Pose, grid: &Grid) -> Range<i64> {
        let z_q16 = grid.position_q16(pose.position_m)[2];
        let level = |z_m: f64| first_centre(z_q16 + length_q16(z_m, grid.voxel_size_m));
        level(self.z_m[0])..level(self.z_m[1])
    }

    /// The layers from `first` to the prism's top.
    pub(crate) fn layers_above(&self, pose: &Pose, grid: &Grid, first: i64) -> Range<i64> {
        let top_q16 = grid.position_q16(pose.position_m)[2] + length_q16(self.z_m[1], grid.voxel_size_m);
        first..first_centre(top_q16)
    }

    /// The voxels of a window above the polygon, in these layers of the grid; over the part of it that holds
    /// them.
    pub(crate) fn layers(&self, pose: &Pose, grid: &Grid, window: Window, layers: Range<i64>) -> BitGrid {
        let within = |z: i64| z.clamp(-1, i64::from(i16::MAX)) as i32;
        let (corners, layers) = (self.corners_q16(pose, grid), within(layers.start)..within(layers.end));
        let around = corners.iter().map(|&[x, y]| {
            let [x, y, _] = Grid::voxel_of([x, y, 0]);
            Window::from_corners([x, y, layers.start], [x, y, layers.end - 1])
        });
        let around = around.reduce(|all, one| all.union(&one)).map(|around| around.intersection(&window));
        let mut voxels = around.map_or_else(BitGrid::nowhere, BitGrid::new);
        column(&mut voxels, &corners, layers);
        voxels
    }

    /// Whether some voxel of the grid is inside.
    pub(crate) fn check(&self, pose: &Pose, grid: &Grid) -> Result<(), Issue> {
        // All layers have the same voxels.
        let mut layers = self.layers_of(pose, grid);
        layers = layers.start.max(0)..layers.end.min(grid.size[2].into());
        layers.end = layers.end.min(layers.start + 1);
        if self.layers(pose, grid, grid.window(), layers).is_empty() {
            return Err(
                Issue::says("its volume holds no voxel of the grid").with_advice("make it larger or move it")
            );
        }
        Ok(())
    }

    /// Whether the polygon lies over the grid as a whole.
    pub(crate) fn is_over(&self, pose: &Pose, grid: &Grid) -> bool {
        let inside =
            |corner: &[i64; 2]| (0..2).all(|a| (0..=i64::from(grid.size[a]) * ONE_Q16).contains(&corner[a]));
        self.corners_q16(pose, grid).iter().all(inside)
    }
}
