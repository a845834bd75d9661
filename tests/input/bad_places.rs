//! Files that a study brings in from where it may not: each is refused with exit code 2, in a message that
//! names who asked, the file, the folder and the flags; and all that is read is listed.

use std::path::Path;

use crate::common::program::{self, Edit, Folder, perirobot, refused, text};
use perirobot_scene::source::Sources;
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;

const STUDY: &str = "study.toml";
const SCENE: &str = "cell.toml";
const POSES: &str = "x_m,y_m,z_m,qw,qx,qy,qz\n0,0,1.3,1,0,0,0\n";
const PERSON: &str = "0,0,1\n0,0,1\n0,0,1\n0.1,0.1,0.2\n0.1,-0.1,0.2\n0.1,0.2,0.3\n0.1,-0.2,0.3\n0.1,0.2,0.3\n\
                      0.1,-0.2,0.3\n0.1,0.2,0.3\n0.1,-0.2,0.3\n,,\n,,\n,,\n,,\n,,\n,,\n";
/// A closed one, with a corner at the origin.
fn tetrahedron() -> String {
    let corners = ["0 0 0", "0.6 0 0", "0 0.6 0", "0 0 0.6"];
    let facet = |[a, b, c]: [usize; 3]| {
        let [a, b, c] = [corners[a], corners[b], corners[c]];
        format!("facet normal 0 0 0\nouter loop\nvertex {a}\nvertex {b}\nvertex {c}\nendloop\nendfacet\n")
    };
    let facets = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(facet);
    format!("solid\n{}endsolid\n", facets.concat())
}

/// Every way of naming a file that is not there, or not allowed: who asks, and with which words.
fn ways(file: &str) -> [(Edit<'static>, String, &'static str); 7] {
    let edit = |file, from, to| (file, from, to);
    let lists = "list = [\n    { name = \"upright\", position_m = [-0.9, 0.6, 0.9], facing = [1, -0.5, 0], pan_deg = 10 },\n    \
                 { name = \"leaning\", position_m = [0.95, -0.6, 1.1], rpy_deg = [0, 30, 135] },\n    \
                 { name = \"corner\", position_m = [0.1, 0.1, 1.3], quaternion = { w = 1, x = 0, y = 0, z = 0 } },\n]";
    let named = |key: &str, name: &str| format!("{key} = \"{file}/{name}\"");
    let object = "\n[[object]]\nname = \"more\"\n";
    [
        (edit(STUDY, "file = \"cell.toml\"", ""), named("file", "cell.toml"), "scene[0].file: "),
        (
            edit(STUDY, lists, ""),
            named("csv", "poses.csv"),
            "study.toml: sensor \"lidar\".poses \"posts\": csv: ",
        ),
        (
            edit(
                STUDY,
                "",
                "\n[[sensor]]\nname = \"ring\"\nkind = \"rays\"\nrange_m = [0, 1]\nsame_poses_as = \"camera\"\n",
            ),
            named("directions", "ring.csv"),
            "study.toml: sensor \"ring\": directions: ",
        ),
        (
            edit(STUDY, "", "\n[[region]]\nname = \"zone\"\n"),
            named("mesh", "zone.stl"),
            "study.toml: region \"zone\".mesh = ",
        ),
        (edit(SCENE, "", object), named("mesh", "zone.stl"), "cell.toml: object \"more\": mesh = "),
        (
            edit(SCENE, "", object),
            named("mannequin", "person.csv"),
            "cell.toml: object \"more\": mannequin = ",
        ),
        (edit(SCENE, "", object), named("urdf", "arm.urdf"), "cell.toml: object \"more\": urdf = "),
    ]
}

