//! A body in voxels: what it covers at a place, and at which places it covers few enough voxels of a set.
//!
//! # Practice
//! Sizes are whole voxels, rounded, and at least one. A round body contains the voxels whose centre is
//! closer to its middle than half its diameter. A body on the floor begins with the layer above that of the floor and
//! ends below its height above the floor: it has only whole layers, at least one. It is stored as bars, boxes one voxel
//! deep along y, so that the voxels of a set in a body are a few differences of running sums, all integers.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;

use perirobot_march::error::Issue;
use perirobot_march::voxel::{BitGrid, Grid, Window};
use perirobot_study::input::{BodyShape, BodySpec};

/// A body that moves without turning. Its place is the lowest corner of the box around it.
#[derive(Clone, Debug)]
pub struct Body {
    /// Its name in the study.
    pub name: String,
    /// Whether it stands on the floor.
    pub on_floor: bool,
    /// Of how many of its voxels must be watched for it to be noticed.
    pub min_voxels: u32,
    /// How many layers it climbs up or down in a step, if it walks on what carries it; `None` if the floor has one height, or
    /// it does not stand on it.
    pub climbs: Option<u32>,
    /// The box around it.
    pub size: [u32; 3],
    bars: Vec<BodyBar>,
}

/// Voxels of a body at one y.
#[derive(Clone, Debug, PartialEq, Eq)]
struct BodyBar {
    xs: Range<u32>,
    y: u32,
    zs: Range<u32>,
}

impl Body {
    /// A body of a study that has places in a grid; `layers` are those that one on the floor may fill ([`standing`]).
    ///
    /// # Errors
    /// One that is smaller than what must be watched of it, which nothing could ever notice.
    pub fn new(spec: &BodySpec, voxel_size_m: f64, layers: Option<&Range<i32>>) -> Result<Body, Issue> {
        let size = size(spec.shape, voxel_size_m, layers);
        let [n, depth, height] = size;
        let bars: Vec<BodyBar> = match spec.shape {
            BodyShape::Cylinder { .. } => {
                (0..n).map(|y| BodyBar { xs: chord(n, &[y]), y, zs: 0..height }).collect()
            }
            BodyShape::Box { .. } => (0..depth).map(|y| BodyBar { xs: 0..n, y, zs: 0..height }).collect(),
            BodyShape::Ball { .. } => {
                let rows = (0..n).flat_map(|y| (0..height).map(move |z| [y, z]));
                rows.map(|[y, z]| BodyBar { xs: chord(n, &[y, z]), y, zs: z..z + 1 }).collect()
            }
        };
        let bars: Vec<BodyBar> = bars.into_iter().filter(|bar| !bar.xs.is_empty()).collect();
        let body = Body {
            name: spec.name.clone(),
            on_floor: spec.on_floor,
            min_voxels: spec.min_voxels,
            climbs: None,
            size,
            bars,
        };
        let count = body.count();
        if count < u64::from(spec.min_voxels) {
            let what = format!(
                "has {count} voxels of {voxel_size_m} m, and is noticed where {} of them are watched, so never",
                spec.min_voxels
            );
            return Err(Issue::says(what)
                .with_advice(format!("take smaller voxels, or give it min_voxels = {count} or less")));
        }
        Ok(body)
    }

    /// How many voxels it has.
    pub(super) fn count(&self) -> u64 {
        let voxels = |bar: &BodyBar| (bar.xs.len() * bar.zs.len()) as u64;
        self.bars.iter().map(voxels).sum()
    }

