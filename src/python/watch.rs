//! Tells Python how far a job is, and stops it where Python raises something: Ctrl-C, or an error of the callback.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use perirobot::backend::Backend;
use perirobot::error::Issue;
use perirobot::results::manifest::Fault;
use perirobot::sweep::Watch;
use perirobot::{Error, Result};
use pyo3::prelude::*;

use crate::error::raised;

/// Why a job ends that Python stopped; the exception itself is raised instead.
const STOPPED: &str = "stopped by Python";

/// What Python is told, and what it raised.
pub(crate) struct Listener {
    /// Called with how many more choices are finished.
    progress: Option<Py<PyAny>>,
    exception: Mutex<Option<PyErr>>,
    begin: Instant,
    /// When Python was asked last, in tenths of a second since then.
    asked: AtomicU64,
}

impl Listener {
    pub(crate) fn new(progress: Option<Py<PyAny>>) -> Listener {
        let (exception, asked) = Default::default();
        Listener { progress, exception, begin: Instant::now(), asked }
    }

    /// Runs a job without the interpreter's lock. What Python raised meanwhile is the outcome, else what the job says.
    pub(crate) fn run<T: Send>(&self, py: Python<'_>, job: impl FnOnce() -> Result<T> + Send) -> PyResult<T> {
        let done = py.detach(job);
        match self.exception().take() {
            Some(exception) => Err(exception),
            None => done.map_err(|error| raised(&error)),
        }
    }

    /// A reason to stop, if Python has one. Signals reach it in its main thread only.
    pub(crate) fn stop(&self) -> Option<String> {
        self.ask(|py| py.check_signals());
        self.exception().is_some().then(|| STOPPED.into())
    }

    /// Whether Python has one, for searches that ask all the time: Python itself is asked ten times a second.
    pub(crate) fn stops_now_and_then(&self) -> bool {
        let now = self.begin.elapsed().as_millis() as u64 / 100;
        match self.asked.swap(now, Ordering::Relaxed) == now {
            true => self.exception().is_some(),
            false => self.stop().is_some(),
        }
    }

    /// Warns of a device that failed.
    pub(crate) fn tell_of(&self, Fault { what, instead, .. }: &Fault) {
        self.ask(|py| warn(py, &format!("{what}; the next poses were done by {instead}")));
    }

    /// An error if Python has a reason to stop.
    pub(crate) fn go_on(&self) -> Result<()> {
        self.stop().map_or(Ok(()), |why| Err(Error::Stopped(Issue::says(why))))
    }

    /// Asks Python, unless it has raised something already.
    fn ask(&self, question: impl FnOnce(Python<'_>) -> PyResult<()>) {
        if self.exception().is_none() {
            let answer = Python::attach(question);
            *self.exception() = answer.err();
        }
    }

    fn exception(&self) -> std::sync::MutexGuard<'_, Option<PyErr>> {
        self.exception.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

impl Watch for &Listener {
    fn runs_on(&mut self, _: &dyn Backend) {}

    fn finished(&mut self, choices: u64) {
        if let Some(progress) = &self.progress {
            self.ask(|py| progress.call1(py, (choices,)).map(drop));
        }
    }

    fn failed(&mut self, fault: &Fault) {
        self.tell_of(fault);
    }

    fn stop(&mut self) -> Option<String> {
        Listener::stop(self)
    }
}

/// Warns as Python does: once a place, and as an exception where the user wants that.
pub(crate) fn warn(py: Python<'_>, text: &str) -> PyResult<()> {
    py.import("warnings")?.call_method1("warn", (text,)).map(drop)
}
