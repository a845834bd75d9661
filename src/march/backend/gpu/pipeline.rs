//! A compute pipeline and the buffers that it is bound to. What the kernels compute is in `shaders/`.

use super::device::GpuDevice;
use super::kernels::Binding;
use super::types::Part;
use crate::Result;

/// How many workgroups a dispatch launches.
#[derive(Clone, Copy, Debug)]
pub(super) enum Groups<'a> {
    /// So many on x and y.
    Known([u32; 2]),
    /// As many as three words of a buffer say, from this byte on.
    In(&'a wgpu::Buffer, u64),
}

/// A compute pipeline, entry point `main`, group 0; a clone is another handle to it.
#[derive(Clone)]
pub(super) struct Pipeline {
    pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    bindings: &'static [Binding],
}

impl Pipeline {
    /// Compiles a kernel, with values of its own for some of its overrides. The driver's complaints come as an error.
    pub(super) fn new(
        device: &GpuDevice,
        name: &str,
        source: String,
        bindings: &'static [Binding],
        overrides: &[(&str, f64)],
    ) -> Result<Self> {
        let entries: Vec<_> = bindings.iter().zip(0..).map(|(b, number)| b.layout_entry(number)).collect();
        let gpu = &device.device;
        let layout = gpu.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some(name),
            entries: &entries,
        });
        let pipeline_layout = gpu.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(name),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let module = gpu.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Wgsl(source.into()),
        });
        let pipeline = gpu.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(name),
            layout: Some(&pipeline_layout),
            module: &module,
            entry_point: Some("main"),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: overrides,
                ..Default::default()
            },
            cache: None,
        });
        device.check()?;
        Ok(Pipeline { pipeline, layout, bindings })
    }

    /// Binds buffers to the kernel, in the order of its bindings.
    pub(super) fn bind(&self, device: &GpuDevice, buffers: &[&wgpu::Buffer]) -> wgpu::BindGroup {
        let resource = |binding: Binding, buffer| match binding {
            Binding::Part => {
                let size = wgpu::BufferSize::new(size_of::<Part>() as u64);
                wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: 0, size })
            }
            _ => buffer.as_entire_binding(),
        };
        let bound = self.bindings.iter().zip(buffers).zip(0..);
        let entry =
            |((&kind, &buffer), binding)| wgpu::BindGroupEntry { binding, resource: resource(kind, buffer) };
        let entries: Vec<_> = bound.map(entry).collect();
        let layout = &self.layout;
        device.device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
    }

    /// Records one dispatch of `groups` workgroups, or of as many as a buffer says from an offset on; `part`
    /// is the offset of its [`Part`], if the kernel has one. `stamps` says where to write when it began and
    /// ended.
    pub(super) fn dispatch(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        bound: &wgpu::BindGroup,
        part: Option<u32>,
        groups: Groups,
        stamps: Option<wgpu::ComputePassTimestampWrites>,
    ) {
        let descriptor = wgpu::ComputePassDescriptor { label: None, timestamp_writes: stamps };
        let mut pass = encoder.begin_compute_pass(&descriptor);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, bound, part.as_slice());
        match groups {
            Groups::Known([x, y]) => pass.dispatch_workgroups(x, y, 1),
            Groups::In(buffer, offset) => pass.dispatch_workgroups_indirect(buffer, offset),
        }
    }
}

impl Binding {
    fn layout_entry(self, number: u32) -> wgpu::BindGroupLayoutEntry {
        let ty = match self {
            Binding::Uniform | Binding::Part => wgpu::BufferBindingType::Uniform,
            Binding::Read | Binding::Write => {
                wgpu::BufferBindingType::Storage { read_only: self == Binding::Read }
            }
        };
        wgpu::BindGroupLayoutEntry {
            binding: number,
            visibility: wgpu::ShaderStages::COMPUTE,
            ty: wgpu::BindingType::Buffer {
                ty,
                has_dynamic_offset: self == Binding::Part,
                min_binding_size: None,
            },
            count: None,
        }
    }
}

/// Runs a kernel of the caller's once, on `groups` workgroups: binding 0 is `input`, binding 1 receives as
/// many words as are returned. This is how the tests ask a device for the values of single functions.
pub fn evaluate(
    device: &GpuDevice,
    source: String,
    input: &[u32],
    words: usize,
    groups: u32,
) -> Result<Vec<u32>> {
    let kernel = Pipeline::new(device, "evaluate", source, &[Binding::Read, Binding::Write], &[])?;
    let input = device.upload("input", input);
    let output = device.storage("output", words as u64 * 4);
    let mut encoder = device.encoder();
    kernel.dispatch(
        &mut encoder,
        &kernel.bind(device, &[&input, &output]),
        None,
        Groups::Known([groups, 1]),
        None,
    );
    let requested = device.request(encoder, &[(&output, 0..words as u64 * 4)], |_| {});
    Ok(device.receive(requested)?.swap_remove(0))
}
