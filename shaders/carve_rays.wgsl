// Marks the voxels that each ray frees, one after the other, from where it enters the window to where it
// leaves it. An invocation takes its rays one after the other; bits are set with atomics, so the order of rays
// cannot matter.
//
// # Theory
// A ray enters a box when it has entered on every axis: that is a crossing, whose place is known in closed
// form.
//
// # Practice
// For sensors with few rays, where looking from each voxel at the rays would cost more.

@group(0) @binding(0) var<uniform> bound_setup: Setup;
@group(0) @binding(1) var<uniform> bound_part: Part;
@group(0) @binding(2) var<uniform> bound_table: Table;
@group(0) @binding(3) var<storage, read> placements: array<array<u32, PLACEMENT_WORDS>>;
@group(0) @binding(4) var<storage, read> dirs: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> ends: array<u32>;
@group(0) @binding(6) var<storage, read_write> free: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

// The crossings made when a ray has entered the window on every axis: none if it begins inside. Where it
// never comes there, or has left again, the voxel that it is in then is outside.
fn entered(begin: March, low: vec3<i32>, high: vec3<i32>) -> vec3<u32> {
    let short = max(max(low - begin.voxel, begin.voxel - high), vec3<i32>());
    let enters = enters3_q16(begin.next_q16, begin.period_q16, vec3<u32>(short));
    let t = max(enters.x, max(enters.y, enters.z));
    let axis = select(select(0, 1, enters.y == t), 2, enters.z == t);
    let made = made_at3(begin.next_q16, begin.period_q16, begin.rate, u32(t), axis);
    return select(made, vec3<u32>(), vec3<bool>(t < 0 || t > i32(FARTHEST_READ_Q16)));
}

fn mark_freed(slot: u32, begin: March, voxels: u32) {
    let size = vec3<i32>(vec3<u32>(setup.window_x, setup.window_y, setup.window_z));
    let low = vec3<i32>(setup.window_min_x, setup.window_min_y, setup.window_min_z);
    let made = entered(begin, low, low + size - 1);
    var ray = begin;
    // From here on voxels count from the window's corner.
    ray.voxel += ray.step * vec3<i32>(made) - low;
    ray.next_q16 += made * ray.period_q16;
    let row = i32(setup.window_words_per_row * 32u);
    let layer = row * size.y;
    let strides = ray.step * vec3<i32>(1, row, layer);
    let plane = slot * setup.window_words;
    var bit = ray.voxel.x + ray.voxel.y * row + ray.voxel.z * layer;
    var left = select(size - 1 - ray.voxel, ray.voxel, ray.step < vec3<i32>());
    // A negative coordinate is a huge unsigned one.
    var inside = all(bitcast<vec3<u32>>(ray.voxel) < vec3<u32>(size));
    var crossings = made.x + made.y + made.z;
    loop {
        if !inside || crossings >= voxels {
            break;
        }
        let word = plane + (u32(bit) >> 5u);
        let mask = 1u << (u32(bit) & 31u);
        // Most voxels near a sensor are freed by many rays: looking is cheaper than another atomic write.
        if (atomicLoad(&free[word]) & mask) == 0u {
            atomicOr(&free[word], mask);
        }
        let axis = next_axis(ray.next_q16);
        let crossed = vec3<u32>(axis) == vec3<u32>(0u, 1u, 2u);
        left -= select(vec3<i32>(), vec3<i32>(1), crossed);
        inside = min(left.x, min(left.y, left.z)) >= 0;
        ray.next_q16 += select(vec3<u32>(), ray.period_q16, crossed);
        bit += select(select(strides.z, strides.y, crossed.y), strides.x, crossed.x);
        crossings += 1u;
    }
    loop_ended(!inside || opaque(crossings) >= voxels);
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
    // Rays that lie apart: neighbours take neighbouring rays.
    let first = part.first + group.x * WORKGROUP * TILE + local / TILE * TILE * TILE + local % TILE;
    let end = min(part.end, first + TILE * TILE);
    var ray = first;
    for (; ray < end; ray += TILE) {
        let voxels = freed(unpacked(ends[row * table.ends_stride + ray]), table.no_return_is_free != 0u);
        mark_freed(placement.slot, launch(placement.believed, dirs[ray]), voxels);
    }
    loop_ended(opaque(ray) >= end);
    report(CARVE_RAYS, local);
}