    /// Its voxels at a place.
    pub fn voxels(&self, [x, y, z]: [i32; 3]) -> impl Iterator<Item = [i32; 3]> + '_ {
        self.bars.iter().flat_map(move |bar| {
            let row =
                move |k: u32| bar.xs.clone().map(move |i| [x + i as i32, y + bar.y as i32, z + k as i32]);
            bar.zs.clone().flat_map(row)
        })
    }

    /// Those of some places at which it covers at most so many voxels of a set over the grid.
    pub(super) fn covers_at_most(&self, most: u32, sums: &Sums, places: Window) -> BitGrid {
        places_where(places, |place| self.sum(sums, place) <= most)
    }

    /// Those of some places at which a voxel of a set over the grid is right below it. A grid begins with layer 0.
    pub(super) fn rests_on(&self, sums: &Sums, places: Window) -> BitGrid {
        let soles = self.soles();
        let below = |[x, y, z]: [i32; 3]| soles.iter().any(|bar| sums.count_bar(bar, [x, y, z - 1]) > 0);
        places_where(places, |place| place[2] > 0 && below(place))
    }

    /// The lowest voxel of each column of the body.
    fn soles(&self) -> Vec<BodyBar> {
        let soles = self.bars.iter().flat_map(|bar| {
            let is_below = |other: &&BodyBar| other.y == bar.y && other.zs.end == bar.zs.start;
            let below = self.bars.iter().find(is_below).map(|other| other.xs.clone());
            let sides = match below {
                Some(below) => [bar.xs.start..below.start, below.end..bar.xs.end],
                None => [bar.xs.clone(), 0..0],
            };
            let zs = bar.zs.start..bar.zs.start + 1;
            sides.into_iter().filter(|xs| !xs.is_empty()).map(move |xs| BodyBar {
                xs,
                y: bar.y,
                zs: zs.clone(),
            })
        });
        soles.collect()
    }

    /// The voxels right below it at a place.
    pub(super) fn voxels_below(&self, [x, y, z]: [i32; 3]) -> impl Iterator<Item = [i32; 3]> {
        let below = move |bar: BodyBar| {
            let (y, z) = (y + bar.y as i32, z + bar.zs.start as i32 - 1);
            bar.xs.map(move |i| [x + i as i32, y, z])
        };
        self.soles().into_iter().flat_map(below)
    }

    /// The sum of a number of each of its voxels at a place.
    pub(super) fn sum(&self, sums: &Sums, place: [i32; 3]) -> u32 {
        self.bars.iter().map(|bar| sums.count_bar(bar, place)).sum()
    }

    /// How far its voxels are at most from the one in its middle, in whole voxels, rounded up.
    pub(super) fn radius(&self) -> u32 {
        let half = self.size.map(|n| u64::from(n / 2 + 1));
        half.iter().map(|n| n * n).sum::<u64>().isqrt() as u32 + 1
    }

    /// The voxel in its middle, or beside it, at a place.
    pub(super) fn middle(&self, place: [i32; 3]) -> [i32; 3] {
        std::array::from_fn(|r| place[r] + self.size[r] as i32 / 2)
    }

    /// Its middle at a place, in world metres.
    pub(crate) fn middle_m(&self, place: [i32; 3], grid: &Grid) -> DVec3 {
        let half = DVec3::from_array(self.size.map(|n| f64::from(n) / 2.0 * grid.voxel_size_m));
        grid.corner_m(place) + half
    }
}

/// The layers that a body on the floor may fill: from the one above the floor's own, as pads have it, as far as they
/// are wholly below its height above the floor; at least one.
pub(super) fn standing(shape: BodyShape, floor_m: f64, grid: &Grid) -> Range<i32> {
    let height_m = match shape {
        BodyShape::Cylinder { height_m, .. } => height_m,
        BodyShape::Box { size_m: [_, _, height_m] } => height_m,
        BodyShape::Ball { diameter_m } => diameter_m,
    };
    // Saturates: no grid is as high.
    let layer = |z: f64| {
        let layer = grid.position_q16(DVec3::new(0.0, 0.0, z))[2] >> 16;
        i32::try_from(layer).unwrap_or(if layer < 0 { -1 << 30 } else { 1 << 30 })
    };
    let first = layer(floor_m) + 1;
    first..layer(floor_m + height_m).max(first + 1)
}

/// The box around a body of a shape, in voxels; `layers` are those that one on the floor may fill.
pub(super) fn size(shape: BodyShape, voxel_size_m: f64, layers: Option<&Range<i32>>) -> [u32; 3] {
    // Saturates: no grid is as large.
    let across = |metres: f64| (metres / voxel_size_m).round().max(1.0) as u32;
    let [x, y, z] = match shape {
        BodyShape::Cylinder { diameter_m, height_m } => [diameter_m, diameter_m, height_m].map(across),
        BodyShape::Box { size_m } => size_m.map(across),
        BodyShape::Ball { diameter_m } => [across(diameter_m); 3],
    };
    [x, y, layers.map_or(z, |layers| z.min(layers.len() as u32))]
}

/// The places of a body of some size in a grid, so that all of it lies inside; if it stands on a floor, those at
/// which its lowest layer is this one. Empty where there is none.
pub(super) fn places(size: [u32; 3], stands_in: Option<i32>, grid: &Grid) -> Window {
    let end = size.map(|n| i32::try_from(n).unwrap_or(i32::MAX));
    let max: [i32; 3] = std::array::from_fn(|r| grid.size[r] as i32 - end[r]);
    match stands_in {
        None => Window::from_corners([0; 3], max),
        Some(layer) if (0..=max[2]).contains(&layer) => {
            Window::from_corners([0, 0, layer], [max[0], max[1], layer])
        }
        Some(_) => Window::from_corners([0; 3], [-1; 3]),
    }
}

