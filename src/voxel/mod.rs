//! From surfaces to voxels: the grid, bit planes over it, the voxelizer, interiors and regions.

pub mod bits;
pub mod grid;

pub use bits::BitGrid;
pub use grid::{Grid, Window};
