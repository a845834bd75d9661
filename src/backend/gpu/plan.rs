//! How work is cut into dispatches: what fits the device at once, which dispatches do it, and whether all of
//! them ran.

use std::ops::Range;

use super::kernels::Stage;
use super::loop_bounds::{WORKGROUP, near_voxels};
use super::pace::Pace;
use super::types::{BOX_EDGE, BOXES_AT_ONCE, FARTHEST_READ_Q16, HEADS, PYRAMID_LEVELS, Part, TILE};
use crate::Result;
use crate::backend::adapter::AdapterReport;
use crate::backend::body_words::{BodyWord, BodyWords};
use crate::backend::{Carving, Image, Rays, VoxelScene};
use crate::error::{Argument, Issue, Words};
use crate::march::MAX_RANGE_VOXELS;
use crate::voxel::{BitGrid, Bricks};

/// What an item of a stage costs, about, in steps of a march: a ray that leaps, the tiles that see a box, a
/// tile, a ray's share of the pyramid, a box to decide, and the rows of a box that was left.
const CAST_COST: u64 = 40;
const SEE_TILES_COST: u64 = 100;
const CAST_TILES_COST: u64 = 100;
const PYRAMID_COST: u64 = 2;
const CARVE_BOXES_COST: u64 = 50;
const CARVE_VOXELS_COST: u64 = 4000;
/// Most items of one dispatch, however little they cost: the number of workgroups of a row is limited.
const ITEMS_PER_DISPATCH: u64 = 1 << 21;
/// Pixels of an image beyond which rays are numbered past what floats hold.
const MOST_IMAGE_PIXELS: u32 = 1 << 24;
/// Most workgroups of a row of a dispatch.
const MOST_GROUPS: u64 = 65_535;
/// What a word of one reading costs to fuse, where each of its voxels has its own sum, and a word to count.
const STEPS_PER_READING: u64 = 32;
const COUNT_COST: u64 = 4;
/// Placements of a batch: more would not make the dispatches any larger.
const PLACEMENTS_PER_BATCH: u64 = 64;
/// Jobs of a batch.
const JOBS_PER_BATCH: u64 = 256;
/// Most pieces of evidence kept at once, however small they are.
const MOST_SLOTS: u64 = 2048;
/// Bytes in the processor's memory and in a GPU's: for the evidence that is kept, and for what a batch needs
/// meanwhile (the ends of its rays, or its fused planes).
const EVIDENCE_BYTES: Budget = Budget { software: 256 << 20, hardware: 1 << 30 };
const BATCH_BYTES: Budget = Budget { software: 64 << 20, hardware: 512 << 20 };
/// The same of first hits in a still layer.
const FIRST_HIT_BYTES: Budget = Budget { software: 256 << 20, hardware: 4 << 30 };

/// How much of something there may be, by where it is.
struct Budget {
    software: u64,
    hardware: u64,
}

impl Budget {
    fn of(&self, adapter: &AdapterReport) -> u64 {
        if adapter.software { self.software } else { self.hardware }
    }

    /// How many items this holds and the adapter binds, each with so many bytes in each of some buffers.
    fn holds(&self, adapter: &AdapterReport, bytes: &[u64]) -> u64 {
        let largest = bytes.iter().max().copied().unwrap_or(0);
        (self.of(adapter) / bytes.iter().sum::<u64>().max(1)).min(binding(adapter) / largest.max(1))
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
    let what = format!("{what} {bytes} bytes, but adapter {} binds at most {limit}", adapter.label());
    let cure = Words::from(format!("use {cure}, or ")) + Argument::Backend.quoted("cpu");
    Err(Issue::too_large(what).wanted(cure).into())
}

/// One dispatch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Dispatch {
    pub(super) stage: Stage,
    pub(super) part: Part,
    /// Workgroups on x (rays, boxes or words) and y (placements or jobs); none where the device decides.
    pub(super) groups: [u32; 2],
    /// What it costs, about, in steps of a march.
    pub(super) work: u64,
}

impl Dispatch {
    /// Which head of the list of what `carve_voxels` leaves tells its workgroups, if the device alone knows
    /// how many they are.
    pub(super) fn head(&self) -> Option<u32> {
        (self.stage == Stage::CarveCrowded).then_some(self.part.region)
    }
}

