//! Regions as a user writes them: each shape has the voxels it should have, a mesh in a file like one in
//! metres, and what cannot be is refused with file, key, value and cure.

use crate::common::glb;
use crate::common::program::{Folder, refused};
use perirobot_march::voxel::BitGrid;
use perirobot_study::input::{Overrides, Study};
use perirobot_study::world::World;

const STUDY: &str = "study.toml";

/// A cube from 0 to 1 as an ASCII STL, z up; `less` triangles are left out.
fn cube_stl(less: usize) -> String {
    let corner = |i: usize| format!("vertex {} {} {}\n", i & 1, i >> 1 & 1, i >> 2 & 1);
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).skip(less);
    let facet = |t: [usize; 3]| {
        let corners: String = t.map(corner).concat();
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    };
    format!("solid cube\n{}endsolid cube\n", triangles.map(facet).collect::<String>())
}

/// The same cube as OBJ.
fn cube_obj() -> String {
    let corners: String = (0..8).map(|i| format!("v {} {} {}\n", i & 1, i >> 1 & 1, i >> 2 & 1)).collect();
    corners + "f 1 3 4 2\nf 5 6 8 7\nf 1 2 6 5\nf 3 7 8 4\nf 1 5 7 3\nf 2 4 8 6\n"
}

/// A line of an OBJ file, a corner in millimetres.
fn in_mm(line: &str) -> String {
    let line = if line.starts_with('v') { line.replace(" 1", " 1000") } else { line.into() };
    line + "\n"
}

/// The same cube as COLLADA in centimetres.
fn cube_dae(up: &str) -> String {
    let corners: String = (0..8).map(|i| format!("{}00 {}00 {}00 ", i & 1, i >> 1 & 1, i >> 2 & 1)).collect();
    format!(
        r##"<COLLADA version="1.4.1"><asset><unit meter="0.01"/><up_axis>{up}</up_axis></asset>
        <library_geometries><geometry id="g"><mesh>
        <source id="s"><float_array id="f" count="24">{corners}</float_array>
        <technique_common><accessor source="#f" count="8" stride="3"/></technique_common></source>
        <vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
        <polylist count="6"><input semantic="VERTEX" source="#v" offset="0"/><vcount>4 4 4 4 4 4</vcount>
        <p>0 2 3 1 4 5 7 6 0 1 5 4 2 6 7 3 0 4 6 2 1 3 7 5</p></polylist></mesh></geometry></library_geometries>
        <library_visual_scenes><visual_scene id="c"><node><instance_geometry url="#g"/></node></visual_scene>
        </library_visual_scenes><scene><instance_visual_scene url="#c"/></scene></COLLADA>"##
    )
}

/// The regions of the usual study with these put before its sensors, over the grid.
fn regions(folder: &Folder, more: &str) -> Vec<(String, BitGrid)> {
    folder.edit(STUDY, "[[sensor]]", &format!("{more}\n[[sensor]]"));
    let study = Study::load(&folder.path(STUDY), &Overrides::default()).unwrap();
    let world = World::prepare(&study, 0).unwrap().remove(0);
    let window = world.grid.window();
    world.regions.iter().map(|region| (region.name.clone(), region.voxels.to_window(window))).collect()
}

fn named<'r>(regions: &'r [(String, BitGrid)], name: &str) -> &'r BitGrid {
    &regions.iter().find(|(other, _)| other == name).unwrap().1
}

