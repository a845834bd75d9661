//! wgpu panics when a device is lost while the program waits for it, and when a device fails while it is closed.
//! Drivers may also hang. Waiting and closing therefore run in a thread that is joined, with a time limit.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::channel;
use std::time::Duration;

use crate::error::describe_panic;

/// The answer of a function that may panic or hang.
///
/// # Errors
/// The message of the panic; that there was no answer in time; that no thread can be started.
pub fn unless_lost<T: Send + 'static>(
    limit: Duration,
    run: impl FnOnce() -> T + Send + 'static,
) -> Result<T, String> {
    let (answer, answered) = channel();
    let wait = move || {
        // After the limit the receiver is gone.
        let _ = answer.send(catch_unwind(AssertUnwindSafe(run)));
    };
    let thread = std::thread::Builder::new().name("device".into()).spawn(wait);
    let thread = thread.map_err(|error| format!("no thread can be started: {error}"))?;
    let done = answered.recv_timeout(limit).map_err(|_| format!("no answer in {limit:?}"))?;
    // It ends at once: the answer is the last thing that it sends.
    let _ = thread.join();
    done.map_err(|panic| describe_panic(panic.as_ref()))
}

#[cfg(test)]
mod tests {
    use std::hint::black_box;

    use super::*;

    #[test]
    fn a_panic_is_no_answer_but_a_reason() {
        let long = Duration::from_secs(60);
        assert_eq!(unless_lost(long, || 7), Ok(7));
        let lost = unless_lost::<i32>(long, || panic!("device number {}", black_box(3)));
        assert_eq!(lost, Err("panicked: device number 3".into()));
        assert_eq!(unless_lost(long, || "as before"), Ok("as before"));
    }

    #[test]
    fn an_answer_that_takes_too_long_is_not_waited_for() {
        let (go_on, wait) = channel::<()>();
        let late = unless_lost(Duration::from_millis(1), move || wait.recv().is_ok());
        assert_eq!(late, Err("no answer in 1ms".into()));
        drop(go_on);
    }
}
