//! `perirobot devices`: which adapters there are and which would run.

use std::process::ExitCode;

use perirobot::Result;
use perirobot::backend::gpu::{AdapterChoice, adapter::select, adapters};

/// List the Vulkan adapters, which one would be used, and how to get one
#[derive(clap::Args)]
pub(super) struct Args {}

pub(super) fn run(_args: &Args) -> Result<ExitCode> {
    let found = adapters();
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let mut text = format!("cpu      {threads} threads for this process\n");
    for adapter in &found {
        text += &format!(
            "gpu {:<4} {}\n         type {}, {} MiB a binding, {} MiB a buffer, {} workgroups on an axis\n",
            adapter.index,
            adapter.label(),
            adapter.device_type,
            adapter.max_binding_bytes >> 20,
            adapter.max_buffer_bytes >> 20,
            adapter.max_workgroups
        );
    }
    // The same choice as a run makes.
    let hardware = select(&found, &AdapterChoice::Hardware).ok().map(|index| &found[index]);
    let software = found.iter().find(|adapter| adapter.software);
    text += &match hardware {
        Some(adapter) => format!("\n--backend auto would use gpu {} ({})\n", adapter.index, adapter.name),
        None => "\n--backend auto would use the cpu: there is no hardware GPU\n".into(),
    };
    if hardware.is_none() {
        text += "  for a hardware GPU, install its vendor's Vulkan driver; `vulkaninfo --summary` should list it\n";
    }
    text += match software {
        Some(_) => {
            "  --adapter software runs the shaders on the processor, as CI does: exact, but slower than cpu\n"
        }
        None => {
            "  for a software adapter (to compare with): apt-get install mesa-vulkan-drivers libvulkan1\n"
        }
    };
    super::print(&text)?;
    Ok(ExitCode::SUCCESS)
}
