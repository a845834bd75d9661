//! Broken, empty and missing surface files: each is refused by the scene's file, the object, the key and the
//! mesh's own file, before any ray is cast. The tests beside the loaders try each kind of damage.

use crate::common::program::Folder;
use perirobot_scene::objects::octomap;

/// The ball's surface taken from a file of these bytes must be refused in words that hold all of `expected`.
#[track_caller]
fn check(key: &str, file: &str, bytes: Option<&[u8]>, expected: &[&str]) {
    let folder = Folder::new();
    if let Some(bytes) = bytes {
        folder.write(file.split('"').next().unwrap(), bytes);
    }
    folder.edit(
        "cell.toml",
        "sphere = { radius_m = 0.12 }\nposition_m = [-0.7, -0.5, 0.3]",
        &format!(
            "{} = \"{file}\"",
            match key {
                "" if file.ends_with(".bt") => "octomap",
                "" => "mesh",
                key => key,
            }
        ),
    );
    let before = folder.names();
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(2), "{file}: {}", outcome.stderr);
    let place = ["cell.toml: object \"ball\"", key];
    for fragment in place.iter().chain(expected) {
        assert!(outcome.stderr.contains(fragment), "no {fragment:?} in {}", outcome.stderr);
    }
    assert!(
        !outcome.stderr.contains("panicked") && !outcome.stderr.contains("running on"),
        "{}",
        outcome.stderr
    );
    assert_eq!(folder.names(), before);
}

/// A glTF with one triangle, its corners in a data URI; `edit` changes the JSON.
fn gltf(edit: impl Fn(String) -> String) -> Vec<u8> {
    // (0,0,0), (1,0,0), (0,1,0) as little-endian floats, and the indices 0, 1, 2 as 16-bit integers.
    let positions = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA";
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"name":"part","mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1}}]}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
        {{"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}},{{"buffer":1,"byteLength":6}}],
        "buffers":[{{"byteLength":36,"uri":"data:application/octet-stream;base64,{positions}"}},
        {{"byteLength":6,"uri":"data:application/octet-stream;base64,AAABAAIA"}}]}}"#
    );
    edit(json).into_bytes()
}

/// One triangle as text.
fn stl(corner: &str) -> Vec<u8> {
    let facet = format!(
        "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex {corner}\nendloop\nendfacet"
    );
    format!("solid part\n{facet}\nendsolid part\n").into_bytes()
}

/// The same.
fn obj(corner: &str) -> Vec<u8> {
    format!("v 0 0 0\nv 1 0 0\nv {corner}\nf 1 2 3\n").into_bytes()
}

/// The same.
fn dae(corner: &str) -> Vec<u8> {
    format!(
        r##"<COLLADA version="1.4.1"><asset><up_axis>Z_UP</up_axis></asset>
        <library_geometries><geometry id="g"><mesh>
        <source id="s"><float_array id="f" count="9">0 0 0 1 0 0 {corner}</float_array>
        <technique_common><accessor source="#f" count="3" stride="3"/></technique_common></source>
        <vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
        <triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
        </mesh></geometry></library_geometries>
        <library_visual_scenes><visual_scene id="c"><node><instance_geometry url="#g"/></node></visual_scene>
        </library_visual_scenes><scene><instance_visual_scene url="#c"/></scene></COLLADA>"##
    )
    .into_bytes()
}

#[test]
fn broken_obj_and_collada() {
    check("mesh", "part.obj", Some(b""), &["part.obj: has no face with an area"]);
    check("mesh", "part.obj", Some(&obj("0 nan 0")), &["part.obj: line 3: nan: must be finite"]);
    check("mesh", "part.obj", Some(&obj("1 0 0")), &["part.obj: has no face with an area"]);
    check("", "part.obj", Some(&obj("0 1e30 0")), &["a corner at", "millimetres"]);
    let whole = dae("0 1 0");
    check("mesh", "part.dae", Some(&whole[..whole.len() / 2]), &["part.dae: is no XML"]);
    check("mesh", "part.dae", Some(b"<svg/>"), &["part.dae: its root is <svg>"]);
    check("mesh", "part.dae", Some(&dae("0 nan 0")), &["part.dae: ", "is no finite number"]);
    let lying = String::from_utf8(whole).unwrap().replace("Z_UP", "UP");
    check(
        "mesh",
        "part.dae",
        Some(lying.as_bytes()),
        &["part.dae: <up_axis> = \"UP\": must be X_UP, Y_UP or Z_UP"],
    );
}

