//! Several sensors' evidence becomes one label a voxel, some rows of words at a time: the twin of
//! `shaders/fuse.wgsl`.
//!
//! # Theory
//! Sums are clamped after each reading, and clamp(sum + reading) is monotone in both. So where no reading
//! lowers a voxel's sum, the sum is above zero as soon as one raises it, and the other way round: only voxels
//! with readings of both signs need their sum. From any sum, the readings still to come cannot lead below the
//! sum of the lowest that each may add (on the way down the upper clamp is never met), nor above that of the
//! highest.
//!
//! # Practice
//! Most words are settled by three bit operations a reading; in the rest, all voxels of a word with the same
//! readings are summed together.

use std::ops::Range;

use super::{Fusion, LOG_ODDS, Planes, Reading, Slot};
use crate::voxel::Window;

/// Rows of one layer of a window, what is fused and counted at a time: few enough to stay in the nearest
/// cache.
#[derive(Clone, Debug)]
pub(super) struct RowSpan {
    /// The layer.
    pub(super) z: i32,
    /// The rows.
    pub(super) ys: Range<i32>,
}

/// The readings of a job, fused row by row.
pub(super) struct FuseJob<'a> {
    fusion: Fusion,
    window: Window,
    voices: Vec<Voice<'a>>,
    /// Of each voice what it adds to the sum of a voxel.
    sayings: Vec<Saying>,
    /// Voxels whose sum some reading raises; after the fusion those that are occupied.
    pub(super) occupied: Vec<u32>,
    /// Voxels whose sum some reading lowers; after the fusion those that are free, none of them occupied.
    pub(super) free: Vec<u32>,
    /// Voxels that some reading labels; kept only where there are several readings.
    once: Vec<u32>,
    /// Those that at least two label; empty of a single reading.
    pub(super) twice: Vec<u32>,
}

/// A reading, and what it says of some rows; `occupied` and `free` have no voxel in common.
struct Voice<'a> {
    parts: Vec<&'a Planes>,
    occupied: Vec<u32>,
    free: Vec<u32>,
}

/// What a reading adds to the sum of a voxel.
#[derive(Clone, Copy, Debug)]
pub struct Saying {
    /// Where it calls the voxel occupied, and where it calls it free.
    said: [i32; 2],
    /// The lowest and the highest that this and all later readings may add.
    still: [i32; 2],
}

impl Saying {
    /// Those of readings in order, each with what it adds to occupied and to free voxels.
    pub fn from_readings(said: impl DoubleEndedIterator<Item = [i32; 2]>) -> Vec<Saying> {
        let mut still = [0; 2];
        let saying = |said: [i32; 2]| {
            let [least, most] = still;
            still = [least + said[0].min(said[1]).min(0), most + said[0].max(said[1]).max(0)];
            Saying { said, still }
        };
        let mut sayings: Vec<Saying> = said.rev().map(saying).collect();
        sayings.reverse();
        sayings
    }
}

impl<'a> FuseJob<'a> {
    /// Readings of evidence over a window or parts of it; slots that hold nothing say nothing.
    pub(super) fn new(
        window: Window,
        fusion: Fusion,
        readings: &[Reading],
        planes: impl Fn(Slot) -> Option<&'a Planes>,
    ) -> Self {
        let said = |reading: &Reading| match fusion {
            Fusion::OccupiedWins => [1, -1],
            Fusion::Octomap => [reading.hit, reading.miss],
        };
        let voice = |reading: &Reading| {
            let slots = [Some(reading.slot), reading.volume];
            let parts = slots.into_iter().flatten().filter_map(&planes).collect();
            Voice { parts, occupied: Vec::new(), free: Vec::new() }
        };
        let voices = readings.iter().map(voice).collect();
        let sayings = Saying::from_readings(readings.iter().map(said));
        let [occupied, free, once, twice] = [const { Vec::new() }; 4];
        FuseJob { fusion, window, voices, sayings, occupied, free, once, twice }
    }

