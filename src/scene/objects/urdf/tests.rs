use std::path::Path;

use glam::{DAffine3, DVec3};

use super::*;
use crate::objects::Mesh;
use crate::objects::mesh::tests::{assert_closed, volume};

const TWO_LINKS: &str = "<robot name='arm'>
<link name='base'/>
<link name='arm'><collision><origin xyz='0 0 1'/><geometry><box size='1 2 3'/></geometry></collision></link>
<joint name='turn' type='revolute'><parent link='base'/><child link='arm'/><origin xyz='1 0 0'/><axis xyz='0 0 1'/>
<limit lower='-1' upper='1' effort='1' velocity='1'/></joint>
</robot>";

#[track_caller]
fn refused_at(path: &str, text: &str, expected: &str) {
    let what = parse(Path::new(path), text).expect_err(expected).to_string();
    assert!(what.starts_with(path), "{what}");
    assert!(what.contains(expected), "{what:?} lacks {expected:?}");
}

#[track_caller]
fn assert_refused(from: &str, to: &str, expected: &str) {
    assert!(TWO_LINKS.contains(from), "{from}");
    refused_at("arm.urdf", &TWO_LINKS.replacen(from, to, 1), expected);
}

#[test]
fn a_xacro_is_named_with_the_command_that_expands_it() {
    let command = "run `xacro ur/arm.urdf.xacro > ur/arm.urdf` (or `ros2 run xacro xacro ur/arm.urdf.xacro > ur/arm.urdf`)";
    let what = |path: &str| document::expand(Path::new(path)).to_string();
    assert!(
        what("ur/arm.urdf.xacro").contains(command)
            && what("arm.xacro").contains("`xacro arm.xacro > arm.urdf`")
    );
    let declared = TWO_LINKS.replacen("<robot", "<robot xmlns:xacro='http://www.ros.org/wiki/xacro'", 1);
    let with_macro = declared.replacen("<link", "<xacro:include filename='x'/><link", 1);
    refused_at("arm.urdf", &with_macro, "`xacro arm.urdf > arm.expanded.urdf`");
    assert_refused("<link", "<xacro:include filename='x'/><link", "is a xacro");
    assert_refused("xyz='0 0 1'", "xyz='0 0 ${height}'", "is a xacro");
    // What the program leaves in an expanded file needs no expanding.
    assert!(parse(Path::new("arm.urdf"), &declared).is_ok());
}

#[test]
fn what_is_no_urdf_is_refused() {
    refused_at("arm.urdf", "", "is empty");
    refused_at("arm.urdf", &TWO_LINKS[..100], "is no XML");
    refused_at("arm.urdf", "<sdf/>", "its root is <sdf>");
    refused_at("arm.urdf", "<robot/>", "has no link");
    let deep = format!("<robot>{}{}</robot>", "<a>".repeat(100_000), "</a>".repeat(100_000));
    refused_at("arm.urdf", &deep, "nests elements more than 64 deep");
    let bomb = format!("<!DOCTYPE x [<!ENTITY a 'b'>]>{TWO_LINKS}");
    refused_at("arm.urdf", &bomb, "leave the DOCTYPE out");
}

#[test]
fn a_mesh_of_scale_0_is_left_out() {
    let with = |scale: &str| {
        let mesh = format!("<mesh filename='a.stl' scale='{scale}'/>");
        let model =
            parse(Path::new("arm.urdf"), &TWO_LINKS.replacen("<box size='1 2 3'/>", &mesh, 1)).unwrap();
        (model.links[1].collision.len(), model.passed_over)
    };
    assert_eq!(with("0 0 0"), (0, 1));
    assert_eq!(with("1 1 1"), (1, 0));
}

#[test]
fn links_must_form_one_tree() {
    assert_refused(
        "child link='arm'",
        "child link='hand'",
        "joint \"turn\": its child \"hand\" is no link of the file",
    );
    assert_refused(
        "parent link='base'",
        "parent link='world'",
        "joint \"turn\": its parent \"world\" is no link",
    );
    assert_refused(
        "<link name='base'/>",
        "<link name='base'/><link name='base'/>",
        "two links are named \"base\"",
    );
    assert_refused(
        "<link name='base'/>",
        "<link name='base'/><link name='other'/>",
        "\"base\" and \"other\" both hang on",
    );
    let joint = |name: &str, parent: &str, child: &str| {
        format!(
            "<joint name='{name}' type='fixed'><parent link='{parent}'/><child link='{child}'/></joint></robot>"
        )
    };
    assert_refused("</robot>", &joint("turn", "arm", "base"), "two joints are named \"turn\"");
    assert_refused("</robot>", &joint("back", "arm", "base"), "link \"base\" is among its own ancestors");
    assert_refused(
        "</robot>",
        &joint("again", "base", "arm"),
        "the child of two joints, \"turn\" and \"again\"",
    );
    assert_refused("</robot>", &joint("self", "base", "base"), "link \"base\" is among its own ancestors");
    let ring = "<link name='a'/><link name='b'/><joint name='x' type='fixed'><parent link='a'/><child link='b'/></joint>";
    let ring = format!("{ring}{}", joint("y", "b", "a"));
    assert_refused("</robot>", &ring, "link \"a\" is among its own ancestors: links must form a tree");
}

