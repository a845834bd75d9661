//! Small files written by hand, each right or wrong in one way.

use base64::Engine as _;
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use serde_json::{Value, json};

use super::*;
use crate::objects::mesh::tests::{assert_closed, volume};
use crate::thorough::cases;

/// A tetrahedron's corners (48 bytes), then its faces as bytes (12), shorts (24) and a strip of ints (24).
fn buffer() -> Vec<u8> {
    let corners: [f32; 12] = [0., 0., 0., 1., 0., 0., 0., 2., 0., 0., 0., 3.];
    let faces: [u8; 12] = [0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3];
    let strip: [u32; 6] = [0, 2, 1, 3, 0, 2];
    let mut bytes: Vec<u8> = corners.iter().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend(faces);
    bytes.extend(faces.iter().flat_map(|x| u16::from(*x).to_le_bytes()));
    bytes.extend(strip.iter().flat_map(|x| x.to_le_bytes()));
    bytes
}

fn document() -> Value {
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "Part", "mesh": 0}],
        "meshes": [{"name": "Tetra", "primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 4},
            {"bufferView": 1, "componentType": 5121, "type": "SCALAR", "count": 12},
            {"bufferView": 1, "byteOffset": 12, "componentType": 5123, "type": "SCALAR", "count": 12},
            {"bufferView": 1, "byteOffset": 36, "componentType": 5125, "type": "SCALAR", "count": 6},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 60},
        ],
        "buffers": [{"byteLength": 108}],
    })
}

