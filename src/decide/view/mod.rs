//! A view: one choice of poses in one scene at one moment, voxel by voxel, with each sensor's evidence, the
//! fused labels, and whether they are right. Pictures, exports and reasons are made from views; sweeps do
//! not need them.
//!
//! # Practice
//! A view is made on the host from the data of a backend. One over the whole grid, with the end of every ray,
//! costs as much as about a dozen scored poses. If only the regions matter, many choices are cast at once, as far
//! as in a sweep. Either way the counts in a region are those of the sweep.

mod find;
pub mod names;
mod outline;
mod recorded_map;
mod returns;
mod set;
mod viewer;
pub mod watched;
pub mod why;

use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

pub use find::{ChoiceSelector, find, find_scene, only_choice};
pub use outline::Outline;
use why::witness::Fan;

use perirobot_march::Result;
use perirobot_march::backend::cpu::BlockerSearch;
use perirobot_march::backend::{Backend, Evidence, GridPose, Planes, Rays};
use perirobot_march::metrics::{Confusion, Overlap};
use perirobot_march::voxel::BitGrid;
use perirobot_scene::truth::Truth;
use perirobot_study::input::Study;
use perirobot_study::world::World;
pub use recorded_map::{Overlooked, Oversight, RecordedMap};
pub use returns::ReturnPoint;
pub use set::with_set;
pub use viewer::Viewer;

/// The subject of a view; indices are those of the study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Choice {
    /// Index of the combination.
    pub combination: usize,
    /// Index of the choice of poses ([`perirobot_study::input::Combination::choice`]).
    pub choice: usize,
    /// Index of the choice of representations ([`perirobot_study::input::Combination::representations`]).
    pub representation: usize,
    /// The repeat, counted from 0.
    pub repeat: usize,
}

/// A sensor of a choice.
#[derive(Clone, Debug)]
pub struct SensorView {
    /// Index of the sensor.
    pub sensor: usize,
    /// Index of its candidate.
    pub candidate: usize,
    /// Its pose in the grid; the origin if it has no pose.
    pub placement: GridPose,
    /// Whether it casts rays in this representation.
    pub casts: bool,
    /// The evidence of its rays, in a view over the whole grid: planes, and the end of each ray.
    pub cast: Option<Evidence>,
    /// Its labels in this representation, at least over the voxels of the view; `occupied` wins if both are set.
    pub says: Planes,
    /// Whether its hits are people's voxels that it feels.
    pub presence: bool,
}

/// A choice of poses, voxel by voxel.
#[derive(Debug)]
pub struct View<'a> {
    /// The study.
    pub study: &'a Study,
    /// The scene at its moment.
    pub world: &'a World,
    /// The truth of that scene.
    pub truth: Arc<Truth>,
    /// The subject.
    pub choice: Choice,
    /// Its sensors, in the order of precedence.
    pub members: Vec<SensorView>,
    /// Their fused labels, over the grid or over the window of the regions; no voxel is both occupied and free, and a
    /// voxel that is neither is unknown.
    pub labels: Planes,
    /// The rays of the study's sensors.
    tables: Arc<Vec<Option<Rays>>>,
    /// Finds the objects that end single rays; created at the first use.
    search: Arc<OnceLock<BlockerSearch>>,
    /// The same for switches that sense their field by rays, and these rays.
    fans: Arc<OnceLock<BTreeMap<usize, Fan>>>,
}

/// A label compared with the truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Verdict {
    /// Occupied, labelled occupied.
    Tp,
    /// Free, labelled occupied.
    Fp,
    /// Occupied, labelled free.
    Fn,
    /// Free, labelled free.
    Tn,
    /// Occupied, unknown.
    Uo,
    /// Free, unknown.
    Uf,
}

impl Verdict {
    /// All verdicts, in the order of the counts.
    pub const ALL: [Verdict; 6] =
        [Verdict::Tp, Verdict::Fp, Verdict::Fn, Verdict::Tn, Verdict::Uo, Verdict::Uf];

    /// The name of its column in results.csv.
    pub fn name(self) -> &'static str {
        ["tp", "fp", "fn", "tn", "uo", "uf"][self as usize]
    }
}

