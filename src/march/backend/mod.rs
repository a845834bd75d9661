//! The backends behind one trait: quantised placements in, integers out. All give the same counts: `oracle`
//! defines them, `cpu` and `gpu` are fast. The command line of perirobot chooses one, once.

pub mod adapter;
pub mod body_words;
mod count;
pub mod cpu;
pub mod factory;
mod fuse;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod lost;
pub mod oracle;
mod self_test;

use std::any::Any;
use std::sync::Arc;

use crate::Result;
use crate::march::{self, End, Gates, March, SHADE_BITS, Slant};
use crate::metrics::Confusion;
use crate::voxel::{BitGrid, People, Window};
pub use fuse::{Saying, settle};
pub use self_test::{POSES as SELF_TEST_POSES, self_test};

/// One scene at one moment, as the backends see it. All planes but `blockers` cover `window`.
#[derive(Clone, Debug)]
pub struct VoxelScene {
    /// What stops rays, over the whole grid.
    pub blockers: Arc<BitGrid>,
    /// How much light its blockers reflect, if that differs.
    pub shades: Option<Arc<Shades>>,
    /// What blocks in every snapshot and what in any, by which the work for one serves the others: the same
    /// allocation (`Arc::ptr_eq`) in all snapshots of a scene, and another one when the numbers for first
    /// hits start over. `None` where there is one snapshot.
    pub over_time: Option<Arc<OverTime>>,
    /// The part of the grid where evidence is kept: normally the bounding box of the regions.
    pub window: Window,
    /// Truly occupied voxels.
    pub truth: BitGrid,
    /// Voxels of a person.
    pub human: BitGrid,
    /// Voxels of the robot.
    pub robot: BitGrid,
    /// The voxels of each region.
    pub regions: Vec<BitGrid>,
    /// The voxels of people: of whom, and of which part of the body.
    pub people: People,
}

impl VoxelScene {
    /// Whether all of it is as in another scene, but for the numbers of first hits.
    pub(crate) fn is_same(&self, other: &VoxelScene) -> bool {
        self.has_same_layers(other)
            && (self.window, &self.people) == (other.window, &other.people)
            && self.shades == other.shades
            && (Arc::ptr_eq(&self.blockers, &other.blockers) || self.blockers == other.blockers)
            && [&self.truth, &self.human, &self.robot] == [&other.truth, &other.human, &other.robot]
            && self.regions == other.regions
    }

    /// Whether the same blocks over all snapshots.
    pub(crate) fn has_same_layers(&self, other: &VoxelScene) -> bool {
        match (&self.over_time, &other.over_time) {
            (None, None) => true,
            (Some(own), Some(other)) => own.has_layers_of(other),
            _ => false,
        }
    }
}

/// How dark voxels are, over the whole grid: a number from 0, which every sensor detects up to its longest range, to
/// [`SHADES`](march::SHADES), which it detects up to [`Gates::shade_ranges_q16`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shades {
    /// The bits of the numbers, the lowest first; all planes cover the same window.
    pub bits: [BitGrid; SHADE_BITS],
}

impl Shades {
    /// The number of a voxel.
    #[inline]
    pub fn of(&self, voxel: [i32; 3]) -> usize {
        let bits = self.bits.iter().enumerate();
        bits.map(|(place, plane)| usize::from(plane.get(voxel)) << place).sum()
    }

    /// Whether a return that comes from a voxel at a distance is too weak to be detected. The gates are those of its ray.
    #[inline]
    pub fn is_too_weak(&self, voxel: [i32; 3], t_q16: u32, gates: &Gates) -> bool {
        match self.of(voxel) {
            0 => false,
            shade => t_q16 > gates.shade_ranges_q16[shade - 1],
        }
    }
}

/// The blockers of a scene over all its snapshots, each over the whole grid.
#[derive(Clone, Debug)]
pub struct OverTime {
    /// Those of every snapshot, which stand still: against them rays are cast only once.
    pub always: Arc<BitGrid>,
    /// Those of any.
    pub ever: Arc<BitGrid>,
}

impl OverTime {
    /// Whether both layers are the very allocations of another's.
    pub(crate) fn has_layers_of(&self, other: &OverTime) -> bool {
        Arc::ptr_eq(&self.always, &other.always) && Arc::ptr_eq(&self.ever, &other.ever)
    }
}

/// One table of rays, as the backends see it: where they go, what ends them, and what chance does to them.
#[derive(Clone, Debug)]
pub struct Rays {
    /// Unit directions in the sensor's frame, Q15, in ray order. Depth is measured along its third axis. A clone of a
    /// table shares them, so that a backend recognises a table that it has made ready.
    pub dirs_q15: Arc<Vec<[i32; 3]>>,
    /// Where the rays come from, if they are the pixels of a camera, row by row.
    pub image: Option<Image>,
    /// Ranges and rules that decide how a ray ends.
    pub gates: Gates,
    /// How far off returns are read, and how many are lost.
    pub noise: Noise,
}

