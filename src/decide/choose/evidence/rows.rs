//! The bits of candidates in the folder's file, which are read at each use.

use std::borrow::Cow;
use std::fs::File;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

use super::super::layout::RegionPlaces;
use super::super::planes::{SAID, SAID_OF, unpack};
use super::file::PackedPlanes;
use perirobot_cover::layout::{BitLayout, PLANES, SPACE_OF};
use perirobot_cover::{Row, RowStore};
use perirobot_march::Error;
use perirobot_march::voxel::Window;

/// Records in a file.
#[derive(Debug)]
pub(super) struct FiledRecords {
    pub(super) path: PathBuf,
    /// The places of each candidate's records, repeat by repeat and then world by world; without noise one repeat.
    pub(super) places: Vec<Vec<RecordPlace>>,
    /// The voxels of the planes of each world.
    pub(super) windows: Vec<Window>,
    /// Why a row could not be read.
    pub(super) failed: OnceLock<io::Error>,
}

/// Rows of a region, read from such records.
#[derive(Debug)]
pub(super) struct FiledRows {
    pub(super) records: Arc<FiledRecords>,
    /// The places of the region in the planes of each world.
    pub(super) region: Vec<RegionPlaces>,
    /// The planes of each candidate that are needed and have a bit.
    pub(super) has: Vec<[bool; PLANES]>,
}

/// The start of a record's planes, their lengths, and a hash of each to detect changes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RecordPlace {
    at: u64,
    lengths: [usize; SAID],
    hashes: [u64; SAID],
}

impl RecordPlace {
    /// The place of a record with these planes.
    pub(super) fn new(at: u64, packed: &PackedPlanes) -> RecordPlace {
        let packed = packed.each_ref();
        RecordPlace { at, lengths: packed.map(Vec::len), hashes: packed.map(|plane| hash_of(plane)) }
    }

    /// Reads one of its planes, packed.
    fn read(&self, file: &mut File, plane: usize) -> io::Result<Vec<u8>> {
        let mut packed = vec![0; self.lengths[plane]];
        file.seek(SeekFrom::Start(self.at + self.lengths[..plane].iter().sum::<usize>() as u64))?;
        file.read_exact(&mut packed)?;
        match hash_of(&packed) == self.hashes[plane] {
            true => Ok(packed),
            false => Err(io::Error::other("the bytes have changed since they were written")),
        }
    }
}

/// A hash for comparisons within one process.
fn hash_of(packed: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    packed.hash(&mut hasher);
    hasher.finish()
}

impl RowStore for FiledRows {
    fn has_bits(&self, item: usize, plane: usize) -> bool {
        self.has[item][plane]
    }

    fn row(&self, layout: &BitLayout, item: usize, wanted: [bool; PLANES]) -> Row<'_> {
        self.read(layout, item, wanted).unwrap_or_else(|error| {
            let _ = self.records.failed.set(error);
            Default::default()
        })
    }

    fn failure(&self) -> Option<Error> {
        let error = self.records.failed.get()?;
        let error = io::Error::new(error.kind(), error.to_string());
        Some(Error::io(&self.records.path, "cannot be read", error))
    }
}

impl FiledRows {
    fn read(&self, layout: &BitLayout, item: usize, wanted: [bool; PLANES]) -> io::Result<Row<'_>> {
        let FiledRecords { path, places, windows, .. } = &*self.records;
        let (mut file, places) = (File::open(path)?, &places[item]);
        let mut rows: [Vec<u64>; PLANES] = Default::default();
        for (number, place) in places.iter().enumerate() {
            let world = number % windows.len();
            for said in 0..SAID {
                let picked = (0..PLANES)
                    .filter(|&plane| SAID_OF[plane] == said && wanted[plane] && self.has[item][plane]);
                let picked: Vec<usize> = picked.collect();
                if picked.is_empty() || place.lengths[said] == 0 {
                    continue;
                }
                let unpacked = unpack(&place.read(&mut file, said)?, windows[world]);
                let unpacked = unpacked.ok_or_else(|| io::Error::other("the plane cannot be unpacked"))?;
                for plane in picked {
                    let words = self.region[world].pick(plane, &unpacked);
                    if words.is_empty() {
                        continue;
                    }
                    let row = &mut rows[plane];
                    row.resize(layout.words[SPACE_OF[plane]], 0);
                    // Sensors without noise have the same evidence in all repeats.
                    for moment in layout.moments.iter().skip(number).step_by(places.len()) {
                        row[moment.words[SPACE_OF[plane]].clone()].copy_from_slice(&words);
                    }
                }
            }
        }
        Ok(rows.map(Cow::Owned))
    }
}
