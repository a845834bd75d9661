//! Where a sensor is and how it is turned, as the page has it and as the study writes it. A pose is rounded to what is
//! written before anything is counted, so that the saved study gives the same counts.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_scene::pose::{Pose, RotationFrame, from_rpy};
use perirobot_study::sensor::Stance;
use perirobot_study::sensor::turned::Turned;

/// Positions are written to a thousandth of a metre, angles to a tenth of a degree.
const PER_METRE: f64 = 1000.0;
const PER_DEGREE: f64 = 10.0;
/// The farthest from the origin that the study can say.
const FARTHEST_M: f64 = 1e6;

/// Where a sensor is and how it is turned, in the world or on the link that carries it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pose6 {
    /// Position, in metres.
    pub position_m: [f64; 3],
    /// Where it looks, from x towards y.
    #[serde(default)]
    pub pan_deg: f64,
    /// How far above the horizon it looks.
    #[serde(default)]
    pub tilt_deg: f64,
    /// How far it is turned about where it looks, clockwise, seen from behind it.
    #[serde(default)]
    pub roll_deg: f64,
}

/// How the study says where a sensor looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Orientation {
    /// Along an axis, panned and tilted.
    Facing { facing: [f64; 3], pan_deg: f64, tilt_deg: f64 },
    /// Roll, pitch, yaw.
    Rpy([f64; 3]),
}

impl Pose6 {
    /// A pose in numbers that people measure, not rounded yet to what is written.
    pub fn new(pose: &Pose) -> Pose6 {
        let Turned { pan_deg, tilt_deg, roll_deg } = Turned::new(pose);
        Pose6 { position_m: pose.position_m.to_array(), pan_deg, tilt_deg, roll_deg }
    }

    /// The same as it is written: to a millimetre and a tenth of a degree, with angles from −180 to 180.
    #[must_use]
    pub fn rounded(&self) -> Pose6 {
        Pose6 {
            position_m: self.position_m.map(round_metres),
            pan_deg: round_degrees(self.pan_deg),
            tilt_deg: (self.tilt_deg * PER_DEGREE).round() / PER_DEGREE + 0.0,
            roll_deg: round_degrees(self.roll_deg),
        }
    }

    /// Checks that a study can say it.
    ///
    /// # Errors
    /// For numbers that are not finite, too far, or more than straight up or down.
    pub fn check(&self) -> Result<()> {
        let wrong = |key: &str, value: String, rule: String| Err(Error::from(Issue::value(key, value, rule)));
        let Pose6 { position_m, pan_deg, tilt_deg, roll_deg } = *self;
        if !position_m.iter().all(|metres| metres.abs() <= FARTHEST_M) {
            let rule = format!("must be three numbers from -{FARTHEST_M} to {FARTHEST_M}");
            return wrong("position_m", format!("{position_m:?}"), rule);
        }
        for (key, value, most) in
            [("pan_deg", pan_deg, 1e6), ("tilt_deg", tilt_deg, 90.0), ("roll_deg", roll_deg, 1e6)]
        {
            if value.is_nan() || value.abs() > most {
                return wrong(
                    key,
                    value.to_string(),
                    format!("must be an angle in degrees from -{most} to {most}"),
                );
            }
        }
        Ok(())
    }

    /// How a study says where a sensor of a stance looks; of a rounded pose.
    pub(super) fn orientation(&self, stance: Stance) -> Orientation {
        let Pose6 { pan_deg, tilt_deg, roll_deg, .. } = *self;
        if roll_deg != 0.0 || tilt_deg != 0.0 && stance != Stance::Facing {
            // A positive pitch looks down. Straight up, pan counts from where the picture's top is towards x.
            let pan_deg = match tilt_deg == 90.0 {
                true => (Pose6 { pan_deg: pan_deg + 180.0, ..*self }).rounded().pan_deg,
                false => pan_deg,
            };
            return Orientation::Rpy([roll_deg, 0.0 - tilt_deg, pan_deg]);
        }
        if tilt_deg.abs() == 90.0 {
            // Panned from where the picture's top is towards x.
            return Orientation::Facing { facing: [0.0, 0.0, tilt_deg.signum()], pan_deg, tilt_deg: 0.0 };
        }
        let quarters = (pan_deg / 90.0).round();
        let facing = match quarters as i32 {
            0 => [1.0, 0.0, 0.0],
            1 => [0.0, 1.0, 0.0],
            -1 => [0.0, -1.0, 0.0],
            _ => [-1.0, 0.0, 0.0],
        };
        let pan_deg = ((pan_deg - quarters * 90.0) * PER_DEGREE).round() / PER_DEGREE + 0.0;
        Orientation::Facing { facing, pan_deg, tilt_deg }
    }
}

/// To a millimetre.
pub(super) fn round_metres(metres: f64) -> f64 {
    (metres * PER_METRE).round() / PER_METRE + 0.0
}

/// A turn to a tenth of a degree, from above −180 to 180.
pub(super) fn round_degrees(degrees: f64) -> f64 {
    // After rounding, so that 180.04 is 180 and not −180.
    let tenths = (degrees * PER_DEGREE).round().rem_euclid(360.0 * PER_DEGREE);
    let tenths = if tenths > 180.0 * PER_DEGREE { tenths - 360.0 * PER_DEGREE } else { tenths };
    tenths / PER_DEGREE + 0.0
}

