//! Cells along a ray, marked one after the other: from where it enters the window to where it leaves it, or
//! frees no more. `plan` chooses the rays.
//!
//! # Theory
//! A ray enters a box when it has entered on every axis, and leaves it when it leaves on any; both are
//! crossings, whose number is known in closed form. So a ray lands in the box at once, and knows the crossing
//! that ends what it frees.
//!
//! # Practice
//! For sensors with few rays, where looking from each voxel at the rays would cost more, and for the voxels
//! next to a camera, which thousands of its pixels see.

use super::first_hit::{self, FirstHit, LeapingRay};
use super::packet::Packet;
use crate::voxel::BitGrid;

/// Marks the voxels of a ray in a plane's window, of its first `freed` ones, those at least that it enters by
/// `until_q16`.
pub(super) fn mark_freed(packet: &Packet, lane: usize, freed: u32, until_q16: u32, plane: &mut BitGrid) {
    let Some(made) = enter(packet, lane, plane) else { return };
    let crossings: u32 = made.iter().sum();
    if crossings >= freed {
        return;
    }
    let ray = packet.ray(lane, made);
    let (min, end) = (plane.window().min, plane.window().end());
    let leaves = |r: usize| {
        let room = if ray.step[r] < 0 { ray.voxel[r] - min[r] } else { end[r] - 1 - ray.voxel[r] };
        ray.next[r] + room as u64 * 4 * u64::from(ray.period_q16[r])
    };
    let end = leaves(0).min(leaves(1)).min(leaves(2)).min(4 * u64::from(until_q16) + 4);
    mark(plane, ray, freed - crossings, end);
}

/// Marks the voxel that a ray is in and those that follow, so many in all, up to the crossing `end`.
#[inline]
fn mark(plane: &mut BitGrid, mut ray: LeapingRay, voxels: u32, end: u64) {
    let row = plane.words_per_row() as i32 * 32;
    let strides = [1, row, row * plane.window().size[1] as i32];
    let from = plane.window().min;
    let stride: [i64; 3] = std::array::from_fn(|r| i64::from(ray.step[r] * strides[r]));
    let period = ray.period_q16.map(|period| 4 * u64::from(period));
    let mut bit = (0..3).map(|r| i64::from((ray.voxel[r] - from[r]) * strides[r])).sum::<i64>();
    let words = plane.words_mut();
    for _ in 0..voxels {
        words[bit as usize >> 5] |= 1 << (bit & 31);
        let [x, y, z] = ray.next;
        let nearest = x.min(y).min(z);
        if nearest >= end {
            break;
        }
        for r in 0..3 {
            let crossed = ray.next[r] == nearest;
            ray.next[r] += if crossed { period[r] } else { 0 };
            bit += if crossed { stride[r] } else { 0 };
        }
    }
}

/// The crossings made when a ray has entered the window on every axis; `None` if it is past it by then, or
/// never comes.
fn enter(packet: &Packet, lane: usize, plane: &BitGrid) -> Option<[u32; 3]> {
    let (min, end) = (plane.window().min, plane.window().end());
    let mut entered: Option<u64> = None;
    for r in 0..3 {
        let (voxel, step) = (packet.voxel[r], packet.dir_q16[r][lane].signum());
        let away = if voxel < min[r] { min[r] - voxel } else { (voxel - (end[r] - 1)).max(0) };
        if away > 0 {
            let towards = if voxel < min[r] { 1 } else { -1 };
            if step != towards {
                return None;
            }
            let (first, period) = (packet.first_q16[r][lane], packet.period_q16[r][lane]);
            let t_q16 = u64::from(first) + (away as u64 - 1) * u64::from(period);
            entered = entered.max(Some(4 * t_q16 + r as u64));
        }
    }
    let Some(entered) = entered else { return Some([0; 3]) };
    if entered > first_hit::LAST.into() {
        return None;
    }
    let made = packet.made_by(lane, first_hit::crossing(entered as FirstHit));
    let inside = (0..3).all(|r| {
        let voxel = packet.voxel[r] + packet.dir_q16[r][lane].signum() * made[r] as i32;
        voxel >= min[r] && voxel < end[r]
    });
    inside.then_some(made)
}

/// Whether a ray passes through the window at all.
pub(super) fn crosses_window(packet: &Packet, lane: usize, plane: &BitGrid) -> bool {
    enter(packet, lane, plane).is_some()
}
