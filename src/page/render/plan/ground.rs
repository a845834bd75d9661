//! The ground plan: footprints of objects as outlines, walls at the height of the cut, and the floor that no sensor
//! watches.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use glam::{DVec2, DVec3};

use super::paper::Paper;
use perirobot_decide::view::watched::WatchedVoxels;
use perirobot_march::voxel::{BitGrid, Grid, Window};
use perirobot_scene::truth::Truth;

/// The height above the floor at which walls are cut.
const CUT_M: f64 = 1.2;
/// Objects above this height are not drawn, and people are below it.
const HEAD_M: f64 = 1.8;

/// Largest height of a slab above the lowest place; it covers at least half of the room.
const SLAB_M: f64 = 0.5;
/// Least area of an enclosed part of the cell; a square as wide as a person must fit in.
const LEAST_M2: f64 = 1.0;
const PERSON_M: f64 = 0.4;

/// The layers of a grid in a plan.
#[derive(Clone, Debug)]
pub(super) struct Storey {
    grid: Grid,
    /// Above the floor, up to the head of a standing person.
    pub(super) layers: Range<i32>,
    /// The height of the cut.
    cut: i32,
    room_m: [DVec3; 2],
    /// Columns inside walls and cupboards.
    pub(super) voids: BitGrid,
}

/// The floor, and its watched share.
#[derive(Debug)]
pub(super) struct WatchedFloor {
    /// Columns without a watched voxel.
    pub(super) blind: BitGrid,
    /// Other columns with less than half of their voxels watched.
    pub(super) hardly: BitGrid,
    /// The number of columns with room for at least a part of a person.
    pub(super) columns: u64,
}

impl Storey {
    /// For a room with its floor at a height, or on a slab on it.
    pub(super) fn new(truth: &Truth, room_m: [DVec3; 2], floor_m: f64) -> Storey {
        let grid = truth.grid;
        let steps = |metres: f64| (metres / grid.voxel_size_m).round() as i32;
        let top = grid.size[2] as i32;
        let lowest =
            (grid.position_q16(DVec3::new(0.0, 0.0, floor_m))[2] >> 16).clamp(0, i64::from(top) - 1) as i32;
        let mut storey = Storey {
            grid,
            layers: lowest..lowest + 1,
            cut: lowest,
            room_m,
            voids: BitGrid::new(Window { min: [0; 3], size: [grid.size[0], grid.size[1], 1] }),
        };
        let columns = storey.columns();
        let is_slab = |z: &i32| {
            let covered = columns.iter().filter(|[x, y]| truth.occupied.get([*x, *y, *z])).count();
            2 * covered >= columns.len()
        };
        let floor = (lowest..(lowest + steps(SLAB_M) + 1).min(top)).rev().find(is_slab).unwrap_or(lowest);
        let low = (floor + 1).min(top - 1);
        storey.layers = low..(floor + steps(HEAD_M)).clamp(low + 1, top.max(low + 1));
        storey.cut = (floor + steps(CUT_M)).clamp(low, storey.layers.end - 1);
        storey.voids = storey.enclosed_voxels(truth);
        storey
    }

    /// The columns whose middle is inside the room.
    fn columns(&self) -> Vec<[i32; 2]> {
        let [low, high] = self.room_m.map(DVec3::truncate);
        let half = DVec2::splat(self.grid.voxel_size_m / 2.0);
        let is_inside = |&[x, y]: &[i32; 2]| {
            let middle = self.grid.corner_m([x, y, 0]).truncate() + half;
            middle.cmpge(low).all() && middle.cmple(high).all()
        };
        let [x, y, _] = self.grid.size.map(|n| n as i32);
        (0..y).flat_map(|y| (0..x).map(move |x| [x, y])).filter(is_inside).collect()
    }

    /// Enclosed voxels at the height of the cut that are too small to be a part of the cell.
    fn enclosed_voxels(&self, truth: &Truth) -> BitGrid {
        let blank = BitGrid::new(Window { min: [0; 3], size: [self.grid.size[0], self.grid.size[1], 1] });
        let mut open = blank.clone();
        let is_cut = |[x, y]: [i32; 2]| {
            let voxel = [x, y, self.cut];
            truth.occupied.get(voxel) && !truth.robot.get(voxel) && !truth.human.get(voxel)
        };
        let free = self.columns().into_iter().filter(|&column| !is_cut(column));
        free.for_each(|[x, y]| open.set([x, y, 0]));
        let wide = (PERSON_M / self.grid.voxel_size_m).ceil() as i32;
        let (mut seen, mut voids) = (blank.clone(), blank);
        for begin in open.voxels().collect::<Vec<_>>() {
            if seen.get(begin) {
                continue;
            }
            seen.set(begin);
            let mut part = vec![begin];
            let mut next = 0;
            while let Some(&[x, y, z]) = part.get(next) {
                next += 1;
                for beside in [[x - 1, y, z], [x + 1, y, z], [x, y - 1, z], [x, y + 1, z]] {
                    if open.get(beside) && !seen.get(beside) {
                        seen.set(beside);
                        part.push(beside);
                    }
                }
            }
            let square =
                |[x, y, z]: &[i32; 3]| (0..wide).all(|dy| (0..wide).all(|dx| open.get([x + dx, y + dy, *z])));
            if self.area_m2(part.len() as u64) < LEAST_M2 || !part.iter().any(square) {
                part.into_iter().for_each(|column| voids.set(column));
            }
        }
        voids
    }

