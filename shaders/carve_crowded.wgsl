// Decides the voxels that `carve_voxels` left, from the pixels that may see each: a team of invocations a voxel, each
// of which takes two columns of four tiles at a time.
//
// # Theory
// As `carve_voxels`: one witness is enough, whichever invocation finds it. Rays that pass through a voxel's outline, but not
// close to its edges, surely visit the voxel (`outline.wgsl`): only those of the pixels about the edges are asked whether
// they do.

@group(0) @binding(0) var<uniform> bound_setup: Setup;
@group(0) @binding(1) var<uniform> bound_part: Part;
@group(0) @binding(2) var<uniform> bound_table: Table;
@group(0) @binding(3) var<storage, read> placements: array<array<vec4<i32>, PLACEMENT_WORDS / 4u>>;
@group(0) @binding(4) var<storage, read> dirs: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> ends: array<vec4<u32>>;
@group(0) @binding(6) var<storage, read> pyramid: array<vec4<u32>>;
@group(0) @binding(7) var<storage, read> undecided: array<u32>;
@group(0) @binding(8) var<storage, read> left: array<u32>;
@group(0) @binding(9) var<storage, read_write> free: array<atomic<u32>>;
@group(0) @binding(10) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

// Voxels that a team has found free.
var<workgroup> found: array<atomic<u32>, TEAMS>;

// The pixels of two columns TILE apart, from a pixel on: a bit each, those of the second behind those of the first.
fn columns_inside(pixel: vec2<i32>, rect: PixelRect, outline: Outline) -> Columns {
    let left = column_inside(pixel, rect, outline);
    let right = column_inside(pixel + vec2<i32>(i32(TILE), 0), rect, outline);
    return Columns(left.outer | (right.outer << ROWS), left.inner | (right.inner << ROWS));
}

// Pixels of two columns in those of four tiles of which a condition holds.
fn pixels_of(tiles: vec4<bool>) -> u32 {
    let bits = select(vec4<u32>(), vec4<u32>(0xffu, 0xff00u, 0xff0000u, 0xff000000u), tiles);
    return bits.x | bits.y | bits.z | bits.w;
}

// Where a sensor is believed to be: the first words of its placement (`GridPose`), looked up four at a time.
fn place_of(row: u32) -> GridFrame {
    let a = placements[row][0];
    let b = placements[row][1];
    let c = placements[row][2];
    let x = array<i32, 3>(a.w, b.x, b.y);
    let y = array<i32, 3>(b.z, b.w, c.x);
    let z = array<i32, 3>(c.y, c.z, c.w);
    return GridFrame(array<i32, 3>(a.x, a.y, a.z), array<array<i32, 3>, 3>(x, y, z));
}

// Which of two pixels, one below the other, free more than so many voxels: a bit each.
fn enough_of_two(row: u32, pixel: vec2<u32>, away: u32) -> u32 {
    let words = ends[four_of_block(row, pixel >> vec2<u32>(1u))];
    let two = select(words.xz, words.yw, (pixel.x & 1u) != 0u);
    let is_free = table.no_return_is_free != 0u;
    return u32(freed(unpacked(two.x), is_free) > away) | (u32(freed(unpacked(two.y), is_free) > away) << 1u);
}

