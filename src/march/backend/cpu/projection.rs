//! Where boxes of voxels are in a camera's image: conservative rectangles of pixels, in floats. A rectangle
//! only says where to look; `carve_voxels` decides in integers.
//!
//! # Theory
//! The ideal rays that cross a box go through the pixels that the box projects to. Rays of integers deviate
//! from them (`cone::deviation`), so the box is grown by that first. Depth and width of a box are bounded
//! separately, which can make the rectangle larger than needed, never smaller.
//!
//! # Practice
//! For the boxes and voxels of `carve_voxels`, eight at a time.

use fearless_simd::{Level, Simd, dispatch};

use super::cone::deviation;
use super::packet::WIDEST_PX;
use super::pyramid::Rect;
use crate::backend::{GridPose, Image};

/// Pixels on an axis beyond which a voxel is too near to be looked at from there.
const WIDEST_VOXEL_PX: f32 = 384.0;

/// A camera at a placement.
pub(super) struct Projection {
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
    /// Diagonals of pixels in a voxel at depth 1.
    per_diagonal: f32,
}

/// Boxes looked at together.
pub(super) const BOXES: usize = 8;

/// A box as a camera sees it: no other pixels' rays visit any of its voxels.
#[derive(Clone, Copy, Debug)]
pub(super) struct PixelRect {
    pub(super) rect: Rect,
    /// Whether some of it is so near that pixels say little.
    pub(super) near: bool,
    /// Whether pixels are so close at its depth, and it so far inside the image, that each of its voxels is
    /// surely visited by one of them.
    pub(super) dense: bool,
    /// The pixel through its centre, or the nearest of the rectangle.
    pub(super) centre: [u32; 2],
    /// Up to how many pixels beside that one, on each axis, all rays surely visit the box, if it is a dense voxel.
    pub(super) beside: u32,
}

/// The pixels about a voxel's centre: the nearest, and on each axis the next one on the centre's side of it.
#[derive(Clone, Copy)]
pub(super) struct CentrePixels {
    columns: [i32; 2],
    rows: [i32; 2],
    /// Whether the ray of each of the four surely visits the voxel: a bit each, columns first.
    surely: i32,
}

impl CentrePixels {
    /// Those whose rays surely visit the voxel.
    #[inline]
    pub(super) fn pixels(self) -> impl Iterator<Item = [u32; 2]> {
        let pixel = move |i: usize| [self.columns[i & 1] as u32, self.rows[i >> 1] as u32];
        (0..4).filter(move |i| self.surely >> i & 1 == 1).map(pixel)
    }
}

/// Boxes as a camera sees them.
pub(super) struct PixelRects {
    first: [[i32; BOXES]; 2],
    last: [[i32; BOXES]; 2],
    // 1 or 0 instead of `bool`: with AVX2, packing comparisons into bytes takes longer than making them.
    seen: [i32; BOXES],
    near: [i32; BOXES],
    dense: [i32; BOXES],
    centre: [[i32; BOXES]; 2],
    beside: [i32; BOXES],
    /// Of voxels: the rest of what [`CentrePixels`] holds.
    next: [[i32; BOXES]; 2],
    surely: [i32; BOXES],
}

impl PixelRects {
    /// One of them; `None` if no pixel sees any of its voxels.
    #[inline]
    pub(super) fn rect(&self, i: usize) -> Option<PixelRect> {
        (self.seen[i] != 0).then(|| self.get(i))
    }

    /// Whether pixels see one of them, and none of its voxels is near.
    #[inline]
    pub(super) fn is_seen_from_afar(&self, i: usize) -> bool {
        (self.seen[i] != 0) & (self.near[i] == 0)
    }

    /// One of them that pixels see.
    #[inline]
    pub(super) fn get(&self, i: usize) -> PixelRect {
        let rect = Rect {
            first: [self.first[0][i] as u32, self.first[1][i] as u32],
            last: [self.last[0][i] as u32, self.last[1][i] as u32],
        };
        let (near, dense, beside) = (self.near[i] != 0, self.dense[i] != 0, self.beside[i] as u32);
        let centre = self.centre.map(|pixels| pixels[i] as u32);
        PixelRect { rect, near, dense, centre, beside }
    }

    /// The pixels about the centre of one of them that pixels see, a voxel.
    #[inline]
    pub(super) fn centre_pixels(&self, i: usize) -> CentrePixels {
        let [columns, rows] = [0, 1].map(|a: usize| [self.centre[a][i], self.next[a][i]]);
        CentrePixels { columns, rows, surely: self.surely[i] }
    }
}

