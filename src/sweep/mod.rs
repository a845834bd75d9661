//! Candidates × scenes → counts: the main job, what keeps it safe on disk and splits it over machines, and the comparison
//! of backends. Tables of results are written by `report`; nothing here draws or searches.

pub mod bench;
mod book;
pub mod check;
pub mod compare;
mod evidence;
pub mod files;
pub mod journal;
pub mod layout;
pub mod manifest;
pub mod merge;
mod order;
pub mod place;
pub mod reopen;
pub mod sample;
pub mod session;
pub mod shapes;
mod shift;
pub mod table;
pub mod world;

use crate::backend::Rays;
use crate::metrics::Confusion;
use crate::sensor::Scale;
use crate::study::{Combination, Study};
pub use book::Watch;
pub use evidence::Batch;
pub use layout::{Ask, Key, Layout, Size};
pub use order::{Ledger, run, run_asks};
pub use shift::{Crew, Gear};
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

/// How the rows of a study are numbered.
pub fn layout_of(study: &Study) -> Layout {
    let size = |c: &Combination| Size { choices: c.choices(), ways: c.ways(&study.sensors) };
    let moments = study.scenes.iter().map(|scene| scene.snapshots).sum();
    let sizes = study.combinations.iter().map(size).collect();
    Layout::new(moments, study.repeats as usize, sizes, study.regions.len())
}

/// How many choices are scored in all, each snapshot of a scene and each repeat for itself.
pub fn jobs(study: &Study) -> u64 {
    let layout = layout_of(study);
    layout.blocks() as u64 * layout.asks() as u64
}

/// The tables of rays that a study's sensors cast, in study order.
pub fn tables(study: &Study) -> Vec<Option<Rays>> {
    tables_of(study, |_| true)
}

/// Those of some sensors; nothing in the places of the others.
fn tables_of(study: &Study, wanted: impl Fn(usize) -> bool) -> Vec<Option<Rays>> {
    (0..study.sensors.len()).map(|sensor| wanted(sensor).then(|| table(study, sensor)).flatten()).collect()
}

/// The table of one of them, if it casts.
pub fn table(study: &Study, sensor: usize) -> Option<Rays> {
    let scale = Scale { voxel_size_m: study.voxel_size_m, backdrop: study.backdrop };
    study.sensors[sensor].kind.rays(&scale)
}
