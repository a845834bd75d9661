// What blocks of a camera's pixels free, as the kernels that carve voxel by voxel look it up. They bind the pyramid
// (`blocks.wgsl`) as `pyramid`, four words at a time.

// Least and most that the pixels of a block free, of those of a level.
fn freed_by_block(row: u32, level: u32, block: vec2<u32>) -> vec2<u32> {
    let tiles = pyramid_tiles();
    let at = row * pyramid_words(tiles) + level_start(tiles, level) + block_at(tiles, level, block);
    let word = pyramid[at >> 2u][at & 3u];
    return vec2<u32>(word & 0xffffu, word >> 16u);
}

// Least and most that the pixels of a rectangle free, or those of a little more. At most nine turns of a loop:
// of rectangles too large for that it says nothing.
fn freed_range(row: u32, first: vec2<i32>, last: vec2<i32>) -> vec2<u32> {
    let tiles = pyramid_tiles();
    let wide = max(last.x - first.x, last.y - first.y);
    let vast = wide >= i32(4u << MOST_LEVEL);
    // At most five blocks on an axis, for rectangles of up to four of the largest.
    let level = clamp(u32(max(firstLeadingBit(wide), 0)), LEAST_LEVEL + 1u, MOST_LEVEL + 1u) - 1u;
    let fours_across = (tiles.x << (MOST_LEVEL - level)) >> 1u;
    let start = (row * pyramid_words(tiles) + level_start(tiles, level)) >> 2u;
    let low = vec2<u32>(first) >> vec2<u32>(level);
    let high = vec2<u32>(last) >> vec2<u32>(level);
    let end = high >> vec2<u32>(1u);
    var leasts = vec4<u32>(0xffffu);
    var mosts = vec4<u32>();
    var at = low >> vec2<u32>(1u);
    loop {
        let words = pyramid[start + at.y * fours_across + at.x];
        let begins = at * 2u >= low;
        let ends_in = at * 2u < high;
        let inside = vec4<bool>(begins.x && begins.y, ends_in.x && begins.y, begins.x && ends_in.y, ends_in.x && ends_in.y);
        leasts = min(leasts, select(vec4<u32>(0xffffu), words & vec4<u32>(0xffffu), inside));
        mosts = max(mosts, select(vec4<u32>(), words >> vec4<u32>(16u), inside));
        at.x += 1u;
        let next = at.x > end.x;
        at = select(at, vec2<u32>(low.x >> 1u, at.y + 1u), next);
        if at.y > end.y || vast {
            break;
        }
    }
    loop_ended(vast || opaque(at.y) > end.y);
    let least = min(min(leasts.x, leasts.y), min(leasts.z, leasts.w));
    let most = max(max(mosts.x, mosts.y), max(mosts.z, mosts.w));
    return select(vec2<u32>(least, most), vec2<u32>(0u, 0xffffu), vast);
}
