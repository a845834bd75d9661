//! The questions about one scene, moment by moment and for all at once, and the answers in the order of the table.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::body::{Body, Sums};
use super::deepest::{ApproachFinding, FreeRoom, deepest, nearest_at_entry, nearest_of_all};
use super::ground::{Company, Ground};
use super::surfaces::{fence_between, room, walked};
use crate::view::watched::{WatchedVoxels, Watchers};
use perirobot_march::Result;
use perirobot_march::progress::Progress;
use perirobot_march::voxel::{BitGrid, Distances};
use perirobot_scene::truth::Truth;
use perirobot_study::world::World;

/// What becomes of a body at its entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AtEntry {
    /// It comes in unnoticed.
    Open,
    /// It is noticed wherever it has room.
    Noticed,
    /// It has no room anywhere.
    NoRoom,
}

impl AtEntry {
    /// As in the column `at_entry`.
    pub fn name(self) -> &'static str {
        match self {
            AtEntry::Open => "open",
            AtEntry::Noticed => "noticed",
            AtEntry::NoRoom => "no_room",
        }
    }
}

/// The answer for one body from one entry.
#[derive(Clone, Debug)]
pub struct ApproachAnswer {
    /// Who else was there.
    pub company: Company,
    /// Which snapshot; `None` for all of them at once.
    pub snapshot: Option<usize>,
    /// Index of the body.
    pub body: usize,
    /// Index of the entry.
    pub entry: usize,
    /// How many places are open to the body, wherever it comes from.
    pub unnoticed: u64,
    /// What becomes of it at the entry.
    pub at_entry: AtEntry,
    /// What it can do.
    pub found: ApproachFinding,
    /// How far a voxel of the grid is from the hazard at most, squared in voxels.
    pub farthest: u32,
    /// The object that stands before the narrowest place, or before the deepest one if there is none.
    pub shadow: Option<String>,
    /// The object between a walking body and the hazard that it does not climb, seen from the deepest place.
    pub fence: Option<String>,
    /// The sensors that latch, by their names, and for each whether the body gets into its zone without having been noticed
    /// on the way.
    pub latches: Vec<(String, bool)>,
}

/// What a floor plan of a body shows, at the last moment that was asked: all snapshots at once, or the only one.
#[derive(Clone, Debug)]
pub struct BodyPlan {
    /// Who else was there.
    pub company: Company,
    /// Index of the body.
    pub body: usize,
    /// What nothing can enter.
    pub solid: Arc<BitGrid>,
    /// What bodies must not come near to.
    pub hazard: Arc<BitGrid>,
    /// Where the body has room.
    pub free: BitGrid,
    /// Where it has room and is not noticed.
    pub open: BitGrid,
}

/// A moment of a scene, or all of them at once, as it is whatever the sensors.
pub struct ApproachMoment<'g> {
    pub(super) ground: &'g Ground<'g>,
    company: Company,
    snapshot: Option<usize>,
    pub(super) solid: Arc<BitGrid>,
    /// What carries bodies that walk.
    pub(super) surfaces: BitGrid,
    hazard: Arc<BitGrid>,
    pub(super) distances: Distances,
    /// Of each body, where it has room.
    free: Vec<BitGrid>,
}

/// What a body can do from an entry, in a few numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NearestApproach {
    /// How near it has come when it is noticed, if ever, squared, in voxels; `None` where it has no room at the entry.
    pub squared: Option<u32>,
    /// How many places are open to it, wherever it comes from.
    pub unnoticed: u64,
    /// How many it reaches from the entry.
    pub joined: u64,
}

