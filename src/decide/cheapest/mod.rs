//! The cheapest set of sensors that passes all requirements of a study, with a proof.
//!
//! # Theory
//! Each requirement becomes what `perirobot_cover::cheapest` searches with. A score of counts is a *share*: under
//! `one_sensor_dead` it must hold without any one member. How close bodies get becomes *demands*: a path on which a body
//! comes too close and that no member notices fails every set whose members all miss it, so that a passing set has one of
//! the other candidates, and one more for each sensor that may be dead. A demand is larger than necessary in one
//! case: candidates that notice the path only together count as missing it. Requirements without a bound (shifted mounts,
//! other people, what a controller measures) are judged for the sets that pass everything else.
//!
//! # Practice
//! `purchasing` runs the stages for the command line and Python. `terms` has the requirements for the search,
//! also at a lower speed of the robot or without some of them, and `number` searches for sets that meet N of them;
//! `passing` tests a set, with `ways` for approaches, `areas` for floor that must be watched, and `remaining` for
//! judgements. `reporter` reports progress. `reasons` explains why no set passes. `question` is the question, and
//! `report` the answer, in names and numbers that are written and read as files; `outcome` scores its sets in the folder
//! as a sweep. `verify` checks the files.

mod areas;
mod number;
mod outcome;
mod passing;
mod purchase_search;
mod purchasing;
mod question;
mod reasons;
mod remaining;
mod report;
mod reporter;
mod terms;
mod verify;
mod ways;

pub use outcome::PurchaseOutcome;
pub use purchasing::{MOST_TIES, Purchasing};
pub use question::{AskedRequirement, AskedThen, PurchaseQuestion};
pub use report::{
    AimReport, CHEAPEST, ProvenWay, PurchasePoint, PurchaseReport, PurchasedSensor, PurchasedSet,
    ReasonReport,
};
pub use reporter::purchase_progress_of;
pub use verify::{PurchaseClaims, PurchaseVerified};
pub use ways::SceneWays;

#[cfg(test)]
mod tests;
