//! Cells along a ray, marked one after the other: from where it enters the window to where it leaves it, or frees no more.
//! Which rays go this way is `plan`'s business.
//!
//! # Theory
//! A ray enters a box when it has entered on every axis, and leaves it when it leaves on any; both are crossings, whose
//! number is known in closed form. So the cells inside the box are counted before the first is marked.
//!
//! # Practice
//! For sensors with few rays, where looking from each voxel at the rays would cost more, and for the voxels next to a
//! camera, which thousands of its pixels see.

use super::bundle::Bundle;
use crate::march::leap::{self, Key};
use crate::march::{self, NEVER};
use crate::voxel::BitGrid;

/// Marks the cells of a ray in a plane's window, of its first `freed` ones, those that it enters by `until_q16`.
pub(super) fn walk(bundle: &Bundle, lane: usize, freed: u32, until_q16: u32, plane: &mut BitGrid) {
    let Some(made) = enter(bundle, lane, plane) else { return };
    let crossings: u32 = made.iter().sum();
    if crossings >= freed {
        return;
    }
    let ray = bundle.march(lane, made);
    let (min, end) = (plane.window().min, plane.window().end());
    let room: [u32; 3] = std::array::from_fn(|r| {
        (if ray.step[r] < 0 { ray.cell[r] - min[r] } else { end[r] - 1 - ray.cell[r] }) as u32
    });
    let last = leap::exit(ray.next_q16, ray.period_q16, room);
    let last = last.min(Key { t_q16: until_q16, axis: 3 });
    let d = |r: usize| bundle.dir_q16[r][lane].unsigned_abs();
    // The crossing that leaves is made, too, and leads to a cell that is not marked.
    let more: u32 = (0..3)
        .map(|r| {
            leap::made_at(ray.next_q16[r], ray.period_q16[r], d(r), r as u32, last.t_q16, last.axis.min(2))
        })
        .sum();
    let inside = if last.axis == 3 { more + 1 } else { more };
    mark(plane, &ray, inside.min(freed - crossings));
}

/// Marks the cell that a ray is in and those that follow, so many in all.
fn mark(plane: &mut BitGrid, ray: &march::March, cells: u32) {
    let row = plane.words_per_row() as i32 * 32;
    let layer = row * plane.window().size[1] as i32;
    let [sx, sy, sz] = [ray.step[0], ray.step[1] * row, ray.step[2] * layer];
    let from = plane.window().min;
    let mut bit = (ray.cell[0] - from[0]) + (ray.cell[1] - from[1]) * row + (ray.cell[2] - from[2]) * layer;
    let [mut x, mut y, mut z] = ray.next_q16;
    let [px, py, pz] = ray.period_q16;
    let words = plane.words_mut();
    for cell in 0..cells {
        words[bit as usize >> 5] |= 1 << (bit & 31);
        if cell + 1 == cells {
            break;
        }
        // Selections instead of branches or of an index: which axis comes next is close to random.
        let is_x = x <= y && x <= z;
        let is_y = !is_x && y <= z;
        let is_z = !is_x && !is_y;
        bit += if is_x {
            sx
        } else if is_y {
            sy
        } else {
            sz
        };
        x += if is_x { px } else { 0 };
        y += if is_y { py } else { 0 };
        z += if is_z { pz } else { 0 };
    }
}

/// The crossings made when a ray has entered the window on every axis; `None` if it is past it by then, or never comes.
fn enter(bundle: &Bundle, lane: usize, plane: &BitGrid) -> Option<[u32; 3]> {
    let (min, end) = (plane.window().min, plane.window().end());
    let mut entered: Option<Key> = None;
    for r in 0..3 {
        let (cell, step) = (bundle.cell[r], bundle.dir_q16[r][lane].signum());
        let away = if cell < min[r] { min[r] - cell } else { (cell - (end[r] - 1)).max(0) };
        if away > 0 {
            let towards = if cell < min[r] { 1 } else { -1 };
            if step != towards {
                return None;
            }
            let (first, period) = (bundle.first_q16[r][lane], bundle.period_q16[r][lane]);
            let t_q16 = march::crossing_q16(first, period, away as u32 - 1);
            entered = entered.max(Some(Key { t_q16, axis: r as u32 }));
        }
    }
    let Some(Key { t_q16, axis }) = entered else { return Some([0; 3]) };
    if t_q16 == NEVER {
        return None;
    }
    let made = std::array::from_fn(|r| {
        let d = bundle.dir_q16[r][lane].unsigned_abs();
        leap::made_at(bundle.first_q16[r][lane], bundle.period_q16[r][lane], d, r as u32, t_q16, axis)
    });
    let inside = (0..3).all(|r| {
        let cell = bundle.cell[r] + bundle.dir_q16[r][lane].signum() * made[r] as i32;
        cell >= min[r] && cell < end[r]
    });
    inside.then_some(made)
}

/// Whether a ray passes through the window at all.
pub(super) fn meets(bundle: &Bundle, lane: usize, plane: &BitGrid) -> bool {
    enter(bundle, lane, plane).is_some()
}
