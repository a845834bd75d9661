//! Candidates × scenes → counts: the main job, its safe storage on disk and its distribution over machines, and the
//! comparison of backends. `results` writes the tables.

mod ahead;
pub mod bench;
pub mod check;
mod checkpoint;
pub mod compare;
mod devices;
mod evidence;
mod failover;
mod order;
pub mod reopen;
mod said;
pub mod sample;
pub mod session;
mod sets;
mod sweeping;

pub use evidence::BatchSize;
pub use failover::Failover;
pub use order::run_unless;
pub use order::{Ledger, run, run_choices};
use perirobot_march::metrics::Confusion;
pub use said::{EvidenceReader, ReadPlan, SensorSays};
pub use sets::run_on;

/// The counts of one choice of poses in one region of one scene; indices are those of the study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Row {
    /// Index of the scene.
    pub scene: usize,
    /// The moment of the scene, counted from 0.
    pub snapshot: usize,
    /// The repeat, counted from 0.
    pub repeat: usize,
    /// Index of the combination.
    pub combination: usize,
    /// Index of the choice of poses ([`perirobot_study::input::Combination::choice`]).
    pub choice: usize,
    /// Index of the choice of representations ([`perirobot_study::input::Combination::representations`]).
    pub representation: usize,
    /// Index of the region.
    pub region: usize,
    /// The counts.
    pub counts: Confusion,
}

impl Row {
    /// Its place in study order.
    fn place(&self) -> [usize; 7] {
        let Row { scene, snapshot, repeat, combination, choice, representation, region, .. } = *self;
        [scene, snapshot, repeat, combination, choice, representation, region]
    }
}

#[cfg(test)]
mod tests;