/// Those of some places that are so.
fn places_where(places: Window, is_so: impl Fn([i32; 3]) -> bool + Sync) -> BitGrid {
    let mut found = BitGrid::new(places);
    if places.is_empty() {
        return found;
    }
    let rows = found.words_per_row() as usize;
    let depth = places.size[1] as usize;
    found.words_mut().par_chunks_mut(rows).enumerate().for_each(|(row, words)| {
        let (y, z) = (places.min[1] + (row % depth) as i32, places.min[2] + (row / depth) as i32);
        for i in 0..places.size[0] as usize {
            let x = places.min[0] + i as i32;
            words[i / 32] |= u32::from(is_so([x, y, z])) << (i % 32);
        }
    });
    found
}

/// Which voxels of a row of a disc or a ball `n` voxels across lie in it; `others` are the row's other
/// coordinates.
fn chord(n: u32, others: &[u32]) -> Range<u32> {
    // In half voxels from the middle.
    let off = |i: u32| (2 * i64::from(i) - i64::from(n) + 1).pow(2);
    let aside: i64 = others.iter().map(|&i| off(i)).sum();
    let inside = |i: &u32| aside + off(*i) < i64::from(n).pow(2);
    let first = (0..n.div_ceil(2)).find(inside);
    first.map_or(0..0, |first| first..n - first)
}

/// Running sums of a set, or of a number of each voxel, along x and z, for each y by itself.
pub(super) struct Sums {
    window: Window,
    /// For each y, each z and one more, each x and one more.
    before: Vec<u32>,
}

impl Sums {
    pub(super) fn new(set: &BitGrid) -> Sums {
        Sums::from_counts(set.window(), |voxel| u32::from(set.get(voxel)))
    }

    /// The sums of a number of each voxel of a window; sums of one y stay below 2³².
    pub(super) fn from_counts(window: Window, count: impl Fn([i32; 3]) -> u32 + Sync) -> Sums {
        let [width, _, height] = window.size.map(|n| n as usize);
        let mut before = vec![0; (width + 1) * (height + 1) * window.size[1] as usize];
        before.par_chunks_mut((width + 1) * (height + 1)).enumerate().for_each(|(y, slice)| {
            let y = window.min[1] + y as i32;
            for k in 0..height {
                let (above, row) = slice[k * (width + 1)..][..2 * (width + 1)].split_at_mut(width + 1);
                let mut sum = 0;
                for i in 0..width {
                    sum += count([window.min[0] + i as i32, y, window.min[2] + k as i32]);
                    row[i + 1] = above[i + 1] + sum;
                }
            }
        });
        Sums { window, before }
    }

