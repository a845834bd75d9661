//! The sides of an object on which a sensor can be mounted, and a grid of places on each of them.
//!
//! A side is a connected part of the surface that faces one of six ways more than the others: along x, y or z of the
//! object's own frame, forwards or backwards. A box has six, a cylinder has its two ends and four quarters of its round
//! side, and each post of a fence has its own. Places are where lines of a grid across that way meet the side, so they
//! are on the surface, whatever its outline.

use std::collections::{BTreeMap, HashMap};

use glam::DVec3;

use super::Mesh;
use perirobot_march::error::Issue;

/// A side that is narrower is no place for a sensor.
pub const NARROWEST_M: f64 = 0.02;
/// Hits of a line that are nearer to each other are one: at an edge that two triangles share.
const SAME_M: f64 = 1e-6;
/// Lengths and shares that differ by less are the same.
const NEARLY: f64 = 1e-9;

/// The grid of places on a side.
#[derive(Clone, Copy, Debug)]
pub struct SideGrid {
    /// The distance between neighbouring places, seen along the way that the side faces.
    pub spacing_m: f64,
    /// The least distance to the ends of the side; half of `spacing_m` if it is not given. A side that is narrower than
    /// twice that has one row of places, in its middle.
    pub margin_m: Option<f64>,
    /// The most places of an object.
    pub most: usize,
}

/// One side of an object.
#[derive(Clone, Debug, PartialEq)]
pub struct Side {
    /// The way that it faces: 0 to 5 for −x, +x, −y, +y, −z and +z.
    pub way: usize,
    /// Its places, by the lower of the two axes across the way, then by the other.
    pub places: Vec<SidePlace>,
    /// Whether it is flat, at a right angle to the way, and has a place on each line of the grid.
    pub is_flat: bool,
}

/// A place on a side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SidePlace {
    /// Where it is on the surface.
    pub at_m: DVec3,
    /// The direction away from the surface, of length 1.
    pub normal: DVec3,
}

impl Mesh {
    /// The sides of a surface, by their ways, and within one in the order of their first triangles.
    ///
    /// # Errors
    /// When they have more places than the grid allows.
    pub fn sides(&self, grid: &SideGrid) -> Result<Vec<Side>, Issue> {
        let mut left = grid.most;
        let mut sides = Vec::new();
        for Part { way, triangles } in self.parts() {
            let side = self.side(way, &triangles, grid, left)?;
            left -= side.places.len();
            sides.push(side);
        }
        Ok(sides)
    }

    /// The parts of the surface that face one way and hang together.
    fn parts(&self) -> Vec<Part> {
        let mut corners: HashMap<(usize, [u64; 3]), usize> = HashMap::new();
        let mut joined = Joined::default();
        let mut placed = Vec::new();
        for (number, triangle) in self.triangles.iter().enumerate() {
            let points = triangle.map(|corner| self.vertices[corner as usize]);
            let Some(way) = way(normal(points)) else { continue };
            let own = points.map(|point| {
                // -0.0 + 0.0 is 0.0.
                let key = (way, (point + DVec3::ZERO).to_array().map(f64::to_bits));
                *corners.entry(key).or_insert_with(|| joined.add())
            });
            joined.join(own[0], own[1]);
            joined.join(own[0], own[2]);
            placed.push((number, way, own[0]));
        }
        // A part is at the number of its first triangle.
        let mut firsts: HashMap<usize, usize> = HashMap::new();
        let mut parts: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
        for (number, way, corner) in placed {
            let first = *firsts.entry(joined.root(corner)).or_insert(number);
            parts.entry((way, first)).or_default().push(number);
        }
        parts.into_iter().map(|((way, _), triangles)| Part { way, triangles }).collect()
    }

