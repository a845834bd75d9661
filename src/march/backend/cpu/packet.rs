//! Packets of 64 rays: tables in the order in which rays are cast together, and the arithmetic that is the
//! same for all rays of a packet, in loops that the compiler turns into vector code for the processor at
//! hand.
//!
//! # Theory
//! Every value is the one that `march` defines; lanes do not depend on each other, so their number changes
//! nothing.
//!
//! # Practice
//! A camera's packet is a tile of 8 × 8 pixels, so that its rays stay together; other tables go in ray order.

use fearless_simd::{Level, Simd, dispatch};

use super::first_hit::{LeapingRay, NextCrossing};
use crate::backend::{GridPose, Image, Rays};
use crate::march::leap::{self, RayAxis};
use crate::march::{self, March};

/// Rays of a packet.
pub(super) const RAYS: usize = 64;

/// Edge of a camera's tile in pixels.
pub(super) const TILE: u32 = 8;

/// The most pixels across or down that rectangles of pixels are made for; the rays of a larger image go one by one.
pub(super) const WIDEST_PX: u32 = 1 << 16;

/// Edge of a group of a camera's tiles.
const GROUP: usize = 4;

/// One number for each ray of a packet.
pub(super) type Lanes<T> = [T; RAYS];

/// The directions of a table, packet by packet.
pub(super) struct Packets {
    /// Q15, axis by axis.
    dirs_q15: Vec<[Lanes<i32>; 3]>,
    rays: usize,
    image: Option<Image>,
}

impl Packets {
    /// The rays of a table in the order they are cast.
    pub(super) fn new(rays: &Rays) -> Self {
        let image = rays.image.filter(|image| image.size_px.iter().all(|&n| n <= WIDEST_PX));
        let mut packets = Packets { dirs_q15: Vec::new(), rays: rays.dirs_q15.len(), image };
        for packet in 0..packets.count() {
            let own = packets.numbers(packet);
            let dirs = |a: usize| std::array::from_fn(|lane| rays.dirs_q15[own[lane] as usize][a]);
            packets.dirs_q15.push(std::array::from_fn(dirs));
        }
        packets
    }

    /// How many packets there are.
    pub(super) fn count(&self) -> usize {
        match self.image {
            None => self.rays.div_ceil(RAYS),
            Some(image) => image.size_px.iter().map(|&n| n.div_ceil(TILE) as usize).product(),
        }
    }

    /// How many rays the table has.
    pub(super) fn rays(&self) -> usize {
        self.rays
    }

    /// The camera whose pixels the rays are, if they are.
    pub(super) fn image(&self) -> Option<&Image> {
        self.image.as_ref()
    }

    /// The packets of each group of a camera's tiles.
    pub(super) fn groups(&self) -> Vec<Vec<usize>> {
        let mut groups = Vec::new();
        for packet in 0..self.count() {
            let group = self.group_of(packet);
            groups.resize(groups.len().max(group + 1), Vec::new());
            groups[group].push(packet);
        }
        groups
    }

    /// The group that a camera's tile is in.
    pub(super) fn group_of(&self, packet: usize) -> usize {
        let across = self.image.map_or(1, |image| image.size_px[0].div_ceil(TILE)) as usize;
        packet / across / GROUP * across.div_ceil(GROUP) + packet % across / GROUP
    }

    /// The directions of a packet, axis by axis.
    pub(super) fn dirs_q15(&self, packet: usize) -> &[Lanes<i32>; 3] {
        &self.dirs_q15[packet]
    }

    /// The number of each lane's ray. Lanes past the edge of an image or the end of a table repeat the last
    /// ray before it.
    pub(super) fn numbers(&self, packet: usize) -> Lanes<u32> {
        let first = (packet * RAYS) as u32;
        let last = self.rays as u32 - 1;
        let Some(image) = self.image else {
            return std::array::from_fn(|lane| (first + lane as u32).min(last));
        };
        let [width, height] = image.size_px;
        let across = width.div_ceil(TILE);
        let [left, top] = [packet as u32 % across * TILE, packet as u32 / across * TILE];
        let mut numbers = [0; RAYS];
        for (v, row) in (top..).zip(numbers.chunks_exact_mut(TILE as usize)) {
            let begin = v.min(height - 1) * width;
            (left..).zip(row).for_each(|(u, number)| *number = begin + u.min(width - 1));
        }
        numbers
    }
}

/// The rays of a packet in a grid, as `march::start` makes each of them.
pub(super) struct Packet {
    /// The voxel where all begin.
    pub(super) voxel: [i32; 3],
    /// Components of the directions, Q16.
    pub(super) dir_q16: [Lanes<i32>; 3],
    pub(super) period_q16: [Lanes<u32>; 3],
    pub(super) first_q16: [Lanes<u32>; 3],
}

