//! Scenes written as a user would, and where things are in their snapshots.

use std::sync::Arc;

use glam::DVec3;

use super::super::load_scene;
use perirobot_march::Result;
use perirobot_scene::objects::build::build;
use perirobot_scene::objects::{Object, Role, Scene, Surface};
use perirobot_scene::source::Sources;
use perirobot_scene::truth::voxelize::{grid_over, scene_extent};
use perirobot_scene::truth::voxelize_all;

/// The snapshots of a scene file in a folder with these other files.
fn scene_of(toml: &str, files: &[(&str, String)]) -> Result<Vec<Scene>> {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let path = folder.path().join("cell.toml");
    std::fs::write(&path, toml).unwrap();
    let sources = Sources::from_main(&path);
    build(&load_scene(&path, &sources)?, &sources, 0.1)
}

/// Lowest and highest corner of a part.
fn bounds(object: &Object) -> [DVec3; 2] {
    let Surface::Mesh(mesh) = &object.surface else { panic!("a mesh") };
    mesh.bounds().unwrap().into()
}

#[track_caller]
fn assert_near(found: DVec3, expected: [f64; 3]) {
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
        assert_eq!(truth.robot.bounds(), perirobot_march::voxel::Window::from_corners([x, 5, 5], [x, 5, 5]));
        assert!(Arc::ptr_eq(&truth.objects[0], &truths[0].objects[0]));
    }
    assert!(Arc::ptr_eq(&truths[0].objects[1], &truths[2].objects[1]));
}

#[test]
fn rotations_come_as_angles_or_quaternions() {
    for list in [
        "rpy_deg = [[0, 0, 0], [0, 0, 90]]",
        "quaternion = [{ w = 1, x = 0, y = 0, z = 0 }, { w = 0.7071068, x = 0, y = 0, z = 0.7071068 }]",
    ] {
        let toml = format!(
            "[[object]]\nname = \"bar\"\nbox = {{ size_m = [0.4, 0.2, 0.2] }}\nposition_m = [1, 0, 0]\n\
             rpy_deg = [0, 45, 0]\n[object.snapshots]\n{list}\n"
        );
        let scenes = scene_of(&toml, &[]).unwrap();
        assert_near(bounds(&scenes[0].objects[0])[1], [1.2, 0.1, 0.1]);
        assert_near(bounds(&scenes[1].objects[0])[1], [1.1, 0.2, 0.1]);
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
        assert_near(walker.keypoints.unwrap()[15].unwrap(), [x, 3.1, 0.1]);
        // Its toes lie 19 cm before the ankle's spot: 15 cm to the last centre, 4 cm around it.
        assert!((bounds(walker)[1].x - (x + 0.19)).abs() < 1e-3, "{:?}", bounds(walker));
    }
    // Another human has them beside its own surface, which stays.
    let toml = "[[object]]\nname = \"doll\"\nrole = \"human\"\nsphere = { radius_m = 0.2 }\n[object.snapshots]\n\
                keypoints = [\"a.csv\", \"b.csv\"]\nposition_m = [[0, 0, 0], [0, 0, 1]]\n";
    let scenes = scene_of(toml, &files).unwrap();
    assert_near(scenes[0].objects[0].keypoints.unwrap()[15].unwrap(), [0.0, 0.1, 0.1]);
    assert_near(scenes[1].objects[0].keypoints.unwrap()[15].unwrap(), [0.5, 0.1, 1.1]);
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
            assert_near(bounds(slide)[0], [x, 0.0, 0.0]);
            assert_near(bounds(slide)[1], [x + 1.0, 0.0, 1.0]);
            assert_eq!(still.warnings, [""; 0]);
        }
    }
    // Poses and times go together, and the clip may go unnamed.
    let toml = format!(
        "{SLIDE}snapshots = {{ position_m = [[0, 5, 0], [0, 6, 0]], animation = {{ times_s = [0, 9] }} }}\n"
    );
    let scenes = scene_of(&toml, &[("cart.gltf", sliding())]).unwrap();
    assert_near(bounds(&scenes[1].objects[1])[0], [4.0, 6.0, 0.0]);
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
    assert_near(bounds(&scenes[0].objects[1])[0], [0.0, 0.0, 0.0]);
    assert_near(bounds(&scenes[2].objects[1])[0], [4.0, 0.0, 0.0]);
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
}

