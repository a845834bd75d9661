// The placement that a whole workgroup works on, which the kernel binds as `placements`.
//
// # Practice
// Each invocation looks up a word of it, and all share them. Software adapters look words up for one
// invocation at a time, so a placement that each looked up for itself would cost them more than casting its
// ray. What is shared, at a place that is known when the kernel is compiled, they look up once for a vector.

var<workgroup> placement_words: array<u32, PLACEMENT_WORDS>;

fn shared_vec3(first: u32) -> array<i32, 3> {
    return array<i32, 3>(
        bitcast<i32>(placement_words[first]),
        bitcast<i32>(placement_words[first + 1u]),
        bitcast<i32>(placement_words[first + 2u]),
    );
}

fn shared_frame(first: u32) -> GridFrame {
    let axis_q15 = array<array<i32, 3>, 3>(shared_vec3(first + 3u), shared_vec3(first + 6u), shared_vec3(first + 9u));
    return GridFrame(shared_vec3(first), axis_q15);
}

// For all invocations of a workgroup together.
fn placement_of(row: u32, local: u32) -> GridPose {
    if local < PLACEMENT_WORDS {
        placement_words[local] = placements[row][local];
    }
    workgroupBarrier();
    return GridPose(
        shared_frame(0u),
        shared_frame(12u),
        placement_words[24],
        placement_words[25],
        placement_words[26],
        placement_words[27],
    );
}
