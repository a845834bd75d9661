//! How much an adapter holds at once.

use crate::Result;
use crate::backend::RAYS_AT_ONCE;
use crate::backend::adapter::AdapterReport;
use crate::backend::gpu::types::MOST_PLACEMENTS;
use crate::error::{Argument, Issue, Words};

/// Bytes in the processor's memory and in a GPU's: for the evidence that is kept, and for what a batch needs
/// meanwhile (the ends of its rays, their pyramid, and the lists of tiles and boxes, or its fused planes).
pub(super) const EVIDENCE_BYTES: DeviceBudget = DeviceBudget { software: 256 << 20, hardware: 1 << 30 };
pub(super) const BATCH_BYTES: DeviceBudget = DeviceBudget { software: 96 << 20, hardware: 512 << 20 };
/// The same of first hits in a still layer.
pub(super) const FIRST_HIT_BYTES: DeviceBudget = DeviceBudget { software: 256 << 20, hardware: 4 << 30 };

/// Rays and placements of a batch. A GPU works on more at a time than a processor, and launches it as one.
pub(super) const RAYS_PER_BATCH: DeviceBudget =
    DeviceBudget { software: RAYS_AT_ONCE as u64, hardware: 1 << 26 };
pub(super) const PLACEMENTS_PER_BATCH: DeviceBudget =
    DeviceBudget { software: 64, hardware: MOST_PLACEMENTS as u64 };

/// How much of something there may be, by where it is.
pub(super) struct DeviceBudget {
    pub(super) software: u64,
    pub(super) hardware: u64,
}

impl DeviceBudget {
    pub(super) fn limit(&self, adapter: &AdapterReport) -> u64 {
        if adapter.software { self.software } else { self.hardware }
    }

    /// How many items this holds and the adapter binds, each with so many bytes in each of some buffers.
    pub(super) fn holds(&self, adapter: &AdapterReport, bytes: &[u64]) -> u64 {
        let largest = bytes.iter().max().copied().unwrap_or(0);
        (self.limit(adapter) / bytes.iter().sum::<u64>().max(1)).min(binding(adapter) / largest.max(1))
    }
}

/// How many rays a batch may have.
pub(in crate::backend::gpu) fn rays_at_once(adapter: &AdapterReport) -> usize {
    RAYS_PER_BATCH.limit(adapter) as usize
}

/// The largest buffer that an adapter binds.
fn binding(adapter: &AdapterReport) -> u64 {
    adapter.max_binding_bytes.min(adapter.max_buffer_bytes)
}

/// Refuses what the adapter cannot bind.
pub(in crate::backend::gpu) fn fits(
    adapter: &AdapterReport,
    what: &str,
    bytes: u64,
    cure: &str,
) -> Result<()> {
    let limit = binding(adapter);
    if bytes <= limit {
        return Ok(());
    }
    let what = format!("{what} {bytes} bytes, but adapter {} binds at most {limit}", adapter.label());
    let cure = Words::from(format!("use {cure}, or ")) + Argument("backend").quote("cpu");
    Err(Issue::too_large(what).with_advice(cure).into())
}
