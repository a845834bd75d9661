// Counts the people's voxels that any reading of a job hits, part by part, and those that presence sensors
// feel, person by person, and those that several readings hit: the twin of src/march/backend/count.rs. One invocation a word of voxels of one part in
// one region.

@group(0) @binding(0) var<uniform> bound_setup: Setup;
@group(0) @binding(1) var<uniform> bound_part: Part;
@group(0) @binding(2) var<storage, read> jobs: array<Job>;
@group(0) @binding(3) var<storage, read> readings: array<Reading>;
@group(0) @binding(4) var<storage, read> body_words: array<BodyWord>;
@group(0) @binding(5) var<storage, read> ended: array<u32>;
@group(0) @binding(6) var<storage, read_write> found: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

// The hits of a slot in a word; its second plane of `ended`.
fn hits_of(slot: u32, word: u32) -> u32 {
    if slot == NO_SLOT {
        return 0u;
    }
    return ended[(2u * slot + 1u) * setup.window_words + word];
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    setup = bound_setup;
    part = bound_part;
    let item = part.first + id.x;
    // No early return: `report` must see every invocation of the group.
    if item < part.end {
        let row = part.first_row + id.y;
        let job = jobs[row];
        let some = body_words[item];
        var hit = 0u;
        var twice = 0u;
        var sensed = 0u;
        var i = job.first;
        for (; i < job.end; i += 1u) {
            let reading = readings[i];
            let hits = hits_of(reading.slot, some.word) | hits_of(reading.volume, some.word);
            twice |= hit & hits;
            hit |= hits;
            sensed |= select(0u, hits, reading.presence != 0u);
        }
        loop_ended(opaque(i) >= job.end);
        let first = row * setup.detection_counters;
        if (hit & some.voxels) != 0u {
            atomicAdd(&found[first + some.hits], countOneBits(hit & some.voxels));
        }
        if (sensed & some.voxels) != 0u {
            atomicAdd(&found[first + some.sensed], countOneBits(sensed & some.voxels));
        }
        if (twice & some.voxels) != 0u {
            atomicAdd(&found[first + some.twice], countOneBits(twice & some.voxels));
        }
    }
    report(DETECT, local);
}
