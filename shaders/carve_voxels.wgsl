// Decides the boxes that `carve_boxes` left: whole cubes of 2 × 2 × 2 voxels, as boxes are, and the voxels of the other
// cubes as far as blocks of pixels tell. Voxels whose pixels must be asked are listed for `carve_crowded`, near ones for
// `carve_near`. One workgroup a box.
//
// # Theory
// A voxel is free if and only if some ray that visits it frees more voxels than the voxel is away: one
// witness is enough, and whether a ray visits a voxel is a matter of six crossings.
//
// # Practice
// Most cubes are decided, and most voxels of the others. So what is left after a step is listed, and all invocations go
// through the list in the next step.

@group(0) @binding(0) var<uniform> bound_setup: Setup;
@group(0) @binding(1) var<uniform> bound_part: Part;
@group(0) @binding(2) var<uniform> bound_table: Table;
@group(0) @binding(3) var<storage, read> placements: array<array<u32, PLACEMENT_WORDS>>;
@group(0) @binding(4) var<storage, read> ends: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read> pyramid: array<vec4<u32>>;
@group(0) @binding(6) var<storage, read> undecided: array<u32>;
@group(0) @binding(7) var<storage, read_write> left: array<atomic<u32>>;
@group(0) @binding(8) var<storage, read_write> free: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

// The box's free voxels: a word for each of its rows, of which the lowest bits count.
var<workgroup> free_rows: array<atomic<u32>, WORKGROUP>;
// Its undecided cubes.
var<workgroup> cubes: array<u32, WORKGROUP>;
var<workgroup> cubes_left: atomic<u32>;
// Its voxels whose pixels must be asked, those that are near from the end on; how many there are of both, and where they
// begin in the lists of all.
var<workgroup> voxels: array<u32, MOST_VOXELS>;
var<workgroup> voxels_left: array<atomic<u32>, 2>;
var<workgroup> first_places: array<u32, 2>;

const MOST_VOXELS = BOX_EDGE * BOX_EDGE * BOX_EDGE;

// What blocks of pixels say of a voxel: that it is not free, that it is, or that its pixels must be asked; most of them if it is
// near.
const HIDDEN = 0u;
const FREE = 1u;
const OPEN = 2u;
const NEAR = 3u;

// Whether some pixel of a block about one of them that reaches no farther than so many pixels beside it frees more than so
// many voxels.
fn enough_about(row: u32, pixel: vec2<u32>, beside: u32, away: u32) -> bool {
    let wanted = min(firstLeadingBit(beside + 1u), MOST_LEVEL);
    let level = max(wanted, LEAST_LEVEL);
    let freed_of_block = freed_by_block(row, level, pixel >> vec2<u32>(level));
    // A block that is too large decides where its pixels agree; else the one pixel does.
    if wanted < level && freed_of_block.x <= away && freed_of_block.y > away {
        let word = ends[four_of_block(row, pixel >> vec2<u32>(1u))][(pixel.y & 1u) * 2u + (pixel.x & 1u)];
        return freed(unpacked(word), table.no_return_is_free != 0u) > away;
    }
    return freed_of_block.y > away;
}

fn look(projection: Projection, row: u32, voxel: vec3<i32>, away: u32) -> u32 {
    let pixel_rect = pixel_rect(projection, voxel, 1);
    // All rays about the one through its centre visit a voxel where pixels are dense.
    if pixel_rect.beside >= 0 && enough_about(row, vec2<u32>(pixel_rect.centre), u32(pixel_rect.beside), away) {
        return FREE;
    }
    let range = freed_range(row, pixel_rect.first, pixel_rect.last);
    return select(HIDDEN, select(OPEN, NEAR, pixel_rect.near), pixel_rect.seen && range.y > away);
}

// A voxel's number in its box (`left.wgsl`).
fn number_of(at: vec3<u32>) -> u32 {
    return at.x + at.y * BOX_EDGE + at.z * (BOX_EDGE * BOX_EDGE);
}

// Where one of the eight voxels of a cube of two is in it.
fn place_in_cube(number: u32) -> vec3<u32> {
    return (vec3<u32>(number) >> vec3<u32>(0u, 1u, 2u)) & vec3<u32>(1u);
}

// Decides a cube as a whole: its voxels are marked if all are free, and it is listed if that is not known.
fn decide_cube(projection: Projection, row: u32, own: vec3<i32>, corner: vec3<i32>, at: vec3<u32>) {
    let cube = corner + vec3<i32>(at);
    let pixel_rect = pixel_rect(projection, cube, 2);
    let of_cube = away(own, cube, 2);
    let range = freed_range(row, pixel_rect.first, pixel_rect.last);
    if pixel_rect.dense && range.x > of_cube.y {
        let first_row = number_of(at) / BOX_EDGE;
        atomicOr(&free_rows[first_row], 3u << at.x);
        atomicOr(&free_rows[first_row + 1u], 3u << at.x);
        atomicOr(&free_rows[first_row + BOX_EDGE], 3u << at.x);
        atomicOr(&free_rows[first_row + BOX_EDGE + 1u], 3u << at.x);
    } else if pixel_rect.seen && range.y > of_cube.x {
        cubes[atomicAdd(&cubes_left, 1u)] = number_of(at);
    }
}

