//! The voxel ray-marcher of perirobot: rays through a grid of voxels, and what they say of each voxel, on the
//! CPU and on any GPU. All counts are integers and follow the [`rules`]. It opens no file, and gets scenes as
//! voxels. Other programs use the crate `perirobot`, which has the map of all rooms on its first page: what is
//! here may change with every version.
//!
//! It is a crate of its own since this is where the time goes. The profiles of the workspace compile it as one
//! unit, in which all that is short is inlined; the rest of the program needs no optimising across units then,
//! which took the compiler long.

// The rooms' pages are read by developers, who build them with private items.
#![allow(rustdoc::private_intra_doc_links)]

pub mod backend;
pub mod error;
pub mod march;
pub mod metrics;
pub mod progress;
pub mod voxel;

#[doc = include_str!("SEMANTICS.md")]
pub mod rules {}

pub use error::{Error, Result};

/// The version of the rules that decide the counts (`SEMANTICS.md`), recorded in every manifest. It changes whenever the
/// same study could give other integers.
pub const SEMANTICS_VERSION: u32 = 4;
