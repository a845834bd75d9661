//! Voxels: the grid, bit planes over it, and what can be asked of them.

mod bits;
mod bricks;
pub mod distance;
pub mod flood;
pub mod grid;
mod ones;
pub mod overlap;
mod people;
pub mod solid;

pub use bits::BitGrid;
pub(crate) use bricks::Bricks;
pub use distance::{Distances, gap_error_m, rounded_down, rounded_up, squared_voxels};
pub use grid::{Grid, Window};
pub use ones::{Joined, Ones};
pub use people::{BodyVoxel, People};
