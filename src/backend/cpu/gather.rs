//! Which voxels a camera proves free, decided voxel by voxel and whole boxes at a time from the image of how many cells each
//! pixel frees. The image is made by `cast`.
//!
//! # Theory
//! A ray has made as many crossings on reaching a voxel as the voxel is away from the sensor's cell, counted along the axes
//! (`SEMANTICS.md`, "A ray, in integers"), whatever the ray. So a voxel is free if and only if some ray that visits it frees more
//! cells than that: one witness is enough, and whether a ray visits a voxel is a matter of six crossings. If no pixel that
//! could see a box frees more than its nearest voxel needs, nothing of it is free; if all free more than its farthest
//! needs, and no voxel slips between the pixels, all of it is.
//!
//! # Practice
//! For cameras, whose free voxels are each visited by hundreds of rays. Most boxes are decided whole; pixels are looked at
//! along silhouettes only.

use super::bundle::Bundles;
use super::plan::Wanted;
use super::pyramid::{Pyramid, Rect};
use super::view::{Sight, View};
use crate::backend::Placement;
use crate::march::{self, leap};
use crate::voxel::BitGrid;

/// Edge of the largest boxes in voxels; a row of one lies in one word of a plane.
pub(super) const LARGEST: i32 = 8;

/// What boxes are decided from.
pub(super) struct Gather<'a> {
    pub(super) view: &'a View,
    pub(super) bundles: &'a Bundles,
    pub(super) placement: &'a Placement,
    pub(super) pyramid: &'a Pyramid,
    /// Voxels that matter.
    pub(super) wanted: &'a Wanted,
}

impl Gather<'_> {
    /// Marks what is free of a box of voxels; near voxels are left alone.
    pub(super) fn decide(&self, corner: [i32; 3], edge: i32, parent: &Rect, free: &mut BitGrid) {
        let near = match self.view.sight(corner, edge) {
            Sight::Unseen => return,
            Sight::Near(rect) => cut(&rect, parent).map(|rect| (rect, false, true)),
            Sight::At { rect, dense } => cut(&rect, parent).map(|rect| (rect, dense, false)),
        };
        let Some((rect, dense, near)) = near else { return };
        if near && edge == 1 {
            return;
        }
        if !near {
            let [nearest, farthest] = self.away(corner, edge);
            let [least, most] = self.pyramid.range(&rect);
            if most <= nearest {
                return;
            }
            if dense && least > farthest {
                fill(free, corner, edge);
                return;
            }
            if edge == 1 {
                if self.is_free(corner, nearest, &rect) {
                    free.set(corner);
                }
                return;
            }
        }
        let half = edge / 2;
        for part in 0..8 {
            let corner = std::array::from_fn(|r| corner[r] + (part >> r & 1) * half);
            if half > 1 || self.wanted.cells.get(corner) {
                self.decide(corner, half, &rect, free);
            }
        }
    }

    /// Voxel boundaries between the sensor's cell and the nearest and farthest voxel of a box.
    #[inline]
    fn away(&self, corner: [i32; 3], edge: i32) -> [u32; 2] {
        let (mut nearest, mut farthest) = (0, 0);
        for r in 0..3 {
            let own = self.placement.origin_q16[r] >> 16;
            let (low, high) = (corner[r] - own, corner[r] + edge - 1 - own);
            nearest += low.max(-high).max(0);
            farthest += high.max(-low);
        }
        [nearest as u32, farthest as u32]
    }

    /// Whether a pixel of a rectangle sees a voxel and frees more than `away` cells.
    fn is_free(&self, cell: [i32; 3], away: u32, rect: &Rect) -> bool {
        let centre = self.view.centre(cell, rect);
        if self.pyramid.get(centre) > away && self.visits(centre, cell) {
            return true;
        }
        for v in rect.first[1]..=rect.last[1] {
            let row = self.pyramid.row(v, rect.first[0], rect.last[0]);
            for (u, &freed) in (rect.first[0]..).zip(row) {
                if u32::from(freed) > away && self.visits([u, v], cell) {
                    return true;
                }
            }
        }
        false
    }

    /// Whether a pixel's ray visits a voxel, were nothing in its way.
    #[inline]
    fn visits(&self, pixel: [u32; 2], cell: [i32; 3]) -> bool {
        let dir_q15 = self.bundles.of_pixel(pixel);
        let (mut first_q16, mut period_q16, mut ahead) = ([0; 3], [0; 3], [0; 3]);
        for r in 0..3 {
            let dir_q16 = march::direction_q16(self.placement.axis_q15[r], dir_q15);
            let away = cell[r] - (self.placement.origin_q16[r] >> 16);
            if away != 0 && away.signum() != dir_q16.signum() {
                return false;
            }
            let d = dir_q16.unsigned_abs();
            let frac = (self.placement.origin_q16[r] & 0xffff) as u32;
            ahead[r] = away.unsigned_abs();
            period_q16[r] = march::period_q16(d);
            let f = if dir_q16 < 0 { frac } else { (1 << 16) - frac };
            first_q16[r] = if d == 0 { march::NEVER } else { march::first_q16(f, period_q16[r]) };
        }
        leap::visits(first_q16, period_q16, ahead)
    }
}

/// What two rectangles share.
#[inline]
fn cut(a: &Rect, b: &Rect) -> Option<Rect> {
    let first = std::array::from_fn(|i| a.first[i].max(b.first[i]));
    let last = std::array::from_fn(|i| a.last[i].min(b.last[i]));
    (first[0] <= last[0] && first[1] <= last[1]).then_some(Rect { first, last })
}

/// Sets all voxels of a box that lie in the window.
fn fill(plane: &mut BitGrid, corner: [i32; 3], edge: i32) {
    for z in corner[2]..corner[2] + edge {
        for y in corner[1]..corner[1] + edge {
            plane.set_run(corner[0], corner[0] + edge, y, z);
        }
    }
}
