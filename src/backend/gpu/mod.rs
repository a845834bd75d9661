//! The backend on a GPU, or on a software Vulkan adapter: `shaders/` through wgpu. Placements go in batches that
//! stay on the device; only counts come back. The same integers as the oracle, whatever the adapter.

pub mod adapter;
pub mod device;
mod kernel;
pub mod types;

pub use adapter::{AdapterChoice, AdapterReport, adapters};
pub use device::{Device, open};
pub use kernel::evaluate;
pub use types::{Stage, shader_prelude, shader_source};

use super::{Backend, Cell, Evidence, Fusion, Placement, Planes, Rays, Reading, Slot};
use crate::metrics::Confusion;
use crate::{Error, Result};

/// An open adapter.
pub struct Gpu {
    device: Device,
}

impl Gpu {
    /// Opens the chosen adapter and compiles the kernels.
    pub fn new(choice: &AdapterChoice) -> Result<Gpu> {
        Ok(Gpu { device: open(choice)? })
    }
}

fn later<T>() -> Result<T> {
    Err(Error::Device("the GPU backend is being rebuilt".into()))
}

impl Backend for Gpu {
    fn name(&self) -> &'static str {
        "gpu"
    }

    fn device(&self) -> String {
        self.device.report.label()
    }

    fn tables(&mut self, _: &[Rays]) -> Result<()> {
        later()
    }

    fn load(&mut self, _: &Cell) -> Result<()> {
        later()
    }

    fn slots(&self) -> usize {
        1
    }

    fn sense(&mut self, _: usize, _: &[(Slot, Placement)]) -> Result<()> {
        later()
    }

    fn upload(&mut self, _: &[(Slot, Planes)]) -> Result<()> {
        later()
    }

    fn score(&mut self, _: Fusion, _: &[Vec<Reading>]) -> Result<Vec<Vec<Confusion>>> {
        later()
    }

    fn read(&mut self, _: usize, _: &Placement) -> Result<Evidence> {
        later()
    }
}
