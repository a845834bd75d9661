//! The backend on a GPU, or on a software Vulkan adapter: `shaders/` through wgpu. Placements go in batches that
//! stay on the device; only counts come back. The same integers as the oracle, whatever the adapter.

pub mod adapter;
pub mod device;
mod kernel;
mod plan;
pub mod types;

pub use adapter::{AdapterChoice, AdapterReport, adapters};
pub use device::{Device, open};
pub use kernel::evaluate;
pub use types::{Stage, shader_prelude, shader_source};

use super::{Backend, Cell, Evidence, Placement, Rays};
use crate::march::End;
use crate::metrics::{COUNTERS, Confusion};
use crate::voxel::{BitGrid, Window};
use crate::{Error, Result};
use kernel::{Binding, Kernel};
use plan::{Dispatch, Sizes};
use types::{Part, PlacementWords, Setup};

/// An open adapter, its kernels, and what is loaded.
pub struct Gpu {
    device: Device,
    kernels: [Kernel; Stage::ALL.len()],
    loaded: Option<Loaded>,
}

/// A scene and a sensor on the device, and room for a batch of placements.
struct Loaded {
    window: Window,
    sizes: Sizes,
    batch: u32,
    /// Bytes from one dispatch's [`Part`] to the next.
    part_stride: u32,
    parts: wgpu::Buffer,
    placements: wgpu::Buffer,
    ends: wgpu::Buffer,
    occupied: wgpu::Buffer,
    free: wgpu::Buffer,
    counts: wgpu::Buffer,
    done: wgpu::Buffer,
    cast: wgpu::BindGroup,
    carve: wgpu::BindGroup,
    /// One a region.
    count: Vec<wgpu::BindGroup>,
}

impl Gpu {
    /// Opens the chosen adapter and compiles the kernels.
    pub fn new(choice: &AdapterChoice) -> Result<Gpu> {
        use Binding::{Part, Read, Uniform, Write};
        let device = open(choice)?;
        let kernel = |stage: Stage, storage: &[Binding]| {
            Kernel::new(&device, stage.name(), shader_source(stage), &[&[Uniform, Part], storage].concat())
        };
        // In the order of each kernel's bindings.
        let kernels = [
            kernel(Stage::Cast, &[Read, Read, Read, Write, Write])?,
            kernel(Stage::Carve, &[Read, Read, Read, Write, Write, Write])?,
            kernel(Stage::Count, &[Read, Read, Read, Read, Read, Read, Write, Write])?,
        ];
        Ok(Gpu { device, kernels, loaded: None })
    }

    fn loaded(&self) -> Result<&Loaded> {
        self.loaded.as_ref().ok_or_else(|| Error::Device("no scene is loaded".into()))
    }

    /// Runs dispatches on a batch of placements, from cleared evidence; nothing is read back.
    fn run(&self, loaded: &Loaded, placements: &[Placement], dispatches: &[Dispatch]) {
        let words: Vec<PlacementWords> = placements.iter().map(PlacementWords::from).collect();
        self.device.queue.write_buffer(&loaded.placements, 0, bytemuck::cast_slice(&words));
        let stride = loaded.part_stride as usize;
        let mut parts = vec![0u8; stride * dispatches.len()];
        for (dispatch, slot) in dispatches.iter().zip(parts.chunks_exact_mut(stride)) {
            slot[..size_of::<Part>()].copy_from_slice(bytemuck::bytes_of(&dispatch.part));
        }
        self.device.queue.write_buffer(&loaded.parts, 0, &parts);

        let planes = (placements.len() as u64 * loaded.sizes.window_words as u64 * 4).max(4);
        let mut encoder = self.device.encoder();
        encoder.clear_buffer(&loaded.occupied, 0, Some(planes));
        encoder.clear_buffer(&loaded.free, 0, Some(planes));
        encoder.clear_buffer(&loaded.counts, 0, None);
        encoder.clear_buffer(&loaded.done, 0, None);
        let mut offset = 0;
        for submission in plan::submissions(dispatches) {
            for dispatch in submission {
                let bound = match dispatch.stage {
                    Stage::Cast => &loaded.cast,
                    Stage::Carve => &loaded.carve,
                    Stage::Count => &loaded.count[dispatch.part.region as usize],
                };
                let kernel = &self.kernels[dispatch.stage as usize];
                kernel.dispatch(&mut encoder, bound, Some(offset), dispatch.groups);
                offset += loaded.part_stride;
            }
            self.device.submit(encoder);
            encoder = self.device.encoder();
        }
    }

    /// Waits for a run and reads buffers back, unless the adapter left out some of the work.
    fn finish(
        &self,
        loaded: &Loaded,
        dispatches: &[Dispatch],
        wanted: &[(&wgpu::Buffer, u64)],
    ) -> Result<Vec<Vec<u32>>> {
        let done = (&loaded.done, Stage::ALL.len() as u64 * 4);
        let mut words = self.device.download(&[&[done], wanted].concat())?;
        plan::check_complete(dispatches, &words.remove(0)).map_err(|e| self.device.failed(&e))?;
        Ok(words)
    }

