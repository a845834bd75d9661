//! Marks the voxels along a ray one after the other: from where the ray enters the window to where it leaves
//! it, or to the last voxel that it frees. `plan` chooses the rays.
//!
//! # Theory
//! The crossings by which a ray enters and leaves a window are known beforehand (`through`). So the ray is put into it in one
//! leap, and the crossing that ends what it frees is known, too. No crossing that is made is as late as 2³¹ as a number (`first_hit::LAST`), so
//! that later ones may all be cut to what 32 bits can say.
//!
//! # Practice
//! For sensors with few rays, where looking from each voxel at the rays would cost more, and for the voxels
//! next to a camera, which thousands of its pixels see.

use fearless_simd::{Level, Simd, dispatch};

use super::first_hit::{self, FirstHit, LeapingRay};
use super::packet::Packet;
use super::through::Through;
use crate::voxel::BitGrid;

/// Rays that are marked together.
const TOGETHER: usize = 16;

/// No crossing within any range is as late.
const LATE: u32 = 1 << 31;

/// Rays whose voxels are to be marked in one plane, each from a voxel that it is in.
pub(super) struct Marks {
    level: Level,
    /// Whether vectors are wide enough that many rays are marked at once.
    wide: bool,
    count: usize,
    bit: [i32; TOGETHER],
    /// How many voxels follow at most, and the crossing by which the last of them is left.
    voxels: [u32; TOGETHER],
    end: [u32; TOGETHER],
    /// The next crossing of each axis, what is added to it, and where it leads.
    next: [[u32; TOGETHER]; 3],
    period: [[u32; TOGETHER]; 3],
    stride: [[i32; TOGETHER]; 3],
}

/// A ray of a packet that is in a plane's window for a part of its way.
pub(super) type RayThrough<'a> = (&'a Packet, &'a Through, usize);

impl Marks {
    /// No rays yet.
    pub(super) fn new(level: Level, wide: bool) -> Self {
        let none = [[0; TOGETHER]; 3];
        let ([voxels, end], bit) = ([[0; TOGETHER]; 2], [0; TOGETHER]);
        Marks {
            level,
            wide,
            count: 0,
            bit,
            voxels,
            end,
            next: none,
            period: none,
            stride: [[0; TOGETHER]; 3],
        }
    }

    /// Marks those of a ray's first `freed` voxels that lie in a plane's window, now or with [`Marks::finish`]; voxels that
    /// the ray enters after `until_q16` may be left out.
    pub(super) fn mark_freed(
        &mut self,
        (packet, through, lane): RayThrough,
        freed: u32,
        until_q16: u32,
        plane: &mut BitGrid,
    ) {
        let Some([enters, leaves]) = through.span(lane) else { return };
        let begins_inside = plane.window().contains(packet.voxel);
        let entered = || packet.made_by(lane, first_hit::crossing(enters));
        let made = if begins_inside { [0; 3] } else { entered() };
        let crossings: u32 = made.iter().sum();
        if crossings < freed {
            let end = leaves.min(until_q16.saturating_mul(4).saturating_add(4));
            self.add(packet.ray(lane, made), freed - crossings, end, plane);
        }
    }

    /// The same, of those that come behind a place, up to which all are marked.
    pub(super) fn freed_behind(
        &mut self,
        (packet, through, lane): RayThrough,
        freed: u32,
        place: FirstHit,
        plane: &mut BitGrid,
    ) {
        let Some([enters, leaves]) = through.span(lane) else { return };
        let from = enters.max(place);
        if from >= leaves {
            return;
        }
        let made = packet.made_by(lane, first_hit::crossing(from));
        let crossings: u32 = made.iter().sum();
        if crossings < freed {
            self.add(packet.ray(lane, made), freed - crossings, leaves, plane);
        }
    }

    /// Adds the voxel that a ray is in and those that follow, `voxels` in all at most, up to the crossing `end`.
    fn add(&mut self, ray: LeapingRay, voxels: u32, end: u32, plane: &mut BitGrid) {
        let row = plane.words_per_row() as i32 * 32;
        let strides = [1, row, row * plane.window().size[1] as i32];
        let from = plane.window().min;
        let i = self.count;
        self.bit[i] = (0..3).map(|r| (ray.voxel[r] - from[r]) * strides[r]).sum();
        (self.voxels[i], self.end[i]) = (voxels, end.min(LATE));
        for (r, axis) in ray.axes.iter().enumerate() {
            self.next[r][i] = axis.next.min(u32::MAX.into()) as u32;
            self.period[r][i] = (4 * u64::from(axis.period_q16)).min(LATE.into()) as u32;
            self.stride[r][i] = axis.step as i32 * strides[r];
        }
        self.count += 1;
        if self.count == TOGETHER {
            self.finish(plane);
        }
    }

    /// Marks all rays that were not marked yet.
    pub(super) fn finish(&mut self, plane: &mut BitGrid) {
        let words = plane.words_mut();
        if !self.wide {
            (0..self.count).for_each(|i| self.mark(i, words));
        } else if self.count > 0 {
            self.voxels[self.count..].fill(0);
            dispatch!(self.level, simd => mark_all(simd, self, words));
        }
        self.count = 0;
    }

    /// Marks one ray.
    #[inline]
    fn mark(&self, i: usize, words: &mut [u32]) {
        let [mut next, period] = [self.next, self.period].map(|axes| axes.map(|rays| rays[i]));
        let (mut bit, stride, end) = (self.bit[i], self.stride.map(|rays| rays[i]), self.end[i]);
        for _ in 0..self.voxels[i] {
            words[bit as usize >> 5] |= 1 << (bit & 31);
            let nearest = next[0].min(next[1]).min(next[2]);
            if nearest >= end {
                break;
            }
            for r in 0..3 {
                let crossed = next[r] == nearest;
                next[r] += if crossed { period[r] } else { 0 };
                bit += if crossed { stride[r] } else { 0 };
            }
        }
    }
}

/// Marks all rays, voxel after voxel. A ray that has come to its end marks its last one again.
#[inline(always)]
fn mark_all<S: Simd>(_: S, marks: &mut Marks, words: &mut [u32]) {
    let Marks { count, bit, voxels, end, next, period, stride, .. } = marks;
    let mut goes_on = 1;
    while goes_on != 0 {
        for bit in &bit[..*count] {
            words[*bit as usize >> 5] |= 1 << (bit & 31);
        }
        goes_on = 0;
        for i in 0..TOGETHER {
            let nearest = next[0][i].min(next[1][i]).min(next[2][i]);
            let goes = (voxels[i] > 1) & (nearest < end[i]);
            goes_on |= u32::from(goes);
            voxels[i] -= u32::from(goes);
            for r in 0..3 {
                let crossed = goes & (next[r][i] == nearest);
                next[r][i] += if crossed { period[r][i] } else { 0 };
                bit[i] += if crossed { stride[r][i] } else { 0 };
            }
        }
    }
}
