//! Robots that cannot be loaded or posed as asked: each is refused by the scene's file, the object, the key
//! and the cure, before any ray is cast. The tests beside the reader try each kind of damage.

use crate::common::glb;
use crate::common::program::{Folder, Outcome, perirobot, text};

/// An arm of one joint; its hand is a mesh.
const URDF: &str = "<robot name='arm'>
<link name='base'><collision><geometry><box size='0.2 0.2 0.2'/></geometry></collision></link>
<link name='hand'><collision><geometry><mesh filename='hand.stl'/></geometry></collision></link>
<joint name='turn' type='revolute'><parent link='base'/><child link='hand'/><origin xyz='0 0 0.2'/>
<axis xyz='0 0 1'/><limit lower='-1' upper='1.5707963' effort='1' velocity='1'/></joint>
</robot>";

const BOX_OBJ: &str = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

const BOX_DAE: &str = "<COLLADA version='1.4.1'><library_geometries><geometry id='g'><mesh>
<source id='s'><float_array id='f' count='9'>0 0 0 0.1 0 0 0 0.1 0</float_array>
<technique_common><accessor source='#f' count='3' stride='3'/></technique_common></source>
<vertices id='v'><input semantic='POSITION' source='#s'/></vertices>
<triangles count='1'><input semantic='VERTEX' source='#v' offset='0'/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id='c'><node><instance_geometry url='#g'/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url='#c'/></scene></COLLADA>";

const STL: &str = "solid hand\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 0.1 0 0\nvertex 0 0.1 0\nendloop\nendfacet\n\
    endsolid hand\n";

/// A folder whose scene has the arm in place of its capsule, with a mesh that loads.
fn folder(keys: &str) -> Folder {
    let folder = Folder::new();
    folder.write("arm.urdf", URDF);
    folder.write("hand.stl", STL);
    folder.edit(
        "cell.toml",
        "role = \"robot\"\ncapsule = { radius_m = 0.1, length_m = 0.6 }\nposition_m = [0.2, 0.3, 0.45]\nquaternion = { w = 1, x = 0, y = 0, z = 0 }",
        &format!("urdf = \"arm.urdf\"\nposition_m = [0.2, 0.3, 0.45]\n{keys}"),
    );
    folder
}

#[track_caller]
fn assert_refused(folder: &Folder, expected: &[&str]) {
    let before = folder.names();
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    for fragment in ["cell.toml: object \"arm\""].iter().chain(expected) {
        assert!(outcome.stderr.contains(fragment), "no {fragment:?} in {}", outcome.stderr);
    }
    for unwanted in ["panicked", "running on"] {
        assert!(!outcome.stderr.contains(unwanted), "{}", outcome.stderr);
    }
    assert_eq!(folder.names(), before);
}

/// The arm, with this changed in its URDF, must be refused.
#[track_caller]
fn refused(from: &str, to: &str, expected: &[&str]) {
    let folder = folder("");
    folder.edit("arm.urdf", from, to);
    assert_refused(&folder, expected);
}

/// The arm must be refused with these keys in its scene.
#[track_caller]
fn refused_keys(keys: &str, expected: &[&str]) {
    assert_refused(&folder(keys), expected);
}

/// The arm must be refused with this hand.
#[track_caller]
fn refused_mesh(name: &str, bytes: Option<&[u8]>, expected: &[&str]) {
    let folder = folder("");
    folder.edit("arm.urdf", "hand.stl", name);
    if let Some(bytes) = bytes {
        folder.write(name, bytes);
    }
    let place = ["urdf = ", "arm.urdf: link \"hand\": collision 1: mesh ", name];
    assert_refused(&folder, &[&place, expected].concat());
}

#[test]
fn what_is_refused_below_would_load_unchanged() {
    let outcome = folder("joints_deg = { turn = 90 }").sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
}

