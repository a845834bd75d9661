#![doc = include_str!("README.md")]
// The pages of rooms are read by developers, who build them with private items.
#![allow(rustdoc::private_intra_doc_links)]

pub mod export;
pub mod letters;
pub mod render;
pub mod report;
pub mod viewer;
