// Counts one region for each job, word by word of what was fused, in the order of Confusion::from_counts. An
// invocation takes WORDS_PER_INVOCATION words; a group adds its sums to the global counters once.

@group(0) @binding(0) var<uniform> setup: Setup;
@group(0) @binding(1) var<uniform> part: Part;
@group(0) @binding(2) var<storage, read> truth: array<u32>;
@group(0) @binding(3) var<storage, read> human: array<u32>;
@group(0) @binding(4) var<storage, read> robot: array<u32>;
@group(0) @binding(5) var<storage, read> region: array<u32>;
@group(0) @binding(6) var<storage, read> occupied: array<u32>;
@group(0) @binding(7) var<storage, read> free: array<u32>;
@group(0) @binding(8) var<storage, read_write> counts: array<atomic<u32>>;
@group(0) @binding(9) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

var<workgroup> sums: array<atomic<u32>, COUNTERS>;

fn count(counter: u32, voxels: u32) {
    // Many combinations never occur in a word; a group's counters are contended.
    if voxels != 0u {
        atomicAdd(&sums[counter], countOneBits(voxels));
    }
}

fn count_word(word: u32, evidence: u32) {
    let inside = region[word];
    if inside == 0u {
        return;
    }
    let solid = truth[word];
    let o = occupied[evidence] & inside;
    let f = free[evidence] & inside & ~o;
    let u = inside & ~(o | f);
    count(0u, o & solid);
    count(1u, o & ~solid);
    count(2u, f & solid);
    count(3u, f & ~solid);
    count(4u, u & solid);
    count(5u, u & ~solid);
    let person = solid & human[word];
    count(6u, o & person);
    count(7u, f & person);
    count(8u, u & person);
    let machine = solid & robot[word];
    count(9u, o & machine);
    count(10u, f & machine);
    count(11u, u & machine);
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let row = part.first_row + group.y;
    // Neighbouring invocations take neighbouring words.
    let first = part.first + group.x * WORKGROUP * WORDS_PER_INVOCATION + local;
    var i = 0u;
    for (; i < WORDS_PER_INVOCATION; i += 1u) {
        let word = first + i * WORKGROUP;
        if word < part.end {
            count_word(word, row * setup.window_words + word);
        }
    }
    loop_ended(opaque(i) >= WORDS_PER_INVOCATION);
    workgroupBarrier();
    if local < COUNTERS {
        let sum = atomicLoad(&sums[local]);
        if sum != 0u {
            atomicAdd(&counts[(row * setup.regions + part.region) * COUNTERS + local], sum);
        }
    }
    report(COUNT, local);
}
