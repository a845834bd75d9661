#![doc = include_str!("README.md")]
// Module pages are for developers, who build them with private items.
#![allow(rustdoc::private_intra_doc_links)]

pub mod results;
pub mod scoring;
