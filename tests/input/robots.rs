//! Robots from a URDF in a scene: what they are by default, where their links stand in the world, and how the
//! shipped arm stands in the paper's scenes.

use std::path::Path;

use glam::DVec3;
use perirobot_scene::objects::{Object, Role, Surface, build::build};
use perirobot_scene::source::Sources;
use perirobot_study::input::load_scene;

fn shipped(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/paper").join(name)
}

/// The shipped arm as the one object of a scene.
fn arm(keys: &str) -> Object {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("cell.toml");
    let urdf = shipped("ur10.urdf");
    std::fs::write(&scene, format!("[[object]]\nname = \"arm\"\nurdf = {urdf:?}\n{keys}\n")).unwrap();
    // The arm lies elsewhere.
    let sources = Sources::from_main(&scene).allow_outside();
    let spec = load_scene(&scene, &sources).unwrap();
    let scene = build(&spec, &sources, 0.05).unwrap().remove(0);
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

/// The robot in each snapshot of a shipped scene.
fn robots(scene: &str) -> Vec<Object> {
    let sources = Sources::from_main(&shipped(scene));
    let spec = load_scene(&shipped(scene), &sources).unwrap();
    let scenes = build(&spec, &sources, 0.05).unwrap();
    (scenes.iter())
        .map(|scene| (**scene.objects.iter().find(|object| object.name == "robot").unwrap()).clone())
        .collect()
}

#[test]
fn the_arm_of_the_papers_scenes_reaches_where_its_kinematics_say() {
    let arm = robots("scene1.toml").remove(0);
    // By hand. The arm's plane points to −35° (145° − 180°, its a are negative). In it the elbow is at reach
    // 0, height 1 + 0.1273 + 0.612; the forearm falls by 30°: reach 0.5723 cos 30° = 0.49563, height 1.45315.
    // Wrist 1 goes 0.1639 to the left, wrist 2 0.1157 down to 1.33745, wrist 3 0.0922 ahead to 0.587826:
    // (0.587826 cos 35° + 0.1639 sin 35°, −0.587826 sin 35° + 0.1639 cos 35°).
    let flange = *arm.linkage.as_ref().unwrap().link("tool0").unwrap();
    let expected = DVec3::new(0.575528, -0.202904, 1.337450);
    assert!((flange.position_m - expected).length() < 2e-6, "{}, not {expected}", flange.position_m);
    let [low, high] = bounds(&arm);
    assert!((high.z - (1.7393 + 0.07)).abs() < 2e-3, "top of the elbow at {}", high.z);
    assert!((low.z - 1.0).abs() < 1e-9, "it stands on the table: {}", low.z);
    for scene in ["scene2.toml", "scene3.toml"] {
        assert!(robots(scene)[0].surface == arm.surface, "{scene}: another posture");
    }
}

#[test]
fn the_arm_of_the_third_experiment_alternates() {
    let (still, moving) = (robots("scene1.toml").remove(0), robots("exp3_scene.toml"));
    for (i, arm) in moving.iter().enumerate() {
        assert_eq!(arm.surface == still.surface, i % 2 == 0, "snapshot {i}");
    }
    assert!(moving.iter().skip(1).step_by(2).all(|arm| arm.surface == moving[1].surface));
    // By hand. The arm's plane points to 0°. The elbow is at 0.612 · (cos 60°, sin 60°) from the shoulder,
    // the forearm falls by 50°: reach 0.306 + 0.36787 = 0.67387, height 1.1273 + 0.53001 − 0.43841 = 1.2189.
    // Wrist 1 goes 0.1639 to the left, wrist 2 0.1157 ahead, wrist 3 0.0922 down, where the tool looks.
    let flange = *moving[1].linkage.as_ref().unwrap().link("tool0").unwrap();
    let expected = DVec3::new(0.78957, 0.1639, 1.12670);
    assert!((flange.position_m - expected).length() < 2e-5, "{}, not {expected}", flange.position_m);
    assert!((flange.link() * DVec3::Z + DVec3::Z).length() < 1e-9, "{}", flange.link() * DVec3::Z);
}

#[test]
fn both_geometries_of_the_shipped_arm_are_one() {
    assert_eq!(arm("geometry = \"visual\"").surface, arm("geometry = \"collision\"").surface);
    assert_eq!(arm("role = \"environment\"").role, Role::Environment);
}
