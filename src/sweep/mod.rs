//! Candidates × scenes → counts: the main job, what keeps it safe on disk and splits it over machines, and
//! the comparison of backends. Tables of results are written by `report`; nothing here draws or searches.

pub mod bench;
mod book;
pub mod check;
pub mod compare;
mod evidence;
mod order;
pub mod reopen;
pub mod sample;
pub mod session;
mod shift;

use crate::metrics::Confusion;
pub use book::Watch;
pub use evidence::Batch;
pub use order::{Ledger, run, run_asks};
pub use shift::{Crew, Gear};

/// The counts of one choice of poses in one region of one scene; indices are those of the study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    /// Index of the scene.
    pub scene: usize,
    /// Which moment of the scene, counted from 0.
    pub snapshot: usize,
    /// Which repeat, counted from 0.
    pub repeat: usize,
    /// Index of the combination.
    pub combination: usize,
    /// Number of the choice of poses ([`crate::study::Combination::choice`]).
    pub choice: usize,
    /// Number of the choice of representations ([`crate::study::Combination::interpretations`]).
    pub interpretation: usize,
    /// Index of the region.
    pub region: usize,
    /// What was right and wrong.
    pub counts: Confusion,
}

impl Row {
    /// Its place in study order.
    fn place(&self) -> [usize; 7] {
        let Row { scene, snapshot, repeat, combination, choice, interpretation, region, .. } = *self;
        [scene, snapshot, repeat, combination, choice, interpretation, region]
    }
}
