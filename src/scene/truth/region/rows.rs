//! Shapes in integers, as runs of voxels along x for each row y, z, wherever the grid is.

use std::ops::Range;

use super::mesh::{MeshRows, VoxelRun};
use perirobot_march::voxel::BitGrid;
use perirobot_march::voxel::solid::{Ball, at_least_zero, both, centre_q16};

/// A shape that can be asked for its rows.
pub(super) enum RowShape {
    /// A ball.
    Ball(Ball),
    /// What is behind none of some planes.
    Cut { part: Box<RowShape>, planes: Vec<CutPlane> },
    /// A box of voxels.
    Box([Range<i64>; 3]),
    /// The inside of a mesh.
    Mesh(MeshRows),
    /// Voxels as they are; some may lie outside the grid.
    Voxels(BitGrid),
    /// What is in any of several.
    Union(Vec<RowShape>),
    /// What is in the first of several and in none of the others.
    Difference(Vec<RowShape>),
}

/// A plane through a point; behind it the offset from the point has a negative product with the normal.
pub(super) struct CutPlane {
    pub(super) point_q16: [i64; 3],
    pub(super) normal_q15: [i64; 3],
}

impl CutPlane {
    /// The voxels of a row that are not behind it.
    fn run(&self, y: i64, z: i64) -> Range<i64> {
        let away = |voxel: i64, r: usize| self.normal_q15[r] * (centre_q16(voxel) - self.point_q16[r]);
        // The product is that of x = 0, and one voxel along x adds the same each time.
        at_least_zero(self.normal_q15[0] << 16, away(0, 0) + away(y, 1) + away(z, 2))
    }
}

impl RowShape {
    /// The rows y and z outside of which there is no voxel.
    pub(super) fn span(&self) -> [Range<i64>; 2] {
        match self {
            RowShape::Ball(ball) => ball.rows(),
            RowShape::Cut { part, .. } => part.span(),
            RowShape::Box([_, y, z]) => [y.clone(), z.clone()],
            RowShape::Mesh(mesh) => mesh.span(),
            RowShape::Voxels(voxels) => {
                let (min, end) = (voxels.window().min, voxels.window().end());
                [1, 2].map(|r| i64::from(min[r])..i64::from(end[r]))
            }
            RowShape::Union(parts) => {
                let spans =
                    parts.iter().map(RowShape::span).filter(|span| span.iter().all(|r| !r.is_empty()));
                let joined = |[y, z]: [Range<i64>; 2], [b, c]: [Range<i64>; 2]| [hull(y, b), hull(z, c)];
                spans.reduce(joined).unwrap_or([0..0, 0..0])
            }
            RowShape::Difference(parts) => parts.first().map_or([0..0, 0..0], RowShape::span),
        }
    }

    /// The runs of a row, lowest first; none overlap.
    pub(super) fn runs(&self, y: i64, z: i64) -> Vec<VoxelRun> {
        let inside = |[ys, zs]: [Range<i64>; 2]| ys.contains(&y) && zs.contains(&z);
        if !inside(self.span()) {
            return Vec::new();
        }
        match self {
            RowShape::Ball(ball) => one(ball.run(y, z)),
            RowShape::Cut { part, planes } => {
                let cut = |run: VoxelRun| planes.iter().fold(run, |left, plane| both(left, plane.run(y, z)));
                part.runs(y, z).into_iter().map(cut).filter(|run| !run.is_empty()).collect()
            }
            RowShape::Box([x, _, _]) => one(x.clone()),
            RowShape::Mesh(mesh) => mesh.runs(y, z),
            RowShape::Voxels(voxels) => {
                // Both lie in the window.
                let first = i64::from(voxels.window().min[0]);
                let each = (first..).zip(bits(voxels.row(y as i32, z as i32)));
                join(each.filter(|(_, is_set)| *is_set).map(|(x, _)| x..x + 1).collect())
            }
            RowShape::Union(parts) => join(parts.iter().flat_map(|part| part.runs(y, z)).collect()),
            RowShape::Difference(parts) => {
                let mut runs = parts.iter().map(|part| part.runs(y, z));
                let first = runs.next().unwrap_or_default();
                runs.flatten().fold(first, |left, taken| subtract(left, &taken))
            }
        }
    }
}

/// The bits of a row of words.
fn bits(words: &[u32]) -> impl Iterator<Item = bool> + '_ {
    words.iter().flat_map(|word| (0..32).map(move |bit| word >> bit & 1 == 1))
}

fn hull(a: Range<i64>, b: Range<i64>) -> Range<i64> {
    a.start.min(b.start)..a.end.max(b.end)
}

fn one(run: VoxelRun) -> Vec<VoxelRun> {
    if run.is_empty() { Vec::new() } else { vec![run] }
}

/// Runs in order, those that touch or overlap joined.
fn join(mut runs: Vec<VoxelRun>) -> Vec<VoxelRun> {
    runs.sort_unstable_by_key(|run| run.start);
    let mut all: Vec<VoxelRun> = Vec::with_capacity(runs.len());
    for run in runs {
        match all.last_mut() {
            Some(last) if run.start <= last.end => last.end = last.end.max(run.end),
            _ => all.push(run),
        }
    }
    all
}

/// Runs less one that is taken away.
fn subtract(runs: Vec<VoxelRun>, taken: &VoxelRun) -> Vec<VoxelRun> {
    let rest = |run: VoxelRun| [run.start..run.end.min(taken.start), run.start.max(taken.end)..run.end];
    runs.into_iter().flat_map(rest).filter(|run| !run.is_empty()).collect()
}

#[cfg(test)]
#[allow(clippy::single_range_in_vec_init)] // a row may well have one run
mod tests {
    use super::*;

    #[test]
    fn runs_are_joined_and_taken_away() {
        assert_eq!(join(vec![5..7, 0..2, 2..3, 6..9, 12..13]), [0..3, 5..9, 12..13]);
        assert_eq!(join(vec![0..9, 2..3]), [0..9]);
        assert_eq!(subtract(vec![0..10, 12..15], &(3..5)), [0..3, 5..10, 12..15]);
        assert_eq!(subtract(vec![0..10, 12..15], &(-3..12)), [12..15]);
        assert_eq!(subtract(vec![0..10, 12..15], &(9..13)), [0..9, 13..15]);
        assert_eq!(subtract(vec![0..10], &(10..13)), [0..10]);
    }

    #[test]
    fn a_union_spans_its_parts_and_no_empty_ones() {
        let cube = |from: i64, to: i64| RowShape::Box([from..to, from..to, from..to]);
        let both = RowShape::Union(vec![cube(0, 3), cube(90, 90), cube(5, 7)]);
        assert_eq!(both.span(), [0..7, 0..7]);
        assert_eq!(both.runs(1, 1), [0..3]);
        assert_eq!((both.runs(1, 6), both.runs(6, 6)), (vec![], vec![5..7]));
    }
}
