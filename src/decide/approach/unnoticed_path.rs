//! A path on which a body comes too near unnoticed, and that few sensors would notice: who wants to close it has few to
//! choose from.
//!
//! # Theory
//! Dijkstra's shortest paths (1959), the length of a step being how many sensors watch how many voxels of the body where
//! it ends. That is not how many would notice it, but goes with it, and needs no more than running sums.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::body::Sums;
use super::deepest::{least, squared_distance};
use super::moments::ApproachMoment;
use perirobot_march::voxel::{BitGrid, Window};

/// How many sensors a voxel of a body counts for at least, in sixteenths.
const SIXTEENTHS: u64 = 16;

/// How many sensors watch each voxel.
pub(crate) struct WatchCounts {
    sums: Sums,
}

impl WatchCounts {
    /// From the number of sensors of each voxel of a window, x first.
    pub(crate) fn new(window: Window, counts: &[u16]) -> WatchCounts {
        let [width, depth, _] = window.size.map(|n| n as usize);
        let at = |voxel: [i32; 3]| {
            let [x, y, z]: [usize; 3] = std::array::from_fn(|r| (voxel[r] - window.min[r]) as usize);
            counts[x + width * (y + depth * z)].into()
        };
        WatchCounts { sums: Sums::from_counts(window, at) }
    }
}

impl ApproachMoment<'_> {
    /// The voxels that any body may fill.
    pub(crate) fn body_window(&self) -> Window {
        let each = self.ground.bodies.iter().zip(&self.ground.places);
        let filled = each.map(|(body, places)| {
            let end = places.end();
            Window::from_corners(places.min, std::array::from_fn(|r| end[r] + body.size[r] as i32 - 2))
        });
        filled.reduce(|all, one| all.union(&one)).unwrap_or(Window::from_corners([0; 3], [-1; 3]))
    }

    /// The places of a path on which a body comes from an entry to a place that is too near by its squared distance,
    /// which comes with it, and nothing notices it where these voxels are watched; `None` if there is none. The watched voxels have the window of
    /// [`ApproachMoment::body_window`].
    pub(crate) fn unnoticed_path(
        &self,
        [number, entry]: [usize; 2],
        watched: &BitGrid,
        counts: &WatchCounts,
        is_too_near: &dyn Fn(u32) -> bool,
    ) -> Option<(Vec<[i32; 3]>, u32)> {
        let (body, begin) = (&self.ground.bodies[number], &self.ground.begins[number][entry]);
        let open = self.open_to(number, &Sums::new(watched));
        let window = open.window();
        let [width, depth, height] = window.size.map(|n| n as usize);
        let index = |place: [i32; 3]| {
            let [x, y, z]: [usize; 3] = std::array::from_fn(|r| (place[r] - window.min[r]) as usize);
            x + width * (y + depth * z)
        };
        let place_at = |at: usize| {
            let own = [at % width, at / width % depth, at / (width * depth)];
            std::array::from_fn::<i32, 3, _>(|r| window.min[r] + own[r] as i32)
        };
        let voxels = body.count();
        let length = |place| SIXTEENTHS * u64::from(body.sum(&counts.sums, place)) / voxels + 1;
        let ends_at = |place| {
            let may_end = u32::try_from(least(body, place, &self.distances)).is_ok_and(is_too_near);
            let squared = may_end.then(|| squared_distance(body, place, &self.distances)).flatten();
            squared.filter(|&squared| is_too_near(squared))
        };
        let mut lengths = vec![u64::MAX; width * depth * height];
        let mut before = vec![u32::MAX; lengths.len()];
        let mut queue = BinaryHeap::new();
        for place in begin.voxels().filter(|&place| open.get(place)) {
            lengths[index(place)] = length(place);
            queue.push(Reverse((length(place), index(place))));
        }
        while let Some(Reverse((so_far, at))) = queue.pop() {
            if lengths[at] != so_far {
                continue;
            }
            let place = place_at(at);
            if let Some(squared) = ends_at(place) {
                let steps = std::iter::successors(Some(at), |&at| {
                    (before[at] != u32::MAX).then_some(before[at] as usize)
                });
                let mut path: Vec<[i32; 3]> = steps.map(place_at).collect();
                path.reverse();
                return Some((path, squared));
            }
            for next in neighbours(place).filter(|&next| window.contains(next) && open.get(next)) {
                let (to, far) = (index(next), so_far + length(next));
                if far < lengths[to] {
                    (lengths[to], before[to]) = (far, at as u32);
                    queue.push(Reverse((far, to)));
                }
            }
        }
        None
    }
}

/// The 26 places around one.
fn neighbours([x, y, z]: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
    let all = (-1..=1).flat_map(move |k| (-1..=1).flat_map(move |j| (-1..=1).map(move |i| [i, j, k])));
    all.filter(|by| *by != [0; 3]).map(move |[i, j, k]| [x + i, y + j, z + k])
}