impl Projection {
    pub(super) fn new(placement: &GridPose, image: &Image) -> Projection {
        let axes: [[f32; 3]; 3] =
            std::array::from_fn(|a| std::array::from_fn(|r| placement.axis_q15[r][a] as f32 / 32_768.0));
        let focal_px = image.focal_px.map(|f| f as f32);
        let half_pixel = 0.5 * (focal_px[0].powi(-2) + focal_px[1].powi(-2)).sqrt();
        Projection {
            origin: placement.origin_q16.map(|x| x as f32 / 65_536.0),
            axes,
            spans: axes.map(|axis| axis.iter().map(|x| x.abs()).sum()),
            focal_px,
            middle_px: image.size_px.map(|n| n as f32 / 2.0 - 0.5),
            last_px: image.size_px.map(|n| n as f32 - 1.0),
            near: 1.8 * focal_px[0].max(focal_px[1]) / WIDEST_VOXEL_PX,
            half_pixel,
            per_diagonal: 0.5 / half_pixel,
        }
    }

    /// All pixels.
    pub(super) fn all(&self) -> Rect {
        Rect { first: [0; 2], last: self.last_px.map(|x| x as u32) }
    }

    /// The pixels of a rectangle that may see cubes of `edge` voxels, from each of at most [`BOXES`] corners
    /// on.
    pub(super) fn pixel_rects(
        &self,
        level: Level,
        corners: &[[i32; 3]],
        edge: i32,
        within: &Rect,
    ) -> PixelRects {
        let half = edge as f32 * 0.5;
        let mut middles = [[0.0; BOXES]; 3];
        for (i, corner) in corners.iter().enumerate() {
            (0..3).for_each(|r| middles[r][i] = corner[r] as f32 + half);
        }
        dispatch!(level, simd => pixel_rects(simd, self, &middles, half, within))
    }

    /// No ray is in a cube of `edge` voxels at a distance of more voxels than that.
    pub(super) fn farthest(&self, corner: [i32; 3], edge: i32) -> f32 {
        let half = edge as f32 * 0.5;
        let away = [0, 1, 2].map(|r| (corner[r] as f32 + half - self.origin[r]).abs() + half);
        let distance = away.iter().map(|x| x * x).sum::<f32>().sqrt();
        distance + 2.0 * deviation(distance) + 1.0
    }

    /// Distance along any ray after which no near voxel is entered, in 1/65536 voxels.
    pub(super) fn last_near_q16(&self) -> u32 {
        // The steepest ray goes through a corner of the image.
        let slope = |a: usize| (self.middle_px[a] + 1.0) / self.focal_px[a];
        let depth = self.near + 2.0 * (0.5 * self.spans[2] + 0.5);
        let t = depth * (1.0 + slope(0).powi(2) + slope(1).powi(2)).sqrt();
        ((t + 2.0 * deviation(t) + 1.0) * 65_536.0).min(f32::from(u16::MAX) * 32_768.0) as u32
    }
}

/// The pixel nearest to a coordinate, cut to those of the widest image, as a number and as a coordinate. Adding 2²³ rounds, and leaves
/// the whole number in the lowest bits; a conversion, which looks at what cannot be converted, is made one by one.
#[inline(always)]
fn nearest(x: f32) -> (i32, f32) {
    const WHOLE: f32 = (1 << 23) as f32;
    let x = if x > 0.0 { x } else { 0.0 };
    let rounded = if x < WIDEST_PX as f32 { x } else { WIDEST_PX as f32 } + WHOLE;
    ((rounded.to_bits() - WHOLE.to_bits()) as i32, rounded - WHOLE)
}

