//! The people of a cell, laid out for counting what is hit: their voxels word by word, one list for all
//! regions. Words are looked up by `count` and, on a device, by `shaders/detect.wgsl`.
//!
//! # Theory
//! Hits are joined over the readings of a job, whatever the rule of fusion, so a word of voxels of one part
//! in one region needs only the hits in it. The thresholds are applied to the sums, on the host, for all
//! backends (`metrics`).

use bytemuck::{Pod, Zeroable};

use super::Cell;
use crate::metrics::{BodyPart, Detection, PartTally};

/// Voxels of one part of one person in one region that share a word of a plane; the twin of `Flesh` in
/// `shaders/types.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Flesh {
    /// The word of a plane over the cell's window.
    pub word: u32,
    /// The voxels in it.
    pub voxels: u32,
    /// The counter of those that are hit.
    pub hits: u32,
    /// The counter of those that presence sensors feel.
    pub sensed: u32,
}

/// The people of a cell.
#[derive(Clone, Debug)]
pub(super) struct Roll {
    min_hits: u32,
    /// Persons and parts that have voxels, in order.
    parts: Vec<(u32, BodyPart)>,
    people: usize,
    /// For each region the voxels of each part.
    voxels: Vec<Vec<u64>>,
    /// All regions, one after the other.
    pub(super) flesh: Vec<Flesh>,
}

impl Roll {
    /// Lays out the people of a cell.
    pub(super) fn new(cell: &Cell) -> Roll {
        let mut parts: Vec<_> = cell.people.voxels.iter().map(|of| (of.person, of.part)).collect();
        parts.sort_unstable();
        parts.dedup();
        let (min_hits, people) = (cell.people.min_hits, cell.people.count());
        let mut roll = Roll { min_hits, parts, people, voxels: Vec::new(), flesh: Vec::new() };
        // (part, word, voxel) of each voxel of the window.
        let mut bits: Vec<([i32; 3], [usize; 2], u32)> = Vec::new();
        for of in &cell.people.voxels {
            let part = roll.parts.binary_search(&(of.person, of.part)).expect("all parts were collected");
            bits.extend(
                cell.truth.bit_index(of.voxel).map(|bit| (of.voxel, [part, bit >> 5], 1 << (bit & 31))),
            );
        }
        bits.sort_unstable_by_key(|&(_, place, _)| place);
        for (number, region) in cell.regions.iter().enumerate() {
            let first = number * roll.counters_of_region();
            let mut voxels = vec![0; roll.parts.len()];
            for same in bits.chunk_by(|(_, a, _), (_, b, _)| a == b) {
                let [part, word] = same[0].1;
                let inside = same.iter().filter(|(voxel, ..)| region.get(*voxel));
                let inside = inside.fold(0, |all, (.., bit)| all | bit);
                if inside != 0 {
                    voxels[part] += u64::from(inside.count_ones());
                    let person = roll.parts[part].0 as usize;
                    let (hits, sensed) = (first + part, first + roll.parts.len() + person);
                    let (word, hits, sensed) = (word as u32, hits as u32, sensed as u32);
                    roll.flesh.push(Flesh { word, voxels: inside, hits, sensed });
                }
            }
            roll.voxels.push(voxels);
        }
        roll
    }

    /// Counters of a region: of each part, then of each person.
    fn counters_of_region(&self) -> usize {
        self.parts.len() + self.people
    }

    /// Counters of a job.
    pub(super) fn counters(&self) -> usize {
        self.voxels.len() * self.counters_of_region()
    }

    /// Who is detected in each region, from the counters of a job.
    pub(super) fn detections<'a>(&'a self, counters: &'a [u32]) -> impl Iterator<Item = Detection> + 'a {
        let one = self.counters_of_region();
        self.voxels.iter().enumerate().map(move |(region, voxels)| {
            let (hits, sensed) = counters[region * one..(region + 1) * one].split_at(self.parts.len());
            let parts = self.parts.iter().zip(voxels).zip(hits).filter(|((_, voxels), _)| **voxels > 0);
            let parts = parts.map(|((&(person, part), &voxels), &hit)| PartTally {
                person: person as usize,
                part,
                voxels,
                hit: hit.into(),
            });
            let sensed: Vec<u64> = sensed.iter().map(|&voxels| voxels.into()).collect();
            Detection::of(self.min_hits.into(), parts, &sensed)
        })
    }
}