pub(super) fn glb(document: &Value, binary: &[u8]) -> Vec<u8> {
    let mut json = serde_json::to_vec(document).unwrap();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((28 + json.len() as u32 + binary.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json[..]), (b"BIN\0", binary)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

fn load(path: &Path) -> Result<Vec<NodeMesh>> {
    Gltf::load(path, &Sources::from_main(path))?.parts(None)
}

fn load_bytes(bytes: &[u8]) -> Result<Vec<NodeMesh>> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.glb");
    std::fs::write(&path, bytes).unwrap();
    load(&path)
}

/// What the loader makes of [`document`] with one value changed.
fn load_with(pointer: &str, value: Value) -> Result<Vec<NodeMesh>> {
    let mut document = document();
    set(&mut document, pointer, value);
    load_bytes(&glb(&document, &buffer()))
}

/// Puts a value at a JSON pointer, whose last key may be new.
pub(super) fn set(document: &mut Value, pointer: &str, value: Value) {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    match document.pointer_mut(parent).unwrap() {
        Value::Array(list) => list[key.parse::<usize>().unwrap()] = value,
        parent => parent[key] = value,
    }
}

#[track_caller]
fn assert_refused(pointer: &str, value: Value, expected: &str) {
    let error = load_with(pointer, value).expect_err(expected).to_string();
    assert!(error.contains(expected), "{error:?} lacks {expected:?}");
}

fn vertices(node: &NodeMesh) -> Vec<[f64; 3]> {
    node.mesh.vertices.iter().map(|v| v.to_array()).collect()
}

#[test]
fn y_up_becomes_z_up_and_bodies_stay_closed() {
    let nodes = load_bytes(&glb(&document(), &buffer())).unwrap();
    assert_eq!(nodes.len(), 1);
    assert_eq!(nodes[0].names, ["Part"]);
    // glTF's y (2) points up, its z (3) toward −y; corners come in the order the faces name them.
    let expected = [[0., 0., 0.], [0., 0., 2.], [1., 0., 0.], [0., -3., 0.]];
    assert_eq!(vertices(&nodes[0]), expected);
    assert_closed(&nodes[0].mesh);
    assert_eq!(volume(&nodes[0].mesh), 1.0);
    let shorts = load_with("/meshes/0/primitives/0/indices", json!(2)).unwrap();
    assert_eq!(shorts, nodes);
}

#[test]
fn strips_and_fans_are_the_same_surface() {
    let strip = json!([{"attributes": {"POSITION": 0}, "indices": 3, "mode": 5}]);
    let nodes = load_with("/meshes/0/primitives", strip).unwrap();
    assert_closed(&nodes[0].mesh);
    assert_eq!(volume(&nodes[0].mesh), 1.0);
    let fan = json!([
        {"attributes": {"POSITION": 0}, "mode": 6},
        {"attributes": {"POSITION": 0}, "mode": 0},
    ]);
    let nodes = load_with("/meshes/0/primitives", fan).unwrap();
    // The fan is (1, 2, 0), (2, 3, 0); vertices are numbered as they come.
    assert_eq!(nodes[0].mesh.triangles, [[0, 1, 2], [1, 3, 2]]);
}

#[test]
fn transforms_compose_down_the_tree() {
    let nodes = json!([
        {"name": "Base", "children": [2, 1], "translation": [10, 0, 0]},
        {"name": "Mirror", "mesh": 0, "scale": [-1, 1, 1]},
        // A quarter turn about glTF's y, not quite of unit length, under a node without a name.
        {"children": [3], "rotation": [0, 0.7, 0, 0.7]},
        {"name": "Tip", "mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,5,0,1]},
    ]);
    let nodes = load_with("/nodes", nodes).unwrap();
    assert_eq!(nodes[0].names, ["Base", "Tip"]);
    assert_eq!(nodes[1].names, ["Base", "Mirror"]);
    // glTF (0,2,0) + (0,5,0), turned: x to −z, z to x; then moved by 10.
    for (vertex, expected) in
        (vertices(&nodes[0]).iter()).zip([[10., 0., 5.], [10., 0., 7.], [10., 1., 5.], [13., 0., 5.]])
    {
        for axis in 0..3 {
            assert!((vertex[axis] - expected[axis]).abs() < 1e-12, "{vertex:?} {expected:?}");
        }
    }
    assert_eq!(nodes[1].mesh.bounds().unwrap().0, DVec3::new(9.0, -3.0, 0.0));
    for node in &nodes {
        assert_closed(&node.mesh);
        assert!((volume(&node.mesh) - 1.0).abs() < 1e-9, "{:?}", node.names);
    }
}

#[test]
fn without_scenes_all_roots_are_read() {
    let mut document = document();
    for key in ["scene", "scenes"] {
        document.as_object_mut().unwrap().remove(key);
    }
    document["nodes"] = json!([{"name": "A", "children": [1]}, {"mesh": 0}, {"mesh": 0, "name": "B"}]);
    let nodes = load_bytes(&glb(&document, &buffer())).unwrap();
    assert_eq!([&nodes[0].names, &nodes[1].names], [&["A"], &["B"]]);
    document["nodes"] = json!([{"children": [1]}, {"children": [0]}, {"mesh": 0}]);
    let error = load_bytes(&glb(&document, &buffer())).unwrap_err().to_string();
    assert!(error.contains("nodes[0] is among its own ancestors"), "{error}");
}

#[test]
fn buffers_come_from_files_and_data_uris() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.gltf");
    std::fs::create_dir(folder.path().join("raw data")).unwrap();
    std::fs::write(folder.path().join("raw data/part.bin"), buffer()).unwrap();
    std::fs::write(folder.path().join("part.glb"), glb(&document(), &buffer())).unwrap();
    let expected = load(&folder.path().join("part.glb")).unwrap();
    let with_uri = |uri: &str| {
        let mut document = document();
        document["buffers"][0]["uri"] = uri.into();
        std::fs::write(&path, document.to_string()).unwrap();
        load(&path).map_err(|e| e.to_string())
    };
    let data = base64::engine::general_purpose::STANDARD.encode(buffer());
    for uri in [
        "raw%20data/part.bin",
        "./raw data/part.bin",
        "raw data\\part.bin",
        "raw%20data%5Cpart.bin",
        &format!("data:application/octet-stream;base64,{data}"),
    ] {
        assert_eq!(with_uri(uri).as_ref(), Ok(&expected), "{uri}");
    }
    let outside = tempfile::NamedTempFile::new_in(folder.path().parent().unwrap()).unwrap();
    let escape = format!("raw data\\..\\..\\{}", outside.path().file_name().unwrap().to_str().unwrap());
    #[cfg(unix)]
    std::os::unix::fs::symlink("/dev/null", folder.path().join("link.bin")).unwrap();
    for (uri, expected) in [
        ("raw%2", "percent-encoded"),
        ("../part.bin", "in the folder of the glTF or below"),
        (&escape, "out of the folder"),
        ("raw data/%2e%2e/../../x", "in the folder of the glTF or below"),
        ("%2fetc/hosts", "in the folder of the glTF or below"),
        ("https://example.org/part.bin", "in the folder of the glTF or below"),
        ("missing.bin", "missing.bin"),
        ("raw%20data", "not a regular file"),
        #[cfg(unix)]
        ("link.bin", "a link out of the folder"),
        ("data:text/plain,abc", "must be base64"),
        ("data:;base64,A*", "base64 data"),
        ("data:;base64,AAAA", "byteLength = 108: only 3 bytes"),
    ] {
        let error = with_uri(uri).expect_err(uri);
        assert!(error.contains(expected), "{error:?} lacks {expected:?}");
    }
}

#[test]
fn what_is_wrong_is_named() {
    assert_refused("/asset/version", json!("1.0"), "needs glTF 1.0: export it again as glTF 2.0");
    assert_refused("/asset", json!({"version": "2.1", "minVersion": "2.1"}), "needs glTF 2.1");
    assert_refused("/asset", json!({"version": "2.0", "minVersion": "3.0"}), "needs glTF 3.0");
    assert_refused("/nodes", json!({"n": {"meshes": ["m"]}}), "its JSON is not that of glTF 2.0");
    assert_refused(
        "/extensionsRequired",
        json!(["KHR_materials_unlit", "EXT_meshopt_compression"]),
        "without compression",
    );
    assert_refused("/extensionsUsed", json!(["EXT_mesh_gpu_instancing"]), "each copy as a node");
    assert_refused(
        "/extensionsRequired",
        json!(["KHR_draco_mesh_compression"]),
        "export again without compression",
    );
    assert_refused("/extensionsRequired", json!(["KHR_mesh_quantization"]), "as plain glTF");
    assert_refused("/scene", json!(4), "scene = 4: there are 1 scenes");
    assert_refused("/scenes/0/nodes/0", json!(9), "refers to nodes[9]: there are 1");
    assert_refused("/nodes/0/children", json!([0]), "nodes[0] is reached twice");
    assert_refused("/scenes/0/nodes", json!([0, 0]), "nodes[0] is reached twice");
    assert_refused("/scenes/0/nodes", json!([]), "no triangle in its scene");
    assert_refused("/nodes/0/mesh", json!(3), "nodes[0]: mesh = 3: there are 1");
    assert_refused("/nodes/0/translation", json!([1e39, 0, 0]), "number out of range");
    assert_refused("/nodes/0/matrix", json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]), "last row");
    let primitive = "/meshes/0/primitives/0";
    let of = |key: &str| format!("{primitive}{key}");
    assert_refused(&of("/mode"), json!(9), "mode: must be 0 to 6");
    assert_refused(&of("/mode"), json!(1), "no triangle in its scene");
    assert_refused(&of("/attributes"), json!({}), "lack POSITION");
    assert_refused(&of("/attributes/POSITION"), json!(1), "POSITION must be VEC3 of float");
    assert_refused(&of("/indices"), json!(0), "indices must be SCALAR");
    assert_refused(&of("/indices"), json!(77), "accessors[77]: no such");
    assert_refused("/accessors/1/count", json!(11), "has 11 corners");
    assert_refused("/accessors/0/count", json!(3), "\"Tetra\" primitives[0]: index 5 is 3: there are 3");
    assert_refused(
        "/accessors/0/count",
        json!(5),
        "accessors[0] needs 60 bytes of bufferViews[0], which has 48",
    );
    assert_refused("/accessors/0/count", json!(u64::MAX), "accessors[0] needs");
    assert_refused("/accessors/0/byteOffset", json!(u64::MAX), "accessors[0] needs");
    assert_refused("/accessors/0/componentType", json!(1), "unknown componentType");
    assert_refused("/accessors/0/bufferView", json!(8), "bufferViews[8]: no such");
    assert_refused("/accessors/0/bufferView", Value::Null, "has no bufferView");
    assert_refused("/bufferViews/0/byteStride", json!(4), "byteStride = 4: elements have 12");
    assert_refused("/bufferViews/0/byteLength", json!(109), "reaches past the 108 bytes");
    assert_refused("/bufferViews/1/byteOffset", json!(u64::MAX), "reaches past");
    assert_refused("/bufferViews/0/buffer", json!(1), "bufferViews[0].buffer = 1: no such");
    assert_refused("/buffers/0/byteLength", json!(109), "only 108 bytes are there");
    assert_refused("/buffers", json!([{"byteLength": 1}, {"byteLength": 1}]), "buffers[1]: has no uri");
}

