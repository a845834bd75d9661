//! The oracle against cells small enough to count by hand.

use std::sync::Arc;

use super::*;
use crate::backend::{GridFrame, Noise};
use crate::march::{FULL_RANGE, Gates};
use crate::voxel::{People, Window};

/// A ray along +x through the middle of a 10 × 3 × 3 grid, from voxel (0, 1, 1), with a wall at x = 6.
fn corridor() -> (VoxelScene, Rays, GridPose) {
    let window = Window::from_corners([0; 3], [9, 2, 2]);
    let mut wall = BitGrid::new(window);
    for y in 0..3 {
        for z in 0..3 {
            wall.set([6, y, z]);
        }
    }
    let mut everything = BitGrid::new(window);
    for y in 0..3 {
        for z in 0..3 {
            everything.set_run(0, 10, y, z);
        }
    }
    let mut human = BitGrid::new(window);
    human.set([6, 1, 1]);
    human.set([6, 2, 1]);
    let scene = VoxelScene {
        shades: None,
        blockers: wall.clone().into(),
        over_time: None,
        window,
        truth: wall,
        human,
        robot: BitGrid::new(window),
        regions: vec![everything],
        people: People::default(),
    };
    let gates = Gates {
        range_min_q16: 0,
        range_max_q16: 100 << 16,
        shade_ranges_q16: FULL_RANGE,
        along_axis: false,
        near_ignore_q16: 0,
        no_return_is_free: false,
        backdrop: false,
    };
    let rays = Rays { dirs_q15: vec![[32_768, 0, 0]].into(), image: None, gates, noise: Noise::default() };
    let placement = GridPose {
        origin_q16: [0x8000, 0x18000, 0x18000],
        axis_q15: [[32_768, 0, 0], [0, 32_768, 0], [0, 0, 32_768]],
        truly: None,
        draws: 0,
    };
    (scene, rays, placement)
}

#[track_caller]
fn check(scene: &VoxelScene, rays: &Rays, placement: &GridPose, end: (u32, u32), six: [u64; 6]) -> Confusion {
    let mut oracle = Oracle::default();
    oracle.tables(std::slice::from_ref(rays)).unwrap();
    oracle.load(scene).unwrap();
    let evidence = oracle.read(0, placement).unwrap();
    assert_eq!((evidence.ends[0].kind, evidence.ends[0].crossings), end);
    oracle.sense(0, &[Shot::once(3, *placement)]).unwrap();
    let alone = vec![Reading { slot: 3, volume: None, hit: 1, miss: -1, presence: false }];
    let counts = oracle.score(Fusion::OccupiedWins, &[alone]).unwrap()[0][0];
    assert_eq!(counts.counts()[..6], six, "tp fp fn tn uo uf");
    counts
}

#[test]
fn a_return_frees_what_it_passed() {
    let (voxel, rays, placement) = corridor();
    // Six free voxels (x = 0…5), one of nine wall voxels seen, 81 − 6 free ones unknown.
    let counts = check(&voxel, &rays, &placement, (RETURN, 6), [1, 0, 0, 6, 8, 75]);
    assert_eq!((counts.human.tp, counts.human.uo), (1, 1));
}

#[test]
fn the_wall_is_entered_at_five_and_a_half_voxels() {
    let (voxel, mut rays, placement) = corridor();
    let wall = 5 * 65_536 + 32_768;
    rays.gates.range_max_q16 = wall;
    check(&voxel, &rays, &placement, (RETURN, 6), [1, 0, 0, 6, 8, 75]);
    rays.gates.range_max_q16 = wall - 1;
    check(&voxel, &rays, &placement, (NOTHING, 5), [0, 0, 0, 0, 9, 81 - 9 + 9]);
    rays.gates.no_return_is_free = true;
    check(&voxel, &rays, &placement, (NOTHING, 5), [0, 0, 0, 6, 9, 75]);
}

#[test]
fn too_near_is_blind_and_claims_nothing() {
    let (voxel, mut rays, placement) = corridor();
    let wall = 5 * 65_536 + 32_768;
    rays.gates.range_min_q16 = wall;
    check(&voxel, &rays, &placement, (RETURN, 6), [1, 0, 0, 6, 8, 75]);
    rays.gates.range_min_q16 = wall + 1;
    rays.gates.no_return_is_free = true;
    check(&voxel, &rays, &placement, (BLIND, 6), [0, 0, 0, 0, 9, 81]);
}

