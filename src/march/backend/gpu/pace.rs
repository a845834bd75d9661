//! How much work goes in one dispatch: as much as the adapter does in a fraction of a second, estimated from
//! earlier dispatches.

use std::time::Duration;

use super::kernels::Stage;

/// How long a dispatch should take: no driver's watchdog ends one before a second or two, and the cost of a
/// launch is negligible beside it.
const AT_ONCE: Duration = Duration::from_millis(250);

/// Work of the first dispatches, before any was timed. A software adapter does some ten million steps of a march a second on
/// a core. On a GPU it is that of some ten cameras: less than a millisecond on a large one, a tenth of a second on one a
/// hundred times slower.
const FIRST_WORK: ByAdapter = ByAdapter { other: 1 << 25, gpu: 1 << 29 };
/// The least and the most work of a dispatch, whatever was measured.
const LEAST_WORK: u64 = 1 << 20;
const MOST_WORK: u64 = 1 << 36;
/// Shorter measurements say no more than that more can go at once.
const SHORTEST: Duration = Duration::from_micros(200);
/// An answer makes the work of a dispatch at most so many times more or less: work is an estimate, and a single measurement
/// may be misleading.
const MOST_CHANGE: u64 = 4;
/// Most items of a dispatch, however little they cost.
const MOST_ITEMS: ByAdapter = ByAdapter { other: 1 << 21, gpu: 1 << 26 };

/// A number for GPUs, and one for adapters that are, or may be, software.
struct ByAdapter {
    gpu: u64,
    other: u64,
}

/// What dispatches of a stage took that were answered together.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct TimedWork {
    /// Their work, in steps of a march; that of the largest of them.
    pub(super) work: u64,
    pub(super) largest: u64,
    pub(super) time: Duration,
    pub(super) dispatches: u32,
}

impl TimedWork {
    /// Adds a dispatch.
    pub(super) fn add(&mut self, work: u64, time: Duration) {
        self.work += work;
        self.largest = self.largest.max(work);
        self.time += time;
        self.dispatches += 1;
    }
}

/// Work of one dispatch of each stage, in steps of a march.
#[derive(Clone, Debug)]
pub(super) struct Pace {
    at_once: [u64; Stage::ALL.len()],
    most_items: u64,
}

impl ByAdapter {
    fn of(&self, is_gpu: bool) -> u64 {
        if is_gpu { self.gpu } else { self.other }
    }
}

impl Pace {
    /// The pace before any dispatch was timed.
    pub(super) fn new(is_gpu: bool) -> Self {
        let at_once = [FIRST_WORK.of(is_gpu); Stage::ALL.len()];
        Pace { at_once, most_items: MOST_ITEMS.of(is_gpu) }
    }

    /// The most work that a dispatch of a stage should be given.
    pub(super) fn work_at_once(&self, stage: Stage) -> u64 {
        self.at_once[stage as usize]
    }

    /// The most items that a dispatch is given.
    pub(super) fn most_items(&self) -> u64 {
        self.most_items
    }

    /// Takes what dispatches of a stage took that were answered together. If they were too short to tell more, the work of a
    /// dispatch grows if one of them was about as large as it may be.
    pub(super) fn took(&mut self, stage: Stage, timed: &TimedWork) {
        if timed.time.is_zero() {
            return;
        }
        let at_once = &mut self.at_once[stage as usize];
        let [least, most] = [*at_once / MOST_CHANGE, *at_once * MOST_CHANGE];
        let next = if timed.time < SHORTEST * timed.dispatches {
            if timed.largest < *at_once / 2 {
                return;
            }
            most
        } else {
            (timed.work as f64 / timed.time.as_secs_f64() * AT_ONCE.as_secs_f64()) as u64
        };
        *at_once = next.clamp(least, most).clamp(LEAST_WORK, MOST_WORK);
    }

