//! How many turns the loops of a kernel make at most: never as many as a driver allows.
//!
//! # Theory
//! Mesa's software adapters (llvmpipe, up to 22.3.6 at least) work on a vector of invocations at a time. The
//! loops of a vector share one allowance, nested ones included; a turn is taken from it as long as any
//! invocation of the vector is in the loop. When nothing is left, every loop ends after its first turn,
//! without any error.
//!
//! So where each invocation loops once, a vector makes as many turns as its slowest invocation; where loops
//! are nested, up to the sum over all of its invocations.
//!
//! # Practice
//! `static_hits` makes one loop, over the crossings of a ray: 3 · 1023 at most. `pyramid`,
//! `carve_boxes`, `carve_voxels` and `count` make some hundred turns. What the others do is bounded below. That no loop was
//! ended early is proved by `shaders/completion.wgsl`, on every device and in every batch.

use super::tiles::{CUBES, TILE};
use crate::backend::Image;
use crate::march::{MAX_RANGE_VOXELS, deviation};

/// Words of a region that one invocation of `count` takes, so that a group's sums are worth their atomics.
pub(super) const WORDS_PER_INVOCATION: u32 = 16;

/// Words that one invocation of `fuse` takes: the numbers of a vector of WGSL.
pub(super) const FUSED_WORDS: u32 = 4;

/// Invocations of a workgroup: one wave or two on any GPU, and a whole number of vectors on a software
/// adapter.
pub const WORKGROUP: u32 = 64;

/// Turns that the loops of a vector may make.
const ALLOWED: u32 = 65_535;

/// Most invocations of a vector: 512 bits.
const LANES: u32 = 16;

/// Most tiles of which an invocation of `cast` takes a column, one after the other: a software adapter is
/// spared looks at tiles that are done, while on a GPU 32 wait for the one with the most to do.
pub(super) const fn most_tiles(software: bool) -> u32 {
    if software { 8 } else { 2 }
}

/// Turns for a column of a tile whose rays make so many crossings: `cast` searches for the blockers of each ray. Each invocation
/// looks for the next tile by itself. `carve_rays` follows as many rays.
const fn turns_of_tile(crossings: u32) -> u32 {
    TILE * (crossings + 3) + 1 + LANES
}

const _: () = assert!(turns_of_tile(3 * MAX_RANGE_VOXELS) <= ALLOWED);

/// Of how many tiles, so many at most, an invocation takes a column, if no ray goes farther than so many voxels.
pub(super) fn tiles_of_invocation(most: u32, voxels: u32) -> u32 {
    (ALLOWED / turns_of_tile(3 * voxels.min(MAX_RANGE_VOXELS))).min(most)
}

/// Workgroups of `cast_listed` that go through the open tiles of a placement: enough for the dispatches of few placements, and
/// few enough for most to find some.
const LEAST_GROUPS: u32 = 256;

/// So many of them for an image of so many tiles, if no ray goes farther than so many voxels: each searches the blockers of a
/// ray for each of its tiles.
pub(super) fn groups_of_lists(tiles: u32, voxels: u32) -> u32 {
    let turns = ALLOWED / (3 * voxels.min(MAX_RANGE_VOXELS) + 3);
    tiles.div_ceil(turns).max(LEAST_GROUPS).min(tiles)
}

/// Boxes of a workgroup of `see_tiles`: all at once on a software adapter, which pays for each projection, and few on a GPU,
/// so that there are enough workgroups.
pub(super) const fn boxes_of_group(is_gpu: bool) -> u32 {
    if is_gpu { 8 } else { WORKGROUP }
}

/// Most tiles of a rectangle that a workgroup of `see_tiles` marks one by one.
pub(super) const MOST_SEEING: u32 = 2048;

// All of its invocations together mark a rectangle of each box, and one of each of its cubes.
const _: () = assert!(WORKGROUP * (1 + CUBES) * (MOST_SEEING / WORKGROUP + 2) + CUBES < ALLOWED);

/// What an invocation of `cast_tiles` does at most: leaps and sections of a cone, rows of a section, layers
/// that may lie across it, and how many of them are looked at.
pub(super) const MOST_LEAPS: u32 = 64;
pub(super) const MOST_SECTIONS: u32 = 16;
pub(super) const MOST_ROWS: u32 = 96;
pub(super) const MOST_LAYERS: u32 = 16;
pub(super) const MOST_LOOKS: u32 = 2;

