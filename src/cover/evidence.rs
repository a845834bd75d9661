//! What every candidate says: rows of bits over the voxels of one region in all scenes, snapshots and repeats. What a set
//! of candidates scores is read from unions of them.

use std::borrow::Cow;
use std::fmt::Debug;

use super::layout::{BitLayout, CLEAR, FALSE, HIT, MISSED, MomentBits, PLANES, SPACE_OF, WantedCounts};
use perirobot_march::metrics::{Confusion, Overlap};
use perirobot_march::voxel::{Joined, Ones};
use perirobot_march::{Error, Result};

/// A row that was asked for: each of the six planes; empty if no bit is set.
pub type Row<'a> = [Cow<'a, [u64]>; PLANES];

/// Rows that are not in memory, and read each time that they are asked for.
pub trait RowStore: Debug + Send + Sync {
    /// Whether a candidate has a bit in one of the six planes.
    fn has_bits(&self, item: usize, plane: usize) -> bool;

    /// Some planes of a candidate. They are empty if they cannot be read, and then `failure` says why.
    fn row(&self, layout: &BitLayout, item: usize, wanted: [bool; PLANES]) -> Row<'_>;

    /// Why a row could not be read, if that is so.
    fn failure(&self) -> Option<Error>;
}

/// The bits of all candidates.
#[derive(Debug)]
enum CandidateRows {
    /// Nothing of a plane without a bit.
    Held(Vec<[Box<[u64]>; PLANES]>),
    Stored(Box<dyn RowStore>),
}

/// The evidence of all candidates.
#[derive(Debug)]
pub struct CandidateEvidence {
    /// Which bit is which voxel.
    pub layout: BitLayout,
    /// Sensor and candidate of each row, in study order.
    pub items: Vec<[usize; 2]>,
    rows: CandidateRows,
    /// How many bytes it may take, with all that is kept beside it.
    memory_bytes: u64,
    /// Counts its bits.
    pub(crate) ones: Ones,
}

/// The union of what some candidates say. A voxel that any of them wrongly calls occupied is no longer free, so
/// it is set in the plane of free ones, where no candidate can add it.
#[derive(Clone, Debug)]
pub struct Union {
    planes: [Vec<u64>; PLANES],
}

impl CandidateEvidence {
    /// Evidence in memory: for each of `items`, which are sensor and candidate, its six planes; nothing of a plane without
    /// a bit. A search may take `memory_bytes` with it.
    pub fn from_memory(
        layout: BitLayout,
        items: Vec<[usize; 2]>,
        rows: Vec<[Box<[u64]>; PLANES]>,
        memory_bytes: u64,
    ) -> CandidateEvidence {
        CandidateEvidence { layout, items, rows: CandidateRows::Held(rows), memory_bytes, ones: Ones::new() }
    }

    /// Evidence that is elsewhere.
    pub fn from_source(
        layout: BitLayout,
        items: Vec<[usize; 2]>,
        rows: Box<dyn RowStore>,
        memory_bytes: u64,
    ) -> CandidateEvidence {
        CandidateEvidence {
            layout,
            items,
            rows: CandidateRows::Stored(rows),
            memory_bytes,
            ones: Ones::new(),
        }
    }

    /// How much memory the bits take; none if they are read from a file.
    pub fn bytes(&self) -> u64 {
        match &self.rows {
            CandidateRows::Held(rows) => rows.iter().flatten().map(|plane| 8 * plane.len() as u64).sum(),
            CandidateRows::Stored(_) => 0,
        }
    }

    /// How much memory may be taken besides.
    pub fn spare_bytes(&self) -> u64 {
        self.memory_bytes.saturating_sub(self.bytes())
    }

    /// Whether rows are read from a file each time that they are asked for, so that only short searches pay.
    pub fn is_filed(&self) -> bool {
        matches!(self.rows, CandidateRows::Stored(_))
    }

    /// Whether all rows could be read that were asked for.
    ///
    /// # Errors
    /// `Error::Storage` if one could not.
    pub fn was_read(&self) -> Result<()> {
        match &self.rows {
            CandidateRows::Held(_) => Ok(()),
            CandidateRows::Stored(rows) => rows.failure().map_or(Ok(()), Err),
        }
    }

    /// How many candidates there are.
    pub fn count(&self) -> usize {
        self.items.len()
    }

    /// Evidence of these candidates, made up.
    #[cfg(test)]
    pub(crate) fn made_up(
        layout: BitLayout,
        items: Vec<[usize; 2]>,
        planes: Vec<[Vec<u64>; PLANES]>,
    ) -> CandidateEvidence {
        let blank_if_zero = |plane: Vec<u64>| match plane.iter().all(|&word| word == 0) {
            true => Box::default(),
            false => plane.into(),
        };
        let rows = planes.into_iter().map(|planes| planes.map(blank_if_zero)).collect();
        CandidateEvidence::from_memory(layout, items, rows, u64::MAX)
    }

