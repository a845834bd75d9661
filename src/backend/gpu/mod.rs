//! The backend on a GPU, or on a software Vulkan adapter: `shaders/` through wgpu. Evidence stays on the device, in
//! slots; only counts come back. The same integers as the oracle, whatever the adapter.

pub mod adapter;
pub mod device;
mod kernel;
mod loaded;
mod plan;
mod queue;
pub mod types;

pub use adapter::{AdapterChoice, AdapterReport, adapters};
pub use device::{Device, open};
pub use kernel::evaluate;
pub use types::{Stage, shader_prelude, shader_source};

use std::collections::VecDeque;

use super::{Backend, Cell, Evidence, Fusion, Placement, Planes, Rays, Reading, Shot, Slot, no_table};
use crate::march::End;
use crate::metrics::{COUNTERS, Confusion};
use crate::voxel::BitGrid;
use crate::{Error, Result};
use loaded::{Loaded, Room, Table};
use plan::CellSizes;
use queue::Queue;
use types::{JobWords, PlacementWords};

/// Bytes of evidence from the host that may be on their way at once.
const UPLOADED_AT_ONCE: u64 = 64 << 20;

/// An open adapter, and what is loaded.
pub struct Gpu {
    queue: Queue,
    /// For evidence, first hits and batches, where that was said.
    memory_bytes: Option<u64>,
    room: Room,
    tables: Vec<Table>,
    loaded: Option<Loaded>,
    answers: VecDeque<Vec<Vec<Confusion>>>,
}

impl Gpu {
    /// Opens the chosen adapter and compiles the kernels.
    pub fn new(choice: &AdapterChoice) -> Result<Gpu> {
        let queue = Queue::new(open(choice)?)?;
        Ok(Gpu {
            queue,
            memory_bytes: None,
            room: Room::new(),
            tables: Vec::new(),
            loaded: None,
            answers: VecDeque::new(),
        })
    }

    /// The same with so much memory for evidence, first hits and batches.
    pub fn memory(self, bytes: u64) -> Self {
        Gpu { memory_bytes: Some(bytes), ..self }
    }

    fn table(&self, table: usize) -> Result<&Table> {
        self.tables.get(table).ok_or_else(|| no_table(table))
    }

    fn loaded(&mut self) -> Result<&mut Loaded> {
        self.loaded.as_mut().ok_or_else(no_scene)
    }

    /// Casts and carves a batch of placements into their slots. The buffer returned begins with the ends of the first.
    fn sense_batch(&mut self, table: usize, shots: &[Shot]) -> Result<wgpu::Buffer> {
        let Gpu { queue, room, tables, loaded, .. } = self;
        let loaded = loaded.as_mut().ok_or_else(no_scene)?;
        let table = tables.get(table).ok_or_else(|| no_table(table))?;
        let mut encoder = queue.device.encoder();
        for &Shot { slot, .. } in shots {
            let (offset, bytes) = (loaded.offset(slot)?, Some(loaded.sizes.plane_bytes()));
            encoder.clear_buffer(&loaded.occupied, offset, bytes);
            encoder.clear_buffer(&loaded.free, offset, bytes);
            loaded.held[slot as usize] = true;
        }
        let words = shots.iter().map(|shot| PlacementWords::new(shot.slot, &shot.placement));
        let placements = room.placements.filled(&queue.device, &words.collect::<Vec<_>>());
        let ends = room.ends.hold(&queue.device, shots.len() as u64 * table.sizes.ends_bytes());
        let dispatches = loaded.sizes.sensing(&table.sizes, shots.len() as u32);
        let parts = queue.parts(&dispatches);
        let uniforms = [&loaded.setup, &parts, &table.words];
        let storage = [&placements, &table.dirs_q15, &table.noise_q16, &loaded.blockers, &ends];
        let cast = queue.bind(Stage::Cast, &uniforms, &storage);
        let storage = [&placements, &table.dirs_q15, &ends, &loaded.occupied, &loaded.free];
        let carve = queue.bind(Stage::Carve, &uniforms, &storage);
        queue.run(encoder, &dispatches, |d| if d.stage == Stage::Cast { &cast } else { &carve });
        Ok(ends)
    }

    /// Fuses and counts a batch of jobs.
    fn score_batch(&mut self, fusion: Fusion, jobs: &[Vec<Reading>]) -> Result<Vec<Vec<Confusion>>> {
        let Gpu { queue, room, loaded, .. } = self;
        let loaded = loaded.as_ref().ok_or_else(no_scene)?;
        let mut readings = Vec::new();
        let mut words = Vec::with_capacity(jobs.len());
        for job in jobs {
            let first = readings.len() as u32;
            for reading in job {
                readings.push(loaded.reading(reading)?);
            }
            words.push(JobWords::new(fusion, first..readings.len() as u32));
        }
        let bytes = size_of_val(readings.as_slice()) as u64;
        plan::fits(&queue.device.report, "the readings of a batch take", bytes, "smaller combinations")?;
        let device = &queue.device;
        let (words, readings) = (room.jobs.filled(device, &words), room.readings.filled(device, &readings));
        let planes = jobs.len() as u64 * loaded.sizes.plane_bytes();
        let occupied = room.fused_occupied.hold(device, planes);
        let free = room.fused_free.hold(device, planes);
        let counters = loaded.regions.len() * COUNTERS;
        let bytes = (jobs.len() * counters * 4) as u64;
        let counts = room.counts.hold(device, bytes);
        let mut encoder = device.encoder();
        encoder.clear_buffer(&counts, 0, Some(bytes));

        let most = jobs.iter().map(Vec::len).max().unwrap_or(0);
        let dispatches = loaded.sizes.scoring(jobs.len() as u32, most);
        let parts = queue.parts(&dispatches);
        let uniforms = [&loaded.setup, &parts];
        let storage = [&words, &readings, &loaded.occupied, &loaded.free, &occupied, &free];
        let fuse = queue.bind(Stage::Fuse, &uniforms, &storage);
        let count = |region: &wgpu::Buffer| {
            let storage = [&loaded.truth, &loaded.human, &loaded.robot, region, &occupied, &free, &counts];
            queue.bind(Stage::Count, &uniforms, &storage)
        };
        let count: Vec<_> = loaded.regions.iter().map(count).collect();
        queue.run(encoder, &dispatches, |d| match d.stage {
            Stage::Fuse => &fuse,
            _ => &count[d.part.region as usize],
        });
        let counts = queue.finish(&[(&counts, bytes)])?.swap_remove(0);
        let region = |c: &[u32]| Confusion::from_counts(std::array::from_fn(|i| c[i] as u64));
        Ok(counts.chunks_exact(counters).map(|c| c.chunks_exact(COUNTERS).map(region).collect()).collect())
    }
}

