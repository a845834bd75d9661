//! The plain oracle: one ray after the other, one step after the other, in u64 arithmetic written straight
//! from the rules, sharing nothing with `march` or the other backends. It defines the counts.

use std::collections::VecDeque;

use super::{Backend, Evidence, Fusion, GridPose, LOG_ODDS, Planes, Rays, Reading, Shot, Slot, VoxelScene};
use crate::march::{BLIND, End, Gates, LEFT, NEVER, NOTHING, RETURN};
use crate::metrics::{COUNTERS, Confusion, Detection, Overlap};
use crate::voxel::grid::MAX_VOXELS_PER_AXIS;
use crate::voxel::{BitGrid, Window};
use crate::{Error, Result};

/// Evidence kept at once; as many as any test or comparison asks of it.
const SLOTS: usize = 256;

/// The oracle and what it works on.
#[derive(Default)]
pub struct Oracle {
    tables: Vec<Rays>,
    scene: Option<VoxelScene>,
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

    fn load(&mut self, scene: &VoxelScene) -> Result<()> {
        self.scene = Some(scene.clone());
        self.slots = vec![None; SLOTS];
        Ok(())
    }

    fn slots(&self) -> usize {
        SLOTS
    }

    fn first_hit_slots(&self) -> usize {
        0
    }

    fn sense(&mut self, table: usize, shots: &[Shot]) -> Result<()> {
        for shot in shots {
            self.slots[shot.slot as usize] = Some(self.read(table, &shot.placement)?.planes);
        }
        Ok(())
    }

    fn upload(&mut self, evidence: Vec<(Slot, Planes)>) -> Result<()> {
        let window = self.scene()?.window;
        for (slot, planes) in evidence {
            self.slots[slot as usize] = Some(fit_planes(window, &planes));
        }
        Ok(())
    }

    fn submit(&mut self, fusion: Fusion, jobs: &[Vec<Reading>]) -> Result<()> {
        let scene = self.scene()?;
        let score = |job: &Vec<Reading>| {
            let in_region = |region| {
                let counts = self.count(scene, region, fusion, job);
                let detection = self.detect(scene, region, job);
                counts.with_detection(detection).with_overlap(self.overlap(scene, region, job))
            };
            scene.regions.iter().map(in_region).collect()
        };
        let answer = jobs.iter().map(score).collect();
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
        let scene = self.scene()?;
        let rays = self.tables.get(table).ok_or_else(|| super::no_table(table))?;
        let mut planes = Planes::blank(scene.blockers.window());
        let mut ends = Vec::with_capacity(rays.dirs_q15.len());
        let mut path = Box::new(Path { voxels: [0; LONGEST_PATH], entered: [0; LONGEST_PATH] });
        let mark = |plane: &mut [u32], bit: u32| plane[bit as usize >> 5] |= 1 << (bit & 31);
        for ray in 0..rays.dirs_q15.len() {
            let Pathend { mut end, blocker, t_q16 } =
                follow(scene, rays, &placement.caster(), ray, &mut path);
            if placement.truly.is_some() {
                end.crossings = trace_path(scene, rays, placement, ray, t_q16, &mut path);
            }
            let endpoint = end.crossings as usize;
            let freed = match end.kind {
                RETURN => endpoint,
                LEFT => endpoint + 1,
                NOTHING if rays.gates.no_return_is_free => endpoint + 1,
                _ => 0,
            };
            path.voxels[..freed].iter().for_each(|&bit| mark(planes.free.words_mut(), bit));
            if end.kind == RETURN {
                mark(planes.occupied.words_mut(), path.voxels[endpoint]);
                mark(planes.hits.words_mut(), blocker);
            }
            ends.push(end);
        }
        Ok(Evidence { planes: fit_planes(scene.window, &planes), ends })
    }
}

impl Oracle {
    fn scene(&self) -> Result<&VoxelScene> {
        self.scene.as_ref().ok_or_else(|| Error::device("no scene is loaded"))
    }