impl Rays {
    /// Whether the other is a clone of this table. A table that was made again from the same sensor is not.
    pub(crate) fn is_clone_of(&self, other: &Rays) -> bool {
        Arc::ptr_eq(&self.dirs_q15, &other.dirs_q15)
            && (self.image, self.gates, &self.noise) == (other.image, other.gates, &other.noise)
    }

    /// The gates of a ray of the table, along it.
    pub fn gates_of(&self, ray: usize) -> Gates {
        self.gates.ray_gates(self.dirs_q15[ray][2])
    }

    /// The slant of the ray that is the most slanted.
    pub fn most_slant(&self) -> Slant {
        self.gates.slant(self.dirs_q15.iter().map(|dir| dir[2]).min().unwrap_or(0))
    }

    /// The farthest before its distance that a return may be read.
    pub(crate) fn nearest_q16(&self) -> u32 {
        self.noise.most_q16(self.most_slant(), i32::min).unsigned_abs()
    }

    /// The farthest behind its distance that a return may be read.
    #[cfg(feature = "gpu")]
    pub(crate) fn farthest_q16(&self) -> u32 {
        self.noise.most_q16(self.most_slant(), i32::max) as u32
    }
}

/// What chance does to returns. The default does nothing.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Noise {
    /// Equally likely deviations of unit width in 1/4096: [`march::NOISE_STEPS`] of them, or none where returns are exact.
    pub unit_q12: Vec<i32>,
    /// Width by which those are multiplied, in 1/65536 voxels: an entry for each whole voxel of distance, or of depth, up to the
    /// longest range; empty with the other table.
    pub std_q16: Vec<u32>,
    /// A return is lost where its ray's number, hashed again, is below this ([`march::is_lost`]).
    pub lost_below: u32,
}

impl Noise {
    /// The error in distance of a return within the range whose ray has this slant and drew this number.
    #[inline]
    pub fn step_q16(&self, slant: Slant, drawn: u32, t_q16: u32) -> i32 {
        match self.unit_q12.is_empty() {
            true => 0,
            false => {
                let unit_q12 = self.unit_q12[march::entry(drawn) as usize];
                let std_q16 = self.std_q16[(t_q16 / slant.period_q16) as usize];
                march::step_q16(unit_q12, march::std_along_q16(std_q16, slant.period_q16))
            }
        }
    }

    /// The largest error of either sign along a ray of a slant.
    fn most_q16(&self, slant: Slant, largest: fn(i32, i32) -> i32) -> i32 {
        let unit_q12 = self.unit_q12.iter().copied().fold(0, largest);
        let std_q16 = self.std_q16.iter().copied().max().unwrap_or(0);
        march::step_q16(unit_q12, march::std_along_q16(std_q16, slant.period_q16))
    }
}

/// An ideal pinhole camera: ray (u, v) goes along ((u + ½ − width/2) / focal x, (v + ½ − height/2) / focal y, 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Image {
    /// Pixels across and down.
    pub size_px: [u32; 2],
    /// Focal lengths in pixels.
    pub focal_px: [f64; 2],
}

/// One pose of a sensor in a grid, quantised: where it is believed to be, which is where its evidence is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GridPose {
    /// Position from the grid's corner, in 1/65536 voxels; inside the grid.
    pub origin_q16: [i32; 3],
    /// Row r of `world_from_sensor`, Q15.
    pub axis_q15: [[i32; 3]; 3],
    /// Where it truly is, if its mount is off: its rays are cast from there.
    pub truly: Option<GridFrame>,
    /// The hash of all words before the ray, for rays with noise ([`crate::march::fold`]).
    pub draws: u32,
}

/// Where a sensor is and how it is turned, quantised as in a [`GridPose`]; the twin of `GridFrame` in
/// `shaders/types.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct GridFrame {
    /// As [`GridPose::origin_q16`].
    pub origin_q16: [i32; 3],
    /// As [`GridPose::axis_q15`].
    pub axis_q15: [[i32; 3]; 3],
}

impl GridPose {
    /// A ray of a table from where it is believed to be.
    pub fn launch(&self, dir_q15: [i32; 3]) -> March {
        march::launch(self.origin_q16, self.axis_q15, dir_q15)
    }

    /// Where its rays are cast from: the true standpoint, as if it were the believed one.
    pub fn caster(&self) -> GridPose {
        match self.truly {
            None => *self,
            Some(GridFrame { origin_q16, axis_q15 }) => {
                GridPose { origin_q16, axis_q15, truly: None, draws: self.draws }
            }
        }
    }
}

