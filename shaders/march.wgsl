// A ray through the voxels, in integers, without bindings. Each function has a twin of the same name in
// src/march/march.rs or src/march/march/leap.rs, and tests/backends/twins.rs runs both. Those whose names end in 3 are the
// same for three axes, and are tested within the others. Axes are told apart by comparing, never by indexing
// a vector: that is slow on software adapters.

struct End {
    kind: u32,
    crossings: u32,
}

struct March {
    voxel: vec3<i32>,
    step: vec3<i32>,
    next_q16: vec3<u32>,
    period_q16: vec3<u32>,
    // The inverse of the period, or a little less (`rate3`): a product instead of a quotient.
    rate: vec3<f32>,
}

fn packed(end: End) -> u32 {
    return (end.kind << 16u) | end.crossings;
}

fn unpacked(word: u32) -> End {
    return End(word >> 16u, word & 0xffffu);
}

// floor(2^32 / d), in floats and put right in integers. However a device rounds, the share errs by less than 2^-21 of itself
// (2.5 ulp for the division). So of the first 2^23 / d, which is less than 2^22, the whole part is found within 3, and what is
// left of 2^32 is within 1536 d of nothing. The second whole part, of less than 1537, is right or off by one: what is left of
// that tells which way.
fn period_q16(d: u32) -> u32 {
    let share = 1.0 / f32(d);
    let about = u32(integer(floor(8388608.0 * share))) << 9u;
    let rest = bitcast<i32>(0u - about * d);
    let more = integer(floor(f32(rest) * share));
    let over = rest - more * i32(d);
    let period = about + u32(more + i32(over >= i32(d)) - i32(over < 0));
    // 2^32 / 2 is already past NEVER.
    return select(period, NEVER, d < 3u);
}

fn first_q16(f: u32, period: u32) -> u32 {
    return (period >> 16u) * f + (((period & 0xffffu) * f) >> 16u);
}

// How much of a ray goes along what its sensor measures along, in Q16: of a depth, the ray's component along the sensor's axis.
fn axial_q16(z_q15: i32, along_axis: bool) -> u32 {
    return select(0x10000u, 2u * u32(max(z_q15, LEAST_AXIAL_Q15)), along_axis);
}

// How far along a ray a depth is, for the period of what it goes along the sensor's axis.
fn ray_range_q16(depth_q16: u32, period_q16: u32) -> u32 {
    let range_q16 = (depth_q16 >> 16u) * period_q16 + first_q16(depth_q16 & 0xffffu, period_q16);
    return min(range_q16, MAX_RANGE_VOXELS << 16u);
}

fn std_along_q16(std_q16: u32, period_q16: u32) -> u32 {
    return min(ray_range_q16(std_q16, period_q16), MAX_STD_VOXELS << 16u);
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
        rate3(dir_q16),
    );
}

// A period is floor(2^32 / d), so d / 2^32, which is a float, is its inverse, or less by 2^-16 of it at most. Where the period
// is NEVER, it is so small that no period lies in any distance.
fn rate3(dir_q16: vec3<i32>) -> vec3<f32> {
    return vec3<f32>(abs(dir_q16)) * (1.0 / 4294967296.0);
}

// Ties take x before y before z, so that every backend visits the same voxels.
fn next_axis(next_q16: vec3<u32>) -> u32 {
    let x_first = next_q16.x <= next_q16.y && next_q16.x <= next_q16.z;
    return select(select(2u, 1u, next_q16.y <= next_q16.z), 0u, x_first);
}

