//! What every sensor says at every candidate, cast once: rows of bits over the voxels of one region in all
//! scenes, snapshots and repeats. What a set of sensors scores is read from unions of them.

mod casting;
mod file;
mod rows;

use std::borrow::Cow;

#[cfg(test)]
use self::rows::HeldRow;
use self::rows::Rows;
use super::layout::{BitLayout, CLEAR, FALSE, PLANES, SPACE_OF, Wanted};
pub use casting::{Casting, CastingWatch};
pub use file::EVIDENCE;
use perirobot_march::backend::Backend;
use perirobot_march::metrics::Confusion;
use perirobot_march::voxel::{Joined, Ones};
use perirobot_march::{Error, Result};
use perirobot_study::study::Study;
use perirobot_study::world::World;
pub(super) use rows::Row;

/// The evidence of all candidates.
#[derive(Debug)]
pub struct CandidateEvidence {
    pub(super) layout: BitLayout,
    /// Sensor and candidate of each row, in study order.
    pub(super) items: Vec<[usize; 2]>,
    rows: Rows,
    /// How many bytes it may take, with all that is kept beside it.
    memory_bytes: u64,
    /// Counts its bits.
    pub(super) ones: Ones,
}

/// The union of what some candidates say. A voxel that any of them wrongly calls occupied is no longer free, so
/// it is set in the plane of free ones, where no candidate can add it.
#[derive(Clone, Debug)]
pub(super) struct Union {
    planes: [Vec<u64>; PLANES],
}

/// Bytes of evidence that may be kept unless something else is said.
pub const MEMORY_BYTES: u64 = 2 << 30;

impl CandidateEvidence {
    /// Casts every candidate of a study in all of its worlds, and keeps all of it in memory. `representations` is the
    /// representation of each sensor.
    ///
    /// # Errors
    /// When it does not fit so many bytes, before anything is cast; when the backend fails; `Error::Stopped`.
    pub fn cast(
        study: &Study,
        worlds: &[World],
        of: (usize, &[usize]),
        memory_bytes: u64,
        backend: &mut dyn Backend,
        watch: &mut dyn CastingWatch,
    ) -> Result<CandidateEvidence> {
        let mut casting = Casting::of(study, worlds, of, Wanted::ALL, memory_bytes, None)?;
        casting.run(backend, watch)?;
        Ok(casting.evidence())
    }

    /// How much memory the bits take; none if they are read from a file.
    pub fn bytes(&self) -> u64 {
        match &self.rows {
            Rows::Held(rows) => {
                rows.iter().flat_map(|row| &row.planes).map(|plane| 8 * plane.len() as u64).sum()
            }
            Rows::Filed(_) => 0,
        }
    }

    /// How much memory may be taken besides.
    pub(super) fn spare_bytes(&self) -> u64 {
        self.memory_bytes.saturating_sub(self.bytes())
    }

    /// Whether rows are read from a file each time that they are asked for, so that only short searches pay.
    pub fn is_filed(&self) -> bool {
        matches!(self.rows, Rows::Filed(_))
    }

    /// Whether all rows could be read that were asked for.
    ///
    /// # Errors
    /// `Error::Storage` if one could not.
    pub fn was_read(&self) -> Result<()> {
        match &self.rows {
            Rows::Filed(rows) => match rows.failed.get() {
                Some(error) => {
                    let error = std::io::Error::new(error.kind(), error.to_string());
                    Err(Error::io(&rows.path, "cannot be read", error))
                }
                None => Ok(()),
            },
            Rows::Held(_) => Ok(()),
        }
    }

    /// How many candidates there are.
    pub fn count(&self) -> usize {
        self.items.len()
    }

    /// Evidence of these candidates, made up.
    #[cfg(test)]
    pub(super) fn made_up(
        layout: BitLayout,
        items: Vec<[usize; 2]>,
        planes: Vec<[Vec<u64>; PLANES]>,
    ) -> CandidateEvidence {
        let blank_if_zero = |plane: Vec<u64>| match plane.iter().all(|&word| word == 0) {
            true => Box::default(),
            false => plane.into(),
        };
        let rows = planes.into_iter().map(|planes| HeldRow { planes: planes.map(blank_if_zero) }).collect();
        CandidateEvidence { layout, items, rows: Rows::Held(rows), memory_bytes: u64::MAX, ones: Ones::new() }
    }

    /// What the candidates of a set score together in the region, moment by moment: repeat by repeat, and in
    /// each scene by scene and snapshot by snapshot, as a sweep counts it.
    pub fn counts(&self, set: &[usize]) -> Vec<Confusion> {
        let mut union = self.nothing();
        set.iter().for_each(|&item| union.add(self, item));
        self.counts_of(&union, None, Wanted::ALL)
    }

    /// One of the six planes of a candidate; empty if no bit is set.
    #[inline]
    pub(super) fn plane(&self, item: usize, plane: usize) -> Cow<'_, [u64]> {
        match &self.rows {
            Rows::Held(rows) => Cow::Borrowed(&rows[item].planes[plane]),
            filed => {
                let mut wanted = [false; PLANES];
                wanted[plane] = true;
                std::mem::take(&mut filed.row(&self.layout, item, wanted)[plane])
            }
        }
    }

    /// Whether a candidate has a bit in one of the six planes.
    pub(super) fn has_bits(&self, item: usize, plane: usize) -> bool {
        match &self.rows {
            Rows::Held(rows) => !rows[item].planes[plane].is_empty(),
            Rows::Filed(rows) => rows.has_bits(item, plane),
        }
    }

    /// What a candidate says.
    pub(super) fn row(&self, item: usize) -> Row<'_> {
        self.rows.row(&self.layout, item, [true; PLANES])
    }

    /// The union of no candidate.
    pub(super) fn nothing(&self) -> Union {
        Union { planes: std::array::from_fn(|plane| vec![0; self.layout.words[SPACE_OF[plane]]]) }
    }

    /// What a union scores, moment by moment, with one more candidate or as it is.
    pub(super) fn counts_of(&self, union: &Union, more: Option<&Row>, wanted: Wanted) -> Vec<Confusion> {
        let more = |plane: usize| more.map_or(&[][..], |row| &row[plane]);
        self.counts_of_planes(&union.planes, more, wanted)
    }

    /// What six planes score, joined with six more.
    pub(super) fn counts_of_planes<'a>(
        &self,
        planes: &'a [Vec<u64>; PLANES],
        more: impl Fn(usize) -> &'a [u64],
        wanted: Wanted,
    ) -> Vec<Confusion> {
        let planes: [Joined; PLANES] = std::array::from_fn(|plane| Joined::of(&planes[plane], more(plane)));
        let counts = |moment| self.layout.counts(self.ones, moment, &planes, wanted);
        self.layout.moments.iter().map(counts).collect()
    }
}

impl Union {
    /// One of the six planes.
    pub(super) fn plane(&self, plane: usize) -> &[u64] {
        &self.planes[plane]
    }

    /// Joins what a candidate says.
    pub(super) fn add(&mut self, evidence: &CandidateEvidence, item: usize) {
        let row = evidence.row(item);
        for (to, from) in self.planes.iter_mut().zip(&row) {
            to.iter_mut().zip(&**from).for_each(|(to, from)| *to |= from);
        }
        self.planes[CLEAR].iter_mut().zip(&*row[FALSE]).for_each(|(to, from)| *to |= from);
    }
}
