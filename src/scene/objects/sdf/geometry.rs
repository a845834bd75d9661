//! The bodies of links as triangles.

use std::collections::HashMap;
use std::path::PathBuf;
use std::rc::Rc;

use glam::{DAffine3, DMat3, DQuat, DVec3};
use roxmltree::Node;

use super::element::{child, text};
use super::pose::{SdfPose, numbers};
use crate::objects::mesh_file::load_mesh;
use crate::objects::{Mesh, primitive};
use crate::source::Sources;
use perirobot_march::Result;
use perirobot_march::error::Issue;

/// Most triangles of a world: a mesh may be placed many times, and each costs memory.
pub(super) const MOST_TRIANGLES: usize = 20_000_000;
/// No body is smaller, in metres.
const SMALLEST_M: f64 = 1e-6;

/// A body at its place in a link; its pose may be relative to nothing else.
#[derive(Clone, Debug)]
pub(super) struct SdfShape {
    pub(super) pose: SdfPose,
    pub(super) shape: Shape,
}

/// A body, about its own frame.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    Box(DVec3),
    Cylinder {
        radius_m: f64,
        length_m: f64,
    },
    Capsule {
        radius_m: f64,
        length_m: f64,
    },
    Ellipsoid(DVec3),
    /// A rectangle, and which way it faces.
    Plane {
        size_m: [f64; 2],
        normal: DVec3,
    },
    Mesh {
        path: PathBuf,
        scale: DVec3,
    },
}

/// The shape of a `<geometry>`: none where it has no body, or one that is not read, whose name comes then.
pub(super) fn shape(
    geometry: Node,
    resolve: impl FnOnce(&str) -> Result<PathBuf, Issue>,
) -> Result<Result<Shape, Option<String>>, Issue> {
    let Some(node) = geometry.children().find(Node::is_element) else { return Ok(Err(None)) };
    let name = node.tag_name().name();
    let list = |key: &str, count: usize, default: Option<&[f64]>| {
        let written = text(node, key);
        let values = match (written, default) {
            (None, Some(default)) => Some(default.to_vec()),
            (written, _) => numbers(written.unwrap_or_default()),
        };
        values.filter(|values| values.len() == count).ok_or_else(|| {
            let what = if count == 1 { "a number".into() } else { format!("{count} numbers") };
            Issue::value(
                format!("{name}.{key}"),
                format!("{:?}", written.unwrap_or_default()),
                format!("must be {what}"),
            )
        })
    };
    let lengths = |key: &str, count: usize, default: Option<&[f64]>| {
        let values = list(key, count, default)?;
        match values.iter().all(|value| *value == 0.0 || *value >= SMALLEST_M) {
            true => Ok(values),
            false => Err(Issue::value(
                format!("{name}.{key}"),
                format!("{values:?}"),
                "must be 0, or 0.000001 m or more",
            )),
        }
    };
    let length = |key: &str| lengths(key, 1, None).map(|values| values[0]);
    let vector = |values: Vec<f64>| DVec3::from_slice(&values);
    // What has no surface is passed over; a plate without thickness has one.
    let (nothing, thinnest) = (Ok(Err(Some("body without extent".into()))), DVec3::splat(SMALLEST_M));
    let is_nothing = |size: DVec3| size.to_array().iter().filter(|edge| **edge == 0.0).count() > 1;
    Ok(Ok(match name {
        "cylinder" | "capsule" | "sphere" if length("radius")? == 0.0 => return nothing,
        "box" if is_nothing(vector(lengths("size", 3, None)?)) => return nothing,
        "ellipsoid" if is_nothing(vector(lengths("radii", 3, None)?)) => return nothing,
        "plane" if lengths("size", 2, Some(&[1.0, 1.0]))?.contains(&0.0) => return nothing,
        "box" => Shape::Box(vector(lengths("size", 3, None)?).max(thinnest)),
        "cylinder" => {
            Shape::Cylinder { radius_m: length("radius")?, length_m: length("length")?.max(SMALLEST_M) }
        }
        "capsule" => {
            Shape::Capsule { radius_m: length("radius")?, length_m: length("length")?.max(SMALLEST_M) }
        }
        "sphere" => Shape::Ellipsoid(DVec3::splat(length("radius")?)),
        "ellipsoid" => Shape::Ellipsoid(vector(lengths("radii", 3, None)?).max(thinnest)),
        "plane" => {
            let size = lengths("size", 2, Some(&[1.0, 1.0]))?;
            let normal = vector(list("normal", 3, Some(&[0.0, 0.0, 1.0]))?).try_normalize();
            let normal = normal.ok_or_else(|| Issue::says("plane.normal").with_advice("must not be zero"))?;
            Shape::Plane { size_m: [size[0], size[1]], normal }
        }
        "mesh" if child(node, "submesh").is_some() => return Ok(Err(Some("submesh of a mesh".into()))),
        "mesh" => {
            let scale = vector(list("scale", 3, Some(&[1.0; 3]))?);
            if scale.abs().min_element() < SMALLEST_M {
                return Err(Issue::value("mesh.scale", scale, "none may be zero (a minus mirrors)"));
            }
            let uri = text(node, "uri").ok_or_else(|| Issue::missing("uri").with_place("mesh"))?;
            Shape::Mesh { path: resolve(uri)?, scale }
        }
        "empty" => return Ok(Err(None)),
        other => return Ok(Err(Some(format!("{other:.40} geometry")))),
    }))
}

