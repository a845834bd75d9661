// How far all rays of a camera's tile of pixels travel through nothing: `cast` sends them on from there. Tiles whose rays
// are of no account, or surely return from behind all that matters, are done. One invocation a tile.
//
// # Theory
// A ray of integers deviates from the ideal one by less than `deviation`. The cone of a tile holds its ideal
// rays and is grown by that, so while the cone is where there are no blockers, no ray has entered one.
//
// If no ray has, up to where it has left the last voxel that matters, and noise cannot bring its return back
// to there, all that matters is that it does return. It does if its cone lies across a layer of blockers: all
// rays are before the layer where a section of the cone begins, and in it or behind it where the section
// ends; they enter it inside the box around the section, and there it is all blockers.
//
// Rays that must all enter such a layer, and no blocker before it, have entered none until just before each crosses into it:
// `cast` sends each of them to there.
//
// Floats decide only what is proved so, with room to spare.

@group(0) @binding(0) var<uniform> bound_setup: Setup;
@group(0) @binding(1) var<uniform> bound_part: Part;
@group(0) @binding(2) var<uniform> bound_table: Table;
@group(0) @binding(3) var<storage, read> placements: array<array<u32, PLACEMENT_WORDS>>;
@group(0) @binding(4) var<storage, read> dirs: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> layer: array<u32>;
// What `see_tiles` wrote.
@group(0) @binding(6) var<storage, read> tiles: array<u32>;
@group(0) @binding(7) var<storage, read_write> ends: array<u32>;
// The tiles left open, for `cast_listed`.
@group(0) @binding(8) var<storage, read_write> listed: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

// Whether tiles are listed: on GPUs, whose lanes would wait for others while they look for the next open tile.
override LISTS: bool = false;

// How many tiles the workgroup adds to each of the two lists, and the places where they begin.
var<workgroup> added: array<atomic<u32>, 2>;
var<workgroup> begins: array<u32, 2>;

// Length in voxels of the sections of a cone that are held against blockers one by one.
const SECTION = 4.0;

// How far before the place where a cone touches what may be a blocker it is said to be clear. There, its rays are surely
// before the layer that they are about to enter.
const SHORT = 0.25;

// How far behind where a cone is clear layers across it are looked for, in voxels.
const FAR = 16.0;

// More than floats are off by, in voxels of distance.
const ROUNDED = 0.01;

// Rays of length 1 from `origin` that end within `spread` of `along`.
struct Cone {
    origin: vec3<f32>,
    along: vec3<f32>,
    spread: f32,
    // How much farther than its depth the most slanted of them is, where the sensor measures depths.
    slant: f32,
}

// Voxels from `low` to `high`, both included.
struct Section {
    low: vec3<i32>,
    high: vec3<i32>,
}

fn pixel_index(pixel: vec2<u32>) -> u32 {
    return min(pixel.y, table.image_y - 1u) * table.image_x + min(pixel.x, table.image_x - 1u);
}

fn dir_of(pixel: vec2<u32>) -> vec3<f32> {
    return vec3<f32>(unpacked_dir(dirs[pixel_index(pixel)])) / 32768.0;
}

// The cone of a tile from a placement: the rays of its corners are the farthest apart.
fn cone_of(place: GridFrame, tile: vec2<u32>) -> Cone {
    let low = tile * TILE;
    let high = low + TILE - 1u;
    let a = dir_of(low);
    let b = dir_of(vec2<u32>(high.x, low.y));
    let c = dir_of(vec2<u32>(low.x, high.y));
    let d = dir_of(high);
    let middle = (a + b + c + d) * 0.25;
    let spread = max(max(distance(a, middle), distance(b, middle)), max(distance(c, middle), distance(d, middle)));
    let along = vec3<f32>(
        dot(vec3<f32>(vec3_of(place.axis_q15[0])), middle),
        dot(vec3<f32>(vec3_of(place.axis_q15[1])), middle),
        dot(vec3<f32>(vec3_of(place.axis_q15[2])), middle),
    ) / 32768.0;
    let axial = max(min(min(a.z, b.z), min(c.z, d.z)), f32(LEAST_AXIAL_Q15) / 32768.0);
    let slant = select(1.0, 1.001 / axial, table.along_axis != 0u);
    return Cone(vec3<f32>(vec3_of(place.origin_q16)) / 65536.0, along, spread * 1.001 + 1e-4, slant);
}

