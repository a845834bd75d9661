//! Approaches: the voxels that each candidate watches, and groups of candidates of which a passing set needs some.

use std::sync::Arc;

use rayon::prelude::*;

use crate::approach::{ApproachMoment, Company, Ground, NearestApproach, WatchCounts, shadow};
use crate::judge::Passage;
use crate::view::watched::{WatchScene, Watcher, Watchers};
use perirobot_march::Result;
use perirobot_march::progress::Progress;
use perirobot_march::voxel::{BitGrid, Window};
use perirobot_scene::truth::Truth;
use perirobot_study::input::Study;

/// A scene in one company and repeat, with all its snapshots.
pub struct SceneWays<'g> {
    moment: ApproachMoment<'g>,
    ground: &'g Ground<'g>,
    /// The ways in, body by body.
    pub(super) passages: Vec<Passage>,
    /// For each candidate and snapshot, the watched voxels in the space of bodies.
    watched: Vec<Vec<Arc<BitGrid>>>,
    counts: WatchCounts,
    looking: Watchers<'g>,
    /// The contents of each snapshot.
    truths: Vec<Arc<Truth>>,
}

/// A path on which a body comes near, and the candidates that notice it there.
#[derive(Clone, Debug)]
pub(super) struct WayIn {
    /// Index of scene, company and repeat.
    pub(super) scene: usize,
    /// Index of the passage.
    pub(super) passage: usize,
    /// The places of the body.
    pub(super) places: Vec<[i32; 3]>,
    /// The distance at the end, squared in voxels.
    pub(super) squared: u32,
    /// A minimal group of candidates: all others together do not notice the body.
    pub(super) noticed_by: Vec<usize>,
}

impl<'g> SceneWays<'g> {
    /// The number of pairs of candidate and snapshot in all scenes.
    pub(super) fn total(study: &Study, grounds: &[Ground], candidates: usize) -> u64 {
        let looks = |ground: &Ground| (ground.companies().len() * ground.worlds.len()) as u64;
        grounds.iter().map(looks).sum::<u64>() * u64::from(study.repeats) * candidates as u64
    }

