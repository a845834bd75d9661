//! What a ray hits first, before any gate: leaps through empty boxes, steps elsewhere. Where it begins and what the hit
//! means is decided elsewhere.
//!
//! # Theory
//! A leap makes all crossings inside a box without blockers at once, and the one that leaves it (`leap`); every cell left
//! out is empty, so the first blocker is the one that single steps would find. Of a union of two layers, the first blocker is
//! the earlier of both, so a hit known in one ends the search in the other.
//!
//! # Practice
//! For every ray of every table. Where the nearest blocker is in the next brick, stepping is as quick.

use crate::march::leap::{self, Key};
use crate::march::{self, March};
use crate::voxel::{BitGrid, Bricks};

/// Blockers, and where there are none.
pub(super) struct Layer {
    pub(super) blockers: BitGrid,
    pub(super) bricks: Bricks,
}

impl Layer {
    pub(super) fn new(blockers: BitGrid) -> Self {
        Layer { bricks: Bricks::new(&blockers), blockers }
    }
}

/// How a ray's search ended, in one word that orders by distance: a hit is its distance · 4 + axis of its crossing.
pub(super) type Strike = u32;

/// The ray left the grid.
pub(super) const LEFT: Strike = u32::MAX - 2;
/// The ray came to the end of its range.
pub(super) const NOTHING: Strike = u32::MAX - 1;
/// Nobody looked.
pub(super) const UNKNOWN: Strike = u32::MAX;

/// The crossing of a hit.
pub(super) fn crossing(hit: Strike) -> Key {
    Key { t_q16: hit >> 2, axis: hit & 3 }
}

/// The range as a strike: no crossing within it is later.
pub(super) fn range(range_max_q16: u32) -> Strike {
    range_max_q16 << 2 | 3
}

/// Searches a layer from where a ray is, in a cell that needs no test. Blockers entered before `ignore_q16` are none. A ray that
/// comes to `limit` strikes what it had struck `otherwise`.
#[inline]
pub(super) fn strike(
    layer: &Layer,
    mut ray: March,
    d: [u32; 3],
    ignore_q16: u32,
    limit: Strike,
    otherwise: Strike,
) -> Strike {
    let size = layer.blockers.window().size;
    let row = layer.blockers.words_per_row() as i32 * 32;
    let strides = [1, row, row * size[1] as i32];
    let words = layer.blockers.words();
    let limit = crossing(limit);
    loop {
        let reach = layer.bricks.reach_at(ray.cell);
        let key = if reach > 1 {
            leap_out(&mut ray, d, size, reach)
        } else {
            let axis = march::next_axis(ray.next_q16);
            Key { t_q16: ray.next_q16[axis], axis: axis as u32 }
        };
        if key >= limit {
            return otherwise;
        }
        let axis = key.axis as usize;
        march::cross(&mut ray, axis);
        if ray.cell[axis] as u32 >= size[axis] {
            return LEFT;
        }
        let bit = (0..3).map(|r| ray.cell[r] * strides[r]).sum::<i32>() as usize;
        if words[bit >> 5] >> (bit & 31) & 1 == 1 && key.t_q16 >= ignore_q16 {
            return key.t_q16 << 2 | key.axis;
        }
    }
}

/// Makes all crossings before the one that leaves the empty box around a cell, and says which that is.
#[inline]
fn leap_out(ray: &mut March, d: [u32; 3], size: [u32; 3], reach: u32) -> Key {
    let (low, high) = empty_box(ray.cell, reach);
    let room = std::array::from_fn(|r| {
        let ahead = if ray.step[r] < 0 {
            ray.cell[r] - low[r].max(0)
        } else {
            high[r].min(size[r] as i32) - 1 - ray.cell[r]
        };
        ahead as u32
    });
    let key = leap::exit(ray.next_q16, ray.period_q16, room);
    for r in 0..3 {
        // The axis of the exit makes what room it has; that needs no division.
        let made = if r as u32 == key.axis {
            room[r]
        } else {
            leap::made_at(ray.next_q16[r], ray.period_q16[r], d[r], r as u32, key.t_q16, key.axis)
        };
        ray.cell[r] += ray.step[r] * made as i32;
        ray.next_q16[r] += made * ray.period_q16[r];
    }
    key
}

/// The voxels of the bricks without blockers around a cell, from the lowest to after the highest; not cut to the grid.
pub(super) fn empty_box(cell: [i32; 3], reach: u32) -> ([i32; 3], [i32; 3]) {
    let edge = Bricks::EDGE as i32;
    let own = cell.map(|x| x >> Bricks::EDGE_LOG2);
    let more = reach as i32 - 1;
    (own.map(|b| (b - more) * edge), own.map(|b| (b + 1 + more) * edge))
}