/// A skeleton of the fewest bones, which walks along z: at x centimetres in frame x / 10, ten frames a second.
fn walking() -> String {
    let limbs = [("LeftArm", 20), ("RightArm", -20), ("LeftUpLeg", 10), ("RightUpLeg", -10)];
    let chain = |(name, x): (&str, i32)| {
        let (side, arm) = (name.split_inclusive('t').next().unwrap(), name.ends_with("Arm"));
        let (next, last, y) = if arm { ("ForeArm", "Hand", 50) } else { ("Leg", "Foot", 0) };
        let bone = |name: String, offset: String, below: String| {
            format!("JOINT {name}\n{{\nOFFSET {offset}\nCHANNELS 0\n{below}}}\n")
        };
        let last = bone(format!("{side}{last}"), "0 -40 0".into(), String::new());
        bone(name.into(), format!("{x} {y} 0"), bone(format!("{side}{next}"), "0 -40 0".into(), last))
    };
    let limbs: String = limbs.into_iter().map(chain).collect();
    let frames: String = (0..5).map(|frame| format!("0 90 {}\n", 10 * frame)).collect();
    format!(
        "HIERARCHY\nROOT Hips\n{{\nOFFSET 0 0 0\nCHANNELS 3 Xposition Yposition Zposition\n{limbs}JOINT Head\n{{\n\
         OFFSET 0 65 0\nCHANNELS 0\n}}\n}}\nMOTION\nFrames: 5\nFrame Time: 0.1\n{frames}"
    )
}

#[test]
fn a_recorded_walk_moves_a_person_and_its_joints() {
    let walker =
        "[[object]]\nname = \"walker\"\nmannequin = \"walk.bvh\"\nunit = \"cm\"\nrpy_deg = [0, 0, 90]\n";
    let moving = format!(
        "{walker}position_m = [5, 0, 0]\nsnapshots = {{ animation = {{ times_s = [0, 0.2, 0.4, 9] }} }}\n"
    );
    let scenes = scene_of(&moving, &[("walk.bvh", walking())]).unwrap();
    assert_eq!(scenes.len(), 4);
    for (scene, z) in scenes.iter().zip([0.0, 0.2, 0.4, 0.4]) {
        let [person] = &scene.objects[..] else { panic!("one") };
        assert_eq!((person.role, person.warnings.len()), (Role::Human, 0));
        // Who walks along the file's z walks along −y, and turned by 90° along +x, with the left at +y.
        let joints = person.keypoints.unwrap();
        assert_near(joints[15].unwrap(), [5.0 + z, 0.1, 0.1]);
        assert_near(joints[5].unwrap(), [5.0 + z, 0.2, 1.4]);
        assert_near(joints[0].unwrap(), [5.1 + z, 0.0, 1.6]);
        let [low, high] = bounds(person);
        assert!(low.z < 0.1 && high.z > 1.6 && low.x < 5.0 + z && high.x > 5.0 + z, "{low} {high}");
    }
    assert!(Arc::ptr_eq(&scenes[2].objects[0], &scenes[3].objects[0]), "held at the end");
    let late = format!("{walker}snapshots = {{ animation = {{ times_s = [7] }} }}\n");
    let scenes = scene_of(&late, &[("walk.bvh", walking())]).unwrap();
    let warnings = &scenes[0].objects[0].warnings;
    assert!(
        warnings[0].contains("from 0 to 0.4 s, and all of snapshots.animation.times_s are outside"),
        "{warnings:?}"
    );
    // Without times it is the first frame.
    assert_near(
        scene_of(walker, &[("walk.bvh", walking())]).unwrap()[0].objects[0].keypoints.unwrap()[15].unwrap(),
        [0.0, 0.1, 0.1],
    );
    let error =
        scene_of(walker, &[("walk.bvh", walking().replace("LeftHand", "Paw"))]).unwrap_err().to_string();
    assert!(
        error.contains("object \"walker\": mannequin = ") && error.contains("walk.bvh: none of its bones"),
        "{error}"
    );
}

/// A long thin box walks round a corner, turned to the side by its own rotation, together with another as long.
#[test]
fn who_walks_faces_along_the_path() {
    let walker = "[[object]]\nname = \"walker\"\nbox = { size_m = [1, 0.2, 0.2] }\nrpy_deg = [0, 0, 90]\n[object.snapshots]\n\
                  walk = { path_m = [[0, 0, 1], [1, 0, 1], [1, 1, 1]], step_m = 1, speed_m_s = 2 }\n";
    let other = walker.replace("walker", "other").replace("rpy_deg = [0, 0, 90]\n", "");
    let scenes = scene_of(&format!("{walker}{other}"), &[]).unwrap();
    assert_eq!(scenes.len(), 3);
    let size = |moment: usize, object: usize| {
        let [low, high] = bounds(&scenes[moment].objects[object]);
        high - low
    };
    assert_near(size(0, 0), [0.2, 1.0, 0.2]);
    assert_near(size(2, 0), [1.0, 0.2, 0.2]);
    assert_near(size(0, 1), [1.0, 0.2, 0.2]);
    let [low, high] = bounds(&scenes[2].objects[0]);
    assert_near((low + high) / 2.0, [1.0, 1.0, 1.0]);
    let refused = |toml: &str, expected: &str| {
        let error = scene_of(toml, &[]).unwrap_err().to_string();
        assert!(error.contains(expected), "no {expected:?} in {error}");
    };
    refused(&format!("{walker}dwell_s = [1, 2, 3]\n"), "both walk and a list of positions");
    let slower = other.replace("speed_m_s = 2", "speed_m_s = 1");
    refused(&format!("{walker}{slower}"), "both have snapshots.dwell_s or a walk, and other durations");
}

