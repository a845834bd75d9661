//! `evidence.journal`: the evidence of each candidate for all voxels of the grid, stored as soon as it is cast, so that
//! another question about the same study casts nothing, and a stopped run resumes.
//!
//! # Theory
//! Records are appended as they come. Each has a checksum over itself and the fingerprint of all that decides the
//! evidence, so that a record of another study, a damaged or a torn one is never used; its candidate is cast again.
//! Evidence consists of integers, so the order of records and the device do not change an answer.
//!
//! # Practice
//! All numbers are little-endian. Header, 60 bytes: magic, format version (u32), the length of what decides the evidence
//! (u64), its SHA-256 (32 bytes), and a checksum of these (8 bytes); then what decides the evidence, as JSON. Record:
//! number of the candidate, of the world and of the repeat, and how many bytes each of the four planes takes (u32 each),
//! checksum of the planes, checksum of all before (8 bytes each); then the planes: occupied, free, hits and felt, each a
//! bit for each voxel of the grid in words (u32) of rows along x, packed by LZ4 (block format). A plane without a bit takes
//! no space.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde_json::{Map, Value};
use sha2::{Digest, Sha256};

use super::super::planes::SAID;
use perirobot_march::error::{Argument, Issue, Words};
use perirobot_march::{Error, Result};
use perirobot_study::input::Study;
use perirobot_sweep::results::checksum::{CHECK_BYTES, checksum};
use perirobot_sweep::results::files::sync_folder_of;
use perirobot_sweep::results::journal::open_alone;
use perirobot_sweep::results::manifest::changes;

/// The file of the evidence, in the folder of an answer.
pub const EVIDENCE: &str = "evidence.journal";

const MAGIC: [u8; 8] = *b"PeRSevid";

/// Version of this format.
const VERSION: u32 = 2;

/// Bytes before the inputs of the evidence.
const HEADER_BYTES: usize = 8 + 4 + 8 + 32 + CHECK_BYTES;

/// Bytes of a record before its planes.
const RECORD_BYTES: usize = 4 * NUMBERS + 2 * CHECK_BYTES;

/// The header numbers of a record: its key and the lengths of its planes.
const NUMBERS: usize = 3 + SAID;

/// The longest description of a study that is read; real ones are shorter.
const MOST_SAID: u64 = 1 << 30;

/// Largest delay between a cast and its sync to disk. A killed process loses nothing; a power failure loses at most
/// this much.
const SYNC_EVERY: Duration = Duration::from_secs(1);

/// The key of a record: a candidate in one repeat of a world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct RecordKey {
    pub(super) item: usize,
    pub(super) world: usize,
    pub(super) repeat: usize,
}

/// The evidence of a candidate in one repeat of a world, packed.
pub(super) type PackedPlanes = [Vec<u8>; SAID];

/// The contents of a file.
#[derive(Debug, Default)]
pub(super) struct FileContents {
    /// Damaged records.
    pub(super) damaged: Vec<RecordKey>,
    /// Whether the file is unreadable from some place on, before its end.
    pub(super) is_cut: bool,
}

/// The evidence file of a folder, created with the first evidence.
#[derive(Debug)]
pub(super) struct EvidenceFile {
    pub(super) path: PathBuf,
    /// The inputs of the evidence.
    says: Vec<u8>,
    fingerprint: [u8; 32],
    file: Option<File>,
    /// The end of the last record; 0 before the file is created.
    end: u64,
    unsynced_since: Option<Instant>,
}

