// What the host and the kernels share. Scalars only, so that WGSL and Rust agree on every offset; the Rust
// mirrors are in src/march/backend/gpu/types.rs, and tests/backends/shaders.rs checks with naga that they match.

// One scene, as long as it is loaded.
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
    regions: u32,
    // Bricks of blockers on an axis, and the word of a layer where they begin, two of them a word.
    bricks_x: u32,
    bricks_y: u32,
    bricks_word: u32,
    // The word of a layer where its shades begin; 0 where there are none.
    shades_word: u32,
    // Words of the still layer's first hits from one slot to the next.
    first_hits_stride: u32,
    // Counters of people's hits of a job.
    detection_counters: u32,
    // Two boxes of the blockers that are not in the still layer; of none where there is no such layer.
    moving_min_x: i32,
    moving_min_y: i32,
    moving_min_z: i32,
    moving_x: u32,
    moving_y: u32,
    moving_z: u32,
    others_min_x: i32,
    others_min_y: i32,
    others_min_z: i32,
    others_x: u32,
    others_y: u32,
    others_z: u32,
}

// One table of rays.
struct Table {
    // Words of `ends` from one placement to the next: its rays, or where these may go by tiles those of whole tiles and a word
    // a tile, in whole fours.
    ends_stride: u32,
    range_min_q16: u32,
    range_max_q16: u32,
    // Whether these, and the deviations of noise, are depths.
    along_axis: u32,
    near_ignore_q16: u32,
    no_return_is_free: u32,
    backdrop: u32,
    // Whether returns are read elsewhere than they are, and below which number they are lost.
    noisy: u32,
    lost_below: u32,
    // Whether dark blockers return less far than others, and how far those of each shade do.
    shaded: u32,
    shade_range_1_q16: u32,
    shade_range_2_q16: u32,
    shade_range_3_q16: u32,
    shade_range_4_q16: u32,
    shade_range_5_q16: u32,
    shade_range_6_q16: u32,
    shade_range_7_q16: u32,
    // A camera's pixels, focal lengths in pixels, and the depth in voxels up to which voxels are near.
    image_x: u32,
    image_y: u32,
    focal_x: f32,
    focal_y: f32,
    near: f32,
    // How much nearer than it is a return may be read, in voxels.
    nearer: f32,
}

// What one dispatch covers: placements (or jobs, for fuse and count) of the batch from `first_row` on, one a
// workgroup row, and rays, tiles, boxes or words from `first` to `end`, exclusive.
struct Part {
    first_row: u32,
    first: u32,
    end: u32,
    region: u32,
    // Whether all rays are cast, those included that do not come near the window or that tiles would do without.
    every_ray: u32,
    // Of how many tiles an invocation takes a column; 0 where rays do not go by tiles. In `see_tiles` how
    // many boxes a workgroup takes, in `cast_listed` how many tiles there are from one of a workgroup to its next.
    tiles: u32,
    // Whether the layer that is bound holds all blockers.
    whole_layer: u32,
    // Boxes of a dispatch of `carve_voxels`; 0 for all but `carve_boxes`.
    boxes_at_once: u32,
    // Always 0, which compilers do not know.
    zero: u32,
}

// What a dispatch is about, as its kernel reads it. Each kernel copies the uniforms that it binds before all else, since
// software adapters read a word of a uniform once for a vector only outside branches and loops; inside they look it up for
// one invocation after the other.
var<private> setup: Setup;
var<private> table: Table;
var<private> part: Part;

// Where a sensor is, and how it is turned.
struct GridFrame {
    origin_q16: array<i32, 3>,
    axis_q15: array<array<i32, 3>, 3>,
}

struct GridPose {
    believed: GridFrame,
    // Where its rays are cast from: the same again, unless its mount is off.
    truly: GridFrame,
    is_off: u32,
    draws: u32,
    slot: u32,
    // Where its first hits in the still layer are kept, or NO_SLOT.
    first_hits: u32,
}

// A ray's direction, from the two words in which tables have it (`dir_words`): 17 bits of x, the low 15 of z; 17 bits of y,
// the other two of z in the lowest place.
fn unpacked_dir(dir: vec2<u32>) -> vec3<i32> {
    let words = bitcast<vec2<i32>>(dir);
    return vec3<i32>(words >> vec2<u32>(15u), ((words.y << 30u) >> 15u) | (words.x & 0x7fff));
}

// How much of a ray of a table goes along what its sensor measures along (`axial_q16`).
fn axial_of(dir: vec2<u32>) -> u32 {
    return axial_q16(unpacked_dir(dir).z, table.along_axis != 0u);
}

// What is fused: readings from `first` to `end`, exclusive.
struct Job {
    first: u32,
    end: u32,
    octomap: u32,
}

// What one sensor contributes; NO_SLOT stands for evidence that there is not.
struct Reading {
    slot: u32,
    volume: u32,
    hit: i32,
    miss: i32,
    // Whether its hits are felt by a presence sensor.
    presence: u32,
}

// Voxels of one part of one person in one region that share a word of a plane, and the counters of those that
// are hit, of those that presence sensors feel, and of those that at least two readings hit.
struct BodyWord {
    word: u32,
    voxels: u32,
    hits: u32,
    sensed: u32,
    twice: u32,
}

// The end of a ray that returns from behind all that matters.
const BEYOND = (RETURN << 16u) | 0xffffu;