    /// Counts a region voxel by voxel.
    fn count(&self, scene: &VoxelScene, region: &BitGrid, fusion: Fusion, job: &[Reading]) -> Confusion {
        let mut counts = [0u64; COUNTERS];
        for voxel in region.voxels() {
            let label = self.label(voxel, fusion, job);
            let truth = scene.truth.get(voxel);
            counts[2 * label + !truth as usize] += 1;
            if truth && scene.human.get(voxel) {
                counts[6 + label] += 1;
            }
            if truth && scene.robot.get(voxel) {
                counts[9 + label] += 1;
            }
        }
        Confusion::from_counts(counts)
    }

    /// Looks at each voxel of a person whether some reading hits it.
    fn detect(&self, scene: &VoxelScene, region: &BitGrid, job: &[Reading]) -> Detection {
        scene.people.detection(
            region,
            |voxel| job.iter().any(|reading| self.hits(reading, voxel)),
            |voxel| job.iter().any(|reading| reading.presence && self.hits(reading, voxel)),
        )
    }

    /// Counts, voxel by voxel, what at least two readings label, and of people's voxels those that at least two hit.
    fn overlap(&self, scene: &VoxelScene, region: &BitGrid, job: &[Reading]) -> Overlap {
        let labels = |reading: &&Reading, voxel| {
            let said = [Some(reading.slot), reading.volume].into_iter().flatten();
            let mut said = said.filter_map(|slot| self.slots[slot as usize].as_ref());
            said.any(|planes| planes.occupied.get(voxel) || planes.free.get(voxel))
        };
        let is_twice = |voxel: &[i32; 3]| job.iter().filter(|reading| labels(reading, *voxel)).count() >= 2;
        let people = scene.people.voxels.iter().map(|of| of.voxel).filter(|voxel| region.get(*voxel));
        let is_hit_twice =
            |voxel: &[i32; 3]| job.iter().filter(|reading| self.hits(reading, *voxel)).count() >= 2;
        Overlap {
            twice: region.voxels().filter(is_twice).count() as u64,
            hit_human_twice: people.filter(is_hit_twice).count() as u64,
        }
    }

    /// Whether a reading hits a voxel.
    fn hits(&self, reading: &Reading, voxel: [i32; 3]) -> bool {
        let slots = [Some(reading.slot), reading.volume].into_iter().flatten();
        let mut said = slots.filter_map(|slot| self.slots[slot as usize].as_ref());
        said.any(|planes| planes.hits.get(voxel))
    }