impl EvidenceFile {
    /// Opens the evidence file of a folder, which has evidence for these inputs or none. With `restart` old evidence is
    /// discarded at the first write.
    ///
    /// # Errors
    /// `Error::Input` if it contains evidence for other inputs, with the differences; `Error::Busy` if another run uses
    /// it; `Error::Storage` if the disk fails.
    pub(super) fn open(
        folder: &Path,
        study: &Study,
        deciding: &Map<String, Value>,
        restart: bool,
    ) -> Result<EvidenceFile> {
        let path = folder.join(EVIDENCE);
        if study.sources.has_read(&path) {
            let what = Words::from("is a file of the study, but ") + Argument("out") + " would overwrite it";
            return Err(Error::input(path, what).with_advice("name another folder"));
        }
        let there = path.symlink_metadata().is_ok();
        let file = there.then(|| open_alone(&path)).transpose()?;
        let says = serde_json::to_vec(deciding).expect("a JSON value is serialisable");
        let fingerprint = Sha256::digest(&says).into();
        let mut kept = EvidenceFile { path, says, fingerprint, file, end: 0, unsynced_since: None };
        if let (Some(file), false) = (&kept.file, restart) {
            match kept.header(file)? {
                None => {}
                Some(says) if says == kept.says => kept.end = (HEADER_BYTES + says.len()) as u64,
                Some(says) => return Err(kept.another(&says, deciding)),
            }
        }
        Ok(kept)
    }

    /// The inputs of a file's evidence; `None` if the file ends within them.
    fn header(&self, mut file: &File) -> Result<Option<Vec<u8>>> {
        let unfit =
            |what: String, cure: Words| Error::from(Issue::damaged(what).cure(cure).with_place(&self.path));
        let mut bytes = Vec::new();
        let read = file.rewind().and_then(|()| file.take(HEADER_BYTES as u64).read_to_end(&mut bytes));
        read.map_err(|e| Error::io(&self.path, "cannot be read", e))?;
        let begins = bytes.len().min(MAGIC.len());
        if bytes[..begins] != MAGIC[..begins] {
            return Err(unfit(
                "is not an evidence file of perirobot".into(),
                "name another folder, or move it away".into(),
            ));
        }
        if bytes.len() < HEADER_BYTES {
            return Ok(None);
        }
        let version = u32::from_le_bytes(std::array::from_fn(|i| bytes[8 + i]));
        if version != VERSION {
            let what = format!("has evidence of format {version}, but this perirobot writes {VERSION}");
            let cure = Words::from("name another folder, or start over with ") + Argument("restart");
            return Err(unfit(what, cure));
        }
        let length = u64::from_le_bytes(std::array::from_fn(|i| bytes[12 + i]));
        let (body, sum) = bytes.split_at(HEADER_BYTES - CHECK_BYTES);
        let damaged =
            || unfit("has a damaged beginning".into(), Words::from(Argument("restart")) + " starts over");
        if checksum([body, &[]]) != sum || length > MOST_SAID {
            return Err(damaged());
        }
        let mut says = Vec::new();
        let read = file.take(length).read_to_end(&mut says);
        read.map_err(|e| Error::io(&self.path, "cannot be read", e))?;
        if (says.len() as u64) < length {
            return Ok(None);
        }
        if Sha256::digest(&says)[..] != body[20..] {
            return Err(damaged());
        }
        Ok(Some(says))
    }

    fn another(&self, was: &[u8], is: &Map<String, Value>) -> Error {
        let was: Map<String, Value> = serde_json::from_slice(was).unwrap_or_default();
        let changes = changes(&was, is).join("; ");
        let cure = Words::from("name another folder, or start over with ")
            + Argument("restart")
            + " (which discards its evidence)";
        Error::input(
            &self.path,
            Words::from(format!("contains evidence of another study: {changes}. ")) + cure,
        )
    }

