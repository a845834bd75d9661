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
use crate::voxel::{BitGrid, Bricks, Window};

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

/// Voxels from the lowest to after the highest on each axis.
pub(super) type Box3 = [[i32; 3]; 2];

/// How far a clearing may reach from a sensor: far enough to come away from the wall that it hangs on.
const CLEARING: i32 = 32;

impl Layer {
    /// A box without blockers around a cell, whatever is in the cell itself: grown on all sides in turn until something is in
    /// the way. Sensors hang on walls, where bricks say little.
    pub(super) fn clearing(&self, cell: [i32; 3]) -> Box3 {
        let size = self.blockers.window().size.map(|n| n as i32);
        let [mut low, mut high] = [cell, cell.map(|x| x + 1)];
        let mut growing = true;
        while growing {
            growing = false;
            for side in 0..6 {
                let r = side / 2;
                let (mut from, mut to) = (low, high);
                if side % 2 == 0 {
                    (from[r], to[r]) = (low[r] - 1, low[r]);
                } else {
                    (from[r], to[r]) = (high[r], high[r] + 1);
                }
                let inside = from[r] >= 0 && to[r] <= size[r] && (from[r] - cell[r]).abs() <= CLEARING;
                let slab = Window::between(from, to.map(|x| x - 1));
                if inside && !self.blockers.any_in(&slab) {
                    low[r] = low[r].min(from[r]);
                    high[r] = high[r].max(to[r]);
                    growing = true;
                }
            }
        }
        [low, high]
    }

    /// The box without blockers that the bricks know around a cell, if its own brick holds none; cut to the grid.
    pub(super) fn empty_box(&self, cell: [i32; 3]) -> Option<Box3> {
        let reach = self.bricks.reach_at(cell);
        (reach > 0).then(|| self.box_of(cell, reach))
    }

    #[inline]
    fn box_of(&self, cell: [i32; 3], reach: u32) -> Box3 {
        let edge = Bricks::EDGE as i32;
        let own = cell.map(|x| x >> Bricks::EDGE_LOG2);
        let more = reach as i32 - 1;
        let size = self.blockers.window().size;
        let high = std::array::from_fn(|r| ((own[r] + 1 + more) * edge).min(size[r] as i32));
        [own.map(|b| ((b - more) * edge).max(0)), high]
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

/// A search in a layer.
pub(super) struct Search<'a> {
    pub(super) layer: &'a Layer,
    /// Blockers entered earlier are none.
    pub(super) ignore_q16: u32,
    /// A box around the sensor in which there is nothing.
    pub(super) clearing: Box3,
}

impl Search<'_> {
    /// Searches from where a ray is, in a cell that needs no test: at its start, or behind it in an empty box. A ray that comes
    /// to `limit` strikes what it had struck `otherwise`.
    #[inline]
    pub(super) fn strike(
        &self,
        mut ray: March,
        d: [u32; 3],
        starts: bool,
        limit: Strike,
        otherwise: Strike,
    ) -> Strike {
        let size = self.layer.blockers.window().size;
        let row = self.layer.blockers.words_per_row() as i32 * 32;
        let strides = [1, row, row * size[1] as i32];
        let words = self.layer.blockers.words();
        let limit = crossing(limit);
        let mut key = if starts { leap_out(&mut ray, d, &self.clearing) } else { self.next(&mut ray, d) };
        while key < limit {
            let axis = key.axis as usize;
            march::cross(&mut ray, axis);
            if ray.cell[axis] as u32 >= size[axis] {
                return LEFT;
            }
            let bit = (0..3).map(|r| ray.cell[r] * strides[r]).sum::<i32>() as usize;
            if words[bit >> 5] >> (bit & 31) & 1 == 1 && key.t_q16 >= self.ignore_q16 {
                return key.t_q16 << 2 | key.axis;
            }
            key = self.next(&mut ray, d);
        }
        otherwise
    }

    /// The next crossing that may lead to a blocker, those before it made.
    #[inline]
    fn next(&self, ray: &mut March, d: [u32; 3]) -> Key {
        let reach = self.layer.bricks.reach_at(ray.cell);
        if reach > 1 {
            return leap_out(ray, d, &self.layer.box_of(ray.cell, reach));
        }
        let axis = march::next_axis(ray.next_q16);
        Key { t_q16: ray.next_q16[axis], axis: axis as u32 }
    }
}

/// Makes all crossings before the one that leaves an empty box, and says which that is.
#[inline]
fn leap_out(ray: &mut March, d: [u32; 3], [low, high]: &Box3) -> Key {
    let room = std::array::from_fn(|r| {
        let ahead = if ray.step[r] < 0 { ray.cell[r] - low[r] } else { high[r] - 1 - ray.cell[r] };
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
