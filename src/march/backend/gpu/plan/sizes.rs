//! The sizes of tables of rays and of scenes that decide how the work is cut, and how much of it goes at once.

use std::ops::Range;

use super::budget::{
    BATCH_BYTES, DeviceBudget, EVIDENCE_BYTES, FIRST_HIT_BYTES, PLACEMENTS_PER_BATCH, RAYS_PER_BATCH, fits,
};
use super::{CARVE_BOXES_COST, CARVE_VOXELS_COST, PYRAMID_COST};
use crate::Result;
use crate::backend::adapter::AdapterReport;
use crate::backend::body_words::{BodyWord, BodyWords};
use crate::backend::gpu::loop_bounds::{NEAR_TILES, most_tiles};
use crate::backend::gpu::tiles::{PYRAMID_LEVELS, TILE, place_of_pixel};
use crate::backend::gpu::types::{HEAD_WORDS, HEADS, MOST_PLACEMENTS};
use crate::backend::{Carving, Image, Rays, VoxelScene};
use crate::voxel::Bricks;

/// Pixels of whole tiles beyond which rays are numbered past what floats hold.
const MOST_IMAGE_PIXELS: u64 = 1 << 24;
/// Boxes that a dispatch of `carve_voxels` can be given on any adapter.
const LEAST_BOXES: u32 = 1024;
/// Jobs of a batch.
const JOBS_PER_BATCH: u64 = 256;
/// Most pieces of evidence kept at once, however small they are.
const MOST_SLOTS: u64 = 2048;

/// The sizes of a table of rays that decide how the work is cut.
#[derive(Clone, Debug)]
pub(in crate::backend::gpu) struct TableSizes {
    pub(super) rays: u32,
    /// Crossings of one axis that its longest ray may make.
    pub(super) reach: u32,
    pub(super) image: Option<Image>,
    /// Most tiles of an invocation, where rays go by them.
    pub(super) most_tiles: u32,
}

impl TableSizes {
    /// The sizes of a table, if the adapter can bind it.
    pub(in crate::backend::gpu) fn new(rays: &Rays, adapter: &AdapterReport) -> Result<Self> {
        let count = rays.dirs_q15.len() as u64;
        fits(adapter, "the sensor's table of rays takes", count * 8, "fewer rays")?;
        // A noisy return may be read behind its blocker, and behind the range.
        let noise = rays.farthest_q16();
        let range = rays.most_slant().ray_range_q16(rays.gates.range_max_q16) >> 16;
        let sizes = TableSizes {
            rays: count as u32,
            reach: range + (noise >> 16) + 3,
            image: rays.image,
            most_tiles: most_tiles(adapter.software),
        };
        fits(adapter, "the ends of one placement's rays take", sizes.ends_bytes(), "fewer rays")?;
        Ok(sizes)
    }

    /// Bytes of one word a ray: the first hits of one placement in the still layer.
    pub(in crate::backend::gpu) fn rays_bytes(&self) -> u64 {
        u64::from(self.rays) * 4
    }

    /// Words of the ends of one placement: its rays, or where these may go by tiles those of whole tiles and a word a tile, in
    /// whole fours.
    pub(in crate::backend::gpu) fn ends_words(&self) -> u32 {
        if self.has_tiles() { (self.rays_of_tiles() + self.tiles()).next_multiple_of(4) } else { self.rays }
    }

    /// The same in bytes.
    pub(in crate::backend::gpu) fn ends_bytes(&self) -> u64 {
        u64::from(self.ends_words()) * 4
    }

    /// Whether rays may go by tiles: they are the pixels of a camera whose image, in whole tiles, is not too large, nor is its
    /// pyramid.
    pub(in crate::backend::gpu) fn has_tiles(&self) -> bool {
        let pixels = u64::from(self.tiles()) * u64::from(TILE * TILE);
        self.image.is_some() && pixels <= MOST_IMAGE_PIXELS && self.pyramid_bytes() <= BATCH_BYTES.software
    }

