//! The bytes of a journal: a header with the sweep and the shard, and records of one size.
//!
//! All numbers are little-endian. Header, 128 bytes: magic, format version (u32), shard's number and number of shards
//! (u32 each), blocks, rows of a block, first and end of the rows of each block in this file (u64 each), the sweep's
//! fingerprint (32 bytes), zeros, and in the last 8 bytes a checksum of the rest. Record, 96 bytes: row (u64), twelve
//! counts in the order of [`Confusion::counts`], five in that of [`Detection::counts`], a bit for each missed body
//! part, and two counts in the order of [`Overlap::counts`] (u32 each), checksum (8 bytes).

use std::fmt;
use std::ops::Range;

use crate::results::checksum::{CHECK_BYTES, checksum};
use perirobot_march::metrics::{COUNTERS, Confusion, DETECTION_COUNTERS, Detection, Overlap};

/// Bytes before the first record.
pub(super) const HEADER_BYTES: usize = 128;

/// Bytes of a record.
pub(super) const RECORD_BYTES: usize = 96;

/// The first bytes of every journal.
const MAGIC: [u8; 8] = *b"PeRSjrnl";

/// Version of this format.
const VERSION: u32 = 3;

/// Why a file cannot be resumed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unfit {
    /// It is not a journal.
    Foreign,
    /// It has another format version.
    Format(u32),
    /// Its header is damaged.
    Damaged,
}

impl fmt::Display for Unfit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Unfit::Foreign => write!(f, "is not a journal of perirobot"),
            Unfit::Format(format) => {
                write!(f, "is a journal of format {format}, but this perirobot writes {VERSION}")
            }
            Unfit::Damaged => write!(f, "has a damaged beginning"),
        }
    }
}

/// One of several parts of a sweep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Shard {
    /// Its number, counted from 0.
    pub number: u32,
    /// The number of parts.
    pub of: u32,
}

impl Shard {
    /// The only part.
    pub const WHOLE: Shard = Shard { number: 0, of: 1 };
}

/// The sweep and rows of a journal.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JournalHeader {
    /// Hash of everything that affects the counts.
    pub fingerprint: [u8; 32],
    /// The part of the sweep.
    pub shard: Shard,
    /// The number of blocks (repeats of moments) of the sweep.
    pub blocks: u64,
    /// The number of rows in each block.
    pub block_rows: u64,
    /// The rows of each block in this file.
    pub kept: Range<u64>,
}

/// The state of a row's place.
#[derive(Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "one at a time is looked at, and most are finished rows")]
pub(super) enum State {
    Missing,
    Finished(Confusion),
    Damaged,
}

impl JournalHeader {
    /// The rows of a block in this file.
    pub fn rows_of_block(&self, block: u64) -> Range<u64> {
        let before = block * self.block_rows;
        before + self.kept.start..before + self.kept.end
    }

    /// The number of rows in this file.
    pub fn rows(&self) -> u64 {
        self.blocks * (self.kept.end - self.kept.start)
    }

    /// The place of a row in this file.
    pub(super) fn place(&self, row: u64) -> u64 {
        let (block, within) = (row / self.block_rows, row % self.block_rows);
        debug_assert!(self.kept.contains(&within), "row {row} is kept elsewhere");
        block * (self.kept.end - self.kept.start) + within - self.kept.start
    }

    /// The header as bytes.
    pub(super) fn bytes(&self) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend([VERSION, self.shard.number, self.shard.of].iter().flat_map(|n| n.to_le_bytes()));
        let numbers = [self.blocks, self.block_rows, self.kept.start, self.kept.end];
        bytes.extend(numbers.iter().flat_map(|n| n.to_le_bytes()));
        bytes.extend(self.fingerprint);
        bytes.resize(HEADER_BYTES - CHECK_BYTES, 0);
        bytes.extend(checksum([&bytes, &[]]));
        bytes
    }

    /// Parses the bytes of a header. Sums and products of a parsed header's numbers do not overflow.
    pub(super) fn parse(bytes: &[u8]) -> Result<JournalHeader, Unfit> {
        let (body, sum) = bytes.split_at(HEADER_BYTES - CHECK_BYTES);
        if !body.starts_with(&MAGIC) {
            return Err(Unfit::Foreign);
        }
        let u32_at = |at: usize| u32::from_le_bytes(std::array::from_fn(|i| body[at + i]));
        let u64_at = |at: usize| u64::from_le_bytes(std::array::from_fn(|i| body[at + i]));
        if u32_at(8) != VERSION {
            return Err(Unfit::Format(u32_at(8)));
        }
        let header = JournalHeader {
            fingerprint: std::array::from_fn(|i| body[52 + i]),
            shard: Shard { number: u32_at(12), of: u32_at(16) },
            blocks: u64_at(20),
            block_rows: u64_at(28),
            kept: u64_at(36)..u64_at(44),
        };
        let rows = header
            .blocks
            .checked_mul(header.block_rows)
            .and_then(|rows| rows.checked_mul(RECORD_BYTES as u64));
        let sound = header.kept.start < header.kept.end
            && header.kept.end <= header.block_rows
            && header.shard.number < header.shard.of;
        if checksum([body, &[]]) != sum || !sound || rows.is_none_or(|bytes| bytes > i64::MAX as u64) {
            return Err(Unfit::Damaged);
        }
        Ok(header)
    }

    /// A row as bytes.
    pub(super) fn record(&self, row: u64, counts: &Confusion) -> [u8; RECORD_BYTES] {
        let mut record = [0; RECORD_BYTES];
        record[..8].copy_from_slice(&row.to_le_bytes());
        let detection = &counts.detection;
        let missed = [detection.missed_bits().into()];
        let numbers = [&counts.counts()[..], &detection.counts(), &missed, &counts.overlap.counts()].concat();
        for (to, number) in record[8..].chunks_exact_mut(4).zip(numbers) {
            let number = u32::try_from(number).expect("no grid has more voxels");
            to.copy_from_slice(&number.to_le_bytes());
        }
        let (body, sum) = record.split_at_mut(RECORD_BYTES - CHECK_BYTES);
        sum.copy_from_slice(&checksum([&self.fingerprint, body]));
        record
    }

    /// The state of a record at the place of a row.
    pub(super) fn state(&self, row: u64, record: &[u8]) -> State {
        if record.iter().all(|byte| *byte == 0) {
            return State::Missing;
        }
        let (body, sum) = record.split_at(RECORD_BYTES - CHECK_BYTES);
        if body[..8] != row.to_le_bytes() || checksum([&self.fingerprint, body]) != sum {
            return State::Damaged;
        }
        let number = |at: usize| u32::from_le_bytes(std::array::from_fn(|i| body[8 + 4 * at + i]));
        let counts = std::array::from_fn(|i| number(i).into());
        let found = std::array::from_fn(|i| number(COUNTERS + i).into());
        let missed = COUNTERS + DETECTION_COUNTERS;
        let detection = Detection::from_counts(found, number(missed));
        let overlap = Overlap::from_counts(std::array::from_fn(|i| number(missed + 1 + i).into()));
        State::Finished(Confusion::from_counts(counts).with_detection(detection).with_overlap(overlap))
    }
}
