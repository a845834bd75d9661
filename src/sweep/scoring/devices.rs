//! Several devices that share a job: each takes a part of the choices that are left, until none is.
//!
//! # Theory
//! Counts do not depend on which device counts, nor rows on their order, so any way of sharing gives the same rows.
//!
//! # Practice
//! A device that asks for work gets a share of what is left, the less the more devices there are: devices that are not
//! equally fast end at about the same time, and each makes a world ready only a few times.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread::ScopedJoinHandle;

use super::failover::{Failover, Resumable, TaskChoices, Timings};
use crate::results::PoseChoice;
use perirobot_march::Result;
use perirobot_march::backend::StageTiming;
use perirobot_march::backend::factory::{BackendFactory, KeptBackends};
use perirobot_march::error::catch_panic;

/// Fewer choices are not worth the preparation of a world, unless a device would otherwise have no work.
const LEAST_CHOICES: usize = 64;

/// The remaining choices of a job.
pub(super) struct Parts<'a> {
    left: Mutex<Option<&'a [PoseChoice]>>,
    devices: usize,
    /// The least choices of a part.
    least: usize,
    halted: AtomicBool,
}

impl<'a> Parts<'a> {
    /// All choices of a job, for this number of devices.
    pub(super) fn new(pose_choices: &'a [PoseChoice], devices: usize) -> Parts<'a> {
        let least = LEAST_CHOICES.min(pose_choices.len().div_ceil(devices.max(1)));
        Parts { left: Mutex::new(Some(pose_choices)), devices, least, halted: AtomicBool::new(false) }
    }

    /// The next part; a single device gets all.
    fn next(&self) -> Option<&'a [PoseChoice]> {
        if self.is_halted() {
            return None;
        }
        let mut left = self.left.lock().unwrap_or_else(PoisonError::into_inner);
        let all = left.take()?;
        let share = all.len().div_ceil(2 * self.devices).max(self.least);
        if self.devices == 1 || all.len() <= share {
            return Some(all);
        }
        let (part, others) = all.split_at(share);
        *left = Some(others);
        Some(part)
    }

    /// Stops all devices from starting more work: the job has failed.
    pub(super) fn halt(&self) {
        self.halted.store(true, Ordering::Relaxed);
    }

    /// Whether no more work may start.
    pub(super) fn is_halted(&self) -> bool {
        self.halted.load(Ordering::Relaxed)
    }

    /// Lets a device do part after part. Returns the stage times of its last backend; after a failure the others start
    /// no more work.
    pub(super) fn work(
        &self,
        failover: &mut Failover,
        choices: TaskChoices,
        task: &mut dyn Resumable,
    ) -> Result<Timings> {
        let mut work = || {
            let (mut timings, mut backend) = (Timings::new(), Some(failover.open()?));
            while let Some(pose_choices) = self.next() {
                let backend = backend.take().map_or_else(|| failover.open(), Ok)?;
                timings = failover.work(TaskChoices { pose_choices, ..choices }, backend, task)?;
                if task.is_stopped() {
                    break;
                }
            }
            // Rows of an earlier run are checked even if no other work is left.
            if backend.is_some() { failover.check(task).map(|()| timings) } else { Ok(timings) }
        };
        work().inspect_err(|_| self.halt())
    }
}

/// The devices of a user's choice, each of which stays open between parts.
pub(super) fn devices(backends: &mut dyn BackendFactory) -> Vec<KeptBackends<&mut dyn BackendFactory>> {
    let all = match backends.each_device().len() {
        0 => vec![backends],
        _ => backends.each_device(),
    };
    all.into_iter().map(KeptBackends::new).collect()
}

/// Runs work on each of several devices in parallel: returns the results in their order, or the first error.
pub(super) fn on_each<D: Send, T: Send>(
    mut devices: Vec<D>,
    parts: &Parts,
    work: impl Fn(D) -> Result<T> + Sync,
) -> Result<Vec<T>> {
    let work = |device: D| catch_panic(|| work(device)).inspect_err(|_| parts.halt());
    if devices.len() == 1 {
        return devices.drain(..).map(work).collect();
    }
    std::thread::scope(|threads| {
        let work = &work;
        let all: Vec<_> = devices.into_iter().map(|device| threads.spawn(move || work(device))).collect();
        let join = |device: ScopedJoinHandle<Result<T>>| {
            device.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        };
        all.into_iter().map(join).collect::<Vec<_>>().into_iter().collect()
    })
}

/// The sums of all devices' stage times, in stage order.
pub(super) fn add_timings(all: impl IntoIterator<Item = Timings>) -> Timings {
    let mut sums = Timings::new();
    for StageTiming { stage, took, dispatches, rows, lanes } in all.into_iter().flatten() {
        match sums.iter_mut().find(|sum| sum.stage == stage) {
            Some(sum) => {
                sum.took += took;
                sum.dispatches += dispatches;
                sum.rows += rows;
                sum.lanes += lanes;
            }
            None => sums.push(StageTiming { stage, took, dispatches, rows, lanes }),
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sizes of the parts of a job, as devices take them.
    fn sizes(choices: usize, devices: usize) -> Vec<usize> {
        let all: Vec<_> = (0..choices).map(|choice| PoseChoice { combination: 0, choice }).collect();
        let parts = Parts::new(&all, devices);
        let taken: Vec<&[PoseChoice]> = std::iter::from_fn(|| parts.next()).collect();
        assert_eq!(taken.concat(), all, "each choice once, in order");
        taken.iter().map(|part| part.len()).collect()
    }

    #[test]
    fn parts_get_smaller_and_a_device_alone_takes_all() {
        assert_eq!(sizes(1000, 1), [1000]);
        assert_eq!(sizes(1000, 2), [250, 188, 141, 106, 79, 64, 64, 64, 44]);
        assert_eq!(sizes(130, 8), [17, 17, 17, 17, 17, 17, 17, 11], "each device has work");
        assert_eq!(sizes(10, 2), [5, 5]);
        assert_eq!(sizes(1, 2), [1]);
        assert_eq!(sizes(0, 2), [0]);
    }

    #[test]
    fn nothing_is_begun_once_the_job_has_failed() {
        let all = [PoseChoice { combination: 0, choice: 0 }; 500];
        let parts = Parts::new(&all, 2);
        assert!(parts.next().is_some() && !parts.is_halted());
        parts.halt();
        assert!(parts.next().is_none() && parts.is_halted());
    }
}
