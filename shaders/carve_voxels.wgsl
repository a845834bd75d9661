// Decides the boxes that `carve_boxes` left, voxel by voxel, from the pixels that may see each. One workgroup
// a box, one invocation a cube of 2 × 2 × 2 of its voxels; voxels that many pixels may see are listed for
// `carve_crowded`.
//
// # Theory
// A voxel is free if and only if some ray that visits it frees more voxels than the voxel is away: one
// witness is enough, and whether a ray visits a voxel is a matter of six crossings. Near voxels, which most
// pixels may see, are left to `carve_rays`.
//
// # Practice
// Software adapters count the turns of the invocations of a vector together, and end all loops when there
// were too many. So an invocation counts those that it makes over pixels, and makes MOST_TURNS at most
// (src/backend/gpu/loop_bounds.rs).

@group(0) @binding(0) var<uniform> setup: Setup;
@group(0) @binding(1) var<uniform> part: Part;
@group(0) @binding(2) var<uniform> table: Table;
@group(0) @binding(3) var<storage, read> placements: array<array<u32, PLACEMENT_WORDS>>;
@group(0) @binding(4) var<storage, read> dirs_q15: array<array<i32, 3>>;
@group(0) @binding(5) var<storage, read> ends: array<u32>;
@group(0) @binding(6) var<storage, read> pyramid: array<u32>;
@group(0) @binding(7) var<storage, read> undecided: array<u32>;
@group(0) @binding(8) var<storage, read_write> left: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read_write> free: array<atomic<u32>>;
@group(0) @binding(10) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

// Turns of the loops over pixels so far.
var<private> turns: u32;

// Whether some pixel of a rectangle sees a voxel and frees more voxels than it is away. The pixel through the
// voxel's centre is asked first: it mostly knows.
fn witnessed(placement: GridPose, row: u32, offset: vec3<i32>, middle: vec2<i32>, first: vec2<i32>, last: vec2<i32>, away: u32) -> bool {
    var pixel = middle;
    var next = first;
    var found = false;
    var enough = false;
    loop {
        // The next pixel that frees enough. Software adapters pay for what follows as often as the slowest of
        // eight neighbours.
        turns += 1u;
        loop {
            turns += 1u;
            let end = ends[row * table.rays + u32(pixel.y) * table.image_x + u32(pixel.x)];
            enough = freed(unpacked(end), table.no_return_is_free != 0u) > away;
            if enough || next.y > last.y {
                break;
            }
            pixel = next;
            next = select(next + vec2<i32>(1, 0), vec2<i32>(first.x, next.y + 1), next.x == last.x);
        }
        loop_ended(opaque(u32(enough)) != 0u || opaque(u32(next.y)) > u32(last.y));
        if !enough {
            break;
        }
        found = sees(placement.believed, dirs_q15[u32(pixel.y) * table.image_x + u32(pixel.x)], offset);
        if found || next.y > last.y {
            break;
        }
        pixel = next;
        next = select(next + vec2<i32>(1, 0), vec2<i32>(first.x, next.y + 1), next.x == last.x);
    }
    loop_ended(!enough || opaque(u32(found)) != 0u || opaque(u32(next.y)) > u32(last.y));
    return found;
}

// Lists a voxel for `carve_crowded`, whose workgroups take TEAMS of them. What that kernel is to do is
// taken from its completion counters, so that they come to nothing when all is done.
fn leave(item: u32, number: u32) {
    let head = part.region * HEAD_WORDS;
    let place = atomicAdd(&left[head + 3u], 1u);
    atomicStore(&left[HEADS * HEAD_WORDS + place], (item << 9u) | number);
    if place % TEAMS == 0u {
        atomicAdd(&left[head], 1u);
        atomicSub(&done[CARVE_CROWDED], 1u);
        atomicSub(&done[KERNELS + CARVE_CROWDED], WORKGROUP);
    }
}

