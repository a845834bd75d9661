// Counts one region for each job, word by word of what was fused, in the order of Confusion::from_counts, and
// then what at least two readings label. An
// invocation takes WORDS_PER_INVOCATION words; a group adds its sums to the global counters once.

@group(0) @binding(0) var<uniform> bound_setup: Setup;
@group(0) @binding(1) var<uniform> bound_part: Part;
@group(0) @binding(2) var<storage, read> truth: array<u32>;
@group(0) @binding(3) var<storage, read> human: array<u32>;
@group(0) @binding(4) var<storage, read> robot: array<u32>;
@group(0) @binding(5) var<storage, read> region: array<u32>;
@group(0) @binding(6) var<storage, read> labels: array<u32>;
@group(0) @binding(7) var<storage, read> twice: array<u32>;
@group(0) @binding(8) var<storage, read_write> counts: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

var<workgroup> sums: array<atomic<u32>, REGION_COUNTERS>;

// What an invocation has counted of the voxels of one label: truly occupied, truly free, people's, the robot's.
var<private> of_occupied: vec4<u32>;
var<private> of_free: vec4<u32>;
var<private> of_unknown: vec4<u32>;
// Of any label, those that at least two readings label.
var<private> of_twice: u32;

fn count_word(word: u32, row: u32) {
    let inside = region[word];
    if inside == 0u {
        return;
    }
    let solid = truth[word];
    let voxels = vec4<u32>(inside) & vec4<u32>(solid, ~solid, solid & human[word], solid & robot[word]);
    let plane = row * setup.window_words;
    let o = labels[2u * plane + word];
    let f = labels[2u * plane + setup.window_words + word];
    of_occupied += countOneBits(voxels & vec4<u32>(o));
    of_free += countOneBits(voxels & vec4<u32>(f));
    of_unknown += countOneBits(voxels & vec4<u32>(~(o | f)));
    of_twice += countOneBits(inside & twice[plane + word]);
}

// Adds to a group's counter, which is contended; many are nothing.
fn add(counter: u32, voxels: u32) {
    if voxels != 0u {
        atomicAdd(&sums[counter], voxels);
    }
}

// Adds what was counted of one label, the labels being occupied, free and unknown.
fn add_label(label: u32, voxels: vec4<u32>) {
    add(2u * label, voxels.x);
    add(2u * label + 1u, voxels.y);
    add(6u + label, voxels.z);
    add(9u + label, voxels.w);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    setup = bound_setup;
    part = bound_part;
    let row = part.first_row + group.y;
    // Neighbouring invocations take neighbouring words.
    let first = part.first + group.x * WORKGROUP * WORDS_PER_INVOCATION + local;
    var i = 0u;
    for (; i < WORDS_PER_INVOCATION; i += 1u) {
        let word = first + i * WORKGROUP;
        if word < part.end {
            count_word(word, row);
        }
    }
    loop_ended(opaque(i) >= WORDS_PER_INVOCATION);
    add_label(0u, of_occupied);
    add_label(1u, of_free);
    add_label(2u, of_unknown);
    add(REGION_COUNTERS - 1u, of_twice);
    workgroupBarrier();
    if local < REGION_COUNTERS {
        let sum = atomicLoad(&sums[local]);
        if sum != 0u {
            atomicAdd(&counts[(row * setup.regions + part.region) * REGION_COUNTERS + local], sum);
        }
    }
    report(COUNT, local);
}
