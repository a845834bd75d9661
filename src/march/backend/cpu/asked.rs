//! The rays of a camera's tiles that voxels were held against lately.
//!
//! # Theory
//! Rays are what `packet` starts, kept or started again.
//!
//! # Practice
//! For `carve_voxels`: voxels that lie side by side ask the same tiles, and to start rays costs more than to hold them
//! against one voxel.

use fearless_simd::{Level, dispatch};

use super::narrow::NarrowPacket;
use super::packet::{Packet, Packets, TILE};
use crate::backend::GridPose;

/// Tiles that are kept, on each axis: those of any so many columns and rows side by side have places of their own.
const KEPT: [u32; 2] = [16, 8];

/// Places for tiles, kept from pose to pose for their memory.
pub(super) struct AskedPlaces {
    packet: Packet,
    /// Each with the tile that is kept there.
    places: Vec<(Option<[u32; 2]>, NarrowPacket)>,
}

impl AskedPlaces {
    pub(super) fn new() -> Self {
        let places = KEPT.iter().product::<u32>() as usize;
        AskedPlaces { packet: Packet::new(), places: vec![(None, NarrowPacket::new()); places] }
    }
}

/// The tiles of a camera at a placement.
pub(super) struct AskedTiles<'a> {
    level: Level,
    packets: &'a Packets,
    placement: &'a GridPose,
    across: u32,
    kept: &'a mut AskedPlaces,
}

impl<'a> AskedTiles<'a> {
    /// None of them is kept yet.
    pub(super) fn new(
        level: Level,
        packets: &'a Packets,
        placement: &'a GridPose,
        kept: &'a mut AskedPlaces,
    ) -> Self {
        kept.places.iter_mut().for_each(|(tile, _)| *tile = None);
        let across = packets.image().map_or(1, |image| image.size_px[0].div_ceil(TILE));
        AskedTiles { level, packets, placement, across, kept }
    }

    /// The rays of a tile, from its column and row.
    pub(super) fn rays(&mut self, tile: [u32; 2]) -> &NarrowPacket {
        let [u, v]: [u32; 2] = std::array::from_fn(|a| tile[a] % KEPT[a]);
        let AskedPlaces { packet, places } = &mut self.kept;
        let (kept, rays) = &mut places[(v * KEPT[0] + u) as usize];
        if *kept != Some(tile) {
            *kept = Some(tile);
            packet.start(
                self.level,
                self.placement,
                self.packets.dirs_q15((tile[1] * self.across + tile[0]) as usize),
            );
            dispatch!(self.level, simd => rays.start(simd, packet));
        }
        rays
    }
}
