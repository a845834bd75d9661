// The list of what `carve_voxels` leaves of its boxes: heads, a word each of workgroups on x, y and z and one of how many voxels
// are left, for each dispatch of `carve_crowded` and then of `carve_near`; then the voxels of one dispatch, those that are near
// from the end on.

// The first word of the head of a dispatch.
fn head_of(number: u32, is_near: bool) -> u32 {
    return (number + select(0u, HEADS, is_near)) * HEAD_WORDS;
}

// The word of a voxel in a list of `words` words. It holds the number of its box in the dispatch, and its own in the box.
fn place_in_list(words: u32, number: u32, is_near: bool) -> u32 {
    return select(2u * HEADS * HEAD_WORDS + number, words - 1u - number, is_near);
}

// Where a voxel with such a word is in its box.
fn place_in_box(word: u32) -> vec3<u32> {
    return (vec3<u32>(word) >> vec3<u32>(0u, 3u, 6u)) & vec3<u32>(BOX_EDGE - 1u);
}
