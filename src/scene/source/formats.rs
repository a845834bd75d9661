//! Formats that are not read, and the program that turns a file of one into a file that is.

use std::path::Path;

use perirobot_march::error::Words;

/// The formats by their endings: what converts them. `{file}` stands for the file, `{stem}` for its name without the ending.
const CONVERTERS: [(&[&str], &str); 29] = [
    (
        &["step", "stp", "p21"],
        "STEP holds curved surfaces and no triangles: `pip install cascadio numpy`, then `python -c \"import cascadio; \
         cascadio.step_to_glb('{file}', '{stem}.glb', 1.0)\"`, which leaves z up: add up = \"z\"; or FreeCAD (File > Export)",
    ),
    (
        &["iges", "igs"],
        "IGES holds curved surfaces and no triangles: `pip install cascadio numpy`, then `python -c \"import cascadio; \
         open('{stem}.glb', 'wb').write(cascadio.load(open('{file}', 'rb').read(), 'iges', 1.0))\"`, which writes millimetres \
         and leaves z up: add unit = \"mm\" and up = \"z\"; or FreeCAD (File > Export)",
    ),
    (
        &["brep", "brp", "fcstd"],
        "it holds curved surfaces and no triangles: export a .glb or .stl in FreeCAD (File > Export); an .stl is in \
         millimetres, then add unit = \"mm\"",
    ),
    (
        &["x_t", "x_b", "sat"],
        "it holds curved surfaces and no triangles: export STEP, .glb or .stl in the CAD program; CAD programs mostly write \
         .stl in millimetres, then add unit = \"mm\"",
    ),
    (&["sldprt", "sldasm"], "only SOLIDWORKS reads it: save as .stl (then add unit = \"mm\"), or as STEP"),
    (
        &["ipt", "iam", "catpart", "catproduct", "prt", "asm", "3dm", "skp", "max", "c4d"],
        "only the program that made it reads it: export .glb, .stl, .obj or .dae there",
    ),
    (&["dwg"], "export an .stl in AutoCAD (STLOUT), or a .dxf and convert that in FreeCAD"),
    (
        &["dxf"],
        "FreeCAD opens it and exports its faces as .stl (File > Export); without a window: `pip install ezdxf`, then `python -c \
         \"import ezdxf; from ezdxf import disassemble as d; from ezdxf.addons import meshex; from ezdxf.render import \
         MeshBuilder; m = MeshBuilder(); [m.add_mesh(mesh=p.mesh) if p.mesh else m.add_face(p.entity.wcs_vertices()) for p in \
         d.to_primitives(d.recursive_decompose(ezdxf.readfile('{file}').modelspace())) if p.mesh or p.entity.dxftype() == \
         '3DFACE']; open('{stem}.stl', 'wb').write(meshex.stl_dumpb(m))\"`; lines have no surface, and solids (3DSOLID) \
         need STLOUT in AutoCAD; add the drawing's unit",
    ),
    (
        &["ifc"],
        "`IfcConvert --y-up --use-element-names {file} {stem}.glb` (IfcOpenShell); or `pip install ifcopenshell`, then \
         `python -c \"import ifcopenshell, ifcopenshell.geom as g; f = ifcopenshell.open('{file}'); s = g.settings(); \
         s.set('y-up', True); s.set('use-element-names', True); z = g.serializers.glb('{stem}.glb', s); z.setFile(f); \
         z.writeHeader(); [z.write(e) for e in g.iterate(s, f)]; z.finalize()\"`",
    ),
    (
        &["ifczip"],
        "unpack the .ifc in it, and convert that with `IfcConvert --y-up --use-element-names` (IfcOpenShell)",
    ),
    (
        &["3mf"],
        "`pip install trimesh networkx lxml`, then `python -c \"import trimesh; trimesh.load('{file}').export('{stem}.glb')\"`, \
         which mostly leaves millimetres and z up: add unit = \"mm\" and up = \"z\"; or FreeCAD or a slicer, which exports .stl",
    ),
    (&["amf"], "open it in FreeCAD or in a slicer and export .stl; then add unit = \"mm\""),
    (
        &["usd", "usda", "usdc", "usdz"],
        "Blender imports it (File > Import > Universal Scene Description) and exports .glb",
    ),
    (&["fbx"], "`FBX2glTF --binary {file}`, or Blender (File > Import > FBX), which exports .glb"),
    (&["blend"], "Blender exports it as .glb (File > Export > glTF 2.0)"),
    (
        &["wrl", "vrml", "x3d", "off", "3ds", "lwo", "ac", "vtk", "vtp"],
        "MeshLab or Blender imports it and exports .stl or .glb",
    ),
    (
        &["las", "laz"],
        "`pdal translate {file} {stem}.ply` (PDAL), or CloudCompare; points have no surface, a sensor of kind = \"recorded\" reads \
         them",
    ),
    (
        &["e57"],
        "`pdal translate {file} {stem}.ply` (PDAL with its E57 plugin), or CloudCompare, for each scan by itself: rays begin \
         where the scanner was; points have no surface, a sensor of kind = \"recorded\" reads them",
    ),
    (
        &["xyz", "pts", "ptx", "asc", "txt", "fls", "rcp", "zfs"],
        "CloudCompare opens it and saves .ply or .pcd; points have no surface, a sensor of kind = \"recorded\" reads them",
    ),
    (
        &["bag"],
        "`mcap convert {file} {stem}.mcap` (the mcap command line tool); points have no surface, a sensor of kind = \"recorded\" reads \
         them",
    ),
    (
        &["db3", "sqlite3"],
        "`mcap convert {file} {stem}.mcap` (the mcap command line tool), or `ros2 bag convert` with storage_id: mcap; \
         points have no surface, a sensor of kind = \"recorded\" reads them",
    ),
    (
        &["ply"],
        "Blender or MeshLab imports its faces and exports .glb or .stl; a cloud of points is read by a sensor of kind = \"recorded\"",
    ),
    (
        &["pcd", "mcap", "npz"],
        "points have no surface: a sensor of kind = \"recorded\" reads them, and octomap_server (ROS) makes an OctoMap of them",
    ),
    (&["bt", "ot"], "an OctoMap is not a mesh: write octomap = instead"),
    (&["glb", "gltf", "stl", "obj", "dae"], "it has surfaces, which belong into a scene: write mesh = there"),
    (&["urdf", "xacro"], "it is a robot: write urdf = instead"),
    (&["sdf", "world"], "it is a world of Gazebo: write sdf = instead"),
    (&["bvh"], "it is a person's motion: write mannequin = instead"),
    (&["zip", "gz", "7z", "rar", "tar"], "unpack it first"),
];

