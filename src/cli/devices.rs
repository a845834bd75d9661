//! `perirobot devices`: the adapters, whether each counts correctly, and which one would be used.

use std::process::ExitCode;
use std::time::Instant;

use perirobot_march::Result;
use perirobot_march::backend::adapter::{AdapterChoice, AdapterReport, select};
use perirobot_march::backend::factory::adapters;
use perirobot_march::backend::factory::{BackendChoice, BackendKind};
use perirobot_march::backend::{SELF_TEST_POSES, self_test};
use perirobot_march::error::Issue;

/// List Vulkan adapters, which would be used, how to get one
///
/// Each adapter counts a batch of poses that the CPU counts as well, and is reported as exact only if all counts are
/// equal.
#[derive(clap::Args)]
pub(super) struct Args {}

pub(super) fn run(_args: &Args) -> Result<ExitCode> {
    let found = adapters();
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let mut text = format!("cpu      {threads} threads for this process\n");
    for adapter in &found {
        text += &format!(
            "gpu {:<4} {}\n         type {}, {} MiB a binding, {} MiB a buffer, {} workgroups on an axis\n         {}\n",
            adapter.index,
            adapter.label(),
            adapter.device_type,
            adapter.max_binding_bytes >> 20,
            adapter.max_buffer_bytes >> 20,
            adapter.max_workgroups,
            describe_test(adapter)
        );
    }
    if !cfg!(feature = "gpu") {
        let what = Issue::left_out("the GPU backend", "gpu");
        return super::print(&format!("{text}\n{}\n", super::flags::to_text(&what.into())))
            .map(|()| ExitCode::SUCCESS);
    }
    // The same choice as in a run.
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
        Some(_) => "  --adapter software runs the shaders on the processor, as CI does: slower than cpu\n",
        None => {
            "  for a software adapter (to compare with): apt-get install mesa-vulkan-drivers libvulkan1\n"
        }
    };
    super::print(&text)?;
    Ok(ExitCode::SUCCESS)
}

/// The result of an adapter's self-test.
fn describe_test(adapter: &AdapterReport) -> String {
    let begin = Instant::now();
    let adapter = Some(AdapterChoice::Named(adapter.index.to_string()));
    let outcome = BackendChoice { kind: BackendKind::Gpu, adapter, ..Default::default() }
        .open()
        .and_then(|(mut gpu, _)| self_test(&mut *gpu).map(|()| begin.elapsed().as_secs_f64()));
    match outcome {
        Ok(seconds) => {
            format!("exact: counts {SELF_TEST_POSES} poses of a camera as the cpu does ({seconds:.1} s)")
        }
        Err(e) => format!("NOT EXACT, do not use it: {}", super::flags::to_text(&e)),
    }
}
