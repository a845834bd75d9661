//! A watcher that records what a sweep reports while a test runs it.

use std::sync::Mutex;

use perirobot_march::backend::Backend;
use perirobot_march::progress::{Fault, Progress};

/// What an [`Onlooker`] heard.
#[derive(Clone, Default)]
pub(crate) struct Heard {
    pub(crate) ran_on: Vec<&'static str>,
    pub(crate) finished: u64,
    pub(crate) faults: Vec<Fault>,
}

/// Keeps what it hears, and never stops.
#[derive(Default)]
pub(crate) struct Onlooker(Mutex<Heard>);

impl Onlooker {
    /// What it heard.
    pub(crate) fn heard(&self) -> Heard {
        self.0.lock().unwrap().clone()
    }
}

impl Progress for Onlooker {
    fn stop_reason(&self) -> Option<String> {
        None
    }

    fn advance(&self, more: u64) {
        self.0.lock().unwrap().finished += more;
    }

    fn show_backend(&self, backend: &dyn Backend) {
        self.0.lock().unwrap().ran_on.push(backend.name());
    }

    fn show_fault(&self, fault: &Fault) {
        self.0.lock().unwrap().faults.push(fault.clone());
    }
}
