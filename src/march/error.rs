//! The error type of perirobot: the variant decides the exit code of its program, its [`Issue`] says where and what is
//! wrong, and what would be right.

mod issue;
mod panic;
mod words;

use std::io::ErrorKind;
use std::path::Path;

pub use issue::{Issue, Site, What};
pub use panic::{catch_panic, describe_panic, latest_backtrace, record_panics};
pub use words::{Argument, NameOf, Words};

/// Why an operation failed.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The user's files or arguments are wrong.
    #[error("{0}")]
    Input(Issue),
    /// A device failed, or gave results that cannot be right, after the input was accepted.
    #[error("{0}")]
    Device(Issue),
    /// The disk failed, or is full: the same may work later. Finished work is kept.
    #[error("{0}")]
    Storage(Issue),
    /// Another process is at work there; the same may work later.
    #[error("{0}")]
    Busy(Issue),
    /// A stop was requested before the work had begun.
    #[error("{0}")]
    Stopped(Issue),
    /// A device gave other counts than the CPU.
    #[error("{0}")]
    Disagreement(Issue),
    /// perirobot itself is wrong: it panicked. Finished work is kept.
    #[error("{0}")]
    Bug(Issue),
}

/// `std::result::Result` with [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// An issue is bad input, unless another variant is chosen.
impl From<Issue> for Error {
    fn from(issue: Issue) -> Self {
        Error::Input(issue)
    }
}

impl Error {
    /// Bad input at a place, as a sentence about it.
    pub fn input(place: impl Into<Site>, what: impl Into<Words>) -> Self {
        Issue::says(what).with_place(place).into()
    }

    /// A device that failed, or gave results that cannot be right.
    pub fn device(what: impl Into<Words>) -> Self {
        Error::Device(Issue::says(what))
    }

    /// What is wrong.
    pub fn issue(&self) -> &Issue {
        match self {
            Error::Input(issue)
            | Error::Device(issue)
            | Error::Storage(issue)
            | Error::Busy(issue)
            | Error::Stopped(issue)
            | Error::Disagreement(issue)
            | Error::Bug(issue) => issue,
        }
    }

    /// The same, with what would be right.
    #[must_use]
    pub fn with_advice(self, wanted: impl Into<Words>) -> Self {
        self.map(|issue| issue.with_advice(wanted))
    }

    /// The same, with what helps otherwise.
    #[must_use]
    pub fn cure(self, cure: impl Into<Words>) -> Self {
        self.map(|issue| issue.cure(cure))
    }

    /// The same error, its issue changed.
    fn map(mut self, change: impl FnOnce(Issue) -> Issue) -> Self {
        let (Error::Input(issue)
        | Error::Device(issue)
        | Error::Storage(issue)
        | Error::Busy(issue)
        | Error::Stopped(issue)
        | Error::Disagreement(issue)
        | Error::Bug(issue)) = &mut self;
        *issue = change(issue.clone());
        self
    }

    /// The same with the place, if it is bad input; other errors do not belong to a place in a file.
    #[must_use]
    pub fn with_place(self, place: impl Into<Site>) -> Self {
        match self {
            Error::Input(_) | Error::Storage(_) => self.map(|issue| issue.with_place(place)),
            other => other,
        }
    }

    /// A file that cannot be read or written: bad input, unless the cause may go away by itself.
    pub fn io(path: &Path, doing: impl Into<Words>, source: std::io::Error) -> Self {
        let issue = Issue::io(doing, &source).with_place(path);
        match Error::may_pass(&source) {
            false => issue.into(),
            true => Error::Storage(issue.with_advice("That may pass: run the same command again")),
        }
    }

    /// Whether the disk or the network failed: any error for which the path and its file are no explanation.
    pub fn may_pass(source: &std::io::Error) -> bool {
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
        !of_the_place && !Error::is_link_loop(source)
    }

    /// Whether symbolic links lead back to themselves, for which there is no stable kind.
    pub fn is_link_loop(source: &std::io::Error) -> bool {
        const ELOOP: i32 = if cfg!(target_os = "linux") { 40 } else { 62 };
        source.raw_os_error() == Some(ELOOP)
    }

    /// The first of several errors, for callers that report one only.
    pub fn first(mut all: Vec<Error>) -> Self {
        match all.is_empty() {
            true => Issue::says("something is wrong, and nothing says what").into(),
            false => all.swap_remove(0),
        }
    }

    /// A file of a sweep that cannot be written to the disk.
    pub fn storage(path: &Path, source: std::io::Error) -> Self {
        let cure = "What is finished is kept: mend that and run the same command again";
        Error::Storage(Issue::io("cannot be written", &source).with_place(path).with_advice(cure))
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
