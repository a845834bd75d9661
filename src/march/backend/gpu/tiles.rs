//! How voxels and pixels are grouped: voxels in boxes, pixels in tiles and in the blocks of a pyramid. The prelude
//! prints these numbers in front of every shader.

/// Voxels along the edge of the boxes that are decided whole; a row of one is in one word of a plane.
pub(super) const BOX_EDGE: u32 = 8;

/// Cubes of a box that are looked for in an image, half as large on each axis.
pub(super) const CUBES: u32 = 8;

/// Bits of a box's number, a third of them an axis: 1023 voxels are 128 boxes.
pub(super) const BOX_BITS: u32 = 21;

/// The smallest and the largest blocks of a pyramid have an edge of two to the power of these pixels.
pub(super) const PYRAMID_LEVELS: std::ops::RangeInclusive<u32> = 1..=6;

/// Edge in pixels of a tile, which is a block of a pyramid two levels above the smallest.
pub(super) const TILE: u32 = 4 << *PYRAMID_LEVELS.start();

/// Where the end of a pixel's ray is among those of its placement, in an image of `across` tiles across: by tiles, the
/// twin of `place_in_tile` in `shaders/tiles.wgsl`.
pub(super) fn place_of_pixel(across: u32, [x, y]: [u32; 2]) -> u32 {
    let (tile, [u, v]) = (y / TILE * across + x / TILE, [x % TILE, y % TILE]);
    tile * TILE * TILE + v / 2 * 2 * TILE + u / 2 * 4 + v % 2 * 2 + u % 2
}
