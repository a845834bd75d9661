//! The one seam between what is asked and who computes it: quantised placements in, integers out. Which backend
//! runs is chosen once, at the top; they all give the same counts (`oracle` defines them, `cpu` and `gpu` are fast).

pub mod cpu;
pub mod gpu;
pub mod oracle;

use crate::Result;
use crate::march::{End, Gates};
use crate::metrics::Confusion;
use crate::voxel::{BitGrid, Window};

/// One scene, as the backends see it. All planes but `blockers` cover `window`.
#[derive(Clone, Debug)]
pub struct Cell {
    /// What stops rays, over the whole grid.
    pub blockers: BitGrid,
    /// The part of the grid where evidence is kept: normally the bounding box of the regions.
    pub window: Window,
    /// Truly occupied voxels.
    pub truth: BitGrid,
    /// Voxels of a person.
    pub human: BitGrid,
    /// Voxels of the robot.
    pub robot: BitGrid,
    /// The voxels of each region.
    pub regions: Vec<BitGrid>,
}

/// One sensor, as the backends see it: a table of rays and what ends them.
#[derive(Clone, Debug)]
pub struct Rays {
    /// Unit directions in the sensor's frame, Q15, in ray order.
    pub dirs_q15: Vec<[i32; 3]>,
    /// Ranges and rules that decide how a ray ends.
    pub gates: Gates,
}

/// One pose of a sensor in a grid, quantised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Placement {
    /// Position from the grid's corner, in 1/65536 voxels; inside the grid.
    pub origin_q16: [i32; 3],
    /// Row r of `world_from_sensor`, Q15.
    pub axis_q15: [[i32; 3]; 3],
}

/// All that a sensor says at one pose: planes over the cell's window, and how each ray ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Evidence {
    /// Endpoints.
    pub occupied: BitGrid,
    /// Cells that returning (or certifying) rays passed; `occupied` wins where both are set.
    pub free: BitGrid,
    /// One end a ray, in ray order.
    pub ends: Vec<End>,
}

/// Who computes. A cell and a sensor are loaded, then any number of placements scored.
pub trait Backend {
    /// `oracle`, `cpu` or `gpu`.
    fn name(&self) -> &'static str;

    /// What runs: adapter or processor, for people and manifests.
    fn device(&self) -> String;

    /// Makes a scene and a sensor ready. Fails if they cannot fit the device, saying what would.
    fn load(&mut self, cell: &Cell, rays: &Rays) -> Result<()>;

    /// How many placements suit one call of [`Backend::score`].
    fn batch(&self) -> usize;

    /// For each placement and each region of the loaded cell, the counts.
    fn score(&mut self, placements: &[Placement]) -> Result<Vec<Vec<Confusion>>>;

    /// All that is known of one placement, for comparisons, exports and pictures.
    fn read(&mut self, placement: &Placement) -> Result<Evidence>;
}

/// Counts one region, word by word. `occupied` wins over `free`; all planes cover the same window.
fn count(cell: &Cell, region: &BitGrid, occupied: &BitGrid, free: &BitGrid) -> Confusion {
    let mut counts = [0u64; crate::metrics::COUNTERS];
    let planes = region.words().iter().zip(cell.truth.words()).zip(cell.human.words());
    let planes = planes.zip(cell.robot.words()).zip(occupied.words()).zip(free.words());
    for (((((&region, &truth), &human), &robot), &occupied), &free) in planes {
        if region == 0 {
            continue;
        }
        let free = free & !occupied;
        let labels = [occupied, free, !(occupied | free)];
        let [o, f, u] = labels.map(|label| label & region);
        let words = [
            o & truth,
            o & !truth,
            f & truth,
            f & !truth,
            u & truth,
            u & !truth,
            o & truth & human,
            f & truth & human,
            u & truth & human,
            o & truth & robot,
            f & truth & robot,
            u & truth & robot,
        ];
        for (count, word) in counts.iter_mut().zip(words) {
            *count += word.count_ones() as u64;
        }
    }
    Confusion::from_counts(counts)
}
