//! What `-v` prints on standard error: a line for each event that the library reports. Warnings are printed
//! at every level.

use std::io::{self, Write};
use std::time::Instant;

use tracing::Level;
use tracing_subscriber::fmt::{format, time::FormatTime};

/// Starts to print what is being done: with `-v` files, scenes and devices, with `-vv` each batch, too.
pub(super) fn start(verbosity: u8) {
    let level = match verbosity {
        0 => return,
        1 => Level::INFO,
        _ => Level::DEBUG,
    };
    let lines = tracing_subscriber::fmt().with_max_level(level).with_target(false);
    lines.with_timer(SinceStart(Instant::now())).with_writer(|| AboveBar).init();
}

/// Seconds since the program began.
struct SinceStart(Instant);

impl FormatTime for SinceStart {
    fn format_time(&self, line: &mut format::Writer<'_>) -> std::fmt::Result {
        write!(line, "{:8.3} s", self.0.elapsed().as_secs_f64())
    }
}

/// Standard error, with the progress bar out of the way.
struct AboveBar;

impl Write for AboveBar {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        let text = String::from_utf8_lossy(line);
        super::progress::above_bar(|| say!("{}", text.trim_end_matches('\n')));
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
