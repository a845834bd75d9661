// A ray through the voxels, in integers: the twin of src/march/mod.rs, function by function, without bindings.
// Axes are told apart by comparing, never by indexing a vector: that is slow on software adapters.

struct End {
    kind: u32,
    crossings: u32,
}

struct March {
    cell: vec3<i32>,
    step: vec3<i32>,
    next_q16: vec3<u32>,
    period_q16: vec3<u32>,
}

fn packed(end: End) -> u32 {
    return (end.kind << 16u) | end.crossings;
}

fn unpacked(word: u32) -> End {
    return End(word >> 16u, word & 0xffffu);
}

fn period_q16(d: u32) -> u32 {
    if d < 3u {
        return NEVER;
    }
    // floor(2^32 / d) from 32-bit arithmetic: floor((2^32 - 1) / d), and one more when d divides 2^32.
    return 0xffffffffu / d + u32(0xffffffffu % d == d - 1u);
}

fn first_q16(f: u32, period: u32) -> u32 {
    return (period >> 16u) * f + (((period & 0xffffu) * f) >> 16u);
}

fn direction_q16(axis_q15: vec3<i32>, dir_q15: vec3<i32>) -> i32 {
    let sum = axis_q15.x * dir_q15.x + axis_q15.y * dir_q15.y + axis_q15.z * dir_q15.z;
    return (sum + 8192) >> 14u;
}

// One axis of `start`: when it is first crossed, and how often after that.
fn start_axis(origin_q16: i32, dir_q16: i32) -> vec2<u32> {
    if dir_q16 == 0 {
        return vec2<u32>(NEVER, NEVER);
    }
    let frac = u32(origin_q16 & 0xffff);
    let f = select(0x10000u - frac, frac, dir_q16 < 0);
    let period = period_q16(u32(abs(dir_q16)));
    return vec2<u32>(first_q16(f, period), period);
}

fn start(origin_q16: vec3<i32>, dir_q16: vec3<i32>) -> March {
    let x = start_axis(origin_q16.x, dir_q16.x);
    let y = start_axis(origin_q16.y, dir_q16.y);
    let z = start_axis(origin_q16.z, dir_q16.z);
    return March(
        origin_q16 >> vec3<u32>(16u),
        sign(dir_q16),
        vec3<u32>(x.x, y.x, z.x),
        vec3<u32>(x.y, y.y, z.y),
    );
}

// Ties take x before y before z, so that every backend visits the same cells.
fn next_axis(next_q16: vec3<u32>) -> u32 {
    let x_first = next_q16.x <= next_q16.y && next_q16.x <= next_q16.z;
    return select(select(2u, 1u, next_q16.y <= next_q16.z), 0u, x_first);
}

fn cross(march: ptr<function, March>, axis: u32) {
    let crossed = vec3<u32>(axis) == vec3<u32>(0u, 1u, 2u);
    (*march).cell += select(vec3<i32>(), (*march).step, crossed);
    (*march).next_q16 += select(vec3<u32>(), (*march).period_q16, crossed);
}

fn freed(end: End, no_return_is_free: bool) -> u32 {
    if end.kind == RETURN {
        return end.crossings;
    }
    if end.kind == LEFT || (end.kind == NOTHING && no_return_is_free) {
        return end.crossings + 1u;
    }
    return 0u;
}

// The march of one ray of a placement: `start` in the directions that `direction_q16` gives for each axis.
fn launch(placement: Placement, dir_q15: array<i32, 3>) -> March {
    let dir = vec3_of(dir_q15);
    let dir_q16 = vec3<i32>(
        direction_q16(vec3_of(placement.axis_x_q15), dir),
        direction_q16(vec3_of(placement.axis_y_q15), dir),
        direction_q16(vec3_of(placement.axis_z_q15), dir),
    );
    return start(vec3_of(placement.origin_q16), dir_q16);
}

fn vec3_of(values: array<i32, 3>) -> vec3<i32> {
    return vec3<i32>(values[0], values[1], values[2]);
}
