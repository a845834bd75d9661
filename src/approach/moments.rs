//! What is asked of one scene, moment by moment and of all at once, and the answers in the order of the table.

use std::collections::BTreeMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::answer::{Found, deepest};
use super::ground::{Ground, solid};
use crate::Result;
use crate::view::watched::{Watch, Watchers};
use crate::voxel::{BitGrid, Distances};

/// Who else is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Company {
    /// Nobody.
    Absent,
    /// The people of the scene, who stand in the way and hide what is behind them.
    Cover,
}

impl Company {
    /// As in the column `people`.
    pub fn name(self) -> &'static str {
        match self {
            Company::Absent => "absent",
            Company::Cover => "cover",
        }
    }
}

/// What becomes of a body at its entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
pub struct Answer {
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
    pub found: Found,
    /// How far a voxel of the grid is from the hazard at most, squared in voxels.
    pub farthest: u32,
    /// The object that stands before the narrowest place, or before the deepest one if there is none.
    pub shadow: Option<String>,
}

/// What a floor plan of a body shows, at the last moment that was asked: all snapshots at once, or the only one.
#[derive(Clone, Debug)]
pub struct Plan {
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

/// A moment, or all of them at once.
struct Moment {
    snapshot: Option<usize>,
    solid: BitGrid,
    watched: BitGrid,
    hazard: BitGrid,
}

/// All answers of a scene: with nobody else first, in each the snapshots in order and then all at once, if there
/// are several; body by body, entry by entry. With them what the floor plans show.
pub fn answers(ground: &Ground, watchers: &Watchers) -> Result<(Vec<Answer>, Vec<Plan>)> {
    let (mut answers, mut plans) = (Vec::new(), Vec::new());
    let cover = ground.has_people().then_some(Company::Cover);
    for company in [Some(Company::Absent), cover].into_iter().flatten() {
        let mut all: Option<Moment> = None;
        let mut watches = Vec::new();
        for world in ground.worlds {
            let truth = match company {
                Company::Absent => Arc::new(world.truth_without_people()),
                Company::Cover => world.truth(),
            };
            let watch = watchers.watch(world, truth);
            let hazard = ground.hazard(world)?;
            let moment = Moment {
                snapshot: Some(world.snapshot),
                solid: solid(&watch.truth),
                watched: watch.voxels.clone(),
                hazard,
            };
            match &mut all {
                None => {
                    all = Some(Moment {
                        snapshot: None,
                        solid: moment.solid.clone(),
                        watched: moment.watched.clone(),
                        hazard: moment.hazard.clone(),
                    });
                }
                Some(all) => {
                    all.solid.keep(&moment.solid);
                    all.watched.keep(&moment.watched);
                    all.hazard.add(&moment.hazard);
                }
            }
            let here = ask(ground, watchers, company, moment, std::slice::from_ref(&watch));
            answers.extend(here.0);
            if ground.worlds.len() == 1 {
                plans.extend(here.1);
            }
            watches.push(watch);
        }
        if let (Some(all), [_, _, ..]) = (all, &watches[..]) {
            let here = ask(ground, watchers, company, all, &watches);
            answers.extend(here.0);
            plans.extend(here.1);
        }
    }
    Ok((answers, plans))
}

/// The answers of one moment; `watches` are those of its snapshots.
fn ask(
    ground: &Ground,
    watchers: &Watchers,
    company: Company,
    moment: Moment,
    watches: &[Watch],
) -> (Vec<Answer>, Vec<Plan>) {
    let distances = Distances::to(&moment.hazard);
    let farthest = distances.farthest();
    let (solid, hazard) = (Arc::new(moment.solid), Arc::new(moment.hazard));
    // Of each body, where it has room, and where it is not noticed there either.
    let planes = ground.bodies.iter().zip(&ground.places).map(|(body, &places)| {
        let free = body.covers_at_most(0, &solid, places);
        let mut open = body.covers_at_most(body.min_voxels - 1, &moment.watched, places);
        open.keep(&free);
        [free, open]
    });
    let planes: Vec<_> = planes.collect();
    let answer = |&[number, entry]: &[usize; 2]| {
        let (body, begin, [free, open]) =
            (&ground.bodies[number], &ground.begins[number][entry], &planes[number]);
        let found = deepest(body, begin, open, &distances);
        let at_entry = match found.deepest {
            Some(_) => AtEntry::Open,
            None if begin.intersects(free) => AtEntry::Noticed,
            None => AtEntry::NoRoom,
        };
        let place = found.deepest.as_ref().and_then(|deepest| {
            deepest.narrowest.map(|narrowest| narrowest.place).or(deepest.path.last().copied())
        });
        let shadow = place.and_then(|place| {
            let mut before = BTreeMap::new();
            for watch in watches {
                for (object, often) in watchers.before(watch, body.voxels(place)) {
                    let name = watch.truth.objects[object].name.clone();
                    *before.entry(name).or_insert(0) += often;
                }
            }
            // The first by name of equals.
            before.into_iter().rev().max_by_key(|(_, often)| *often).map(|(name, _)| name)
        });
        let (snapshot, unnoticed) = (moment.snapshot, open.count());
        Answer { company, snapshot, body: number, entry, unnoticed, at_entry, found, farthest, shadow }
    };
    let all =
        (0..planes.len()).flat_map(|body| (0..ground.begins[body].len()).map(move |entry| [body, entry]));
    let all: Vec<_> = all.collect();
    let at_once = all.chunks(ground.at_once());
    let answers = at_once.flat_map(|some| some.par_iter().map(answer).collect::<Vec<_>>()).collect();
    let plans = planes.into_iter().enumerate().filter(|(body, _)| ground.bodies[*body].on_floor);
    let plan = |(body, [free, open]): (usize, [BitGrid; 2])| {
        let (solid, hazard) = (solid.clone(), hazard.clone());
        Plan { company, body, solid, hazard, free, open }
    };
    (answers, plans.map(plan).collect())
}
