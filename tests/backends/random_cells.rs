//! The oracle, the CPU and the GPU give the same integers: every count, plane and end, on random cells.
//! `PERIROBOT_CASE=<seed>` runs one case.

use crate::common::cases::{Case, case, job, open_gates};
use crate::common::thorough::cases;
use crate::common::{self, Random, cases};
use perirobot_march::backend::adapter::AdapterChoice;
use perirobot_march::backend::cpu::{Cpu, SimdLevel};
use perirobot_march::backend::gpu::Gpu;
use perirobot_march::backend::oracle::Oracle;
use perirobot_march::backend::{
    Backend, Carving, Evidence, Fusion, GridFrame, GridPose, LOG_ODDS, Noise, Planes, Rays, Reading, Shot,
    VoxelScene,
};
use perirobot_march::march::{FULL_RANGE, Gates, NOTHING, RETURN};
use perirobot_march::metrics::{BodyPart, Confusion};
use perirobot_march::voxel::{BitGrid, BodyVoxel, People, Window};

/// Runs a case on both and compares all that comes back.
#[track_caller]
fn compare(expected: &mut impl Backend, found: &mut impl Backend, case: &Case, test: &str) {
    let names = format!("{} (left) against {} (right)", found.name(), expected.name());
    let rerun =
        format!("rerun: PERIROBOT_CASE={} cargo test --test backends random_cells::{test}", case.seed);
    let (window, size) = (case.scene.window, case.scene.blockers.window().size);
    let mut both: [&mut dyn Backend; 2] = [found, expected];
    for backend in &mut both {
        unwrap(backend.tables(&case.tables), &rerun);
        unwrap(backend.load(&case.scene), &rerun);
    }
    // Evidence first: a wrong ray says more than the counts that follow from it.
    for (number, cases::Shot { table, placement, .. }) in case.shots.iter().enumerate() {
        let [left, right] = both.each_mut().map(|backend| unwrap(backend.read(*table, placement), &rerun));
        let rays = &case.tables[*table];
        if let Some(difference) = difference(&left, &right, rays) {
            let of = format!("{names}, case {}, shot {number} {placement:?}", case.seed);
            panic!("{of}\n{window:?} of {size:?}, {:?}\n{difference}\n{rerun}", rays.gates);
        }
    }
    for backend in &mut both {
        unwrap(keep(*backend, case), &rerun);
    }
    for fusion in [Fusion::OccupiedWins, Fusion::Octomap] {
        let [left, right] = both.each_mut().map(|backend| unwrap(backend.score(fusion, &case.jobs), &rerun));
        assert_eq!((left.len(), right.len()), (case.jobs.len(), case.jobs.len()), "{names}\n{rerun}");
        for (job, (left, right)) in case.jobs.iter().zip(left.iter().zip(&right)) {
            let place = format!("{names}, case {}, {fusion:?} of {job:?}\n{rerun}", case.seed);
            assert_eq!(left.len(), case.scene.regions.len(), "{place}");
            for (region, (left, right)) in left.iter().zip(right).enumerate() {
                assert_eq!(left.counts(), right.counts(), "region {region}, {place}");
                assert_eq!(left.detection, right.detection, "region {region}, {place}");
                assert_eq!(left.overlap, right.overlap, "region {region}, {place}");
            }
        }
    }
}

