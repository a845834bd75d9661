//! What the rays of a pose free in all snapshots of a scene, marked once for all of them.
//!
//! # Theory
//! Some blockers stand in all snapshots, the others in some. In any snapshot a ray's first hit is no later than its first hit on the
//! former, and no earlier than the earlier of its first hits on both. If these two are the same the ray is *steady*: it never meets
//! what moves. Where the ray surely returns, it frees at least the voxels up to the earlier of the two, less the farthest that noise may
//! bring a return nearer; these are marked in a plane that all snapshots begin with. Where it surely does not return, it
//! frees the same in all snapshots. A ray that has left the window before the place up to which it is marked has nothing
//! left to do in any snapshot, and a packet of such rays is passed over.
//!
//! # Practice
//! For tables that are carved by ray. Returns must not be lost by chance, and the mount must be where it is
//! believed to be. At the first snapshot of a pose nothing is known yet; the second makes the plane.

use super::first_hit::{self, FirstHit};
use super::packet::RAYS;
use crate::voxel::BitGrid;

/// Nothing is left to do for a ray.
pub(super) const DONE: FirstHit = u32::MAX;

/// What is known of the rays of a pose.
#[derive(Clone)]
pub(super) struct Alike {
    /// What they all free, over a window.
    pub(super) free: BitGrid,
    /// Up to where each ray's voxels are marked there: 0 for not at all, or [`DONE`].
    pub(super) marked: Vec<FirstHit>,
    /// The rays that may meet what moves and are not [`DONE`], a bit each, packet by packet.
    pub(super) moved: Vec<u64>,
}

impl Alike {
    /// Those of a packet: up to where each is marked, and which what moves may meet; `None` if nothing is left to do.
    pub(super) fn packet(&self, packet: usize) -> Option<(&[FirstHit], u64)> {
        let marked = &self.marked[packet * RAYS..(packet + 1) * RAYS];
        marked.iter().any(|&place| place != DONE).then(|| (marked, self.moved[packet]))
    }
}

/// A place before all where a return is read that lies this far, or farther, and is brought nearer by noise by at most so
/// much; 0 for where the ray begins.
pub(super) fn earliest_hit(hit: FirstHit, nearer_q16: u32) -> FirstHit {
    let nearest_q16 = (hit >> 2).saturating_sub(nearer_q16);
    match nearest_q16.checked_sub(1) {
        Some(t_q16) => first_hit::range(t_q16) & !3 | 2,
        None => 0,
    }
}
