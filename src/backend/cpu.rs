//! All cores, one placement a thread: cast a ray keeping its path, carve the path, count by words. The arithmetic is
//! `march`, the twin of the shaders'.

use rayon::prelude::*;

use super::{Backend, Cell, Evidence, Placement, Rays, count};
use crate::march::{self, End, Gates, March};
use crate::metrics::Confusion;
use crate::voxel::{BitGrid, grid::MAX_VOXELS_PER_AXIS};
use crate::{Error, Result};

/// The thread pool and what it works on.
pub struct Cpu {
    pool: rayon::ThreadPool,
    loaded: Option<(Cell, Rays)>,
}

impl Cpu {
    /// A backend of `threads` threads, or of as many as the process may use (cgroup limits honoured).
    pub fn new(threads: Option<usize>) -> Result<Self> {
        let available = std::thread::available_parallelism().map_or(1, |n| n.get());
        let pool =
            rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(available)).build().map_err(
                |e| Error::Device(format!("cannot start {} threads: {e}", threads.unwrap_or(available))),
            )?;
        Ok(Cpu { pool, loaded: None })
    }

    fn loaded(&self) -> Result<&(Cell, Rays)> {
        self.loaded.as_ref().ok_or_else(|| Error::Device("no scene is loaded".into()))
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

    fn load(&mut self, cell: &Cell, rays: &Rays) -> Result<()> {
        self.loaded = Some((cell.clone(), rays.clone()));
        Ok(())
    }

    fn batch(&self) -> usize {
        4 * self.pool.current_num_threads()
    }

    fn score(&mut self, placements: &[Placement]) -> Result<Vec<Vec<Confusion>>> {
        let (cell, rays) = self.loaded()?;
        Ok(self.pool.install(|| {
            placements
                .par_iter()
                .map_init(Planes::of(cell), |planes, placement| {
                    let (occupied, free) = sense(cell, rays, placement, planes, |_| {});
                    let regions = cell.regions.iter();
                    regions.map(|region| count(cell, region, &occupied, &free)).collect()
                })
                .collect()
        }))
    }

    fn read(&mut self, placement: &Placement) -> Result<Evidence> {
        let (cell, rays) = self.loaded()?;
        let mut ends = Vec::with_capacity(rays.dirs_q15.len());
        let mut planes = Planes::of(cell)();
        let (occupied, free) = sense(cell, rays, placement, &mut planes, |end| ends.push(end));
        Ok(Evidence { occupied, free, ends })
    }
}

/// What a thread marks on, kept from placement to placement. The planes cover the whole grid, so that a cell has one
/// index for blockers and evidence alike.
struct Planes {
    occupied: BitGrid,
    free: BitGrid,
}

impl Planes {
    fn of(cell: &Cell) -> impl Fn() -> Planes {
        let window = cell.blockers.window();
        move || Planes { occupied: BitGrid::new(window), free: BitGrid::new(window) }
    }
}

/// Casts and carves every ray of a placement; `see` hears how each ended. The evidence covers the cell's window.
fn sense(
    cell: &Cell,
    rays: &Rays,
    placement: &Placement,
    Planes { occupied, free }: &mut Planes,
    mut see: impl FnMut(End),
) -> (BitGrid, BitGrid) {
    occupied.words_mut().fill(0);
    free.words_mut().fill(0);
    let mut path = Box::new([0; LONGEST_PATH]);
    for &dir_q15 in &rays.dirs_q15 {
        let dir_q16 = placement.axis_q15.map(|axis| march::direction_q16(axis, dir_q15));
        let begin = march::start(placement.origin_q16, dir_q16);
        let end = cast(&cell.blockers, begin, &rays.gates, &mut path);
        carve(end, &path[..], &rays.gates, occupied, free);
        see(end);
    }
    (occupied.over(cell.window), free.over(cell.window))
}

/// Most cells that a ray can be in: it moves one way on each axis.
const LONGEST_PATH: usize = 3 * MAX_VOXELS_PER_AXIS as usize;

/// Marches a ray to its end. `path` receives the bit index of every cell it is in, the first included.
fn cast(blockers: &BitGrid, mut ray: March, gates: &Gates, path: &mut [u32; LONGEST_PATH]) -> End {
    let size = blockers.window().size;
    let row = blockers.words_per_row() as i32 * 32;
    let strides = [ray.step[0], ray.step[1] * row, ray.step[2] * row * size[1] as i32];
    let mut bit = ray.cell[0] + ray.cell[1] * row + ray.cell[2] * row * size[1] as i32;
    // How many crossings of each axis stay inside the grid.
    let mut room: [i32; 3] = std::array::from_fn(|r| match ray.step[r] {
        -1 => ray.cell[r],
        _ => size[r] as i32 - 1 - ray.cell[r],
    });
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
            let kind = if t < gates.range_min_q16 { march::BLIND } else { march::RETURN };
            return End { kind, crossings: crossings as u32 };
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
