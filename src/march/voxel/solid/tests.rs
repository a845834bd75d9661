//! Each solid against a loop over all voxels that is written straight from its rule, over odd windows that
//! cut it, and on cases counted by hand.

use super::*;
use crate::voxel::Window;
use crate::voxel::grid::length_q16;

/// The same numbers on every machine: SplitMix64.
struct Random(u64);

impl Random {
    /// A number from `from` to `to`, both included.
    fn number_between(&mut self, from: i64, to: i64) -> i64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        from + ((z ^ (z >> 31)) % (to - from + 1) as u64) as i64
    }

    fn voxel(&mut self, reach: i64) -> [i32; 3] {
        std::array::from_fn(|_| self.number_between(-reach, reach) as i32)
    }

    /// A window that does not begin at a word, wider than one.
    fn window(&mut self) -> Window {
        let min = self.voxel(12);
        Window {
            min,
            size: [
                self.number_between(1, 45) as u32,
                self.number_between(1, 15) as u32,
                self.number_between(1, 15) as u32,
            ],
        }
    }
}

fn voxels(window: Window) -> impl Iterator<Item = [i32; 3]> {
    let (min, end) = (window.min, window.end());
    (min[2]..end[2])
        .flat_map(move |z| (min[1]..end[1]).flat_map(move |y| (min[0]..end[0]).map(move |x| [x, y, z])))
}

/// Exactly the voxels of the plane's window for which `rule` holds are set. Returns their number.
#[track_caller]
fn assert_is(plane: &BitGrid, what: &str, rule: impl Fn([i128; 3]) -> bool) -> u64 {
    let expected = voxels(plane.window()).filter(|voxel| rule(voxel.map(i128::from)));
    let mut same = BitGrid::new(plane.window());
    expected.for_each(|voxel| same.set(voxel));
    assert_eq!(plane.voxels().collect::<Vec<_>>(), same.voxels().collect::<Vec<_>>(), "{what}");
    assert_eq!(plane, &same, "padding of {what}");
    plane.count()
}

fn minus(a: [i128; 3], b: [i32; 3]) -> [i128; 3] {
    std::array::from_fn(|r| a[r] - b[r] as i128)
}

fn dot(a: [i128; 3], b: [i128; 3]) -> i128 {
    (0..3).map(|r| a[r] * b[r]).sum()
}

/// A radius, often exactly the distance between two voxels or one off.
fn radius(random: &mut Random) -> i64 {
    match random.number_between(0, 3) {
        0 => (random.number_between(1, 9) << 16) + random.number_between(-1, 1),
        1 => ((random.number_between(1, 90) as f64).sqrt() * 65_536.0) as i64 + random.number_between(0, 1),
        _ => random.number_between(0, 8 << 16),
    }
}

#[test]
fn balls_are_their_rule() {
    let (mut random, mut set) = (Random(1), 0);
    for _ in 0..400 {
        let (mut plane, center, r) = (BitGrid::new(random.window()), random.voxel(14), radius(&mut random));
        ball(&mut plane, center, r);
        set += assert_is(&plane, &format!("{center:?} {r}"), |voxel| {
            let away = minus(voxel, center);
            dot(away, away) << 32 < (r as i128).pow(2)
        });
    }
    assert!(set > 5_000, "{set}");
}

#[test]
fn balls_counted_by_hand() {
    let count = |radius_q16| {
        let mut plane = BitGrid::new(Window::from_corners([-5; 3], [5; 3]));
        ball(&mut plane, [0; 3], radius_q16);
        plane.count()
    };
    // The centre; with its faces' neighbours; with its edges', from just over √2; not yet its corners' at √3.
    assert_eq!([0, 1, 65_536, 65_537, 92_681, 92_682, 113_511].map(count), [0, 1, 1, 7, 7, 19, 19]);
    // The paper's spheres, 0.20 m at 5 cm: d² < 16 in voxels.
    assert_eq!(
        count(length_q16(0.20, 0.05)),
        voxels(Window::from_corners([-5; 3], [5; 3]))
            .filter(|c| c.iter().map(|x| x * x).sum::<i32>() < 16)
            .count() as u64
    );
    assert_eq!(count(i64::MAX), 11 * 11 * 11);
    assert_eq!(count(-65_537), 0);
}

