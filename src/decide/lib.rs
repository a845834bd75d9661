#![doc = include_str!("README.md")]
// Module pages are for developers, who build them with private items.
#![allow(rustdoc::private_intra_doc_links)]

pub mod approach;
pub mod cheapest;
pub mod choose;
pub mod controller;
mod json_file;
pub mod judge;
pub mod look;
mod purchased_sets;
pub mod view;

#[cfg(test)]
#[path = "../thorough.rs"]
mod thorough;