    /// Rays of whole tiles.
    pub(super) fn rays_of_tiles(&self) -> u32 {
        self.tiles() * TILE * TILE
    }

    /// The ends of a placement in the order of its rays, as they were carved.
    pub(in crate::backend::gpu) fn order_ends(&self, mut words: Vec<u32>, carving: Carving) -> Vec<u32> {
        let Some(image) = self.image.filter(|_| carving == Carving::ByVoxel) else {
            words.truncate(self.rays as usize);
            return words;
        };
        let [wide, _] = image.size_px;
        let place = |ray: u32| place_of_pixel(wide.div_ceil(TILE), [ray % wide, ray / wide]);
        (0..self.rays).map(|ray| words[place(ray) as usize]).collect()
    }

    /// Blocks of 2^`level` pixels across and down that hold the image.
    fn blocks(&self, level: u32) -> u32 {
        self.image.map_or(0, |image| image.size_px.iter().map(|n| n.div_ceil(1 << level)).product())
    }

    /// Tiles of the image.
    pub(super) fn tiles(&self) -> u32 {
        self.blocks(TILE.ilog2())
    }

    /// Workgroups of `carve_near` that share a voxel.
    pub(in crate::backend::gpu) fn groups_of_near(&self) -> u32 {
        self.tiles().div_ceil(NEAR_TILES).max(1)
    }

    /// Bytes of what the tiles of one placement see: a word of all, and of each.
    pub(in crate::backend::gpu) fn tiles_bytes(&self) -> u64 {
        (u64::from(self.tiles()) + 1) * 4
    }

    /// Bytes of the lists of tiles of some placements that are left open.
    pub(in crate::backend::gpu) fn listed_bytes(&self, placements: u32) -> u64 {
        (u64::from(2 * MOST_PLACEMENTS) + u64::from(placements) * u64::from(self.tiles())) * 4
    }

    /// Largest blocks of pixels of one placement's pyramid, which come two by two.
    pub(super) fn largest_blocks(&self) -> u32 {
        4 * self.blocks(*PYRAMID_LEVELS.end() + 1)
    }

    /// Bytes of the pyramid of one placement.
    pub(in crate::backend::gpu) fn pyramid_bytes(&self) -> u64 {
        let levels = PYRAMID_LEVELS.end() - PYRAMID_LEVELS.start();
        let blocks: u64 = (0..=levels).map(|level| 1 << (2 * level)).sum();
        u64::from(self.largest_blocks()) * blocks * 4
    }

    /// How many placements go in a batch: as many as the budget and a binding hold the ends of, and the
    /// boxes, and no more rays than keep the device busy; at least one.
    pub(in crate::backend::gpu) fn placements_at_once(
        &self,
        scene: &SceneSizes,
        adapter: &AdapterReport,
    ) -> usize {
        let of_tiles = if self.has_tiles() { [self.pyramid_bytes(), 2 * self.tiles_bytes()] } else { [0; 2] };
        let [pyramid, tiles] = of_tiles;
        let bytes = [self.ends_bytes(), pyramid, tiles, scene.undecided_bytes(1)];
        // On a slow adapter a dispatch takes few boxes, and there are so many dispatches at most.
        let boxes = (HEADS * LEAST_BOXES) as u64 / u64::from(scene.boxes[1].max(1));
        let rays = RAYS_PER_BATCH.limit(adapter) / u64::from(self.rays.max(1));
        let most = PLACEMENTS_PER_BATCH.limit(adapter);
        BATCH_BYTES.holds(adapter, &bytes).min(boxes).min(rays).clamp(1, most) as usize
    }

    /// How many placements' first hits in a still layer are kept: as many as the budget, a quarter of the memory if that was
    /// said, and a binding hold.
    pub(in crate::backend::gpu) fn first_hits_at_once(
        &self,
        adapter: &AdapterReport,
        memory_bytes: Option<u64>,
    ) -> usize {
        let told = memory_bytes.map(|bytes| DeviceBudget { software: bytes / 4, hardware: bytes / 4 });
        told.unwrap_or(FIRST_HIT_BYTES).holds(adapter, &[self.rays_bytes()]) as usize
    }
}

