//! What every sensor says at every candidate, cast once: rows of bits over the voxels of one region in all
//! scenes, snapshots and repeats. What a set of sensors scores is read from unions of them.

mod casting;
mod file;

use fearless_simd::{Level, Simd, dispatch};

use super::layout::{BitLayout, CLEAR, FALSE, Joined, PLANES, SPACE_OF, Wanted};
use crate::Result;
use crate::backend::Backend;
use crate::metrics::Confusion;
use crate::study::Study;
use crate::world::World;
pub use casting::{Casting, CastingWatch};
pub use file::EVIDENCE;

/// The evidence of all candidates.
#[derive(Debug)]
pub struct CandidateEvidence {
    pub(super) layout: BitLayout,
    /// Sensor and candidate of each row, in study order.
    pub(super) items: Vec<[usize; 2]>,
    rows: Vec<CandidateBits>,
    level: Level,
}

/// What one candidate says: bits of all moments; nothing of a plane without a bit.
#[derive(Clone, Debug, Default)]
struct CandidateBits {
    planes: [Box<[u64]>; PLANES],
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

    /// How much memory it takes.
    pub fn bytes(&self) -> u64 {
        self.rows.iter().flat_map(|row| &row.planes).map(|plane| 8 * plane.len() as u64).sum()
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
        let rows =
            planes.into_iter().map(|planes| CandidateBits { planes: planes.map(blank_if_zero) }).collect();
        CandidateEvidence { layout, items, rows, level: Level::new() }
    }

    /// What the candidates of a set score together in the region, moment by moment: repeat by repeat, and in
    /// each scene by scene and snapshot by snapshot, as a sweep counts it.
    pub fn counts(&self, set: &[usize]) -> Vec<Confusion> {
        let mut union = self.nothing();
        set.iter().for_each(|&item| union.add(self, item));
        self.counts_of(&union, None, Wanted::ALL)
    }

    /// One of the six planes of a candidate; empty if no bit is set.
    pub(super) fn plane(&self, item: usize, plane: usize) -> &[u64] {
        &self.rows[item].planes[plane]
    }

    /// The union of no candidate.
    pub(super) fn nothing(&self) -> Union {
        Union { planes: std::array::from_fn(|plane| vec![0; self.layout.words[SPACE_OF[plane]]]) }
    }

    /// What a union scores, moment by moment, with one more candidate or as it is.
    pub(super) fn counts_of(&self, union: &Union, more: Option<usize>, wanted: Wanted) -> Vec<Confusion> {
        let more = |plane| more.map_or(&[][..], |item| self.plane(item, plane));
        let planes: [Joined; PLANES] =
            std::array::from_fn(|plane| Joined::of(&union.planes[plane], more(plane)));
        dispatch!(self.level, simd => all_counts(simd, &self.layout, &planes, wanted))
    }
}

impl Union {
    /// One of the six planes.
    pub(super) fn plane(&self, plane: usize) -> &[u64] {
        &self.planes[plane]
    }

    /// Joins what a candidate says.
    pub(super) fn add(&mut self, evidence: &CandidateEvidence, item: usize) {
        for (to, from) in self.planes.iter_mut().zip(&evidence.rows[item].planes) {
            to.iter_mut().zip(from).for_each(|(to, from)| *to |= from);
        }
        let wrong = &evidence.rows[item].planes[FALSE];
        self.planes[CLEAR].iter_mut().zip(wrong).for_each(|(to, from)| *to |= from);
    }
}

#[inline(always)]
fn all_counts<S: Simd>(
    _: S,
    layout: &BitLayout,
    planes: &[Joined; PLANES],
    wanted: Wanted,
) -> Vec<Confusion> {
    layout.moments.iter().map(|moment| layout.counts(moment, planes, wanted)).collect()
}