#[test]
fn files_that_are_no_plain_urdf() {
    let folder = folder("");
    folder.write("arm.urdf.xacro", "<robot/>");
    folder.edit("cell.toml", "arm.urdf", "arm.urdf.xacro");
    assert_refused(
        &folder,
        &["urdf = ", "is a xacro", "run `xacro ", "arm.urdf.xacro > ", "ros2 run xacro xacro"],
    );
    refused("<link", "<xacro:macro name='x'/><link", &["urdf = ", "arm.urdf: is a xacro"]);
    refused("</robot>", "", &["arm.urdf: is no XML"]);
    refused("name='hand'", "name='base'", &["arm.urdf: two links are named \"base\""]);
    let gone = Folder::new();
    gone.edit("cell.toml", "capsule = { radius_m = 0.1, length_m = 0.6 }", "urdf = \"gone.urdf\"");
    assert_refused(&gone, &["urdf = ", "gone.urdf: cannot be read"]);
}

#[test]
fn joints_that_cannot_be() {
    refused(
        "revolute",
        "floating",
        &["arm.urdf: joint \"turn\": is floating, which is not supported: make it fixed"],
    );
    refused(
        "<axis",
        "<mimic joint='x'/><axis",
        &["arm.urdf: joint \"turn\": mimics \"x\", which is no joint of the file"],
    );
    let ring = "<joint name='back' type='fixed'><parent link='hand'/><child link='base'/></joint></robot>";
    refused(
        "</robot>",
        ring,
        &["arm.urdf: link \"base\" is among its own ancestors, as all are: links must form a tree"],
    );
    refused(
        "xyz='0 0 0.2'",
        "xyz='0 0 nan'",
        &["arm.urdf: joint \"turn\" (line 4): <origin xyz = \"0 0 nan\">"],
    );
}

#[test]
fn joint_values_that_cannot_be() {
    refused_keys("joints_deg = { elbow = 1 }", &["joints_deg.elbow = 1", "no such joint; there are turn"]);
    let limits = ["joints_deg.turn = 100: must be from -57.2958 to 90 degrees, its limits in ", "arm.urdf"];
    refused_keys("joints_deg = { turn = 100 }", &limits);
    refused_keys(
        "joints_m = { turn = 1 }",
        &["joints_m.turn = 1: turns: write its degrees under joints_deg"],
    );
    refused_keys("joints_deg = { turn = nan }", &["joints_deg.turn = NaN: must be a number"]);
    let folder = folder("");
    folder.edit("arm.urdf", "lower='-1'", "lower='0.5'");
    assert_refused(
        &folder,
        &["no joints_deg.turn: the joint cannot be at 0", "28.6479 to 90 degrees; give it a value"],
    );
}

#[test]
fn keys_of_a_urdf_without_one() {
    for key in
        ["geometry = \"visual\"", "packages = { a = \"b\" }", "joints_deg = { a = 1 }", "joints_m = {}"]
    {
        let folder = Folder::new();
        folder.edit("cell.toml", "role = \"robot\"\n", &format!("role = \"robot\"\n{key}\n"));
        assert_refused(&folder, &["geometry, packages, joints_deg and joints_m belong to a urdf"]);
    }
    let folder = folder("geometry = \"exact\"");
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(2));
    assert!(outcome.stderr.contains("expected `collision` or `visual`"), "{}", outcome.stderr);
    let folder = self::folder("");
    folder.edit("cell.toml", "urdf = ", "sphere = { radius_m = 1 }\nurdf = ");
    assert_refused(&folder, &["both sphere and urdf"]);
    refused_keys("geometry = \"visual\"", &["no link has visual geometry: write geometry = \"collision\""]);
}

