//! From surfaces to voxels: the grid, bit planes over it, the voxelizer, interiors, solids and regions.

pub mod bits;
pub mod bricks;
pub mod distance;
pub mod flood;
pub mod grid;
pub mod overlap;
pub mod people;
pub mod region;
mod snapshots;
pub mod solid;
mod truth;
pub mod voxelize;

pub use bits::BitGrid;
pub use bricks::Bricks;
pub use distance::{Distances, rounded_down, rounded_up, squared_voxels};
pub use grid::{Grid, Window};
pub use people::{BodyVoxel, People};
pub use region::{Region, RegionShape};
pub(crate) use snapshots::GoOn;
pub use snapshots::{Snapshots, voxelize_all};
pub use truth::{ObjectVoxels, RobotReach, Truth};
