//! The compiled kernels and the work given to them: dispatches are submitted, and each answer is checked for
//! whether all of them ran to their ends.

use std::ops::Range;
use std::time::{Duration, Instant};

use super::buffers::GrowingBuffer;
use super::device::{GpuDevice, Requested};
use super::kernels::{DONE_WORDS, Stage};
use super::pace::{Pace, TimedWork};
use super::pass::Pass;
use super::pipeline::Pipeline;
use super::plan::{self, Dispatch, Launched};
use super::timestamps::{TimedDispatch, Timestamps};
use super::types::Part;
use crate::Result;

/// An open adapter, its kernels, and what they were given to do.
pub(super) struct Queue {
    /// A pipeline a stage.
    pipelines: Vec<Pipeline>,
    /// `cast` once more, for plain placements; none where tiles are listed.
    plain_cast: Option<Pipeline>,
    /// Bytes from one dispatch's [`Part`] to the next.
    part_stride: u32,
    parts: GrowingBuffer,
    /// Completion counters, and what they must come to.
    done: wgpu::Buffer,
    launched: Launched,
    clock: Timestamps,
    /// How much work goes in a dispatch.
    pub(super) pace: Pace,
    /// What each stage did so far, and what it took as far as it was timed.
    pub(super) done_by: [StageDone; Stage::ALL.len()],
    /// Work submitted since the last request, a number a stage, and when the last answer came.
    work: [u64; Stage::ALL.len()],
    answered: Instant,
    /// The last field, so that the device is closed after what was made with it is gone.
    pub(super) device: GpuDevice,
}

/// What a stage did.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct StageDone {
    /// As far as it was timed.
    pub(super) took: Duration,
    /// Dispatches and their rows: placements or jobs, or parts of them.
    pub(super) dispatches: u64,
    pub(super) rows: u64,
    /// Their workgroups. Of those that the device asked for itself it tells with its answers.
    pub(super) groups: u64,
}

impl StageDone {
    fn add(&mut self, dispatch: &Dispatch) {
        self.dispatches += 1;
        self.groups += dispatch.workgroups();
        self.rows += u64::from(dispatch.groups[1].max(1));
    }
}

/// Words that are on their way, and what must have been done before they are trusted.
pub(super) struct InFlight {
    requested: Requested,
    launched: Launched,
    timed: Vec<TimedDispatch>,
    work: [u64; Stage::ALL.len()],
    asked: Instant,
}

