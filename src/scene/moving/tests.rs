//! Scenes written as a user would, and where things are in their snapshots.

use super::*;
use crate::scene::build::build;
use crate::scene::spec::SceneSpec;
use crate::scene::{Role, Scene};
use crate::source::Sources;
use crate::voxel::voxelize::{grid_over, scene_extent};
use crate::voxel::voxelize_all;

/// The snapshots of a scene file in a folder with these other files.
fn scene_of(toml: &str, files: &[(&str, String)]) -> Result<Vec<Scene>> {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let path = folder.path().join("cell.toml");
    std::fs::write(&path, toml).unwrap();
    let sources = Sources::beside(&path);
    build(&SceneSpec::load(&path, &sources)?, &sources, 0.1)
}

/// Lowest and highest corner of a part.
fn bounds(object: &Object) -> [DVec3; 2] {
    let Surface::Mesh(mesh) = &object.surface else { panic!("a mesh") };
    mesh.bounds().unwrap().into()
}

#[track_caller]
fn near(found: DVec3, expected: [f64; 3]) {
    assert!((found - DVec3::from_array(expected)).length() < 1e-6, "{found}, expected {expected:?}");
}

const WALL: &str = "[[object]]\nname = \"wall\"\nbox = { size_m = [0.1, 1, 1] }\nposition_m = [2, 0, 0]\n";

#[test]
fn what_stands_still_is_shared_and_what_moves_lands_where_it_should() {
    let toml = format!(
        "{WALL}[[object]]\nname = \"cart\"\nrole = \"robot\"\nbox = {{ size_m = [0.02, 0.02, 0.02] }}\n\
         position_m = [9, 9, 9]\n[object.snapshots]\nposition_m = [[0.05, 0.05, 0.05], [0.25, 0.05, 0.05], \
         [0.05, 0.05, 0.05]]\n"
    );
    let scenes = scene_of(&toml, &[]).unwrap();
    assert_eq!(
        scenes.iter().map(|s| (s.name.as_str(), s.snapshot)).collect::<Vec<_>>(),
        [("cell", 0), ("cell", 1), ("cell", 2)]
    );
    assert!(scenes.iter().all(|scene| Arc::ptr_eq(&scene.objects[0], &scenes[0].objects[0])));
    assert!(!Arc::ptr_eq(&scenes[0].objects[1], &scenes[1].objects[1]));
    assert!(Arc::ptr_eq(&scenes[0].objects[1], &scenes[2].objects[1]), "back where it was");
    let grid = grid_over(&scene_extent(&scenes, 0.1).unwrap(), 0.1).unwrap();
    let truths = voxelize_all(&scenes, grid).unwrap();
    for (truth, x) in truths.iter().zip([0, 2, 0]) {
        // The grid's lowest voxel is the wall's on y and z, and the cart's on x.
        assert_eq!(truth.robot.bounds(), crate::voxel::Window::between([x, 5, 5], [x, 5, 5]));
        assert!(Arc::ptr_eq(&truth.objects[0], &truths[0].objects[0]));
    }
    assert!(Arc::ptr_eq(&truths[0].objects[1], &truths[2].objects[1]));
}

#[test]
fn rotations_come_as_angles_or_quaternions() {
    for list in [
        "rpy_deg = [[0, 0, 0], [0, 0, 90]]",
        "quaternion = [{ w = 1, x = 0, y = 0, z = 0 }, { w = 2, x = 0, y = 0, z = 2 }]",
    ] {
        let toml = format!(
            "[[object]]\nname = \"bar\"\nbox = {{ size_m = [0.4, 0.2, 0.2] }}\nposition_m = [1, 0, 0]\n\
             rpy_deg = [0, 45, 0]\n[object.snapshots]\n{list}\n"
        );
        let scenes = scene_of(&toml, &[]).unwrap();
        near(bounds(&scenes[0].objects[0])[1], [1.2, 0.1, 0.1]);
        near(bounds(&scenes[1].objects[0])[1], [1.1, 0.2, 0.1]);
    }
}

