#![doc = include_str!("README.md")]
// The pages of rooms are read by developers, who build them with private items.
#![allow(rustdoc::private_intra_doc_links)]

mod answers;
pub mod document;
pub mod find;
pub mod gallery;
pub mod live;
mod own_scores;
pub mod page;
pub mod problem;
pub mod report;
pub mod server;
pub mod session;
pub mod state;
pub mod study_file;
