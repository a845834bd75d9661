//! The native half of the Python package: studies, sweeps, and the command line. What Python's users see of it is
//! described in `perirobot/`, whose classes are thin covers of these.

mod error;
mod study;
mod table;
mod watch;

use std::ffi::OsString;
use std::process::ExitCode;

use pyo3::prelude::*;

/// The module `perirobot._perirobot`.
#[pymodule]
mod _perirobot {
    #[pymodule_export]
    use super::run;
    #[pymodule_export]
    use super::study::Study;
}

/// Runs a command line, the program's name its first word, and returns the exit code.
#[pyfunction]
fn run(py: Python<'_>, words: Vec<OsString>) -> u8 {
    number(py.detach(|| perirobot::cli::run(words)))
}

/// The number of an exit code, which the standard library does not tell.
fn number(code: ExitCode) -> u8 {
    (0..=u8::MAX).find(|&number| ExitCode::from(number) == code).unwrap_or(1)
}