/// The pose of a sensor as the study that is written will give it, to the last bit.
pub fn rounded(at: &Pose6, stance: Stance) -> Pose {
    let at = at.rounded();
    let position = DVec3::from_array(at.position_m);
    match (at.orientation(stance), stance) {
        (Orientation::Rpy(rpy_deg), _) => {
            Pose::from_rotation(position, from_rpy(rpy_deg.map(f64::to_radians)), RotationFrame::Link)
        }
        (Orientation::Facing { facing, pan_deg, tilt_deg }, Stance::Facing) => {
            Pose::facing(position, DVec3::from_array(facing), pan_deg.to_radians(), tilt_deg.to_radians())
        }
        (Orientation::Facing { facing, pan_deg, .. }, Stance::Upright | Stance::Level) => {
            Pose::upright(position, DVec3::from_array(facing), pan_deg.to_radians())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_leaves_what_is_written() {
        let pose = Pose6 {
            position_m: [1.2345, -0.00049, 2.9996],
            pan_deg: 180.04,
            tilt_deg: -30.06,
            roll_deg: -0.04,
        };
        let expected =
            Pose6 { position_m: [1.235, 0.0, 3.0], pan_deg: 180.0, tilt_deg: -30.1, roll_deg: 0.0 };
        assert_eq!(pose.rounded(), expected);
        assert_eq!(pose.rounded().rounded(), pose.rounded());
        assert!(
            pose.rounded().position_m[1].is_sign_positive() && pose.rounded().roll_deg.is_sign_positive()
        );
        for (degrees, wanted) in [
            (-180.0, 180.0),
            (-179.96, 180.0),
            (540.0, 180.0),
            (359.96, 0.0),
            (-90.0, -90.0),
            (181.0, -179.0),
        ] {
            assert_eq!(Pose6 { pan_deg: degrees, ..pose }.rounded().pan_deg, wanted, "{degrees}");
        }
    }

    #[test]
    fn an_orientation_faces_the_nearest_axis() {
        let written = |pan_deg, tilt_deg, roll_deg, stance| {
            Pose6 { position_m: [0.0; 3], pan_deg, tilt_deg, roll_deg }.rounded().orientation(stance)
        };
        let facing = |facing, pan_deg, tilt_deg| Orientation::Facing { facing, pan_deg, tilt_deg };
        let cases = [
            ((30.0, -20.0, 0.0), facing([1.0, 0.0, 0.0], 30.0, -20.0)),
            ((100.2, 0.0, 0.0), facing([0.0, 1.0, 0.0], 10.2, 0.0)),
            ((-135.1, 5.0, 0.0), facing([-1.0, 0.0, 0.0], 44.9, 5.0)),
            ((-80.0, 0.0, 0.0), facing([0.0, -1.0, 0.0], 10.0, 0.0)),
            ((25.0, -90.0, 0.0), facing([0.0, 0.0, -1.0], 25.0, 0.0)),
            ((25.0, 90.0, 0.0), facing([0.0, 0.0, 1.0], 25.0, 0.0)),
            ((25.0, -20.0, 3.0), Orientation::Rpy([3.0, 20.0, 25.0])),
        ];
        for ((pan, tilt, roll), expected) in cases {
            assert_eq!(written(pan, tilt, roll, Stance::Facing), expected, "{pan} {tilt} {roll}");
        }
        assert_eq!(written(30.0, -5.0, 0.0, Stance::Level), Orientation::Rpy([0.0, 5.0, 30.0]));
        assert_eq!(written(120.0, 0.0, 0.0, Stance::Upright), facing([0.0, 1.0, 0.0], 30.0, 0.0));
    }

    #[test]
    fn a_rounded_pose_is_turned_as_it_says() {
        for stance in [Stance::Facing, Stance::Upright, Stance::Level] {
            for (pan_deg, tilt_deg, roll_deg) in [
                (0.0, 0.0, 0.0),
                (33.3, -20.5, 0.0),
                (-170.1, 45.0, 0.0),
                (180.0, 10.0, -15.0),
                (90.0, 0.0, 90.0),
                (25.0, -90.0, 0.0),
                (-120.0, 90.0, 0.0),
            ] {
                let at = Pose6 { position_m: [1.0, 2.0, 3.0], pan_deg, tilt_deg, roll_deg };
                let got = Pose6::new(&rounded(&at, stance));
                let near = |a: f64, b: f64| (a - b).abs() < 0.011;
                let same = near(got.pan_deg, pan_deg)
                    && near(got.tilt_deg, tilt_deg)
                    && near(got.roll_deg, roll_deg);
                assert!(same, "{stance:?}: {at:?} became {got:?}");
            }
        }
    }

    #[test]
    fn a_pose_that_no_study_can_say_is_refused() {
        let at = Pose6 { position_m: [0.0; 3], pan_deg: 0.0, tilt_deg: 0.0, roll_deg: 0.0 };
        assert!(at.check().is_ok());
        for (wrong, key) in [
            (Pose6 { position_m: [f64::NAN, 0.0, 0.0], ..at }, "position_m"),
            (Pose6 { position_m: [0.0, 2e6, 0.0], ..at }, "position_m"),
            (Pose6 { tilt_deg: 90.1, ..at }, "tilt_deg = 90.1"),
            (Pose6 { pan_deg: f64::INFINITY, ..at }, "pan_deg = inf"),
            (Pose6 { roll_deg: f64::NAN, ..at }, "roll_deg = NaN"),
        ] {
            let error = wrong.check().unwrap_err().to_string();
            assert!(error.starts_with(key), "{error}");
        }
    }
}
