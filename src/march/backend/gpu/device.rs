//! An open adapter: buffers in, work queued, words out, every failure as an error.

use std::ops::Range;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use super::enumerate::{enumerate, refuse_forked};
use super::kernels::most_storage_buffers;
use crate::backend::adapter::{AdapterChoice, AdapterReport, select};
use crate::backend::lost::unless_lost;
use crate::error::{Argument, Issue, Words};
use crate::{Error, Result};

/// How long a device may work on what was submitted: two batches take minutes on a slow software adapter.
/// Most drivers reset one that hangs within seconds, and say so.
const PATIENCE: Duration = Duration::from_secs(600);

/// Time within which a device must be closed.
const CLOSE_WITHIN: Duration = Duration::from_secs(10);

/// An open adapter. Failures of the driver are kept as they come and reported by the next call that can fail.
pub struct GpuDevice {
    /// What was opened; of a software adapter that is treated as a GPU, that of such a GPU.
    pub report: AdapterReport,
    /// What it is called in messages and manifests.
    pub(super) label: String,
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    failure: Arc<Mutex<Option<String>>>,
    /// How long to wait for an answer.
    pub(super) patience: Duration,
    /// Dropped last, see [`Closing`].
    _closing: Closing,
}

/// Closes a device when it is dropped, if nothing else holds the device any more: with a time limit, and not here if
/// closing panics. What was made with the device must be dropped before.
struct Closing(Option<(wgpu::Device, wgpu::Queue)>);

impl Drop for Closing {
    fn drop(&mut self) {
        let last = self.0.take();
        // The work is done or has failed already, so a failure to close the device changes nothing.
        if let Err(why) = unless_lost(CLOSE_WITHIN, move || drop(last)) {
            log::warn!("the device could not be closed: {why}");
        }
    }
}

/// Opens the chosen adapter with the limits that it really has.
pub fn open(choice: &AdapterChoice) -> Result<GpuDevice> {
    let found = enumerate();
    let reports: Vec<AdapterReport> = found.iter().map(|(report, _)| report.clone()).collect();
    let index = select(&reports, choice)?;
    refuse_forked()?;
    let (report, adapter) = &found[index];
    let needed = most_storage_buffers();
    if report.max_storage_buffers < needed {
        let what = format!("{} storage buffers a kernel, {needed} are needed", report.max_storage_buffers);
        let cure = Words::from("use ") + Argument("backend").quote("cpu");
        return Err(Error::input(format!("adapter {}", report.label()), what).with_advice(cure));
    }
    let had = adapter.limits();
    let limits = wgpu::Limits {
        max_storage_buffer_binding_size: had.max_storage_buffer_binding_size,
        max_buffer_size: had.max_buffer_size,
        ..wgpu::Limits::default().or_worse_values_from(&had)
    };
    let descriptor = wgpu::DeviceDescriptor {
        label: Some("perirobot"),
        required_limits: limits,
        required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
        // Buffers are few and mostly large, so allocating ahead would gain nothing.
        memory_hints: wgpu::MemoryHints::MemoryUsage,
        ..Default::default()
    };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
        .map_err(|e| Error::device(format!("adapter {} cannot be opened: {e}", report.label())))?;
    let failure = Arc::new(Mutex::new(None));
    let uncaptured = failure.clone();
    device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| keep(&uncaptured, error.to_string())));
    let lost = failure.clone();
    device.set_device_lost_callback(move |reason, message| {
        // Dropping a device reports its loss, too.
        if reason != wgpu::DeviceLostReason::Destroyed {
            keep(&lost, format!("device lost: {message}"));
        }
    });
    let closing = Closing(Some((device.clone(), queue.clone())));
    let (report, label) = (report.clone(), report.label());
    Ok(GpuDevice { report, label, device, queue, failure, patience: PATIENCE, _closing: closing })
}

/// Keeps the first failure: those that follow are mostly its consequences.
fn keep(failure: &Mutex<Option<String>>, message: String) {
    if let Ok(mut kept) = failure.lock() {
        kept.get_or_insert(message);
    }
}

impl GpuDevice {
    /// The same device, given the large batches and the kernels of a GPU even if it is a software adapter.
    pub fn treat_as_gpu(mut self) -> Self {
        if self.report.software {
            self.report.software = false;
            self.report.device_type = "DiscreteGpu".into();
        }
        self
    }

    /// What went wrong since the last check, if anything.
    pub(crate) fn check(&self) -> Result<()> {
        let failed = self.failure.lock().map_or(None, |mut kept| kept.take());
        failed.map_or(Ok(()), |message| Err(self.failure(message)))
    }

