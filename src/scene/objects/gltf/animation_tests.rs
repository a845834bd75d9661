//! Animations and skins small enough to be worked by hand.

use glam::DVec3;
use rand::{RngExt, SeedableRng};
use serde_json::{Value, json};

use super::tests::{glb, set};
use super::*;

/// A file under construction: its JSON, and the bytes that its accessors name.
#[derive(Clone)]
pub(super) struct Draft {
    pub(super) document: Value,
    binary: Vec<u8>,
}

impl Draft {
    /// One triangle, (0, 0, 0), (1, 0, 0), (0, 1, 0) in glTF's axes, as mesh 0.
    pub(super) fn triangle(nodes: Value, roots: &[usize]) -> Draft {
        let document = json!({
            "asset": {"version": "2.0"},
            "scenes": [{"nodes": roots}],
            "nodes": nodes,
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "accessors": [],
            "bufferViews": [],
            "animations": [{"name": "go", "channels": [], "samplers": []}],
        });
        let mut draft = Draft { document, binary: Vec::new() };
        draft.floats("VEC3", &[0., 0., 0., 1., 0., 0., 0., 1., 0.]);
        draft
    }

    pub(super) fn list(&mut self, key: &str) -> &mut Vec<Value> {
        self.document[key].as_array_mut().unwrap()
    }

    pub(super) fn accessor(&mut self, component: u32, kind: &str, count: usize, bytes: &[u8]) -> usize {
        let (offset, view) = (self.binary.len(), self.list("bufferViews").len());
        self.list("bufferViews").push(json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}));
        let normalized = component != 5126 && kind == "VEC4";
        self.list("accessors").push(json!({
            "bufferView": view, "componentType": component, "type": kind, "count": count, "normalized": normalized,
        }));
        self.binary.extend(bytes);
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        self.list("accessors").len() - 1
    }

    pub(super) fn floats(&mut self, kind: &str, numbers: &[f32]) -> usize {
        let width = match kind {
            "SCALAR" => 1,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let bytes: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(5126, kind, numbers.len() / width, &bytes)
    }

    /// Adds a channel to animation 0.
    pub(super) fn channel(
        &mut self,
        node: usize,
        path: &str,
        interpolation: &str,
        times: &[f32],
        values: &[f32],
    ) {
        let input = self.floats("SCALAR", times);
        let kind = match path {
            "rotation" => "VEC4",
            "weights" => "SCALAR",
            _ => "VEC3",
        };
        let output = self.floats(kind, values);
        let clip = &mut self.document["animations"][0];
        let samplers = clip["samplers"].as_array_mut().unwrap();
        samplers.push(json!({"input": input, "output": output, "interpolation": interpolation}));
        let sampler = samplers.len() - 1;
        let channel = json!({"sampler": sampler, "target": {"node": node, "path": path}});
        clip["channels"].as_array_mut().unwrap().push(channel);
    }

    pub(super) fn with_value(&self, pointer: &str, value: Value) -> Draft {
        let mut draft = self.clone();
        set(&mut draft.document, pointer, value);
        draft
    }

    pub(super) fn open(&self) -> Result<Gltf> {
        let mut document = self.document.clone();
        document["buffers"] = json!([{"byteLength": self.binary.len()}]);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("part.glb");
        std::fs::write(&path, glb(&document, &self.binary)).unwrap();
        Gltf::load(&path, &Sources::from_main(&path))
    }

    /// The vertices of the first part in glTF's axes, at a time of the clip or as the nodes stand.
    pub(super) fn vertices(&self, time_s: Option<f64>) -> Result<Vec<DVec3>> {
        let file = self.open()?;
        let clip = time_s.map(|_| file.clip(&WhichClip::Only)).transpose()?;
        let parts = file.parts(clip.as_ref().zip(time_s))?;
        Ok(parts[0].mesh.vertices.iter().map(|v| DVec3::new(v.x, v.z, -v.y)).collect())
    }

    /// The first vertex, the triangle's (0, 0, 0), at a time; and the second.
    #[track_caller]
    pub(super) fn check(&self, time_s: f64, first: [f64; 3], second: [f64; 3]) {
        let vertices = self.vertices(Some(time_s)).unwrap();
        for (found, expected) in vertices.iter().zip([first, second]) {
            let off = (*found - DVec3::from_array(expected)).length();
            assert!(off < 1e-6, "at {time_s} s: {found}, expected {expected:?}");
        }
    }

    #[track_caller]
    pub(super) fn assert_refused(&self, expected: &str) {
        let error = self.vertices(Some(0.0)).expect_err(expected).to_string();
        assert!(error.contains("part.glb: ") && error.contains(expected), "{error:?} lacks {expected:?}");
    }
}

