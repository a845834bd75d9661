//! Follows a job for the command line: shows its progress on standard error, and stops it on a signal or at
//! `--max-time`.

use std::collections::HashSet;
use std::sync::{Mutex, PoisonError};

use perirobot_march::backend::Backend;
use perirobot_march::progress::{Fault, Progress, PurchaseState, SearchState};

use super::progress::{JobProgress, SearchProgress, suspend_bar};
use super::stop::StopAt;

/// The kind of progress shown.
pub(super) enum Shown {
    /// The finished part of a job.
    Job(JobProgress),
    /// The results of a search.
    Search(SearchProgress),
    /// Nothing.
    Nothing,
}

/// Shows a job, and stops it if it can be stopped.
pub(super) struct Onlooker<'a> {
    shown: Mutex<Shown>,
    stop: Option<&'a StopAt>,
    /// Devices to print, each once until one fails; `None` prints no devices.
    named: Mutex<Option<HashSet<String>>>,
}

impl<'a> Onlooker<'a> {
    pub(super) fn new(shown: Shown, stop: Option<&'a StopAt>, names_backend: bool) -> Onlooker<'a> {
        Onlooker { shown: Mutex::new(shown), stop, named: Mutex::new(names_backend.then(HashSet::new)) }
    }

    /// To be called when the job has ended, finished or not.
    pub(super) fn finish(self) {
        drop(self);
    }

    fn with_shown<T>(&self, act: impl FnOnce(&mut Shown) -> T) -> T {
        act(&mut self.shown.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Progress for Onlooker<'_> {
    fn stop_reason(&self) -> Option<String> {
        self.stop?.reason()
    }

    fn advance(&self, more: u64) {
        self.with_shown(|shown| {
            if let Shown::Job(job) = shown {
                job.inc(more);
            }
        });
    }

    fn show_backend(&self, backend: &dyn Backend) {
        let mut named = self.named.lock().unwrap_or_else(PoisonError::into_inner);
        if named.as_mut().is_some_and(|named| named.insert(backend.device())) {
            suspend_bar(|| say!("running on {}: {}", backend.name(), backend.device()));
        }
    }

    fn show_fault(&self, Fault { what, scene, instead }: &Fault) {
        *self.named.lock().unwrap_or_else(PoisonError::into_inner) = Some(HashSet::new());
        let scene = if scene.is_empty() { String::new() } else { format!("scene {scene}: ") };
        let things = self.with_shown(|shown| match shown {
            Shown::Job(job) => job.what,
            _ => "poses",
        });
        suspend_bar(|| say!("warning: {scene}{what}; the next {things} were done by {instead}"));
    }

    fn show_search(&self, state: &SearchState) {
        self.with_shown(|shown| {
            if let Shown::Search(search) = shown {
                search.show(state);
            }
        });
    }

    fn show_purchase(&self, state: &PurchaseState) {
        self.with_shown(|shown| {
            if let Shown::Search(search) = shown {
                search.show_purchase(state);
            }
        });
    }
}
