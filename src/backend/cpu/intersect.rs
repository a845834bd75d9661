//! Which of a few blockers each ray of a packet hits first: every ray against every blocker, 64 rays at
//! once. `cone` lists these blockers.
//!
//! # Theory
//! A ray visits a voxel if and only if it enters on every axis before it leaves on any, six crossings in
//! closed form (`SEMANTICS.md`, "Rays"). Of all blockers visited, the one entered first is the one that
//! single steps would find. A section of a cone holds every voxel that its rays are in up to a distance, so
//! an entry up to there is first of all.
//!
//! # Practice
//! Where the processor has wide vectors: no ray waits for another's guess of which axis comes next, and
//! nothing is looked up. A tile's rays end on a dozen voxels or two.

use fearless_simd::{Level, Simd, dispatch};

use super::packet::{Lanes, Packet, RAYS};
use crate::march::leap::RayAxis;

/// The crossings of a packet's rays as numbers, distance · 4 + axis.
pub(super) struct Intersect {
    first: [Lanes<u64>; 3],
    /// Distance alone, in 1/65536 voxels.
    period: [Lanes<u64>; 3],
    step: [Lanes<i64>; 3],
    /// For each ray, the crossing by which it entered the first blocker so far.
    pub(super) entered: Lanes<u64>,
}

impl Intersect {
    pub(super) fn new() -> Self {
        Intersect { first: [[0; RAYS]; 3], period: [[0; RAYS]; 3], step: [[0; RAYS]; 3], entered: [0; RAYS] }
    }

    /// Rays that have hit nothing.
    pub(super) fn start(&mut self, level: Level, packet: &Packet) {
        dispatch!(level, simd => start(simd, self, packet));
    }

    /// The rays of a packet against a blocker, `away` voxels from the voxel where all of them begin. For rays
    /// that enter it before `ignore_q16` it is no blocker.
    pub(super) fn intersect(&mut self, level: Level, away: [i32; 3], ignore_q16: u32) {
        dispatch!(level, simd => intersect(simd, self, away, ignore_q16));
    }
}

#[inline(always)]
fn start<S: Simd>(_: S, intersect: &mut Intersect, packet: &Packet) {
    for r in 0..3 {
        for lane in 0..RAYS {
            intersect.first[r][lane] = 4 * u64::from(packet.first_q16[r][lane]) + r as u64;
            intersect.period[r][lane] = packet.period_q16[r][lane].into();
            intersect.step[r][lane] = packet.dir_q16[r][lane].signum().into();
        }
    }
    intersect.entered = [u64::MAX; RAYS];
}

#[inline(always)]
fn intersect<S: Simd>(_: S, intersect: &mut Intersect, away: [i32; 3], ignore_q16: u32) {
    let mut enters = [0; RAYS];
    let mut leaves = [u64::MAX; RAYS];
    for r in 0..3 {
        if away[r] == 0 {
            // The same tests as `slab`, made for all lanes at once.
            (0..RAYS).for_each(|lane| leaves[lane] = leaves[lane].min(intersect.first[r][lane]));
            continue;
        }
        for lane in 0..RAYS {
            // A product of 32 bits each is quicker than one of 64.
            let (step, period_q16) = (intersect.step[r][lane], intersect.period[r][lane] as u32);
            let axis = RayAxis { step, next: intersect.first[r][lane], period_q16 };
            let [own_enters, own_leaves] = axis.slab(away[r], away[r]);
            enters[lane] = enters[lane].max(own_enters);
            leaves[lane] = leaves[lane].min(own_leaves);
        }
    }
    let ignored = 4 * u64::from(ignore_q16);
    for lane in 0..RAYS {
        let visits = enters[lane] < leaves[lane] && enters[lane] >= ignored;
        let entry = if visits { enters[lane] } else { u64::MAX };
        intersect.entered[lane] = intersect.entered[lane].min(entry);
    }
}
