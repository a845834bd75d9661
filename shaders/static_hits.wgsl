// What each ray of each placement hits first in the still layer, kept for all snapshots of a scene. One
// invocation a ray.
//
// # Theory
// Of a union of two layers the first blocker is the earlier of both layers' (src/march/SEMANTICS.md, "Rays"),
// so what is still need be searched once. What is kept comes before all gates and noise but the sensor's own
// housing and range, which belong to the table.

@group(0) @binding(0) var<uniform> bound_setup: Setup;
@group(0) @binding(1) var<uniform> bound_part: Part;
@group(0) @binding(2) var<uniform> bound_table: Table;
@group(0) @binding(3) var<storage, read> placements: array<array<u32, PLACEMENT_WORDS>>;
@group(0) @binding(4) var<storage, read> dirs: array<vec2<u32>>;
@group(0) @binding(5) var<storage, read> layer: array<u32>;
@group(0) @binding(6) var<storage, read_write> first_hits: array<u32>;
@group(0) @binding(7) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    setup = bound_setup;
    part = bound_part;
    table = bound_table;
    let placement = placement_of(part.first_row + group.y, local);
    let ray = part.first + id.x;
    // No early return: `report` must see every invocation of the group.
    if ray < part.end {
        let begin = launch(placement.truly, dirs[ray]);
        let last_q16 = ray_range_q16(table.range_max_q16, period_q16(axial_of(dirs[ray])));
        first_hits[placement.first_hits * setup.first_hits_stride + ray] = first_hit(begin, last_q16);
    }
    report(STATIC_HITS, local);
}
