//! Files as other programs write them: what is odd about one is passed over, told, or refused by what a user can do about
//! it; nothing is placed wrongly in silence. The tests beside the readers try more of each kind.

use crate::common::program::{Folder, Outcome, perirobot, text};

/// A cube of 1 m from the origin.
const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nv 9 9 9\n\
                    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
const WHOLE: &str = "[0.00, 0.00, 0.00] … [1.00, 1.00, 1.00]";

/// Lists a scene of one object with these keys, beside these files.
fn voxelize(keys: &str, files: &[(&str, &[u8])]) -> Outcome {
    let folder = Folder::new();
    files.iter().for_each(|(name, bytes)| {
        std::fs::create_dir_all(folder.path(name).parent().unwrap()).unwrap();
        folder.write(name, bytes);
    });
    folder.write("cell.toml", format!("[[object]]\nname = \"part\"\n{keys}\n"));
    let (cell, map) = (folder.path("cell.toml"), folder.path("map.bt"));
    perirobot(&["voxelize", text(&cell), "--voxel-size", "0.1", "--out", text(&map)])
}

/// The object is read, and its line and the warnings hold all of `expected`; without a warning among them there is none.
#[track_caller]
fn read(keys: &str, files: &[(&str, &[u8])], expected: &[&str]) {
    let outcome = voxelize(keys, files);
    assert_eq!(outcome.code, Some(0), "{keys}: {}", outcome.stderr);
    let said = outcome.stdout + &outcome.stderr;
    expected.iter().for_each(|part| assert!(said.contains(part), "{keys}: no {part:?} in {said}"));
    let is_warned = expected.iter().any(|part| part.starts_with("object"));
    assert_eq!(said.contains("cell.toml: object"), is_warned, "{keys}: {said}");
}

/// The object is refused in words that hold all of `expected`.
#[track_caller]
fn refused(keys: &str, files: &[(&str, &[u8])], expected: &[&str]) {
    let outcome = voxelize(keys, files);
    assert_eq!(outcome.code, Some(2), "{keys}: {}", outcome.stdout);
    let said = outcome.stderr;
    expected.iter().for_each(|part| assert!(said.contains(part), "{keys}: no {part:?} in {said}"));
}

fn utf_16(text: &str) -> Vec<u8> {
    format!("\u{feff}{text}").encode_utf16().flat_map(u16::to_le_bytes).collect()
}

/// A glTF of one triangle of 1 m in its x and y, in the nodes of this JSON.
fn gltf(nodes: &str, more: &str) -> Vec<u8> {
    let data = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0,1]}},{{"name":"spare"}}],"nodes":{nodes},
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],
        "buffers":[{{"byteLength":36,"uri":"data:;base64,{data}"}}]{more}}}"#
    )
    .into_bytes()
}

#[test]
fn meshes() {
    let mesh = "mesh = \"part.obj\"";
    let commented = CUBE.replacen("v 1 0 0", "# from D:\\parts\\\nv 1 0 0", 1);
    read(mesh, &[("part.obj", commented.as_bytes())], &[" 12 ", WHOLE]);
    read(mesh, &[("part.obj", format!("g \\\\nas\\cell\\\n{CUBE}f 1 2\n").as_bytes())], &[" 12 ", WHOLE]);
    refused(mesh, &[("part.obj", &utf_16(CUBE))], &["part.obj: is UTF-16 text: save it as UTF-8"]);
    let pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 12\n";
    refused(mesh, &[("part.obj", pointer)], &["part.obj: is a pointer of Git LFS", "git lfs pull"]);
    let turned = CUBE.replacen("f 5 6 7 8", "f 8 7 6 5", 1);
    let filled = "mesh = \"part.obj\"\ninterior = \"occupied\"";
    let told = "object \"part\" is not watertight (some of its faces are turned inside out";
    read(filled, &[("part.obj", turned.as_bytes())], &[WHOLE, told]);
    let open = CUBE.replacen("f 5 6 7 8", "", 1);
    read(
        filled,
        &[("part.obj", open.as_bytes())],
        &["object \"part\" is not watertight (an edge has only one side)"],
    );
    // A triangle, and two bytes more than are declared.
    let corners = [0f32, 0., 0., 1., 0., 0., 0., 1., 0.].map(f32::to_le_bytes).concat();
    let stl = [&[b' '; 80][..], &[1, 0, 0, 0], &[0; 12], &corners, &[0; 4]].concat();
    let told = "object \"part\" is read from";
    read(
        "mesh = \"part.stl\"",
        &[("part.stl", &stl)],
        &[told, "part.stl: without 2 bytes behind its triangles"],
    );
    refused(
        "mesh = \"part.stl\"",
        &[("part.stl", b"solid s\nfacet normal 0 0 1\nouter loop\nvertex 0,5 1 1\nendsolid\n")],
        &["line 4: a vertex has \"0,5\": must be a finite number with a decimal point"],
    );
}

