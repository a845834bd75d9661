// Least and most voxels that the pixels of a camera free, over blocks of 8 × 8, 16 × 16, 32 × 32 and 64 × 64
// pixels, both in one word. One workgroup a block of the largest, one invocation a block of the smallest in
// it.
//
// # Theory
// The least of a block that holds a rectangle is at most the rectangle's least, and the most at least its
// most: both err on the side that decides nothing.

@group(0) @binding(0) var<uniform> setup: Setup;
@group(0) @binding(1) var<uniform> part: Part;
@group(0) @binding(2) var<uniform> table: Table;
@group(0) @binding(3) var<storage, read> ends: array<u32>;
@group(0) @binding(4) var<storage, read_write> pyramid: array<u32>;
@group(0) @binding(5) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

var<workgroup> blocks: array<u32, WORKGROUP>;

// Two words of least (lower half) and most as one.
fn joined(a: u32, b: u32) -> u32 {
    return min(a & 0xffffu, b & 0xffffu) | (max(a >> 16u, b >> 16u) << 16u);
}

// Least and most of the pixels of a block; of none, what changes nothing.
fn block(row: u32, corner: vec2<u32>) -> u32 {
    var word = 0xffffu;
    var i = 0u;
    for (; i < 64u; i += 1u) {
        let pixel = corner + vec2<u32>(i & 7u, i >> 3u);
        if pixel.x < table.image_x && pixel.y < table.image_y {
            let end = unpacked(ends[row * table.rays + pixel.y * table.image_x + pixel.x]);
            let voxels = freed(end, table.no_return_is_free != 0u);
            word = joined(word, voxels | (voxels << 16u));
        }
    }
    loop_ended(opaque(i) >= 64u);
    return word;
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let tiles = pyramid_tiles();
    let tile_index = part.first + group.x;
    let tile = vec2<u32>(tile_index % tiles.x, tile_index / tiles.x);
    let row = part.first_row + group.y;
    let start = row * pyramid_words(tiles);
    var side = 8u;
    var at = vec2<u32>(local & 7u, local >> 3u);
    var word = block(row, tile * 64u + at * 8u);
    var level = LEAST_LEVEL;
    for (; level <= MOST_LEVEL; level += 1u) {
        at = vec2<u32>(local % side, local / side);
        let inside = local < side * side;
        if inside && level > LEAST_LEVEL {
            let below = (at.y * 2u) * (side * 2u) + at.x * 2u;
            word = joined(
                joined(blocks[below], blocks[below + 1u]),
                joined(blocks[below + side * 2u], blocks[below + side * 2u + 1u]),
            );
        }
        workgroupBarrier();
        if inside {
            blocks[local] = word;
            let columns = tiles.x << (MOST_LEVEL - level);
            let here = tile * side + at;
            pyramid[start + level_start(tiles, level) + here.y * columns + here.x] = word;
        }
        workgroupBarrier();
        side /= 2u;
    }
    loop_ended(opaque(level) > MOST_LEVEL);
    report(PYRAMID, local);
}
