//! How far a body can go unnoticed: from some places to all that steps join, by shortest paths. A step leads to one of
//! the 26 neighbours; a body that walks on surfaces steps to one of the 8 columns beside its own, up or down by at most the
//! layers that it climbs.
//!
//! # Theory
//! Dijkstra's shortest paths (1959). Steps are 1000, 1414 and 1732 long, thousandths of a voxel, and so on, rounded down,
//! so that whole numbers decide which path is shorter: sums of roots would be rounded anyway, and these are off by less
//! than a four-thousandth. With so few lengths the queue is a ring of buckets (Dial 1969).

use perirobot_march::voxel::{BitGrid, Window};

/// No path leads there.
const FAR: u64 = u64::MAX;

/// The steps of a body that moves freely, or that walks and climbs at most `climbs` layers in a step: the change of its
/// place, and the length; along z before y before x.
pub(super) fn steps(climbs: Option<u32>) -> Vec<([i32; 3], u64)> {
    let layers = climbs.map_or(1, |layers| layers as i32);
    let each = || -1..=1;
    let all = (-layers..=layers).flat_map(move |z| each().flat_map(move |y| each().map(move |x| [x, y, z])));
    let moves = all.filter(|[x, y, z]| *x != 0 || *y != 0 || climbs.is_none() && *z != 0);
    let length =
        |by: [i32; 3]| by.iter().map(|&n| u64::from(n.unsigned_abs()).pow(2) * 1_000_000).sum::<u64>();
    moves.map(|by| (by, length(by).isqrt())).collect()
}

/// Lengths of the shortest paths to all places.
#[derive(Clone, Debug)]
pub struct Flood {
    /// The places, with a margin of one around them that nothing enters.
    around: Window,
    /// For each place of that window; 0 also where nothing may be.
    lengths: Vec<u64>,
    reached: BitGrid,
    climbs: Option<u32>,
    longest: u64,
}

impl Flood {
    /// From those of some places that are open, through open ones. Both planes cover the same window. `climbs` are the
    /// layers of a step of a body that walks ([`Body::climbs`](super::Body::climbs)).
    pub fn from_places(begin: &BitGrid, open: &BitGrid, climbs: Option<u32>) -> Flood {
        let mut around = open.window().grown(1);
        if let Some(layers) = climbs {
            around.min[2] = open.window().min[2] - layers as i32;
            around.size[2] = open.window().size[2] + 2 * layers;
        }
        let longest = steps(climbs).iter().map(|(_, length)| *length).max().unwrap_or(0);
        let reached = BitGrid::new(open.window());
        let mut flood = Flood { around, lengths: Vec::new(), reached, climbs, longest };
        flood.lengths = vec![0; around.volume() as usize];
        open.voxels().for_each(|place| {
            let at = flood.index(place);
            flood.lengths[at] = FAR;
        });
        let steps = flood.steps();
        let mut ring: Vec<Vec<u32>> = vec![Vec::new(); longest as usize + 1];
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
                        ring[((length + step) % (longest + 1)) as usize].push(next as u32);
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

    /// The length of the longest step.
    pub fn longest_step(&self) -> u64 {
        self.longest
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

    /// By how much the index changes with each step, and the step's length.
    fn steps(&self) -> Vec<(i64, u64)> {
        let [width, depth, _] = self.around.size.map(i64::from);
        let all = steps(self.climbs).into_iter().map(|(by, length)| (by.map(i64::from), length));
        all.map(|([x, y, z], length)| (x + width * (y + depth * z), length)).collect()
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

    /// The length of a step from one place to another; `None` if it is neither a climb of few enough layers nor a neighbour.
    fn step(from: [i32; 3], to: [i32; 3], climbs: Option<u32>) -> Option<u64> {
        let apart: [u32; 3] = std::array::from_fn(|r| from[r].abs_diff(to[r]));
        let [x, y, z] = apart.map(|n| n as usize);
        let is_step = x <= 1 && y <= 1 && z <= climbs.unwrap_or(1) as usize;
        let walks = climbs.is_none() || x + y > 0;
        // Square roots of 1 to 6, rounded down to thousandths.
        let lengths = [0, 1000, 1414, 1732, 2000, 2236, 2449];
        (is_step && walks && from != to).then(|| lengths[x + y + z * z])
    }

    /// Lengths by relaxing every step until nothing changes.
    fn plain(
        begin: &BitGrid,
        open: &BitGrid,
        climbs: Option<u32>,
    ) -> std::collections::BTreeMap<[i32; 3], u64> {
        let mut lengths: std::collections::BTreeMap<[i32; 3], u64> =
            begin.voxels().filter(|&place| open.get(place)).map(|place| (place, 0)).collect();
        loop {
            let mut changed = false;
            for place in open.voxels() {
                let around = Window::from_corners(place.map(|x| x - 2), place.map(|x| x + 2));
                let through = |from: [i32; 3]| Some(lengths.get(&from)? + step(from, place, climbs)?);
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
            for (share, climbs) in [150, 300, 600, 1000]
                .into_iter()
                .flat_map(|share| [None, Some(0), Some(1), Some(2)].map(|climbs| (share, climbs)))
            {
                let window = Window { min: [-2, 3, 7], size };
                let (open, begin) = (scatter(window, share, seed), scatter(window, 10, seed + 99));
                let found = Flood::from_places(&begin, &open, climbs);
                let expected = plain(&begin, &open, climbs);
                assert_eq!(found.places().count(), expected.len() as u64);
                cut_off += open.count() - found.places().count();
                for (place, length) in expected {
                    assert_eq!(found.length(place), length, "{place:?} of {size:?}");
                    let path = found.path(place);
                    assert!(begin.get(path[0]) && path[path.len() - 1] == place);
                    assert!(path.iter().all(|&place| open.get(place)));
                    let steps = path.windows(2).map(|pair| step(pair[0], pair[1], climbs).unwrap());
                    assert_eq!(steps.sum::<u64>(), length, "a path that is as long as it says");
                }
            }
        }
        assert!(cut_off > 100, "some places cannot be reached");
    }
}
