//! Loops that a driver ends early. Mesa's software adapters do so, and say nothing; here it is done to each
//! loop of each kernel on purpose, and it is always found.

use std::sync::Arc;

use crate::common::cases::{self, Case, case};
use crate::common::{self, Random, say};
use perirobot_march::backend::gpu::{
    DONE_WORDS, Gpu, GpuDevice, SHADER_COMPLETION, Stage, WORKGROUP, evaluate, open, shader_prelude,
    shader_source,
};
use perirobot_march::backend::{Backend, Carving, Fusion, Noise, Shot, oracle::Oracle};
use perirobot_march::march::{Gates, pcg};
use perirobot_march::metrics::Confusion;
use perirobot_march::voxel::{BitGrid, Window};
use perirobot_march::{Error, Result};
use perirobot_study::sensor::Camera;

/// Runs a kernel's statements in one workgroup: they turn `input[0]` times, and leave a number in `hash`,
/// whatever its loops. Says how many invocations proved that their loops ended, and the sum of the numbers.
#[track_caller]
fn turned(device: &GpuDevice, turns: u32, statements: &str) -> (u32, u32) {
    let kernel = format!(
        "
        @group(0) @binding(0) var<storage, read> input: array<u32>;
        @group(0) @binding(1) var<storage, read_write> done: array<atomic<u32>>;
        @compute @workgroup_size(WORKGROUP)
        fn main(@builtin(local_invocation_index) local: u32) {{
            part.zero = input[1];
            let turns = input[0];
            var hash = local;
            {statements}
            atomicAdd(&done[DONE_WORDS], hash);
            report(0u, local);
        }}"
    );
    let source = shader_prelude() + SHADER_COMPLETION + &kernel;
    let words = evaluate(device, source, &[turns, 0], DONE_WORDS as usize + 1, 1);
    let words = words.unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(words[0], 1, "the workgroup ran");
    (words[Stage::ALL.len()], words[DONE_WORDS as usize])
}

/// The sum of what invocations should have come to that hashed so often.
fn hashed(times: u32) -> u32 {
    let of_one = |local: u32| (0..times).fold(local, |hash, _| pcg(hash));
    (0..WORKGROUP).map(of_one).fold(0, u32::wrapping_add)
}

/// Whatever a driver does: what is wrong is proved wrong, and what is proved right is right.
#[test]
fn a_driver_that_ends_loops_early_is_found() {
    let Some(adapter) = common::adapter() else { return };
    let device = open(&adapter).unwrap_or_else(|e| panic!("{e}"));
    let once = "
        var i = 0u;
        for (; i < turns; i += 1u) { hash = pcg(hash); }
        loop_ended(opaque(i) >= turns);";
    // One loop after the other: each makes half of the turns.
    let twice = "
        var i = 0u;
        for (; i < turns / 2u; i += 1u) { hash = pcg(hash); }
        loop_ended(opaque(i) >= turns / 2u);
        for (; i < turns; i += 1u) { hash = pcg(hash); }
        loop_ended(opaque(i) >= turns);";
    // Invocations take turns: each makes an eighth of the turns of eight neighbours together.
    let nested = "
        var k = 0u;
        for (; k < 8u; k += 1u) {
            let own = select(0u, turns / 8u, (local & 7u) == k);
            var i = 0u;
            for (; i < own; i += 1u) { hash = pcg(hash); }
            loop_ended(opaque(i) >= own);
        }
        loop_ended(opaque(k) >= 8u);";
    for (name, statements, share) in [("one loop", once, 1), ("two", twice, 1), ("nested", nested, 8)] {
        for (turns, within) in [(60_000, true), (65_000, true), (66_000, false), (1_000_000, false)] {
            let (whole, sum) = turned(&device, turns, statements);
            let right = sum == hashed(turns / share);
            say(&format!("{name}, {turns} turns: {whole} invocations whole, right: {right}"));
            assert_eq!(
                whole == WORKGROUP,
                right,
                "{name}, {turns} turns: {whole} of {WORKGROUP} are proved whole"
            );
            assert!(
                right || !within,
                "{name}, {turns} turns: fewer than src/march/backend/gpu/loop_bounds.rs allows"
            );
        }
    }
}

