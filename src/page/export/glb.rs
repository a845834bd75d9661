//! The cell with its placed sensors as glTF, for Blender and web viewers: metres, y up, a node for each object and
//! sensor, coloured by role. Surfaces are those of the scene, not of voxels.

use std::borrow::Cow;
use std::collections::{BTreeMap, HashSet};

use glam::DVec3;
use gltf::binary::{Glb, Header};
use gltf::json::validation::Checked::Valid;
use gltf::json::{Index, Root, accessor, buffer, material, mesh, scene};

use perirobot_decide::view::{Outline, View};
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_scene::objects::{Mesh, Role, Scene, Surface, polygon};

/// Length of a sensor's pyramid or cone in metres.
const FIGURE_M: f64 = 0.3;
/// Half the width of the figure of an all-round sensor, in metres.
const ALL_AROUND_M: f64 = 0.06;
/// Height of the plate drawn for a pad or a gate.
const PLATE_M: f64 = 0.02;

/// Materials: name, colour (linear red, green, blue, opacity).
const MATERIALS: [(&str, [f32; 4]); 4] = [
    ("environment", [0.45, 0.45, 0.47, 1.0]),
    ("robot", [0.0, 0.17, 0.45, 1.0]),
    ("human", [0.79, 0.35, 0.0, 1.0]),
    ("sensor", [0.0, 0.34, 0.17, 0.6]),
];

/// The bytes of a `.glb`, and the number of its objects and sensors. `scene` is the source of the view's world.
pub(crate) fn bytes(view: &View, of: &Scene) -> Result<(Vec<u8>, usize)> {
    let mut writer = GlbWriter::new();
    for object in of.objects.iter().filter(|object| !object.tag_only) {
        let mesh = match &object.surface {
            Surface::Mesh(mesh) => Cow::Borrowed(mesh),
            Surface::Voxels { resolution_m, keys } => Cow::Owned(faces(*resolution_m, keys)),
        };
        let material = match object.role {
            Role::Environment => 0,
            Role::Robot => 1,
            Role::Human => 2,
        };
        writer.node(&object.name, &mesh, material)?;
    }
    for member in &view.members {
        let sensor = &view.study.sensors[member.sensor];
        let name = format!("{}:{}", sensor.name, sensor.candidates[member.candidate].name);
        let plates = view.grounds(member).iter().map(|corners| plate(corners)).collect::<Result<Vec<_>>>()?;
        for mesh in view.outline(member).map(|outline| figure(&outline)).into_iter().chain(plates) {
            writer.node(&name, &mesh, 3)?;
        }
    }
    writer.finish()
}

/// A pyramid or cone from a sensor's lens, or an octahedron for an all-round sensor.
pub(super) fn figure(outline: &Outline) -> Mesh {
    let apex = outline.apex_m;
    if outline.rim.is_empty() {
        let ends = [DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y, DVec3::Z, -DVec3::Z];
        let vertices = ends.map(|end| apex + end * ALL_AROUND_M).to_vec();
        let sides = (0..4).flat_map(|i| [[i, (i + 1) % 4, 4], [(i + 1) % 4, i, 5]]);
        return Mesh { vertices, triangles: sides.collect() };
    }
    // All of the rim has the same depth, so that the figure ends in a plane.
    let middle = outline.rim.iter().sum::<DVec3>().normalize();
    let rim = outline.rim.iter().map(|dir| apex + *dir * (FIGURE_M / dir.dot(middle).max(0.1)));
    let count = outline.rim.len() as u32;
    let vertices = [apex, apex + middle * FIGURE_M].into_iter().chain(rim).collect();
    let next = |i: u32| 2 + (i + 1) % count;
    let sides = (0..count).flat_map(|i| [[0, 2 + i, next(i)], [1, next(i), 2 + i]]);
    Mesh { vertices, triangles: sides.collect() }
}

/// A plate on the ground watched by a pad or a gate.
pub(super) fn plate(corners: &[DVec3]) -> Result<Mesh> {
    let count = corners.len() as u32;
    let next = |i: u32| (i + 1) % count;
    let mut around = corners.to_vec();
    let turn: f64 = (0..count).map(|i| corners[i as usize].cross(corners[next(i) as usize]).z).sum();
    // Anticlockwise as seen from above.
    if turn < 0.0 {
        around.reverse();
    }
    let lids = polygon::triangles(&around)?;
    let mut mesh = Mesh { vertices: around.clone(), triangles: Vec::new() };
    mesh.vertices.extend(around.iter().map(|corner| *corner + DVec3::Z * PLATE_M));
    for [a, b, c] in lids.into_iter().map(|lid| lid.map(|i| i as u32)) {
        mesh.triangles.extend([[a, c, b], [count + a, count + b, count + c]]);
    }
    let sides = (0..count).flat_map(|i| [[i, next(i), count + next(i)], [i, count + next(i), count + i]]);
    mesh.triangles.extend(sides);
    Ok(mesh)
}

/// The faces of voxels that no other voxel covers.
pub fn faces(edge_m: f64, keys: &[[i32; 3]]) -> Mesh {
    let filled: HashSet<[i32; 3]> = keys.iter().copied().collect();
    let mut mesh = Mesh::default();
    for &key in keys {
        for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            let mut beside = key;
            beside[axis] += 2 * side - 1;
            if filled.contains(&beside) {
                continue;
            }
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let base = mesh.vertices.len() as u32;
            // Anticlockwise as seen from outside.
            let around =
                if side == 1 { [[0, 0], [1, 0], [1, 1], [0, 1]] } else { [[0, 0], [0, 1], [1, 1], [1, 0]] };
            mesh.vertices.extend(around.map(|[on_u, on_v]| {
                let mut corner = key;
                corner[axis] += side;
                corner[u] += on_u;
                corner[v] += on_v;
                DVec3::from_array(corner.map(f64::from)) * edge_m
            }));
            mesh.triangles.extend([[base, base + 1, base + 2], [base, base + 2, base + 3]]);
        }
    }
    mesh
}