// Whether a voxel is free as far as that is known; a voxel that it would take many pixels to know of is left.
fn is_free(placement: GridPose, projection: Projection, row: u32, voxel: vec3<i32>, item: u32, number: u32) -> bool {
    let pixel_rect = pixel_rect(projection, voxel, 1);
    let own = vec3_of(placement.believed.origin_q16) >> vec3<u32>(16u);
    let away = away(own, voxel, 1).x;
    let range = freed_range(row, pixel_rect.first, pixel_rect.last);
    let open = pixel_rect.seen && !pixel_rect.near && range.y > away;
    if open {
        let size = pixel_rect.last - pixel_rect.first + 1;
        let pixels = u32(size.x * size.y);
        if pixel_rect.tile_visits && most_of_tile(row, vec2<u32>(pixel_rect.centre) / TILE) > away {
            return true;
        }
        if pixels > MOST_PIXELS || turns + 2u * pixels + 4u > MOST_TURNS {
            // The pixel through the middle mostly knows.
            let index = u32(pixel_rect.centre.y) * table.image_x + u32(pixel_rect.centre.x);
            let end = unpacked(ends[row * table.rays + index]);
            let enough = freed(end, table.no_return_is_free != 0u) > away;
            if enough && sees(placement.believed, dirs_q15[index], voxel - own) {
                return true;
            }
            leave(item, number);
            return false;
        }
        return witnessed(placement, row, voxel - own, pixel_rect.centre, pixel_rect.first, pixel_rect.last, away);
    }
    return false;
}

// Which voxels of a cube of two are free as far as that is known: a bit each, x fastest. The cube may be
// decided whole, as boxes are.
fn free_of_cube(placement: GridPose, projection: Projection, row: u32, low: vec3<u32>, item: u32, first: u32) -> u32 {
    let window = vec3<u32>(setup.window_x, setup.window_y, setup.window_z);
    let voxel = vec3<i32>(low) + vec3<i32>(setup.window_min_x, setup.window_min_y, setup.window_min_z);
    let pixel_rect = pixel_rect(projection, voxel, 2);
    let away = away(vec3_of(placement.believed.origin_q16) >> vec3<u32>(16u), voxel, 2);
    let range = freed_range(row, pixel_rect.first, pixel_rect.last);
    let all_free = pixel_rect.dense && range.x > away.y;
    // A loop that ends at once costs a software adapter little; what is behind a branch it pays for.
    let voxels = select(0u, 8u, pixel_rect.seen && range.y > away.x && !all_free);
    var bits = select(0u, 0xffu, all_free);
    var i = 0u;
    for (; i < voxels; i += 1u) {
        let at = vec3<u32>(i & 1u, (i >> 1u) & 1u, i >> 2u);
        if all(low + at < window) {
            let number = first + at.x + at.y * BOX_EDGE + at.z * BOX_EDGE * BOX_EDGE;
            bits |= u32(is_free(placement, projection, row, voxel + vec3<i32>(at), item, number)) << i;
        }
    }
    loop_ended(opaque(i) >= voxels);
    return bits;
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let window = vec3<u32>(setup.window_x, setup.window_y, setup.window_z);
    let cube = vec3<u32>(local & 3u, (local >> 2u) & 3u, local >> 4u) * 2u;
    let number = cube.x + cube.y * BOX_EDGE + cube.z * BOX_EDGE * BOX_EDGE;
    let item = part.first + group.x;
    let is_left = item < min(part.end, undecided[0]);
    let word = undecided[select(0u, item + 1u, is_left)];
    let row = word >> BOX_BITS;
    let placement = placement_of(row, local);
    // No early return: `report` must see every invocation of the group.
    if is_left {
        let low = box_corner(word) + cube;
        if all(low < window) {
            let bits = free_of_cube(placement, projection_of(placement.believed), row, low, group.x, number);
            // The last voxel of a row may stand alone.
            let within = select(1u, 3u, low.x + 1u < window.x);
            var i = 0u;
            for (; i < 4u; i += 1u) {
                let two = (bits >> (2u * i)) & within;
                let y = low.y + (i & 1u);
                let z = low.z + (i >> 1u);
                if two != 0u && y < window.y && z < window.z {
                    let at = (z * window.y + y) * setup.window_words_per_row + (low.x >> 5u);
                    atomicOr(&free[placement.slot * setup.window_words + at], two << (low.x & 31u));
                }
            }
            loop_ended(opaque(i) >= 4u);
        }
    }
    report(CARVE_VOXELS, local);
}
