//! `counts.journal`: every finished row of counts, on disk from the moment it is finished.
//!
//! # Theory
//! A record has the same size for every row and stands at the row's own place, so the order in which rows are
//! finished leaves no trace: two journals of the same rows are equal byte for byte. A record carries its row,
//! its counts and a checksum over both and the fingerprint of the sweep; a place that was never written, or
//! torn by a crash, or belongs to another sweep, cannot be taken for a finished row and is counted again.
//!
//! # Practice
//! The file is its own lock: a writer holds it exclusively, readers share it. It is never replaced, since
//! that would leave two files with a lock each.

mod pages;
mod record;

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{ErrorKind, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::results::files::{JOURNAL, open_regular, sync_folder_of};
pub use pages::Pages;
use perirobot_march::error::Issue;
use perirobot_march::metrics::Confusion;
use perirobot_march::{Error, Result};
use record::{HEADER_BYTES, RECORD_BYTES, State};
pub use record::{JournalHeader, Shard, Unfit};

/// Largest delay between a finished row and its sync to disk. A killed process loses nothing; a power failure loses at
/// most this much.
const SYNC_EVERY: Duration = Duration::from_secs(1);

/// Records per read.
const READ_ROWS: u64 = 1 << 14;

/// An open journal.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    header: JournalHeader,
    unsynced_since: Option<Instant>,
}

/// A journal locked by this process, before its contents are checked.
#[derive(Debug)]
pub struct Locked {
    path: PathBuf,
    file: File,
    /// Its header; `None` if it is new, or was created without a header.
    pub header: Result<Option<JournalHeader>, Unfit>,
}

impl Locked {
    /// Opens the journal of a folder, creating it if needed, for this process alone.
    ///
    /// # Errors
    /// `Error::Busy` if another process uses it; `Error::Storage` if the disk fails; `Error::Input` if the path is not
    /// a file of this folder alone.
    pub fn open(folder: &Path) -> Result<Locked> {
        let path = folder.join(JOURNAL);
        let file = open_alone(&path)?;
        let header = read_header(&path, &file)?;
        Ok(Locked { path, file, header })
    }

    /// Resumes with its rows, which belong to the sweep in `header`.
    pub fn go_on(self, header: JournalHeader) -> Journal {
        Journal { path: self.path, file: self.file, header, unsynced_since: None }
    }

    /// Starts empty; its rows are discarded.
    pub fn begin(mut self, header: JournalHeader) -> Result<Journal> {
        let write = |file: &mut File| {
            file.set_len(0)?;
            file.rewind()?;
            file.write_all(&header.bytes())?;
            file.sync_all()?;
            sync_folder_of(&self.path)
        };
        write(&mut self.file).map_err(|e| Error::storage(&self.path, e))?;
        Ok(Journal { path: self.path, file: self.file, header, unsynced_since: None })
    }
}

impl Journal {
    /// Opens the journal of a folder for reading, without a concurrent writer.
    pub fn read(folder: &Path) -> Result<Journal> {
        let path = folder.join(JOURNAL);
        let file = open_regular(&path, u64::MAX)?;
        let busy = "a run still uses this folder: wait until it has ended";
        check_lock(&path, file.try_lock_shared(), busy)?;
        let wrong = |what: String| Error::from(Issue::damaged(what).cure("sweep again").with_place(&path));
        let header = read_header(&path, &file)?.map_err(|unfit| wrong(unfit.to_string()))?;
        let header = header.ok_or_else(|| wrong("is empty".into()))?;
        Ok(Journal { path, file, header, unsynced_since: None })
    }

    /// Its sweep and shard.
    pub fn header(&self) -> &JournalHeader {
        &self.header
    }

    /// Its path, for messages.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the counts of consecutive rows in one block.
    pub fn put(&mut self, first: u64, counts: &[Confusion]) -> Result<()> {
        let rows = (first..).zip(counts);
        let bytes: Vec<u8> = rows.flat_map(|(row, counts)| self.header.record(row, counts)).collect();
        let at = self.offset(first);
        let write = |mut file: &File| {
            file.seek(SeekFrom::Start(at))?;
            file.write_all(&bytes)
        };
        write(&self.file).map_err(|e| Error::storage(&self.path, e))?;
        match self.unsynced_since {
            Some(since) if since.elapsed() >= SYNC_EVERY => self.sync(),
            Some(_) => Ok(()),
            None => {
                self.unsynced_since = Some(Instant::now());
                Ok(())
            }
        }
    }

    /// Renames the file, whose rows cannot be trusted, in its folder, and starts an empty one.
    pub(crate) fn set_aside(&mut self, name: &str) -> Result<()> {
        let renamed = std::fs::rename(&self.path, self.path.with_file_name(name));
        renamed.map_err(|e| Error::storage(&self.path, e))?;
        let folder = self.path.parent().unwrap_or(Path::new("."));
        *self = Locked::open(folder)?.begin(self.header.clone())?;
        Ok(())
    }

    /// Syncs all written data to disk.
    pub fn sync(&mut self) -> Result<()> {
        self.unsynced_since = None;
        self.file.sync_data().map_err(|e| Error::storage(&self.path, e))
    }

