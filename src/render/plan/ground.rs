//! What stands where on the floor: footprints of objects as outlines, walls where the plan cuts them, and the floor
//! that no sensor watches.

use std::collections::BTreeMap;
use std::ops::Range;

use glam::{DVec2, DVec3};

use super::paper::Paper;
use crate::view::watched::Watch;
use crate::voxel::{BitGrid, Grid, Truth, Window};

/// The height above the floor at which walls are cut.
const CUT_M: f64 = 1.2;
/// What is higher above the floor is not drawn, and nobody stands there.
const HEAD_M: f64 = 1.8;

/// The layers of a grid that a plan is about.
#[derive(Clone, Debug)]
pub(super) struct Storey {
    grid: Grid,
    /// Above the floor, up to the head of a person who stands.
    pub(super) layers: Range<i32>,
    /// Where walls are cut.
    cut: i32,
}

/// The floor, and how much of it is watched.
#[derive(Debug)]
pub(super) struct Floor {
    /// Columns of which no voxel is watched.
    pub(super) blind: BitGrid,
    /// Others of which fewer than half are.
    pub(super) hardly: BitGrid,
    /// How many columns there are that a person could stand in, at least with a part.
    pub(super) columns: u64,
}

impl Storey {
    pub(super) fn new(grid: Grid, floor_m: f64) -> Storey {
        let layer = |above_m: f64| {
            let z = grid.position_q16(DVec3::new(0.0, 0.0, floor_m + above_m))[2] >> 16;
            z.clamp(0, i64::from(grid.size[2])) as i32
        };
        // As pads have it: the layer above that of the floor.
        let low = (layer(0.0) + 1).min(grid.size[2] as i32 - 1);
        let layers = low..layer(HEAD_M).max(low + 1);
        let cut = layer(CUT_M).clamp(layers.start, layers.end - 1);
        Storey { grid, layers, cut }
    }

    /// The columns of the grid that have a voxel of a set in some layers, as one layer.
    fn flattened(&self, voxels: &BitGrid, layers: Range<i32>) -> BitGrid {
        let [x, y, _] = self.grid.size;
        let mut flat = BitGrid::new(Window { min: [0; 3], size: [x, y, 1] });
        let part = voxels.window().intersection(&Window {
            min: [0, 0, layers.start],
            size: [x, y, (layers.end - layers.start).max(0) as u32],
        });
        voxels.each_in(&part, |[x, y, _]| flat.set([x, y, 0]));
        flat
    }

    /// What an object covers, seen from above.
    pub(super) fn footprint(&self, voxels: &BitGrid) -> BitGrid {
        self.flattened(voxels, self.layers.clone())
    }

    /// The same at any height.
    pub(super) fn shadow(&self, voxels: &BitGrid) -> BitGrid {
        self.flattened(voxels, 0..self.grid.size[2] as i32)
    }

    /// Where an object is cut.
    pub(super) fn section(&self, voxels: &BitGrid) -> BitGrid {
        self.flattened(voxels, self.cut..self.cut + 1)
    }

    /// How much of the floor inside of a room is watched: in each column the voxels that are not solid count.
    pub(super) fn floor(&self, truth: &Truth, watch: &Watch, [low, high]: [DVec3; 2]) -> Floor {
        let [x, y, _] = self.grid.size;
        let blank = BitGrid::new(Window { min: [0; 3], size: [x, y, 1] });
        let mut floor = Floor { blind: blank.clone(), hardly: blank, columns: 0 };
        let half = DVec2::splat(self.grid.voxel_size_m / 2.0);
        let is_inside = |x: i32, y: i32| {
            let middle = self.grid.corner_m([x, y, 0]).truncate() + half;
            middle.cmpge(low.truncate()).all() && middle.cmple(high.truncate()).all()
        };
        for y in 0..y as i32 {
            for x in (0..x as i32).filter(|&x| is_inside(x, y)) {
                let (mut free, mut watched) = (0, 0);
                for voxel in self.layers.clone().map(|z| [x, y, z]) {
                    let is_solid = truth.occupied.get(voxel) || truth.ignored.get(voxel);
                    if !is_solid || watch.voxels.get(voxel) {
                        free += 1;
                        watched += u32::from(watch.voxels.get(voxel));
                    }
                }
                // The column of a wall, as deep as its voxels are, is no floor.
                if truth.occupied.get([x, y, self.cut]) || truth.ignored.get([x, y, self.cut]) || free == 0 {
                    continue;
                }
                floor.columns += 1;
                match watched {
                    0 => floor.blind.set([x, y, 0]),
                    some if 2 * some < free => floor.hardly.set([x, y, 0]),
                    _ => {}
                }
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

    /// The middle of a layer's voxels in metres, and how far they reach to each side.
    pub(super) fn extent(&self, flat: &BitGrid) -> [DVec2; 2] {
        let around = flat.bounds();
        [around.min, around.end()].map(|corner| self.grid.corner_m(corner).truncate())
    }

    /// The area of so many columns.
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

/// A ring without the places at which it goes straight on.
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
        let area = |ring: &Vec<[i32; 2]>| {
            let next = |i: usize| ring[(i + 1) % ring.len()];
            (0..ring.len()).map(|i| ring[i][0] * next(i)[1] - next(i)[0] * ring[i][1]).sum::<i32>() / 2
        };
        let rings = rings(&flat);
        assert_eq!(rings.iter().map(area).sum::<i32>(), 2, "{rings:?}");
    }
}
