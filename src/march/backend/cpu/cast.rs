//! What the rays of a packet hit first: a camera's tile goes together as long as that pays, other rays go one by one.
//!
//! # Theory
//! Where a tile's cone is clear, no ray has hit anything (`cone`). Between two such places all that a ray can hit is in the
//! section of the cone there: blockers that rays are held against one after the other (`intersect`), or a layer of them that
//! stops all (`across`). What is left goes on by itself from the last place that is known to be clear (`first_hit`).
//!
//! # Practice
//! A tile that passes an edge of an object is soon together again behind it.

use super::across::BlockerLayer;
use super::cone::ConeAtPose;
use super::first_hit::{self, FirstHit, Search};
use super::limits::PacketLimits;
use super::packet::RAYS;
use super::scratch::Scratch;
use super::table::TableCaster;
use crate::backend::GridPose;

/// Length of a section of a cone in voxels, how many are looked at one after the other, and the most blockers
/// that are held against all rays, without wide vectors and with them: beyond that, rays go on one by one.
pub(super) const SECTION: f32 = 4.0;
const SECTIONS: usize = 16;
const MOST_NEAR: [usize; 2] = [12, 48];

/// Where the rays of a packet have entered no blocker yet.
#[derive(Clone, Copy)]
pub(super) enum Clear<'a> {
    /// Up to a distance that all have in common, in voxels.
    Distance(f32),
    /// Up to a place of each ray's own; 0 where nothing is known of it.
    Places(&'a [FirstHit]),
}

impl TableCaster<'_> {
    /// The first hits of a packet on a layer, where they come before those already known, of some rays at least.
    pub(super) fn first_hits(
        &self,
        search: &Search,
        packet: usize,
        rays: u64,
        clear: Clear,
        placement: &GridPose,
        scratch: &mut Scratch,
    ) {
        let limits = self.table.limits(packet);
        let Some(cone) = self.table.cones.get(packet) else {
            for lane in (0..RAYS).filter(|lane| rays >> lane & 1 == 1) {
                let known = scratch.found[lane];
                let place = if let Clear::Places(places) = clear { places[lane] } else { 0 };
                let made = match place {
                    0 => [0; 3],
                    place => scratch.packet.made_by(lane, first_hit::crossing(place)),
                };
                let ray = scratch.packet.ray(lane, made);
                scratch.found[lane] = search.first_hit(ray, place == 0, known.min(limits.last[lane]), known);
            }
            return;
        };
        let cone = cone.place(placement);
        let mut clear = cone.clear(search, if let Clear::Distance(clear) = clear { clear } else { 0.0 });
        let mut open = u64::MAX;
        if clear > 0.0 {
            (open, clear) = self.intersect(search, &cone, clear, scratch, limits);
        }
        if open == 0 {
            return;
        }
        let clear_q16 = (clear * 65_536.0) as u32;
        if clear_q16 > 0 {
            scratch.places.t_q16 = [clear_q16; RAYS];
            scratch.packet.count_crossings(self.level, &scratch.places, &mut scratch.made);
        } else {
            scratch.made = [[0; RAYS]; 3];
        }
        for lane in (0..RAYS).filter(|lane| open >> lane & 1 == 1) {
            let ray = scratch.packet.ray(lane, std::array::from_fn(|r| scratch.made[r][lane]));
            let known = scratch.found[lane];
            scratch.found[lane] = search.first_hit(ray, clear_q16 == 0, known.min(limits.last[lane]), known);
        }
    }

    /// The layer of blockers that all rays of a cone enter after they have come so far, if there is one.
    fn find_layer(&self, search: &Search, cone: &ConeAtPose, from: f32) -> Option<BlockerLayer> {
        let blockers = &search.layer.blockers;
        let is_behind = from > search.ignore_q16 as f32 / 65_536.0 + 1.0;
        is_behind.then(|| BlockerLayer::new(blockers, cone, from, SECTION, f32::MAX)).flatten()
    }

    /// The first hits of rays that end soon after where a cone is clear. Says which lanes are open still, and
    /// from where.
    fn intersect(
        &self,
        search: &Search,
        cone: &ConeAtPose,
        clear: f32,
        scratch: &mut Scratch,
        limits: &PacketLimits,
    ) -> (u64, f32) {
        let grid = search.layer.blockers.window();
        let mut open = u64::MAX;
        let mut from = clear;
        scratch.intersect.start(self.level, &scratch.packet);
        for _ in 0..SECTIONS {
            let to = from + SECTION;
            let section = cone.section(from, to);
            scratch.near.clear();
            let touches = cone.touches(to);
            search.layer.blockers.each_in(&section, |voxel| {
                if touches(voxel) {
                    scratch.near.push(voxel);
                }
            });
            let across = match scratch.near.is_empty() {
                true => None,
                false => self.find_layer(search, cone, from),
            };
            if let Some(across) = &across {
                scratch.near.clear();
                search.layer.blockers.each_in(&across.before, |voxel| scratch.near.push(voxel));
            }
            if scratch.near.len() > MOST_NEAR[usize::from(self.wide)] {
                break;
            }
            for voxel in &scratch.near {
                let away = std::array::from_fn(|r| voxel[r] - scratch.packet.voxel[r]);
                if away != [0; 3] {
                    scratch.intersect.intersect(self.level, away, search.ignore_q16);
                }
            }
            if let Some(BlockerLayer { axis, at, .. }) = across {
                scratch.intersect.enter(self.level, axis, at - scratch.packet.voxel[axis]);
                let open = scratch.intersect.settle(self.level, 0, &limits.last, true, &mut scratch.found);
                return (open, from);
            }
            let until = first_hit::range((to * 65_536.0) as u32);
            let inside = section.intersection(&grid) == section;
            // A ray that has come to the end of its range may have left the grid before.
            let all = inside && limits.farthest <= until;
            open = scratch.intersect.settle(self.level, until, &limits.last, all, &mut scratch.found);
            // Rays that are open may have left the grid in this section: they go on from where they surely
            // had not.
            if open == 0 || !inside {
                break;
            }
            from = cone.clear(search, to);
        }
        (open, from)
    }
}