#[test]
fn a_file_of_version_1_is_told_by_its_version() {
    let old = r#"{"asset": {"version": "1.0"}, "scenes": {"s": {"nodes": ["n"]}}, "nodes": {"n": {}}, "scene": "s"}"#;
    for (bytes, expected) in [
        (old.as_bytes(), "needs glTF 1.0: export it again as glTF 2.0"),
        (b"glTF\x01\0\0\0\x14\0\0\0", "is glTF 1.0 by its header: export it again as glTF 2.0"),
        (b"", "is empty: export it again"),
        (b"{\"asset\": {", "its JSON ends too early: the file is cut off"),
        (b"solid part\nfacet", "does not begin with a JSON object: is it a glTF file?"),
    ] {
        let error = load_bytes(bytes).unwrap_err().to_string();
        assert!(error.contains(expected), "{error:?} lacks {expected:?}");
    }
}

#[test]
fn what_is_not_looked_at_refuses_no_file() {
    let whole = load_bytes(&glb(&document(), &buffer())).unwrap();
    for (pointer, value) in [
        ("/scenes", json!([{"nodes": [0]}, {"name": "spare"}, {}])),
        ("/asset", json!({"version": "2.1", "minVersion": "2.0"})),
        (
            "/extensionsRequired",
            json!([
                "KHR_materials_unlit",
                "KHR_texture_transform",
                "KHR_lights_punctual",
                "EXT_texture_webp"
            ]),
        ),
        (
            "/extensionsRequired",
            json!([
                "KHR_xmp_json_ld",
                "KHR_materials_variants",
                "KHR_node_visibility",
                "MSFT_packing_normalRoughnessMetallic"
            ]),
        ),
        ("/nodes/0/rotation", json!([0, 0, 0, 0])),
    ] {
        assert_eq!(load_with(pointer, value).unwrap(), whole, "{pointer}");
    }
    // With a byte-order mark before its JSON.
    let mut document = document();
    let data = base64::engine::general_purpose::STANDARD.encode(buffer());
    document["buffers"][0]["uri"] = format!("data:;base64,{data}").into();
    assert_eq!(load_bytes(format!("\u{feff}{document}").as_bytes()).unwrap(), whole);
}

