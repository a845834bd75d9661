//! Robots that are xacros: expanded by a program of that name if the user allows it, and by nothing else. A script
//! stands in for it; the program itself comes from PyPI, into the environment of the Python tests.

use std::os::unix::fs::PermissionsExt;
use std::process::Command;

use crate::common::program::{Folder, Outcome, text};
use crate::common::python;

/// A box on a post, of the height that an argument says.
const XACRO: &str = r#"<robot name="post" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:arg name="height" default="0.4"/>
<xacro:property name="edge" value="${2 * 0.1}"/>
<xacro:macro name="block" params="name z"><link name="${name}"><collision><origin xyz="0 0 ${z}"/>
<geometry><box size="${edge} ${edge} ${edge}"/></geometry></collision></link></xacro:macro>
<xacro:block name="base" z="0"/><xacro:block name="top" z="$(arg height)"/>
<joint name="weld" type="fixed"><parent link="base"/><child link="top"/></joint></robot>"#;

/// A folder whose scene has the post in place of its capsule.
fn folder(keys: &str) -> Folder {
    let folder = Folder::new();
    folder.write("post.urdf.xacro", XACRO);
    folder.edit(
        "cell.toml",
        "role = \"robot\"\ncapsule = { radius_m = 0.1, length_m = 0.6 }\nposition_m = [0.2, 0.3, 0.45]\nquaternion = { w = 1, x = 0, y = 0, z = 0 }",
        &format!("urdf = \"post.urdf.xacro\"\nposition_m = [0.2, 0.3, 0.2]\n{keys}"),
    );
    folder
}

/// Lists the scene of a folder, with programs that are found in these folders only.
fn voxelize(folder: &Folder, path: &str, more: &[&str]) -> Outcome {
    let (cell, map) = (folder.path("cell.toml"), folder.path("map.bt"));
    let mut command = Command::new(env!("CARGO_BIN_EXE_perirobot"));
    let output = command
        .args(["voxelize", text(&cell), "--voxel-size", "0.05", "--out", text(&map)])
        .args(more)
        .env("PATH", path)
        .output();
    let output = output.unwrap();
    let told = |bytes| String::from_utf8(bytes).unwrap();
    Outcome { code: output.status.code(), stdout: told(output.stdout), stderr: told(output.stderr) }
}

/// A folder of programs with a script in the place of xacro, which writes down that it was run and with which arguments.
fn stand_in(folder: &Folder, script: &str) -> String {
    std::fs::create_dir_all(folder.path("bin")).unwrap();
    let log = folder.path("ran");
    folder.write(
        "bin/xacro",
        format!("#!/bin/sh\necho run >> '{0}'\nprintf '%s\\n' \"$@\" >> '{0}'\n{script}\n", log.display()),
    );
    let program = folder.path("bin/xacro");
    std::fs::set_permissions(&program, std::fs::Permissions::from_mode(0o755)).unwrap();
    format!("{}:/usr/bin:/bin", folder.path("bin").display())
}

fn ran(folder: &Folder) -> Vec<String> {
    let log = std::fs::read_to_string(folder.path("ran")).unwrap_or_default();
    log.lines().map(String::from).collect()
}

/// What the list says of the post.
#[track_caller]
fn post(outcome: &Outcome) -> &str {
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    outcome.stdout.lines().find(|line| line.contains("robot")).unwrap_or_else(|| panic!("{}", outcome.stdout))
}

const PLAIN: &str = "cat <<'END'\n<robot name='post'><link name='base'><collision><geometry><box size='0.2 0.2 0.4'/></geometry></collision>\
                     </link></robot>\nEND";

#[test]
fn nothing_is_run_unless_it_is_allowed() {
    let folder = folder("");
    let path = stand_in(&folder, PLAIN);
    let refused = voxelize(&folder, &path, &[]);
    assert_eq!(refused.code, Some(2), "{}", refused.stdout);
    for expected in ["object \"", "urdf = ", "is a xacro", "expanded by --xacro", "pip install xacro"] {
        assert!(refused.stderr.contains(expected), "no {expected:?} in {}", refused.stderr);
    }
    assert_eq!(ran(&folder), [""; 0]);
    let allowed = voxelize(&folder, &path, &["--xacro"]);
    assert!(post(&allowed).contains("0.40]"), "from 0 to 0.4 m: {}", allowed.stdout);
    assert_eq!(ran(&folder).len(), 2);
    // A URDF needs no program.
    folder.edit("cell.toml", "post.urdf.xacro", "post.urdf");
    folder.write("post.urdf", "<robot name='p'><link name='b'><collision><geometry><sphere radius='0.2'/></geometry></collision></link></robot>");
    post(&voxelize(&folder, &path, &["--xacro"]));
    assert_eq!(ran(&folder).len(), 2);
}

#[test]
fn arguments_reach_the_program_and_it_runs_once() {
    let folder = folder(
        "xacro_args = { height = \"0.6 $(touch x)\", b = \"\" }\n[object.snapshots]\nposition_m = [[0, 0, 0], [0, 0.1, 0]]\n",
    );
    let path = stand_in(&folder, PLAIN);
    post(&voxelize(&folder, &path, &["--xacro"]));
    let file = folder.path("post.urdf.xacro").canonicalize().unwrap();
    assert_eq!(ran(&folder), ["run", text(&file), "b:=", "height:=0.6 $(touch x)"]);
    for (keys, expected) in [
        (
            "xacro_args = { \"--help\" = \"1\" }",
            "xacro_args.--help = \"1\": names have letters, digits and _",
        ),
        ("xacro_args = { \"\" = \"1\" }", "names have letters, digits and _"),
        ("xacro_args = { a = \"x\\ny\" }", "values no control characters"),
    ] {
        let folder = self::folder(keys);
        let path = stand_in(&folder, PLAIN);
        let refused = voxelize(&folder, &path, &["--xacro"]);
        assert_eq!((refused.code, ran(&folder).len()), (Some(2), 0), "{}", refused.stderr);
        assert!(refused.stderr.contains(expected), "no {expected:?} in {}", refused.stderr);
    }
    folder.edit("cell.toml", "post.urdf.xacro", "post.urdf");
    let refused = voxelize(&folder, &path, &["--xacro"]);
    assert!(refused.stderr.contains("xacro_args belong to a file that ends in .xacro"), "{}", refused.stderr);
}