/// The sizes of a table of rays that decide how the work is cut.
#[derive(Clone, Debug)]
pub(super) struct TableSizes {
    rays: u32,
    /// Crossings of one axis that its longest ray may make.
    reach: u32,
    image: Option<Image>,
}

impl TableSizes {
    /// The sizes of a table, if the adapter can bind it.
    pub(super) fn of(rays: &Rays, adapter: &AdapterReport) -> Result<Self> {
        let count = rays.dirs_q15.len() as u64;
        fits(adapter, "the sensor's table of rays takes", count * 12, "fewer rays")?;
        // A noisy return may be read behind its blocker, and behind the range.
        let noise = rays.noise.farthest_q16();
        let range = (rays.gates.range_max_q16 >> 16).min(MAX_RANGE_VOXELS);
        Ok(TableSizes { rays: count as u32, reach: range + (noise >> 16) + 3, image: rays.image })
    }

    /// Bytes of one word a ray: the ends of one placement, or its first hits in the still layer.
    pub(super) fn ends_bytes(&self) -> u64 {
        self.rays as u64 * 4
    }

    /// Whether the rays are the pixels of a camera.
    pub(super) fn is_image(&self) -> bool {
        self.image.is_some()
    }

    /// Blocks of 2^`level` pixels across and down that hold the image.
    fn blocks(&self, level: u32) -> u32 {
        self.image.map_or(0, |image| image.size_px.iter().map(|n| n.div_ceil(1 << level)).product())
    }

    /// Tiles of the image.
    fn tiles(&self) -> u32 {
        self.blocks(TILE.ilog2())
    }

    /// Bytes of what the tiles of one placement see.
    pub(super) fn tiles_bytes(&self) -> u64 {
        (u64::from(self.tiles()) + 1) * 4
    }

    /// Largest blocks of pixels of one placement's pyramid.
    fn largest_blocks(&self) -> u32 {
        self.blocks(*PYRAMID_LEVELS.end())
    }

    /// Bytes of the pyramid of one placement.
    pub(super) fn pyramid_bytes(&self) -> u64 {
        let levels = PYRAMID_LEVELS.end() - PYRAMID_LEVELS.start();
        let blocks: u64 = (0..=levels).map(|level| 1 << (2 * level)).sum();
        u64::from(self.largest_blocks()) * blocks * 4
    }

    /// How many placements go in a batch: as many as the budget and a binding hold the ends of, and the
    /// boxes, at least one.
    pub(super) fn placements_at_once(&self, scene: &SceneSizes, adapter: &AdapterReport) -> usize {
        let bytes = self.ends_bytes().max(self.pyramid_bytes()).max(scene.undecided_bytes(1));
        let boxes = (HEADS * BOXES_AT_ONCE) as u64 / u64::from(scene.boxes[1].max(1));
        BATCH_BYTES.holds(adapter, &[bytes]).min(boxes).clamp(1, PLACEMENTS_PER_BATCH) as usize
    }

    /// How many placements' first hits in a still layer are kept.
    pub(super) fn first_hits_at_once(&self, adapter: &AdapterReport) -> usize {
        FIRST_HIT_BYTES.holds(adapter, &[self.ends_bytes()]) as usize
    }

    /// The distance in 1/65536 voxels up to which rays can pass near voxels, so that rays need be followed no
    /// farther: a near voxel begins at most `near` deep, is less than two voxels deep, and the rays of the
    /// corners take the longest way there.
    fn near_until_q16(&self) -> u32 {
        let Some(image) = self.image else { return FARTHEST_READ_Q16 };
        let corner = |a: usize| f64::from(image.size_px[a]) / 2.0 / image.focal_px[a];
        let slant = (1.0 + corner(0).powi(2) + corner(1).powi(2)).sqrt();
        let until = (near_voxels(&image) + 2.2) * slant * 1.01 + 1.0;
        ((until * 65_536.0) as u64).min(FARTHEST_READ_Q16 as u64) as u32
    }

