//! What is where in a scene, in voxels: the voxelizer, interiors, people, regions.

mod objects;
mod people;
pub mod region;
mod truths;
pub mod voxelize;

pub use objects::{ObjectVoxels, RadarTruth, RobotReach, Truth};
pub use people::people;
pub use region::{Region, RegionShape, SafetyPlane};
pub use truths::{Snapshots, voxelize_all};