#[test]
fn lists_that_repeat_fill_the_scene() {
    let toml = format!(
        "{WALL}snapshots.position_m = [[0, 0, 0], [1, 0, 0], [2, 0, 0], [3, 0, 0], [4, 0, 0]]\n\
         [[object]]\nname = \"arm\"\nbox = {{ size_m = [0.2, 0.2, 0.2] }}\n[object.snapshots]\ncycle = true\n\
         position_m = [[0, 0, 1], [0, 0, 2]]\nrpy_deg = [[0, 0, 0], [0, 0, 10], [0, 0, 20]]\n"
    );
    let scenes = scene_of(&toml, &[]).unwrap();
    assert_eq!(scenes.len(), 5);
    let heights: Vec<f64> = scenes.iter().map(|s| bounds(&s.objects[1])[1].z.round()).collect();
    assert_eq!(heights, [1.0, 2.0, 1.0, 2.0, 1.0]);
    // Unturned, it reaches 0.1 on x; turned by 10° 0.1158, by 20° 0.1282.
    let reach: Vec<f64> = scenes.iter().map(|s| (bounds(&s.objects[1])[1].x * 1e4).round()).collect();
    assert_eq!(reach, [1000.0, 1158.0, 1282.0, 1000.0, 1158.0]);
    // Alone, the longest list that repeats is once through.
    let alone = "[[object]]\nname = \"arm\"\nbox = { size_m = [0.2, 0.2, 0.2] }\n[object.snapshots]\ncycle = true\n\
                 position_m = [[0, 0, 1], [0, 0, 2]]\n";
    assert_eq!(scene_of(alone, &[]).unwrap().len(), 2);
}

/// Keypoints of hips and ankles: hips 0.2 m apart at a height, legs straight down.
fn legs(x: f64) -> String {
    let pair = |z: f64| format!("{x},0.1,{z}\n{x},-0.1,{z}\n");
    format!("{}{}{}{}", ",,\n".repeat(11), pair(0.9), pair(0.5), pair(0.1))
}

#[test]
fn people_move_by_their_keypoints() {
    let files = [("a.csv", legs(0.0)), ("b.csv", legs(0.5))];
    let toml = "[[object]]\nname = \"walker\"\nposition_m = [0, 3, 0]\n[object.snapshots]\n\
                mannequin = [\"a.csv\", \"b.csv\"]\n";
    let scenes = scene_of(toml, &files).unwrap();
    for (scene, x) in scenes.iter().zip([0.0, 0.5]) {
        let walker = &scene.objects[0];
        assert_eq!(walker.role, Role::Human);
        near(walker.keypoints.unwrap()[15].unwrap(), [x, 3.1, 0.1]);
        // Its toes lie 19 cm before the ankle's spot: 15 cm to the last centre, 4 cm around it.
        assert!((bounds(walker)[1].x - (x + 0.19)).abs() < 1e-3, "{:?}", bounds(walker));
    }
    // Another human has them beside its own surface, which stays.
    let toml = "[[object]]\nname = \"doll\"\nrole = \"human\"\nsphere = { radius_m = 0.2 }\n[object.snapshots]\n\
                keypoints = [\"a.csv\", \"b.csv\"]\nposition_m = [[0, 0, 0], [0, 0, 1]]\n";
    let scenes = scene_of(toml, &files).unwrap();
    near(scenes[0].objects[0].keypoints.unwrap()[15].unwrap(), [0.0, 0.1, 0.1]);
    near(scenes[1].objects[0].keypoints.unwrap()[15].unwrap(), [0.5, 0.1, 1.1]);
    assert!((bounds(&scenes[1].objects[0])[1].z - 1.2).abs() < 1e-3);
}

/// A glTF file as text: the triangle (0, 0, 0), (1, 0, 0), (0, 1, 0) twice, at nodes `still` and `slide`; a
/// clip moves `slide` along glTF's x from 0 to 4 m in 2 s. The buffer is that of 9 + 2 + 6 floats.
fn sliding() -> String {
    use base64::Engine as _;
    let floats = [0f32, 0., 0., 1., 0., 0., 0., 1., 0., 0., 2., 0., 0., 0., 4., 0., 0.];
    let bytes: Vec<u8> = floats.iter().flat_map(|x| x.to_le_bytes()).collect();
    let data = base64::engine::general_purpose::STANDARD.encode(bytes);
    serde_json::json!({
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"name": "still", "mesh": 0}, {"name": "slide", "mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "animations": [{
            "name": "go",
            "channels": [
                {"sampler": 0, "target": {"node": 1, "path": "translation"}},
            ],
            "samplers": [{"input": 1, "output": 2}],
        }],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3},
            {"bufferView": 0, "byteOffset": 36, "componentType": 5126, "type": "SCALAR", "count": 2},
            {"bufferView": 0, "byteOffset": 44, "componentType": 5126, "type": "VEC3", "count": 2},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 68}],
        "buffers": [{"byteLength": 68, "uri": format!("data:application/octet-stream;base64,{data}")}],
    })
    .to_string()
}

const SLIDE: &str =
    "[[object]]\nname = \"cart\"\nmesh = \"cart.gltf\"\nnodes = [{ match = \"slide\", role = \"robot\" }]\n";

