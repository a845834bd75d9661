//! Random cells, sensors, placements and jobs, from a seed: walls and clutter, people and robots, odd grid
//! sizes and windows, rays along axes and diagonals, ranges at exact hits, noise small and huge, lost
//! returns, readings with and without volumes.

use std::sync::Arc;

use perirobot_march::backend::oracle::Oracle;
use perirobot_march::backend::{
    Backend, GridFrame, GridPose, Noise, OverTime, Planes, Rays, Reading, Shades, Slot, VoxelScene,
};
use perirobot_march::march::{self, End, FULL_RANGE, Gates, MAX_RANGE_VOXELS, NOISE_STEPS, SHADES};
use perirobot_march::metrics::BodyPart;
use perirobot_march::voxel::{BitGrid, BodyVoxel, People, Window};
use perirobot_study::sensor::Camera;

use super::Random;

/// What two backends are compared on.
pub(crate) struct Case {
    pub(crate) seed: u64,
    pub(crate) scene: VoxelScene,
    pub(crate) tables: Vec<Rays>,
    pub(crate) shots: Vec<Shot>,
    pub(crate) uploads: Vec<(Slot, Planes)>,
    pub(crate) jobs: Vec<Vec<Reading>>,
}

/// What is cast, and where its evidence is kept.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shot {
    pub(crate) table: usize,
    pub(crate) slot: Slot,
    pub(crate) placement: GridPose,
}

/// Slots that cases use: few enough for every backend, and more than hold evidence.
const SLOTS: u32 = 16;

/// The case of a seed.
pub(crate) fn case(seed: u64) -> Case {
    let mut random = Random(seed);
    let size = match random.below(8) {
        0 => [5, 40, 33],
        1 => [70, 50, 40],
        2 => [33, 32, 31],
        3 => [64, 20, 9],
        4 => [31, 7, 66],
        5 => [1, 1, 40],
        _ => std::array::from_fn(|_| 1 + random.below(50)),
    };
    let grid = Window { min: [0; 3], size };
    let scene = scene(&mut random, grid);
    let placements: Vec<_> = (0..4).map(|_| placement(&mut random, &scene)).collect();
    let number = 1 + random.below(3) as usize;
    let tables: Vec<_> = (0..number).map(|_| table(&mut random, &scene, &placements[0])).collect();
    // Slots in no order, none twice.
    let first = random.below(SLOTS);
    let mut slots = (0..SLOTS).map(|i| (first + 5 * i) % SLOTS);
    let mut slot = || slots.next().expect("fewer pieces of evidence than slots");
    let shots = placements.iter().enumerate();
    let shots: Vec<_> =
        shots.map(|(i, &placement)| Shot { table: i % number, slot: slot(), placement }).collect();
    let uploads = (0..1 + random.below(4)).map(|_| (slot(), planes(&mut random, scene.window))).collect();
    // Each shot alone as a presence sensor, wherever its mount is, and any slots together.
    let alone =
        |shot: &Shot| vec![Reading { slot: shot.slot, volume: None, hit: 3511, miss: -405, presence: true }];
    let jobs = shots.iter().map(alone).chain((0..8).map(|_| job(&mut random))).collect();
    Case { seed, scene, tables, shots, uploads, jobs }
}

/// A camera or a LIDAR, with rays along the lattice, gates and noise.
fn table(random: &mut Random, scene: &VoxelScene, placement: &GridPose) -> Rays {
    let mut rays = if random.one_in(2) {
        image(random)
    } else {
        let mut dirs_q15 = if random.one_in(2) { pinhole(random) } else { lidar(random) };
        dirs_q15.extend(lattice());
        Rays { dirs_q15: dirs_q15.into(), image: None, gates: open_gates(), noise: Noise::default() }
    };
    rays.gates = gates(random, scene, &rays, placement);
    rays.noise = noise(random);
    // Steps that no table has would leave 32 bits along slanted rays.
    rays.gates.along_axis &= rays.noise.unit_q12.iter().all(|step| step.abs() <= 5 << 16);
    rays
}

