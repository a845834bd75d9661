//! Candidates × scenes → counts: the main job, and the comparison of backends. Files are written by `table` and
//! `manifest`; nothing here draws or searches.

pub mod bench;
pub mod compare;
mod evidence;
pub mod files;
pub mod manifest;
mod order;
pub mod shapes;
pub mod table;
pub mod world;

use crate::backend::Rays;
use crate::metrics::Confusion;
use crate::sensor::Scale;
use crate::study::Study;
pub use order::run;
use order::run_asks;
pub use world::World;

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

/// A choice of poses to be scored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ask {
    /// Index of the combination.
    pub combination: usize,
    /// Number of the choice of poses.
    pub choice: usize,
}

/// Every choice of every combination of a study, in study order.
pub fn asks(study: &Study) -> impl Iterator<Item = Ask> + '_ {
    study
        .combinations
        .iter()
        .enumerate()
        .flat_map(|(combination, spec)| (0..spec.choices()).map(move |choice| Ask { combination, choice }))
}

/// How many choices are scored in all, each snapshot of a scene and each repeat for itself.
pub fn jobs(study: &Study) -> u64 {
    let choices: usize = study.combinations.iter().map(|combination| combination.choices()).sum();
    let snapshots: usize = study.scenes.iter().map(|scene| scene.snapshots).sum();
    (snapshots * choices) as u64 * u64::from(study.repeats)
}

/// The tables of rays that a study's sensors cast, in study order.
pub fn tables(study: &Study) -> Vec<Option<Rays>> {
    (0..study.sensors.len()).map(|sensor| table(study, sensor)).collect()
}

/// The table of one of them, if it casts.
fn table(study: &Study, sensor: usize) -> Option<Rays> {
    let scale = Scale { voxel_size_m: study.voxel_size_m, backdrop: study.backdrop };
    study.sensors[sensor].kind.rays(&scale)
}
