//! Robots from a URDF in a scene: what they are by default, where their links stand in the world, and that the shipped
//! arm stands as the one of the paper's scenes does.

use std::path::Path;

use glam::DVec3;
use perirobot::scene::{Object, Role, Surface, build::build, gltf};
use perirobot::study::SceneSpec;

/// The posture of `ur10.glb`; see `generated_meshes.rs`. The paper's robot has its base on the table, as its maker
/// turns it: half a turn from ROS's.
const POSTURE: &str = "position_m = [0, 0, 1]
rpy_deg = [0, 0, 180]
joints_deg = { shoulder_pan_joint = 145, shoulder_lift_joint = -90, elbow_joint = 120, wrist_1_joint = -30, \
    wrist_2_joint = 90 }";

fn shipped(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/paper").join(name)
}

/// The shipped arm as the one object of a scene.
fn arm(keys: &str) -> Object {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("cell.toml");
    let urdf = shipped("ur10.urdf");
    std::fs::write(&scene, format!("[[object]]\nname = \"arm\"\nurdf = {urdf:?}\n{keys}\n")).unwrap();
    let scene = build(&SceneSpec::load(&scene).unwrap(), 0.05).unwrap().remove(0);
    assert_eq!(scene.objects.len(), 1);
    (*scene.objects[0]).clone()
}

fn bounds(object: &Object) -> [DVec3; 2] {
    let Surface::Mesh(mesh) = &object.surface else { panic!("a mesh") };
    mesh.bounds().unwrap().into()
}

#[test]
fn a_urdf_is_a_robot_and_keeps_its_links() {
    let arm = arm("position_m = [1, 2, 3]\nrpy_deg = [0, 0, 90]");
    assert_eq!((arm.name.as_str(), arm.role), ("arm", Role::Robot));
    let linkage = arm.linkage.as_ref().unwrap();
    let names: Vec<&str> = linkage.links.iter().map(|(name, _)| name.as_str()).collect();
    #[rustfmt::skip]
    assert_eq!(names, [
        "base_link", "shoulder_link", "upper_arm_link", "forearm_link", "wrist_1_link", "wrist_2_link",
        "wrist_3_link", "tool0",
    ]);
    assert_eq!(linkage.base_m, DVec3::new(1.0, 2.0, 3.0));
    assert!(linkage.reach_m > 1.3 && linkage.reach_m < 1.6, "{}", linkage.reach_m);
    // Stretched along the robot's x, which is the world's y: see the lengths in the URDF.
    let tool = linkage.link("tool0").unwrap();
    let expected = DVec3::new(1.0 - 0.2561, 2.0 + 1.1843, 3.0 + 0.0116);
    assert!((tool.position_m - expected).length() < 1e-12, "{}", tool.position_m);
    // The tool looks sideways, away from where the arm's plane is.
    assert!((tool.link() * DVec3::Z + DVec3::X).length() < 1e-12, "{}", tool.link());
    // The ball around the wrist reaches farthest along, the last cylinder hangs lowest.
    let [low, high] = bounds(&arm);
    assert!((high.y - (2.0 + 1.1843 + 0.06)).abs() < 0.01, "{high}");
    assert!((low.z - (3.0 + 0.0116 - 0.05)).abs() < 0.01, "{low}");
}

#[test]
fn the_shipped_arm_stands_as_the_one_of_the_papers_scenes() {
    let nodes = gltf::Gltf::load(&shipped("ur10.glb")).unwrap().parts(None).unwrap();
    let tool = nodes.iter().find(|node| node.names.last().is_some_and(|name| name == "tool")).unwrap();
    let (low, high) = tool.mesh.bounds().unwrap();
    // Its tool is a cylinder of 0.1 m from the flange on.
    let arm = arm(POSTURE);
    let flange = arm.linkage.as_ref().unwrap().link("tool0").unwrap();
    let middle = flange.position_m + flange.link() * DVec3::Z * 0.05;
    assert!(((low + high) / 2.0 - middle).length() < 1e-5, "{} is not {middle}", (low + high) / 2.0);
    let all = nodes.iter().filter(|node| node.names.last().is_some_and(|name| name != "tool"));
    let [arm_low, arm_high] = bounds(&arm);
    for node in all {
        let (low, high) = node.mesh.bounds().unwrap();
        let inside = (low - arm_low).min_element().min((arm_high - high).min_element());
        assert!(inside > -0.03, "{:?} sticks out by {}", node.names, -inside);
    }
}

#[test]
fn both_geometries_of_the_shipped_arm_are_one() {
    assert_eq!(arm("geometry = \"visual\"").surface, arm("geometry = \"collision\"").surface);
    assert_eq!(arm("role = \"environment\"").role, Role::Environment);
}