#[test]
fn the_small_files_they_start_from_are_good() {
    for (file, bytes) in [
        ("part.gltf", gltf(|json| json)),
        ("part.stl", stl("0 1 0")),
        ("part.obj", obj("0 1 0")),
        ("part.dae", dae("0 1 0")),
    ] {
        let folder = Folder::new();
        folder.write(file, bytes);
        folder.edit("cell.toml", "sphere = { radius_m = 0.12 }", &format!("mesh = \"{file}\""));
        let outcome = folder.sweep(&[]);
        assert_eq!(outcome.code, Some(0), "{file}: {}", outcome.stderr);
    }
}

#[test]
fn missing_files() {
    for (key, file) in [
        ("mesh", "gone.glb"),
        ("mesh", "gone.gltf"),
        ("mesh", "gone.stl"),
        ("octomap", "gone.bt"),
        ("mannequin", "gone.csv"),
    ] {
        check(key, file, None, &[file, "cannot be read"]);
    }
    check("mesh", "gone.obj", None, &["gone.obj: cannot be read"]);
    check("mesh", "gone.dae", None, &["gone.dae: cannot be read"]);
    check(
        "mesh",
        "part.ply",
        None,
        &["part.ply", "must be a .glb, .gltf, .stl, .obj, .dae or .step file", "Blender"],
    );
    check("mesh", "part.bt", None, &["write octomap = instead"]);
    check("mesh", "", None, &["must be a .glb"]);
}

#[test]
fn broken_gltf() {
    let changed = |from: &'static str, to: &'static str| {
        gltf(move |json| {
            assert!(json.contains(from), "{from}");
            json.replacen(from, to, 1)
        })
    };
    let whole = gltf(|json| json);
    check("mesh", "part.gltf", Some(&whole[..whole.len() / 2]), &["part.gltf"]);
    check("mesh", "part.gltf", Some(b""), &["part.gltf"]);
    check("mesh", "part.glb", Some(b"glTF\x02\0\0\0\xff\0\0\0"), &["part.glb"]);
    // The index 9 of three corners.
    check("mesh", "part.gltf", Some(&changed("AAABAAIA", "AAABAAkA")), &["part.gltf", "nodes[0]"]);
    check("mesh", "part.gltf", Some(&changed("\"mesh\":0", "\"mesh\":7")), &["part.gltf", "nodes[0]"]);
    let recursive = changed("\"mesh\":0", "\"mesh\":0,\"children\":[0]");
    check("mesh", "part.gltf", Some(&recursive), &["part.gltf", "nodes[0] is reached twice"]);
    // A quiet not-a-number in place of the second corner's x.
    check("mesh", "part.gltf", Some(&changed("AACAPw", "AADAfw")), &["part.gltf", "nodes[0]"]);
    check("mesh", "part.gltf", Some(&changed(",\"mesh\":0", "")), &["part.gltf", "has no triangle"]);
    check(
        "mesh",
        "part.gltf",
        Some(&changed("\"byteLength\":36,\"uri\"", "\"byteLength\":99,\"uri\"")),
        &["part.gltf"],
    );
    let pattern = "part.gltf\"\nnodes = [{ match = \"Fence*\" }]\n#\"";
    check("", pattern, Some(&whole), &["nodes.match = \"Fence*\"", "there are part"]);
    let layer = "part.gltf\"\nnodes = [{ match = \"*\" }, { layer = \"Fence\" }]\n#\"";
    check("", layer, Some(&whole), &["nodes[1].layer = \"Fence\"", "only a .step mesh has layers"]);
    let neither = "part.gltf\"\nnodes = [{ ignore = true }]\n#\"";
    check("", neither, Some(&whole), &["nodes[0]: has neither match nor layer"]);
}