#[test]
fn regions_are_made_of_those_above_them() {
    let more = r#"
        [[region]]
        name = "either"
        union = ["robot", "human"]
        [[region]]
        name = "rest"
        difference = ["either", "human", "box"]
        [[region]]
        name = "upper"
        half_sphere = { center_m = [0.2, 0.3, 0.4], radius_m = 0.6 }
        [[region]]
        name = "lower"
        half_sphere = { center_m = [0.2, 0.3, 0.4], radius_m = 0.6, normal = [0, 0, -2.5] }
        [[region]]
        name = "halves"
        union = ["upper", "lower"]"#;
    let regions = regions(&Folder::new(), more);
    let get = |name| named(&regions, name).clone();
    let mut either = get("robot");
    either.add(&get("human"));
    assert_eq!(get("either"), either);
    let mut rest = get("robot");
    rest.remove(&get("human"));
    rest.remove(&get("box"));
    assert_eq!(get("rest"), rest);
    assert!(!rest.is_empty() && get("upper").count() < get("robot").count());
    assert_eq!(get("halves"), get("robot"));
}

#[test]
fn a_mesh_in_a_file_is_turned_moved_and_scaled() {
    let folder = Folder::new();
    folder.write("zone.stl", cube_stl(0));
    folder.write("zone_mm.stl", cube_stl(0).replace(" 1", " 1000"));
    folder.write("zone.obj", cube_obj());
    folder.write("zone_mm.obj", cube_obj().lines().map(in_mm).collect::<String>());
    for (name, up) in [("zone_x.dae", "X_UP"), ("zone_y.dae", "Y_UP"), ("zone_z.dae", "Z_UP")] {
        folder.write(name, cube_dae(up));
    }
    folder.write("zone.glb", glb::bytes(&glb::part("zone", [0.0; 3], [1.0; 3])));
    // The cube spans −0.5 … 0.5 on x and y, 0.1 … 1.1 on z, as the region "box" does.
    let meshes = [
        ("zone.stl", "", [-0.5, -0.5]),
        ("zone_mm.stl", "unit = \"mm\"", [-0.5, -0.5]),
        ("zone.stl", "rpy_deg = [0, 0, 90]", [0.5, -0.5]),
        ("zone.stl", "up = \"y\"", [-0.5, 0.5]),
        ("zone.obj", "", [-0.5, -0.5]),
        ("zone_mm.obj", "unit = \"mm\"\nup = \"y\"", [-0.5, 0.5]),
        ("zone_z.dae", "", [-0.5, -0.5]),
        ("zone_y.dae", "", [-0.5, 0.5]),
        ("zone_x.dae", "", [0.5, 0.5]),
        ("zone.glb", "", [-0.5, -0.5]),
    ];
    let region = |(number, (mesh, keys, [x, y])): (usize, &(&str, &str, [f64; 2]))| {
        format!("[[region]]\nname = \"{number}\"\nmesh = {mesh:?}\nposition_m = [{x}, {y}, 0.1]\n{keys}\n")
    };
    let regions = regions(&folder, &meshes.iter().enumerate().map(region).collect::<String>());
    for (number, mesh) in meshes.iter().enumerate() {
        assert_eq!(named(&regions, &number.to_string()), named(&regions, "box"), "{mesh:?}");
    }
}

/// A region in place of the study's sphere must be refused in words that hold all of `expected`.
#[track_caller]
fn wrong(shape: &str, expected: &[&str]) {
    let folder = Folder::new();
    folder.write("open.stl", cube_stl(1));
    folder.write("zone.stl", cube_stl(0));
    let sphere = "sphere = { center_m = [0.2, 0.3, 0.4], radius_m = 0.6 }";
    refused(&folder, &[(STUDY, sphere, shape)], &[&[STUDY, "region \"robot\""], expected].concat());
}

