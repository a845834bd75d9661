// Least and most voxels that the pixels of a camera free, over blocks of 2 × 2, 4 × 4, … and 64 × 64 pixels,
// both in one word. One workgroup a block of the largest, one invocation a tile in it.
//
// # Theory
// The least of a block that holds a rectangle is at most the rectangle's least, and the most at least its
// most: both err on the side that decides nothing.

@group(0) @binding(0) var<uniform> bound_setup: Setup;
@group(0) @binding(1) var<uniform> bound_part: Part;
@group(0) @binding(2) var<uniform> bound_table: Table;
@group(0) @binding(3) var<storage, read> ends: array<vec4<u32>>;
@group(0) @binding(4) var<storage, read_write> pyramid: array<u32>;
@group(0) @binding(5) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

var<workgroup> blocks: array<u32, WORKGROUP>;

// Two words of least (lower half) and most as one.
fn joined(a: u32, b: u32) -> u32 {
    return min(a & 0xffffu, b & 0xffffu) | (max(a >> 16u, b >> 16u) << 16u);
}

// Least and most of two by two pixels.
fn of_block(row: u32, block: vec2<u32>) -> u32 {
    let words = ends[four_of_block(row, block)];
    let pixel = block * 2u;
    let left = pixel.x < table.image_x;
    let right = pixel.x + 1u < table.image_x;
    let upper = pixel.y < table.image_y;
    let lower = pixel.y + 1u < table.image_y;
    return joined(
        joined(of_end(words.x, left && upper), of_end(words.y, right && upper)),
        joined(of_end(words.z, left && lower), of_end(words.w, right && lower)),
    );
}

// Least and most of a pixel; of one outside the image, what changes nothing.
fn of_end(word: u32, inside: bool) -> u32 {
    let voxels = freed(unpacked(word), table.no_return_is_free != 0u);
    return select(0xffffu, voxels | (voxels << 16u), inside);
}

// Least and most of the pixels of a tile, whose smaller blocks are written, unless they free nothing.
fn of_tile(row: u32, tile: vec2<u32>) -> u32 {
    let across = tiles_of_image();
    let inside = all(tile < across);
    let own_word = select(0u, word_of_tile(row, tile.y * across.x + tile.x), inside);
    let known = ends[own_word >> 2u][own_word & 3u];
    // Whether its pixels are to be looked at one by one.
    let apart = inside && (part.every_ray != 0u || (known & SENT) != 0u);
    let whole = of_end(known, inside);
    let tiles = pyramid_tiles();
    let start = row * pyramid_words(tiles);
    let small = start + level_start(tiles, LEAST_LEVEL);
    let large = start + level_start(tiles, LEAST_LEVEL + 1u) + block_at(tiles, LEAST_LEVEL + 1u, tile * 2u);
    let turns = select(0u, 4u, apart || whole > 0xffffu);
    var of_all = select(whole, 0xffffu, turns > 0u);
    var i = 0u;
    for (; i < turns; i += 1u) {
        let at = (tile * 2u + vec2<u32>(i & 1u, i >> 1u)) * 2u;
        let four = small + block_at(tiles, LEAST_LEVEL, at);
        var of_four = 0xffffu;
        var k = 0u;
        for (; k < 4u; k += 1u) {
            var word = whole;
            if apart {
                word = of_block(row, at + vec2<u32>(k & 1u, k >> 1u));
            }
            pyramid[four + k] = word;
            of_four = joined(of_four, word);
        }
        loop_ended(opaque(k) >= 4u);
        pyramid[large + i] = of_four;
        of_all = joined(of_all, of_four);
    }
    loop_ended(opaque(i) >= turns);
    return of_all;
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    setup = bound_setup;
    part = bound_part;
    table = bound_table;
    let tiles = pyramid_tiles();
    let tile_index = part.first + group.x;
    let tile = vec2<u32>(tile_index % tiles.x, tile_index / tiles.x);
    let row = part.first_row + group.y;
    let start = row * pyramid_words(tiles);
    var side = 8u;
    var at = vec2<u32>(local & 7u, local >> 3u);
    var word = of_tile(row, tile * 8u + at);
    var level = TILE_LEVEL;
    for (; level <= MOST_LEVEL; level += 1u) {
        at = vec2<u32>(local % side, local / side);
        let inside = local < side * side;
        if inside && level > TILE_LEVEL {
            let below = (at.y * 2u) * (side * 2u) + at.x * 2u;
            word = joined(
                joined(blocks[below], blocks[below + 1u]),
                joined(blocks[below + side * 2u], blocks[below + side * 2u + 1u]),
            );
        }
        workgroupBarrier();
        if inside {
            blocks[local] = word;
            pyramid[start + level_start(tiles, level) + block_at(tiles, level, tile * side + at)] = word;
        }
        workgroupBarrier();
        side /= 2u;
    }
    loop_ended(opaque(level) > MOST_LEVEL);
    report(PYRAMID, local);
}
