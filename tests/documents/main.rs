//! What users read: pages, pictures, reports, files for other programs.

#[path = "../common/mod.rs"]
mod common;

#[cfg(target_os = "linux")]
mod browser;
mod export;
mod figures;
mod flags;
mod front;
mod licences;
mod measured;
#[cfg(unix)]
mod pages;
mod purchase;
mod render;
mod report;
mod report_tables;
mod versions;
#[cfg(unix)]
mod words;