#[test]
fn a_housing_is_looked_through() {
    let (voxel, mut rays, placement) = corridor();
    rays.gates.near_ignore_q16 = 5 * 65_536 + 32_769;
    rays.gates.no_return_is_free = true;
    // Nothing left to hit: all ten voxels of the row are free, the wall's among them (a miss).
    check(&voxel, &rays, &placement, (NOTHING, 9), [0, 0, 1, 9, 8, 72]);
}

#[test]
fn a_backdrop_frees_the_way_out() {
    let (mut scene, mut rays, placement) = corridor();
    scene.blockers = BitGrid::new(scene.window).into();
    check(&scene, &rays, &placement, (NOTHING, 9), [0, 0, 0, 0, 9, 81]);
    rays.gates.backdrop = true;
    check(&scene, &rays, &placement, (LEFT, 9), [0, 0, 1, 9, 8, 72]);
    // The hall begins half a voxel behind x = 9: entered at 9.5.
    rays.gates.range_max_q16 = 9 * 65_536 + 32_767;
    check(&scene, &rays, &placement, (NOTHING, 9), [0, 0, 0, 0, 9, 81]);
}

#[test]
fn the_first_cell_is_never_tested() {
    let (mut scene, rays, placement) = corridor();
    Arc::make_mut(&mut scene.blockers).set([0, 1, 1]);
    check(&scene, &rays, &placement, (RETURN, 6), [1, 0, 0, 6, 8, 75]);
}

#[test]
fn a_diagonal_takes_x_before_y_before_z() {
    let (mut scene, mut rays, mut placement) = corridor();
    placement.origin_q16 = [0x8000; 3];
    let diagonal = 18_919; // 2¹⁵ / √3: all three axes cross together
    rays.dirs_q15 = vec![[diagonal; 3]].into();
    scene.blockers = BitGrid::new(scene.window).into();
    Arc::make_mut(&mut scene.blockers).set([1, 1, 0]);
    check(&scene, &rays, &placement, (RETURN, 2), [0, 1, 0, 2, 9, 78]);
}

/// Noise of these steps at any distance: a width of 4096 makes the entries of the unit table steps of 1/65536
/// voxel.
fn steps(unit_q12: Vec<i32>) -> Noise {
    Noise { unit_q12, std_q16: vec![4096; 10], lost_below: 0 }
}

/// The corridor (9 voxels of wall, 81 free) with one and the same noise, whatever is drawn.
#[track_caller]
fn check_noisy(noise_q16: i32, end: (u32, u32), six: [u64; 6]) {
    let (voxel, mut rays, placement) = corridor();
    rays.noise = steps(vec![noise_q16; 4096]);
    check(&voxel, &rays, &placement, end, six);
}

#[test]
fn a_noisy_return_is_read_before_or_behind_the_wall() {
    // The wall is entered at 5.5 voxels, x = n + 1 at n + 0.5. Two voxels before it, x = 4 is just entered.
    check_noisy(-2 * 65_536, (RETURN, 4), [0, 1, 0, 4, 9, 76]);
    check_noisy(-2 * 65_536 - 1, (RETURN, 3), [0, 1, 0, 3, 9, 77]);
    // Half a voxel is too little to leave the wall's voxel, a whole one is not: then the wall itself is
    // called free.
    check_noisy(32_768, (RETURN, 6), [1, 0, 0, 6, 8, 75]);
    check_noisy(65_535, (RETURN, 6), [1, 0, 0, 6, 8, 75]);
    check_noisy(65_536, (RETURN, 7), [0, 1, 1, 6, 8, 74]);
    check_noisy(0, (RETURN, 6), [1, 0, 0, 6, 8, 75]);
}

#[test]
fn noise_ends_at_the_sensor_and_at_the_grid() {
    check_noisy(-100 * 65_536, (RETURN, 0), [0, 1, 0, 0, 9, 80]);
    check_noisy(-5 * 65_536 - 32_768, (RETURN, 0), [0, 1, 0, 0, 9, 80]);
    // x = 9 is entered at 8.5, and left for good at 9.5.
    check_noisy(4 * 65_536 - 1, (RETURN, 9), [0, 1, 1, 8, 8, 72]);
    check_noisy(4 * 65_536, (RETURN, 9), [0, 1, 1, 8, 8, 72]);
    check_noisy(300 * 65_536, (RETURN, 9), [0, 1, 1, 8, 8, 72]);
}