    /// Labels the voxels of some rows.
    pub(super) fn fuse(&mut self, rows: &RowSpan) {
        let words = rows.ys.len() * self.window.size[0].div_ceil(32) as usize;
        blank(&mut self.occupied, words);
        blank(&mut self.free, words);
        let is_shared = self.voices.len() > 1;
        if is_shared {
            blank(&mut self.once, words);
            blank(&mut self.twice, words);
        }
        for (voice, saying) in self.voices.iter_mut().zip(&self.sayings) {
            voice.hear(self.window, rows, words);
            if is_shared {
                voice.count_labels(&mut self.once, &mut self.twice);
            }
            for (voxels, said) in [&voice.occupied, &voice.free].into_iter().zip(saying.said) {
                match said {
                    1.. => join(&mut self.occupied, voxels),
                    0 => {}
                    ..0 => join(&mut self.free, voxels),
                }
            }
        }
        match self.fusion {
            Fusion::OccupiedWins => take(&mut self.free, &self.occupied),
            // A single reading never both raises and lowers a voxel.
            Fusion::Octomap if self.voices.len() < 2 => {}
            Fusion::Octomap => self.settle(),
        }
    }

    /// Sums up where readings disagree.
    fn settle(&mut self) {
        for word in 0..self.occupied.len() {
            let disputed = self.occupied[word] & self.free[word];
            if disputed != 0 {
                let heard = |i: usize| {
                    let Voice { occupied, free, .. } = &self.voices[i];
                    [occupied[word].into(), free[word].into()]
                };
                let [occupied, free] = settle(&self.sayings, &heard, disputed.into());
                self.occupied[word] = self.occupied[word] & !disputed | occupied as u32;
                self.free[word] = self.free[word] & !disputed | free as u32;
            }
        }
    }
}

impl Voice<'_> {
    /// Joins what its parts say of some rows.
    fn hear(&mut self, window: Window, rows: &RowSpan, words: usize) {
        blank(&mut self.occupied, words);
        blank(&mut self.free, words);
        for planes in &self.parts {
            planes.occupied.add_to_rows(&mut self.occupied, window, rows.ys.clone(), rows.z);
            planes.free.add_to_rows(&mut self.free, window, rows.ys.clone(), rows.z);
        }
        take(&mut self.free, &self.occupied);
    }

    /// Joins what it labels with what one reading and what at least two label.
    fn count_labels(&self, once: &mut [u32], twice: &mut [u32]) {
        let labelled = self.occupied.iter().zip(&self.free).map(|(occupied, free)| occupied | free);
        for ((once, twice), labelled) in once.iter_mut().zip(twice).zip(labelled) {
            *twice |= *once & labelled;
            *once |= labelled;
        }
    }
}

/// Which of some voxels of a word are occupied, and which are free: the sums of readings, of which `heard` tells the
/// voxels that each calls occupied and free.
pub fn settle(sayings: &[Saying], heard: &impl Fn(usize) -> [u64; 2], voxels: u64) -> [u64; 2] {
    let mut labels = [0; 2];
    sum(sayings, heard, (0, 0), voxels, &mut labels);
    labels
}

/// Adds readings in order, from one on, to voxels of a word that have the same sum so far, and labels them occupied
/// or free, or, at a sum of zero, neither.
fn sum(
    sayings: &[Saying],
    heard: &impl Fn(usize) -> [u64; 2],
    (from, mut so_far): (usize, i32),
    mut voxels: u64,
    labels: &mut [u64; 2],
) {
    for (i, saying) in sayings.iter().enumerate().skip(from) {
        if so_far + saying.still[0] > 0 || so_far + saying.still[1] < 0 {
            break;
        }
        for (heard_here, said) in heard(i).into_iter().zip(saying.said) {
            let here = heard_here & voxels;
            let after = (so_far + said).clamp(*LOG_ODDS.start(), *LOG_ODDS.end());
            if here == voxels {
                // The reading applies to all of these voxels; the other plane holds none of them.
                so_far = after;
                break;
            } else if here != 0 {
                sum(sayings, heard, (i + 1, after), here, labels);
                voxels &= !here;
            }
        }
    }
    match so_far {
        1.. => labels[0] |= voxels,
        0 => {}
        ..0 => labels[1] |= voxels,
    }
}

