//! Where boxes of voxels are in a camera's image: conservative rectangles of pixels, in floats. A rectangle only says where to
//! look; what is seen there is decided in integers elsewhere.
//!
//! # Theory
//! The ideal rays that cross a box go through the pixels that the box projects to. Rays of integers stray from them
//! (`beam::stray`), so the box is grown by that first. Depth and width of a box are bounded one by one, which makes the
//! rectangle larger than need be, never smaller.

use super::beam::stray;
use super::pyramid::Rect;
use crate::backend::{Image, Placement};

/// Pixels on an axis beyond which a voxel is too near to be looked at from there.
const WIDEST_VOXEL_PX: f32 = 96.0;

/// A camera at a placement.
pub(super) struct View {
    origin: [f32; 3],
    /// Rows of sensor_from_grid, and their absolute values.
    axes: [[f32; 3]; 3],
    spans: [f32; 3],
    focal_px: [f32; 2],
    middle_px: [f32; 2],
    last_px: [f32; 2],
    /// Depth in voxels up to which voxels are near.
    near: f32,
    /// Half the diagonal of a pixel at depth 1.
    half_pixel: f32,
}

/// A box as a camera sees it.
pub(super) enum Sight {
    /// No ray visits any of its voxels.
    Unseen,
    /// Some of it is so near that pixels say little.
    Near(Rect),
    /// Only rays of these pixels visit it. `dense` says that each of its voxels is surely visited by one of them.
    At {
        /// The pixels.
        rect: Rect,
        /// Whether pixels are so close at its depth, and it so far inside the image, that no voxel slips through.
        dense: bool,
    },
}

impl View {
    pub(super) fn new(placement: &Placement, image: &Image) -> View {
        let axes: [[f32; 3]; 3] =
            std::array::from_fn(|a| std::array::from_fn(|r| placement.axis_q15[r][a] as f32 / 32_768.0));
        let focal_px = image.focal_px.map(|f| f as f32);
        View {
            origin: placement.origin_q16.map(|x| x as f32 / 65_536.0),
            axes,
            spans: axes.map(|axis| axis.iter().map(|x| x.abs()).sum()),
            focal_px,
            middle_px: image.size_px.map(|n| n as f32 / 2.0 - 0.5),
            last_px: image.size_px.map(|n| n as f32 - 1.0),
            near: 1.8 * focal_px[0].max(focal_px[1]) / WIDEST_VOXEL_PX,
            half_pixel: 0.5 * (focal_px[0].powi(-2) + focal_px[1].powi(-2)).sqrt(),
        }
    }

    /// A point of the grid in the sensor's frame.
    #[inline]
    fn point(&self, at: [f32; 3]) -> [f32; 3] {
        let from = [at[0] - self.origin[0], at[1] - self.origin[1], at[2] - self.origin[2]];
        self.axes.map(|axis| axis[0] * from[0] + axis[1] * from[1] + axis[2] * from[2])
    }

    /// The pixels that may see a cube of `edge` voxels from `corner` on.
    #[inline]
    pub(super) fn sight(&self, corner: [i32; 3], edge: i32) -> Sight {
        let half = edge as f32 * 0.5;
        let [x, y, z] = self.point(corner.map(|c| c as f32 + half));
        // No farther than that from the sensor.
        let grown = stray(x.abs() + y.abs() + z.abs() + 3.0 * half);
        let deep = half * self.spans[2] + grown;
        let (near, far) = (z - deep, z + deep);
        if far <= 0.0 {
            return Sight::Unseen;
        }
        let (mut first, mut last) = ([0; 2], [0; 2]);
        let mut whole = true;
        for (a, middle) in [x, y].into_iter().enumerate() {
            let wide = half * self.spans[a] + grown;
            let (low, high) = (middle - wide, middle + wide);
            // The slope of an edge is steepest where the box is nearest, or farthest if it goes the other way.
            let low = if low >= 0.0 {
                low / far
            } else if near > 0.0 {
                low / near
            } else {
                f32::NEG_INFINITY
            };
            let high = if high <= 0.0 {
                high / far
            } else if near > 0.0 {
                high / near
            } else {
                f32::INFINITY
            };
            let low = (self.focal_px[a] * low + self.middle_px[a]).ceil();
            let high = (self.focal_px[a] * high + self.middle_px[a]).floor();
            whole &= low >= 0.0 && high <= self.last_px[a];
            let (low, high) = (low.max(0.0), high.min(self.last_px[a]));
            if low > high {
                return Sight::Unseen;
            }
            (first[a], last[a]) = (low as u32, high as u32);
        }
        let rect = Rect { first, last };
        if near <= self.near {
            return Sight::Near(rect);
        }
        // The ray through the nearest pixel passes within half a voxel of a voxel's centre, so it crosses the voxel.
        let dense = whole && self.half_pixel * far + grown <= 0.5;
        Sight::At { rect, dense }
    }

    /// The pixel through the centre of a voxel, or the nearest of a rectangle.
    #[inline]
    pub(super) fn centre(&self, cell: [i32; 3], rect: &Rect) -> [u32; 2] {
        let [x, y, z] = self.point(cell.map(|c| c as f32 + 0.5));
        let at = |a: usize, x: f32| {
            let pixel = self.focal_px[a] * x / z + self.middle_px[a];
            (pixel.round() as u32).clamp(rect.first[a], rect.last[a])
        };
        [at(0, x), at(1, y)]
    }

    /// Distance along any ray after which no near voxel is entered, in 1/65536 voxels.
    pub(super) fn near_q16(&self) -> u32 {
        // The steepest ray goes through a corner of the image.
        let slope = |a: usize| (self.middle_px[a] + 1.0) / self.focal_px[a];
        let depth = self.near + 2.0 * (0.5 * self.spans[2] + 0.5);
        let t = depth * (1.0 + slope(0).powi(2) + slope(1).powi(2)).sqrt();
        ((t + 2.0 * stray(t) + 1.0) * 65_536.0).min(f32::from(u16::MAX) * 32_768.0) as u32
    }
}
