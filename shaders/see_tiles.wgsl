// Which tiles of a camera's pixels see boxes of voxels that matter, and how far the farthest of them reaches.
// An invocation projects a box; then all of a workgroup mark the tiles of each. Boxes that many tiles see are looked at again,
// a cube of four voxels an invocation.
//
// # Theory
// No ray of a tile that sees no box visits a voxel that matters, so what it hits and frees does not count. The cubes of a box
// hold its voxels, so all tiles that see the box see one of them.

@group(0) @binding(0) var<uniform> bound_setup: Setup;
@group(0) @binding(1) var<uniform> bound_part: Part;
@group(0) @binding(2) var<uniform> bound_table: Table;
@group(0) @binding(3) var<storage, read> placements: array<array<u32, PLACEMENT_WORDS>>;
@group(0) @binding(4) var<storage, read> boxes: array<u32>;
// How far in voxels what is seen reaches, or 0.
@group(0) @binding(5) var<storage, read_write> tiles: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

// Voxels along the edge of a box's cubes.
const CUBE_EDGE = BOX_EDGE / 2u;

// A rectangle of tiles: the word of `tiles` of the first, what to mark all of them with, how many there are in a row and in
// all.
struct TileRect {
    first: u32,
    value: u32,
    columns: u32,
    count: u32,
}

// Those of boxes, or of cubes.
var<workgroup> rects: array<TileRect, WORKGROUP>;
var<workgroup> rect_count: atomic<u32>;

// From more tiles on a box is large: marking its cubes apart spares `cast` more than it costs.
const LARGE_TILES = 16u * WORKGROUP;

// The large boxes, by their places in `boxes`. AT_ONCE of them have one cube for each invocation.
const AT_ONCE = WORKGROUP / CUBES;
var<workgroup> again: array<u32, WORKGROUP>;
var<workgroup> again_count: atomic<u32>;
var<workgroup> rounds: u32;

// How far a cube of `edge` voxels reaches along any ray.
fn reaches(projection: Projection, corner: vec3<i32>, edge: i32) -> u32 {
    let half = f32(edge) * 0.5;
    let distance = length(abs(vec3<f32>(corner) + half - projection.origin) + half);
    return u32(integer(floor(distance + 2.0 * deviation(distance) + 2.0)));
}

// Tiles of a rectangle of pixels, across and down.
fn tiles_across(first: vec2<i32>, last: vec2<i32>) -> vec2<u32> {
    return vec2<u32>(last) / TILE - vec2<u32>(first) / TILE + 1u;
}

// Lists the tiles of a rectangle of pixels to be marked, from a word of `tiles` on.
fn list_tiles(start: u32, first: vec2<i32>, last: vec2<i32>, value: u32) {
    let low = vec2<u32>(first) / TILE;
    let across = tiles_across(first, last);
    let count = across.x * across.y;
    // A box that so many see is rare, and may be seen by all.
    if count > MOST_SEEING {
        atomicMax(&tiles[start], value);
    } else {
        let first_tile = start + 1u + low.y * tiles_of_image().x + low.x;
        rects[atomicAdd(&rect_count, 1u)] = TileRect(first_tile, value, across.x, count);
    }
}

// The lowest voxel of a box in the grid.
fn corner_of(item: u32) -> vec3<i32> {
    return vec3<i32>(box_corner(boxes[item])) + vec3<i32>(setup.window_min_x, setup.window_min_y, setup.window_min_z);
}

// Lists the tiles that see a box, or the box itself if many see it.
fn list_box(projection: Projection, row: u32, item: u32) {
    let corner = corner_of(item);
    let rect = pixel_rect(projection, corner, i32(BOX_EDGE));
    let across = tiles_across(rect.first, rect.last);
    let is_large = across.x * across.y > LARGE_TILES;
    if rect.seen && !is_large {
        list_tiles(seen_from(row), rect.first, rect.last, reaches(projection, corner, i32(BOX_EDGE)));
    }
    if rect.seen && is_large {
        again[atomicAdd(&again_count, 1u)] = item;
    }
}

// Lists the tiles that see a cube of a box.
fn list_cube(projection: Projection, row: u32, box: u32, cube: u32) {
    let at = vec3<u32>(cube & 1u, (cube >> 1u) & 1u, cube >> 2u) * CUBE_EDGE;
    let corner = corner_of(box) + vec3<i32>(at);
    let rect = pixel_rect(projection, corner, i32(CUBE_EDGE));
    if rect.seen {
        list_tiles(seen_from(row), rect.first, rect.last, reaches(projection, corner, i32(CUBE_EDGE)));
    }
}

// Marks the tiles of all rectangles, for all invocations of a workgroup together.
fn mark_listed(local: u32) {
    workgroupBarrier();
    let across = tiles_of_image().x;
    let count = atomicLoad(&rect_count);
    var k = 0u;
    for (; k < count; k += 1u) {
        let rect = rects[k];
        var i = local;
        for (; i < rect.count; i += WORKGROUP) {
            atomicMax(&tiles[rect.first + i / rect.columns * across + i % rect.columns], rect.value);
        }
        loop_ended(opaque(i) >= rect.count);
    }
    loop_ended(opaque(k) >= count);
    workgroupBarrier();
    if local == 0u {
        atomicStore(&rect_count, 0u);
        rounds = (atomicLoad(&again_count) + AT_ONCE - 1u) / AT_ONCE;
    }
    workgroupBarrier();
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    setup = bound_setup;
    part = bound_part;
    table = bound_table;
    let row = part.first_row + group.y;
    let placement = placement_of(row, local);
    let projection = projection_of(placement.believed);
    let item = part.first + group.x * part.tiles + local;
    // No early return: `report` must see every invocation of the group.
    if local < part.tiles && item < part.end {
        list_box(projection, row, item);
    }
    mark_listed(local);
    let turns = workgroupUniformLoad(&rounds);
    var round = 0u;
    for (; round < turns; round += 1u) {
        let place = round * AT_ONCE + local / CUBES;
        if place < atomicLoad(&again_count) {
            list_cube(projection, row, again[place], local % CUBES);
        }
        mark_listed(local);
    }
    loop_ended(opaque(round) >= turns);
    report(SEE_TILES, local);
}
