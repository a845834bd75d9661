//! What stays on the device: tables of rays, a scene, evidence in slots, and room for a batch. Which kernel reads what
//! when is `mod.rs`'s business.

use super::device::{Device, Scratch};
use super::plan::{CellSizes, TableSizes};
use super::types::{NO_SLOT, ReadingWords, Setup, TableWords};
use crate::backend::{Cell, Rays, Reading, Slot};
use crate::voxel::Window;
use crate::{Error, Result};

/// A table of rays on the device.
pub(super) struct Table {
    pub(super) sizes: TableSizes,
    /// The uniform [`TableWords`].
    pub(super) words: wgpu::Buffer,
    pub(super) dirs_q15: wgpu::Buffer,
    pub(super) noise_q16: wgpu::Buffer,
}

impl Table {
    /// Uploads a table, if the adapter can bind it.
    pub(super) fn new(device: &Device, rays: &Rays) -> Result<Self> {
        Ok(Table {
            sizes: TableSizes::of(rays, &device.report)?,
            words: Scratch::uniform("table").filled(device, &[TableWords::from(rays)]),
            dirs_q15: device.upload("dirs_q15", &rays.dirs_q15),
            noise_q16: device.upload("noise_q16", &rays.noise_q16),
        })
    }
}

/// A scene on the device.
pub(super) struct Loaded {
    pub(super) window: Window,
    pub(super) sizes: CellSizes,
    /// The uniform [`Setup`].
    pub(super) setup: wgpu::Buffer,
    pub(super) blockers: wgpu::Buffer,
    pub(super) truth: wgpu::Buffer,
    pub(super) human: wgpu::Buffer,
    pub(super) robot: wgpu::Buffer,
    pub(super) regions: Vec<wgpu::Buffer>,
    /// The planes of all slots, one after the other.
    pub(super) occupied: wgpu::Buffer,
    pub(super) free: wgpu::Buffer,
    /// Which slots hold evidence of this scene; what the others hold is left over from another.
    pub(super) held: Vec<bool>,
}

impl Loaded {
    /// Uploads a scene of these sizes.
    pub(super) fn new(
        device: &Device,
        cell: &Cell,
        sizes: CellSizes,
        memory_bytes: Option<u64>,
        room: &mut Room,
    ) -> Self {
        let slots = sizes.slots(&device.report, memory_bytes);
        let arena = slots as u64 * sizes.plane_bytes();
        Loaded {
            window: cell.window,
            setup: Scratch::uniform("setup").filled(device, &[Setup::new(cell)]),
            blockers: device.upload("blockers", cell.blockers.words()),
            truth: device.upload("truth", cell.truth.words()),
            human: device.upload("human", cell.human.words()),
            robot: device.upload("robot", cell.robot.words()),
            regions: cell.regions.iter().map(|region| device.upload("region", region.words())).collect(),
            occupied: room.occupied.hold(device, arena),
            free: room.free.hold(device, arena),
            held: vec![false; slots],
            sizes,
        }
    }

    /// Where a slot's planes begin, in bytes. An error for a slot that there is not: writing there would hit nothing, or
    /// another's evidence.
    pub(super) fn offset(&self, slot: Slot) -> Result<u64> {
        if slot as usize >= self.held.len() {
            return Err(Error::Device(format!("no slot {slot}: there are {}", self.held.len())));
        }
        Ok(slot as u64 * self.sizes.plane_bytes())
    }

    /// A reading as the device sees it: slots without evidence say nothing.
    pub(super) fn reading(&self, reading: &Reading) -> Result<ReadingWords> {
        let held = |slot: Slot| {
            self.offset(slot)?;
            Ok(if self.held[slot as usize] { slot } else { NO_SLOT })
        };
        let Reading { slot, volume, hit, miss } = *reading;
        Ok(ReadingWords { slot: held(slot)?, volume: volume.map_or(Ok(NO_SLOT), held)?, hit, miss })
    }
}

/// Buffers that outlast a scene, because the next one mostly needs them as large.
pub(super) struct Room {
    pub(super) placements: Scratch,
    pub(super) ends: Scratch,
    /// The arenas of [`Loaded`].
    occupied: Scratch,
    free: Scratch,
    pub(super) jobs: Scratch,
    pub(super) readings: Scratch,
    pub(super) fused_occupied: Scratch,
    pub(super) fused_free: Scratch,
    pub(super) counts: Scratch,
}

impl Room {
    /// No room yet.
    pub(super) fn new() -> Self {
        Room {
            placements: Scratch::storage("placements"),
            ends: Scratch::storage("ends"),
            occupied: Scratch::storage("occupied"),
            free: Scratch::storage("free"),
            jobs: Scratch::storage("jobs"),
            readings: Scratch::storage("readings"),
            fused_occupied: Scratch::storage("fused_occupied"),
            fused_free: Scratch::storage("fused_free"),
            counts: Scratch::storage("counts"),
        }
    }
}