// How far a ray may be from the middle of its cone.
fn radius(cone: Cone, t: f32) -> f32 {
    return t * cone.spread + deviation(t);
}

// How much farther the cone goes inside the empty cube that the bricks know around its middle.
fn gain(cone: Cone, t: f32) -> f32 {
    let size = vec3<i32>(vec3<u32>(setup.grid_x, setup.grid_y, setup.grid_z));
    let at = cone.origin + cone.along * t;
    let voxel = integer3(floor(at));
    if any(bitcast<vec3<u32>>(voxel) >= vec3<u32>(size)) {
        return 0.0;
    }
    let reach = reach_of(brick_at(voxel));
    let brick = voxel >> vec3<u32>(BRICK_EDGE_LOG2);
    let low = max((brick - reach + 1) << vec3<u32>(BRICK_EDGE_LOG2), vec3<i32>());
    let high = min((brick + reach) << vec3<u32>(BRICK_EDGE_LOG2), size);
    let to_low = at - vec3<f32>(low) - radius(cone, t);
    let to_high = vec3<f32>(high) - at - radius(cone, t);
    let growth = vec3<f32>(cone.spread + DEVIATION_PER_VOXEL);
    let gains = min(to_low / max(growth - cone.along, vec3<f32>(1e-6)), to_high / max(growth + cone.along, vec3<f32>(1e-6)));
    let inside = reach > 0 && all(to_low >= vec3<f32>()) && all(to_high >= vec3<f32>());
    return select(0.0, min(gains.x, min(gains.y, gains.z)), inside);
}

// The voxels in which a cone's rays may be between two distances.
fn section(cone: Cone, begin: f32, end: f32) -> Section {
    let a = cone.origin + cone.along * begin;
    let b = cone.origin + cone.along * end;
    return Section(integer3(floor(min(a, b) - radius(cone, end))), integer3(floor(max(a, b) + radius(cone, end))));
}

fn is_in_grid(cut: Section) -> bool {
    let size = vec3<i32>(vec3<u32>(setup.grid_x, setup.grid_y, setup.grid_z));
    return all(cut.low >= vec3<i32>()) && all(cut.high < size);
}

// Whether any voxel of a section of the grid is a blocker, and whether all are. Of a section with too many
// rows: any, not all.
fn blockers_in(cut: Section) -> vec2<bool> {
    let size = vec3<u32>(cut.high - cut.low) + 1u;
    let rows = size.y * size.z;
    let vast = rows > MOST_ROWS || size.x > 32u;
    let turns = select(rows, 0u, vast);
    let shift = u32(cut.low.x) & 31u;
    let mask = 0xffffffffu >> ((32u - size.x) & 31u);
    // Whether a row ends in the word after that in which it begins.
    let next = select(0u, 1u, shift + size.x > 32u);
    var some = vast;
    var every = !vast;
    let row_words = setup.grid_words_per_row;
    var word = (u32(cut.low.z) * setup.grid_y + u32(cut.low.y)) * row_words + (u32(cut.low.x) >> 5u);
    // From the last row of a layer to the first of the next.
    let on = (setup.grid_y + 1u - size.y) * row_words;
    var y = 1u;
    var i = 0u;
    loop {
        let above = select(0u, layer[word + next] << ((32u - shift) & 31u), next != 0u);
        let bits = ((layer[word] >> shift) | above) & mask;
        some = some || bits != 0u;
        every = every && bits == mask;
        let is_last = y == size.y;
        word += select(row_words, on, is_last);
        y = select(y, 0u, is_last) + 1u;
        i += 1u;
        if i >= turns {
            break;
        }
    }
    loop_ended(opaque(i) >= turns);
    return vec2<bool>(some, every);
}

// The part of a vector on an axis, without indexing it.
fn on_axis(v: vec3<f32>, axis: u32) -> f32 {
    return select(select(v.z, v.y, axis == 1u), v.x, axis == 0u);
}

// A layer of blockers across an axis that stops all rays of a cone, if `stops`.
struct Across {
    stops: bool,
    axis: u32,
    // Where the layer is on its axis.
    at: i32,
    // The part of it that they may enter.
    layer: Section,
}

