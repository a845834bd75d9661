//! What can be reached through faces: a 6-connected flood over bit planes, a word at a time. Serves the
//! interiors of bodies and the ceiling of what any sensor could see.

use super::bits::BitGrid;

/// The voxels of `open` that a path through faces of open voxels joins to a seed; seeds count if they are
/// open. Both planes cover the same window.
pub fn flood(open: &BitGrid, seeds: &BitGrid) -> BitGrid {
    let [_, ny, nz] = open.window().size.map(|n| n as usize);
    let row = open.words_per_row() as usize;
    let mut reached = seeds.clone();
    reached.keep(open);
    let words = reached.words_mut();
    let beside = |r: usize| {
        let (y, z) = (r % ny, r / ny);
        [
            (y > 0).then(|| r.wrapping_sub(1)),
            (y + 1 < ny).then_some(r + 1),
            (z > 0).then(|| r.wrapping_sub(ny)),
            (z + 1 < nz).then_some(r + ny),
        ]
    };
    // A row can only grow if one beside it has grown since it was looked at last.
    let mut due = vec![false; ny * nz];
    for r in 0..ny * nz {
        let own = &mut words[r * row..(r + 1) * row];
        if own.iter().any(|&word| word != 0) {
            spread(own, &open.words()[r * row..(r + 1) * row]);
            beside(r).into_iter().flatten().for_each(|n| due[n] = true);
        }
    }
    let mut forward = true;
    loop {
        let mut changed = false;
        for step in 0..ny * nz {
            let r = if forward { step } else { ny * nz - 1 - step };
            if !std::mem::take(&mut due[r]) {
                continue;
            }
            let neighbours = beside(r);
            let open_row = &open.words()[r * row..(r + 1) * row];
            let mut grew = false;
            for w in 0..row {
                let from = neighbours.iter().flatten().fold(0, |all, n| all | words[n * row + w]);
                let grown = words[r * row + w] | (from & open_row[w]);
                grew |= grown != words[r * row + w];
                words[r * row + w] = grown;
            }
            if grew {
                changed = true;
                spread(&mut words[r * row..(r + 1) * row], open_row);
                neighbours.into_iter().flatten().for_each(|n| due[n] = true);
            }
        }
        if !changed {
            return reached;
        }
        forward = !forward;
    }
}

/// A plane with the voxels that share a face with one of its own, inside its window.
pub fn with_neighbours(plane: &BitGrid) -> BitGrid {
    let [_, ny, nz] = plane.window().size.map(|n| n as usize);
    let row = plane.words_per_row() as usize;
    let mut grown = plane.clone();
    grown.spread_x();
    let words = grown.words_mut();
    for (r, own) in plane.words().chunks_exact(row.max(1)).enumerate() {
        if own.iter().all(|&word| word == 0) {
            continue;
        }
        let (y, z) = (r % ny, r / ny);
        let mut add = |to: usize| {
            words[to * row..(to + 1) * row].iter_mut().zip(own).for_each(|(to, from)| *to |= from);
        };
        if y > 0 {
            add(r - 1);
        }
        if y + 1 < ny {
            add(r + 1);
        }
        if z > 0 {
            add(r - ny);
        }
        if z + 1 < nz {
            add(r + ny);
        }
    }
    grown
}

/// Spreads set bits along a row through open ones.
fn spread(row: &mut [u32], open: &[u32]) {
    let mut carry = 0;
    for (word, &open) in row.iter_mut().zip(open) {
        *word = fill(*word | (carry & open), open, |w, n| w << n);
        carry = *word >> 31;
    }
    let mut carry = 0;
    for (word, &open) in row.iter_mut().zip(open).rev() {
        *word = fill(*word | (carry & open), open, |w, n| w >> n);
        carry = *word << 31;
    }
}

/// Doubling steps: after five, a bit has gone as far as its word is open.
fn fill(mut word: u32, mut open: u32, shift: impl Fn(u32, u32) -> u32) -> u32 {
    for n in [1, 2, 4, 8, 16] {
        word |= open & shift(word, n);
        open &= shift(open, n);
    }
    word
}

