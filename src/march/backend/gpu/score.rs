//! Fuses and counts: requests are queued on the device and answered later, so that it works on one while the
//! host prepares the next.

use super::kernels::Stage;
use super::loop_bounds::MOST_READINGS;
use super::queue::{InFlight, Queue};
use super::types::{JobWords, REGION_COUNTERS};
use super::{Gpu, no_scene, plan};
use crate::Result;
use crate::backend::body_words::BodyWords;
use crate::backend::{Fusion, Reading};
use crate::error::{Argument, Issue, Words};
use crate::metrics::{COUNTERS, Confusion, Detection, Overlap};

/// Counts that are on their way.
pub(super) struct PendingCounts {
    /// Each batch of jobs.
    batches: Vec<InFlight>,
    jobs: usize,
    regions: usize,
}

impl PendingCounts {
    /// Waits for the counts of each job in each region.
    pub(super) fn answer(self, queue: &mut Queue, body_words: &BodyWords) -> Result<Vec<Vec<Confusion>>> {
        let PendingCounts { batches, jobs, regions } = self;
        if regions == 0 {
            return Ok(vec![vec![]; jobs]);
        }
        let mut counts = Vec::with_capacity(jobs);
        for batch in batches {
            let words = queue.receive(batch)?;
            let of_jobs = words[0].chunks_exact(regions * REGION_COUNTERS);
            let of_jobs = of_jobs.zip(words[1].chunks_exact(body_words.counters()));
            counts.extend(of_jobs.map(|(counts, found)| {
                let of_regions = counts.chunks_exact(REGION_COUNTERS).zip(body_words.detections(found));
                of_regions.map(|(counts, found)| confusion(counts, found)).collect()
            }));
        }
        Ok(counts)
    }
}

/// What `shaders/count.wgsl` counted in a region, and what `shaders/detect.wgsl` found there: who is detected, and how many
/// of people's voxels are hit twice.
fn confusion(counts: &[u32], (detection, hit_human_twice): (Detection, u64)) -> Confusion {
    let labels = Confusion::from_counts(std::array::from_fn(|i| counts[i].into()));
    let twice = counts[COUNTERS].into();
    labels.with_detection(detection).with_overlap(Overlap { twice, hit_human_twice })
}

impl Gpu {
    /// Submits all work of a request.
    pub(super) fn question(&mut self, fusion: Fusion, jobs: &[Vec<Reading>]) -> Result<PendingCounts> {
        let loaded = self.loaded.as_ref().ok_or_else(no_scene)?;
        let regions = loaded.sizes.regions();
        let at_once = loaded.sizes.jobs_at_once(&self.queue.device.report);
        let batches = if regions == 0 { &[] } else { jobs };
        let batches =
            batches.chunks(at_once).map(|batch| self.submit_batch(fusion, batch)).collect::<Result<_>>()?;
        Ok(PendingCounts { batches, jobs: jobs.len(), regions })
    }

    /// Fuses and counts a batch of jobs.
    fn submit_batch(&mut self, fusion: Fusion, jobs: &[Vec<Reading>]) -> Result<InFlight> {
        let Gpu { queue, room, loaded, .. } = self;
        let loaded = loaded.as_ref().ok_or_else(no_scene)?;
        let mut readings = Vec::new();
        let mut words = Vec::with_capacity(jobs.len());
        for job in jobs {
            if job.len() > MOST_READINGS as usize {
                let cure = Words::from(format!(
                    "a GPU fuses at most {MOST_READINGS}, use smaller combinations, or "
                )) + Argument("backend").quote("cpu");
                let what = format!("a choice of {} readings", job.len());
                return Err(Issue::too_large(what).with_advice(cure).into());
            }
            let first = readings.len() as u32;
            for reading in job {
                readings.push(loaded.reading(reading)?);
            }
            words.push(JobWords::new(fusion, first..readings.len() as u32));
        }
        let bytes = size_of_val(readings.as_slice()) as u64;
        plan::fits(&queue.device.report, "the readings of a batch take", bytes, "smaller combinations")?;
        let device = &queue.device;
        let (words, readings) = (room.jobs.fill(device, &words), room.readings.fill(device, &readings));
        let planes = jobs.len() as u64 * loaded.sizes.plane_bytes();
        let labels = room.labels.hold(device, 2 * planes);
        let twice = room.twice.hold(device, planes);
        let bytes = (jobs.len() * loaded.regions.len() * REGION_COUNTERS * 4) as u64;
        let counts = room.counts.hold(device, bytes);
        let mut encoder = device.encoder();
        encoder.clear_buffer(&counts, 0, Some(bytes));
        let found_bytes = jobs.len() as u64 * loaded.sizes.found_bytes();
        let found = room.found.hold(device, found_bytes);
        encoder.clear_buffer(&found, 0, Some(found_bytes));

        let most = jobs.iter().map(Vec::len).max().unwrap_or(0);
        let dispatches = loaded.sizes.scoring(jobs.len() as u32, most, &queue.pace);
        let parts = queue.parts(&dispatches);
        let uniforms = [&loaded.setup, &parts];
        let storage = [&words, &readings, &loaded.ended, &loaded.free, &labels, &twice];
        let mut passes = vec![queue.pass(Stage::Fuse, &uniforms, &storage)];
        passes.extend(loaded.regions.iter().zip(0..).map(|(region, number)| {
            let storage = [&loaded.truth, &loaded.human, &loaded.robot, region, &labels, &twice, &counts];
            queue.pass(Stage::Count, &uniforms, &storage).with_region(number)
        }));
        let storage = [&words, &readings, &loaded.body, &loaded.ended, &found];
        passes.push(queue.pass(Stage::Detect, &uniforms, &storage));
        queue.run(encoder, &dispatches, &passes);
        Ok(queue.submit(&[(&counts, 0..bytes), (&found, 0..found_bytes)]))
    }
}
