// How each ray of each placement ends. One invocation a ray; the blockers cover the whole grid.

@group(0) @binding(0) var<uniform> setup: Setup;
@group(0) @binding(1) var<uniform> part: Part;
@group(0) @binding(2) var<uniform> table: Table;
@group(0) @binding(3) var<storage, read> placements: array<Placement>;
@group(0) @binding(4) var<storage, read> dirs_q15: array<array<i32, 3>>;
@group(0) @binding(5) var<storage, read> noise_q16: array<i32>;
@group(0) @binding(6) var<storage, read> blockers: array<u32>;
@group(0) @binding(7) var<storage, read_write> ends: array<u32>;
@group(0) @binding(8) var<storage, read_write> done: array<atomic<u32>, KERNELS>;

fn cast_ray(begin: March, step_q16: i32) -> End {
    var ray = begin;
    let size = vec3<u32>(setup.grid_x, setup.grid_y, setup.grid_z);
    let row = i32(setup.grid_words_per_row * 32u);
    let layer = row * i32(size.y);
    // A cell's bit and the crossings that stay inside the grid are kept up to date, so that a step costs additions.
    let strides = ray.step * vec3<i32>(1, row, layer);
    var bit = ray.cell.x + ray.cell.y * row + ray.cell.z * layer;
    let inside = room(begin, size);
    var left = vec3<i32>(inside);
    var crossings = 0u;
    var t = 0u;
    loop {
        let axis = next_axis(ray.next_q16);
        let crossed = vec3<u32>(axis) == vec3<u32>(0u, 1u, 2u);
        t = min(ray.next_q16.x, min(ray.next_q16.y, ray.next_q16.z));
        if t > table.range_max_q16 {
            return End(NOTHING, crossings);
        }
        left -= select(vec3<i32>(), vec3<i32>(1), crossed);
        if min(left.x, min(left.y, left.z)) < 0 {
            return End(select(NOTHING, LEFT, table.backdrop != 0u), crossings);
        }
        cross(&ray, axis);
        bit += select(select(strides.z, strides.y, crossed.y), strides.x, crossed.x);
        crossings += 1u;
        let blocked = ((blockers[bit >> 5u] >> (u32(bit) & 31u)) & 1u) != 0u;
        if blocked && t >= table.near_ignore_q16 {
            break;
        }
    }
    if t < table.range_min_q16 {
        return End(BLIND, crossings);
    }
    if step_q16 == 0 {
        return End(RETURN, crossings);
    }
    return End(RETURN, crossings_at(begin, inside, noisy_q16(t, step_q16)));
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
        var step_q16 = 0;
        if table.noisy != 0u {
            step_q16 = noise_q16[draw(placement.draws, ray)];
        }
        let end = cast_ray(launch(placement, dirs_q15[ray]), step_q16);
        ends[row * table.rays + ray] = packed(end);
    }
    workgroupBarrier();
    if local == 0u {
        atomicAdd(&done[CAST], 1u);
    }
}