/// What a sensor says: three planes over a window, or over parts of it outside of which it says nothing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Planes {
    /// Voxels that the sensor calls occupied.
    pub occupied: BitGrid,
    /// Voxels that it calls free; `occupied` wins where both are set.
    pub free: BitGrid,
    /// Voxels that its returns truly come from, whatever distance they are read at.
    pub hits: BitGrid,
}

impl Planes {
    /// Nothing is said of any voxel of a window.
    pub fn blank(window: Window) -> Planes {
        let blank = BitGrid::new(window);
        Planes { occupied: blank.clone(), free: blank.clone(), hits: blank }
    }

    /// Joins what else is said, as far as it lies in their windows.
    pub fn add(&mut self, other: &Planes) {
        self.occupied.add(&other.occupied);
        self.free.add(&other.free);
        self.hits.add(&other.hits);
    }

    /// The planes with their names, in order.
    pub fn planes_with_names(&self) -> [(&'static str, &BitGrid); 3] {
        [("occupied", &self.occupied), ("free", &self.free), ("hits", &self.hits)]
    }
}

/// All that casting one placement tells: planes over the scene's window, and how each ray ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Evidence {
    /// Endpoints, the voxels that returning (or certifying) rays passed, and the blockers that returns come from.
    pub planes: Planes,
    /// One end a ray, in ray order; the end of a noisy return is where it is read.
    pub ends: Vec<End>,
}

/// Where a backend keeps a piece of evidence: a number below [`Backend::slots`].
pub type Slot = u32;

/// A placement to be cast.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shot {
    /// Where its evidence goes.
    pub slot: Slot,
    /// Where the sensor is.
    pub placement: GridPose,
    /// Where to keep what its rays hit first in the scene's still layer, and to find it again in the next scene of the
    /// same layer: a number below [`Backend::first_hit_slots`]. A number stands for one table and placement, but for its
    /// draws, as long as the layer is loaded.
    pub first_hits: Option<Slot>,
}

impl Shot {
    /// A placement that is cast in this scene only.
    pub fn once(slot: Slot, placement: GridPose) -> Self {
        Shot { slot, placement, first_hits: None }
    }
}

/// What one sensor contributes to a fusion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reading {
    /// Its evidence.
    pub slot: Slot,
    /// More of the same sensor's evidence, joined with the first: the volumes around what it detected.
    pub volume: Option<Slot>,
    /// What `occupied` adds to a voxel's log-odds, in thousandths.
    pub hit: i32,
    /// What `free` adds.
    pub miss: i32,
    /// Whether its hits are voxels of people that a presence sensor feels: one is enough to detect a person.
    pub presence: bool,
}

/// How the voxels that a placement frees are found; every way gives the same.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Carving {
    /// Voxels look at the pixels that see them: for cameras.
    ByVoxel,
    /// Rays mark the voxels they pass.
    ByRay,
}

/// How the evidence of several sensors becomes one label a voxel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fusion {
    /// Occupied if any sensor says so, else free if any does, else unknown.
    #[default]
    OccupiedWins,
    /// Log-odds summed in the order of the sensors, clamped after each; above zero is occupied, below is free.
    Octomap,
}

impl Fusion {
    /// As in a study.
    pub fn name(self) -> &'static str {
        match self {
            Fusion::OccupiedWins => "occupied_wins",
            Fusion::Octomap => "octomap",
        }
    }
}

/// Smallest and largest log-odds of a voxel, in thousandths (OctoMap's defaults).
pub const LOG_ODDS: std::ops::RangeInclusive<i32> = -2000..=3511;

/// Bytes that a backend may take for evidence, first hits and batches by default: little compared with the
/// memory of any machine that sweeps. Half of it is for evidence.
pub const MEMORY_BYTES: u64 = 512 << 20;

/// Rays that a call of [`Backend::sense`] casts, as far as that keeps a processor busy: those of some twenty cameras.
pub const RAYS_AT_ONCE: usize = 1 << 24;

/// What a stage of a backend's work took so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StageTiming {
    /// The stage, by the name of its kernel.
    pub stage: &'static str,
    /// As far as it was timed.
    pub took: std::time::Duration,
    /// How often it was dispatched.
    pub dispatches: u64,
    /// Placements or jobs in all these dispatches; a part of one counts as one.
    pub rows: u64,
    /// Invocations in all of them, those without work included.
    pub lanes: u64,
}

/// What the host makes of a scene before a backend loads it, in the backend's own form.
pub type MadeScene = Box<dyn Any + Send>;

/// Makes that, or nothing of a scene that the backend knows.
pub type SceneMaker = Box<dyn FnOnce(&VoxelScene) -> Option<MadeScene> + Send>;

/// A backend. Ray tables and a scene are loaded, evidence is cast or uploaded into slots, and fused from there any
/// number of times.
pub trait Backend {
    /// `oracle`, `cpu` or `gpu`.
    fn name(&self) -> &'static str;

