//! The best set of sensors, and a bound on every other.
//!
//! Every candidate is cast once, and a set is scored without a ray: `perirobot-cover` has the theory and the search.
//!
//! # Practice
//! `planes` are a sensor's evidence voxel by voxel, and `layout` maps them to bits of a region. `evidence` has those of
//! each candidate (`evidence/casting` casts them, `evidence/file` stores them for `evidence/deciding`, `check` counts some
//! again), `problem` is the question, with the `pairs` that no set may have. `report` has the answer
//! in names and numbers, with `ties`, `files` writes and reads it, `sets` makes combinations of it, and `outcome` scores
//! them in the folder as a sweep; `refine` looks between the listed poses, and `verify` checks the files.
//! `choosing` runs these stages for the command line and Python.

mod check;
mod choosing;
mod evidence;
mod files;
mod layout;
mod outcome;
mod pairs;
mod planes;
mod problem;
mod refine;
mod report;
mod sets;
mod ties;
mod verify;

pub use check::count_again;
pub use choosing::{Choosing, Found, SearchEnding};
pub use evidence::{CastEvidence, Casting, EVIDENCE, MEMORY_BYTES, cast_evidence};
pub(crate) use files::fingerprint;
pub use files::{
    AskedScore, AskedSensor, ChooseQuestion, Chosen, FRONT, PROOF, REFINED, SETS, describe_asked_prices,
};
pub(crate) use outcome::sweep_sets;
pub use outcome::{Outcome, as_swept};
pub(crate) use pairs::PairTerms;
pub use pairs::disturbing_pairs;
#[cfg(test)]
pub(crate) use pairs::plain_camera::PlainCamera;
pub use problem::{answer, problem_of, progress_of, wanted_counts};
pub(crate) use problem::{candidates_of, odds_of, rules_of};
pub use refine::{Refinement, refine};
pub use report::{
    DisturbedReport, FinePose, FrontReport, RefinedReport, SensorReport, SetReport, StepReport,
};
pub(crate) use verify::{
    AllowedSets, DisturbedPairs, SweptSets, is_written, pose_name, sweep_again, thousandths,
};
pub use verify::{Claims, Verified};