    /// Computes what each candidate watches in each scene.
    ///
    /// # Errors
    /// `Error::Stopped`; if no hazard exists.
    pub(super) fn all(
        study: &'g Study,
        grounds: &'g [Ground<'g>],
        watchers: &[Watcher],
        progress: &dyn Progress,
    ) -> Result<Vec<SceneWays<'g>>> {
        let mut all = Vec::new();
        for ground in grounds {
            for company in ground.companies() {
                for repeat in 0..study.repeats as usize {
                    all.push(SceneWays::new(study, ground, company, repeat, watchers, progress)?);
                }
            }
        }
        Ok(all)
    }

    fn new(
        study: &'g Study,
        ground: &'g Ground<'g>,
        company: Company,
        repeat: usize,
        watchers: &[Watcher],
        progress: &dyn Progress,
    ) -> Result<SceneWays<'g>> {
        let truths: Vec<Arc<Truth>> = ground.worlds.iter().map(|world| company.truth(world)).collect();
        let moment = ApproachMoment::new(ground, company, ground.worlds, &truths)?;
        let room = moment.body_window();
        let looking = Watchers::from_watchers(study, watchers.to_vec(), repeat);
        let scenes = ground.worlds.iter().zip(&truths);
        let scenes: Vec<WatchScene> =
            scenes.map(|(world, truth)| WatchScene::new(world, truth.clone(), room)).collect();
        let look = |one: &Watcher| -> Result<Vec<Arc<BitGrid>>> {
            let mut of_snapshots: Vec<Arc<BitGrid>> = Vec::new();
            for scene in &scenes {
                progress.check_stop()?;
                let watched = looking.watched_voxels(one, scene).to_window(room).trim();
                // Most sensors watch the same in most snapshots.
                let known = of_snapshots.last().filter(|last| ***last == watched).cloned();
                of_snapshots.push(known.unwrap_or_else(|| watched.into()));
                progress.advance(1);
            }
            Ok(of_snapshots)
        };
        let watched: Vec<Vec<Arc<BitGrid>>> = watchers.par_iter().map(look).collect::<Result<_>>()?;
        let counts = WatchCounts::from_watched(room, watched.iter().map(|each| at_all(room, each)));
        let passages = crate::judge::passages(ground, company, repeat);
        Ok(SceneWays { moment, ground, passages, watched, counts, looking, truths })
    }

    /// The voxels that some candidates watch in all snapshots.
    pub(super) fn watched_by(&self, set: &[usize]) -> BitGrid {
        let room = self.moment.body_window();
        let at_snapshot = |snapshot: usize| {
            let mut all = BitGrid::new(room);
            set.iter().for_each(|&item| all.add(&self.watched[item][snapshot]));
            all
        };
        let mut all = at_snapshot(0);
        for snapshot in 1..self.ground.worlds.len() {
            let is_same =
                |&item: &usize| Arc::ptr_eq(&self.watched[item][snapshot], &self.watched[item][snapshot - 1]);
            if !set.iter().all(is_same) {
                all.keep(&at_snapshot(snapshot));
            }
        }
        all
    }

    /// The reach of each body from each entry with these voxels watched, in the order of the passages.
    pub(super) fn nearest(&self, watched: &BitGrid) -> Vec<NearestApproach> {
        self.moment.nearest(watched)
    }

    /// The distance of each body at each entry, independent of sensors, squared in voxels; `None` if it does not fit.
    pub(super) fn at_entries(&self) -> Vec<Option<u32>> {
        self.moment.entries().into_iter().map(|(_, squared)| squared).collect()
    }

    /// The free places of each body.
    pub(super) fn free(&self) -> &[BitGrid] {
        self.moment.free()
    }

    /// The same for bodies on the floor, with their numbers.
    pub(super) fn free_floor(&self) -> impl Iterator<Item = (usize, &BitGrid)> {
        self.free().iter().enumerate().filter(|(body, _)| self.ground.bodies[*body].on_floor)
    }

    /// The places where a candidate and others may notice each body together at the first snapshot, for a given number
    /// of sensors ([`ApproachMoment::may_notice`]).
    pub(super) fn may_notice(&self, item: usize, sensors: usize) -> Vec<BitGrid> {
        let watched = self.watched[item][0].to_window(self.moment.body_window());
        self.moment.may_notice(&watched, sensors)
    }

    /// Body and entry of a passage.
    pub(super) fn body_and_entry(&self, passage: usize) -> [usize; 2] {
        let entries = self.ground.study.approach.entries.len();
        [passage / entries, passage % entries]
    }

    /// A path by which a passage leads too near, which some candidates do not notice, with as few others as possible
    /// that do.
    pub(super) fn way_in(
        &self,
        [scene, passage]: [usize; 2],
        unnoticing: &[usize],
        is_too_near: &dyn Fn(u32) -> bool,
    ) -> Option<WayIn> {
        let watched = self.watched_by(unnoticing);
        let (places, squared) =
            self.moment.unnoticed_path(self.body_and_entry(passage), &watched, &self.counts, is_too_near)?;
        let noticed_by = self.noticed_by(passage, &places, unnoticing);
        Some(WayIn { scene, passage, places, squared, noticed_by })
    }

    /// The body's centre at the end of a way, in world metres.
    pub(super) fn end_m(&self, way: &WayIn) -> [f64; 3] {
        let body = &self.ground.bodies[self.body_and_entry(way.passage)[0]];
        let end = way.places.last().copied().unwrap_or_default();
        body.middle_m(end, &self.ground.worlds[0].grid).to_array()
    }

    /// The object in front of the end of a way, as seen from most candidates.
    pub(super) fn hiding_object(&self, way: &WayIn) -> Option<String> {
        let body = &self.ground.bodies[self.body_and_entry(way.passage)[0]];
        let watches = self.ground.worlds.iter().zip(&self.truths);
        let watches: Vec<_> =
            watches.map(|(world, truth)| self.looking.watch(world, truth.clone())).collect();
        shadow(body, *way.places.last()?, &self.looking, &watches)
    }

    /// The candidates outside a maximal set that contains `unnoticing` and does not notice a body on a path.
    fn noticed_by(&self, passage: usize, places: &[[i32; 3]], unnoticing: &[usize]) -> Vec<usize> {
        let sight = PathSight::new(self, self.body_and_entry(passage)[0], places);
        let mut missing = sight.nothing();
        unnoticing.iter().for_each(|&item| sight.join(&mut missing, item));
        let seen = |item: usize| sight.seen[item].iter().flatten().map(|word| word.count_ones()).sum::<u32>();
        let others = (0..self.watched.len()).filter(|item| !unnoticing.contains(item));
        let mut others: Vec<(u32, usize)> =
            others.map(|item| (seen(item), item)).filter(|(seen, _)| *seen > 0).collect();
        // Those that watch little of it first: more of them fit together.
        others.sort_unstable();
        let mut among = Vec::new();
        for (_, item) in others {
            let mut with = missing.clone();
            sight.join(&mut with, item);
            match sight.notices(&with) {
                true => among.push(item),
                false => missing = with,
            }
        }
        among.sort_unstable();
        among
    }
}

