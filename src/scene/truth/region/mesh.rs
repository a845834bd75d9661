//! The voxels whose centre is inside a watertight mesh: a ray along x through each row of centres counts the
//! triangles it passes, and a centre is inside where those behind it face one way more often than the other.

use perirobot_march::lengths::describe_place;
use std::ops::Range;

use crate::objects::Mesh;
use perirobot_march::error::Issue;
use perirobot_march::voxel::overlap::{self, Corner, VOXEL};
use perirobot_march::voxel::solid::{ceil_div, centre_q16, centres_in, first_centre, passes};
use perirobot_march::voxel::{grid::MAX_VOXELS_PER_AXIS, grid::ONE_Q16};

/// A run of voxels along x, not empty.
pub(super) type VoxelRun = Range<i64>;

/// Where rows of centres pass the surface of a mesh.
pub(super) struct MeshRows {
    passed: Vec<Passed>,
    span: [Range<i64>; 2],
}

/// A triangle that a row passes: the row, the first voxel whose centre is not before it, and how it faces.
type Passed = ([i64; 2], i64, i64);

impl MeshRows {
    /// The inside of a mesh, its corners on the truth's lattice, from a grid's corner.
    ///
    /// # Errors
    /// When the mesh is not watertight there, or too large.
    pub(super) fn new(mesh: &Mesh, voxel_size_m: f64, origin: [i32; 3]) -> Result<MeshRows, Issue> {
        let corners = corners(mesh, voxel_size_m)?;
        let triangles = || mesh.triangles.iter().map(|t| t.map(|i| corners[i as usize]));
        let extent = overlap::extent(triangles().flatten().collect::<Vec<_>>().iter());
        if extent.size.iter().any(|&n| n > 4 * MAX_VOXELS_PER_AXIS) {
            return Err(Issue::says(format!(
                "is over {} voxels long; is it in millimetres (unit = \"mm\") or centimetres (unit = \"cm\")?",
                4 * MAX_VOXELS_PER_AXIS
            )));
        }
        if let Some(why) = overlap::closure(triangles()).describe() {
            return Err(Issue::says(format!("{why}, so it has no inside")).with_advice("mend its surface"));
        }
        let mut passed = Vec::new();
        // A corner counts 1/512 voxel; the origin is a whole number of voxels, so nothing is lost.
        let from_grid = |corner: Corner| -> [i64; 3] {
            std::array::from_fn(|r| corner[r] * (ONE_Q16 / VOXEL) - origin[r] as i64 * ONE_Q16)
        };
        triangles().for_each(|triangle| pass(triangle.map(from_grid), &mut passed));
        passed.sort_unstable();
        let span = [1, 2].map(|r| {
            let first = (extent.min[r] - origin[r]) as i64;
            first..first + extent.size[r] as i64
        });
        Ok(MeshRows { passed, span })
    }

    /// The rows y and z outside of which there is no voxel.
    pub(super) fn span(&self) -> [Range<i64>; 2] {
        self.span.clone()
    }

    /// The runs inside the mesh in one row, lowest first.
    pub(super) fn runs(&self, y: i64, z: i64) -> Vec<VoxelRun> {
        let start = self.passed.partition_point(|(row, ..)| *row < [z, y]);
        let row = self.passed[start..].iter().take_while(|(row, ..)| *row == [z, y]);
        let (mut runs, mut winding, mut entered) = (Vec::<VoxelRun>::new(), 0, 0);
        for &(_, x, facing) in row {
            if winding == 0 {
                entered = x;
            }
            winding += facing;
            if winding == 0 && entered < x {
                runs.push(entered..x);
            }
        }
        runs
    }
}

fn corners(mesh: &Mesh, voxel_size_m: f64) -> Result<Vec<Corner>, Issue> {
    let corner = |&vertex| {
        overlap::corner(vertex, voxel_size_m).ok_or_else(|| {
            Issue::says(format!("has a corner at {}, too far away", describe_place(vertex)))
                .with_advice("is it in millimetres (unit = \"mm\") or centimetres (unit = \"cm\")?")
        })
    };
    mesh.vertices.iter().map(corner).collect()
}

/// Adds the rows of centres that pass a triangle. Seen along x, an area includes its lower end in y and
/// excludes its upper one, and a centre on the triangle counts as behind it: as if each point were moved by
/// an infinitesimal along y and a smaller one along x, so that it lies on no triangle and on no edge.
fn pass(triangle: [[i64; 3]; 3], passed: &mut Vec<Passed>) {
    let [p, q] =
        [1, 2].map(|i| -> [i128; 3] { std::array::from_fn(|r| (triangle[i][r] - triangle[0][r]) as i128) });
    let normal: [i128; 3] = std::array::from_fn(|r| {
        let (s, t) = ((r + 1) % 3, (r + 2) % 3);
        p[s] * q[t] - p[t] * q[s]
    });
    if normal[0] == 0 {
        return;
    }
    let heights = triangle.map(|corner| corner[2]);
    let (low, high) = (heights.into_iter().min(), heights.into_iter().max());
    for z in centres_in(low.unwrap_or(0)..high.unwrap_or(0)) {
        let edges = (0..3).map(|e| [triangle[e], triangle[(e + 1) % 3]].map(|c| [c[1], c[2]]));
        let mut ys: Vec<i64> = edges.filter_map(|[a, b]| passes(a, b, centre_q16(z))).collect();
        ys.sort_unstable();
        let [from, to] = ys[..] else { continue };
        for y in centres_in(from..to) {
            // The plane's x over this centre: normal · (point − corner) = 0.
            let [_, y_away, z_away] =
                [0, centre_q16(y) - triangle[0][1], centre_q16(z) - triangle[0][2]].map(i128::from);
            let x = ceil_div(-(normal[1] * y_away + normal[2] * z_away), normal[0]) as i64;
            passed.push(([z, y], first_centre(triangle[0][0] + x), normal[0].signum() as i64));
        }
    }
}

#[cfg(test)]
#[allow(clippy::single_range_in_vec_init)] // a row may well have one run
mod tests;