/// Where the loops of a kernel begin: the ends of the lines that head them.
fn heads(source: &str) -> Vec<usize> {
    let is_head = |line: &&str| {
        let line = line.trim();
        line.ends_with('{') && (line.starts_with("loop") || line.starts_with("for ("))
    };
    let end = |line: &str| line.as_ptr() as usize - source.as_ptr() as usize + line.len();
    source.lines().filter(is_head).map(end).collect()
}

/// A kernel with a loop that ends after its first turn, as loops do on a driver that has had enough of them.
fn cut(source: &str, head: usize) -> String {
    let line = source[..head].rfind('\n').map_or(0, |end| end + 1);
    let (before, rest) = source.split_at(line);
    let (header, body) = rest.split_at(head - line);
    format!("{before}var cut_after = 0u;\n{header}\nif cut_after > 0u {{ break; }}\ncut_after += 1u;\n{body}")
}

/// A case whose first table is a camera of more pixels than voxels, in the middle of the grid; in an `empty`
/// one nothing stops its rays, and all they pass is free, whole boxes of voxels.
fn close_up(seed: u64, empty: bool) -> Case {
    let mut case = case(seed);
    let mut random = Random(seed);
    let fov_rad = if empty { [2.0, 2.0] } else { [0.9, 0.7] };
    let camera = Camera { fov_rad, resolution_px: [500, 400] };
    case.tables[0].dirs_q15 = camera.dirs_q15().into();
    case.tables[0].image = Some(camera.image());
    case.tables[0].gates = Gates { no_return_is_free: empty, ..cases::open_gates() };
    if empty {
        case.scene.blockers = Arc::new(BitGrid::new(case.scene.blockers.window()));
        case.scene.shades = None;
        case.scene.over_time = None;
        case.scene.regions[0] = BitGrid::full(case.scene.window);
    }
    let size = case.scene.blockers.window().size;
    for shot in &mut case.shots {
        shot.table = 0;
        shot.placement.axis_q15 = cases::quarter_turns(&mut random);
        shot.placement.origin_q16 = size.map(|n| (n << 15) as i32 + 77);
    }
    case
}

/// A case whose cameras stand beside a small window in a large hall: most of what they see is far behind all that
/// matters.
fn hall(seed: u64) -> Case {
    let mut case = close_up(seed, true);
    let size = [96; 3];
    let mut walls = BitGrid::full(Window { min: [0; 3], size });
    walls.remove(&BitGrid::full(Window { min: [1; 3], size: [94; 3] }));
    case.scene.blockers = Arc::new(walls);
    case.scene.shades = None;
    case.tables[0].noise = Noise::default();
    let middle: [i32; 3] =
        std::array::from_fn(|r| case.scene.window.min[r] + case.scene.window.size[r] as i32 / 2);
    for (shot, r) in case.shots.iter_mut().zip([0, 1, 2, 0]) {
        let mut origin = middle;
        origin[r] += 14;
        shot.placement.origin_q16 = origin.map(|n| (n << 16) + 77);
        shot.placement.truly = None;
    }
    case
}

/// A case whose cameras look along rows of boxes, each of which a quarter of an image sees.
fn narrow(seed: u64) -> Case {
    let mut case = close_up(seed, true);
    let camera = Camera { fov_rad: [0.3, 0.3], resolution_px: [640, 480] };
    case.tables[0].dirs_q15 = camera.dirs_q15().into();
    case.tables[0].image = Some(camera.image());
    let [x, y, z] = case.scene.window.min;
    for shot in &mut case.shots {
        shot.placement.axis_q15 = [[0, 0, 32_768], [32_768, 0, 0], [0, 32_768, 0]];
        shot.placement.origin_q16 = [x, y + 8, z + 8].map(|n| (n << 16) + 77);
        shot.placement.truly = None;
    }
    case
}