#[test]
fn gates_judge_where_the_wall_is_not_where_it_is_read() {
    let (scene, mut rays, placement) = corridor();
    let wall = 5 * 65_536 + 32_768;
    (rays.gates.range_min_q16, rays.gates.range_max_q16) = (wall, wall);
    for (noise, end) in [(-3 * 65_536, 3), (2 * 65_536, 8)] {
        rays.noise = steps(vec![noise; 4096]);
        let mut oracle = Oracle::default();
        oracle.tables(std::slice::from_ref(&rays)).unwrap();
        oracle.load(&scene).unwrap();
        assert_eq!(oracle.read(0, &placement).unwrap().ends, [End { kind: RETURN, crossings: end }]);
    }
    rays.gates.range_min_q16 = wall + 1;
    check(&scene, &rays, &placement, (BLIND, 6), [0, 0, 0, 0, 9, 81]);
}

#[test]
fn a_ray_draws_its_own_step() {
    let (scene, mut rays, mut placement) = corridor();
    // The hash of 0 is 129 708 002: step 123. That of 1 is 2 831 084 092: step 2699.
    rays.noise = steps(vec![0; 4096]);
    (rays.noise.unit_q12[123], rays.noise.unit_q12[2699]) = (65_536, 2 * 65_536);
    rays.dirs_q15 = vec![[32_768, 0, 0]; 3].into();
    let mut oracle = Oracle::default();
    oracle.tables(&[rays]).unwrap();
    oracle.load(&scene).unwrap();
    let mut ends = |draws| {
        placement.draws = draws;
        oracle.read(0, &placement).unwrap().ends.iter().map(|end| end.crossings).collect::<Vec<_>>()
    };
    assert_eq!(ends(0), [7, 8, 6]);
    assert_eq!(ends(1), [8, 7, 6], "draws and ray are joined by xor");
}

#[test]
fn the_step_grows_with_the_distance_of_the_return() {
    // The wall is at 5.5 voxels, so that entry 5 decides. -1.5 · 4096 times 1.33334 voxels is 2.00001 voxels
    // less.
    let (scene, mut rays, placement) = corridor();
    let mut check_entry = |at: usize, end| {
        let mut std_q16 = vec![0; 10];
        std_q16[at] = 87_382;
        rays.noise = Noise { unit_q12: vec![-6144; 4096], std_q16, lost_below: 0 };
        let mut oracle = Oracle::default();
        oracle.tables(std::slice::from_ref(&rays)).unwrap();
        oracle.load(&scene).unwrap();
        assert_eq!(oracle.read(0, &placement).unwrap().ends, [End { kind: RETURN, crossings: end }], "{at}");
    };
    (0..10).filter(|&at| at != 5).for_each(|at| check_entry(at, 6));
    check_entry(5, 3);
}

/// The hash of 0 is 129 708 002, and of that again 817 759 070.
#[test]
fn a_lost_return_says_nothing_or_frees_what_its_ray_passes() {
    let (scene, mut rays, placement) = corridor();
    rays.noise.lost_below = 817_759_070;
    check(&scene, &rays, &placement, (RETURN, 6), [1, 0, 0, 6, 8, 75]);
    rays.noise.lost_below += 1;
    // Along all ten voxels, the wall among them: it is the third that is called free.
    check(&scene, &rays, &placement, (NOTHING, 9), [0, 0, 0, 0, 9, 81]);
    rays.gates.no_return_is_free = true;
    check(&scene, &rays, &placement, (NOTHING, 9), [0, 0, 1, 9, 8, 72]);
    // No farther than its range, and not if it is blind.
    rays.gates.range_max_q16 = 7 << 16;
    check(&scene, &rays, &placement, (NOTHING, 7), [0, 0, 1, 7, 8, 74]);
    rays.gates.range_min_q16 = 6 << 16;
    check(&scene, &rays, &placement, (BLIND, 6), [0, 0, 0, 0, 9, 81]);
    // What leaves towards a backdrop is a return, too.
    let (mut scene, mut rays, placement) = corridor();
    scene.blockers = BitGrid::new(scene.window).into();
    (rays.gates.backdrop, rays.noise.lost_below) = (true, 817_759_070);
    check(&scene, &rays, &placement, (LEFT, 9), [0, 0, 1, 9, 8, 72]);
    rays.noise.lost_below += 1;
    check(&scene, &rays, &placement, (NOTHING, 9), [0, 0, 0, 0, 9, 81]);
}

