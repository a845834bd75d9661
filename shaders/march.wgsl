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

fn made_by(first_q16: u32, period_q16: u32, t_q16: u32) -> u32 {
    // Where the first crossing is later, the difference wraps and is not used.
    return select((t_q16 - first_q16) / period_q16 + 1u, 0u, first_q16 > t_q16);
}

fn crossing_q16(first_q16: u32, period_q16: u32, n: u32) -> u32 {
    let never = first_q16 == NEVER || n * (period_q16 >> 16u) > MAX_RANGE_VOXELS;
    return select(first_q16 + n * period_q16, NEVER, never);
}

// One axis of `crossings_at`: how many of its crossings come before the ray leaves the grid at `exit_q16`.
fn made_inside(first_q16: u32, period_q16: u32, room: u32, order: i32, exit_q16: u32) -> u32 {
    if order == 0 {
        return room;
    }
    // Of what happens at the very distance of the exit, the axes before it come first.
    if order < 0 {
        return made_by(first_q16, period_q16, exit_q16);
    }
    if exit_q16 == 0u {
        return 0u;
    }
    return made_by(first_q16, period_q16, exit_q16 - 1u);
}

fn crossings_at(begin: March, room: vec3<u32>, t_q16: u32) -> u32 {
    let first = begin.next_q16;
    let period = begin.period_q16;
    let leaves = vec3<u32>(
        crossing_q16(first.x, period.x, room.x),
        crossing_q16(first.y, period.y, room.y),
        crossing_q16(first.z, period.z, room.z),
    );
    let exit_q16 = min(leaves.x, min(leaves.y, leaves.z));
    if t_q16 < exit_q16 {
        return made_by(first.x, period.x, t_q16)
            + made_by(first.y, period.y, t_q16)
            + made_by(first.z, period.z, t_q16);
    }
    let exit = i32(next_axis(leaves));
    return made_inside(first.x, period.x, room.x, -exit, exit_q16)
        + made_inside(first.y, period.y, room.y, 1 - exit, exit_q16)
        + made_inside(first.z, period.z, room.z, 2 - exit, exit_q16);
}

fn room(begin: March, size: vec3<u32>) -> vec3<u32> {
    let cell = vec3<u32>(begin.cell);
    return select(size - 1u - cell, cell, begin.step < vec3<i32>());
}

fn pcg(word: u32) -> u32 {
    let state = word * 747796405u + 2891336453u;
    let mixed = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (mixed >> 22u) ^ mixed;
}

fn draw(draws: u32, ray: u32) -> u32 {
    return pcg(draws ^ ray) >> DRAW_SHIFT;
}

fn noisy_q16(t_q16: u32, step_q16: i32) -> u32 {
    return u32(max(i32(t_q16) + step_q16, 0));
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
