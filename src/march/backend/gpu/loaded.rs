//! What stays on the device: tables of rays, a scene, evidence in slots, and room for a batch.

use super::buffers::{GrowingBuffer, RememberedBuffer};
use super::device::GpuDevice;
use super::first_hits::FirstHitCache;
use super::layers::{LazyLayer, layer_words};
use super::moving::boxes_of;
use super::plan::{SceneSizes, TableSizes};
use super::tiles::{BOX_BITS, BOX_EDGE};
use super::types::{NO_SLOT, ReadingWords, Setup, TableWords, dir_words};
use crate::backend::body_words::BodyWords;
use crate::backend::{OverTime, Rays, Reading, Slot, VoxelScene};
use crate::voxel::{BitGrid, Window};
use crate::{Error, Result};

/// A table of rays on the device.
pub(super) struct DeviceTable {
    pub(super) sizes: TableSizes,
    /// What it was made of.
    pub(super) rays: Rays,
    /// The uniform [`TableWords`].
    pub(super) words: wgpu::Buffer,
    /// Two words a ray.
    pub(super) dirs: wgpu::Buffer,
    /// Both tables of the noise, one after the other.
    pub(super) noise: wgpu::Buffer,
}

impl DeviceTable {
    /// Uploads a table, if the adapter can bind it.
    pub(super) fn new(device: &GpuDevice, rays: &Rays) -> Result<Self> {
        let std_q16 = rays.noise.std_q16.iter().map(|&std_q16| std_q16 as i32);
        let noise: Vec<i32> = rays.noise.unit_q12.iter().copied().chain(std_q16).collect();
        let sizes = TableSizes::new(rays, &device.report)?;
        let words = TableWords::new(rays, sizes.ends_words());
        Ok(DeviceTable {
            sizes,
            rays: rays.clone(),
            words: GrowingBuffer::uniform("table").fill(device, &[words]),
            dirs: device.upload("dirs", &rays.dirs_q15.iter().copied().map(dir_words).collect::<Vec<_>>()),
            noise: device.upload("noise", &noise),
        })
    }
}

/// What the host makes of a scene for the device.
pub(super) struct HostScene {
    /// The lowest voxels of the boxes that the window is decided in, those of the regions first.
    pub(super) boxes: Vec<[u32; 3]>,
    /// How many boxes are those of the regions.
    pub(super) wanted: u32,
    pub(super) body_words: BodyWords,
    /// The words of the blockers that are not in the still layer; of all where there is none.
    layer: Vec<u32>,
    /// Boxes of the blockers that are not in the still layer; of none where there is no such layer.
    moving: [Window; 2],
}

impl HostScene {
    pub(super) fn new(scene: &VoxelScene) -> HostScene {
        let (boxes, wanted) = super::plan::boxes(scene);
        let (layer, moving) = match scene.over_time.as_deref() {
            None => (
                layer_words(&scene.blockers, scene.shades.as_deref()),
                [Window { min: [0; 3], size: [0; 3] }; 2],
            ),
            Some(OverTime { always: still, .. }) => {
                let mut moving = BitGrid::clone(&scene.blockers);
                moving.remove(still);
                (layer_words(&moving, scene.shades.as_deref()), boxes_of(&moving))
            }
        };
        HostScene { boxes, wanted, body_words: BodyWords::new(scene), layer, moving }
    }
}

/// A scene on the device.
pub(super) struct DeviceScene {
    pub(super) window: Window,
    pub(super) sizes: SceneSizes,
    /// The uniform [`Setup`].
    pub(super) setup: wgpu::Buffer,
    /// All blockers.
    pub(super) blockers: LazyLayer,
    /// The same of the still layer, if there is one, and of the blockers that are not in it.
    pub(super) layers: Option<[wgpu::Buffer; 2]>,
    /// The numbers of the boxes of voxels that the window is decided in, those of the regions first.
    pub(super) boxes: wgpu::Buffer,
    pub(super) truth: wgpu::Buffer,
    pub(super) human: wgpu::Buffer,
    pub(super) robot: wgpu::Buffer,
    pub(super) regions: Vec<wgpu::Buffer>,
    pub(super) body_words: BodyWords,
    /// The voxels of people, as `BodyWords` lists them.
    pub(super) body: wgpu::Buffer,
    /// Two planes of each slot, one after the other: occupied and hits.
    pub(super) ended: wgpu::Buffer,
    /// The free plane of each slot.
    pub(super) free: wgpu::Buffer,
    /// Which slots hold evidence of this scene; the others may hold that of an earlier scene.
    pub(super) held: Vec<bool>,
}

