//! wgpu panics when a device is lost while it is waited for, and when a device runs out of memory while it is closed.
//! Those are failures of an adapter, and other backends can go on. So waiting and closing each run in a thread of
//! their own, whose panic is reported as an error. In a program built with `panic = "abort"` the panic hook stops that
//! thread for good, before the program would be aborted. A stopped thread keeps its reference to the device, and no
//! other hook can be set from then on.

use std::cell::Cell;
use std::sync::Once;
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::time::Duration;

/// How wgpu begins to say that a device was lost while it was waited for.
const POLLED: &str = "Error in Device::poll";

thread_local! {
    /// Who is told why there is no answer, in threads that may panic because a device is lost.
    static WAITING: Cell<Option<Sender<String>>> = const { Cell::new(None) };
}

/// The answer of something that may panic, or why there is none. It is waited for no longer than the limit.
///
/// # Errors
/// What the panic says; that there was no answer in time; that no thread can be started.
pub fn unless_lost<T: Send + 'static>(
    limit: Duration,
    run: impl FnOnce() -> T + Send + 'static,
) -> Result<T, String> {
    keep_panics();
    let (answer, answered) = channel();
    let (waiting, ended) = channel();
    let wait = move || {
        WAITING.set(Some(waiting));
        // Where the limit is over, nobody wants it.
        let _ = answer.send(run());
        WAITING.take();
    };
    let thread = std::thread::Builder::new().name("device".into()).spawn(wait);
    thread.map_err(|error| format!("no thread can be started: {error}"))?;
    // Nothing is said before the thread ends or stops, unless it panics.
    let why = match ended.recv_timeout(limit) {
        Ok(why) => {
            // Until it has let go of the device, or stopped.
            let _ = ended.recv_timeout(limit);
            why
        }
        Err(RecvTimeoutError::Timeout) => format!("no answer in {limit:?}"),
        Err(RecvTimeoutError::Disconnected) => "no answer".into(),
    };
    answered.try_recv().map_err(|_| why)
}

/// From now on a panic in a thread that waits for a device does not end the program.
fn keep_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let otherwise = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            let Ok(Some(waiting)) = WAITING.try_with(Cell::take) else { return otherwise(panic) };
            let said = panic.payload();
            let said = said.downcast_ref::<String>().map(String::as_str).or(said.downcast_ref().copied());
            let said = said.unwrap_or("panicked");
            if !said.starts_with(POLLED) {
                // No device was lost, or not in a way that is known: somebody may want to know where.
                eprintln!("{panic}");
            }
            // Whoever waits is gone if the limit is over.
            let _ = waiting.send(format!("lost while waiting for it: {said}"));
            if cfg!(panic = "abort") {
                drop(waiting);
                loop {
                    std::thread::park();
                }
            }
            WAITING.set(Some(waiting));
        }));
    });
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
        assert_eq!(lost, Err("lost while waiting for it: device number 3".into()));
        let lost = unless_lost::<i32>(long, || panic!("gone"));
        assert_eq!(lost, Err("lost while waiting for it: gone".into()));
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
