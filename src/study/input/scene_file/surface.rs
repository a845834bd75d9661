//! The surface of an object: a solid by its size, or a file.

use std::path::Path;

use glam::DVec3;

use super::person::PersonKeys;
use super::{BallFile, CapsuleFile, CylinderFile, ObjectFile, PlaneFile, SizeFile};
use crate::diagnostics::{Place, only_one};
use crate::input::urdf::UrdfFile;
use crate::keys::{Unit, UpFile};
use perirobot_march::Result;
use perirobot_scene::objects::Up;
use perirobot_scene::objects::mesh_file::{ENDINGS, MeshFile, MeshFormat};
use perirobot_scene::objects::sdf::SdfFile;
use perirobot_scene::objects::spec::{PersonFile, SurfaceSpec, UrdfSpec};
use perirobot_scene::source::{accepted_formats, is_other_format};

/// The surface that one of the keys of an object gives.
pub(super) fn surface(at: &Place, entry: &ObjectFile, person: &PersonKeys) -> Result<SurfaceSpec> {
    // A person who moves may have a file for each snapshot instead of one for all.
    let moving = entry.snapshots.as_ref().and_then(|s| s.mannequin.as_ref()?.first());
    let joints = entry.mannequin.as_ref().or(moving);
    let triangles = |path| mesh(at, at.folder(), path, entry.unit, entry.up).map(SurfaceSpec::Mesh);
    let choices = vec![
        ("box", entry.r#box.as_ref().map(|file| cuboid(at, file))),
        ("room", entry.room.as_ref().map(|file| room(at, file))),
        ("plane", entry.plane.as_ref().map(|file| plane(at, file))),
        ("sphere", entry.sphere.as_ref().map(|file| sphere(at, file))),
        ("cylinder", entry.cylinder.as_ref().map(|file| cylinder(at, file))),
        ("capsule", entry.capsule.as_ref().map(|file| capsule(at, file))),
        ("mesh", entry.mesh.as_deref().map(triangles)),
        ("octomap", entry.octomap.as_deref().map(|path| octomap(at, path))),
        ("mannequin", joints.map(|path| person.check(at, "mannequin", path).map(SurfaceSpec::Mannequin))),
        ("sdf", sdf(at, entry)?.map(|world| Ok(SurfaceSpec::Sdf(world)))),
        ("urdf", urdf(at, entry, at.folder())?.map(|robot| Ok(SurfaceSpec::Urdf(robot)))),
    ];
    only_one(at, "surface", choices)?
}

/// A length of a solid.
fn length(at: &Place, key: &str, value: f64) -> Result<f64> {
    at.number(key, value, 1e-6..1e6, "a length in metres from 0.000001 to 1000000")
}

fn size(at: &Place, key: &str, file: &SizeFile) -> Result<DVec3> {
    file.size_m.iter().try_for_each(|&edge| length(at, key, edge).map(drop))?;
    Ok(DVec3::from_array(file.size_m))
}

fn cuboid(at: &Place, file: &SizeFile) -> Result<SurfaceSpec> {
    Ok(SurfaceSpec::Box { size_m: size(at, "box.size_m", file)? })
}

fn room(at: &Place, file: &SizeFile) -> Result<SurfaceSpec> {
    Ok(SurfaceSpec::Room { size_m: size(at, "room.size_m", file)? })
}

fn plane(at: &Place, file: &PlaneFile) -> Result<SurfaceSpec> {
    file.size_m.iter().try_for_each(|&edge| length(at, "plane.size_m", edge).map(drop))?;
    Ok(SurfaceSpec::Plane { size_m: file.size_m })
}

fn sphere(at: &Place, file: &BallFile) -> Result<SurfaceSpec> {
    Ok(SurfaceSpec::Sphere { radius_m: length(at, "sphere.radius_m", file.radius_m)? })
}

fn cylinder(at: &Place, file: &CylinderFile) -> Result<SurfaceSpec> {
    let radius_m = length(at, "cylinder.radius_m", file.radius_m)?;
    Ok(SurfaceSpec::Cylinder { radius_m, height_m: length(at, "cylinder.height_m", file.height_m)? })
}

fn capsule(at: &Place, file: &CapsuleFile) -> Result<SurfaceSpec> {
    let radius_m = length(at, "capsule.radius_m", file.radius_m)?;
    Ok(SurfaceSpec::Capsule { radius_m, length_m: length(at, "capsule.length_m", file.length_m)? })
}

fn octomap(at: &Place, path: &Path) -> Result<SurfaceSpec> {
    match is_other_format(path, &["bt", "ot"]) {
        true => {
            let rule = accepted_formats(path, "a .bt or .ot file").to_string();
            Err(at.wrong("octomap", format!("{path:?}"), &rule))
        }
        false => Ok(SurfaceSpec::Octomap(at.folder().join(path))),
    }
}

fn sdf(at: &Place, entry: &ObjectFile) -> Result<Option<SdfFile>> {
    if entry.sdf.is_none() && entry.models.is_some() {
        return Err(at.says("models belong to an sdf").with_advice("give one, or take them away"));
    }
    let world = entry.sdf.as_ref().map(|path| SdfFile {
        path: at.folder().join(path),
        geometry: entry.geometry.unwrap_or_default(),
        models: entry.models.iter().flatten().map(|models| at.folder().join(models)).collect(),
    });
    Ok(world)
}

fn urdf(at: &Place, entry: &ObjectFile, folder: &Path) -> Result<Option<UrdfSpec>> {
    let keys = UrdfFile {
        urdf: entry.urdf.as_ref(),
        geometry: entry.geometry.filter(|_| entry.sdf.is_none()),
        packages: entry.packages.as_ref(),
        joints_deg: entry.joints_deg.as_ref(),
        joints_m: entry.joints_m.as_ref(),
        xacro_args: entry.xacro_args.as_ref(),
    };
    keys.check(at, folder).transpose()
}

/// Refuses keys that do not belong to an object's surface: unit, up and nodes.
pub(super) fn refuse_strange_keys(at: &Place, entry: &ObjectFile, surface: &SurfaceSpec) -> Result<()> {
    let file = match surface {
        SurfaceSpec::Mesh(file) => Some(file),
        _ => None,
    };
    if !matches!(surface, SurfaceSpec::Mannequin(PersonFile::Motion(_))) {
        unit_and_up_belong(at, file, entry.unit, entry.up)?;
    }
    let has_nodes = surface.gltf().is_some() || matches!(surface, SurfaceSpec::Sdf(_));
    if !has_nodes && !entry.nodes.is_empty() {
        return Err(at.says("nodes belong to a .glb, .gltf or .step mesh or to an sdf"));
    }
    let has_layers = file.is_some_and(|file| file.format == MeshFormat::Step);
    for (index, rule) in entry.nodes.iter().enumerate() {
        let at = at.key(&format!("nodes[{index}]"));
        match (&rule.r#match, &rule.layer) {
            (_, Some(layer)) if !has_layers => {
                let what =
                    "does not belong here: only a .step mesh has layers, use match, which selects by names";
                return Err(at.wrong("layer", format!("{layer:?}"), what));
            }
            (None, None) => {
                return Err(at.says("has neither match nor layer").with_advice("match = \"*\" selects all"));
            }
            _ => {}
        }
    }
    Ok(())
}

/// Refuses `unit` and `up` where a file says them itself, and where there is no file.
pub(crate) fn unit_and_up_belong(
    at: &Place,
    file: Option<&MeshFile>,
    unit: Option<Unit>,
    up: Option<UpFile>,
) -> Result<()> {
    match file.map(|file| file.format) {
        _ if unit.is_none() && up.is_none() => Ok(()),
        Some(MeshFormat::Stl | MeshFormat::Obj | MeshFormat::Gltf) => Ok(()),
        Some(MeshFormat::Step) if unit.is_none() => Ok(()),
        Some(MeshFormat::Step) => Err(at
            .says("unit does not belong to a STEP mesh")
            .with_advice("the file contains its unit, and is converted to metres: take unit away")),
        Some(MeshFormat::Collada) => Err(at.says("unit and up do not belong to a .dae mesh").with_advice(
            "COLLADA says both itself and is turned to z up; if it was exported lying, \
                turn it with rpy_deg",
        )),
        None => Err(at
            .says("unit and up belong to a mesh")
            .with_advice("all other lengths are metres, and z is up")),
    }
}

/// The file of a mesh; whether `unit` and `up` belong to it is the caller's to check.
pub(crate) fn mesh(
    at: &Place,
    folder: &Path,
    path: &Path,
    unit: Option<Unit>,
    up: Option<UpFile>,
) -> Result<MeshFile> {
    let scale = unit.map_or(1.0, |Unit(metres)| metres);
    if let Some(format) = MeshFormat::from_path(path) {
        let up = match up {
            Some(UpFile::Y) => Up::Y,
            Some(UpFile::Z) => Up::Z,
            None if format == MeshFormat::Gltf => Up::Y,
            None => Up::Z,
        };
        return Ok(MeshFile { path: folder.join(path), format, scale, up });
    }
    Err(at.wrong("mesh", format!("{path:?}"), &accepted_formats(path, ENDINGS).to_string()))
}
