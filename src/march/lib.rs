//! The voxel ray-marcher of perirobot: rays through a grid of voxels, and what they say of each voxel, on the
//! CPU and on any GPU. All results are integers and follow the rules in `SEMANTICS.md`. Nothing here opens a
//! file or knows a scene; the crate `perirobot` does, and has the map of all rooms on its first page.
//!
//! It is a crate of its own since this is where the time goes: compiled as one unit, all that is short in it is
//! inlined, and the rest of the program needs no optimising across units, which took the compiler long.

// The rooms' pages are read by developers, who build them with private items.
#![allow(rustdoc::private_intra_doc_links)]

pub mod backend;
pub mod error;
pub mod march;
pub mod metrics;
pub mod voxel;

#[doc = include_str!("SEMANTICS.md")]
pub mod rules {}

pub use error::{Error, Result};