#[test]
fn what_the_program_does_wrong_is_told() {
    let said = |script: &str| {
        let folder = folder("");
        let path = stand_in(&folder, script);
        let outcome = voxelize(&folder, &path, &["--xacro"]);
        assert_eq!(outcome.code, Some(2), "{}", outcome.stdout);
        outcome.stderr
    };
    let failed = said("echo half a robot; echo 'no such arg: height' >&2; exit 3");
    assert!(
        failed.contains("post.urdf.xacro: xacro: the program failed and says: no such arg: height"),
        "{failed}"
    );
    assert!(said("echo not xml").contains("post.urdf.xacro: is no XML"));
    assert!(said("printf '\\377\\377'").contains("is not UTF-8 text"));
    assert!(said("yes '<robot/>'").contains("xacro: writes more than 64 MiB"));
    // What comes out is data like any other: nothing is expanded twice.
    assert!(said("cat \"$1\"").contains("is a xacro"));
    let folder = folder("");
    let gone = voxelize(&folder, text(&folder.path("nowhere")), &["--xacro"]);
    assert_eq!(gone.code, Some(2));
    assert!(gone.stderr.contains("xacro: the program is not on the path: ROS has it"), "{}", gone.stderr);
}

#[test]
fn what_comes_out_is_part_of_what_a_sweep_is_of() {
    let folder = folder("");
    let path = stand_in(&folder, PLAIN);
    let study = folder.path("study.toml");
    let out = folder.path("out");
    let sweep = || {
        let mut command = Command::new(env!("CARGO_BIN_EXE_perirobot"));
        let arguments = ["sweep", text(&study), "--out", text(&out), "--backend", "cpu", "--xacro"];
        let output = command.args(arguments).env("PATH", &path).output().unwrap();
        (
            output.status.code(),
            String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap(),
        )
    };
    let (code, said) = sweep();
    assert_eq!(code, Some(0), "{said}");
    let manifest = std::fs::read_to_string(out.join("manifest.json")).unwrap();
    assert!(manifest.contains("post.urdf.xacro (expanded)"), "{manifest}");
    stand_in(&folder, &PLAIN.replace("0.2 0.2 0.4", "0.2 0.2 0.3"));
    let (code, said) = sweep();
    assert!(code == Some(2) && said.contains("post.urdf.xacro"), "{code:?}: {said}");
}

/// `$(find NAME)` is what the module of ROS says, which comes with perirobot: the folder in the scene file.
#[test]
fn packages_are_found_without_a_ros() {
    let Some(interpreter) = python::python() else { return };
    let find = |name: &str| {
        let ask = format!(
            "from ament_index_python.packages import get_package_share_directory as find; print(find(\"{name}\"))"
        );
        format!(
            "folder=$('{}' -c '{ask}') || exit 1; cat \"$folder/box.xml\"; echo \"<link name='m'><visual><geometry>\
             <mesh filename='file://$folder/box.xml'/></geometry></visual></link><joint name='j' type='fixed'><parent link='a'/><child link='m'/></joint></robot>\"",
            interpreter.display()
        )
    };
    let folder = folder("packages = { arm_description = \"parts\" }");
    std::fs::create_dir(folder.path("parts")).unwrap();
    folder.write("parts/box.xml", "<robot name='r'><link name='a'><collision><geometry><box size='0.2 0.2 0.4'/></geometry></collision></link>");
    let found = voxelize(&folder, &stand_in(&folder, &find("arm_description")), &["--xacro"]);
    assert!(post(&found).contains("0.40]"), "from 0 to 0.4 m: {}", found.stdout);
    // A name of a file in a package is the same on every machine.
    folder.edit("cell.toml", "urdf = ", "geometry = \"visual\"\nurdf = ");
    let named = voxelize(&folder, &stand_in(&folder, &find("arm_description")), &["--xacro"]);
    assert!(named.stderr.contains("mesh \"package://arm_description/box.xml\""), "{}", named.stderr);
    let unknown = voxelize(&folder, &stand_in(&folder, &find("hand")), &["--xacro"]);
    let expected = "package \"hand\" is not known: say where it is, as in packages = { hand = \"DIR\" }";
    assert!(unknown.code == Some(2) && unknown.stderr.contains(expected), "{}", unknown.stderr);
}

#[test]
fn the_program_itself_agrees() {
    let Some(interpreter) = python::python() else { return };
    // The environment was moved after it was made, so that its own scripts lead nowhere.
    let program = format!("exec '{}' -c 'import xacro; xacro.main()' \"$@\"", interpreter.display());
    // The top box reaches from 0.3 to 0.5 m above the origin by default, which is 0.2 m high.
    for (keys, top) in [("", "0.70]"), ("xacro_args = { height = \"0.6\" }", "0.90]")] {
        let folder = folder(keys);
        let outcome = voxelize(&folder, &stand_in(&folder, &program), &["--xacro"]);
        assert!(post(&outcome).contains(top), "{}", outcome.stdout);
    }
}
