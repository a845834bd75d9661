//! The people of a scene, laid out for counting what is hit: their voxels word by word, one list for all
//! regions. Words are looked up by `count` and, on a device, by `shaders/detect.wgsl`.
//!
//! # Theory
//! Hits are joined over the readings of a job, whatever the rule of fusion, so a word of voxels of one part
//! in one region needs only the hits in it. The thresholds are applied to the sums, on the host, for all
//! backends (`metrics`).

use bytemuck::{Pod, Zeroable};

use super::VoxelScene;
use crate::metrics::{BodyPart, Detection, PartTally};

/// Voxels of one part of one person in one region that share a word of a plane; the twin of `BodyWord` in
/// `shaders/types.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct BodyWord {
    /// The word of a plane over the scene's window.
    pub word: u32,
    /// The voxels in it.
    pub voxels: u32,
    /// The counter of those that are hit.
    pub hits: u32,
    /// The counter of those that presence sensors feel.
    pub sensed: u32,
    /// The counter of those that at least two readings hit.
    pub twice: u32,
}

/// The people of a scene.
#[derive(Clone, Debug)]
pub(super) struct BodyWords {
    min_hits: u32,
    /// Persons and parts that have voxels, in order.
    parts: Vec<(u32, BodyPart)>,
    people: usize,
    /// For each region the voxels of each part.
    voxels: Vec<Vec<u64>>,
    /// All regions, one after the other.
    pub(super) body: Vec<BodyWord>,
}

impl BodyWords {
    /// Lays out the people of a scene.
    pub(super) fn new(scene: &VoxelScene) -> BodyWords {
        let mut parts: Vec<_> = scene.people.voxels.iter().map(|of| (of.person, of.part)).collect();
        parts.sort_unstable();
        parts.dedup();
        let (min_hits, people) = (scene.people.min_hits, scene.people.count());
        let mut body_words = BodyWords { min_hits, parts, people, voxels: Vec::new(), body: Vec::new() };
        // (part, word, voxel) of each voxel of the window.
        let mut bits: Vec<([i32; 3], [usize; 2], u32)> = Vec::new();
        for of in &scene.people.voxels {
            let part =
                body_words.parts.binary_search(&(of.person, of.part)).expect("all parts were collected");
            bits.extend(
                scene.truth.bit_index(of.voxel).map(|bit| (of.voxel, [part, bit >> 5], 1 << (bit & 31))),
            );
        }
        bits.sort_unstable_by_key(|&(_, place, _)| place);
        for (number, region) in scene.regions.iter().enumerate() {
            let first = number * body_words.counters_of_region();
            let mut voxels = vec![0; body_words.parts.len()];
            for same in bits.chunk_by(|(_, a, _), (_, b, _)| a == b) {
                let [part, word] = same[0].1;
                let inside = same.iter().filter(|(voxel, ..)| region.get(*voxel));
                let inside = inside.fold(0, |all, (.., bit)| all | bit);
                if inside != 0 {
                    voxels[part] += u64::from(inside.count_ones());
                    let person = body_words.parts[part].0 as usize;
                    let (hits, sensed) = (first + part, first + body_words.parts.len() + person);
                    let twice = first + body_words.counters_of_region() - 1;
                    let [word, hits, sensed, twice] = [word, hits, sensed, twice].map(|n| n as u32);
                    body_words.body.push(BodyWord { word, voxels: inside, hits, sensed, twice });
                }
            }
            body_words.voxels.push(voxels);
        }
        body_words
    }

    /// Counters of a region: of each part, then of each person, then of what is hit twice.
    fn counters_of_region(&self) -> usize {
        self.parts.len() + self.people + 1
    }

    /// Counters of a job.
    pub(super) fn counters(&self) -> usize {
        self.voxels.len() * self.counters_of_region()
    }

    /// Who is detected in each region, and how many of people's voxels are hit twice, from the counters of a job.
    pub(super) fn detections<'a>(
        &'a self,
        counters: &'a [u32],
    ) -> impl Iterator<Item = (Detection, u64)> + 'a {
        let regions = self.voxels.iter().zip(counters.chunks_exact(self.counters_of_region()));
        regions.map(|(voxels, counters)| {
            let (hits, others) = counters.split_at(self.parts.len());
            let (sensed, twice) = others.split_at(self.people);
            let parts = self.parts.iter().zip(voxels).zip(hits).filter(|((_, voxels), _)| **voxels > 0);
            let parts = parts.map(|((&(person, part), &voxels), &hit)| PartTally {
                person: person as usize,
                part,
                voxels,
                hit: hit.into(),
            });
            let sensed: Vec<u64> = sensed.iter().map(|&voxels| voxels.into()).collect();
            (Detection::from_parts(self.min_hits.into(), parts, &sensed), twice[0].into())
        })
    }
}
