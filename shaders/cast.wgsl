// How each ray of each placement ends; where each return is read and what it hits, marked in the slot of its
// placement. An invocation takes its rays one after the other.

@group(0) @binding(0) var<uniform> bound_setup: Setup;
@group(0) @binding(1) var<uniform> bound_part: Part;
@group(0) @binding(2) var<uniform> bound_table: Table;
@group(0) @binding(3) var<storage, read> placements: array<array<u32, PLACEMENT_WORDS>>;
@group(0) @binding(4) var<storage, read> dirs: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> noise: array<i32>;
@group(0) @binding(6) var<storage, read> layer: array<u32>;
@group(0) @binding(7) var<storage, read> first_hits: array<u32>;
@group(0) @binding(8) var<storage, read_write> ends: array<u32>;
@group(0) @binding(9) var<storage, read_write> ended: array<atomic<u32>>;
@group(0) @binding(10) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

// Whether all rays go by tiles and where they are believed to, and nothing is known of what they hit. For such placements,
// which most are, the kernel is compiled once more: software adapters also pay for what is behind a branch that none takes.
override PLAIN: bool = false;

// Whether a ray may come near a box of voxels before it has gone so many voxels. In floats: the box is grown by 1.5 voxels on
// each side, of which the ray's place in its first voxel takes one, and its deviation (a quarter of a voxel at the longest
// range, src/march/march/deviation.rs) and the floats' rounding less than the other half.
fn comes_near(begin: March, corner: vec3<i32>, size: vec3<u32>, farthest: f32) -> bool {
    let low = vec3<f32>(corner - begin.voxel) - 1.5;
    let high = low + vec3<f32>(size) + 3.0;
    // Distance a voxel, which is the period; an axis that is never crossed gets one so long that its slab decides
    // alone.
    let period = select(vec3<f32>(begin.period_q16) * (1.0 / 65536.0), vec3<f32>(1e5), begin.step == vec3<i32>());
    let toward = select(period, -period, begin.step < vec3<i32>());
    let a = low * toward;
    let b = high * toward;
    let enters = max(min(a, b), vec3<f32>());
    let leaves = max(a, b);
    return max(enters.x, max(enters.y, enters.z)) <= min(min(leaves.x, farthest), min(leaves.y, leaves.z)) + 1.0;
}

// Whether it may come near the window, however far it goes.
fn comes_near_window(begin: March) -> bool {
    return comes_near(
        begin,
        vec3<i32>(setup.window_min_x, setup.window_min_y, setup.window_min_z),
        vec3<u32>(setup.window_x, setup.window_y, setup.window_z),
        1e6,
    );
}

// Whether a ray may enter a blocker of the layer that is bound, up to a distance. If these are the blockers that are not in the
// still layer, they are in two boxes, and most rays keep their first hits in the still layer without a search.
fn may_hit(sent: March, last_q16: u32) -> bool {
    if PLAIN || part.whole_layer != 0u {
        return true;
    }
    let farthest = f32(last_q16) * (1.0 / 65536.0);
    let corner = vec3<i32>(setup.moving_min_x, setup.moving_min_y, setup.moving_min_z);
    let other = vec3<i32>(setup.others_min_x, setup.others_min_y, setup.others_min_z);
    return comes_near(sent, corner, vec3<u32>(setup.moving_x, setup.moving_y, setup.moving_z), farthest)
        || comes_near(sent, other, vec3<u32>(setup.others_x, setup.others_y, setup.others_z), farthest);
}

// How far away blockers of a shade, from 1 to 7, are detected.
fn shade_range_q16(shade: u32) -> u32 {
    switch shade {
        case 1u: {
            return table.shade_range_1_q16;
        }
        case 2u: {
            return table.shade_range_2_q16;
        }
        case 3u: {
            return table.shade_range_3_q16;
        }
        case 4u: {
            return table.shade_range_4_q16;
        }
        case 5u: {
            return table.shade_range_5_q16;
        }
        case 6u: {
            return table.shade_range_6_q16;
        }
        default: {
            return table.shade_range_7_q16;
        }
    }
}

// Whether what a ray hit is too dark for its distance: the light that it returns is not detected.
fn is_too_weak(sent: March, slant: Slant, found: u32) -> bool {
    if table.shaded == 0u || setup.shades_word == 0u || found == NO_HIT {
        return false;
    }
    let hit_q16 = found >> 2u;
    let made = made_at3(sent.next_q16, sent.period_q16, sent.rate, hit_q16, i32(found & 3u));
    let shade = shade_of(sent.voxel + sent.step * vec3<i32>(made));
    return shade != 0u && hit_q16 > ray_range_q16(shade_range_q16(shade), slant.period_q16);
}

fn cast_ray(placement: GridPose, ray: u32, end_word: u32) {
    let dir = dirs[ray];
    let begin = launch(placement.believed, dir);
    let is_off = !PLAIN && placement.is_off != 0u;
    var sent = begin;
    if is_off {
        sent = launch(placement.truly, dir);
    }
    let slant = slant_of(dir);
    var last_q16 = slant.range_max_q16;
    var found = NO_HIT;
    if !PLAIN && placement.first_hits != NO_SLOT {
        found = first_hits[placement.first_hits * setup.first_hits_stride + ray];
        // Only what is found before counts, or at the same distance.
        last_q16 = min(last_q16, found >> 2u);
    }
    var end = End(NOTHING, 0u);
    // What is hit lies elsewhere than the ray is believed to go if the mount is off.
    if PLAIN || part.tiles != 0u || part.every_ray != 0u || is_off || comes_near_window(begin) {
        if may_hit(sent, last_q16) {
            found = min(found, first_hit(sent_on(sent, clear_q16(begin, of_tile)), last_q16));
        }
        let too_weak = !PLAIN && is_too_weak(sent, slant, found);
        let finish = finish(sent, begin, is_off, slant, found, too_weak, draw(placement.draws, ray));
        end = finish.end;
        if end.kind == RETURN {
            mark(2u * placement.slot, finish.voxel);
            mark(2u * placement.slot + 1u, finish.hit);
        }
    }
    ends[end_word] = packed(end);
}

// Whether the rays of a tile are to be cast.
fn is_wanted(row: u32, tile: u32) -> bool {
    of_tile = select(ends[word_of_tile(row, tile)], SENT, part.every_ray != 0u);
    return (of_tile & SENT) != 0u;
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
    loop {
        let run = next_run(row, group.x, local);
        var turn = 0u;
        loop {
            if turn < run.count {
                cast_ray(placement, run.first + turn * run.stride, word_of_turn(row, run, turn));
            }
            turn += 1u;
            if turn >= run.count {
                break;
            }
        }
        loop_ended(opaque(turn) >= run.count);
        if tiles_done >= part.tiles {
            break;
        }
    }
    loop_ended(opaque(tiles_done) >= part.tiles);
    report(CAST, local);
}