// Looks at two columns of each four tiles of the pixels that may see a voxel.
fn scan(word: u32, team: u32, column: u32) {
    let box = undecided[UNDECIDED_FIRST + part.first + (word >> 9u)];
    let row = box >> BOX_BITS;
    let at = box_corner(box) + place_in_box(word);
    let voxel = vec3<i32>(at) + vec3<i32>(setup.window_min_x, setup.window_min_y, setup.window_min_z);
    let place = place_of(row);
    let own = vec3_of(place.origin_q16) >> vec3<u32>(16u);
    let away = away(own, voxel, 1).x;
    let projection = projection_of(place);
    let rect = pixel_rect(projection, voxel, 1);
    let low = vec3<f32>(voxel) - projection.origin;
    let one = vec3<f32>(1.0);
    let deviates = 0.01 + deviation(dot(abs(low), one) + 3.0);
    let depth = dot(projection.forward, low + 0.5) - (0.5 + deviates) * dot(abs(projection.forward), one);
    let outline = outline_of(projection, low, low + 1.0, deviates / max(depth, NEAREST));
    let first = vec2<u32>(rect.first) / TILE;
    let last = vec2<u32>(rect.last) / TILE;
    // The four tiles about the middle mostly know; most voxels are seen by no others.
    var tile = first + ((vec2<u32>(rect.centre) / TILE - first) & vec2<u32>(~1u));
    var next = select(first, last + 1u, vec2<bool>(all(last <= first + 1u)));
    var is_witness = false;
    var known = false;
    loop {
        let beside = min(tile + 1u, last);
        let a = freed_by_block(row, TILE_LEVEL, tile);
        let b = freed_by_block(row, TILE_LEVEL, vec2<u32>(tile.x, beside.y));
        let c = freed_by_block(row, TILE_LEVEL, vec2<u32>(beside.x, tile.y));
        let d = freed_by_block(row, TILE_LEVEL, beside);
        let some = pixels_of(vec4<u32>(a.y, b.y, c.y, d.y) > vec4<u32>(away));
        let all = pixels_of(vec4<u32>(a.x, b.x, c.x, d.x) > vec4<u32>(away));
        let pixel = tile * TILE + vec2<u32>(column, 0u);
        var columns = Columns();
        if some != 0u {
            columns = columns_inside(vec2<i32>(pixel), rect, outline);
        }
        // Pixels that free enough, and those of which it is not known yet; two rows at a time. Those that surely see the voxel are
        // asked first.
        var enough = columns.outer & all;
        var unasked = columns.outer & some & ~all;
        is_witness = (enough & columns.inner) != 0u;
        loop {
            if unasked == 0u || is_witness {
                break;
            }
            let inner = unasked & columns.inner;
            let bit = firstTrailingBit(select(unasked, inner, inner != 0u)) & ~1u;
            let two = enough_of_two(row, pixel + vec2<u32>((bit / ROWS) * TILE, bit % ROWS), away);
            enough |= (two << bit) & columns.outer;
            unasked &= ~(3u << bit);
            is_witness = (enough & columns.inner) != 0u;
        }
        loop_ended(opaque(unasked) == 0u || opaque(u32(is_witness)) != 0u);
        if is_witness {
            atomicStore(&found[team], 1u);
        }
        known = atomicLoad(&found[team]) != 0u;
        loop {
            if enough == 0u || known {
                break;
            }
            let bit = firstTrailingBit(enough);
            let asked = pixel + vec2<u32>((bit / ROWS) * TILE, bit % ROWS);
            is_witness = sees(place, dirs[asked.y * table.image_x + asked.x], voxel - own);
            enough &= enough - 1u;
            if is_witness {
                atomicStore(&found[team], 1u);
            }
            known = atomicLoad(&found[team]) != 0u;
        }
        loop_ended(opaque(enough) == 0u || opaque(u32(known)) != 0u);
        if known || next.y > last.y {
            break;
        }
        tile = next;
        next = select(next + vec2<u32>(2u, 0u), vec2<u32>(first.x, next.y + 2u), next.x + 2u > last.x);
    }
    loop_ended(opaque(u32(known)) != 0u || opaque(next.y) > last.y);
    if is_witness {
        let slot = u32(placements[row][6].z);
        let plane = slot * setup.window_words;
        let in_row = (at.z * setup.window_y + at.y) * setup.window_words_per_row + (at.x >> 5u);
        atomicOr(&free[plane + in_row], 1u << (at.x & 31u));
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
    let team = local / TILE;
    let item = group.x * ABREAST + group.y * TEAMS + team;
    if item < left[head_of(part.region, false) + 3u] {
        scan(left[place_in_list(arrayLength(&left), item, false)], team, local % TILE);
    }
    report(CARVE_CROWDED, local);
}
