//! Requirements, and how near a body comes: `judge`, `approach`, `why`.

#[path = "../common/mod.rs"]
mod common;

mod approach;
mod approach_random;
mod delivery;
mod floors;
mod hall;
mod json;
mod latch;
mod near;
mod postures;
mod radar;
mod same_best;
mod speed;
mod verdicts;
mod what_if;
mod why;