    /// Whether a placement may be so near to boxes of voxels that some of their voxels are near.
    pub(super) fn is_near(&self, origin_q16: [i32; 3], boxes: &[[i32; 3]]) -> bool {
        let until = (self.near_until_q16() >> 16) as i32 + 2;
        let near = |corner: &[i32; 3]| {
            (0..3).all(|r| {
                let from = corner[r] - (origin_q16[r] >> 16);
                from <= until && from + BOX_EDGE as i32 > -until
            })
        };
        boxes.iter().any(near)
    }
}

/// The sizes of a loaded scene that decide how the work is cut.
#[derive(Clone, Debug)]
pub(super) struct SceneSizes {
    window: [u32; 3],
    /// Words of a plane over the window.
    window_words: u32,
    /// Boxes of voxels with voxels of a region, and all of the window.
    boxes: [u32; 2],
    /// The words of each region that are not zero, from the first to the last.
    regions: Vec<Range<u32>>,
    /// Words with voxels of people, and the counters of a job's hits in them.
    body: u32,
    counters: u32,
}

/// What a batch of placements needs.
#[derive(Clone, Copy, Debug)]
pub(super) struct CastBatch {
    pub(super) placements: u32,
    /// Placements, the first of the batch, that are near to boxes.
    pub(super) near: u32,
    /// Whether all is wanted, or only what is inside the regions.
    pub(super) everything: bool,
    pub(super) carving: Carving,
    /// Whether the layer that is cast in holds all blockers.
    pub(super) whole_layer: bool,
}

impl CastBatch {
    /// Whether rays go tile by tile as long as they go through nothing, and only those of tiles that see
    /// something that matters.
    pub(super) fn by_tile(&self) -> bool {
        self.carving == Carving::ByVoxel && !self.everything
    }
}

impl SceneSizes {
    /// The sizes of a scene of so many boxes of voxels, if the adapter can bind it.
    pub(super) fn of(
        scene: &VoxelScene,
        boxes: [u32; 2],
        body_words: &BodyWords,
        adapter: &AdapterReport,
    ) -> Result<Self> {
        let (grid, window) = (scene.blockers.words().len(), scene.truth.words().len());
        let bricks = Bricks::size_of(scene.blockers.window().size).iter().map(|&n| n as u64).product::<u64>();
        fits(adapter, "the grid takes", grid as u64 * 4 + bricks.next_multiple_of(4), "larger voxels")?;
        fits(adapter, "the evidence of one placement takes", window as u64 * 8, "smaller regions")?;
        let (body, counters) = (body_words.body.len() as u64, body_words.counters() as u64);
        fits(adapter, "the voxels of people take", body * size_of::<BodyWord>() as u64, "fewer regions")?;
        fits(adapter, "the parts of people take", counters * 4, "fewer regions")?;
        let region_words = |words: &[u32]| {
            let first = words.iter().position(|&w| w != 0).unwrap_or(0);
            let end = words.iter().rposition(|&w| w != 0).map_or(first, |last| last + 1);
            first as u32..end as u32
        };
        Ok(SceneSizes {
            window: scene.window.size,
            window_words: window as u32,
            boxes,
            regions: scene.regions.iter().map(|region| region_words(region.words())).collect(),
            body: body as u32,
            counters: counters as u32,
        })
    }

    /// How many regions are counted.
    pub(super) fn regions(&self) -> usize {
        self.regions.len()
    }

    /// Bytes of a plane over the window.
    pub(super) fn plane_bytes(&self) -> u64 {
        self.window_words as u64 * 4
    }

    /// Bytes of the list of boxes that are left of some placements.
    pub(super) fn undecided_bytes(&self, placements: u32) -> u64 {
        (1 + placements as u64 * self.boxes[1] as u64) * 4
    }

    /// How many pieces of evidence are kept: as many as the budget, half of the memory if that was said, and
    /// a binding hold, at least one.
    pub(super) fn slots(&self, adapter: &AdapterReport, memory_bytes: Option<u64>) -> usize {
        let told = memory_bytes.map(|bytes| Budget { software: bytes / 2, hardware: bytes / 2 });
        let planes = [2 * self.plane_bytes(), self.plane_bytes()];
        told.unwrap_or(EVIDENCE_BYTES).holds(adapter, &planes).clamp(1, MOST_SLOTS) as usize
    }

