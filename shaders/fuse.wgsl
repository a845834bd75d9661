// What the readings of each job say together: the twin of src/march/backend/fuse.rs. One invocation four words of 32
// voxels, so that readings are looked up for all of them at once. `labels` are two planes of each job, one after the other:
// occupied, and free, which holds no voxel of the first. `twice` are the voxels that at least two readings label.

@group(0) @binding(0) var<uniform> bound_setup: Setup;
@group(0) @binding(1) var<uniform> bound_part: Part;
@group(0) @binding(2) var<storage, read> jobs: array<Job>;
@group(0) @binding(3) var<storage, read> readings: array<Reading>;
@group(0) @binding(4) var<storage, read> ended: array<u32>;
@group(0) @binding(5) var<storage, read> free: array<u32>;
@group(0) @binding(6) var<storage, read_write> labels: array<u32>;
@group(0) @binding(7) var<storage, read_write> twice: array<u32>;
@group(0) @binding(8) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

// Four words of voxels, as one sensor or all of them see them.
struct Said {
    occupied: vec4<u32>,
    free: vec4<u32>,
}

// What all readings say of them, and which voxels at least two label.
struct Fused {
    said: Said,
    twice: vec4<u32>,
}

fn kept(slot: u32, words: vec4<u32>) -> Said {
    if slot == NO_SLOT {
        return Said();
    }
    let at = slot * setup.window_words + words;
    let hits = at + slot * setup.window_words;
    return Said(
        vec4<u32>(ended[hits.x], ended[hits.y], ended[hits.z], ended[hits.w]),
        vec4<u32>(free[at.x], free[at.y], free[at.z], free[at.w]),
    );
}

fn said(reading: Reading, words: vec4<u32>) -> Said {
    let points = kept(reading.slot, words);
    let volume = kept(reading.volume, words);
    let both = points.occupied | volume.occupied;
    return Said(both, (points.free | volume.free) & ~both);
}

// Occupied if any sensor says so, else free if any does.
fn fuse_words(job: Job, words: vec4<u32>) -> Fused {
    var any = Said();
    var both = vec4<u32>();
    var i = job.first;
    loop {
        if i < job.end {
            let one = said(readings[i], words);
            both |= (any.occupied | any.free) & (one.occupied | one.free);
            any.occupied |= one.occupied;
            any.free |= one.free;
        }
        i += 1u;
        if i >= job.end {
            break;
        }
    }
    loop_ended(opaque(i) >= job.end);
    any.free &= ~any.occupied;
    return Fused(any, both);
}

// The sign of the log-odds. Voxels of which all sensors say the same are summed once; there are few kinds in
// a word.
fn sum_words(job: Job, words: vec4<u32>) -> Fused {
    let either = fuse_words(job, words);
    var left = either.said.occupied | either.said.free;
    var signs = Said();
    while any(left != vec4<u32>()) {
        let first = left & (~left + 1u);
        var same = left;
        var sum = vec4<i32>();
        var i = job.first;
        for (; i < job.end; i += 1u) {
            let reading = readings[i];
            let one = said(reading, words);
            let hit = (one.occupied & first) != vec4<u32>();
            let missed = (one.free & first) != vec4<u32>();
            same &= select(select(~(one.occupied | one.free), one.free, missed), one.occupied, hit);
            sum += select(select(vec4<i32>(), vec4<i32>(reading.miss), missed), vec4<i32>(reading.hit), hit);
            sum = clamp(sum, vec4<i32>(LEAST_LOG_ODDS), vec4<i32>(MOST_LOG_ODDS));
        }
        loop_ended(opaque(i) >= job.end);
        signs.occupied |= select(vec4<u32>(), same, sum > vec4<i32>());
        signs.free |= select(vec4<u32>(), same, sum < vec4<i32>());
        left &= ~same;
    }
    loop_ended(opaque(left.x | left.y | left.z | left.w) == 0u);
    return Fused(signs, either.twice);
}

fn write(row: u32, word: u32, occupied: u32, free: u32, both: u32) {
    if word < part.end {
        let plane = row * setup.window_words;
        labels[2u * plane + word] = occupied;
        labels[2u * plane + setup.window_words + word] = free;
        twice[plane + word] = both;
    }
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
    let words = part.first + group.x * WORKGROUP * 4u + local + vec4<u32>(0u, 1u, 2u, 3u) * WORKGROUP;
    // No early return: `report` must see every invocation of the group.
    if words.x < part.end {
        let job = jobs[row];
        let within = min(words, vec4<u32>(part.end - 1u));
        var fused: Fused;
        if job.octomap != 0u {
            fused = sum_words(job, within);
        } else {
            fused = fuse_words(job, within);
        }
        let said = fused.said;
        write(row, words.x, said.occupied.x, said.free.x, fused.twice.x);
        write(row, words.y, said.occupied.y, said.free.y, fused.twice.y);
        write(row, words.z, said.occupied.z, said.free.z, fused.twice.z);
        write(row, words.w, said.occupied.w, said.free.w, fused.twice.w);
    }
    report(FUSE, local);
}
