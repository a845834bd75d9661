//! Marks the voxels along a ray one after the other: from where the ray enters the window to where it leaves
//! it, or to the last voxel that it frees. `plan` chooses the rays.
//!
//! # Theory
//! A ray enters a box when it has entered on every axis, and leaves it when it leaves on any; both are
//! crossings, whose number is known in closed form. So the ray is put into the box in one leap, and the
//! crossing that ends what it frees is known beforehand.
//!
//! # Practice
//! For sensors with few rays, where looking from each voxel at the rays would cost more, and for the voxels
//! next to a camera, which thousands of its pixels see.

use super::first_hit::{self, FirstHit, LeapingRay};
use super::packet::Packet;
use crate::march::leap;
use crate::voxel::BitGrid;

/// Marks those of a ray's first `freed` voxels that lie in a plane's window; voxels that the ray enters after
/// `until_q16` may be left out.
pub(super) fn mark_freed(packet: &Packet, lane: usize, freed: u32, until_q16: u32, plane: &mut BitGrid) {
    let Some([enters, leaves]) = span(packet, lane, plane) else { return };
    let begins_inside = plane.window().contains(packet.voxel);
    let entered = || packet.made_by(lane, first_hit::crossing(enters as FirstHit));
    let made = if begins_inside { [0; 3] } else { entered() };
    let crossings: u32 = made.iter().sum();
    if crossings < freed {
        let end = leaves.min(4 * u64::from(until_q16) + 4);
        mark(plane, packet.ray(lane, made), freed - crossings, end);
    }
}

/// Marks those of a ray's first `freed` voxels that lie in a plane's window and come behind a place, up to which all are
/// marked.
pub(super) fn mark_freed_behind(
    packet: &Packet,
    lane: usize,
    place: FirstHit,
    freed: u32,
    plane: &mut BitGrid,
) {
    let Some([enters, leaves]) = span(packet, lane, plane) else { return };
    let from = enters.max(place.into());
    if from >= leaves {
        return;
    }
    let made = packet.made_by(lane, first_hit::crossing(from as FirstHit));
    let crossings: u32 = made.iter().sum();
    if crossings < freed {
        mark(plane, packet.ray(lane, made), freed - crossings, leaves);
    }
}

/// Whether a ray that passes through a plane's window has left it by a place.
pub(super) fn has_left(packet: &Packet, lane: usize, place: FirstHit, plane: &BitGrid) -> bool {
    span(packet, lane, plane).is_some_and(|[_, leaves]| u64::from(place) >= leaves)
}

/// Marks the voxel that a ray is in and those that follow, `voxels` in all at most, up to the crossing `end`.
#[inline]
fn mark(plane: &mut BitGrid, mut ray: LeapingRay, voxels: u32, end: u64) {
    let row = plane.words_per_row() as i32 * 32;
    let strides = [1, row, row * plane.window().size[1] as i32];
    let from = plane.window().min;
    let stride: [i64; 3] = std::array::from_fn(|r| ray.axes[r].step * i64::from(strides[r]));
    let period = ray.axes.map(|axis| 4 * u64::from(axis.period_q16));
    let mut bit = (0..3).map(|r| i64::from((ray.voxel[r] - from[r]) * strides[r])).sum::<i64>();
    let words = plane.words_mut();
    for _ in 0..voxels {
        words[bit as usize >> 5] |= 1 << (bit & 31);
        let [x, y, z] = ray.axes.map(|axis| axis.next);
        let nearest = x.min(y).min(z);
        if nearest >= end {
            break;
        }
        for r in 0..3 {
            let crossed = ray.axes[r].next == nearest;
            ray.axes[r].next += if crossed { period[r] } else { 0 };
            bit += if crossed { stride[r] } else { 0 };
        }
    }
}

/// The crossings by which a ray enters and leaves a plane's window; `None` if it never comes there. The first
/// is 0 where the ray begins inside, and also where it enters by a crossing of x at distance 0.
#[inline]
fn span(packet: &Packet, lane: usize, plane: &BitGrid) -> Option<[u64; 2]> {
    let (min, end) = (plane.window().min, plane.window().end());
    let low = std::array::from_fn(|r| min[r] - packet.voxel[r]);
    let high = std::array::from_fn(|r| end[r] - 1 - packet.voxel[r]);
    leap::span(|r| packet.axis(lane, r), low, high).filter(|[enters, _]| *enters <= first_hit::LAST.into())
}

/// Whether a ray passes through a plane's window at all.
pub(super) fn crosses_window(packet: &Packet, lane: usize, plane: &BitGrid) -> bool {
    span(packet, lane, plane).is_some()
}
