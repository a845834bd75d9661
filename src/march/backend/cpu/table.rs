//! A table of rays made ready, and the scene that it is cast in.

use fearless_simd::Level;

use super::cone::Cone;
use super::first_hit::{Layer, Search};
use super::limits::PacketLimits;
use super::packet::Packets;
use super::plan::RelevantVoxels;
use crate::backend::{Carving, GridPose, Noise, Rays, Shades};
use crate::march::Gates;

/// A table of rays made ready.
pub(super) struct RayTable {
    pub(super) packets: Packets,
    /// For a camera's packets, and for groups of so many tiles on each axis.
    pub(super) cones: Vec<Cone>,
    pub(super) groups: Vec<Cone>,
    pub(super) gates: Gates,
    limits: Vec<PacketLimits>,
    pub(super) noise: Noise,
    /// What it was made of.
    pub(super) rays: Rays,
    /// The farthest before its distance that a return may be read.
    pub(super) nearer_q16: u32,
}

impl RayTable {
    /// Makes a table ready.
    pub(super) fn new(rays: &Rays) -> Self {
        let packets = Packets::new(rays);
        let tiles = if packets.image().is_some() { packets.count() } else { 0 };
        let cones = (0..tiles).map(|tile| Cone::new(&packets, &[tile])).collect();
        let groups = if packets.image().is_some() { packets.groups() } else { Vec::new() };
        let groups = groups.iter().map(|tiles| Cone::new(&packets, tiles)).collect();
        let limits = PacketLimits::from_packets(&packets, &rays.gates);
        let nearer_q16 = rays.nearest_q16();
        let (gates, noise, rays) = (rays.gates, rays.noise.clone(), rays.clone());
        RayTable { packets, cones, groups, gates, limits, noise, rays, nearer_q16 }
    }

    /// The limits of a packet's rays.
    pub(super) fn limits(&self, packet: usize) -> &PacketLimits {
        &self.limits[if self.gates.along_axis { packet } else { 0 }]
    }
}

/// What stops rays: one layer, or what stands still in all snapshots and the rest.
pub(super) struct Blockers<'a> {
    pub(super) still: Option<&'a Layer>,
    pub(super) moving: &'a Layer,
    /// What stops rays in some snapshots, and not in all.
    pub(super) sometimes: Option<&'a Layer>,
}

/// A table of rays in a scene, before it has a pose.
pub(super) struct TableCaster<'a> {
    pub(super) level: Level,
    /// Whether vectors are wide enough that all rays against many near blockers pay, or all pixels of a tile at once.
    pub(super) wide: bool,
    pub(super) table: &'a RayTable,
    pub(super) blockers: Blockers<'a>,
    /// How dark blockers are, if that matters to the table.
    pub(super) shades: Option<&'a Shades>,
    pub(super) wanted: &'a RelevantVoxels,
    pub(super) carving: Option<Carving>,
    /// Most words of a plane that is kept from snapshot to snapshot.
    pub(super) plane_words: usize,
}

impl TableCaster<'_> {
    /// Whether returns may be lost, so that a ray may end in nothing although it hits something within its range.
    pub(super) fn may_lose_returns(&self) -> bool {
        self.table.noise.lost_below > 0 || self.shades.is_some()
    }

    /// What finds the first hits on a layer of the rays that are cast from a pose.
    pub(super) fn search<'l>(&self, layer: &'l Layer, caster: &GridPose) -> Search<'l> {
        Search::new(layer, self.table.gates.near_ignore_q16, caster.origin_q16.map(|x| x >> 16))
    }
}
