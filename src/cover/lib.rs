#![doc = include_str!("README.md")]
//!
//! # Theory
//! Under "occupied wins" all counts of a set are counts of bits of unions. F1 = 2TP/(s + TP − TN), s being the voxels of
//! the region; F1 > p/q holds just if (2q − p)TP + p·TN > p·s. So whether any set beats the best one that is known is a
//! question of weighted coverage in whole numbers, and a search by branch and bound answers it.
//!
//! # Practice
//! `layout` says which bit is which voxel, `evidence` has the rows of each candidate, `worth` the value of counts,
//! `problem` which sets are allowed. `front` goes through sizes and steps of cost, and `step` searches one of them:
//! `climb` finds a good set, `question` asks whether any is better, and `search` answers, with `candidates` (those that
//! may join a set), `pairs` (overlaps of two) and `budget` (what fits). `mean` is for means of scores, `odds` for
//! log-odds fusion. Where that is long, `gap` bounds all sets by cuts, which `lp` weighs; `cuts` checks them.

// The pages of modules are read by developers, who build them with private items.
#![allow(rustdoc::private_intra_doc_links)]

mod budget;
mod candidates;
pub mod cheapest;
mod climb;
mod cuts;
mod evidence;
mod front;
mod gap;
pub mod layout;
mod lp;
mod mean;
mod odds;
mod pairs;
mod problem;
mod question;
mod rules;
mod search;
mod step;
mod worth;

pub use cuts::{CutLimits, CutProof, ProofCut, check_cuts};
pub use evidence::{CandidateEvidence, Row, RowStore, Union};
pub use front::{FrontAnswer, NoAnswer, answer};
pub use gap::Gap;
pub use odds::Odds;
pub use pairs::PairCounts;
pub use problem::{FoundSet, JointCandidates, Merit, Problem};
pub use rules::{SetLimits, SetRules};
pub use step::{Bound, FrontStep, KnownSets, best_within, overlaps, polish};
pub use worth::{MOST_VOXELS, Ratio, Worth};

#[cfg(test)]
mod tests;
#[cfg(test)]
#[path = "../thorough.rs"]
mod thorough;