/// The voxels without surface that no path through faces reaches from outside the window.
pub fn enclosed_voxels(surface: &BitGrid) -> BitGrid {
    let window = surface.window();
    let mut around = window;
    around.min = around.min.map(|m| m - 1);
    around.size = around.size.map(|n| n + 2);
    let mut open = BitGrid::full(around);
    open.remove(surface);
    let mut seed = BitGrid::new(around);
    seed.set(around.min);
    let outside = flood(&open, &seed);
    open.remove(&outside);
    open.to_window(window)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::voxel::Window;

    /// The surface of a box of voxels.
    fn shell(min: [i32; 3], max: [i32; 3]) -> BitGrid {
        let window = Window::from_corners(min, max);
        let mut grid = BitGrid::new(window);
        for z in min[2]..=max[2] {
            for y in min[1]..=max[1] {
                for x in min[0]..=max[0] {
                    let voxel = [x, y, z];
                    if (0..3).any(|r| voxel[r] == min[r] || voxel[r] == max[r]) {
                        grid.set(voxel);
                    }
                }
            }
        }
        grid
    }

    #[test]
    fn a_closed_shell_keeps_its_inside() {
        let inside = enclosed_voxels(&shell([-2, 3, 0], [70, 12, 5]));
        assert_eq!(inside.count(), 71 * 8 * 4);
        assert!(inside.get([0, 5, 2]) && !inside.get([-2, 5, 2]));
    }

    #[test]
    fn one_missing_face_voxel_lets_everything_out_but_a_corner_does_not() {
        let whole = shell([0, 0, 0], [40, 9, 9]);
        let mut hole = BitGrid::new(whole.window());
        hole.set([0, 5, 5]);
        let mut leaky = whole.clone();
        leaky.remove(&hole);
        assert!(enclosed_voxels(&leaky).is_empty());
        let mut edge = BitGrid::new(whole.window());
        edge.set([0, 0, 5]);
        let mut nicked = whole.clone();
        nicked.remove(&edge);
        assert_eq!(enclosed_voxels(&nicked).count(), 39 * 8 * 8, "an edge voxel joins no faces");
    }

    #[test]
    fn a_flood_follows_a_winding_corridor() {
        let window = Window::from_corners([0; 3], [99, 20, 0]);
        let mut open = BitGrid::new(window);
        for y in (0..20).step_by(2) {
            open.set_run(0, 100, y, 0);
            open.set(if y % 4 == 0 { [99, y + 1, 0] } else { [0, y + 1, 0] });
        }
        let mut seed = BitGrid::new(window);
        seed.set([5, 0, 0]);
        assert_eq!(flood(&open, &seed), open);
        let mut gap = BitGrid::new(window);
        gap.set([50, 10, 0]);
        open.remove(&gap);
        // Row 10 is entered at x = 99 and cut at x = 50.
        assert_eq!(flood(&open, &seed).count(), 5 * 101 + 49);
    }

    /// The voxels beside a voxel.
    fn beside(voxel: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
        (0..6).map(move |way| {
            let mut next = voxel;
            next[way / 2] += if way % 2 == 0 { -1 } else { 1 };
            next
        })
    }

    #[test]
    fn floods_and_neighbours_are_those_of_single_voxels() {
        let mut state = 7u64;
        let mut random = move |n: i32| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) % n as u64) as i32
        };
        for case in 0..40 {
            let min = [-3, 2, 0];
            let size = [70, 9, 9].map(|n| 1 + random(n));
            let window = Window::from_corners(min, std::array::from_fn(|r| min[r] + size[r] - 1));
            let (mut open, mut seeds) = (BitGrid::new(window), BitGrid::new(window));
            // As many open voxels as leave long winding ways.
            for voxel in BitGrid::full(window).voxels().filter(|_| random(100) < [35, 60, 95][case % 3]) {
                open.set(voxel);
            }
            (0..2).for_each(|_| seeds.set(std::array::from_fn(|r| min[r] + random(size[r]))));
            let mut expected = BitGrid::new(window);
            let mut left: Vec<[i32; 3]> = seeds.voxels().filter(|&voxel| open.get(voxel)).collect();
            while let Some(voxel) = left.pop() {
                expected.set(voxel);
                left.extend(beside(voxel).filter(|&next| open.get(next) && !expected.get(next)));
            }
            assert_eq!(flood(&open, &seeds), expected, "case {case}, {size:?}");
            let mut grown = open.clone();
            open.voxels().flat_map(beside).for_each(|voxel| grown.set(voxel));
            assert_eq!(with_neighbours(&open), grown, "case {case}, {size:?}");
        }
    }
}
