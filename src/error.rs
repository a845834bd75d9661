//! The one error type. It says where, what, and what to do; the command line turns its kind into an exit code.

use std::path::Path;

/// Why a command could not be carried out.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The user's files or arguments are wrong; the message names the place and what would be right. Exit code 2.
    #[error("{0}")]
    Input(String),
    /// A device failed, or lied, after the input was accepted. Exit code 3.
    #[error("{0}")]
    Device(String),
    /// The disk failed, or is full, while counts were written. What is finished is kept. Exit code 3.
    #[error("{0}")]
    Storage(String),
    /// Somebody else is at work there; later it may work. Exit code 75.
    #[error("{0}")]
    Busy(String),
    /// A device gave other counts than the CPU. Exit code 1.
    #[error("{0}")]
    Disagreement(String),
}

/// `std::result::Result` with [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// Bad input at a place (a file, or a file and a key): `place: what`.
    pub fn input(place: impl std::fmt::Display, what: impl std::fmt::Display) -> Self {
        Error::Input(format!("{place}: {what}"))
    }

    /// A file that cannot be read or written.
    pub fn io(path: &Path, what: &str, source: std::io::Error) -> Self {
        Error::Input(format!("{}: {what}: {source}", path.display()))
    }

    /// The first of several, for who can tell one only; where there is none, that is what it says.
    pub(crate) fn first(mut all: Vec<Error>) -> Self {
        match all.is_empty() {
            true => Error::Input("something is wrong, and nothing says what".into()),
            false => all.swap_remove(0),
        }
    }

    /// A file of a sweep that the disk does not take.
    pub(crate) fn storage(path: &Path, source: std::io::Error) -> Self {
        let cure = "What is finished is kept: mend that and run the same command again";
        Error::Storage(format!("{}: cannot be written: {source}. {cure}", path.display()))
    }
}
