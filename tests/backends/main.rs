//! Oracle, CPU and GPU give the same integers: random cells, every sensor, every study that ships.

#[path = "../common/mod.rs"]
mod common;

mod batches;
mod cameras;
mod loops;
mod moving;
mod near;
mod places;
mod random_cells;
mod real_scans;
mod recorded;
mod reference;
mod scenes;
mod seen;
mod sensors;
mod shaders;
mod shipped;
mod stopping;
mod twice;
mod twins;