/// A partly written file.
struct GlbWriter {
    root: Root,
    nodes: Vec<Index<scene::Node>>,
    binary: Vec<u8>,
}

impl GlbWriter {
    fn new() -> Self {
        let mut root = Root::default();
        root.asset.generator = Some(concat!("perirobot ", env!("CARGO_PKG_VERSION")).into());
        let blank = buffer::Buffer {
            byte_length: 0usize.into(),
            name: None,
            uri: None,
            extensions: None,
            extras: Default::default(),
        };
        root.push(blank);
        for (name, colour) in MATERIALS {
            let mut material = material::Material { name: Some(name.into()), ..Default::default() };
            material.pbr_metallic_roughness.base_color_factor = material::PbrBaseColorFactor(colour);
            material.pbr_metallic_roughness.metallic_factor = material::StrengthFactor(0.0);
            material.double_sided = true;
            if colour[3] < 1.0 {
                material.alpha_mode = Valid(material::AlphaMode::Blend);
            }
            root.push(material);
        }
        GlbWriter { root, nodes: Vec::new(), binary: Vec::new() }
    }

    /// Adds a named mesh in the world's frame (z up).
    fn node(&mut self, name: &str, mesh: &Mesh, material: u32) -> Result<()> {
        if mesh.triangles.is_empty() {
            return Ok(());
        }
        // glTF is y up.
        let turned = mesh.vertices.iter().map(|v| [v.x as f32, v.z as f32, -v.y as f32]);
        let corners: Vec<[f32; 3]> = turned.collect();
        let most = |better: fn(f32, f32) -> f32| {
            corners.iter().skip(1).fold(corners[0], |a, b| std::array::from_fn(|r| better(a[r], b[r])))
        };
        let bounds = [most(f32::min), most(f32::max)];
        let positions = self.accessor(bytemuck::cast_slice(&corners), corners.len(), Some(bounds))?;
        let indices = self.accessor(bytemuck::cast_slice(&mesh.triangles), 3 * mesh.triangles.len(), None)?;
        let primitive = mesh::Primitive {
            attributes: BTreeMap::from([(Valid(mesh::Semantic::Positions), positions)]),
            indices: Some(indices),
            material: Some(Index::new(material)),
            mode: Valid(mesh::Mode::Triangles),
            targets: None,
            extensions: None,
            extras: Default::default(),
        };
        let mesh = mesh::Mesh {
            name: Some(name.into()),
            primitives: vec![primitive],
            weights: None,
            extensions: None,
            extras: Default::default(),
        };
        let mesh = self.root.push(mesh);
        let node = scene::Node { name: Some(name.into()), mesh: Some(mesh), ..Default::default() };
        self.nodes.push(self.root.push(node));
        Ok(())
    }

    /// Adds positions (with their bounds) or indices.
    fn accessor(
        &mut self,
        bytes: &[u8],
        count: usize,
        bounds: Option<[[f32; 3]; 2]>,
    ) -> Result<Index<accessor::Accessor>> {
        let view = buffer::View {
            buffer: Index::new(0),
            byte_length: bytes.len().into(),
            byte_offset: Some(self.binary.len().into()),
            byte_stride: None,
            name: None,
            target: Some(Valid(match bounds {
                Some(_) => buffer::Target::ArrayBuffer,
                None => buffer::Target::ElementArrayBuffer,
            })),
            extensions: None,
            extras: Default::default(),
        };
        self.binary.extend_from_slice(bytes);
        if self.binary.len() > 0x7fff_ffff {
            return Err(Issue::too_large("the surfaces need more than 2 GiB, more than viewers can read")
                .with_place("cell.glb")
                .into());
        }
        let (component, kind) = match bounds {
            Some(_) => (accessor::ComponentType::F32, accessor::Type::Vec3),
            None => (accessor::ComponentType::U32, accessor::Type::Scalar),
        };
        let value = |corner: [f32; 3]| serde_json::Value::from(corner.to_vec());
        let view = self.root.push(view);
        Ok(self.root.push(accessor::Accessor {
            buffer_view: Some(view),
            byte_offset: None,
            count: count.into(),
            component_type: Valid(accessor::GenericComponentType(component)),
            type_: Valid(kind),
            min: bounds.map(|[low, _]| value(low)),
            max: bounds.map(|[_, high]| value(high)),
            name: None,
            normalized: false,
            sparse: None,
            extensions: None,
            extras: Default::default(),
        }))
    }

    fn finish(self) -> Result<(Vec<u8>, usize)> {
        let GlbWriter { mut root, nodes, binary } = self;
        let count = nodes.len();
        root.buffers[0].byte_length = binary.len().into();
        let whole = scene::Scene { name: None, nodes, extensions: None, extras: Default::default() };
        root.scene = Some(root.push(whole));
        let failed = |e: &dyn std::fmt::Display| Error::device(format!("cannot write cell.glb: {e}"));
        let json = root.to_vec().map_err(|e| failed(&e))?;
        let header = Header { magic: *b"glTF", version: 2, length: 0 };
        let glb = Glb { header, json: json.into(), bin: Some(binary.into()) };
        Ok((glb.to_vec().map_err(|e| failed(&e))?, count))
    }
}
