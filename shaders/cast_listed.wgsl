// How the rays of the tiles that `cast_tiles` leaves open end, as `cast` finds it for plain placements. A workgroup takes tiles of
// a placement's lists that lie as far apart as it has groups, an invocation a pixel of each.
//
// # Theory
// Where `cast_tiles` has proved that all rays of a tile enter a layer of blockers, and none before it, a ray hits that layer
// when it crosses into it: nothing is searched.
//
// # Practice
// The lists hold what is searched first, then what is sent to a layer: lanes next to each other work equally long. Ends are
// written 64 words in a row.

@group(0) @binding(0) var<uniform> bound_setup: Setup;
@group(0) @binding(1) var<uniform> bound_part: Part;
@group(0) @binding(2) var<uniform> bound_table: Table;
@group(0) @binding(3) var<storage, read> placements: array<array<u32, PLACEMENT_WORDS>>;
@group(0) @binding(4) var<storage, read> dirs: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> noise: array<i32>;
@group(0) @binding(6) var<storage, read> layer: array<u32>;
@group(0) @binding(7) var<storage, read> listed: array<u32>;
@group(0) @binding(8) var<storage, read_write> ends: array<u32>;
@group(0) @binding(9) var<storage, read_write> ended: array<atomic<u32>>;
@group(0) @binding(10) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

// What a ray of a tile hits first, in a word that orders by distance as that of `first_hit`.
fn hit_of(begin: March, known: u32, last_q16: u32) -> u32 {
    if (known & SENT_TO_LAYER) == 0u {
        return first_hit(sent_on(begin, clear_q16(begin, known)), last_q16);
    }
    let t_q16 = u32(enters_layer_q16(begin, known));
    return select(NO_HIT, (t_q16 << 2u) | axis_of_layer(known), t_q16 <= last_q16);
}

// Casts the ray of an invocation's pixel of a tile.
fn cast_pixel(placement: GridPose, row: u32, tile: u32, local: u32) {
    let across = tiles_of_image().x;
    let pixel = vec2<u32>(tile % across, tile / across) * TILE + pixel_at(local);
    if pixel.x < table.image_x && pixel.y < table.image_y {
        let ray = pixel.y * table.image_x + pixel.x;
        let dir = dirs[ray];
        let begin = launch(placement.believed, dir);
        let slant = slant_of(dir);
        let found = hit_of(begin, ends[word_of_tile(row, tile)], slant.range_max_q16);
        let finish = finish(begin, begin, false, slant, found, false, draw(placement.draws, ray));
        if finish.end.kind == RETURN {
            mark(2u * placement.slot, finish.voxel);
            mark(2u * placement.slot + 1u, finish.hit);
        }
        ends[row * table.ends_stride + tile * (TILE * TILE) + local] = packed(finish.end);
    }
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
    let searched = listed[head_of_lists(row)];
    let count = searched + listed[head_of_lists(row) + 1u];
    var i = part.first + group.x;
    loop {
        if i < count {
            let of_layer = i >= searched;
            cast_pixel(placement, row, listed[word_of_list(row, select(i, i - searched, of_layer), of_layer)], local);
        }
        i += part.tiles;
        if i >= count {
            break;
        }
    }
    loop_ended(opaque(i) >= count);
    report(CAST_LISTED, local);
}
