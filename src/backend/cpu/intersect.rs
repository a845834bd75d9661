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

use super::first_hit::FirstHit;
use super::narrow::{self, NONE, Slab};
use super::packet::{self, Lanes, Packet, RAYS};

/// The crossings of a packet's rays as `narrow` has them.
pub(super) struct Intersect {
    first: [Lanes<u32>; 3],
    /// Distance alone, in 1/65536 voxels.
    period: [Lanes<u32>; 3],
    step: [Lanes<i32>; 3],
    /// For each ray, the crossing by which it entered the first blocker so far.
    entered: Lanes<u32>,
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

    /// What rays hit first, of those that hit something up to `until`, and if `all`, of the others, too: the first
    /// blocker so far if it comes before `limit` and before what is known already. Says which rays are open still, a
    /// bit each. Rays that are not stay as they are when more blockers have been tested.
    pub(super) fn settle(
        &self,
        level: Level,
        [until, limit]: [FirstHit; 2],
        all: bool,
        found: &mut Lanes<FirstHit>,
    ) -> u64 {
        let until = if all { NONE } else { until };
        dispatch!(level, simd => settle(simd, &self.entered, [until, limit], found))
    }
}

#[inline(always)]
fn start<S: Simd>(_: S, intersect: &mut Intersect, packet: &Packet) {
    for r in 0..3 {
        for lane in 0..RAYS {
            intersect.first[r][lane] = narrow::first(packet.first_q16[r][lane], r);
            intersect.period[r][lane] = packet.period_q16[r][lane];
            intersect.step[r][lane] = packet.dir_q16[r][lane].signum();
        }
    }
    intersect.entered = [NONE; RAYS];
}

#[inline(always)]
fn intersect<S: Simd>(_: S, intersect: &mut Intersect, away: [i32; 3], ignore_q16: u32) {
    let mut enters = [0; RAYS];
    let mut leaves = [NONE; RAYS];
    for r in 0..3 {
        let (first, period, step) = (&intersect.first[r], &intersect.period[r], &intersect.step[r]);
        if away[r] == 0 {
            (0..RAYS).for_each(|lane| leaves[lane] = leaves[lane].min(first[lane]));
            continue;
        }
        let slab = Slab::new(away[r]);
        for lane in 0..RAYS {
            let [own_enters, own_leaves] = slab.crossings(first[lane], period[lane], step[lane]);
            enters[lane] = enters[lane].max(own_enters);
            leaves[lane] = leaves[lane].min(own_leaves);
        }
    }
    let ignored = 4 * ignore_q16;
    for lane in 0..RAYS {
        let visits = (enters[lane] < leaves[lane]) & (enters[lane] >= ignored);
        let entry = if visits { enters[lane] } else { NONE };
        intersect.entered[lane] = intersect.entered[lane].min(entry);
    }
}

#[inline(always)]
fn settle<S: Simd>(
    _: S,
    entered: &Lanes<u32>,
    [until, limit]: [FirstHit; 2],
    found: &mut Lanes<FirstHit>,
) -> u64 {
    let mut open = [0u32; RAYS];
    for lane in 0..RAYS {
        let known = found[lane];
        let is_open = entered[lane].min(known) > until;
        let is_first = entered[lane] < known.min(limit);
        found[lane] = if is_first & !is_open { entered[lane] } else { known };
        open[lane] = is_open as u32;
    }
    packet::mask(&open)
}
