// Which tiles of a camera's pixels see boxes of voxels that matter, and how far the farthest of them reaches.
// One invocation a box.
//
// # Theory
// No ray of a tile that sees no box visits a voxel that matters, so what it hits and frees does not count.

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
    return u32(distance + 2.0 * deviation(distance) + 2.0);
}

fn see(word: u32, reach: u32, near: bool) {
    atomicMax(&tiles[word], reach);
    if near {
        atomicMax(&tiles[word + near_from()], 1u);
    }
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
            let reach = reaches(projection, corner, i32(BOX_EDGE));
            let size = tiles_of_image();
            let first = vec2<u32>(pixel_rect.first) / TILE;
            let columns = u32(pixel_rect.last.x) / TILE - first.x + 1u;
            let seeing = columns * (u32(pixel_rect.last.y) / TILE - first.y + 1u);
            let start = seen_from(row);
            // A box that so many see is rare, and may be seen by all.
            let turns = select(seeing, 0u, seeing > MOST_SEEING);
            if turns == 0u {
                see(start, reach, pixel_rect.near);
            }
            var i = 0u;
            for (; i < turns; i += 1u) {
                let at = first + vec2<u32>(i % columns, i / columns);
                see(start + 1u + at.y * size.x + at.x, reach, pixel_rect.near);
            }
            loop_ended(opaque(i) >= turns);
        }
    }
    report(SEE_TILES, local);
}
