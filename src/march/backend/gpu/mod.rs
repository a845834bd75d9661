//! The backend on a GPU, or on a software Vulkan adapter: `shaders/` through wgpu. Evidence stays on the
//! device, in slots; only counts come back. The same integers as the oracle, whatever the adapter.

mod buffers;
pub mod device;
mod enumerate;
mod first_hits;
mod kernels;
mod layers;
mod loaded;
mod loop_bounds;
mod moving;
mod pace;
mod pass;
mod pipeline;
mod plan;
mod prelude;
mod queue;
mod score;
mod sense;
mod tiles;
mod timestamps;
pub mod types;
mod upload;

pub use device::{GpuDevice, open};
pub(super) use enumerate::enumerate;
pub use kernels::{DONE_WORDS, SHADER_COMPLETION, Stage};
pub use loop_bounds::WORKGROUP;
pub use pipeline::evaluate;
pub use prelude::{shader_prelude, shader_source};

use std::collections::VecDeque;
use std::time::Duration;

use super::adapter::AdapterChoice;
use super::{
    Backend, Carving, Evidence, Fusion, GridPose, MadeScene, Planes, Rays, Reading, SceneMaker, Shot, Slot,
    StageTiming, VoxelScene, no_table,
};
use crate::march::End;
use crate::metrics::Confusion;
use crate::voxel::BitGrid;
use crate::{Error, Result};
use first_hits::FirstHitCache;
use loaded::{BufferPool, DeviceScene, DeviceTable, HostScene};
use plan::SceneSizes;
use queue::{Queue, StageDone};
use score::PendingCounts;

/// Bytes of evidence that are read back at once.
const READ_AT_ONCE: u64 = 64 << 20;

/// An open adapter, and what is loaded.
pub struct Gpu {
    /// Memory for evidence, first hits and batches, if the user set it.
    memory_bytes: Option<u64>,
    room: BufferPool,
    tables: Vec<DeviceTable>,
    loaded: Option<DeviceScene>,
    kept: FirstHitCache,
    questions: VecDeque<PendingCounts>,
    carving: Option<Carving>,
    /// The last field, since it closes the device: what is on the device goes before.
    queue: Queue,
}

impl Gpu {
    /// Opens the chosen adapter and compiles the kernels.
    pub fn new(choice: &AdapterChoice) -> Result<Gpu> {
        Gpu::with_sources(choice, &shader_source)
    }

    /// The same with kernels from other sources, for tests.
    pub fn with_sources(choice: &AdapterChoice, source: &dyn Fn(Stage) -> String) -> Result<Gpu> {
        Gpu::from_device(open(choice)?, source)
    }

    /// Compiles the kernels for a device that is open.
    pub fn from_device(device: GpuDevice, source: &dyn Fn(Stage) -> String) -> Result<Gpu> {
        Ok(Gpu {
            queue: Queue::new(device, source)?,
            memory_bytes: None,
            room: BufferPool::new(),
            tables: Vec::new(),
            loaded: None,
            kept: FirstHitCache::new(),
            questions: VecDeque::new(),
            carving: None,
        })
    }

    /// The same with half of this memory for evidence; memory for first hits and batches follows from the
    /// adapter.
    pub(crate) fn memory(self, bytes: u64) -> Self {
        Gpu { memory_bytes: Some(bytes), ..self }
    }

    /// Finds the free voxels of cameras in this way, for tests, or (`None`) in the cheaper one. Other sensors,
    /// and cameras whose images are too large for it, have one way only.
    pub fn carve_by(&mut self, carving: Option<Carving>) {
        self.carving = carving;
    }

    /// The same with another limit to waiting, for tests.
    pub fn patience(mut self, patience: Duration) -> Self {
        self.queue.device.patience = patience;
        self
    }

    /// Loses the device, as a driver does that resets it, for tests.
    pub fn lose(&self) {
        self.queue.device.device.destroy();
    }

    fn table(&self, table: usize) -> Result<&DeviceTable> {
        self.tables.get(table).ok_or_else(|| no_table(table))
    }
}

/// The error for a scene that was never made ready.
fn no_scene() -> Error {
    Error::device("no scene is loaded")
}

