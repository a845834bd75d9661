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
// (src/march/backend/gpu/loop_bounds.rs).

@group(0) @binding(0) var<uniform> bound_setup: Setup;
@group(0) @binding(1) var<uniform> bound_part: Part;
@group(0) @binding(2) var<uniform> bound_table: Table;
@group(0) @binding(3) var<storage, read> placements: array<array<u32, PLACEMENT_WORDS>>;
@group(0) @binding(4) var<storage, read> dirs: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> ends: array<vec4<u32>>;
@group(0) @binding(6) var<storage, read> pyramid: array<vec4<u32>>;
@group(0) @binding(7) var<storage, read> undecided: array<u32>;
@group(0) @binding(8) var<storage, read_write> left: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read_write> free: array<atomic<u32>>;
@group(0) @binding(10) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

// Turns of the loops over pixels so far.
var<private> turns: u32;

// The pixels of a block of two by two that lie in a rectangle and free more than so many voxels: a bit each.
fn enough_of_block(row: u32, block: vec2<u32>, freed_of_block: vec2<u32>, pixel_rect: PixelRect, away: u32) -> u32 {
    let low = vec2<i32>(block * 2u);
    var voxels = vec4<u32>(freed_of_block.x);
    if freed_of_block.x <= away {
        let words = ends[four_of_block(row, block)];
        let is_free = table.no_return_is_free != 0u;
        voxels = vec4<u32>(
            freed(unpacked(words.x), is_free),
            freed(unpacked(words.y), is_free),
            freed(unpacked(words.z), is_free),
            freed(unpacked(words.w), is_free),
        );
    }
    let begins = low >= pixel_rect.first;
    let ends_in = low + 1 <= pixel_rect.last;
    let inside = vec4<bool>(begins.x && begins.y, ends_in.x && begins.y, begins.x && ends_in.y, ends_in.x && ends_in.y);
    let bits = select(vec4<u32>(), vec4<u32>(1u, 2u, 4u, 8u), inside & (voxels > vec4<u32>(away)));
    return bits.x | bits.y | bits.z | bits.w;
}

// Whether some pixel of a rectangle sees a voxel and frees more voxels than it is away. The pixels about the
// one through the voxel's centre are asked first: they mostly know.
fn witnessed(placement: GridPose, row: u32, offset: vec3<i32>, pixel_rect: PixelRect, away: u32) -> bool {
    let first = vec2<u32>(pixel_rect.first) / 2u;
    let last = vec2<u32>(pixel_rect.last) / 2u;
    var block = vec2<u32>(pixel_rect.centre) / 2u;
    var next = first;
    var found = false;
    loop {
        // The next block of which some pixel frees enough. Software adapters pay for what follows as often as
        // the slowest of eight neighbours.
        var enough = false;
        var freed_of_block = vec2<u32>();
        turns += 1u;
        loop {
            turns += 1u;
            freed_of_block = freed_by_block(row, LEAST_LEVEL, block);
            enough = freed_of_block.y > away;
            if enough || next.y > last.y {
                break;
            }
            block = next;
            next = select(next + vec2<u32>(1u, 0u), vec2<u32>(first.x, next.y + 1u), next.x == last.x);
        }
        loop_ended(opaque(u32(enough)) != 0u || opaque(next.y) > last.y);
        if !enough {
            break;
        }
        var bits = enough_of_block(row, block, freed_of_block, pixel_rect, away);
        loop {
            turns += 1u;
            let bit = firstTrailingBit(bits);
            let pixel = vec2<i32>(block * 2u + vec2<u32>(bit & 1u, bit >> 1u));
            found = bits != 0u && (all(abs(pixel - pixel_rect.centre) <= vec2<i32>(pixel_rect.beside))
                || sees(placement.believed, dirs[u32(pixel.y) * table.image_x + u32(pixel.x)], offset));
            bits &= bits - 1u;
            if bits == 0u || found {
                break;
            }
        }
        loop_ended(opaque(bits) == 0u || opaque(u32(found)) != 0u);
        if found || next.y > last.y {
            break;
        }
        block = next;
        next = select(next + vec2<u32>(1u, 0u), vec2<u32>(first.x, next.y + 1u), next.x == last.x);
    }
    loop_ended(opaque(u32(found)) != 0u || opaque(next.y) > last.y);
    return found;
}

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