    /// The columns of the grid with a voxel of a set in some layers, as one layer.
    fn flatten(&self, voxels: &BitGrid, layers: Range<i32>) -> BitGrid {
        let [x, y, _] = self.grid.size;
        let mut flat = BitGrid::new(Window { min: [0; 3], size: [x, y, 1] });
        let part = voxels.window().intersection(&Window {
            min: [0, 0, layers.start],
            size: [x, y, (layers.end - layers.start).max(0) as u32],
        });
        voxels.each_in(&part, |[x, y, _]| flat.set([x, y, 0]));
        flat
    }

    /// The area of an object, seen from above.
    pub(super) fn footprint(&self, voxels: &BitGrid) -> BitGrid {
        self.flatten(voxels, self.layers.clone())
    }

    /// The same at any height.
    pub(super) fn shadow(&self, voxels: &BitGrid) -> BitGrid {
        self.flatten(voxels, 0..self.grid.size[2] as i32)
    }

    /// The section of an object at the height of the cut.
    pub(super) fn section(&self, voxels: &BitGrid) -> BitGrid {
        self.flatten(voxels, self.cut..self.cut + 1)
    }

    /// How much is watched of surfaces that bodies walk on, up to a person's head above each. A column with several is blind if one
    /// of them is.
    pub(super) fn walked_floor(
        &self,
        truth: &Truth,
        watch: &WatchedVoxels,
        surfaces: &BitGrid,
    ) -> WatchedFloor {
        let blank = BitGrid::new(self.voids.window());
        let (mut all, mut blind, mut hardly) = (blank.clone(), blank.clone(), blank);
        let head = (HEAD_M / self.grid.voxel_size_m).round() as i32;
        let columns: BTreeSet<[i32; 2]> = self.columns().into_iter().collect();
        for [x, y, surface] in surfaces.voxels().filter(|[x, y, _]| columns.contains(&[*x, *y])) {
            let above = (surface + 1..=surface + head).map(|z| [x, y, z]);
            let is_open = |voxel: &[i32; 3]| {
                let is_solid = truth.occupied.get(*voxel) || truth.ignored.get(*voxel);
                self.grid.window().contains(*voxel) && (!is_solid || watch.voxels.get(*voxel))
            };
            let open: Vec<[i32; 3]> = above.filter(is_open).collect();
            let watched = open.iter().filter(|voxel| watch.voxels.get(**voxel)).count();
            all.set([x, y, 0]);
            match watched {
                0 => blind.set([x, y, 0]),
                some if 2 * some < open.len() => hardly.set([x, y, 0]),
                _ => {}
            }
        }
        hardly.remove(&blind);
        WatchedFloor { blind, hardly, columns: all.count() }
    }

    /// The watched floor: counts the voxels of each column that are not solid.
    pub(super) fn floor(&self, truth: &Truth, watch: &WatchedVoxels) -> WatchedFloor {
        let blank = BitGrid::new(self.voids.window());
        let mut floor = WatchedFloor { blind: blank.clone(), hardly: blank, columns: 0 };
        for [x, y] in self.columns() {
            let (mut free, mut watched) = (0, 0);
            for voxel in self.layers.clone().map(|z| [x, y, z]) {
                let is_solid = truth.occupied.get(voxel) || truth.ignored.get(voxel);
                if !is_solid || watch.voxels.get(voxel) {
                    free += 1;
                    watched += u32::from(watch.voxels.get(voxel));
                }
            }
            // Sections, and what they enclose, are not floor.
            let cut = [x, y, self.cut];
            if self.voids.get([x, y, 0]) || truth.occupied.get(cut) || truth.ignored.get(cut) || free == 0 {
                continue;
            }
            floor.columns += 1;
            match watched {
                0 => floor.blind.set([x, y, 0]),
                some if 2 * some < free => floor.hardly.set([x, y, 0]),
                _ => {}
            }
        }
        floor
    }

    /// The outline of a layer, as a path.
    pub(super) fn outline(&self, flat: &BitGrid, paper: &Paper) -> String {
        let corner = |[x, y]: [i32; 2]| self.grid.corner_m([x, y, 0]).truncate();
        let path = |ring: &Vec<[i32; 2]>| {
            paper.ring(&ring.iter().map(|&place| corner(place)).collect::<Vec<DVec2>>())
        };
        rings(flat).iter().map(path).collect()
    }

