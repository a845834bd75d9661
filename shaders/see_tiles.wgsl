// Which tiles of a camera's pixels see boxes of voxels that matter, and how far the farthest of them reaches.
// One invocation a box.
//
// # Theory
// No ray of a tile that sees no box visits a voxel that matters, so what it hits and frees does not count.
//
// Voxels that are near are left to `carve_rays`, which follows the rays of the tiles that see some. If a voxel is near, so is
// its cube of two, and so is the box; and the pixels that may see it are among those that may see its cube (`projection.wgsl`).

@group(0) @binding(0) var<uniform> bound_setup: Setup;
@group(0) @binding(1) var<uniform> bound_part: Part;
@group(0) @binding(2) var<uniform> bound_table: Table;
@group(0) @binding(3) var<storage, read> placements: array<array<u32, PLACEMENT_WORDS>>;
@group(0) @binding(4) var<storage, read> boxes: array<u32>;
// How far in voxels what is seen reaches, or 0; and whether some of it is near.
@group(0) @binding(5) var<storage, read_write> tiles: array<atomic<u32>>;
@group(0) @binding(6) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

// How far a cube of `edge` voxels reaches along any ray.
fn reaches(projection: Projection, corner: vec3<i32>, edge: i32) -> u32 {
    let half = f32(edge) * 0.5;
    let distance = length(abs(vec3<f32>(corner) + half - projection.origin) + half);
    return u32(integer(floor(distance + 2.0 * deviation(distance) + 2.0)));
}

// Marks the tiles of a rectangle of pixels, from a word of `tiles` on; none with 0.
fn mark_tiles(start: u32, first: vec2<i32>, last: vec2<i32>, value: u32) {
    let size = tiles_of_image();
    let low = vec2<u32>(first) / TILE;
    let columns = u32(last.x) / TILE - low.x + 1u;
    let seeing = select(0u, columns * (u32(last.y) / TILE - low.y + 1u), value > 0u);
    // A box that so many see is rare, and may be seen by all.
    let vast = seeing > MOST_SEEING;
    if vast {
        atomicMax(&tiles[start], value);
    }
    let turns = select(seeing, 0u, vast);
    var i = 0u;
    for (; i < turns; i += 1u) {
        let at = low + vec2<u32>(i % columns, i / columns);
        atomicMax(&tiles[start + 1u + at.y * size.x + at.x], value);
    }
    loop_ended(opaque(i) >= turns);
}

// The pixels that may see near voxels of a box, as a rectangle around those of its cubes of two: next to a sensor, a whole box
// is seen by nearly all pixels, though most look past what is near of it.
fn near_rect(projection: Projection, corner: vec3<i32>, of_box: PixelRect) -> PixelRect {
    var rect = of_box;
    rect.first = of_box.last;
    rect.last = of_box.first;
    rect.seen = false;
    let edge = BOX_EDGE / 2u;
    let cubes = select(0u, edge * edge * edge, of_box.near);
    var i = 0u;
    for (; i < cubes; i += 1u) {
        let at = vec3<u32>(i % edge, i / edge % edge, i / (edge * edge)) * 2u;
        let cube = pixel_rect(projection, corner + vec3<i32>(at), 2);
        let is_near = cube.seen && cube.near;
        rect.first = select(rect.first, min(rect.first, cube.first), is_near);
        rect.last = select(rect.last, max(rect.last, cube.last), is_near);
        rect.seen = rect.seen || is_near;
    }
    loop_ended(opaque(i) >= cubes);
    return rect;
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    setup = bound_setup;
    part = bound_part;
    table = bound_table;
    let row = part.first_row + group.y;
    let placement = placement_of(row, local);
    let item = part.first + id.x;
    // No early return: `report` must see every invocation of the group.
    if item < part.end {
        let projection = projection_of(placement.believed);
        let corner = vec3<i32>(box_corner(boxes[item])) + vec3<i32>(setup.window_min_x, setup.window_min_y, setup.window_min_z);
        let pixel_rect = pixel_rect(projection, corner, i32(BOX_EDGE));
        if pixel_rect.seen {
            let start = seen_from(row);
            mark_tiles(start, pixel_rect.first, pixel_rect.last, reaches(projection, corner, i32(BOX_EDGE)));
            let near = near_rect(projection, corner, pixel_rect);
            mark_tiles(start + near_from(), near.first, near.last, u32(near.seen));
        }
    }
    report(SEE_TILES, local);
}
