//! What a robot carries: where it is from one moment to the next, what is refused, and what is told of it.

use glam::{DQuat, DVec3};
use perirobot_march::Result;
use perirobot_scene::objects::{Object, Role, Scene, Surface, build::build};
use perirobot_scene::source::Sources;
use perirobot_study::input::load_scene;

use crate::common::program::{Folder, perirobot, refused, text};

/// A turning arm of one metre whose tip is 0.5 m high.
const ARM: &str = r#"<robot name="arm"><link name="base"/>
<link name="arm"><collision><origin xyz="0.5 0 0"/><geometry><box size="1 0.1 0.1"/></geometry></collision></link>
<link name="tip"/>
<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><origin xyz="0 0 0.5"/><axis xyz="0 0 1"/>
<limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="weld" type="fixed"><parent link="arm"/><child link="tip"/><origin xyz="1 0 0" rpy="0 1.5707963267948966 0"/></joint>
</robot>"#;

/// The arm, which stands at (1, 2, 0) and turns.
const ROBOT: &str = "[[object]]\nname = \"arm\"\nurdf = \"arm.urdf\"\nposition_m = [1, 2, 0]\n\
                     [object.snapshots]\njoints_deg = [{ turn = 0 }, { turn = 90 }, { turn = 30 }]\n";

/// A box of 10 × 20 × 30 cm that ends where the tip's frame is, with these keys.
fn gripper(keys: &str) -> String {
    format!(
        "[[object]]\nname = \"gripper\"\nbox = {{ size_m = [0.1, 0.2, 0.3] }}\nposition_m = [0, 0, 0.15]\n\
         on = {{ object = \"arm\", link = \"tip\" }}\n{keys}"
    )
}

fn scenes(toml: &str) -> Result<Vec<Scene>> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cell.toml");
    std::fs::write(folder.path().join("arm.urdf"), ARM).unwrap();
    std::fs::write(&path, toml).unwrap();
    let sources = Sources::from_main(&path);
    build(&load_scene(&path, &sources)?, &sources, 0.1)
}

fn find<'a>(scene: &'a Scene, name: &str) -> &'a Object {
    scene.objects.iter().find(|object| object.name == name).unwrap()
}

#[track_caller]
fn assert_bounds(object: &Object, low: [f64; 3], high: [f64; 3]) {
    let Surface::Mesh(mesh) = &object.surface else { panic!("a mesh") };
    let (found_low, found_high) = mesh.bounds().unwrap();
    let is_near = |found: DVec3, expected: [f64; 3]| (found - DVec3::from_array(expected)).length() < 1e-9;
    assert!(is_near(found_low, low) && is_near(found_high, high), "{found_low} to {found_high}");
}

#[test]
fn a_gripper_goes_where_its_link_goes() {
    // The gripper is before its robot in the file, and stays so.
    let scenes = scenes(&(gripper("") + ROBOT)).unwrap();
    assert_eq!(scenes.len(), 3);
    assert!(scenes.iter().all(|scene| scene.objects[0].name == "gripper"));
    assert_eq!(find(&scenes[0], "gripper").role, Role::Robot);
    // The tip's z points along the arm and its x down: 30 cm on from (2, 2, 0.5).
    assert_bounds(find(&scenes[0], "gripper"), [2.0, 1.9, 0.45], [2.3, 2.1, 0.55]);
    assert_bounds(find(&scenes[1], "gripper"), [0.9, 3.0, 0.45], [1.1, 3.3, 0.55]);
    // Every corner at 30 degrees, by a rotation about the arm's axis.
    let Surface::Mesh(mesh) = &find(&scenes[2], "gripper").surface else { panic!("a mesh") };
    let Surface::Mesh(ahead) = &find(&scenes[0], "gripper").surface else { panic!("a mesh") };
    let foot = DVec3::new(1.0, 2.0, 0.5);
    let turn = DQuat::from_rotation_z(30f64.to_radians());
    for (corner, ahead) in mesh.vertices.iter().zip(&ahead.vertices) {
        assert!((*corner - (foot + turn * (*ahead - foot))).length() < 1e-9, "{corner}");
    }
}

#[test]
fn a_box_is_put_down() {
    let keys = "role = \"environment\"\n[object.snapshots]\ncarried = [false, true, false]\n\
                position_m = [[3, 3, 0.1], [0, 0, 0.15], [0, 0, 0.2]]\n";
    let scenes = scenes(&(ROBOT.to_string() + &gripper(keys))).unwrap();
    let of = |moment: usize| find(&scenes[moment], "gripper");
    assert_bounds(of(0), [2.95, 2.9, -0.05], [3.05, 3.1, 0.25]);
    assert_bounds(of(1), [0.9, 3.0, 0.45], [1.1, 3.3, 0.55]);
    assert_bounds(of(2), [-0.05, -0.1, 0.05], [0.05, 0.1, 0.35]);
    assert_eq!(of(0).role, Role::Environment);
}