/// What candidates watch of a body's voxels along a path.
struct PathSight {
    /// The voxels of the body at each place of the path.
    bodies: Vec<Vec<u64>>,
    min_voxels: u32,
    /// The watched voxels of each candidate and snapshot.
    seen: Vec<Vec<Vec<u64>>>,
    words: usize,
    snapshots: usize,
}

impl PathSight {
    fn new(ways: &SceneWays, body: usize, places: &[[i32; 3]]) -> PathSight {
        let body = &ways.ground.bodies[body];
        let mut voxels: Vec<[i32; 3]> = places.iter().flat_map(|&place| body.voxels(place)).collect();
        voxels.sort_unstable();
        voxels.dedup();
        let words = voxels.len().div_ceil(64);
        let pack = |has: &dyn Fn(&[i32; 3]) -> bool| {
            let mut bits = vec![0u64; words];
            let set = voxels.iter().enumerate().filter(|(_, voxel)| has(voxel));
            set.for_each(|(number, _)| bits[number / 64] |= 1 << (number % 64));
            bits
        };
        let of_place = |&place: &[i32; 3]| {
            let mut bits = vec![0u64; words];
            for voxel in body.voxels(place) {
                if let Ok(number) = voxels.binary_search(&voxel) {
                    bits[number / 64] |= 1 << (number % 64);
                }
            }
            bits
        };
        let seen = ways.watched.par_iter().map(|of_snapshots| {
            let mut seen: Vec<Vec<u64>> = Vec::new();
            for (snapshot, watched) in of_snapshots.iter().enumerate() {
                let is_same = snapshot > 0 && Arc::ptr_eq(watched, &of_snapshots[snapshot - 1]);
                let bits =
                    if is_same { seen[snapshot - 1].clone() } else { pack(&|&voxel| watched.get(voxel)) };
                seen.push(bits);
            }
            seen
        });
        PathSight {
            bodies: places.par_iter().map(of_place).collect(),
            min_voxels: body.min_voxels,
            seen: seen.collect(),
            words,
            snapshots: ways.ground.worlds.len(),
        }
    }

    fn nothing(&self) -> Vec<Vec<u64>> {
        vec![vec![0; self.words]; self.snapshots]
    }

    fn join(&self, all: &mut [Vec<u64>], item: usize) {
        for (to, from) in all.iter_mut().zip(&self.seen[item]) {
            to.iter_mut().zip(from).for_each(|(to, from)| *to |= from);
        }
    }

    /// Whether the body is noticed anywhere on the path.
    fn notices(&self, all: &[Vec<u64>]) -> bool {
        let always = |word: usize| all.iter().fold(u64::MAX, |both, own| both & own[word]);
        let always: Vec<u64> = (0..self.words).map(always).collect();
        let watched = |body: &Vec<u64>| {
            body.iter().zip(&always).map(|(body, always)| (body & always).count_ones()).sum::<u32>()
        };
        self.bodies.iter().any(|body| watched(body) >= self.min_voxels)
    }
}

/// The intersection of some sets.
fn at_all(room: Window, sets: &[Arc<BitGrid>]) -> BitGrid {
    let mut all = BitGrid::full(room);
    sets.iter().for_each(|one| all.keep(one));
    all
}