    /// What the candidates of a set score together in the region, moment by moment: repeat by repeat, and in
    /// each scene by scene and snapshot by snapshot, as a sweep counts it.
    pub fn counts(&self, set: &[usize]) -> Vec<Confusion> {
        let mut union = self.nothing();
        set.iter().for_each(|&item| union.add(self, item));
        self.counts_of(&union, None, WantedCounts::ALL)
    }

    /// What a set counts, moment by moment, with what at least two of its members label. People's voxels that two of them
    /// hit are not counted.
    pub fn counts_with_overlap(&self, set: &[usize]) -> Vec<Confusion> {
        let twice: [Vec<u64>; 2] = [[HIT, MISSED], [FALSE, CLEAR]].map(|planes| {
            let words = self.layout.words[SPACE_OF[planes[0]]];
            let (mut once, mut twice) = (vec![0u64; words], vec![0u64; words]);
            for &item in set {
                let rows = planes.map(|plane| self.plane(item, plane));
                let bits = |word: usize| rows.iter().fold(0, |bits, row| bits | row.get(word).unwrap_or(&0));
                for word in 0..words {
                    twice[word] |= once[word] & bits(word);
                    once[word] |= bits(word);
                }
            }
            twice
        });
        let of_moment = |(counts, moment): (Confusion, &MomentBits)| {
            let ones =
                |space: usize| twice[space][moment.words[space].clone()].iter().map(|word| word.count_ones());
            let twice = (0..2).flat_map(ones).map(u64::from).sum();
            counts.with_overlap(Overlap { twice, hit_human_twice: 0 })
        };
        self.counts(set).into_iter().zip(&self.layout.moments).map(of_moment).collect()
    }

    /// One of the six planes of a candidate; empty if no bit is set.
    #[inline]
    pub fn plane(&self, item: usize, plane: usize) -> Cow<'_, [u64]> {
        match &self.rows {
            CandidateRows::Held(rows) => Cow::Borrowed(&rows[item][plane]),
            CandidateRows::Stored(rows) => {
                let mut wanted = [false; PLANES];
                wanted[plane] = true;
                std::mem::take(&mut rows.row(&self.layout, item, wanted)[plane])
            }
        }
    }

    /// Whether a candidate has a bit in one of the six planes.
    pub fn has_bits(&self, item: usize, plane: usize) -> bool {
        match &self.rows {
            CandidateRows::Held(rows) => !rows[item][plane].is_empty(),
            CandidateRows::Stored(rows) => rows.has_bits(item, plane),
        }
    }

    /// What a candidate says.
    pub fn row(&self, item: usize) -> Row<'_> {
        match &self.rows {
            CandidateRows::Held(rows) => rows[item].each_ref().map(|plane| Cow::Borrowed(&plane[..])),
            CandidateRows::Stored(rows) => rows.row(&self.layout, item, [true; PLANES]),
        }
    }

    /// The union of no candidate.
    pub fn nothing(&self) -> Union {
        Union { planes: std::array::from_fn(|plane| vec![0; self.layout.words[SPACE_OF[plane]]]) }
    }

    /// What a union scores, moment by moment, with one more candidate or as it is.
    pub fn counts_of(&self, union: &Union, more: Option<&Row>, wanted: WantedCounts) -> Vec<Confusion> {
        let more = |plane: usize| more.map_or(&[][..], |row| &row[plane]);
        self.counts_of_planes(&union.planes, more, wanted)
    }

    /// What six planes score, joined with six more.
    pub fn counts_of_planes<'a>(
        &self,
        planes: &'a [Vec<u64>; PLANES],
        more: impl Fn(usize) -> &'a [u64],
        wanted: WantedCounts,
    ) -> Vec<Confusion> {
        let planes: [Joined; PLANES] = std::array::from_fn(|plane| Joined::new(&planes[plane], more(plane)));
        let counts = |moment| self.layout.counts(self.ones, moment, &planes, wanted);
        self.layout.moments.iter().map(counts).collect()
    }
}

impl Union {
    /// One of the six planes.
    pub fn plane(&self, plane: usize) -> &[u64] {
        &self.planes[plane]
    }

    /// Joins what a candidate says.
    pub fn add(&mut self, evidence: &CandidateEvidence, item: usize) {
        let row = evidence.row(item);
        (0..PLANES).for_each(|plane| self.add_plane(plane, &row[plane]));
    }

    /// Joins what a candidate says in some of the six planes.
    pub(crate) fn add_planes(&mut self, evidence: &CandidateEvidence, item: usize, wanted: [bool; PLANES]) {
        for plane in (0..PLANES).filter(|&plane| wanted[plane]) {
            self.add_plane(plane, &evidence.plane(item, plane));
        }
    }

    fn add_plane(&mut self, plane: usize, row: &[u64]) {
        join(&mut self.planes[plane], row);
        if plane == FALSE {
            join(&mut self.planes[CLEAR], row);
        }
    }
}

fn join(to: &mut [u64], from: &[u64]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to |= from);
}
