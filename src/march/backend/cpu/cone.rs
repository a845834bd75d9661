//! How far all rays of a camera's tile travel through nothing: a cone around the tile is pushed through empty
//! boxes, and every ray starts where it stops. `first_hit` finds what they hit from there on.
//!
//! # Theory
//! A ray of integers deviates from the ideal one by no more than `march::deviation` says. The cone holds all
//! ideal rays of the tile and is grown by that, so while the cone stays in boxes without blockers, no ray of
//! the tile has entered a blocker. Floats decide only how far that is proved, with room to spare; the ray
//! itself lands by counting crossings (`leap`).
//!
//! # Practice
//! For the tiles of cameras. The rays of a LIDAR's packet are too far apart.

use super::first_hit::Search;
use super::packet::{Packets, RAYS};
use crate::backend::GridPose;
use crate::march::deviation;
use crate::voxel::Window;

/// The cone of a tile in the sensor's frame: rays of length 1 end within `spread` of `middle`.
#[derive(Clone, Copy)]
pub(super) struct Cone {
    middle: [f32; 3],
    spread: f32,
}

/// A gain of fewer voxels is not worth another look.
const LEAST_GAIN: f32 = 1.0;

/// How far before the place where a cone touches what may be a blocker it is said to be clear. There, its rays are surely
/// before the layer that they are about to enter (`across`).
const SHORT: f32 = 0.25;

/// How far a ray of integers may be from the ideal one, in voxels.
pub(super) fn deviation(t: f32) -> f32 {
    DEVIATION_PER_VOXEL * t + deviation::FIXED as f32
}

/// What the deviation grows by along a ray.
const DEVIATION_PER_VOXEL: f32 = deviation::PER_VOXEL as f32;

impl Cone {
    /// The cone of some packets.
    pub(super) fn new(packets: &Packets, own: &[usize]) -> Cone {
        let dirs = || {
            let all = own.iter().map(|&packet| packets.dirs_q15(packet));
            all.flat_map(|dirs| (0..RAYS).map(|lane| dirs.each_ref().map(|dirs| dirs[lane])))
        };
        let lanes = (own.len() * RAYS) as f32;
        let mean = |a: usize| dirs().map(|dir| i64::from(dir[a])).sum::<i64>() as f32 / (lanes * 32_768.0);
        let middle = [mean(0), mean(1), mean(2)];
        let apart = |dir: [i32; 3]| -> f32 {
            let away = (0..3).map(|a| dir[a] as f32 / 32_768.0 - middle[a]);
            away.map(|x| x * x).sum::<f32>().sqrt()
        };
        let spread = dirs().map(apart).fold(0.0, f32::max);
        Cone { middle, spread: spread * 1.001 + 1e-5 }
    }

    /// The cone sent from a placement.
    pub(super) fn place(&self, from: &GridPose) -> ConeAtPose {
        let along: [f32; 3] =
            from.axis_q15.map(|row| (0..3).map(|a| row[a] as f32 / 32_768.0 * self.middle[a]).sum());
        let origin = from.origin_q16.map(|x| x as f32 / 65_536.0);
        ConeAtPose { origin, along, spread: self.spread, square: along.iter().map(|x| x * x).sum() }
    }
}

/// A cone in the grid.
pub(super) struct ConeAtPose {
    origin: [f32; 3],
    along: [f32; 3],
    spread: f32,
    /// The square of the length of `along`.
    square: f32,
}

impl ConeAtPose {
    /// Where its middle is at a distance.
    fn position(&self, t: f32) -> [f32; 3] {
        std::array::from_fn(|r| self.origin[r] + self.along[r] * t)
    }

    /// How far from its middle a ray of integers may be at a distance.
    fn radius(&self, t: f32) -> f32 {
        t * self.spread + deviation(t)
    }

    /// How far its rays have surely entered no blocker, in voxels along each, that have entered none up to `from`.
    pub(super) fn clear(&self, search: &Search, from: f32) -> f32 {
        let layer = search.layer;
        let size = layer.blockers.window().size;
        let growth = self.spread + DEVIATION_PER_VOXEL;
        let mut t = from;
        loop {
            let at = self.position(t);
            let voxel = at.map(floor);
            if (0..3).any(|r| voxel[r] as u32 >= size[r]) {
                break;
            }
            let known = if t == 0.0 { Some(*search.clearing()) } else { layer.empty_box(voxel) };
            let Some([low, high]) = known else { break };
            let radius = self.radius(t);
            let mut gain = f32::MAX;
            for r in 0..3 {
                let to_low = at[r] - low[r] as f32 - radius;
                let to_high = high[r] as f32 - at[r] - radius;
                if to_low < 0.0 || to_high < 0.0 {
                    gain = 0.0;
                }
                gain = gain
                    .min(to_low / (growth - self.along[r]).max(1e-6))
                    .min(to_high / (growth + self.along[r]).max(1e-6));
            }
            if gain < LEAST_GAIN {
                break;
            }
            t += gain;
        }
        (t - SHORT).max(from)
    }

    /// The voxels in which any of its rays may be from one distance to another; they may lie outside the
    /// grid.
    pub(super) fn section(&self, from: f32, to: f32) -> Window {
        let (a, b, radius) = (self.position(from), self.position(to), self.radius(to));
        let low = std::array::from_fn(|r| floor(a[r].min(b[r]) - radius));
        let high = std::array::from_fn(|r| floor(a[r].max(b[r]) + radius));
        Window::from_corners(low, high)
    }

    /// The layers of voxels across an axis that all its rays enter between two distances, having been before them, and whether
    /// that is upwards.
    pub(super) fn layers(&self, r: usize, from: f32, to: f32) -> (impl Iterator<Item = i32> + use<>, bool) {
        let (at, on, is_up) = (self.position(from)[r], self.position(to)[r], self.along[r] > 0.0);
        let (before, behind) = (self.radius(from), self.radius(to));
        // The lowest and the highest of them.
        let (low, high) = if is_up {
            (floor(at + before) + 1, floor(on - behind))
        } else {
            (floor(on + behind), floor(at - before) - 1)
        };
        let layers = (high - low + 1).max(0);
        ((0..layers).map(move |n| if is_up { low + n } else { high - n }), is_up)
    }

    /// Says of voxels whether any of its rays may be in them before a distance.
    #[inline]
    pub(super) fn touches(&self, to: f32) -> impl Fn([i32; 3]) -> bool {
        // Half the diagonal of a voxel, and a little.
        let reach = self.radius(to) + 0.88;
        // Rays so far apart that their middle says nothing: a tile with all of a very wide image.
        let is_wide = self.square < 0.25;
        let (inverse, square) = (1.0 / self.square.max(0.25), reach * reach);
        let (origin, along) = (self.origin.map(|x| x - 0.5), self.along);
        let dot = |a: &[f32; 3], b: &[f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        move |voxel| {
            let away: [f32; 3] = std::array::from_fn(|r| voxel[r] as f32 - origin[r]);
            let t = dot(&away, &along) * inverse;
            let off: [f32; 3] = std::array::from_fn(|r| away[r] - along[r] * t);
            is_wide || dot(&off, &off) <= square
        }
    }
}

/// ⌊x⌋ of a coordinate in a grid, without a function call; within 1/128 below a whole number it may be that
/// number. The deviation used here has more to spare than that.
fn floor(x: f32) -> i32 {
    const BEYOND: i32 = 1 << 16;
    (x + BEYOND as f32) as i32 - BEYOND
}
