// Decides the voxels that `carve_voxels` left, which many pixels may see: one workgroup a voxel at a time,
// one invocation a pixel.
//
// # Theory
// As `carve_voxels`: one witness is enough, whichever invocation finds it.

@group(0) @binding(0) var<uniform> setup: Setup;
@group(0) @binding(1) var<uniform> part: Part;
@group(0) @binding(2) var<uniform> table: Table;
@group(0) @binding(3) var<storage, read> placements: array<GridPose>;
@group(0) @binding(4) var<storage, read> dirs_q15: array<array<i32, 3>>;
@group(0) @binding(5) var<storage, read> ends: array<u32>;
@group(0) @binding(6) var<storage, read> pyramid: array<u32>;
@group(0) @binding(7) var<storage, read> undecided: array<u32>;
@group(0) @binding(8) var<storage, read> left: array<u32>;
@group(0) @binding(9) var<storage, read_write> free: array<atomic<u32>>;
@group(0) @binding(10) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

// Which of a group's voxels some invocation has found free.
var<workgroup> found: array<atomic<u32>, SCANS_AT_ONCE>;

// Looks at every WORKGROUPth pixel that may see a voxel.
fn scan(entry: u32, word: u32, local: u32) {
    let box = undecided[part.first + (word >> 9u) + 1u];
    let row = box >> BOX_BITS;
    let placement = placements[row];
    let at = box_corner(box) + vec3<u32>(word & 7u, (word >> 3u) & 7u, (word >> 6u) & 7u);
    let voxel = vec3<i32>(at) + vec3<i32>(setup.window_min_x, setup.window_min_y, setup.window_min_z);
    let own = vec3_of(placement.believed.origin_q16) >> vec3<u32>(16u);
    let away = away(own, voxel, 1).x;
    let pixel_rect = pixel_rect(projection_of(placement.believed), voxel, 1);
    let columns = u32(pixel_rect.last.x - pixel_rect.first.x + 1);
    let pixels = columns * u32(pixel_rect.last.y - pixel_rect.first.y + 1);
    var pixel = local;
    var known = 0u;
    for (; pixel < pixels; pixel += WORKGROUP) {
        let u = u32(pixel_rect.first.x) + pixel % columns;
        let v = u32(pixel_rect.first.y) + pixel / columns;
        let end = unpacked(ends[row * table.rays + v * table.image_x + u]);
        let enough = freed(end, table.no_return_is_free != 0u) > away;
        if enough && sees(placement.believed, dirs_q15[v * table.image_x + u], voxel - own) {
            atomicStore(&found[entry], 1u);
            let plane = placement.slot * setup.window_words;
            let in_row = (at.z * setup.window_y + at.y) * setup.window_words_per_row + (at.x >> 5u);
            atomicOr(&free[plane + in_row], 1u << (at.x & 31u));
        }
        known = atomicLoad(&found[entry]);
        if known != 0u {
            break;
        }
    }
    loop_ended(opaque(known) != 0u || opaque(pixel) >= pixels);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let first = group.x * SCANS_AT_ONCE;
    let count = min(SCANS_AT_ONCE, left[part.region * HEAD_WORDS + 3u] - first);
    var entry = 0u;
    for (; entry < count; entry += 1u) {
        scan(entry, left[HEADS * HEAD_WORDS + first + entry], local);
    }
    loop_ended(opaque(entry) >= count);
    report(CARVE_CROWDED, local);
}
