//! How a sensor is turned, as angles that people measure: pan, tilt and roll. Tables hold them, so they are
//! the same on every machine.

use glam::DVec3;

use perirobot_scene::pose::Pose;

/// Nearer than this to straight up or down, a direction has no azimuth.
const VERTICAL: f64 = 1e-9;

/// Where a sensor looks, in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turned {
    /// Azimuth of where it looks, from world x towards world y: counter-clockwise, seen from above.
    pub pan_deg: f64,
    /// How far above the horizon it looks; negative is down.
    pub tilt_deg: f64,
    /// How far it is turned about where it looks, clockwise, seen from behind it.
    pub roll_deg: f64,
}

impl Turned {
    /// Of a pose. What looks straight up or down is panned only: pan 0 has the top of its picture towards
    /// world x.
    pub fn new(pose: &Pose) -> Turned {
        let link = pose.link();
        let (forward, right) = (link.x_axis, -link.y_axis);
        let vertical = libm::hypot(forward.x, forward.y) < VERTICAL;
        let up = if vertical { DVec3::X } else { DVec3::Z };
        let level = forward.cross(up).normalize();
        let turn = libm::atan2(level.cross(right).dot(forward), level.dot(right));
        let tilt = libm::asin(forward.z.clamp(-1.0, 1.0));
        let (pan, roll) = match vertical {
            true => (turn * forward.z.signum(), 0.0),
            false => (libm::atan2(forward.y, forward.x), turn),
        };
        let [pan_deg, tilt_deg, roll_deg] = [pan, tilt, roll].map(tidy_deg);
        Turned { pan_deg, tilt_deg, roll_deg }
    }
}

/// Degrees, to a hundredth; never −0, and 180 for −180.
fn tidy_deg(radians: f64) -> f64 {
    let degrees = (radians.to_degrees() * 100.0).round() / 100.0;
    if degrees == -180.0 { 180.0 } else { degrees + 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use perirobot_scene::pose::{RotationFrame, from_rpy};

    fn turn(pose: Pose) -> [f64; 3] {
        let Turned { pan_deg, tilt_deg, roll_deg } = Turned::new(&pose);
        [pan_deg, tilt_deg, roll_deg]
    }

    #[test]
    fn pan_is_from_x_and_tilt_is_up() {
        let facing = |facing, pan: f64, tilt: f64| {
            turn(Pose::facing(DVec3::ZERO, facing, pan.to_radians(), tilt.to_radians()))
        };
        assert_eq!(facing(DVec3::Y, 0.0, 0.0), [90.0, 0.0, 0.0]);
        assert_eq!(facing(DVec3::Y, -20.0, -30.0), [70.0, -30.0, 0.0]);
        assert_eq!(facing(-DVec3::X, 0.0, 10.0), [180.0, 10.0, 0.0]);
        // Straight down the picture's top is towards x, panned.
        assert_eq!(facing(-DVec3::Z, 0.0, 0.0), [0.0, -90.0, 0.0]);
        assert_eq!(facing(-DVec3::Z, 25.0, 0.0), [25.0, -90.0, 0.0]);
        assert_eq!(facing(DVec3::Z, 25.0, 0.0), [25.0, 90.0, 0.0]);
    }

    #[test]
    fn roll_is_clockwise_from_behind() {
        // URDF's roll about x (forward) lifts the left side: clockwise for a viewer who looks along it.
        let rpy = |r: f64, p: f64, y: f64| from_rpy([r, p, y].map(f64::to_radians));
        let pose = |r, p, y| Pose::from_rotation(DVec3::ZERO, rpy(r, p, y), RotationFrame::Link);
        assert_eq!(turn(pose(30.0, 0.0, 40.0)), [40.0, 0.0, 30.0]);
        assert_eq!(turn(pose(-90.0, 20.0, 0.0)), [0.0, -20.0, -90.0]);
    }
}
