//! The oracle against cells small enough to count by hand.

use super::*;
use crate::march::Gates;
use crate::voxel::Window;

/// A ray along +x through the middle of a 10 × 3 × 3 grid, from voxel (0, 1, 1), with a wall at x = 6.
fn corridor() -> (Cell, Rays, Placement) {
    let window = Window::between([0; 3], [9, 2, 2]);
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
    let cell = Cell {
        blockers: wall.clone(),
        window,
        truth: wall,
        human,
        robot: BitGrid::new(window),
        regions: vec![everything],
    };
    let gates = Gates {
        range_min_q16: 0,
        range_max_q16: 100 << 16,
        near_ignore_q16: 0,
        no_return_is_free: false,
        backdrop: false,
    };
    let rays = Rays { dirs_q15: vec![[32_768, 0, 0]], gates };
    let placement = Placement {
        origin_q16: [0x8000, 0x18000, 0x18000],
        axis_q15: [[32_768, 0, 0], [0, 32_768, 0], [0, 0, 32_768]],
    };
    (cell, rays, placement)
}

#[track_caller]
fn check(cell: &Cell, rays: &Rays, placement: &Placement, end: (u32, u32), six: [u64; 6]) -> Confusion {
    let mut oracle = Oracle::default();
    oracle.load(cell, rays).unwrap();
    let evidence = oracle.read(placement).unwrap();
    assert_eq!((evidence.ends[0].kind, evidence.ends[0].crossings), end);
    let counts = oracle.score(&[*placement]).unwrap()[0][0];
    assert_eq!(counts.counts()[..6], six, "tp fp fn tn uo uf");
    counts
}

#[test]
fn a_return_frees_what_it_passed() {
    let (cell, rays, placement) = corridor();
    // Six free cells (x = 0…5), one of nine wall voxels seen, 81 − 6 free ones unknown.
    let counts = check(&cell, &rays, &placement, (RETURN, 6), [1, 0, 0, 6, 8, 75]);
    assert_eq!((counts.human.tp, counts.human.uo), (1, 1));
}

#[test]
fn the_wall_is_entered_at_five_and_a_half_voxels() {
    let (cell, mut rays, placement) = corridor();
    let wall = 5 * 65_536 + 32_768;
    rays.gates.range_max_q16 = wall;
    check(&cell, &rays, &placement, (RETURN, 6), [1, 0, 0, 6, 8, 75]);
    rays.gates.range_max_q16 = wall - 1;
    check(&cell, &rays, &placement, (NOTHING, 5), [0, 0, 0, 0, 9, 81 - 9 + 9]);
    rays.gates.no_return_is_free = true;
    check(&cell, &rays, &placement, (NOTHING, 5), [0, 0, 0, 6, 9, 75]);
}

#[test]
fn too_near_is_blind_and_claims_nothing() {
    let (cell, mut rays, placement) = corridor();
    let wall = 5 * 65_536 + 32_768;
    rays.gates.range_min_q16 = wall;
    check(&cell, &rays, &placement, (RETURN, 6), [1, 0, 0, 6, 8, 75]);
    rays.gates.range_min_q16 = wall + 1;
    rays.gates.no_return_is_free = true;
    check(&cell, &rays, &placement, (BLIND, 6), [0, 0, 0, 0, 9, 81]);
}

#[test]
fn a_housing_is_looked_through() {
    let (cell, mut rays, placement) = corridor();
    rays.gates.near_ignore_q16 = 5 * 65_536 + 32_769;
    rays.gates.no_return_is_free = true;
    // Nothing left to hit: all ten cells of the row are free, the wall's among them (a miss).
    check(&cell, &rays, &placement, (NOTHING, 9), [0, 0, 1, 9, 8, 72]);
}

#[test]
fn a_backdrop_frees_the_way_out() {
    let (mut cell, mut rays, placement) = corridor();
    cell.blockers = BitGrid::new(cell.window);
    check(&cell, &rays, &placement, (NOTHING, 9), [0, 0, 0, 0, 9, 81]);
    rays.gates.backdrop = true;
    check(&cell, &rays, &placement, (LEFT, 9), [0, 0, 1, 9, 8, 72]);
    // The hall begins half a voxel behind x = 9: entered at 9.5.
    rays.gates.range_max_q16 = 9 * 65_536 + 32_767;
    check(&cell, &rays, &placement, (NOTHING, 9), [0, 0, 0, 0, 9, 81]);
}

#[test]
fn the_first_cell_is_never_tested() {
    let (mut cell, rays, placement) = corridor();
    cell.blockers.set([0, 1, 1]);
    check(&cell, &rays, &placement, (RETURN, 6), [1, 0, 0, 6, 8, 75]);
}

#[test]
fn a_diagonal_takes_x_before_y_before_z() {
    let (mut cell, mut rays, mut placement) = corridor();
    placement.origin_q16 = [0x8000; 3];
    let diagonal = 18_919; // 2¹⁵ / √3: all three axes cross together
    rays.dirs_q15 = vec![[diagonal; 3]];
    cell.blockers = BitGrid::new(cell.window);
    cell.blockers.set([1, 1, 0]);
    check(&cell, &rays, &placement, (RETURN, 2), [0, 1, 0, 2, 9, 78]);
}
