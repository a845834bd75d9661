//! The one error type. It says where, what, and what to do; the command line turns its kind into an exit
//! code.

use std::io::ErrorKind;
use std::path::Path;

/// Why a command could not be carried out.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The user's files or arguments are wrong; the message names the place and what would be right. Exit
    /// code 2.
    #[error("{0}")]
    Input(String),
    /// A device failed, or lied, after the input was accepted. Exit code 3.
    #[error("{0}")]
    Device(String),
    /// The disk failed, or is full: another time the same may work. What is finished is kept. Exit code 3.
    #[error("{0}")]
    Storage(String),
    /// Somebody else is at work there; later it may work. Exit code 75.
    #[error("{0}")]
    Busy(String),
    /// A stop was asked for before the work had begun. Exit code 75.
    #[error("{0}")]
    Stopped(String),
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

    /// The same, with the place where it is bad input; what else went wrong is not of the place.
    pub(crate) fn at(self, place: impl std::fmt::Display) -> Self {
        match self {
            Error::Input(what) => Error::input(place, what),
            other => other,
        }
    }

    /// A file that cannot be read or written: bad input, unless it may pass.
    pub fn io(path: &Path, what: &str, source: std::io::Error) -> Self {
        let text = format!("{}: {what}: {source}", path.display());
        match Error::may_pass(&source) {
            false => Error::Input(text),
            true => Error::Storage(format!("{text}. That may pass: run the same command again")),
        }
    }

    /// Whether the disk or the network failed: any error that the path and the file there do not explain.
    pub(crate) fn may_pass(source: &std::io::Error) -> bool {
        /// Too many links, for which there is no stable kind.
        const ELOOP: i32 = if cfg!(target_os = "linux") { 40 } else { 62 };
        let of_the_place = matches!(
            source.kind(),
            ErrorKind::NotFound
                | ErrorKind::PermissionDenied
                | ErrorKind::AlreadyExists
                | ErrorKind::IsADirectory
                | ErrorKind::NotADirectory
                | ErrorKind::DirectoryNotEmpty
                | ErrorKind::InvalidFilename
                | ErrorKind::InvalidInput
                | ErrorKind::InvalidData
                | ErrorKind::ReadOnlyFilesystem
        );
        !of_the_place && source.raw_os_error() != Some(ELOOP)
    }

    /// The first of several errors, for callers that report one only.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(target_os = "linux")]
    #[test]
    fn failures_that_may_pass_are_no_bad_input() {
        let [enoent, enotdir, eloop, eio, emfile, estale] = [2, 20, 40, 5, 24, 116];
        for (numbers, passes) in [([enoent, enotdir, eloop], false), ([eio, emfile, estale], true)] {
            for number in numbers {
                let source = std::io::Error::from_raw_os_error(number);
                let error = Error::io(Path::new("a.stl"), "cannot be read", source);
                let is_right = match error {
                    Error::Input(_) => !passes,
                    Error::Storage(_) => passes,
                    _ => false,
                };
                assert!(is_right && error.to_string().starts_with("a.stl: cannot be read: "), "{error}");
            }
        }
    }
}
