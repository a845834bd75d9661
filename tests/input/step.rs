//! STEP files: converted by the package cascadio if the user allows it, and by nothing else. The package comes from PyPI,
//! into the environment of the Python tests.

mod file;

use std::path::Path;
use std::process::Command;
use std::sync::Arc;

use glam::DVec3;
use perirobot_scene::objects::{Object, Surface, build::build};
use perirobot_scene::source::Sources;
use perirobot_study::input::load_scene;

use self::file::{Part, assembly, one_part};
use crate::common::program::{Folder, Outcome, text};
use crate::common::python;

/// Two boxes whose edges all differ, one moved.
const PARTS: [Part; 2] = [
    Part {
        name: "Table",
        layers: &["0"],
        corners: [[10.0, 20.0, 30.0], [110.0, 320.0, 730.0]],
        place: [0.0; 3],
    },
    Part {
        name: "Fence left",
        layers: &["Schutzz\\X2\\00E4\\X0\\une", "0"],
        corners: [[0.0, -5.0, 1.0], [40.0, 7.0, 90.0]],
        place: [1000.0, -200.0, 35.0],
    },
];

/// A folder whose scene is a file of these bytes.
fn folder(step: &str, keys: &str) -> Folder {
    let folder = Folder::new();
    folder.write("cell.STEP", step);
    folder.write("cell.toml", format!("[[object]]\nname = \"cell\"\nmesh = \"cell.STEP\"\n{keys}"));
    folder
}

/// The objects of a folder's scene, and the names of the files that were read.
fn objects(folder: &Folder, python: &Path) -> (Vec<Arc<Object>>, Vec<String>) {
    let path = folder.path("cell.toml");
    let sources = Sources::from_main(&path).allow_step(python);
    let scenes = build(&load_scene(&path, &sources).unwrap(), &sources, 0.1).unwrap();
    let read = sources.read_files().into_iter().map(|file| file.path.display().to_string());
    (scenes.into_iter().next().unwrap().objects, read.collect())
}

/// The corners that bound an object.
fn bounds(object: &Object) -> [DVec3; 2] {
    let Surface::Mesh(mesh) = &object.surface else { panic!("{} has no mesh", object.name) };
    let (first, rest) = mesh.vertices.split_first().unwrap();
    rest.iter().fold([*first; 2], |[low, high], vertex| [low.min(*vertex), high.max(*vertex)])
}

#[track_caller]
fn assert_bounds(object: &Object, part: &Part, unit_m: f64) {
    let place = DVec3::from_array(part.place);
    for (found, corner) in bounds(object).into_iter().zip(part.corners) {
        let expected = (place + DVec3::from_array(corner)) * unit_m;
        assert!((found - expected).abs().max_element() < 1e-6, "{}: {found}, not {expected}", part.name);
    }
}

/// Lists the scene of a folder, in it, with an interpreter.
fn voxelize(folder: &Folder, python: &str, modules: &Path, more: &[&str]) -> Outcome {
    let mut command = Command::new(env!("CARGO_BIN_EXE_perirobot"));
    command.args(["voxelize", "cell.toml", "--voxel-size", "0.05", "--out", "map.bt"]).args(more);
    command.current_dir(folder.path(".")).env("PERIROBOT_PYTHON", python).env("PYTHONPATH", modules);
    let output = command.output().unwrap();
    let told = |bytes| String::from_utf8(bytes).unwrap();
    Outcome { code: output.status.code(), stdout: told(output.stdout), stderr: told(output.stderr) }
}

#[track_caller]
fn assert_refused(outcome: &Outcome, expected: &[&str]) {
    assert_eq!(outcome.code, Some(2), "{}", outcome.stdout);
    for expected in expected {
        assert!(outcome.stderr.contains(expected), "no {expected:?} in {}", outcome.stderr);
    }
}

