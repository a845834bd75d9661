//! How many labels are right, and how many voxels of people are hit: readings fused and counted in one pass,
//! a layer at a time and only where a region has voxels. `fuse` makes the labels.
//!
//! # Theory
//! A region's voxels, and how many of them are truly occupied, a person's or the robot's, do not depend on
//! labels. Two counts of labels, occupied and free, among each of the four give all twelve counters.
//!
//! # Practice
//! Voxels are counted under the words of a region's rows. Those that are truly occupied are few: their words
//! are listed with the voxels in them, and so are the person's and the robot's.

use fearless_simd::{Level, Simd, dispatch};

use super::body_words::BodyWords;
use super::fuse::{FuseJob, RowSpan};
use super::{Fusion, Planes, Reading, Slot, VoxelScene};
use crate::metrics::{Confusion, Overlap};
use crate::voxel::{BitGrid, Window};

/// The regions of a scene, laid out for counting.
#[derive(Clone, Debug)]
pub(super) struct RegionTally {
    window: Window,
    layers: Vec<RegionRows>,
    /// For each region, its voxels and how many of them are occupied, a person's, the robot's.
    totals: Vec<[u64; 4]>,
    body_words: BodyWords,
}

/// The rows of a layer in which some region has voxels.
#[derive(Clone, Debug)]
struct RegionRows {
    rows: RowSpan,
    parts: Vec<RegionLayer>,
}

/// What a region has in a layer.
#[derive(Clone, Debug)]
struct RegionLayer {
    region: usize,
    /// Its first word, counted from that of the layer's rows.
    first: usize,
    words: Vec<u32>,
    /// Of the voxels that are truly occupied, a person's occupied ones, the robot's: words, counted alike,
    /// and the voxels in them.
    listed: [Vec<(u32, u32)>; 3],
}

impl RegionTally {
    /// Lays out the regions of a scene.
    pub(super) fn new(scene: &VoxelScene) -> RegionTally {
        let (window, mut human, mut robot) = (scene.window, scene.human.clone(), scene.robot.clone());
        human.keep(&scene.truth);
        robot.keep(&scene.truth);
        let planes = [&scene.truth, &human, &robot];
        let mut totals = vec![[0; 4]; scene.regions.len()];
        let layers = (window.min[2]..window.end()[2]).filter_map(|z| {
            let spans =
                scene.regions.iter().enumerate().filter_map(|(i, region)| Some((i, rows(region, z)?)));
            let spans: Vec<_> = spans.collect();
            let first = spans.iter().map(|(_, rows)| rows.ys.start).min()?;
            let end = spans.iter().map(|(_, rows)| rows.ys.end).max()?;
            let part = |(region, rows): (usize, RowSpan)| {
                let part = RegionLayer::new(region, &scene.regions[region], planes, &rows, first);
                let listed = part.listed.iter().map(|listed| ones(listed.iter().map(|&(_, voxels)| voxels)));
                let counts = std::iter::once(ones(part.words.iter().copied())).chain(listed);
                totals[region].iter_mut().zip(counts).for_each(|(total, count)| *total += count);
                part
            };
            let parts = spans.into_iter().map(part).collect();
            Some(RegionRows { rows: RowSpan { z, ys: first..end }, parts })
        });
        let layers = layers.collect();
        RegionTally { window, layers, totals, body_words: BodyWords::new(scene) }
    }

