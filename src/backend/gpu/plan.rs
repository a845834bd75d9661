//! How the work is cut: what fits the device at once, which dispatches do it, and whether all of them were done.
//! Pure arithmetic; recording and running is left to `mod.rs`.

use std::ops::Range;

use super::adapter::AdapterReport;
use super::types::{Part, Stage, WORDS_PER_INVOCATION, WORKGROUP};
use crate::backend::{Cell, Rays};
use crate::march::MAX_RANGE_VOXELS;
use crate::{Error, Result};

/// Crossings that one dispatch may have to make at worst. A software adapter makes some ten million a second on a
/// core, so that this is seconds there and milliseconds on a GPU: no driver's watchdog bites.
const CROSSINGS_PER_DISPATCH: u64 = 1 << 27;
/// Rays of one dispatch, however short they are.
const RAYS_PER_DISPATCH: u64 = 1 << 18;
/// Words of the window that one dispatch fuses or counts.
const WORDS_PER_DISPATCH: u32 = 1 << 20;
/// What a word of one reading costs to fuse, in crossings, where each of its voxels has its own sum.
const CROSSINGS_PER_READING: u64 = 32;
/// Placements of a batch: more would not make the dispatches any larger.
const PLACEMENTS_PER_BATCH: u64 = 64;
/// Jobs of a batch.
const JOBS_PER_BATCH: u64 = 256;
/// Most pieces of evidence kept at once, however small they are.
const MOST_SLOTS: u64 = 2048;
/// Bytes on the processor's memory and on a GPU's: of the evidence that is kept, and of what a batch needs on its way
/// (the ends of its rays, or its fused planes).
const EVIDENCE_BYTES: Budget = Budget { software: 256 << 20, hardware: 1 << 30 };
const BATCH_BYTES: Budget = Budget { software: 64 << 20, hardware: 512 << 20 };

/// Bytes that something may take, by where they are.
struct Budget {
    software: u64,
    hardware: u64,
}

impl Budget {
    /// How many items of `planes` buffers, `bytes` an item in each, this holds and the adapter binds.
    fn holds(&self, adapter: &AdapterReport, planes: u64, bytes: u64) -> u64 {
        let budget = if adapter.software { self.software } else { self.hardware };
        (budget / planes).min(binding(adapter)) / bytes.max(1)
    }
}

/// The largest buffer that an adapter binds.
fn binding(adapter: &AdapterReport) -> u64 {
    adapter.max_binding_bytes.min(adapter.max_buffer_bytes)
}

/// Refuses what the adapter cannot bind.
pub(super) fn fits(adapter: &AdapterReport, what: &str, bytes: u64, cure: &str) -> Result<()> {
    let limit = binding(adapter);
    if bytes <= limit {
        return Ok(());
    }
    Err(Error::Input(format!(
        "{what} {bytes} bytes, but adapter {} binds at most {limit}: use {cure}, or `--backend cpu`",
        adapter.label()
    )))
}

/// One dispatch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Dispatch {
    pub(super) stage: Stage,
    pub(super) part: Part,
    /// Workgroups on x (rays or words) and y (placements or jobs).
    pub(super) groups: [u32; 2],
    /// What it may cost at worst, in crossings.
    pub(super) work: u64,
}

/// The sizes of a table of rays that decide how the work is cut.
#[derive(Clone, Debug)]
pub(super) struct TableSizes {
    rays: u32,
    /// Crossings of one axis that its longest ray may make.
    reach: u32,
}

impl TableSizes {
    /// The sizes of a table, if the adapter can bind it.
    pub(super) fn of(rays: &Rays, adapter: &AdapterReport) -> Result<Self> {
        let count = rays.dirs_q15.len() as u64;
        fits(adapter, "the sensor's table of rays takes", count * 12, "fewer rays")?;
        // A noisy return may be read behind its blocker, and behind the range.
        let noise = rays.noise_q16.iter().max().map_or(0, |&most| most.max(0) as u32);
        let range = (rays.gates.range_max_q16 >> 16).min(MAX_RANGE_VOXELS);
        Ok(TableSizes { rays: count as u32, reach: range + (noise >> 16) + 3 })
    }