/// Casts and uploads a case's evidence into its slots, over other evidence.
pub(super) fn keep(backend: &mut dyn Backend, case: &Case) -> perirobot_march::Result<()> {
    let slots = case.shots.iter().map(|shot| shot.slot).chain(case.uploads.iter().map(|(slot, _)| *slot));
    let placements = case.shots.iter().rev().map(|shot| shot.placement).cycle();
    let wrong: Vec<_> = slots.zip(placements).map(|(slot, placement)| Shot::once(slot, placement)).collect();
    backend.sense(0, &wrong)?;
    if let Some((_, planes)) = case.uploads.first() {
        backend.upload(vec![(case.shots[0].slot, planes.clone())])?;
    }
    backend.upload(case.uploads.clone())?;
    for table in 0..case.tables.len() {
        // Twice, where first hits in the still layer are kept: once to find them, once to find them again.
        let all = case.shots.iter().zip(0..).filter(|(shot, _)| shot.table == table);
        let kept = |number: u32| Some(number).filter(|&number| (number as usize) < backend.first_hit_slots());
        let shot = |(shot, number): (&cases::Shot, u32)| Shot {
            first_hits: kept(number),
            ..Shot::once(shot.slot, shot.placement)
        };
        let shots: Vec<_> = all.map(shot).collect();
        backend.sense(table, &shots)?;
        if shots.iter().any(|shot| shot.first_hits.is_some()) {
            backend.sense(table, &shots)?;
        }
    }
    Ok(())
}

#[track_caller]
fn unwrap<T>(result: perirobot_march::Result<T>, rerun: &str) -> T {
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
    let mut planes = left.planes.planes_with_names().into_iter().zip(right.planes.planes_with_names());
    planes.find_map(|((name, left), (_, right))| plane_difference(name, left, right))
}