#[test]
fn an_animation_moves_its_nodes_and_shares_the_others() {
    let written = [("\"go\"", "{ start = 0, stop = 1.5, step = 0.5 }"), ("0", "[0, 0.5, 1, 1.5]")];
    for (clip, times) in written {
        let toml = format!("{SLIDE}snapshots = {{ animation = {{ clip = {clip}, times_s = {times} }} }}\n");
        let scenes = scene_of(&toml, &[("cart.gltf", sliding())]).unwrap();
        assert_eq!(scenes.len(), 4);
        for (scene, x) in scenes.iter().zip([0.0, 1.0, 2.0, 3.0]) {
            let [still, slide] = &scene.objects[..] else { panic!("two parts") };
            assert!(Arc::ptr_eq(still, &scenes[0].objects[0]));
            assert_eq!((slide.name.as_str(), slide.role), ("cart/slide", Role::Robot));
            near(bounds(slide)[0], [x, 0.0, 0.0]);
            near(bounds(slide)[1], [x + 1.0, 0.0, 1.0]);
            assert_eq!(still.warnings, [""; 0]);
        }
    }
    // Poses and times go together, and the clip may go unnamed.
    let toml = format!(
        "{SLIDE}snapshots = {{ position_m = [[0, 5, 0], [0, 6, 0]], animation = {{ times_s = [0, 9] }} }}\n"
    );
    let scenes = scene_of(&toml, &[("cart.gltf", sliding())]).unwrap();
    near(bounds(&scenes[1].objects[1])[0], [4.0, 6.0, 0.0]);
    assert_eq!(scenes[1].objects[0].warnings, [""; 0], "one time is inside");
}

#[test]
fn times_that_are_all_outside_the_clip_are_told() {
    let toml = format!("{SLIDE}snapshots = {{ animation = {{ times_s = [-1, 3, 4] }} }}\n");
    let scenes = scene_of(&toml, &[("cart.gltf", sliding())]).unwrap();
    let warnings = &scenes[0].objects[0].warnings;
    assert!(
        warnings[0].contains("from 0 to 2 s, and all of snapshots.animation.times_s are outside"),
        "{warnings:?}"
    );
    near(bounds(&scenes[0].objects[1])[0], [0.0, 0.0, 0.0]);
    near(bounds(&scenes[2].objects[1])[0], [4.0, 0.0, 0.0]);
    assert!(Arc::ptr_eq(&scenes[1].objects[1], &scenes[2].objects[1]), "held at the end");
}

#[test]
fn what_cannot_be_sampled_is_named_by_scene_object_key_and_file() {
    let refused = |clip: &str, file: String, expected: &[&str]| {
        let toml = format!("{SLIDE}snapshots = {{ animation = {{ {clip}times_s = [0, 1] }} }}\n");
        let error = scene_of(&toml, &[("cart.gltf", file)]).unwrap_err().to_string();
        for fragment in [&["cell.toml: object \"cart\": ", "cart.gltf: "], expected].concat() {
            assert!(error.contains(fragment), "no {fragment:?} in {error}");
        }
    };
    let unknown = ["snapshots.animation.clip: ", "no animation is named \"walk\": there are \"go\""];
    refused("clip = \"walk\", ", sliding(), &unknown);
    refused("clip = 1, ", sliding(), &["there is no animation 1: there are 1, counted from 0: \"go\""]);
    let still = sliding().replace("\"animations\"", "\"animatons\"");
    refused("", still, &["snapshots.animation.clip: ", "has no animation"]);
    refused("", sliding().replace("\"byteOffset\":36", "\"byteOffset\":40"), &["times must increase"]);
    // A file that shrinks a part away would leave it without a place in the results.
    let parts = |names: &[&str]| {
        let part = |name: &&str| {
            Arc::new(Object { name: (*name).into(), ..(*scene_of(WALL, &[]).unwrap()[0].objects[0]).clone() })
        };
        names.iter().map(part).collect::<Vec<_>>()
    };
    let error = same_parts(&parts(&["a", "b"]), &parts(&["b"]), 3).unwrap_err().to_string();
    assert!(error.contains("the parts a, b in snapshot 0, but b in snapshot 3"), "{error}");
}

#[test]
fn triangles_are_counted_where_an_object_is_another_than_before() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cell.toml");
    let moving = "[object.snapshots]\nposition_m = [[2, 0, 0], [2, 1, 0], [2, 0, 0], [2, 1, 0]]\n";
    std::fs::write(&path, format!("{WALL}{moving}")).unwrap();
    let sources = Sources::beside(&path);
    let spec = SceneSpec::load(&path, &sources).unwrap();
    let with = |triangles_left| {
        let mut files = SceneFiles { triangles_left, ..SceneFiles::new(&sources) };
        moments(&spec.objects[0], 4, &mut files, 0.01).map(|_| files.triangles_left)
    };
    // A box has 12: its shape, and it in two places.
    assert_eq!(with(40).unwrap(), 4);
    assert_eq!(with(36).unwrap(), 0);
    let error = with(35).unwrap_err().to_string();
    assert!(error.contains("unfolds to more than") && error.contains("split the recording"), "{error}");
}
