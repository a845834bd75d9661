//! The backend on all cores of the processor: each thread works on one placement or one job. The algorithms
//! are in files of their own, each with a reason why it is exact: `first_hit` (leaps), `cone`, `intersect`, `across`,
//! `beyond`, `carve_voxels`, `carve_rays`, `alike`; `plan` says which is used when. The arithmetic is `march`. `sight` has the
//! same without noise, for what sensors would notice; `nearest_range` decides there what rays enter about their shortest range.
//!
//! A pose is sensed in this order: `plan` (what matters), `beyond` (tiles that need not be cast), `packet` (rays by the 64),
//! `cast` with `cone`, `across`, `intersect` and `first_hit` (what they hit), `end` (gates and noise), `pyramid` and
//! `carve_voxels` with `asked`, or `carve_rays` with `through` (what they free). `together` does it on several threads where
//! there are fewer poses than those.

mod across;
mod alike;
mod asked;
mod beyond;
mod blocker_search;
mod carve_rays;
mod carve_voxels;
mod cast;
mod cone;
mod end;
mod first_hit;
mod intersect;
mod limits;
mod narrow;
mod nearest_range;
mod open_voxels;
mod packet;
mod plan;
mod projection;
mod pyramid;
mod scratch;
mod sense;
mod sight;
mod simd;
mod table;
#[cfg(test)]
mod test_camera;
#[cfg(test)]
mod tests;
mod through;
mod together;

use std::collections::VecDeque;
use std::sync::Arc;

use rayon::prelude::*;

use super::{
    Backend, Carving, Evidence, Fusion, GridPose, MEMORY_BYTES, MadeScene, OverTime, Planes, Rays, Reading,
    SceneMaker, Shot, Slot, VoxelScene, count::RegionTally,
};
use crate::march::{End, NOTHING};
use crate::metrics::Confusion;
use crate::voxel::{BitGrid, Window};
use crate::{Error, Result};
pub use blocker_search::{BlockerSearch, RaysFrom};
use first_hit::Layer;
use plan::RelevantVoxels;
use scratch::Scratch;
use sense::PoseCache;
pub use sight::{SightRays, SightScene};
pub use simd::SimdLevel;
use table::{Blockers, RayTable, TableCaster};

/// Most pieces of evidence kept at once, however small they are.
const MOST_SLOTS: usize = 4096;

/// Most rays of tables that are kept ready though no job needs them now: some fifty bytes each.
const SPARE_RAYS: usize = 1 << 21;

/// The thread pool and what it works on.
pub struct Cpu {
    pool: rayon::ThreadPool,
    memory_bytes: u64,
    simd: SimdLevel,
    carving: Option<Carving>,
    tables: Vec<RayTable>,
    /// Tables that were ready before, the latest last: as many as have no more than [`SPARE_RAYS`].
    spare: Vec<RayTable>,
    loaded: Option<LoadedScene>,
    /// Scenes that were loaded before, the latest last: as many as have room.
    earlier: Vec<LoadedScene>,
    slots: Vec<Option<Planes>>,
    /// What is kept of poses from snapshot to snapshot, by slot.
    kept: Vec<PoseCache>,
    /// Most words of a plane that is kept so.
    plane_words: usize,
    answers: VecDeque<Vec<Vec<Confusion>>>,
}

/// A scene made ready.
struct LoadedScene {
    scene: VoxelScene,
    /// Those over all snapshots, which scenes of the same snapshots share.
    layers: Option<Arc<Layers>>,
    /// The other blockers, or all.
    moving: Arc<Layer>,
    wanted: RelevantVoxels,
    tally: RegionTally,
}

/// Blockers over all snapshots, made ready.
struct Layers {
    /// Of every snapshot.
    always: Layer,
    /// Of some.
    sometimes: Layer,
}

/// What other scenes may take from a scene that was made ready.
struct KnownScene {
    blockers: Arc<BitGrid>,
    over_time: Option<Arc<OverTime>>,
    window: Window,
    layers: Option<Arc<Layers>>,
    moving: Arc<Layer>,
}

impl From<&LoadedScene> for KnownScene {
    fn from(LoadedScene { scene, layers, moving, .. }: &LoadedScene) -> KnownScene {
        KnownScene {
            blockers: scene.blockers.clone(),
            over_time: scene.over_time.clone(),
            window: scene.window,
            layers: layers.clone(),
            moving: moving.clone(),
        }
    }
}