impl Backend for Gpu {
    fn name(&self) -> &'static str {
        "gpu"
    }

    fn device(&self) -> String {
        self.queue.device.label.clone()
    }

    fn tables(&mut self, tables: &[Rays]) -> Result<()> {
        self.kept.forget();
        let is_ready = |(ready, rays): (&DeviceTable, &Rays)| ready.rays.is_clone_of(rays);
        if self.tables.len() == tables.len() && self.tables.iter().zip(tables).all(is_ready) {
            return Ok(());
        }
        // The old ones go first, so that both need not fit side by side.
        self.tables.clear();
        let device = &self.queue.device;
        self.tables = tables.iter().map(|rays| DeviceTable::new(device, rays)).collect::<Result<_>>()?;
        device.check().inspect_err(|_| self.tables.clear())
    }

    fn load(&mut self, scene: &VoxelScene) -> Result<()> {
        self.load_made(scene, None)
    }

    fn scene_maker(&self) -> Option<SceneMaker> {
        Some(Box::new(|scene| Some(Box::new(HostScene::new(scene)) as MadeScene)))
    }

    fn load_made(&mut self, scene: &VoxelScene, made: Option<MadeScene>) -> Result<()> {
        self.loaded = None;
        let device = &self.queue.device;
        let made = made.and_then(|made| made.downcast::<HostScene>().ok());
        let made = made.map_or_else(|| HostScene::new(scene), |made| *made);
        let boxes = [made.wanted, made.boxes.len() as u32];
        let sizes = SceneSizes::new(scene, boxes, &made.body_words, &device.report)?;
        let memory_bytes = self.memory_bytes;
        self.kept.load(device, scene.over_time.as_ref(), &self.tables, memory_bytes);
        self.loaded = Some(DeviceScene::new(
            device,
            scene,
            (sizes, made),
            memory_bytes,
            &mut self.kept,
            &mut self.room,
        ));
        log::debug!("gpu: scene loaded, room for {} pieces of evidence", self.slots());
        self.queue.device.check().inspect_err(|_| {
            // What did not come to the device is not there the next time, either.
            (self.loaded, self.room) = (None, BufferPool::new());
        })
    }

    fn slots(&self) -> usize {
        self.loaded.as_ref().map_or(1, |loaded| loaded.held.len())
    }

    fn first_hit_slots(&self) -> usize {
        self.kept.held.len()
    }

    fn rays_at_once(&self) -> usize {
        plan::rays_at_once(&self.queue.device.report)
    }

    fn sense(&mut self, table: usize, shots: &[Shot]) -> Result<()> {
        log::debug!("gpu: casts table of rays {table} from {} poses", shots.len());
        let report = self.queue.device.report.clone();
        let rays = &self.table(table)?.sizes;
        let voxel = &self.loaded.as_ref().ok_or_else(no_scene)?.sizes;
        let most = rays.placements_at_once(voxel, &report);
        let (kept, once): (Vec<Shot>, Vec<Shot>) = shots.iter().partition(|shot| shot.first_hits.is_some());
        for some in [kept, once] {
            for batch in plan::batches(&some, most) {
                self.sense_batch(table, batch, false)?;
            }
        }
        self.queue.device.check()
    }

    fn upload(&mut self, evidence: Vec<(Slot, Planes)>) -> Result<()> {
        self.upload_all(&evidence)
    }

    fn submit(&mut self, fusion: Fusion, jobs: &[Vec<Reading>]) -> Result<()> {
        log::debug!("gpu: scores {} choices", jobs.len());
        let question = self.question(fusion, jobs)?;
        self.questions.push_back(question);
        Ok(())
    }

    fn receive(&mut self) -> Result<Vec<Vec<Confusion>>> {
        let question = self.questions.pop_front().ok_or_else(super::nothing_submitted)?;
        let body_words = &self.loaded.as_ref().ok_or_else(no_scene)?.body_words;
        question.answer(&mut self.queue, body_words)
    }

    fn planes(&mut self, slots: &[Slot]) -> Result<Vec<Planes>> {
        let Gpu { queue, loaded, .. } = self;
        let loaded = loaded.as_ref().ok_or_else(no_scene)?;
        let bytes = loaded.sizes.plane_bytes();
        let at_once = (READ_AT_ONCE / (3 * bytes).max(1)).max(1) as usize;
        let mut planes = Vec::with_capacity(slots.len());
        for slots in slots.chunks(at_once) {
            let mut wanted = Vec::new();
            for &slot in slots {
                let offset = loaded.offset(slot)?;
                if !loaded.held[slot as usize] {
                    return Err(super::nothing_in(slot));
                }
                wanted.push((&loaded.ended, 2 * offset..2 * offset + bytes));
                wanted.push((&loaded.free, offset..offset + bytes));
                wanted.push((&loaded.ended, 2 * offset + bytes..2 * offset + 2 * bytes));
            }
            let asked = queue.submit(&wanted);
            let grid =
                |words| BitGrid::from_words(loaded.window, words).expect("a plane has the window's words");
            let mut grids = queue.receive(asked)?.into_iter().map(grid);
            while let (Some(occupied), Some(free), Some(hits)) = (grids.next(), grids.next(), grids.next()) {
                planes.push(Planes { occupied, free, hits });
            }
        }
        Ok(planes)
    }

    fn read(&mut self, table: usize, placement: &GridPose) -> Result<Evidence> {
        let (ends, carving) = self.sense_batch(table, &[Shot::once(0, *placement)], true)?;
        let rays = self.table(table)?.sizes.clone();
        let Gpu { queue, loaded, .. } = self;
        let loaded = loaded.as_mut().ok_or_else(no_scene)?;
        loaded.held.fill(false);
        // The first slot is where the arenas begin.
        let plane = loaded.sizes.plane_bytes();
        let ends_bytes = rays.ends_bytes();
        let asked =
            queue.submit(&[(&loaded.ended, 0..2 * plane), (&loaded.free, 0..plane), (&ends, 0..ends_bytes)]);
        let words = queue.receive(asked)?;
        let [mut occupied, free, ends] = words.try_into().expect("as many as were wanted");
        let hits = occupied.split_off(plane as usize / 4);
        let grid = |words| BitGrid::from_words(loaded.window, words).expect("a plane has the window's words");
        let planes = Planes { occupied: grid(occupied), free: grid(free), hits: grid(hits) };
        Ok(Evidence { planes, ends: rays.order_ends(ends, carving).into_iter().map(End::unpacked).collect() })
    }

    fn timings(&self) -> Vec<StageTiming> {
        let done = Stage::ALL.into_iter().zip(self.queue.done_by).filter(|(_, done)| done.dispatches > 0);
        let timing = |(stage, done): (Stage, StageDone)| {
            let StageDone { took, dispatches, rows, groups } = done;
            let lanes = groups * u64::from(WORKGROUP);
            StageTiming { stage: stage.name(), took, dispatches, rows, lanes }
        };
        done.map(timing).collect()
    }
}