    /// Bytes of the counters of one job's hits.
    pub(super) fn found_bytes(&self) -> u64 {
        self.counters as u64 * 4
    }

    /// How many jobs go in a batch: as many as the budget and a binding hold the fused planes and counters
    /// of, at least one.
    pub(super) fn jobs_at_once(&self, adapter: &AdapterReport) -> usize {
        let bytes = [self.plane_bytes(), self.plane_bytes(), self.found_bytes()];
        BATCH_BYTES.holds(adapter, &bytes).clamp(1, JOBS_PER_BATCH) as usize
    }

    /// How a table's free voxels are found for less: along its rays, through the window, or from the pixels
    /// of its image, if it is one.
    pub(super) fn carving(&self, table: &TableSizes) -> Carving {
        let longest = self.window.iter().map(|&n| table.reach.min(n) as u64).sum::<u64>();
        let by_ray = table.rays as u64 * longest / 2;
        // A quarter of the boxes is left, about.
        let by_voxel = table.rays as u64 * PYRAMID_COST
            + self.boxes[0] as u64 * (CARVE_BOXES_COST + CARVE_VOXELS_COST / 4);
        let fits = table.rays <= MOST_IMAGE_PIXELS && table.pyramid_bytes() <= BATCH_BYTES.software;
        if table.image.is_some() && by_voxel < by_ray && fits { Carving::ByVoxel } else { Carving::ByRay }
    }

    /// The dispatches that search the still layer for some placements.
    pub(super) fn keeping(&self, table: &TableSizes, placements: u32, pace: &Pace) -> Vec<Dispatch> {
        self.stage(Stage::StaticHits, placements, 0..table.rays, CAST_COST, Part::default(), pace).collect()
    }

