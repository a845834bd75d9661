//! Where a sensor is and how it is turned: whatever form a study gives it in, it becomes one position and one
//! quaternion of the link frame (x forward, y left, z up; REP-103).

use glam::{DMat3, DQuat, DVec3};

use perirobot_march::Result;
use perirobot_march::error::Issue;

/// How far the length of a quaternion may be from 1.
const FROM_UNIT: f64 = 1e-3;

/// `world_from_sensor`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Position in the world, metres.
    pub position_m: DVec3,
    /// Rotation of the link frame, a unit quaternion.
    pub rotation: DQuat,
}

/// Which axes a given rotation turns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum RotationFrame {
    /// x forward, y left, z up.
    #[default]
    Link,
    /// z forward, x right, y down.
    Optical,
}

/// Columns: the optical axes (right, down, forward) in the link frame.
const LINK_FROM_OPTICAL: DMat3 =
    DMat3::from_cols(DVec3::new(0.0, -1.0, 0.0), DVec3::new(0.0, 0.0, -1.0), DVec3::new(1.0, 0.0, 0.0));

fn about_z(angle: f64) -> DMat3 {
    let (sin, cos) = libm::sincos(angle);
    DMat3::from_cols(DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.0), DVec3::Z)
}

fn about_y(angle: f64) -> DMat3 {
    let (sin, cos) = libm::sincos(angle);
    DMat3::from_cols(DVec3::new(cos, 0.0, -sin), DVec3::Y, DVec3::new(sin, 0.0, cos))
}

fn about_x(angle: f64) -> DMat3 {
    let (sin, cos) = libm::sincos(angle);
    DMat3::from_cols(DVec3::X, DVec3::new(0.0, cos, sin), DVec3::new(0.0, -sin, cos))
}

/// Roll about x, then pitch about y, then yaw about z, all fixed axes, as in URDF.
pub fn from_rpy(rpy_rad: [f64; 3]) -> DMat3 {
    about_z(rpy_rad[2]) * about_y(rpy_rad[1]) * about_x(rpy_rad[0])
}

/// Whether a unit vector points straight up or down. A trace of x and y, as a cosine of 90° leaves, is no direction,
/// and the square of a smaller one would vanish.
fn is_vertical(forward: DVec3) -> bool {
    forward.x.hypot(forward.y) < 1e-12
}

impl Pose {
    /// The world's own frame.
    pub const ORIGIN: Pose = Pose { position_m: DVec3::ZERO, rotation: DQuat::IDENTITY };

    /// This pose, given in a frame that is itself somewhere in the world.
    pub fn carried_by(&self, frame: &Pose) -> Pose {
        Pose {
            position_m: frame.position_m + frame.rotation * self.position_m,
            rotation: (frame.rotation * self.rotation).normalize(),
        }
    }

    /// A pose that faces a direction (not zero), panned about world z and tilted about its own right, up
    /// positive: Rz(pan) · [right, down, facing] · Rx(tilt). Up is world z, or world x where the pose faces
    /// straight up or down.
    pub fn facing(position_m: DVec3, facing: DVec3, pan_rad: f64, tilt_rad: f64) -> Self {
        let forward = facing.normalize();
        let up = if is_vertical(forward) { DVec3::X } else { DVec3::Z };
        let right = forward.cross(up).normalize();
        let base = DMat3::from_cols(right, forward.cross(right), forward);
        let world_from_optical = about_z(pan_rad) * base * about_x(tilt_rad);
        Pose::from_rotation(position_m, world_from_optical, RotationFrame::Optical)
    }

    /// A pose that stands upright: z is world z, x the horizontal part of a facing (world x where that is vertical),
    /// panned.
    pub fn upright(position_m: DVec3, facing: DVec3, pan_rad: f64) -> Self {
        let forward = facing.normalize();
        let flat = DVec3::new(forward.x, forward.y, 0.0);
        let x = if is_vertical(forward) { DVec3::X } else { flat.normalize() };
        let base = DMat3::from_cols(x, DVec3::Z.cross(x), DVec3::Z);
        Pose::from_rotation(position_m, about_z(pan_rad) * base, RotationFrame::Link)
    }

    /// The same pose elsewhere, panned about world z and tilted about its own right.
    pub fn moved_to(&self, position_m: DVec3, pan_rad: f64, tilt_rad: f64) -> Self {
        if pan_rad == 0.0 && tilt_rad == 0.0 {
            return Pose { position_m, ..*self };
        }
        let world_from_optical = about_z(pan_rad) * self.optical() * about_x(tilt_rad);
        Pose::from_rotation(position_m, world_from_optical, RotationFrame::Optical)
    }

    /// A pose from the rotation of one of its frames.
    pub fn from_rotation(position_m: DVec3, rotation: DMat3, frame: RotationFrame) -> Self {
        let link = match frame {
            RotationFrame::Link => rotation,
            RotationFrame::Optical => rotation * LINK_FROM_OPTICAL.transpose(),
        };
        // One sign for each rotation, so that a table of poses reads the same however it was made.
        let q = DQuat::from_mat3(&link).normalize();
        Pose { position_m, rotation: if q.w < 0.0 { -q } else { q } }
    }