    /// The voxels of a set in a bar of a body at a place; the bar lies in the window.
    fn count_bar(&self, bar: &BodyBar, place: [i32; 3]) -> u32 {
        let [x, y, z]: [usize; 3] = std::array::from_fn(|r| (place[r] - self.window.min[r]) as usize);
        let [width, _, height] = self.window.size.map(|n| n as usize + 1);
        let slice = (y + bar.y as usize) * height;
        let at = |i: u32, k: u32| self.before[(slice + z + k as usize) * width + x + i as usize];
        at(bar.xs.end, bar.zs.end) + at(bar.xs.start, bar.zs.start)
            - at(bar.xs.start, bar.zs.end)
            - at(bar.xs.end, bar.zs.start)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use perirobot_march::march::pcg;

    /// A body of a shape, at voxels of a metre.
    pub(crate) fn body(shape: BodyShape, on_floor: bool, min_voxels: u32) -> Body {
        Body::new(&BodySpec { name: "it".into(), shape, on_floor, min_voxels }, 1.0, None).unwrap()
    }

    /// A plane with so many thousandths of its voxels set.
    pub(crate) fn scatter(window: Window, share: u32, seed: u32) -> BitGrid {
        let mut set = BitGrid::new(window);
        let all = BitGrid::full(window);
        let numbered = (0..).zip(all.voxels());
        numbered.filter(|(n, _)| pcg(seed ^ pcg(*n)) % 1000 < share).for_each(|(_, voxel)| set.set(voxel));
        set
    }

    #[test]
    fn round_bodies_hold_the_voxels_within_their_radius() {
        for n in 1..12 {
            let diameter_m = f64::from(n);
            let near = |i: i32, j: i32, k: i32| {
                let off = |i: i32| (f64::from(i) + 0.5 - diameter_m / 2.0).powi(2);
                off(i) + off(j) + off(k) < diameter_m * diameter_m / 4.0
            };
            let all = |depth: i32| {
                (0..n).flat_map(move |i| (0..n).flat_map(move |j| (0..depth).map(move |k| [i, j, k])))
            };
            let ball = body(BodyShape::Ball { diameter_m }, false, 1);
            let mut found: Vec<_> = ball.voxels([0; 3]).collect();
            found.sort();
            assert_eq!(found, all(n).filter(|&[i, j, k]| near(i, j, k)).collect::<Vec<_>>(), "a ball of {n}");
            let disc = body(BodyShape::Cylinder { diameter_m, height_m: 2.0 }, true, 1);
            let mut found: Vec<_> = disc.voxels([0; 3]).collect();
            found.sort();
            let flat = |i: i32, j: i32| {
                let off = |i: i32| (f64::from(i) + 0.5 - diameter_m / 2.0).powi(2);
                off(i) + off(j) < diameter_m * diameter_m / 4.0
            };
            assert_eq!(found, all(2).filter(|&[i, j, _]| flat(i, j)).collect::<Vec<_>>(), "a disc of {n}");
        }
    }

    #[test]
    fn what_a_body_covers_is_counted_voxel_by_voxel() {
        let grid = Grid { voxel_size_m: 1.0, origin: [0; 3], size: [37, 11, 9] };
        let shapes = [
            BodyShape::Cylinder { diameter_m: 4.0, height_m: 5.0 },
            BodyShape::Ball { diameter_m: 5.0 },
            BodyShape::Box { size_m: [3.0, 1.0, 2.0] },
        ];
        for (seed, shape) in (0..).zip(shapes) {
            for on_floor in [false, true] {
                let (body, set) = (body(shape, on_floor, 1), scatter(grid.window(), 100, seed));
                let places = places(body.size, on_floor.then_some(1), &grid);
                for most in [0, 2, 5] {
                    let found = body.covers_at_most(most, &Sums::new(&set), places);
                    assert!(!places.is_empty() && (found.count() > 0 || most == 0));
                    for place in BitGrid::full(places).voxels() {
                        let covered = body.voxels(place).filter(|&voxel| set.get(voxel)).count();
                        assert_eq!(found.get(place), covered <= most as usize, "{shape:?} at {place:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn places_lie_in_the_grid() {
        let grid = Grid { voxel_size_m: 1.0, origin: [0; 3], size: [5, 6, 7] };
        let ball = size(BodyShape::Ball { diameter_m: 5.0 }, 1.0, None);
        assert_eq!(places(ball, None, &grid), Window::from_corners([0; 3], [0, 1, 2]));
        let stands = |height_m, layer| {
            places(size(BodyShape::Cylinder { diameter_m: 2.0, height_m }, 1.0, None), Some(layer), &grid)
        };
        assert_eq!(stands(6.0, 1), Window::from_corners([0, 0, 1], [3, 4, 1]));
        assert!(stands(7.0, 1).is_empty() && stands(6.0, -1).is_empty() && stands(1e12, 0).is_empty());
    }

    #[test]
    fn a_body_on_the_floor_ends_below_its_height() {
        let grid = Grid { voxel_size_m: 0.05, origin: [0, 0, -4], size: [20, 20, 60] };
        let of =
            |height_m, floor_m| standing(BodyShape::Cylinder { diameter_m: 0.4, height_m }, floor_m, &grid);
        // The floor is in layer 4, and the top at 40: 1.8 m are 36 layers, and the body begins one above the floor.
        assert_eq!(of(1.8, 0.0), 5..40);
        assert_eq!(of(1.849, 0.0), 5..40);
        assert_eq!(of(1.85, 0.0), 5..41);
        // Just below and above the edges of a layer.
        assert_eq!(of(1.8, -0.001), 4..39);
        assert_eq!(of(1.8, 0.049), 5..40);
        assert_eq!(of(1.8, 0.05), 6..41);
        assert_eq!(of(0.02, 0.0), 5..6);
        let ball = BodySpec {
            name: "it".into(),
            shape: BodyShape::Ball { diameter_m: 0.4 },
            on_floor: true,
            min_voxels: 1,
        };
        let layers = standing(ball.shape, 0.0, &grid);
        let highest = |body: Body| body.voxels([0, 0, layers.start]).map(|[_, _, z]| z).max();
        assert_eq!(highest(Body::new(&ball, 0.05, Some(&layers)).unwrap()), Some(11));
    }

    #[test]
    fn a_body_too_small_to_be_noticed_is_refused() {
        let spec = |min_voxels| BodySpec {
            name: "finger".into(),
            shape: BodyShape::Ball { diameter_m: 0.02 },
            on_floor: false,
            min_voxels,
        };
        let error = Body::new(&spec(3), 0.05, None).unwrap_err().to_string();
        assert!(error.contains("has 1 voxels of 0.05 m") && error.contains("min_voxels = 1"), "{error}");
        assert!(Body::new(&spec(1), 0.05, None).is_ok() && Body::new(&spec(3), 0.005, None).is_ok());
    }
}