// Lists a voxel for `carve_crowded`, whose workgroups, ABREAST at a time, take TEAMS of them each. What that
// kernel is to do is taken from its completion counters, so that they come to nothing when all is done.
fn leave(item: u32, number: u32) {
    let head = part.region * HEAD_WORDS;
    let place = atomicAdd(&left[head + 3u], 1u);
    atomicStore(&left[HEADS * HEAD_WORDS + place], (item << 9u) | number);
    if place % (TEAMS * ABREAST) == 0u {
        atomicAdd(&left[head], 1u);
        atomicSub(&done[CARVE_CROWDED], ABREAST);
        atomicSub(&done[KERNELS + CARVE_CROWDED], WORKGROUP * ABREAST);
        atomicAdd(&done[2u * KERNELS + CARVE_CROWDED], ABREAST);
    }
}

// What blocks of pixels say of a voxel: that it is not free, that it is, or that its pixels must be asked.
const HIDDEN = 0u;
const FREE = 1u;
const OPEN = 2u;

fn look(projection: Projection, row: u32, voxel: vec3<i32>, away: u32) -> u32 {
    let pixel_rect = pixel_rect(projection, voxel, 1);
    // All rays about the one through its centre visit a voxel where pixels are dense.
    if pixel_rect.beside >= 0 && enough_about(row, vec2<u32>(pixel_rect.centre), u32(pixel_rect.beside), away) {
        return FREE;
    }
    let range = freed_range(row, pixel_rect.first, pixel_rect.last);
    return select(HIDDEN, OPEN, pixel_rect.seen && !pixel_rect.near && range.y > away);
}

// Whether an open voxel is free as far as that is known; a voxel that it would take many pixels to know of is
// left.
fn is_free(placement: GridPose, projection: Projection, row: u32, voxel: vec3<i32>, own: vec3<i32>, item: u32, number: u32) -> bool {
    let pixel_rect = pixel_rect(projection, voxel, 1);
    let size = pixel_rect.last - pixel_rect.first + 1;
    let pixels = u32(size.x * size.y);
    if pixels > MOST_PIXELS || turns + 4u * pixels + 12u > MOST_TURNS {
        leave(item, number);
        return false;
    }
    return witnessed(placement, row, voxel - own, pixel_rect, away(own, voxel, 1).x);
}

// Which voxels of a cube of two are free as far as that is known: a bit each, x fastest. The cube may be
// decided whole, as boxes are.
fn free_of_cube(placement: GridPose, projection: Projection, row: u32, low: vec3<u32>, item: u32, first: u32) -> u32 {
    let window = vec3<u32>(setup.window_x, setup.window_y, setup.window_z);
    let voxel = vec3<i32>(low) + vec3<i32>(setup.window_min_x, setup.window_min_y, setup.window_min_z);
    let pixel_rect = pixel_rect(projection, voxel, 2);
    let own = vec3_of(placement.believed.origin_q16) >> vec3<u32>(16u);
    let of_cube = away(own, voxel, 2);
    let range = freed_range(row, pixel_rect.first, pixel_rect.last);
    let all_free = pixel_rect.dense && range.x > of_cube.y;
    // No branch around the loop: software adapters run what is behind a branch in any case. A loop of no voxels is one turn.
    let voxels = select(0u, 8u, pixel_rect.seen && range.y > of_cube.x && !all_free);
    var bits = select(0u, 0xffu, all_free);
    var open = 0u;
    var i = 0u;
    loop {
        let at = vec3<u32>(i & 1u, (i >> 1u) & 1u, i >> 2u);
        if i < voxels && all(low + at < window) {
            let one = voxel + vec3<i32>(at);
            let seen = look(projection, row, one, away(own, one, 1).x);
            bits |= u32(seen == FREE) << i;
            open |= u32(seen == OPEN) << i;
        }
        i += 1u;
        if i >= voxels {
            break;
        }
    }
    loop_ended(opaque(i) >= voxels);
    // Each invocation goes on to its own next open voxel, so that a vector makes as many turns as the one with
    // the most of them.
    loop {
        let i = firstTrailingBit(open);
        let at = vec3<u32>(i & 1u, (i >> 1u) & 1u, i >> 2u);
        let number = first + at.x + at.y * BOX_EDGE + at.z * BOX_EDGE * BOX_EDGE;
        if open != 0u {
            bits |= u32(is_free(placement, projection, row, voxel + vec3<i32>(at), own, item, number)) << i;
        }
        open &= open - 1u;
        if open == 0u {
            break;
        }
    }
    loop_ended(opaque(open) == 0u);
    return bits;
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    setup = bound_setup;
    part = bound_part;
    table = bound_table;
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
