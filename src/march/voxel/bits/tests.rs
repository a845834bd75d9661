//! Planes against sets of voxels and single bits, at the ends of words and rows.

use super::*;

/// A plane with a third of its voxels set in no simple pattern.
fn speckle(window: Window) -> BitGrid {
    let mut grid = BitGrid::new(window);
    let end = window.end();
    for z in window.min[2]..end[2] {
        for y in window.min[1]..end[1] {
            for x in window.min[0]..end[0] {
                if (x * 7 + y * 11 + z * 13 + x * y).rem_euclid(3) == 0 {
                    grid.set([x, y, z]);
                }
            }
        }
    }
    grid
}

#[test]
fn voxels_come_x_first_then_y_then_z() {
    for (min, size) in [([-40, -2, 3], [100, 3, 4]), ([5, 0, -1], [32, 2, 2]), ([-1, -1, -1], [1, 1, 1])] {
        let plane = speckle(Window { min, size });
        let end = plane.window().end();
        let mut expected = Vec::new();
        for z in min[2]..end[2] {
            for y in min[1]..end[1] {
                expected.extend((min[0]..end[0]).map(|x| [x, y, z]).filter(|&voxel| plane.get(voxel)));
            }
        }
        assert_eq!(plane.voxels().collect::<Vec<_>>(), expected, "{min:?} {size:?}");
        assert_eq!(expected.len() as u64, plane.count());
    }
    assert_eq!(BitGrid::nowhere().voxels().next(), None);
    assert_eq!(BitGrid::new(Window { min: [0; 3], size: [70, 2, 2] }).voxels().next(), None);
}

#[test]
fn planes_over_other_windows_keep_their_voxels() {
    let source = speckle(Window::from_corners([-3, -2, 1], [70, 4, 3]));
    for window in [
        Window::from_corners([-40, -2, 1], [90, 4, 3]),
        Window::from_corners([30, 0, 0], [36, 9, 2]),
        Window::from_corners([-3, -2, 1], [28, 4, 3]),
    ] {
        let moved = source.to_window(window);
        let expected: Vec<_> = source.voxels().filter(|&c| window.contains(c)).collect();
        assert_eq!(moved.voxels().collect::<Vec<_>>(), expected, "{window:?}");
        assert_eq!(moved.count(), expected.len() as u64, "padding stays zero");
    }
}

#[test]
fn add_remove_keep() {
    let a = speckle(Window::from_corners([0, 0, 0], [50, 5, 5]));
    let b = speckle(Window::from_corners([1, 1, 0], [40, 9, 3]));
    let mut joined = a.clone();
    joined.add(&b);
    let mut removed = a.clone();
    removed.remove(&b);
    let mut kept = a.clone();
    kept.keep(&b);
    assert!(joined.voxels().all(|c| a.get(c) || b.get(c)));
    assert!(removed.voxels().all(|c| a.get(c) && !b.get(c)));
    assert!(kept.voxels().all(|c| a.get(c) && b.get(c)));
    assert_eq!(removed.count() + kept.count(), a.count());
    assert!(removed.count() > 0 && kept.count() > 0);
}

#[test]
fn runs_and_bounds() {
    let mut grid = BitGrid::new(Window::from_corners([0, 0, 0], [99, 3, 3]));
    grid.set_run(-5, 35, 2, 1);
    assert_eq!(grid.count(), 35);
    assert_eq!(grid.bounds(), Window::from_corners([0, 2, 1], [34, 2, 1]));
    grid.set_run(0, 10, 9, 9);
    assert_eq!(grid.count(), 35, "outside the window nothing is set");
    for (from, to) in [(31, 33), (32, 64), (64, 64), (70, 69), (95, 120), (-1_000_000, 1_000_000)] {
        let mut grid = BitGrid::new(Window::from_corners([0, 2, 1], [99, 2, 1]));
        grid.set_run(from, to, 2, 1);
        let expected: Vec<_> = (0..100).filter(|x| (from..to).contains(x)).map(|x| [x, 2, 1]).collect();
        assert_eq!(grid.voxels().collect::<Vec<_>>(), expected, "{from} to {to}");
    }
    assert!(BitGrid::new(grid.window()).bounds().is_empty());
}

#[test]
fn spreading_sets_neighbours_across_words_and_no_padding() {
    let mut grid = BitGrid::new(Window::from_corners([-3, 0, 0], [66, 1, 0]));
    for x in [-3, 28, 29, 40, 66] {
        grid.set([x, 1, 0]);
    }
    grid.spread_x();
    let expected = [-3, -2, 27, 28, 29, 30, 39, 40, 41, 65, 66].map(|x| [x, 1, 0]);
    assert_eq!(grid.voxels().collect::<Vec<_>>(), expected);
    let row = grid.row(1, 0).to_vec();
    grid.add_row(0, 0, &row);
    grid.add_row(2, 0, &row);
    assert_eq!(grid.count(), 22, "row 2 is outside");
}
