//! The oracle, the CPU and the GPU give the same integers: every count, plane and end, on random cells.
//! `PERIROBOT_CASE=<seed>` runs one case.

mod common;

use common::cases::{Case, case, open_gates};
use common::{Random, cases};
use perirobot::backend::cpu::Cpu;
use perirobot::backend::gpu::{AdapterChoice, Gpu};
use perirobot::backend::oracle::Oracle;
use perirobot::backend::{Backend, Evidence, Rays};
use perirobot::voxel::BitGrid;

/// Runs a case on both and compares all that comes back.
#[track_caller]
fn compare(expected: &mut impl Backend, found: &mut impl Backend, case: &Case, test: &str) {
    let names = format!("{} (left) against {} (right)", found.name(), expected.name());
    let rerun = format!("rerun: PERIROBOT_CASE={} cargo test --test backends {test}", case.seed);
    let (window, gates) = (case.cell.window, case.rays.gates);
    let size = case.cell.blockers.window().size;
    let place = |number: usize| {
        let placement = case.placements[number];
        let of = format!("{names}, case {}, placement {number}", case.seed);
        format!("{of} {placement:?}\n{window:?} of {size:?}, {gates:?}")
    };
    let mut both: [&mut dyn Backend; 2] = [found, expected];
    for backend in &mut both {
        unwrap(backend.load(&case.cell, &case.rays), &rerun);
    }
    // Evidence first: a wrong ray says more than the counts that follow from it.
    for (number, placement) in case.placements.iter().enumerate() {
        let [left, right] = both.each_mut().map(|backend| unwrap(backend.read(placement), &rerun));
        if let Some(difference) = difference(&left, &right, &case.rays) {
            panic!("{}\n{difference}\n{rerun}", place(number));
        }
    }
    let [left, right] = both.map(|backend| unwrap(backend.score(&case.placements), &rerun));
    assert_eq!((left.len(), right.len()), (case.placements.len(), case.placements.len()), "{names}\n{rerun}");
    for (number, (left, right)) in left.iter().zip(&right).enumerate() {
        assert_eq!(left.len(), case.cell.regions.len(), "{}\n{rerun}", place(number));
        for (region, (left, right)) in left.iter().zip(right).enumerate() {
            assert_eq!(left.counts(), right.counts(), "region {region}, {}\n{rerun}", place(number));
        }
    }
}

#[track_caller]
fn unwrap<T>(result: perirobot::Result<T>, rerun: &str) -> T {
    result.unwrap_or_else(|error| panic!("{error}\n{rerun}"))
}

/// The first ray or voxel in which two pieces of evidence differ.
fn difference(left: &Evidence, right: &Evidence, rays: &Rays) -> Option<String> {
    if left.ends.len() != right.ends.len() {
        return Some(format!("{} ends, {} expected", left.ends.len(), right.ends.len()));
    }
    if let Some(ray) = (0..left.ends.len()).find(|&ray| left.ends[ray] != right.ends[ray]) {
        let dir_q15 = rays.dirs_q15[ray];
        return Some(format!("ray {ray}, {dir_q15:?}: {:?}, expected {:?}", left.ends[ray], right.ends[ray]));
    }
    let planes = [("occupied", &left.occupied, &right.occupied), ("free", &left.free, &right.free)];
    planes.iter().find_map(|(name, left, right)| plane_difference(name, left, right))
}

fn plane_difference(name: &str, left: &BitGrid, right: &BitGrid) -> Option<String> {
    if left == right {
        return None;
    }
    let differs = |&cell: &[i32; 3]| left.get(cell) != right.get(cell);
    Some(match left.cells().chain(right.cells()).filter(differs).min_by_key(|&[x, y, z]| [z, y, x]) {
        Some(voxel) => {
            format!("{name}: voxel {voxel:?} is {}, expected {}", left.get(voxel), right.get(voxel))
        }
        None => format!("{name}: padding or windows differ: {:?}, {:?}", left.window(), right.window()),
    })
}

