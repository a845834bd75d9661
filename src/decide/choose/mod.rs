//! Which set of sensors is the best, and how much better any other could be.
//!
//! # Theory
//! Under "occupied wins" all counts of a set are counts of bits of unions. So every candidate is cast once,
//! and a set is scored without a ray. F1 = 2TP/(s + TP − TN), s being the voxels of the region; F1 > p/q
//! holds just if (2q − p)TP + p·TN > p·s. So whether any set beats the best one that is known is a question
//! of weighted coverage in whole numbers, and a search by branch and bound answers it.
//!
//! # Practice
//! `layout` says which bit is which voxel, `evidence` has what each candidate says (`evidence/casting` casts it,
//! `evidence/file` keeps it on disk, `check` counts some of it again), `worth` what counts are worth, `problem`
//! which sets are allowed. `front` goes through sizes and steps of cost, and `within` searches one of them:
//! `climb` finds a good set, `question` asks whether any is better, and `search` answers, with `open` (candidates
//! that may join a set), `pairs` (overlaps of two) and `purse` (what fits the budget). `mean`
//! is for means of scores, `odds` for log-odds fusion. Where that is long, `gap`
//! bounds all sets by cuts, which `game` weighs. `told` has the answer in names and numbers, with `ties`, `files`
//! writes and reads it, `sets` makes combinations of it, and `outcome` scores them in the folder as a sweep; `refine`
//! looks between the listed poses, and `verify` checks what was written.

mod check;
mod climb;
mod evidence;
mod files;
mod front;
mod game;
mod gap;
mod layout;
mod mean;
mod odds;
mod open;
mod outcome;
mod pairs;
mod problem;
mod purse;
mod question;
mod refine;
mod search;
mod sets;
mod ties;
mod told;
mod verify;
mod within;
mod worth;

pub use evidence::{CandidateEvidence, Casting, CastingWatch, EVIDENCE, MEMORY_BYTES};
pub use files::{Asked, AskedScore, AskedSensor, Chosen, FRONT, PROOF, REFINED, SETS};
pub use front::{Answer, answer};
pub use gap::Gap;
pub use outcome::{Outcome, as_swept};
pub use problem::{Found, Problem, SetLimits, examine};
pub use refine::{RefineWatch, Refinement, refine};
pub use told::{FinePose, Told, ToldCut, ToldCuts, ToldRefined, ToldSensor, ToldSet, ToldStep};
pub use verify::{Claims, Verified, VerifyWatch, verify};
pub use within::{Bound, FrontStep, SearchWatch};
pub use worth::{Ratio, Worth};

#[cfg(test)]
mod tests;
