//! A set of points around an axis, in cells of layers, rings and sectors: turning it about the axis or sliding it along is
//! exact but for the size of a cell.

use std::f64::consts::TAU;
use std::ops::Range;

use glam::DVec3;

/// Cells about the z axis, each at most one step long, wide and high.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct PolarSet {
    step_m: f64,
    /// Number of the lowest layer.
    lowest: i64,
    layers: usize,
    /// Where each ring begins among the cells of a layer, and where the last one ends.
    begins: Vec<usize>,
    words: Vec<u64>,
}

/// Most cells, of which a byte holds eight: 64 MiB.
const MOST_CELLS: f64 = 5e8;

/// A point is at most this many steps from the middle of its cell.
pub(super) const HALF_CELL: f64 = 0.87;

impl PolarSet {
    /// The empty set of all points within a radius of the origin, and as much higher or lower as they may slide; `None` if
    /// that takes too many cells.
    pub(super) fn new(step_m: f64, radius_m: f64, slide_m: [f64; 2]) -> Option<PolarSet> {
        let rings = radius_m / step_m + 2.0;
        let layers = (slide_m[1].max(0.0) - slide_m[0].min(0.0) + 2.0 * radius_m) / step_m + 4.0;
        if TAU * rings * rings * layers > MOST_CELLS {
            return None;
        }
        let cells = |metres: f64| (metres / step_m).floor() as i64;
        let (lowest, highest) =
            (cells(slide_m[0].min(0.0) - radius_m) - 1, cells(slide_m[1].max(0.0) + radius_m) + 1);
        let mut begins = vec![0];
        for ring in 0..=cells(radius_m) + 1 {
            let sectors = (TAU * (ring + 1) as f64).ceil() as usize;
            begins.push(begins[begins.len() - 1] + sectors);
        }
        let layers = (highest - lowest + 1) as usize;
        let cells = layers * begins[begins.len() - 1];
        Some(PolarSet { step_m, lowest, layers, begins, words: vec![0; cells.div_ceil(64)] })
    }

    /// Adds the cell of a point.
    pub(super) fn add(&mut self, at: DVec3) {
        let radius = libm::hypot(at.x, at.y);
        let layer = ((at.z / self.step_m).floor() as i64 - self.lowest).clamp(0, self.layers as i64 - 1);
        let ring = ((radius / self.step_m).floor() as usize).min(self.begins.len() - 2);
        let sectors = self.sectors(ring);
        let turn = (libm::atan2(at.y, at.x) / TAU).rem_euclid(1.0);
        let sector = ((turn * sectors as f64).floor() as usize).min(sectors - 1);
        self.set(self.row(layer as usize, ring).start + sector);
    }

    /// All points that the set reaches when it turns by any of these angles.
    pub(super) fn turn(&mut self, [from, to]: [f64; 2]) {
        for layer in 0..self.layers {
            for ring in 0..self.begins.len() - 1 {
                let (row, sectors) = (self.row(layer, ring), self.sectors(ring) as i64);
                let of_sectors = |angle: f64| angle / TAU * sectors as f64;
                // A point anywhere in its sector gets into each of these.
                let (low, high) = (of_sectors(from).floor(), of_sectors(to).floor() + 1.0);
                let set: Vec<i64> =
                    (0..sectors).filter(|sector| self.get(row.start + *sector as usize)).collect();
                if set.is_empty() {
                    continue;
                }
                if high - low + 1.0 >= sectors as f64 {
                    row.for_each(|cell| self.set(cell));
                    continue;
                }
                let (low, high) = (low as i64, high as i64);
                // Runs of sectors that follow each other are turned together.
                for run in set.chunk_by(|a, b| a + 1 == *b) {
                    let end = (run[run.len() - 1] + high).min(run[0] + low + sectors - 1);
                    for sector in run[0] + low..=end {
                        self.set(row.start + sector.rem_euclid(sectors) as usize);
                    }
                }
            }
        }
    }