    /// Bytes of the ends of one placement.
    pub(super) fn ends_bytes(&self) -> u64 {
        self.rays as u64 * 4
    }

    /// How many placements go in a batch: as many as the budget and a binding hold the ends of, at least one.
    pub(super) fn placements_at_once(&self, adapter: &AdapterReport) -> usize {
        BATCH_BYTES.holds(adapter, 1, self.ends_bytes()).clamp(1, PLACEMENTS_PER_BATCH) as usize
    }
}

/// The sizes of a loaded scene that decide how the work is cut.
#[derive(Clone, Debug)]
pub(super) struct CellSizes {
    grid: [u32; 3],
    /// Words of a plane over the window.
    window_words: u32,
    /// The words of each region that are not zero, from the first to the last.
    regions: Vec<Range<u32>>,
}

impl CellSizes {
    /// The sizes of a scene, if the adapter can bind it.
    pub(super) fn of(cell: &Cell, adapter: &AdapterReport) -> Result<Self> {
        let (grid, window) = (cell.blockers.words().len(), cell.truth.words().len());
        fits(adapter, "the grid takes", grid as u64 * 4, "larger voxels")?;
        fits(adapter, "the evidence of one placement takes", window as u64 * 4, "smaller regions")?;
        let region_words = |words: &[u32]| {
            let first = words.iter().position(|&w| w != 0).unwrap_or(0);
            let end = words.iter().rposition(|&w| w != 0).map_or(first, |last| last + 1);
            first as u32..end as u32
        };
        Ok(CellSizes {
            grid: cell.blockers.window().size,
            window_words: window as u32,
            regions: cell.regions.iter().map(|region| region_words(region.words())).collect(),
        })
    }

    /// Bytes of a plane over the window.
    pub(super) fn plane_bytes(&self) -> u64 {
        self.window_words as u64 * 4
    }

    /// How many pieces of evidence are kept: as many as the budget, half of the memory if that was said, and a binding
    /// hold, at least one.
    pub(super) fn slots(&self, adapter: &AdapterReport, memory_bytes: Option<u64>) -> usize {
        let told = memory_bytes.map(|bytes| Budget { software: bytes / 2, hardware: bytes / 2 });
        told.unwrap_or(EVIDENCE_BYTES).holds(adapter, 2, self.plane_bytes()).clamp(1, MOST_SLOTS) as usize
    }

    /// How many jobs go in a batch: as many as the budget and a binding hold the fused planes of, at least one.
    pub(super) fn jobs_at_once(&self, adapter: &AdapterReport) -> usize {
        BATCH_BYTES.holds(adapter, 2, self.plane_bytes()).clamp(1, JOBS_PER_BATCH) as usize
    }

    /// The dispatches that cast and carve a batch of placements, in the order they must run.
    pub(super) fn sensing(&self, table: &TableSizes, placements: u32) -> Vec<Dispatch> {
        let longest = self.grid.iter().map(|&n| table.reach.min(n) as u64).sum::<u64>().max(1);
        let rays_at_once = (CROSSINGS_PER_DISPATCH / longest).min(RAYS_PER_DISPATCH) as u32;
        let rays_at_once = rays_at_once.next_multiple_of(WORKGROUP);
        let mut out = Vec::new();
        for stage in [Stage::Cast, Stage::Carve] {
            let blocks = cut(placements, 0..table.rays, rays_at_once);
            out.extend(blocks.into_iter().map(|block| block.dispatch(stage, 0, WORKGROUP, longest)));
        }
        out
    }