    /// A run-time failure of this adapter.
    pub(super) fn failure(&self, what: impl Into<Words>) -> Error {
        self.at_fault(Issue::says(what))
    }

    /// The same of what is known in more detail.
    pub(super) fn at_fault(&self, issue: Issue) -> Error {
        Error::Device(issue.with_place(format!("adapter {}", self.label)))
    }

    /// A buffer of `bytes`; at least one word, since an empty one cannot be bound.
    pub(super) fn buffer(&self, label: &str, bytes: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: bytes.max(4),
            usage,
            mapped_at_creation: false,
        })
    }

    /// A storage buffer of zeros that the host can clear, write and read.
    pub(super) fn storage(&self, label: &str, bytes: u64) -> wgpu::Buffer {
        use wgpu::BufferUsages as Usage;
        self.buffer(label, bytes, Usage::STORAGE | Usage::COPY_DST | Usage::COPY_SRC)
    }

    /// A storage buffer that holds `data`; room for one item where there is none, since a shader's array is
    /// not empty.
    pub(super) fn upload<T: bytemuck::NoUninit>(&self, label: &str, data: &[T]) -> wgpu::Buffer {
        let buffer = self.storage(label, size_of_val(data).max(size_of::<T>()) as u64);
        self.write(&buffer, 0, data);
        buffer
    }

    /// Writes `data` to a buffer, after all that was submitted before.
    pub(super) fn write<T: bytemuck::NoUninit>(&self, buffer: &wgpu::Buffer, offset: u64, data: &[T]) {
        self.queue.write_buffer(buffer, offset, bytemuck::cast_slice(data));
    }

    pub(super) fn encoder(&self) -> wgpu::CommandEncoder {
        self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: None })
    }

    pub(super) fn submit(&self, encoder: wgpu::CommandEncoder) -> wgpu::SubmissionIndex {
        self.queue.submit([encoder.finish()])
    }

    /// Asks for bytes of buffers, a whole number of words of each, as they are after what the
    /// encoder holds; nothing is waited for. `then` adds what is to be done after that.
    pub(super) fn request(
        &self,
        mut encoder: wgpu::CommandEncoder,
        wanted: &[(&wgpu::Buffer, Range<u64>)],
        then: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Requested {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let bytes: Vec<u64> = wanted.iter().map(|(_, range)| range.end - range.start).collect();
        let staging = self.buffer("staging", bytes.iter().sum(), usage);
        let mut offset = 0;
        for ((buffer, range), &bytes) in wanted.iter().zip(&bytes).filter(|&(_, &bytes)| bytes > 0) {
            encoder.copy_buffer_to_buffer(buffer, range.start, &staging, offset, bytes);
            offset += bytes;
        }
        then(&mut encoder);
        let submission = self.submit(encoder);
        // A failed map leaves a range that cannot be read: reported when it is received.
        staging.map_async(wgpu::MapMode::Read, .., |_| {});
        Requested { staging, bytes, submission }
    }

    /// Waits for what was asked for: the words of each buffer.
    pub(super) fn receive(&self, requested: Requested) -> Result<Vec<Vec<u32>>> {
        let Requested { staging, bytes, submission } = requested;
        self.wait_until(Some(submission))?;
        let view = staging.get_mapped_range(..).map_err(|e| self.failure(e.to_string()))?;
        let mut rest = &view[..];
        let words = bytes.iter().map(|&bytes| {
            let (first, others) = rest.split_at(bytes as usize);
            rest = others;
            bytemuck::pod_collect_to_vec(first)
        });
        Ok(words.collect())
    }

    /// Waits until the queue is empty.
    pub(super) fn wait(&self) -> Result<()> {
        self.wait_until(None)
    }

    /// Waits for a submission, or for all of them, no longer than the limit.
    fn wait_until(&self, submission_index: Option<wgpu::SubmissionIndex>) -> Result<()> {
        let (device, timeout) = (self.device.clone(), Some(self.patience));
        let poll = move || device.poll(wgpu::PollType::Wait { submission_index, timeout });
        let polled = unless_lost(Duration::MAX, poll);
        self.check()?;
        match polled {
            Ok(Ok(_)) => Ok(()),
            Ok(Err(wgpu::PollError::Timeout)) => {
                Err(self.failure(format!("no answer in {:?}", self.patience)))
            }
            Ok(Err(error)) => Err(self.failure(error.to_string())),
            Err(why) => Err(self.failure(why)),
        }
    }
}

/// Words that are on their way to the host.
pub(super) struct Requested {
    staging: wgpu::Buffer,
    bytes: Vec<u64>,
    submission: wgpu::SubmissionIndex,
}