    /// All points that the set reaches when it slides by any of these lengths.
    pub(super) fn slide(&mut self, [from_m, to_m]: [f64; 2]) {
        let whole = |metres: f64| (metres / self.step_m).floor() as i64;
        let (low, high) = (whole(from_m), whole(to_m) + 1);
        let (before, in_layer) = (self.clone(), self.begins[self.begins.len() - 1]);
        self.words.fill(0);
        for layer in 0..self.layers {
            let reached = (layer as i64 + low).max(0)..=(layer as i64 + high).min(self.layers as i64 - 1);
            for cell in (0..in_layer).filter(|cell| before.get(layer * in_layer + cell)) {
                reached.clone().for_each(|to| self.set(to as usize * in_layer + cell));
            }
        }
    }

    /// Calls a function with the middle of each cell.
    pub(super) fn for_each(&self, visit: &mut dyn FnMut(DVec3)) {
        for ring in 0..self.begins.len() - 1 {
            let (radius, sectors) = ((ring as f64 + 0.5) * self.step_m, self.sectors(ring));
            let middles: Vec<[f64; 2]> = (0..sectors)
                .map(|sector| {
                    let (sin, cos) = libm::sincos((sector as f64 + 0.5) / sectors as f64 * TAU);
                    [radius * cos, radius * sin]
                })
                .collect();
            for layer in 0..self.layers {
                let z = ((layer as i64 + self.lowest) as f64 + 0.5) * self.step_m;
                let row = self.row(layer, ring);
                for (cell, [x, y]) in row.zip(&middles).filter(|(cell, _)| self.get(*cell)) {
                    debug_assert!(cell < self.words.len() * 64);
                    visit(DVec3::new(*x, *y, z));
                }
            }
        }
    }

    fn sectors(&self, ring: usize) -> usize {
        self.begins[ring + 1] - self.begins[ring]
    }

    /// The cells of a ring in a layer.
    fn row(&self, layer: usize, ring: usize) -> Range<usize> {
        let first = layer * self.begins[self.begins.len() - 1];
        first + self.begins[ring]..first + self.begins[ring + 1]
    }

    fn get(&self, cell: usize) -> bool {
        self.words[cell / 64] >> (cell % 64) & 1 == 1
    }

    fn set(&mut self, cell: usize) {
        self.words[cell / 64] |= 1 << (cell % 64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a set has a cell whose middle is near a point.
    fn has(set: &PolarSet, at: DVec3) -> bool {
        let mut found = false;
        set.for_each(&mut |middle| found |= middle.distance(at) <= HALF_CELL * set.step_m);
        found
    }

    #[test]
    fn a_point_is_in_its_cell_turned_and_slid() {
        let at = DVec3::new(0.31, -0.22, 0.47);
        let turned = |angle: f64| {
            DVec3::new(at.x * angle.cos() - at.y * angle.sin(), at.x * angle.sin() + at.y * angle.cos(), at.z)
        };
        for angles in [[-0.5, 1.5], [0.2, 0.2], [-3.0, 3.0], [5.0, 7.0]] {
            let mut set = PolarSet::new(0.01, 0.7, [0.0, 0.0]).unwrap();
            set.add(at);
            set.turn(angles);
            for part in 0..=20 {
                let angle = angles[0] + (angles[1] - angles[0]) * f64::from(part) / 20.0;
                assert!(has(&set, turned(angle)), "{angles:?}: {angle}");
            }
            // Two cells outside of the angles nothing is reached.
            let more = 0.04;
            if angles[1] - angles[0] < 3.0 {
                assert!(!has(&set, turned(angles[1] + more * 2.0)), "{angles:?}");
                assert!(!has(&set, turned(angles[0] - more * 2.0)), "{angles:?}");
            }
        }
        let mut set = PolarSet::new(0.01, 0.7, [-0.2, 0.3]).unwrap();
        // Also where a joint slides little, far away.
        assert_eq!([[-1e6, 1e6], [1e6, 1e6 + 1.0]].map(|far| PolarSet::new(0.01, 0.7, far)), [None, None]);
        set.add(at);
        set.slide([-0.2, 0.3]);
        for (z, is_reached) in [(-0.2, true), (0.0, true), (0.3, true), (-0.23, false), (0.33, false)] {
            assert_eq!(has(&set, at + DVec3::Z * z), is_reached, "{z}");
        }
    }
}