#[test]
fn parts_have_their_sizes_and_names_in_any_unit() {
    let Some(python) = python::python() else { return };
    let rules = "[[object.nodes]]\nmatch = \"Fence*\"\noptical = \"see_through\"\n";
    for (is_in_inches, unit_m) in [(false, 0.001), (true, 0.0254)] {
        let folder = folder(&assembly(is_in_inches, &PARTS), rules);
        let (objects, read) = objects(&folder, &python);
        assert_eq!(objects.iter().map(|object| &*object.name).collect::<Vec<_>>(), ["cell", "cell/Fence*"]);
        objects.iter().zip(&PARTS).for_each(|(object, part)| assert_bounds(object, part, unit_m));
        assert_eq!(read, ["cell.STEP", "cell.STEP (converted)", "cell.toml"]);
    }
}

/// The surface of an object's box in square millimetres, which a solid that is there twice doubles.
fn area_mm2(object: &Object) -> f64 {
    let Surface::Mesh(mesh) = &object.surface else { panic!("{} has no mesh", object.name) };
    let area = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| mesh.vertices[corner as usize]);
        (b - a).cross(c - a).length() / 2.0
    };
    mesh.triangles.iter().map(area).sum::<f64>() * 1e6
}

#[test]
fn layers_select_parts_and_solids_of_one_part() {
    let Some(python) = python::python() else { return };
    let still = PARTS.map(|part| Part { place: [0.0; 3], ..part });
    let rule = "[[object.nodes]]\nlayer = \"Schutz*une\"\noptical = \"see_through\"\n";
    for (step, parts) in [(assembly(false, &PARTS), &PARTS), (one_part(&still), &still)] {
        let folder = folder(&step, rule);
        let (objects, read) = objects(&folder, &python);
        assert_eq!(
            objects.iter().map(|object| &*object.name).collect::<Vec<_>>(),
            ["cell", "cell/Schutz*une"]
        );
        for (object, part) in objects.iter().zip(parts) {
            assert_bounds(object, part, 0.001);
            let [low, high] = part.corners.map(DVec3::from_array);
            let [x, y, z] = (high - low).to_array();
            let expected = 2.0 * (x * y + y * z + z * x);
            assert!((area_mm2(object) - expected).abs() < 0.1, "{}: {}", part.name, area_mm2(object));
        }
        let converted =
            ["not on", "on"].map(|on| format!("cell.STEP (converted, {on} layer \"Schutz*une\")"));
        assert_eq!(read, [&["cell.STEP".into()], &converted[..], &["cell.toml".into()]].concat());
    }
}

#[test]
fn the_first_rule_counts_of_a_part_on_several_layers() {
    let Some(python) = python::python() else { return };
    let rules = "[[object.nodes]]\nlayer = \"0\"\nmatch = \"Fence*\"\n[[object.nodes]]\nlayer = \"0\"\n";
    let (found, _) = objects(&folder(&assembly(false, &PARTS), rules), &python);
    assert_eq!(found.iter().map(|object| &*object.name).collect::<Vec<_>>(), ["cell/0/Fence*", "cell/0"]);
    found.iter().zip(PARTS.iter().rev()).for_each(|(object, part)| assert_bounds(object, part, 0.001));
}

#[test]
fn a_layer_that_selects_nothing_is_refused_with_those_of_the_file() {
    let Some(python) = python::python() else { return };
    let python = text(&python);
    let refused = |step: &str, rules: &str, expected: &str| {
        let folder = folder(step, &format!("[[object.nodes]]\n{rules}\n"));
        assert_refused(&voxelize(&folder, python, Path::new("none"), &["--step"]), &[expected]);
    };
    let step = assembly(false, &PARTS);
    let others = "nodes.layer = \"Fence\": no whole solid or surface is on such a layer (assemblies, faces and curves do not count); there are 0, Schutzzäune";
    refused(&step, "layer = \"Fence\"", others);
    let no_name =
        "nodes.match = \"Wall\": no node with triangles has such a name; there are Fence left, Table";
    refused(&step, "layer = \"0\"\nmatch = \"Wall\"", no_name);
    let not_both = "nodes.match = \"Table\": no part of such a name is on a layer \"Schutz*\"";
    refused(&step, "layer = \"Schutz*\"\nmatch = \"Table\"", not_both);
    let plain = assembly(false, &PARTS.map(|part| Part { layers: &[], ..part }));
    let none = "nodes.layer = \"0\": no whole solid or surface of the file is on a layer (assemblies, faces and curves do not count): select parts by match";
    refused(&plain, "layer = \"0\"", none);
}