/// The seeds to run: those given, or the one asked for.
fn seeds(all: std::ops::Range<u64>) -> std::ops::Range<u64> {
    match std::env::var("PERIROBOT_CASE").ok().and_then(|seed| seed.parse().ok()) {
        Some(seed) => seed..seed + 1,
        None => all,
    }
}

fn gpu() -> Option<Gpu> {
    let choice: AdapterChoice = common::adapter()?;
    Some(Gpu::new(&choice).unwrap_or_else(|e| panic!("{e}")))
}

#[test]
fn the_cpu_equals_the_oracle() {
    let mut cpu = Cpu::new(Some(2)).unwrap_or_else(|e| panic!("{e}"));
    for seed in seeds(0..400) {
        compare(&mut Oracle::default(), &mut cpu, &case(seed), "the_cpu_equals_the_oracle");
    }
}

#[test]
fn the_gpu_equals_the_oracle() {
    let Some(mut gpu) = gpu() else { return };
    for seed in seeds(0..100) {
        compare(&mut Oracle::default(), &mut gpu, &case(seed), "the_gpu_equals_the_oracle");
    }
}

/// A batch and a bit, each placement in its own slot of the device's buffers.
#[test]
fn more_placements_than_a_batch() {
    let Some(mut gpu) = gpu() else { return };
    for seed in seeds(500..502) {
        let mut random = Random(seed);
        let mut small = case(seed);
        let size = small.cell.blockers.window().size;
        small.placements = (0..70)
            .map(|_| perirobot::backend::Placement {
                origin_q16: size.map(|n| random.below(n << 16) as i32),
                axis_q15: cases::quarter_turns(&mut random),
            })
            .collect();
        gpu.load(&small.cell, &small.rays).unwrap_or_else(|e| panic!("{e}"));
        assert!(gpu.batch() < 70, "a batch of {}", gpu.batch());
        compare(&mut Oracle::default(), &mut gpu, &small, "more_placements_than_a_batch");
    }
}

/// More rays than one dispatch takes.
#[test]
fn a_camera_of_several_dispatches() {
    let Some(mut gpu) = gpu() else { return };
    let mut large = case(1);
    large.rays = Rays { dirs_q15: cases::camera(700, 500, 1.2, 0.8), gates: open_gates() };
    large.placements.truncate(2);
    let mut cpu = Cpu::new(Some(2)).unwrap_or_else(|e| panic!("{e}"));
    compare(&mut cpu, &mut gpu, &large, "a_camera_of_several_dispatches");
}

/// The cases reach what they are meant to reach: otherwise equal results would say little.
#[test]
fn the_cases_are_varied() {
    let mut kinds = [0u32; 4];
    let (mut occupied, mut free, mut windows) = (0, 0, 0);
    for seed in 0..100 {
        let case = case(seed);
        let mut oracle = Oracle::default();
        oracle.load(&case.cell, &case.rays).unwrap_or_else(|e| panic!("{e}"));
        for placement in &case.placements {
            let evidence = oracle.read(placement).unwrap_or_else(|e| panic!("{e}"));
            evidence.ends.iter().for_each(|end| kinds[end.kind as usize] += 1);
            occupied += evidence.occupied.count();
            free += evidence.free.count();
        }
        windows += (case.cell.window != case.cell.blockers.window()) as u32;
    }
    assert!(kinds.iter().all(|&n| n > 1000), "nothing, return, blind, left: {kinds:?}");
    assert!(occupied > 1000 && free > 10_000 && windows > 30, "{occupied} {free} {windows}");
}

#[test]
fn nothing_is_scored_before_it_is_loaded() {
    let Some(mut gpu) = gpu() else { return };
    assert!(matches!(gpu.score(&case(0).placements), Err(perirobot::Error::Device(_))));
}
