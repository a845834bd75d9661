//! The arithmetic of a ray against exact quotients, other implementations, and a march step by step.

use super::*;

#[test]
fn periods_are_the_exact_quotient() {
    assert_eq!(period_q16(0), NEVER);
    for d in 1..=65_539u32 {
        let exact = ((1u64 << 32) / d as u64).min(NEVER as u64);
        assert_eq!(period_q16(d) as u64, exact, "d = {d}");
    }
}

#[test]
fn first_crossings_are_the_exact_product() {
    for period in [65_533, 65_536, 65_537, 131_072, 9_999_999, NEVER - 1, NEVER] {
        for f in [0, 1, 2, 3, 255, 32_767, 32_768, 65_535, 65_536] {
            let exact = (f as u64 * period as u64) >> 16;
            assert_eq!(first_q16(f, period) as u64, exact, "f {f}, period {period}");
        }
    }
}

#[test]
fn a_boundary_start_moving_down_crosses_at_once() {
    let march = start([3 << 16, 1 << 15, 0], [-65_536, 0, 0]);
    assert_eq!((march.voxel, march.next_q16), ([3, 0, 0], [0, NEVER, NEVER]));
    let march = start([3 << 16, 1 << 15, 0], [65_536, 0, 0]);
    assert_eq!(march.next_q16[0], 1 << 16);
}

#[test]
fn ties_take_x_then_y_then_z() {
    assert_eq!(next_axis([5, 5, 5]), 0);
    assert_eq!(next_axis([6, 5, 5]), 1);
    assert_eq!(next_axis([6, 6, 5]), 2);
    assert_eq!(next_axis([5, 6, 5]), 0);
}

#[test]
fn the_extremes_of_a_direction_stay_in_32_bits() {
    assert_eq!(direction_q16([32_768, 0, 0], [32_768, 0, 0]), 65_536);
    assert_eq!(direction_q16([-32_768, 0, 0], [32_768, 0, 0]), -65_536);
    let diagonal = 18_919; // 2¹⁵ / √3
    assert_eq!(direction_q16([diagonal; 3], [diagonal; 3]), 65_539);
}

#[test]
fn ends_pack_and_free() {
    let end = End { kind: RETURN, crossings: 3069 };
    assert_eq!(End::unpacked(end.packed()), end);
    assert_eq!(freed(end, false), 3069);
    let silent = End { kind: NOTHING, crossings: 7 };
    assert_eq!((freed(silent, false), freed(silent, true)), (0, 8));
    assert_eq!(freed(End { kind: BLIND, crossings: 7 }, true), 0);
    assert_eq!(freed(End { kind: LEFT, crossings: 7 }, false), 8);
}

/// Numbers below a bound, the same each time.
fn random() -> impl FnMut(i32) -> i32 {
    let mut state = 1u32;
    move |below| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as i32 % below
    }
}

/// A position in a grid and a direction: on boundaries, centres or anywhere; along the lattice or anywhere.
/// `None` for no direction.
fn ray(random: &mut impl FnMut(i32) -> i32, case: usize, size: [u32; 3]) -> Option<([i32; 3], [i32; 3])> {
    let lattice = [-65_536, -37_837, 0, 37_837, 65_536];
    let origin = size.map(|n| match case % 3 {
        0 => random(n as i32) << 16,
        1 => (random(n as i32) << 16) + 0x8000,
        _ => random((n << 16) as i32),
    });
    let dir: [i32; 3] = std::array::from_fn(|_| {
        if case.is_multiple_of(2) { lattice[random(5) as usize] } else { random(131_079) - 65_539 }
    });
    (dir != [0; 3]).then_some((origin, dir))
}

#[test]
fn crossings_are_counted_up_to_a_distance() {
    // First at 10, then every 65 536: 10, 65 546, 131 082 …
    for (t_q16, made) in [(9, 0), (10, 1), (65_545, 1), (65_546, 2)] {
        assert_eq!(made_at(10, 65_536, 0, t_q16, 2), made, "{t_q16}");
        assert_eq!(made_at(10, 65_536, 1, t_q16, 1), made, "{t_q16}");
        assert_eq!(made_at(10, 65_536, 1, t_q16 + 1, 0), made, "{t_q16} and just before axis 1");
    }
    assert_eq!(made_at(0, 65_533, 0, 0, 2), 1, "a start on a boundary crosses at once");
    assert_eq!(made_at(0, 65_533, 0, 0, -1), 0, "but not before all crossings");
    assert_eq!(made_at(0, NEVER, 0, 2047 << 16, 2), 1, "and never again");
    assert_eq!(made_at(NEVER, NEVER, 0, 2047 << 16, 2), 0);
}