/// [`Projection::pixel_rects`] of cubes with these centres and half edges.
#[inline(always)]
fn pixel_rects<S: Simd>(
    _: S,
    projection: &Projection,
    middles: &[[f32; BOXES]; 3],
    half: f32,
    within: &Rect,
) -> PixelRects {
    let mut out = PixelRects {
        first: [[0; BOXES]; 2],
        last: [[0; BOXES]; 2],
        seen: [0; BOXES],
        near: [0; BOXES],
        dense: [0; BOXES],
        centre: [[0; BOXES]; 2],
        beside: [0; BOXES],
        next: [[0; BOXES]; 2],
        surely: [0; BOXES],
    };
    let mut at = [[0.0f32; BOXES]; 3];
    for i in 0..BOXES {
        let from: [f32; 3] = [0, 1, 2].map(|r| middles[r][i] - projection.origin[r]);
        for a in 0..3 {
            let axis = projection.axes[a];
            at[a][i] = axis[0] * from[0] + axis[1] * from[1] + axis[2] * from[2];
        }
    }
    let [mut grown, mut per_near, mut per_far, mut far, mut inverse] = [[0.0f32; BOXES]; 5];
    // Squares of distances in voxels from a box's centre, on each axis: of the rays of the nearest pixel, and of the next.
    let mut apart = [[[0.0f32; BOXES]; 2]; 2];
    for i in 0..BOXES {
        // No farther than that from the sensor.
        grown[i] = deviation(at[0][i].abs() + at[1][i].abs() + at[2][i].abs() + 3.0 * half);
        let deep = half * projection.spans[2] + grown[i];
        let near = at[2][i] - deep;
        far[i] = at[2][i] + deep;
        per_far[i] = 1.0 / far[i];
        // Where a box reaches behind the sensor, no edge bounds the slope.
        per_near[i] = if near > 0.0 { 1.0 / near } else { f32::INFINITY };
        out.near[i] = i32::from(near <= projection.near);
        out.seen[i] = i32::from(far[i] > 0.0);
        // The ray through the nearest pixel passes within half a voxel of a voxel's centre, so it crosses the
        // voxel.
        out.dense[i] = i32::from(projection.half_pixel * far[i] + grown[i] <= 0.5);
        inverse[i] = 1.0 / at[2][i];
        // The rays through these pass within half a voxel, too. What is rounded is less by a half, so that it is cut.
        out.beside[i] = nearest((0.5 - grown[i]) * inverse[i] * projection.per_diagonal - 1.0).0;
    }
    for a in 0..2 {
        let (first, last) = (within.first[a] as i32, within.last[a] as i32);
        for i in 0..BOXES {
            let wide = half * projection.spans[a] + grown[i];
            let (low, high) = (at[a][i] - wide, at[a][i] + wide);
            // The slope of an edge is steepest where the box is nearest, or farthest if it goes the other
            // way.
            let low = low * if low >= 0.0 { per_far[i] } else { per_near[i] };
            let high = high * if high <= 0.0 { per_far[i] } else { per_near[i] };
            let low = projection.focal_px[a] * low + projection.middle_px[a];
            let high = projection.focal_px[a] * high + projection.middle_px[a];
            out.dense[i] &= i32::from(low >= 0.0) & i32::from(high <= projection.last_px[a]);
            // The first pixel not below, the last not above.
            let ((from, near_low), (to, near_high)) = (nearest(low), nearest(high));
            out.first[a][i] = (from + i32::from(near_low < low)).max(first);
            out.last[a][i] = (to - i32::from(near_high > high)).min(last);
            let centre = projection.focal_px[a] * at[a][i] * inverse[i] + projection.middle_px[a];
            out.centre[a][i] = nearest(centre).0.max(out.first[a][i]).min(out.last[a][i]);
            out.seen[i] &= i32::from(high >= 0.0) & i32::from(out.first[a][i] <= out.last[a][i]);
            let off = centre - out.centre[a][i] as f32;
            out.next[a][i] = out.centre[a][i] + if off < 0.0 { -1 } else { 1 };
            let per_pixel = at[2][i] / projection.focal_px[a];
            apart[a][0][i] = (off * per_pixel).powi(2);
            // Farther than anything, if the image has no such pixel.
            let is_next = (first <= out.next[a][i]) & (out.next[a][i] <= last);
            let to_next = (1.0 - off.abs()) * per_pixel;
            apart[a][1][i] = if is_next { to_next * to_next } else { f32::INFINITY };
        }
    }
    // What passes within half a voxel of a voxel's centre visits it.
    for i in 0..BOXES {
        let within = (0.5 - grown[i]).max(0.0).powi(2);
        let is_sure = |u: usize, v: usize| i32::from(apart[0][u][i] + apart[1][v][i] < within);
        out.surely[i] = is_sure(0, 0) | is_sure(1, 0) << 1 | is_sure(0, 1) << 2 | is_sure(1, 1) << 3;
    }
    out
}

#[cfg(test)]
mod tests {
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::super::narrow::{NarrowPacket, Slabs};
    use super::super::packet::{Packet, Packets, RAYS, TILE};
    use super::super::simd::SimdLevel;
    use super::super::test_camera::{SIZE_PX, camera};
    use super::*;

