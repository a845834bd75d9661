//! Which voxels a triangle intersects, decided in integers: a separating-axis test of a closed triangle
//! against closed boxes. Lengths here count 1/512 voxel from the world's origin.

use std::collections::HashMap;

use glam::DVec3;

use super::grid::{FARTHEST_VOXEL, Window};

/// One voxel in the unit of this file.
pub const VOXEL: i64 = 512;

/// A corner in 1/512 voxels.
pub type Corner = [i64; 3];

/// A world position rounded to 1/256 voxel and moved by 1/512, so that no corner lies on a voxel's boundary:
/// a wall on a boundary fills the upper layer, once. `None` beyond [`FARTHEST_VOXEL`], where products would
/// overflow.
pub fn corner(metres: DVec3, voxel_size_m: f64) -> Option<Corner> {
    let scaled = metres.to_array().map(|x| (x / voxel_size_m * 256.0).round());
    let farthest = (FARTHEST_VOXEL * 256) as f64;
    scaled.iter().all(|x| x.abs() < farthest).then(|| scaled.map(|x| 2 * x as i64 + 1))
}

/// The voxel that holds a corner, as a world key.
pub(crate) fn key_of(corner: Corner) -> [i32; 3] {
    corner.map(|x| x.div_euclid(VOXEL) as i32)
}

/// The world keys of all voxels that hold a corner, from the lowest to the highest, both included.
pub fn extent<'a>(corners: impl IntoIterator<Item = &'a Corner>) -> Window {
    corners
        .into_iter()
        .map(|&c| Window::from_corners(key_of(c), key_of(c)))
        .fold(Window::from_corners([0; 3], [-1; 3]), |all, one| all.union(&one))
}

/// Whether a surface has an inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closure {
    /// Each edge, corners welded on the lattice, is walked equally often in both directions.
    Closed,
    /// Each edge has two sides, or several pairs of them, but some faces are turned inside out.
    Turned,
    /// An edge has a side without another one, or there is no edge.
    Open,
}

impl Closure {
    /// What a surface that is not closed is, in words; nothing of a closed one.
    pub fn describe(self) -> Option<&'static str> {
        match self {
            Closure::Closed => None,
            Closure::Turned => Some(
                "is not watertight (some of its faces are turned inside out: turn all outwards, in Blender by Mesh > \
                 Normals > Recalculate Outside)",
            ),
            Closure::Open => Some("is not watertight (an edge has only one side)"),
        }
    }
}

/// Whether a surface is closed.
pub fn closure(triangles: impl IntoIterator<Item = [Corner; 3]>) -> Closure {
    // How often an edge is walked one way less the other, and how often at all.
    let mut walked: HashMap<(Corner, Corner), [i64; 2]> = HashMap::new();
    for corners in triangles {
        for e in 0..3 {
            let (from, to) = (corners[e], corners[(e + 1) % 3]);
            let (edge, way) = match from.cmp(&to) {
                std::cmp::Ordering::Less => ((from, to), 1),
                std::cmp::Ordering::Greater => ((to, from), -1),
                std::cmp::Ordering::Equal => continue,
            };
            let [balance, times] = walked.entry(edge).or_default();
            *balance += way;
            *times += 1;
        }
    }
    match () {
        () if walked.is_empty() || walked.values().any(|[_, times]| times % 2 == 1) => Closure::Open,
        () if walked.values().any(|[balance, _]| *balance != 0) => Closure::Turned,
        () => Closure::Closed,
    }
}

