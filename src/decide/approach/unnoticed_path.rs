//! A path on which a body comes too close unnoticed, with few sensors that would notice it: a passing set has one of
//! these, so fewer are better.
//!
//! # Theory
//! Dijkstra's shortest paths (1959). The length of a step is the number of sensors that watch a voxel of the body at its
//! end, averaged over the voxels. That is correlated with the number of sensors that notice the body, and needs only
//! running sums.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::body::Sums;
use super::deepest::{least, squared_distance};
use super::flood::steps;
use super::moments::ApproachMoment;
use perirobot_march::voxel::{BitGrid, Window};

/// Lengths of steps are whole multiples of this fraction of a sensor.
const PARTS: u64 = 16;

/// How many sensors watch each voxel.
pub(crate) struct WatchCounts {
    sums: Sums,
}

impl WatchCounts {
    /// From the voxels of a window that each sensor watches.
    pub(crate) fn from_watched(window: Window, each: impl Iterator<Item = BitGrid>) -> WatchCounts {
        let mut counts = vec![0u16; window.volume() as usize];
        let index = |voxel| index_in(window, voxel);
        each.for_each(|watched| {
            watched.voxels().for_each(|voxel| counts[index(voxel)] = counts[index(voxel)].saturating_add(1));
        });
        WatchCounts { sums: Sums::from_counts(window, |voxel| counts[index(voxel)].into()) }
    }
}

/// The number of a voxel of a window, x first.
fn index_in(window: Window, voxel: [i32; 3]) -> usize {
    let [x, y, z]: [usize; 3] = std::array::from_fn(|r| (voxel[r] - window.min[r]) as usize);
    let [width, depth, _] = window.size.map(|n| n as usize);
    x + width * (y + depth * z)
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

    /// The places of a path on which a body comes from an entry to a place that is too near, and is not noticed if these
    /// voxels are watched; with the squared distance at its end. `None` if there is no such path. The window of the watched
    /// voxels is [`ApproachMoment::body_window`].
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
        let index = |place| index_in(window, place);
        let place_at = |at: usize| {
            let own = [at % width, at / width % depth, at / (width * depth)];
            std::array::from_fn::<i32, 3, _>(|r| window.min[r] + own[r] as i32)
        };
        let voxels = body.count();
        let length = |place| PARTS * u64::from(body.sum(&counts.sums, place)) / voxels + 1;
        let ends_at = |place| {
            let may_end = u32::try_from(least(body, place, &self.distances)).is_ok_and(is_too_near);
            let squared = may_end.then(|| squared_distance(body, place, &self.distances)).flatten();
            squared.filter(|&squared| is_too_near(squared))
        };
        let mut lengths = vec![u64::MAX; width * depth * height];
        let mut before = vec![u32::MAX; lengths.len()];
        let mut queue = BinaryHeap::new();
        let moves = steps(body.climbs);
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
            let neighbours = moves.iter().map(|(by, _)| std::array::from_fn(|r| place[r] + by[r]));
            for next in neighbours.filter(|&next| window.contains(next) && open.get(next)) {
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
