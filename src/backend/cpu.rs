//! All cores, one placement or one job a thread: cast a ray keeping its path, carve the path, fuse and count by
//! words. The arithmetic is `march`, the twin of the shaders'.

use std::collections::VecDeque;

use rayon::prelude::*;

use super::{
    Backend, Cell, Evidence, Fusion, MEMORY_BYTES, Placement, Planes, Rays, Reading, Shot, Slot, count::Tally,
};
use crate::march::{self, End, Gates, March};
use crate::metrics::Confusion;
use crate::voxel::{BitGrid, grid::MAX_VOXELS_PER_AXIS};
use crate::{Error, Result};

/// Most pieces of evidence kept at once, however small they are.
const MOST_SLOTS: usize = 4096;

/// The thread pool and what it works on.
pub struct Cpu {
    pool: rayon::ThreadPool,
    memory_bytes: u64,
    tables: Vec<Rays>,
    cell: Option<Cell>,
    tally: Option<Tally>,
    slots: Vec<Option<Planes>>,
    answers: VecDeque<Vec<Vec<Confusion>>>,
}

impl Cpu {
    /// A backend of `threads` threads, or of as many as the process may use (cgroup limits honoured).
    pub fn new(threads: Option<usize>) -> Result<Self> {
        let available = std::thread::available_parallelism().map_or(1, |n| n.get());
        let pool =
            rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(available)).build().map_err(
                |e| Error::Device(format!("cannot start {} threads: {e}", threads.unwrap_or(available))),
            )?;
        Ok(Cpu {
            pool,
            memory_bytes: MEMORY_BYTES,
            tables: Vec::new(),
            cell: None,
            tally: None,
            slots: Vec::new(),
            answers: VecDeque::new(),
        })
    }

    /// The same with so much memory for evidence, first hits and batches, instead of [`MEMORY_BYTES`].
    pub fn memory(self, bytes: u64) -> Self {
        Cpu { memory_bytes: bytes, ..self }
    }

    fn cell(&self) -> Result<&Cell> {
        self.cell.as_ref().ok_or_else(no_scene)
    }

    fn table(&self, table: usize) -> Result<&Rays> {
        self.tables.get(table).ok_or_else(|| super::no_table(table))
    }
}

/// The error for a scene that was never made ready.
fn no_scene() -> Error {
    Error::Device("no scene is loaded".into())
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
        self.tables = tables.to_vec();
        Ok(())
    }

    fn load(&mut self, cell: &Cell) -> Result<()> {
        let evidence = usize::try_from(self.memory_bytes / 2).unwrap_or(usize::MAX);
        let piece = 2 * 4 * cell.truth.words().len().max(1);
        // Even where a piece is large, all threads have one to work on, and a job of several sensors fits.
        let least = 4 * self.pool.current_num_threads().max(4);
        self.slots = vec![None; (evidence / piece).clamp(least, MOST_SLOTS)];
        self.tally = Some(Tally::new(cell));
        self.cell = Some(cell.clone());
        Ok(())
    }

    fn slots(&self) -> usize {
        self.slots.len()
    }

    fn hit_slots(&self) -> usize {
        0
    }

    fn sense(&mut self, table: usize, shots: &[Shot]) -> Result<()> {
        let (cell, rays) = (self.cell()?, self.table(table)?);
        let sensed: Vec<Planes> = self.pool.install(|| {
            let each = shots
                .par_iter()
                .map_init(|| blank(cell), |planes, shot| sense(cell, rays, &shot.placement, planes, |_| {}));
            each.collect()
        });
        shots.iter().zip(sensed).for_each(|(shot, planes)| self.slots[shot.slot as usize] = Some(planes));
        Ok(())
    }

    fn upload(&mut self, evidence: Vec<(Slot, Planes)>) -> Result<()> {
        evidence.into_iter().for_each(|(slot, planes)| self.slots[slot as usize] = Some(planes));
        Ok(())
    }

    fn ask(&mut self, fusion: Fusion, jobs: &[Vec<Reading>]) -> Result<()> {
        let tally = self.tally.as_ref().ok_or_else(no_scene)?;
        let planes = |slot: Slot| self.slots[slot as usize].as_ref();
        let score = |job: &Vec<Reading>| tally.score(fusion, job, planes);
        let answer = self.pool.install(|| jobs.par_iter().map(score).collect());
        self.answers.push_back(answer);
        Ok(())
    }

    fn answer(&mut self) -> Result<Vec<Vec<Confusion>>> {
        self.answers.pop_front().ok_or_else(super::nothing_asked)
    }

    fn read(&mut self, table: usize, placement: &Placement) -> Result<Evidence> {
        let (cell, rays) = (self.cell()?, self.table(table)?);
        let mut ends = Vec::with_capacity(rays.dirs_q15.len());
        let planes = sense(cell, rays, placement, &mut blank(cell), |end| ends.push(end));
        Ok(Evidence { planes, ends })
    }
}