    /// Passes every finished row to `take` in order, and returns the number of damaged places.
    pub fn scan(&self, mut finished: impl FnMut(u64, Confusion) -> Result<()>) -> Result<u64> {
        let length = self.file.metadata().map_err(|e| self.cannot_read(e))?.len();
        let mut damaged = 0;
        for block in 0..self.header.blocks {
            let rows = self.header.rows_of_block(block);
            for first in rows.clone().step_by(READ_ROWS as usize) {
                // A short file takes a short time, regardless of the row count in its header.
                if self.offset(first) >= length {
                    return Ok(damaged);
                }
                let some = first..rows.end.min(first + READ_ROWS);
                for (row, state) in some.clone().zip(self.states(some)?) {
                    match state {
                        State::Finished(counts) => finished(row, counts)?,
                        State::Missing => {}
                        State::Damaged => damaged += 1,
                    }
                }
            }
        }
        Ok(damaged)
    }

    /// The counts of consecutive rows in one block; all must be finished.
    pub fn counts(&self, rows: Range<u64>) -> Result<Vec<Confusion>> {
        let states = rows.clone().zip(self.states(rows)?);
        let counts = states.map(|(row, state)| match state {
            State::Finished(counts) => Ok(counts),
            _ => {
                Err(Error::Storage(Issue::says(format!("{}: row {row} is missing now", self.path.display()))))
            }
        });
        counts.collect()
    }

    /// The states of consecutive rows in one block; empty beyond the end of the file.
    fn states(&self, rows: Range<u64>) -> Result<Vec<State>> {
        let at = self.offset(rows.start);
        let length = (rows.end - rows.start) * RECORD_BYTES as u64;
        let mut bytes = Vec::with_capacity(length as usize);
        let read = |mut file: &File, bytes: &mut Vec<u8>| {
            file.seek(SeekFrom::Start(at))?;
            file.take(length).read_to_end(bytes)
        };
        read(&self.file, &mut bytes).map_err(|e| self.cannot_read(e))?;
        bytes.resize(length as usize, 0);
        let records = bytes.chunks_exact(RECORD_BYTES);
        Ok(rows.zip(records).map(|(row, record)| self.header.state(row, record)).collect())
    }

    fn offset(&self, row: u64) -> u64 {
        HEADER_BYTES as u64 + self.header.place(row) * RECORD_BYTES as u64
    }

    fn cannot_read(&self, e: std::io::Error) -> Error {
        Error::Storage(Issue::says(format!("{}: cannot be read: {e}", self.path.display())))
    }
}

#[cfg(all(any(test, feature = "example"), target_os = "linux"))]
impl Journal {
    /// Makes every later read fail: reading the start of a process's memory is an input/output error.
    pub(crate) fn break_disk(&mut self) {
        self.file = File::open("/proc/self/mem").expect("Linux has it");
    }
}

/// Opens a file with a single writing process, creating it if needed, for this process alone.
///
/// # Errors
/// `Error::Busy` if another process uses it; `Error::Storage` if the disk fails; `Error::Input` if the path is not a
/// file of its folder alone.
pub fn open_alone(path: &Path) -> Result<File> {
    // Through a link, an untrusted folder could overwrite any file of the user.
    if path.symlink_metadata().is_ok_and(|metadata| !metadata.is_file()) {
        let what = "is not a regular file, but a journal is needed there: move it away";
        return Err(Error::input(path, what));
    }
    let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
    let file = file.map_err(|e| Error::io(path, "cannot be opened", e))?;
    let names = names_of(&file).map_err(|e| Error::io(path, "cannot be read", e))?;
    if names > 1 {
        let what = format!(
            "has {names} names (hard links), and writing would change the file under all of them: replace it by a \
             copy"
        );
        return Err(Error::input(path, what));
    }
    let busy = "another run uses this folder: wait for it, or name another folder";
    check_lock(path, file.try_lock(), busy)?;
    Ok(file)
}

/// Fails unless a file could be locked: with `busy` if another process holds the lock.
fn check_lock(path: &Path, outcome: Result<(), TryLockError>, busy: &str) -> Result<()> {
    match outcome {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => Err(Error::Busy(Issue::says(format!("{}: {busy}", path.display())))),
        Err(TryLockError::Error(e)) => Err(cannot_lock(path, &e)),
    }
}

/// The error of a file that could not be locked: an input error if its file system has no locks.
fn cannot_lock(path: &Path, source: &std::io::Error) -> Error {
    let issue = Issue::io("cannot be locked", source).with_place(path);
    match source.kind() == ErrorKind::Unsupported || !Error::may_pass(source) {
        true => issue
            .with_advice("Without a lock two runs could write to it: name a folder on another file system")
            .into(),
        false => Error::Storage(issue.with_advice(
            "The error may be temporary: run the same command again; if it remains, name a folder on another file system",
        )),
    }
}

/// The number of names of a file, if the system reports it.
fn names_of(file: &File) -> std::io::Result<u64> {
    #[cfg(unix)]
    return Ok(std::os::unix::fs::MetadataExt::nlink(&file.metadata()?));
    #[cfg(not(unix))]
    return file.metadata().map(|_| 1);
}

/// The header of a file; `None` if the file ends before its header does.
fn read_header(path: &Path, mut file: &File) -> Result<Result<Option<JournalHeader>, Unfit>> {
    let mut bytes = Vec::new();
    let read = file.rewind().and_then(|()| file.take(HEADER_BYTES as u64).read_to_end(&mut bytes));
    read.map_err(|e| Error::io(path, "cannot be read", e))?;
    if bytes.len() < HEADER_BYTES {
        return Ok(Ok(None));
    }
    Ok(JournalHeader::parse(&bytes).map(Some))
}

#[cfg(test)]
mod tests;
