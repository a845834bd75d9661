//! The output of `-v` on standard error: a line for each logged event. Warnings are printed at every level.

use std::time::Instant;

use log::{LevelFilter, Log, Metadata, Record};

/// Starts the log: with `-v` files, scenes and devices, with `-vv` also each batch.
pub(super) fn start(verbosity: u8) {
    let level = match verbosity {
        0 => return,
        1 => LevelFilter::Info,
        _ => LevelFilter::Debug,
    };
    if log::set_boxed_logger(Box::new(LogLines { begin: Instant::now() })).is_ok() {
        log::set_max_level(level);
    }
}

/// A line for each event, with the seconds since the program began, above the progress bar.
struct LogLines {
    begin: Instant,
}

impl Log for LogLines {
    /// Only events of this crate and its marcher, not of other libraries.
    fn enabled(&self, event: &Metadata) -> bool {
        event.target().starts_with("perirobot")
    }

    fn log(&self, event: &Record) {
        if self.enabled(event.metadata()) {
            let seconds = self.begin.elapsed().as_secs_f64();
            super::progress::suspend_bar(|| say!("{seconds:8.3} s {:>5} {}", event.level(), event.args()));
        }
    }

    fn flush(&self) {}
}