fn cross(march: ptr<function, March>, axis: u32) {
    let crossed = vec3<u32>(axis) == vec3<u32>(0u, 1u, 2u);
    (*march).voxel += select(vec3<i32>(), (*march).step, crossed);
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

// How many whole periods lie in a distance, floor(x / period), for x < 2^28 and the period and rate of a direction. The true
// quotient is less than 4098. The product with the rate is less by 1/15 at most, and off by 2^-10 at most, since floats are
// rounded twice, whichever way. So its whole part is right or off by one: what is left of x tells which way.
fn periods_in(x: u32, period_q16: u32, rate: f32) -> u32 {
    let about = integer(floor(f32(bitcast<i32>(x)) * rate));
    let rest = bitcast<i32>(x - u32(about) * period_q16);
    return u32(about + i32(rest >= bitcast<i32>(period_q16)) - i32(rest < 0));
}

// How many crossings of one axis are made when a ray has come to (t_q16, axis) in the order of all crossings,
// those at that very place included: `own` is the axis in question. An axis below 0 comes before all
// crossings at its distance.
fn made_at(first_q16: u32, period_q16: u32, rate: f32, own: i32, t_q16: u32, axis: i32) -> u32 {
    // At the same distance a later axis has not crossed yet. Negative where the first crossing is later
    // still.
    let x = t_q16 - first_q16 - u32(own > axis);
    return select(periods_in(x, period_q16, rate) + 1u, 0u, bitcast<i32>(x) < 0);
}

fn made_at3(first_q16: vec3<u32>, period_q16: vec3<u32>, rate: vec3<f32>, t_q16: u32, axis: i32) -> vec3<u32> {
    return vec3<u32>(
        made_at(first_q16.x, period_q16.x, rate.x, 0, t_q16, axis),
        made_at(first_q16.y, period_q16.y, rate.y, 1, t_q16, axis),
        made_at(first_q16.z, period_q16.z, rate.z, 2, t_q16, axis),
    );
}

fn crossing_q16(first_q16: u32, period_q16: u32, n: u32) -> u32 {
    let never = first_q16 == NEVER || n * (period_q16 >> 16u) > MAX_RANGE_VOXELS;
    return select(first_q16 + n * period_q16, NEVER, never);
}

fn crossing3_q16(first_q16: vec3<u32>, period_q16: vec3<u32>, n: vec3<u32>) -> vec3<u32> {
    return vec3<u32>(
        crossing_q16(first_q16.x, period_q16.x, n.x),
        crossing_q16(first_q16.y, period_q16.y, n.y),
        crossing_q16(first_q16.z, period_q16.z, n.z),
    );
}

// Where a ray is after some of its crossings.
struct Stand {
    // Crossings made of each axis.
    made: vec3<u32>,
    // Whether it was stopped in the last voxel inside the grid.
    stopped: bool,
}

// Where a ray is after all crossings up to (t_q16, axis), stopped in the last voxel inside the grid.
fn made_until(begin: March, room: vec3<u32>, t_q16: u32, axis: i32) -> Stand {
    let leaves = crossing3_q16(begin.next_q16, begin.period_q16, room);
    let exit = i32(next_axis(leaves));
    let exit_q16 = min(leaves.x, min(leaves.y, leaves.z));
    let stopped = exit_q16 < t_q16 || (exit_q16 == t_q16 && exit <= axis);
    // Of what happens at the very distance of the exit, the axes before it come first.
    let last_q16 = select(t_q16, exit_q16, stopped);
    let last = select(axis, exit - 1, stopped);
    return Stand(made_at3(begin.next_q16, begin.period_q16, begin.rate, last_q16, last), stopped);
}

fn crossings_at(begin: March, room: vec3<u32>, t_q16: u32) -> u32 {
    let made = made_until(begin, room, t_q16, 2).made;
    return made.x + made.y + made.z;
}

// When a ray enters what lies so many voxels ahead, on each axis: -1, which is before all crossings, where
// that is where it begins.
fn enters3_q16(first_q16: vec3<u32>, period_q16: vec3<u32>, ahead: vec3<u32>) -> vec3<i32> {
    let last = crossing3_q16(first_q16, period_q16, max(ahead, vec3<u32>(1u)) - 1u);
    return select(vec3<i32>(-1), vec3<i32>(last), ahead > vec3<u32>());
}

// Whether a ray visits the voxel that lies so many voxels ahead on each axis: it does if it enters on every
// axis before it leaves on any.
fn visits(first_q16: vec3<u32>, period_q16: vec3<u32>, ahead: vec3<u32>) -> bool {
    let enters = enters3_q16(first_q16, period_q16, ahead);
    let leaves = vec3<i32>(crossing3_q16(first_q16, period_q16, ahead));
    return enters.x <= leaves.y && enters.x <= leaves.z
        && enters.y < leaves.x && enters.y <= leaves.z
        && enters.z < leaves.x && enters.z < leaves.y
        // A crossing that never happens enters nothing.
        && max(enters.x, max(enters.y, enters.z)) < i32(NEVER);
}

fn room(begin: March, size: vec3<u32>) -> vec3<u32> {
    let voxel = vec3<u32>(begin.voxel);
    return select(size - 1u - voxel, voxel, begin.step < vec3<i32>());
}

fn pcg(word: u32) -> u32 {
    let state = word * 747796405u + 2891336453u;
    let mixed = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (mixed >> 22u) ^ mixed;
}

fn draw(draws: u32, ray: u32) -> u32 {
    return pcg(draws ^ ray);
}

fn entry(drawn: u32) -> u32 {
    return drawn >> ENTRY_SHIFT;
}

fn is_lost(drawn: u32, lost_below: u32) -> bool {
    return pcg(drawn) < lost_below;
}

fn step_q16(unit_q12: i32, std_q16: u32) -> i32 {
    let whole = i32(std_q16 >> 12u);
    let part = i32(std_q16 & 0xfffu);
    return unit_q12 * whole + ((unit_q12 * part + 2048) >> 12u);
}

fn noisy_q16(t_q16: u32, step_q16: i32) -> u32 {
    return u32(max(i32(t_q16) + step_q16, 0));
}

// The march of a ray of a table: `start` in the directions that `direction_q16` gives for each axis.
fn launch(place: GridFrame, dir: vec2<u32>) -> March {
    let along = unpacked_dir(dir);
    let dir_q16 = vec3<i32>(
        direction_q16(vec3_of(place.axis_q15[0]), along),
        direction_q16(vec3_of(place.axis_q15[1]), along),
        direction_q16(vec3_of(place.axis_q15[2]), along),
    );
    return start(vec3_of(place.origin_q16), dir_q16);
}

fn vec3_of(values: array<i32, 3>) -> vec3<i32> {
    return vec3<i32>(values[0], values[1], values[2]);
}
