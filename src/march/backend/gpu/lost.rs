//! wgpu panics when a device is lost while it is waited for. That is an adapter's failure, and other backends can
//! go on. So what may panic so runs in a thread of its own, which tells that it did. Programs that a panic ends
//! (`panic = "abort"`) must not get that far: there the thread stops in the panic hook, for good.

use std::cell::Cell;
use std::sync::Once;
use std::sync::mpsc::{Sender, channel};

thread_local! {
    /// Who is told why there is no answer, in threads that may panic because a device is lost.
    static WAITING: Cell<Option<Sender<String>>> = const { Cell::new(None) };
}

/// The answer of something that may panic, or why there is none.
pub(super) fn unless_lost<T: Send + 'static>(run: impl FnOnce() -> T + Send + 'static) -> Result<T, String> {
    keep_panics();
    let (answer, answered) = channel();
    let (waiting, ended) = channel();
    let wait = move || {
        WAITING.set(Some(waiting));
        let answer = answer.send(run());
        WAITING.take();
        answer
    };
    std::thread::Builder::new().name("device".into()).spawn(wait).map_err(|error| error.to_string())?;
    // Ends when the thread has an answer, or panics.
    let why = ended.recv();
    answered.try_recv().map_err(|_| why.unwrap_or_else(|_| "lost while waiting for it".into()))
}

/// From now on threads that wait for a device panic without a message, and without ending the program.
fn keep_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let otherwise = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            let Some(waiting) = WAITING.take() else { return otherwise(panic) };
            if let Some(why) = panic.payload().downcast_ref::<String>() {
                // Whoever waits is there until it is told.
                let _ = waiting.send(format!("lost while waiting for it: {why}"));
            }
            drop(waiting);
            while cfg!(panic = "abort") {
                std::thread::park();
            }
        }));
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_no_answer_but_a_reason() {
        assert_eq!(unless_lost(|| 7), Ok(7));
        let lost = unless_lost::<i32>(|| panic!("device number {}", 3));
        assert_eq!(lost, Err("lost while waiting for it: device number 3".into()));
        assert_eq!(unless_lost::<i32>(|| panic!("gone")), Err("lost while waiting for it".into()));
        assert_eq!(unless_lost(|| "as before"), Ok("as before"));
    }
}
