//! How work is cut into dispatches. `budget` is what fits the device at once, `sizes` what that means for a scene and
//! its rays, `launched` proves that all of them ran.

mod budget;
mod launched;
mod sizes;

use std::ops::Range;

use super::kernels::Stage;
use super::loop_bounds::{WORKGROUP, boxes_of_group, groups_of_lists, tiles_of_invocation};
use super::pace::Pace;
use super::tiles::{BOX_EDGE, PYRAMID_LEVELS};
use super::types::{ABREAST, BOXES_AT_ONCE, HEADS, Part};
use crate::backend::{Carving, VoxelScene};
pub(super) use budget::{fits, rays_at_once};
pub(super) use launched::Launched;
pub(super) use sizes::{SceneSizes, TableSizes};

/// What an item of a stage costs, about, in steps of a march: a ray that leaps, the tiles that see a box, a
/// tile, a ray's share of the pyramid, a box to decide, and the rows of a box that was left.
const CAST_COST: u64 = 40;
const SEE_TILES_COST: u64 = 100;
const CAST_TILES_COST: u64 = 100;
const PYRAMID_COST: u64 = 2;
const CARVE_BOXES_COST: u64 = 50;
const CARVE_VOXELS_COST: u64 = 4000;
/// Least boxes of a dispatch of `carve_voxels`, so that those that a workgroup of `carve_boxes` leaves go in two at most.
const LEAST_AT_ONCE: u64 = WORKGROUP as u64;
/// Most workgroups of a row of a dispatch.
const MOST_GROUPS: u64 = 65_535;
// `carve_crowded` or `carve_near` may be left all voxels of the boxes of a dispatch.
const _: () = assert!((BOXES_AT_ONCE * BOX_EDGE.pow(3)) as u64 <= MOST_GROUPS * ABREAST as u64);
/// What a word of one reading costs to fuse, where each of its voxels has its own sum, and a word to count.
const STEPS_PER_READING: u64 = 32;
const COUNT_COST: u64 = 4;

/// One dispatch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Dispatch {
    pub(super) stage: Stage,
    pub(super) part: Part,
    /// Workgroups on x (rays, boxes or words) and y (placements or jobs); none if the device decides.
    pub(super) groups: [u32; 2],
    /// What it costs, about, in steps of a march.
    pub(super) work: u64,
}

impl Dispatch {
    /// How many workgroups it has; none where the device decides.
    pub(super) fn workgroups(&self) -> u64 {
        self.groups.map(u64::from).iter().product()
    }

    /// The number of the head that tells its workgroups, if the device alone knows how many they are.
    pub(super) fn head(&self) -> Option<u32> {
        match self.stage {
            Stage::CarveVoxels | Stage::CarveCrowded => Some(self.part.region),
            Stage::CarveNear => Some(HEADS + self.part.region),
            _ => None,
        }
    }
}

/// What a batch of placements needs.
#[derive(Clone, Copy, Debug)]
pub(super) struct CastBatch {
    pub(super) placements: u32,
    /// Whether all is wanted, or only what is inside the regions.
    pub(super) everything: bool,
    pub(super) carving: Carving,
    /// Whether the layer that is cast in holds all blockers.
    pub(super) whole_layer: bool,
    /// Whether no mount is off, and nothing is known of what rays hit.
    pub(super) plain: bool,
    /// Whether `cast_tiles` lists the tiles that it leaves open.
    pub(super) lists: bool,
}

/// A kernel that casts rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Caster {
    /// For any placement.
    Any,
    /// For plain placements, tile by tile.
    Plain,
    /// For plain placements, from the lists of open tiles.
    Listed,
}

impl CastBatch {
    /// Whether rays go tile by tile.
    fn is_tiled(&self) -> bool {
        self.carving == Carving::ByVoxel
    }

    /// The kernel that casts its rays.
    pub(super) fn caster(&self) -> Caster {
        match (self.plain && self.is_tiled(), self.lists) {
            (true, false) => Caster::Plain,
            (true, true) if !self.everything => Caster::Listed,
            _ => Caster::Any,
        }
    }
}

impl SceneSizes {
    /// The dispatches that search the still layer for some placements.
    pub(super) fn keeping(&self, table: &TableSizes, placements: u32, pace: &Pace) -> Vec<Dispatch> {
        self.stage(Stage::StaticHits, placements, 0..table.rays, CAST_COST, Part::default(), pace).collect()
    }

