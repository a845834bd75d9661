//! Reads the triangles of a glTF mesh and puts them where a node, or the joints of a skin, have them.

use ::gltf::json::mesh::{Mode, Primitive, Semantic};
use ::gltf::json::validation::Checked;
use glam::{DAffine3, DVec3};

use super::MemoryLimit;
use super::accessor::Elements;
use super::container::Container;
use super::morph::{self, Blend};
use super::nodes::PlacedNode;
use super::skin::{Influences, Skin};
use crate::objects::Mesh;
use crate::objects::mesh::Welder;
use perirobot_march::error::Issue;

/// What a triangle costs while its corners are welded, at most.
const TRIANGLE_BYTES: u64 = 160;

/// A mesh where its node, or the joints of the node's skin, put it; the world's z is up. `weights` are those of an
/// animation, if it blends the mesh's morph targets.
pub(super) fn read_mesh(
    container: &Container,
    index: usize,
    node: &PlacedNode,
    weights: Option<&[f64]>,
    placed: &[PlacedNode],
    budget: &mut MemoryLimit,
) -> Result<Mesh, Issue> {
    let json = (container.root.meshes.get(index))
        .ok_or_else(|| Issue::value("mesh", index, format!("there are {}", container.root.meshes.len())))?;
    let skin = match node.json.skin {
        Some(skin) => Some(Skin::read(container, skin.value(), placed, budget)?),
        None => None,
    };
    let name = json.name.as_deref().unwrap_or_default();
    let weights = morph::weights(json, node, weights);
    let weights = weights.map_err(|issue| issue.with_place(format!("meshes[{index}] {name:?}")))?;
    let mut welder = Welder::default();
    for (number, primitive) in json.primitives.iter().enumerate() {
        let posed = (skin.as_ref(), weights.as_slice());
        read_primitive(container, primitive, posed, &mut welder, budget)
            .map_err(|issue| issue.with_place(format!("meshes[{index}] {name:?} primitives[{number}]")))?;
    }
    let mut mesh = welder.finish();
    // A skin's joints have placed the corners already; where its node stands has no effect.
    let world_from_mesh = if skin.is_some() { DAffine3::IDENTITY } else { node.world_from_node };
    for vertex in &mut mesh.vertices {
        let p = world_from_mesh.transform_point3(*vertex);
        *vertex = DVec3::new(p.x, -p.z, p.y);
        if !vertex.is_finite() {
            return Err(Issue::says(format!("meshes[{index}]"))
                .with_advice("its transforms move a vertex to infinity"));
        }
    }
    // A mirror turns triangles inside out; glTF wants them turned back.
    if world_from_mesh.matrix3.determinant() < 0.0 {
        for triangle in &mut mesh.triangles {
            triangle.swap(1, 2);
        }
    }
    Ok(mesh)
}

fn read_primitive(
    container: &Container,
    primitive: &Primitive,
    (skin, weights): (Option<&Skin>, &[f64]),
    welder: &mut Welder,
    budget: &mut MemoryLimit,
) -> Result<(), Issue> {
    // Even an empty primitive takes time, and a mesh of many can be placed many times.
    budget.spend(TRIANGLE_BYTES)?;
    let mode = match primitive.mode {
        Checked::Valid(mode) => mode,
        Checked::Invalid => return Err(Issue::says("mode").with_advice("must be 0 to 6")),
    };
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        return Ok(());
    }
    let positions = (primitive.attributes)
        .get(&Checked::Valid(Semantic::Positions))
        .ok_or_else(|| Issue::says("attributes lack POSITION"))?;
    let positions = Elements::positions(container, *positions)?;
    let influences = match skin {
        Some(_) => Influences::read(container, primitive, positions.count, budget)?,
        None => Influences::default(),
    };
    let blend = Blend::read(container, primitive, weights, positions.count, budget)?;
    let indices = match primitive.indices {
        Some(index) => Some(Elements::indices(container, index)?),
        None => None,
    };
    let count = indices.as_ref().map_or(positions.count, |i| i.count);
    let triangles = match mode {
        Mode::Triangles if count % 3 != 0 => {
            return Err(
                Issue::says(format!("has {count} corners")).with_advice("triangles need a multiple of 3")
            );
        }
        Mode::Triangles => count / 3,
        _ => count.saturating_sub(2),
    };
    let each = TRIANGLE_BYTES + influences.bytes_per_triangle() + blend.bytes_per_triangle();
    budget.spend((triangles as u64).saturating_mul(each))?;

    let corner = |place: usize| -> Result<DVec3, Issue> {
        let vertex = indices.as_ref().map_or(place, |i| i.index(place));
        if vertex >= positions.count {
            return Err(Issue::says(format!("index {place} is {vertex}"))
                .with_advice(format!("there are {} positions", positions.count)));
        }
        let position = blend.blend(positions.position(vertex), vertex);
        if !position.is_finite() {
            return Err(Issue::says(format!("position {vertex} is {position}")).with_advice("must be finite"));
        }
        skin.map_or(Ok(position), |skin| skin.pose(position, &influences, vertex))
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