impl LoadedScene {
    /// Makes a scene ready; those that are known may have some of it.
    fn new(scene: &VoxelScene, known: &[KnownScene]) -> Self {
        let has_layers = |known: &KnownScene, all: &OverTime| {
            known.over_time.as_ref().is_some_and(|known| known.has_layers_of(all))
        };
        let same = |all: &OverTime| {
            known.iter().find(|known| has_layers(known, all)).and_then(|known| known.layers.clone())
        };
        let ready = |all: &OverTime| {
            let mut sometimes = BitGrid::clone(&all.ever);
            sometimes.remove(&all.always);
            let always = Layer::new(BitGrid::clone(&all.always));
            Arc::new(Layers { always, sometimes: Layer::new(sometimes) })
        };
        let is_alike = |known: &&KnownScene| {
            let has_same_layers = match &scene.over_time {
                Some(all) => has_layers(known, all),
                None => known.over_time.is_none(),
            };
            Arc::ptr_eq(&known.blockers, &scene.blockers) && has_same_layers
        };
        let moving = || {
            let mut moving = BitGrid::clone(&scene.blockers);
            scene.over_time.iter().for_each(|all| moving.remove(&all.always));
            Arc::new(Layer::new(moving))
        };
        let wanted = RelevantVoxels::new(scene.window, &scene.regions);
        LoadedScene {
            layers: scene.over_time.as_deref().map(|all| same(all).unwrap_or_else(|| ready(all))),
            moving: known.iter().find(is_alike).map_or_else(moving, |known| known.moving.clone()),
            wanted,
            tally: RegionTally::new(scene),
            scene: scene.clone(),
        }
    }

    fn blockers(&self) -> Blockers<'_> {
        let layers = self.layers.as_deref();
        Blockers {
            still: layers.map(|layers| &layers.always),
            moving: &self.moving,
            sometimes: layers.map(|layers| &layers.sometimes),
        }
    }

    /// About how much memory it takes: planes of the grid and of the window, and the bricks.
    fn bytes(&self) -> u64 {
        let VoxelScene { blockers, truth, regions, .. } = &self.scene;
        let (whole, part) = (blockers.words().len() as u64, truth.words().len() as u64);
        4 * (2 * whole + (5 + 2 * regions.len() as u64) * part)
    }
}

impl Cpu {
    /// A backend of `threads` threads, or of as many as the process may use (cgroup limits honoured).
    pub fn new(threads: Option<usize>) -> Result<Self> {
        let available = std::thread::available_parallelism().map_or(1, |n| n.get());
        let pool =
            rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(available)).build().map_err(
                |e| Error::device(format!("cannot start {} threads: {e}", threads.unwrap_or(available))),
            )?;
        Ok(Cpu {
            pool,
            memory_bytes: MEMORY_BYTES,
            simd: SimdLevel::most(),
            carving: None,
            tables: Vec::new(),
            spare: Vec::new(),
            loaded: None,
            earlier: Vec::new(),
            kept: Vec::new(),
            plane_words: 0,
            slots: Vec::new(),
            answers: VecDeque::new(),
        })
    }

    /// The same with half of so much memory for evidence, a quarter for first hits and a quarter for scenes that may come
    /// back, instead of [`MEMORY_BYTES`].
    pub(crate) fn memory(self, bytes: u64) -> Self {
        Cpu { memory_bytes: bytes, ..self }
    }

    /// The same with some of the vector instructions that the processor has, instead of all.
    pub fn simd(self, simd: SimdLevel) -> Self {
        Cpu { simd, ..self }
    }

    /// The same, with all tables carved in one way, whatever that costs. Only tables of cameras can be carved
    /// voxel by voxel.
    pub fn carving(mut self, carving: Carving) -> Self {
        self.carving = Some(carving);
        self
    }

    fn loaded_scene(&self) -> Result<&LoadedScene> {
        self.loaded.as_ref().ok_or_else(|| Error::device("no scene is loaded"))
    }

    /// Forgets the oldest of the earlier scenes until the others take no more than a quarter of the memory.
    fn forget_earlier(&mut self) {
        let mut room = self.memory_bytes / 4;
        let fitting = self.earlier.iter().rev().take_while(|scene| {
            let left = room.checked_sub(scene.bytes());
            room = left.unwrap_or(0);
            left.is_some()
        });
        let forgotten = self.earlier.len() - fitting.count();
        self.earlier.drain(..forgotten);
    }

    /// What is kept for a shot; nothing yet if it is new.
    fn take_kept(&mut self, shot: &Shot) -> Option<PoseCache> {
        let slot = shot.first_hits? as usize;
        if self.kept.len() <= slot {
            self.kept.resize(slot + 1, PoseCache::default());
        }
        Some(std::mem::take(&mut self.kept[slot]))
    }

    /// A table's rays in the loaded scene.
    fn sensor<'a>(&'a self, table: usize, wanted: &'a RelevantVoxels) -> Result<TableCaster<'a>> {
        let table = self.tables.get(table).ok_or_else(|| super::no_table(table))?;
        let LoadedScene { scene, .. } = self.loaded_scene()?;
        let blockers = self.loaded_scene()?.blockers();
        let shades = scene.shades.as_deref().filter(|_| table.gates.has_shades());
        let (level, wide) = (self.simd.level, self.simd.wide);
        let (carving, plane_words) = (self.carving, self.plane_words);
        Ok(TableCaster { level, wide, table, blockers, shades, wanted, carving, plane_words })
    }
}

