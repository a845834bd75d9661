//! Morph targets small enough to be worked by hand: one triangle, whose corners are told in glTF's axes.

use glam::DVec3;
use serde_json::{Value, json};

use crate::objects::gltf::animation_tests::{Draft, arm};

/// The triangle (0, 0, 0), (1, 0, 0), (0, 1, 0) with two targets: one lifts its first corner to z = 2, the other
/// takes the second by 10 along x and the third by 100 along y.
fn face() -> Draft {
    let mut file = Draft::triangle(json!([{"mesh": 0, "name": "face"}]), &[0]);
    let lift = file.floats("VEC3", &[0., 0., 2., 0., 0., 0., 0., 0., 0.]);
    let stretch = file.floats("VEC3", &[0., 0., 0., 10., 0., 0., 0., 100., 0.]);
    file.document["meshes"][0]["primitives"][0]["targets"] =
        json!([{"POSITION": lift}, {"POSITION": stretch, "NORMAL": lift}]);
    file
}

/// Where the corners are with these weights.
fn blend([lift, stretch]: [f64; 2]) -> [[f64; 3]; 3] {
    [[0., 0., 2. * lift], [1. + 10. * stretch, 0., 0.], [0., 1. + 100. * stretch, 0.]]
}

#[track_caller]
fn assert_near(file: &Draft, time_s: Option<f64>, expected: [[f64; 3]; 3]) {
    let found = file.vertices(time_s).unwrap();
    let off =
        found.iter().zip(expected).map(|(f, e)| (*f - DVec3::from_array(e)).length()).fold(0.0, f64::max);
    assert!(found.len() == 3 && off < 1e-5, "at {time_s:?} s: {found:?}, expected {expected:?}");
}

#[test]
fn weights_are_the_nodes_else_the_meshes_else_zero() {
    let file = face();
    assert_near(&file, None, blend([0., 0.]));
    let of_mesh = file.with_value("/meshes/0/weights", json!([0.5, 1.0]));
    assert_near(&of_mesh, None, blend([0.5, 1.0]));
    assert_near(&of_mesh.with_value("/nodes/0/weights", json!([-1.0, 0.25])), None, blend([-1.0, 0.25]));
    // Targets that move no corner, and accessors without bytes, are zero everywhere.
    let targets = json!([{"NORMAL": 1}, {"POSITION": 2}]);
    assert_near(&of_mesh.with_value("/meshes/0/primitives/0/targets", targets), None, blend([0., 1.]));
    let bare = json!({"componentType": 5126, "type": "VEC3", "count": 3});
    assert_near(&of_mesh.with_value("/accessors/1", bare), None, blend([0., 1.]));
}

#[test]
fn animated_weights_follow_their_interpolation() {
    let keys = [0., 0.2, 1., 0.6];
    let with = |interpolation: &str, values: &[f32]| {
        let mut file = face().with_value("/meshes/0/weights", json!([9.0, 9.0]));
        file.channel(0, "weights", interpolation, &[1., 3.], values);
        file
    };
    let linear = with("LINEAR", &keys);
    for (time_s, weights) in
        [(0., [0., 0.2]), (1., [0., 0.2]), (1.5, [0.25, 0.3]), (3., [1., 0.6]), (7., [1., 0.6])]
    {
        assert_near(&linear, Some(time_s), blend(weights));
    }
    // Without the clip, the file's own.
    assert_near(&linear, None, blend([9., 9.]));
    let step = with("STEP", &keys);
    assert_near(&step, Some(2.999), blend([0., 0.2]));
    assert_near(&step, Some(3.0), blend([1., 0.6]));
    // Of each key the tangents coming in, the values, the tangents going out; at the middle of two seconds ½·a + ½·b
    // + 2·⅛·(out − into).
    #[rustfmt::skip]
    let spline = with("CUBICSPLINE", &[
        7., 8.,  0., 0.2,  2., 0.4,
        1., 0.,  1., 0.6,  9., 9.,
    ]);
    assert_near(&spline, Some(2.0), blend([0.5 + 0.25, 0.4 + 0.1]));
    assert_near(&spline, Some(1.0), blend([0., 0.2]));
    // Fractions of integers.
    let mut file = with("LINEAR", &keys);
    let bytes = file.accessor(5121, "SCALAR", 4, &[0, 51, 255, 153]);
    let small = file
        .with_value("/animations/0/samplers/0/output", json!(bytes))
        .with_value(&format!("/accessors/{bytes}/normalized"), json!(true));
    assert_near(&small, Some(1.5), blend([0.25, 0.3]));
}

/// The arm's tip, moved from (0, 2, 0) to (3, 2, 0), turns with its bone: a quarter about (0, 1, 0).
#[test]
fn joints_place_what_was_blended() {
    let mut file = arm();
    let move_tip = file.floats("VEC3", &[0., 0., 0., 3., 0., 0., 0., 0., 0.]);
    file.document["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": move_tip}]);
    file.document["meshes"][0]["weights"] = json!([1.0]);
    assert_near(&file, Some(1.0), [[0., 0., 0.], [-1., 4., 0.], [0.5, 1.5, 0.]]);
}