#[test]
fn cylinders_are_their_rule() {
    let (mut random, mut set) = (Random(2), 0);
    for case in 0..1500 {
        let (from, mut to) = (random.voxel(12), random.voxel(12));
        // Along an axis or in its plane, where terms of the quadratic vanish.
        for r in 0..case % 3 {
            let axis = (case / 3 + r) % 3;
            to[axis] = from[axis];
        }
        let (mut plane, r) = (BitGrid::new(random.window()), radius(&mut random));
        cylinder(&mut plane, from, to, r);
        let axis = minus(to.map(i128::from), from);
        set += assert_is(&plane, &format!("{from:?} {to:?} {r}"), |voxel| {
            let p = minus(voxel, from);
            let (along, length) = (dot(p, axis), dot(axis, axis));
            // d² = |p|² − along²/length, times length · 2³².
            let near = (dot(p, p) * length - along * along) << 32 < (r as i128).pow(2) * length;
            length > 0 && (0..=length).contains(&along) && near
        });
    }
    assert!(set > 5_000, "{set}");
}

#[test]
fn cylinders_counted_by_hand() {
    let count = |from: [i32; 3], to: [i32; 3], radius_q16| {
        let mut plane = BitGrid::new(Window::from_corners([-20; 3], [20; 3]));
        cylinder(&mut plane, from, to, radius_q16);
        plane.count()
    };
    // Five discs of one voxel, of five, and of nine; both ends are in.
    for (radius_q16, disc) in [(65_536, 1), (65_537, 5), (2 << 16, 9)] {
        for axis in 0..3 {
            let mut to = [1, 2, 3];
            to[axis] += 4;
            assert_eq!(count([1, 2, 3], to, radius_q16), 5 * disc, "axis {axis}");
            assert_eq!(count(to, [1, 2, 3], radius_q16), 5 * disc, "axis {axis}");
        }
    }
    // A diagonal of three voxels; beside it, distance² 2/3 within the ends: six around each of two gaps.
    assert_eq!(count([0; 3], [2; 3], 1), 3);
    assert_eq!(count([0; 3], [2; 3], 65_536), 3 + 12);
    assert_eq!(count([1, 2, 3], [1, 2, 3], 9 << 16), 0);
    assert_eq!(count([0; 3], [1; 3], 0), 0);
}

#[test]
fn the_largest_cylinder_does_not_overflow() {
    let mut plane = BitGrid::new(Window::from_corners([0, 500, 0], [1022, 501, 1022]));
    cylinder(&mut plane, [0, 1022, 0], [1022, 0, 1022], i64::MAX);
    let axis = [1022, -1022, 1022];
    assert_is(&plane, "a diagonal", |[x, y, z]| {
        let along = dot([x, y - 1022, z], axis);
        (0..=dot(axis, axis)).contains(&along)
    });
}

#[test]
fn cuboids_are_their_rule() {
    let mut random = Random(3);
    for count in 0..40 {
        let voxels: Vec<_> = (0..count % 5).map(|_| random.voxel(15)).collect();
        let mut plane = BitGrid::new(random.window());
        cuboid(&mut plane, voxels.iter().copied());
        assert_is(&plane, &format!("{voxels:?}"), |voxel| {
            let side = |r: usize| voxels.iter().map(move |c| c[r] as i128);
            let spans = |r: usize| (side(r).min()..=side(r).max()).contains(&Some(voxel[r]));
            !voxels.is_empty() && (0..3).all(spans)
        });
    }
    let mut plane = BitGrid::new(Window::from_corners([-9; 3], [9; 3]));
    cuboid(&mut plane, [[1, -2, 3], [0, 4, 3], [1, 1, 5]]);
    assert_eq!((plane.count(), plane.bounds()), (2 * 7 * 3, Window::from_corners([0, -2, 3], [1, 4, 5])));
}

