//! Lists that are right, and every way in which they can be wrong.

use std::path::Path;

use super::super::parse_scene;
use super::*;
use perirobot_scene::objects::Up;
use perirobot_scene::objects::bvh::MotionFile;
use perirobot_scene::objects::keypoints::{JointLayout, KeypointFile};
use perirobot_scene::objects::spec::SceneSpec;

const BOX: &str = "box = { size_m = [1, 1, 1] }";

/// A scene of objects, each with its surface and its `[object.snapshots]`.
fn scene(objects: &[(&str, &str, &str)]) -> Result<SceneSpec> {
    let text = objects.iter().map(|(name, surface, lists)| {
        format!("[[object]]\nname = {name:?}\n{surface}\n[object.snapshots]\n{lists}\n")
    });
    parse_scene(Path::new("cell.toml"), text.collect()).map_err(perirobot_march::Error::first)
}

#[track_caller]
fn assert_refused(objects: &[(&str, &str, &str)], expected: &str) {
    let error = scene(objects).expect_err(expected).to_string();
    assert!(error.starts_with("cell.toml: ") && error.contains(expected), "no {expected:?} in {error}");
}

#[test]
fn a_scene_has_as_many_snapshots_as_its_lists() {
    let count = |objects: &[(&str, &str, &str)]| scene(objects).unwrap().snapshots;
    let still = "[[object]]\nname = \"a\"\nbox = { size_m = [1, 1, 1] }\n";
    assert_eq!(parse_scene(Path::new("cell.toml"), still.into()).unwrap().snapshots, 1);
    let three = "rpy_deg = [[0, 0, 0], [0, 0, 1], [0, 0, 2]]";
    let two = "cycle = true\nposition_m = [[0, 0, 0], [1, 0, 0]]";
    assert_eq!(count(&[("a", BOX, three)]), 3);
    assert_eq!(count(&[("b", BOX, two), ("a", BOX, three)]), 3);
    assert_eq!(count(&[("b", BOX, two)]), 2);
    assert_eq!(count(&[("b", BOX, two), ("c", BOX, &format!("cycle = true\n{three}"))]), 3);
    let times = "animation = { times_s = { start = 0, stop = 0.3, step = 0.1 } }";
    assert_eq!(count(&[("walk", "mesh = \"walk.glb\"", times)]), 4);
}

/// Against the same scene with its lists written by hand.
#[test]
fn crossed_lists_meet_every_moment_of_the_rest() {
    let (arm, light) =
        ("rpy_deg = [[0, 0, 0], [0, 0, 9], [0, 0, 5]]", "cycle = true\nrpy_deg = [[0, 0, 1], [0, 0, 2]]");
    let person = "cross = true\nposition_m = [[0, 0, 0], [1, 0, 0]]\nrpy_deg = [[0, 0, 7], [0, 0, 8]]";
    let door = "cross = true\nposition_m = [[0, 0, 0], [0, 2, 0]]";
    let crossed = scene(&[("a", BOX, arm), ("p", BOX, person), ("l", BOX, light), ("d", BOX, door)]).unwrap();
    let times = |entries: &[&str], each: usize| {
        let all: Vec<&str> = entries.iter().flat_map(|entry| vec![*entry; each]).collect();
        all.join(", ")
    };
    let arm = format!("rpy_deg = [{}]", [times(&["[0, 0, 0], [0, 0, 9], [0, 0, 5]"], 4)].concat());
    let light = format!("rpy_deg = [{}]", times(&["[0, 0, 1], [0, 0, 2], [0, 0, 1]"], 4));
    let of_person = |one: &str, other: &str| {
        let half = times(&[one, other], 3);
        format!("[{half}, {half}]")
    };
    let person = format!(
        "position_m = {}\nrpy_deg = {}",
        of_person("[0, 0, 0]", "[1, 0, 0]"),
        of_person("[0, 0, 7]", "[0, 0, 8]")
    );
    let door = format!("position_m = [{}]", times(&["[0, 0, 0]", "[0, 2, 0]"], 6));
    let by_hand =
        scene(&[("a", BOX, &arm), ("p", BOX, &person), ("l", BOX, &light), ("d", BOX, &door)]).unwrap();
    assert_eq!((crossed.snapshots, by_hand.snapshots), (12, 12));
    for snapshot in 0..12 {
        for (crossed, by_hand) in crossed.objects.iter().zip(&by_hand.objects) {
            assert_eq!(
                crossed.snapshot(snapshot),
                by_hand.snapshot(snapshot),
                "snapshot {snapshot} of {}",
                by_hand.name
            );
        }
    }
    // Alone it is a list like any other.
    assert_eq!(
        scene(&[("d", BOX, "cross = true\nposition_m = [[0, 0, 0], [0, 2, 0]]")]).unwrap().snapshots,
        2
    );
}

