//! Reads glTF 2.0 files (`.glb`, `.gltf`) as one mesh a node, in metres, turned from glTF's y up to the
//! world's z up, at any moment of an animation.
//!
//! Only shapes are read, blended with their morph targets; materials, cameras and lights are ignored. Indices and sizes in the file are
//! checked where they are used, because the parser's own readers trust them.

mod accessor;
mod animation;
mod container;
mod morph;
mod nodes;
mod skin;
mod sparse;
mod surface;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use ::gltf::json::Root;
use wildmatch::WildMatch;

use self::animation::Moved;
pub use self::animation::{Clip, WhichClip};
use self::container::Container;
use super::Mesh;
use crate::source::{Layered, MemoryLimit, Sources, is_step};
use crate::spelling::plural;
use perirobot_march::Result;
use perirobot_march::error::Issue;

/// A file that was read, to be posed as often as needed.
pub struct Gltf {
    path: PathBuf,
    container: Container,
}

/// The triangles of one node.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeMesh {
    /// Names of the nodes from the root down to this one; nodes without a name are left out. That of the part comes last
    /// in a STEP file.
    pub names: Vec<String>,
    /// The layers that it is on, if it is of a STEP file that was read by layers. Other nodes that the same rules
    /// match may be on some of them in its place.
    pub layers: Vec<String>,
    /// In metres, z up; equal positions share a vertex.
    pub mesh: Mesh,
}

impl Gltf {
    /// Reads a file with its buffers.
    ///
    /// # Errors
    /// When the file or a buffer cannot be read, or needs an extension.
    pub fn load(path: &Path, sources: &Sources) -> Result<Gltf> {
        let container = Container::open(path, sources)?;
        refuse_extensions(&container.root).map_err(|issue| issue.with_place(path))?;
        if let count @ 1.. = container.hidden.len() {
            let nodes = plural(count, "node");
            sources.remark(path, format!("without {nodes} that KHR_node_visibility hides, and all below"));
        }
        if let count @ 1.. = nodes_of_scale_0(&container) {
            sources.remark(path, format!("without {} of scale 0", plural(count, "node")));
        }
        Ok(Gltf { path: path.into(), container })
    }

    /// The nodes of a STEP file with their layers, read so that each pattern matches all of a node or nothing of it.
    ///
    /// # Errors
    /// When the file cannot be read or converted, or has no triangle at all.
    pub(crate) fn step_layers(
        path: &Path,
        patterns: &[WildMatch],
        sources: &Sources,
    ) -> Result<Vec<NodeMesh>> {
        let mut nodes = Vec::new();
        for Layered { layers, glb } in sources.convert_step_layers(path, patterns)? {
            let gltf = Gltf { path: path.into(), container: Container::parse(path, &glb, sources)? };
            // A group may have curves only.
            let group = gltf.read_nodes(None).map_err(|issue| issue.with_place(path))?;
            nodes.extend(group.into_iter().map(|node| NodeMesh { layers: layers.clone(), ..node }));
        }
        refuse_nothing(&nodes).map_err(|issue| issue.with_place(path))?;
        Ok(nodes)
    }

    /// One of its animations.
    ///
    /// # Errors
    /// When there is no such animation, or several of that name, or it moves no node, or contradicts itself.
    pub fn clip(&self, which: &WhichClip) -> Result<Clip> {
        Clip::read(&self.container, which, &mut self.budget())
            .map_err(|issue| issue.with_place(&self.path).into())
    }

    /// The default scene's nodes (or the first scene's, or all nodes) that have triangles, parents first: as
    /// the nodes stand in the file, or as a clip of this file moves them at a time in seconds.
    ///
    /// # Errors
    /// When the file contradicts itself, has a position that is not finite, or has no triangle at all.
    pub fn parts(&self, moment: Option<(&Clip, f64)>) -> Result<Vec<NodeMesh>> {
        let nodes = self.read_nodes(moment).and_then(|nodes| refuse_nothing(&nodes).map(|()| nodes));
        nodes.map_err(|issue| issue.with_place(&self.path).into())
    }

