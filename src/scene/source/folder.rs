//! A folder for files that another program reads or writes.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Longest part of a program's output that an error repeats, in characters.
const LONGEST_OUTPUT: usize = 2000;

/// A new folder among the temporary files, removed when it is dropped.
pub(super) struct TemporaryFolder(PathBuf);

impl TemporaryFolder {
    pub(super) fn new() -> std::io::Result<TemporaryFolder> {
        // The name must be new: a folder of that name may be another user's, or left by a run that was killed.
        let made = (0..1000).find_map(|number| {
            let folder = std::env::temp_dir().join(format!("perirobot-{}-{number}", std::process::id()));
            match std::fs::create_dir(&folder) {
                Err(e) if e.kind() == ErrorKind::AlreadyExists => None,
                made => Some(made.map(|()| folder)),
            }
        });
        made.unwrap_or_else(|| Err(ErrorKind::AlreadyExists.into())).map(TemporaryFolder)
    }

    pub(super) fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for TemporaryFolder {
    fn drop(&mut self) {
        // What stays behind in the folder for temporary files does no harm.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// The end of a program's output, for an error.
pub(super) fn output_end(output: &[u8]) -> String {
    let text = String::from_utf8_lossy(output).trim().to_string();
    let begin = text.char_indices().rev().take(LONGEST_OUTPUT).last().map_or(0, |(at, _)| at);
    text[begin..].to_string()
}