    /// The places on a part of the surface.
    fn side(&self, way: usize, triangles: &[usize], grid: &SideGrid, most: usize) -> Result<Side, Issue> {
        let across = way / 2;
        let axes = [[1, 2], [0, 2], [0, 1]][across];
        let corners = |triangle: usize| self.triangles[triangle].map(|corner| self.vertices[corner as usize]);
        let ends = axes.map(|axis| {
            let all = triangles.iter().flat_map(|&triangle| corners(triangle).map(|corner| corner[axis]));
            all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)])
        });
        let no_places = Side { way, places: Vec::new(), is_flat: false };
        if ends.iter().any(|[low, high]| high - low < NARROWEST_M - NEARLY) {
            return Ok(no_places);
        }
        let counts = ends.map(|ends| grid.count(ends));
        if counts[0] * counts[1] > most as f64 {
            return Err(Issue::too_large("has more places than a study can have poses")
                .with_advice("widen spacing_m, or name fewer sides"));
        }
        let lines: [Vec<f64>; 2] = std::array::from_fn(|n| grid.lines(ends[n], counts[n]));
        let mut hits: BTreeMap<[usize; 2], Vec<(f64, DVec3)>> = BTreeMap::new();
        for points in triangles.iter().map(|&triangle| corners(triangle)) {
            let flat = points.map(|point| axes.map(|axis| point[axis]));
            let normal = normal(points).normalize();
            let spans: [std::ops::Range<usize>; 2] = std::array::from_fn(|n| {
                let own = flat.map(|point| point[n]);
                let (low, high) = (own[0].min(own[1]).min(own[2]), own[0].max(own[1]).max(own[2]));
                let before = |end: f64| lines[n].partition_point(|line| *line < end);
                before(low - NEARLY)..before(high + NEARLY)
            });
            for first in spans[0].clone() {
                for second in spans[1].clone() {
                    let shares = shares(flat, [lines[0][first], lines[1][second]]);
                    if shares.iter().all(|share| *share >= -NEARLY) {
                        let at = (0..3).map(|n| shares[n] * points[n][across]).sum();
                        hits.entry([first, second]).or_default().push((at, normal));
                    }
                }
            }
        }
        let mut places = Vec::new();
        for ([first, second], mut met) in hits {
            met.sort_by(|(a, _), (b, _)| a.total_cmp(b));
            for same in met.chunk_by(|(a, _), (b, _)| b - a < SAME_M) {
                let mut at_m = DVec3::ZERO;
                (at_m[axes[0]], at_m[axes[1]], at_m[across]) = (lines[0][first], lines[1][second], same[0].0);
                let normal = same.iter().map(|(_, normal)| *normal).sum::<DVec3>().normalize();
                places.push(SidePlace { at_m, normal });
            }
        }
        if places.len() > most {
            return Err(Issue::too_large("has more places than a study can have poses")
                .with_advice("widen spacing_m, or name fewer sides"));
        }
        let first = places.first().map_or(0.0, |place| place.at_m[across]);
        let is_even = places.iter().all(|place| {
            (place.at_m[across] - first).abs() < SAME_M && 1.0 - place.normal[across].abs() < NEARLY
        });
        let is_flat = is_even && places.len() == lines[0].len() * lines[1].len();
        Ok(Side { places, is_flat, ..no_places })
    }
}

/// The inside of a closed surface that faces outwards; the walls of a room enclose nothing.
pub struct Enclosed<'a> {
    mesh: &'a Mesh,
    /// The ends of the mesh across the lines that are followed, and the triangles of each strip between them.
    ends: [f64; 2],
    strips: Vec<Vec<u32>>,
}

/// The direction of a line that meets no edge of a drawn body, and one across it.
const ALONG: DVec3 = DVec3::new(0.301_511_3, 0.418_121_0, 0.856_873_9);
const ACROSS: DVec3 = DVec3::new(0.856_873_9, 0.0, -0.301_511_3);
/// Strips of a large mesh.
const STRIPS: usize = 1024;

