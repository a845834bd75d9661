//! Which voxels a camera proves free, decided voxel by voxel and whole boxes at a time from the image of how
//! many cells each pixel frees.
//!
//! # Theory
//! A ray has made as many crossings on reaching a voxel as the voxel is away from the sensor's cell, counted
//! along the axes (`SEMANTICS.md`, "Rays"), whatever the ray. So a voxel is free if and only if some ray that
//! visits it frees more cells than that: one witness is enough, and whether a ray visits a voxel is a matter
//! of six crossings. If no pixel that could see a box frees more than its nearest voxel needs, nothing of it
//! is free; if all free more than its farthest needs, and no voxel slips between the pixels, all of it is.
//!
//! # Practice
//! For cameras, whose free voxels are each visited by hundreds of rays. Most boxes are decided whole; pixels
//! are looked at along silhouettes only.

use fearless_simd::Level;

use super::bundle::{self, Bundles};
use super::plan::Wanted;
use super::pyramid::{Pyramid, Rect};
use super::view::{BOXES, Sight, View};
use crate::backend::Placement;
use crate::march;
use crate::voxel::BitGrid;

/// What boxes are decided from.
pub(super) struct Gather<'a> {
    pub(super) level: Level,
    pub(super) view: &'a View,
    pub(super) bundles: &'a Bundles,
    pub(super) placement: &'a Placement,
    pub(super) pyramid: &'a Pyramid,
    /// Voxels that matter.
    pub(super) wanted: &'a Wanted,
}

impl Gather<'_> {
    /// Marks what is free of a box of voxels, as the camera sees it; near voxels are left alone.
    pub(super) fn decide(&self, corner: [i32; 3], edge: i32, sight: &Sight, free: &mut BitGrid) {
        if !sight.near {
            let [nearest, farthest] = self.away(corner, edge);
            let [least, most] = self.pyramid.range(&sight.rect);
            if most <= nearest {
                return;
            }
            if sight.dense && least > farthest {
                fill(free, corner, edge);
                return;
            }
            if edge == 1 {
                if self.is_free(corner, nearest, &sight.rect) {
                    free.set(corner);
                }
                return;
            }
        }
        if edge == 1 {
            return;
        }
        let half = edge / 2;
        let corners: [[i32; 3]; BOXES] =
            std::array::from_fn(|part| std::array::from_fn(|r| corner[r] + (part as i32 >> r & 1) * half));
        let sights = self.view.sights(self.level, &corners, half, &sight.rect);
        for (part, &corner) in corners.iter().enumerate() {
            if let Some(sight) = sights.of(part).filter(|_| half > 1 || self.wanted.cells.get(corner)) {
                self.decide(corner, half, &sight, free);
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
        // Block by block, so that what is wholly hidden costs one look.
        for block in self.pyramid.blocks(rect) {
            if self.pyramid.most(&block) <= away {
                continue;
            }
            for v in block.first[1]..=block.last[1] {
                let row = self.pyramid.row(v, block.first[0], block.last[0]);
                for (u, &freed) in (block.first[0]..).zip(row) {
                    if u32::from(freed) > away && self.visits([u, v], cell) {
                        return true;
                    }
                }
            }
        }
        false
    }

    /// Whether a pixel's ray visits a voxel, were nothing in its way.
    #[inline]
    fn visits(&self, pixel: [u32; 2], cell: [i32; 3]) -> bool {
        let dir_q15 = self.bundles.of_pixel(pixel);
        // Crossings in order are numbers, distance · 4 + axis.
        let (mut enters, mut leaves) = (0, u64::MAX);
        for r in 0..3 {
            let dir_q16 = march::direction_q16(self.placement.axis_q15[r], dir_q15);
            let away = cell[r] - (self.placement.origin_q16[r] >> 16);
            let d = dir_q16.unsigned_abs();
            let frac = (self.placement.origin_q16[r] & 0xffff) as u32;
            let ahead = if dir_q16 < 0 { frac } else { (1 << 16) - frac };
            let period_q16 = bundle::period_q16(d);
            let first_q16 = if d == 0 { march::NEVER } else { march::first_q16(ahead, period_q16) };
            let period = 4 * u64::from(period_q16);
            let last = 4 * u64::from(first_q16) + r as u64 + u64::from(away.unsigned_abs()) * period;
            leaves = leaves.min(last);
            if away != 0 {
                enters = enters.max(last - period);
                if away.signum() != dir_q16.signum() {
                    return false;
                }
            }
            if enters >= leaves {
                return false;
            }
        }
        true
    }
}

/// Sets all voxels of a box that lie in the window.
fn fill(plane: &mut BitGrid, corner: [i32; 3], edge: i32) {
    for z in corner[2]..corner[2] + edge {
        for y in corner[1]..corner[1] + edge {
            plane.set_run(corner[0], corner[0] + edge, y, z);
        }
    }
}