/// The ending of a file's name in small letters; empty if it has none.
pub fn ending(path: &Path) -> String {
    path.extension().map(|ending| ending.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Whether a file is of a known format that is none of the accepted ones, by its ending.
pub fn is_other_format(path: &Path, accepted: &[&str]) -> bool {
    let ending = ending(path);
    !accepted.contains(&&*ending) && CONVERTERS.iter().any(|(known, _)| known.contains(&&*ending))
}

/// What a file must be, and what converts this one into that, if it is of a known format.
pub fn accepted_formats(path: &Path, endings: &str) -> Words {
    match converter(path) {
        Some(how) => format!("must be {endings}; a .{} file is not read: {how}", ending(path)).into(),
        None => format!("must be {endings}").into(),
    }
}

/// What converts a file of a known format into one that is read.
pub(super) fn converter(path: &Path) -> Option<String> {
    let ending = ending(path);
    let (_, how) = CONVERTERS.iter().find(|(known, _)| known.contains(&ending.as_str()))?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    // A name that a shell might take for more than a name does not come into a command.
    let is_plain = !name.starts_with('-') && name.chars().all(|c| c.is_alphanumeric() || "._-".contains(c));
    let stem = if is_plain { &*name } else { "NAME" };
    let written = path.extension().unwrap_or_default().to_string_lossy();
    Some(how.replace("{file}", &format!("{stem}.{written}")).replace("{stem}", stem))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_known_format_has_its_converter() {
        for (file, expected) in [
            ("in/a.STEP", "cascadio.step_to_glb('a.STEP', 'a.glb', 1.0)"),
            ("a.igs", "open('a.glb', 'wb').write(cascadio.load(open('a.igs', 'rb').read(), 'iges', 1.0))"),
            ("a.brep", "FreeCAD"),
            ("a.x_t", "export STEP"),
            ("a.SLDPRT", "SOLIDWORKS"),
            ("a.dxf", "ezdxf.readfile('a.dxf')"),
            ("hall.ifc", "`IfcConvert --y-up --use-element-names hall.ifc hall.glb`"),
            ("SYSTEM.ifc", "ifcopenshell.open('SYSTEM.ifc')"),
            ("PROFILE.ifc", "g.serializers.glb('PROFILE.glb', s)"),
            ("a.ifczip", "unpack"),
            ("a.3mf", "trimesh.load('a.3mf').export('a.glb')"),
            ("a.amf", "slicer"),
            ("a.usdz", "Blender"),
            ("a.fbx", "FBX2glTF --binary a.fbx"),
            ("a.las", "pdal translate a.las a.ply"),
            ("a.e57", "pdal translate a.e57 a.ply"),
            ("a.bag", "mcap convert a.bag a.mcap"),
            ("a.db3", "mcap convert a.db3 a.mcap"),
            ("a.laz", "a sensor of kind = \"recorded\" reads them"),
            ("b.bag", "a sensor of kind = \"recorded\" reads them"),
            ("a.urdf", "urdf ="),
            ("$(reboot).ifc", "--use-element-names NAME.ifc NAME.glb`"),
            ("-o.fbx", "`FBX2glTF --binary NAME.fbx`"),
        ] {
            let said = accepted_formats(Path::new(file), "a .glb file").to_string();
            assert!(said.starts_with("must be a .glb file; a .") && said.contains(expected), "{said}");
        }
        for file in ["a.doc", "a", ""] {
            assert_eq!(accepted_formats(Path::new(file), "a .glb file").to_string(), "must be a .glb file");
        }
        let mut all: Vec<&str> = CONVERTERS.iter().flat_map(|(endings, _)| endings.iter().copied()).collect();
        all.sort_unstable();
        assert!(all.windows(2).all(|pair| pair[0] != pair[1]), "{all:?}");
    }
}