    /// All nodes as they stand in the file, as one mesh.
    ///
    /// # Errors
    /// As [`Gltf::parts`].
    pub(crate) fn whole(&self) -> Result<Mesh> {
        let mut whole = Mesh::default();
        self.parts(None)?.iter().for_each(|node| whole.append(&node.mesh));
        Ok(whole)
    }

    fn read_nodes(&self, moment: Option<(&Clip, f64)>) -> Result<Vec<NodeMesh>, Issue> {
        let container = &self.container;
        let mut budget = self.budget();
        let moved = moment.map(|(clip, time_s)| clip.move_nodes(time_s)).transpose()?.unwrap_or_default();
        let placed = nodes::place_nodes(container, &moved)?;
        let mut meshes = Vec::new();
        for node in placed.iter().filter(|node| !node.is_hidden && !node.is_nothing()) {
            let Some(mesh) = &node.json.mesh else { continue };
            let weights = moved.get(&node.index).and_then(|moved| moved.weights.as_deref());
            let mesh = surface::read_mesh(container, mesh.value(), node, weights, &placed, &mut budget)
                .map_err(|issue| issue.with_place(format!("nodes[{}]", node.index)))?;
            if !mesh.triangles.is_empty() {
                let mut names = nodes::names(&placed, node, &mut budget)?;
                if is_step(&self.path) {
                    // Many CAD programs name the places of parts NAUO1, NAUO2, …: the mesh has the part's name.
                    let mesh = container.root.meshes.get(node.json.mesh.map_or(0, |mesh| mesh.value()));
                    let part = mesh.and_then(|mesh| mesh.name.clone());
                    names.extend(part.filter(|part| names.last() != Some(part)));
                }
                meshes.push(NodeMesh { names, layers: Vec::new(), mesh });
            }
        }
        Ok(meshes)
    }

    fn budget(&self) -> MemoryLimit {
        MemoryLimit::new(self.container.bytes)
    }
}

fn refuse_nothing(nodes: &[NodeMesh]) -> Result<(), Issue> {
    match nodes.is_empty() {
        true => Err(Issue::says("has no triangle in its scene").with_advice("export the surfaces as meshes")),
        false => Ok(()),
    }
}

/// How many nodes with a mesh have no extent; an animation may give them one.
fn nodes_of_scale_0(container: &Container) -> usize {
    if !container.root.animations.is_empty() {
        return 0;
    }
    let placed = nodes::place_nodes(container, &HashMap::new()).unwrap_or_default();
    placed.iter().filter(|node| node.json.mesh.is_some() && !node.is_hidden && node.is_nothing()).count()
}

fn refuse_extensions(root: &Root) -> Result<(), Issue> {
    let instancing = "EXT_mesh_gpu_instancing";
    if root.extensions_used.iter().any(|name| name == instancing) {
        return Err(Issue::value(
            "extensionsUsed",
            instancing,
            "not supported, export each copy as a node of its own",
        ));
    }
    let mut required = root.extensions_required.iter().map(String::as_str);
    match required.find(|name| *name != VISIBILITY && !is_about_looks(name)) {
        None => Ok(()),
        Some(name) if name.contains("draco") || name.contains("meshopt") => Err(Issue::value(
            "extensionsRequired",
            name,
            "the meshes are compressed, export again without compression",
        )),
        Some(name) => Err(Issue::value(
            "extensionsRequired",
            format!("{name:.80}"),
            "not supported, export again as plain glTF 2.0",
        )),
    }
}

/// Says whether a node is shown.
const VISIBILITY: &str = "KHR_node_visibility";

/// Whether an extension changes how surfaces look and not where they are.
fn is_about_looks(extension: &str) -> bool {
    let (_, name) = extension.split_once('_').unwrap_or_default();
    let looks = [
        "materials_",
        "material_",
        "texture_",
        "lights_",
        "image_",
        "techniques_",
        "xmp",
        "packing_",
        "environment_",
    ];
    looks.iter().any(|begin| name.starts_with(begin))
}

#[cfg(test)]
mod animation_tests;
#[cfg(test)]
mod tests;
