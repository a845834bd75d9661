// Tiles of a camera's pixels, where `tiles` holds what `see_tiles` finds each to see, and `ends` what `cast_tiles` knows of
// it: behind the ends of a placement's rays, a word a tile. The ends themselves are in the order of tiles, all of them whole; in
// a tile four pixels of two rows lie together, so that software adapters look them up at once.

// How far the rays of a tile are sent, with this bit; or how all of them end, which is not written ray by ray.
const SENT = 0x80000000u;
// Or with this bit, too: to before a layer of voxels across an axis that they all enter; the axis, and where it is there.
const SENT_TO_LAYER = 0x40000000u;
const LAYER_BITS = 11u;

// Tiles of an image, across and down.
fn tiles_of_image() -> vec2<u32> {
    return (vec2<u32>(table.image_x, table.image_y) + TILE - 1u) / TILE;
}

// The word of `tiles` that tells how far all tiles of a placement see. That of each follows.
fn seen_from(row: u32) -> u32 {
    let size = tiles_of_image();
    return row * (size.x * size.y + 1u);
}

// The word of a tile in `ends`.
fn word_of_tile(row: u32, tile: u32) -> u32 {
    let size = tiles_of_image();
    return row * table.ends_stride + size.x * size.y * (TILE * TILE) + tile;
}

// Where a pixel's end is in its tile.
fn place_in_tile(pixel: vec2<u32>) -> u32 {
    return (pixel.y >> 1u) * (2u * TILE) + (pixel.x >> 1u) * 4u + (pixel.y & 1u) * 2u + (pixel.x & 1u);
}

// The pixel of a tile that has a place there.
fn pixel_at(place: u32) -> vec2<u32> {
    return vec2<u32>(((place >> 2u) & 3u) * 2u + (place & 1u), (place >> 4u) * 2u + ((place >> 1u) & 1u));
}

// The word of `listed` that counts the tiles of a placement whose rays search for blockers. The next word counts those whose rays
// are sent to a layer.
fn head_of_lists(row: u32) -> u32 {
    return 2u * row;
}

// The word of `listed` with a tile of either list. They share the room of all tiles: one begins at its end.
fn word_of_list(row: u32, place: u32, of_layer: bool) -> u32 {
    let size = tiles_of_image();
    let tiles = size.x * size.y;
    return 2u * MOST_PLACEMENTS + row * tiles + select(place, tiles - 1u - place, of_layer);
}

// Where the ends of a block of two by two pixels are in `ends`, in fours.
fn four_of_block(row: u32, block: vec2<u32>) -> u32 {
    let tile = block / (TILE / 2u);
    let first = row * table.ends_stride + (tile.y * tiles_of_image().x + tile.x) * (TILE * TILE);
    return (first + place_in_tile(block % (TILE / 2u) * 2u)) >> 2u;
}