/// A coordinate in Q16, mostly on a centre or one off.
fn coordinate(random: &mut Random, reach: i64) -> i64 {
    (random.number_between(-reach, reach) << 15) + random.number_between(-1, 1)
}

#[test]
fn boxes_are_half_open() {
    let mut random = Random(4);
    for _ in 0..300 {
        let low: [i64; 3] = std::array::from_fn(|_| coordinate(&mut random, 30));
        let high = low.map(|x| x + coordinate(&mut random, 30).abs());
        let mut plane = BitGrid::new(random.window());
        half_open_box(&mut plane, low, high);
        assert_is(&plane, &format!("{low:?} {high:?}"), |voxel| {
            let inside = |r: usize| (low[r] as i128..high[r] as i128).contains(&(voxel[r] * 65_536 + 32_768));
            (0..3).all(inside)
        });
    }
}

/// Even-odd from the definition: how many edges are passed on the way from a point to −x, the point moved up
/// by less than anything.
fn is_inside(polygon: &[[i64; 2]], [x, y]: [i128; 2]) -> bool {
    let passed = (0..polygon.len()).filter(|&i| {
        let [a, b] = [polygon[i], polygon[(i + 1) % polygon.len()]].map(|p| p.map(i128::from));
        let (low, high) = if a[1] < b[1] { (a, b) } else { (b, a) };
        // The edge's x at y is at most x, without the division.
        let left = (high[0] - low[0]) * (y - low[1]) <= (x - low[0]) * (high[1] - low[1]);
        low[1] <= y && y < high[1] && left
    });
    passed.count() % 2 == 1
}

#[test]
fn columns_are_their_rule() {
    let (mut random, mut set) = (Random(5), 0);
    for _ in 0..500 {
        let corners = random.number_between(3, 7);
        let polygon: Vec<_> = (0..corners).map(|_| [0, 1].map(|_| coordinate(&mut random, 40))).collect();
        let layers = random.number_between(-14, 3) as i32..random.number_between(0, 20) as i32;
        let mut plane = BitGrid::new(random.window());
        column(&mut plane, &polygon, layers.clone());
        set += assert_is(&plane, &format!("{polygon:?}"), |[x, y, z]| {
            layers.contains(&(z as i32)) && is_inside(&polygon, [x, y].map(|c| c * 65_536 + 32_768))
        });
    }
    assert!(set > 5_000, "{set}");
}

#[test]
fn polygons_with_a_common_edge_share_no_voxel_and_leave_none_out() {
    let window = Window::from_corners([-20, -20, 2], [20, 20, 2]);
    let mut random = Random(6);
    for _ in 0..200 {
        // A fan of triangles about a point, corners on centres so that many lie on edges.
        let on_centre = |voxel: i64| (voxel << 16) + 32_768;
        let middle = [0, 1].map(|_| on_centre(random.number_between(-9, 9)));
        let rim = [[-15, -15], [random.number_between(-5, 5), -15], [15, -15], [15, 15], [-15, 15]]
            .map(|p| p.map(on_centre));
        let mut sum = 0;
        let mut all = BitGrid::new(window);
        for i in 0..rim.len() {
            let mut part = BitGrid::new(window);
            column(&mut part, &[middle, rim[i], rim[(i + 1) % rim.len()]], 2..3);
            sum += part.count();
            all.add(&part);
        }
        // Half-open: the centres −15 … 14.
        assert_eq!((sum, all.count()), (900, 900), "{middle:?}");
        assert_eq!(all.bounds(), Window::from_corners([-15, -15, 2], [14, 14, 2]));
    }
}

