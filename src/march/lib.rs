#![doc = include_str!("README.md")]
// The pages of rooms are read by developers, who build them with private items.
#![allow(rustdoc::private_intra_doc_links)]

pub mod backend;
pub mod error;
pub mod lengths;
pub mod march;
pub mod metrics;
pub mod progress;
pub mod voxel;

#[doc = include_str!("SEMANTICS.md")]
pub mod rules {}

pub use error::{Error, Result};

/// The version of the rules that decide the counts (`SEMANTICS.md`), recorded in every manifest. It changes whenever the
/// same study could give other integers.
pub const SEMANTICS_VERSION: u32 = 5;
