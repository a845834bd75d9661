// What the host and the kernels share. Scalars only, so that WGSL and Rust agree on every offset; the Rust mirrors
// are in src/backend/gpu/types.rs, and tests/shaders.rs asks naga whether they still match.

// One scene and one sensor, as long as they are loaded.
struct Setup {
    grid_x: u32,
    grid_y: u32,
    grid_z: u32,
    grid_words_per_row: u32,
    window_min_x: i32,
    window_min_y: i32,
    window_min_z: i32,
    window_words_per_row: u32,
    window_x: u32,
    window_y: u32,
    window_z: u32,
    window_words: u32,
    rays: u32,
    range_min_q16: u32,
    range_max_q16: u32,
    near_ignore_q16: u32,
    no_return_is_free: u32,
    backdrop: u32,
    regions: u32,
    unused: u32,
}

// What one dispatch covers: placements from `first_placement` on (one a workgroup row), and rays (cast, carve) or
// words of the window (count) from `first` to `end`, exclusive.
struct Part {
    first_placement: u32,
    first: u32,
    end: u32,
    region: u32,
}

struct Placement {
    origin_q16: array<i32, 3>,
    axis_x_q15: array<i32, 3>,
    axis_y_q15: array<i32, 3>,
    axis_z_q15: array<i32, 3>,
}