    /// Takes a measurement of all stages together: this work of each took this long in all. Each stage is
    /// taken to be off by the same factor as the sum.
    pub(super) fn all_took(&mut self, work: &[u64; Stage::ALL.len()], time: Duration) {
        let share = |stage: Stage| work[stage as usize] as f64 / self.work_at_once(stage) as f64;
        let thought = AT_ONCE.mul_f64(Stage::ALL.iter().map(|&stage| share(stage)).sum());
        if thought < SHORTEST {
            return;
        }
        let slower = time.as_secs_f64() / thought.as_secs_f64();
        for stage in Stage::ALL.into_iter().filter(|&stage| work[stage as usize] > 0) {
            let mut timed = TimedWork::default();
            timed.add(self.work_at_once(stage), AT_ONCE.mul_f64(slower));
            self.took(stage, &timed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn timed(work: u64, time: Duration) -> TimedWork {
        let mut timed = TimedWork::default();
        timed.add(work, time);
        timed
    }

    /// What a camera costs in `cast`.
    const CAMERA: u64 = 921_600 * 40;

    /// Answers of imagined devices: each gets batches of 64 cameras, cut as the pace says, and takes so long for a launch and
    /// for a camera. How many cameras a dispatch has after some answers.
    fn cameras_after(answers: u32, is_gpu: bool, launch_us: u64, camera_us: u64) -> u64 {
        let mut pace = Pace::new(is_gpu);
        for _ in 0..answers {
            let mut timed = TimedWork::default();
            let mut left = 64 * CAMERA;
            while left > 0 {
                let work = left.min(pace.work_at_once(Stage::Cast));
                let us = launch_us + camera_us * work / CAMERA;
                timed.add(work, Duration::from_micros(us));
                left -= work;
            }
            pace.took(Stage::Cast, &timed);
        }
        pace.work_at_once(Stage::Cast) / CAMERA
    }

    #[test]
    fn dispatches_grow_on_a_quick_device_though_each_is_short() {
        assert!(cameras_after(3, true, 30, 15) >= 64);
        assert!(cameras_after(4, false, 30, 15) >= 64, "from less than one camera");
    }

    #[test]
    fn dispatches_take_a_quarter_of_a_second_on_a_slow_device() {
        let cameras = cameras_after(3, true, 3000, 1500);
        assert!((100..170).contains(&cameras), "{cameras}");
        // A tenth of a second a camera, as on two cores.
        assert_eq!(cameras_after(3, false, 100, 100_000), 2);
        assert_eq!(cameras_after(3, true, 100, 100_000), 2);
    }

    #[test]
    fn dispatches_shrink_at_once_on_a_device_that_stalls() {
        let mut pace = Pace::new(true);
        (0..9).for_each(|_| pace.took(Stage::Cast, &timed(MOST_WORK, Duration::from_millis(1))));
        assert_eq!(pace.work_at_once(Stage::Cast), MOST_WORK);
        pace.took(Stage::Cast, &timed(MOST_WORK, Duration::from_secs(4)));
        assert_eq!(pace.work_at_once(Stage::Cast), MOST_WORK / MOST_CHANGE);
    }

    #[test]
    fn work_at_once_follows_what_was_measured() {
        let mut pace = Pace::new(false);
        let first = FIRST_WORK.other;
        // A billion steps a second: a quarter of it at once, come to step by step.
        for _ in 0..8 {
            pace.took(Stage::Cast, &timed(1_000_000, Duration::from_millis(1)));
        }
        assert_eq!(pace.work_at_once(Stage::Cast), 250_000_000);
        assert_eq!(pace.work_at_once(Stage::CarveRays), first, "each stage has its own");
        pace.took(Stage::Cast, &timed(1_000_000, Duration::from_secs(1)));
        assert_eq!(pace.work_at_once(Stage::Cast), 62_500_000, "one answer makes it a quarter at least");
        pace.took(Stage::CarveRays, &timed(1, Duration::from_nanos(10)));
        assert_eq!(
            pace.work_at_once(Stage::CarveRays),
            first,
            "a short dispatch with little work says nothing"
        );
        for untimed in [TimedWork::default(), timed(first, Duration::ZERO)] {
            pace.took(Stage::CarveRays, &untimed);
            assert_eq!(
                pace.work_at_once(Stage::CarveRays),
                first,
                "nothing was timed, or by a clock that stands still"
            );
        }
        let mut work = [0; Stage::ALL.len()];
        (work[Stage::CarveBoxes as usize], work[Stage::CarveVoxels as usize]) = (first, first);
        pace.all_took(&work, 3 * AT_ONCE);
        let together =
            [Stage::CarveBoxes, Stage::CarveVoxels, Stage::CarveRays].map(|stage| pace.work_at_once(stage));
        assert_eq!(together, [first * 2 / 3, first * 2 / 3, first], "three times what was thought, not two");
        (0..40).for_each(|_| pace.took(Stage::Cast, &timed(0, Duration::from_secs(1))));
        assert_eq!(pace.work_at_once(Stage::Cast), LEAST_WORK);
        (0..60).for_each(|_| pace.took(Stage::Cast, &timed(u64::MAX, Duration::from_secs(1))));
        assert_eq!(pace.work_at_once(Stage::Cast), MOST_WORK);
    }
}