/// Believed to stand two voxels nearer to the wall, at x = 2.5, and to look a row higher: what the ray meets
/// after 5.5 voxels is taken for something at x = 8.
#[test]
fn evidence_is_written_where_the_mount_is_believed_to_be() {
    let (scene, mut rays, mut placement) = corridor();
    let GridPose { origin_q16, axis_q15, .. } = placement;
    placement.truly = Some(GridFrame { origin_q16, axis_q15 });
    // Where both are the same, so is what is said.
    check(&scene, &rays, &placement, (RETURN, 6), [1, 0, 0, 6, 8, 75]);
    placement.origin_q16 = [0x28000, 0x28000, 0x18000];
    check(&scene, &rays, &placement, (RETURN, 6), [0, 1, 1, 5, 8, 75]);
    let read = |rays: &Rays, placement: &GridPose| {
        let mut oracle = Oracle::default();
        oracle.tables(std::slice::from_ref(rays)).unwrap();
        oracle.load(&scene).unwrap();
        let Evidence { planes: Planes { occupied, hits, .. }, ends } = oracle.read(0, placement).unwrap();
        (occupied.voxels().collect::<Vec<_>>(), hits.voxels().collect::<Vec<_>>(), ends[0])
    };
    let (occupied, hits, _) = read(&rays, &placement);
    assert_eq!((occupied, hits), (vec![[8, 2, 1]], vec![[6, 1, 1]]), "what is hit is what is there");
    // Noise takes it to where the believed ray leaves the grid; ranges are those of the true ray.
    rays.noise = steps(vec![3 * 65_536; 4096]);
    let end = |kind, crossings| End { kind, crossings };
    assert_eq!(read(&rays, &placement), (vec![[9, 2, 1]], vec![[6, 1, 1]], end(RETURN, 7)));
    rays.noise = Noise::default();
    rays.gates.range_min_q16 = 6 << 16;
    assert_eq!(read(&rays, &placement), (vec![], vec![], end(BLIND, 6)));
    (rays.gates.range_min_q16, rays.gates.range_max_q16) = (0, 5 << 16);
    assert_eq!(read(&rays, &placement).2, end(NOTHING, 5));
}

/// A tie that the blocker ends at once for a true ray: the believed one makes all crossings at that distance.
#[test]
fn a_believed_ray_takes_all_axes_that_are_crossed_at_a_distance() {
    let (mut scene, mut rays, mut placement) = corridor();
    placement.origin_q16 = [3 << 16, 1 << 16, 0x8000];
    rays.dirs_q15 = vec![[-23_170, -23_170, 0]].into();
    scene.blockers = BitGrid::new(scene.window).into();
    Arc::make_mut(&mut scene.blockers).set([2, 1, 0]);
    check(&scene, &rays, &placement, (RETURN, 1), [0, 1, 0, 1, 9, 79]);
    let GridPose { origin_q16, axis_q15, .. } = placement;
    placement.truly = Some(GridFrame { origin_q16, axis_q15 });
    check(&scene, &rays, &placement, (RETURN, 2), [0, 1, 0, 2, 9, 78]);
}

#[test]
fn a_hit_at_the_sensor_takes_all_axes_that_are_crossed_there() {
    let (mut scene, mut rays, mut placement) = corridor();
    // On the edge between four voxels, backwards: x and y are crossed at distance 0, x first, and there is
    // the hit.
    placement.origin_q16 = [3 << 16, 1 << 16, 0x8000];
    rays.dirs_q15 = vec![[-23_170, -23_170, 0]].into();
    scene.blockers = BitGrid::new(scene.window).into();
    Arc::make_mut(&mut scene.blockers).set([2, 1, 0]);
    check(&scene, &rays, &placement, (RETURN, 1), [0, 1, 0, 1, 9, 79]);
    rays.noise = steps(vec![-1; 4096]);
    check(&scene, &rays, &placement, (RETURN, 2), [0, 1, 0, 2, 9, 78]);
}