/// Blender writes targets so: only the corners that move.
#[test]
fn targets_may_be_sparse() {
    let sparse = |base: bool, component: u32, places: &[u8]| {
        let mut file = face().with_value("/meshes/0/weights", json!([1.0, 0.0]));
        let values = file.floats("VEC3", &[0., 0., 5., 7., 0., 0.]);
        let places = file.accessor(component, "SCALAR", 2, places);
        let sparse = json!({
            "count": 2,
            "indices": {"bufferView": places, "componentType": component},
            "values": {"bufferView": values},
        });
        let mut accessor = json!({"componentType": 5126, "type": "VEC3", "count": 3, "sparse": sparse});
        if base {
            accessor["bufferView"] = json!(1);
        }
        file.with_value("/accessors/1", accessor)
    };
    for (component, places) in
        [(5121, &[1u8, 2][..]), (5123, &[1, 0, 2, 0]), (5125, &[1, 0, 0, 0, 2, 0, 0, 0])]
    {
        // The base lifts the first corner by 2; without it that is zero.
        assert_near(&sparse(true, component, places), None, [[0., 0., 2.], [1., 0., 5.], [7., 1., 0.]]);
        assert_near(&sparse(false, component, places), None, [[0., 0., 0.], [1., 0., 5.], [7., 1., 0.]]);
    }
    let refused = |file: &Draft, expected: &str| {
        let error = file.vertices(None).expect_err(expected).to_string();
        assert!(error.contains("part.glb: ") && error.contains(expected), "{error:?} lacks {expected:?}");
    };
    let rule = "targets[0]: accessors[1]: sparse: indices must increase, and stay below its count of 3";
    for places in [[1u8, 1], [2, 1], [1, 3]] {
        refused(&sparse(true, 5121, &places), rule);
    }
    let good = sparse(true, 5121, &[1, 2]);
    let with = |key: &str, value: Value| good.with_value(&format!("/accessors/1/sparse{key}"), value);
    refused(&with("/count", json!(5)), "sparse: indices: needs 5 bytes: bufferViews[");
    refused(&with("/count", json!(u64::MAX)), "sparse: indices: needs");
    refused(&with("/values/byteOffset", json!(1)), "sparse: values: needs 25 bytes");
    refused(&with("/indices/componentType", json!(5126)), "sparse: indices: must be unsigned byte");
    refused(&with("/indices/bufferView", json!(99)), "bufferViews[99]: no such");
    assert_near(&with("/count", json!(0)), None, [[0., 0., 2.], [1., 0., 0.], [0., 1., 0.]]);
    // A few bytes that stand for very many elements.
    let bare = json!({"componentType": 5126, "type": "VEC3", "count": 3_999_999_999u64,
        "sparse": good.document["accessors"][1]["sparse"]});
    let good = good.with_value("/meshes/0/weights", json!([0, 0]));
    refused(&good.with_value("/accessors/0", bare.clone()), "unfolds to far more than its size");
    let mut more = bare;
    more["count"] = json!(u64::MAX);
    refused(&good.with_value("/accessors/0", more), "accessors[0]: has no bufferView");
}

#[test]
fn what_is_wrong_is_named() {
    let good = face().with_value("/meshes/0/weights", json!([0.5, 1.0]));
    let refused = |file: &Draft, expected: &str| {
        let error = file.vertices(None).expect_err(expected).to_string();
        assert!(error.contains("part.glb: ") && error.contains(expected), "{error:?} lacks {expected:?}");
    };
    let rule = "nodes[0]: meshes[0] \"\": has 1 weights: must be finite, one for each of its 2 morph targets";
    refused(&good.with_value("/meshes/0/weights", json!([0.5])), rule);
    refused(
        &good.with_value("/meshes/0/primitives/0/targets/0/POSITION", json!(77)),
        "targets[0]: accessors[77]: no such",
    );
    let short = good.with_value("/accessors/1/count", json!(2));
    refused(&short, "primitives[0]: targets[0]: moves 2 positions: there are 3");
    let other = json!([good.document["meshes"][0]["primitives"][0], {"attributes": {"POSITION": 0}}]);
    refused(
        &good.with_value("/meshes/0/primitives", other),
        "its primitives have 2 and 0 morph targets: all must have",
    );
    let mut animated = good.clone();
    animated.channel(0, "weights", "LINEAR", &[0., 1.], &[0., 0., 1.]);
    animated.assert_refused("samplers[0]: output has 3 values: its 2 times of 2 morph targets need 4");
    let mut bare = good.with_value("/nodes", json!([{"mesh": 0}, {}]));
    bare.channel(1, "weights", "LINEAR", &[0.], &[0., 0.]);
    bare.assert_refused("animations[0].channels[0]: blends shapes of nodes[1]: that node must have a mesh");
    // Of targets that were taken away, the channel may be left.
    let mut left =
        Draft::triangle(json!([{"mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,5,0,1]}]), &[0]);
    left.channel(0, "weights", "LINEAR", &[0.], &[1.]);
    left.assert_refused("animations[0] moves no node");
    // A node's own matrix is no hindrance: it is its mesh that changes.
    let mut placed =
        face().with_value("/nodes/0/matrix", json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1]));
    placed.channel(0, "weights", "LINEAR", &[0.], &[1., 0.]);
    assert_near(&placed, Some(0.0), [[0., 0., 7.], [1., 0., 5.], [0., 1., 5.]]);
}