#[test]
fn joints_that_are_not_supported_say_what_would_do() {
    for kind in ["floating", "planar", "spherical"] {
        assert_refused("revolute", kind, &format!("joint \"turn\": is {kind}, which is not supported: "));
    }
    assert_refused(
        "<axis",
        "<mimic joint='other'/><axis",
        "joint \"turn\": mimics \"other\", which is no joint of the file",
    );
    assert_refused(
        "revolute",
        "ball",
        "joint \"turn\" (line 4): <joint type = \"ball\">: must be fixed, revolute",
    );
    assert_refused("<axis xyz='0 0 1'/>", "<axis xyz='0 0 0'/>", "joint \"turn\": <axis xyz");
    assert_refused("lower='-1'", "lower='2'", "<limit lower = 2 upper = 1>: lower must not be above upper");
    assert_refused("lower='-1'", "lower='nan'", "<limit lower = NaN");
    assert_refused(
        "upper='1'",
        "upper='x'",
        "joint \"turn\" (line 5): <limit upper = \"x\">: must be a number",
    );
    assert_refused(
        "<limit lower='-1' upper='1' effort='1' velocity='1'/>",
        "",
        "is revolute and has no <limit>",
    );
    let slide = TWO_LINKS.replace("revolute", "prismatic").replace("upper='1'", "upper='inf'");
    refused_at("arm.urdf", &slide, "joint \"turn\": its limits [-1.0, inf] must be metres");
}

#[test]
fn numbers_must_be_numbers_of_a_sensible_size() {
    for (from, to, expected) in [
        ("xyz='0 0 1'", "xyz='0 0 nan'", "link \"arm\" (line 3): <origin xyz = \"0 0 nan\">: must be three"),
        ("xyz='0 0 1'", "xyz='0 inf 1'", "link \"arm\" (line 3): <origin xyz"),
        ("xyz='0 0 1'", "xyz='0 0'", "link \"arm\" (line 3): <origin xyz"),
        // The parser alone would read 0 0 1.
        ("xyz='0 0 1'", "xyz='0 o.5 0 1'", "link \"arm\" (line 3): <origin xyz"),
        ("xyz='0 0 1'", "rpy='0 0 nan'", "link \"arm\" (line 3): <origin rpy"),
        (
            "xyz='0 0 1'",
            "rpy='0 0 1e300'",
            "link \"arm\" (line 3): <origin rpy = \"0 0 1e300\">: must be angles",
        ),
        ("xyz='0 0 1'", "xyz='0 0 1e300'", "link \"arm\": collision 1: <origin xyz"),
        ("xyz='1 0 0'", "xyz='1 0 nan'", "joint \"turn\" (line 4): <origin xyz"),
        (
            "size='1 2 3'",
            "size='1 1e-9 3'",
            "link \"arm\": collision 1: box size = 0.000000001: must be 0 or a length in metres",
        ),
        ("size='1 2 3'", "size='1 -2 3'", "box size = -2"),
        ("<box size='1 2 3'/>", "<sphere radius='nan'/>", "sphere radius = NaN"),
        ("<box size='1 2 3'/>", "<cylinder radius='1' length='-1'/>", "cylinder length = -1"),
        ("<box size='1 2 3'/>", "<capsule radius='-1' length='1'/>", "capsule radius = -1"),
        (
            "<box size='1 2 3'/>",
            "<mesh filename='a.stl' scale='1 0 1'/>",
            "mesh \"a.stl\" scale = [1.0, 0.0, 1.0]",
        ),
        ("<box size='1 2 3'/>", "<cone/>", "link \"arm\" (line 3): <cone>: must be a box"),
        ("<box size='1 2 3'/>", "<sphere/>", "link \"arm\" (line 3): <sphere>: must have radius = "),
        ("<box size='1 2 3'/>", "", "link \"arm\" (line 3): <geometry>: must hold a box"),
        (
            "<geometry><box size='1 2 3'/></geometry>",
            "",
            "link \"arm\" (line 3): <collision>: must hold <geometry>",
        ),
        ("<child link='arm'/>", "", "joint \"turn\" (line 4): <joint>: must hold <child>"),
        ("<link name='base'/>", "<link/>", "link \"\" (line 2): <link>: must have name = "),
    ] {
        assert_refused(from, to, expected);
    }
}