#[test]
fn crossings_past_any_grid_never_happen() {
    assert_eq!(crossing_q16(10, 65_536, 0), 10);
    assert_eq!(crossing_q16(10, 65_536, 1022), 10 + 1022 * 65_536);
    assert_eq!(crossing_q16(NEVER, NEVER, 0), NEVER);
    assert_eq!(crossing_q16(0, NEVER, 0), 0);
    assert_eq!(crossing_q16(0, NEVER, 1), NEVER);
    assert_eq!(crossing_q16(0, 2048 << 16, 1), NEVER);
    assert_eq!(crossing_q16(5, 2047 << 16, 1), 5 + (2047 << 16));
    // The product would wrap.
    assert_eq!(crossing_q16(0, NEVER, 1022), NEVER);
}

#[test]
fn room_is_what_lies_ahead_in_the_grid() {
    let begin = start([3 << 16, 3 << 16, 3 << 16], [65_536, -65_536, 0]);
    assert_eq!(room(&begin, [10, 20, 30]), [6, 3, 26]);
    assert_eq!(room(&begin, [4, 4, 4]), [0, 3, 0]);
}

/// Steps to the last voxel that a ray enters at or before a distance inside a grid, and counts.
fn step_count(begin: March, size: [u32; 3], t_q16: u32) -> u32 {
    let (mut march, mut crossings) = (begin, 0);
    loop {
        let axis = next_axis(march.next_q16);
        if march.next_q16[axis] > t_q16 {
            return crossings;
        }
        cross(&mut march, axis);
        if march.voxel.iter().zip(size).any(|(&c, n)| !(0..n as i32).contains(&c)) {
            return crossings;
        }
        crossings += 1;
    }
}

/// The closed form is where a march stands that was stopped at a distance, or at the grid's last voxel: at
/// the distance of each of the ray's crossings, around them, and far behind the grid.
#[test]
fn a_closed_form_lands_where_a_march_would() {
    let mut random = random();
    let (mut inside, mut stopped, mut at_the_exit) = (0, 0, 0);
    for case in 0..30_000 {
        let size = if case % 5 == 0 { [1023; 3] } else { [0; 3].map(|_| 1 + random(12) as u32) };
        let Some((origin, dir)) = ray(&mut random, case, size) else { continue };
        // A direction of length one has a component of 1 / √3, and leaves any grid within its diagonal.
        if dir.iter().all(|d| d.abs() < 37_837) {
            continue;
        }
        let begin = start(origin, dir);
        let rooms = room(&begin, size);
        let leaves = (0..3).map(|r| crossing_q16(begin.next_q16[r], begin.period_q16[r], rooms[r])).min();
        let exit = leaves.unwrap_or(NEVER).min(2047 << 16);
        let axis = random(3) as usize;
        let any =
            crossing_q16(begin.next_q16[axis], begin.period_q16[axis], random(8) as u32).min(2300 << 16);
        let anywhere = random((exit + 2).min(2300 << 16) as i32) as u32;
        for t in [
            0,
            1,
            any.saturating_sub(1),
            any,
            any + 1,
            exit.saturating_sub(1),
            exit,
            exit + 1,
            anywhere,
            2300 << 16,
        ] {
            let expected = step_count(begin, size, t);
            let found = crossings_at(&begin, rooms, t);
            assert_eq!(found, expected, "ray {origin:?} {dir:?} in {size:?} at {t}, exit {exit}");
            inside += (t < exit) as u32;
            stopped += (t > exit) as u32;
            at_the_exit += (t == exit) as u32;
        }
    }
    assert!(inside.min(stopped).min(at_the_exit) > 20_000, "{inside} {stopped} {at_the_exit}");
}

