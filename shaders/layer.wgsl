// A layer of blockers: those of the whole grid, and the reach of their bricks, in one buffer that the kernel
// binds as `layer`.

// The reach of the brick that holds a voxel.
fn reach_at(voxel: vec3<i32>) -> i32 {
    let brick = vec3<u32>(voxel) >> vec3<u32>(BRICK_EDGE_LOG2);
    let index = (brick.z * setup.bricks_y + brick.y) * setup.bricks_x + brick.x;
    return i32((layer[setup.reach_word + (index >> 2u)] >> ((index & 3u) * 8u)) & 0xffu);
}

// Whether a voxel of the grid is a blocker.
fn is_blocked(voxel: vec3<i32>) -> bool {
    let word = (u32(voxel.z) * setup.grid_y + u32(voxel.y)) * setup.grid_words_per_row + (u32(voxel.x) >> 5u);
    return ((layer[word] >> (u32(voxel.x) & 31u)) & 1u) != 0u;
}
