//! How far a body can go unnoticed: from some places to all that steps to the 26 neighbours join, by shortest
//! paths.
//!
//! # Theory
//! Dijkstra's shortest paths (1959). Steps are 1000, 1414 and 1732 long, thousandths of a voxel, so that whole
//! numbers decide which path is shorter: sums of roots would be rounded anyway, and these are off by less than
//! a four-thousandth. With so few lengths the queue is a ring of buckets (Dial 1969).

use perirobot_march::voxel::{BitGrid, Window};

/// The longest step: over a voxel's corner.
pub const LONGEST_STEP: u64 = 1732;

/// Lengths of steps by how many axes they move along.
const STEPS: [u64; 4] = [0, 1000, 1414, LONGEST_STEP];

/// No path leads there.
const FAR: u64 = u64::MAX;

/// Lengths of the shortest paths to all places.
#[derive(Clone, Debug)]
pub struct Flood {
    /// The places, with a margin of one around them that nothing enters.
    around: Window,
    /// For each place of that window; 0 also where nothing may be.
    lengths: Vec<u64>,
    reached: BitGrid,
}

impl Flood {
    /// From those of some places that are open, through open ones. Both planes cover the same window.
    pub fn from_places(begin: &BitGrid, open: &BitGrid) -> Flood {
        let around = open.window().grown(1);
        let mut flood = Flood { around, lengths: Vec::new(), reached: BitGrid::new(open.window()) };
        flood.lengths = vec![0; around.volume() as usize];
        open.voxels().for_each(|place| {
            let at = flood.index(place);
            flood.lengths[at] = FAR;
        });
        let steps = flood.steps();
        let mut ring: Vec<Vec<u32>> = vec![Vec::new(); LONGEST_STEP as usize + 1];
        for place in begin.voxels().filter(|&place| open.get(place)) {
            let at = flood.index(place);
            flood.lengths[at] = 0;
            flood.reached.set(place);
            ring[0].push(at as u32);
        }
        let mut waiting = ring[0].len();
        let mut length = 0;
        while waiting > 0 {
            let bucket = (length % ring.len() as u64) as usize;
            while let Some(at) = ring[bucket].pop() {
                waiting -= 1;
                if flood.lengths[at as usize] != length {
                    // A shorter way was found since.
                    continue;
                }
                for &(by, step) in &steps {
                    let next = (i64::from(at) + by) as usize;
                    if flood.lengths[next] > length + step {
                        if flood.lengths[next] == FAR {
                            flood.reached.set(flood.place(next));
                        }
                        flood.lengths[next] = length + step;
                        ring[((length + step) % (LONGEST_STEP + 1)) as usize].push(next as u32);
                        waiting += 1;
                    }
                }
            }
            length += 1;
        }
        flood
    }

    /// The places that are reached.
    pub fn places(&self) -> &BitGrid {
        &self.reached
    }

    /// The length of the shortest path to a place that is reached, in thousandths of a voxel.
    pub fn length(&self, place: [i32; 3]) -> u64 {
        self.lengths[self.index(place)]
    }

    /// A shortest path to a place that is reached, from where it begins: of steps back that are equally short
    /// the first, along x before y before z, down before up.
    pub fn path(&self, to: [i32; 3]) -> Vec<[i32; 3]> {
        let steps = self.steps();
        let mut path = vec![to];
        let mut at = self.index(to);
        while self.lengths[at] > 0 {
            let before =
                steps.iter().map(|&(by, step)| ((at as i64 + by) as usize, step)).find(|&(before, step)| {
                    self.lengths[before] != FAR
                        && self.lengths[before] + step == self.lengths[at]
                        && self.reached.get(self.place(before))
                });
            let Some((before, _)) = before else { break };
            at = before;
            path.push(self.place(at));
        }
        path.reverse();
        path
    }

    /// Steps to the neighbours: by how much the index changes, and how long they are.
    fn steps(&self) -> Vec<(i64, u64)> {
        let [width, depth, _] = self.around.size.map(i64::from);
        let each = || -1..=1i64;
        let all = each().flat_map(move |z| each().flat_map(move |y| each().map(move |x| [x, y, z])));
        let moved = |by: &[i64; 3]| by.iter().filter(|&&d| d != 0).count();
        all.filter(|by| moved(by) > 0)
            .map(|by| (by[0] + width * (by[1] + depth * by[2]), STEPS[moved(&by)]))
            .collect()
    }

    fn index(&self, place: [i32; 3]) -> usize {
        let [x, y, z]: [usize; 3] = std::array::from_fn(|r| (place[r] - self.around.min[r]) as usize);
        let [width, depth, _] = self.around.size.map(|n| n as usize);
        x + width * (y + depth * z)
    }

    fn place(&self, index: usize) -> [i32; 3] {
        let [width, depth, _] = self.around.size.map(|n| n as usize);
        let at = [index % width, index / width % depth, index / width / depth];
        std::array::from_fn(|r| at[r] as i32 + self.around.min[r])
    }
}

#[cfg(test)]
mod tests {
    use super::super::body::tests::scatter;
    use super::*;

    /// Lengths by relaxing every step until nothing changes.
    fn plain(begin: &BitGrid, open: &BitGrid) -> std::collections::BTreeMap<[i32; 3], u64> {
        let mut lengths: std::collections::BTreeMap<[i32; 3], u64> =
            begin.voxels().filter(|&place| open.get(place)).map(|place| (place, 0)).collect();
        loop {
            let mut changed = false;
            for place in open.voxels() {
                let around = Window::from_corners(place.map(|x| x - 1), place.map(|x| x + 1));
                let through = |from: [i32; 3]| {
                    let moved = (0..3).filter(|&r| from[r] != place[r]).count();
                    lengths.get(&from).map(|length| length + [0, 1000, 1414, 1732][moved])
                };
                let shortest = BitGrid::full(around).voxels().filter_map(through).min();
                if let Some(shortest) = shortest.filter(|s| lengths.get(&place).is_none_or(|old| s < old)) {
                    lengths.insert(place, shortest);
                    changed = true;
                }
            }
            if !changed {
                return lengths;
            }
        }
    }

    #[test]
    fn lengths_are_those_of_a_plain_search() {
        let mut cut_off = 0;
        for (seed, size) in (0..).zip([[1, 1, 1], [40, 1, 1], [12, 9, 1], [7, 8, 9], [35, 6, 3], [4, 20, 7]])
        {
            for share in [150, 300, 600, 1000] {
                let window = Window { min: [-2, 3, 7], size };
                let (open, begin) = (scatter(window, share, seed), scatter(window, 10, seed + 99));
                let (found, expected) = (Flood::from_places(&begin, &open), plain(&begin, &open));
                assert_eq!(found.places().count(), expected.len() as u64);
                cut_off += open.count() - found.places().count();
                for (place, length) in expected {
                    assert_eq!(found.length(place), length, "{place:?} of {size:?}");
                    let path = found.path(place);
                    assert!(begin.get(path[0]) && path[path.len() - 1] == place);
                    assert!(path.iter().all(|&place| open.get(place)));
                    let steps = path.windows(2).map(|pair| {
                        let apart: [u32; 3] = std::array::from_fn(|r| pair[0][r].abs_diff(pair[1][r]));
                        assert!(apart.iter().all(|&d| d <= 1) && apart != [0; 3]);
                        STEPS[apart.iter().sum::<u32>() as usize]
                    });
                    assert_eq!(steps.sum::<u64>(), length, "a path that is as long as it says");
                }
            }
        }
        assert!(cut_off > 100, "some places cannot be reached");
    }
}
