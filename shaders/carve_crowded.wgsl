// Decides the voxels that `carve_voxels` left, which many pixels may see: a team of invocations a voxel, one
// a column of each tile.
//
// # Theory
// As `carve_voxels`: one witness is enough, whichever invocation finds it.

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

// Three edges of an outline in the image: pixels are inside where ax + by + c is not negative.
struct Edges {
    a: vec3<f32>,
    b: vec3<f32>,
    c: vec3<f32>,
}

// The outline of a voxel: an edge for each pair of axes, and the one opposite to it.
struct Outline {
    edges: Edges,
    opposite: Edges,
}

// Where rays pass one corner of a box on the same side, as seen on each axis and the next: where the corner is on both; on the
// other side for their negatives. `right` and `down` lead from the ray of the first pixel to those of its neighbours.
fn edges_of(on: vec3<f32>, on_next: vec3<f32>, right: vec3<f32>, down: vec3<f32>, first: vec3<f32>) -> Edges {
    return Edges(
        on * right.yzx - on_next * right,
        on * down.yzx - on_next * down,
        // More than the floats are off by.
        on * first.yzx - on_next * first + 1e-5 * (abs(on) + abs(on_next)),
    );
}

// The outline of the box between two corners, counted from the sensor.
//
// As seen on two axes, rays pass the box between those two of its corners that are farthest apart from there. A ray that
// does so on each pair of axes enters the box. If the sensor is within the box on both, all rays do.
fn outline_of(projection: Projection, low: vec3<f32>, high: vec3<f32>) -> Outline {
    // As if the box were not behind the sensor on any axis.
    let behind = high < vec3<f32>();
    let near = select(low, -high, behind);
    let far = select(high, -low, behind);
    let side = select(vec3<f32>(1.0), vec3<f32>(-1.0), behind);
    let size = vec2<f32>(vec2<u32>(table.image_x, table.image_y));
    let right = projection.right * side / table.focal_x;
    let down = projection.down * side / table.focal_y;
    let first = projection.forward * side + right * (0.5 - size.x * 0.5) + down * (0.5 - size.y * 0.5);
    let within = near <= vec3<f32>();
    let all_pass = within & within.yzx;
    let one = select(select(far, near, within.yzx), vec3<f32>(), all_pass);
    let one_next = select(near.yzx, vec3<f32>(), all_pass);
    let other = select(near, vec3<f32>(), all_pass);
    let other_next = select(select(far.yzx, near.yzx, within), vec3<f32>(), all_pass);
    return Outline(edges_of(one, one_next, right, down, first), edges_of(-other, -other_next, right, down, first));
}

// The pixels of a column that are inside some edges, of those from the first to the last.
fn inside_edges(edges: Edges, u: f32, span: vec2<f32>) -> vec2<f32> {
    let crossed = -(edges.a * u + edges.c) / edges.b;
    let firsts = select(vec3<f32>(span.x), crossed, edges.b > vec3<f32>());
    let lasts = select(vec3<f32>(span.y), crossed, edges.b < vec3<f32>());
    return vec2<f32>(
        max(max(span.x, firsts.x), max(firsts.y, firsts.z)),
        min(min(span.y, lasts.x), min(lasts.y, lasts.z)),
    );
}