    /// Against all rays of a camera: those that visit a voxel are in its rectangle, and those that surely visit it do.
    #[test]
    fn rectangles_hold_what_visits_a_voxel_and_centre_pixels_only_that() {
        let mut random = ChaCha8Rng::seed_from_u64(19);
        let levels = SimdLevel::all();
        let (mut nearest, mut next, mut at_the_edge) = (0, 0, 0);
        for turn in 0..60 {
            let mut share = || f64::from(random.next_u32()) / f64::from(u32::MAX);
            let focal = 30.0 + 200.0 * share();
            let rays = camera([focal, focal * (0.4 + 1.2 * share())]);
            let (packets, image) = (Packets::new(&rays), rays.image.expect("a camera"));
            let turned = glam::DQuat::from_xyzw(share() - 0.5, share() - 0.5, share() - 0.5, share() - 0.5);
            let turned = glam::DMat3::from_quat(turned.normalize());
            let q15 = |row: [f64; 3]| row.map(|x| (x * 32_768.0).round() as i32);
            let axis_q15 = turned.transpose().to_cols_array_2d().map(q15);
            let origin_q16 = [0; 3].map(|_: i32| (300 << 16) + (65_536.0 * share()) as i32);
            let pose = GridPose { origin_q16, axis_q15, draws: 0, truly: None };
            let level = levels[turn % levels.len()].level;
            let tiles: Vec<NarrowPacket> = (0..packets.count())
                .map(|tile| {
                    let (mut packet, mut narrow) = (Packet::new(), NarrowPacket::new());
                    packet.start(level, &pose, packets.dirs_q15(tile));
                    dispatch!(level, simd => narrow.start(simd, &packet));
                    narrow
                })
                .collect();
            let projection = Projection::new(&pose, &image);
            for _ in 0..20 {
                // Voxels about points that it sees, at its edges, too.
                let corners: [[i32; 3]; BOXES] = std::array::from_fn(|_| {
                    let depth = 4.0 + 150.0 * share() * share();
                    let mut at = |a: usize| 1.1 * (share() - 0.5) * f64::from(SIZE_PX[a]) / image.focal_px[a];
                    let point = turned * glam::DVec3::new(at(0) * depth, at(1) * depth, depth);
                    point.to_array().map(|x| 300 + x.floor() as i32)
                });
                let pixel_rects = projection.pixel_rects(level, &corners, 1, &projection.all());
                for (i, corner) in corners.iter().enumerate() {
                    let seen = pixel_rects.rect(i);
                    let (slabs, mut visits) = (Slabs::new(corner.map(|x| x - 300)), Vec::new());
                    for (tile, narrow) in tiles.iter().enumerate() {
                        let (lanes, across) = (0..RAYS as u32, SIZE_PX[0].div_ceil(TILE));
                        let [u, v] = [tile as u32 % across * TILE, tile as u32 / across * TILE];
                        let pixels = lanes.filter(|&lane| narrow.visits(lane as usize, &slabs));
                        let pixels = pixels.map(|lane| [u + lane % TILE, v + lane / TILE]);
                        visits.extend(pixels.filter(|pixel| (0..2).all(|a| pixel[a] < SIZE_PX[a])));
                    }
                    let Some(PixelRect { rect, near, .. }) = seen else {
                        assert_eq!(visits, Vec::<[u32; 2]>::new(), "{corner:?} is not seen");
                        continue;
                    };
                    let holds =
                        |pixel: &[u32; 2]| (0..2).all(|a| (rect.first[a]..=rect.last[a]).contains(&pixel[a]));
                    assert!(visits.iter().all(holds), "{corner:?}: {visits:?} in {rect:?}");
                    if near {
                        continue;
                    }
                    let about = pixel_rects.centre_pixels(i);
                    let surely: Vec<[u32; 2]> = about.pixels().collect();
                    assert!(surely.iter().all(|pixel| visits.contains(pixel)), "{surely:?} of {visits:?}");
                    nearest += about.surely & 1;
                    next += (about.surely >> 1).count_ones();
                    let is_at_the_edge = |a: usize| rect.first[a] == 0 || rect.last[a] + 1 == SIZE_PX[a];
                    at_the_edge += usize::from((0..2).any(is_at_the_edge) && surely.len() > 1);
                }
            }
        }
        assert!(nearest > 2000 && next > 2000 && at_the_edge > 100, "{nearest}, {next}, {at_the_edge}");
    }
}
