//! `plan`: what the planner counts, edits and saves, asked by HTTP as its page asks.

#[path = "../common/mod.rs"]
mod common;

mod bad;
#[cfg(target_os = "linux")]
mod browser;
mod found;
mod gallery;
mod links;
mod objects;
mod papers;
mod planner;
mod saved;
mod shapes;
#[cfg(target_os = "linux")]
mod speed;
