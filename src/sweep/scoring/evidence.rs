//! Stores evidence on the backend: that of each sensor at each candidate is made once and fused for all combinations.
//! When the slots run out, the oldest evidence is dropped.

use std::collections::{HashMap, HashSet, VecDeque};
use std::sync::Arc;

use rayon::prelude::*;

use crate::results::PoseChoice;
use perirobot_march::Result;
use perirobot_march::backend::{Backend, GridPose, Planes, Rays, Reading, Shot, Slot};
use perirobot_march::error::{Argument, Issue, Words};
use perirobot_march::voxel::Window;
use perirobot_scene::truth::Truth;
use perirobot_study::input::Study;
use perirobot_study::sensor::{Claim, Station};
use perirobot_study::world::World;

/// Largest batch for a backend; a single choice may be more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BatchSize {
    /// Jobs: a choice in one representation counts as one.
    pub jobs: usize,
    /// Cast rays, or fewer if those keep the backend busy.
    pub rays: usize,
}

impl BatchSize {
    /// Enough to keep any device busy.
    pub const FULL: BatchSize = BatchSize { jobs: 4096, rays: usize::MAX };

    /// For a device that failed at more: about one camera.
    pub const SMALL: BatchSize = BatchSize { jobs: 256, rays: 1 << 20 };

    /// The rays of a batch on a backend.
    pub fn rays_on(&self, backend: &dyn Backend) -> usize {
        self.rays.min(backend.rays_at_once())
    }
}

/// A sensor at a candidate, in one repeat; sensors without noise have the same evidence in all repeats.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct EvidenceKey {
    sensor: usize,
    candidate: usize,
    repeat: usize,
}

/// The slots of the first hits of a sensor at a candidate: by the indices of both.
pub(super) type FirstHitSlots = HashMap<(usize, usize), Slot>;

/// The slots of a piece of evidence.
struct HeldEvidence {
    /// All its slots.
    slots: Vec<Slot>,
    /// For each representation, its contribution to a fusion; `None` without evidence.
    readings: Vec<Option<Reading>>,
}

/// The evidence of one world on a backend.
pub(super) struct Store<'a> {
    pub(super) study: &'a Study,
    pub(super) world: &'a World,
    truth: Arc<Truth>,
    tables: &'a [Option<Rays>],
    /// The slots of first hits on the backend.
    first_hits: &'a FirstHitSlots,
    window: Window,
    held: HashMap<EvidenceKey, HeldEvidence>,
    /// In the order of creation.
    oldest: VecDeque<EvidenceKey>,
    vacant: Vec<Slot>,
    slots: usize,
    batch: BatchSize,
}

impl<'a> Store<'a> {
    /// An empty store for a world that the backend has loaded over a window, with as many slots as it has.
    pub(super) fn new(
        study: &'a Study,
        (world, window): (&'a World, Window),
        tables: &'a [Option<Rays>],
        first_hits: &'a FirstHitSlots,
        slots: usize,
        batch: BatchSize,
    ) -> Store<'a> {
        Store {
            study,
            world,
            truth: world.truth(),
            tables,
            first_hits,
            window,
            held: HashMap::new(),
            oldest: VecDeque::new(),
            vacant: (0..slots as Slot).rev().collect(),
            slots,
            batch,
        }
    }

    /// Makes the evidence of the first choices, as many as fit at once; returns their number.
    pub(super) fn make_ready(
        &mut self,
        pose_choices: &[PoseChoice],
        repeat: usize,
        backend: &mut dyn Backend,
    ) -> Result<usize> {
        let mut wanted = HashSet::new();
        let (mut missing, mut count, mut room) = (Vec::new(), 0, self.slots);
        let (mut jobs, mut rays) = (0, 0);
        let most_rays = self.batch.rays_on(backend);
        for pose_choice in pose_choices {
            let mut new: Vec<EvidenceKey> = self.keys(pose_choice, repeat).collect();
            new.retain(|key| !wanted.contains(key));
            let slots: usize = new.iter().map(|key| self.most_slots(key)).sum();
            jobs +=
                self.study.combinations[pose_choice.combination].representation_count(&self.study.sensors);
            let lacking = || new.iter().filter(|key| !self.held.contains_key(key));
            let table =
                |key: &EvidenceKey| self.tables[key.sensor].as_ref().map_or(0, |table| table.dirs_q15.len());
            rays += lacking().map(table).sum::<usize>();
            if slots > room || (count > 0 && (jobs > self.batch.jobs || rays > most_rays)) {
                break;
            }
            room -= slots;
            missing.extend(lacking());
            wanted.extend(new);
            count += 1;
        }
        if count == 0 {
            let combination = &self.study.combinations[pose_choices[0].combination].name;
            let what = format!(
                "the evidence of its sensors does not fit backend {} at once ({} pieces do)",
                backend.name(),
                self.slots
            );
            let cure =
                Words::from("use larger voxels, smaller regions, or ") + Argument("backend").quote("cpu");
            let place = format!("combination {combination:?}");
            return Err(Issue::too_large(what).with_advice(cure).with_place(place).into());
        }
        self.make_room(&missing, &wanted);
        self.make(&missing, backend)?;
        Ok(count)
    }

