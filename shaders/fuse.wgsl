// What the readings of each job say together: the twin of src/backend/fuse.rs. One invocation a word of 32
// voxels; the fused `free` holds no voxel of the fused `occupied`.

@group(0) @binding(0) var<uniform> setup: Setup;
@group(0) @binding(1) var<uniform> part: Part;
@group(0) @binding(2) var<storage, read> jobs: array<Job>;
@group(0) @binding(3) var<storage, read> readings: array<Reading>;
@group(0) @binding(4) var<storage, read> ended: array<u32>;
@group(0) @binding(5) var<storage, read> free: array<u32>;
@group(0) @binding(6) var<storage, read_write> fused_occupied: array<u32>;
@group(0) @binding(7) var<storage, read_write> fused_free: array<u32>;
@group(0) @binding(8) var<storage, read_write> done: array<atomic<u32>, DONE_WORDS>;

// 32 voxels, as one sensor or all of them see them.
struct Said {
    occupied: u32,
    free: u32,
}

fn kept(slot: u32, word: u32) -> Said {
    if slot == NO_SLOT {
        return Said(0u, 0u);
    }
    let plane = slot * setup.window_words;
    return Said(ended[2u * plane + word], free[plane + word]);
}

fn said(reading: Reading, word: u32) -> Said {
    let points = kept(reading.slot, word);
    let volume = kept(reading.volume, word);
    let both = points.occupied | volume.occupied;
    return Said(both, (points.free | volume.free) & ~both);
}

// Occupied if any sensor says so, else free if any does.
fn fuse_word(job: Job, word: u32) -> Said {
    var any = Said(0u, 0u);
    var i = job.first;
    for (; i < job.end; i += 1u) {
        let one = said(readings[i], word);
        any.occupied |= one.occupied;
        any.free |= one.free;
    }
    loop_ended(opaque(i) >= job.end);
    any.free &= ~any.occupied;
    return any;
}

// The sign of the log-odds. Voxels of which all sensors say the same are summed once; there are few kinds in
// a word.
fn sum_word(job: Job, word: u32) -> Said {
    let any = fuse_word(job, word);
    var left = any.occupied | any.free;
    var signs = Said(0u, 0u);
    while left != 0u {
        let first = left & (~left + 1u);
        var same = left;
        var sum = 0;
        var i = job.first;
        for (; i < job.end; i += 1u) {
            let reading = readings[i];
            let one = said(reading, word);
            if (one.occupied & first) != 0u {
                same &= one.occupied;
                sum += reading.hit;
            } else if (one.free & first) != 0u {
                same &= one.free;
                sum += reading.miss;
            } else {
                same &= ~(one.occupied | one.free);
            }
            sum = clamp(sum, LEAST_LOG_ODDS, MOST_LOG_ODDS);
        }
        loop_ended(opaque(i) >= job.end);
        signs.occupied |= select(0u, same, sum > 0);
        signs.free |= select(0u, same, sum < 0);
        left &= ~same;
    }
    loop_ended(opaque(left) == 0u);
    return signs;
}

@compute @workgroup_size(WORKGROUP)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(local_invocation_index) local: u32,
) {
    let word = part.first + id.x;
    // No early return: `report` must see every invocation of the group.
    if word < part.end {
        let row = part.first_row + id.y;
        let job = jobs[row];
        var fused: Said;
        if job.octomap != 0u {
            fused = sum_word(job, word);
        } else {
            fused = fuse_word(job, word);
        }
        let at = row * setup.window_words + word;
        fused_occupied[at] = fused.occupied;
        fused_free[at] = fused.free;
    }
    report(FUSE, local);
}
