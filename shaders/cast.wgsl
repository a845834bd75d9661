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

// How a ray ended, in which voxel it is read, and in which a return has its blocker.
struct Finish {
    end: End,
    voxel: vec3<i32>,
    hit: vec3<i32>,
}

// How a ray is slanted to what its sensor measures along, and its longest range.
struct Slant {
    axial_q16: u32,
    period_q16: u32,
    range_max_q16: u32,
}

fn slant_of(dir: vec2<u32>) -> Slant {
    let axial_q16 = axial_of(dir);
    let period_q16 = period_q16(axial_q16);
    return Slant(axial_q16, period_q16, ray_range_q16(table.range_max_q16, period_q16));
}

// What a return at a distance is off by: the unit table comes first in the buffer.
fn off_by_q16(slant: Slant, drawn: u32, t_q16: u32) -> i32 {
    if table.noisy == 0u {
        return 0;
    }
    let rate = rate3(vec3<i32>(i32(slant.axial_q16))).x;
    let std_q16 = u32(noise[NOISE_STEPS + periods_in(t_q16, slant.period_q16, rate)]);
    return step_q16(noise[entry(drawn)], std_along_q16(std_q16, slant.period_q16));
}

// `sent` is the ray that is truly cast; `begin` the same as it is believed to go, another where the mount is
// off.
fn finish(sent: March, begin: March, is_off: bool, slant: Slant, found: u32, drawn: u32) -> Finish {
    let size = vec3<u32>(setup.grid_x, setup.grid_y, setup.grid_z);
    let hit_q16 = found >> 2u;
    let blind = found != NO_HIT && hit_q16 < ray_range_q16(table.range_min_q16, slant.period_q16);
    let lost = is_lost(drawn, table.lost_below) && !blind;
    let nothing = found == NO_HIT || lost;
    var kind = select(RETURN, BLIND, blind);
    var step_q16 = 0;
    if !nothing {
        step_q16 = off_by_q16(slant, drawn, hit_q16);
    }
    // Where it is read: at the crossing into the blocker; with noise, or on a ray that is only believed,
    // after all crossings up to there.
    let exact = !is_off && (blind || step_q16 == 0);
    let read_q16 = select(noisy_q16(hit_q16, step_q16), hit_q16, blind || step_q16 == 0);
    let read_axis = select(2, i32(found & 3u), exact);
    let stand = made_until(
        begin,
        room(begin, size),
        select(read_q16, slant.range_max_q16, nothing),
        select(read_axis, 2, nothing),
    );
    var stopped = stand.stopped;
    if is_off {
        stopped = made_until(sent, room(sent, size), slant.range_max_q16, 2).stopped;
    }
    let left = stopped && table.backdrop != 0u && !lost;
    kind = select(kind, select(NOTHING, LEFT, left), nothing);
    let voxel = begin.voxel + begin.step * vec3<i32>(stand.made);
    var hit = voxel;
    if !exact {
        let made = made_at3(sent.next_q16, sent.period_q16, sent.rate, hit_q16, i32(found & 3u));
        hit = sent.voxel + sent.step * vec3<i32>(made);
    }
    return Finish(End(kind, stand.made.x + stand.made.y + stand.made.z), voxel, hit);
}

// Whether a ray may come near the window. In floats: the window is grown by 1.5 voxels on each side, of which
// the ray's place in its first voxel takes one, and its deviation (a quarter of a voxel at the longest range,
// src/march/march/deviation.rs) and the floats' rounding less than the other half.
fn comes_near(begin: March) -> bool {
    let low = vec3<f32>(vec3<i32>(setup.window_min_x, setup.window_min_y, setup.window_min_z) - begin.voxel) - 1.5;
    let high = low + vec3<f32>(vec3<u32>(setup.window_x, setup.window_y, setup.window_z)) + 3.0;
    // Distance a voxel, which is the period; an axis that is never crossed gets one so long that its slab decides
    // alone.
    let period = select(vec3<f32>(begin.period_q16) * (1.0 / 65536.0), vec3<f32>(1e5), begin.step == vec3<i32>());
    let toward = select(period, -period, begin.step < vec3<i32>());
    let a = low * toward;
    let b = high * toward;
    let enters = max(min(a, b), vec3<f32>());
    let leaves = max(a, b);
    return max(enters.x, max(enters.y, enters.z)) <= min(leaves.x, min(leaves.y, leaves.z)) + 1.0;
}

// Marks a voxel in a plane of `ended`: planes 2 · slot and 2 · slot + 1 are a slot's occupied voxels and its
// hits.
fn mark(plane: u32, voxel: vec3<i32>) {
    let at = voxel - vec3<i32>(setup.window_min_x, setup.window_min_y, setup.window_min_z);
    if all(bitcast<vec3<u32>>(at) < vec3<u32>(setup.window_x, setup.window_y, setup.window_z)) {
        let row = u32(at.z) * setup.window_y + u32(at.y);
        let word = plane * setup.window_words + row * setup.window_words_per_row + (u32(at.x) >> 5u);
        let mask = 1u << (u32(at.x) & 31u);
        // Many rays end in the same voxel: looking is cheaper than another atomic write.
        if (atomicLoad(&ended[word]) & mask) == 0u {
            atomicOr(&ended[word], mask);
        }
    }
}

// Up to which distance a ray of a tile has entered no blocker.
fn clear_q16(begin: March) -> u32 {
    let known = of_tile & ~SENT;
    if (known & SENT_TO_LAYER) == 0u {
        return known;
    }
    let own = vec3<u32>((known & ~SENT_TO_LAYER) >> LAYER_BITS) == vec3<u32>(0u, 1u, 2u);
    let ahead = abs(vec3<i32>(i32(known & ((1u << LAYER_BITS) - 1u))) - begin.voxel);
    let enters = enters3_q16(begin.next_q16, begin.period_q16, select(vec3<u32>(), vec3<u32>(ahead), own));
    return u32(clamp(max(enters.x, max(enters.y, enters.z)) - 1, 0, i32(table.range_max_q16)));
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
    if PLAIN || part.tiles != 0u || part.every_ray != 0u || is_off || comes_near(begin) {
        found = min(found, first_hit(sent_on(sent, clear_q16(begin)), last_q16));
        let finish = finish(sent, begin, is_off, slant, found, draw(placement.draws, ray));
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