/// A camera that is known to be one: from a single pixel to images whose pixels lie much denser than any
/// voxel.
pub(crate) fn image(random: &mut Random) -> Rays {
    let most = random.of(&[[3, 3], [24, 16], [90, 60], [200, 150]]);
    let camera = match random.below(12) {
        // All of a half-space in one tile, and nearly nothing.
        0 => Camera { fov_rad: [179.9999f64.to_radians(); 2], resolution_px: [8, 8] },
        1 => Camera { fov_rad: [0.001f64.to_radians(); 2], resolution_px: [40, 30] },
        _ => Camera {
            fov_rad: std::array::from_fn(|_| 0.1 + random.share() * 2.6),
            resolution_px: most.map(|n| 1 + random.below(n)),
        },
    };
    Rays {
        dirs_q15: camera.dirs_q15().into(),
        image: Some(camera.image()),
        gates: open_gates(),
        noise: Noise::default(),
    }
}

/// Noise that moves nothing, as much at all distances, or another width at each; small, or across any grid.
/// Some lose returns.
pub(crate) fn noise(random: &mut Random) -> Noise {
    let lost_below = random.of(&[0, 0, 0, 1 << 28, 1 << 31]);
    let most = match random.below(7) {
        0 | 1 => return Noise { lost_below, ..Noise::default() },
        2 => 0,
        3 => 1 << 15,
        4 => 5 << 16,
        5 => 300 << 16,
        _ => {
            let most = random.of(&[1 << 16, 1 << 19, 64 << 16]);
            return Noise {
                // Up to 4.5 widths, more than any table has.
                unit_q12: (0..NOISE_STEPS).map(|_| random.between(-18_432, 18_432)).collect(),
                std_q16: (0..=MAX_RANGE_VOXELS).map(|_| random.below(most + 1)).collect(),
                lost_below,
            };
        }
    };
    steps((0..NOISE_STEPS).map(|_| random.between(-most, most)).collect(), lost_below)
}

/// Noise of these steps in 1/65536 voxels at any distance: a width of 4096 makes the entries of the unit
/// table steps.
pub(crate) fn steps(unit_q12: Vec<i32>, lost_below: u32) -> Noise {
    Noise { unit_q12, std_q16: vec![4096; MAX_RANGE_VOXELS as usize + 1], lost_below }
}

/// Evidence as a host may make it: with voxels in several planes, too, each over a part of the window.
fn planes(random: &mut Random, window: Window) -> Planes {
    let [occupied, free, hits] = [40, 60, 30].map(|percent| {
        let window = match random.below(8) {
            0 => Window::from_corners([0; 3], [-1; 3]),
            1 | 2 => inner(random, window),
            _ => window,
        };
        if window.is_empty() {
            return BitGrid::new(window);
        }
        let mut plane = BitGrid::new(window);
        let part = inner(random, window);
        fill(random, &mut plane, part, percent);
        plane
    });
    Planes { occupied, free, hits }
}

/// One to four readings of any slots, those included that hold nothing.
pub(crate) fn job(random: &mut Random) -> Vec<Reading> {
    let reading = |random: &mut Random| {
        let (hit, miss) = match random.below(8) {
            0 => (random.between(-4000, 4000), random.between(-4000, 4000)),
            // From either clamp back to exactly zero.
            1 | 2 => (2000, -3511),
            _ => random.of(&[(847, -405), (3511, -405), (3511, 0)]),
        };
        let volume = random.one_in(2).then(|| random.below(SLOTS));
        Reading { slot: random.below(SLOTS), volume, hit, miss, presence: random.one_in(3) }
    };
    (0..1 + random.below(4)).map(|_| reading(random)).collect()
}

/// Gates that let every ray through.
pub(crate) fn open_gates() -> Gates {
    Gates {
        range_min_q16: 0,
        range_max_q16: MAX_RANGE_VOXELS << 16,
        shade_ranges_q16: FULL_RANGE,
        along_axis: false,
        near_ignore_q16: 0,
        no_return_is_free: false,
        backdrop: false,
    }
}

