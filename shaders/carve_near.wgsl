// Decides the near voxels that `carve_voxels` left, which most pixels of an image may see: a workgroup a voxel.
//
// # Theory
// As `carve_voxels`: one witness is enough. For most free voxels, a pixel close to the middle is one. If not, all tiles are
// checked, except those that free too little, those outside of the voxel's outline (`outline.wgsl`), and those whose rays go
// away from the voxel on some axis on which it is not level with the sensor. The outline alone does not limit the tiles of
// voxels right behind the sensor's own.
//
// # Practice
// The invocations look at a tile each, list those that may see the voxel, and ask the pixels of each listed tile together.
// Very large images are shared by several workgroups a voxel, since software adapters end all loops after so many turns
// (src/march/backend/gpu/loop_bounds.rs).

@group(0) @binding(0) var<uniform> bound_setup: Setup;
@group(0) @binding(1) var<uniform> bound_part: Part;
@group(0) @binding(2) var<uniform> bound_table: Table;
@group(0) @binding(3) var<storage, read> placements: array<array<u32, PLACEMENT_WORDS>>;
@group(0) @binding(4) var<storage, read> dirs: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> ends: array<vec4<u32>>;
@group(0) @binding(6) var<storage, read> pyramid: array<vec4<u32>>;
@group(0) @binding(7) var<storage, read> undecided: array<u32>;
@group(0) @binding(8) var<storage, read> left: array<u32>;
@group(0) @binding(9) var<storage, read_write> free: array<atomic<u32>>;
@group(0) @binding(10) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

// The tiles that may see the voxel, of those that were looked at, and how many they are.
var<workgroup> tiles: array<u32, WORKGROUP>;
var<workgroup> tiles_seeing: atomic<u32>;
// Whether a witness was found.
var<workgroup> found: atomic<u32>;
// Rounds through all tiles, each of as many as there are invocations; none once a witness is known.
var<workgroup> rounds: u32;

// Whether a pixel frees more than so many voxels. Ends of tiles that were not cast ray by ray are in the pyramid alone.
fn is_enough(row: u32, pixel: vec2<u32>, away: u32) -> bool {
    let of_tile = freed_by_block(row, TILE_LEVEL, pixel / TILE);
    let word = ends[four_of_block(row, pixel / 2u)][(pixel.y & 1u) * 2u + (pixel.x & 1u)];
    return of_tile.x > away || (of_tile.y > away && freed(unpacked(word), table.no_return_is_free != 0u) > away);
}

// Whether some place of a tile is inside of some edges.
fn reaches_in(edges: Edges, low: vec2<f32>, high: vec2<f32>) -> bool {
    let u = select(vec3<f32>(low.x), vec3<f32>(high.x), edges.a > vec3<f32>());
    let v = select(vec3<f32>(low.y), vec3<f32>(high.y), edges.b > vec3<f32>());
    return all(edges.a * u + edges.b * v + edges.c >= -edges.margin);
}

// Whether some ray of a tile goes towards a voxel on all axes on which it is not level with the sensor.
fn goes_towards(projection: Projection, offset: vec3<i32>, low: vec2<f32>, high: vec2<f32>) -> bool {
    let rays = pixel_rays(projection, vec3<f32>(sign(offset)));
    let u = select(vec3<f32>(low.x), vec3<f32>(high.x), rays.right > vec3<f32>());
    let v = select(vec3<f32>(low.y), vec3<f32>(high.y), rays.down > vec3<f32>());
    // More than directions are rounded by.
    return all(rays.first + rays.right * u + rays.down * v >= vec3<f32>(-1e-3 * image_reach()));
}

// Whether some ray of a tile may see a voxel and frees more than so many.
fn may_see(projection: Projection, outline: Outline, row: u32, tile: vec2<u32>, offset: vec3<i32>, away: u32) -> bool {
    let low = vec2<f32>(tile * TILE);
    let high = low + f32(TILE - 1u);
    return freed_by_block(row, TILE_LEVEL, tile).y > away
        && reaches_in(outline.edges, low, high)
        && reaches_in(outline.opposite, low, high)
        && goes_towards(projection, offset, low, high);
}

