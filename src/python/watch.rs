//! Runs jobs for Python, each on threads of its own. The thread that called stays with Python: ten times a second it
//! checks for Ctrl-C, and reports how far the job is. No other thread takes the interpreter's lock, so that a job never
//! waits for it.

use std::mem;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use perirobot_decide::cheapest::purchase_progress_of;
use perirobot_decide::choose::progress_of;
use perirobot_march::Result;
use perirobot_march::progress::{Fault, Progress, PurchaseState, SearchState};
use pyo3::prelude::*;

use crate::error::to_exception;
use crate::process;

/// Why a job ends that Python stopped; what Python raised is told instead.
const STOPPED: &str = "stopped by Python";

/// Time between two looks at Python.
const BETWEEN_LOOKS: Duration = Duration::from_millis(100);

/// What Python is told of a job.
enum Event {
    /// So many things (named in the plural) are to be done, 0 where that is not known.
    Begins(&'static str, u64),
    /// So many more of them are done.
    Finished(u64),
    /// Something about it in words.
    Says(String),
    /// Something about the study or about results that its user may not expect.
    WarnsOfStudy(String),
    /// A device failed or is not used.
    WarnsOfDevice(String),
}

/// Takes what a job says, until Python is told of it, and knows whether the job is to stop.
#[derive(Default)]
pub(crate) struct Listener {
    events: Mutex<Vec<Event>>,
    is_stopped: AtomicBool,
}

/// Runs a job. What Python raises meanwhile (Ctrl-C, an error of `progress`) stops it and is the outcome, else what the
/// job says. `progress` is an object with the methods `begin`, `update` and `say`.
pub(crate) fn run<T: Send>(
    py: Python<'_>,
    progress: Option<&Py<PyAny>>,
    job: impl FnOnce(&Listener) -> Result<T> + Send,
) -> PyResult<T> {
    let listener = &Listener::default();
    let threads = process::threads().map_err(|error| to_exception(&error))?;
    let mut done = None;
    let mut told = py.detach(|| {
        threads.in_place_scope(|scope| {
            let (ending, end) = mpsc::channel::<()>();
            let done = &mut done;
            scope.spawn(move |_| {
                // Dropped when the job has ended, also where it panics.
                let _ending = ending;
                *done = Some(job(listener));
            });
            let mut told = Ok(());
            while end.recv_timeout(BETWEEN_LOOKS) == Err(RecvTimeoutError::Timeout) {
                if told.is_ok() {
                    told = Python::attach(|py| listener.tell(py, progress));
                    listener.is_stopped.store(told.is_err(), Ordering::Relaxed);
                }
            }
            told
        })
    });
    process::keep(threads);
    match &told {
        Ok(()) => told = listener.tell(py, progress),
        // Shown is how far it came; what is raised stays what it is.
        Err(_) => drop(listener.pass_on(py, progress)),
    }
    told?;
    done.expect("the job has ended").map_err(|error| to_exception(&error))
}

impl Listener {
    /// So many things (named in the plural) are to be done, 0 where that is not known.
    pub(crate) fn begins(&self, what: &'static str, of: u64) {
        self.take(Event::Begins(what, of));
    }

    /// Something about the study or about results that its user may not expect.
    pub(crate) fn warns_of_study(&self, text: String) {
        self.take(Event::WarnsOfStudy(text));
    }

    /// A device failed or is not used.
    pub(crate) fn warns_of_device(&self, text: String) {
        self.take(Event::WarnsOfDevice(text));
    }

    /// Keeps an event for Python. Of those that follow each other one is enough to tell how far a job is.
    fn take(&self, event: Event) {
        let mut events = self.events.lock().unwrap_or_else(PoisonError::into_inner);
        match (events.last_mut(), event) {
            (Some(Event::Finished(all)), Event::Finished(more)) => *all += more,
            (Some(Event::Says(last)), Event::Says(text)) => *last = text,
            (_, event) => events.push(event),
        }
    }

    /// Tells Python what there is to tell. What Python raises is the error.
    fn tell(&self, py: Python<'_>, progress: Option<&Py<PyAny>>) -> PyResult<()> {
        py.check_signals()?;
        self.pass_on(py, progress)
    }

    /// The same, whether or not somebody pressed Ctrl-C.
    fn pass_on(&self, py: Python<'_>, progress: Option<&Py<PyAny>>) -> PyResult<()> {
        let events = mem::take(&mut *self.events.lock().unwrap_or_else(PoisonError::into_inner));
        for event in events {
            match (event, progress) {
                (Event::WarnsOfStudy(text), _) => warn(py, "of_input", (text,))?,
                (Event::WarnsOfDevice(text), _) => warn(py, "of_device", (text,))?,
                (_, None) => {}
                (Event::Begins(what, of), Some(shown)) => {
                    drop(shown.call_method1(py, "begin", (what, of))?)
                }
                (Event::Finished(more), Some(shown)) => drop(shown.call_method1(py, "update", (more,))?),
                (Event::Says(text), Some(shown)) => drop(shown.call_method1(py, "say", (text,))?),
            }
        }
        Ok(())
    }
}

impl Progress for Listener {
    fn stop_reason(&self) -> Option<String> {
        self.is_stopped.load(Ordering::Relaxed).then(|| STOPPED.into())
    }

    fn advance(&self, more: u64) {
        self.take(Event::Finished(more));
    }

    fn show_fault(&self, Fault { what, instead, .. }: &Fault) {
        self.warns_of_device(format!("{what}; the next poses were done by {instead}"));
    }

    fn show_search(&self, state: &SearchState) {
        self.take(Event::Says(progress_of(state)));
    }

    fn show_purchase(&self, state: &PurchaseState) {
        self.take(Event::Says(purchase_progress_of(state)));
    }
}

/// Warns by a function of `perirobot/warned.py`. What it raises is the error: a user may want that.
pub(crate) fn warn<'py, A: pyo3::call::PyCallArgs<'py>>(
    py: Python<'py>,
    how: &str,
    words: A,
) -> PyResult<()> {
    py.import("perirobot.warned")?.call_method1(how, words).map(drop)
}