#[test]
fn what_is_not_needed_does_no_harm() {
    let plain = format!("{:?}", parse(Path::new("arm.urdf"), TWO_LINKS).unwrap());
    for (from, to) in [
        ("<link", "<material name='grey'><texture/></material><gazebo><link/><a/></gazebo><link"),
        ("</collision>", "</collision><inertial><mass value='heavy'/></inertial>"),
        ("<axis", "<dynamics damping='much'/><safety_controller/><calibration rising='x'/><axis"),
        ("<robot name='arm'>", "<?xml version='1.0'?><!-- from ${file} --><robot name='arm' version='1.0'>"),
    ] {
        let model = parse(Path::new("arm.urdf"), &TWO_LINKS.replacen(from, to, 1)).expect(to);
        assert_eq!(format!("{model:?}"), plain, "{to}");
    }
}

/// What URDF 1.1 and 1.2 added, and what that means in a file that does not say its version.
#[test]
fn versions_of_the_format_are_told_apart() {
    let at = |version: &str, from: &str, to: &str| {
        let text = TWO_LINKS.replacen("<robot", &format!("<robot version='{version}'"), 1);
        parse(Path::new("arm.urdf"), &text.replacen(from, to, 1))
    };
    let turned = |version| {
        let model =
            at(version, "<origin xyz='1 0 0'/>", "<origin xyz='1 0 0' quat_xyzw='0 0 2 2'/>").unwrap();
        model.pose(&JointValues::default()).unwrap()[1].transform_vector3(DVec3::X)
    };
    assert_eq!(turned("1.0"), DVec3::X);
    assert!((turned("1.1") - DVec3::Y).length() < 1e-12);
    let both =
        at("1.1", "xyz='1 0 0'", "xyz='1 0 0' rpy='0 0 0' quat_xyzw='0 0 0 1'").unwrap_err().to_string();
    assert!(
        both.contains("joint \"turn\" (line 4): <origin>: must have rpy or quat_xyzw, not both"),
        "{both}"
    );
    let odd = at("1.1", "xyz='1 0 0'", "quat_xyzw='1e200 0 0 0'").unwrap_err().to_string();
    assert!(odd.contains("<origin quat_xyzw>: must be a quaternion"), "{odd}");
    let unturned = at("1.1", "xyz='1 0 0'", "quat_xyzw='0 0 0 0'").unwrap();
    let pose = unturned.pose(&JointValues::default()).unwrap()[1];
    assert_eq!(pose.transform_vector3(DVec3::X), DVec3::X, "as ROS has it");
    let bounds = |version| match at(version, "lower='-1' upper='1'", "").unwrap().links[1]
        .joint
        .as_ref()
        .unwrap()
        .motion
    {
        JointMotion::Turn { limits_rad, .. } => limits_rad,
        _ => unreachable!("it turns"),
    };
    assert_eq!(bounds("1.0"), [0.0; 2]);
    assert_eq!(bounds("1.2"), [f64::NEG_INFINITY, f64::INFINITY]);
}

#[test]
fn no_cut_of_a_file_panics() {
    for length in 0..TWO_LINKS.len() {
        assert!(parse(Path::new("arm.urdf"), &TWO_LINKS[..length]).is_err(), "cut at {length}");
    }
}

/// The triangles of a robot without packages.
fn meshes(model: &RobotModel, geometry: GeometryUse, sag_m: f64) -> Result<Vec<Mesh>> {
    model.meshes(geometry, &Packages::default(), &Sources::from_main(&model.path), sag_m)
}

/// The robot of one body at (0, 0, 1) of its link, as one mesh.
fn body(folder: &Path, geometry: &str) -> Result<Mesh> {
    let text = TWO_LINKS.replace("<box size='1 2 3'/>", geometry);
    let model = parse(&folder.join("arm.urdf"), &text).unwrap();
    let found = meshes(&model, GeometryUse::Collision, 0.001)?;
    let placed = model.pose(&JointValues::default()).unwrap();
    Ok(merge(&found, &placed))
}