#[test]
fn lists_that_cannot_be_crossed_are_told() {
    let two = "position_m = [[0, 0, 0], [1, 0, 0]]";
    let unequal = format!("cross = true\n{two}\nrpy_deg = [[0, 0, 0]]");
    assert_refused(
        &[("a", BOX, &unequal)],
        "object \"a\".snapshots: rpy_deg or quaternion has 1 entries, but position_m has 2: all lists of an object \
         that is crossed",
    );
    assert_refused(&[("a", BOX, &format!("cross = true\ncycle = true\n{two}"))], "both cycle and cross");
    let many = |key: &str| format!("{key}position_m = [{}]", vec!["[0, 0, 0]"; 200].join(", "));
    assert_refused(
        &[("a", BOX, &many("")), ("b", BOX, &many("cross = true\n"))],
        "object \"b\".snapshots: its 200 entries make 40000 snapshots with the rest: at most 10000 can be",
    );
}

#[test]
fn lists_of_unequal_length_name_both_and_the_cure() {
    let (two, three) = ("position_m = [[0, 0, 0], [1, 0, 0]]", "rpy_deg = [[0, 0, 0], [0, 0, 1], [0, 0, 2]]");
    assert_refused(
        &[("a", BOX, two), ("b", BOX, three)],
        "object \"b\".snapshots: rpy_deg or quaternion has 3 entries, but object \"a\".snapshots.position_m has 2: \
         all lists of a scene must be equally long, or those of an object repeat with cycle = true",
    );
    assert_refused(
        &[("a", BOX, &format!("{two}\n{three}"))],
        "object \"a\".snapshots: rpy_deg or quaternion has 3 entries",
    );
    let times = "animation = { times_s = [0.5] }";
    assert_refused(
        &[("a", BOX, two), ("walk", "mesh = \"walk.glb\"", times)],
        "object \"walk\".snapshots: animation.times_s has 1 entries, but",
    );
    assert_refused(
        &[("a", BOX, two), ("b", BOX, &format!("cycle = true\n{three}"))],
        "object \"b\".snapshots: rpy_deg or quaternion has 3 entries, but object \"a\".snapshots.position_m has 2: the \
         rest of a list that repeats would never be seen",
    );
}

#[test]
fn wrong_entries_are_named_by_their_place() {
    for (surface, lists, expected) in [
        (BOX, "position_m = []", "object \"a\".snapshots.position_m = []: must have one entry a snapshot"),
        (BOX, "rpy_deg = []", "snapshots.rpy_deg = []"),
        (BOX, "quaternion = []", "snapshots.quaternion = []"),
        (BOX, "", "object \"a\".snapshots: no list: give at least one of walk, position_m"),
        (BOX, "cycle = true", "object \"a\".snapshots: no list"),
        (BOX, "position_m = [[0, 0, 0], [0, 0]]", "a list of 3 numbers"),
        (BOX, "position_m = [[0, 0, 0, 0]]", "a list of 3 numbers"),
        (BOX, "position_m = [[0, 0, 0], [0, nan, 0]]", "snapshots.position_m[1] = [0.0, NaN, 0.0]"),
        (BOX, "rpy_deg = [[0, 0, inf]]", "snapshots.rpy_deg[0] = [0.0, 0.0, inf]"),
        (
            BOX,
            "quaternion = [{ w = 0, x = 0, y = 0, z = 0 }]",
            "snapshots.quaternion[0] = { w = 0, x = 0, y = 0, z = 0 }: must",
        ),
        (
            BOX,
            "rpy_deg = [[0, 0, 0]]\nquaternion = [{ w = 1, x = 0, y = 0, z = 0 }]",
            "both rpy_deg and quaternion",
        ),
        (BOX, "positions_m = [[0, 0, 0]]", "positions_m"),
        (BOX, "animation = { times_s = [0] }", "animation belongs to a .glb or .gltf mesh"),
        (BOX, "mannequin = [\"a.csv\"]", "both box and mannequin: give one surface"),
        (BOX, "mannequin = []", "snapshots.mannequin = []"),
        (BOX, "keypoints = [\"a.csv\"]", "keypoints are a human's joints: add role = \"human\""),
        ("mannequin = \"a.csv\"", "keypoints = [\"a.csv\"]", "a mannequin's are its own"),
        ("role = \"human\"\nbox = { size_m = [1, 1, 1] }", "keypoints = []", "snapshots.keypoints = []"),
        ("octomap = \"a.bt\"", "position_m = [[0, 0, 0]]", "an octomap stays where it is"),
        ("octomap = \"a.bt\"", "rpy_deg = [[0, 0, 0]]", "an octomap stays where it is"),
        ("mesh = \"a.glb\"", "animation = { clip = \"walk\" }", "times_s"),
        (
            "mesh = \"a.glb\"",
            "animation = { times_s = [] }",
            "snapshots.animation.times_s = []: must be at least one",
        ),
        ("mesh = \"a.glb\"", "animation = { times_s = [nan] }", "snapshots.animation.times_s = NaN"),
        (
            "mesh = \"a.glb\"",
            "animation = { times_s = { start = 1, stop = 0, step = 0.1 } }",
            "snapshots.animation.times_s = { start = 1, stop = 0, step = 0.1 }: step must be above 0",
        ),
        (
            "mesh = \"a.glb\"",
            "animation = { times_s = { start = 0, stop = 1000, step = 0.01 } }",
            "animation.times_s = (100001 entries): must have at most 10000",
        ),
    ] {
        assert_refused(&[("a", surface, lists)], expected);
    }
}

