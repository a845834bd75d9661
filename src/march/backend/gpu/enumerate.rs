//! Asks the system which adapters there are.

use std::sync::{Mutex, PoisonError};

use crate::backend::adapter::AdapterReport;
use crate::error::{Argument, Words};
use crate::{Error, Result};

/// Where the shaders run: Vulkan and, as far as they are compiled in, which Cargo.toml decides, Metal and DirectX 12.
const BACKENDS: wgpu::Backends = wgpu::Backends::PRIMARY;

/// The adapters with what opens them.
type Adapters = Vec<(AdapterReport, wgpu::Adapter)>;

/// Those of a process. They keep the system's drivers open: if NVIDIA's for Linux is closed before a thread ends that
/// used it, the program ends with a segmentation fault.
static ADAPTERS: Mutex<Option<(u32, Adapters)>> = Mutex::new(None);

/// The adapters of this process, listed once. A forked child has none of the threads that its parent's drivers wait for,
/// so it lists its own. If one of the parent's is hardware, the child keeps the parent's list, and [`refuse_forked`]
/// fails.
pub(in crate::backend) fn enumerate() -> Adapters {
    let process = std::process::id();
    let mut known = ADAPTERS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((of, adapters)) = known.as_ref()
        && (*of == process || adapters.iter().any(|(report, _)| !report.software))
    {
        return adapters.clone();
    }
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = BACKENDS;
    // No validation layers: wgpu checks what it is given itself, in every build.
    descriptor.flags = wgpu::InstanceFlags::empty();
    let drivers = wgpu::Instance::new(descriptor);
    let found = pollster::block_on(drivers.enumerate_adapters(BACKENDS));
    // Without an adapter, nothing else keeps them open.
    std::mem::forget(drivers);
    let found = found.into_iter().enumerate().map(|(index, adapter)| (report(index, &adapter), adapter));
    let adapters: Adapters = found.collect();
    // A parent's are not closed here.
    std::mem::forget(known.replace((process, adapters.clone())));
    adapters
}

/// Fails in a forked child whose parent has opened a driver of hardware, which may wait forever for threads of the
/// parent.
pub(super) fn refuse_forked() -> Result<()> {
    let known = ADAPTERS.lock().unwrap_or_else(PoisonError::into_inner);
    let is_forked = known.as_ref().is_some_and(|(of, _)| *of != std::process::id());
    if !is_forked {
        return Ok(());
    }
    let what =
        "this process was forked from one that had asked for GPUs, whose drivers work in one process only";
    let cure = Words::from("spawn processes, or use a fork server, or ") + Argument("backend").quote("cpu");
    Err(Error::device(what).with_advice(cure))
}

fn report(index: usize, adapter: &wgpu::Adapter) -> AdapterReport {
    let (info, limits) = (adapter.get_info(), adapter.limits());
    AdapterReport {
        index,
        name: info.name,
        driver: if info.driver_info.is_empty() { info.driver } else { info.driver_info },
        backend: format!("{:?}", info.backend),
        device_type: format!("{:?}", info.device_type),
        software: info.device_type == wgpu::DeviceType::Cpu,
        max_binding_bytes: limits.max_storage_buffer_binding_size,
        max_buffer_bytes: limits.max_buffer_size,
        max_workgroups: limits.max_compute_workgroups_per_dimension,
        max_storage_buffers: limits.max_storage_buffers_per_shader_stage,
    }
}