impl<'a> Enclosed<'a> {
    /// Sorts the triangles, so that a point is asked of few.
    pub fn new(mesh: &'a Mesh) -> Enclosed<'a> {
        let all = mesh.vertices.iter().map(|vertex| vertex.dot(ACROSS));
        let ends = all.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], v| [low.min(v), high.max(v)]);
        let mut enclosed = Enclosed { mesh, ends, strips: vec![Vec::new(); STRIPS] };
        for (number, triangle) in (0..).zip(&mesh.triangles) {
            let strips = triangle.map(|corner| enclosed.strip(mesh.vertices[corner as usize]));
            let (low, high) =
                (strips[0].min(strips[1]).min(strips[2]), strips[0].max(strips[1]).max(strips[2]));
            enclosed.strips[low..=high].iter_mut().for_each(|strip| strip.push(number));
        }
        enclosed
    }

    /// Whether a point is inside.
    pub fn contains(&self, point: DVec3) -> bool {
        let crossings = self.strips[self.strip(point)].iter().map(|&number| {
            let triangle = self.mesh.triangles[number as usize];
            let [a, b, c] = triangle.map(|corner| self.mesh.vertices[corner as usize] - point);
            let volumes = [b.cross(c), c.cross(a), a.cross(b)].map(|area| area.dot(ALONG));
            let is_met = volumes.iter().all(|v| *v >= 0.0) || volumes.iter().all(|v| *v <= 0.0);
            let normal = normal([a, b, c]);
            let (facing, ahead) = (normal.dot(ALONG), normal.dot(a));
            match is_met && facing != 0.0 && ahead / facing > 0.0 {
                true => facing.signum() as i64,
                false => 0,
            }
        });
        crossings.sum::<i64>() > 0
    }

    /// The strip of a point; of one outside of all strips the nearest.
    fn strip(&self, point: DVec3) -> usize {
        let share = (point.dot(ACROSS) - self.ends[0]) / (self.ends[1] - self.ends[0]);
        ((share * STRIPS as f64) as usize).min(STRIPS - 1)
    }
}

/// Triangles that face one way and hang together, by their numbers.
struct Part {
    way: usize,
    triangles: Vec<usize>,
}

impl SideGrid {
    /// How many lines there are between two ends; a number of its own, as it may be huge.
    fn count(&self, [low, high]: [f64; 2]) -> f64 {
        let margin = self.margin_m.unwrap_or(self.spacing_m / 2.0).min((high - low) / 2.0);
        ((high - low - 2.0 * margin) / self.spacing_m + NEARLY).floor() + 1.0
    }

    /// The lines between two ends, about their middle.
    fn lines(&self, [low, high]: [f64; 2], count: f64) -> Vec<f64> {
        let first = (low + high) / 2.0 - (count - 1.0) / 2.0 * self.spacing_m;
        (0..count as usize).map(|line| first + line as f64 * self.spacing_m).collect()
    }
}

/// The normal of a triangle, twice as long as its area.
fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// The way that a normal faces most, the first axis of several; none for one without length.
fn way(normal: DVec3) -> Option<usize> {
    let size = normal.abs();
    let largest = size.max_element();
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    let axis = (0..3).find(|&axis| size[axis] >= largest * (1.0 - NEARLY))?;
    Some(2 * axis + usize::from(normal[axis] > 0.0))
}

/// The shares of three corners in a point: all are 0 or more inside of their triangle.
fn shares([a, b, c]: [[f64; 2]; 3], point: [f64; 2]) -> [f64; 3] {
    let area =
        |p: [f64; 2], q: [f64; 2], r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
    let whole = area(a, b, c);
    [area(b, c, point) / whole, area(c, a, point) / whole, area(a, b, point) / whole]
}

/// Numbers that are joined into sets.
#[derive(Default)]
struct Joined {
    above: Vec<usize>,
}

impl Joined {
    fn add(&mut self) -> usize {
        self.above.push(self.above.len());
        self.above.len() - 1
    }

    fn root(&mut self, mut number: usize) -> usize {
        while self.above[number] != number {
            self.above[number] = self.above[self.above[number]];
            number = self.above[number];
        }
        number
    }

    fn join(&mut self, one: usize, other: usize) {
        let (one, other) = (self.root(one), self.root(other));
        self.above[one.max(other)] = one.min(other);
    }
}

#[cfg(test)]
mod tests;
