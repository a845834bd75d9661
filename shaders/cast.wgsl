// How each ray of each placement ends. One invocation a ray; the blockers cover the whole grid.

@group(0) @binding(0) var<uniform> setup: Setup;
@group(0) @binding(1) var<uniform> part: Part;
@group(0) @binding(2) var<storage, read> placements: array<Placement>;
@group(0) @binding(3) var<storage, read> dirs_q15: array<array<i32, 3>>;
@group(0) @binding(4) var<storage, read> blockers: array<u32>;
@group(0) @binding(5) var<storage, read_write> ends: array<u32>;
@group(0) @binding(6) var<storage, read_write> done: array<atomic<u32>, KERNELS>;

fn cast_ray(begin: March) -> End {
    var ray = begin;
    let size = vec3<i32>(vec3<u32>(setup.grid_x, setup.grid_y, setup.grid_z));
    let row = i32(setup.grid_words_per_row * 32u);
    let layer = row * size.y;
    // A cell's bit and the crossings that stay inside the grid are kept up to date, so that a step costs additions.
    let strides = ray.step * vec3<i32>(1, row, layer);
    var bit = ray.cell.x + ray.cell.y * row + ray.cell.z * layer;
    var room = select(size - 1 - ray.cell, ray.cell, ray.step < vec3<i32>());
    var crossings = 0u;
    loop {
        let axis = next_axis(ray.next_q16);
        let crossed = vec3<u32>(axis) == vec3<u32>(0u, 1u, 2u);
        let t = min(ray.next_q16.x, min(ray.next_q16.y, ray.next_q16.z));
        if t > setup.range_max_q16 {
            return End(NOTHING, crossings);
        }
        room -= select(vec3<i32>(), vec3<i32>(1), crossed);
        if min(room.x, min(room.y, room.z)) < 0 {
            return End(select(NOTHING, LEFT, setup.backdrop != 0u), crossings);
        }
        cross(&ray, axis);
        bit += select(select(strides.z, strides.y, crossed.y), strides.x, crossed.x);
        crossings += 1u;
        let blocked = ((blockers[bit >> 5u] >> (u32(bit) & 31u)) & 1u) != 0u;
        if blocked && t >= setup.near_ignore_q16 {
            return End(select(RETURN, BLIND, t < setup.range_min_q16), crossings);
        }
    }
    // Not reached; WGSL asks for it.
    return End(NOTHING, crossings);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let ray = part.first + id.x;
    // No early return: the barrier below must see every invocation of the group.
    if ray < part.end {
        let slot = part.first_placement + id.y;
        let end = cast_ray(launch(placements[slot], dirs_q15[ray]));
        ends[slot * setup.rays + ray] = packed(end);
    }
    workgroupBarrier();
    if local == 0u {
        atomicAdd(&done[CAST], 1u);
    }
}