// Decides or lists a voxel of an undecided cube.
fn decide_voxel(projection: Projection, row: u32, own: vec3<i32>, corner: vec3<i32>, at: vec3<u32>) {
    let voxel = corner + vec3<i32>(at);
    let seen = look(projection, row, voxel, away(own, voxel, 1).x);
    if seen == FREE {
        atomicOr(&free_rows[number_of(at) / BOX_EDGE], 1u << at.x);
    }
    if seen == OPEN {
        voxels[atomicAdd(&voxels_left[0], 1u)] = number_of(at);
    }
    if seen == NEAR {
        voxels[MOST_VOXELS - 1u - atomicAdd(&voxels_left[1], 1u)] = number_of(at);
    }
}

// Reserves places for some voxels in the list of a kernel, which takes ABREAST of them for each of its workgroups on x, and
// returns the first. Its work is subtracted from its completion counters, which are zero again when all of it is done.
fn make_room(head: u32, kernel: u32, count: u32) -> u32 {
    let first = atomicAdd(&left[head + 3u], count);
    let more = (first + count + ABREAST - 1u) / ABREAST - (first + ABREAST - 1u) / ABREAST;
    if more > 0u {
        let groups = more * atomicLoad(&left[head + 1u]) * atomicLoad(&left[head + 2u]);
        atomicAdd(&left[head], more);
        atomicSub(&done[kernel], groups);
        atomicSub(&done[KERNELS + kernel], groups * WORKGROUP);
        atomicAdd(&done[2u * KERNELS + kernel], groups);
    }
    return first;
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    setup = bound_setup;
    part = bound_part;
    table = bound_table;
    let word = undecided[UNDECIDED_FIRST + part.first + group.x];
    let row = word >> BOX_BITS;
    let placement = placement_of(row, local);
    let projection = projection_of(placement.believed);
    let own = vec3_of(placement.believed.origin_q16) >> vec3<u32>(16u);
    let low = box_corner(word);
    let corner = vec3<i32>(low) + vec3<i32>(setup.window_min_x, setup.window_min_y, setup.window_min_z);
    let window = vec3<u32>(setup.window_x, setup.window_y, setup.window_z);
    let cube = vec3<u32>(local & 3u, (local >> 2u) & 3u, local >> 4u) * 2u;
    if all(low + cube < window) {
        decide_cube(projection, row, own, corner, cube);
    }
    workgroupBarrier();
    let looks = 8u * atomicLoad(&cubes_left);
    var i = local;
    for (; i < looks; i += WORKGROUP) {
        let at = place_in_box(cubes[i >> 3u]) + place_in_cube(i & 7u);
        if all(low + at < window) {
            decide_voxel(projection, row, own, corner, at);
        }
    }
    loop_ended(opaque(i) >= looks);
    workgroupBarrier();
    let crowded = atomicLoad(&voxels_left[0]);
    let near = atomicLoad(&voxels_left[1]);
    if local == 0u && crowded > 0u {
        first_places[0] = make_room(head_of(part.region, false), CARVE_CROWDED, crowded);
    }
    if local == 0u && near > 0u {
        first_places[1] = make_room(head_of(part.region, true), CARVE_NEAR, near);
    }
    let of_row = atomicLoad(&free_rows[local]) & (0xffu >> (BOX_EDGE - min(BOX_EDGE, window.x - low.x)));
    let y = low.y + local % BOX_EDGE;
    let z = low.z + local / BOX_EDGE;
    if of_row != 0u && y < window.y && z < window.z {
        let at = (z * window.y + y) * setup.window_words_per_row + (low.x >> 5u);
        atomicOr(&free[placement.slot * setup.window_words + at], of_row << (low.x & 31u));
    }
    workgroupBarrier();
    var k = local;
    for (; k < crowded + near; k += WORKGROUP) {
        let is_near = k >= crowded;
        let number = select(k, k - crowded, is_near);
        let voxel = voxels[select(number, MOST_VOXELS - 1u - number, is_near)];
        let place = place_in_list(arrayLength(&left), first_places[u32(is_near)] + number, is_near);
        atomicStore(&left[place], (group.x << 9u) | voxel);
    }
    loop_ended(opaque(k) >= crowded + near);
    report(CARVE_VOXELS, local);
}