    /// The dispatches that fuse and count a batch of jobs of at most so many readings, in the order they must run.
    /// Only words of regions are fused.
    pub(super) fn scoring(&self, jobs: u32, readings: usize) -> Vec<Dispatch> {
        let regions = self.regions.iter().filter(|words| !words.is_empty());
        let first = regions.clone().map(|words| words.start).min().unwrap_or(0);
        let end = regions.map(|words| words.end).max().unwrap_or(0);
        let cost = CROSSINGS_PER_READING * readings.max(1) as u64;
        let words_at_once = (CROSSINGS_PER_DISPATCH / cost).min(WORDS_PER_DISPATCH as u64) as u32;
        let blocks = cut(jobs, first..end, words_at_once.max(1).next_multiple_of(WORKGROUP));
        let mut out: Vec<_> =
            blocks.into_iter().map(|block| block.dispatch(Stage::Fuse, 0, WORKGROUP, cost)).collect();
        for (words, region) in self.regions.iter().zip(0..) {
            let blocks = cut(jobs, words.clone(), WORDS_PER_DISPATCH).into_iter();
            let per_group = WORKGROUP * WORDS_PER_INVOCATION;
            out.extend(blocks.map(|block| block.dispatch(Stage::Count, region, per_group, 0)));
        }
        out
    }
}

/// Some items of some rows.
struct Block {
    rows: Range<u32>,
    items: Range<u32>,
}

impl Block {
    /// The dispatch of a block whose items cost so many crossings each; a workgroup takes `per_group` of them.
    fn dispatch(self, stage: Stage, region: u32, per_group: u32, cost: u64) -> Dispatch {
        let Block { rows, items } = self;
        let work = (items.len() * rows.len()) as u64 * cost;
        let groups = [(items.len() as u32).div_ceil(per_group), rows.len() as u32];
        let part = Part { first_row: rows.start, first: items.start, end: items.end, region };
        Dispatch { stage, part, groups, work }
    }
}

/// Cuts rows of `items` into blocks of about `at_once` items: several whole rows, or parts of one.
fn cut(rows: u32, items: Range<u32>, at_once: u32) -> Vec<Block> {
    let rows_at_once = (at_once / (items.len() as u32).max(1)).max(1) as usize;
    let mut blocks = Vec::new();
    for row in (0..rows).step_by(rows_at_once) {
        for first in items.clone().step_by(at_once as usize) {
            let end = first.saturating_add(at_once).min(items.end);
            let rows = row..row.saturating_add(rows_at_once as u32).min(rows);
            blocks.push(Block { rows, items: first..end });
        }
    }
    blocks
}

/// Groups dispatches into submissions, so that none may take longer than its largest dispatch may.
pub(super) fn submissions(dispatches: &[Dispatch]) -> Vec<&[Dispatch]> {
    let mut out = Vec::new();
    let (mut first, mut work) = (0, 0);
    for (i, dispatch) in dispatches.iter().enumerate() {
        if i > first && work + dispatch.work > CROSSINGS_PER_DISPATCH {
            out.push(&dispatches[first..i]);
            (first, work) = (i, 0);
        }
        work += dispatch.work;
    }
    out.push(&dispatches[first..]);
    out
}

/// Workgroups launched since the last check, a counter a stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Launched([u64; Stage::ALL.len()]);

impl Launched {
    /// Dispatches were submitted.
    pub(super) fn add(&mut self, dispatches: &[Dispatch]) {
        for dispatch in dispatches {
            self.0[dispatch.stage as usize] += dispatch.groups[0] as u64 * dispatch.groups[1] as u64;
        }
    }

    /// Compares the workgroups launched with those that reported their end.
    pub(super) fn check(&self, done: &[u32]) -> Result<(), String> {
        for stage in Stage::ALL {
            let (launched, ended) = (self.0[stage as usize], done[stage as usize]);
            // The device counts in 32 bits.
            if ended != launched as u32 {
                return Err(format!(
                    "incomplete dispatch: {ended} of {launched} workgroups of `{}` ran to their end, so its counts \
                     cannot be trusted; use another adapter, or `--backend cpu`",
                    stage.name()
                ));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
