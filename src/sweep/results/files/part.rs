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

/// The parts that this process writes to.
static OPEN: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

/// How often a part is begun again if another process removed it before it was locked.
const ATTEMPTS: usize = 16;

/// A temporary file beside the place of another; it is removed when this is dropped. Its name is random.
#[derive(Debug)]
pub(super) struct PartialFile {
    pub(super) path: PathBuf,
    pub(super) file: File,
}

impl PartialFile {
    /// Begins a part of the file at this place, and removes those that were left of it.
    pub(super) fn create(of: &Path) -> Result<PartialFile> {
        let name = of.file_name().ok_or(ErrorKind::IsADirectory)?;
        tidy(super::folder_of(of), |other| *name == *other);
        for _ in 0..ATTEMPTS {
            let mut name = name.to_os_string();
            name.push(format!(".{:016x}.part", RandomState::new().hash_one(())));
            let path = of.with_file_name(name);
            // Only a new file, so that nothing that was put there is written through.
            let file = match File::create_new(&path) {
                Err(e) if e.kind() == ErrorKind::AlreadyExists => continue,
                file => file?,
            };
            // On a file system without locks no process removes parts either.
            let locked = file.try_lock();
            if path.exists() && !matches!(locked, Err(fs::TryLockError::WouldBlock)) {
                parts().push(path.clone());
                return Ok(PartialFile { path, file });
            }
        }
        Err(Error::new(ErrorKind::ResourceBusy, "another program removes what is written there"))
    }
}

impl Drop for PartialFile {
    fn drop(&mut self) {
        // It may have been renamed; an error has nowhere to be reported.
        let _ = fs::remove_file(&self.path);
        parts().retain(|path| *path != self.path);
    }
}

/// Removes the parts that this process writes to, before it ends at once.
pub fn abandon() {
    for path in parts().drain(..) {
        let _ = fs::remove_file(path);
    }
}

fn parts() -> std::sync::MutexGuard<'static, Vec<PathBuf>> {
    OPEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the parts in a folder that nobody writes to, of files with certain names.
pub(super) fn tidy(folder: &Path, is_wanted: impl Fn(&str) -> bool) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if !is_file || !entry.file_name().to_str().and_then(whole_of).is_some_and(&is_wanted) {
            continue;
        }
        let left = File::open(entry.path()).is_ok_and(|file| file.try_lock().is_ok());
        if left {
            // It is gone already, or belongs to another user, and is left alone.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// The name of the file that a file is a part of, if it is one.
fn whole_of(name: &str) -> Option<&str> {
    let (whole, number) = name.strip_suffix(".part")?.rsplit_once('.')?;
    let is_number = number.len() == 16 && number.bytes().all(|b| b.is_ascii_hexdigit());
    is_number.then_some(whole)
}
