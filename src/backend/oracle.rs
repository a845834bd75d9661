//! The plain oracle: one ray after the other, one step after the other, in u64 arithmetic written straight from
//! the rules, sharing nothing with `march` or the other backends. It defines the counts; it is lean, but not clever.

use std::collections::VecDeque;

use super::{Backend, Cell, Evidence, Fusion, LOG_ODDS, Placement, Planes, Rays, Reading, Shot, Slot};
use crate::march::{BLIND, End, LEFT, NEVER, NOTHING, RETURN};
use crate::metrics::{COUNTERS, Confusion};
use crate::voxel::BitGrid;
use crate::{Error, Result};

/// Evidence kept at once; as many as any test or comparison asks of it.
const SLOTS: usize = 256;

/// The oracle and what it works on.
#[derive(Default)]
pub struct Oracle {
    tables: Vec<Rays>,
    cell: Option<Cell>,
    slots: Vec<Option<Planes>>,
    answers: VecDeque<Vec<Vec<Confusion>>>,
}

impl Backend for Oracle {
    fn name(&self) -> &'static str {
        "oracle"
    }

    fn device(&self) -> String {
        "one thread, plain march".into()
    }

    fn tables(&mut self, tables: &[Rays]) -> Result<()> {
        self.tables = tables.to_vec();
        Ok(())
    }

    fn load(&mut self, cell: &Cell) -> Result<()> {
        self.cell = Some(cell.clone());
        self.slots = vec![None; SLOTS];
        Ok(())
    }

    fn slots(&self) -> usize {
        SLOTS
    }

    fn hit_slots(&self) -> usize {
        0
    }

    fn sense(&mut self, table: usize, shots: &[Shot]) -> Result<()> {
        for shot in shots {
            self.slots[shot.slot as usize] = Some(self.read(table, &shot.placement)?.planes);
        }
        Ok(())
    }

    fn upload(&mut self, evidence: Vec<(Slot, Planes)>) -> Result<()> {
        evidence.into_iter().for_each(|(slot, planes)| self.slots[slot as usize] = Some(planes));
        Ok(())
    }

    fn ask(&mut self, fusion: Fusion, jobs: &[Vec<Reading>]) -> Result<()> {
        let cell = self.cell()?;
        let score = |job: &Vec<Reading>| {
            cell.regions.iter().map(|region| self.count(cell, region, fusion, job)).collect()
        };
        let answer = jobs.iter().map(score).collect();
        self.answers.push_back(answer);
        Ok(())
    }

    fn answer(&mut self) -> Result<Vec<Vec<Confusion>>> {
        self.answers.pop_front().ok_or_else(super::nothing_asked)
    }

    fn read(&mut self, table: usize, placement: &Placement) -> Result<Evidence> {
        let cell = self.cell()?;
        let rays = self.tables.get(table).ok_or_else(|| super::no_table(table))?;
        let mut occupied = BitGrid::new(cell.blockers.window());
        let mut free = BitGrid::new(cell.blockers.window());
        let mut ends = Vec::with_capacity(rays.dirs_q15.len());
        let mut path = Vec::new();
        let mark = |plane: &mut BitGrid, bit: usize| plane.words_mut()[bit >> 5] |= 1 << (bit & 31);
        for ray in 0..rays.dirs_q15.len() {
            let end = walk(cell, rays, placement, ray, &mut path);
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
        let planes = Planes { occupied: occupied.over(cell.window), free: free.over(cell.window) };
        Ok(Evidence { planes, ends })
    }
}

impl Oracle {
    fn cell(&self) -> Result<&Cell> {
        self.cell.as_ref().ok_or_else(|| Error::Device("no scene is loaded".into()))
    }