impl Packet {
    /// No rays yet.
    pub(super) fn new() -> Self {
        let none = [[march::NEVER; RAYS]; 3];
        Packet { voxel: [0; 3], dir_q16: [[0; RAYS]; 3], period_q16: none, first_q16: none }
    }

    /// Sends rays from a placement.
    pub(super) fn start(&mut self, level: Level, placement: &GridPose, dirs_q15: &[Lanes<i32>; 3]) {
        self.voxel = placement.origin_q16.map(|x| x >> 16);
        dispatch!(level, simd => start(simd, self, placement, dirs_q15));
    }

    /// How many crossings of each axis each ray has made at a place of its own (see [`leap::made_at`]).
    pub(super) fn count_crossings(&self, level: Level, at: &RayPlaces, made: &mut [Lanes<u32>; 3]) {
        dispatch!(level, simd => made_at(simd, self, at, made));
    }

    /// How many crossings of each axis a ray has made at a crossing.
    pub(super) fn made_by(&self, lane: usize, NextCrossing { t_q16, axis }: NextCrossing) -> [u32; 3] {
        std::array::from_fn(|r| {
            let d = self.dir_q16[r][lane].unsigned_abs();
            leap::made_at(self.first_q16[r][lane], self.period_q16[r][lane], d, r as u32, t_q16, axis)
        })
    }

    /// A ray where it begins.
    pub(super) fn march(&self, lane: usize) -> March {
        March {
            voxel: self.voxel,
            step: std::array::from_fn(|r| self.dir_q16[r][lane].signum()),
            next_q16: std::array::from_fn(|r| self.first_q16[r][lane]),
            period_q16: std::array::from_fn(|r| self.period_q16[r][lane]),
        }
    }

    /// One axis of a ray where it begins.
    #[inline(always)]
    pub(super) fn axis(&self, lane: usize, r: usize) -> RayAxis {
        RayAxis::new(r, self.dir_q16[r][lane].signum(), self.first_q16[r][lane], self.period_q16[r][lane])
    }

    /// A ray after so many crossings.
    #[inline]
    pub(super) fn ray(&self, lane: usize, made: [u32; 3]) -> LeapingRay {
        let axes: [RayAxis; 3] = std::array::from_fn(|r| self.axis(lane, r));
        LeapingRay {
            voxel: std::array::from_fn(|r| self.voxel[r] + axes[r].step as i32 * made[r] as i32),
            axes: std::array::from_fn(|r| RayAxis { next: axes[r].crossing(made[r]), ..axes[r] }),
            d: std::array::from_fn(|r| self.dir_q16[r][lane].unsigned_abs()),
        }
    }
}

/// A place on each ray of a packet: a distance, and the last axis that has crossed there.
pub(super) struct RayPlaces {
    pub(super) t_q16: Lanes<u32>,
    pub(super) axis: Lanes<u32>,
}

#[inline(always)]
fn start<S: Simd>(_: S, packet: &mut Packet, placement: &GridPose, dirs_q15: &[Lanes<i32>; 3]) {
    let [x, y, z] = dirs_q15;
    for r in 0..3 {
        let axis_q15 = placement.axis_q15[r];
        let (dir, period, first) =
            (&mut packet.dir_q16[r], &mut packet.period_q16[r], &mut packet.first_q16[r]);
        for lane in 0..RAYS {
            let dir_q16 = march::direction_q16(axis_q15, [x[lane], y[lane], z[lane]]);
            dir[lane] = dir_q16;
            [first[lane], period[lane]] = march::start_axis(placement.origin_q16[r], dir_q16);
        }
    }
}

/// A bit for each lane, from 0 or 1 for each.
#[inline(always)]
pub(super) fn mask(lanes: &Lanes<u32>) -> u64 {
    let mut bytes = [0; RAYS];
    (0..RAYS).for_each(|lane| bytes[lane] = lanes[lane] as u8);
    // The product has the lowest bit of each of eight bytes in its highest byte.
    let byte = |lanes: &[u8; 8]| u64::from_le_bytes(*lanes).wrapping_mul(0x0102_0408_1020_4080) >> 56;
    bytes.as_chunks().0.iter().rev().fold(0, |all, lanes| all << 8 | byte(lanes))
}

#[inline(always)]
fn made_at<S: Simd>(_: S, packet: &Packet, at: &RayPlaces, made: &mut [Lanes<u32>; 3]) {
    for r in 0..3 {
        for lane in 0..RAYS {
            let (first, period) = (packet.first_q16[r][lane], packet.period_q16[r][lane]);
            let d = packet.dir_q16[r][lane].unsigned_abs();
            made[r][lane] = leap::made_at(first, period, d, r as u32, at.t_q16[lane], at.axis[lane]);
        }
    }
}