fn plane_difference(name: &str, left: &BitGrid, right: &BitGrid) -> Option<String> {
    if left == right {
        return None;
    }
    let differs = |&voxel: &[i32; 3]| left.get(voxel) != right.get(voxel);
    Some(match left.voxels().chain(right.voxels()).filter(differs).min_by_key(|&[x, y, z]| [z, y, x]) {
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

pub(super) fn gpu() -> Option<Gpu> {
    let choice: AdapterChoice = common::adapter()?;
    Some(Gpu::new(&choice).unwrap_or_else(|e| panic!("{e}")))
}

/// The CPU with each set of vector instructions that it has, in each way to carve.
fn cpus(threads: usize) -> Vec<(SimdLevel, Cpu)> {
    let cpu = |simd| Cpu::new(Some(threads)).unwrap_or_else(|e| panic!("{e}")).simd(simd);
    let each = |simd| {
        let [by_voxel, by_ray] = [Carving::ByVoxel, Carving::ByRay].map(|carving| cpu(simd).carving(carving));
        [cpu(simd), by_voxel, by_ray].map(|cpu| (simd, cpu))
    };
    SimdLevel::all().into_iter().flat_map(each).collect()
}

#[test]
fn the_cpu_equals_the_oracle() {
    let mut cpus = cpus(2);
    for seed in seeds(0..cases(200, 600)) {
        let case = case(seed);
        for (simd, cpu) in &mut cpus {
            println!("{}", simd.name());
            compare(&mut Oracle::default(), cpu, &case, "the_cpu_equals_the_oracle");
        }
    }
}

#[test]
fn the_gpu_equals_the_oracle() {
    let Some(mut gpu) = gpu() else { return };
    for seed in seeds(0..100) {
        compare(&mut Oracle::default(), &mut gpu, &case(seed), "the_gpu_equals_the_oracle");
    }
}

/// Cases without end: `PERIROBOT_SOAK_S=3600 cargo test --release --test backends soak -- --ignored`.
#[test]
#[ignore = "runs as long as PERIROBOT_SOAK_S says"]
fn soak() {
    let seconds =
        std::env::var("PERIROBOT_SOAK_S").map_or(60, |s| s.parse().expect("PERIROBOT_SOAK_S: seconds"));
    let first = std::env::var("PERIROBOT_SOAK_FROM").map_or(1_000_000, |s| s.parse().expect("a number"));
    let (begin, mut seed) = (std::time::Instant::now(), first);
    let mut cpus = cpus(1);
    let mut gpu = gpu();
    while begin.elapsed().as_secs() < seconds {
        cpus.iter_mut()
            .for_each(|(_, cpu)| compare(&mut Oracle::default(), cpu, &case(seed), "the_cpu_equals"));
        if let Some(gpu) = gpu.as_mut().filter(|_| seed % 4 == 0) {
            compare(&mut Oracle::default(), gpu, &case(seed), "the_gpu_equals");
        }
        seed += 1;
    }
    common::say(&format!("soak: cases {first} to {seed}, {} s", begin.elapsed().as_secs()));
}

/// A batch and a bit, of placements and of jobs, each in its own part of the device's buffers.
#[test]
fn more_than_a_batch() {
    let Some(mut gpu) = gpu() else { return };
    for seed in seeds(500..502) {
        let mut random = Random(seed);
        let mut small = case(seed);
        let size = small.scene.blockers.window().size;
        let shot = |slot| {
            let mut stand = || {
                let origin_q16 = size.map(|n| random.below(n << 16) as i32);
                GridFrame { origin_q16, axis_q15: cases::quarter_turns(&mut random) }
            };
            let GridFrame { origin_q16, axis_q15 } = stand();
            // Every other one hits where no ray is believed to go.
            let truly = (slot % 2 == 1).then(stand);
            let placement = GridPose { origin_q16, axis_q15, truly, draws: slot };
            cases::Shot { table: 0, slot, placement }
        };
        small.shots = (0..70).map(shot).collect();
        small.uploads.clear();
        let any = |random: &mut Random, reading: Reading| Reading { slot: random.below(80), ..reading };
        let far = |random: &mut Random| job(random).into_iter().map(|reading| any(random, reading)).collect();
        small.jobs = (0..300).map(|_| far(&mut random)).collect();
        compare(&mut Oracle::default(), &mut gpu, &small, "more_than_a_batch");
    }
}

/// Evidence from the host, over windows that begin and end anywhere, over earlier evidence, and more than once: where layers
/// are long, the device gets pieces of them.
#[test]
fn evidence_from_the_host_arrives_whole() {
    let Some(mut gpu) = gpu() else { return };
    let grid = Window { min: [0; 3], size: [300, 400, 5] };
    let mut random = Random(7);
    let mut scattered = |window: Window, one_in: u32| {
        let mut plane = BitGrid::new(window);
        BitGrid::full(window).voxels().filter(|_| random.one_in(one_in)).for_each(|voxel| plane.set(voxel));
        plane
    };
    let window = Window { min: [3, 5, 1], size: [290, 390, 4] };
    let blank = BitGrid::new(grid);
    let scene = VoxelScene {
        shades: None,
        blockers: blank.clone().into(),
        over_time: None,
        window,
        truth: blank.to_window(window),
        human: blank.to_window(window),
        robot: blank.to_window(window),
        regions: vec![BitGrid::full(window)],
        people: People::default(),
    };
    let all = scattered(window, 3);
    let person = scattered(Window { min: [100, 200, 2], size: [40, 30, 2] }, 2);
    let beyond = scattered(Window { min: [-20, -3, 0], size: [60, 100, 3] }, 2);
    let nearly_all = scattered(Window { min: [0, 6, 2], size: [300, 380, 3] }, 4);
    let nowhere = BitGrid::new(Window::from_corners([0; 3], [-1; 3]));
    let said = |occupied: &BitGrid, free: &BitGrid, hits: &BitGrid| Planes {
        occupied: occupied.clone(),
        free: free.clone(),
        hits: hits.clone(),
    };
    let batches = [
        vec![
            (4, said(&all, &all, &all)),
            (0, said(&all, &nowhere, &person)),
            (1, said(&nowhere, &all, &nowhere)),
        ],
        vec![
            (1, said(&person, &beyond, &nearly_all)),
            (4, said(&beyond, &nowhere, &blank)),
            (2, said(&person, &person, &all)),
        ],
    ];
    let mut oracle = Oracle::default();
    let kept = [&mut oracle as &mut dyn Backend, &mut gpu].map(|backend| {
        backend.load(&scene).unwrap();
        batches.iter().for_each(|batch| backend.upload(batch.clone()).unwrap());
        backend.planes(&[0, 1, 2, 4]).unwrap()
    });
    for (number, (expected, found)) in kept[0].iter().zip(&kept[1]).enumerate() {
        for ((name, expected), (_, found)) in
            expected.planes_with_names().into_iter().zip(found.planes_with_names())
        {
            assert_eq!(plane_difference(name, found, &expected.to_window(window)), None, "number {number}");
        }
    }
}

/// A camera in a corner is believed to look out of the grid; truly it looks at a person, of whom all evidence
/// is kept.
#[test]
fn people_are_hit_where_no_ray_is_believed_to_come_near() {
    let (grid, window) = ([30; 3], Window::from_corners([20; 3], [24; 3]));
    let person = BitGrid::full(window);
    let voxels = person.voxels().map(|voxel| BodyVoxel { voxel, person: 0, part: BodyPart::Body }).collect();
    let scene = VoxelScene {
        shades: None,
        blockers: person.to_window(Window { min: [0; 3], size: grid }).into(),
        over_time: None,
        window,
        truth: person.clone(),
        human: person.clone(),
        robot: BitGrid::new(window),
        regions: vec![person],
        people: People { min_hits: 3, voxels },
    };
    let looks = |x: i32| [[0, 0, x], [x, 0, 0], [0, -32_768, 0]];
    let at = |place: [i32; 3]| place.map(|voxel| (voxel << 16) + 0x8000);
    let truly = GridFrame { origin_q16: at([10, 22, 22]), axis_q15: looks(32_768) };
    let placement =
        GridPose { origin_q16: at([1; 3]), axis_q15: looks(-32_768), truly: Some(truly), draws: 0 };
    let dirs_q15 = cases::camera(24, 16, 0.2, 0.2);
    let rays = Rays { dirs_q15: dirs_q15.into(), image: None, gates: open_gates(), noise: Noise::default() };
    let reading = Reading { slot: 0, volume: None, hit: 847, miss: -405, presence: true };
    let case = Case {
        seed: 0,
        scene,
        tables: vec![rays],
        shots: vec![cases::Shot { table: 0, slot: 0, placement }],
        uploads: Vec::new(),
        jobs: vec![vec![reading]],
    };
    let mut cpu = Cpu::new(Some(1)).unwrap_or_else(|e| panic!("{e}"));
    compare(&mut Oracle::default(), &mut cpu, &case, "people_are_hit");
    let counts = unwrap(cpu.score(Fusion::OccupiedWins, &case.jobs), "");
    assert_eq!(counts[0][0].detection.counts(), [25, 1, 1, 1, 1], "the near side of a cube");
    let Some(mut gpu) = gpu() else { return };
    compare(&mut Oracle::default(), &mut gpu, &case, "people_are_hit");
}

/// More rays than one dispatch takes.
#[test]
fn a_camera_of_several_dispatches() {
    let Some(mut gpu) = gpu() else { return };
    let mut large = case(1);
    let dirs_q15 = cases::camera(700, 500, 1.2, 0.8);
    let noise = cases::steps((0..4096).map(|step| (step - 2048) << 7).collect(), 1 << 29);
    large.tables = vec![Rays { dirs_q15: dirs_q15.into(), image: None, gates: open_gates(), noise }];
    large.shots.truncate(2);
    large.shots.iter_mut().for_each(|shot| shot.table = 0);
    let mut cpu = Cpu::new(Some(2)).unwrap_or_else(|e| panic!("{e}"));
    compare(&mut cpu, &mut gpu, &large, "a_camera_of_several_dispatches");
}

/// The cases reach what they are meant to reach: otherwise equal results would say little.
#[test]
fn the_cases_are_varied() {
    let mut kinds = [0u32; 4];
    let (mut occupied, mut free, mut hits, mut windows) = (0, 0, [0; 2], 0);
    let (mut reads, mut losses, mut sums) = ([0u32; 3], 0, [0u64; 3]);
    let (mut off, mut off_and_felt, mut weak) = (0, 0, 0);
    for seed in 0..100 {
        let case = case(seed);
        let mut oracle = Oracle::default();
        let quiet = |rays: &Rays| Rays { noise: Noise::default(), ..rays.clone() };
        let bright = |rays: &Rays| Rays {
            gates: Gates { shade_ranges_q16: FULL_RANGE, ..rays.gates },
            ..rays.clone()
        };
        let tables = case.tables.iter().cloned().chain(case.tables.iter().map(quiet));
        let tables = tables.chain(case.tables.iter().map(bright));
        oracle.tables(&tables.collect::<Vec<_>>()).unwrap_or_else(|e| panic!("{e}"));
        oracle.load(&case.scene).unwrap_or_else(|e| panic!("{e}"));
        let mut kept = vec![None; 16];
        for cases::Shot { table, slot, placement } in &case.shots {
            let mut read = |table| oracle.read(table, placement).unwrap_or_else(|e| panic!("{e}"));
            let ends = read(*table).ends.into_iter().zip(read(*table + 2 * case.tables.len()).ends);
            weak += ends.filter(|(end, bright)| bright.kind == RETURN && end.kind == NOTHING).count();
            off += placement.truly.is_some() as u32;
            let (evidence, quiet) = (read(*table), read(*table + case.tables.len()));
            evidence.ends.iter().for_each(|end| kinds[end.kind as usize] += 1);
            occupied += evidence.planes.occupied.count();
            free += evidence.planes.free.count();
            let mut only_hit = evidence.planes.hits.clone();
            only_hit.remove(&evidence.planes.occupied);
            hits[0] += evidence.planes.hits.count();
            hits[1] += only_hit.count();
            let returns = evidence.ends.iter().zip(&quiet.ends).filter(|(_, quiet)| quiet.kind == RETURN);
            let (lost, read): (Vec<_>, Vec<_>) = returns.partition(|(end, _)| end.kind == NOTHING);
            losses += lost.len();
            if !case.tables[*table].noise.unit_q12.is_empty() {
                let order = read.into_iter().map(|(end, quiet)| end.crossings.cmp(&quiet.crossings));
                order.for_each(|order| reads[(order as i8 + 1) as usize] += 1);
            }
            kept[*slot as usize] = Some(evidence.planes);
        }
        case.uploads.iter().for_each(|(slot, planes)| kept[*slot as usize] = Some(planes.clone()));
        case.jobs.iter().for_each(|job| clamps(&case, &kept, job, &mut sums));
        let feels = |shot: &&cases::Shot| {
            let hits = kept[shot.slot as usize].as_ref().map(|planes| &planes.hits);
            shot.placement.truly.is_some() && hits.is_some_and(|hits| hits.intersects(&case.scene.human))
        };
        off_and_felt += case.shots.iter().filter(feels).count();
        windows += (case.scene.window != case.scene.blockers.window()) as u32;
    }
    assert!(kinds.iter().all(|&n| n > 1000), "nothing, return, blind, left: {kinds:?}");
    assert!(occupied > 1000 && free > 10_000 && windows > 30, "{occupied} {free} {windows}");
    assert!(hits[0] > 1000 && hits[1] > 200, "hit, and hit but read elsewhere: {hits:?}");
    assert!(reads.iter().all(|&n| n > 1000), "read before, at, behind the blocker: {reads:?}");
    assert!(
        off > 50 && off_and_felt > 5,
        "mounts that are off: {off}, those from which people are hit: {off_and_felt}"
    );
    assert!(losses > 1000, "lost returns: {losses}");
    assert!(weak > 400, "returns of what is too dark: {weak}");
    assert!(sums.iter().all(|&n| n > 100), "log-odds clamped below, within, clamped above: {sums:?}");
}

/// Counts the voxels of regions whose sum is clamped below, never, or above.
fn clamps(case: &Case, kept: &[Option<Planes>], job: &[Reading], sums: &mut [u64; 3]) {
    for voxel in case.scene.regions.iter().flat_map(BitGrid::voxels) {
        let mut sum = 0;
        for reading in job {
            let slots = [Some(reading.slot), reading.volume].into_iter().flatten();
            let said: Vec<_> = slots.filter_map(|slot| kept[slot as usize].as_ref()).collect();
            let said = |plane: fn(&Planes) -> &BitGrid| said.iter().any(|planes| plane(planes).get(voxel));
            let (occupied, free) = (said(|planes| &planes.occupied), said(|planes| &planes.free));
            let raw = sum + if occupied { reading.hit } else { free as i32 * reading.miss };
            sum = raw.clamp(*LOG_ODDS.start(), *LOG_ODDS.end());
            sums[((raw - sum).signum() + 1) as usize] += 1;
        }
    }
}

/// The first case with a large region that its first table sees something of.
fn with_a_region() -> Case {
    let seen = |case: &Case| {
        let mut oracle = Oracle::default();
        unwrap(oracle.tables(&case.tables), "");
        unwrap(oracle.load(&case.scene), "");
        let mut known = case.shots.iter().map(|shot| unwrap(oracle.read(0, &shot.placement), "").planes.free);
        known.any(|free| {
            case.scene.regions.iter().any(|region| region.intersects(&free) && region.count() > 1000)
        })
    };
    (0..).map(case).find(seen).expect("some case has a region")
}

/// What was cast for one scene says nothing of the next.
#[test]
fn nothing_is_left_of_another_scene() {
    let Some(mut gpu) = gpu() else { return };
    let case = with_a_region();
    let shots: Vec<_> = case.shots.iter().map(|shot| Shot::once(shot.slot, shot.placement)).collect();
    let reading = |&Shot { slot, .. }: &Shot| Reading {
        slot,
        volume: Some(slot),
        hit: 847,
        miss: -405,
        presence: false,
    };
    let job: Vec<_> = shots.iter().map(reading).collect();
    // Voxels that are known, and all of them, over the regions.
    let known_to = |gpu: &mut Gpu, job: &Vec<Reading>| {
        let counts = unwrap(gpu.score(Fusion::Octomap, std::slice::from_ref(job)), "");
        let sum = |of: fn(&Confusion) -> u64| counts[0].iter().map(of).sum::<u64>();
        (sum(|c| c.total() - c.uo - c.uf), sum(Confusion::total))
    };
    let known = |gpu: &mut Gpu| known_to(gpu, &job);
    unwrap(gpu.tables(&case.tables), "");
    unwrap(gpu.load(&case.scene), "");
    assert_eq!(known(&mut gpu).0, 0);
    unwrap(gpu.sense(0, &shots), "");
    let (some, all) = known(&mut gpu);
    assert!(some > 0 && some < all, "{some} of {all}");
    assert_eq!(known_to(&mut gpu, &vec![]), (0, all), "no readings say nothing");
    unwrap(gpu.load(&case.scene), "");
    assert_eq!(known(&mut gpu), (0, all));
}

#[test]
fn what_is_not_there_is_an_error() {
    let Some(mut gpu) = gpu() else { return };
    let case = with_a_region();
    let placement = case.shots[0].placement;
    let fails = |result: perirobot_march::Result<()>, expected: &str| match result {
        Err(perirobot_march::Error::Device(message)) => {
            assert!(message.to_string().contains(expected), "{message}")
        }
        other => panic!("{expected}: {other:?}"),
    };
    fails(gpu.score(Fusion::Octomap, &case.jobs).map(drop), "no scene is loaded");
    fails(gpu.sense(0, &[Shot::once(0, placement)]), "no table 0 of rays is loaded");
    unwrap(gpu.tables(&case.tables), "");
    fails(gpu.sense(0, &[Shot::once(0, placement)]), "no scene is loaded");
    unwrap(gpu.load(&case.scene), "");
    fails(gpu.sense(3, &[Shot::once(0, placement)]), "no table 3 of rays is loaded");
    let slots = gpu.slots() as u32;
    fails(gpu.sense(0, &[Shot::once(slots, placement)]), &format!("no slot {slots}"));
    let far = Reading { slot: 0, volume: Some(slots), hit: 1, miss: -1, presence: false };
    fails(gpu.score(Fusion::Octomap, &[vec![far]]).map(drop), &format!("no slot {slots}"));
}
