//! A mount that is not quite where a study believes it to be.

use glam::{DQuat, DVec3};

use super::noise::unit_q12;
use perirobot_march::march;
use perirobot_scene::pose::Pose;

/// How far off mounts are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// Standard deviation of the position along each of the sensor's own axes, in metres.
    pub position_m: f64,
    /// Standard deviation of the rotation about each of them, in radians.
    pub angle_rad: f64,
}

/// Takes the place of the scene's index in the hash, beyond any index of a scene: a mount is off by the same
/// amount in all scenes.
const NO_SCENE: u32 = u32::MAX;

/// The same of mounts that are drawn to be judged.
const MOUNTED: u32 = u32::MAX - 1;

impl Calibration {
    /// The true pose of a sensor in one repeat, from its believed pose; all indices count in study order.
    pub(crate) fn true_pose(
        &self,
        believed: &Pose,
        seed: u64,
        [sensor, candidate, repeat]: [usize; 3],
    ) -> Pose {
        let words = [seed as u32, (seed >> 32) as u32, NO_SCENE];
        self.perturb(believed, words.into_iter().chain(indices([sensor, candidate, repeat])), false)
    }

    /// A mount that is not where it is planned, in one attempt at a draw; all numbers count in study order. A sensor that
    /// stays level keeps its height, too, and turns about the vertical only.
    pub fn mount(
        &self,
        planned: &Pose,
        seed: u64,
        [sensor, candidate, draw]: [usize; 3],
        attempt: u32,
        is_level: bool,
    ) -> Pose {
        let words = [seed as u32, (seed >> 32) as u32, MOUNTED];
        let words = words.into_iter().chain(indices([sensor, candidate, draw])).chain([attempt]);
        self.perturb(planned, words, is_level)
    }

    /// A pose that is off by what some words draw.
    fn perturb(&self, pose: &Pose, words: impl Iterator<Item = u32>, is_level: bool) -> Pose {
        let (draws, unit) = (march::fold(words), unit_q12());
        let normal = |axis: u32| f64::from(unit[march::entry(march::draw(draws, axis)) as usize]) / 4096.0;
        let (mut off_m, mut turned) =
            (DVec3::new(normal(0), normal(1), normal(2)), DVec3::new(normal(3), normal(4), normal(5)));
        if is_level {
            off_m.z = 0.0;
            (turned.x, turned.y) = (0.0, 0.0);
        }
        let (off_m, turned) = (self.position_m * off_m, self.angle_rad * turned);
        Pose {
            position_m: pose.position_m + pose.rotation * off_m,
            rotation: (pose.rotation * about(turned)).normalize(),
        }
    }
}

fn indices(all: [usize; 3]) -> impl Iterator<Item = u32> {
    all.into_iter().map(|index| index as u32)
}

/// The rotation about a vector by its length, with the same sines on every machine.
fn about(vector: DVec3) -> DQuat {
    let angle = vector.length();
    let (sin, cos) = libm::sincos(angle / 2.0);
    let axis = if angle > 0.0 { vector * (sin / angle) } else { DVec3::ZERO };
    DQuat::from_xyzw(axis.x, axis.y, axis.z, cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    const OFF: Calibration = Calibration { position_m: 0.01, angle_rad: 0.005 };

    fn draw(repeat: usize, believed: &Pose) -> Pose {
        OFF.true_pose(believed, 7, [1, 2, repeat])
    }

    #[test]
    fn mounts_are_off_by_what_was_said_along_and_about_each_axis() {
        let believed = Pose::facing(DVec3::new(1.0, 2.0, 3.0), DVec3::new(1.0, 2.0, -0.5), 0.3, -0.2);
        let mut squares = [0.0; 6];
        let repeats = 4000;
        for repeat in 0..repeats {
            let found = draw(repeat, &believed);
            let off = believed.rotation.inverse() * (found.position_m - believed.position_m);
            // Small rotations: twice the vector part.
            let turned = believed.rotation.inverse() * found.rotation;
            let turned = DVec3::new(turned.x, turned.y, turned.z) * 2.0;
            for (sum, value) in squares.iter_mut().zip([off.to_array(), turned.to_array()].concat()) {
                *sum += value * value;
            }
        }
        for (axis, sum) in squares.into_iter().enumerate() {
            let expected = if axis < 3 { OFF.position_m } else { OFF.angle_rad };
            let std = (sum / repeats as f64).sqrt();
            // Five standard errors.
            assert!((std / expected - 1.0).abs() < 0.056, "axis {axis}: {std}, not {expected}");
        }
    }

    #[test]
    fn each_sensor_pose_repeat_and_seed_has_its_own() {
        let believed = Pose::ORIGIN;
        let first = OFF.true_pose(&believed, 7, [1, 2, 3]);
        assert_eq!(first, OFF.true_pose(&believed, 7, [1, 2, 3]));
        for (seed, words) in
            [(8, [1, 2, 3]), (7 | 1 << 40, [1, 2, 3]), (7, [2, 1, 3]), (7, [1, 3, 2]), (7, [1, 2, 4])]
        {
            assert_ne!(first, OFF.true_pose(&believed, seed, words), "{seed} {words:?}");
        }
    }

    #[test]
    fn the_error_is_in_the_frame_of_the_sensor() {
        // Two poses, the second turned and moved: the same error, seen from each.
        let here = Pose::ORIGIN;
        let there = Pose::facing(DVec3::new(4.0, -1.0, 2.0), DVec3::new(-1.0, 1.0, 0.2), 0.0, 0.4);
        let (a, b) = (draw(5, &here), draw(5, &there));
        let back = there.rotation.inverse() * (b.position_m - there.position_m);
        assert!((back - a.position_m).length() < 1e-12, "{back} {}", a.position_m);
        let turned = there.rotation.inverse() * b.rotation;
        assert!(turned.dot(a.rotation).abs() > 1.0 - 1e-12);
    }

    #[test]
    fn what_is_exact_stays() {
        let believed = Pose::facing(DVec3::ONE, DVec3::Y, 0.1, 0.2);
        let exact = Calibration { position_m: 0.0, angle_rad: 0.0 };
        let found = exact.true_pose(&believed, 1, [0; 3]);
        assert_eq!(found.position_m, believed.position_m);
        assert!(found.rotation.dot(believed.rotation).abs() > 1.0 - 1e-15);
    }
}
