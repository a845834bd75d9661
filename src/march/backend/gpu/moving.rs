//! Where the blockers are that are not in the still layer: in two boxes, outside of which no ray meets them.
//!
//! # Theory
//! Rays from all around enter a box about as often as its surface is large. So the box of all is cut in two where the
//! boxes of both parts together have the least surface; that of two things that move apart is mostly between them.

use crate::voxel::{BitGrid, Window};

/// Voxels by which rays are cast as if a box were larger, on both sides together (`comes_near` in `shaders/cast.wgsl`).
const GROWN: u64 = 3;

/// Two boxes that together hold all of some voxels; twice the same where one is as good, or there are none.
pub(super) fn boxes_of(moving: &BitGrid) -> [Window; 2] {
    let all = moving.bounds();
    let mut slabs = [0, 1, 2].map(|axis| vec![Window { min: [0; 3], size: [0; 3] }; all.size[axis] as usize]);
    for voxel in moving.voxels() {
        for (axis, slabs) in slabs.iter_mut().enumerate() {
            let slab = &mut slabs[(voxel[axis] - all.min[axis]) as usize];
            *slab = slab.union(&Window { min: voxel, size: [1; 3] });
        }
    }
    let union = |slabs: &[Window]| {
        slabs.iter().fold(Window { min: [0; 3], size: [0; 3] }, |all, slab| all.union(slab))
    };
    let cuts = slabs
        .iter()
        .flat_map(|slabs| (1..slabs.len()).map(move |at| [&slabs[..at], &slabs[at..]].map(union)));
    let best = cuts.min_by_key(|boxes| boxes.iter().map(surface).sum::<u64>());
    best.filter(|boxes| boxes.iter().map(surface).sum::<u64>() < surface(&all)).unwrap_or([all; 2])
}

/// Half the surface of a box as rays are cast at it.
fn surface(window: &Window) -> u64 {
    let [x, y, z] = window.size.map(|n| u64::from(n) + GROWN);
    x * y + y * z + z * x
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(parts: &[Window]) -> BitGrid {
        let mut plane = BitGrid::new(Window { min: [0; 3], size: [70, 40, 30] });
        parts
            .iter()
            .flat_map(|part| BitGrid::full(*part).voxels().collect::<Vec<_>>())
            .for_each(|voxel| plane.set(voxel));
        plane
    }

    #[test]
    fn two_things_that_move_apart_have_a_box_each() {
        let [a, b] =
            [([3, 2, 1], [4, 5, 6]), ([60, 2, 20], [5, 4, 3])].map(|(min, size)| Window { min, size });
        assert_eq!(boxes_of(&filled(&[a, b])), [a, b]);
        assert_eq!(boxes_of(&filled(&[a])), [a; 2]);
        assert!(boxes_of(&filled(&[])).iter().all(Window::is_empty));
        // Three: those that are close together share one.
        let near = Window { min: [3, 10, 1], ..a };
        assert_eq!(boxes_of(&filled(&[a, near, b])), [a.union(&near), b]);
    }

    #[test]
    fn all_that_moves_is_in_one_of_the_boxes() {
        for step in 1..60 {
            let mut plane = filled(&[]);
            BitGrid::full(plane.window()).voxels().step_by(1009 * step).for_each(|voxel| plane.set(voxel));
            let boxes = boxes_of(&plane);
            assert!(plane.voxels().all(|voxel| boxes.iter().any(|window| window.contains(voxel))), "{step}");
            assert!(boxes.iter().map(surface).sum::<u64>() <= 2 * surface(&plane.bounds()), "{step}");
        }
    }
}
