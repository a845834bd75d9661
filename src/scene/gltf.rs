//! Reads glTF 2.0 files (`.glb`, `.gltf`) as one mesh a node, in metres, turned from glTF's y up to the world's
//! z up. Which node is which object, and where the file stands in the cell, is for others.
//!
//! Only shape is read: materials, morphs, cameras, lights and animations are passed over. A mesh that a skeleton
//! poses is refused, since it would stand in its bind pose. Indices and
//! sizes in the file are checked where they are used, because the parser's own readers trust them.

mod accessor;
mod container;

use std::path::Path;

use ::gltf::json::{
    Index, Node, Root,
    mesh::{Mode, Primitive, Semantic},
    validation::Checked,
};
use glam::{DAffine3, DMat4, DQuat, DVec3};

use self::accessor::Elements;
use self::container::Container;
use super::Mesh;
use super::mesh::Welder;
use crate::{Error, Result};

/// Deepest nesting of nodes that is read; each node repeats the names of all above it.
const MAX_DEPTH: usize = 256;
/// What any file may unfold to, in bytes, before its own size gives it more: a mesh may be placed many times.
const FLOOR_BYTES: u64 = 256 << 20;
/// Bytes a file may unfold to for each of its own; a plain export needs about 4.
const BYTES_PER_BYTE: u64 = 64;
/// What a triangle costs while its corners are welded, at most.
const TRIANGLE_BYTES: u64 = 160;

/// The triangles of one node.
#[derive(Clone, Debug, PartialEq)]
pub struct NodeMesh {
    /// Names of the nodes from the root down to this one; nodes without a name are left out.
    pub names: Vec<String>,
    /// In metres, z up; equal positions share a vertex.
    pub mesh: Mesh,
}

/// Reads the default scene's nodes (or the first scene's, or all nodes) that have triangles, parents first.
///
/// # Errors
/// When the file or a buffer cannot be read, needs an extension, contradicts itself, has a position that is not
/// finite, or has no triangle at all.
pub fn load(path: &Path) -> Result<Vec<NodeMesh>> {
    let container = Container::open(path)?;
    read_nodes(&container).map_err(|what| Error::input(path.display(), what))
}

fn read_nodes(container: &Container) -> Result<Vec<NodeMesh>, String> {
    refuse_extensions(&container.root)?;
    let mut budget = Budget(FLOOR_BYTES + BYTES_PER_BYTE * container.bytes);
    let placed = place_nodes(&container.root)?;
    let mut meshes = Vec::new();
    for node in &placed {
        let Some(mesh) = node.json.mesh else { continue };
        let mesh = read_mesh(container, mesh.value(), node.world_from_node, &mut budget)
            .map_err(|what| format!("nodes[{}]: {what}", node.index))?;
        if !mesh.triangles.is_empty() {
            let names = names(&placed, node, &mut budget)?;
            meshes.push(NodeMesh { names, mesh });
        }
    }
    if meshes.is_empty() {
        return Err("has no triangle in its scene: export the surfaces as meshes".into());
    }
    Ok(meshes)
}

fn refuse_extensions(root: &Root) -> Result<(), String> {
    let instancing = "EXT_mesh_gpu_instancing";
    if root.extensions_used.iter().any(|name| name == instancing) {
        return Err(format!(
            "extensionsUsed = {instancing}: not supported, export each copy as a node of its own"
        ));
    }
    match root.extensions_required.first().map(String::as_str) {
        None => Ok(()),
        Some(name) if name.contains("draco") || name.contains("meshopt") => Err(format!(
            "extensionsRequired = {name}: the meshes are compressed, export again without compression"
        )),
        Some(name) => {
            Err(format!("extensionsRequired = {name:.80}: not supported, export again as plain glTF 2.0"))
        }
    }
}

/// Memory a file may still ask for.
struct Budget(u64);

impl Budget {
    fn spend(&mut self, bytes: u64) -> Result<(), String> {
        self.0 = (self.0.checked_sub(bytes)).ok_or(
            "unfolds to far more than its size: place fewer copies of its meshes, or split the file",
        )?;
        Ok(())
    }
}

