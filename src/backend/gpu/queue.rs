//! The compiled kernels and the work given to them: dispatches in, and word back that all of them ran. What they are
//! bound to is decided in `mod.rs`.

use super::device::{Device, Scratch};
use super::kernel::{Binding, Kernel};
use super::plan::{self, Dispatch, Launched};
use super::types::{Part, Stage, shader_source};
use crate::Result;

/// An open adapter, its kernels, and what they were given to do.
pub(super) struct Queue {
    pub(super) device: Device,
    kernels: [Kernel; Stage::ALL.len()],
    /// Bytes from one dispatch's [`Part`] to the next.
    part_stride: u32,
    parts: Scratch,
    /// Completion counters, one a stage, and what they must come to.
    done: wgpu::Buffer,
    launched: Launched,
}

impl Queue {
    /// Compiles the kernels.
    pub(super) fn new(device: Device) -> Result<Self> {
        use Binding::{Part as Each, Read, Uniform, Write};
        let kernel = |stage: Stage, bindings: &[Binding]| {
            Kernel::new(&device, stage.name(), shader_source(stage), bindings)
        };
        // In the order of each kernel's bindings; the last is always `done`.
        let kernels = [
            kernel(Stage::Cast, &[Uniform, Each, Uniform, Read, Read, Read, Read, Write, Write])?,
            kernel(Stage::Carve, &[Uniform, Each, Uniform, Read, Read, Read, Write, Write, Write])?,
            kernel(Stage::Fuse, &[Uniform, Each, Read, Read, Read, Read, Write, Write, Write])?,
            kernel(Stage::Count, &[Uniform, Each, Read, Read, Read, Read, Read, Read, Write, Write])?,
        ];
        let alignment = device.device.limits().min_uniform_buffer_offset_alignment;
        Ok(Queue {
            part_stride: alignment.max(size_of::<Part>() as u32),
            parts: Scratch::uniform("parts"),
            done: device.storage("done", Stage::ALL.len() as u64 * 4),
            launched: Launched::default(),
            kernels,
            device,
        })
    }

    /// The buffer of the dispatches' parts, to be bound and run before the next is asked for.
    pub(super) fn parts(&mut self, dispatches: &[Dispatch]) -> wgpu::Buffer {
        let stride = self.part_stride as usize;
        let mut parts = vec![0u8; stride * dispatches.len().max(1)];
        for (dispatch, part) in dispatches.iter().zip(parts.chunks_exact_mut(stride)) {
            part[..size_of::<Part>()].copy_from_slice(bytemuck::bytes_of(&dispatch.part));
        }
        self.parts.filled(&self.device, &parts)
    }

    /// Binds buffers to a kernel: uniforms first, then storage, all but the completion counters.
    pub(super) fn bind(
        &self,
        stage: Stage,
        uniforms: &[&wgpu::Buffer],
        storage: &[&wgpu::Buffer],
    ) -> wgpu::BindGroup {
        self.kernels[stage as usize].bind(&self.device, &[uniforms, storage, &[&self.done]].concat())
    }

    /// Submits dispatches after what the encoder holds; nothing is waited for.
    pub(super) fn run<'a>(
        &mut self,
        mut encoder: wgpu::CommandEncoder,
        dispatches: &[Dispatch],
        bound: impl Fn(&Dispatch) -> &'a wgpu::BindGroup,
    ) {
        let mut offset = 0;
        for submission in plan::submissions(dispatches) {
            for dispatch in submission {
                let kernel = &self.kernels[dispatch.stage as usize];
                kernel.dispatch(&mut encoder, bound(dispatch), Some(offset), dispatch.groups);
                offset += self.part_stride;
            }
            self.device.submit(encoder);
            encoder = self.device.encoder();
        }
        self.launched.add(dispatches);
    }

    /// Waits for all that ran and reads buffers back, unless the adapter left out some of the work.
    pub(super) fn finish(&mut self, wanted: &[(&wgpu::Buffer, u64)]) -> Result<Vec<Vec<u32>>> {
        let done = (&self.done, Stage::ALL.len() as u64 * 4);
        let words = self.device.download(&[&[done], wanted].concat());
        let mut encoder = self.device.encoder();
        encoder.clear_buffer(&self.done, 0, None);
        self.device.submit(encoder);
        let launched = std::mem::take(&mut self.launched);
        let mut words = words?;
        launched.check(&words.remove(0)).map_err(|e| self.device.failed(&e))?;
        Ok(words)
    }
}