#[test]
fn sizes_that_no_cell_has_are_reported() {
    let Some(python) = python::python() else { return };
    let (python, step) = (text(&python), assembly(false, &PARTS));
    for (unit, code, expected) in [
        ("$,.METRE.", 2, "object \"cell\" is 1030.00 × 525.00 × 700.00 m: are its lengths in centimetres"),
        (".MICRO.,.METRE.", 0, "object \"cell\" is 1.0 mm long, less than a voxel: is its unit right?"),
    ] {
        let folder = folder(&step.replace(".MILLI.,.METRE.", unit), "");
        let outcome = voxelize(&folder, python, Path::new("none"), &["--step"]);
        assert_eq!(outcome.code, Some(code), "{}", outcome.stderr);
        assert!(outcome.stderr.contains(expected), "{}", outcome.stderr);
    }
}

#[test]
fn a_file_that_is_y_up_is_turned() {
    let Some(python) = python::python() else { return };
    let folder = folder(&assembly(false, &PARTS[..1]), "up = \"y\"\n");
    let turned = Part {
        name: "turned",
        layers: &[],
        corners: [[10.0, -730.0, 20.0], [110.0, -30.0, 320.0]],
        place: [0.0; 3],
    };
    assert_bounds(&objects(&folder, &python).0[0], &turned, 0.001);
}

#[test]
fn nothing_is_run_unless_it_is_allowed() {
    let folder = folder(&assembly(false, &PARTS), "");
    std::fs::create_dir(folder.path("modules")).unwrap();
    let modules = folder.path("modules");
    folder.write("modules/cascadio.py", format!("open({:?}, 'w')", text(&folder.path("ran"))));
    let refused = voxelize(&folder, "python3", &modules, &[]);
    let expected = [
        "object \"cell\": mesh = cell.STEP: is a STEP file",
        "step_to_glb('cell.STEP', 'cell.glb', 1.0)",
        "--step",
    ];
    assert_refused(&refused, &expected);
    assert!(!folder.path("ran").exists());
    folder.edit("cell.toml", "mesh =", "unit = \"mm\"\nmesh =");
    assert_refused(
        &voxelize(&folder, "python3", &modules, &["--step"]),
        &["unit does not belong to a STEP mesh: the file contains its unit"],
    );
    assert!(!folder.path("ran").exists());
}

#[test]
fn a_failure_is_reported_in_the_programs_words() {
    let Some(python) = python::python() else { return };
    let (python, whole) = (text(&python), assembly(false, &PARTS));
    let folder = folder(&whole, "");
    let none = folder.path("none");
    // A module beside the scene is not the package.
    folder.write("cascadio.py", "raise SystemExit('not this')");
    let converted = voxelize(&folder, python, &none, &["--step"]);
    assert_eq!(converted.code, Some(0), "{}", converted.stderr);
    assert!(converted.stdout.contains("[0.01, -0.21, 0.03] … [1.04, 0.32, 0.73]"), "{}", converted.stdout);
    folder.write("cell.STEP", &whole[..whole.len() / 2]);
    let broken =
        ["mesh = cell.STEP: STEP: cascadio failed and says: ", "Incorrect syntax: unexpected end of file"];
    assert_refused(&voxelize(&folder, python, &none, &["--step"]), &broken);
    folder.write("cell.STEP", &whole);
    let gone = voxelize(&folder, "/nowhere/python", &none, &["--step"]);
    assert_refused(&gone, &["STEP: the program /nowhere/python cannot be found: install Python 3"]);
    std::fs::create_dir(folder.path("modules")).unwrap();
    folder.write("modules/cascadio.py", "raise ModuleNotFoundError(\"No module named 'cascadio'\")");
    let missing = voxelize(&folder, python, &folder.path("modules"), &["--step"]);
    let install = format!("STEP: No module named 'cascadio': run `{python} -m pip install cascadio numpy`");
    assert_refused(&missing, &[&install]);
}
