//! Asks the system which adapters there are.

use std::sync::{Mutex, PoisonError};

use crate::backend::adapter::AdapterReport;

/// Where the shaders run: Vulkan and, as far as they are compiled in, which Cargo.toml decides, Metal and DirectX 12.
const BACKENDS: wgpu::Backends = wgpu::Backends::PRIMARY;

/// The system's drivers, opened once a process and never closed: where NVIDIA's for Linux is closed before a thread
/// ends that used it, the program ends with a segmentation fault.
static DRIVERS: Mutex<Option<(u32, wgpu::Instance)>> = Mutex::new(None);

/// The drivers of this process. In a forked child, which has none of the threads that its parent's drivers wait for,
/// they are opened anew.
fn drivers() -> wgpu::Instance {
    let process = std::process::id();
    let mut drivers = DRIVERS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, open)) = drivers.as_ref().filter(|(of, _)| *of == process) {
        return open.clone();
    }
    let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
    descriptor.backends = BACKENDS;
    // No validation layers: wgpu checks what it is given itself, in every build.
    descriptor.flags = wgpu::InstanceFlags::empty();
    let open = wgpu::Instance::new(descriptor);
    std::mem::forget(drivers.replace((process, open.clone())));
    open
}

/// The adapters with what opens them.
pub(in crate::backend) fn enumerate() -> Vec<(AdapterReport, wgpu::Adapter)> {
    let found = pollster::block_on(drivers().enumerate_adapters(BACKENDS));
    found.into_iter().enumerate().map(|(index, adapter)| (report(index, &adapter), adapter)).collect()
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