/// A slide that carries a turning arm of one metre, with a finger that mimics, and one that is fixed.
const ARM: &str = r#"<robot name="arm"><link name="base"/><link name="cart"/><link name="arm"><collision><origin xyz="0.5 0 0"/>
<geometry><box size="1 0.1 0.1"/></geometry></collision></link><link name="finger"/><link name="tip"/>
<joint name="slide" type="prismatic"><parent link="base"/><child link="cart"/><axis xyz="1 0 0"/><limit lower="0" upper="9" effort="1" velocity="1"/></joint>
<joint name="turn" type="revolute"><parent link="cart"/><child link="arm"/><axis xyz="0 0 1"/><limit lower="-2" upper="2" effort="1" velocity="1"/></joint>
<joint name="grip" type="revolute"><parent link="arm"/><child link="finger"/><axis xyz="0 0 1"/><limit lower="-9" upper="9" effort="1" velocity="1"/><mimic joint="turn"/></joint>
<joint name="weld" type="fixed"><parent link="arm"/><child link="tip"/><origin xyz="1 0 0"/></joint></robot>"#;

#[test]
fn a_robot_stands_as_it_was_recorded() {
    let table = "time_s,turn,slide,grip,weld\n10,0,1,7,0\n12,1.5707963267948966,3,8,0\n";
    let files = |table: &str| [("arm.urdf", ARM.to_string()), ("did.csv", table.to_string())];
    let toml = |angles: &str, times: &str| {
        format!(
            "[[object]]\nname = \"arm\"\nurdf = \"arm.urdf\"\njoints_m = {{ slide = 8 }}\n[object.snapshots]\n\
             animation = {{ joints = \"did.csv\", angles = \"{angles}\", times_s = {times} }}\n"
        )
    };
    let tip = |scene: &Scene| scene.objects[0].linkage.as_ref().unwrap().link("tip").unwrap().position_m;
    let scenes = scene_of(&toml("rad", "[10, 11, 99]"), &files(table)).unwrap();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    assert_near(tip(&scenes[0]), [2.0, 0.0, 0.0]);
    assert_near(tip(&scenes[1]), [2.0 + half, half, 0.0]);
    assert_near(tip(&scenes[2]), [3.0, 1.0, 0.0]);
    let in_degrees = table.replace("1.5707963267948966", "90");
    assert_near(tip(&scene_of(&toml("deg", "[12]"), &files(&in_degrees)).unwrap()[0]), [3.0, 1.0, 0.0]);
    // A joint that the table does not have is as the object says.
    let only = "time_s,turn\n0,0\n";
    assert_near(tip(&scene_of(&toml("deg", "[0]"), &files(only)).unwrap()[0]), [9.0, 0.0, 0.0]);
    let refused = |angles: &str, table: &str, expected: &[&str]| {
        let error = scene_of(&toml(angles, "[12]"), &files(table)).unwrap_err().to_string();
        for fragment in [&["cell.toml: object \"arm\": "], expected].concat() {
            assert!(error.contains(fragment), "no {fragment:?} in {error}");
        }
    };
    refused("rad", &table.replace("turn", "trun"), &["did.csv: column \"trun\": ", "there are slide, turn"]);
    refused("rad", &in_degrees, &["joints_deg.turn = 5156", "must be from -114.5916 to 114.5916"]);
    refused("rad", "time,turn\n", &["snapshots.animation.joints = ", "did.csv: its header begins with"]);
    let late = scene_of(&toml("deg", "[1]"), &files(only)).unwrap();
    assert!(late[0].objects[0].warnings[0].contains("from 0 to 0 s"), "{:?}", late[0].objects[0].warnings);
}

#[test]
fn models_of_a_world_take_roles_by_their_names() {
    let model = |name: &str, x: f64| {
        format!(
            "<model name='{name}'><pose>{x} 0 0 0 0 0</pose><link name='body'><sensor name='s'/><collision name='c'><geometry><box>\
             <size>1 1 1</size></box></geometry></collision></link></model>"
        )
    };
    let world = format!(
        "<sdf version='1.9'><world name='w'>{}{}{}</world></sdf>",
        model("table", 0.0),
        model("arm_1", 2.0),
        model("dummy", 4.0)
    );
    let toml = "[[object]]\nname = \"cell\"\nsdf = \"cell.world\"\nposition_m = [0, 0, 5]\n\
                nodes = [{ match = \"arm_*\", role = \"robot\" }, { match = \"dummy\", ignore = true }]\n";
    let scenes = scene_of(toml, &[("cell.world", world)]).unwrap();
    let [rest, arm] = &scenes[0].objects[..] else { panic!("two parts") };
    assert_eq!((rest.name.as_str(), rest.role), ("cell", Role::Environment));
    assert_eq!((arm.name.as_str(), arm.role), ("cell/arm_*", Role::Robot));
    assert_near(bounds(rest)[1], [0.5, 0.5, 5.5]);
    assert_near(bounds(arm)[0], [1.5, -0.5, 4.5]);
    assert_eq!(rest.warnings, ["is an SDF world of which this is left out: sensor (3)"]);
}
