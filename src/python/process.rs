//! Values that belong to one process, and threads for jobs. A forked child has its parent's memory, but neither its threads
//! nor its devices: using or dropping a value that needs them could wait forever.

use std::mem;
use std::sync::{Mutex, PoisonError};

use perirobot_march::{Error, Result};
use rayon::{ThreadPool, ThreadPoolBuilder};

/// The stack of a main thread.
const STACK_BYTES: usize = 8 << 20;

/// A value that a forked child neither uses nor drops.
pub(crate) struct OfProcess<T> {
    value: Option<T>,
    process: u32,
}

impl<T> OfProcess<T> {
    /// A value of this process.
    pub(crate) fn new(value: T) -> OfProcess<T> {
        OfProcess { value: Some(value), process: std::process::id() }
    }

    /// The value, in the process that made it.
    pub(crate) fn take(mut self) -> Option<T> {
        if self.is_here() { self.value.take() } else { None }
    }

    fn is_here(&self) -> bool {
        self.process == std::process::id()
    }
}

impl<T> Drop for OfProcess<T> {
    fn drop(&mut self) {
        if !self.is_here() {
            mem::forget(self.value.take());
        }
    }
}

/// Threads that wait for the next job. They are taken and put back by threads that hold the interpreter's lock, as do those
/// that fork, so that this is not locked when a child gets it.
static IDLE: Mutex<Option<OfProcess<ThreadPool>>> = Mutex::new(None);

/// Threads for one job, as many as the process may use. Rayon's global ones would be missing in a forked child.
pub(crate) fn threads() -> Result<ThreadPool> {
    let idle = IDLE.lock().unwrap_or_else(PoisonError::into_inner).take();
    if let Some(pool) = idle.and_then(OfProcess::take) {
        return Ok(pool);
    }
    let pool = ThreadPoolBuilder::new().stack_size(STACK_BYTES).build();
    pool.map_err(|e| Error::device(format!("cannot start threads: {e}")))
}

/// Keeps the threads of a job that has ended for the next one.
pub(crate) fn keep(pool: ThreadPool) {
    *IDLE.lock().unwrap_or_else(PoisonError::into_inner) = Some(OfProcess::new(pool));
}
