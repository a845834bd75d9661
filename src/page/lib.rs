#![doc = include_str!("README.md")]
// Module pages are for developers, who build them with private items.
#![allow(rustdoc::private_intra_doc_links)]

pub mod export;
pub mod letters;
pub mod render;
pub mod report;
pub mod viewer;