    /// A pose from a quaternion (w, x, y, z) of length 1. Lengths that differ by at most 0.001 are normalised, but
    /// those within 1e-12 are kept as they are, so that a table read back gives the same rays.
    ///
    /// # Errors
    /// For other lengths, and numbers that are not finite.
    pub fn from_quaternion(position_m: DVec3, wxyz: [f64; 4], frame: RotationFrame) -> Result<Self, Issue> {
        let q = DQuat::from_xyzw(wxyz[1], wxyz[2], wxyz[3], wxyz[0]);
        let length = q.length();
        if !length.is_finite() || length < 1e-9 {
            return Err(Issue::says("must not be zero, and all four finite"));
        }
        if (length - 1.0).abs() > FROM_UNIT {
            let what = format!("must have a length of 1 within {FROM_UNIT}, and has {length:.4}");
            let [w, x, y, z] = wxyz.map(|part| part / length);
            let cure = format!("of length 1 it is w = {w:.6}, x = {x:.6}, y = {y:.6}, z = {z:.6}");
            return Err(Issue::says(what).with_advice(cure));
        }
        let q = if (length - 1.0).abs() < 1e-12 { q } else { q / length };
        Ok(match frame {
            RotationFrame::Link => Pose { position_m, rotation: q },
            RotationFrame::Optical => Pose::from_rotation(position_m, DMat3::from_quat(q), frame),
        })
    }

    /// Rotation of the optical frame (z forward, x right, y down).
    pub fn optical(&self) -> DMat3 {
        self.link() * LINK_FROM_OPTICAL
    }

    /// Rotation of the link frame (x forward, y left, z up).
    pub fn link(&self) -> DMat3 {
        DMat3::from_quat(self.rotation)
    }
}

/// The unit quaternion of one in a file. Zeros turn nothing, as the libraries of ROS, Gazebo and three.js have it. `None`
/// if its length is not finite.
pub(crate) fn unit_quaternion(quaternion: DQuat) -> Option<DQuat> {
    let length = quaternion.length();
    match length > 1e-9 {
        _ if !length.is_finite() => None,
        true => Some(quaternion / length),
        false => Some(DQuat::IDENTITY),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(m: DMat3) -> [[i32; 3]; 3] {
        [m.x_axis, m.y_axis, m.z_axis].map(|c| c.to_array().map(|v| (v * 1000.0).round() as i32))
    }

    #[test]
    fn facing_a_wall() {
        let pose = Pose::facing(DVec3::ZERO, DVec3::Y, 0.0, 0.0);
        assert_eq!(columns(pose.optical()), [[1000, 0, 0], [0, 0, -1000], [0, 1000, 0]]);
        let down = Pose::facing(DVec3::ZERO, -DVec3::Z, 0.0, 0.0);
        assert_eq!(columns(down.optical()), [[0, -1000, 0], [-1000, 0, 0], [0, 0, -1000]]);
    }

    #[test]
    fn a_trace_of_sideways_is_vertical() {
        for trace in [6e-17, 1e-200, -1e-300] {
            let facing = DVec3::new(trace, trace, -1.0);
            let (down, straight) = [facing, -DVec3::Z].map(|f| Pose::facing(DVec3::ZERO, f, 0.0, 0.0)).into();
            assert_eq!(columns(down.optical()), columns(straight.optical()), "{trace}");
            let upright = Pose::upright(DVec3::ZERO, facing, 0.0);
            assert_eq!(columns(upright.link()), columns(DMat3::IDENTITY), "{trace}");
        }
    }

    #[test]
    fn tilt_is_up_and_pan_is_left() {
        let angle = 30f64.to_radians();
        let up = Pose::facing(DVec3::ZERO, DVec3::X, 0.0, angle).optical().z_axis;
        assert!(up.z > 0.49 && up.y.abs() < 1e-12);
        let left = Pose::facing(DVec3::ZERO, DVec3::X, angle, 0.0).optical().z_axis;
        assert!(left.y > 0.49 && left.z.abs() < 1e-12);
    }

    #[test]
    fn every_way_of_saying_a_rotation_agrees() {
        let facing = Pose::facing(DVec3::ONE, DVec3::new(0.0, -1.0, 0.0), 0.0, 0.0);
        let rpy =
            Pose::from_rotation(DVec3::ONE, from_rpy([0.0, 0.0, (-90f64).to_radians()]), RotationFrame::Link);
        let half = 0.5f64.sqrt();
        let link = Pose::from_quaternion(DVec3::ONE, [half, 0.0, 0.0, -half], RotationFrame::Link).unwrap();
        let optical = Pose::from_quaternion(
            DVec3::ONE,
            [0.0, 0.0, -half * 1.0009, half * 1.0009],
            RotationFrame::Optical,
        )
        .unwrap();
        for other in [rpy, link, optical] {
            assert_eq!(columns(other.optical()), columns(facing.optical()));
        }
    }

    #[test]
    fn a_quaternion_of_another_length_is_refused() {
        for (wxyz, expected) in [
            ([0.0; 4], "must not be zero, and all four finite"),
            ([f64::NAN, 0.0, 0.0, 1.0], "must not be zero, and all four finite"),
            (
                [0.0, 0.0, 0.0, 1.0011],
                "must have a length of 1 within 0.001, and has 1.0011: of length 1 it is w = 0",
            ),
            ([0.5, 0.0, 0.0, 0.5], "has 0.7071: of length 1 it is w = 0.707107, x = 0.000000, y = 0"),
        ] {
            let found =
                Pose::from_quaternion(DVec3::ZERO, wxyz, RotationFrame::Link).unwrap_err().to_string();
            assert!(found.contains(expected), "{wxyz:?}: {found}");
        }
    }

    #[test]
    fn upright_scanners_spin_about_world_z() {
        let tilted = Pose::upright(DVec3::ZERO, DVec3::new(0.0, 1.0, -0.5), 0.0);
        assert_eq!(columns(tilted.link()), [[0, 1000, 0], [-1000, 0, 0], [0, 0, 1000]]);
        let down = Pose::upright(DVec3::ZERO, -DVec3::Z, 0.0);
        assert_eq!(columns(down.link()), [[1000, 0, 0], [0, 1000, 0], [0, 0, 1000]]);
    }
}
