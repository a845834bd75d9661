//! How much work goes in one dispatch: as much as the adapter does in a fraction of a second, estimated from
//! earlier dispatches.

use std::time::Duration;

use super::kernels::Stage;

/// How long a dispatch should take: no driver's watchdog ends one before a second or two, and the cost of a
/// launch is negligible beside it.
const AT_ONCE: Duration = Duration::from_millis(250);

/// Work of an adapter's first dispatches, before any was timed; a software adapter does some ten million
/// steps of a march a second on a core.
const FIRST_WORK: u64 = 1 << 25;
/// The least and the most work of a dispatch, whatever was measured.
const LEAST_WORK: u64 = 1 << 20;
const MOST_WORK: u64 = 1 << 36;
/// Shorter measurements say more of the launch than of the work.
const SHORTEST: Duration = Duration::from_micros(200);

/// Work of one dispatch of each stage, in steps of a march.
#[derive(Clone, Debug)]
pub(super) struct Pace([u64; Stage::ALL.len()]);

impl Pace {
    /// The pace before any dispatch was timed.
    pub(super) fn new() -> Self {
        Pace([FIRST_WORK; Stage::ALL.len()])
    }

    /// The most work that a dispatch of a stage should be given.
    pub(super) fn work_at_once(&self, stage: Stage) -> u64 {
        self.0[stage as usize]
    }

    /// Takes a measurement: this work of a stage took this long. One measurement at most doubles or halves
    /// the work of a dispatch, since work is an estimate, and a single measurement may be misleading.
    pub(super) fn took(&mut self, stage: Stage, work: u64, time: Duration) {
        if time < SHORTEST {
            return;
        }
        let at_once = &mut self.0[stage as usize];
        let measured = (work as f64 / time.as_secs_f64() * AT_ONCE.as_secs_f64()) as u64;
        *at_once = measured.clamp(*at_once / 2, *at_once * 2).clamp(LEAST_WORK, MOST_WORK);
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
            self.took(stage, self.work_at_once(stage), AT_ONCE.mul_f64(slower));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_at_once_follows_what_was_measured() {
        let mut pace = Pace::new();
        // A billion steps a second: a quarter of it at once, come to by doubling.
        for _ in 0..8 {
            pace.took(Stage::Cast, 1_000_000, Duration::from_millis(1));
        }
        assert_eq!(pace.work_at_once(Stage::Cast), 250_000_000);
        assert_eq!(pace.work_at_once(Stage::CarveRays), FIRST_WORK, "each stage has its own");
        pace.took(Stage::Cast, 1_000_000, Duration::from_secs(1));
        assert_eq!(pace.work_at_once(Stage::Cast), 125_000_000, "one measurement halves at most");
        pace.took(Stage::CarveRays, 1, Duration::from_nanos(10));
        assert_eq!(pace.work_at_once(Stage::CarveRays), FIRST_WORK, "too short to say anything");
        let mut work = [0; Stage::ALL.len()];
        (work[Stage::CarveBoxes as usize], work[Stage::CarveVoxels as usize]) = (FIRST_WORK, FIRST_WORK);
        pace.all_took(&work, 3 * AT_ONCE);
        let together =
            [Stage::CarveBoxes, Stage::CarveVoxels, Stage::CarveRays].map(|stage| pace.work_at_once(stage));
        assert_eq!(
            together,
            [FIRST_WORK * 2 / 3, FIRST_WORK * 2 / 3, FIRST_WORK],
            "three times what was thought, not two"
        );
        (0..40).for_each(|_| pace.took(Stage::Cast, 0, Duration::from_secs(1)));
        assert_eq!(pace.work_at_once(Stage::Cast), LEAST_WORK);
        (0..60).for_each(|_| pace.took(Stage::Cast, u64::MAX, Duration::from_secs(1)));
        assert_eq!(pace.work_at_once(Stage::Cast), MOST_WORK);
    }
}
