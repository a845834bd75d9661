//! How long dispatches take, from timestamps that the adapter writes between them; nothing where it has none.

use std::time::Duration;

use super::device::GpuDevice;
use super::kernels::Stage;
use super::plan::Dispatch;

/// Timestamps between two readings; dispatches beyond are not timed.
const STAMPS: u32 = wgpu::QUERY_SET_MAX_QUERIES;

/// Timestamps of the dispatches since the last reading.
pub(super) struct Timestamps {
    stamps: Option<Stamps>,
    timed: Vec<TimedDispatch>,
}

struct Stamps {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    ns_a_tick: f64,
}

/// A dispatch whose timestamps are on their way.
#[derive(Clone, Copy, Debug)]
pub(super) struct TimedDispatch {
    pub(super) stage: Stage,
    pub(super) work: u64,
}

impl Timestamps {
    /// A clock, or none if the adapter cannot write timestamps.
    pub(super) fn new(device: &GpuDevice) -> Self {
        let stamps = device.device.features().contains(wgpu::Features::TIMESTAMP_QUERY).then(|| {
            use wgpu::BufferUsages as Usage;
            let set = device.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("stamps"),
                ty: wgpu::QueryType::Timestamp,
                count: STAMPS,
            });
            let resolved =
                device.buffer("stamps", u64::from(STAMPS) * 8, Usage::QUERY_RESOLVE | Usage::COPY_SRC);
            Stamps { set, resolved, ns_a_tick: f64::from(device.queue.get_timestamp_period()) }
        });
        Timestamps { stamps, timed: Vec::new() }
    }

    /// The timestamps of the next dispatch, if it is timed.
    pub(super) fn stamp(&mut self, dispatch: &Dispatch) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let stamps = self.stamps.as_ref()?;
        let first = 2 * self.timed.len() as u32;
        if first + 2 > STAMPS {
            return None;
        }
        self.timed.push(TimedDispatch { stage: dispatch.stage, work: dispatch.work });
        Some(wgpu::ComputePassTimestampWrites {
            query_set: &stamps.set,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        })
    }

    /// Makes the timestamps so far ready to be read, and starts anew: what was timed, and the buffer that
    /// will hold its timestamps, two a dispatch.
    pub(super) fn read(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
    ) -> (Vec<TimedDispatch>, Option<wgpu::Buffer>) {
        let timed = std::mem::take(&mut self.timed);
        let resolved = self.stamps.as_ref().filter(|_| !timed.is_empty()).map(|stamps| {
            encoder.resolve_query_set(&stamps.set, 0..2 * timed.len() as u32, &stamps.resolved, 0);
            stamps.resolved.clone()
        });
        (timed, resolved)
    }

    /// How long a dispatch took, from its two timestamps as pairs of words.
    pub(super) fn time(&self, words: &[u32]) -> Duration {
        let stamp = |i: usize| u64::from(words[2 * i]) | u64::from(words[2 * i + 1]) << 32;
        let ticks = stamp(1).saturating_sub(stamp(0)) as f64;
        Duration::from_nanos((ticks * self.stamps.as_ref().map_or(0.0, |stamps| stamps.ns_a_tick)) as u64)
    }
}
