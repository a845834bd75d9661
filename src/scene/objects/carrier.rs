//! An object that carries a sensor: its surface before a scene is built, and whether another one is in the way of a
//! place on it.

use glam::{DQuat, DVec3};

use super::loaded::{SceneFiles, with_key};
use super::parts::parts;
use super::spec::{ObjectSpec, SurfaceSpec, UrdfSpec};
use super::urdf::{self, AxisLimits, Envelope};
use super::{Mesh, Surface};
use crate::source::Sources;
use perirobot_march::Result;
use perirobot_march::error::Issue;

/// How far the triangles of a round body may be inside of it.
const SAG_M: f64 = 0.0005;
/// Lengths that differ by less are the same.
const NEARLY_M: f64 = 1e-6;

/// The surface of an object in its own frame, at the first moment of its scene. An object whose parts have names of their
/// own (`cell/beam*`) is named by the part. Its files are read, as they are again when worlds are made.
///
/// # Errors
/// When a file cannot be read, or it is a map of voxels.
pub fn read_surface(object: &ObjectSpec, name: &str, sources: &Sources) -> Result<Mesh> {
    let now = object.snapshot(0);
    let own = ObjectSpec { rotation: DQuat::IDENTITY, position_m: DVec3::ZERO, ..now };
    let mut whole = Mesh::default();
    for part in parts(&own, &mut SceneFiles::new(sources), SAG_M)? {
        match part.surface {
            Surface::Mesh(mesh) if part.name == name => whole.append(&mesh),
            Surface::Voxels { .. } => {
                return Err(Issue::says("is a map of voxels, which has no flat sides").into());
            }
            Surface::Mesh(_) => {}
        }
    }
    // A sheet is seen from both sides.
    if matches!(own.surface, SurfaceSpec::Plane { .. }) {
        let mut back = whole.clone();
        back.triangles.iter_mut().for_each(|triangle| triangle.swap(1, 2));
        whole.append(&back);
    }
    Ok(whole)
}

/// The surface of a robot's link in the link's frame.
///
/// # Errors
/// When a file cannot be read, or there is no such link.
pub fn read_link_surface(robot: &UrdfSpec, link: &str, sources: &Sources) -> Result<Mesh> {
    let model =
        urdf::load(&robot.path, &robot.xacro_args, &robot.packages, sources).map_err(with_key("urdf"))?;
    let number = model.link_number(link)?;
    let meshes = model.meshes(robot.geometry, &robot.packages, sources, SAG_M).map_err(with_key("urdf"))?;
    Ok(meshes.into_iter().nth(number).unwrap_or_default())
}

/// All that a robot reaches within the limits of its joints, in the frame of its root, with a tool of this length and of
/// any direction on the last links and on those named.
///
/// # Errors
/// When a file cannot be read, or a limit is not one of the robot's joints.
pub fn read_envelope(
    robot: &UrdfSpec,
    limits: &AxisLimits,
    tool: (f64, &[&str]),
    step_m: f64,
    sources: &Sources,
) -> Result<Envelope> {
    let model =
        urdf::load(&robot.path, &robot.xacro_args, &robot.packages, sources).map_err(with_key("urdf"))?;
    let meshes = model.meshes(robot.geometry, &robot.packages, sources, SAG_M).map_err(with_key("urdf"))?;
    Ok(model.envelope(&meshes, limits, tool, step_m)?)
}