    /// The evidence of a choice's members, in the order of precedence, each in its representation.
    pub(super) fn readings(
        &self,
        pose_choice: &PoseChoice,
        repeat: usize,
        representations: &[usize],
    ) -> Vec<Reading> {
        let held = self.keys(pose_choice, repeat).map(|key| &self.held[&key]);
        held.zip(representations).filter_map(|(held, &way)| held.readings[way]).collect()
    }

    fn keys(&self, pose_choice: &PoseChoice, repeat: usize) -> impl Iterator<Item = EvidenceKey> + use<'a> {
        let (study, combination) = (self.study, &self.study.combinations[pose_choice.combination]);
        let members = combination.members.iter().zip(combination.choice(pose_choice.choice));
        members.map(move |(member, candidate)| {
            let noisy = study.sensors[member.sensor].kind.is_noisy();
            EvidenceKey { sensor: member.sensor, candidate, repeat: if noisy { repeat } else { 0 } }
        })
    }

    /// One slot for the cast evidence, and one for the host's addition in each representation.
    fn most_slots(&self, key: &EvidenceKey) -> usize {
        let kind = &self.study.sensors[key.sensor].kind;
        let added = (0..kind.representations().len()).filter(|&representation| kind.adds(representation));
        self.tables[key.sensor].is_some() as usize + added.count()
    }

    /// Drops the oldest unneeded evidence until the missing one fits.
    fn make_room(&mut self, missing: &[EvidenceKey], wanted: &HashSet<EvidenceKey>) {
        let needed: usize = missing.iter().map(|key| self.most_slots(key)).sum();
        let mut kept = VecDeque::new();
        while self.vacant.len() < needed {
            let Some(key) = self.oldest.pop_front() else { break };
            if wanted.contains(&key) {
                kept.push_back(key);
            } else if let Some(held) = self.held.remove(&key) {
                self.vacant.extend(held.slots);
            }
        }
        kept.append(&mut self.oldest);
        self.oldest = kept;
    }

    /// Casts and claims the missing evidence.
    fn make(&mut self, missing: &[EvidenceKey], backend: &mut dyn Backend) -> Result<()> {
        let claims_of_missing: Vec<(GridPose, Vec<Claim>)> =
            missing.par_iter().map(|key| self.sensor_claims(key)).collect();
        let mut shots: Vec<Vec<Shot>> = vec![Vec::new(); self.tables.len()];
        let mut uploads: Vec<(Slot, Planes)> = Vec::new();
        for (key, (placement, claims)) in missing.iter().zip(claims_of_missing) {
            let mut slots = Vec::new();
            let mut take = |vacant: &mut Vec<Slot>| {
                let slot = vacant.pop().expect("room was made for all that is missing");
                slots.push(slot);
                slot
            };
            let cast = claims.iter().any(|claim| claim.cast).then(|| take(&mut self.vacant));
            let first_hits = self.first_hits.get(&(key.sensor, key.candidate)).copied();
            shots[key.sensor].extend(cast.map(|slot| Shot { slot, placement, first_hits }));
            let mut readings = Vec::new();
            for (representation, claim) in claims.into_iter().enumerate() {
                let kind = &self.study.sensors[key.sensor].kind;
                let ([hit, miss], presence) =
                    (kind.log_odds(representation), kind.feels_presence(representation));
                let added = claim.planes.map(|planes| {
                    let slot = take(&mut self.vacant);
                    uploads.push((slot, planes));
                    slot
                });
                let cast = cast.filter(|_| claim.cast);
                readings.push(match (cast, added) {
                    (Some(slot), volume) => Some(Reading { slot, volume, hit, miss, presence }),
                    (None, added) => added.map(|slot| Reading { slot, volume: None, hit, miss, presence }),
                });
            }
            self.held.insert(*key, HeldEvidence { slots, readings });
            self.oldest.push_back(*key);
        }
        let casting = shots.iter().zip(self.tables).filter(|(_, table)| table.is_some());
        for (table, (shots, _)) in casting.enumerate().filter(|(_, (shots, _))| !shots.is_empty()) {
            backend.sense(table, shots)?;
        }
        backend.upload(uploads)
    }

    /// The pose of a sensor, and its claims in each representation.
    fn sensor_claims(&self, key: &EvidenceKey) -> (GridPose, Vec<Claim>) {
        let (world, spec) = (self.world, &self.study.sensors[key.sensor]);
        let station = Station {
            window: self.window,
            rays: self.tables[key.sensor].as_ref(),
            ..world.station(self.study, &self.truth, [key.sensor, key.candidate, key.repeat])
        };
        (station.placement(&*spec.kind), spec.kind.claims(&station))
    }
}
