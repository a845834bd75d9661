//! How far each voxel is from the nearest of a set: the exact Euclidean distance, squared, in whole voxels.
//!
//! # Theory
//! The distance transform of Meijster, Roerdink and Hesselink (2000), which is the lower envelope of parabolas
//! of Felzenszwalb and Huttenlocher (2012) in whole numbers: one axis after the other, each row by itself, in
//! time that grows with the voxels alone.

use rayon::prelude::*;

use super::{BitGrid, Window};

/// No voxel of the set is known yet. Squares of distances on a grid stay below 3 · 1023².
const FAR: u32 = u32::MAX;

/// A distance in metres as the least whole squared distance between centres of voxels that is not below it. Lengths
/// become whole nanometres first, the distance rounded up and the voxel down, so that all that rounds makes it
/// larger; a thousandth of one is passed over, which is what is left of sums of decimal fractions.
pub fn squared_voxels(metres: f64, voxel_size_m: f64) -> u32 {
    let nanometres = (metres * 1e9 - 1e-3).ceil().max(0.0) as u128;
    let voxel = ((voxel_size_m * 1e9 + 1e-3).floor() as u128).max(1);
    // Saturates below what is not known: no grid is as large.
    u32::try_from((nanometres * nanometres).div_ceil(voxel * voxel)).unwrap_or(FAR).min(FAR - 1)
}

/// By how many metres the gap between surfaces may be less than a distance between voxels of bodies: the diagonal of a voxel,
/// and half a voxel by which a size is rounded; rounded up to centimetres.
pub fn gap_error_m(voxel_size_m: f64) -> f64 {
    ((3f64.sqrt() + 0.5) * voxel_size_m * 100.0).ceil() / 100.0
}

/// Metres with so many digits behind the point, rounded down: for distances that there are. A millionth of the last
/// digit is passed over, which is what is left of sums and roots of decimal fractions.
pub fn rounded_down(metres: f64, digits: u32) -> String {
    round(metres, digits, |scaled| (scaled + 1e-6).floor())
}

/// Metres with so many digits behind the point, rounded up, alike: for distances that are needed.
pub fn rounded_up(metres: f64, digits: u32) -> String {
    round(metres, digits, |scaled| (scaled - 1e-6).ceil())
}

fn round(metres: f64, digits: u32, whole: impl Fn(f64) -> f64) -> String {
    let scale = 10f64.powi(digits as i32);
    // Not −0.
    format!("{:.*}", digits as usize, whole(metres * scale) / scale + 0.0)
}

/// Squared distances over a window.
#[derive(Clone, Debug)]
pub struct Distances {
    window: Window,
    /// For each y, each z, each x.
    squared: Vec<u32>,
}

impl Distances {
    /// From the voxels of a set, which has at least one, over its window.
    pub fn from_set(set: &BitGrid) -> Distances {
        let window = set.window();
        let [width, depth, height] = window.size.map(|n| n as usize);
        let mut squared = vec![FAR; width * depth * height];
        // Along x and z in each slice of y, which lies together; then across the slices.
        squared.par_chunks_mut((width * height).max(1)).enumerate().for_each(|(y, slice)| {
            let y = window.min[1] + y as i32;
            let mut row = Envelope::new(width.max(height));
            for (line, z) in slice.chunks_mut(width).zip(window.min[2]..) {
                for (squared, x) in line.iter_mut().zip(window.min[0]..) {
                    *squared = if set.get([x, y, z]) { 0 } else { FAR };
                }
                row.lower(line, 0, 1, width);
            }
            for x in 0..width {
                row.lower(slice, x, width, height);
            }
        });
        // Each layer of z is put together from the slices and taken apart again.
        let layers: Vec<Vec<u32>> = (0..height)
            .into_par_iter()
            .map(|z| {
                let mut row = Envelope::new(depth);
                let at = |y: usize| (y * height + z) * width;
                let mut layer: Vec<u32> =
                    (0..depth).flat_map(|y| squared[at(y)..at(y) + width].iter().copied()).collect();
                for x in 0..width {
                    row.lower(&mut layer, x, width, depth);
                }
                layer
            })
            .collect();
        squared.par_chunks_mut((width * height).max(1)).enumerate().for_each(|(y, slice)| {
            for (line, layer) in slice.chunks_mut(width).zip(&layers) {
                line.copy_from_slice(&layer[y * width..][..width]);
            }
        });
        Distances { window, squared }
    }

    /// From a voxel of the window, between centres.
    pub fn squared_distance(&self, voxel: [i32; 3]) -> u32 {
        let [x, y, z]: [usize; 3] = std::array::from_fn(|r| (voxel[r] - self.window.min[r]) as usize);
        self.squared[(y * self.window.size[2] as usize + z) * self.window.size[0] as usize + x]
    }

    /// The voxels that are no farther than this.
    pub fn voxels_within(&self, squared: u32) -> BitGrid {
        let mut found = BitGrid::new(self.window);
        let [width, _, height] = self.window.size.map(|n| n as usize);
        for (number, line) in self.squared.chunks(width.max(1)).enumerate() {
            let (y, z) = (
                self.window.min[1] + (number / height) as i32,
                self.window.min[2] + (number % height) as i32,
            );
            let near = line.iter().zip(self.window.min[0]..).filter(|(own, _)| **own <= squared);
            near.for_each(|(_, x)| found.set([x, y, z]));
        }
        found
    }

    /// The farthest that a voxel of the window is away.
    pub fn farthest(&self) -> u32 {
        self.squared.iter().copied().max().unwrap_or(0)
    }