// Leaps are a loop, and so is what is around it; so are the search for the next layer and what is around that, on three axes.
// Rows are looked at in each section, in layers, and before one of them.
const _: () = assert!(
    LANES
        * (2 * MOST_LEAPS
            + MOST_SECTIONS * MOST_ROWS
            + 4
            + 3 * (2 * MOST_LAYERS + 1 + MOST_LOOKS * MOST_ROWS)
            + MOST_ROWS)
        <= ALLOWED
);

/// Teams of a workgroup of `carve_crowded`, of as many invocations as a tile has columns: each decides a voxel.
pub(super) const TEAMS: u32 = WORKGROUP / TILE;

/// Most pixels of the tiles with pixels that may see a voxel that is scanned.
const MOST_SCANNED: u32 = 190_000;

/// Turns for at most so many tiles in so many rows: two by two, and of each four the ends of two columns of pixels are looked up two at a
/// time, and the pixels are asked one by one; of a single row or column half as many.
const fn turns_of_scan(tiles: u32, rows: u32) -> u32 {
    let columns = tiles / rows;
    let pixels = if rows == 1 || columns == 1 { 2 * TILE } else { 4 * TILE };
    rows.div_ceil(2) * columns.div_ceil(2) * (1 + pixels / 2 + 1 + pixels + 1)
}

const _: () = {
    let tiles = MOST_SCANNED / (TILE * TILE) + 1;
    let mut rows = 1;
    while rows <= tiles {
        assert!(turns_of_scan(tiles, rows) <= ALLOWED);
        rows += 1;
    }
};

/// Most tiles of an image that a workgroup of `carve_near` goes through.
pub(super) const NEAR_TILES: u32 = 1 << 14;

// It looks at as many tiles in a round as it has invocations, and then asks one after the other.
const _: () = assert!((WORKGROUP + 2) * (NEAR_TILES / WORKGROUP + 1) <= ALLOWED);

/// Most readings that are fused for a choice: `fuse` looks at each of them once, and again for each of the 32
/// voxels of a word.
pub(super) const MOST_READINGS: u32 = 1900;

const _: () = assert!((MOST_READINGS + 1) + 32 * (MOST_READINGS + 1) + 33 <= ALLOWED);

/// What a ray may deviate in a voxel of distance, for kernels: twice as much, since their floats have fewer
/// digits than the distance needs.
pub(super) const DEVIATION_PER_VOXEL: f64 = 2.0 * deviation::PER_VOXEL;

