//! A panic as an error: it ends the work under way, not the process.

use std::any::Any;
use std::backtrace::{Backtrace, BacktraceStatus};
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::sync::{Mutex, PoisonError};

use super::{Error, Issue, Result};

/// The latest panic, if [`record_panics`] was called.
static LATEST: Mutex<Option<RecordedPanic>> = Mutex::new(None);

struct RecordedPanic {
    message: String,
    place: String,
    backtrace: Backtrace,
}

/// Runs work whose panic is an [`Error::Bug`]. What the work changed must not be used afterwards, unless it is sound
/// after each step, as a journal is.
///
/// # Errors
/// Those of the work.
pub fn catch_panic<T>(work: impl FnOnce() -> Result<T>) -> Result<T> {
    catch_unwind(AssertUnwindSafe(work))
        .unwrap_or_else(|panic| Err(Error::Bug(Issue::says(describe_panic(panic.as_ref())))))
}

/// A caught panic in words, with its place in the source if that was recorded.
pub fn describe_panic(panic: &(dyn Any + Send)) -> String {
    let message = message_of(panic);
    let latest = LATEST.lock().unwrap_or_else(PoisonError::into_inner);
    match latest.as_ref().filter(|latest| latest.message == message) {
        Some(RecordedPanic { place, .. }) => format!("panicked: {message} (at {place})"),
        None => format!("panicked: {message}"),
    }
}

/// The backtrace of the latest panic, if panics are recorded and `RUST_BACKTRACE` requests one.
pub fn latest_backtrace() -> Option<String> {
    let latest = LATEST.lock().unwrap_or_else(PoisonError::into_inner);
    let backtrace = &latest.as_ref()?.backtrace;
    (backtrace.status() == BacktraceStatus::Captured).then(|| backtrace.to_string())
}

/// From now on panics of this process are recorded instead of printed, for programs that catch all of them.
pub fn record_panics() {
    set_hook(Box::new(|panic| {
        let place = panic.location().map_or("an unknown place".into(), ToString::to_string);
        let message = message_of(panic.payload());
        let recorded = RecordedPanic { message, place, backtrace: Backtrace::capture() };
        *LATEST.lock().unwrap_or_else(PoisonError::into_inner) = Some(recorded);
    }));
}

fn message_of(panic: &dyn Any) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or(panic.downcast_ref::<&str>().copied()).unwrap_or("without a message").into()
}

#[cfg(test)]
mod tests {
    use std::hint::black_box;

    use super::*;

    #[test]
    fn a_panic_is_an_error_with_its_message() {
        assert_eq!(catch_panic(|| Ok(7)).unwrap(), 7);
        assert!(matches!(catch_panic::<()>(|| Err(Error::device("lost"))), Err(Error::Device(_))));
        let formatted = catch_panic::<()>(|| panic!("device number {}", black_box(3))).unwrap_err();
        assert!(matches!(formatted, Error::Bug(_)));
        assert_eq!(formatted.to_string(), "panicked: device number 3");
        assert_eq!(catch_panic::<()>(|| panic!("gone")).unwrap_err().to_string(), "panicked: gone");
        let odd = catch_panic::<()>(|| std::panic::panic_any(3)).unwrap_err();
        assert_eq!(odd.to_string(), "panicked: without a message");
    }

    /// Panics of other threads pass through the thread that waits for them.
    #[test]
    fn a_panic_of_a_pool_is_an_error() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let work = || pool.install(|| rayon::join(|| 1, || -> i32 { panic!("in a worker") }));
        assert_eq!(catch_panic(|| Ok(work())).unwrap_err().to_string(), "panicked: in a worker");
        assert_eq!(pool.install(|| 7), 7, "the pool still works");
    }
}
