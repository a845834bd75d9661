//! The backend that Python names, kept open from one call to the next.

use std::sync::{Mutex, PoisonError};

use perirobot_march::Result;
use perirobot_march::backend::adapter::AdapterChoice;
use perirobot_march::backend::factory::{BackendChoice, BackendKind, ChosenBackends, KeptBackends};
use perirobot_march::error::Issue;
use pyo3::Python;

use crate::process::OfProcess;
use crate::watch::Listener;

/// Most threads, as on the command line.
const MOST_THREADS: i64 = 1024;

/// What computes: which backend, on which adapter, with how many threads.
pub(crate) type BackendWords = (String, Option<String>, Option<i64>);

/// The backend that is named, and its fallbacks; a warning if that is not the GPU that is there.
pub(crate) fn open(words: &BackendWords, listener: &Listener) -> Result<ChosenBackends> {
    open_choice(&choice(words)?.for_one_device()?, listener)
}

/// The same for a sweep, which several GPUs may share.
pub(crate) fn open_all(words: &BackendWords, listener: &Listener) -> Result<ChosenBackends> {
    open_choice(&choice(words)?, listener)
}

fn open_choice(choice: &BackendChoice, listener: &Listener) -> Result<ChosenBackends> {
    let (backends, unused) = ChosenBackends::open(choice)?;
    if let Some(reason) = unused {
        listener.warns_of_device(format!("{reason}; using the CPU instead"));
    }
    Ok(backends)
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
    if adapter.is_some() && matches!(kind, BackendKind::Cpu | BackendKind::Oracle) {
        return Err(Issue::says("adapter belongs to backend=\"gpu\" (or \"auto\")").into());
    }
    let adapters = adapter.as_ref().map(|names| AdapterChoice::parse_list(names)).transpose()?;
    let mut adapters = adapters.into_iter().flatten();
    if let Some(threads) = threads.filter(|threads| !(1..=MOST_THREADS).contains(threads)) {
        let wanted = format!("must be from 1 to {MOST_THREADS}");
        return Err(Issue::value("threads", threads.to_string(), wanted).into());
    }
    let threads = threads.map(|threads| threads as usize);
    let (adapter, others) = (adapters.next(), adapters.collect());
    Ok(BackendChoice { kind, adapter, others, threads, ..BackendChoice::default() })
}

/// The backends of a study that were used last.
#[derive(Default)]
pub(crate) struct LastBackends(Mutex<Option<OfProcess<OpenBackends>>>);

/// Backends that are open, with the words by which they were opened; none at first.
#[derive(Default)]
pub(crate) struct OpenBackends(Option<(BackendWords, KeptBackends<ChosenBackends>)>);

impl LastBackends {
    /// Takes them for a job; none in a child that was forked. The caller holds the interpreter's lock, as in
    /// [`LastBackends::put`], so that a process is not forked while this is locked.
    pub(crate) fn take(&self) -> OpenBackends {
        let last = self.0.lock().unwrap_or_else(PoisonError::into_inner).take();
        last.and_then(OfProcess::take).unwrap_or_default()
    }

    /// Keeps those of a job that did well.
    pub(crate) fn put(&self, py: Python<'_>, backends: OpenBackends) {
        let before = self.0.lock().unwrap_or_else(PoisonError::into_inner).replace(OfProcess::new(backends));
        // Those of another thread; closing them may take long.
        py.detach(|| drop(before));
    }
}

impl OpenBackends {
    /// Does a job with the backend that is named, which is opened unless it is open.
    pub(crate) fn use_backend<T>(
        self,
        words: BackendWords,
        listener: &Listener,
        job: impl FnOnce(&mut KeptBackends<ChosenBackends>) -> Result<T>,
    ) -> Result<(T, OpenBackends)> {
        let mut backends = match self.0.filter(|(of, _)| *of == words) {
            Some((_, backends)) => backends,
            None => KeptBackends::new(open(&words, listener)?),
        };
        let done = job(&mut backends)?;
        Ok((done, OpenBackends(Some((words, backends)))))
    }
}
