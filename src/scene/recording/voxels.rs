//! A map in voxels of its own, and what it says in the grid of a study, whose voxels may be of another size
//! and turned.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use super::{Anchor, Said};
use crate::objects::octomap::{Leaf, Tree};
use perirobot_march::backend::Planes;
use perirobot_march::voxel::{Grid, Window};

/// A map in voxels. Voxel [0, 0, 0] has its lowest corner at `corner_m` of the map's frame.
#[derive(Clone, Debug, PartialEq)]
pub struct VoxelMap {
    /// Edge of a voxel in metres.
    pub(super) voxel_size_m: f64,
    pub(super) corner_m: DVec3,
    /// Where the sensor was that recorded it, in the map's frame, if that is known.
    pub(super) sensor_m: Option<DVec3>,
    pub(super) known: VoxelKnowledge,
}

/// What a map knows.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum VoxelKnowledge {
    /// Cubes of voxels, none of which overlap.
    Leaves(Vec<Leaf>),
    /// A plane for each label, and where it is known one of the voxels that returns came from.
    Planes { planes: Planes, knows_hits: bool },
}

impl VoxelMap {
    /// The map of an OctoMap, whose key 0 begins at the origin.
    pub(super) fn from_tree(tree: Tree) -> VoxelMap {
        let known = VoxelKnowledge::Leaves(tree.leaves);
        VoxelMap { voxel_size_m: tree.resolution_m, corner_m: DVec3::ZERO, sensor_m: None, known }
    }

    /// What it knows of a box of its own voxels.
    fn planes(&self, window: Window) -> Planes {
        let mut out = Planes::blank(window);
        match &self.known {
            VoxelKnowledge::Planes { planes, .. } => out.add(planes),
            VoxelKnowledge::Leaves(leaves) => {
                let end = window.end();
                for Leaf { key, edge, occupied } in leaves {
                    let plane = if *occupied { &mut out.occupied } else { &mut out.free };
                    for z in key[2].max(window.min[2])..(key[2] + edge).min(end[2]) {
                        for y in key[1].max(window.min[1])..(key[1] + edge).min(end[1]) {
                            plane.set_run(key[0], key[0] + edge, y, z);
                        }
                    }
                }
            }
        }
        out
    }

    /// The voxels of which it knows something, as a box.
    fn extent(&self) -> Window {
        match &self.known {
            VoxelKnowledge::Planes { planes, .. } => planes.occupied.window(),
            VoxelKnowledge::Leaves(leaves) => {
                leaves.iter().fold(Window::from_corners([0; 3], [-1; 3]), |all, leaf| {
                    all.union(&Window::from_corners(leaf.key, leaf.key.map(|low| low + leaf.edge - 1)))
                })
            }
        }
    }

    pub(super) fn bounds_m(&self) -> [DVec3; 2] {
        let extent = self.extent();
        [extent.min, extent.end()].map(|corner| self.corner_of_m(corner))
    }

    pub(super) fn describe(&self) -> String {
        let kind = match &self.known {
            VoxelKnowledge::Planes { .. } => "labels",
            VoxelKnowledge::Leaves(_) => "an OctoMap",
        };
        let size_m = self.bounds_m()[1] - self.bounds_m()[0];
        format!(
            "{kind} of {:.2} × {:.2} × {:.2} m in voxels of {} m",
            size_m.x, size_m.y, size_m.z, self.voxel_size_m
        )
    }

    /// The lowest corner of a voxel in the map's frame.
    fn corner_of_m(&self, voxel: [i32; 3]) -> DVec3 {
        self.corner_m + DVec3::from_array(voxel.map(f64::from)) * self.voxel_size_m
    }

    /// The part of it that may lie in a grid.
    fn nearby(&self, anchor: &Anchor, grid: &Grid) -> Window {
        self.extent().intersection(&Laid { map: self, anchor, grid }.source_window(grid.window()))
    }

    /// How many voxels that part has.
    pub(super) fn voxels_near(&self, anchor: &Anchor, grid: &Grid) -> u64 {
        self.nearby(anchor, grid).size.into_iter().fold(1, |all, n| all.saturating_mul(n.into()))
    }

    /// What it says in the grid of a study.
    pub(super) fn to_grid(&self, anchor: &Anchor, grid: &Grid) -> Said {
        let laid = Laid { map: self, anchor, grid };
        let nearby = self.planes(self.nearby(anchor, grid));
        let [_, depth, _] = grid.size;
        let rows: Vec<Planes> = (0..depth as i32).into_par_iter().map(|y| laid.row(y, &nearby)).collect();
        let mut planes = Planes::blank(grid.window());
        rows.iter().for_each(|row| planes.add(row));
        planes.free.remove(&planes.occupied);
        Said { planes, knows_hits: matches!(self.known, VoxelKnowledge::Planes { knows_hits: true, .. }) }
    }
}

/// A map laid into a grid.
struct Laid<'a> {
    map: &'a VoxelMap,
    anchor: &'a Anchor,
    grid: &'a Grid,
}

/// Corners of a voxel of the map as seen from above, in order around it, in 1/65536 voxels of the grid.
type Corners = [[i64; 2]; 4];