/// The labels of all voxels of a window, and the hits of all readings.
pub(super) fn fuse<'a>(
    window: Window,
    fusion: Fusion,
    readings: &[Reading],
    planes: impl Fn(Slot) -> Option<&'a Planes>,
) -> Planes {
    let mut job = FuseJob::new(window, fusion, readings, &planes);
    let mut labels = Planes::blank(window);
    let slots = readings.iter().flat_map(|reading| [Some(reading.slot), reading.volume]).flatten();
    slots.filter_map(&planes).for_each(|said| labels.hits.add(&said.hits));
    let ([_, y, z], [_, y_end, z_end]) = (window.min, window.end());
    for z in z..z_end {
        job.fuse(&RowSpan { z, ys: y..y_end });
        for (plane, words) in [(&mut labels.occupied, &job.occupied), (&mut labels.free, &job.free)] {
            let row = plane.words_per_row() as usize;
            for (y, words) in (y..).zip(words.chunks_exact(row.max(1))) {
                plane.add_row(y, z, words);
            }
        }
    }
    labels
}

fn blank(plane: &mut Vec<u32>, words: usize) {
    plane.clear();
    plane.resize(words, 0);
}

fn join(to: &mut [u32], from: &[u32]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to |= from);
}

fn take(to: &mut [u32], from: &[u32]) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to &= !from);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxel::BitGrid;

    /// Up to eight readings of dense planes, some of whose sums are clamped and come back, against plain
    /// sums.
    #[test]
    fn sums_of_words_are_sums_of_voxels() {
        let mut state = 1u64;
        let mut random = |below: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % below
        };
        let window = Window::from_corners([0; 3], [69, 3, 2]);
        let rows = RowSpan { z: 1, ys: 1..4 };
        let mut labels = [0; 3];
        for case in 0..300 {
            let mut plane = || {
                let mut plane = BitGrid::new(window);
                let voxels = BitGrid::full(window);
                voxels.voxels().filter(|_| random(2) == 0).for_each(|voxel| plane.set(voxel));
                plane
            };
            let planes: Vec<_> =
                (0..6).map(|_| Planes { occupied: plane(), free: plane(), hits: plane() }).collect();
            let reading = |_| {
                let [hit, miss] = match random(4) {
                    0 => [847, -405],
                    1 => [3511, -405],
                    2 => [2000, -3511],
                    _ => [random(8001) as i32 - 4000, random(8001) as i32 - 4000],
                };
                let volume = (random(2) == 0).then(|| random(6) as Slot);
                Reading { slot: random(8) as Slot, volume, hit, miss, presence: false }
            };
            let readings: Vec<_> = (0..case % 9).map(reading).collect();
            let mut job = FuseJob::new(window, Fusion::Octomap, &readings, |slot| planes.get(slot as usize));
            job.fuse(&rows);
            let plain = |voxel: [i32; 3]| {
                readings.iter().fold(0, |sum: i32, reading| {
                    let slots = [Some(reading.slot), reading.volume].into_iter().flatten();
                    let parts: Vec<_> = slots.filter_map(|slot| planes.get(slot as usize)).collect();
                    let says = |of: fn(&Planes) -> &BitGrid| parts.iter().any(|part| of(part).get(voxel));
                    let said = match (says(|part| &part.occupied), says(|part| &part.free)) {
                        (true, _) => reading.hit,
                        (false, free) => i32::from(free) * reading.miss,
                    };
                    (sum + said).clamp(-2000, 3511)
                })
            };
            for (row, y) in rows.ys.clone().enumerate() {
                for x in 0..70 {
                    let bit = |words: &[u32]| words[3 * row + x / 32] >> (x % 32) & 1 == 1;
                    let found = i32::from(bit(&job.occupied)) - i32::from(bit(&job.free));
                    let voxel = [x as i32, y, rows.z];
                    assert_eq!(found, plain(voxel).signum(), "case {case}, {voxel:?}: {readings:?}");
                    labels[(found + 1) as usize] += 1;
                }
            }
        }
        assert!(labels.iter().all(|&n| n > 1000), "free, neither, occupied: {labels:?}");
    }
}
