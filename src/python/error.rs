//! Errors as Python's users expect them: bad input is a `ValueError`, arguments are named as Python writes them.

use perirobot_march::Error;
use perirobot_march::error::Argument;
use pyo3::PyErr;
use pyo3::exceptions::{PyOSError, PyRuntimeError, PyValueError};

/// The exception for an error.
pub(crate) fn to_exception(error: &Error) -> PyErr {
    let words = error.issue().to_text(&name);
    match error {
        Error::Input(_) => PyValueError::new_err(words),
        Error::Storage(_) | Error::Busy(_) => PyOSError::new_err(words),
        Error::Device(_) | Error::Stopped(_) | Error::Disagreement(_) | Error::Bug(_) => {
            PyRuntimeError::new_err(words)
        }
    }
}

/// An argument as a keyword.
fn name(argument: Argument) -> String {
    match argument {
        Argument("voxel size") => "voxel_size_m".into(),
        Argument(other) => other.replace(' ', "_"),
    }
}