fn one_node() -> Draft {
    Draft::triangle(json!([{"mesh": 0, "translation": [0, 5, 0]}]), &[0])
}

#[test]
fn a_node_moves_along_a_line_and_is_held_at_its_ends() {
    let mut file = one_node();
    file.channel(0, "translation", "LINEAR", &[1., 3., 4.], &[0., 0., 0., 8., 4., 0., 8., 0., 0.]);
    file.check(1.0, [0., 0., 0.], [1., 0., 0.]);
    file.check(1.5, [2., 1., 0.], [3., 1., 0.]);
    file.check(3.0, [8., 4., 0.], [9., 4., 0.]);
    file.check(3.25, [8., 3., 0.], [9., 3., 0.]);
    for before in [-1.0, 0.0] {
        file.check(before, [0., 0., 0.], [1., 0., 0.]);
    }
    file.check(9.0, [8., 0., 0.], [9., 0., 0.]);
    let clip = file.open().unwrap().clip(&WhichClip::Named("go".into())).unwrap();
    assert_eq!(clip.span_s(), [1.0, 4.0]);
    // Without the clip the node stands as in the file.
    assert_eq!(file.vertices(None).unwrap()[0], DVec3::new(0., 5., 0.));
}

#[test]
fn steps_hold_their_value_up_to_the_next() {
    let mut file = one_node();
    file.channel(0, "scale", "STEP", &[0., 1., 2.], &[1., 1., 1., 2., 2., 2., 3., 3., 3.]);
    for (time, scale) in [(0.0, 1.), (0.999, 1.), (1.0, 2.), (1.999, 2.), (2.0, 3.), (7.0, 3.)] {
        file.check(time, [0., 5., 0.], [scale, 5., 0.]);
    }
}

#[test]
fn rotations_go_the_shorter_way_at_constant_speed() {
    // Half a turn about z, from none.
    let mut file = one_node();
    file.channel(0, "rotation", "LINEAR", &[0., 1.], &[0., 0., 0., 1., 0., 0., 1., 0.]);
    for (time, degrees) in [(0.0, 0f64), (0.25, 45.), (0.5, 90.), (2.0 / 3.0, 120.), (1.0, 180.)] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        file.check(time, [0., 5., 0.], [cos, 5. + sin, 0.]);
    }
    // A quarter turn whose second key is written with the opposite sign: still a quarter, not three.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let mut file = one_node();
    file.channel(0, "rotation", "LINEAR", &[0., 1.], &[0., 0., 0., 1., 0., 0., -half, -half]);
    file.check(1.0 / 3.0, [0., 5., 0.], [3f64.sqrt() / 2., 5.5, 0.]);
    // Equal keys have no sine to divide by.
    let mut file = one_node();
    file.channel(0, "rotation", "LINEAR", &[0., 1.], &[0., 0., half, half, 0., 0., half, half]);
    file.check(0.4, [0., 5., 0.], [0., 6., 0.]);
}

