//! The plain oracle: one ray after the other, one step after the other, in u64 arithmetic written straight from
//! the rules, sharing nothing with `march` or the other backends. It defines the counts; it is lean, but not clever.

use super::{Backend, Cell, Evidence, Placement, Rays};
use crate::march::{BLIND, End, LEFT, NEVER, NOTHING, RETURN};
use crate::metrics::{COUNTERS, Confusion};
use crate::voxel::BitGrid;
use crate::{Error, Result};

/// The oracle and what it works on.
#[derive(Default)]
pub struct Oracle {
    loaded: Option<(Cell, Rays)>,
}

impl Backend for Oracle {
    fn name(&self) -> &'static str {
        "oracle"
    }

    fn device(&self) -> String {
        "one thread, plain march".into()
    }

    fn load(&mut self, cell: &Cell, rays: &Rays) -> Result<()> {
        self.loaded = Some((cell.clone(), rays.clone()));
        Ok(())
    }

    fn batch(&self) -> usize {
        1
    }

    fn score(&mut self, placements: &[Placement]) -> Result<Vec<Vec<Confusion>>> {
        placements
            .iter()
            .map(|placement| {
                let evidence = self.read(placement)?;
                let (cell, _) = self.loaded()?;
                Ok(cell.regions.iter().map(|region| count(cell, region, &evidence)).collect())
            })
            .collect()
    }

    fn read(&mut self, placement: &Placement) -> Result<Evidence> {
        let (cell, rays) = self.loaded()?;
        let mut occupied = BitGrid::new(cell.blockers.window());
        let mut free = BitGrid::new(cell.blockers.window());
        let mut ends = Vec::with_capacity(rays.dirs_q15.len());
        let mut path = Vec::new();
        let mark = |plane: &mut BitGrid, bit: usize| plane.words_mut()[bit >> 5] |= 1 << (bit & 31);
        for &dir_q15 in &rays.dirs_q15 {
            let end = walk(cell, rays, placement, dir_q15, &mut path);
            let freed = match end.kind {
                RETURN => &path[..path.len() - 1],
                LEFT => &path[..],
                NOTHING if rays.gates.no_return_is_free => &path[..],
                _ => &[],
            };
            freed.iter().for_each(|&bit| mark(&mut free, bit));
            if end.kind == RETURN {
                mark(&mut occupied, path[path.len() - 1]);
            }
            ends.push(end);
        }
        Ok(Evidence { occupied: occupied.over(cell.window), free: free.over(cell.window), ends })
    }
}

impl Oracle {
    fn loaded(&self) -> Result<&(Cell, Rays)> {
        self.loaded.as_ref().ok_or_else(|| Error::Device("no scene is loaded".into()))
    }
}

/// Fills `path` with the bit index of the cells that a ray is in, inside the grid and within range, up to its first
/// blocker, and says how the ray ended.
fn walk(cell: &Cell, rays: &Rays, placement: &Placement, dir_q15: [i32; 3], path: &mut Vec<usize>) -> End {
    let mut position = [0i32; 3];
    let mut step = [0i32; 3];
    let mut first = [NEVER as u64; 3];
    let mut period = [NEVER as u64; 3];
    for r in 0..3 {
        let sum: i64 = (0..3).map(|a| placement.axis_q15[r][a] as i64 * dir_q15[a] as i64).sum();
        let dir = (sum + (1 << 13)) >> 14;
        let frac = (placement.origin_q16[r] & 0xffff) as u64;
        position[r] = placement.origin_q16[r] >> 16;
        step[r] = dir.signum() as i32;
        if dir != 0 {
            let ahead = if dir < 0 { frac } else { (1 << 16) - frac };
            period[r] = ((1u64 << 32) / dir.unsigned_abs()).min(NEVER as u64);
            first[r] = (ahead * period[r]) >> 16;
        }
    }
    path.clear();
    path.extend(cell.blockers.bit_index(position));
    let mut made = [0u64; 3];
    let mut next = first;
    let end = |kind, path: &[usize]| End { kind, crossings: path.len() as u32 - 1 };
    loop {
        // The smallest (distance, axis): a later axis must be strictly nearer.
        let mut r = 0;
        for other in 1..3 {
            if next[other] < next[r] {
                r = other;
            }
        }
        let t = next[r];
        if t > rays.gates.range_max_q16 as u64 {
            return end(NOTHING, path);
        }
        made[r] += 1;
        next[r] = first[r] + made[r] * period[r];
        position[r] += step[r];
        let Some(bit) = cell.blockers.bit_index(position) else {
            return end(if rays.gates.backdrop { LEFT } else { NOTHING }, path);
        };
        path.push(bit);
        let blocked = cell.blockers.words()[bit >> 5] >> (bit & 31) & 1 == 1;
        if blocked && t >= rays.gates.near_ignore_q16 as u64 {
            let kind = if t < rays.gates.range_min_q16 as u64 { BLIND } else { RETURN };
            return end(kind, path);
        }
    }
}

/// Counts a region voxel by voxel.
fn count(cell: &Cell, region: &BitGrid, evidence: &Evidence) -> Confusion {
    let mut counts = [0u64; COUNTERS];
    for voxel in region.cells() {
        let label = if evidence.occupied.get(voxel) {
            0
        } else if evidence.free.get(voxel) {
            1
        } else {
            2
        };
        let truth = cell.truth.get(voxel);
        counts[2 * label + !truth as usize] += 1;
        if truth && cell.human.get(voxel) {
            counts[6 + label] += 1;
        }
        if truth && cell.robot.get(voxel) {
            counts[9 + label] += 1;
        }
    }
    Confusion::from_counts(counts)
}

#[cfg(test)]
mod tests;