// The first layer across an axis that stops all rays of a cone which are before it at `begin`, and before `limit`.
//
// At a distance t the rays are within radius(t) of the cone's middle, on each axis. So with `away` from the sensor to the
// layer on its axis none has entered it before t * slope + radius(t) = away, and all have after t * slope - radius(t) = away.
fn across_axis(cone: Cone, axis: u32, begin: f32, limit: f32) -> Across {
    let own = vec3<u32>(axis) == vec3<u32>(0u, 1u, 2u);
    let size = vec3<i32>(vec3<u32>(setup.grid_x, setup.grid_y, setup.grid_z));
    let is_up = on_axis(cone.along, axis) > 0.0;
    let step = select(-1, 1, is_up);
    let slope = abs(on_axis(cone.along, axis));
    let growth = cone.spread + DEVIATION_PER_VOXEL;
    let origin = on_axis(cone.origin, axis);
    let at = origin + on_axis(cone.along, axis) * begin;
    let first = integer(floor(at + f32(step) * radius(cone, begin))) + step;
    let away = select(origin - f32(first + 1), f32(first) - origin, is_up);
    // Below 0 if no layer stops the cone; so it is with a range of less than a voxel, where `limit` is below 0.
    let farthest = max(min(begin + FAR, limit) - ROUNDED, 0.0) * (slope - growth) - DEVIATION_FIXED;
    let in_grid = select(first + 1, i32(on_axis(vec3<f32>(size), axis)) - first, is_up);
    let in_reach = integer(floor(clamp(farthest - away, -1.0, f32(MOST_LAYERS) - 1.0))) + 1;
    let layers = max(min(in_reach, in_grid), 0);
    var stops = false;
    var looks = 0u;
    var i = 0;
    var layer_at = first;
    var cut: Section;
    loop {
        // The next layer that holds a blocker in the middle: of most, this one look says that they stop nothing. A ray that
        // leaves the grid on another axis enters no layer.
        var is_next = false;
        loop {
            layer_at = first + i * step;
            let own_away = away + f32(i);
            let enters = max((own_away - DEVIATION_FIXED) / (slope + growth) - ROUNDED, begin);
            cut = section(cone, enters, (own_away + DEVIATION_FIXED) / (slope - growth) + ROUNDED);
            cut = Section(select(cut.low, vec3<i32>(layer_at), own), select(cut.high, vec3<i32>(layer_at), own));
            if i < layers && is_in_grid(cut) {
                let middle = (cut.low + cut.high) / 2;
                is_next = is_blocked(brick_at(middle), middle);
            }
            i += 1;
            if is_next || i >= layers {
                break;
            }
        }
        loop_ended(opaque(u32(is_next)) != 0u || opaque(u32(i)) >= u32(layers));
        if !is_next || looks >= MOST_LOOKS {
            break;
        }
        looks += 1u;
        stops = blockers_in(cut).y;
        if stops {
            break;
        }
    }
    loop_ended(opaque(u32(i)) >= u32(layers) || opaque(u32(stops)) != 0u || opaque(looks) >= MOST_LOOKS);
    return Across(stops, axis, layer_at, cut);
}

// A layer across some axis that stops all rays of a cone from `begin` on and before `limit`.
fn across(cone: Cone, begin: f32, limit: f32) -> Across {
    var found: Across;
    var axis = 0u;
    loop {
        found = across_axis(cone, axis, begin, limit);
        axis += 1u;
        if axis >= 3u || found.stops {
            break;
        }
    }
    loop_ended(opaque(axis) >= 3u || opaque(u32(found.stops)) != 0u);
    return found;
}

// Whether no ray of a cone enters a blocker from `begin` on before the layer that stops it.
fn is_clear_before(cone: Cone, begin: f32, found: Across) -> bool {
    let size = vec3<i32>(vec3<u32>(setup.grid_x, setup.grid_y, setup.grid_z));
    let own = vec3<u32>(found.axis) == vec3<u32>(0u, 1u, 2u);
    let at = integer3(floor(cone.origin + cone.along * begin - radius(cone, begin)));
    let on = integer3(floor(cone.origin + cone.along * begin + radius(cone, begin)));
    let is_up = on_axis(cone.along, found.axis) > 0.0;
    let low = select(min(at, found.layer.low), select(found.layer.low + 1, at, is_up), own);
    let high = select(max(on, found.layer.high), select(on, found.layer.high - 1, is_up), own);
    let before = Section(max(low, vec3<i32>()), min(high, size - 1));
    return any(before.low > before.high) || !blockers_in(before).x;
}

