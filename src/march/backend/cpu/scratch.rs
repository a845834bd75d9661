//! What a thread works on while it senses, kept from pose to pose so that nothing is allocated anew.

use super::asked::AskedPlaces;
use super::carve_rays::Marks;
use super::end::PacketEnds;
use super::first_hit::{self, FirstHit};
use super::intersect::Intersect;
use super::packet::{Lanes, Packet, RAYS, RayPlaces};
use super::pyramid::Pyramid;
use super::table::TableCaster;
use super::through::Through;

/// What a thread works on, kept from pose to pose.
pub(super) struct Scratch {
    pub(super) packet: Packet,
    /// The rays as they are truly cast, where those of the packet are only believed.
    pub(super) truly: Packet,
    pub(super) found: Lanes<FirstHit>,
    pub(super) ends: PacketEnds,
    pub(super) places: RayPlaces,
    pub(super) made: [Lanes<u32>; 3],
    pub(super) pyramid: Option<Pyramid>,
    pub(super) asked: AskedPlaces,
    pub(super) through: Through,
    pub(super) marks: Marks,
    pub(super) intersect: Intersect,
    /// Blockers that a cone comes to.
    pub(super) near: Vec<[i32; 3]>,
}

impl Scratch {
    /// Room for the rays of a table; nothing is known yet.
    pub(super) fn new(caster: &TableCaster) -> Self {
        let pyramid = caster.table.packets.image().map(Pyramid::new);
        Scratch { pyramid, ..Scratch::without_image(caster) }
    }

    /// The same without room for the image of a camera.
    pub(super) fn without_image(caster: &TableCaster) -> Self {
        Scratch {
            packet: Packet::new(),
            truly: Packet::new(),
            found: [first_hit::UNKNOWN; RAYS],
            ends: PacketEnds::new(),
            places: RayPlaces { t_q16: [0; RAYS], axis: [2; RAYS] },
            made: [[0; RAYS]; 3],
            pyramid: None,
            asked: AskedPlaces::new(),
            through: Through::new(),
            marks: Marks::new(caster.level, caster.wide),
            intersect: Intersect::new(),
            near: Vec::new(),
        }
    }
}