/// What a job says of each voxel of a row: `o`, `f` or `?`. Evidence is written the same way, `b` for both, a
/// row a slot.
#[track_caller]
fn check_fused(evidence: &[&str], job: &[Reading], occupied_wins: &str, octomap: &str) {
    let window = Window::from_corners([0; 3], [occupied_wins.len() as i32 - 1, 0, 0]);
    let (mut scene, ..) = corridor();
    let blank = BitGrid::new(window);
    scene.window = window;
    (scene.truth, scene.human, scene.robot) = (blank.clone(), blank.clone(), blank.clone());
    let mut oracle = Oracle::default();
    oracle.load(&scene).unwrap();
    for (row, slot) in evidence.iter().zip(0..) {
        let mut planes = Planes::blank(window);
        for (said, x) in row.chars().zip(0..) {
            "ob".contains(said).then(|| planes.occupied.set([x, 0, 0]));
            "fb".contains(said).then(|| planes.free.set([x, 0, 0]));
        }
        oracle.upload(vec![(slot, planes)]).unwrap();
    }
    for (fusion, expected) in [(Fusion::OccupiedWins, occupied_wins), (Fusion::Octomap, octomap)] {
        let said: String = (0..expected.len())
            .map(|x| ["o", "f", "?"][oracle.label([x as i32, 0, 0], fusion, job)])
            .collect();
        assert_eq!(said, expected, "{fusion:?}");
    }
}

/// A range sensor, a pad, the known robot.
fn range(slot: Slot) -> Reading {
    Reading { slot, volume: None, hit: 847, miss: -405, presence: false }
}
fn pad(slot: Slot) -> Reading {
    Reading { slot, volume: None, hit: 3511, miss: -405, presence: false }
}
fn robot(slot: Slot) -> Reading {
    Reading { slot, volume: None, hit: 3511, miss: 0, presence: false }
}

#[test]
fn two_misses_do_not_outweigh_a_hit_but_three_do() {
    // 2 · 847 − 405; 847 − 2 · 405 = 37; 847 − 3 · 405 = −368; −405; nothing at all.
    let rows = ["ooo??", "off??", "fff??", "??ff?"];
    check_fused(&rows, &[range(0), range(1), range(2), range(3)], "ooof?", "ooff?");
}

#[test]
fn a_silent_pad_does_not_erase_what_a_camera_saw() {
    // 847 − 405; −2 · 405; −405 + 3511; −405.
    check_fused(&["off?", "ffof"], &[range(0), pad(1)], "ofof", "ofof");
    // A sum of zero is no label.
    let even = Reading { slot: 0, volume: None, hit: 405, miss: -405, presence: false };
    check_fused(&["o", "f"], &[even, range(1)], "o", "?");
}

#[test]
fn sums_are_clamped_after_each_so_that_order_matters() {
    let (hits, misses) = ([range(0); 5], [range(1); 9]);
    // 5 · 847 = 4235, clamped to 3511; less 9 · 405 = 3645 is −134.
    check_fused(&["o", "f"], &[&hits[..], &misses].concat(), "o", "f");
    // −3645, clamped to −2000; with 4235 it is 2235.
    check_fused(&["o", "f"], &[&misses[..], &hits].concat(), "o", "o");
    // One less of either stays within the clamp below, or just reaches it: −1620 and −2000 against 847 and 2
    // · 847.
    check_fused(&["o", "f"], &[&[range(1); 4][..], &[range(0); 2]].concat(), "o", "o");
    check_fused(&["o", "f"], &[&[range(1); 5][..], &[range(0); 2]].concat(), "o", "f");
}

#[test]
fn the_known_robot_speaks_last() {
    // Freed down to −2000, then 1511; spoken first, 3511 − 10 · 405 = −539. Where it is not, it says nothing.
    let cameras = [range(0); 10];
    check_fused(&["ff?", "o??"], &[&cameras[..], &[robot(1)]].concat(), "of?", "of?");
    check_fused(&["ff?", "o??"], &[&[robot(1)][..], &cameras].concat(), "of?", "ff?");
}

#[test]
fn a_sensor_and_its_volume_speak_once() {
    // Points say free, the volume occupied: one hit, not a hit and a miss; and two that agree are one, too:
    // after them three misses (−1215) outweigh 847, not 2 · 847.
    let both = Reading { volume: Some(1), ..range(0) };
    let misses = [range(2); 3];
    check_fused(&["foffb", "oof??", "?????"], &[both], "ooffo", "ooffo");
    check_fused(&["fo", "oo", "ff"], &[&[both][..], &misses].concat(), "oo", "ff");
    // A slot that was never filled adds nothing.
    check_fused(&["fo"], &[Reading { volume: Some(200), ..range(0) }], "fo", "fo");
}
