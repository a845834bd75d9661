//! Labels over a box of voxels as a map, whatever array they come from.

use glam::DVec3;

use super::FARTHEST_M;
use super::voxels::{VoxelKnowledge, VoxelMap};
use perirobot_march::backend::Planes;
use perirobot_march::error::Issue;
use perirobot_march::voxel::{BitGrid, Window};

/// Most voxels, with rows along x filled up to 32: three planes of a quarter of a gigabyte.
const MOST_VOXELS: usize = 1 << 31;

/// Calls what it is given with the place and the number of each entry of an array.
pub(super) type Each<'a> = dyn Fn(&mut dyn FnMut([i32; 3], f64)) + 'a;

/// An array of labels: 1 is occupied, 0 free, −1 unknown.
pub(super) struct LabelArray<'a> {
    pub(super) shape: [usize; 3],
    pub(super) each: &'a Each<'a>,
    /// Whether 255 is unknown, too.
    pub(super) are_bytes: bool,
    /// Which voxels returns came from, if that is known: those that are not 0.
    pub(super) hits: Option<&'a Each<'a>>,
    /// Lowest corner of voxel `[0, 0, 0]`.
    pub(super) origin_m: DVec3,
    pub(super) voxel_size_m: f64,
}

/// The entries of an array of three axes, the first the fastest.
pub(super) fn voxels_of([nx, ny, nz]: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    let rows = (0..nz).flat_map(move |z| (0..ny).map(move |y| [y, z]));
    rows.flat_map(move |[y, z]| (0..nx).map(move |x| [x, y, z]))
}

impl LabelArray<'_> {
    /// The map that they make.
    pub(super) fn map(self) -> Result<VoxelMap, Issue> {
        let LabelArray { shape, origin_m, voxel_size_m, .. } = self;
        let [x, y, z] = shape.map(|n| n.min(1 << 21));
        if shape.iter().any(|n| *n > 1 << 20) || x.next_multiple_of(32) * y * z > MOST_VOXELS {
            let what = format!(
                "has the shape {shape:?}: at most {} voxels on an axis and {MOST_VOXELS} in all are read, with x filled up to 32",
                1 << 20
            );
            return Err(Issue::too_large(what).with_advice("cut the map to the cell").with_place("labels"));
        }
        let window = Window { min: [0; 3], size: [x, y, z].map(|n| n as u32) };
        let [mut occupied, mut free, mut hits] = [(); 3].map(|()| BitGrid::new(window));
        let mut odd = None;
        (self.each)(&mut |voxel, label| match label {
            1.0 => occupied.set(voxel),
            0.0 => free.set(voxel),
            -1.0 => {}
            255.0 if self.are_bytes => {}
            other => odd = odd.or(Some((voxel, other))),
        });
        if let Some((voxel, label)) = odd {
            let rule = "must be 1 (occupied), 0 (free) or -1 (unknown)";
            return Err(Issue::value(format!("{voxel:?}"), label, rule).with_place("labels"));
        }
        if let Some(each) = self.hits {
            each(&mut |voxel, is_hit| {
                if is_hit != 0.0 {
                    hits.set(voxel);
                }
            });
        }
        if occupied.is_empty() && free.is_empty() {
            return Err(Issue::says("has no voxel that is occupied or free").with_place("labels"));
        }
        if !origin_m.to_array().iter().all(|v| v.abs() <= FARTHEST_M) {
            let rule = format!("must be three lengths in metres, from -{FARTHEST_M} to {FARTHEST_M}");
            return Err(Issue::says(rule).with_place("origin_m"));
        }
        if !(voxel_size_m.is_finite() && voxel_size_m > 0.0) {
            return Err(Issue::says("must be one positive length in metres").with_place("voxel_size_m"));
        }
        let known = VoxelKnowledge::Planes {
            planes: Planes { occupied, free, hits },
            knows_hits: self.hits.is_some(),
        };
        Ok(VoxelMap { voxel_size_m, corner_m: origin_m, sensor_m: None, known })
    }
}