// Up to which distance no ray of a cone has entered a blocker, as far as a few looks tell.
fn clear_of(cone: Cone) -> f32 {
    let range = min(f32(table.range_max_q16) / 65536.0 * cone.slant, f32(MAX_RANGE_VOXELS));
    var t = 0.0;
    var sections = 0u;
    var turns = 0u;
    var on = true;
    loop {
        // Leaps, as long as they are long. Software adapters pay for what follows as often as the slowest of eight neighbours.
        var leaps = true;
        loop {
            let more = gain(cone, t);
            leaps = more >= 1.0;
            t += select(0.0, more, leaps);
            turns += u32(leaps);
            if !leaps || turns >= MOST_LEAPS || t > range {
                break;
            }
        }
        loop_ended(opaque(u32(leaps)) == 0u || opaque(turns) >= MOST_LEAPS || t > range);
        if leaps {
            break;
        }
        let cut = section(cone, t, t + SECTION);
        on = is_in_grid(cut) && sections < MOST_SECTIONS;
        if on {
            on = !blockers_in(cut).x;
        }
        t += select(0.0, SECTION, on);
        sections += 1u;
        turns += 1u;
        if !on || turns >= MOST_LEAPS || t > range {
            break;
        }
    }
    loop_ended(opaque(u32(on)) == 0u || opaque(turns) >= MOST_LEAPS || t > range);
    return max(t - SHORT, 0.0);
}

// What is known of the rays of a tile that sees something.
fn word_of(cone: Cone, seen: u32) -> u32 {
    let clear = clear_of(cone);
    let least = max(f32(table.range_min_q16) * cone.slant, f32(table.near_ignore_q16)) / 65536.0;
    let behind = max(f32(seen) + table.nearer, least) + 1.0;
    // The least slanted ray measures no farther than that, at worst.
    let limit = f32(table.range_max_q16) / 65536.0 - 1.0;
    let found = across(cone, clear, limit);
    if !found.stops {
        return SENT | u32(clear * 65536.0);
    }
    // What is lost does not return; and a layer is not all blockers.
    if part.whole_layer != 0u && table.lost_below == 0u && table.shaded == 0u && clear > behind {
        return BEYOND;
    }
    // Before what is ignored, rays do not end.
    let ends_there = clear > f32(table.near_ignore_q16) / 65536.0 + 1.0;
    if ends_there && is_clear_before(cone, clear, found) {
        return SENT | SENT_TO_LAYER | (found.axis << LAYER_BITS) | u32(found.at);
    }
    return SENT | u32(clear * 65536.0);
}

// Lists an invocation's tile if it is open, for all invocations of a workgroup together.
fn list_tile(row: u32, tile: u32, word: u32, local: u32) {
    let is_open = (word & SENT) != 0u;
    let of_layer = (word & SENT_TO_LAYER) != 0u;
    let list = u32(of_layer);
    var place = 0u;
    if is_open {
        place = atomicAdd(&added[list], 1u);
    }
    workgroupBarrier();
    if local < 2u {
        begins[local] = atomicAdd(&listed[head_of_lists(row) + local], atomicLoad(&added[local]));
    }
    workgroupBarrier();
    if is_open {
        atomicStore(&listed[word_of_list(row, begins[list] + place, of_layer)], tile);
    }
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
    var word = 0u;
    // No early return: `report` must see every invocation of the group.
    if item < part.end {
        let size = tiles_of_image();
        let start = seen_from(row);
        let seen = max(tiles[start], tiles[start + 1u + item]);
        let tile = vec2<u32>(item % size.x, item / size.x);
        // Of a mount that is off, all rays are cast: they hit elsewhere than they are believed to go.
        word = SENT;
        if placement.is_off == 0u {
            word = packed(End(BLIND, 0u));
            if seen != 0u {
                word = word_of(cone_of(placement.believed, tile), seen);
            }
        }
        ends[word_of_tile(row, item)] = word;
    }
    if LISTS {
        list_tile(row, item, word, local);
    }
    report(CAST_TILES, local);
}