    /// Fuses the readings of a job, and counts the labels and the hits in each region. Hits cover the window,
    /// or are empty.
    pub(super) fn score<'a>(
        &self,
        level: Level,
        fusion: Fusion,
        readings: &[Reading],
        planes: impl Fn(Slot) -> Option<&'a Planes>,
    ) -> Vec<Confusion> {
        let mut labelled = vec![[[0; 2]; 4]; self.totals.len()];
        let mut twice = vec![0; self.totals.len()];
        let detections = self.detect(readings, &planes);
        let mut job = FuseJob::new(self.window, fusion, readings, planes);
        for layer in &self.layers {
            job.fuse(&layer.rows);
            for part in &layer.parts {
                let labelled = &mut labelled[part.region];
                dispatch!(level, simd => part.count(simd, &job.occupied, &job.free, labelled));
                if !job.twice.is_empty() {
                    twice[part.region] += dispatch!(level, simd => part.count_all(simd, &job.twice));
                }
            }
        }
        let counted = self.totals.iter().zip(&labelled).map(|(totals, labelled)| confusion(totals, labelled));
        let found = self.body_words.detections(&detections);
        let with_people = |((counts, twice), (detection, hit_human_twice)): ((Confusion, u64), _)| {
            counts.with_detection(detection).with_overlap(Overlap { twice, hit_human_twice })
        };
        counted.zip(twice).zip(found).map(with_people).collect()
    }

    /// Counts the hits of a job: the counters of [`BodyWords`].
    fn detect<'a>(&self, readings: &[Reading], planes: impl Fn(Slot) -> Option<&'a Planes>) -> Vec<u32> {
        let mut counters = vec![0; self.body_words.counters()];
        let hits = |reading: &Reading| {
            let slots = [Some(reading.slot), reading.volume].into_iter().flatten();
            let words = slots.filter_map(&planes).map(|said| said.hits.words());
            (words.filter(|words| !words.is_empty()).collect(), reading.presence)
        };
        let hits: Vec<(Vec<&[u32]>, bool)> = readings.iter().map(hits).collect();
        for body in &self.body_words.body {
            let (mut hit, mut twice, mut sensed) = (0, 0, 0);
            for (planes, presence) in &hits {
                let word = planes.iter().fold(0, |word, plane| word | plane[body.word as usize]);
                twice |= hit & word;
                hit |= word;
                sensed |= if *presence { word } else { 0 };
            }
            counters[body.hits as usize] += (hit & body.voxels).count_ones();
            counters[body.sensed as usize] += (sensed & body.voxels).count_ones();
            counters[body.twice as usize] += (twice & body.voxels).count_ones();
        }
        counters
    }
}

impl RegionLayer {
    fn new(
        region: usize,
        voxels: &BitGrid,
        planes: [&BitGrid; 3],
        rows: &RowSpan,
        first_y: i32,
    ) -> RegionLayer {
        let words_of = |plane: &BitGrid| -> Vec<u32> {
            rows.ys.clone().flat_map(|y| plane.row(y, rows.z).iter().copied()).collect()
        };
        let words = words_of(voxels);
        let listed = planes.map(|plane| {
            let voxels = (0..).zip(words_of(plane).into_iter().zip(&words).map(|(plane, word)| plane & word));
            voxels.filter(|&(_, voxels)| voxels != 0).collect()
        });
        let first = (rows.ys.start - first_y) as usize * voxels.words_per_row() as usize;
        RegionLayer { region, first, words, listed }
    }

    /// Adds up the labels of its voxels: occupied and free, among all and among those listed.
    #[inline(always)]
    fn count<S: Simd>(&self, simd: S, occupied: &[u32], free: &[u32], labelled: &mut [[u64; 2]; 4]) {
        for (label, plane) in [occupied, free].into_iter().enumerate() {
            labelled[0][label] += self.count_all(simd, plane);
            let plane = &plane[self.first..self.first + self.words.len()];
            for (listed, labelled) in self.listed.iter().zip(&mut labelled[1..]) {
                labelled[label] += ones(listed.iter().map(|&(word, voxels)| plane[word as usize] & voxels));
            }
        }
    }

    /// How many of its voxels a plane of the layer's rows holds.
    #[inline(always)]
    fn count_all<S: Simd>(&self, _: S, plane: &[u32]) -> u64 {
        let plane = &plane[self.first..self.first + self.words.len()];
        ones(plane.iter().zip(&self.words).map(|(plane, word)| plane & word))
    }
}

/// The rows of a layer from the first to the last in which a plane has voxels.
fn rows(plane: &BitGrid, z: i32) -> Option<RowSpan> {
    let ys = plane.window().min[1]..plane.window().end()[1];
    let filled = |y: &i32| plane.row(*y, z).iter().any(|&word| word != 0);
    let (first, last) = (ys.clone().find(filled)?, ys.rev().find(filled)?);
    Some(RowSpan { z, ys: first..last + 1 })
}

/// How many bits are set in the words of a layer: at most 1023², so that 32 bits hold the sum.
#[inline(always)]
fn ones(words: impl Iterator<Item = u32>) -> u64 {
    // Sums that are checked, as in tests, do not become vectors.
    words.fold(0u32, |sum, word| sum.wrapping_add(word.count_ones())).into()
}

/// The counters of a region.
fn confusion([all, truth, human, robot]: &[u64; 4], labelled: &[[u64; 2]; 4]) -> Confusion {
    let [[o, f], [tp, fn_], [human_tp, human_fn], [robot_tp, robot_fn]] = *labelled;
    let unknown = all - o - f;
    let uo = truth - tp - fn_;
    let of_role = |all: &u64, tp: u64, fn_: u64| [tp, fn_, all - tp - fn_];
    let [h, r] = [of_role(human, human_tp, human_fn), of_role(robot, robot_tp, robot_fn)];
    Confusion::from_counts([tp, o - tp, fn_, f - fn_, uo, unknown - uo, h[0], h[1], h[2], r[0], r[1], r[2]])
}
