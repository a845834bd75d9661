//! Scores where to put the sensors of a robot cell.
//!
//! perirobot voxelizes a cell, casts every ray of every candidate sensor pose through it, writes what the
//! sensor would claim (occupied, free, unknown), compares that with the truth inside regions of interest, and
//! scores the pose with F1 and Cohen's κ. It implements the perirobot space representation of Rozlivek, Svarny
//! and Hoffmann (IROS 2023).
//!
//! The rooms, in the order of the paper:
//! [`study`] (what the user wrote) → [`scene`] (surfaces with roles) → [`voxel`] (truth and regions) →
//! [`sensor`] (rays, in integers) → [`backend`] (march, carve, count: the same integers on every device) →
//! [`metrics`] (F1, κ) → [`sweep`] (counts of all poses) → [`table`] (long tables for programs) → [`report`] (tables for
//! people). [`view`] looks at single poses, for [`export`] and [`render`]. The arithmetic that every backend shares is [`march`]; every file comes in through [`source`].

pub mod backend;
pub mod cluster;
pub mod error;
pub mod export;
pub mod march;
pub mod metrics;
pub mod render;
pub mod report;
pub mod scene;
pub mod sensor;
pub mod shell;
pub mod source;
pub mod study;
pub mod sweep;
pub mod table;
pub mod view;
pub mod voxel;

mod spelling;

pub use error::{Error, Result};

/// The version of the rules that decide the counts (`src/march/SEMANTICS.md`), recorded in every manifest.
/// It changes whenever the same study could give other integers.
pub const SEMANTICS_VERSION: u32 = 3;