    /// What runs: adapter or processor, for people and manifests.
    fn device(&self) -> String;

    /// Makes the tables of a study's casting sensors ready, in the order by which [`Backend::sense`] names them. Tables that
    /// are clones of those that are ready cost nothing.
    fn tables(&mut self, tables: &[Rays]) -> Result<()>;

    /// Makes a scene ready, and forgets all evidence; no request may be open. If the scene does not fit the
    /// device, the error says what would. A scene that was loaded lately may cost little.
    fn load(&mut self, scene: &VoxelScene) -> Result<()>;

    /// Makes of a scene, on any thread and while the backend works on another one, what [`Backend::load_made`] takes; `None`
    /// where all is made in [`Backend::load`].
    fn scene_maker(&self) -> Option<SceneMaker> {
        None
    }

    /// As [`Backend::load`], with what the scene maker made of the same scene, if anything.
    fn load_made(&mut self, scene: &VoxelScene, made: Option<MadeScene>) -> Result<()> {
        drop(made);
        self.load(scene)
    }

    /// How many pieces of evidence of the loaded scene can be kept at once; at least 1.
    fn slots(&self) -> usize;

    /// How many placements' first hits in the still layer can be kept at once; 0 if the scene has no such layer.
    fn first_hit_slots(&self) -> usize;

    /// How many rays of one call of [`Backend::sense`] keep the device busy.
    fn rays_at_once(&self) -> usize {
        RAYS_AT_ONCE
    }

    /// Casts a table's rays from placements; what each proves replaces what its slot held. No slot comes twice.
    fn sense(&mut self, table: usize, shots: &[Shot]) -> Result<()>;

    /// Puts evidence made by the host into slots. Planes cover the scene's window or any part of it. No slot comes twice.
    fn upload(&mut self, evidence: Vec<(Slot, Planes)>) -> Result<()>;

    /// Asks for the readings of each job to be fused, in their order, and for the labels and the hits in each region of the
    /// scene to be counted. What is cast or uploaded later changes nothing.
    fn submit(&mut self, fusion: Fusion, jobs: &[Vec<Reading>]) -> Result<()>;

    /// Waits for the counts of the oldest open request: of each job, in each region, with who is detected
    /// there.
    fn receive(&mut self) -> Result<Vec<Vec<Confusion>>>;

    /// Submits and waits. No other request may be open.
    fn score(&mut self, fusion: Fusion, jobs: &[Vec<Reading>]) -> Result<Vec<Vec<Confusion>>> {
        self.submit(fusion, jobs)?;
        self.receive()
    }

    /// What the stages of its work took so far, in the order they run; nothing where there are none.
    fn timings(&self) -> Vec<StageTiming> {
        Vec::new()
    }

    /// What slots hold, each over the scene's window, or over a part of it outside of which it says nothing. What it says of
    /// voxels outside all regions may be less than the sensor would claim.
    fn planes(&mut self, slots: &[Slot]) -> Result<Vec<Planes>>;

    /// All that is known of one placement, for comparisons, exports and pictures. No slot survives it.
    fn read(&mut self, table: usize, placement: &GridPose) -> Result<Evidence>;
}

/// What several sensors say together, in the order they speak, over a window: their planes, and what `occupied` and `free`
/// add to a voxel's log-odds. No voxel of the answer is both occupied and free; its hits are those of any sensor.
pub fn fuse(window: Window, fusion: Fusion, voices: &[(Planes, [i32; 2])]) -> Planes {
    let reading = |(slot, (_, [hit, miss])): (usize, &(Planes, [i32; 2]))| Reading {
        slot: slot as Slot,
        volume: None,
        hit: *hit,
        miss: *miss,
        presence: false,
    };
    let readings: Vec<_> = voices.iter().enumerate().map(reading).collect();
    fuse::fuse(window, fusion, &readings, |slot| voices.get(slot as usize).map(|(planes, _)| planes))
}

/// The error for a table that was never made ready.
fn no_table(table: usize) -> crate::Error {
    crate::Error::device(format!("no table {table} of rays is loaded"))
}

/// The error for a slot that holds nothing.
fn nothing_in(slot: Slot) -> crate::Error {
    crate::Error::device(format!("slot {slot} holds no evidence of this scene"))
}

/// The evidence in some of the slots that are held.
fn planes_in(held: &[Option<Planes>], slots: &[Slot]) -> Result<Vec<Planes>> {
    let planes = |&slot: &Slot| held.get(slot as usize).and_then(Option::clone);
    slots.iter().map(|slot| planes(slot).ok_or_else(|| nothing_in(*slot))).collect()
}

/// The error for an answer without a request.
fn nothing_submitted() -> crate::Error {
    crate::Error::device("no question is open")
}