#[test]
fn an_octomap_of_a_human_may_have_joints_that_move() {
    let lists = "keypoints = [\"a.csv\", \"b.csv\"]";
    let spec = scene(&[("a", "role = \"human\"\noctomap = \"a.bt\"", lists)]).unwrap();
    let second = KeypointFile { path: "b.csv".into(), layout: JointLayout::Coco17 };
    assert_eq!(spec.objects[0].snapshot(1).keypoints, Some(second));
    assert_eq!(spec.objects[0].snapshot(1).surface, spec.objects[0].surface);
}

#[test]
fn people_are_read_in_their_layout_or_their_unit() {
    let table = |path: &str, layout| PersonFile::Joints(KeypointFile { path: path.into(), layout });
    let person = |keys: &str, lists: &str, snapshot: usize| {
        let object = scene(&[("a", keys, lists)]).unwrap().objects[0].snapshot(snapshot);
        let SurfaceSpec::Mannequin(person) = object.surface else { panic!("a mannequin") };
        person
    };
    let still = "position_m = [[0, 0, 0], [1, 0, 0]]";
    assert_eq!(person("mannequin = \"a.csv\"", still, 0), table("a.csv", JointLayout::Coco17));
    assert_eq!(
        person("mannequin = \"a.csv\"\nlayout = \"smpl-24\"", still, 1),
        table("a.csv", JointLayout::Smpl24)
    );
    let lists = "mannequin = [\"a.csv\", \"b.csv\"]";
    assert_eq!(person("layout = \"halpe-26\"", lists, 1), table("b.csv", JointLayout::Halpe26));
    let motion = |scale, up, time_s, bones: &[(&str, &str)]| {
        let bones = bones.iter().map(|(joint, bone)| ((*joint).into(), (*bone).into())).collect();
        PersonFile::Motion(MotionFile { path: "w.BVH".into(), scale, up, bones, time_s, centred: false })
    };
    let times = "animation = { times_s = [0.5, 0.7] }";
    for (unit, scale) in [
        ("\"m\"", 1.0),
        ("\"cm\"", 0.01),
        ("\"mm\"", 0.001),
        ("\"in\"", 0.0254),
        ("0.056", 0.056),
        ("2", 2.0),
    ] {
        let keys = format!("mannequin = \"w.BVH\"\nunit = {unit}");
        assert_eq!(person(&keys, times, 1), motion(scale, Up::Y, 0.7, &[]), "{unit}");
        assert_eq!(person(&keys, still, 1), motion(scale, Up::Y, 0.0, &[]), "{unit}");
    }
    let keys = "mannequin = \"w.BVH\"\nunit = 1\nup = \"z\"\nbones = { head = \"Kopf\", left_knee = \"\" }";
    assert_eq!(person(keys, times, 0), motion(1.0, Up::Z, 0.5, &[("head", "Kopf"), ("left_knee", "")]));
}

