//! The results of a sweep: the folder's files, the journal of counts, the manifest, the numbering of rows, merged
//! shards, and all of it read back, with scores over scenes, snapshots and repeats and the tables for pandas.

pub mod checksum;
pub mod columns;
#[cfg(any(test, feature = "example"))]
pub mod example;
pub mod files;
pub mod journal;
pub mod layout;
pub mod manifest;
pub mod merge;
pub mod over;
mod read;
pub mod rows;
pub mod scores;
pub mod swept;
pub mod table;

pub use layout::{CombinationSize, PoseChoice, RowKey, RowLayout, jobs, layout_of, places_of};
pub use over::Over;
pub use read::Folder;
pub use swept::{Results, Subject};
