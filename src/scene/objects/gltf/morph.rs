//! Blends the corners of a mesh with its morph targets, in f64: each target moves them by its weight times a
//! displacement, before joints or nodes place them.

use ::gltf::json::accessor::Accessor;
use ::gltf::json::mesh::Primitive;
use ::gltf::json::{Index, Mesh, Root};
use glam::DVec3;

use super::MemoryLimit;
use super::accessor::Elements;
use super::container::Container;
use super::nodes::PlacedNode;
use perirobot_march::error::Issue;

/// The targets of a primitive that move it at a moment, with their weights.
#[derive(Default)]
pub(super) struct Blend<'a> {
    targets: Vec<(f64, Elements<'a>)>,
}

/// How many morph targets the mesh of a node has.
pub(super) fn targets_of_node(root: &Root, node: usize) -> Result<usize, Issue> {
    let mesh = root.nodes[node].mesh.as_ref().and_then(|mesh| root.meshes.get(mesh.value()));
    let mesh = mesh.ok_or_else(|| {
        Issue::says(format!("blends shapes of nodes[{node}]")).with_advice("that node must have a mesh")
    })?;
    targets(mesh)
}

/// How many morph targets each primitive of a mesh has.
fn targets(mesh: &Mesh) -> Result<usize, Issue> {
    let mut counts = mesh.primitives.iter().map(|primitive| primitive.targets.iter().flatten().count());
    let first = counts.next().unwrap_or_default();
    match counts.find(|&count| count != first) {
        None => Ok(first),
        Some(other) => Err(Issue::says(format!("its primitives have {first} and {other} morph targets"))
            .with_advice("all must have as many")),
    }
}

/// A weight for each morph target of a node's mesh: an animation's, else the node's own, else the mesh's, else none.
pub(super) fn weights(mesh: &Mesh, node: &PlacedNode, animated: Option<&[f64]>) -> Result<Vec<f64>, Issue> {
    let targets = targets(mesh)?;
    if targets == 0 {
        return Ok(Vec::new());
    }
    let own = node.json.weights.as_ref().or(mesh.weights.as_ref());
    let own = || own.map(|weights| weights.iter().map(|&weight| f64::from(weight)).collect());
    let weights = animated.map(<[f64]>::to_vec).or_else(own).unwrap_or_else(|| vec![0.0; targets]);
    match weights.len() == targets && weights.iter().all(|weight| weight.is_finite()) {
        true => Ok(weights),
        false => Err(Issue::says(format!("has {} weights", weights.len()))
            .with_advice(format!("must be finite, one for each of its {targets} morph targets"))),
    }
}

impl<'a> Blend<'a> {
    /// The targets of a primitive with so many corners that have a weight.
    pub(super) fn read(
        container: &'a Container,
        primitive: &Primitive,
        weights: &[f64],
        vertices: usize,
        budget: &mut MemoryLimit,
    ) -> Result<Blend<'a>, Issue> {
        let mut blend = Blend::default();
        for (number, (target, &weight)) in primitive.targets.iter().flatten().zip(weights).enumerate() {
            let (Some(positions), true) = (target.positions, weight != 0.0) else { continue };
            if is_zero(container, positions) {
                continue;
            }
            let at = |issue: Issue| issue.with_place(format!("targets[{number}]"));
            let positions = Elements::positions(container, positions).map_err(at)?;
            if positions.count != vertices {
                return Err(at(Issue::says(format!("moves {} positions", positions.count))
                    .with_advice(format!("there are {vertices}"))));
            }
            // Many nodes can share a mesh without triangles.
            budget.spend(size_of::<(f64, Elements)>() as u64)?;
            blend.targets.push((weight, positions));
        }
        Ok(blend)
    }

    /// A corner of the mesh where its targets move it.
    pub(super) fn blend(&self, position: DVec3, vertex: usize) -> DVec3 {
        self.targets.iter().fold(position, |sum, (weight, target)| sum + *weight * target.position(vertex))
    }

    /// What blending a triangle costs, expressed in bytes of memory.
    pub(super) fn bytes_per_triangle(&self) -> u64 {
        3 * (self.targets.len() * size_of::<DVec3>()) as u64
    }
}

/// Whether an accessor names no bytes at all: it is zero everywhere, and so moves nothing.
fn is_zero(container: &Container, index: Index<Accessor>) -> bool {
    let accessor = container.root.accessors.get(index.value());
    accessor.is_some_and(|accessor| accessor.buffer_view.is_none() && accessor.sparse.is_none())
}

#[cfg(test)]
mod tests;