/// What a thread marks on, kept from placement to placement. The planes cover the whole grid, so that a cell has one
/// index for blockers and evidence alike.
fn blank(cell: &Cell) -> Planes {
    let window = cell.blockers.window();
    Planes { occupied: BitGrid::new(window), free: BitGrid::new(window) }
}

/// Casts and carves every ray of a placement; `see` hears how each ended. The evidence covers the cell's window.
fn sense(
    cell: &Cell,
    rays: &Rays,
    placement: &Placement,
    Planes { occupied, free }: &mut Planes,
    mut see: impl FnMut(End),
) -> Planes {
    occupied.words_mut().fill(0);
    free.words_mut().fill(0);
    let mut path = Box::new([0; LONGEST_PATH]);
    for (ray, &dir_q15) in rays.dirs_q15.iter().enumerate() {
        let dir_q16 = placement.axis_q15.map(|axis| march::direction_q16(axis, dir_q15));
        let begin = march::start(placement.origin_q16, dir_q16);
        let noise_q16 = match rays.noise_q16.len() {
            0 => 0,
            _ => rays.noise_q16[march::draw(placement.draws, ray as u32) as usize],
        };
        let end = cast(&cell.blockers, begin, &rays.gates, noise_q16, &mut path);
        carve(end, &path[..], &rays.gates, occupied, free);
        see(end);
    }
    Planes { occupied: occupied.over(cell.window), free: free.over(cell.window) }
}

/// Most cells that a ray can be in: it moves one way on each axis.
const LONGEST_PATH: usize = 3 * MAX_VOXELS_PER_AXIS as usize;

/// Marches a ray to its end. `path` receives the bit index of every cell it is in, the first included.
fn cast(
    blockers: &BitGrid,
    begin: March,
    gates: &Gates,
    noise_q16: i32,
    path: &mut [u32; LONGEST_PATH],
) -> End {
    let size = blockers.window().size;
    let row = blockers.words_per_row() as i32 * 32;
    let mut ray = begin;
    let strides = [ray.step[0], ray.step[1] * row, ray.step[2] * row * size[1] as i32];
    let mut bit = ray.cell[0] + ray.cell[1] * row + ray.cell[2] * row * size[1] as i32;
    let mut room = march::room(&begin, size);
    let words = blockers.words();
    let mut crossings = 0;
    loop {
        path[crossings] = bit as u32;
        let axis = march::next_axis(ray.next_q16);
        let t = ray.next_q16[axis];
        if t > gates.range_max_q16 {
            return End { kind: march::NOTHING, crossings: crossings as u32 };
        }
        if room[axis] == 0 {
            let kind = if gates.backdrop { march::LEFT } else { march::NOTHING };
            return End { kind, crossings: crossings as u32 };
        }
        room[axis] -= 1;
        march::cross(&mut ray, axis);
        bit += strides[axis];
        crossings += 1;
        let blocked = words[bit as usize >> 5] >> (bit & 31) & 1 == 1;
        if blocked && t >= gates.near_ignore_q16 {
            path[crossings] = bit as u32;
            if t < gates.range_min_q16 {
                return End { kind: march::BLIND, crossings: crossings as u32 };
            }
            if noise_q16 == 0 {
                return End { kind: march::RETURN, crossings: crossings as u32 };
            }
            let read_q16 = march::noisy_q16(t, noise_q16);
            let read = march::crossings_at(&begin, march::room(&begin, size), read_q16);
            // Read behind the blocker: the path goes on to there.
            for crossings in crossings + 1..=read as usize {
                let axis = march::next_axis(ray.next_q16);
                march::cross(&mut ray, axis);
                bit += strides[axis];
                path[crossings] = bit as u32;
            }
            return End { kind: march::RETURN, crossings: read };
        }
    }
}

/// Marks what a ray's end proves: the leading cells that it frees, and the endpoint of a return.
fn carve(end: End, path: &[u32], gates: &Gates, occupied: &mut BitGrid, free: &mut BitGrid) {
    let freed = march::freed(end, gates.no_return_is_free) as usize;
    let words = free.words_mut();
    for &bit in &path[..freed] {
        words[bit as usize >> 5] |= 1 << (bit & 31);
    }
    if end.kind == march::RETURN {
        let bit = path[end.crossings as usize];
        occupied.words_mut()[bit as usize >> 5] |= 1 << (bit & 31);
    }
}