#[track_caller]
fn assert_spans(mesh: &Mesh, low: [f64; 3], high: [f64; 3], tolerance: f64) {
    assert_closed(mesh);
    assert!(volume(mesh) > 0.0, "looks inward");
    let (found_low, found_high) = mesh.bounds().unwrap();
    let near = |a: DVec3, b: [f64; 3]| (a - DVec3::from(b)).abs().max_element() < tolerance;
    assert!(near(found_low, low) && near(found_high, high), "{found_low} {found_high}");
}

#[test]
fn bodies_stand_in_their_links_about_their_origins() {
    // The joint adds (1, 0, 0), the body's origin (0, 0, 1).
    let here = |geometry: &str| body(Path::new("."), geometry).unwrap();
    assert_spans(&here("<box size='1 2 3'/>"), [0.5, -1.0, -0.5], [1.5, 1.0, 2.5], 1e-12);
    assert_spans(&here("<sphere radius='0.5'/>"), [0.5, -0.5, 0.5], [1.5, 0.5, 1.5], 1e-12);
    let cylinder = here("<cylinder radius='0.5' length='3'/>");
    assert_spans(&cylinder, [0.5, -0.5, -0.5], [1.5, 0.5, 2.5], 1e-12);
    // A capsule's length is between the centres of its ends.
    let capsule = here("<capsule radius='0.5' length='2'/>");
    assert_spans(&capsule, [0.5, -0.5, -0.5], [1.5, 0.5, 2.5], 1e-12);
}

/// A tetrahedron with corners 0, x, y and z, its faces outward.
const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

#[test]
fn meshes_are_scaled_and_mirrored_in_their_own_axes() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("part.OBJ"), OBJ).unwrap();
    let part = |scale: &str| body(folder.path(), &format!("<mesh filename='part.OBJ' {scale}/>")).unwrap();
    assert_spans(&part(""), [1.0, 0.0, 1.0], [2.0, 1.0, 2.0], 1e-12);
    assert_spans(&part("scale='0.001 2 3'"), [1.0, 0.0, 1.0], [1.001, 2.0, 4.0], 1e-12);
    assert_spans(&part("scale='-1 1 1'"), [0.0, 0.0, 1.0], [1.0, 1.0, 2.0], 1e-12);
}

#[test]
fn a_robot_without_the_geometry_asked_for_says_what_it_has() {
    let model = parse(Path::new("arm.urdf"), TWO_LINKS).unwrap();
    let what = meshes(&model, GeometryUse::Visual, 0.01).unwrap_err().to_string();
    assert_eq!(
        what,
        "arm.urdf: no link has visual geometry: write geometry = \"collision\" in the scene file"
    );
    let bare = parse(Path::new("arm.urdf"), "<robot name='x'><link name='a'/></robot>").unwrap();
    let what = meshes(&bare, GeometryUse::Visual, 0.01).unwrap_err().to_string();
    assert!(what.contains("no link has a body"), "{what}");
    assert_eq!(bare.pose(&JointValues::default()).unwrap(), [DAffine3::IDENTITY]);
    assert_eq!(bare.reach_m(), 0.0);
}

#[test]
fn visual_geometry_is_its_own() {
    let text = TWO_LINKS.replace("collision", "visual").replace(
        "</robot>",
        "<link name='tip'><collision><geometry><sphere radius='1'/></geometry></collision></link>\
         <joint name='weld' type='fixed'><parent link='arm'/><child link='tip'/></joint></robot>",
    );
    let model = parse(Path::new("arm.urdf"), &text).unwrap();
    let count = |geometry| {
        let found = meshes(&model, geometry, 0.1).unwrap();
        found.iter().map(|mesh| mesh.triangles.len()).collect::<Vec<_>>()
    };
    assert_eq!(count(GeometryUse::Visual), [0, 12, 0]);
    assert_eq!(count(GeometryUse::Collision)[..2], [0, 0]);
}

#[test]
fn bodies_without_extent_are_passed_over_and_plates_are_not() {
    let with = |shape: &str| {
        let text = format!(
            "<robot name='r'><link name='a'><collision><geometry>{shape}</geometry></collision><collision><geometry>\
             <box size='1 1 1'/></geometry></collision></link></robot>"
        );
        let model = parse(Path::new("arm.urdf"), &text).unwrap();
        (model.links[0].collision.len(), model.passed_over)
    };
    for nothing in [
        "<sphere radius='0'/>",
        "<cylinder radius='0' length='0'/>",
        "<capsule radius='0.0' length='1'/>",
        "<box size='0 0 0'/>",
        "<box size='0 1 0'/>",
    ] {
        assert_eq!(with(nothing), (1, 1), "{nothing}");
    }
    assert_eq!(with("<box size='1 1 0'/>"), (2, 0));
    assert_eq!(with("<cylinder radius='1' length='0'/>"), (2, 0));
}