impl<'a> View<'a> {
    /// The view of a choice over the whole grid. The backend unloads its previous scene.
    pub fn new(
        study: &'a Study,
        world: &'a World,
        choice: Choice,
        backend: &mut dyn Backend,
    ) -> Result<View<'a>> {
        Viewer::new(study, backend)?.view(world, choice)
    }

    /// The labels of the grid, a byte for each voxel, x fastest: 1 occupied, 0 free, 255 (as a signed byte −1) unknown.
    pub fn label_bytes(&self) -> Vec<u8> {
        let mut bytes = vec![0; self.world.grid.size.iter().map(|&n| n as usize).product()];
        self.write_labels(&mut bytes);
        bytes
    }

    /// Writes the same into bytes, one for each voxel of the grid.
    pub fn write_labels(&self, bytes: &mut [u8]) {
        let window = self.world.grid.window();
        let covers = |plane: &BitGrid| plane.window() == window;
        if !covers(&self.labels.occupied) || !covers(&self.labels.free) {
            let [occupied, free] = [&self.labels.occupied, &self.labels.free].map(|p| p.to_window(window));
            return write_rows(&occupied, &free, bytes);
        }
        write_rows(&self.labels.occupied, &self.labels.free, bytes);
    }

    /// The label of a voxel of the view, compared with the truth.
    pub fn verdict(&self, voxel: [i32; 3]) -> Verdict {
        let is_there = self.truth.occupied.get(voxel);
        match (self.labels.occupied.get(voxel), self.labels.free.get(voxel)) {
            (true, _) if is_there => Verdict::Tp,
            (true, _) => Verdict::Fp,
            (_, true) if is_there => Verdict::Fn,
            (_, true) => Verdict::Tn,
            _ if is_there => Verdict::Uo,
            _ => Verdict::Uf,
        }
    }

    /// The voxels of the view with this verdict.
    pub fn voxels(&self, verdict: Verdict) -> BitGrid {
        let Planes { occupied, free, .. } = &self.labels;
        let truth = &*self.truth.occupied;
        let mut voxels = match verdict {
            Verdict::Tp | Verdict::Fp => occupied.clone(),
            Verdict::Fn | Verdict::Tn => free.clone(),
            Verdict::Uo | Verdict::Uf => BitGrid::full(occupied.window()),
        };
        match verdict {
            Verdict::Tp | Verdict::Fn | Verdict::Uo => voxels.keep(truth),
            Verdict::Fp | Verdict::Tn | Verdict::Uf => voxels.remove(truth),
        }
        if matches!(verdict, Verdict::Uo | Verdict::Uf) {
            voxels.remove(occupied);
            voxels.remove(free);
        }
        voxels
    }

    /// The counts in a region, equal to a sweep's.
    pub fn counts(&self, region: usize) -> Confusion {
        let of_region = &*self.world.regions[region].voxels;
        let truth = &self.truth;
        let count = |verdict: Verdict, of: Option<&BitGrid>| {
            let mut voxels = self.voxels(verdict);
            [Some(of_region), of].into_iter().flatten().for_each(|plane| voxels.keep(plane));
            voxels.count()
        };
        let mut counts = Verdict::ALL.map(|verdict| count(verdict, None)).to_vec();
        for of in [&truth.human, &truth.robot] {
            let all = [Verdict::Tp, Verdict::Fn, Verdict::Uo];
            counts.extend(all.map(|verdict| count(verdict, Some(of))));
        }
        let sensed = |voxel| self.members.iter().any(|member| member.presence && member.says.hits.get(voxel));
        let detection = self.world.people.detection(of_region, |voxel| self.labels.hits.get(voxel), sensed);
        let labels = Confusion::from_counts(std::array::from_fn(|i| counts[i]));
        labels.with_detection(detection).with_overlap(self.overlap(of_region))
    }

    /// The voxels that at least two sensors see in a region, by label.
    fn overlap(&self, of_region: &BitGrid) -> Overlap {
        let blank = BitGrid::new(of_region.window());
        let (mut once, mut twice) = (blank.clone(), blank);
        for SensorView { says, .. } in &self.members {
            let mut labelled = says.occupied.to_window(of_region.window());
            labelled.add(&says.free);
            labelled.keep(of_region);
            let mut again = once.clone();
            again.keep(&labelled);
            twice.add(&again);
            once.add(&labelled);
        }
        let is_hit_twice =
            |voxel: &[i32; 3]| self.members.iter().filter(|member| member.says.hits.get(*voxel)).count() >= 2;
        let people = self.world.people.voxels.iter().map(|of| of.voxel);
        let people = people.filter(|voxel| of_region.get(*voxel));
        Overlap { twice: twice.count(), hit_human_twice: people.filter(is_hit_twice).count() as u64 }
    }
}

/// Writes the labels of two planes over the same window, row by row.
fn write_rows(occupied: &BitGrid, free: &BitGrid, bytes: &mut [u8]) {
    let row_voxels = occupied.window().size[0].max(1) as usize;
    let row_words = occupied.words_per_row().max(1) as usize;
    let rows = occupied.words().chunks_exact(row_words).zip(free.words().chunks_exact(row_words));
    for (row, (occupied, free)) in bytes.chunks_exact_mut(row_voxels).zip(rows) {
        for (bytes, (occupied, free)) in row.chunks_mut(32).zip(occupied.iter().zip(free)) {
            let known = occupied | free;
            for (bit, byte) in bytes.iter_mut().enumerate() {
                // Unknown is 255: 0 less 1.
                *byte = ((known >> bit & 1) as u8).wrapping_sub(1) | (occupied >> bit & 1) as u8;
            }
        }
    }
}

#[cfg(test)]
mod tests;