/// Calls `emit` with the world key of every voxel of `window` that the triangle meets.
pub fn triangle_voxels(triangle: &[Corner; 3], window: &Window, mut emit: impl FnMut([i32; 3])) {
    let bounds = extent(triangle).intersection(window);
    if bounds.is_empty() {
        return;
    }
    let (min, end) = (bounds.min, bounds.end());
    let normal = normal(triangle);
    // Columns run along the axis that the triangle faces most, so that a column meets few voxels.
    let w = (0..3).max_by_key(|&r| (normal[r].unsigned_abs(), std::cmp::Reverse(r))).unwrap_or(0);
    let (u, v) = ((w + 1) % 3, (w + 2) % 3);
    let [across, side_u, side_v] = [(u, v), (v, w), (w, u)].map(|(a, b)| EdgeTest::three(triangle, a, b));
    for cv in min[v]..end[v] {
        for cu in min[u]..end[u] {
            if !across.iter().all(|test| test.intersects(cu, cv)) {
                continue;
            }
            let (low, high) =
                plane_range(triangle, normal, [u, v, w], [cu, cv]).unwrap_or((min[w], end[w] - 1));
            for cw in low.max(min[w])..=high.min(end[w] - 1) {
                if side_u.iter().all(|test| test.intersects(cv, cw))
                    && side_v.iter().all(|test| test.intersects(cw, cu))
                {
                    let mut key = [0; 3];
                    (key[u], key[v], key[w]) = (cu, cv, cw);
                    emit(key);
                }
            }
        }
    }
}

/// The triangle's normal; zero if it is degenerate. Components stay below 2⁶².
fn normal([a, b, c]: &[Corner; 3]) -> [i64; 3] {
    let (p, q): ([i64; 3], [i64; 3]) =
        (std::array::from_fn(|r| b[r] - a[r]), std::array::from_fn(|r| c[r] - a[r]));
    std::array::from_fn(|r| {
        let (s, t) = ((r + 1) % 3, (r + 2) % 3);
        p[s] * q[t] - p[t] * q[s]
    })
}

/// The voxels of a column that the triangle's plane meets, lowest and highest; `None` for a degenerate
/// triangle, which has no plane to separate by.
fn plane_range(
    triangle: &[Corner; 3],
    normal: [i64; 3],
    [u, v, w]: [usize; 3],
    voxel: [i32; 2],
) -> Option<(i32, i32)> {
    if normal[w] == 0 {
        return None;
    }
    // The plane is n · p = level; make the column's component positive.
    let sign = normal[w].signum() as i128;
    let n = normal.map(|c| c as i128 * sign);
    let level: i128 = (0..3).map(|r| n[r] * triangle[0][r] as i128).sum();
    let (mut least, mut most) = (0, 0);
    for (axis, c) in [(u, voxel[0]), (v, voxel[1])] {
        let (low, high) =
            (n[axis] * (c as i128 * VOXEL as i128), n[axis] * ((c as i128 + 1) * VOXEL as i128));
        least += low.min(high);
        most += low.max(high);
    }
    // A voxel c of the column spans n·512·c … n·512·(c + 1) beside [least, most].
    let voxel = n[w] * VOXEL as i128;
    let high = (level - least).div_euclid(voxel);
    let low = -(most - level).div_euclid(voxel) - 1;
    let clamp = |x: i128| x.clamp(i32::MIN as i128 / 2, i32::MAX as i128 / 2) as i32;
    Some((clamp(low), clamp(high)))
}

/// Whether a line across an edge, in one of the three projections, separates triangle and box.
struct EdgeTest {
    /// The axis to project on.
    axis: [i64; 2],
    /// The triangle's interval on it.
    least: i64,
    most: i64,
    /// A box's extent below and above its lower corner.
    below: i64,
    above: i64,
}

impl EdgeTest {
    /// The tests of the triangle's three edges, seen along the third axis.
    fn three(triangle: &[Corner; 3], a: usize, b: usize) -> [EdgeTest; 3] {
        std::array::from_fn(|e| {
            let (from, to) = (triangle[e], triangle[(e + 1) % 3]);
            let axis = [from[b] - to[b], to[a] - from[a]];
            let at = triangle.map(|p| axis[0] * p[a] + axis[1] * p[b]);
            let reach = axis.map(|x| x * VOXEL);
            EdgeTest {
                axis,
                least: at[0].min(at[1]).min(at[2]),
                most: at[0].max(at[1]).max(at[2]),
                below: reach[0].min(0) + reach[1].min(0),
                above: reach[0].max(0) + reach[1].max(0),
            }
        })
    }