    fn score_batch(&self, loaded: &Loaded, placements: &[Placement]) -> Result<Vec<Vec<Confusion>>> {
        let dispatches = loaded.sizes.dispatches(placements.len() as u32);
        self.run(loaded, placements, &dispatches);
        let counters = loaded.sizes.regions.len() * COUNTERS;
        let bytes = (placements.len() * counters * 4) as u64;
        let counts = self.finish(loaded, &dispatches, &[(&loaded.counts, bytes)])?.swap_remove(0);
        let region = |c: &[u32]| Confusion::from_counts(std::array::from_fn(|i| c[i] as u64));
        Ok(counts.chunks_exact(counters).map(|c| c.chunks_exact(COUNTERS).map(region).collect()).collect())
    }
}

impl Backend for Gpu {
    fn name(&self) -> &'static str {
        "gpu"
    }

    fn device(&self) -> String {
        self.device.report.label()
    }

    fn load(&mut self, cell: &Cell, rays: &Rays) -> Result<()> {
        // What was loaded goes first, so that two scenes need not fit side by side.
        self.loaded = None;
        let sizes = Sizes::of(cell, rays, &self.device.report)?;
        self.loaded = Some(Loaded::new(&self.device, &self.kernels, cell, rays, sizes));
        self.device.check().inspect_err(|_| self.loaded = None)
    }

    fn batch(&self) -> usize {
        self.loaded.as_ref().map_or(1, |loaded| loaded.batch as usize)
    }

    fn score(&mut self, placements: &[Placement]) -> Result<Vec<Vec<Confusion>>> {
        let loaded = self.loaded()?;
        if loaded.sizes.regions.is_empty() {
            return Ok(vec![vec![]; placements.len()]);
        }
        let batches = placements.chunks(loaded.batch as usize).map(|batch| self.score_batch(loaded, batch));
        Ok(batches.collect::<Result<Vec<_>>>()?.concat())
    }

    fn read(&mut self, placement: &Placement) -> Result<Evidence> {
        let loaded = self.loaded()?;
        let mut dispatches = loaded.sizes.dispatches(1);
        dispatches.retain(|dispatch| dispatch.stage != Stage::Count);
        self.run(loaded, &[*placement], &dispatches);
        let plane = loaded.sizes.window_words as u64 * 4;
        let ends = loaded.sizes.rays as u64 * 4;
        let wanted = [(&loaded.occupied, plane), (&loaded.free, plane), (&loaded.ends, ends)];
        let words = self.finish(loaded, &dispatches, &wanted)?;
        let [occupied, free, ends] = words.try_into().expect("as many as were wanted");
        let grid = |words| BitGrid::from_words(loaded.window, words).expect("a plane has the window's words");
        let ends = ends.into_iter().map(End::unpacked).collect();
        Ok(Evidence { occupied: grid(occupied), free: grid(free), ends })
    }
}

impl Loaded {
    fn new(device: &Device, kernels: &[Kernel], cell: &Cell, rays: &Rays, sizes: Sizes) -> Self {
        use wgpu::BufferUsages as Usage;
        let batch = sizes.batch(&device.report);
        let part_stride =
            device.device.limits().min_uniform_buffer_offset_alignment.max(size_of::<Part>() as u32);
        let slots = batch as u64;
        let uniform = |label, bytes| device.buffer(label, bytes, Usage::UNIFORM | Usage::COPY_DST);

        let setup = uniform("setup", size_of::<Setup>() as u64);
        device.queue.write_buffer(&setup, 0, bytemuck::bytes_of(&Setup::new(cell, rays)));
        let dispatches = sizes.dispatches(batch).len() as u64;
        let parts = uniform("parts", dispatches.max(1) * part_stride as u64);
        let placements = device.storage("placements", slots * size_of::<PlacementWords>() as u64);
        let dirs_q15 = match rays.dirs_q15.as_slice() {
            // The shader's table has whole rays.
            [] => device.upload("dirs_q15", &[[0i32; 3]]),
            dirs_q15 => device.upload("dirs_q15", dirs_q15),
        };
        let blockers = device.upload("blockers", cell.blockers.words());
        let truth = device.upload("truth", cell.truth.words());
        let human = device.upload("human", cell.human.words());
        let robot = device.upload("robot", cell.robot.words());
        let ends = device.storage("ends", slots * sizes.rays as u64 * 4);
        let occupied = device.storage("occupied", slots * sizes.window_words as u64 * 4);
        let free = device.storage("free", slots * sizes.window_words as u64 * 4);
        let counts = device.storage("counts", slots * (cell.regions.len() * COUNTERS * 4) as u64);
        let done = device.storage("done", Stage::ALL.len() as u64 * 4);

        let bind = |stage: Stage, storage: &[&wgpu::Buffer]| {
            kernels[stage as usize].bind(device, &[&[&setup, &parts], storage].concat())
        };
        let cast = bind(Stage::Cast, &[&placements, &dirs_q15, &blockers, &ends, &done]);
        let carve = bind(Stage::Carve, &[&placements, &dirs_q15, &ends, &occupied, &free, &done]);
        let count = cell.regions.iter().map(|region| {
            let region = device.upload("region", region.words());
            bind(Stage::Count, &[&truth, &human, &robot, &region, &occupied, &free, &counts, &done])
        });
        Loaded {
            count: count.collect(),
            window: cell.window,
            sizes,
            batch,
            part_stride,
            parts,
            placements,
            ends,
            occupied,
            free,
            counts,
            done,
            cast,
            carve,
        }
    }
}