/// A tool changer: a second arm on the first, and a box on the second. A person stands on the base.
#[test]
fn what_is_carried_carries() {
    let second = "[[object]]\nname = \"second\"\nurdf = \"arm.urdf\"\nrpy_deg = [0, -90, 0]\njoints_deg = { turn = 90 }\n\
                  on = { object = \"arm\", link = \"tip\" }\n";
    let end = gripper("").replace("object = \"arm\"", "object = \"second\"");
    let scenes = scenes(&(end + second + ROBOT)).unwrap();
    // Turned back by 90 degrees, the second arm stands upright on the tip, turned by 90.
    assert_bounds(find(&scenes[0], "gripper"), [1.9, 3.0, 0.95], [2.1, 3.3, 1.05]);
    // Both turn: with the first at 90 the second points back.
    assert_bounds(find(&scenes[1], "gripper"), [-0.3, 2.9, 0.95], [0.0, 3.1, 1.05]);
}

#[test]
fn carrying_that_cannot_be() {
    let wrong = |toml: &str, expected: &[&str]| {
        let error = scenes(toml).unwrap_err().to_string();
        for fragment in expected {
            assert!(error.contains(fragment), "no {fragment:?} in {error}");
        }
    };
    let with = |from: &str, to: &str| ROBOT.to_string() + &gripper("").replace(from, to);
    wrong(
        &with("\"tip\"", "\"tool0\""),
        &["cell.toml: object \"gripper\": on: link = \"tool0\": there is no link", "base, arm, tip"],
    );
    wrong(
        &with("\"arm\"", "\"Arm\""),
        &["object \"gripper\".on.object = \"Arm\": must be another object of the scene", "[\"arm\"]"],
    );
    wrong(
        &with("\"arm\"", "\"gripper\""),
        &["object \"gripper\".on: it is carried by what it carries itself", "must stand in the world"],
    );
    wrong(
        &with(
            "on = { object = \"arm\", link = \"tip\" }",
            "[object.snapshots]\ncarried = [true, false, true]",
        ),
        &["object \"gripper\".snapshots: carried belongs to an object on another one", "add on = {"],
    );
    wrong(
        &(ROBOT.to_string() + &gripper("[object.snapshots]\ncarried = [true, false, true]\n")),
        &["object \"gripper\": no role", "put down at some moments", "role = \"environment\""],
    );
    wrong(
        &(ROBOT.to_string()
            + &gripper("role = \"robot\"\n[object.snapshots]\ncarried = [true, false, true]\n")),
        &["object \"gripper\".snapshots: no position_m", "in the link's frame where it is carried"],
    );
    wrong(
        &(ROBOT.to_string() + &gripper("[object.snapshots]\ncarried = [true, true]\n")),
        &["carried has 2 entries", "has 3"],
    );
    let map = "[[object]]\nname = \"map\"\noctomap = \"m.bt\"\non = { object = \"arm\", link = \"tip\" }\n";
    wrong(&(ROBOT.to_string() + map), &["object \"map\": an octomap stays where it is"]);
    // One mistake, told once.
    wrong(
        &(gripper("") + ROBOT).replace("arm.urdf", "no.urdf"),
        &["cell.toml: object \"arm\": urdf = ", "no.urdf"],
    );
}

/// The cell of the other tests with this arm and a small tool on it.
fn with_tool(position: &str) -> Folder {
    let folder = Folder::new();
    folder.write("arm.urdf", ARM);
    let objects = format!(
        "\n[[object]]\nname = \"robot\"\nurdf = \"arm.urdf\"\nposition_m = [-0.9, 0, 0.2]\n\
         [[object]]\nname = \"tool\"\nbox = {{ size_m = [0.06, 0.06, 0.2] }}\nposition_m = {position}\n\
         on = {{ object = \"robot\", link = \"tip\" }}\n"
    );
    folder.edit("cell.toml", "", &objects);
    folder
}

#[test]
fn what_is_carried_has_no_place_of_its_own() {
    let candidate = "\n[[candidate]]\nobject = \"tool\"\nx_m = [0, 1]\ny_m = [0]\n";
    let expected =
        ["study.toml", "candidate \"tool\".object: \"tool\" is carried by \"robot\"", "place that instead"];
    refused(&with_tool("[0, 0, 0.1]"), &[("study.toml", "", candidate)], &expected);
    let surface = "\n[[sensor]]\nname = \"eye\"\nkind = \"rgbd\"\nresolution_px = [16, 9]\nfov_deg = [70, 50]\n\
                   range_m = [0.1, 3]\n[[sensor.poses]]\nname = \"wall\"\n\
                   surface = { object = \"tool\", spacing_m = 0.1 }\n";
    let expected = ["object \"tool\": moves from one snapshot", "or move with a link of a robot"];
    refused(&with_tool("[0, 0, 0.1]"), &[("study.toml", "", surface)], &expected);
}