    /// 0, 1 or 2: occupied, free, unknown.
    fn label(&self, voxel: [i32; 3], fusion: Fusion, job: &[Reading]) -> usize {
        // All evidence covers the scene's window, as the truth does.
        let bit = self.scene.as_ref().and_then(|scene| scene.truth.bit_index(voxel));
        let Some(bit) = bit else { return 2 };
        let in_slot = |slot: Slot, plane: fn(&Planes) -> &BitGrid| {
            self.slots[slot as usize].as_ref().is_some_and(|planes| is_set(plane(planes).words(), bit))
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

/// Planes over a window, whatever they covered.
fn fit_planes(window: Window, planes: &Planes) -> Planes {
    let Planes { occupied, free, hits } = planes;
    Planes {
        occupied: occupied.to_window(window),
        free: free.to_window(window),
        hits: hits.to_window(window),
    }
}

/// Most voxels that a ray can be in: it moves one way on each axis.
const LONGEST_PATH: usize = 3 * MAX_VOXELS_PER_AXIS as usize;

/// The voxels that a ray is in, as bit indices, and the crossing by which it entered each.
struct Path {
    voxels: [u32; LONGEST_PATH],
    entered: [u64; LONGEST_PATH],
}

/// A ray on its way. Crossings come in the order of (distance, axis), so that both are one number: 4 ·
/// distance + axis.
#[derive(Clone, Copy)]
struct Ray {
    /// The bit of the voxel that it is in.
    bit: i64,
    /// The next crossing of each axis.
    next: [u64; 3],
    /// From one crossing to the next.
    period: [u64; 3],
    /// What a crossing adds to the bit.
    stride: [i64; 3],
    /// The crossing that leaves the grid.
    exit: u64,
}

impl Ray {
    fn start(blockers: &BitGrid, placement: &GridPose, dir_q15: [i32; 3]) -> Ray {
        let size = blockers.window().size.map(i64::from);
        let row = i64::from(blockers.words_per_row()) * 32;
        let strides = [1, row, row * size[1]];
        let mut ray = Ray { bit: 0, next: [0; 3], period: [0; 3], stride: [0; 3], exit: u64::MAX };
        for r in 0..3 {
            let sum: i64 = (0..3).map(|a| i64::from(placement.axis_q15[r][a]) * i64::from(dir_q15[a])).sum();
            let dir = (sum + (1 << 13)) >> 14;
            let voxel = i64::from(placement.origin_q16[r] >> 16);
            let frac = (placement.origin_q16[r] & 0xffff) as u64;
            let (ahead, room) = if dir < 0 { (frac, voxel) } else { ((1 << 16) - frac, size[r] - 1 - voxel) };
            let never = u64::from(NEVER);
            let period =
                (1u64 << 32).checked_div(dir.unsigned_abs()).map_or(never, |period| period.min(never));
            let first = if dir == 0 { never } else { (ahead * period) >> 16 };
            ray.bit += voxel * strides[r];
            ray.next[r] = 4 * first + r as u64;
            ray.period[r] = 4 * period;
            ray.stride[r] = dir.signum() * strides[r];
            ray.exit = ray.exit.min(ray.next[r] + room as u64 * ray.period[r]);
        }
        ray
    }

    /// Makes the next crossing and returns it, unless that is `limit` or later.
    #[inline(always)]
    fn cross(&mut self, limit: u64) -> Option<u64> {
        let [x, y, z] = self.next;
        let nearest = x.min(y).min(z);
        if nearest >= limit {
            return None;
        }
        // A processor cannot predict which axis is crossed, so nothing branches on it.
        for r in 0..3 {
            let crossed = self.next[r] == nearest;
            self.next[r] += if crossed { self.period[r] } else { 0 };
            self.bit += if crossed { self.stride[r] } else { 0 };
        }
        Some(nearest)
    }
}

/// The first crossing that would be later than a distance.
fn next_crossing(q16: u64) -> u64 {
    4 * (q16 + 1)
}

fn is_set(words: &[u32], bit: usize) -> bool {
    words[bit >> 5] >> (bit & 31) & 1 == 1
}

/// What became of a ray.
struct Pathend {
    end: End,
    /// The bit of the blocker that a return comes from.
    blocker: u32,
    /// How far along the ray its evidence reaches: where a return is read, where the blocker of a blind ray
    /// is, else the range.
    t_q16: u64,
}

/// Fills `path` with the voxels that a ray is in, inside the grid and within range, up to its first blocker,
/// or to where a noisy return is read.
fn follow(scene: &VoxelScene, rays: &Rays, placement: &GridPose, number: usize, path: &mut Path) -> Pathend {
    let words = scene.blockers.words();
    let gates = &rays.gates;
    let slant = slant(rays, number);
    let [least_q16, range_q16] =
        [gates.range_min_q16, gates.range_max_q16].map(|q16| ray_range_q16(q16, slant));
    let mut ray = Ray::start(&scene.blockers, placement, rays.dirs_q15[number]);
    let out_of_range = next_crossing(range_q16);
    let limit = ray.exit.min(out_of_range);
    let mut crossings = 0;
    let ended = |kind, crossings: usize, blocker: u32, t_q16: u64| {
        let end = End { kind, crossings: crossings as u32 };
        Pathend { end, blocker, t_q16 }
    };
    path.voxels[0] = ray.bit as u32;
    path.entered[0] = 0;
    while let Some(crossing) = ray.cross(limit) {
        crossings += 1;
        path.voxels[crossings] = ray.bit as u32;
        path.entered[crossings] = crossing;
        let t = crossing >> 2;
        if is_set(words, ray.bit as usize) && t >= u64::from(gates.near_ignore_q16) {
            if t < least_q16 {
                return ended(BLIND, crossings, 0, t);
            }
            let drawn = hash(placement.draws as u64 ^ number as u64);
            let too_weak = is_too_weak(scene, gates, slant, ray.bit as usize, t);
            if too_weak || hash(drawn) < rays.noise.lost_below.into() {
                return ended(NOTHING, unhindered_crossings(ray, limit, path, crossings), 0, range_q16);
            }
            let noise_q16 = noise_q16(rays, slant, drawn, t);
            let read_q16 = (t as i64 + noise_q16).max(0) as u64;
            let read = match noise_q16 {
                0 => crossings,
                _ => endpoint(ray, read_q16, path, crossings),
            };
            return ended(RETURN, read, ray.bit as u32, read_q16);
        }
    }
    let lost = || hash(hash(placement.draws as u64 ^ number as u64)) < rays.noise.lost_below.into();
    let left = gates.backdrop && ray.exit < out_of_range && !lost();
    ended(if left { LEFT } else { NOTHING }, crossings, 0, range_q16)
}

/// Whether a blocker is too dark for its return to come back from a distance.
fn is_too_weak(scene: &VoxelScene, gates: &Gates, slant: u64, bit: usize, t: u64) -> bool {
    let Some(shades) = scene.shades.as_deref() else { return false };
    let [one, two, four] = shades.bits.each_ref().map(|plane| usize::from(is_set(plane.words(), bit)));
    match one + 2 * two + 4 * four {
        0 => false,
        shade => t > ray_range_q16(gates.shade_ranges_q16[shade - 1], slant),
    }
}

/// Fills `path` with the voxels that a ray is believed to be in up to a distance, were nothing in its way:
/// how many crossings those are.
fn trace_path(
    scene: &VoxelScene,
    rays: &Rays,
    from: &GridPose,
    number: usize,
    t_q16: u64,
    path: &mut Path,
) -> u32 {
    let ray = Ray::start(&scene.blockers, from, rays.dirs_q15[number]);
    path.voxels[0] = ray.bit as u32;
    unhindered_crossings(ray, ray.exit.min(next_crossing(t_q16)), path, 0) as u32
}

/// How many crossings a ray makes up to a limit, if it was stopped after so many of them and nothing stops it
/// now.
fn unhindered_crossings(mut ray: Ray, limit: u64, path: &mut Path, mut crossings: usize) -> usize {
    while ray.cross(limit).is_some() {
        crossings += 1;
        path.voxels[crossings] = ray.bit as u32;
    }
    crossings
}

/// How many crossings a ray has made where it is read, if it was stopped after so many of them.
fn endpoint(ray: Ray, read_q16: u64, path: &mut Path, mut crossings: usize) -> usize {
    let limit = next_crossing(read_q16);
    // Voxels entered later than that were not passed.
    while path.entered[crossings] >= limit {
        crossings -= 1;
    }
    // At that distance or farther, blockers stop nothing.
    unhindered_crossings(ray, ray.exit.min(limit), path, crossings)
}

/// How far a ray goes for a voxel of what it measures, which is depth or distance.
fn slant(rays: &Rays, number: usize) -> u64 {
    let axial_q15 = if rays.gates.along_axis { rays.dirs_q15[number][2].max(1 << 11) } else { 1 << 15 };
    (1 << 31) / axial_q15 as u64
}

/// How far along a ray of a slant a depth is.
fn ray_range_q16(depth_q16: u32, slant: u64) -> u64 {
    ((u64::from(depth_q16) * slant) >> 16).min(2047 << 16)
}

/// What a return at a distance is off by.
fn noise_q16(rays: &Rays, slant: u64, drawn: u64, t: u64) -> i64 {
    match rays.noise.unit_q12.get((drawn >> 20) as usize) {
        None => 0,
        Some(&unit) => {
            let std_q16 = ray_range_q16(rays.noise.std_q16[(t / slant) as usize], slant).min(64 << 16);
            (i64::from(unit) * std_q16 as i64 + 2048) >> 12
        }
    }
}

/// The hash of 32 bits, in 64.
fn hash(word: u64) -> u64 {
    const WORD: u64 = u32::MAX as u64;
    let state = (word * 747_796_405 + 2_891_336_453) & WORD;
    let mixed = (((state >> ((state >> 28) + 4)) ^ state) * 277_803_737) & WORD;
    (mixed >> 22) ^ mixed
}

#[cfg(test)]
mod tests;