#[test]
fn gltf_files() {
    let mesh = "mesh = \"part.gltf\"";
    let both = r#"[{"mesh":0},{"mesh":0,"translation":[4,0,0]}]"#;
    read(mesh, &[("part.gltf", &gltf(both, ""))], &["[0.00, 0.00, 0.00] … [5.00, 0.00, 1.00]"]);
    let hidden = r#"[{"mesh":0},{"mesh":0,"translation":[4,0,0],"extensions":{"KHR_node_visibility":{"visible":false}}}]"#;
    let used = r#","extensionsUsed":["KHR_node_visibility"],"extensionsRequired":["KHR_materials_unlit"]"#;
    let told = "part.gltf: without 1 node that KHR_node_visibility hides";
    read(
        mesh,
        &[("part.gltf", &gltf(hidden, used))],
        &["object \"part\"", told, "[0.00, 0.00, 0.00] … [1.00, 0.00, 1.00]"],
    );
    let told = "part.gltf: is taken as z up by up = \"z\", against the rules of glTF";
    read(
        "mesh = \"part.gltf\"\nup = \"z\"",
        &[("part.gltf", &gltf(both, ""))],
        &["object \"part\"", told, "[0.00, 0.00, 0.00] … [5.00, 1.00, 0.00]"],
    );
    read("mesh = \"part.gltf\"\nup = \"y\"", &[("part.gltf", &gltf(both, ""))], &["[5.00, 0.00, 1.00]"]);
    refused(mesh, &[("part.gltf", b"")], &["part.gltf: is empty: export it again"]);
    refused(
        mesh,
        &[("part.gltf", br#"{"asset":{"version":"1.0"},"nodes":{"a":{}}}"#)],
        &["needs glTF 1.0: export it again as glTF 2.0"],
    );
}

#[test]
fn formats_that_are_not_read() {
    for (keys, expected) in [
        ("mesh = \"hall.IFC\"", "IfcConvert --y-up --use-element-names hall.IFC hall.glb"),
        ("mesh = \"arm.sldprt\"", "SOLIDWORKS"),
        ("mesh = \"plan.dxf\"", "FreeCAD"),
        ("mesh = \"man.fbx\"", "FBX2glTF --binary man.fbx"),
        ("mesh = \"scan.e57\"", "pdal translate scan.e57 scan.ply"),
    ] {
        refused(keys, &[], &["cell.toml: object \"part\".mesh", "must be a .glb", expected]);
    }
    let folder = Folder::new();
    folder.write("drive.db3", "SQLite");
    let (bag, study) = (folder.path("drive.db3"), folder.path("study.toml"));
    let outcome = perirobot(&["score", text(&bag), text(&study)]);
    assert_eq!(outcome.code, Some(2));
    assert!(outcome.stderr.contains("mcap convert drive.db3 drive.mcap"), "{}", outcome.stderr);
}

#[test]
fn paths_and_numbers_in_toml() {
    for (keys, expected) in [
        (r#"mesh = "C:\Users\part.obj""#, "write paths with /, as in \"C:/cell/part.stl\""),
        (r#"mesh = "parts\new.obj""#, "its name has a control character"),
        (r#"mesh = "parts\cube.obj""#, "write paths with /"),
        ("box = { size_m = [.5, 1, 1] }", "a number begins with a digit, as in 0.5"),
        ("box = { size_m = [1., 1, 1] }", "a digit follows the point, as in 5.0"),
        ("interior = occupied", "write text between plain quotes"),
    ] {
        refused(keys, &[], &["cell.toml: ", expected]);
    }
    read(r"mesh = 'parts\cube.obj'", &[("parts/cube.obj", CUBE.as_bytes())], &[" 12 ", WHOLE]);
    let near = r"parts\cubes.obj: cannot be read";
    refused(
        r"mesh = 'parts\cubes.obj'",
        &[("parts/cube.obj", CUBE.as_bytes())],
        &[near, "there is \"cube.obj\""],
    );
}

#[test]
fn robots_and_worlds() {
    let urdf = r"<!-- a -- b --><robot name='r'><gazebo><gz:x/></gazebo><link name='a'><collision><geometry><mesh filename='m\cube.obj'/></geometry></collision></link></robot>";
    read(
        "urdf = \"r.urdf\"",
        &[("r.urdf", urdf.as_bytes()), ("m/cube.obj", CUBE.as_bytes())],
        &[" 12 ", WHOLE],
    );
    // Prefixes that are declared again and again, which take a parser of namespaces a minute.
    let declared: String = (0..250).map(|i| format!(" xmlns:n{i}='u'")).collect();
    let nested =
        format!("{}{}{}", format!("<g{declared}>").repeat(60), "<h/>".repeat(30_000), "</g>".repeat(60));
    let slow = urdf.replacen("<gz:x/>", &nested, 1);
    read(
        "urdf = \"r.urdf\"",
        &[("r.urdf", slow.as_bytes()), ("m/cube.obj", CUBE.as_bytes())],
        &[" 12 ", WHOLE],
    );
    let link = "<model name='m'><link name='l'><collision name='c'><geometry><box><size>1 1 1</size></box></geometry></collision></link></model>";
    let state = "<state world_name='w'><model name='m'><pose>7 0 0 0 0 0</pose></model></state>";
    let world = format!(
        "<sdf version='1.6'><!-- saved -- today --><world name='w'><gz:x/>{link}{state}</world></sdf>"
    );
    let told = "world.sdf: with 1 model placed by its <state>";
    read(
        "sdf = \"world.sdf\"",
        &[("world.sdf", world.as_bytes())],
        &["object \"part\"", told, "[6.50, -0.50, -0.50] … [7.50, 0.50, 0.50]"],
    );
    refused("sdf = \"world.sdf\"", &[("world.sdf", &utf_16(&world))], &["world.sdf: is UTF-16 text"]);
    refused(
        "sdf = \"world.sdf\"",
        &[("world.sdf", b"<sdf>\nGeh\xe4use")],
        &["is not UTF-8 text: line 2 has the byte 0xE4"],
    );
}

#[test]
fn people() {
    let rows = |wrist: &str| {
        format!(
            "0.1,0,1.6\n0.08,0.03,1.63\n0.08,-0.03,1.63\n0,0.07,1.6\n0,-0.07,1.6\n0,0.18,1.4\n0,-0.18,1.4\n0,0.2,1.1\n0,-0.2,1.1\n{wrist}\n\
             0,-0.2,0.85\n0,0.1,0.9\n0,-0.1,0.9\n0,0.1,0.48\n0,-0.1,0.48\n0,0.1,0.08\n0,-0.1,0.08\n"
        )
    };
    let person = "mannequin = \"p.csv\"";
    read(person, &[("p.csv", rows("0,0.2,0.85").as_bytes())], &["human"]);
    read(
        person,
        &[("p.csv", format!("\u{feff}x_m,y_m,z_m\n{}", rows("-nan(ind),nan,1.#QNAN")).as_bytes())],
        &["human"],
    );
    let told = "p.csv: left_wrist at exactly 0, 0, 0: leave the cells of a joint empty that was not found";
    read(person, &[("p.csv", rows("0,0,0").as_bytes())], &["object \"part\"", told]);
    let counted: String =
        rows("0,0.2,0.85").lines().enumerate().map(|(row, line)| format!("{row},{line}\n")).collect();
    refused(person, &[("p.csv", counted.as_bytes())], &["p.csv: x_m is the number of the row in each row"]);
    refused(person, &[("p.csv", &utf_16(&rows("0,0.2,0.85")))], &["p.csv: is UTF-16 text"]);
}

/// A cloud whose coordinates are those of a map of a country.
#[test]
fn clouds_in_map_coordinates() {
    let folder = Folder::new();
    let header = "ply\nformat ascii 1.0\nelement vertex 1\nproperty double x\nproperty double y\nproperty double z\nend_header\n";
    folder.write("scan.ply", format!("{header}654321.5 6123456.25 101\n"));
    let (scan, study) = (folder.path("scan.ply"), folder.path("study.toml"));
    let score = |more: &[&str]| perirobot(&[&["score", text(&scan), text(&study)], more].concat());
    let there = score(&["--at=-654321,-6123456,-100,0", "--sensor=654321,6123456,101"]);
    assert_eq!(there.code, Some(0), "{}", there.stderr);
    assert!(
        there.stdout.contains("1 points measured from 654321.000, 6123456.000, 101.000 m"),
        "{}",
        there.stdout
    );
    let beyond = score(&["--at=0,1e9,0,0"]);
    assert!(beyond.stderr.contains("each from -100000000 to 100000000"), "{}", beyond.stderr);
    folder.edit("study.toml", "[[sensor]]", "[[sensor]]\nname = \"old\"\nkind = \"recorded\"\n[[sensor.recording]]\nfile = \"scan.ply\"\nposition_m = [-654321, -6123456, -100]\nsensor_m = [654321, 6123456, 101]\n[[sensor]]");
    let outcome = perirobot(&["check", text(&study)]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stdout + &outcome.stderr);
    assert!(!outcome.stderr.contains("looks like millimetres"), "{}", outcome.stderr);
}

#[test]
fn regions_are_read_from_files_like_objects() {
    let folder = Folder::new();
    let corners = [[0f32, 0., 0.], [0., 1., 0.], [1., 0., 0.], [0., 0., 1.]];
    let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [2, 1, 3]].map(|face: [usize; 3]| {
        [&[0; 12][..], &face.map(|i| corners[i].map(f32::to_le_bytes).concat()).concat(), &[0; 2]].concat()
    });
    folder.write("zone.stl", [&[b' '; 80][..], &[4, 0, 0, 0], &faces.concat(), b"more"].concat());
    folder.edit("study.toml", "[[region]]", "[[region]]\nname = \"zone\"\nmesh = \"zone.stl\"\n[[region]]");
    let outcome = perirobot(&["check", text(&folder.path("study.toml"))]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stdout + &outcome.stderr);
    let said = outcome.stdout + &outcome.stderr;
    assert!(
        said.contains("a region is read from") && said.contains("zone.stl: without 4 bytes behind"),
        "{said}"
    );
}
