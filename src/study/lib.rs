#![doc = include_str!("README.md")]
// The pages of rooms are read by developers, who build them with private items.
#![allow(rustdoc::private_intra_doc_links)]

mod diagnostics;
pub mod input;
mod keys;
pub mod sensor;
pub mod world;