#[test]
fn hidden_nodes_are_left_out_and_told() {
    ["extensionsUsed", "extensionsRequired", "extras"].into_iter().for_each(hides);
}

/// With the extension named under a key of the file.
fn hides(declared: &str) {
    let mut document = document();
    let hidden = json!({"KHR_node_visibility": {"visible": false}});
    document[declared] = json!(["KHR_node_visibility"]);
    document["scenes"][0]["nodes"] = json!([0, 1, 3]);
    document["nodes"] = json!([
        {"name": "shown", "mesh": 0, "extensions": {"KHR_node_visibility": {"visible": true}}},
        {"name": "layer", "children": [2], "extensions": hidden},
        {"name": "below", "mesh": 0, "extensions": {"KHR_node_visibility": {}}},
        {"name": "alone", "mesh": 0, "extensions": hidden},
    ]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.glb");
    let sources = Sources::from_main(&path);
    std::fs::write(&path, glb(&document, &buffer())).unwrap();
    let nodes = Gltf::load(&path, &sources).unwrap().parts(None).unwrap();
    assert_eq!(nodes.iter().map(|node| &node.names[..]).collect::<Vec<_>>(), [["shown"]]);
    let remarks = sources.take_remarks();
    assert!(
        remarks.len() == 1 && remarks[0].contains("part.glb: without 2 nodes that KHR_node_visibility hides"),
        "{remarks:?}"
    );
    assert_eq!(sources.take_remarks(), [""; 0]);
}

#[test]
fn a_node_of_scale_0_is_left_out_and_told() {
    let mut document = document();
    document["scenes"][0]["nodes"] = json!([0, 1]);
    document["nodes"] = json!([
        {"name": "shown", "mesh": 0},
        {"name": "gone", "scale": [0, 0, 0], "children": [2]},
        {"name": "below", "mesh": 0, "translation": [1, 2, 3]},
    ]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.glb");
    let sources = Sources::from_main(&path);
    std::fs::write(&path, glb(&document, &buffer())).unwrap();
    let nodes = Gltf::load(&path, &sources).unwrap().parts(None).unwrap();
    assert_eq!(nodes.iter().map(|node| &node.names[..]).collect::<Vec<_>>(), [["shown"]]);
    let remarks = sources.take_remarks();
    assert!(remarks.len() == 1 && remarks[0].contains("part.glb: without 1 node of scale 0"), "{remarks:?}");
}

#[test]
fn positions_must_be_finite() {
    for bad in [f32::NAN, f32::INFINITY] {
        let mut binary = buffer();
        binary[16..20].copy_from_slice(&bad.to_le_bytes());
        let error = load_bytes(&glb(&document(), &binary)).unwrap_err().to_string();
        assert!(error.contains("\"Tetra\" primitives[0]: position 1 is"), "{error}");
    }
    // Nine nested scales of 1e38 pass f64's range.
    let nodes: Vec<Value> = (1..=9)
        .map(|next| json!({"children": [next], "scale": [1e38, 1e38, 1e38]}))
        .chain([json!({"mesh": 0})])
        .collect();
    assert_refused("/nodes", json!(nodes), "move a vertex to infinity");
}

#[test]
fn files_that_unfold_without_end_are_refused() {
    let chain: Vec<Value> =
        (1..=300).map(|next| json!({"children": [next]})).chain([json!({"mesh": 0})]).collect();
    assert_refused("/nodes", json!(chain), "nested more than 256 deep");
    // 3000 nodes, each with 3000 primitives.
    let mut document = document();
    let primitive = document["meshes"][0]["primitives"][0].clone();
    document["meshes"][0]["primitives"] = json!(vec![primitive; 3000]);
    document["nodes"] = json!(vec![json!({"mesh": 0}); 3000]);
    document["scenes"][0]["nodes"] = json!((0..3000).collect::<Vec<_>>());
    let error = load_bytes(&glb(&document, &buffer())).unwrap_err().to_string();
    assert!(error.contains("unfolds to far more than its size"), "{error}");
    // One long name above many nodes.
    let mut nodes = vec![json!({"mesh": 0}); 1001];
    nodes[0] = json!({"name": "n".repeat(1 << 20), "children": (1..=1000).collect::<Vec<_>>()});
    assert_refused("/nodes", json!(nodes), "unfolds to far more than its size");
}

#[test]
fn damaged_files_never_panic() {
    let good = glb(&document(), &buffer());
    load_bytes(&good).unwrap();
    for length in 0..good.len() {
        assert!(load_bytes(&good[..length]).is_err(), "cut at {length}");
    }
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(5);
    for _ in 0..cases(4_000, 20_000) {
        let mut bytes = good.clone();
        for _ in 0..random.random_range(1..4) {
            let at = random.random_range(0..bytes.len());
            bytes[at] = match random.random_range(0..2) {
                0 => random.random(),
                // Digits change numbers without breaking the JSON.
                _ => b'0' + random.random_range(0..10),
            };
        }
        let _ = load_bytes(&bytes);
    }
    for header in [0u32, 11, 12, 20, u32::MAX] {
        let mut bytes = good.clone();
        bytes[8..12].copy_from_slice(&header.to_le_bytes());
        assert!(load_bytes(&bytes).is_err(), "header says {header} bytes");
    }
}
