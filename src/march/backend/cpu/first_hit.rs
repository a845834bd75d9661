//! What a ray hits first, before range and noise are applied: it leaps through empty boxes and steps
//! elsewhere.
//!
//! # Theory
//! A leap makes all crossings inside a box without blockers at once, and the one that leaves the box
//! (`leap`); every voxel that is skipped is empty, so the first blocker is the one that single steps would
//! find. Outside of the box that holds all blockers there are none. The first blocker in the union of two layers is the
//! earlier of their first blockers, so a hit known in one layer ends the search in the other.
//!
//! # Practice
//! Used for every ray of every table. Where the nearest blocker is in the next brick, stepping is as quick.

use std::cell::OnceCell;

use crate::march::MAX_RANGE_VOXELS;
use crate::march::leap::{self, RayAxis};
use crate::voxel::{BitGrid, Bricks, Window};

/// Blockers, and where there are none.
#[derive(Debug)]
pub(super) struct Layer {
    pub(super) blockers: BitGrid,
    pub(super) bricks: Bricks,
    /// The smallest box that holds all blockers; one that no ray comes to, if there are none.
    bounds: Box3,
}

impl Layer {
    pub(super) fn new(blockers: BitGrid) -> Self {
        let bounds = blockers.bounds();
        Layer { bricks: Bricks::new(&blockers), bounds: [bounds.min, bounds.end()], blockers }
    }
}

/// Voxels from the lowest to after the highest on each axis.
pub(super) type Box3 = [[i32; 3]; 2];

/// How far the empty box around a sensor may reach: far enough to get away from the wall that the sensor
/// hangs on.
const CLEARING: i32 = 32;

impl Layer {
    /// A box without blockers around a voxel of the grid, whatever is in the voxel itself: the box that its brick knows, grown
    /// on all sides in turn until something is in the way. Sensors hang on walls, where bricks say little.
    pub(super) fn clearing(&self, voxel: [i32; 3]) -> Box3 {
        let size = self.blockers.window().size.map(|n| n as i32);
        let own = || [voxel, voxel.map(|x| x + 1)];
        let [mut low, mut high] = self.empty_box(voxel).unwrap_or_else(own);
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
                let inside = from[r] >= 0 && to[r] <= size[r] && (from[r] - voxel[r]).abs() <= CLEARING;
                let slab = Window::from_corners(from, to.map(|x| x - 1));
                if inside && !self.blockers.any_in(&slab) {
                    low[r] = low[r].min(from[r]);
                    high[r] = high[r].max(to[r]);
                    growing = true;
                }
            }
        }
        [low, high]
    }

    /// The box without blockers that the bricks know around a voxel, if its own brick holds none; cut to the
    /// grid.
    pub(super) fn empty_box(&self, voxel: [i32; 3]) -> Option<Box3> {
        let reach = self.bricks.reach_at(voxel);
        (reach > 0).then(|| self.box_of(voxel, reach))
    }

    #[inline]
    fn box_of(&self, voxel: [i32; 3], reach: u32) -> Box3 {
        let edge = Bricks::EDGE as i32;
        let own = voxel.map(|x| x >> Bricks::EDGE_LOG2);
        let more = reach as i32 - 1;
        let size = self.blockers.window().size;
        let high = std::array::from_fn(|r| ((own[r] + 1 + more) * edge).min(size[r] as i32));
        [own.map(|b| ((b - more) * edge).max(0)), high]
    }
}

/// How a ray's search ended, in one word that orders by distance: a hit is its distance · 4 + axis of its
/// crossing.
pub(super) type FirstHit = u32;

/// The ray left the grid.
pub(super) const LEFT: FirstHit = u32::MAX - 2;
/// The ray came to the end of its range.
pub(super) const NOTHING: FirstHit = u32::MAX - 1;
/// The ray was not searched.
pub(super) const UNKNOWN: FirstHit = u32::MAX;

/// A crossing: its distance and axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct NextCrossing {
    pub(super) t_q16: u32,
    pub(super) axis: u32,
}

/// The crossing of a hit.
pub(super) fn crossing(hit: FirstHit) -> NextCrossing {
    NextCrossing { t_q16: hit >> 2, axis: hit & 3 }
}

/// No hit is later: it allows for the longest range and for noise behind it.
pub(super) const LAST: FirstHit = range((2 * MAX_RANGE_VOXELS) << 16);

/// The range as a first hit: no crossing within it is later.
pub(super) const fn range(range_max_q16: u32) -> FirstHit {
    range_max_q16 << 2 | 3
}

/// A ray on its way.
#[derive(Clone, Copy)]
pub(super) struct LeapingRay {
    pub(super) voxel: [i32; 3],
    pub(super) axes: [RayAxis; 3],
    /// Magnitude of the direction's components, Q16.
    pub(super) d: [u32; 3],
}

/// A search in a layer.
pub(super) struct Search<'a> {
    pub(super) layer: &'a Layer,
    /// Blockers entered earlier are none.
    pub(super) ignore_q16: u32,
    /// The sensor's voxel, and an empty box around it once that is asked for.
    pub(super) voxel: [i32; 3],
    pub(super) clearing: OnceCell<Box3>,
}

/// Steps between two looks at the bricks.
const STEPS: usize = 8;

impl<'a> Search<'a> {
    /// From a sensor in a voxel of the grid.
    pub(super) fn new(layer: &'a Layer, ignore_q16: u32, voxel: [i32; 3]) -> Self {
        Search { layer, ignore_q16, voxel, clearing: OnceCell::new() }
    }

    /// A box around the sensor in which there is nothing.
    pub(super) fn clearing(&self) -> &Box3 {
        self.clearing.get_or_init(|| self.layer.clearing(self.voxel))
    }

