// A layer of blockers: those of the whole grid in rows, then once more in bricks of 2 × 2 × 2 with their reach, in one
// buffer that the kernel binds as `layer`. A ray that leaps asks for both at once.

// The brick that holds a voxel: which of its voxels are blockers, a bit each, x fastest; from bit 8 on its reach.
fn brick_at(voxel: vec3<i32>) -> u32 {
    let brick = vec3<u32>(voxel) >> vec3<u32>(BRICK_EDGE_LOG2);
    let index = (brick.z * setup.bricks_y + brick.y) * setup.bricks_x + brick.x;
    return (layer[setup.bricks_word + (index >> 1u)] >> ((index & 1u) * 16u)) & 0xffffu;
}

// How dark a voxel is, from 0 to 7: three planes over the whole grid.
fn shade_of(voxel: vec3<i32>) -> u32 {
    let row = u32(voxel.z) * setup.grid_y + u32(voxel.y);
    let word = setup.shades_word + row * setup.grid_words_per_row + (u32(voxel.x) >> 5u);
    let bit = u32(voxel.x) & 31u;
    let one = (layer[word] >> bit) & 1u;
    let two = (layer[word + setup.bricks_word] >> bit) & 1u;
    let four = (layer[word + 2u * setup.bricks_word] >> bit) & 1u;
    return one | (two << 1u) | (four << 2u);
}

// How far a brick is from the nearest that holds a blocker.
fn reach_of(brick: u32) -> i32 {
    return i32(brick >> 8u);
}

// Whether a voxel of a brick is a blocker.
fn is_blocked(brick: u32, voxel: vec3<i32>) -> bool {
    let own = vec3<u32>(voxel) & vec3<u32>(1u);
    return ((brick >> (own.x | (own.y << 1u) | (own.z << 2u))) & 1u) != 0u;
}