#[test]
fn a_tie_at_the_exit_takes_the_axes_before_it_only() {
    // From the middle of a voxel along the diagonal all three axes cross together, at √3 · ½ and then every
    // √3.
    let begin = start([0x8000; 3], [37_837; 3]);
    let at = begin.next_q16[0];
    // y has no room: x is crossed before it, z would come after.
    assert_eq!(crossings_at(&begin, [5, 0, 5], at), 1);
    assert_eq!(crossings_at(&begin, [5, 0, 5], at - 1), 0);
    assert_eq!(crossings_at(&begin, [0, 5, 5], at), 0);
    assert_eq!(crossings_at(&begin, [5, 5, 0], at), 2);
    assert_eq!(crossings_at(&begin, [5, 5, 5], at), 3);
    assert_eq!(crossings_at(&begin, [5, 5, 1], 2047 << 16), 5, "twice x, twice y, once z");
    // Backwards from a boundary into no room: nothing is crossed at distance 0.
    let begin = start([0, 0, 0x8000], [65_536, -65_536, 0]);
    assert_eq!(crossings_at(&begin, [5, 0, 5], 2047 << 16), 0);
    let begin = start([3 << 16, 0, 0x8000], [-65_536, -65_536, 0]);
    assert_eq!(crossings_at(&begin, [3, 0, 5], 0), 1, "x first");
}

#[test]
fn the_hash_is_the_published_one() {
    // As other implementations give it (several agree), and in 64-bit arithmetic.
    let known = [(0, 129_708_002), (1, 2_831_084_092), (42, 1_223_963_391), (0xdead_beef, 1_730_779_506)];
    known.iter().for_each(|&(word, hash)| assert_eq!(pcg(word), hash, "pcg({word})"));
    assert_eq!((pcg(1 << 31), pcg(u32::MAX)), (566_699_590, 3_861_530_882));
    for i in 0..10_000u64 {
        let word = i * 429_497;
        let state = (word * 747_796_405 + 2_891_336_453) % (1 << 32);
        let mixed = ((state / (1 << (state / (1 << 28) + 4))) ^ state) * 277_803_737 % (1 << 32);
        assert_eq!(pcg(word as u32) as u64, (mixed / (1 << 22)) ^ mixed, "pcg({word})");
    }
}

#[test]
fn words_fold_in_their_order() {
    assert_eq!(fold([]), 0);
    assert_eq!(fold([0]), 129_708_002);
    // Worked outside of Rust.
    assert_eq!(fold([1, 2, 3]), 604_675_008);
    assert_ne!(fold([2, 1, 3]), fold([1, 2, 3]));
    assert_ne!(fold([0, 1]), fold([1]));
    // The ray is the last word, of which the top twelve bits are drawn.
    assert_eq!(draw(fold([1, 2]), 3), 604_675_008);
    assert_eq!(entry(604_675_008), 604_675_008 >> 20);
}

#[test]
fn every_step_of_noise_is_drawn_about_equally_often() {
    let mut often = [0u32; NOISE_STEPS as usize];
    (0..409_600).for_each(|ray| often[entry(draw(fold([7, 1, 0]), ray)) as usize] += 1);
    // 100 each on the mean; a share deviates by 10, and none of 4096 by six times that.
    assert!(
        often.iter().all(|n| (40..=160).contains(n)),
        "{:?} {:?}",
        often.iter().min(),
        often.iter().max()
    );
}

#[test]
fn steps_are_rounded_products() {
    let mut word = 1;
    for _ in 0..20_000 {
        word = pcg(word);
        let (unit, std) = ((word >> 17) as i32 - (1 << 14), pcg(word) % ((64 << 16) + 1));
        let expected = (f64::from(unit) * f64::from(std) / 4096.0 + 0.5).floor();
        assert_eq!(f64::from(step_q16(unit, std)), expected, "{unit} of {std}");
    }
    assert_eq!([1, -1, 3].map(|unit| step_q16(unit, 2048)), [1, 0, 2], "halves are rounded up");
    assert_eq!(step_q16(-15_025, 64 << 16), -15_385_600);
}

#[test]
fn what_is_lost_does_not_depend_on_the_noise() {
    let mut lost = [0u32; 2];
    for ray in 0..100_000 {
        let drawn = draw(fold([7, 1, 0]), ray);
        lost[(entry(drawn) >= NOISE_STEPS / 2) as usize] += is_lost(drawn, 1 << 30) as u32;
    }
    // A quarter of each half; six standard errors.
    assert!(lost.iter().all(|&n| n.abs_diff(12_500) < 6 * 97), "{lost:?}");
    assert!(!is_lost(draw(0, 0), 0));
}

