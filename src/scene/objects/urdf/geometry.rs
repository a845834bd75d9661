//! The bodies of a robot as triangles, one mesh a link.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use glam::{DAffine3, DMat3, DVec3};

use super::{GeometryUse, LinkShape, Packages, PlacedShape, RobotModel};
use crate::objects::mesh_file::load_mesh;
use crate::objects::{Mesh, primitive, unknown_link};
use crate::source::Sources;
use perirobot_march::Result;
use perirobot_march::error::Issue;

/// Most triangles of a robot: a mesh may be placed many times, and each costs memory.
const MOST_TRIANGLES: usize = 20_000_000;

impl RobotModel {
    /// The triangles of every link in the link's own frame, parents before children; empty
    /// for a link without bodies. Round bodies stay within `sag_m` of their true surface.
    ///
    /// # Errors
    /// When a mesh cannot be found or read, its format is not known, or no link has a body of the kind asked
    /// for.
    pub(crate) fn meshes(
        &self,
        geometry: GeometryUse,
        packages: &Packages,
        sources: &Sources,
        sag_m: f64,
    ) -> Result<Vec<Mesh>> {
        let in_file = |issue: Issue| issue.with_place(&self.path);
        let mut files = Files { urdf: &self.path, packages, sources, read: HashMap::new() };
        let mut triangles = 0;
        let mut meshes = Vec::with_capacity(self.links.len());
        for link in &self.links {
            let (kind, bodies) = match geometry {
                GeometryUse::Collision => ("collision", &link.collision),
                GeometryUse::Visual => ("visual", &link.visual),
            };
            let mut whole = Mesh::default();
            for (number, body) in bodies.iter().enumerate() {
                let mesh = body.mesh(sag_m, &mut files).map_err(|e| {
                    e.with_place(format!("link {:?}: {kind} {}", link.name, number + 1))
                        .with_place(&self.path)
                })?;
                triangles += mesh.triangles.len();
                if triangles > MOST_TRIANGLES {
                    let what = format!("has more than {MOST_TRIANGLES} triangles");
                    let issue = Issue::too_large(what).with_advice("simplify its meshes");
                    return Err(in_file(issue).into());
                }
                whole.append(&mesh);
            }
            meshes.push(whole);
        }
        if triangles == 0 {
            return Err(in_file(self.bare(geometry)).into());
        }
        Ok(meshes)
    }

    /// The number of a link among [`RobotModel::meshes`].
    ///
    /// # Errors
    /// Names the links there are.
    pub(crate) fn link_number(&self, name: &str) -> Result<usize, Issue> {
        let found = self.links.iter().position(|link| link.name == name);
        found.ok_or_else(|| {
            let links = self.links.iter().map(|link| link.name.as_str());
            unknown_link(name, links).with_place(&self.path)
        })
    }

    fn bare(&self, geometry: GeometryUse) -> Issue {
        let is_drawn = self.links.iter().any(|link| !link.visual.is_empty());
        let is_kept_clear = self.links.iter().any(|link| !link.collision.is_empty());
        match geometry {
            GeometryUse::Collision if is_drawn => Issue::says("no link has collision geometry")
                .with_advice("write geometry = \"visual\" in the scene file"),
            GeometryUse::Visual if is_kept_clear => Issue::says("no link has visual geometry")
                .with_advice("write geometry = \"collision\" in the scene file"),
            _ => Issue::says("no link has a body")
                .with_advice("give its links <collision> or <visual> geometry"),
        }
    }
}

/// All links as one mesh, each where its joints put it.
pub(crate) fn merge(meshes: &[Mesh], root_from_link: &[DAffine3]) -> Mesh {
    let mut whole = Mesh::default();
    for (mesh, root_from_link) in meshes.iter().zip(root_from_link) {
        whole.append(&mesh.place(root_from_link));
    }
    whole
}

/// The mesh files of a robot, each read once.
struct Files<'a> {
    urdf: &'a Path,
    packages: &'a Packages,
    sources: &'a Sources,
    read: HashMap<PathBuf, Rc<Mesh>>,
}

impl Files<'_> {
    fn mesh(&mut self, filename: &str) -> Result<Rc<Mesh>> {
        let path = self.packages.resolve(filename, self.urdf)?;
        if let Some(mesh) = self.read.get(&path) {
            return Ok(mesh.clone());
        }
        // The file's axes are the link's, whatever it says is up, as in RViz.
        let (mesh, _) = load_mesh(&path, self.sources)?;
        let mesh = Rc::new(mesh);
        self.read.insert(path, mesh.clone());
        Ok(mesh)
    }
}

impl PlacedShape {
    fn mesh(&self, sag_m: f64, files: &mut Files) -> Result<Mesh> {
        let (mesh, scale) = match &self.shape {
            LinkShape::Box { size_m } => (Rc::new(primitive::cuboid(*size_m)), DVec3::ONE),
            LinkShape::Sphere { radius_m } => (Rc::new(primitive::sphere(*radius_m, sag_m)), DVec3::ONE),
            LinkShape::Cylinder { radius_m, length_m } => {
                (Rc::new(primitive::cylinder(*radius_m, *length_m, sag_m)), DVec3::ONE)
            }
            LinkShape::Capsule { radius_m, length_m } => {
                (Rc::new(primitive::capsule(*radius_m, *length_m, sag_m)), DVec3::ONE)
            }
            LinkShape::Mesh { filename, scale } => {
                (files.mesh(filename).map_err(|e| e.with_place(format!("mesh {filename:?}")))?, *scale)
            }
        };
        let mesh = mesh.place(&(self.link_from_body * DAffine3::from_mat3(DMat3::from_diagonal(scale))));
        if mesh.vertices.iter().any(|vertex| !vertex.is_finite()) {
            return Err(Issue::says("its transforms move a vertex to infinity").into());
        }
        Ok(mesh)
    }
}
