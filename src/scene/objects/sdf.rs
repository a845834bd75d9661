//! Reads worlds and models of Gazebo (SDF): boxes, cylinders, spheres, capsules, ellipsoids, finite planes and meshes of
//! links, where their poses put them, with the models that a file includes. Joints are at 0.
//!
//! What has no shape is passed over; lights, plugins, sensors, actors and shapes that are not read are counted, to be
//! told. glTF is turned to z up, and COLLADA's up axis is not honoured, as in Gazebo.

mod element;
mod geometry;
mod include;
mod model;
mod pose;
mod state;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DAffine3;

use super::gltf::NodeMesh;
use super::urdf::GeometryUse;
use crate::source::Sources;
use geometry::Meshes;
use model::Model;
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};

/// A world, and what the user says about it.
#[derive(Clone, Debug, PartialEq)]
pub struct SdfFile {
    /// The file.
    pub path: PathBuf,
    /// Which of its geometry counts.
    pub geometry: GeometryUse,
    /// The folders in which `model://name` is looked for.
    pub models: Vec<PathBuf>,
}

/// A world that was read.
#[derive(Debug)]
pub struct SdfWorld {
    /// A mesh for each link with a body; its names are those of the link and of the models around it, from the inside
    /// out.
    pub links: Vec<NodeMesh>,
    /// What was left out, and how often.
    pub left_out: BTreeMap<String, usize>,
}

/// Reads a world with all that it includes, in metres, z up. Curved bodies stay within `sag_m` of their true surface.
///
/// # Errors
/// When a file cannot be read, is no SDF, a number is not what it must be, a pose is relative to nothing that is there, a
/// model is not found, or nothing has a body.
pub(super) fn load(file: &SdfFile, sources: &Sources, sag_m: f64) -> Result<SdfWorld> {
    let mut reader = include::WorldReader::new(file, sources);
    let mut world = reader.world()?;
    world.index();
    let mut links = Vec::new();
    let mut meshes =
        Meshes { sources, sag_m, triangles_left: geometry::MOST_TRIANGLES, read: Default::default() };
    place(&world, DAffine3::IDENTITY, &[], &mut meshes, &mut links)?;
    if links.is_empty() {
        let bare = Issue::says("no link has a body of that geometry").with_advice(
            "write geometry = \"visual\" (or \"collision\") in the scene file, or name another world",
        );
        return Err(bare.with_place(&file.path).into());
    }
    Ok(SdfWorld { links, left_out: reader.left_out })
}

/// The links of a model and of those in it, in the world.
fn place(
    model: &Model,
    world_from_model: DAffine3,
    around: &[String],
    meshes: &mut Meshes,
    links: &mut Vec<NodeMesh>,
) -> Result<()> {
    let at = |issue: Issue| Error::from(issue.with_place(model.place()).with_place(&*model.file));
    let names: Vec<String> = model.name.iter().cloned().chain(around.iter().cloned()).collect();
    for link in &model.links {
        let world_from_link = world_from_model * model.pose(&link.pose, model::OWN).map_err(at)?;
        let of_link = |e: Error| {
            e.with_place(format!("link {:?}", link.name)).with_place(model.place()).with_place(&*model.file)
        };
        let mesh = meshes.whole(&link.bodies, world_from_link).map_err(of_link)?;
        if !mesh.triangles.is_empty() {
            let names = [std::slice::from_ref(&link.name), &names[..]].concat();
            links.push(NodeMesh { names, layers: Vec::new(), mesh });
        }
    }
    for inner in &model.models {
        let world_from_inner = world_from_model * model.place_of(inner).map_err(at)?;
        place(inner, world_from_inner, &names, meshes, links)?;
    }
    Ok(())
}

impl SdfWorld {
    /// What was left out, as a sentence about the object.
    pub(super) fn warning(&self) -> Option<String> {
        let each = self.left_out.iter().map(|(what, count)| match count {
            1 => what.clone(),
            count => format!("{what} ({count})"),
        });
        let each: Vec<String> = each.collect();
        (!each.is_empty()).then(|| format!("is an SDF world of which this is left out: {}", each.join(", ")))
    }
}

/// A file with the path that messages name.
type File = std::rc::Rc<Path>;

#[cfg(test)]
mod tests;