    /// The dispatches that cast and carve a batch of placements, in the order they must run.
    pub(super) fn sensing(&self, table: &TableSizes, batch: &CastBatch, pace: &Pace) -> Vec<Dispatch> {
        let rows = batch.placements;
        let mut out = Vec::new();
        // Rays go on together as long as they go through nothing, and only those of tiles that see something that matters.
        if batch.is_tiled() && !batch.everything {
            let seeing = 0..self.boxes[0];
            let part = Part { tiles: boxes_of_group(batch.lists), ..Part::default() };
            out.extend(self.stage(Stage::SeeTiles, rows, seeing, SEE_TILES_COST, part, pace));
            let part = Part { whole_layer: batch.whole_layer as u32, ..Part::default() };
            out.extend(self.stage(Stage::CastTiles, rows, 0..table.tiles(), CAST_TILES_COST, part, pace));
        }
        let tiles = if batch.is_tiled() { tiles_of_invocation(table.most_tiles, table.reach) } else { 0 };
        let every_ray = batch.everything as u32;
        let cast = Part { every_ray, tiles, whole_layer: batch.whole_layer as u32, ..Part::default() };
        let items = if batch.is_tiled() { 0..table.rays_of_tiles() } else { 0..table.rays };
        if batch.caster() == Caster::Listed {
            let groups = groups_of_lists(table.tiles(), table.reach);
            let part = Part { tiles: groups, ..Part::default() };
            let cost = (u64::from(items.end) * CAST_COST).div_ceil(u64::from(groups.max(1)));
            out.extend(self.stage(Stage::CastListed, rows, 0..groups, cost, part, pace));
        } else {
            out.extend(self.stage(Stage::Cast, rows, items.clone(), CAST_COST, cast, pace));
        }
        if batch.carving == Carving::ByRay {
            let sizes = self.window.iter().map(|&n| (n.min(table.reach)) as u64).sum::<u64>();
            let cost = (sizes / 2).max(1);
            out.extend(self.stage(Stage::CarveRays, rows, items, cost, Part::default(), pace));
            return out;
        }
        let boxes = 0..self.boxes[batch.everything as usize];
        let tile_cost = PYRAMID_COST << (2 * PYRAMID_LEVELS.end());
        out.extend(self.stage(
            Stage::Pyramid,
            rows,
            0..table.largest_blocks(),
            tile_cost,
            Part { every_ray, ..Part::default() },
            pace,
        ));
        out.extend(self.stage(
            Stage::CarveBoxes,
            rows,
            boxes.clone(),
            CARVE_BOXES_COST,
            Part { boxes_at_once: boxes_at_once(boxes.end * rows, pace), ..Part::default() },
            pace,
        ));
        out.extend(carving_voxels(boxes.end * rows, pace));
        out
    }

    /// The dispatches of a stage over items of rows, which cost so much each.
    fn stage(
        &self,
        stage: Stage,
        rows: u32,
        items: Range<u32>,
        cost: u64,
        part: Part,
        pace: &Pace,
    ) -> impl Iterator<Item = Dispatch> + use<> {
        let per_group = per_group(stage, &part);
        let at_once = (pace.work_at_once(stage) / cost.max(1)).min(pace.most_items());
        cut(rows, items, at_once.max(1) as u32, per_group)
            .into_iter()
            .map(move |block| block.dispatch(stage, part, cost))
    }

    /// The dispatches that fuse and count a batch of jobs of at most so many readings, in the order they must
    /// run. Only words of regions are fused.
    pub(super) fn scoring(&self, jobs: u32, readings: usize, pace: &Pace) -> Vec<Dispatch> {
        let regions = self.regions.iter().filter(|words| !words.is_empty());
        let first = regions.clone().map(|words| words.start).min().unwrap_or(0);
        let end = regions.map(|words| words.end).max().unwrap_or(0);
        let cost = STEPS_PER_READING * readings.max(1) as u64;
        let mut out: Vec<_> =
            self.stage(Stage::Fuse, jobs, first..end, cost, Part::default(), pace).collect();
        for (words, region) in self.regions.iter().zip(0..) {
            let part = Part { region, ..Part::default() };
            out.extend(self.stage(Stage::Count, jobs, words.clone(), COUNT_COST, part, pace));
        }
        let cost = readings.max(1) as u64;
        out.extend(self.stage(Stage::Detect, jobs, 0..self.body, cost, Part::default(), pace));
        out
    }
}

/// How many of some boxes a dispatch of `carve_voxels` takes.
fn boxes_at_once(boxes: u32, pace: &Pace) -> u32 {
    // `carve_crowded` and `carve_near` take the same boxes, and may be slower.
    let stages = [Stage::CarveVoxels, Stage::CarveCrowded, Stage::CarveNear];
    let work = stages.map(|stage| pace.work_at_once(stage)).into_iter().fold(u64::MAX, u64::min);
    let at_once = (work / CARVE_VOXELS_COST).clamp(LEAST_AT_ONCE, BOXES_AT_ONCE as u64) as u32;
    at_once.max(boxes.div_ceil(HEADS))
}

/// The dispatches that decide the boxes which were left, a workgroup a box, and the voxels that were left of
/// each of them.
fn carving_voxels(boxes: u32, pace: &Pace) -> impl Iterator<Item = Dispatch> + use<> {
    let at_once = boxes_at_once(boxes, pace);
    let block = move |first: u32| Span { rows: 0..1, items: first..first.saturating_add(at_once).min(boxes) };
    (0..boxes).step_by(at_once as usize).map(block).zip(0..).flat_map(|(block, head)| {
        let part = Part { region: head, ..Part::default() };
        let block =
            Dispatch { groups: [0, 0], ..block.dispatch(Stage::CarveVoxels, part, CARVE_VOXELS_COST) };
        [
            block,
            Dispatch { stage: Stage::CarveCrowded, ..block },
            Dispatch { stage: Stage::CarveNear, ..block },
        ]
    })
}