#[test]
fn meshes_that_cannot_be_read() {
    refused_mesh("gone.stl", None, &["gone.stl: cannot be read"]);
    refused_mesh("hand.igs", Some(b"x"), &["must be a .glb, .gltf, .stl, .obj, .dae or .step file"]);
    refused_mesh("hand.obj", Some(&BOX_OBJ.as_bytes()[..42]), &["hand.obj: has no face with an area"]);
    refused_mesh(
        "hand.obj",
        Some(BOX_OBJ.replace("0.1", "nan").as_bytes()),
        &["hand.obj: line 2: nan: must be finite"],
    );
    refused_mesh(
        "hand.obj",
        Some(b"v 0 0 0\nf 1 2 3\n"),
        &["hand.obj: line 2: corner 2 of a face: there are 1 so far"],
    );
    refused_mesh("hand.dae", Some(&BOX_DAE.as_bytes()[..BOX_DAE.len() - 9]), &["hand.dae: is no XML"]);
    refused_mesh(
        "hand.dae",
        Some(BOX_DAE.replace("0 1 2<", "0 1 3<").as_bytes()),
        &["position 3: there are 3"],
    );
    refused_mesh(
        "hand.dae",
        Some(BOX_DAE.replace("0 0.1 0<", "0 nan 0<").as_bytes()),
        &["is no finite number"],
    );
    refused_mesh("part.stl", Some(&STL.as_bytes()[..60]), &["part.stl: "]);
    refused_mesh("hand.glb", Some(b"glTF"), &["hand.glb: "]);
    refused(
        "filename='hand.stl'",
        "filename='hand.stl' scale='1 0 1'",
        &["link \"hand\": collision 1: mesh", "none may be zero"],
    );
}

#[test]
fn every_format_is_read() {
    let glb = glb::bytes(&glb::part("hand", [0.0; 3], [0.1; 3]));
    let [obj, dae, stl] = [BOX_OBJ, BOX_DAE, STL].map(|text| text.as_bytes().to_vec());
    for (name, bytes) in [("a.obj", obj), ("a.dae", dae), ("a.stl", stl), ("a.glb", glb)] {
        let folder = folder("");
        folder.write(name, bytes);
        folder.edit("arm.urdf", "hand.stl", name);
        let outcome = folder.sweep(&[]);
        assert_eq!(outcome.code, Some(0), "{name}: {}", outcome.stderr);
    }
}

/// Voxelizes the scene of a folder.
fn voxelize(folder: &Folder, more: &[&str]) -> Outcome {
    let (scene, out) = (folder.path("cell.toml"), folder.path("cell.bt"));
    perirobot(&[&["voxelize", text(&scene), "--out", text(&out)], more].concat())
}

#[test]
fn packages_are_found_by_the_scene_file_or_the_command_line() {
    let folder = folder("");
    folder.edit("arm.urdf", "hand.stl", "package://my_arm/hand.stl");
    let cure =
        ["mesh \"package://my_arm/hand.stl\": package \"my_arm\" is not known", "--package my_arm=DIR"];
    assert_refused(&folder, &cure);
    assert_refused(&folder, &["packages = { my_arm = \"DIR\" } in the scene file"]);
    assert_eq!(voxelize(&folder, &[]).code, Some(2));

    let here = format!("my_arm={}", text(&folder.path("")));
    for outcome in [voxelize(&folder, &["--package", &here]), folder.sweep(&["--package", &here])] {
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    }
    // In the scene file, folders are taken from the file's own; the command line is heard last.
    folder.edit("cell.toml", "urdf = ", "packages = { my_arm = \".\" }\nurdf = ");
    assert_eq!(voxelize(&folder, &[]).code, Some(0));
    let outcome = voxelize(&folder, &["--package", "my_arm=/nowhere"]);
    assert_eq!(outcome.code, Some(2));
    assert!(outcome.stderr.contains("/nowhere/hand.stl: cannot be read"), "{}", outcome.stderr);
    let study = folder.path("study.toml");
    let compared = |package: &str| {
        let arguments =
            ["verify-backends", text(&study), "--poses", "1", "--backend", "cpu", "--package", package];
        perirobot(&arguments)
    };
    assert_eq!(compared("my_arm=/nowhere").code, Some(2));
    for wrong in ["my_arm", "=x", "my_arm="] {
        let outcome = compared(wrong);
        assert_eq!(outcome.code, Some(2));
        assert!(outcome.stderr.contains("must be a name, = and a folder"), "{}", outcome.stderr);
    }
}
