//! Stops a job on a signal or at `--max-time`. The current batch is finished first; a second signal ends the program at
//! once, and finished rows are still kept.

use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use perirobot_march::error::catch_panic;
use perirobot_march::{Error, Result};
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use super::progress::suspend_bar;

/// The exit code for a job that the same command can finish (`EX_TEMPFAIL`): it was stopped, or another run uses the
/// folder.
pub(super) const TRY_AGAIN: u8 = 75;

/// Waits for a reason to stop.
#[derive(Clone)]
pub(super) struct StopAt {
    signal: Arc<AtomicUsize>,
    until: Option<Instant>,
}

/// The signals that stop a job, with their names.
const SIGNALS: &[(i32, &str)] = &[
    (SIGINT, "Ctrl-C (SIGINT)"),
    (SIGTERM, "SIGTERM"),
    #[cfg(unix)]
    (signal_hook::consts::SIGUSR1, "SIGUSR1"),
];

impl StopAt {
    /// Starts to listen. `max_time` counts from here.
    pub(super) fn listen(max_time: Option<Duration>) -> Result<StopAt> {
        StopAt::listen_saying("stopping after the current batch; repeat the signal to stop now", max_time)
    }

    /// The same with another message.
    pub(super) fn listen_saying(words: &'static str, max_time: Option<Duration>) -> Result<StopAt> {
        let (signal, again) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(false)));
        for &(number, name) in SIGNALS {
            let wrong = |e| Error::device(format!("cannot listen for {name}: {e}"));
            // The order matters: the first arms the shutdown that the second triggers.
            flag::register_conditional_shutdown(number, TRY_AGAIN.into(), again.clone()).map_err(wrong)?;
            flag::register(number, again.clone()).map_err(wrong)?;
            flag::register_usize(number, signal.clone(), number as usize).map_err(wrong)?;
        }
        on_signal(move |_| suspend_bar(|| say!("{words}")))?;
        // A time beyond the range of the clock never comes.
        let until = max_time.and_then(|time| Instant::now().checked_add(time));
        Ok(StopAt { signal, until })
    }

    /// The reason to stop, if any.
    pub(super) fn reason(&self) -> Option<String> {
        let signal = self.signal.load(Ordering::Relaxed);
        let name = SIGNALS.iter().find(|(number, _)| *number as usize == signal).map(|(_, name)| *name);
        let late = self.until.is_some_and(|until| Instant::now() >= until);
        name.or(late.then_some("--max-time")).map(|why| format!("stopped by {why}"))
    }
}

/// From here on, a signal ends the program as usual, but leaves no half-written file.
pub(super) fn end_tidily() -> Result<()> {
    on_signal(|signal| {
        // The signal ends the program even if this panics.
        let _ = catch_panic(|| {
            perirobot_sweep::results::files::abandon();
            Ok(())
        });
        let _ = signal_hook::low_level::emulate_default_handler(signal);
    })
}

/// Runs a function once, in its own thread, at the first signal.
fn on_signal(act: impl FnOnce(i32) + Send + 'static) -> Result<()> {
    let wrong = |e| Error::device(format!("cannot listen for signals: {e}"));
    let next = next_signal().map_err(wrong)?;
    let listener = thread::Builder::new().spawn(move || {
        if let Some(signal) = next() {
            // A panic here must not prevent the stop.
            let acted = catch_panic(|| {
                act(signal);
                Ok(())
            });
            if let Err(bug) = acted {
                say!("error: {bug}");
            }
        }
    });
    listener.map(drop).map_err(wrong)
}

/// A function that waits for a signal.
#[cfg(unix)]
fn next_signal() -> std::io::Result<impl FnOnce() -> Option<i32>> {
    let mut signals = signal_hook::iterator::Signals::new(SIGNALS.iter().map(|(number, _)| number))?;
    Ok(move || signals.forever().next())
}

/// The same for Windows, where signal-hook has no iterator.
#[cfg(not(unix))]
fn next_signal() -> std::io::Result<impl FnOnce() -> Option<i32>> {
    let signal = Arc::new(AtomicUsize::new(0));
    for &(number, _) in SIGNALS {
        flag::register_usize(number, signal.clone(), number as usize)?;
    }
    Ok(move || {
        loop {
            match signal.load(Ordering::Relaxed) {
                0 => thread::sleep(Duration::from_millis(50)),
                number => return Some(number as i32),
            }
        }
    })
}

/// The exit code of a stopped job.
pub(super) fn stop_code() -> ExitCode {
    ExitCode::from(TRY_AGAIN)
}