/// The boxes of voxels that a window is decided in, those with voxels of a region first and how many those
/// are: the lowest voxel of each, counted from the window's corner.
pub(super) fn boxes(scene: &VoxelScene) -> (Vec<[u32; 3]>, u32) {
    let [nx, ny, nz] = scene.window.size.map(|n| n.div_ceil(BOX_EDGE));
    let mut wanted = vec![false; (nx * ny * nz) as usize];
    let row_words = scene.window.size[0].div_ceil(32).max(1) as usize;
    for region in &scene.regions {
        debug_assert_eq!(region.window(), scene.window, "all planes cover the window");
        for (row, words) in region.words().chunks_exact(row_words).enumerate() {
            let (y, z) = (row as u32 % scene.window.size[1], row as u32 / scene.window.size[1]);
            let first = (z / BOX_EDGE * ny + y / BOX_EDGE) * nx;
            for (w, &word) in words.iter().enumerate().filter(|(_, word)| **word != 0) {
                let boxes =
                    (0..32 / BOX_EDGE).filter(|x| word >> (x * BOX_EDGE) & ((1 << BOX_EDGE) - 1) != 0);
                boxes.for_each(|x| wanted[(first + w as u32 * (32 / BOX_EDGE) + x) as usize] = true);
            }
        }
    }
    let corner = |i: u32| [i % nx, i / nx % ny, i / nx / ny].map(|n| n * BOX_EDGE);
    let (first, last): (Vec<_>, Vec<_>) = (0..nx * ny * nz).partition(|&i| wanted[i as usize]);
    let count = first.len() as u32;
    (first.into_iter().chain(last).map(corner).collect(), count)
}

/// Items of a row that one workgroup of a dispatch takes.
fn per_group(stage: Stage, part: &Part) -> u32 {
    let tiles = if stage == Stage::CastListed { 1 } else { part.tiles.max(1) };
    stage.items_per_group() * tiles
}

/// Some items of some rows.
struct Span {
    rows: Range<u32>,
    items: Range<u32>,
}

impl Span {
    /// The dispatch of a block whose items cost so much each.
    fn dispatch(self, stage: Stage, part: Part, cost: u64) -> Dispatch {
        let Span { rows, items } = self;
        let work = (items.len() * rows.len()) as u64 * cost;
        let groups = [(items.len() as u32).div_ceil(per_group(stage, &part)), rows.len() as u32];
        let part = Part { first_row: rows.start, first: items.start, end: items.end, ..part };
        Dispatch { stage, part, groups, work }
    }
}

/// Cuts rows of `items` into blocks of about `at_once` items: several whole rows, or equal parts of one, of whole groups. A row
/// stays whole if it is at most half as much again.
fn cut(rows: u32, items: Range<u32>, at_once: u32, per_group: u32) -> Vec<Span> {
    let count = items.len() as u32;
    let parts = (2 * u64::from(count) / (3 * u64::from(at_once)) + 1) as u32;
    let part = count.div_ceil(parts).min((MOST_GROUPS as u32).saturating_mul(per_group));
    let part = part.max(1).next_multiple_of(per_group);
    let rows_at_once = (at_once / count.max(1)).clamp(1, MOST_GROUPS as u32) as usize;
    let mut blocks = Vec::new();
    for row in (0..rows).step_by(rows_at_once) {
        for first in items.clone().step_by(part as usize) {
            let end = first.saturating_add(part).min(items.end);
            let rows = row..row.saturating_add(rows_at_once as u32).min(rows);
            blocks.push(Span { rows, items: first..end });
        }
    }
    blocks
}

/// Cuts a list into batches of at most so many, all about as large.
pub(super) fn batches<T>(list: &[T], most: usize) -> std::slice::Chunks<'_, T> {
    let count = list.len().div_ceil(most).max(1);
    list.chunks(list.len().div_ceil(count).max(1))
}

/// Groups dispatches into submissions, so that none may take longer than its largest dispatch may.
pub(super) fn submissions<'a>(dispatches: &'a [Dispatch], pace: &Pace) -> Vec<&'a [Dispatch]> {
    let mut out = Vec::new();
    let (mut first, mut share) = (0, 0.0);
    for (i, dispatch) in dispatches.iter().enumerate() {
        let own = dispatch.work as f64 / pace.work_at_once(dispatch.stage) as f64;
        if i > first && share + own > 1.0 {
            out.push(&dispatches[first..i]);
            (first, share) = (i, 0.0);
        }
        share += own;
    }
    out.push(&dispatches[first..]);
    out
}

#[cfg(test)]
mod tests;