/// The small study in a folder beside another with everything that it may name.
fn beside() -> (Folder, tempfile::TempDir) {
    let other = tempfile::tempdir().unwrap();
    let urdf = "<robot name='arm'><link name='a'><collision><geometry><mesh filename='zone.stl'/></geometry>\
                </collision></link></robot>";
    for (name, bytes) in [
        ("cell.toml", program::SCENE),
        ("poses.csv", POSES),
        ("ring.csv", "x,y,z\n1,0,0\n"),
        ("zone.stl", &tetrahedron()),
        ("person.csv", PERSON),
        ("arm.urdf", urdf),
    ] {
        std::fs::write(other.path().join(name), bytes).unwrap();
    }
    (Folder::new(), other)
}

#[test]
fn whatever_names_a_file_elsewhere_is_refused_and_may_be_allowed() {
    let count = ways("").len();
    for way in 0..count {
        let (folder, other) = beside();
        let ((file, from, to), key, who) = ways(text(other.path())).into_iter().nth(way).unwrap();
        let to = format!("{to}{key}\n");
        let expected =
            [who, text(other.path()), ": lies outside of ", "--package NAME=DIR", "--allow-outside"];
        refused(&folder, &[(file, from, &to)], &expected);
        let allowed = folder.sweep(&["--allow-outside"]);
        assert_eq!(allowed.code, Some(0), "{key}: {}", allowed.stderr);
    }
}

#[test]
fn a_scene_alone_has_its_own_folder() {
    let (folder, other) = beside();
    let mesh = format!("\n[[object]]\nname = \"more\"\nmesh = {:?}\n", other.path().join("zone.stl"));
    folder.edit(SCENE, "", &mesh);
    let (scene, out) = (folder.path(SCENE), folder.path("cell.bt"));
    let voxelize = |more: &[&str]| {
        let outcome = perirobot(&[&["voxelize", text(&scene), "--out", text(&out)], more].concat());
        (outcome.code, outcome.stderr)
    };
    let (code, stderr) = voxelize(&[]);
    assert_eq!(code, Some(2), "{stderr}");
    assert!(
        stderr.contains("cell.toml: object \"more\": mesh = ") && stderr.contains("lies outside of"),
        "{stderr}"
    );
    assert_eq!(voxelize(&["--allow-outside"]).0, Some(0));
    // The folder of a package that the user names may be read; a study cannot name one for itself.
    assert_eq!(voxelize(&["--package", &format!("parts={}", text(other.path()))]).0, Some(0));
}

#[test]
fn a_study_cannot_open_a_folder_by_calling_it_a_package() {
    let (folder, other) = beside();
    let urdf = std::fs::read_to_string(other.path().join("arm.urdf")).unwrap();
    folder.write("arm.urdf", urdf.replace("zone.stl", "package://parts/zone.stl"));
    let packages = format!("packages = {{ parts = {:?} }}", other.path());
    let robot = format!("\n[[object]]\nname = \"more\"\nurdf = \"arm.urdf\"\n{packages}\n");
    refused(&folder, &[(SCENE, "", &robot)], &["zone.stl: lies outside of ", "--package NAME=DIR"]);
    let outcome = folder.sweep(&["--package", &format!("parts={}", text(other.path()))]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
}

#[test]
fn a_study_made_ready_has_listed_all_its_files() {
    for (study, files) in [
        (
            "scenes/sensors.toml",
            &[
                "sensors.toml",
                "sensors/../paper/scene1_operator.csv",
                "sensors/../paper/ur10.urdf",
                "sensors/cell.toml",
                "sensors/ring.csv",
                "sensors/visitor.csv",
            ][..],
        ),
        ("scenes/tiny.toml", &["tiny.toml", "tiny/cell.toml"]),
    ] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(study);
        let study = Study::read(&path, &Overrides::default(), Sources::from_main(&path)).unwrap();
        World::prepare_all(&study).unwrap();
        let listed: Vec<_> = study.sources.read_files().into_iter().map(|file| file.path).collect();
        assert_eq!(listed.iter().map(|path| text(path)).collect::<Vec<_>>(), files);
    }
}
