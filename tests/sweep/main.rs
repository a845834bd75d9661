//! Sweeps: their tables, and what happens when they are stopped, split, or run on devices that fail.

#[path = "../common/mod.rs"]
mod common;

mod answer;
mod bench;
mod cli;
#[cfg(target_os = "linux")]
mod cluster;
mod devices;
#[cfg(target_os = "linux")]
mod engines;
mod equal_sensors;
mod faults;
mod logs;
#[cfg(target_os = "linux")]
mod lost_device;
mod pandas;
mod placements;
#[cfg(unix)]
mod reflectance;
mod resume;
#[cfg(unix)]
mod shards;
mod summary;
