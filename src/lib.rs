//! Scores where to put the sensors of a robot cell.
//!
//! perirobot voxelizes a cell, casts every ray of every candidate sensor pose through it, writes what the
//! sensor would claim (occupied, free, unknown), compares that with the truth inside regions of interest, and
//! scores the pose with F1 and Cohen's κ. It implements the perirobot space representation of Rozlivek,
//! Svarny and Hoffmann (IROS 2023).
//!
//! # Rooms
//!
//! No room uses one that stands below it in this table; `tests/rooms.rs` holds the code to that.
//!
//! | room | what it has |
//! |---|---|
//! | [`error`], `spelling`, [`shell`] | what is wrong, what may be meant, words for a shell |
//! | [`source`] | the one door by which files come in |
//! | [`march`] | the arithmetic that every backend shares, and the rules of every count |
//! | [`metrics`] | from counts to scores: F1, κ, who is detected |
//! | [`pose`] | where something is and how it is turned |
//! | [`scene`] | surfaces with roles: formats, robots, people, motion |
//! | [`voxel`] | grid, bit planes, voxelizer, regions: the truth |
//! | [`backend`] | march, carve, fuse, count: the same integers from oracle, CPU and GPU |
//! | [`sensor`] | rays and volumes, a file a sensor |
//! | [`study`] | what the user wrote, checked once |
//! | [`world`] | a study's scene at one moment, ready to be asked |
//! | [`results`] | what a sweep leaves: journal, manifest, tables, and all of it read back |
//! | [`sweep`] | what is run, in which order, on whom; the comparison of backends |
//! | [`choose`] | the best set of sensors, with proof |
//! | [`view`], [`render`], [`export`] | a chosen set, voxel by voxel: why, as a picture, as files |
//! | [`report`] | results presented to people: text and page |
//! | [`cluster`] | a sweep for Slurm, HyperQueue and Kubernetes |
//!
//! The command line (`cli`) is the program's, above them all. The [`guide`] has no code: it is pages to read,
//! from a first hour to which files to touch for a new sensor.

pub mod backend;
pub mod choose;
pub mod cluster;
pub mod error;
pub mod export;
pub mod guide;
pub mod march;
pub mod metrics;
pub mod pose;
pub mod render;
pub mod report;
pub mod results;
pub mod scene;
pub mod sensor;
pub mod shell;
pub mod source;
pub mod study;
pub mod sweep;
pub mod view;
pub mod voxel;
pub mod world;

mod spelling;

pub use error::{Error, Result};

/// The version of the rules that decide the counts (`src/march/SEMANTICS.md`), recorded in every manifest.
/// It changes whenever the same study could give other integers.
pub const SEMANTICS_VERSION: u32 = 3;