/// Depth in voxels up to which voxels of an image are near: behind it none is seen by tiles of more than
/// [`MOST_SCANNED`] pixels.
///
/// A voxel is at most √3 wide and as deep, and `pixel_rect` in `shaders/projection.wgsl` grows it by what
/// rays may deviate at its distance, on both sides. If it is in the middle of the image, its near side
/// decides how many pixels it covers; else they reach from the image's edge at its near side to where its
/// other end is at its far side, at least a voxel deeper.
pub(super) fn last_near_voxels(image: &Image) -> f64 {
    let edge = |axis: usize| f64::from(image.size_px[axis]) / 2.0;
    let slopes = edge(0) / image.focal_px[0] + edge(1) / image.focal_px[1];
    let pixels = |depth: f64, axis: usize| {
        let deviation = DEVIATION_PER_VOXEL * ((depth + 2.0) * (1.0 + slopes) + 3.5) + deviation::FIXED;
        let (wide, focal) = (3f64.sqrt() + 2.0 * deviation, image.focal_px[axis]);
        let across = wide * f64::max(focal / depth, (focal + edge(axis)) / (depth + 1.0));
        (across + 3.0).min(2.0 * edge(axis)) + f64::from(2 * (TILE - 1))
    };
    // No voxel is deeper.
    (10..=10 * MAX_RANGE_VOXELS)
        .map(|tenth| f64::from(tenth) / 10.0)
        .find(|&depth| pixels(depth, 0) * pixels(depth, 1) <= f64::from(MOST_SCANNED))
        .unwrap_or(f64::from(MAX_RANGE_VOXELS))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_invocation_takes_as_many_tiles_as_its_loops_may_turn_for() {
        for most in [true, false].map(most_tiles) {
            for voxels in 1..=2 * MAX_RANGE_VOXELS {
                let tiles = tiles_of_invocation(most, voxels);
                let turns = |tiles: u32| tiles * turns_of_tile(3 * voxels.min(MAX_RANGE_VOXELS));
                assert!(tiles > 0 && turns(tiles) <= ALLOWED, "{tiles} at {voxels}");
                assert!(tiles == most || turns(tiles + 1) > ALLOWED, "{tiles} at {voxels}");
            }
        }
        assert_eq!([200, 500, 1000].map(|voxels| tiles_of_invocation(most_tiles(true), voxels)), [8, 5, 2]);
    }

    /// `pixel_rect` in `shaders/projection.wgsl`, or a pixel more on each side: how many pixels of one axis are in tiles that may see a
    /// voxel at `p` in the camera's frame whose half extents there are `half`, and the depth where it begins.
    fn seen_rect(image: &Image, axis: usize, p: [f64; 3], half: [f64; 3]) -> (f64, f64) {
        let deviation =
            DEVIATION_PER_VOXEL * (p.iter().map(|x| x.abs()).sum::<f64>() + 1.5) + deviation::FIXED;
        let (low, high) = (p[axis] - half[axis] - deviation, p[axis] + half[axis] + deviation);
        let (z_low, z_high) = (p[2] - half[2] - deviation, p[2] + half[2] + deviation);
        let (size, focal) = (f64::from(image.size_px[axis]), image.focal_px[axis]);
        let from = size / 2.0 + focal * low / if low < 0.0 { z_low } else { z_high } - 0.5;
        let to = size / 2.0 + focal * high / if high < 0.0 { z_high } else { z_low } + 0.5;
        if to < 0.0 || from >= size {
            return (0.0, z_low);
        }
        let tile = |pixel: f64| (pixel.clamp(0.0, size - 1.0) / f64::from(TILE)).floor();
        ((tile(to) - tile(from) + 1.0) * f64::from(TILE), z_low)
    }

    #[test]
    fn no_voxel_that_is_not_near_is_seen_by_more_pixels_than_scan_looks_at() {
        let cameras = [
            Image { size_px: [1280, 720], focal_px: [674.4, 649.5] },
            Image { size_px: [4096, 4096], focal_px: [2000.0, 2000.0] },
            Image { size_px: [4096, 3000], focal_px: [40_000.0, 40_000.0] },
            Image { size_px: [4000, 4000], focal_px: [250.0, 250.0] },
        ];
        for image in &cameras {
            let near = last_near_voxels(image);
            let mut most = 0.0f64;
            // Turned in all directions by eighths of a right angle, at depths from the nearest on, over a
            // quarter of the image.
            for turn in 0..64 {
                let [a, b] = [turn % 8, turn / 8].map(|i| f64::from(i) * std::f64::consts::FRAC_PI_2 / 8.0);
                let rows = [
                    [a.cos(), a.sin(), 0.0],
                    [-a.sin() * b.cos(), a.cos() * b.cos(), b.sin()],
                    [a.sin() * b.sin(), -a.cos() * b.sin(), b.cos()],
                ];
                for order in [[0, 1, 2], [1, 2, 0], [2, 0, 1]] {
                    let half = order.map(|r| rows[r].iter().map(|x| x.abs() / 2.0).sum::<f64>());
                    for step in 0..2000 {
                        let z = near + f64::from(step % 20) * 0.2 * (1.0 + near / 20.0);
                        let off = |axis: usize, i: i32| {
                            z * f64::from(i) / 9.0 * f64::from(image.size_px[axis])
                                / 2.0
                                / image.focal_px[axis]
                        };
                        let p = [off(0, step / 20 % 10), off(1, step / 200), z];
                        let ((u, begins), (v, _)) =
                            (seen_rect(image, 0, p, half), seen_rect(image, 1, p, half));
                        if begins >= near {
                            most = most.max(u * v);
                        }
                    }
                }
            }
            assert!(most <= f64::from(MOST_SCANNED), "{image:?}: {most} pixels, near is {near}");
            assert!(most >= 0.3 * f64::from(MOST_SCANNED) || near >= 2000.0, "{image:?}: only {most} pixels");
        }
    }
}
