//! How near a body can come to the robot without being noticed: the deepest undetected approach.
//!
//! # Theory
//! A body is a set of voxels that moves without turning. At a place it is *noticed* if at least `min_voxels` of
//! its voxels are watched ([`perirobot_study::sensor::watch`]), and it may not be where one of them is solid: occupied, or
//! inside of something. From the places at which it comes in, all that steps to the 26 neighbours reach
//! unnoticed is flooded. The answer is the place from which the nearest voxel of the body to the hazard is the
//! least away, between the centres of voxels; of equally deep places that with the shortest path, then the first
//! along z, y and x. At those places of an entry at which the body has room and is noticed it has come as near as
//! they are before anything tells: the least distance of them is said beside the deepest, and the lesser of both is
//! held against what is needed.
//!
//! Each snapshot is asked by itself, and all of them at once, cautiously: what is not watched in some snapshot
//! is not watched, what is not solid in some snapshot can be entered, and the robot is wherever it is in one.
//! Each is asked with nobody else in the scene, and, where the scene has people, with them as cover: they are
//! solid, and hide what is behind them.
//!
//! *The narrowest place* tells where the way can be closed. The places whose shortest paths are between k and
//! k + 1 longest steps long form a front that every way to a place farther on must cross; the narrowest front
//! between the entry and the deepest place has the fewest places, and the path crosses it at the narrowest
//! place.
//!
//! # Practice
//! Watched voxels are counted in a body by running sums, paths by whole numbers, distances by squares, all on
//! the host: no device has a part in it, so all give the same answer.

mod approach_json;
mod body;
mod check;
mod deepest;
mod entries;
mod flood;
mod ground;
mod moments;
mod needed;
mod picture;
mod table;
mod unnoticed_path;
mod ways;

pub use approach_json::{APPROACH, APPROACH_JSON, ApproachRow, Approaches};
pub use body::Body;
pub use check::check_approach;
pub use deepest::{ApproachFinding, Deepest, FreeRoom, Narrowest, deepest};
pub use flood::{Flood, LONGEST_STEP};
pub use ground::{Company, Ground};
pub(crate) use moments::shadow;
pub use moments::{ApproachAnswer, ApproachMoment, AtEntry, BodyPlan, NearestApproach, answers, moments_of};
pub use picture::{PATHS, floor_plan, is_named_as_plan, paths_ply, plan_names};
pub use table::{describe, fusion_warning};
pub(crate) use unnoticed_path::WatchCounts;
pub use ways::{Way, nearest_ways};