/// The sizes of a loaded scene that decide how the work is cut.
#[derive(Clone, Debug)]
pub(in crate::backend::gpu) struct SceneSizes {
    pub(super) window: [u32; 3],
    /// Words of a plane over the window.
    pub(super) window_words: u32,
    /// Boxes of voxels with voxels of a region, and all of the window.
    pub(super) boxes: [u32; 2],
    /// The words of each region that are not zero, from the first to the last.
    pub(super) regions: Vec<Range<u32>>,
    /// Words with voxels of people, and the counters of a job's hits in them.
    pub(super) body: u32,
    pub(super) counters: u32,
}

impl SceneSizes {
    /// The sizes of a scene of so many boxes of voxels, if the adapter can bind it.
    pub(in crate::backend::gpu) fn new(
        scene: &VoxelScene,
        boxes: [u32; 2],
        body_words: &BodyWords,
        adapter: &AdapterReport,
    ) -> Result<Self> {
        let (grid, window) = (scene.blockers.words().len(), scene.truth.words().len());
        let bricks = Bricks::size_of(scene.blockers.window().size).iter().map(|&n| n as u64).product::<u64>();
        let planes = scene.shades.as_ref().map_or(0, |shades| shades.bits.len() as u64);
        let shades = planes * grid as u64 * 4;
        let layer = grid as u64 * 4 + 2 * bricks.next_multiple_of(2) + shades;
        fits(adapter, "the grid takes", layer, "larger voxels")?;
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
    pub(in crate::backend::gpu) fn regions(&self) -> usize {
        self.regions.len()
    }

    /// Bytes of a plane over the window.
    pub(in crate::backend::gpu) fn plane_bytes(&self) -> u64 {
        self.window_words as u64 * 4
    }

    /// Bytes of the list of boxes that are left of some placements.
    pub(in crate::backend::gpu) fn undecided_bytes(&self, placements: u32) -> u64 {
        (u64::from(HEADS * HEAD_WORDS) + placements as u64 * self.boxes[1] as u64) * 4
    }

    /// How many pieces of evidence are kept: as many as the budget, half of the memory if that was said, and
    /// a binding hold, at least one.
    pub(in crate::backend::gpu) fn slots(&self, adapter: &AdapterReport, memory_bytes: Option<u64>) -> usize {
        let told = memory_bytes.map(|bytes| DeviceBudget { software: bytes / 2, hardware: bytes / 2 });
        let planes = [2 * self.plane_bytes(), self.plane_bytes()];
        told.unwrap_or(EVIDENCE_BYTES).holds(adapter, &planes).clamp(1, MOST_SLOTS) as usize
    }

    /// Bytes of the counters of one job's hits.
    pub(in crate::backend::gpu) fn found_bytes(&self) -> u64 {
        self.counters as u64 * 4
    }

    /// How many jobs go in a batch: as many as the budget and a binding hold the fused planes and counters
    /// of, at least one.
    pub(in crate::backend::gpu) fn jobs_at_once(&self, adapter: &AdapterReport) -> usize {
        let bytes = [2 * self.plane_bytes(), self.plane_bytes(), self.found_bytes()];
        BATCH_BYTES.holds(adapter, &bytes).clamp(1, JOBS_PER_BATCH) as usize
    }

    /// How a table's free voxels are found for less: along its rays, through the window, or from the pixels
    /// of its image, if it is one.
    pub(in crate::backend::gpu) fn carving(&self, table: &TableSizes) -> Carving {
        let longest = self.window.iter().map(|&n| table.reach.min(n) as u64).sum::<u64>();
        let by_ray = table.rays as u64 * longest / 2;
        // A quarter of the boxes is left, about.
        let by_voxel = table.rays as u64 * PYRAMID_COST
            + self.boxes[0] as u64 * (CARVE_BOXES_COST + CARVE_VOXELS_COST / 4);
        if table.has_tiles() && by_voxel < by_ray { Carving::ByVoxel } else { Carving::ByRay }
    }
}