#[test]
fn simple_polygons_and_others() {
    let check = |corners: &[[i64; 2]], expected| {
        assert_eq!(is_simple(corners), expected, "{corners:?}");
        let turned: Vec<_> = corners.iter().map(|[x, y]| [-y, *x]).collect();
        assert_eq!(is_simple(&turned), expected, "{turned:?}");
    };
    let meet = |i, j| Err(NotSimple::EdgesMeet(i, j));
    check(&[], Err(NotSimple::TooFew(0)));
    check(&[[0, 0], [1, 0]], Err(NotSimple::TooFew(2)));
    check(&[[0, 0], [4, 0], [4, 4], [0, 4]], Ok(()));
    check(&[[0, 4], [4, 4], [4, 0], [0, 0]], Ok(()));
    check(&[[0, 0], [2, 0], [4, 0], [4, 4], [2, 1]], Ok(()));
    // A bow tie; no area; a spike; a corner twice; a corner on another edge; an edge along another.
    check(&[[0, 0], [4, 4], [4, 0], [0, 4]], meet(0, 2));
    check(&[[0, 0], [2, 2], [4, 4]], meet(0, 2));
    check(&[[0, 0], [4, 0], [4, 4], [4, 6], [4, 5], [0, 4]], meet(2, 3));
    check(&[[0, 0], [4, 0], [4, 0], [4, 4]], meet(0, 1));
    check(&[[0, 0], [4, 0], [4, 4], [2, 0], [0, 4]], meet(0, 2));
    check(&[[0, 0], [9, 0], [9, 2], [6, 2], [6, 0], [3, 0], [3, 2], [0, 2]], meet(0, 3));
    // The first edge against the last.
    check(&[[0, 0], [4, 0], [4, 4], [-2, 4], [2, 0]], meet(0, 3));
    check(&[[0, 0], [4, 0], [4, 4], [2, 0]], meet(0, 2));
    let far = 1 << 36;
    check(&[[-far, -far], [far, -far], [far, far], [-far, far]], Ok(()));
    check(&[[-far, -far], [far, far], [far, -far], [-far, far - 1]], meet(0, 2));
}

#[test]
fn within_is_its_rule() {
    let (mut random, mut set) = (Random(7), 0);
    for case in 0..150 {
        let mut solid = BitGrid::new(random.window());
        for voxel in voxels(solid.window()) {
            if random.number_between(0, [3, 60, 400][case % 3]) == 0 {
                solid.set(voxel);
            }
        }
        let centers: Vec<_> = solid.voxels().collect();
        let (window, distance) = (random.window(), radius(&mut random));
        let near = dilate(&solid, distance, window);
        set += assert_is(&near, &format!("case {case}, {distance}"), |voxel| {
            centers.iter().any(|&c| {
                let away = minus(voxel, c);
                dot(away, away) << 32 <= (distance.max(0) as i128).pow(2)
            })
        });
        assert_eq!(near.window(), window);
    }
    assert!(set > 5_000, "{set}");
}

#[test]
fn thirty_centimetres_are_six_voxels() {
    let window = Window::from_corners([-10; 3], [10; 3]);
    let mut solid = BitGrid::new(window);
    solid.set([0; 3]);
    let near = dilate(&solid, length_q16(0.3, 0.05), window);
    assert_eq!(near.bounds(), Window::from_corners([-6; 3], [6; 3]));
    for voxel in [[6, 0, 0], [-6, 0, 0], [0, 6, 0], [0, 0, -6], [4, 4, 2]] {
        assert!(near.get(voxel), "{voxel:?}");
    }
    assert!(!near.get([6, 1, 0]) && !near.get([4, 4, 3]));
    assert_eq!(dilate(&solid, 0, window), solid);
    assert_eq!(dilate(&solid, -1, window), solid);
    assert!(dilate(&BitGrid::new(window), 1 << 20, window).is_empty());
    assert_eq!(dilate(&solid, i64::MAX, window).count(), window.volume());
}
