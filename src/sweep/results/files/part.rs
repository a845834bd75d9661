//! The temporary file (a part) that holds what is written until it is whole, and the removal of parts that a
//! killed run left behind.
//!
//! # Theory
//! A process that writes to a part holds its lock, and the system releases the lock however the process ends.
//! So a part that can be locked belongs to no process, and may be removed.

use std::fs::{self, File};
use std::hash::{BuildHasher, RandomState};
use std::io::{Error, ErrorKind, Result};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The temporary files that this process writes.
static OPEN: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// Attempts to create a temporary file, if another process removes it before it is locked.
const ATTEMPTS: usize = 16;

/// A temporary file next to the final path, with a random name; removed on drop.
#[derive(Debug)]
pub(super) struct PartialFile {
    pub(super) path: PathBuf,
    pub(super) file: File,
}

impl PartialFile {
    /// Creates a temporary file for this path, and removes abandoned ones.
    pub(super) fn create(of: &Path) -> Result<PartialFile> {
        let name = of.file_name().ok_or(ErrorKind::IsADirectory)?;
        tidy(super::folder_of(of), |other| *name == *other);
        for _ in 0..ATTEMPTS {
            let mut name = name.to_os_string();
            name.push(format!(".{:016x}.part", RandomState::new().hash_one(())));
            let path = of.with_file_name(name);
            // Only a new file, so that no existing link is written through.
            let file = match File::create_new(&path) {
                Err(e) if e.kind() == ErrorKind::AlreadyExists => continue,
                file => file?,
            };
            // On a file system without locks no process removes temporary files either.
            let locked = file.try_lock();
            if path.exists() && !matches!(locked, Err(fs::TryLockError::WouldBlock)) {
                parts().push(path.clone());
                return Ok(PartialFile { path, file });
            }
        }
        Err(Error::new(ErrorKind::ResourceBusy, "another program removes the files written there"))
    }
}

impl Drop for PartialFile {
    fn drop(&mut self) {
        // It may have been renamed; errors cannot be reported here.
        let _ = fs::remove_file(&self.path);
        parts().retain(|path| *path != self.path);
    }
}

/// Removes the temporary files of this process, before it exits immediately.
pub fn abandon() {
    for path in parts().drain(..) {
        let _ = fs::remove_file(path);
    }
}

fn parts() -> std::sync::MutexGuard<'static, Vec<PathBuf>> {
    OPEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes unlocked temporary files in a folder, for files with certain names.
pub(super) fn tidy(folder: &Path, is_wanted: impl Fn(&str) -> bool) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if !is_file || !entry.file_name().to_str().and_then(whole_of).is_some_and(&is_wanted) {
            continue;
        }
        let left = File::open(entry.path()).is_ok_and(|file| file.try_lock().is_ok());
        if left {
            // It is already gone, or belongs to another user, and is left alone.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// The final name of a temporary file, if it is one.
fn whole_of(name: &str) -> Option<&str> {
    let (whole, number) = name.strip_suffix(".part")?.rsplit_once('.')?;
    let is_number = number.len() == 16 && number.bytes().all(|b| b.is_ascii_hexdigit());
    is_number.then_some(whole)
}
