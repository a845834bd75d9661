//! The objects in a cell, as their shadows along the axes, for the sketches.

use std::collections::{BTreeMap, BTreeSet};

use crate::render::plan::short_name;
use perirobot_march::voxel::BitGrid;
use perirobot_scene::objects::Role;
use perirobot_scene::truth::Truth;
use perirobot_study::world::place::{is_room, room_m};

/// A shadow of at least this share of the room's width and height is a wall, floor or ceiling seen from the front.
const WHOLE: f64 = 0.8;

/// A rectangle in metres: from and to along the first axis of a view, from and to along the second.
pub(in crate::report::page) type Patch = [f64; 4];

/// Furniture, a fence or a robot.
#[derive(Debug)]
pub(in crate::report::page) struct Thing {
    pub(super) name: String,
    pub(super) is_robot: bool,
    /// Its shadow along each axis, in disjoint rectangles; empty if it is the room's own side.
    pub(super) shadows: [Vec<Patch>; 3],
}

impl Thing {
    /// The ends of its shadow along an axis.
    pub(super) fn extent(&self, axis: usize) -> Option<Patch> {
        let join = |a: Patch, b: Patch| [a[0].min(b[0]), a[1].max(b[1]), a[2].min(b[2]), a[3].max(b[3])];
        self.shadows[axis].iter().copied().reduce(join)
    }
}

/// The objects in a scene, without the room itself and without people.
pub(in crate::report::page) fn things(truth: &Truth) -> Vec<Thing> {
    let room = room_m(truth);
    let stands = truth.objects.iter().filter(|object| object.role != Role::Human && !is_room(object, room));
    let thing = |object: &std::sync::Arc<perirobot_scene::truth::ObjectVoxels>| Thing {
        name: short_name(&object.name).into(),
        is_robot: object.role == Role::Robot,
        shadows: [0, 1, 2].map(|axis| {
            let [low, high] = object.bounds_m;
            let is_whole = (0..3)
                .filter(|other| *other != axis)
                .all(|other| high[other] - low[other] >= WHOLE * (room[1][other] - room[0][other]));
            let patches = if is_whole { Vec::new() } else { shadow(&object.voxels, axis) };
            let others: Vec<usize> = (0..3).filter(|other| *other != axis).collect();
            let metres = |edges: [i32; 4]| {
                let place = |n: usize| {
                    let mut voxel = [0; 3];
                    voxel[others[n / 2]] = edges[n];
                    truth.grid.corner_m(voxel)[others[n / 2]]
                };
                [0, 1, 2, 3].map(place)
            };
            patches.into_iter().map(metres).collect()
        }),
    };
    stands.map(thing).collect()
}

/// The shadow of voxels along an axis, in edges of voxels; equal runs in consecutive rows form one rectangle.
fn shadow(voxels: &BitGrid, axis: usize) -> Vec<[i32; 4]> {
    let [across, up] = [[1, 2], [0, 2], [0, 1]][axis];
    let mut rows: BTreeMap<i32, BTreeSet<i32>> = BTreeMap::new();
    voxels.voxels().for_each(|voxel| {
        rows.entry(voxel[up]).or_default().insert(voxel[across]);
    });
    let mut patches: Vec<[i32; 4]> = Vec::new();
    for (row, cells) in rows {
        let cells: Vec<i32> = cells.into_iter().collect();
        for run in cells.chunk_by(|a, b| a + 1 == *b) {
            let (from, to) = (run[0], run[run.len() - 1] + 1);
            match patches.iter_mut().find(|patch| patch[..2] == [from, to] && patch[3] == row) {
                Some(patch) => patch[3] = row + 1,
                None => patches.push([from, to, row, row + 1]),
            }
        }
    }
    patches
}

#[cfg(test)]
mod tests {
    use super::*;
    use perirobot_march::voxel::Window;

    #[test]
    fn a_shadow_is_what_it_hides_in_few_rectangles() {
        let mut voxels = BitGrid::new(Window { min: [0; 3], size: [8, 8, 8] });
        // An L on the floor, two voxels high, with one separate voxel.
        for (x, y) in [(1, 1), (2, 1), (3, 1), (1, 2), (1, 3), (6, 1)] {
            voxels.set([x, y, 0]);
            voxels.set([x, y, 1]);
        }
        assert_eq!(shadow(&voxels, 2), [[1, 4, 1, 2], [6, 7, 1, 2], [1, 2, 2, 4]]);
        assert_eq!(shadow(&voxels, 1), [[1, 4, 0, 2], [6, 7, 0, 2]]);
        assert_eq!(shadow(&voxels, 0), [[1, 4, 0, 2]]);
    }
}