impl Laid<'_> {
    /// A corner between voxels of the map, in 1/65536 voxels from the grid's corner. Neighbours share their
    /// corners, so that no gap opens between them.
    fn corner_q16(&self, voxel: [i32; 3]) -> [i64; 3] {
        self.grid.position_q16(self.anchor.world(self.map.corner_of_m(voxel)))
    }

    /// A box of voxels of the map that holds all that reach into a box of voxels of the grid.
    fn source_window(&self, part: Window) -> Window {
        let end = part.end();
        let corners = (0..8).map(|corner| {
            let at = std::array::from_fn(|r| if corner >> r & 1 == 0 { part.min[r] } else { end[r] });
            let in_map = self.anchor.frame(self.grid.corner_m(at)) - self.map.corner_m;
            (in_map / self.map.voxel_size_m).to_array()
        });
        let corners: Vec<[f64; 3]> = corners.collect();
        let over =
            |r: usize, pick: fn(f64, f64) -> f64| corners.iter().map(|c| c[r]).reduce(pick).unwrap_or(0.0);
        // One voxel more on each side makes up for rounding; no map reaches as far as the limit.
        let near = |voxels: f64| voxels.clamp(-1e9, 1e9) as i32;
        Window::from_corners(
            std::array::from_fn(|r| near(over(r, f64::min).floor()) - 1),
            std::array::from_fn(|r| near(over(r, f64::max).ceil()) + 1),
        )
    }

    /// What the map says in a row of columns of the grid's voxels. Beyond `nearby` it says nothing.
    fn row(&self, y: i32, nearby: &Planes) -> Planes {
        let [width, _, height] = self.grid.size.map(|n| n as i32);
        let mut row = Planes::blank(Window::from_corners([0, y, 0], [width - 1, y, height - 1]));
        let part = nearby.free.window();
        let layers: Vec<Range<i32>> = (0..height).map(|z| self.layers(z, part)).collect();
        for x in 0..width {
            let columns = self.columns([x, y], part);
            if columns.is_empty() {
                continue;
            }
            for z in 0..height {
                let voxels = || {
                    let layers = layers[z as usize].clone();
                    layers.flat_map(|k| columns.iter().map(move |[i, j]| [*i, *j, k]))
                };
                let voxel = [x, y, z];
                if voxels().any(|of_map| nearby.occupied.get(of_map)) {
                    row.occupied.set(voxel);
                } else if voxels().all(|of_map| nearby.free.get(of_map)) && !layers[z as usize].is_empty() {
                    row.free.set(voxel);
                }
                if voxels().any(|of_map| nearby.hits.get(of_map)) {
                    row.hits.set(voxel);
                }
            }
        }
        row
    }

    /// The layers of the map of which a part lies in a layer of the grid, likewise.
    fn layers(&self, z: i32, part: Window) -> Range<i32> {
        let [width, depth, _] = self.grid.size;
        let layer = Window { min: [0, 0, z], size: [width, depth, 1] };
        let below = self.source_window(layer).intersection(&part.grown(1));
        let (low, high) = (i64::from(z) << 16, i64::from(z + 1) << 16);
        let height = |k: i32| self.corner_q16([0, 0, k])[2];
        let reaches = |k: &i32| height(*k) + HAIR_Q16 < high && height(*k + 1) > low + HAIR_Q16;
        let mut inside = (below.min[2]..below.end()[2]).filter(reaches);
        inside.next().map_or(0..0, |first| first..inside.next_back().unwrap_or(first) + 1)
    }

    /// The columns of the map of which a part lies in a column of the grid, among those of a part of the map and
    /// the ones around it, which suffice to tell that a voxel reaches beyond.
    fn columns(&self, [x, y]: [i32; 2], part: Window) -> Vec<[i32; 2]> {
        let [_, _, height] = self.grid.size;
        let column = Window { min: [x, y, 0], size: [1, 1, height] };
        let below = self.source_window(column).intersection(&part.grown(1));
        let square = [x, y].map(|low| i64::from(low) << 16);
        let mut columns = Vec::new();
        for j in below.min[1]..below.end()[1] {
            for i in below.min[0]..below.end()[0] {
                let corner = |i: i32, j: i32| {
                    let [x, y, _] = self.corner_q16([i, j, 0]);
                    [x, y]
                };
                let corners = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                if overlap(square, &corners) {
                    columns.push([i, j]);
                }
            }
        }
        columns
    }
}

/// How deep one voxel must lie in another to count, in 1/65536 voxels of the grid: 1/256 of a voxel. Corners that were
/// rounded to single precision are off by less.
const HAIR_Q16: i64 = 256;

/// Whether a voxel's square (by its lowest corner) and a convex quadrangle lie more than a hair in each other, by
/// separating axes in integers.
fn overlap(square: [i64; 2], corners: &Corners) -> bool {
    let edge = 1i64 << 16;
    let of_square = [[0, 0], [edge, 0], [edge, edge], [0, edge]].map(|[x, y]| [square[0] + x, square[1] + y]);
    let sides = (0..4).map(|n| {
        let (a, b) = (corners[n], corners[(n + 1) % 4]);
        [a[1] - b[1], b[0] - a[0]]
    });
    let axes = [[1, 0], [0, 1]].into_iter().chain(sides);
    let span = |of: &Corners, axis: [i64; 2]| {
        let along =
            of.map(|[x, y]| i128::from(x) * i128::from(axis[0]) + i128::from(y) * i128::from(axis[1]));
        (along.into_iter().min().unwrap_or(0), along.into_iter().max().unwrap_or(0))
    };
    axes.into_iter().all(|axis| {
        let ((low, high), (low_2, high_2)) = (span(&of_square, axis), span(corners, axis));
        let depth = high.min(high_2) - low.max(low_2);
        let squared: i128 = axis.iter().map(|&part| i128::from(part).pow(2)).sum();
        depth > 0 && depth.pow(2) > i128::from(HAIR_Q16).pow(2) * squared
    })
}