impl<'g> ApproachMoment<'g> {
    /// Some snapshots of a scene at once, with what is where in each.
    pub fn new(
        ground: &'g Ground<'g>,
        company: Company,
        worlds: &[World],
        truths: &[Arc<Truth>],
    ) -> Result<ApproachMoment<'g>> {
        let mut solid = BitGrid::full(worlds[0].grid.window());
        let mut surfaces = match ground.walks() {
            true => BitGrid::new(worlds[0].grid.window()),
            false => BitGrid::nowhere(),
        };
        let mut hazard = BitGrid::new(worlds[0].grid.window());
        for (world, truth) in worlds.iter().zip(truths) {
            let here = super::ground::solid(truth);
            if ground.walks() {
                surfaces.add(&super::surfaces::surfaces(truth, &here));
            }
            solid.keep(&here);
            hazard.add(&ground.hazard(world)?);
        }
        let sums = [&solid, &surfaces].map(Sums::new);
        let free = ground.bodies.iter().zip(&ground.places).zip(&ground.begins);
        let free = free
            .map(|((body, &places), begins)| walked(body, begins, room(body, &sums[0], &sums[1], places)));
        let free = free.collect();
        let snapshot = if let [world] = worlds { Some(world.snapshot) } else { None };
        let distances = Distances::from_set(&hazard);
        Ok(ApproachMoment {
            ground,
            company,
            snapshot,
            solid: solid.into(),
            surfaces,
            hazard: hazard.into(),
            distances,
            free,
        })
    }

    /// Of each body, where it has room and is not noticed.
    fn open(&self, watched: &BitGrid) -> Vec<BitGrid> {
        let sums = Sums::new(watched);
        (0..self.ground.bodies.len()).map(|body| self.open_to(body, &sums)).collect()
    }

    /// The same of one body, from the sums of watched voxels.
    pub(super) fn open_to(&self, body: usize, watched: &Sums) -> BitGrid {
        let Ground { bodies, places, .. } = self.ground;
        let mut open = bodies[body].covers_at_most(bodies[body].min_voxels - 1, watched, places[body]);
        open.keep(&self.free[body]);
        open
    }

    /// Where each body has room.
    pub(crate) fn free(&self) -> &[BitGrid] {
        &self.free
    }

    /// Where each body has room, and at least a share of what it is noticed by is in some voxels: those of its voxels that one
    /// of so many sensors watches, if they notice it together. The window of the voxels is
    /// [`ApproachMoment::body_window`].
    pub(crate) fn may_notice(&self, watched: &BitGrid, sensors: usize) -> Vec<BitGrid> {
        let Ground { bodies, places, .. } = self.ground;
        let sums = Sums::new(watched);
        let of_body = |number: usize| {
            let least = bodies[number].min_voxels.div_ceil(sensors.max(1) as u32);
            let mut here = self.free[number].clone();
            here.remove(&bodies[number].covers_at_most(least - 1, &sums, places[number]));
            here
        };
        (0..bodies.len()).map(of_body).collect()
    }

    fn room<'r>(&'r self, body: usize, open: &'r [BitGrid]) -> FreeRoom<'r> {
        FreeRoom { free: &self.free[body], open: &open[body], distances: &self.distances }
    }

    /// Something of each body from each entry, body by body; no more at once than there is room for.
    fn each<T: Send>(&self, of: impl Fn([usize; 2]) -> T + Sync) -> Vec<T> {
        let begins = self.ground.begins.iter().enumerate();
        let all: Vec<[usize; 2]> =
            begins.flat_map(|(body, of)| (0..of.len()).map(move |entry| [body, entry])).collect();
        let at_once = all.chunks(self.ground.at_once());
        at_once.flat_map(|some| some.par_iter().map(|&one| of(one)).collect::<Vec<_>>()).collect()
    }

    /// The body and the entry of each answer, in the order of [`ApproachMoment::nearest`], with the least squared distance of the
    /// body at the entry; `None` where it has no room there.
    pub(crate) fn entries(&self) -> Vec<([usize; 2], Option<u32>)> {
        self.each(|[number, entry]| {
            let (body, begin) = (&self.ground.bodies[number], &self.ground.begins[number][entry]);
            ([number, entry], nearest_at_entry(body, begin, &self.free[number], &self.distances))
        })
    }

    /// What each body can do from each entry where these voxels are watched, body by body.
    pub fn nearest(&self, watched: &BitGrid) -> Vec<NearestApproach> {
        let open = self.open(watched);
        self.each(|[number, entry]| {
            let (body, begin) = (&self.ground.bodies[number], &self.ground.begins[number][entry]);
            let (squared, joined) = nearest_of_all(body, begin, self.room(number, &open));
            NearestApproach { squared, unnoticed: open[number].count(), joined }
        })
    }

    /// The answers where sensors watch at each of the snapshots, and what floor plans show.
    fn ask(&self, watchers: &Watchers, watches: &[WatchedVoxels]) -> (Vec<ApproachAnswer>, Vec<BodyPlan>) {
        let mut watched = watches[0].voxels.clone();
        watches[1..].iter().for_each(|watch| watched.keep(&watch.voxels));
        let (open, farthest) = (self.open(&watched), self.distances.farthest());
        let latches = latches(watchers, watches);
        let answers = self.each(|[number, entry]| {
            let (body, begin) = (&self.ground.bodies[number], &self.ground.begins[number][entry]);
            let found = deepest(body, begin, self.room(number, &open));
            let at_entry = match (&found.deepest, found.noticed) {
                (Some(_), _) => AtEntry::Open,
                (None, Some(_)) => AtEntry::Noticed,
                (None, None) => AtEntry::NoRoom,
            };
            let place = found.deepest.as_ref().and_then(|deepest| {
                deepest.narrowest.map(|narrowest| narrowest.place).or(deepest.path.last().copied())
            });
            let shadow = place.and_then(|place| shadow(body, place, watchers, watches));
            let end = found.deepest.as_ref().and_then(|deepest| deepest.path.last().copied());
            let around = (&*self.solid, &*self.hazard, &self.distances);
            let fence = end.and_then(|place| fence_between((body, place), &watches[0].truth, around));
            let latches = latches.iter().map(|(name, zone)| {
                let mut inside = found.reached.clone();
                inside.remove(&body.covers_at_most(0, zone, self.ground.places[number]));
                (name.clone(), !inside.is_empty())
            });
            let latches = latches.collect();
            let (company, snapshot, unnoticed) = (self.company, self.snapshot, open[number].count());
            ApproachAnswer {
                company,
                snapshot,
                body: number,
                entry,
                unnoticed,
                at_entry,
                found,
                farthest,
                shadow,
                fence,
                latches,
            }
        });
        let planes = self.free.iter().zip(open).enumerate();
        let plans = planes.filter(|(body, _)| self.ground.bodies[*body].on_floor);
        let plan = |(body, (free, open)): (usize, (&BitGrid, BitGrid))| {
            let (solid, hazard) = (self.solid.clone(), self.hazard.clone());
            BodyPlan { company: self.company, body, solid, hazard, free: free.clone(), open }
        };
        (answers, plans.map(plan).collect())
    }
}

