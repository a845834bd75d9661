//! Columns over polygons, by the even-odd rule, and whether a polygon is one: what a protective field is
//! drawn with. Corners are [x, y] in 1/65536 voxel; the last is joined to the first.

use std::ops::Range;

use super::super::{BitGrid, Window};
use super::{centre_q16, centres_in, mark, passes};

/// Sets the voxels of some layers of z whose centre lies inside a polygon. Half-open: of two polygons with a
/// common edge at most one has a centre on it, and together they leave none out.
pub fn column(plane: &mut BitGrid, polygon_q16: &[[i64; 2]], layers: Range<i32>) {
    let window = plane.window();
    let layers = layers.start.max(window.min[2])..layers.end.min(window.end()[2]);
    if layers.is_empty() {
        return;
    }
    let [(x, width), (y, depth)] = [0, 1].map(|r| (window.min[r], window.size[r]));
    let mut layer = BitGrid::new(Window { min: [x, y, layers.start], size: [width, depth, 1] });
    for y in window.min[1]..window.end()[1] {
        let mut passed: Vec<i64> =
            edges(polygon_q16).filter_map(|(from, to)| passes(from, to, centre_q16(y as i64))).collect();
        passed.sort_unstable();
        for pair in passed.chunks_exact(2) {
            let run = centres_in(pair[0]..pair[1]);
            mark(&mut layer, &run, y as i64, layers.start.into());
        }
    }
    layers.for_each(|z| plane.add_layer(z, &layer));
}

/// Why corners do not bound one area.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotSimple {
    /// There are this many corners.
    #[error("{0} corners bound no area: give at least 3")]
    TooFew(usize),
    /// Two edges have more than a corner in common; edge i goes from corner i to the next.
    #[error(
        "the edges that begin at corners {0} and {1} (counted from 0) cross or touch: \
         go around the area once, and give each corner once"
    )]
    EdgesMeet(usize, usize),
}

/// Whether a polygon's edges meet only at the corners they share, so that it bounds one area.
///
/// # Errors
/// With the first two edges that meet elsewhere, or the number of corners if there are fewer than three.
pub fn is_simple(polygon_q16: &[[i64; 2]]) -> Result<(), NotSimple> {
    let count = polygon_q16.len();
    if count < 3 {
        return Err(NotSimple::TooFew(count));
    }
    for (i, first) in edges(polygon_q16).enumerate() {
        for (j, second) in edges(polygon_q16).enumerate().skip(i + 1) {
            let meet = if j == i + 1 {
                turns_back(first, second)
            } else if i == 0 && j == count - 1 {
                turns_back(second, first)
            } else {
                touch(first, second)
            };
            if meet {
                return Err(NotSimple::EdgesMeet(i, j));
            }
        }
    }
    Ok(())
}

type Edge = ([i64; 2], [i64; 2]);

fn edges(polygon: &[[i64; 2]]) -> impl Iterator<Item = Edge> + '_ {
    polygon.iter().copied().zip(polygon.iter().copied().cycle().skip(1))
}

/// Twice the area of a triangle, positive if it turns left.
fn area(a: [i64; 2], b: [i64; 2], c: [i64; 2]) -> i128 {
    let [p, q] = [b, c].map(|d| [0, 1].map(|r| (d[r] - a[r]) as i128));
    p[0] * q[1] - p[1] * q[0]
}

/// Whether an edge runs back over the one before it, or one of the two has no length.
fn turns_back((a, b): Edge, (_, c): Edge) -> bool {
    let forward: i128 = (0..2).map(|r| (b[r] - a[r]) as i128 * (c[r] - b[r]) as i128).sum();
    area(a, b, c) == 0 && forward <= 0
}

/// Whether two closed edges have a point in common.
fn touch((a, b): Edge, (c, d): Edge) -> bool {
    let apart = |r: usize| a[r].max(b[r]) < c[r].min(d[r]) || c[r].max(d[r]) < a[r].min(b[r]);
    let one_side = |p, q, r, s| area(p, q, r).signum() * area(p, q, s).signum() > 0;
    !apart(0) && !apart(1) && !one_side(a, b, c, d) && !one_side(c, d, a, b)
}
