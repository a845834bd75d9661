//! Whether cameras disturb each other, from their angles, for tests.

use glam::DVec3;

use perirobot_march::voxel::Grid;
use perirobot_scene::pose::Pose;
use perirobot_study::input::Disturb;

/// A camera at a pose.
pub(crate) struct PlainCamera {
    pub(crate) pose: Pose,
    /// Full angles of view.
    pub(crate) fov_deg: [f64; 2],
    /// Its range, as a depth or along each ray.
    pub(crate) far_m: f64,
    pub(crate) is_depth: bool,
    /// The lowest and the highest corner of the grid.
    pub(crate) walls_m: [[f64; 3]; 2],
}

impl PlainCamera {
    /// The corners of a grid.
    pub(crate) fn walls_m(grid: &Grid) -> [[f64; 3]; 2] {
        let corner =
            |voxel: [u32; 3], r: usize| f64::from(grid.origin[r] + voxel[r] as i32) * grid.voxel_size_m;
        [[0; 3], grid.size].map(|voxel| [0, 1, 2].map(|r| corner(voxel, r)))
    }

    /// Whether one of two cameras disturbs the other.
    pub(crate) fn disturbs(&self, other: &PlainCamera, disturb: &Disturb) -> bool {
        let most_deg = disturb.apart_deg.unwrap_or(180.0);
        let sees = |one: &PlainCamera, point: DVec3| one.is_in_view(point) && one.angle_deg(point) < most_deg;
        let look = sees(self, other.pose.position_m) && sees(other, self.pose.position_m);
        let share = self.share_in(other).max(other.share_in(self));
        look || disturb.overlap.is_some_and(|most| share > most)
    }

    /// A point as right, down and forward coordinates.
    fn in_camera(&self, point: DVec3) -> [f64; 3] {
        let axes = self.pose.optical();
        [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| axis.dot(point - self.pose.position_m))
    }

    fn is_in_view(&self, point: DVec3) -> bool {
        let [x, y, z] = self.in_camera(point);
        let half = self.fov_deg.map(|full| (full / 2.0).to_radians().tan());
        z > 0.0 && x.abs() < half[0] * z && y.abs() < half[1] * z
    }

    fn angle_deg(&self, point: DVec3) -> f64 {
        let [_, _, z] = self.in_camera(point);
        (z / point.distance(self.pose.position_m)).acos().to_degrees()
    }

    /// The share of its viewed places that are in another's view: for 9 columns and 5 rows of rays, cut at the range or
    /// at the walls of the grid, the middles of five equal parts.
    fn share_in(&self, other: &PlainCamera) -> f64 {
        let (axes, half) = (self.pose.optical(), self.fov_deg.map(|full| (full / 2.0).to_radians().tan()));
        let (mut seen, mut all) = (0, 0);
        for (column, row) in (0..5).flat_map(|row| (0..9).map(move |column| (column, row))) {
            let x = half[0] * (f64::from(2 * column + 1) / 9.0 - 1.0);
            let y = half[1] * (f64::from(2 * row + 1) / 5.0 - 1.0);
            // A ray with depth 1.
            let ray = axes * DVec3::new(x, y, 1.0);
            let wall = |axis: usize| match ray[axis] {
                0.0 => f64::MAX,
                step => (self.walls_m[usize::from(step > 0.0)][axis] - self.pose.position_m[axis]) / step,
            };
            let far = if self.is_depth { self.far_m } else { self.far_m / ray.length() };
            let end = (0..3).map(wall).fold(far, f64::min);
            for part in 0..5 {
                let place = self.pose.position_m + ray * (end * (f64::from(part) + 0.5) / 5.0);
                let [_, _, depth] = other.in_camera(place);
                let distance = if other.is_depth { depth } else { place.distance(other.pose.position_m) };
                seen += i32::from(other.is_in_view(place) && distance <= other.far_m);
                all += 1;
            }
        }
        f64::from(seen) / f64::from(all)
    }
}
