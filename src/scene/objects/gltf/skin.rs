//! Poses the corners of a mesh by the joints of its skeleton, in f64.

use std::collections::HashMap;

use ::gltf::json::accessor::Type;
use ::gltf::json::mesh::{Primitive, Semantic};
use ::gltf::json::validation::Checked;
use glam::{DAffine3, DMat4, DVec3, DVec4};

use super::MemoryLimit;
use super::accessor::Elements;
use super::container::Container;
use super::nodes::PlacedNode;

use perirobot_march::error::Issue;

/// A skeleton at one moment.
pub(super) struct Skin {
    index: usize,
    /// For each joint, where it takes a corner of the mesh at rest.
    world_from_mesh: Vec<DAffine3>,
}

/// Which joints move each corner of a primitive, four in a set, and with which weight.
#[derive(Default)]
pub(super) struct Influences<'a> {
    sets: Vec<(Elements<'a>, Elements<'a>)>,
}

impl Skin {
    pub(super) fn read(
        container: &Container,
        index: usize,
        placed: &[PlacedNode],
        budget: &mut MemoryLimit,
    ) -> Result<Skin, Issue> {
        let skins = &container.root.skins;
        let json = skins
            .get(index)
            .ok_or_else(|| Issue::value("skin", index, format!("there are {}", skins.len())))?;
        budget.spend((placed.len() * size_of::<(usize, usize)>()) as u64)?;
        budget.spend((json.joints.len() * size_of::<DAffine3>()) as u64)?;
        let slots: HashMap<usize, &PlacedNode> = placed.iter().map(|node| (node.index, node)).collect();
        let joint_from_mesh = inverse_binds(container, index)?;
        let joints = json.joints.iter().zip(joint_from_mesh).enumerate();
        let world_from_mesh = joints.map(|(number, (joint, joint_from_mesh))| {
            let node = slots.get(&joint.value()).ok_or_else(|| {
                Issue::value(
                    format!("skins[{index}].joints[{number}]"),
                    joint.value(),
                    "no such node in the scene",
                )
            })?;
            Ok(node.world_from_node * joint_from_mesh)
        });
        Ok(Skin { index, world_from_mesh: world_from_mesh.collect::<Result<_, Issue>>()? })
    }

    /// Where the joints put a corner of the mesh: the weighted mean of where each joint alone would put it.
    pub(super) fn pose(
        &self,
        position: DVec3,
        influences: &Influences,
        vertex: usize,
    ) -> Result<DVec3, Issue> {
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for (joints, weights) in &influences.sets {
            for slot in 0..4 {
                let weight = weights.number(vertex, slot);
                if !(weight.is_finite() && weight >= 0.0) {
                    return Err(Issue::says(format!("WEIGHTS of vertex {vertex} hold {weight}"))
                        .with_advice("must be 0 or more"));
                }
                if weight == 0.0 {
                    continue;
                }
                let joint = joints.index_of(vertex, slot);
                let world_from_mesh = self.world_from_mesh.get(joint).ok_or_else(|| {
                    let count = self.world_from_mesh.len();
                    Issue::says(format!("JOINTS of vertex {vertex} name joint {joint}"))
                        .with_advice(format!("skins[{}] has {count}", self.index))
                })?;
                sum += weight * world_from_mesh.transform_point3(position);
                total += weight;
            }
        }
        if total == 0.0 {
            return Err(Issue::says(format!("vertex {vertex} has no weight"))
                .with_advice("bind each vertex to a joint"));
        }
        Ok(sum / total)
    }
}

/// For each joint of a skin, where the mesh at rest is in the joint's own frame.
fn inverse_binds(container: &Container, index: usize) -> Result<Vec<DAffine3>, Issue> {
    let json = &container.root.skins[index];
    let Some(accessor) = json.inverse_bind_matrices else {
        return Ok(vec![DAffine3::IDENTITY; json.joints.len()]);
    };
    let at = |issue: Issue| issue.with_place(format!("skins[{index}].inverseBindMatrices"));
    let matrices = Elements::floats(container, accessor, Type::Mat4, "must be MAT4 of float").map_err(at)?;
    if matrices.count < json.joints.len() {
        return Err(at(Issue::says(format!("has {} for {} joints", matrices.count, json.joints.len()))));
    }
    let matrix = |joint: usize| {
        let columns: [f64; 16] = std::array::from_fn(|c| matrices.number(joint, c));
        let matrix = DMat4::from_cols_array(&columns);
        // Exporters that invert in f32 leave a trace in the last row.
        if !matrix.is_finite() || (matrix.row(3) - DVec4::W).abs().max_element() > 1e-3 {
            return Err(at(Issue::says(format!(
                "matrix {joint} must be finite, with 0, 0, 0, 1 as its last row"
            ))));
        }
        Ok(DAffine3::from_mat4(matrix))
    };
    (0..json.joints.len()).map(matrix).collect()
}

impl<'a> Influences<'a> {
    /// All sets of a primitive: JOINTS_0 with WEIGHTS_0, and further ones.
    pub(super) fn read(
        container: &'a Container,
        primitive: &Primitive,
        vertices: usize,
        budget: &mut MemoryLimit,
    ) -> Result<Influences<'a>, Issue> {
        let mut sets = Vec::new();
        for set in 0.. {
            let get = |semantic| primitive.attributes.get(&Checked::Valid(semantic));
            let (joints, weights) = (get(Semantic::Joints(set)), get(Semantic::Weights(set)));
            let (joints, weights) = match (joints, weights) {
                (Some(joints), Some(weights)) => (joints, weights),
                (None, None) if set > 0 => break,
                _ => {
                    return Err(Issue::says(format!(
                        "a mesh with a skin needs both JOINTS_{set} and WEIGHTS_{set}"
                    )));
                }
            };
            let joints = Elements::joints(container, *joints)?;
            let weights = Elements::weights(container, *weights)?;
            if joints.count != vertices || weights.count != vertices {
                let (joints, weights) = (joints.count, weights.count);
                return Err(Issue::says(format!(
                    "has {vertices} positions, but {joints} JOINTS_{set} and {weights} WEIGHTS_{set}"
                )));
            }
            // Many nodes can share a skin without triangles.
            budget.spend(size_of::<(Elements, Elements)>() as u64)?;
            sets.push((joints, weights));
        }
        Ok(Influences { sets })
    }

    /// What posing a triangle costs, expressed in bytes of memory.
    pub(super) fn bytes_per_triangle(&self) -> u64 {
        3 * 4 * (self.sets.len() * size_of::<DVec3>()) as u64
    }
}