#[test]
fn rotations_may_be_fractions_of_integers() {
    let mut file = one_node();
    file.channel(0, "rotation", "LINEAR", &[0., 1.], &[0., 0., 0., 1., 0., 0., 1., 0.]);
    let bytes: Vec<u8> = [0i16, 0, 0, 32_767, 0, 0, 32_767, 0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let output = file.accessor(5122, "VEC4", 2, &bytes);
    set(&mut file.document, "/animations/0/samplers/0/output", json!(output));
    file.check(0.5, [0., 5., 0.], [0., 6., 0.]);
    // The lowest integer of each size is −1, too, as glTF rules.
    let number = |component: u32, bytes: &[u8]| {
        let mut file = one_node();
        let index = file.accessor(component, "VEC4", 1, bytes);
        let gltf = file.open().unwrap();
        let index = ::gltf::json::Index::new(index as u32);
        let elements = accessor::Elements::rotations(&gltf.container, index).unwrap();
        [0, 1, 2, 3].map(|c| elements.number(0, c))
    };
    assert_eq!(number(5120, &[0x80, 0x81, 127, 0]), [-1., -1., 1., 0.]);
    assert_eq!(number(5121, &[0, 51, 102, 255]), [0., 0.2, 0.4, 1.]);
    assert_eq!(number(5122, &[0, 0x80, 1, 0x80, 0xff, 0x7f, 0, 0]), [-1., -1., 1., 0.]);
    assert_eq!(number(5123, &[0, 0, 0x33, 0x33, 0xff, 0xff, 0, 0]), [0., 0.2, 1., 0.]);
    let plain = file.with_value(&format!("/accessors/{output}/normalized"), json!(false));
    plain.assert_refused(
        "samplers[0].output: accessors[3]: a rotation's output must be VEC4 of float, or of normalized",
    );
}

#[test]
fn cubic_splines_follow_their_tangents() {
    // Over two seconds from x = 1, leaving at 3 m/s, to x = 5, arriving at 1 m/s. In y the tangents at the
    // two outer ends, which no segment uses, are nonsense.
    let mut file = one_node();
    #[rustfmt::skip]
    let values = [
        7., 9., 0.,  1., 0., 0.,  3., 0., 0.,
        1., 0., 0.,  5., 0., 0.,  8., 9., 0.,
    ];
    file.channel(0, "translation", "CUBICSPLINE", &[1., 3.], &values);
    // At the middle: ½·1 + 2·⅛·3 + ½·5 − 2·⅛·1 = 3.5.
    file.check(2.0, [3.5, 0., 0.], [4.5, 0., 0.]);
    // At a quarter: h00 = 27/32, h10 = 9/64, h01 = 5/32, h11 = −3/64: 0.84375 + 0.84375 + 0.78125 − 0.09375.
    file.check(1.5, [2.375, 0., 0.], [3.375, 0., 0.]);
    file.check(1.0, [1., 0., 0.], [2., 0., 0.]);
    file.check(3.0, [5., 0., 0.], [6., 0., 0.]);
    // A rotation's result is made a unit again: halfway between none and half a turn, without tangents, (0,
    // 0, ½, ½).
    let mut file = one_node();
    let values =
        [0.; 4].into_iter().chain([0., 0., 0., 1.]).chain([0.; 8]).chain([0., 0., 1., 0.]).chain([0.; 4]);
    file.channel(0, "rotation", "CUBICSPLINE", &[0., 1.], &values.collect::<Vec<_>>());
    file.check(0.5, [0., 5., 0.], [0., 6., 0.]);
}

#[test]
fn children_ride_on_animated_parents() {
    let nodes = json!([
        {"children": [1]},
        {"children": [2], "translation": [1, 0, 0]},
        {"mesh": 0, "translation": [1, 0, 0], "name": "tip"},
    ]);
    let mut file = Draft::triangle(nodes, &[0]);
    let half_turn = [0., 0., 0., 1., 0., 0., 1., 0.];
    file.channel(0, "rotation", "LINEAR", &[0., 1.], &half_turn);
    file.channel(1, "rotation", "LINEAR", &[0., 1.], &half_turn);
    file.check(0.0, [2., 0., 0.], [3., 0., 0.]);
    // A quarter turn at the root, another at the elbow (0, 1), then one metre on, which is −x by now.
    file.check(0.5, [-1., 1., 0.], [-2., 1., 0.]);
    file.check(1.0, [0., 0., 0.], [1., 0., 0.]);
}

#[test]
fn clips_are_found_by_name_and_by_number() {
    let mut file = one_node();
    file.channel(0, "translation", "LINEAR", &[0.], &[1., 0., 0.]);
    file.list("animations").push(json!({"channels": [], "samplers": []}));
    let named = |name: &str| WhichClip::Named(name.into());
    let clip = |file: &Draft, which: &WhichClip| file.open().unwrap().clip(which).map_err(|e| e.to_string());
    assert!(clip(&file, &named("go")).is_ok());
    assert!(clip(&file, &WhichClip::Number(0)).is_ok());
    let refused = |file: &Draft, which, expected: &str| {
        let error = clip(file, &which).expect_err(expected);
        assert!(error.contains(expected), "{error}");
    };
    refused(&file, WhichClip::Only, "has several animations: set clip to one of \"go\", 1 (it has no name)");
    refused(&file, named("walk"), "no animation is named \"walk\": there are \"go\", 1 (it has no name)");
    refused(&file, WhichClip::Number(1), "animations[1] moves no node");
    refused(&file, WhichClip::Number(2), "there is no animation 2: there are 2, counted from 0: \"go\", 1 (");
    let twice = file.with_value("/animations/1/name", json!("go"));
    refused(&twice, named("go"), "two animations are named \"go\": set clip to the number of one");
    assert!(clip(&twice, &WhichClip::Number(0)).is_ok());
    refused(&file.with_value("/animations", json!([])), WhichClip::Number(0), "has no animation: export one");
    // Without a name, only its number tells which.
    let nameless = file.with_value("/animations/0/name", Value::Null);
    nameless.open().unwrap().clip(&WhichClip::Number(0)).unwrap();
}

#[test]
fn wrong_animations_are_named() {
    let mut good = one_node();
    good.channel(0, "translation", "LINEAR", &[0., 1.], &[0., 0., 0., 1., 0., 0.]);
    good.check(1.0, [1., 0., 0.], [2., 0., 0.]);
    let clip = "/animations/0";
    let refused = |key: &str, value: Value, expected: &str| {
        good.with_value(&format!("{clip}{key}"), value).assert_refused(expected);
    };
    refused("/channels/0/target/node", json!(7), "animations[0].channels[0]: target.node = 7: there are 1");
    refused("/channels/0/target/path", json!("colour"), "target.path: must be translation, rotation, scale");
    refused("/channels/0/sampler", json!(3), "sampler = 3: there are 1");
    refused("/samplers/0/interpolation", json!("SMOOTH"), "must be LINEAR, STEP or CUBICSPLINE");
    refused("/samplers/0/interpolation", json!("CUBICSPLINE"), "output has 2 values: its 2 times need 6");
    refused("/samplers/0/input", json!(0), "samplers[0].input: accessors[0]: must be SCALAR of float");
    refused("/samplers/0/output", json!(1), "samplers[0].output: accessors[1]: must be VEC3 of float");
    refused("/samplers/0/output", json!(0), "output has 3 values: its 2 times need 2");
    refused("/samplers/0/output", json!(9), "accessors[9]: no such");
    let channel = good.document["animations"][0]["channels"][0].clone();
    refused("/channels", json!([channel, channel]), "moved by another channel");
    good.with_value("/accessors/1/count", json!(0)).assert_refused("samplers[0].input: has no time");
    good.with_value("/nodes/0", json!({"mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}))
        .assert_refused("nodes[0].matrix: an animated node needs translation");
    let with = |path: &str, times: &[f32], values: &[f32]| {
        let mut file = one_node();
        file.channel(0, path, "LINEAR", times, values);
        file
    };
    let two = [0., 0., 0., 1., 0., 0.];
    with("translation", &[1., 1.], &two).assert_refused("time 1 is 1 after 1: times must increase");
    with("translation", &[1., 0.], &two).assert_refused("times must increase");
    with("translation", &[0., f32::NAN], &two).assert_refused("time 1 is NaN: must be finite");
    with("scale", &[0., 1.], &[0., 0., 0., 1., f32::INFINITY, 0.]).assert_refused("output value 1 is");
    with("rotation", &[0.], &[0., 0., 0., 0.]).assert_refused("must be finite and not zero");
    // The two keys of a spline cancel out halfway.
    let mut file = one_node();
    let turn = |w| [[0., 0., 0., 0.], [0., 0., 0., w], [0., 0., 0., 0.]].concat();
    file.channel(0, "rotation", "CUBICSPLINE", &[-1., 1.], &[turn(1.), turn(-1.)].concat());
    file.assert_refused("animations[0].channels[0]: no rotation is left at 0 s");
}

/// Two bones along y, the second from (0, 1, 0) on, and a strip of three corners: at the root, at the tip (0,
/// 2, 0) beside the second bone, and between (1, 1, 0), which both hold alike. The mesh's own node is far
/// away, which a skin makes irrelevant.
pub(super) fn arm() -> Draft {
    let nodes = json!([
        {"mesh": 0, "skin": 0, "translation": [100, 0, 0], "name": "arm"},
        {"children": [2], "name": "upper"},
        {"translation": [0, 1, 0], "name": "lower"},
    ]);
    let mut file = Draft::triangle(nodes, &[0, 1]);
    let positions = file.floats("VEC3", &[0., 0., 0., 0., 2., 0., 1., 1., 0.]);
    let joints = file.accessor(5121, "VEC4", 3, &[0, 9, 9, 9, 1, 0, 0, 0, 0, 1, 0, 0]);
    let weights = file.floats("VEC4", &[1., 0., 0., 0., 1., 0., 0., 0., 0.5, 0.5, 0., 0.]);
    #[rustfmt::skip]
    let matrices = file.floats("MAT4", &[
        1., 0., 0., 0.,  0., 1., 0., 0.,  0., 0., 1., 0.,  0., 0., 0., 1.,
        1., 0., 0., 0.,  0., 1., 0., 0.,  0., 0., 1., 0.,  0., -1., 0., 1.,
    ]);
    file.document["meshes"] = json!([{"primitives": [{
        "attributes": {"POSITION": positions, "JOINTS_0": joints, "WEIGHTS_0": weights},
    }]}]);
    file.document["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": matrices}]);
    // The elbow bends by 90° about z.
    let half = std::f32::consts::FRAC_1_SQRT_2;
    file.channel(2, "rotation", "LINEAR", &[0., 1.], &[0., 0., 0., 1., 0., 0., half, half]);
    file
}

#[track_caller]
fn assert_near(found: &[DVec3], expected: [[f64; 3]; 3]) {
    let off =
        found.iter().zip(expected).map(|(f, e)| (*f - DVec3::from_array(e)).length()).fold(0.0, f64::max);
    assert!(found.len() == 3 && off < 1e-6, "{found:?}, expected {expected:?}");
}

#[test]
fn a_skin_bends_with_its_bones() {
    let file = arm();
    assert_near(&file.vertices(None).unwrap(), [[0., 0., 0.], [0., 2., 0.], [1., 1., 0.]]);
    assert_near(&file.vertices(Some(0.0)).unwrap(), [[0., 0., 0.], [0., 2., 0.], [1., 1., 0.]]);
    // The tip turns about (0, 1, 0) to (−1, 1, 0); the middle is the mean of (1, 1, 0) and, turned, (0, 2,
    // 0).
    assert_near(&file.vertices(Some(1.0)).unwrap(), [[0., 0., 0.], [-1., 1., 0.], [0.5, 1.5, 0.]]);
    // Where the root of the bones goes, all go.
    let mut file = file;
    file.channel(1, "translation", "STEP", &[0.], &[0., 0., 7.]);
    assert_near(&file.vertices(Some(1.0)).unwrap(), [[0., 0., 7.], [-1., 1., 7.], [0.5, 1.5, 7.]]);
}

#[test]
fn weights_come_in_several_forms_and_are_normalised() {
    let bent = [[0., 0., 0.], [-1., 1., 0.], [0.5, 1.5, 0.]];
    let attributes = "/meshes/0/primitives/0/attributes";
    let bytes = [1u8, 0, 0, 0, 255, 0, 0, 0, 77, 77, 0, 0];
    let mut file = arm();
    let small = file.accessor(5121, "VEC4", 3, &bytes);
    assert_near(
        &file.with_value(&format!("{attributes}/WEIGHTS_0"), json!(small)).vertices(Some(1.0)).unwrap(),
        bent,
    );
    let shorts: Vec<u8> = bytes.iter().flat_map(|&b| (u16::from(b) * 200).to_le_bytes()).collect();
    let wide = file.accessor(5123, "VEC4", 3, &shorts);
    assert_near(
        &file.with_value(&format!("{attributes}/WEIGHTS_0"), json!(wide)).vertices(Some(1.0)).unwrap(),
        bent,
    );
    let joints: Vec<u8> =
        [0u16, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0].iter().flat_map(|j| j.to_le_bytes()).collect();
    let joints = file.accessor(5123, "VEC4", 3, &joints);
    assert_near(
        &file.with_value(&format!("{attributes}/JOINTS_0"), json!(joints)).vertices(Some(1.0)).unwrap(),
        bent,
    );
    let plain = file.with_value(&format!("{attributes}/WEIGHTS_0"), json!(small));
    plain
        .with_value(&format!("/accessors/{small}/normalized"), json!(false))
        .assert_refused("WEIGHTS must be VEC4 of float");
    // The middle held by half in a first set and half in a second.
    let mut file = arm();
    let first = file.floats("VEC4", &[1., 0., 0., 0., 1., 0., 0., 0., 0.3, 0., 0., 0.]);
    let second = file.floats("VEC4", &[0., 0., 0., 0., 0., 0., 0., 0., 0.3, 0., 0., 0.]);
    let joints = file.accessor(5121, "VEC4", 3, &[0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0]);
    let attributes = &mut file.document["meshes"][0]["primitives"][0]["attributes"];
    attributes["WEIGHTS_0"] = json!(first);
    attributes["JOINTS_1"] = json!(joints);
    attributes["WEIGHTS_1"] = json!(second);
    assert_near(&file.vertices(Some(1.0)).unwrap(), bent);
}

#[test]
fn without_inverse_binds_the_mesh_is_in_the_joints_frames() {
    let mut file = arm();
    file.document["skins"] = json!([{"joints": [1, 2]}]);
    assert_near(&file.vertices(None).unwrap(), [[0., 0., 0.], [0., 3., 0.], [1., 1.5, 0.]]);
}

#[test]
fn wrong_skins_are_named() {
    let good = arm();
    let attributes = "/meshes/0/primitives/0/attributes";
    let attribute =
        |key: &str| good.document.pointer(&format!("{attributes}/{key}")).unwrap().as_u64().unwrap();
    let refused = |pointer: &str, value: Value, expected: &str| {
        good.with_value(pointer, value).assert_refused(expected)
    };
    refused("/nodes/0/skin", json!(4), "nodes[0]: skin = 4: there are 1");
    refused("/skins/0/joints", json!([1, 9]), "skins[0].joints[1] = 9: no such node in the scene");
    refused("/scenes/0/nodes", json!([0]), "skins[0].joints[0] = 1: no such node in the scene");
    refused("/skins/0/joints", json!([1]), "JOINTS of vertex 1 name joint 1: skins[0] has 1");
    refused("/skins/0/joints", json!([1, 2, 2]), "skins[0].inverseBindMatrices: has 2 for 3 joints");
    refused("/skins/0/inverseBindMatrices", json!(0), "must be MAT4 of float");
    refused(&format!("{attributes}/JOINTS_0"), json!(0), "JOINTS must be VEC4");
    refused(&format!("{attributes}/WEIGHTS_0"), json!(0), "WEIGHTS must be VEC4");
    refused(&format!("{attributes}/WEIGHTS_1"), json!(0), "needs both JOINTS_1 and WEIGHTS_1");
    refused(attributes, json!({"POSITION": attribute("POSITION")}), "needs both JOINTS_0 and WEIGHTS_0");
    refused(
        &format!("/accessors/{}/count", attribute("WEIGHTS_0")),
        json!(2),
        "3 positions, but 3 JOINTS_0 and 2 WEIGHTS_0",
    );
    refused(&format!("/accessors/{}/count", attribute("JOINTS_0")), json!(2), "but 2 JOINTS_0");
    let weights = |weights: [f32; 12]| {
        let mut file = good.clone();
        let index = file.floats("VEC4", &weights);
        file.with_value(&format!("{attributes}/WEIGHTS_0"), json!(index))
    };
    let with_first = |first: f32| weights([first, 0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0.]);
    with_first(0.0).assert_refused("vertex 0 has no weight");
    with_first(-1.0).assert_refused("WEIGHTS of vertex 0 hold -1: must be 0 or more");
    with_first(f32::NAN).assert_refused("WEIGHTS of vertex 0 hold NaN");
    for (place, value) in [(3, 0.5), (12, f32::NAN)] {
        let mut matrices: Vec<f32> = (0..2).flat_map(|_| glam::Mat4::IDENTITY.to_cols_array()).collect();
        matrices[16 + place] = value;
        let mut file = good.clone();
        let index = file.floats("MAT4", &matrices);
        file.with_value("/skins/0/inverseBindMatrices", json!(index))
            .assert_refused("matrix 1 must be finite, with 0, 0, 0, 1");
    }
}

#[test]
fn damaged_animations_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.glb");
    let mut document = arm().document;
    document["buffers"] = json!([{"byteLength": arm().binary.len()}]);
    let good = glb(&document, &arm().binary);
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(6);
    let mut posed = 0;
    for _ in 0..3_000 {
        let mut bytes = good.clone();
        for _ in 0..random.random_range(1..4) {
            let at = random.random_range(0..bytes.len());
            // Digits change numbers without breaking the JSON.
            bytes[at] = if random.random() { b'0' + random.random_range(0..10) } else { random.random() };
        }
        std::fs::write(&path, bytes).unwrap();
        let Ok(file) = Gltf::load(&path, &Sources::from_main(&path)) else { continue };
        let Ok(clip) = file.clip(&WhichClip::Only) else { continue };
        for time_s in [f64::NEG_INFINITY, 0.0, 0.4, f64::MAX] {
            posed += usize::from(file.parts(Some((&clip, time_s))).is_ok());
        }
    }
    assert!(posed > 500, "most damage must leave a file to pose: {posed}");
}