impl ObjectSpec {
    /// Whether this object leaves no room for a sensor in front of another's surface, both places in the world: the sensor
    /// is inside of a body, behind a plane, or outside of a room in which the surface is. Of what is read from files, or
    /// carried by a robot, that is unknown here.
    pub fn is_in_the_way(&self, surface_m: DVec3, sensor_m: DVec3) -> bool {
        let own = |at: DVec3| self.rotation.inverse() * (at - self.position_m);
        let (foot, head) = (own(surface_m), own(sensor_m));
        let is_within = |at: DVec3, size_m: DVec3, more_m: f64| at.abs().cmple(size_m / 2.0 + more_m).all();
        let to_axis = head.truncate().length();
        match &self.surface {
            _ if self.on.is_some() => false,
            SurfaceSpec::Box { size_m } => is_within(head, *size_m, NEARLY_M),
            SurfaceSpec::Sphere { radius_m } => head.length() <= radius_m + NEARLY_M,
            SurfaceSpec::Cylinder { radius_m, height_m } => {
                to_axis <= radius_m + NEARLY_M && head.z.abs() <= height_m / 2.0 + NEARLY_M
            }
            SurfaceSpec::Capsule { radius_m, length_m } => {
                let beyond = (head.z.abs() - length_m / 2.0).max(0.0);
                to_axis.hypot(beyond) <= radius_m + NEARLY_M
            }
            SurfaceSpec::Room { size_m } => {
                is_within(foot, *size_m, NEARLY_M) && !is_within(head, *size_m, -NEARLY_M)
            }
            // What stands on a floor has a side that touches it.
            SurfaceSpec::Plane { size_m: [x, y] } => {
                let goes_down = foot.z >= -NEARLY_M && head.z < -NEARLY_M;
                let comes_up = foot.z < -NEARLY_M && head.z >= -NEARLY_M;
                (goes_down || comes_up) && is_within(head.with_z(0.0), DVec3::new(*x, *y, 0.0), NEARLY_M)
            }
            SurfaceSpec::Mesh(_)
            | SurfaceSpec::Octomap(_)
            | SurfaceSpec::Mannequin(_)
            | SurfaceSpec::Shipped(_)
            | SurfaceSpec::Urdf(_)
            | SurfaceSpec::Sdf(_) => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objects::spec::MotionSpec;
    use crate::objects::{Interior, Optical, RadarOptics, Role};

    fn object(surface: SurfaceSpec) -> ObjectSpec {
        ObjectSpec {
            name: "thing".into(),
            role: Role::Environment,
            interior: Interior::Ignored,
            optical: Optical::Opaque,
            radar: RadarOptics::Stops,
            speed_m_s: None,
            reflectance: None,
            specular: None,
            shade: 0,
            person_shade: 0,
            tag_only: false,
            on: None,
            position_m: DVec3::new(1.0, 0.0, 0.0),
            // A quarter turn about z: what is along x is along y.
            rotation: DQuat::from_rotation_z(std::f64::consts::FRAC_PI_2),
            surface,
            keypoints: None,
            nodes: Vec::new(),
            animated: None,
            motion: MotionSpec::default(),
        }
    }

    #[test]
    fn bodies_rooms_and_planes_are_in_the_way() {
        let at = DVec3::new;
        for (surface, foot, head, expected) in [
            (SurfaceSpec::Box { size_m: at(2.0, 0.2, 1.0) }, at(1.5, 0.9, 0.0), at(1.05, 0.9, 0.0), true),
            (SurfaceSpec::Box { size_m: at(2.0, 0.2, 1.0) }, at(1.5, 0.9, 0.0), at(1.15, 0.9, 0.0), false),
            (SurfaceSpec::Sphere { radius_m: 0.5 }, at(0.0, 0.0, 0.0), at(0.6, 0.0, 0.0), true),
            (SurfaceSpec::Sphere { radius_m: 0.5 }, at(0.0, 0.0, 0.0), at(0.6, 0.4, 0.4), false),
            (
                SurfaceSpec::Cylinder { radius_m: 0.1, height_m: 1.0 },
                at(1.3, 0.0, 0.0),
                at(1.1, 0.0, 0.4),
                true,
            ),
            (
                SurfaceSpec::Cylinder { radius_m: 0.1, height_m: 1.0 },
                at(1.3, 0.0, 0.0),
                at(1.1, 0.0, 0.6),
                false,
            ),
            (
                SurfaceSpec::Capsule { radius_m: 0.1, length_m: 1.0 },
                at(1.3, 0.0, 0.0),
                at(1.0, 0.0, 0.59),
                true,
            ),
            (
                SurfaceSpec::Capsule { radius_m: 0.1, length_m: 1.0 },
                at(1.3, 0.0, 0.0),
                at(1.08, 0.0, 0.59),
                false,
            ),
            // A beam that touches the wall of its room; the same beam at the free side.
            (SurfaceSpec::Room { size_m: at(4.0, 2.0, 3.0) }, at(2.0, 0.0, 1.0), at(2.05, 0.0, 1.0), true),
            (SurfaceSpec::Room { size_m: at(4.0, 2.0, 3.0) }, at(1.9, 0.0, 1.0), at(1.95, 0.0, 1.0), false),
            // Another room's beam.
            (SurfaceSpec::Room { size_m: at(4.0, 2.0, 3.0) }, at(2.5, 0.0, 1.0), at(2.6, 0.0, 1.0), false),
            // The underside of a box on the floor, its front, and a mat on the floor.
            (SurfaceSpec::Plane { size_m: [4.0, 4.0] }, at(1.0, 0.0, 0.0), at(1.0, 0.0, -0.05), true),
            (SurfaceSpec::Plane { size_m: [4.0, 4.0] }, at(1.0, 0.0, 0.5), at(1.05, 0.0, 0.5), false),
            (SurfaceSpec::Plane { size_m: [4.0, 4.0] }, at(1.0, 0.0, 0.0), at(1.0, 0.0, 0.05), false),
            (SurfaceSpec::Plane { size_m: [4.0, 4.0] }, at(4.0, 0.0, 0.0), at(4.0, 0.0, -0.05), false),
        ] {
            let thing = object(surface);
            assert_eq!(thing.is_in_the_way(foot, head), expected, "{:?} {foot} {head}", thing.surface);
        }
    }

    #[test]
    fn a_plane_has_two_sides_in_its_own_frame() {
        let sources = Sources::from_main("cell.toml".as_ref());
        let mesh =
            read_surface(&object(SurfaceSpec::Plane { size_m: [2.0, 1.0] }), "thing", &sources).unwrap();
        assert_eq!((mesh.triangles.len(), mesh.bounds().unwrap().1), (4, DVec3::new(1.0, 0.5, 0.0)));
        let none =
            read_surface(&object(SurfaceSpec::Plane { size_m: [2.0, 1.0] }), "thing/a*", &sources).unwrap();
        assert_eq!(none.triangles.len(), 0);
    }
}