#[test]
fn a_person_of_two_parts_has_no_keypoints() {
    let folder = Folder::new();
    let two = r#"[{"name":"head","mesh":0},{"name":"body","mesh":0,"translation":[0,0.2,0]}]"#;
    let parts = gltf(|json| {
        json.replace(r#"[{"name":"part","mesh":0}]"#, two).replace(r#""nodes":[0]"#, r#""nodes":[0,1]"#)
    });
    folder.write("person.gltf", parts);
    folder.write("joints.csv", "0,0,0.6\n".to_string() + &",,\n".repeat(16));
    folder.edit(
        "cell.toml",
        "",
        "[[object]]\nname = \"person\"\nrole = \"human\"\nmesh = \"person.gltf\"\nkeypoints = \"joints.csv\"\n\
         nodes = [{ match = \"head\" }]\n",
    );
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    let expected = "object \"person\": nodes: \"person\" and \"person/head\" are both human";
    assert!(outcome.stderr.contains(expected), "{}", outcome.stderr);
    // One rule for all of the person is good.
    folder.edit("cell.toml", "match = \"head\"", "match = \"*\"");
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
}

#[test]
fn everything_ignored() {
    let folder = Folder::new();
    folder.write("part.gltf", gltf(|json| json));
    folder.write(
        "cell.toml",
        "[[object]]\nname = \"a\"\nmesh = \"part.gltf\"\nnodes = [{ match = \"*\", ignore = true }]\n",
    );
    let outcome = folder.sweep(&[]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("cell.toml: nodes: every part"), "{}", outcome.stderr);
}

#[test]
fn broken_stl() {
    let whole = stl("0 1 0");
    check("mesh", "part.stl", Some(&whole[..whole.len() / 2]), &["part.stl"]);
    check("mesh", "part.stl", Some(b""), &["part.stl"]);
    check("mesh", "part.stl", Some(b"solid part\nendsolid part\n"), &["part.stl"]);
    check("mesh", "part.stl", Some(&stl("0 nan 0")), &["part.stl"]);
    check("mesh", "part.stl", Some(&stl("0 inf 0")), &["part.stl"]);
    let binary = |triangles: u32, floats: &[f32]| {
        let mut bytes = vec![b' '; 80];
        bytes.extend(triangles.to_le_bytes());
        floats.iter().for_each(|f| bytes.extend(f.to_le_bytes()));
        bytes.extend([0; 2]);
        bytes
    };
    let corners = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    check("mesh", "part.stl", Some(&binary(2, &corners)), &["part.stl"]);
    check("mesh", "part.stl", Some(&binary(u32::MAX, &corners)), &["part.stl"]);
    check("mesh", "part.stl", Some(&binary(0, &[])), &["part.stl"]);
    let mut nan = corners;
    nan[4] = f32::NAN;
    check("mesh", "part.stl", Some(&binary(1, &nan)), &["part.stl"]);
    // Larger than any cell, though each number is a number.
    check("", "part.stl", Some(&stl("0 1e30 0")), &["a corner at", "millimetres"]);
}

#[test]
fn broken_octomaps() {
    let good = octomap::write(0.1, [0; 3], [2; 3], &|_| Some(true));
    check("octomap", "map.bt", Some(&good[..good.len() - 1]), &["map.bt", "truncated"]);
    check("octomap", "map.bt", Some(b"# Octomap OcTree file\n"), &["map.bt", "ends before the line `data`"]);
    let empty = octomap::write(0.1, [0; 3], [2; 3], &|_| Some(false));
    check("octomap", "map.bt", Some(&empty), &["map.bt", "has no occupied voxel"]);
    let finer = octomap::write(0.05, [0; 3], [2; 3], &|_| Some(true));
    check("", "map.bt", Some(&finer), &["0.05 m and the grid's 0.1 m", "voxel_size_m = 0.05"]);
    check("octomap", "map.bt\"\nposition_m = [1, 0, 0]\n#\"", Some(&good), &["an octomap stays where it is"]);
}

#[test]
fn broken_keypoints() {
    check("mannequin", "person.csv", Some(b""), &["person.csv", "has 0 joints"]);
    check(
        "mannequin",
        "person.csv",
        Some(b"joint,x_m,y_m,z_m\nnose,0,0,x\n"),
        &["person.csv", "line 2 (nose)"],
    );
    check(
        "mannequin",
        "person.csv",
        Some(b"joint,x_m,y_m,z_m\nnose,0,0,nan\n"),
        &["person.csv", "line 2 (nose)"],
    );
    check("mannequin", "person.csv", Some(b"\xff\xfe\0\0"), &["person.csv"]);
}

#[test]
fn files_of_other_formats_are_named_with_their_converter() {
    check("octomap", "scan.pcd", Some(b"VERSION 0.7"), &["must be a .bt or .ot file", "octomap_server"]);
    check("mannequin", "walk.fbx", Some(b"Kaydara"), &["(.bvh): Blender imports it and exports .bvh"]);
    check("mesh", "hall.las", Some(b"LASF"), &["a sensor of kind = \"recorded\" reads them"]);
}