/// The mesh files of a world, each read once.
pub(super) struct Meshes<'a> {
    pub(super) sources: &'a Sources,
    pub(super) sag_m: f64,
    /// Of [`MOST_TRIANGLES`].
    pub(super) triangles_left: usize,
    pub(super) read: HashMap<PathBuf, Rc<Mesh>>,
}

impl Meshes<'_> {
    /// All bodies of a link as one mesh, in the world.
    pub(super) fn whole(&mut self, bodies: &[SdfShape], world_from_link: DAffine3) -> Result<Mesh> {
        let mut whole = Mesh::default();
        for body in bodies {
            let (mesh, own) = self.shape_mesh(&body.shape)?;
            let left = self.triangles_left.checked_sub(mesh.triangles.len()).ok_or_else(|| {
                let what = format!("with it, the world has more than {MOST_TRIANGLES} triangles");
                Issue::too_large(what).with_advice("simplify its meshes")
            })?;
            self.triangles_left = left;
            let mesh = mesh.place(&(world_from_link * body.pose.parent_from_own * own));
            if mesh.vertices.iter().any(|vertex| !vertex.is_finite()) {
                return Err(Issue::says("its transforms move a vertex to infinity").into());
            }
            whole.append(&mesh);
        }
        Ok(whole)
    }

    /// A body about its own frame, and where that is.
    fn shape_mesh(&mut self, shape: &Shape) -> Result<(Rc<Mesh>, DAffine3)> {
        let plain = |mesh| Ok((Rc::new(mesh), DAffine3::IDENTITY));
        match *shape {
            Shape::Box(size_m) => plain(primitive::cuboid(size_m)),
            Shape::Cylinder { radius_m, length_m } => {
                plain(primitive::cylinder(radius_m, length_m, self.sag_m))
            }
            Shape::Capsule { radius_m, length_m } => {
                plain(primitive::capsule(radius_m, length_m, self.sag_m))
            }
            Shape::Ellipsoid(radii_m) => plain(primitive::ellipsoid(radii_m, self.sag_m)),
            Shape::Plane { size_m, normal } => {
                let turn = DAffine3::from_quat(DQuat::from_rotation_arc(DVec3::Z, normal));
                Ok((Rc::new(primitive::plane(size_m)), turn))
            }
            Shape::Mesh { ref path, scale } => {
                let scale = DAffine3::from_mat3(DMat3::from_diagonal(scale));
                if let Some(mesh) = self.read.get(path) {
                    return Ok((mesh.clone(), scale));
                }
                let mesh = Rc::new(load_mesh(path, self.sources)?.0);
                self.read.insert(path.clone(), mesh.clone());
                Ok((mesh, scale))
            }
        }
    }
}
