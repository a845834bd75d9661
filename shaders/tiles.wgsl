// Tiles of a camera's pixels, and where `ends` holds what `cast_tiles` knows of each: behind a placement's rays, a word a
// tile.

// How far the rays of a tile are sent, with this bit; or how all of them end, which is not written ray by ray.
const SENT = 0x80000000u;

// Tiles of an image, across and down.
fn tiles_of_image() -> vec2<u32> {
    return (vec2<u32>(table.image_x, table.image_y) + TILE - 1u) / TILE;
}

// The word of a tile in `ends`.
fn word_of_tile(row: u32, tile: u32) -> u32 {
    return row * table.ends_stride + table.rays + tile;
}
