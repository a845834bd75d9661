//! Which voxels a camera proves free, decided voxel by voxel and whole boxes at a time from the image of how
//! many voxels each pixel frees.
//!
//! # Theory
//! A ray has made as many crossings on reaching a voxel as the voxel is away from the sensor's voxel, counted
//! along the axes (`SEMANTICS.md`, "Rays"), whatever the ray. So a voxel is free if and only if some ray that
//! visits it frees more voxels than that: one witness is enough, and whether a ray visits a voxel is a matter
//! of six crossings. If no pixel that could see a box frees more than its nearest voxel needs, nothing of it
//! is free; if all free more than its farthest needs, and no voxel slips between the pixels, all of it is.
//! Where pixels are dense, those about the one through a voxel's centre pass within half a voxel of it, and surely visit it.
//!
//! # Practice
//! For cameras, whose free voxels are each visited by hundreds of rays. Most boxes are decided whole; pixels
//! are looked at along silhouettes only.

use fearless_simd::{Level, Simd, dispatch};

use super::asked::AskedTiles;
use super::narrow::{self, NarrowPacket};
use super::packet::{Lanes, RAYS, TILE};
use super::plan::RelevantVoxels;
use super::projection::{BOXES, PixelRect, Projection};
use super::pyramid::Pyramid;
use crate::backend::GridPose;
use crate::voxel::{BitGrid, Window};

/// What boxes are decided from.
pub(super) struct CarveVoxels<'a> {
    pub(super) level: Level,
    /// Whether all pixels of a tile are asked at once.
    pub(super) wide: bool,
    pub(super) projection: &'a Projection,
    pub(super) asked: AskedTiles<'a>,
    pub(super) placement: &'a GridPose,
    pub(super) pyramid: &'a Pyramid,
    /// Voxels that matter.
    pub(super) wanted: &'a RelevantVoxels,
}

impl CarveVoxels<'_> {
    /// Marks what is free of a box of voxels, as the camera sees it; near voxels are left alone.
    pub(super) fn decide(&mut self, corner: [i32; 3], edge: i32, pixel_rect: &PixelRect, free: &mut BitGrid) {
        if !pixel_rect.near {
            let [nearest, farthest] = self.away(corner, edge);
            if edge == 1 {
                if self.is_free(corner, nearest, pixel_rect) {
                    free.set(corner);
                }
                return;
            }
            let [least, most] = self.pyramid.range(&pixel_rect.rect);
            if most <= nearest {
                return;
            }
            if pixel_rect.dense && least > farthest {
                free.set_all(&Window { min: corner, size: [edge as u32; 3] });
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
    fn is_free(&mut self, voxel: [i32; 3], away: u32, seen: &PixelRect) -> bool {
        let PixelRect { rect, dense, centre, beside, .. } = seen;
        if *dense && self.pyramid.most_about(*centre, *beside) > away {
            return true;
        }
        let [_, most] = self.pyramid.range(rect);
        if most <= away {
            return false;
        }
        let from = self.placement.origin_q16.map(|x| x >> 16);
        let to: [i32; 3] = std::array::from_fn(|r| voxel[r] - from[r]);
        if !*dense && self.pyramid.get(*centre) > away {
            let lane = centre[1] % TILE * TILE + centre[0] % TILE;
            if self.asked.rays(centre.map(|x| x / TILE)).visits(lane as usize, to) {
                return true;
            }
        }
        // Tile by tile, so that what is wholly hidden costs one look.
        self.pyramid.tiles(rect, away).any(|tile| {
            let (freed, rays) = (self.pyramid.tile(tile), self.asked.rays(tile));
            match self.wide {
                true => dispatch!(self.level, simd => any_visits(simd, rays, freed, away, to)),
                false => rect.part(tile).any(|lane| u32::from(freed[lane]) > away && rays.visits(lane, to)),
            }
        })
    }
}

/// Whether any of a tile's pixels that free more than `away` voxels has a ray that visits the voxel so far away.
#[inline(always)]
fn any_visits<S: Simd>(simd: S, rays: &NarrowPacket, freed: &Lanes<u16>, away: u32, to: [i32; 3]) -> bool {
    let [enters, leaves] = rays.spans(simd, to);
    let mut any = 0;
    for lane in 0..RAYS {
        any |= u32::from((u32::from(freed[lane]) > away) & narrow::is_visited(enters[lane], leaves[lane]));
    }
    any != 0
}
