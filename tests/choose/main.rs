//! `choose`: the best sets of sensors and their proofs.

#[path = "../common/mod.rs"]
mod common;

mod best;
mod cheapest;
mod cheapest_proof;
mod command;
mod evidence;
mod exp1;
mod faults;
mod mip;
mod refine;