// Asks a pixel, which may be outside of the image, whether it is a witness.
fn ask(place: GridFrame, row: u32, pixel: vec2<u32>, offset: vec3<i32>, away: u32) {
    if pixel.x < table.image_x && pixel.y < table.image_y {
        if is_enough(row, pixel, away) && sees(place, dirs[pixel.y * table.image_x + pixel.x], offset) {
            atomicStore(&found, 1u);
        }
    }
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    setup = bound_setup;
    part = bound_part;
    table = bound_table;
    let count = left[head_of(part.region, true) + 3u];
    let item = group.x * ABREAST + group.y;
    let is_there = item < count;
    let word = left[place_in_list(arrayLength(&left), min(item, count - 1u), true)];
    let box = undecided[UNDECIDED_FIRST + part.first + (word >> 9u)];
    let row = box >> BOX_BITS;
    let placement = placement_of(row, local);
    let place = placement.believed;
    let at = box_corner(box) + place_in_box(word);
    let voxel = vec3<i32>(at) + vec3<i32>(setup.window_min_x, setup.window_min_y, setup.window_min_z);
    let own = vec3_of(place.origin_q16) >> vec3<u32>(16u);
    let offset = voxel - own;
    let away = away(own, voxel, 1).x;
    let projection = projection_of(place);
    let rect = pixel_rect(projection, voxel, 1);
    let low = vec3<f32>(voxel) - projection.origin;
    let deviates = 0.01 + deviation(dot(abs(low), vec3<f32>(1.0)) + 3.0);
    let outline = outline_of(projection, low - deviates, low + 1.0 + deviates, 0.0);
    // As many pixels as there are invocations, about the middle.
    let size = vec2<i32>(vec2<u32>(table.image_x, table.image_y));
    let middle = clamp(rect.centre - i32(TILE / 2u), vec2<i32>(), max(size - i32(TILE), vec2<i32>()));
    let in_tile = vec2<u32>(local % TILE, local / TILE);
    if is_there {
        ask(place, row, vec2<u32>(middle) + in_tile, offset, away);
    }
    let first = vec2<u32>(rect.first) / TILE;
    let across = vec2<u32>(rect.last) / TILE - first + 1u;
    let begin = group.z * NEAR_TILES;
    let end = min(across.x * across.y, begin + NEAR_TILES);
    workgroupBarrier();
    if local == 0u && is_there && begin < end && atomicLoad(&found) == 0u {
        rounds = (end - begin + WORKGROUP - 1u) / WORKGROUP;
    }
    var round = 0u;
    loop {
        if round >= workgroupUniformLoad(&rounds) {
            break;
        }
        let number = begin + round * WORKGROUP + local;
        let tile = first + vec2<u32>(number % across.x, number / across.x);
        if number < end && may_see(projection, outline, row, tile, offset, away) {
            tiles[atomicAdd(&tiles_seeing, 1u)] = tile.x | (tile.y << 16u);
        }
        workgroupBarrier();
        let seeing = atomicLoad(&tiles_seeing);
        var i = 0u;
        loop {
            if i >= seeing || atomicLoad(&found) != 0u {
                break;
            }
            ask(place, row, vec2<u32>(tiles[i] & 0xffffu, tiles[i] >> 16u) * TILE + in_tile, offset, away);
            i += 1u;
        }
        loop_ended(opaque(i) >= seeing || opaque(atomicLoad(&found)) != 0u);
        workgroupBarrier();
        if local == 0u {
            atomicStore(&tiles_seeing, 0u);
            rounds = select(rounds, 0u, atomicLoad(&found) != 0u);
        }
        round += 1u;
    }
    loop_ended(opaque(round) >= rounds);
    if local == 0u && atomicLoad(&found) != 0u {
        let in_row = (at.z * setup.window_y + at.y) * setup.window_words_per_row + (at.x >> 5u);
        atomicOr(&free[placement.slot * setup.window_words + in_row], 1u << (at.x & 31u));
    }
    report(CARVE_NEAR, local);
}