    /// Passes every complete record to `take`, with the place of its planes. `is_known` decides whether such a record
    /// exists, and `take` whether its planes could be unpacked.
    pub(super) fn read(
        &mut self,
        is_known: impl Fn(RecordKey) -> bool,
        mut take: impl FnMut(RecordKey, u64, PackedPlanes) -> bool,
    ) -> Result<FileContents> {
        let mut found = FileContents::default();
        let (Some(mut file), true) = (self.file.as_ref(), self.end > 0) else { return Ok(found) };
        let unreadable = |e| Error::io(&self.path, "cannot be read", e);
        let length = file.metadata().map_err(unreadable)?.len();
        file.seek(SeekFrom::Start(self.end)).map_err(unreadable)?;
        let mut reader = BufReader::with_capacity(1 << 20, file);
        let mut payload = Vec::new();
        while self.end + RECORD_BYTES as u64 <= length {
            let mut record = [0; RECORD_BYTES];
            reader.read_exact(&mut record).map_err(unreadable)?;
            let (body, sum) = record.split_at(RECORD_BYTES - CHECK_BYTES);
            let number = |at: usize| u32::from_le_bytes(std::array::from_fn(|i| body[4 * at + i])) as usize;
            let key = RecordKey { item: number(0), world: number(1), repeat: number(2) };
            if checksum([&self.fingerprint, body]) != sum || !is_known(key) {
                found.is_cut = true;
                break;
            }
            let lengths: [usize; SAID] = std::array::from_fn(|plane| number(3 + plane));
            let bytes = lengths.iter().sum::<usize>();
            let next = self.end + (RECORD_BYTES + bytes) as u64;
            if next > length {
                break;
            }
            payload.resize(bytes, 0);
            reader.read_exact(&mut payload).map_err(unreadable)?;
            let mut left = &payload[..];
            let planes = lengths.map(|length| left.split_off(..length).unwrap_or_default().to_vec());
            let is_whole = checksum([&self.fingerprint, &payload]) == body[4 * NUMBERS..];
            if !is_whole || !take(key, self.end + RECORD_BYTES as u64, planes) {
                found.damaged.push(key);
            }
            self.end = next;
        }
        Ok(found)
    }

    /// Appends records, and returns the places of their planes.
    pub(super) fn append<'r>(
        &mut self,
        records: impl Iterator<Item = (RecordKey, &'r PackedPlanes)>,
    ) -> Result<Vec<u64>> {
        let mut bytes = Vec::new();
        if self.end == 0 {
            bytes.extend(MAGIC);
            bytes.extend(VERSION.to_le_bytes());
            bytes.extend((self.says.len() as u64).to_le_bytes());
            bytes.extend(self.fingerprint);
            bytes.extend(checksum([&bytes, &[]]));
            bytes.extend(&self.says);
        }
        let mut places = Vec::new();
        for (key, said) in records {
            places.push(self.end + (bytes.len() + RECORD_BYTES) as u64);
            bytes.extend(self.record(key, said));
        }
        let begins = self.end == 0;
        let mut file = match &self.file {
            Some(file) => file,
            None => self.file.insert(open_alone(&self.path)?),
        };
        let mut write = || {
            // Torn records, and all after a damaged one, are overwritten.
            file.set_len(self.end)?;
            file.seek(SeekFrom::Start(self.end))?;
            file.write_all(&bytes)?;
            if begins {
                file.sync_all()?;
                sync_folder_of(&self.path)?;
            }
            Ok(())
        };
        write().map_err(|e| Error::storage(&self.path, e))?;
        self.end += bytes.len() as u64;
        if self.unsynced_since.get_or_insert_with(Instant::now).elapsed() >= SYNC_EVERY {
            self.sync()?;
        }
        Ok(places)
    }

    fn record(&self, key: RecordKey, said: &PackedPlanes) -> Vec<u8> {
        let numbers = [key.item, key.world, key.repeat].into_iter().chain(said.iter().map(Vec::len));
        let number =
            |number| u32::try_from(number).expect("no study has as many poses or voxels").to_le_bytes();
        let payload = said.concat();
        let mut record: Vec<u8> = numbers.flat_map(number).collect();
        record.extend(checksum([&self.fingerprint, &payload]));
        record.extend(checksum([&self.fingerprint, &record]));
        record.extend(payload);
        record
    }

    /// Syncs all evidence to disk.
    pub(super) fn sync(&mut self) -> Result<()> {
        self.unsynced_since = None;
        let synced = self.file.as_ref().map_or(Ok(()), File::sync_data);
        synced.map_err(|e| Error::storage(&self.path, e))
    }
}
