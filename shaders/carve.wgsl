// What each ray's end proves: the cells it frees and the endpoint of a return, marked in the slot of its placement.
// One invocation a ray, which marches again; bits are set with atomics, so the order of rays cannot matter.

@group(0) @binding(0) var<uniform> setup: Setup;
@group(0) @binding(1) var<uniform> part: Part;
@group(0) @binding(2) var<uniform> table: Table;
@group(0) @binding(3) var<storage, read> placements: array<Placement>;
@group(0) @binding(4) var<storage, read> dirs_q15: array<array<i32, 3>>;
@group(0) @binding(5) var<storage, read> ends: array<u32>;
@group(0) @binding(6) var<storage, read_write> occupied: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> free: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> done: array<atomic<u32>, KERNELS>;

fn carve_ray(slot: u32, begin: March, end: End) {
    let freed_cells = freed(end, table.no_return_is_free != 0u);
    var ray = begin;
    // From here on cells count from the window's corner.
    ray.cell -= vec3<i32>(setup.window_min_x, setup.window_min_y, setup.window_min_z);
    let size = vec3<u32>(setup.window_x, setup.window_y, setup.window_z);
    let row = i32(setup.window_words_per_row * 32u);
    let layer = row * i32(size.y);
    let strides = ray.step * vec3<i32>(1, row, layer);
    let plane = slot * setup.window_words;
    var bit = ray.cell.x + ray.cell.y * row + ray.cell.z * layer;
    for (var crossings = 0u; crossings < freed_cells; crossings += 1u) {
        // A negative coordinate is a huge unsigned one.
        if all(bitcast<vec3<u32>>(ray.cell) < size) {
            let word = plane + (u32(bit) >> 5u);
            let mask = 1u << (u32(bit) & 31u);
            // Most cells near a sensor are freed by many rays: looking is cheaper than another atomic write.
            if (atomicLoad(&free[word]) & mask) == 0u {
                atomicOr(&free[word], mask);
            }
        }
        let axis = next_axis(ray.next_q16);
        cross(&ray, axis);
        bit += select(select(strides.z, strides.y, axis == 1u), strides.x, axis == 0u);
    }
    // Outside the loop, since software adapters pay for every branch in it, taken or not. A return frees all but its
    // last cell, so the march is now in its endpoint.
    if end.kind == RETURN && all(bitcast<vec3<u32>>(ray.cell) < size) {
        atomicOr(&occupied[plane + (u32(bit) >> 5u)], 1u << (u32(bit) & 31u));
    }
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let ray = part.first + id.x;
    // No early return: the barrier below must see every invocation of the group.
    if ray < part.end {
        let row = part.first_row + id.y;
        let placement = placements[row];
        let end = unpacked(ends[row * table.rays + ray]);
        carve_ray(placement.slot, launch(placement, dirs_q15[ray]), end);
    }
    workgroupBarrier();
    if local == 0u {
        atomicAdd(&done[CARVE], 1u);
    }
}
