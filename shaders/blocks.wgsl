// The levels of a pyramid of blocks of a camera's pixels in its buffer: the largest blocks first, each level padded to whole
// blocks of the largest, and those to two by two. The four blocks that make one of the next level lie together, so that
// software adapters look them up at once.

// Blocks of 2^MOST_LEVEL pixels across and down, an even number.
fn pyramid_tiles() -> vec2<u32> {
    return ((vec2<u32>(table.image_x, table.image_y) + (2u << MOST_LEVEL) - 1u) >> vec2<u32>(MOST_LEVEL + 1u)) * 2u;
}

// Blocks before those of a level: 1 + 4 + 16 + … for each of the largest.
fn level_start(tiles: vec2<u32>, level: u32) -> u32 {
    return tiles.x * tiles.y * (((1u << (2u * (MOST_LEVEL - level))) - 1u) / 3u);
}

// Blocks of all levels.
fn pyramid_words(tiles: vec2<u32>) -> u32 {
    return tiles.x * tiles.y * (((1u << (2u * (MOST_LEVEL - LEAST_LEVEL + 1u))) - 1u) / 3u);
}

// The place of a block among those of its level.
fn block_at(tiles: vec2<u32>, level: u32, block: vec2<u32>) -> u32 {
    let fours = (block.y >> 1u) * ((tiles.x << (MOST_LEVEL - level)) >> 1u) + (block.x >> 1u);
    return (fours << 2u) | ((block.y & 1u) << 1u) | (block.x & 1u);
}