#[test]
fn noise_ends_at_the_sensor() {
    assert_eq!(noisy_q16(10, 5), 15);
    assert_eq!(noisy_q16(10, -10), 0);
    assert_eq!(noisy_q16(10, -11), 0);
    assert_eq!(noisy_q16(2047 << 16, 300 << 16), 2347 << 16);
    assert_eq!(noisy_q16(0, -300 << 16), 0);
}

/// Invariants of the march on random and lattice rays in a grid of 1023³: distance never falls, each crossing
/// moves to an adjacent voxel along the step, the running sum equals the closed form first + n · period, the
/// crossings made are the Manhattan distance from the first voxel, and a ray that leaves the grid never comes
/// back.
#[test]
fn marches_move_on_and_stay_adjacent() {
    let mut random = random();
    for case in 0..20_000 {
        let Some((origin, dir)) = ray(&mut random, case, [1023; 3]) else { continue };
        let begin = start(origin, dir);
        let mut march = begin;
        let (mut last, mut made, mut left) = (0, [0u64; 3], false);
        loop {
            let axis = next_axis(march.next_q16);
            let t = march.next_q16[axis];
            if t > MAX_RANGE_VOXELS << 16 {
                break;
            }
            let closed = begin.next_q16[axis] as u64 + made[axis] * begin.period_q16[axis] as u64;
            assert_eq!(t as u64, closed, "ray {origin:?} {dir:?}, crossings {made:?} of axis {axis}");
            assert!(t >= last, "ray {origin:?} {dir:?}: distance fell from {last} to {t}");
            last = t;
            made[axis] += 1;
            let before = march.voxel;
            cross(&mut march, axis);
            let moved: i32 = (0..3).map(|r| (march.voxel[r] - before[r]).abs()).sum();
            assert_eq!(moved, 1, "ray {origin:?} {dir:?} jumped from {before:?}");
            assert_eq!(march.voxel[axis] - before[axis], dir[axis].signum());
            let distance: u32 = (0..3).map(|r| march.voxel[r].abs_diff(begin.voxel[r])).sum();
            assert_eq!(distance as u64, made.iter().sum::<u64>(), "ray {origin:?} {dir:?}");
            let inside = march.voxel.iter().all(|c| (0..1023).contains(c));
            assert!(!(left && inside), "ray {origin:?} {dir:?} came back to {:?}", march.voxel);
            left |= !inside;
            // The exact line is at origin + dir · t on each axis; a crossing is at most two voxels from it.
            for r in 0..3 {
                let line = (origin[r] as i64 * 65_536 + dir[r] as i64 * t as i64) >> 32;
                let off = (line - march.voxel[r] as i64).abs();
                assert!(
                    off <= 2,
                    "ray {origin:?} {dir:?} at {t}: cell {:?} is {off} from the line",
                    march.voxel
                );
            }
        }
    }
}

#[test]
fn a_depth_is_a_distance_along_the_axis_and_farther_off_it() {
    for depth_q16 in [0, 1, 65_535, 65_536, 9_999_999, MAX_RANGE_VOXELS << 16] {
        assert_eq!(ray_range_q16(depth_q16, period_q16(axial_q16(-5, false))), depth_q16);
        assert_eq!(ray_range_q16(depth_q16, period_q16(axial_q16(32_768, true))), depth_q16);
        for z_q15 in [-32_768, 0, 1, 2048, 2049, 16_384, 18_919, 32_767] {
            let slant = Slant::new(axial_q16(z_q15, true));
            let exact = (u64::from(depth_q16) * ((1 << 31) / z_q15.max(2048) as u64)) >> 16;
            assert_eq!(
                u64::from(slant.ray_range_q16(depth_q16)),
                exact.min(2047 << 16),
                "{depth_q16} at {z_q15}"
            );
            // So the deviations of a table reach to the longest range.
            assert!(slant.ray_range_q16(depth_q16) / slant.period_q16 <= depth_q16 >> 16);
        }
    }
}