impl Queue {
    /// Compiles the kernels from the source of each stage.
    pub(super) fn new(device: GpuDevice, source: &dyn Fn(Stage) -> String) -> Result<Self> {
        let compiled = |stage: Stage, overrides: &[(&str, f64)]| {
            Pipeline::new(&device, stage.name(), source(stage), stage.bindings(), overrides)
        };
        let lists = !device.report.software;
        let usual = |stage: Stage| match stage {
            Stage::CastTiles => compiled(stage, &[("LISTS", lists.into())]),
            _ => compiled(stage, &[]),
        };
        let pipelines = Stage::ALL.into_iter().map(usual).collect::<Result<_>>()?;
        let plain_cast = (!lists).then(|| compiled(Stage::Cast, &[("PLAIN", 1.0)])).transpose()?;
        let alignment = device.device.limits().min_uniform_buffer_offset_alignment;
        Ok(Queue {
            part_stride: alignment.max(size_of::<Part>() as u32),
            parts: GrowingBuffer::uniform("parts"),
            done: device.storage("done", u64::from(DONE_WORDS) * 4),
            launched: Launched::default(),
            clock: Timestamps::new(&device),
            pace: Pace::new(device.report.is_gpu()),
            done_by: Default::default(),
            work: Default::default(),
            answered: Instant::now(),
            pipelines,
            plain_cast,
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
        self.parts.fill(&self.device, &parts)
    }

    /// The pass of a stage over buffers: uniforms first, then storage, all but the completion counters.
    pub(super) fn pass(&self, stage: Stage, uniforms: &[&wgpu::Buffer], storage: &[&wgpu::Buffer]) -> Pass {
        self.bind(stage, &self.pipelines[stage as usize], uniforms, storage)
    }

    /// Whether `cast_tiles` lists the tiles that it leaves open.
    pub(super) fn lists(&self) -> bool {
        self.plain_cast.is_none()
    }

    /// The pass of `cast` for plain placements, if there is one, over the same buffers as for others.
    pub(super) fn plain_cast(&self, uniforms: &[&wgpu::Buffer], storage: &[&wgpu::Buffer]) -> Pass {
        let usual = &self.pipelines[Stage::Cast as usize];
        self.bind(Stage::Cast, self.plain_cast.as_ref().unwrap_or(usual), uniforms, storage)
    }

    fn bind(
        &self,
        stage: Stage,
        pipeline: &Pipeline,
        uniforms: &[&wgpu::Buffer],
        storage: &[&wgpu::Buffer],
    ) -> Pass {
        Pass::new(&self.device, stage, pipeline, &[uniforms, storage, &[&self.done]].concat())
    }

    /// Submits dispatches, each in its pass, after what the encoder holds; nothing is waited for.
    pub(super) fn run(
        &mut self,
        mut encoder: wgpu::CommandEncoder,
        dispatches: &[Dispatch],
        passes: &[Pass],
    ) {
        let mut offset = 0;
        for submission in plan::submissions(dispatches, &self.pace) {
            for dispatch in submission {
                let pass = passes.iter().find(|pass| pass.includes(dispatch));
                let pass = pass.expect("each stage of a plan has its pass");
                pass.record(&mut encoder, dispatch, offset, self.clock.stamp(dispatch));
                offset += self.part_stride;
                self.work[dispatch.stage as usize] += dispatch.work;
                self.done_by[dispatch.stage as usize].add(dispatch);
            }
            self.device.submit(encoder);
            encoder = self.device.encoder();
        }
        self.launched.add(dispatches);
    }

    /// Asks for bytes of buffers as they are after all that was submitted; nothing is waited for.
    pub(super) fn submit(&mut self, wanted: &[(&wgpu::Buffer, Range<u64>)]) -> InFlight {
        let mut encoder = self.device.encoder();
        let (timed, stamps) = self.clock.read(&mut encoder);
        let stamps = stamps.as_ref().unwrap_or(&self.done);
        let own = [(&self.done, 0..u64::from(DONE_WORDS) * 4), (stamps, 0..timed.len() as u64 * 16)];
        let clear = |encoder: &mut wgpu::CommandEncoder| encoder.clear_buffer(&self.done, 0, None);
        InFlight {
            requested: self.device.request(encoder, &[&own, wanted].concat(), clear),
            launched: std::mem::take(&mut self.launched),
            work: std::mem::take(&mut self.work),
            asked: Instant::now(),
            timed,
        }
    }

    /// Waits for what was asked for. An error if the adapter left out some of the work.
    pub(super) fn receive(&mut self, asked: InFlight) -> Result<Vec<Vec<u32>>> {
        let InFlight { requested, launched, timed, work, asked } = asked;
        let mut words = self.device.receive(requested)?;
        launched.check(&words[0]).map_err(|e| self.device.at_fault(e))?;
        for (done, &groups) in self.done_by.iter_mut().zip(&words[0][2 * Stage::ALL.len()..]) {
            done.groups += u64::from(groups);
        }
        let mut took = [TimedWork::default(); Stage::ALL.len()];
        for (TimedDispatch { stage, work }, stamps) in timed.iter().zip(words[1].chunks_exact(4)) {
            took[*stage as usize].add(*work, self.clock.time(stamps));
        }
        for (stage, took) in Stage::ALL.into_iter().zip(&took) {
            self.done_by[stage as usize].took += took.time;
            self.pace.took(stage, took);
        }
        if took.iter().all(|took| took.time.is_zero()) {
            // Without timestamps, or with a clock that stands still, only the time of the answer is known, and work begins no sooner than the
            // answer before.
            self.pace.all_took(&work, asked.max(self.answered).elapsed());
        }
        self.answered = Instant::now();
        Ok(words.split_off(2))
    }
}