/// The error for a scene that was never made ready.
fn no_scene() -> Error {
    Error::Device("no scene is loaded".into())
}

impl Backend for Gpu {
    fn name(&self) -> &'static str {
        "gpu"
    }

    fn device(&self) -> String {
        self.queue.device.report.label()
    }

    fn tables(&mut self, tables: &[Rays]) -> Result<()> {
        // The old ones go first, so that both need not fit side by side.
        self.tables.clear();
        let device = &self.queue.device;
        self.tables = tables.iter().map(|rays| Table::new(device, rays)).collect::<Result<_>>()?;
        device.check().inspect_err(|_| self.tables.clear())
    }

    fn load(&mut self, cell: &Cell) -> Result<()> {
        self.loaded = None;
        let device = &self.queue.device;
        let sizes = CellSizes::of(cell, &device.report)?;
        self.loaded = Some(Loaded::new(device, cell, sizes, self.memory_bytes, &mut self.room));
        device.check().inspect_err(|_| self.loaded = None)
    }

    fn slots(&self) -> usize {
        self.loaded.as_ref().map_or(1, |loaded| loaded.held.len())
    }

    fn hit_slots(&self) -> usize {
        0
    }

    fn sense(&mut self, table: usize, shots: &[Shot]) -> Result<()> {
        let at_once = self.table(table)?.sizes.placements_at_once(&self.queue.device.report);
        for batch in shots.chunks(at_once) {
            self.sense_batch(table, batch)?;
        }
        self.queue.device.check()
    }

    fn upload(&mut self, evidence: Vec<(Slot, Planes)>) -> Result<()> {
        let Gpu { queue, loaded, .. } = self;
        let loaded = loaded.as_mut().ok_or_else(no_scene)?;
        let mut on_their_way = 0;
        for (slot, planes) in evidence {
            let offset = loaded.offset(slot)?;
            for (plane, arena) in [(&planes.occupied, &loaded.occupied), (&planes.free, &loaded.free)] {
                if plane.window() == loaded.window {
                    queue.device.write(arena, offset, plane.words());
                } else {
                    queue.device.write(arena, offset, plane.over(loaded.window).words());
                }
            }
            loaded.held[slot as usize] = true;
            on_their_way += 2 * loaded.sizes.plane_bytes();
            if on_their_way > UPLOADED_AT_ONCE {
                queue.device.submit(queue.device.encoder());
                queue.device.wait()?;
                on_their_way = 0;
            }
        }
        queue.device.check()
    }

    fn ask(&mut self, fusion: Fusion, jobs: &[Vec<Reading>]) -> Result<()> {
        let report = self.queue.device.report.clone();
        let loaded = self.loaded()?;
        if loaded.regions.is_empty() {
            self.answers.push_back(vec![vec![]; jobs.len()]);
            return Ok(());
        }
        let batches = jobs.chunks(loaded.sizes.jobs_at_once(&report));
        let answer =
            batches.map(|batch| self.score_batch(fusion, batch)).collect::<Result<Vec<_>>>()?.concat();
        self.answers.push_back(answer);
        Ok(())
    }

    fn answer(&mut self) -> Result<Vec<Vec<Confusion>>> {
        self.answers.pop_front().ok_or_else(super::nothing_asked)
    }

    fn read(&mut self, table: usize, placement: &Placement) -> Result<Evidence> {
        let ends = self.sense_batch(table, &[Shot::once(0, *placement)])?;
        let ends_bytes = self.table(table)?.sizes.ends_bytes();
        let Gpu { queue, loaded, .. } = self;
        let loaded = loaded.as_mut().ok_or_else(no_scene)?;
        loaded.held.fill(false);
        // The first slot is where the arenas begin.
        let plane = loaded.sizes.plane_bytes();
        let wanted = [(&loaded.occupied, plane), (&loaded.free, plane), (&ends, ends_bytes)];
        let words = queue.finish(&wanted)?;
        let [occupied, free, ends] = words.try_into().expect("as many as were wanted");
        let grid = |words| BitGrid::from_words(loaded.window, words).expect("a plane has the window's words");
        let planes = Planes { occupied: grid(occupied), free: grid(free) };
        Ok(Evidence { planes, ends: ends.into_iter().map(End::unpacked).collect() })
    }
}
