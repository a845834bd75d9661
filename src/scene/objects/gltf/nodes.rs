//! Puts the nodes of a glTF file where the scene has them, by their own transforms or an animation's.

use std::collections::HashMap;

use ::gltf::json::{Index, Node, Root};
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3};

use super::container::Container;
use super::{MemoryLimit, Moved};

use crate::pose::unit_quaternion;
use perirobot_march::error::{Issue, Site};

/// Deepest nesting of nodes that is read; each node repeats the names of all above it.
const MAX_DEPTH: usize = 256;

/// A node where the scene puts it.
pub(super) struct PlacedNode<'a> {
    pub(super) index: usize,
    pub(super) json: &'a Node,
    /// Index of the parent among the placed nodes, which come parents first.
    parent: Option<usize>,
    depth: usize,
    /// Whether it is not shown, like all below it.
    pub(super) is_hidden: bool,
    pub(super) world_from_node: DAffine3,
}

impl PlacedNode<'_> {
    /// Whether a scale of 0 leaves nothing of its mesh. A skin's joints place a mesh, not its node.
    pub(super) fn is_nothing(&self) -> bool {
        self.json.skin.is_none() && self.world_from_node.matrix3 == DMat3::ZERO
    }
}

/// The nodes of the scene, parents first, some of them moved from where the file has them.
pub(super) fn place_nodes<'a>(
    container: &'a Container,
    moved: &HashMap<usize, Moved>,
) -> Result<Vec<PlacedNode<'a>>, Issue> {
    let root = &container.root;
    let mut placed: Vec<PlacedNode> = Vec::new();
    let mut reached = vec![false; root.nodes.len()];
    let roots = root_nodes(root)?;
    // A stack of our own: a tree nested as deep as the file allows would overflow the thread's.
    let mut open: Vec<(usize, Option<usize>)> = roots.iter().rev().map(|i| (*i, None)).collect();
    while let Some((index, parent)) = open.pop() {
        let json = (root.nodes.get(index)).ok_or_else(|| {
            Issue::says(format!("a scene or node refers to nodes[{index}]"))
                .with_advice(format!("there are {}", root.nodes.len()))
        })?;
        if std::mem::replace(&mut reached[index], true) {
            return Err(
                Issue::says(format!("nodes[{index}] is reached twice")).with_advice("nodes must form a tree")
            );
        }
        let (depth, world_from_parent, is_hidden) = match parent.map(|slot: usize| &placed[slot]) {
            Some(parent) => (parent.depth + 1, parent.world_from_node, parent.is_hidden),
            None => (1, DAffine3::IDENTITY, false),
        };
        if depth > MAX_DEPTH {
            return Err(Issue::too_large(format!("nodes[{index}] is nested more than {MAX_DEPTH} deep"))
                .with_advice("flatten the tree"));
        }
        let parent_from_node = parent_from_node(json, moved.get(&index))
            .map_err(|issue| issue.with_place(Site::Table(format!("nodes[{index}]"))))?;
        let children = json.children.iter().flatten().rev();
        open.extend(children.map(|child| (child.value(), Some(placed.len()))));
        placed.push(PlacedNode {
            index,
            json,
            parent,
            depth,
            is_hidden: is_hidden || container.hidden.contains(&index),
            world_from_node: world_from_parent * parent_from_node,
        });
    }
    if root.scenes.is_empty()
        && let Some(index) = reached.iter().position(|reached| !reached)
    {
        return Err(Issue::says(format!("nodes[{index}] is among its own ancestors"))
            .with_advice("nodes must form a tree"));
    }
    Ok(placed)
}

/// The roots of the default scene, else of the first, else all nodes without a parent.
fn root_nodes(root: &Root) -> Result<Vec<usize>, Issue> {
    let scene = root.scene.as_ref().map_or(0, Index::value);
    if let Some(scene) = root.scenes.get(scene) {
        return Ok(scene.nodes.iter().map(Index::value).collect());
    }
    if root.scene.is_some() {
        return Err(Issue::value("scene", scene, format!("there are {} scenes", root.scenes.len())));
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
fn parent_from_node(node: &Node, moved: Option<&Moved>) -> Result<DAffine3, Issue> {
    let wide = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    if let Some(matrix) = node.matrix {
        if moved.is_some_and(Moved::is_placed) {
            return Err(Issue::says("an animated node needs translation, rotation and scale instead")
                .with_place("matrix"));
        }
        let matrix = DMat4::from_cols_array(&matrix.map(f64::from));
        if !matrix.is_finite() || matrix.row(3) != glam::DVec4::W {
            return Err(Issue::says("must be finite, with 0, 0, 0, 1 as its last row").with_place("matrix"));
        }
        return Ok(DAffine3::from_mat4(matrix));
    }
    let moved = moved.cloned().unwrap_or_default();
    let translation = moved.translation.unwrap_or(wide(node.translation.unwrap_or_default()));
    let scale = moved.scale.unwrap_or(wide(node.scale.unwrap_or([1.0; 3])));
    let own = || DQuat::from_array(node.rotation.unwrap_or_default().0.map(f64::from));
    let rotation = moved.rotation.unwrap_or_else(own);
    if !translation.is_finite() || !scale.is_finite() {
        return Err(Issue::says("must be finite").with_place("translation or scale"));
    }
    // The file's quaternion has unit length in f32 only, which would stretch what hangs on it.
    let rotation = unit_quaternion(rotation)
        .ok_or_else(|| Issue::says("must be a quaternion of finite length").with_place("rotation"))?;
    Ok(DAffine3::from_scale_rotation_translation(scale, rotation, translation))
}

/// Names from the root down to a node, which the file's budget pays for.
pub(super) fn names(
    placed: &[PlacedNode],
    node: &PlacedNode,
    budget: &mut MemoryLimit,
) -> Result<Vec<String>, Issue> {
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
