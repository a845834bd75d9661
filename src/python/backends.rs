//! The backend that Python names, kept open from one call to the next.

use std::sync::{Mutex, PoisonError};

use perirobot::backend::factory::{BackendChoice, BackendKind, ChosenBackends, KeptBackends};
use perirobot::error::Issue;
use perirobot::{Error, Result};

/// What computes: which backend, on which adapter, with how many threads.
pub(crate) type BackendWords = (String, Option<String>, Option<usize>);

/// The backend that is named, and its fallbacks.
pub(crate) fn opened(words: &BackendWords) -> Result<ChosenBackends> {
    Ok(ChosenBackends::open(&choice(words)?)?.0)
}

fn choice((backend, adapter, threads): &BackendWords) -> Result<BackendChoice> {
    let kind = match backend.as_str() {
        "auto" => BackendKind::Auto,
        "cpu" => BackendKind::Cpu,
        "gpu" => BackendKind::Gpu,
        "oracle" => BackendKind::Oracle,
        _ => {
            let wanted = "must be \"auto\", \"cpu\", \"gpu\" or \"oracle\"";
            return Err(Issue::value("backend", format!("{backend:?}"), wanted).into());
        }
    };
    let adapter =
        adapter.as_ref().map(|name| name.parse().map_err(|e| Error::input("adapter", format!("{e}"))));
    Ok(BackendChoice { kind, adapter: adapter.transpose()?, threads: *threads, memory_bytes: None })
}

/// The backends that were used last, for whoever asks for the same.
#[derive(Default)]
pub(crate) struct LastBackends(Mutex<Option<(BackendWords, KeptBackends<ChosenBackends>)>>);

impl LastBackends {
    /// Does a job with the backend that is named. Where the job fails, it is not used again.
    pub(crate) fn with<T>(
        &self,
        words: &BackendWords,
        job: impl FnOnce(&mut KeptBackends<ChosenBackends>) -> Result<T>,
    ) -> Result<T> {
        let last = self.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        let mut backends = match last.filter(|(of, _)| of == words) {
            Some((_, backends)) => backends,
            None => KeptBackends::new(opened(words)?),
        };
        let done = job(&mut backends)?;
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some((words.clone(), backends));
        Ok(done)
    }
}