    /// The dispatches that cast and carve a batch of placements, in the order they must run.
    pub(super) fn sensing(&self, table: &TableSizes, batch: &CastBatch, pace: &Pace) -> Vec<Dispatch> {
        let rows = batch.placements;
        let mut out = Vec::new();
        if batch.by_tile() {
            let seeing = 0..self.boxes[0];
            out.extend(self.stage(Stage::SeeTiles, rows, seeing, SEE_TILES_COST, Part::default(), pace));
            let part = Part { whole_layer: batch.whole_layer as u32, ..Part::default() };
            out.extend(self.stage(Stage::CastTiles, rows, 0..table.tiles(), CAST_TILES_COST, part, pace));
        }
        let (every_ray, tiles) = (batch.everything as u32, batch.by_tile() as u32);
        let cast = Part { every_ray, tiles, ..Part::default() };
        let items = if batch.by_tile() { 0..table.tiles() * TILE * TILE } else { 0..table.rays };
        out.extend(self.stage(Stage::Cast, rows, items.clone(), CAST_COST, cast, pace));
        let by_ray = |rows: u32, items: Range<u32>, until_q16: u32| {
            let sizes = self.window.iter().map(|&n| (n.min(table.reach)) as u64).sum::<u64>();
            let cost = (sizes / 2).min(3 * (until_q16 >> 16) as u64).max(1);
            let part = Part { until_q16, tiles, ..Part::default() };
            self.stage(Stage::CarveRays, rows, items, cost, part, pace)
        };
        if batch.carving == Carving::ByRay {
            out.extend(by_ray(rows, items, FARTHEST_READ_Q16));
            return out;
        }
        out.extend(by_ray(batch.near, items, table.near_until_q16()));
        let boxes = 0..self.boxes[batch.everything as usize];
        let tile_cost = PYRAMID_COST << (2 * PYRAMID_LEVELS.end());
        out.extend(self.stage(
            Stage::Pyramid,
            rows,
            0..table.largest_blocks(),
            tile_cost,
            Part::default(),
            pace,
        ));
        out.extend(self.stage(
            Stage::CarveBoxes,
            rows,
            boxes.clone(),
            CARVE_BOXES_COST,
            Part::default(),
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
        let per_group = stage.items_per_group();
        let at_once = (pace.work_at_once(stage) / cost.max(1))
            .min(ITEMS_PER_DISPATCH.min(MOST_GROUPS * per_group as u64));
        let at_once = (at_once.max(1) as u32).next_multiple_of(per_group);
        cut(rows, items, at_once).into_iter().map(move |block| block.dispatch(stage, part, cost))
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

/// The dispatches that decide the boxes which were left, a workgroup a box, and the voxels that were left of
/// each of them.
fn carving_voxels(boxes: u32, pace: &Pace) -> impl Iterator<Item = Dispatch> + use<> {
    let at_once =
        (pace.work_at_once(Stage::CarveVoxels) / CARVE_VOXELS_COST).clamp(1, BOXES_AT_ONCE as u64) as u32;
    let blocks = cut(1, 0..boxes, at_once.max(boxes.div_ceil(HEADS)));
    blocks.into_iter().zip(0..).flat_map(|(block, head)| {
        let part = Part { region: head, ..Part::default() };
        let by_voxel = block.dispatch(Stage::CarveVoxels, part, CARVE_VOXELS_COST);
        [by_voxel, Dispatch { stage: Stage::CarveCrowded, groups: [0, 0], ..by_voxel }]
    })
}

/// The boxes of voxels that a window is decided in, those with voxels of a region first and how many those
/// are: the lowest voxel of each, counted from the window's corner.
pub(super) fn boxes(scene: &VoxelScene) -> (Vec<[u32; 3]>, u32) {
    let [nx, ny, nz] = scene.window.size.map(|n| n.div_ceil(BOX_EDGE));
    let mut wanted = vec![false; (nx * ny * nz) as usize];
    for [x, y, z] in scene.regions.iter().flat_map(BitGrid::voxels) {
        let of = |voxel: i32, r: usize| (voxel - scene.window.min[r]) as u32 / BOX_EDGE;
        wanted[((of(z, 2) * ny + of(y, 1)) * nx + of(x, 0)) as usize] = true;
    }
    let corner = |i: u32| [i % nx, i / nx % ny, i / nx / ny].map(|n| n * BOX_EDGE);
    let (first, last): (Vec<_>, Vec<_>) = (0..nx * ny * nz).partition(|&i| wanted[i as usize]);
    let count = first.len() as u32;
    (first.into_iter().chain(last).map(corner).collect(), count)
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
        let groups = [(items.len() as u32).div_ceil(stage.items_per_group()), rows.len() as u32];
        let part = Part { first_row: rows.start, first: items.start, end: items.end, ..part };
        Dispatch { stage, part, groups, work }
    }
}

/// Cuts rows of `items` into blocks of about `at_once` items: several whole rows, or parts of one.
fn cut(rows: u32, items: Range<u32>, at_once: u32) -> Vec<Span> {
    let rows_at_once = (at_once / (items.len() as u32).max(1)).max(1) as usize;
    let mut blocks = Vec::new();
    for row in (0..rows).step_by(rows_at_once) {
        for first in items.clone().step_by(at_once as usize) {
            let end = first.saturating_add(at_once).min(items.end);
            let rows = row..row.saturating_add(rows_at_once as u32).min(rows);
            blocks.push(Span { rows, items: first..end });
        }
    }
    blocks
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

    /// Compares the workgroups launched with those that came to their end, and their invocations with those
    /// whose loops did.
    pub(super) fn check(&self, done: &[u32]) -> Result<(), Issue> {
        let (groups, whole) = done.split_at(self.0.len());
        let distrusted = |what: String| {
            Issue::damaged(format!("{what}, so its counts cannot be trusted"))
                .cure(Words::from("use another adapter, or ") + Argument::Backend.quoted("cpu"))
        };
        for stage in Stage::ALL {
            let (name, launched, ended) = (stage.name(), self.0[stage as usize], groups[stage as usize]);
            // The device counts in 32 bits.
            if ended != launched as u32 {
                return Err(distrusted(format!(
                    "incomplete dispatch: {ended} of {launched} workgroups of `{name}` ran to their end"
                )));
            }
            let (launched, ended) = (launched * u64::from(WORKGROUP), whole[stage as usize]);
            if ended != launched as u32 {
                return Err(distrusted(format!(
                    "loops cut short: in {ended} of {launched} invocations of `{name}` all loops ended by their own \
                     condition, the driver ended others early"
                )));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