/// Each sensor that latches at one of these moments, by its name, with the sums of the voxels in which people count as
/// detected.
fn latches(watchers: &Watchers, watches: &[WatchedVoxels]) -> Vec<(String, Sums)> {
    let mut zones: BTreeMap<usize, BitGrid> = BTreeMap::new();
    for watch in watches {
        for (sensor, zone) in &watch.latched {
            zones.entry(*sensor).or_insert_with(|| BitGrid::new(watch.voxels.window())).add(zone);
        }
    }
    zones.into_iter().map(|(sensor, zone)| (watchers.name(sensor).to_string(), Sums::new(&zone))).collect()
}

/// The object that stands before most voxels of a body at a place, seen from the sensors.
pub(crate) fn shadow(
    body: &Body,
    place: [i32; 3],
    watchers: &Watchers,
    watches: &[WatchedVoxels],
) -> Option<String> {
    let mut before = BTreeMap::new();
    for watch in watches {
        for (object, often) in watchers.blocking_objects(watch, body.voxels(place)) {
            let name = watch.truth.objects[object].name.clone();
            *before.entry(name).or_insert(0) += often;
        }
    }
    // The first by name of equals.
    before.into_iter().rev().max_by_key(|(_, often)| *often).map(|(name, _)| name)
}

/// How many moments of a scene are asked.
pub fn moments_of(ground: &Ground) -> u64 {
    let snapshots = ground.worlds.len() as u64;
    ground.companies().len() as u64 * (snapshots + u64::from(snapshots > 1))
}

/// All answers of a scene: with nobody else first, in each the snapshots in order and then all at once, if there
/// are several; body by body, entry by entry. With them what the floor plans show. `worlds` are the snapshots with
/// the sensors as they are looked at; `progress` advances by one after each of [`moments_of`].
///
/// # Errors
/// When a snapshot has no hazard; `Error::Stopped`.
pub fn answers(
    ground: &Ground,
    worlds: &[World],
    watchers: &Watchers,
    progress: &dyn Progress,
) -> Result<(Vec<ApproachAnswer>, Vec<BodyPlan>)> {
    let (mut answers, mut plans) = (Vec::new(), Vec::new());
    for company in ground.companies() {
        let (truths, watches) = observe(company, worlds, watchers);
        let mut ask = |snapshots: Range<usize>| -> Result<Vec<BodyPlan>> {
            progress.check_stop()?;
            let moment =
                ApproachMoment::new(ground, company, &worlds[snapshots.clone()], &truths[snapshots.clone()])?;
            let (here, plans) = moment.ask(watchers, &watches[snapshots]);
            answers.extend(here);
            progress.advance(1);
            Ok(plans)
        };
        let mut last = Vec::new();
        for snapshot in 0..worlds.len() {
            last = ask(snapshot..snapshot + 1)?;
        }
        if worlds.len() > 1 {
            last = ask(0..worlds.len())?;
        }
        plans.extend(last);
    }
    Ok((answers, plans))
}

/// The answers of all snapshots of a scene at once, with nobody else first; body by body, entry by entry. `worlds` as
/// in [`answers`].
pub(super) fn at_once(ground: &Ground, worlds: &[World], watchers: &Watchers) -> Result<Vec<ApproachAnswer>> {
    let mut answers = Vec::new();
    for company in ground.companies() {
        let (truths, watches) = observe(company, worlds, watchers);
        answers.extend(ApproachMoment::new(ground, company, worlds, &truths)?.ask(watchers, &watches).0);
    }
    Ok(answers)
}

/// What is where at each snapshot, and what sensors watch there.
fn observe(company: Company, worlds: &[World], watchers: &Watchers) -> (Vec<Arc<Truth>>, Vec<WatchedVoxels>) {
    let truths: Vec<Arc<Truth>> = worlds.iter().map(|world| company.truth(world)).collect();
    let each = worlds.iter().zip(&truths);
    let watches = each.map(|(world, truth)| watchers.watch(world, truth.clone())).collect();
    (truths, watches)
}