/// A node where the scene puts it.
struct Placed<'a> {
    index: usize,
    json: &'a Node,
    /// Index of the parent among the placed nodes, which come parents first.
    parent: Option<usize>,
    depth: usize,
    world_from_node: DAffine3,
}

fn place_nodes(root: &Root) -> Result<Vec<Placed<'_>>, String> {
    let mut placed: Vec<Placed> = Vec::new();
    let mut reached = vec![false; root.nodes.len()];
    let roots = root_nodes(root)?;
    // A stack of our own: a tree nested as deep as the file allows would overflow the thread's.
    let mut open: Vec<(usize, Option<usize>)> = roots.iter().rev().map(|i| (*i, None)).collect();
    while let Some((index, parent)) = open.pop() {
        let json = (root.nodes.get(index)).ok_or_else(|| {
            format!("a scene or node refers to nodes[{index}]: there are {}", root.nodes.len())
        })?;
        if std::mem::replace(&mut reached[index], true) {
            return Err(format!("nodes[{index}] is reached twice: nodes must form a tree"));
        }
        let (depth, world_from_parent) = match parent {
            Some(slot) => (placed[slot].depth + 1, placed[slot].world_from_node),
            None => (1, DAffine3::IDENTITY),
        };
        if depth > MAX_DEPTH {
            return Err(format!("nodes[{index}] is nested more than {MAX_DEPTH} deep: flatten the tree"));
        }
        let parent_from_node = parent_from_node(json).map_err(|what| format!("nodes[{index}].{what}"))?;
        if json.mesh.is_some() && json.skin.is_some() {
            return Err(format!(
                "nodes[{index}] is posed by a skeleton (skin): export it with the pose applied to the mesh"
            ));
        }
        let children = json.children.iter().flatten().rev();
        open.extend(children.map(|child| (child.value(), Some(placed.len()))));
        placed.push(Placed {
            index,
            json,
            parent,
            depth,
            world_from_node: world_from_parent * parent_from_node,
        });
    }
    if root.scenes.is_empty()
        && let Some(index) = reached.iter().position(|reached| !reached)
    {
        return Err(format!("nodes[{index}] is among its own ancestors: nodes must form a tree"));
    }
    Ok(placed)
}

/// The roots of the default scene, else of the first, else all nodes that are nobody's child.
fn root_nodes(root: &Root) -> Result<Vec<usize>, String> {
    let scene = root.scene.as_ref().map_or(0, Index::value);
    if let Some(scene) = root.scenes.get(scene) {
        return Ok(scene.nodes.iter().map(Index::value).collect());
    }
    if root.scene.is_some() {
        return Err(format!("scene = {scene}: there are {} scenes", root.scenes.len()));
    }
    let mut is_root = vec![true; root.nodes.len()];
    for child in root.nodes.iter().flat_map(|n| n.children.iter().flatten()) {
        if let Some(is_root) = is_root.get_mut(child.value()) {
            *is_root = false;
        }
    }
    Ok((0..root.nodes.len()).filter(|i| is_root[*i]).collect())
}

/// A node's own transform, composed in f64 from the file's f32.
fn parent_from_node(node: &Node) -> Result<DAffine3, String> {
    let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    if let Some(matrix) = node.matrix {
        let matrix = DMat4::from_cols_array(&matrix.map(f64::from));
        if !matrix.is_finite() || matrix.row(3) != glam::DVec4::W {
            return Err("matrix: must be finite, with 0, 0, 0, 1 as its last row".into());
        }
        return Ok(DAffine3::from_mat4(matrix));
    }
    let translation = wide(node.translation.unwrap_or_default());
    let scale = wide(node.scale.unwrap_or([1.0; 3]));
    let rotation = DQuat::from_array(node.rotation.unwrap_or_default().0.map(f64::from));
    if !translation.is_finite() || !scale.is_finite() {
        return Err("translation or scale: must be finite".into());
    }
    // The file's quaternion has unit length in f32 only, which would stretch what hangs on it.
    let length = rotation.length();
    if !(length.is_finite() && length > 0.0) {
        return Err("rotation: must be a quaternion with a finite length above zero".into());
    }
    let rotation = rotation / length;
    Ok(DAffine3::from_scale_rotation_translation(scale, rotation, translation))
}