impl Backend for Cpu {
    fn name(&self) -> &'static str {
        "cpu"
    }

    fn device(&self) -> String {
        let threads = self.pool.current_num_threads();
        format!("{threads} thread{}", if threads == 1 { "" } else { "s" })
    }

    fn tables(&mut self, tables: &[Rays]) -> Result<()> {
        self.kept.clear();
        let mut ready = std::mem::take(&mut self.spare);
        ready.append(&mut self.tables);
        let table = |rays: &Rays| match ready.iter().position(|table| table.rays.is_clone_of(rays)) {
            Some(known) => ready.swap_remove(known),
            None => RayTable::new(rays),
        };
        self.tables = tables.iter().map(table).collect();
        let mut room = SPARE_RAYS;
        let fitting = ready.iter().rev().take_while(|table| {
            let left = room.checked_sub(table.packets.rays());
            room = left.unwrap_or(0);
            left.is_some()
        });
        let forgotten = ready.len() - fitting.count();
        self.spare = ready.split_off(forgotten);
        Ok(())
    }

    fn load(&mut self, scene: &VoxelScene) -> Result<()> {
        self.load_made(scene, None)
    }

    fn scene_maker(&self) -> Option<SceneMaker> {
        let known: Vec<KnownScene> = self.earlier.iter().chain(&self.loaded).map(KnownScene::from).collect();
        Some(Box::new(move |scene| {
            let is_known = |known: &KnownScene| {
                known.window == scene.window && Arc::ptr_eq(&known.blockers, &scene.blockers)
            };
            (!known.iter().any(is_known)).then(|| Box::new(LoadedScene::new(scene, &known)) as MadeScene)
        }))
    }

    fn load_made(&mut self, scene: &VoxelScene, made: Option<MadeScene>) -> Result<()> {
        let evidence = usize::try_from(self.memory_bytes / 2).unwrap_or(usize::MAX);
        let piece = 3 * 4 * scene.truth.words().len().max(1);
        // Even where a piece of evidence is large, each thread has one to work on, and a job of several
        // sensors fits.
        let least = 4 * self.pool.current_num_threads().max(4);
        self.slots = vec![None; (evidence / piece).min(MOST_SLOTS).max(least)];
        let before = self.loaded.take();
        let was = before.as_ref().and_then(|loaded| loaded.scene.over_time.clone());
        if !was.iter().zip(&scene.over_time).any(|(was, is)| Arc::ptr_eq(was, is)) {
            self.kept.clear();
            self.plane_words = scene.truth.words().len();
        }
        self.earlier.extend(before);
        let known = self.earlier.iter().rposition(|earlier| earlier.scene.is_same(scene));
        self.loaded = Some(match known.map(|known| self.earlier.remove(known)) {
            Some(known) => LoadedScene { scene: scene.clone(), ..known },
            None => match made.and_then(|made| made.downcast::<LoadedScene>().ok()) {
                // First hits are numbered by the scene that is loaded.
                Some(made) => LoadedScene { scene: scene.clone(), ..*made },
                None => {
                    let known: Vec<KnownScene> = self.earlier.iter().map(KnownScene::from).collect();
                    LoadedScene::new(scene, &known)
                }
            },
        });
        self.forget_earlier();
        log::debug!("cpu: scene loaded, room for {} pieces of evidence of {piece} bytes", self.slots.len());
        Ok(())
    }

    fn slots(&self) -> usize {
        self.slots.len()
    }

    fn first_hit_slots(&self) -> usize {
        let Some(loaded) = self.loaded.as_ref().filter(|loaded| loaded.layers.is_some()) else { return 0 };
        let of_table = |table: &RayTable| {
            let rays = table.packets.count() * packet::RAYS;
            // A first hit of each ray; of rays that are carved one by one also up to where each is marked, which of them
            // meet what moves, and a plane.
            match self.carving.unwrap_or_else(|| plan::carving(&table.packets, loaded.scene.window)) {
                Carving::ByVoxel if table.packets.image().is_some() => 4 * rays,
                _ => 9 * rays + 4 * self.plane_words,
            }
        };
        let most = self.tables.iter().map(of_table).max().unwrap_or(0);
        usize::try_from(self.memory_bytes / 4).unwrap_or(usize::MAX) / most.max(1)
    }

    fn sense(&mut self, table: usize, shots: &[Shot]) -> Result<()> {
        log::debug!("cpu: casts table of rays {table} from {} poses", shots.len());
        let mut kept: Vec<Option<PoseCache>> = shots.iter().map(|shot| self.take_kept(shot)).collect();
        let loaded = self.loaded_scene()?;
        let sensor = self.sensor(table, &loaded.wanted)?;
        let threads = self.pool.current_num_threads();
        let is_large = sensor.table.packets.rays() >= together::LEAST_RAYS;
        let sensed: Vec<Planes> = self.pool.install(|| {
            if shots.len() < threads && is_large && kept.iter().all(Option::is_none) {
                return shots.iter().map(|shot| sensor.sense_together(&shot.placement, threads)).collect();
            }
            let each = shots.par_iter().zip(&mut kept).map_init(
                || Scratch::new(&sensor),
                |scratch, (shot, kept)| sensor.sense(&shot.placement, scratch, kept.as_mut(), None),
            );
            each.collect()
        });
        for ((shot, planes), kept) in shots.iter().zip(sensed).zip(kept) {
            self.slots[shot.slot as usize] = Some(planes);
            if let (Some(slot), Some(kept)) = (shot.first_hits, kept) {
                self.kept[slot as usize] = kept;
            }
        }
        Ok(())
    }

    fn upload(&mut self, evidence: Vec<(Slot, Planes)>) -> Result<()> {
        let window = self.loaded_scene()?.scene.window;
        for (slot, mut planes) in evidence {
            // Hits are looked up by their words.
            if planes.hits.window() != window {
                let blank = planes.hits.is_empty();
                planes.hits = if blank { BitGrid::nowhere() } else { planes.hits.to_window(window) };
            }
            self.slots[slot as usize] = Some(planes);
        }
        Ok(())
    }

    fn submit(&mut self, fusion: Fusion, jobs: &[Vec<Reading>]) -> Result<()> {
        log::debug!("cpu: scores {} choices", jobs.len());
        let tally = &self.loaded_scene()?.tally;
        let planes = |slot: Slot| self.slots[slot as usize].as_ref();
        let score = |job: &Vec<Reading>| tally.score(self.simd.level, fusion, job, planes);
        let answer = self.pool.install(|| jobs.par_iter().map(score).collect());
        self.answers.push_back(answer);
        Ok(())
    }

    fn receive(&mut self) -> Result<Vec<Vec<Confusion>>> {
        self.answers.pop_front().ok_or_else(super::nothing_submitted)
    }

    fn planes(&mut self, slots: &[Slot]) -> Result<Vec<Planes>> {
        super::planes_in(&self.slots, slots)
    }

    fn read(&mut self, table: usize, placement: &GridPose) -> Result<Evidence> {
        let wanted = RelevantVoxels::all(self.loaded_scene()?.scene.window);
        let sensor = self.sensor(table, &wanted)?;
        let mut ends = vec![End { kind: NOTHING, crossings: 0 }; sensor.table.packets.rays()];
        let planes = sensor.sense(placement, &mut Scratch::new(&sensor), None, Some(&mut ends));
        Ok(Evidence { planes, ends })
    }
}
