//! What every sensor says at every candidate, cast once: rows of bits over the voxels of one region in all
//! scenes, snapshots and repeats. What a set of sensors scores is read from unions of them.

use fearless_simd::{Level, Simd, dispatch};
use rayon::prelude::*;

use super::layout::{BitLayout, CLEAR, FALSE, Joined, PLANES, SPACE_OF, Wanted};
use crate::backend::Backend;
use crate::error::{Argument, Issue, Words};
use crate::metrics::Confusion;
use crate::results::PoseChoice;
use crate::study::{Combination, Member, Study};
use crate::sweep::{EvidenceReader, SensorSays, read_choices};
use crate::world::World;
use crate::{Error, Result};

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

/// Voxels that some candidates of a set call, hit or feel. What somebody calls occupied falsely nobody calls free
/// any more: it is among the free ones, where none can be added.
#[derive(Clone, Debug)]
pub(super) struct Union {
    planes: [Vec<u64>; PLANES],
}

/// Is told how the casting proceeds, and may stop it.
pub trait CastingWatch {
    /// So many more candidates were cast in some scene, snapshot and repeat.
    fn cast(&mut self, more: u64);

    /// Why nothing more is to be begun, if that is so.
    fn stop(&mut self) -> Option<String>;
}

/// Bytes of evidence that may be kept unless something else is said.
pub const MEMORY_BYTES: u64 = 2 << 30;

impl CandidateEvidence {
    /// How many rows of how many candidates there will be to cast.
    pub fn to_cast(study: &Study, worlds: &[World]) -> u64 {
        let of = |sensor: &crate::sensor::Sensor| {
            let repeats = if sensor.kind.is_noisy() { u64::from(study.repeats) } else { 1 };
            sensor.candidates.len() as u64 * repeats
        };
        study.sensors.iter().map(of).sum::<u64>() * worlds.len() as u64
    }

    /// Casts every candidate of a study in all of its worlds. `representations` is the representation of each sensor.
    ///
    /// # Errors
    /// When it does not fit so many bytes, before anything is cast; when the backend fails; `Error::Stopped`.
    pub fn cast(
        study: &Study,
        worlds: &[World],
        (region, representations): (usize, &[usize]),
        memory_bytes: u64,
        backend: &mut dyn Backend,
        progress: &mut dyn CastingWatch,
    ) -> Result<CandidateEvidence> {
        let layout = BitLayout::new(study, worlds, region);
        let alone = |(sensor, spec): (usize, &crate::sensor::Sensor)| Combination {
            name: spec.name.clone(),
            fusion: Default::default(),
            members: vec![Member { sensor, candidates: (0..spec.candidates.len()).collect() }],
        };
        let combinations: Vec<Combination> = study.sensors.iter().enumerate().map(alone).collect();
        let study = &Study { combinations, ..study.clone() };
        let choices = study.sensors.iter().enumerate();
        let choices = choices.flat_map(|(sensor, spec)| (0..spec.candidates.len()).map(move |c| [sensor, c]));
        let items: Vec<[usize; 2]> = choices.collect();
        let needed = items.len() as u64 * 8 * layout.words.iter().sum::<usize>() as u64;
        fits(needed, memory_bytes, items.len(), layout.moments.len())?;
        let pose_choices: Vec<PoseChoice> =
            items.iter().map(|&[combination, choice]| PoseChoice { combination, choice }).collect();
        let mut first = Vec::new();
        for sensor in &study.sensors {
            first.push(first.last().copied().unwrap_or(0) + sensor.candidates.len());
        }
        first.insert(0, 0);
        let noisy = study.sensors.iter().map(|sensor| sensor.kind.is_noisy()).collect();
        let rows = vec![CandidateBits::default(); items.len()];
        let mut taking =
            Taking { layout, rows, first, noisy, worlds, memory_bytes, bytes: 0, progress, stopped: None };
        read_choices(study, worlds, &pose_choices, representations, backend, &mut taking)?;
        match taking.stopped {
            Some(why) => Err(Error::Stopped(Issue::says(why))),
            None => {
                Ok(CandidateEvidence { layout: taking.layout, items, rows: taking.rows, level: Level::new() })
            }
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

/// Whether rows of bits fit, and what to do if they do not.
fn fits(needed: u64, memory_bytes: u64, candidates: usize, moments: usize) -> Result<()> {
    if needed <= memory_bytes {
        return Ok(());
    }
    let mib = |bytes: u64| bytes.div_ceil(1 << 20);
    let what = format!(
        "the evidence of {candidates} poses in {moments} scenes, snapshots and repeats takes {} MiB, and {} MiB are allowed",
        mib(needed),
        memory_bytes >> 20
    );
    let cure = Words::from("give ")
        + Argument::Memory.to(format!("{}MiB", mib(needed)))
        + ", or use larger voxels, a smaller region, or fewer poses";
    Err(Issue::too_large(what).wanted(cure).into())
}

/// Takes what sensors say as it comes.
struct Taking<'a> {
    layout: BitLayout,
    rows: Vec<CandidateBits>,
    /// The row of each sensor's first candidate.
    first: Vec<usize>,
    noisy: Vec<bool>,
    worlds: &'a [World],
    memory_bytes: u64,
    bytes: u64,
    progress: &'a mut dyn CastingWatch,
    stopped: Option<String>,
}

impl EvidenceReader for Taking<'_> {
    fn wants(&self, _: &World, repeat: usize, pose_choice: &PoseChoice) -> bool {
        repeat == 0 || self.noisy[pose_choice.combination]
    }

    fn take(&mut self, world: &World, repeat: usize, said: Vec<(PoseChoice, Vec<SensorSays>)>) -> Result<()> {
        let here = |other: &World| (other.scene, other.snapshot) == (world.scene, world.snapshot);
        let number = self.worlds.iter().position(here).expect("worlds are those that are cast");
        let layout = &self.layout;
        let picked: Vec<_> = said.par_iter().map(|(_, said)| layout.pick(number, said)).collect();
        let repeats = layout.moments.len() / layout.worlds();
        for ((pose_choice, _), picked) in said.iter().zip(picked) {
            // What has no noise says the same in all repeats.
            let repeats = if self.noisy[pose_choice.combination] { repeat..repeat + 1 } else { 0..repeats };
            let row = &mut self.rows[self.first[pose_choice.combination] + pose_choice.choice];
            for (plane, bits) in
                picked.iter().enumerate().filter(|(_, bits)| bits.iter().any(|&word| word != 0))
            {
                let words = layout.words[SPACE_OF[plane]];
                if row.planes[plane].is_empty() {
                    self.bytes += 8 * words as u64;
                    row.planes[plane] = vec![0; words].into();
                }
                for repeat in repeats.clone() {
                    let moment = &layout.moments[repeat * layout.worlds() + number];
                    row.planes[plane][moment.words[SPACE_OF[plane]].clone()].copy_from_slice(bits);
                }
            }
        }
        fits(self.bytes, self.memory_bytes, self.rows.len(), layout.moments.len())?;
        self.progress.cast(said.len() as u64);
        Ok(())
    }

    fn enough(&mut self) -> bool {
        self.stopped = self.stopped.take().or_else(|| self.progress.stop());
        self.stopped.is_some()
    }
}