// Which pixels of a column of a tile are in a rectangle and an outline and free more than so many voxels: a bit each, from
// above. `all_do` says that every pixel of the tile frees more; then none is looked up.
fn enough_of_column(row: u32, u: i32, v: i32, all_do: bool, pixel_rect: PixelRect, away: u32, outline: Outline) -> u32 {
    let inside = u >= pixel_rect.first.x && u <= pixel_rect.last.x;
    let tile = vec2<f32>(f32(v), f32(v + i32(TILE) - 1));
    let span = inside_edges(outline.opposite, f32(u), inside_edges(outline.edges, f32(u), tile));
    // Some of a pixel for rounding.
    let first_v = max(integer(ceil(min(span.x, tile.y + 1.0) - 0.01)), pixel_rect.first.y);
    let end_v = min(integer(floor(max(span.y, tile.x - 1.0) + 0.01)), pixel_rect.last.y) + 1;
    let count = u32(max(end_v - first_v, 0));
    let wanted = select(0u, ((1u << count) - 1u) << u32(max(first_v - v, 0)), inside);
    var bits = wanted;
    // Two rows at a time.
    var unasked = select(wanted, 0u, all_do);
    loop {
        if unasked == 0u {
            break;
        }
        let at = firstTrailingBit(unasked) & 6u;
        let words = ends[four_of_block(row, vec2<u32>(u32(u), u32(v) + at) >> vec2<u32>(1u))];
        let two = select(words.xz, words.yw, (u & 1) != 0);
        let is_free = table.no_return_is_free != 0u;
        let enough = vec2<bool>(freed(unpacked(two.x), is_free) > away, freed(unpacked(two.y), is_free) > away);
        let hidden = select(vec2<u32>(1u, 2u), vec2<u32>(), enough);
        bits &= ~((hidden.x | hidden.y) << at);
        unasked &= ~(3u << at);
    }
    loop_ended(opaque(unasked) == 0u);
    return bits;
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

// Looks at a column of each tile of the pixels that may see a voxel.
fn scan(word: u32, team: u32, column: u32) {
    let box = undecided[UNDECIDED_FIRST + part.first + (word >> 9u)];
    let row = box >> BOX_BITS;
    let at = box_corner(box) + vec3<u32>(word & 7u, (word >> 3u) & 7u, (word >> 6u) & 7u);
    let voxel = vec3<i32>(at) + vec3<i32>(setup.window_min_x, setup.window_min_y, setup.window_min_z);
    let place = place_of(row);
    let own = vec3_of(place.origin_q16) >> vec3<u32>(16u);
    let away = away(own, voxel, 1).x;
    let projection = projection_of(place);
    let pixel_rect = pixel_rect(projection, voxel, 1);
    let low = vec3<f32>(voxel) - projection.origin;
    let grown = 0.01 + deviation(dot(abs(low), vec3<f32>(1.0)) + 3.0);
    let outline = outline_of(projection, low - grown, low + 1.0 + grown);
    let first = vec2<u32>(pixel_rect.first) / TILE;
    let last = vec2<u32>(pixel_rect.last) / TILE;
    // The tile through the middle mostly knows.
    var tile = vec2<u32>(pixel_rect.centre) / TILE;
    var next = first;
    var is_witness = false;
    var known = false;
    loop {
        // The next tile of which some pixel frees enough.
        var freed_of_tile = vec2<u32>();
        var enough = false;
        loop {
            freed_of_tile = freed_by_block(row, TILE_LEVEL, tile);
            enough = freed_of_tile.y > away;
            if enough || next.y > last.y {
                break;
            }
            tile = next;
            next = select(next + vec2<u32>(1u, 0u), vec2<u32>(first.x, next.y + 1u), next.x == last.x);
        }
        loop_ended(opaque(u32(enough)) != 0u || opaque(next.y) > last.y);
        if !enough {
            break;
        }
        let u = i32(tile.x * TILE + column);
        let v = i32(tile.y * TILE);
        var bits = enough_of_column(row, u, v, freed_of_tile.x > away, pixel_rect, away, outline);
        loop {
            if bits == 0u || is_witness {
                break;
            }
            let pixel = u32(v + i32(firstTrailingBit(bits))) * table.image_x + u32(u);
            is_witness = sees(place, dirs[pixel], voxel - own);
            bits &= bits - 1u;
        }
        loop_ended(opaque(bits) == 0u || opaque(u32(is_witness)) != 0u);
        if is_witness {
            atomicStore(&found[team], 1u);
        }
        known = atomicLoad(&found[team]) != 0u;
        if known || next.y > last.y {
            break;
        }
        tile = next;
        next = select(next + vec2<u32>(1u, 0u), vec2<u32>(first.x, next.y + 1u), next.x == last.x);
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
    let item = (group.x * ABREAST + group.y) * TEAMS + team;
    if item < left[part.region * HEAD_WORDS + 3u] {
        scan(left[HEADS * HEAD_WORDS + item], team, local % TILE);
    }
    report(CARVE_CROWDED, local);
}
