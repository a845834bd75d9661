//! How close a body gets to the robot before any sensor detects it: the deepest undetected approach.
//!
//! # Theory
//! A body is a set of voxels that moves without turning. At a place it is *noticed* if at least `min_voxels` of
//! its voxels are watched ([`perirobot_study::sensor::watch`]), and it may not be where one of them is solid: occupied, or
//! inside a body. Everything that steps to the 26 neighbours reach unnoticed from the places of an entry is flooded; with
//! `floor = "auto"` a body on the floor steps from surface to surface instead (`surfaces.rs`). The answer is the place with the smallest distance between voxel centres of the body and of the hazard; of equally deep
//! places the one with the shortest path, then the first along z, y and x. If the body has room at places of an entry
//! and is noticed there, the closest of them is how close it gets before any sensor detects it: this distance is
//! reported beside the deepest, and the lesser of both is compared with the needed one.
//!
//! Each snapshot is answered by itself, and all of them at once, cautiously: a voxel that is not watched in one snapshot
//! is not watched, one that is not solid in one snapshot can be entered, and the robot is everywhere it is in one. Each
//! is answered without other people, and, if the scene has people, with them as cover: they are solid, and hide the space
//! behind them.
//!
//! *The narrowest place* is where the path can be closed. The places whose shortest paths are between k and
//! k + 1 longest steps long form a front that every way to a place farther on must cross; the narrowest front
//! between the entry and the deepest place has the fewest places, and the path crosses it at the narrowest
//! place.
//!
//! # Practice
//! Watched voxels of a body are counted by running sums, paths by integers, distances by squares, all on the host, so the
//! answer does not depend on a device.

mod approach_json;
mod asking;
mod body;
mod check;
mod deepest;
mod entries;
mod flood;
mod ground;
mod latches;
mod moments;
mod needed;
mod picture;
mod resolution;
mod surfaces;
mod table;
mod traps;
mod unnoticed_path;
mod ways;

pub use approach_json::{APPROACH, APPROACH_JSON, ApproachRow, Approaches};
pub use asking::{Approached, Approaching, ChoiceIn};
pub use body::Body;
pub use check::check_approach;
pub use deepest::{ApproachFinding, Deepest, FreeRoom, Narrowest, deepest};
pub use flood::Flood;
pub use ground::{Company, Ground};
pub(crate) use latches::{passed_latches, unproven_latches};
pub(crate) use moments::shadow;
pub use moments::{ApproachAnswer, ApproachMoment, AtEntry, BodyPlan, NearestApproach, answers, moments_of};
pub use picture::{PATHS, floor_plan, is_named_as_plan, paths_ply, plan_names};
pub use resolution::check_resolution;
pub(crate) use surfaces::spot_height_m;
pub use surfaces::walked_surfaces;
pub use table::{describe, fusion_warning};
pub(crate) use unnoticed_path::WatchCounts;
pub use ways::{Way, nearest_ways};