/// A window inside `outer`, not empty.
pub(crate) fn inner(random: &mut Random, outer: Window) -> Window {
    let size = outer.size.map(|n| 1 + random.below(n));
    let min = std::array::from_fn(|r| outer.min[r] + random.below(outer.size[r] - size[r] + 1) as i32);
    Window { min, size }
}

/// Sets every voxel of `part` with the given chance in percent.
fn fill(random: &mut Random, plane: &mut BitGrid, part: Window, percent: u32) {
    let end = part.end();
    for z in part.min[2]..end[2] {
        for y in part.min[1]..end[1] {
            for x in part.min[0]..end[0] {
                if percent == 100 || random.below(100) < percent {
                    plane.set([x, y, z]);
                }
            }
        }
    }
}

fn scene(random: &mut Random, grid: Window) -> VoxelScene {
    let mut truth = BitGrid::new(grid);
    let clutter = random.of(&[0, 0, 1, 1, 5, 10, 30, 50]);
    fill(random, &mut truth, grid, clutter);
    if random.one_in(12) {
        // A checkerboard: every ray is beside a blocker, and slips between them.
        let part = inner(random, grid);
        let black = |c: &[i32; 3]| c.iter().sum::<i32>() % 2 == 0;
        BitGrid::full(part).voxels().filter(black).for_each(|c| truth.set(c));
    }
    // Walls one voxel thick across the grid, some of them at its sides.
    for _ in 0..random.below(4) {
        let axis = random.below(3) as usize;
        let mut wall = grid;
        wall.min[axis] = random.of(&[0, grid.size[axis] as i32 - 1, grid.size[axis] as i32 / 2]);
        wall.size[axis] = 1;
        let percent = random.of(&[100, 100, 90]);
        fill(random, &mut truth, wall, percent);
    }
    let mut person = |random: &mut Random| {
        let mut plane = BitGrid::new(grid);
        let body = inner(random, grid);
        fill(random, &mut plane, body, 30);
        // Half of it is interior: a person's voxel, but not occupied.
        let mut surface = BitGrid::new(grid);
        fill(random, &mut surface, body, 50);
        surface.keep(&plane);
        truth.add(&surface);
        plane
    };
    let (human, robot) = (person(random), person(random));
    // See-through objects are true, but stop nothing.
    let mut blockers = truth.clone();
    if random.one_in(2) {
        let mut fence = BitGrid::new(grid);
        let part = inner(random, grid);
        fill(random, &mut fence, part, 50);
        blockers.remove(&fence);
    }
    let window = if random.one_in(3) { grid } else { inner(random, grid) };
    let mut regions = Vec::new();
    for _ in 0..random.below(4) {
        let mut region = BitGrid::new(window);
        let part = inner(random, window);
        let percent = random.of(&[0, 20, 100]);
        fill(random, &mut region, part, percent);
        regions.push(region);
    }
    let [truth, human, robot] = [truth, human, robot].map(|plane| plane.to_window(window));
    let people = people(random, &truth, &human);
    let over_time = random.one_in(3).then(|| {
        let mut always = blockers.clone();
        let moves = inner(random, grid);
        always.remove(&BitGrid::full(moves));
        Arc::new(OverTime { always: always.into(), ever: blockers.clone().into() })
    });
    let shades = random.one_in(2).then(|| {
        let mut plane = || {
            let mut plane = BitGrid::new(grid);
            let part = if random.one_in(2) { grid } else { inner(random, grid) };
            let percent = random.of(&[30, 100]);
            fill(random, &mut plane, part, percent);
            plane
        };
        Arc::new(Shades { bits: [plane(), plane(), plane()] })
    });
    VoxelScene { blockers: blockers.into(), shades, over_time, window, truth, human, robot, regions, people }
}

