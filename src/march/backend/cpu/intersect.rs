//! Which of a few blockers each ray of a packet hits first: every ray against every blocker, 64 rays at
//! once. `cast` lists these blockers.
//!
//! # Theory
//! A ray visits a voxel if and only if it enters on every axis before it leaves on any, six crossings in
//! closed form (`SEMANTICS.md`, "Rays"). Of all blockers visited, the one entered first is the one that
//! single steps would find. A section of a cone holds every voxel that its rays are in up to a distance, so
//! an entry up to there is first of all.
//!
//! # Practice
//! Where blockers are few, or vectors wide: no ray waits for another's guess of which axis comes next, and
//! nothing is looked up. A tile's rays end on a dozen voxels or two.
//!
//! No lane is written under a mask: with AVX2 some processors do that slowly (`benches/RESULTS.md`). The compiler
//! would do it where it sees that a minimum with [`NONE`] changes nothing, so `black_box` hides that value from it.

use std::hint::black_box;

use fearless_simd::{Level, Simd, dispatch};

use super::first_hit::FirstHit;
use super::narrow::{NONE, NarrowPacket, Slabs};
use super::packet::{self, Lanes, Packet, RAYS};

/// Rays that are held against a blocker together: so few that their crossings stay in registers.
const AT_ONCE: usize = 16;

/// The rays of a packet.
pub(super) struct Intersect {
    rays: NarrowPacket,
    /// For each ray, the crossing by which it entered the first blocker so far.
    entered: Lanes<u32>,
}

impl Intersect {
    pub(super) fn new() -> Self {
        Intersect { rays: NarrowPacket::new(), entered: [NONE; RAYS] }
    }

    /// Rays that have hit nothing.
    pub(super) fn start(&mut self, level: Level, packet: &Packet) {
        dispatch!(level, simd => self.rays.start(simd, packet));
        self.entered = [NONE; RAYS];
    }

    /// The rays of a packet against a blocker, `away` voxels from the voxel where all of them begin. For rays
    /// that enter it before `ignore_q16` it is no blocker.
    pub(super) fn intersect(&mut self, level: Level, away: [i32; 3], ignore_q16: u32) {
        dispatch!(level, simd => intersect(simd, self, away, ignore_q16));
    }

    /// The rays of a packet against a layer of blockers across an axis, `away` voxels from where they begin. All of them
    /// must enter it, and later than blockers are ignored.
    pub(super) fn enter(&mut self, level: Level, axis: usize, away: i32) {
        dispatch!(level, simd => {
            let enters = self.rays.enters(simd, axis, away);
            (0..RAYS).for_each(|lane| self.entered[lane] = self.entered[lane].min(enters[lane]));
        });
    }

    /// What rays hit first, of those that hit something up to `until`, and if `all`, of the others, too: the first
    /// blocker so far if it comes before its own limit and before what is known already. Says which rays are open still, a
    /// bit each. Rays that are not stay as they are when more blockers have been tested.
    pub(super) fn settle(
        &self,
        level: Level,
        until: FirstHit,
        limits: &Lanes<FirstHit>,
        all: bool,
        found: &mut Lanes<FirstHit>,
    ) -> u64 {
        let until = if all { NONE } else { until };
        dispatch!(level, simd => settle(simd, &self.entered, until, limits, found))
    }
}

#[inline(always)]
fn intersect<S: Simd>(_: S, intersect: &mut Intersect, away: [i32; 3], ignore_q16: u32) {
    let (slabs, ignored, none) = (Slabs::new(away), 4 * ignore_q16, black_box(NONE));
    for (nth, entered) in intersect.entered.as_chunks_mut::<AT_ONCE>().0.iter_mut().enumerate() {
        let [enters, leaves] = intersect.rays.spans::<AT_ONCE>(nth * AT_ONCE, &slabs);
        for lane in 0..AT_ONCE {
            let visits = (enters[lane] < leaves[lane]) & (enters[lane] >= ignored);
            let entry = if visits { enters[lane] } else { none };
            entered[lane] = entered[lane].min(entry);
        }
    }
}

#[inline(always)]
fn settle<S: Simd>(
    _: S,
    entered: &Lanes<u32>,
    until: FirstHit,
    limits: &Lanes<FirstHit>,
    found: &mut Lanes<FirstHit>,
) -> u64 {
    let (mut open, none) = ([0u32; RAYS], black_box(NONE));
    for lane in 0..RAYS {
        let known = found[lane];
        let is_open = entered[lane].min(known) > until;
        let is_first = entered[lane] < known.min(limits[lane]);
        found[lane] = known.min(if is_first & !is_open { entered[lane] } else { none });
        open[lane] = is_open as u32;
    }
    packet::mask(&open)
}