/// What a backend counts of a case.
fn counts(backend: &mut dyn Backend, case: &Case) -> Result<Vec<Vec<Confusion>>> {
    backend.tables(&case.tables)?;
    backend.load(&case.scene)?;
    for table in 0..case.tables.len() {
        // First hits are kept where there is room, under a number for each shot.
        let room = backend.first_hit_slots() as u32;
        let shots = case.shots.iter().zip(0..).filter(|(shot, _)| shot.table == table);
        let shots: Vec<_> = shots
            .map(|(shot, number)| Shot {
                first_hits: Some(number).filter(|&number| number < room),
                ..Shot::once(shot.slot, shot.placement)
            })
            .collect();
        backend.sense(table, &shots)?;
    }
    backend.upload(case.uploads.clone())?;
    let mut counts = backend.score(Fusion::OccupiedWins, &case.jobs)?;
    counts.extend(backend.score(Fusion::Octomap, &case.jobs)?);
    Ok(counts)
}

#[test]
fn each_loop_that_is_cut_is_found_in_the_same_batch() {
    let Some(adapter) = common::adapter() else { return };
    let of_seed = |seed| if seed % 2 == 0 { close_up(seed, false) } else { case(seed) };
    // Room for whole boxes of free voxels.
    let is_large = |seed: &u64| case(*seed).scene.window.size.iter().all(|&n| n >= 24);
    let empty = (24..).filter(is_large).take(4).map(|seed| close_up(seed, true));
    let narrow = (24..).filter(is_large).take(4).map(narrow);
    let is_small = |seed: &u64| {
        let scene = case(*seed).scene;
        !scene.regions.is_empty() && scene.window.size.iter().all(|&n| n <= 16)
    };
    let halls = (24..).filter(is_small).take(12).map(hall);
    let cases: Vec<_> = (0..24).map(of_seed).chain(empty).chain(narrow).chain(halls).collect();
    let of_oracle = |case: &Case| counts(&mut Oracle::default(), case).unwrap_or_else(|e| panic!("{e}"));
    let expected: Vec<_> = cases.iter().map(of_oracle).collect();
    // Tiles are listed on a GPU only.
    let opened = |listed: bool, source: &dyn Fn(Stage) -> String| {
        let device = open(&adapter)?;
        Gpu::from_device(if listed { device.treat_as_gpu() } else { device }, source)
    };
    for (carving, listed) in [(Carving::ByVoxel, false), (Carving::ByRay, false), (Carving::ByVoxel, true)] {
        let mut gpu = opened(listed, &shader_source).unwrap_or_else(|e| panic!("{e}"));
        gpu.carve_by(Some(carving));
        for (case, expected) in cases.iter().zip(&expected) {
            let found = counts(&mut gpu, case).unwrap_or_else(|e| panic!("{e}"));
            assert!(found == *expected, "case {}, {carving:?}, listed {listed}: with whole loops", case.seed);
        }
    }
    for stage in Stage::ALL {
        // It comes with `freed_range` of shaders/freed.wgsl, and does not call it.
        let uncalled = usize::from([Stage::CarveCrowded, Stage::CarveNear].contains(&stage));
        for (number, head) in heads(&shader_source(stage)).into_iter().enumerate().skip(uncalled) {
            let place = format!("loop {number} of `{}`", stage.name());
            let source = |s: Stage| if s == stage { cut(&shader_source(s), head) } else { shader_source(s) };
            let listed = stage == Stage::CastListed;
            let mut gpu = opened(listed, &source).unwrap_or_else(|e| panic!("{place}: {e}"));
            let mut found = 0;
            let by_ray = stage == Stage::CarveRays;
            gpu.carve_by(Some(if by_ray { Carving::ByRay } else { Carving::ByVoxel }));
            for (case, expected) in cases.iter().zip(&expected) {
                match counts(&mut gpu, case) {
                    Ok(counts) => assert!(counts == *expected, "{place}, case {}: not found", case.seed),
                    Err(Error::Device(what)) => {
                        let told = format!("invocations of `{}` all loops ended", stage.name());
                        assert!(
                            what.to_string().contains("loops cut short") && what.to_string().contains(&told),
                            "{place}: {what}"
                        );
                        found += 1;
                    }
                    Err(other) => panic!("{place}: {other}"),
                }
                if found > 2 {
                    break;
                }
            }
            say(&format!("{place}: found {found} times"));
            assert!(found > 0, "{place}: no case turns it twice");
        }
    }
}