    /// The least distance of any voxel of another set, if one is in the window.
    pub fn least(&self, others: &BitGrid) -> Option<u32> {
        others
            .voxels()
            .filter(|&voxel| self.window.contains(voxel))
            .map(|voxel| self.squared_distance(voxel))
            .min()
    }
}

/// The lower envelope of the parabolas over one row, kept between rows for its memory.
struct Envelope {
    /// The row as it was.
    before: Vec<u32>,
    /// Where the parabolas of the envelope have their lowest point.
    lowest: Vec<usize>,
    /// From which place on each is the lowest.
    from: Vec<i64>,
}

impl Envelope {
    fn new(longest: usize) -> Self {
        Envelope {
            before: Vec::with_capacity(longest),
            lowest: Vec::with_capacity(longest),
            from: Vec::with_capacity(longest),
        }
    }

    /// Turns the squared distances of one row, every `step` from `begin` on, into those with this axis, too.
    fn lower(&mut self, values: &mut [u32], begin: usize, step: usize, count: usize) {
        self.before.clear();
        self.before.extend((0..count).map(|i| values[begin + i * step]));
        self.lowest.clear();
        self.from.clear();
        let known = |i: &usize| self.before[*i] != FAR;
        for place in (0..count).filter(known) {
            let height = |at: usize| i64::from(self.before[at]) + (at * at) as i64;
            // The first place at which this parabola is lower than the last of the envelope.
            let mut from = 0;
            while let (Some(&last), Some(&begins)) = (self.lowest.last(), self.from.last()) {
                from = (height(place) - height(last)).div_euclid(2 * (place - last) as i64) + 1;
                if from > begins {
                    break;
                }
                self.lowest.pop();
                self.from.pop();
                from = 0;
            }
            if from < count as i64 {
                self.lowest.push(place);
                self.from.push(from);
            }
        }
        let mut part = 0;
        for i in 0..count {
            while part + 1 < self.from.len() && self.from[part + 1] <= i as i64 {
                part += 1;
            }
            if let Some(&lowest) = self.lowest.get(part) {
                values[begin + i * step] = self.before[lowest] + lowest.abs_diff(i).pow(2) as u32;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::march::pcg;

    #[test]
    fn metres_are_rounded_up_once() {
        for (metres, voxel_size_m, expected) in [
            (0.0, 0.05, 0),
            (1.5, 0.05, 900),
            // 0.1 + 0.2 = 0.30000000000000004 in f64.
            (0.1 + 0.2, 0.1, 9),
            (1.5 + 1e-6, 0.05, 901),
            (1.5 - 1e-6, 0.05, 900),
            // 0.7 / 0.3 squared is 5.44.
            (0.7, 0.3, 6),
            (1e9, 1e-4, u32::MAX - 1),
        ] {
            assert_eq!(squared_voxels(metres, voxel_size_m), expected, "{metres} m at {voxel_size_m} m");
        }
    }

    #[test]
    fn what_there_is_is_rounded_down_and_what_is_needed_up() {
        for (metres, down, up) in [
            (0.29, "0.29", "0.29"),
            (21.0 * 0.05, "1.05", "1.05"),
            (441f64.sqrt() * 0.05, "1.05", "1.05"),
            (0.3 - 0.2, "0.10", "0.10"),
            (1.9501, "1.95", "1.96"),
            (1.9599, "1.95", "1.96"),
            (-0.0001, "-0.01", "0.00"),
            (0.0, "0.00", "0.00"),
            (f64::INFINITY, "inf", "inf"),
        ] {
            assert_eq!([rounded_down(metres, 2), rounded_up(metres, 2)], [down, up], "{metres}");
        }
    }

    #[test]
    fn distances_are_those_of_a_plain_search() {
        for (seed, size) in
            [[1, 1, 1], [9, 1, 1], [1, 7, 5], [33, 4, 6], [12, 13, 14]].into_iter().enumerate()
        {
            for share in [1, 20, 300] {
                let window = Window { min: [-3, 5, 2], size };
                let mut set = BitGrid::new(window);
                for (number, voxel) in (0..).zip(BitGrid::full(window).voxels()) {
                    if pcg(seed as u32 ^ pcg(share ^ pcg(number))) % 1000 < share {
                        set.set(voxel);
                    }
                }
                set.set(std::array::from_fn(|r| window.min[r] + size[r] as i32 / 3));
                let found = Distances::from_set(&set);
                for voxel in BitGrid::full(window).voxels() {
                    let to =
                        |other: [i32; 3]| (0..3).map(|r| voxel[r].abs_diff(other[r]).pow(2)).sum::<u32>();
                    assert_eq!(
                        Some(found.squared_distance(voxel)),
                        set.voxels().map(to).min(),
                        "{voxel:?} of {size:?}"
                    );
                }
                let all = || {
                    BitGrid::full(window)
                        .voxels()
                        .map(|voxel| found.squared_distance(voxel))
                        .collect::<Vec<_>>()
                };
                assert_eq!(Some(found.farthest()), all().into_iter().max());
                for most in [0, 1, 9, 1000] {
                    let near = found.voxels_within(most);
                    assert_eq!(near.count(), all().iter().filter(|&&own| own <= most).count() as u64);
                    assert!(
                        near.voxels().all(|voxel| found.squared_distance(voxel) <= most),
                        "{most} of {size:?}"
                    );
                    let beyond = window.grown(2);
                    assert_eq!(found.least(&BitGrid::full(beyond)), Some(0));
                }
            }
        }
    }
}