/// Whose the truly occupied voxels of people are: of up to three people, who have parts of all kinds in any
/// voxel.
fn people(random: &mut Random, truth: &BitGrid, human: &BitGrid) -> People {
    let mut theirs = human.clone();
    theirs.keep(truth);
    let (people, parts) = (1 + random.below(3), 1 + random.below(11));
    let mut of = |voxel| BodyVoxel {
        voxel,
        person: random.below(people),
        part: BodyPart::ALL[random.below(parts) as usize],
    };
    let voxels = theirs.voxels().map(&mut of).collect();
    People { min_hits: 1 + random.below(6), voxels }
}

/// A direction in Q15, of length one.
fn unit_q15(v: [f64; 3]) -> [i32; 3] {
    let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    v.map(|x| (x / norm * 32_768.0).round() as i32)
}

/// A small camera: z forward, rows of pixels.
pub(crate) fn camera(columns: u32, rows: u32, half_width: f64, half_height: f64) -> Vec<[i32; 3]> {
    let pixel = |i: u32, n: u32, half: f64| half * (2.0 * (i as f64 + 0.5) / n as f64 - 1.0);
    let row =
        |v| (0..columns).map(move |u| [pixel(u, columns, half_width), pixel(v, rows, half_height), 1.0]);
    (0..rows).flat_map(row).map(unit_q15).collect()
}

fn pinhole(random: &mut Random) -> Vec<[i32; 3]> {
    let (columns, rows) = (1 + random.below(24), 1 + random.below(16));
    camera(columns, rows, 0.3 + random.share(), 0.2 + random.share())
}

fn lidar(random: &mut Random) -> Vec<[i32; 3]> {
    let (columns, rows) = (1 + random.below(60), 1 + random.below(8));
    let turn = std::f64::consts::TAU;
    let column = |i: u32| (0..rows).map(move |k| (i as f64 / columns as f64 * turn, k as f64 * 0.1 - 0.3));
    let ray = |(a, e): (f64, f64)| unit_q15([a.cos() * e.cos(), a.sin() * e.cos(), e.sin()]);
    (0..columns).flat_map(column).map(ray).collect()
}

/// The 26 directions to a voxel's neighbours: axes and exact diagonals, where distances tie.
pub(crate) fn lattice() -> Vec<[i32; 3]> {
    let steps = [-1.0, 0.0, 1.0];
    let all = steps.iter().flat_map(|&x| steps.iter().flat_map(move |&y| steps.map(|z| [x, y, z])));
    all.filter(|&v| v != [0.0; 3]).map(unit_q15).collect()
}

fn placement(random: &mut Random, scene: &VoxelScene) -> GridPose {
    let size = scene.blockers.window().size;
    let anywhere = |random: &mut Random| size.map(|n| random.below(n << 16) as i32);
    let origin_q16 = match random.below(6) {
        // Inside what it will see, if there is anything.
        0 => {
            let occupied: Vec<_> = scene.blockers.voxels().collect();
            match occupied.as_slice() {
                [] => anywhere(random),
                voxels => random.of(voxels).map(|c| (c << 16) + random.below(1 << 16) as i32),
            }
        }
        1 => size.map(|n| (random.below(n) << 16) as i32),
        2 => size.map(|n| (random.below(n) << 16) as i32 + 0x8000),
        3 => {
            let mut origin = anywhere(random);
            let axis = random.below(3) as usize;
            origin[axis] = random.of(&[0, 1, (size[axis] as i32 / 2) << 16, (size[axis] << 16) as i32 - 1]);
            origin
        }
        _ => anywhere(random),
    };
    let axis_q15 = if random.one_in(3) { quarter_turns(random) } else { turned(random) };
    let truly = random.one_in(4).then(|| standpoint(random, scene, origin_q16, axis_q15));
    GridPose { origin_q16, axis_q15, truly, draws: random.bits() as u32 }
}

