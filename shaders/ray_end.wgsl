// How a ray of a table ends once its first hit is known, and what is marked for it: what `cast` and `cast_listed` share. The
// kernel binds `noise` and `ended`.

// How a ray ended, in which voxel it is read, and in which a return has its blocker.
struct Finish {
    end: End,
    voxel: vec3<i32>,
    hit: vec3<i32>,
}

// How a ray is slanted to what its sensor measures along, and its longest range.
struct Slant {
    axial_q16: u32,
    period_q16: u32,
    range_max_q16: u32,
}

fn slant_of(dir: vec2<u32>) -> Slant {
    let axial_q16 = axial_of(dir);
    let period_q16 = period_q16(axial_q16);
    return Slant(axial_q16, period_q16, ray_range_q16(table.range_max_q16, period_q16));
}

// What a return at a distance is off by: the unit table comes first in the buffer.
fn off_by_q16(slant: Slant, drawn: u32, t_q16: u32) -> i32 {
    if table.noisy == 0u {
        return 0;
    }
    let rate = rate3(vec3<i32>(i32(slant.axial_q16))).x;
    let std_q16 = u32(noise[NOISE_STEPS + periods_in(t_q16, slant.period_q16, rate)]);
    return step_q16(noise[entry(drawn)], std_along_q16(std_q16, slant.period_q16));
}

// `sent` is the ray that is truly cast; `begin` the same as it is believed to go, another where the mount is
// off. `too_weak` says that what it hit is too dark for its distance.
fn finish(sent: March, begin: March, is_off: bool, slant: Slant, found: u32, too_weak: bool, drawn: u32) -> Finish {
    let size = vec3<u32>(setup.grid_x, setup.grid_y, setup.grid_z);
    let hit_q16 = found >> 2u;
    let blind = found != NO_HIT && hit_q16 < ray_range_q16(table.range_min_q16, slant.period_q16);
    let lost = (is_lost(drawn, table.lost_below) || too_weak) && !blind;
    let nothing = found == NO_HIT || lost;
    var kind = select(RETURN, BLIND, blind);
    var step_q16 = 0;
    if !nothing {
        step_q16 = off_by_q16(slant, drawn, hit_q16);
    }
    // Where it is read: at the crossing into the blocker; with noise, or on a ray that is only believed,
    // after all crossings up to there.
    let exact = !is_off && (blind || step_q16 == 0);
    let read_q16 = select(noisy_q16(hit_q16, step_q16), hit_q16, blind || step_q16 == 0);
    let read_axis = select(2, i32(found & 3u), exact);
    let stand = made_until(
        begin,
        room(begin, size),
        select(read_q16, slant.range_max_q16, nothing),
        select(read_axis, 2, nothing),
    );
    var stopped = stand.stopped;
    if is_off {
        stopped = made_until(sent, room(sent, size), slant.range_max_q16, 2).stopped;
    }
    let left = stopped && table.backdrop != 0u && !lost;
    kind = select(kind, select(NOTHING, LEFT, left), nothing);
    let voxel = begin.voxel + begin.step * vec3<i32>(stand.made);
    var hit = voxel;
    if !exact {
        let made = made_at3(sent.next_q16, sent.period_q16, sent.rate, hit_q16, i32(found & 3u));
        hit = sent.voxel + sent.step * vec3<i32>(made);
    }
    return Finish(End(kind, stand.made.x + stand.made.y + stand.made.z), voxel, hit);
}

// Marks a voxel in a plane of `ended`: planes 2 · slot and 2 · slot + 1 are a slot's occupied voxels and its
// hits.
fn mark(plane: u32, voxel: vec3<i32>) {
    let at = voxel - vec3<i32>(setup.window_min_x, setup.window_min_y, setup.window_min_z);
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

// The axis of the layer of voxels that all rays of a tile enter (SENT_TO_LAYER).
fn axis_of_layer(known: u32) -> u32 {
    return (known & ~(SENT | SENT_TO_LAYER)) >> LAYER_BITS;
}

// When a ray of the tile crosses into that layer.
fn enters_layer_q16(begin: March, known: u32) -> i32 {
    let own = vec3<u32>(axis_of_layer(known)) == vec3<u32>(0u, 1u, 2u);
    let ahead = abs(vec3<i32>(i32(known & ((1u << LAYER_BITS) - 1u))) - begin.voxel);
    let enters = enters3_q16(begin.next_q16, begin.period_q16, select(vec3<u32>(), vec3<u32>(ahead), own));
    return max(enters.x, max(enters.y, enters.z));
}

// Up to which distance a ray of a tile has entered no blocker.
fn clear_q16(begin: March, known: u32) -> u32 {
    if (known & SENT_TO_LAYER) == 0u {
        return known & ~SENT;
    }
    return u32(clamp(enters_layer_q16(begin, known) - 1, 0, i32(table.range_max_q16)));
}
