//! The direction of a table nearest to a given one, and how far the table's directions are apart.
//! Directions are unit vectors in Q15, distances the straight lines between their ends, squared.
//!
//! # Theory
//! A k-d tree (Bentley 1975) in integers: each node is the median along one of the three axes alternately, and a
//! branch is left out if the plane between is farther away than the best direction found. Of equally near
//! directions the first counts, so the answer does not depend on how the tree was built.

/// The most directions that are searched one by one.
const LEAF: usize = 8;

/// The number of directions whose neighbours are sampled for the spacing of a table.
const SAMPLES: usize = 256;

/// A searchable table of directions.
pub(super) struct NearestDirection<'a> {
    dirs_q15: &'a [[i32; 3]],
    /// The indices of all directions, each part with its median in the middle.
    order: Vec<u32>,
}

impl<'a> NearestDirection<'a> {
    pub(super) fn new(dirs_q15: &'a [[i32; 3]]) -> Self {
        let mut order: Vec<u32> = (0..dirs_q15.len() as u32).collect();
        sort(dirs_q15, &mut order, 0);
        NearestDirection { dirs_q15, order }
    }

    /// The index of the nearest direction within a squared distance, and its squared distance.
    pub(super) fn find(&self, dir_q15: [i32; 3], within: i64) -> Option<(u32, i64)> {
        let mut best = (within, u32::MAX);
        self.search(&self.order, 0, dir_q15, &mut best);
        (best.1 != u32::MAX).then_some((best.1, best.0))
    }

    fn search(&self, part: &[u32], axis: usize, wanted: [i32; 3], best: &mut (i64, u32)) {
        let mut see = |number: u32| {
            *best = (*best).min((squared_distance(self.dirs_q15[number as usize], wanted), number))
        };
        if part.len() <= LEAF {
            return part.iter().for_each(|&number| see(number));
        }
        let middle = part.len() / 2;
        see(part[middle]);
        let beyond = i64::from(wanted[axis] - self.dirs_q15[part[middle] as usize][axis]);
        let (low, high) = (&part[..middle], &part[middle + 1..]);
        let (near, far) = if beyond < 0 { (low, high) } else { (high, low) };
        self.search(near, (axis + 1) % 3, wanted, best);
        if beyond * beyond <= best.0 {
            self.search(far, (axis + 1) % 3, wanted, best);
        }
    }
}

fn sort(dirs_q15: &[[i32; 3]], part: &mut [u32], axis: usize) {
    if part.len() <= LEAF {
        return;
    }
    let middle = part.len() / 2;
    part.select_nth_unstable_by_key(middle, |&number| (dirs_q15[number as usize][axis], number));
    let (low, high) = part.split_at_mut(middle);
    let next = (axis + 1) % 3;
    rayon::join(|| sort(dirs_q15, low, next), || sort(dirs_q15, &mut high[1..], next));
}

/// The spacing of a table's directions, squared: the median over directions of the distance to the nearest other one or
/// to the nearest one beside that line, whichever is larger. So the spacing of a raster is that of its rows; directions
/// more than ten times as far beside a line belong to no row. 0 for a single direction.
pub(super) fn gap(dirs_q15: &[[i32; 3]]) -> i64 {
    let every = dirs_q15.len().div_ceil(SAMPLES).max(1);
    let mut gaps: Vec<i64> = dirs_q15.iter().step_by(every).map(|&at| gap_around(at, dirs_q15)).collect();
    gaps.sort_unstable();
    gaps.get(gaps.len() / 2).copied().unwrap_or(0)
}

fn gap_around(at: [i32; 3], dirs_q15: &[[i32; 3]]) -> i64 {
    let others =
        || dirs_q15.iter().map(|&other| (squared_distance(other, at), other)).filter(|(far, _)| *far > 0);
    let Some((along, nearest)) = others().min() else { return 0 };
    let line = minus(nearest, at);
    let is_beside = |other: [i32; 3], far: i64| {
        let way = minus(other, at);
        let along_line: i64 = (0..3).map(|r| i64::from(line[r]) * i64::from(way[r])).sum();
        2 * i128::from(along_line).pow(2) <= i128::from(along) * i128::from(far)
    };
    let beside = others().filter(|&(far, other)| is_beside(other, far)).map(|(far, _)| far).min();
    beside.filter(|&far| far <= 100 * along).map_or(along, |far| far.max(along))
}

fn minus(a: [i32; 3], b: [i32; 3]) -> [i32; 3] {
    std::array::from_fn(|r| a[r] - b[r])
}

fn squared_distance(a: [i32; 3], b: [i32; 3]) -> i64 {
    minus(a, b).into_iter().map(|x| i64::from(x) * i64::from(x)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use perirobot_march::march::pcg;

    fn unit_q15(v: [f64; 3]) -> [i32; 3] {
        let length = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        v.map(|x| (x / length * 32_768.0).round() as i32)
    }

    /// Directions in no order, each of the first few twice.
    fn scatter(count: u32, seed: u32) -> Vec<[i32; 3]> {
        let component = |n: u32| f64::from(pcg(seed ^ pcg(n)) >> 8) / f64::from(1 << 23) - 1.0;
        let one = |n: u32| unit_q15([0, 1, 2].map(|r| component(3 * n + r)));
        (0..count).chain(0..count / 10).map(one).collect()
    }

    /// Rows and columns with this spacing in radians, about straight ahead.
    fn raster(rows: i32, columns: i32, [up, across]: [f64; 2]) -> Vec<[i32; 3]> {
        let voxel = |i: i32| {
            [f64::from(i % columns - columns / 2) * across, f64::from(i / columns - rows / 2) * up, 1.0]
        };
        (0..rows * columns).map(|i| unit_q15(voxel(i))).collect()
    }

    #[test]
    fn the_nearest_is_that_of_a_plain_search() {
        for count in [1, 2, 7, 8, 9, 17, 300, 2000] {
            let dirs = scatter(count, count);
            let nearest = NearestDirection::new(&dirs);
            for wanted in scatter(200, 77) {
                let plain =
                    (0..).zip(&dirs).map(|(n, &dir)| (squared_distance(dir, wanted), n)).min().unwrap();
                assert_eq!(nearest.find(wanted, i64::MAX), Some((plain.1, plain.0)), "{wanted:?} of {count}");
                assert_eq!(nearest.find(wanted, plain.0), Some((plain.1, plain.0)), "as far as allowed");
                assert_eq!(nearest.find(wanted, plain.0 - 1), None);
            }
        }
        assert_eq!(NearestDirection::new(&[]).find([32_768, 0, 0], i64::MAX), None);
    }

    #[test]
    fn a_raster_is_as_coarse_as_its_rows() {
        let about = |squared: i64, radians: f64| {
            let found = (squared as f64).sqrt() / 32_768.0;
            assert!((found / radians - 1.0).abs() < 0.1, "{found} is not about {radians}");
        };
        about(gap(&raster(9, 9, [0.01, 0.01])), 0.01);
        about(gap(&raster(9, 40, [0.02, 0.004])), 0.02);
        about(gap(&raster(40, 9, [0.004, 0.02])), 0.02);
        // A single row has no neighbour row, and a row too far away does not count.
        about(gap(&raster(1, 40, [0.0, 0.01])), 0.01);
        about(gap(&raster(2, 40, [0.2, 0.01])), 0.01);
        assert_eq!((gap(&[]), gap(&[[0, 0, 32_768]]), gap(&[[0, 0, 32_768]; 3])), (0, 0, 0));
    }
}