/// A cart that drives and turns, and who stands on it.
const CART: &str = "[[object]]\nname = \"rider\"\nrole = \"human\"\nbox = { size_m = [0.2, 0.2, 1] }\nposition_m = [0.1, 0, 0.7]\n\
                    on = { object = \"cart\" }\n\
                    [[object]]\nname = \"cart\"\nbox = { size_m = [1, 0.6, 0.4] }\n[object.snapshots]\n\
                    position_m = [[0, 0, 0.2], [1, 2, 0.2]]\nrpy_deg = [[0, 0, 0], [0, 0, 90]]\n";

#[test]
fn a_driver_goes_where_the_cart_goes() {
    let scenes = scenes(CART).unwrap();
    let roles = ["rider", "cart"].map(|name| find(&scenes[0], name).role);
    assert_eq!(roles, [Role::Human, Role::Environment]);
    assert_bounds(find(&scenes[0], "rider"), [0.0, -0.1, 0.4], [0.2, 0.1, 1.4]);
    // A quarter turn takes 0.1 m along x to y.
    assert_bounds(find(&scenes[1], "rider"), [0.9, 2.0, 0.4], [1.1, 2.2, 1.4]);
}

/// A workpiece in a gripper is as dangerous as the robot.
#[test]
fn what_is_on_a_gripper_is_robot() {
    let part =
        "[[object]]\nname = \"part\"\nbox = { size_m = [0.1, 0.1, 0.1] }\non = { object = \"gripper\" }\n";
    let scenes = scenes(&(gripper("") + ROBOT + part)).unwrap();
    assert_eq!(find(&scenes[0], "part").role, Role::Robot);
    let told = scenes
        .iter()
        .map(|scene| find(scene, "part").frame.position_m.distance(find(scene, "gripper").frame.position_m));
    assert!(told.into_iter().all(|away_m| away_m < 1e-9));
}

#[test]
fn carriers_that_cannot_be() {
    let wrong = |from: &str, to: &str| {
        assert!(CART.contains(from));
        scenes(
            &(ROBOT.replace("[{ turn = 0 }, { turn = 90 }, { turn = 30 }]", "[{ turn = 0 }, { turn = 90 }]")
                + &CART.replace(from, to)),
        )
        .unwrap_err()
        .to_string()
    };
    for (carrier, expected) in [
        (
            "{ object = \"truck\" }",
            "on.object = \"truck\": must be another object of the scene: [\"arm\", \"cart\"]",
        ),
        ("{ object = \"arm\" }", "on: no link: \"arm\" is a robot with the links base, arm, tip"),
        ("{ object = \"cart\", link = \"seat\" }", "object = \"cart\": must be a robot with links"),
    ] {
        let told = wrong("{ object = \"cart\" }", carrier);
        assert!(told.contains("object \"rider\"") && told.contains(expected), "{told}");
    }
}

/// What `check` says of it.
fn told(position: &str, region: &str) -> String {
    let folder = with_tool(position);
    folder.edit("study.toml", "sphere = { center_m = [0.2, 0.3, 0.4], radius_m = 0.6 }", region);
    let outcome = perirobot(&["check", text(&folder.path("study.toml")), "--backend", "cpu", "--poses", "0"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let lines = outcome.stdout.lines().chain(outcome.stderr.lines());
    lines.filter(|line| line.contains("\"tool\"") || line.contains("planes")).collect::<Vec<_>>().join("\n")
}

#[test]
fn a_carried_object_in_the_wrong_place_is_told() {
    let sphere = "sphere = { center_m = [0.2, 0.3, 0.4], radius_m = 0.6 }";
    assert_eq!(told("[0, 0, 0.1]", sphere), "");
    let inside = told("[0, 0, -0.5]", sphere);
    assert!(inside.contains("object \"tool\" is inside \"robot\", which carries it, with 100 %"), "{inside}");
    // As one would write it in the world.
    let far = told("[0.1, 0, 0.7]", sphere);
    assert!(
        far.contains("but is more than 0.2 m away from it: position_m is in the frame of link \"tip\" of"),
        "{far}"
    );
}

#[test]
fn a_reach_without_the_tool_is_told() {
    let reach = |tool_m: &str| told("[0, 0, 0.1]", &format!("robot_reach = {{ {tool_m} }}"));
    // √(0.2² + 2 · 0.03²) = 0.2045 m.
    let short = reach("");
    assert!(short.contains("region \"robot\": \"tool\" gets up to 0.21 m from link \"tip\""), "{short}");
    assert!(short.contains("write tool_m = 0.21"), "{short}");
    assert_eq!(reach("tool_m = 0.21"), "");
    // A safety plane the wrong way round.
    let plane = |normal: &str| {
        told(
            "[0, 0, 0.1]",
            &format!(
                "robot_reach = {{ tool_m = 0.21, planes = [{{ point_m = [0, 0, 0], normal = {normal} }}] }}"
            ),
        )
    };
    assert_eq!(plane("[-1, 0, 0]"), "");
    let behind = plane("[1, 0, 0]");
    assert!(behind.contains("the base of \"robot\" is behind robot_reach.planes[0]"), "{behind}");
}