    /// Counts a region voxel by voxel.
    fn count(&self, cell: &Cell, region: &BitGrid, fusion: Fusion, job: &[Reading]) -> Confusion {
        let mut counts = [0u64; COUNTERS];
        for voxel in region.cells() {
            let label = self.label(voxel, fusion, job);
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

    /// 0, 1 or 2: occupied, free, unknown.
    fn label(&self, voxel: [i32; 3], fusion: Fusion, job: &[Reading]) -> usize {
        let in_slot = |slot: Slot, plane: fn(&Planes) -> &BitGrid| {
            self.slots[slot as usize].as_ref().is_some_and(|planes| plane(planes).get(voxel))
        };
        let says = |reading: &Reading, plane: fn(&Planes) -> &BitGrid| {
            in_slot(reading.slot, plane) || reading.volume.is_some_and(|slot| in_slot(slot, plane))
        };
        let readings = job.iter().map(|reading| {
            let occupied = says(reading, |planes| &planes.occupied);
            (reading, occupied, !occupied && says(reading, |planes| &planes.free))
        });
        match fusion {
            Fusion::OccupiedWins => {
                let (mut any_occupied, mut any_free) = (false, false);
                readings.for_each(|(_, occupied, free)| {
                    any_occupied |= occupied;
                    any_free |= free;
                });
                if any_occupied { 0 } else { 2 - any_free as usize }
            }
            Fusion::Octomap => {
                let sum = readings.fold(0, |sum: i32, (reading, occupied, free)| {
                    let said = match (occupied, free) {
                        (true, _) => reading.hit,
                        (_, true) => reading.miss,
                        _ => 0,
                    };
                    (sum + said).clamp(*LOG_ODDS.start(), *LOG_ODDS.end())
                });
                match sum {
                    1.. => 0,
                    0 => 2,
                    ..0 => 1,
                }
            }
        }
    }
}

/// Fills `path` with the bit index of the cells that a ray is in, inside the grid and within range, up to its first
/// blocker, or to where a noisy return is read, and says how the ray ended.
fn walk(cell: &Cell, rays: &Rays, placement: &Placement, ray: usize, path: &mut Vec<usize>) -> End {
    let dir_q15 = rays.dirs_q15[ray];
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
    // Where a return is read, once one is found.
    let mut read_at = None;
    let mut distances = vec![];
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
        if let Some(read_at) = read_at {
            if t as i64 > read_at {
                return end(RETURN, path);
            }
        } else if t > rays.gates.range_max_q16 as u64 {
            return end(NOTHING, path);
        }
        made[r] += 1;
        next[r] = first[r] + made[r] * period[r];
        position[r] += step[r];
        let Some(bit) = cell.blockers.bit_index(position) else {
            let kind = if rays.gates.backdrop { LEFT } else { NOTHING };
            return end(if read_at.is_some() { RETURN } else { kind }, path);
        };
        path.push(bit);
        if !rays.noise_q16.is_empty() {
            distances.push(t as i64);
        }
        let blocked = cell.blockers.words()[bit >> 5] >> (bit & 31) & 1 == 1;
        if read_at.is_none() && blocked && t >= rays.gates.near_ignore_q16 as u64 {
            if t < rays.gates.range_min_q16 as u64 {
                return end(BLIND, path);
            }
            let noise = if rays.noise_q16.is_empty() { 0 } else { noise(rays, placement.draws, ray) };
            if noise == 0 {
                return end(RETURN, path);
            }
            let at = (t as i64 + noise).max(0);
            // Cells entered later than that were not seen to be entered.
            path.truncate(1 + distances.iter().filter(|&&entered| entered <= at).count());
            // At the blocker's own distance (a hit at 0 is read at 0 at the nearest) more axes may be crossed.
            if at < t as i64 {
                return end(RETURN, path);
            }
            read_at = Some(at);
        }
    }
}

/// What a ray's return is off by.
fn noise(rays: &Rays, draws: u32, ray: usize) -> i64 {
    const WORD: u64 = u32::MAX as u64;
    let state = ((draws as u64 ^ ray as u64) * 747_796_405 + 2_891_336_453) & WORD;
    let mixed = (((state >> ((state >> 28) + 4)) ^ state) * 277_803_737) & WORD;
    let hash = (mixed >> 22) ^ mixed;
    rays.noise_q16[(hash >> 20) as usize] as i64
}

#[cfg(test)]
mod tests;
