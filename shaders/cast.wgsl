// How each ray of each placement ends; where each return is read and what it hits, marked in the slot of its placement. One
// invocation a ray.

@group(0) @binding(0) var<uniform> setup: Setup;
@group(0) @binding(1) var<uniform> part: Part;
@group(0) @binding(2) var<uniform> table: Table;
@group(0) @binding(3) var<storage, read> placements: array<Placement>;
@group(0) @binding(4) var<storage, read> dirs_q15: array<array<i32, 3>>;
@group(0) @binding(5) var<storage, read> noise_q16: array<i32>;
@group(0) @binding(6) var<storage, read> layer: array<u32>;
@group(0) @binding(7) var<storage, read> first_hits: array<u32>;
@group(0) @binding(8) var<storage, read_write> ends: array<u32>;
@group(0) @binding(9) var<storage, read_write> ended: array<atomic<u32>>;
@group(0) @binding(10) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

// How a ray ended, in which cell it is read, and in which a return has its blocker.
struct Finish {
    end: End,
    cell: vec3<i32>,
    hit: vec3<i32>,
}

fn finish(begin: March, struck: u32, step_q16: i32) -> Finish {
    let nothing = struck == NO_HIT;
    let hit_q16 = struck >> 2u;
    var kind = select(RETURN, BLIND, hit_q16 < table.range_min_q16);
    // Where it is read: at the crossing into the blocker, with noise after all crossings up to there.
    let exact = kind == BLIND || step_q16 == 0;
    let read_q16 = select(noisy_q16(hit_q16, step_q16), hit_q16, exact);
    let read_axis = select(2, i32(struck & 3u), exact);
    let stand = made_until(
        begin,
        room(begin, vec3<u32>(setup.grid_x, setup.grid_y, setup.grid_z)),
        select(read_q16, table.range_max_q16, nothing),
        select(read_axis, 2, nothing),
    );
    let left = stand.stopped && table.backdrop != 0u;
    kind = select(kind, select(NOTHING, LEFT, left), nothing);
    let cell = begin.cell + begin.step * vec3<i32>(stand.made);
    var hit = cell;
    if !exact {
        let made = made_at3(begin.next_q16, begin.period_q16, hit_q16, i32(struck & 3u));
        hit = begin.cell + begin.step * vec3<i32>(made);
    }
    return Finish(End(kind, stand.made.x + stand.made.y + stand.made.z), cell, hit);
}

// Whether a ray may come near the window. In floats: the window is grown by 1.5 voxels on each side, of which the ray's place in its
// first cell takes one, and its stray (10⁻⁴ of the distance) and the floats' rounding less than the other half.
fn comes_near(begin: March) -> bool {
    let low = vec3<f32>(vec3<i32>(setup.window_min_x, setup.window_min_y, setup.window_min_z) - begin.cell) - 1.5;
    let high = low + vec3<f32>(vec3<u32>(setup.window_x, setup.window_y, setup.window_z)) + 3.0;
    // Voxels a unit of distance; an axis that is hardly crossed gets a period so long that its slab decides alone.
    let period = vec3<f32>(begin.period_q16) * (1.0 / 65536.0);
    let speed = vec3<f32>(begin.step) / period;
    let toward = select(vec3<f32>(-1.0), vec3<f32>(1.0), begin.step >= vec3<i32>()) / max(abs(speed), vec3<f32>(1e-5));
    let a = low * toward;
    let b = high * toward;
    let enters = max(min(a, b), vec3<f32>());
    let leaves = max(a, b);
    return max(enters.x, max(enters.y, enters.z)) <= min(leaves.x, min(leaves.y, leaves.z)) + 1.0;
}

// Marks a cell in a plane of `ended`: planes 2 · slot and 2 · slot + 1 are a slot's occupied voxels and its hits.
fn mark(plane: u32, cell: vec3<i32>) {
    let at = cell - vec3<i32>(setup.window_min_x, setup.window_min_y, setup.window_min_z);
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

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let ray = part.first + id.x;
    // No early return: `report` must see every invocation of the group.
    if ray < part.end {
        let row = part.first_row + id.y;
        let placement = placements[row];
        let begin = launch(placement, dirs_q15[ray]);
        var end = End(NOTHING, 0u);
        var last_q16 = table.range_max_q16;
        var struck = NO_HIT;
        if placement.first_hits != NO_SLOT {
            struck = first_hits[placement.first_hits * setup.first_hits_stride + ray];
            // Only what is struck before counts, or at the same distance.
            last_q16 = min(last_q16, struck >> 2u);
        }
        let near = part.every_ray != 0u || comes_near(begin);
        if near {
            struck = min(struck, strike(begin, last_q16));
            var step_q16 = 0;
            if table.noisy != 0u {
                step_q16 = noise_q16[draw(placement.draws, ray)];
            }
            let finish = finish(begin, struck, step_q16);
            end = finish.end;
            if end.kind == RETURN {
                mark(2u * placement.slot, finish.cell);
                mark(2u * placement.slot + 1u, finish.hit);
            }
        }
        ends[row * table.rays + ray] = packed(end);
    }
    report(CAST, local);
}
