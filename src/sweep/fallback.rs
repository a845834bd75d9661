//! Work that another backend takes over where a device fails.

use super::evidence::BatchSize;
use super::worker::fault_words;
use crate::backend::Backend;
use crate::backend::factory::{BackendFactory, Fallback};
use crate::backend::lost::close;
use crate::error::catch_panic;
use crate::results::manifest::Fault;
use crate::{Error, Result};

/// Work that knows what of it is done, so that it can be begun again.
pub(super) trait Resumable {
    /// Does what is left.
    fn work(&mut self, batch: BatchSize, backend: &mut dyn Backend) -> Result<()>;

    /// This backend begins.
    fn runs_on(&mut self, backend: &dyn Backend);

    /// A device failed; another backend goes on.
    fn failed(&mut self, fault: &Fault);
}

/// Works with the backend of a user's choice. Of a device that fails what is left is done in small batches, and if it
/// fails at those too, by the CPU.
pub(super) fn work_on(backends: &mut dyn BackendFactory, task: &mut dyn Resumable) -> Result<()> {
    let mut fallback = Fallback::None;
    let mut backend = backends.open(fallback)?;
    task.runs_on(backend.as_ref());
    loop {
        let batch = if fallback == Fallback::Small { BatchSize::SMALL } else { BatchSize::FULL };
        // What does not fit in small batches is no fault of the user's.
        let issue = match catch_panic(|| task.work(batch, backend.as_mut())) {
            Err(Error::Device(issue) | Error::Bug(issue))
                if backends.needs_check() && fallback != Fallback::Cpu =>
            {
                issue
            }
            Err(Error::Input(issue)) if fallback == Fallback::Small => issue,
            Ok(()) if fallback == Fallback::None => {
                backends.take_back(backend);
                return Ok(());
            }
            other => {
                // The outcome of the work matters more than how the device was closed.
                let _ = close(backend);
                return other;
            }
        };
        let closed = close(backend);
        let small = (fallback == Fallback::None).then(|| backends.open(Fallback::Small));
        let instead;
        (fallback, backend, instead) = match small {
            Some(Ok(small)) => (Fallback::Small, small, "the same device in small batches"),
            _ => (Fallback::Cpu, backends.open(Fallback::Cpu)?, "the CPU"),
        };
        let what = fault_words(issue, closed);
        task.failed(&Fault { what, scene: String::new(), instead: instead.into() });
    }
}