    fn intersects(&self, ca: i32, cb: i32) -> bool {
        let corner = self.axis[0] * (ca as i64 * VOXEL) + self.axis[1] * (cb as i64 * VOXEL);
        corner + self.above >= self.least && corner + self.below <= self.most
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    fn voxels(triangle: &[Corner; 3]) -> BTreeSet<[i32; 3]> {
        let mut set = BTreeSet::new();
        triangle_voxels(triangle, &Window::from_corners([-99; 3], [99; 3]), |key| assert!(set.insert(key)));
        set
    }

    /// The same decision by clipping: the triangle is cut by the six half-spaces of a box, in rationals
    /// scaled so that they stay exact. It is slow, and another method than separating axes.
    fn intersects_by_clipping(triangle: &[Corner; 3], key: [i32; 3]) -> bool {
        // Homogeneous points: position = p / w, w > 0.
        let mut polygon: Vec<([i128; 3], i128)> =
            triangle.iter().map(|p| (p.map(|x| x as i128), 1)).collect();
        for r in 0..3 {
            for (bound, side) in [(key[r] as i128 * 512, 1), ((key[r] as i128 + 1) * 512, -1)] {
                let inside = |&(p, w): &([i128; 3], i128)| side * (p[r] - bound * w);
                let mut kept = Vec::new();
                for i in 0..polygon.len() {
                    let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
                    let (da, db) = (inside(&a), inside(&b));
                    if da >= 0 {
                        kept.push(a);
                    }
                    if (da > 0 && db < 0) || (da < 0 && db > 0) {
                        // a + (b − a) · da/(da − db), in homogeneous form.
                        let (s, t) = (db.abs(), da.abs());
                        let p: [i128; 3] = std::array::from_fn(|k| a.0[k] * s + b.0[k] * t);
                        let w = a.1 * s + b.1 * t;
                        let g = p.iter().fold(w, |g, &x| gcd(g, x.abs()));
                        kept.push((p.map(|x| x / g), w / g));
                    }
                }
                polygon = kept;
            }
        }
        !polygon.is_empty()
    }

    fn gcd(a: i128, b: i128) -> i128 {
        if b == 0 { a } else { gcd(b, a % b) }
    }

    #[test]
    fn separating_axes_agree_with_clipping() {
        let mut state = 7u32;
        let mut random = |below: i64| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as i64 % below
        };
        let mut met = 0;
        for case in 0..400 {
            // Large, small, flat and degenerate triangles, corners odd as the rounding makes them.
            let reach = [4000, 700, 3000, 1500][case % 4];
            let mut triangle: [Corner; 3] =
                std::array::from_fn(|_| std::array::from_fn(|_| 2 * random(reach) - reach + 1));
            match case % 8 {
                2 => triangle.iter_mut().for_each(|p| p[1] = 513),
                3 => triangle[2] = triangle[0],
                6 => triangle[2] = std::array::from_fn(|r| (triangle[0][r] + triangle[1][r]) / 2),
                _ => {}
            }
            let found = voxels(&triangle);
            met += found.len();
            let around = extent(&triangle);
            let (min, end) = (around.min, around.end());
            for x in min[0]..end[0] {
                for y in min[1]..end[1] {
                    for z in min[2]..end[2] {
                        let expected = intersects_by_clipping(&triangle, [x, y, z]);
                        assert_eq!(
                            found.contains(&[x, y, z]),
                            expected,
                            "case {case}: {triangle:?} at {x} {y} {z}"
                        );
                    }
                }
            }
        }
        assert!(met > 5000, "the cases are not empty: {met} voxels");
    }

    #[test]
    fn a_wall_on_a_boundary_fills_the_upper_layer_once() {
        let at = |x: f64, y: f64, z: f64| corner(DVec3::new(x, y, z), 0.05).unwrap();
        let found = voxels(&[at(0.1, 0.0, 0.0), at(0.1, 0.5, 0.0), at(0.1, 0.0, 0.5)]);
        assert!(found.iter().all(|key| key[0] == 2), "x = 0.1 m at 5 cm is voxel 2 only");
        let below = voxels(&[at(-0.1, 0.0, 0.0), at(-0.1, 0.5, 0.0), at(-0.1, 0.0, 0.5)]);
        assert!(below.iter().all(|key| key[0] == -2));
    }

    #[test]
    fn farther_than_the_farthest_is_refused() {
        assert!(corner(DVec3::new(1e9, 0.0, 0.0), 0.05).is_none());
        assert!(corner(DVec3::new(50_000.0, 0.0, 0.0), 0.05).is_some());
    }
}
