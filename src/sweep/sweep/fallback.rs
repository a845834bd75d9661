//! Work that another backend takes over where a device fails.

use super::evidence::BatchSize;
use crate::results::manifest::Fault;
use perirobot_march::backend::Backend;
use perirobot_march::backend::factory::{BackendFactory, Fallback};
use perirobot_march::error::catch_panic;
use perirobot_march::{Error, Result};

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
        let error = match catch_panic(|| task.work(batch, backend.as_mut())) {
            Err(error @ (Error::Device(_) | Error::Bug(_)))
                if backends.needs_check() && fallback != Fallback::Cpu =>
            {
                error
            }
            Err(error @ Error::Input(_)) if fallback == Fallback::Small => error,
            Ok(()) if fallback == Fallback::None => {
                backends.take_back(backend);
                return Ok(());
            }
            other => return other,
        };
        // Its memory must be free before the next one is opened.
        drop(backend);
        let small = (fallback == Fallback::None).then(|| backends.open(Fallback::Small));
        let instead;
        (fallback, backend, instead) = match small {
            Some(Ok(small)) => (Fallback::Small, small, "the same device in small batches"),
            _ => (Fallback::Cpu, backends.open(Fallback::Cpu)?, "the CPU"),
        };
        task.failed(&Fault::new(&error, "", instead));
    }
}
