//! How far a ray of integers is from its ideal line at most: the one bound that code with floats allows for.
//!
//! # Theory
//! A component of the direction in the grid is a sum of three products a·d of a rotation's entry and of a
//! direction's, both rounded to 2⁻¹⁵ and so off by 2⁻¹⁶ at most. The sum is off by Σ(|a| + |d|) · 2⁻¹⁶ ≤ 2√3
//! · 2⁻¹⁶, and by 2⁻¹⁷ more once it is rounded itself: 6.1 · 10⁻⁵ a component. A period is rounded down by
//! less than 2⁻¹⁶ of what it is for a component of 1, and less for smaller ones: 1.6 · 10⁻⁵ along the ray. A
//! rotation's rows cannot all have Σ|a| = √3 at once, so all three components together stay below 1.1 · 10⁻⁴
//! voxels a voxel of distance; the test below measures what is reached.
//!
//! What does not grow with the distance (first crossings are rounded down) is below 10⁻⁴ voxels. [`FIXED`] is
//! much more: room for the rounding of 32-bit floats in a grid of a thousand voxels.

/// What a ray of integers deviates from its ideal line in a voxel of distance, at most, in voxels.
pub const PER_VOXEL: f64 = 1.1e-4;

/// What is added to that, whatever the distance, in voxels.
pub const FIXED: f64 = 0.03;

#[cfg(test)]
mod tests {
    use glam::{DMat3, DQuat, DVec3};
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;
    use crate::march::{MAX_RANGE_VOXELS, NEVER, crossings, direction_q16, start};

    /// A number from −1 to 1.
    fn share(random: &mut ChaCha8Rng) -> f64 {
        f64::from(random.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0
    }

    fn unit(random: &mut ChaCha8Rng) -> DVec3 {
        loop {
            let v = DVec3::from_array(std::array::from_fn(|_| share(random)));
            if v.length() > 0.1 && v.length() < 1.0 {
                return v.normalize();
            }
        }
    }

    /// Where the integers have a ray at a distance, from where its crossings are: straight between two of an
    /// axis.
    fn place(origin_q16: [i32; 3], first: [u32; 3], period: [u32; 3], step: [i32; 3], t: f64) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|r| {
            let origin = f64::from(origin_q16[r]) / 65_536.0;
            if step[r] == 0 || period[r] == NEVER {
                return origin;
            }
            let ahead = if step[r] > 0 { origin.floor() + 1.0 - origin } else { origin - origin.floor() };
            let made = (t - f64::from(first[r])) / f64::from(period[r]);
            origin + f64::from(step[r]) * (ahead + made)
        }))
    }

    #[test]
    fn no_ray_deviates_farther_than_the_bound() {
        let mut random = ChaCha8Rng::seed_from_u64(13);
        let (mut most, mut fixed) = (0.0f64, 0.0f64);
        for _ in 0..20_000 {
            let about = unit(&mut random);
            let rotation = DMat3::from_quat(DQuat::from_axis_angle(about, 4.0 * share(&mut random)));
            let dir = unit(&mut random);
            let q15 = |v: DVec3| v.to_array().map(|x| (x * 32_768.0).round() as i32);
            let axis_q15 = [0, 1, 2].map(|r| q15(rotation.row(r)));
            let dir_q16 = axis_q15.map(|axis| direction_q16(axis, q15(dir)));
            let origin_q16 = std::array::from_fn(|_| (500 << 16) + (random.next_u32() & 0xffff) as i32);
            let begin = start(origin_q16, dir_q16);
            let ideal =
                |t: f64| DVec3::from_array(origin_q16.map(|x| f64::from(x) / 65_536.0)) + rotation * dir * t;
            let apart = |t_q16: u32| {
                let at = place(origin_q16, begin.next_q16, begin.period_q16, begin.step, f64::from(t_q16));
                (at - ideal(f64::from(t_q16) / 65_536.0)).length()
            };
            // Rays that hardly cross an axis have no second crossing to go by.
            if begin.period_q16.iter().any(|&period| period > 200 << 16) {
                continue;
            }
            for crossing in crossings(begin).step_by(7) {
                let t = f64::from(crossing.t_q16) / 65_536.0;
                let apart = apart(crossing.t_q16);
                assert!(apart <= PER_VOXEL * t + FIXED, "{dir_q16:?} at {t}: {apart}");
                if t > 1000.0 {
                    most = most.max(apart / t);
                } else if t < 1.0 {
                    fixed = fixed.max(apart);
                }
            }
        }
        // The bound is no larger than it need be: more than half of it is reached, and little of what is
        // fixed.
        assert!(most > 0.5 * PER_VOXEL && most < PER_VOXEL, "{most} a voxel");
        assert!(fixed < 3e-4 && f64::from(MAX_RANGE_VOXELS) * PER_VOXEL < 0.25, "{fixed} at the beginning");
    }
}
