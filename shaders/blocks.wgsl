// What a camera's pixels free, by blocks of pixels: what `pyramid` makes, and the kernels that carve voxel by
// voxel look up. The kernel binds the pyramid as `pyramid`.

// The levels of a pyramid in its buffer: the largest blocks first, each level padded to whole blocks of the
// largest.

// Blocks of 2^MOST_LEVEL pixels across and down.
fn pyramid_tiles() -> vec2<u32> {
    return (vec2<u32>(table.image_x, table.image_y) + (1u << MOST_LEVEL) - 1u) >> vec2<u32>(MOST_LEVEL);
}

// Blocks before those of a level: 1 + 4 + 16 + … for each of the largest.
fn level_start(tiles: vec2<u32>, level: u32) -> u32 {
    return tiles.x * tiles.y * (((1u << (2u * (MOST_LEVEL - level))) - 1u) / 3u);
}

// Blocks of all levels.
fn pyramid_words(tiles: vec2<u32>) -> u32 {
    return tiles.x * tiles.y * (((1u << (2u * (MOST_LEVEL - LEAST_LEVEL + 1u))) - 1u) / 3u);
}

// Least and most that the pixels of a block free, of those of a level.
fn freed_by_block(row: u32, level: u32, block: vec2<u32>) -> vec2<u32> {
    let tiles = pyramid_tiles();
    let at = level_start(tiles, level) + block.y * (tiles.x << (MOST_LEVEL - level)) + block.x;
    let word = pyramid[row * pyramid_words(tiles) + at];
    return vec2<u32>(word & 0xffffu, word >> 16u);
}

// Least and most that the pixels of a rectangle free, or those of a little more. At most 25 turns of a loop:
// of rectangles too large for that it says nothing.
fn freed_range(row: u32, first: vec2<i32>, last: vec2<i32>) -> vec2<u32> {
    let tiles = pyramid_tiles();
    let wide = max(last.x - first.x, last.y - first.y);
    let vast = wide >= i32(4u << MOST_LEVEL);
    // At most five blocks on an axis, for rectangles of up to four of the largest.
    let level = clamp(u32(max(firstLeadingBit(wide), 0)), LEAST_LEVEL + 1u, MOST_LEVEL + 1u) - 1u;
    let columns = tiles.x << (MOST_LEVEL - level);
    let start = row * pyramid_words(tiles) + level_start(tiles, level);
    let low = vec2<u32>(first) >> vec2<u32>(level);
    let high = vec2<u32>(last) >> vec2<u32>(level);
    var least = 0xffffu;
    var most = 0u;
    var at = low;
    loop {
        let word = pyramid[start + at.y * columns + at.x];
        least = min(least, word & 0xffffu);
        most = max(most, word >> 16u);
        at.x += 1u;
        let next = at.x > high.x;
        at = select(at, vec2<u32>(low.x, at.y + 1u), next);
        if at.y > high.y || vast {
            break;
        }
    }
    loop_ended(vast || opaque(at.y) > high.y);
    return select(vec2<u32>(least, most), vec2<u32>(0u, 0xffffu), vast);
}
