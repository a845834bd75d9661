//! Which voxels a camera proves free, decided voxel by voxel and whole boxes at a time from the image of how
//! many voxels each pixel frees.
//!
//! # Theory
//! A ray has made as many crossings on reaching a voxel as the voxel is away from the sensor's voxel, counted
//! along the axes (`SEMANTICS.md`, "Rays"), whatever the ray. So a voxel is free if and only if some ray that
//! visits it frees more voxels than that: one witness is enough, and whether a ray visits a voxel is a matter
//! of six crossings. If no pixel that could see a box frees more than its nearest voxel needs, nothing of it
//! is free; if all free more than its farthest needs, and no voxel slips between the pixels, all of it is.
//! Rays that pass within half a voxel of a voxel's centre surely visit it: where pixels are dense, those of several about it.
//!
//! # Practice
//! For cameras, whose free voxels are each visited by hundreds of rays. Most boxes are decided whole; pixels
//! are looked at along silhouettes only.

use fearless_simd::{Level, Simd, dispatch};

use super::asked::AskedTiles;
use super::narrow::{self, NarrowPacket, Slabs};
use super::packet::{Lanes, TILE};
use super::plan::RelevantVoxels;
use super::projection::{BOXES, PixelRect, PixelRects, Projection};
use super::pyramid::{Pyramid, Rect};
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
    /// Marks what is free of a box of voxels of an even edge, as the camera sees it; near voxels are left alone.
    pub(super) fn decide(&mut self, corner: [i32; 3], edge: i32, pixel_rect: &PixelRect, free: &mut BitGrid) {
        if !pixel_rect.near {
            let [nearest, farthest] = self.away(corner, edge);
            let [least, most] = self.pyramid.range(&pixel_rect.rect);
            if most <= nearest {
                return;
            }
            if pixel_rect.dense && least > farthest {
                free.set_all(&Window { min: corner, size: [edge as u32; 3] });
                return;
            }
        }
        let half = edge / 2;
        let corners: [[i32; 3]; BOXES] =
            std::array::from_fn(|part| std::array::from_fn(|r| corner[r] + (part as i32 >> r & 1) * half));
        let pixel_rects = self.projection.pixel_rects(self.level, &corners, half, &pixel_rect.rect);
        if half == 1 {
            return self.decide_voxels(corner, &pixel_rects, free);
        }
        for (part, &corner) in corners.iter().enumerate() {
            if let Some(pixel_rect) = pixel_rects.rect(part) {
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

    /// Marks which voxels of a box of 2 × 2 × 2 are free, of those that matter and are not near.
    fn decide_voxels(&mut self, corner: [i32; 3], pixel_rects: &PixelRects, free: &mut BitGrid) {
        // Two voxels beside each other on x lie in the same word.
        let pairs: [Option<usize>; BOXES / 2] = std::array::from_fn(|pair| {
            free.bit_index([corner[0], corner[1] + (pair as i32 & 1), corner[2] + (pair as i32 >> 1)])
        });
        let to: [i32; 3] = std::array::from_fn(|r| corner[r] - (self.placement.origin_q16[r] >> 16));
        for (pair, bit) in pairs.into_iter().enumerate() {
            let Some(bit) = bit else { continue };
            let wanted = self.wanted.voxels.words()[bit >> 5] >> (bit & 31);
            for x in (0..2).filter(|x| wanted >> x & 1 == 1) {
                let part = 2 * pair + x;
                let to: [i32; 3] = std::array::from_fn(|r| to[r] + (part as i32 >> r & 1));
                if pixel_rects.is_seen_from_afar(part) && self.is_free(to, pixel_rects, part) {
                    free.words_mut()[bit >> 5] |= 1 << (bit & 31) << x;
                }
            }
        }
    }

    /// Whether a pixel that sees a voxel, so far from the sensor's, frees more voxels than lie between.
    #[inline]
    fn is_free(&mut self, to: [i32; 3], pixel_rects: &PixelRects, part: usize) -> bool {
        let away = to.iter().map(|x| x.unsigned_abs()).sum();
        let PixelRect { rect, dense, centre, beside, .. } = pixel_rects.get(part);
        if beside > 0 && dense && self.pyramid.most_about(centre, beside) > away {
            return true;
        }
        if pixel_rects.centre_pixels(part).pixels().any(|pixel| self.pyramid.get(pixel) > away) {
            return true;
        }
        let [_, most] = self.pyramid.range(&rect);
        most > away && self.is_visited(to, away, &pixel_rects.get(part))
    }

    /// Whether the ray of a pixel that sees a voxel, so far from the sensor's, and frees more than `away` voxels, visits it.
    fn is_visited(&mut self, to: [i32; 3], away: u32, seen: &PixelRect) -> bool {
        let PixelRect { rect, dense, centre, .. } = seen;
        let to = Slabs::new(to);
        if !*dense && self.pyramid.get(*centre) > away {
            let lane = centre[1] % TILE * TILE + centre[0] % TILE;
            if self.asked.rays(centre.map(|x| x / TILE)).visits(lane as usize, &to) {
                return true;
            }
        }
        // Tile by tile, so that what is wholly hidden costs one look.
        self.pyramid.tiles(rect, away).any(|tile| {
            let (freed, rays) = (self.pyramid.tile(tile), self.asked.rays(tile));
            match self.wide {
                true => dispatch!(self.level, simd => any_visits(simd, rays, freed, rect, tile, away, &to)),
                false => rect.part(tile).any(|lane| u32::from(freed[lane]) > away && rays.visits(lane, &to)),
            }
        })
    }
}

/// Whether any of a rectangle's pixels in a tile that free more than `away` voxels has a ray that visits a voxel.
#[inline(always)]
fn any_visits<S: Simd>(
    _: S,
    rays: &NarrowPacket,
    freed: &Lanes<u16>,
    rect: &Rect,
    tile: [u32; 2],
    away: u32,
    voxel: &Slabs,
) -> bool {
    let [columns, rows] = rect.tile_overlap(tile);
    for row in rows {
        let begin = (row * TILE) as usize;
        let mut over = [0; TILE as usize];
        for (column, over) in over.iter_mut().enumerate() {
            let is_seen = (columns.start <= column as u32) & ((column as u32) < columns.end);
            *over = u16::from(is_seen & (u32::from(freed[begin + column]) > away));
        }
        if over == [0; TILE as usize] {
            continue;
        }
        let [enters, leaves] = rays.spans::<{ TILE as usize }>(begin, voxel);
        let mut any = 0;
        for (column, over) in over.iter().enumerate() {
            any |= over & u16::from(narrow::is_visited(enters[column], leaves[column]));
        }
        if any != 0 {
            return true;
        }
    }
    false
}
