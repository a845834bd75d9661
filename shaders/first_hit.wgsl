// What a ray hits first in a layer of blockers (`layer.wgsl`), before any gate: the part that `cast` and
// `static_hits` share.
//
// # Theory
// All bricks nearer than the reach of a brick are empty (src/march/voxel/bricks.rs), so all crossings inside that
// cube and the one that leaves it may be made at once, in closed form; the first blocker is the one that
// single steps would find. In a brick that holds blockers the cube is the voxel itself, and the leap a step:
// there is one way of moving, since software adapters pay for every branch, taken or not.

// No blocker within range inside the grid.
const NO_HIT = 0xffffffffu;

// Voxels ahead on each axis in the empty cube around a voxel, cut to the grid.
fn ahead(voxel: vec3<i32>, step: vec3<i32>, reach: i32, size: vec3<i32>) -> vec3<u32> {
    let brick = voxel >> vec3<u32>(BRICK_EDGE_LOG2);
    let low = max((brick - reach + 1) << vec3<u32>(BRICK_EDGE_LOG2), vec3<i32>());
    let high = min((brick + reach) << vec3<u32>(BRICK_EDGE_LOG2), size);
    // Without reach both are behind the voxel.
    return vec3<u32>(max(select(high - 1 - voxel, voxel - low, step < vec3<i32>()), vec3<i32>()));
}

// A ray on its way at a distance up to which it has entered no blocker; at 0, where it begins.
fn sent_on(begin: March, t_q16: u32) -> March {
    let made = select(vec3<u32>(), made_at3(begin.next_q16, begin.period_q16, begin.rate, t_q16, 2), t_q16 > 0u);
    let next_q16 = min(begin.next_q16 + made * begin.period_q16, vec3<u32>(NEVER));
    return March(begin.voxel + begin.step * vec3<i32>(made), begin.step, next_q16, begin.period_q16, begin.rate);
}

// The first blocker of a ray in one word that orders by distance: the distance times four, plus the axis of
// the crossing into it; NO_HIT if there is none up to `last_q16`.
fn first_hit(begin: March, last_q16: u32) -> u32 {
    var ray = begin;
    let size = vec3<i32>(vec3<u32>(setup.grid_x, setup.grid_y, setup.grid_z));
    var reach = reach_of(brick_at(ray.voxel));
    var hit = NO_HIT;
    var t = 0u;
    loop {
        let leaves = crossing3_q16(ray.next_q16, ray.period_q16, ahead(ray.voxel, ray.step, reach, size));
        let axis = next_axis(leaves);
        t = min(leaves.x, min(leaves.y, leaves.z));
        if t > last_q16 {
            break;
        }
        let made = made_at3(ray.next_q16, ray.period_q16, ray.rate, t, i32(axis));
        ray.voxel += ray.step * vec3<i32>(made);
        // What is never crossed again stays a signed number.
        ray.next_q16 = min(ray.next_q16 + made * ray.period_q16, vec3<u32>(NEVER));
        // A negative coordinate is a huge unsigned one.
        if any(bitcast<vec3<u32>>(ray.voxel) >= vec3<u32>(size)) {
            break;
        }
        let brick = brick_at(ray.voxel);
        reach = reach_of(brick);
        if is_blocked(brick, ray.voxel) && t >= table.near_ignore_q16 {
            hit = (t << 2u) | axis;
            break;
        }
    }
    let outside = any(bitcast<vec3<u32>>(ray.voxel) + opaque(0u) >= vec3<u32>(size));
    loop_ended(opaque(t) > last_q16 || outside || opaque(hit) != NO_HIT);
    return hit;
}