#[test]
fn people_whose_keys_do_not_fit_are_told() {
    let bvh = |more: &str| format!("mannequin = \"w.bvh\"\n{more}");
    let (cm, still, times) = ("unit = \"cm\"", "position_m = [[0, 0, 0]]", "animation = { times_s = [0] }");
    for (keys, lists, expected) in [
        (bvh(""), still, "object \"a\": a .bvh file does not say its unit: add unit = \"cm\""),
        (bvh("unit = \"ft\""), still, "unknown variant `ft`, expected one of `m`, `cm`, `mm`, `in`"),
        (bvh("unit = 0"), still, "or metres in one of it, from 0.000001"),
        (bvh("unit = -1.0"), still, "or metres in one of it, from 0.000001"),
        (bvh(&format!("{cm}\nlayout = \"smpl-24\"")), still, "layout belongs to tables of joints"),
        (
            bvh(&format!("{cm}\nbones = {{ nos = \"Nose\" }}")),
            still,
            "bones.nos: does not exist; there are nose, left_eye",
        ),
        (
            bvh(cm),
            "animation = { clip = \"walk\", times_s = [0] }",
            "animation: clip belongs to a .glb or .gltf mesh: a .bvh file",
        ),
        (
            bvh(cm),
            "animation = { joints = \"a.csv\", angles = \"deg\", times_s = [0] }",
            "animation: joints and angles belong to a urdf",
        ),
        (
            bvh(cm),
            "mannequin = [\"a.csv\", \"b.bvh\"]",
            "snapshots.mannequin[1] = \"b.bvh\": must be a table of joints (.csv)",
        ),
        (
            "mannequin = \"a.csv\"".into(),
            times,
            "snapshots: animation belongs to a .glb or .gltf mesh, a .bvh mannequin or",
        ),
        (
            "mannequin = \"a.csv\"\nbones = { head = \"Head\" }".into(),
            still,
            "bones belong to motion capture: a .bvh file",
        ),
        ("mannequin = \"a.csv\"\nunit = \"cm\"".into(), still, "unit and up belong to a mesh"),
        (
            "mannequin = \"a.csv\"\nlayout = \"coco\"".into(),
            still,
            "unknown variant `coco`, expected one of `coco-17`",
        ),
        (format!("{BOX}\nlayout = \"smpl-24\""), still, "layout belongs to mannequin or keypoints"),
        (format!("{BOX}\nbones = {{ head = \"Head\" }}"), still, "bones belong to a mannequin"),
        (
            format!("{BOX}\nrole = \"human\"\nkeypoints = \"a.bvh\""),
            still,
            "keypoints = \"a.bvh\": must be a table of joints",
        ),
    ] {
        assert_refused(&[("a", &keys, lists)], expected);
    }
}

#[test]
fn a_robots_table_of_joints_needs_its_times_and_the_unit_of_its_angles() {
    let arm = "urdf = \"a.urdf\"\njoints_deg = { elbow = 5 }";
    let lists = "animation = { joints = \"did.csv\", angles = \"rad\", times_s = [1, 2, 4] }";
    let spec = scene(&[("a", arm, lists)]).unwrap();
    let SurfaceSpec::Urdf(robot) = spec.objects[0].snapshot(2).surface else { panic!("a robot") };
    let table = JointTableFile { path: "did.csv".into(), angles: AngleUnit::Rad };
    assert_eq!((robot.recorded, robot.joints.angles_deg["elbow"]), (Some((table, 4.0)), 5.0));
    assert_eq!((spec.snapshots, spec.objects[0].snapshot(2).animated.clone()), (3, None));
    for (lists, expected) in [
        (
            "animation = { joints = \"did.csv\", times_s = [1] }",
            "snapshots.animation: no angles: add angles = \"rad\"",
        ),
        ("animation = { times_s = [1] }", "snapshots.animation: no joints: name a table"),
        (
            "animation = { joints = \"did.csv\", angles = \"turns\", times_s = [1] }",
            "unknown variant `turns`",
        ),
        (
            "joints_deg = [{ elbow = 1 }]\nanimation = { joints = \"did.csv\", angles = \"rad\", times_s = [1] }",
            "both animation.joints and a list of joints",
        ),
    ] {
        assert_refused(&[("a", arm, lists)], expected);
    }
}
