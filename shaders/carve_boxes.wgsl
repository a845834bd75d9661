// Decides boxes of 8 × 8 × 8 voxels of a camera whole, where its pixels agree: marks what is free, and lists
// what is left for `carve_voxels`. One invocation a box.
//
// # Theory
// A ray has made as many crossings on reaching a voxel as the voxel is away from the sensor's voxel, counted
// along the axes (src/march/SEMANTICS.md, "Rays"), whatever the ray. So if no pixel that could see a box
// frees more voxels than its nearest voxel is away, nothing of it is free; if all free more than its farthest
// is away, and no voxel slips between the pixels, all of it is.

@group(0) @binding(0) var<uniform> bound_setup: Setup;
@group(0) @binding(1) var<uniform> bound_part: Part;
@group(0) @binding(2) var<uniform> bound_table: Table;
@group(0) @binding(3) var<storage, read> placements: array<array<u32, PLACEMENT_WORDS>>;
@group(0) @binding(4) var<storage, read> pyramid: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read> boxes: array<u32>;
// First the heads: the workgroups of each dispatch of `carve_voxels`; the first head also counts the boxes that are left.
// Then the boxes: the placement in the batch and the number of each.
@group(0) @binding(6) var<storage, read_write> undecided: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> free: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

// Boxes of the workgroup that are left, and where they begin in the list of all.
var<workgroup> left_here: atomic<u32>;
var<workgroup> first_place: u32;

// Reserves places for some boxes in the list, of two dispatches of `carve_voxels` at most, and returns the first. Their work is
// subtracted from their completion counters, which are zero again when all of it is done.
fn make_room(count: u32) -> u32 {
    let first = atomicAdd(&undecided[3], count);
    let dispatch = first / part.boxes_at_once;
    let of_first = min(count, (dispatch + 1u) * part.boxes_at_once - first);
    atomicAdd(&undecided[dispatch * HEAD_WORDS], of_first);
    if of_first < count {
        atomicAdd(&undecided[(dispatch + 1u) * HEAD_WORDS], count - of_first);
    }
    atomicSub(&done[CARVE_VOXELS], count);
    atomicSub(&done[KERNELS + CARVE_VOXELS], count * WORKGROUP);
    atomicAdd(&done[2u * KERNELS + CARVE_VOXELS], count);
    return first;
}

// Sets the voxels of a box, counted from the window's corner, that lie in the window.
fn fill(slot: u32, corner: vec3<u32>) {
    let mask = (0xffu >> (BOX_EDGE - min(BOX_EDGE, setup.window_x - corner.x))) << (corner.x & 31u);
    var i = 0u;
    for (; i < BOX_EDGE * BOX_EDGE; i += 1u) {
        let y = corner.y + i % BOX_EDGE;
        let z = corner.z + i / BOX_EDGE;
        if y < setup.window_y && z < setup.window_z {
            let row = (z * setup.window_y + y) * setup.window_words_per_row;
            atomicOr(&free[slot * setup.window_words + row + (corner.x >> 5u)], mask);
        }
    }
    loop_ended(opaque(i) >= BOX_EDGE * BOX_EDGE);
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
    var is_left = false;
    var place = 0u;
    // No early return: `report` must see every invocation of the group.
    if item < part.end {
        let own = vec3_of(placement.believed.origin_q16) >> vec3<u32>(16u);
        let in_window = box_corner(boxes[item]);
        let corner = vec3<i32>(in_window) + vec3<i32>(setup.window_min_x, setup.window_min_y, setup.window_min_z);
        let edge = i32(BOX_EDGE);
        let pixel_rect = pixel_rect(projection_of(placement.believed), corner, edge);
        if pixel_rect.seen {
            let freed = freed_range(row, pixel_rect.first, pixel_rect.last);
            let away = away(own, corner, edge);
            if freed.y > away.x {
                if pixel_rect.dense && freed.x > away.y {
                    fill(placement.slot, in_window);
                } else {
                    is_left = true;
                    place = atomicAdd(&left_here, 1u);
                }
            }
        }
    }
    workgroupBarrier();
    let count = atomicLoad(&left_here);
    if local == 0u && count > 0u {
        first_place = make_room(count);
    }
    workgroupBarrier();
    if is_left {
        atomicStore(&undecided[UNDECIDED_FIRST + first_place + place], (row << BOX_BITS) | boxes[item]);
    }
    report(CARVE_BOXES, local);
}
