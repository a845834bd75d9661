//! Writes a tree of meshes as a GLB file, the same bytes every time. It is no general exporter: positions and
//! indices only, one primitive a node, nothing moved by nodes.

use glam::DVec3;
use perirobot_scene::objects::Mesh;
use perirobot_scene::objects::primitive::cuboid;

/// A node in the world's convention (z up, metres); the writer turns it to glTF's y up.
pub(crate) struct GlbNode {
    pub(crate) name: &'static str,
    pub(crate) mesh: Option<Mesh>,
    pub(crate) children: Vec<GlbNode>,
}

/// A box with these corners. They are in world coordinates, not moved by nodes, so that f32 rounds each of
/// them only once.
pub(crate) fn slab(low: [f64; 3], high: [f64; 3]) -> Mesh {
    let corners = [DVec3::from(low), DVec3::from(high)];
    let mut mesh = cuboid(DVec3::ONE);
    for vertex in &mut mesh.vertices {
        *vertex =
            DVec3::from_array(std::array::from_fn(|axis| corners[usize::from(vertex[axis] > 0.0)][axis]));
    }
    mesh
}

/// A node that is a box with these corners.
pub(crate) fn part(name: &'static str, low: [f64; 3], high: [f64; 3]) -> GlbNode {
    GlbNode { name, mesh: Some(slab(low, high)), children: vec![] }
}

/// A node without a mesh.
pub(crate) fn group(name: &'static str, children: Vec<GlbNode>) -> GlbNode {
    GlbNode { name, mesh: None, children }
}

/// The bytes of a GLB with one scene, whose root is `root`.
pub(crate) fn bytes(root: &GlbNode) -> Vec<u8> {
    let mut writer = Writer::default();
    writer.node(root);
    let Writer { nodes, meshes, accessors, views, mut binary } = writer;
    let mut json = format!(
        concat!(
            r#"{{"asset":{{"version":"2.0","generator":"perirobot tests/input/generated_meshes.rs"}},"#,
            r#""scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{}],"meshes":[{}],"accessors":[{}],"#,
            r#""bufferViews":[{}],"buffers":[{{"byteLength":{}}}]}}"#
        ),
        nodes.join(","),
        meshes.join(","),
        accessors.join(","),
        views.join(","),
        binary.len()
    )
    .into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    binary.resize(binary.len().next_multiple_of(4), 0);

    let mut bytes = b"glTF".to_vec();
    bytes.extend(2u32.to_le_bytes());
    bytes.extend(((12 + 8 + json.len() + 8 + binary.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", binary)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

#[derive(Default)]
struct Writer {
    nodes: Vec<String>,
    meshes: Vec<String>,
    accessors: Vec<String>,
    views: Vec<String>,
    binary: Vec<u8>,
}

impl Writer {
    fn node(&mut self, node: &GlbNode) -> usize {
        let index = self.nodes.len();
        self.nodes.push(String::new());
        let mut fields = vec![format!(r#""name":"{}""#, node.name)];
        if let Some(mesh) = &node.mesh {
            fields.push(format!(r#""mesh":{}"#, self.mesh(node.name, mesh)));
        }
        if !node.children.is_empty() {
            let children: Vec<String> =
                (node.children.iter()).map(|child| self.node(child).to_string()).collect();
            fields.push(format!(r#""children":[{}]"#, children.join(",")));
        }
        self.nodes[index] = format!("{{{}}}", fields.join(","));
        index
    }

    fn mesh(&mut self, name: &str, mesh: &Mesh) -> usize {
        let positions: Vec<[f32; 3]> = mesh.vertices.iter().map(|v| y_up(*v)).collect();
        let limit = |pick: fn(f32, f32) -> f32| {
            let limit = positions[1..]
                .iter()
                .fold(positions[0], |limit, p| std::array::from_fn(|axis| pick(limit[axis], p[axis])));
            format!("[{},{},{}]", limit[0], limit[1], limit[2])
        };
        let kind = format!(r#""type":"VEC3","min":{},"max":{}"#, limit(f32::min), limit(f32::max));
        let position_bytes = positions.as_flattened().iter().flat_map(|x| x.to_le_bytes());
        let position = self.accessor(position_bytes.collect(), 34962, 5126, positions.len(), &kind);
        let corners = mesh.triangles.as_flattened();
        let corner_bytes = corners.iter().flat_map(|i| i.to_le_bytes());
        let kind = r#""type":"SCALAR""#;
        let indices = self.accessor(corner_bytes.collect(), 34963, 5125, corners.len(), kind);
        self.meshes.push(format!(
            r#"{{"name":"{name}","primitives":[{{"attributes":{{"POSITION":{position}}},"indices":{indices}}}]}}"#
        ));
        self.meshes.len() - 1
    }

    /// Every element has 4 bytes or 12, so views stay aligned without padding.
    fn accessor(&mut self, bytes: Vec<u8>, target: u32, component: u32, count: usize, kind: &str) -> usize {
        let index = self.accessors.len();
        self.views.push(format!(
            r#"{{"buffer":0,"byteOffset":{},"byteLength":{},"target":{target}}}"#,
            self.binary.len(),
            bytes.len()
        ));
        self.accessors
            .push(format!(r#"{{"bufferView":{index},"componentType":{component},"count":{count},{kind}}}"#));
        self.binary.extend(bytes);
        index
    }
}

/// glTF's y is the world's z, its z the world's −y. Adding zero turns −0 into 0.
fn y_up(v: DVec3) -> [f32; 3] {
    [v.x as f32 + 0.0, v.z as f32 + 0.0, -v.y as f32 + 0.0]
}
