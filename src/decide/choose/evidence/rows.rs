//! The bits of candidates in the file of the folder, from which they are read each time that they are asked for.

use std::borrow::Cow;
use std::fs::File;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::PathBuf;
use std::sync::OnceLock;

use super::file::CandidateWords;
use perirobot_cover::layout::{BitLayout, PLANES, SPACE_OF};
use perirobot_cover::{Row, RowStore};
use perirobot_march::Error;

/// Rows in a file.
#[derive(Debug)]
pub(super) struct FiledRows {
    pub(super) path: PathBuf,
    /// Of each candidate the places of its records, repeat by repeat and in each world by world; of what has no
    /// noise one repeat.
    pub(super) places: Vec<Vec<RecordPlace>>,
    /// Of each candidate the planes that are needed.
    pub(super) needed: Vec<[bool; PLANES]>,
    /// Why a row could not be read.
    pub(super) failed: OnceLock<io::Error>,
}

/// Where the words of a record begin, which planes it has, and a hash of each, by which it is known again.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RecordPlace {
    pub(super) at: u64,
    pub(super) has: [bool; PLANES],
    hashes: [u64; PLANES],
}

impl RecordPlace {
    /// The place of a record with these words.
    pub(super) fn new(at: u64, said: &CandidateWords) -> RecordPlace {
        RecordPlace {
            at,
            has: std::array::from_fn(|plane| !said[plane].is_empty()),
            hashes: std::array::from_fn(|plane| hash_of(&said[plane])),
        }
    }
}

/// A hash that is compared within one process only.
fn hash_of(words: &[u64]) -> u64 {
    let mut hasher = DefaultHasher::new();
    words.hash(&mut hasher);
    hasher.finish()
}

impl RowStore for FiledRows {
    fn has_bits(&self, item: usize, plane: usize) -> bool {
        self.needed[item][plane] && self.places[item].iter().any(|place| place.has[plane])
    }

    fn row(&self, layout: &BitLayout, item: usize, wanted: [bool; PLANES]) -> Row<'_> {
        self.read(layout, item, wanted).unwrap_or_else(|error| {
            let _ = self.failed.set(error);
            Default::default()
        })
    }

    fn failure(&self) -> Option<Error> {
        let error = self.failed.get()?;
        let error = io::Error::new(error.kind(), error.to_string());
        Some(Error::io(&self.path, "cannot be read", error))
    }
}

impl FiledRows {
    fn read(&self, layout: &BitLayout, item: usize, wanted: [bool; PLANES]) -> io::Result<Row<'_>> {
        let mut file = File::open(&self.path)?;
        let (places, mut bytes) = (&self.places[item], Vec::new());
        let mut planes: [Vec<u64>; PLANES] = Default::default();
        for (number, moment) in layout.moments.iter().enumerate() {
            // What has no noise says the same in all repeats.
            let place = places[number % places.len()];
            let words = |plane: usize| moment.words[SPACE_OF[plane]].clone();
            let mut at = place.at;
            for plane in (0..PLANES).filter(|&plane| place.has[plane]) {
                let length = 8 * words(plane).len();
                if wanted[plane] && self.needed[item][plane] {
                    bytes.resize(length, 0);
                    file.seek(SeekFrom::Start(at))?;
                    file.read_exact(&mut bytes)?;
                    planes[plane].resize(layout.words[SPACE_OF[plane]], 0);
                    let (eights, _) = bytes.as_chunks::<8>();
                    let read = eights.iter().map(|word| u64::from_le_bytes(*word));
                    let to = &mut planes[plane][words(plane)];
                    to.iter_mut().zip(read).for_each(|(to, word)| *to = word);
                    if hash_of(to) != place.hashes[plane] {
                        return Err(io::Error::other("other bytes were read than were written"));
                    }
                }
                at += length as u64;
            }
        }
        Ok(planes.map(Cow::Owned))
    }
}
