//! Which voxels a camera proves free, decided voxel by voxel and whole boxes at a time from the image of how
//! many voxels each pixel frees.
//!
//! # Theory
//! A ray has made as many crossings on reaching a voxel as the voxel is away from the sensor's voxel, counted
//! along the axes (`SEMANTICS.md`, "Rays"), whatever the ray. So a voxel is free if and only if some ray that
//! visits it frees more voxels than that: one witness is enough, and whether a ray visits a voxel is a matter
//! of six crossings. If no pixel that could see a box frees more than its nearest voxel needs, nothing of it
//! is free; if all free more than its farthest needs, and no voxel slips between the pixels, all of it is.
//!
//! # Practice
//! For cameras, whose free voxels are each visited by hundreds of rays. Most boxes are decided whole; pixels
//! are looked at along silhouettes only.

use fearless_simd::{Level, Simd, dispatch};

use super::narrow::{self, NONE, Slab};
use super::packet::{Packets, TILE};
use super::plan::RelevantVoxels;
use super::projection::{BOXES, PixelRect, Projection};
use super::pyramid::{Pyramid, Rect};
use crate::backend::GridPose;
use crate::march;
use crate::march::leap::{self, RayAxis};
use crate::voxel::BitGrid;

/// What boxes are decided from.
pub(super) struct CarveVoxels<'a> {
    pub(super) level: Level,
    /// Whether a row of pixels is asked at once.
    pub(super) wide: bool,
    pub(super) projection: &'a Projection,
    pub(super) packets: &'a Packets,
    pub(super) placement: &'a GridPose,
    pub(super) pyramid: &'a Pyramid,
    /// Voxels that matter.
    pub(super) wanted: &'a RelevantVoxels,
}

impl CarveVoxels<'_> {
    /// Marks what is free of a box of voxels, as the camera sees it; near voxels are left alone.
    pub(super) fn decide(&self, corner: [i32; 3], edge: i32, pixel_rect: &PixelRect, free: &mut BitGrid) {
        if !pixel_rect.near {
            let [nearest, farthest] = self.away(corner, edge);
            let [least, most] = self.pyramid.range(&pixel_rect.rect);
            if most <= nearest {
                return;
            }
            if pixel_rect.dense && least > farthest {
                fill(free, corner, edge);
                return;
            }
            if edge == 1 {
                if self.is_free(corner, nearest, &pixel_rect.rect) {
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
        let pixel_rects = self.projection.pixel_rects(self.level, &corners, half, &pixel_rect.rect);
        for (part, &corner) in corners.iter().enumerate() {
            if let Some(pixel_rect) =
                pixel_rects.of(part).filter(|_| half > 1 || self.wanted.voxels.get(corner))
            {
                self.decide(corner, half, &pixel_rect, free);
            }
        }
    }

    /// Voxel boundaries between the sensor's voxel and the nearest and farthest voxel of a box.
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

    /// Whether a pixel of a rectangle sees a voxel and frees more than `away` voxels.
    fn is_free(&self, voxel: [i32; 3], away: u32, rect: &Rect) -> bool {
        let centre = self.projection.centre(voxel, rect);
        if self.pyramid.get(centre) > away && self.visits(centre, voxel) {
            return true;
        }
        // Block by block, so that what is wholly hidden costs one look; with wide vectors row by row, else pixel by pixel.
        self.pyramid.blocks(rect).filter(|block| self.pyramid.most(block) > away).any(|block| {
            (block.first[1]..=block.last[1]).any(|v| {
                let row = self.pyramid.row(v, block.first[0], block.last[0]);
                let mut enough = (block.first[0]..).zip(row).filter(|(_, freed)| u32::from(**freed) > away);
                match self.wide {
                    true => enough.next().is_some() && self.any_visits([block.first[0], v], row, away, voxel),
                    false => enough.any(|(u, _)| self.visits([u, v], voxel)),
                }
            })
        })
    }

    /// Whether a pixel of a row from `first` on, all of one tile, frees more than `away` voxels and visits a voxel.
    fn any_visits(&self, first: [u32; 2], row: &[u16], away: u32, voxel: [i32; 3]) -> bool {
        let mut freed = [0; TILE as usize];
        let left = (first[0] % TILE) as usize;
        freed[left..left + row.len()].copy_from_slice(row);
        let dirs_q15 = self.packets.of_row(first);
        dispatch!(self.level, simd => any_visits(simd, self.placement, dirs_q15, &freed, away, voxel))
    }

    /// Whether a pixel's ray visits a voxel, were nothing in its way.
    #[inline]
    fn visits(&self, pixel: [u32; 2], voxel: [i32; 3]) -> bool {
        let dir_q15 = self.packets.of_pixel(pixel);
        let GridPose { origin_q16, axis_q15, .. } = self.placement;
        let away = std::array::from_fn(|r| voxel[r] - (origin_q16[r] >> 16));
        let axis = |r: usize| {
            let dir_q16 = march::direction_q16(axis_q15[r], dir_q15);
            let [first_q16, period_q16] = march::start_axis(origin_q16[r], dir_q16);
            RayAxis::new(r, dir_q16.signum(), first_q16, period_q16)
        };
        leap::span(axis, away, away).is_some()
    }
}

/// [`CarveVoxels::any_visits`] of the row of a whole tile; pixels that are not asked free nothing. `visits` for eight at once.
#[inline(always)]
fn any_visits<S: Simd>(
    _: S,
    placement: &GridPose,
    dirs_q15: [&[i32; TILE as usize]; 3],
    freed: &[u16; TILE as usize],
    away: u32,
    voxel: [i32; 3],
) -> bool {
    const PIXELS: usize = TILE as usize;
    let [mut enters, mut leaves] = [[0; PIXELS], [NONE; PIXELS]];
    for r in 0..3 {
        let (origin_q16, axis_q15) = (placement.origin_q16[r], placement.axis_q15[r]);
        let away = voxel[r] - (origin_q16 >> 16);
        let ([mut firsts, mut periods], mut steps) = ([[0; PIXELS]; 2], [0; PIXELS]);
        for i in 0..PIXELS {
            let dir_q16 = march::direction_q16(axis_q15, dirs_q15.map(|dirs| dirs[i]));
            let [first_q16, period_q16] = march::start_axis(origin_q16, dir_q16);
            (firsts[i], periods[i]) = (narrow::first(first_q16, r), period_q16);
            steps[i] = dir_q16.signum();
        }
        if away == 0 {
            (0..PIXELS).for_each(|i| leaves[i] = leaves[i].min(firsts[i]));
            continue;
        }
        let slab = Slab::new(away);
        for i in 0..PIXELS {
            let [own_enters, own_leaves] = slab.crossings(firsts[i], periods[i], steps[i]);
            enters[i] = enters[i].max(own_enters);
            leaves[i] = leaves[i].min(own_leaves);
        }
    }
    (0..PIXELS).fold(false, |any, i| {
        any | (u32::from(freed[i]) > away) & (enters[i] <= leaves[i]) & (enters[i] < NONE)
    })
}

/// Sets all voxels of a box that lie in the window.
fn fill(plane: &mut BitGrid, corner: [i32; 3], edge: i32) {
    for z in corner[2]..corner[2] + edge {
        for y in corner[1]..corner[1] + edge {
            plane.set_run(corner[0], corner[0] + edge, y, z);
        }
    }
}
