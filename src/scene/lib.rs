#![doc = include_str!("README.md")]
// The pages of rooms are read by developers, who build them with private items.
#![allow(rustdoc::private_intra_doc_links)]

pub mod objects;
pub mod pose;
pub mod psenscan;
pub mod recording;
pub mod ros;
pub mod shell;
pub mod source;
pub mod spelling;
#[cfg(test)]
#[path = "../thorough.rs"]
mod thorough;
pub mod truth;