    /// Searches from where a ray is, in a voxel that needs no test: at its start, or behind it in an empty
    /// box. A ray that comes to `limit` has the hit `otherwise`.
    #[inline]
    pub(super) fn first_hit(
        &self,
        mut ray: LeapingRay,
        starts: bool,
        limit: FirstHit,
        otherwise: FirstHit,
    ) -> FirstHit {
        let size = self.layer.blockers.window().size;
        let exit = ray.leaves(&[[0; 3], size.map(|n| n as i32)]);
        let past = || if exit < u64::from(limit) { LEFT } else { otherwise };
        let Some([enters, leaves]) = ray.span(&self.layer.bounds) else { return past() };
        let end = exit.min(limit.into()).min(leaves);
        if enters >= end {
            return past();
        }
        if enters > 0 {
            ray.advance(enters);
            if self.stops(&ray, enters) {
                return enters as FirstHit;
            }
        } else if starts {
            match ray.leap(self.clearing(), end) {
                None => return past(),
                Some(entered) if self.stops(&ray, entered) => return entered as FirstHit,
                Some(_) => {}
            }
        }
        loop {
            loop {
                let reach = self.layer.bricks.reach_at(ray.voxel);
                if reach < 2 {
                    break;
                }
                match ray.leap(&self.layer.box_of(ray.voxel, reach), end) {
                    None => return past(),
                    Some(entered) if self.stops(&ray, entered) => return entered as FirstHit,
                    Some(_) => {}
                }
            }
            match self.step(&mut ray, end) {
                Stepped::Past => return past(),
                Stepped::Entered(at) => return at,
                Stepped::On => {}
            }
        }
    }

    /// Whether the voxel that a ray has just entered stops it.
    #[inline]
    fn stops(&self, ray: &LeapingRay, entered: u64) -> bool {
        let [_, row, layer] = self.strides();
        let bit = (ray.voxel[0] + ray.voxel[1] * row + ray.voxel[2] * layer) as usize;
        self.layer.blockers.words()[bit >> 5] >> (bit & 31) & 1 == 1 && entered >> 2 >= self.ignore_q16.into()
    }

    fn strides(&self) -> [i32; 3] {
        let row = self.layer.blockers.words_per_row() as i32 * 32;
        [1, row, row * self.layer.blockers.window().size[1] as i32]
    }

    /// Makes some steps.
    #[inline]
    fn step(&self, ray: &mut LeapingRay, end: u64) -> Stepped {
        let words = self.layer.blockers.words();
        let strides = self.strides();
        let stride: [i64; 3] = std::array::from_fn(|r| ray.axes[r].step * i64::from(strides[r]));
        let period: [u64; 3] = ray.axes.map(|axis| 4 * u64::from(axis.period_q16));
        let mut bit = (0..3).map(|r| i64::from(ray.voxel[r] * strides[r])).sum::<i64>();
        for _ in 0..STEPS {
            let [x, y, z] = ray.axes.map(|axis| axis.next);
            let nearest = x.min(y).min(z);
            if nearest >= end {
                return Stepped::Past;
            }
            for r in 0..3 {
                // A processor cannot predict which axis is crossed, so nothing branches on it.
                let crossed = ray.axes[r].next == nearest;
                ray.axes[r].next += if crossed { period[r] } else { 0 };
                bit += if crossed { stride[r] } else { 0 };
            }
            if words[bit as usize >> 5] >> (bit & 31) & 1 == 1 && nearest >> 2 >= self.ignore_q16.into() {
                return Stepped::Entered(nearest as FirstHit);
            }
        }
        let (bit, row, layer) = (bit as u32, strides[1] as u32, strides[2] as u32);
        ray.voxel = [bit % layer % row, bit % layer / row, bit / layer].map(|x| x as i32);
        Stepped::On
    }
}

/// What became of some steps.
enum Stepped {
    /// The next crossing is `end` or later.
    Past,
    /// A blocker was entered.
    Entered(FirstHit),
    /// Nothing yet.
    On,
}

impl LeapingRay {
    /// The first crossing that leaves a box which holds the ray.
    #[inline]
    fn leaves(&self, [low, high]: &Box3) -> u64 {
        let leaves = |r: usize| self.axes[r].leaves(low[r] - self.voxel[r], high[r] - 1 - self.voxel[r]);
        leaves(0).min(leaves(1)).min(leaves(2))
    }

    /// The crossings by which it enters and leaves a box (see [`leap::span`]).
    #[inline]
    fn span(&self, [low, high]: &Box3) -> Option<[u64; 2]> {
        let low = std::array::from_fn(|r| low[r] - self.voxel[r]);
        let high = std::array::from_fn(|r| high[r] - 1 - self.voxel[r]);
        leap::span(|r| self.axes[r], low, high)
    }

    /// Leaves an empty box by the first crossing that does; which that was, unless it is `end` or later.
    #[inline]
    fn leap(&mut self, empty: &Box3, end: u64) -> Option<u64> {
        let exit = self.leaves(empty);
        (exit < end).then(|| {
            self.advance(exit);
            exit
        })
    }

    /// Makes all crossings up to one of them.
    #[inline]
    fn advance(&mut self, last: u64) {
        for r in 0..3 {
            let axis = &mut self.axes[r];
            if axis.next <= last {
                // The shift rounds down, so that a crossing at the last one's own distance counts only if its
                // axis does not come after the last one's.
                let apart = ((last - axis.next) >> 2) as u32;
                let made = leap::periods_in(apart, axis.period_q16, self.d[r]) + 1;
                self.voxel[r] += axis.step as i32 * made as i32;
                axis.next = axis.crossing(made);
            }
        }
    }
}
