//! Where voxels are: lengths as integers, the grid, and windows of it.

use glam::DVec3;

/// Most voxels on an axis: crossing counts and packed indices of every backend rely on it.
pub const MAX_VOXELS_PER_AXIS: u32 = 1023;

/// One voxel in Q16, the unit of every length: 1/65536 of a voxel.
pub const ONE_Q16: i64 = 1 << 16;

/// Smallest and largest edge of a voxel in metres.
pub const VOXEL_SIZES_M: std::ops::RangeInclusive<f64> = 1e-4..=10.0;

/// Lengths are refused beyond this many voxels, so that no product of two of them overflows.
pub const FARTHEST_VOXEL: i64 = 1 << 20;

/// A length in metres as 1/65536 voxels, ties away from zero. All floors and comparisons come after this.
/// Saturates at ± [`FARTHEST_VOXEL`], which no grid reaches; NaN becomes 0 (loaders refuse it).
pub fn length_q16(metres: f64, voxel_size_m: f64) -> i64 {
    let farthest = (FARTHEST_VOXEL * ONE_Q16) as f64;
    (metres / voxel_size_m * ONE_Q16 as f64).round().clamp(-farthest, farthest) as i64
}

/// A point in metres as 1/65536 voxels on each axis.
pub fn point_q16(metres: DVec3, voxel_size_m: f64) -> [i64; 3] {
    metres.to_array().map(|value| length_q16(value, voxel_size_m))
}

/// A box of voxels: `min` and how many voxels follow on each axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Window {
    /// Lowest voxel on each axis.
    pub min: [i32; 3],
    /// Voxels on each axis; zero on any axis means empty.
    pub size: [u32; 3],
}

impl Window {
    /// The window from `min` to `max`, both included; empty where `max` is below `min`.
    pub fn from_corners(min: [i32; 3], max: [i32; 3]) -> Self {
        let size = std::array::from_fn(|r| (max[r] as i64 - min[r] as i64 + 1).max(0) as u32);
        Window { min, size }
    }

    /// Whether no voxel lies in it.
    pub fn is_empty(&self) -> bool {
        self.size.contains(&0)
    }

    /// The first voxel after the window on each axis.
    pub fn end(&self) -> [i32; 3] {
        std::array::from_fn(|r| self.min[r] + self.size[r] as i32)
    }

    /// Voxels in the window.
    pub fn volume(&self) -> u64 {
        self.size.iter().map(|&n| n as u64).product()
    }

    /// Whether a voxel lies in the window.
    pub fn contains(&self, voxel: [i32; 3]) -> bool {
        (0..3).all(|r| voxel[r] >= self.min[r] && voxel[r] < self.end()[r])
    }

    /// What two windows share.
    pub fn intersection(&self, other: &Window) -> Window {
        let min: [i32; 3] = std::array::from_fn(|r| self.min[r].max(other.min[r]));
        let size = std::array::from_fn(|r| (self.end()[r].min(other.end()[r]) - min[r]).max(0) as u32);
        Window { min, size }
    }

    /// The smallest window that holds both; an empty one adds nothing.
    pub fn union(&self, other: &Window) -> Window {
        if self.is_empty() {
            return *other;
        }
        if other.is_empty() {
            return *self;
        }
        let min: [i32; 3] = std::array::from_fn(|r| self.min[r].min(other.min[r]));
        let size = std::array::from_fn(|r| (self.end()[r].max(other.end()[r]) - min[r]) as u32);
        Window { min, size }
    }

    /// The window with so many voxels more on each side; an empty one stays empty.
    pub fn grown(&self, by: i32) -> Window {
        if self.is_empty() {
            return *self;
        }
        Window::from_corners(self.min.map(|low| low - by), self.end().map(|end| end - 1 + by))
    }

    /// The same voxels counted from another origin.
    pub fn shift(&self, by: [i32; 3]) -> Window {
        Window { min: std::array::from_fn(|r| self.min[r] + by[r]), size: self.size }
    }
}

/// The voxel grid of a cell. Its origin is a whole number of voxels from the world's, so that it lines up
/// with OctoMap keys. Voxel (i, j, k) is the half-open box [origin + i, origin + i + 1) on each axis, in
/// voxels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Edge of a voxel in metres.
    pub voxel_size_m: f64,
    /// World key of voxel (0, 0, 0): floor(x / voxel size).
    pub origin: [i32; 3],
    /// Voxels on each axis, 1 to [`MAX_VOXELS_PER_AXIS`].
    pub size: [u32; 3],
}

impl Grid {
    /// All voxels, counted from the grid's own origin.
    pub fn window(&self) -> Window {
        Window { min: [0; 3], size: self.size }
    }

    /// A world position relative to the grid's corner, in 1/65536 voxels.
    pub fn position_q16(&self, metres: DVec3) -> [i64; 3] {
        let world = point_q16(metres, self.voxel_size_m);
        std::array::from_fn(|r| world[r] - self.origin[r] as i64 * ONE_Q16)
    }

    /// The voxel that holds a position given by [`Grid::position_q16`]; it may lie outside the grid.
    pub fn voxel_of(position_q16: [i64; 3]) -> [i32; 3] {
        position_q16.map(|x| (x >> 16) as i32)
    }

    /// Lower corner of a voxel in world metres, for messages and exports only.
    pub fn corner_m(&self, voxel: [i32; 3]) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|r| (voxel[r] + self.origin[r]) as f64 * self.voxel_size_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_round_before_they_floor() {
        // 0.3 / 0.05 in f64 is 5.999…; as a length it is exactly six voxels.
        assert_eq!((0.3f64 / 0.05).floor(), 5.0);
        assert_eq!(length_q16(0.3, 0.05), 6 * ONE_Q16);
        assert_eq!(length_q16(-0.3, 0.05), -6 * ONE_Q16);
        assert_eq!(length_q16(0.5 / 65536.0, 1.0), 1, "ties go away from zero");
        assert_eq!(length_q16(-0.5 / 65536.0, 1.0), -1);
        assert_eq!(length_q16(1e300, 0.05), FARTHEST_VOXEL * ONE_Q16);
    }

    #[test]
    fn windows_meet_and_join() {
        let a = Window::from_corners([0, 0, 0], [9, 9, 9]);
        let b = Window::from_corners([5, -5, 3], [14, 4, 3]);
        assert_eq!(a.intersection(&b), Window::from_corners([5, 0, 3], [9, 4, 3]));
        assert_eq!(a.union(&b), Window::from_corners([0, -5, 0], [14, 9, 9]));
        assert!(a.intersection(&Window::from_corners([20, 0, 0], [30, 9, 9])).is_empty());
        assert_eq!(a.volume(), 1000);
        assert!(a.contains([9, 0, 0]) && !a.contains([10, 0, 0]));
    }
}