/// Where a sensor truly is that is believed to be somewhere: there, near by, or anywhere.
pub(crate) fn standpoint(
    random: &mut Random,
    scene: &VoxelScene,
    origin_q16: [i32; 3],
    axis_q15: [[i32; 3]; 3],
) -> GridFrame {
    let size = scene.blockers.window().size;
    match random.below(6) {
        0 => GridFrame { origin_q16, axis_q15 },
        1 => GridFrame { origin_q16: size.map(|n| random.below(n << 16) as i32), axis_q15: turned(random) },
        _ => {
            let most = random.of(&[1, 1 << 12, 1 << 16, 4 << 16]);
            let near =
                |r: usize| (origin_q16[r] + random.between(-most, most)).clamp(0, (size[r] << 16) as i32 - 1);
            let origin_q16 = std::array::from_fn(near);
            // Turned by up to three degrees about one of its own axes.
            let (a, by) = (random.below(3) as usize, random.between(-1700, 1700));
            let (b, c) = ((a + 1) % 3, (a + 2) % 3);
            let (sin, cos) = (f64::from(by) / 32_768.0).sin_cos();
            let mut rows = axis_q15;
            for (row, old) in rows.iter_mut().zip(axis_q15) {
                row[b] = (f64::from(old[b]) * cos - f64::from(old[c]) * sin).round() as i32;
                row[c] = (f64::from(old[b]) * sin + f64::from(old[c]) * cos).round() as i32;
            }
            GridFrame { origin_q16, axis_q15: rows }
        }
    }
}

/// Axes onto axes: rays along the lattice stay there.
pub(crate) fn quarter_turns(random: &mut Random) -> [[i32; 3]; 3] {
    let order = random.of(&[[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]]);
    order.map(|axis| {
        let mut row = [0; 3];
        row[axis] = random.of(&[-32_768, 32_768]);
        row
    })
}

/// Any rotation, from a random quaternion.
pub(crate) fn turned(random: &mut Random) -> [[i32; 3]; 3] {
    let q: [f64; 4] = std::array::from_fn(|_| random.share() - 0.5);
    let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-9);
    let [w, x, y, z] = q.map(|c| c / norm);
    let rows = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ];
    rows.map(|row| row.map(|c| (c * 32_768.0).round() as i32))
}

/// When a ray enters its last cell, in Q16.
fn end_distance(placement: &GridPose, dir_q15: [i32; 3], end: End) -> u32 {
    let mut ray = placement.launch(dir_q15);
    let mut t = 0;
    for _ in 0..end.crossings {
        let axis = march::next_axis(ray.next_q16);
        t = ray.next_q16[axis];
        march::cross(&mut ray, axis);
    }
    t
}

/// Random gates; most of their distances are those of an end, or one off.
fn gates(random: &mut Random, scene: &VoxelScene, rays: &Rays, placement: &GridPose) -> Gates {
    let mut oracle = Oracle::default();
    oracle.tables(std::slice::from_ref(rays)).expect("the oracle takes any table");
    oracle.load(scene).expect("the oracle takes any cell");
    let ends = oracle.read(0, placement).expect("a cell is loaded").ends;
    let near_an_end = |random: &mut Random| {
        let ray = random.below(ends.len() as u32) as usize;
        let t = end_distance(placement, rays.dirs_q15[ray], ends[ray]) as i64 + random.between(-1, 1) as i64;
        t.clamp(0, (MAX_RANGE_VOXELS as i64) << 16) as u32
    };
    Gates {
        range_min_q16: if random.one_in(2) { near_an_end(random) } else { random.below(3 << 16) },
        range_max_q16: match random.below(4) {
            0 => MAX_RANGE_VOXELS << 16,
            1 => random.below(60 << 16),
            _ => near_an_end(random),
        },
        shade_ranges_q16: match random.one_in(2) {
            true => FULL_RANGE,
            false => [0; SHADES].map(|_| match random.one_in(4) {
                true => random.below(60 << 16),
                false => near_an_end(random),
            }),
        },
        along_axis: random.one_in(3),
        near_ignore_q16: match random.below(4) {
            0 => near_an_end(random),
            1 => random.below(4 << 16),
            _ => 0,
        },
        no_return_is_free: random.one_in(2),
        backdrop: random.one_in(2),
    }
}
