//! A watcher that records what a sweep reports while a test runs it.

use perirobot_march::backend::Backend;
use perirobot_sweep::results::manifest::Fault;
use perirobot_sweep::sweep::Watch;

/// Keeps what it hears of faults, and never stops.
#[derive(Default)]
pub(crate) struct Onlooker {
    pub(crate) ran_on: Vec<&'static str>,
    pub(crate) finished: u64,
    pub(crate) faults: Vec<Fault>,
}

impl Watch for Onlooker {
    fn runs_on(&mut self, backend: &dyn Backend) {
        self.ran_on.push(backend.name());
    }

    fn finished(&mut self, choices: u64) {
        self.finished += choices;
    }

    fn failed(&mut self, fault: &Fault) {
        self.faults.push(fault.clone());
    }

    fn stop(&mut self) -> Option<String> {
        None
    }
}