fn names(placed: &[Placed], node: &Placed, budget: &mut Budget) -> Result<Vec<String>, String> {
    let mut names = Vec::new();
    let mut next = Some(node);
    while let Some(node) = next {
        if let Some(name) = &node.json.name {
            budget.spend((size_of::<String>() + name.len()) as u64)?;
            names.push(name.clone());
        }
        next = node.parent.map(|slot| &placed[slot]);
    }
    names.reverse();
    Ok(names)
}

fn read_mesh(
    container: &Container,
    index: usize,
    world_from_node: DAffine3,
    budget: &mut Budget,
) -> Result<Mesh, String> {
    let json = (container.root.meshes.get(index))
        .ok_or_else(|| format!("mesh = {index}: there are {}", container.root.meshes.len()))?;
    let mut welder = Welder::default();
    for (number, primitive) in json.primitives.iter().enumerate() {
        read_primitive(container, primitive, &mut welder, budget).map_err(|what| {
            let name = json.name.as_deref().unwrap_or_default();
            format!("meshes[{index}] {name:?} primitives[{number}]: {what}")
        })?;
    }
    let mut mesh = welder.finish();
    for vertex in &mut mesh.vertices {
        let p = world_from_node.transform_point3(*vertex);
        *vertex = DVec3::new(p.x, -p.z, p.y);
        if !vertex.is_finite() {
            return Err(format!("meshes[{index}]: its transforms move a vertex to infinity"));
        }
    }
    // A mirror turns triangles inside out; glTF wants them turned back.
    if world_from_node.matrix3.determinant() < 0.0 {
        for triangle in &mut mesh.triangles {
            triangle.swap(1, 2);
        }
    }
    Ok(mesh)
}

fn read_primitive(
    container: &Container,
    primitive: &Primitive,
    welder: &mut Welder,
    budget: &mut Budget,
) -> Result<(), String> {
    // Even an empty primitive takes time, and a mesh of many can be placed many times.
    budget.spend(TRIANGLE_BYTES)?;
    let mode = match primitive.mode {
        Checked::Valid(mode) => mode,
        Checked::Invalid => return Err("mode: must be 0 to 6".into()),
    };
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        return Ok(());
    }
    let positions =
        (primitive.attributes).get(&Checked::Valid(Semantic::Positions)).ok_or("attributes lack POSITION")?;
    let positions = Elements::positions(container, *positions)?;
    let indices = match primitive.indices {
        Some(index) => Some(Elements::indices(container, index)?),
        None => None,
    };
    let count = indices.as_ref().map_or(positions.count, |i| i.count);
    let triangles = match mode {
        Mode::Triangles if count % 3 != 0 => {
            return Err(format!("has {count} corners: triangles need a multiple of 3"));
        }
        Mode::Triangles => count / 3,
        _ => count.saturating_sub(2),
    };
    budget.spend(triangles as u64 * TRIANGLE_BYTES)?;

    let corner = |place: usize| -> Result<DVec3, String> {
        let vertex = indices.as_ref().map_or(place, |i| i.index(place));
        if vertex >= positions.count {
            return Err(format!("index {place} is {vertex}: there are {} positions", positions.count));
        }
        let position = positions.position(vertex);
        if !position.is_finite() {
            return Err(format!("position {vertex} is {position}: must be finite"));
        }
        Ok(position)
    };
    for i in 0..triangles {
        let places = match mode {
            Mode::Triangles => [3 * i, 3 * i + 1, 3 * i + 2],
            // Every second triangle of a strip runs the other way round.
            Mode::TriangleStrip => [i, i + 1 + i % 2, i + 2 - i % 2],
            _ => [i + 1, i + 2, 0],
        };
        welder.triangle([corner(places[0])?, corner(places[1])?, corner(places[2])?]);
    }
    Ok(())
}

#[cfg(test)]
mod tests;