    /// The middle of a layer's voxels in metres, and half its size.
    pub(super) fn extent(&self, flat: &BitGrid) -> [DVec2; 2] {
        let around = flat.bounds();
        [around.min, around.end()].map(|corner| self.grid.corner_m(corner).truncate())
    }

    /// The same of its largest part.
    pub(super) fn extent_of_largest(&self, flat: &BitGrid) -> [DVec2; 2] {
        let largest = rings(flat).into_iter().max_by_key(|ring| twice_the_area(ring)).unwrap_or_default();
        let corners = largest.iter().map(|&[x, y]| self.grid.corner_m([x, y, 0]).truncate());
        corners.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], corner| {
            [low.min(corner), high.max(corner)]
        })
    }

    /// The area of this many columns.
    pub(super) fn area_m2(&self, columns: u64) -> f64 {
        columns as f64 * self.grid.voxel_size_m * self.grid.voxel_size_m
    }
}

/// The corners of the outlines of a layer, anticlockwise around what is set and clockwise around holes.
fn rings(flat: &BitGrid) -> Vec<Vec<[i32; 2]>> {
    let mut edges: BTreeMap<[i32; 2], Vec<[i32; 2]>> = BTreeMap::new();
    for [x, y, z] in flat.voxels() {
        let sides = [
            ([0, -1], [x, y], [x + 1, y]),
            ([1, 0], [x + 1, y], [x + 1, y + 1]),
            ([0, 1], [x + 1, y + 1], [x, y + 1]),
            ([-1, 0], [x, y + 1], [x, y]),
        ];
        for (way, from, to) in sides {
            if !flat.get([x + way[0], y + way[1], z]) {
                edges.entry(from).or_default().push(to);
            }
        }
    }
    let mut rings = Vec::new();
    while let Some((&begin, _)) = edges.first_key_value() {
        let mut ring = vec![begin];
        let mut at = begin;
        while let Some(next) = edges.get_mut(&at).and_then(Vec::pop) {
            if edges.get(&at).is_some_and(Vec::is_empty) {
                edges.remove(&at);
            }
            ring.push(next);
            at = next;
        }
        ring.pop();
        rings.push(corners(&ring));
    }
    rings
}

/// Twice the area of a ring, negative if it is clockwise.
fn twice_the_area(ring: &[[i32; 2]]) -> i32 {
    let next = |i: usize| ring[(i + 1) % ring.len()];
    (0..ring.len()).map(|i| ring[i][0] * next(i)[1] - next(i)[0] * ring[i][1]).sum()
}

/// A ring without its straight vertices.
fn corners(ring: &[[i32; 2]]) -> Vec<[i32; 2]> {
    let turns = |i: usize| {
        let [before, at, after] = [i + ring.len() - 1, i, i + 1].map(|i| ring[i % ring.len()]);
        let way = |a: [i32; 2], b: [i32; 2]| [(b[0] - a[0]).signum(), (b[1] - a[1]).signum()];
        way(before, at) != way(at, after)
    };
    (0..ring.len()).filter(|&i| turns(i)).map(|i| ring[i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layer(rows: &[&str]) -> BitGrid {
        let size = [rows[0].len() as u32, rows.len() as u32, 1];
        let mut flat = BitGrid::new(Window { min: [0; 3], size });
        for (y, row) in rows.iter().enumerate() {
            for (x, _) in row.chars().enumerate().filter(|(_, letter)| *letter == '#') {
                flat.set([x as i32, y as i32, 0]);
            }
        }
        flat
    }

    #[test]
    fn outlines_have_corners_only() {
        assert_eq!(rings(&layer(&["###", "###"])), [[[0, 0], [3, 0], [3, 2], [0, 2]]]);
        assert_eq!(rings(&layer(&["..."])), Vec::<Vec<[i32; 2]>>::new());
        let ring = rings(&layer(&["###", "#.#", "###"]));
        assert_eq!(ring.len(), 2, "{ring:?}");
        assert_eq!(ring[1], [[1, 1], [1, 2], [2, 2], [2, 1]], "a hole, clockwise");
        let steps = rings(&layer(&["#..", "##."]));
        assert_eq!(steps, [vec![[0, 0], [1, 0], [1, 1], [2, 1], [2, 2], [0, 2]]]);
    }

    #[test]
    fn voxels_that_meet_at_a_corner_are_all_outlined() {
        let flat = layer(&["#.", ".#"]);
        let rings = rings(&flat);
        assert_eq!(rings.iter().map(|ring| twice_the_area(ring)).sum::<i32>(), 4, "{rings:?}");
    }
}