impl DeviceScene {
    /// Uploads a scene of these sizes.
    pub(super) fn new(
        device: &GpuDevice,
        scene: &VoxelScene,
        (sizes, HostScene { boxes, body_words, layer, moving, .. }): (SceneSizes, HostScene),
        memory_bytes: Option<u64>,
        kept: &mut FirstHitCache,
        room: &mut BufferPool,
    ) -> Self {
        let slots = sizes.slots(&device.report, memory_bytes);
        let arena = slots as u64 * sizes.plane_bytes();
        let all = LazyLayer::new(scene);
        let layers = match scene.over_time.as_deref() {
            None => {
                all.fill(device, &layer);
                None
            }
            Some(OverTime { always: still, .. }) => {
                Some([kept.still_layer(device, still), device.upload("moving", &layer)])
            }
        };
        let bits = BOX_BITS / 3;
        let number = |corner: &[u32; 3]| {
            let [x, y, z] = corner.map(|c| c / BOX_EDGE);
            x | y << bits | z << (2 * bits)
        };
        room.regions.resize_with(scene.regions.len(), || RememberedBuffer::new("region"));
        let regions = room.regions.iter_mut();
        DeviceScene {
            window: scene.window,
            setup: GrowingBuffer::uniform("setup")
                .fill(device, &[Setup::new(scene, moving, kept.stride, body_words.counters() as u32)]),
            blockers: all,
            layers,
            boxes: room.boxes.hold(device, &boxes.iter().map(number).collect::<Vec<_>>()),
            truth: room.truth.hold(device, scene.truth.words()),
            human: room.human.hold(device, scene.human.words()),
            robot: room.robot.hold(device, scene.robot.words()),
            regions: regions
                .zip(&scene.regions)
                .map(|(room, plane)| room.hold(device, plane.words()))
                .collect(),
            body: room.body.hold(device, bytemuck::cast_slice(&body_words.body)),
            body_words,
            ended: room.ended.hold(device, 2 * arena),
            free: room.free.hold(device, arena),
            held: vec![false; slots],
            sizes,
        }
    }

    /// Where a slot's free plane begins, in bytes; its other planes begin at twice that. A slot that does not
    /// exist is an error, since writing there would change nothing, or another slot's evidence.
    pub(super) fn offset(&self, slot: Slot) -> Result<u64> {
        if slot as usize >= self.held.len() {
            return Err(Error::device(format!("no slot {slot}: there are {}", self.held.len())));
        }
        Ok(slot as u64 * self.sizes.plane_bytes())
    }

    /// Clears the planes of a slot for new evidence: its offset.
    pub(super) fn clear_slot(&self, encoder: &mut wgpu::CommandEncoder, slot: Slot) -> Result<u64> {
        let (offset, bytes) = (self.offset(slot)?, self.sizes.plane_bytes());
        encoder.clear_buffer(&self.ended, 2 * offset, Some(2 * bytes));
        encoder.clear_buffer(&self.free, offset, Some(bytes));
        Ok(offset)
    }

    /// A reading as the device sees it: slots without evidence say nothing.
    pub(super) fn reading(&self, reading: &Reading) -> Result<ReadingWords> {
        let held = |slot: Slot| {
            self.offset(slot)?;
            Ok::<_, Error>(if self.held[slot as usize] { slot } else { NO_SLOT })
        };
        let Reading { slot, volume, hit, miss, presence } = *reading;
        let volume = volume.map_or(Ok(NO_SLOT), held)?;
        Ok(ReadingWords { slot: held(slot)?, volume, hit, miss, presence: presence.into() })
    }
}

/// Buffers that are kept from scene to scene, because the next scene mostly needs the same sizes.
pub(super) struct BufferPool {
    pub(super) placements: GrowingBuffer,
    pub(super) ends: GrowingBuffer,
    pub(super) tiles: GrowingBuffer,
    /// The tiles that `cast_tiles` leaves open.
    pub(super) listed: GrowingBuffer,
    pub(super) pyramid: GrowingBuffer,
    pub(super) undecided: GrowingBuffer,
    /// What `carve_voxels` leaves to `carve_crowded` and `carve_near`: heads, then voxels.
    pub(super) left: GrowingBuffer,
    /// What [`DeviceScene`] has of a scene that is often the same in the next: mostly only people and the robot move.
    boxes: RememberedBuffer,
    truth: RememberedBuffer,
    human: RememberedBuffer,
    robot: RememberedBuffer,
    regions: Vec<RememberedBuffer>,
    body: RememberedBuffer,
    /// The arenas of [`DeviceScene`].
    ended: GrowingBuffer,
    free: GrowingBuffer,
    /// Evidence from the host, on its way into the arenas: here, and on the device.
    pub(super) rows: Vec<u32>,
    pub(super) uploaded: GrowingBuffer,
    pub(super) jobs: GrowingBuffer,
    pub(super) readings: GrowingBuffer,
    /// Two planes of each job of a batch, one after the other: occupied and free.
    pub(super) labels: GrowingBuffer,
    /// What at least two readings of each job label.
    pub(super) twice: GrowingBuffer,
    pub(super) counts: GrowingBuffer,
    pub(super) found: GrowingBuffer,
}

impl BufferPool {
    /// No room yet.
    pub(super) fn new() -> Self {
        BufferPool {
            placements: GrowingBuffer::storage("placements"),
            ends: GrowingBuffer::storage("ends"),
            tiles: GrowingBuffer::storage("tiles"),
            listed: GrowingBuffer::storage("listed"),
            pyramid: GrowingBuffer::storage("pyramid"),
            undecided: GrowingBuffer::indirect("undecided"),
            left: GrowingBuffer::indirect("left"),
            boxes: RememberedBuffer::new("boxes"),
            truth: RememberedBuffer::new("truth"),
            human: RememberedBuffer::new("human"),
            robot: RememberedBuffer::new("robot"),
            regions: Vec::new(),
            body: RememberedBuffer::new("body"),
            ended: GrowingBuffer::storage("ended"),
            free: GrowingBuffer::storage("free"),
            rows: Vec::new(),
            uploaded: GrowingBuffer::storage("uploaded"),
            jobs: GrowingBuffer::storage("jobs"),
            readings: GrowingBuffer::storage("readings"),
            labels: GrowingBuffer::storage("labels"),
            twice: GrowingBuffer::storage("twice"),
            counts: GrowingBuffer::storage("counts"),
            found: GrowingBuffer::storage("found"),
        }
    }
}