#[test]
fn shapes_that_cannot_be() {
    let half = |rest: &str| format!("half_sphere = {{ center_m = [0, 0, 0.5], {rest} }}");
    wrong(&half("radius_m = -1"), &["half_sphere.radius_m = -1: must be a length above 0"]);
    wrong(
        &half("radius_m = 1, normal = [0, 0, 0]"),
        &["half_sphere.normal = [0.0, 0.0, 0.0]: must not be zero"],
    );
    wrong(&half("radius_m = 900"), &["radius_m = 900: at most 2047 voxels"]);
    wrong(
        "robot_reach = { tool_m = -0.1 }",
        &["robot_reach.tool_m = -0.1: must be a length in metres from 0"],
    );
    wrong(
        "robot_reach = { planes = [{ point_m = [0, 0, 0], normal = [0, 0, 0] }] }",
        &["robot_reach.planes[0].normal = [0.0, 0.0, 0.0]: must not be zero"],
    );
    wrong(
        "robot_reach = {}",
        &["scene \"cell\"", "robot_reach: no robot has a known reach: give the robot as a urdf"],
    );
    wrong(
        "robot_reach = { object = \"crate\" }",
        &["robot_reach.object = \"crate\": the scene's robots are [\"arm\"]"],
    );
    wrong("union = [\"robot\"]", &["union = [\"robot\"]: must name two regions or more"]);
    wrong(
        "union = []\nbox = { min_m = [0, 0, 0], max_m = [1, 1, 1] }",
        &["both box and union: give one shape"],
    );
    // Neither itself nor one below it.
    wrong(
        "union = [\"robot\", \"box\"]",
        &["union[0] = \"robot\": must be a region that stands above", "file: []"],
    );
    wrong(
        "unit = \"mm\"\nsphere = { center_m = [0, 0, 1], radius_m = 1 }",
        &["unit and up belong to a mesh"],
    );
    wrong(
        "rpy_deg = [0, 0, 1]\nsphere = { center_m = [0, 0, 1], radius_m = 1 }",
        &["rpy_deg belong to a mesh"],
    );
    wrong(
        "position_m = [0, 0, 1]\nsphere = { center_m = [0, 0, 1], radius_m = 1 }",
        &["position_m and rpy_deg"],
    );
}

#[test]
fn meshes_that_cannot_be_regions() {
    wrong("mesh = \"gone.stl\"", &[".mesh = ", "gone.stl: cannot be read"]);
    wrong(
        "mesh = \"zone.ply\"",
        &["mesh = \"zone.ply\": must be a .glb, .gltf, .stl, .obj, .dae or .step file"],
    );
    wrong("mesh = \"zone.dae\"\nup = \"y\"", &["unit and up do not belong to a .dae mesh"]);
    wrong(
        "mesh = \"open.stl\"",
        &["mesh: is not watertight (an edge has only one side)", "mend its surface"],
    );
    wrong("mesh = \"zone.stl\"\nposition_m = [0, 0, nan]", &["position_m = [0.0, 0.0, NaN]"]);
    wrong("mesh = \"zone.stl\"\nposition_m = [0, 0, 900000]", &["mesh: has a corner at", "millimetres"]);
    wrong("mesh = \"zone.stl\"\nposition_m = [0, 0, 900]", &["lies outside the grid"]);
}

#[test]
fn names_of_other_regions() {
    let after = |shape: &str, expected: &[&str]| {
        let entry = format!("[[region]]\nname = \"new\"\n{shape}\n[[sensor]]");
        refused(
            &Folder::new(),
            &[(STUDY, "[[sensor]]", &entry)],
            &[&[STUDY, "region \"new\""], expected].concat(),
        );
    };
    after(
        "difference = [\"robot\", \"gone\"]",
        &["difference[1] = \"gone\"", "[\"robot\", \"box\", \"human\"]"],
    );
    after(
        "difference = [\"robot\", \"box\", \"robot\"]",
        &["difference: the others leave nothing of the first"],
    );
    let chain: String = (0..12)
        .map(|i| {
            let last = if i == 0 { "robot".into() } else { format!("r{}", i - 1) };
            format!("[[region]]\nname = \"r{i}\"\nunion = [\"{last}\", \"{last}\"]\n")
        })
        .collect();
    refused(
        &Folder::new(),
        &[(STUDY, "[[sensor]]", &format!("{chain}[[sensor]]"))],
        &[STUDY, "region \"r9\"", "is made of 1024 shapes"],
    );
}
