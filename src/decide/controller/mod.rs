//! What a controller would measure between people and the robot, and what it would do. Requirements on that are in
//! [`judge`](crate::judge).
//!
//! # Theory
//! A controller that reads labels measures the distance from the robot to the nearest voxel that may be a person, and
//! stops the robot if that is less than people must be away. `separation` selects the voxels that may be one. A distance is a
//! root of whole voxels; the error of a measured distance is a difference of two roots, which `excess` compares
//! exactly.
//!
//! # Practice
//! `measure` looks at sets of sensors at every moment of a study, `separation_csv` writes what was measured. `judge` uses
//! this module: it chooses the sets, as planned or altered, and compares with limits.

mod excess;
mod measure;
mod separation;
mod separation_csv;

pub use excess::Excess;
pub(crate) use measure::measure;
pub use separation::{Decision, MeasuredSurroundings, Separation};
pub(crate) use separation_csv::{MeasuredMoment, separation_csv};
