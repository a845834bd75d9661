//! A scene file, as TOML: the objects of a cell with their roles, poses and surfaces, checked and turned into
//! `scene::spec`.

pub(super) mod person;
mod snapshots;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};
use serde::Deserialize;

use super::urdf::UrdfFile;
use crate::diagnostics::{
    self, Place, Problems, only_one, parse_in_parts, refuse_folder, top_keys, wrong_with,
};
use crate::keys::{Quaternion, Unit, UpFile, exactly, exactly_if_given};
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_scene::pose::{Frame, Pose, from_rpy};
use perirobot_scene::scene::keypoints::Layout;
use perirobot_scene::scene::mesh_file::{ENDINGS, MeshFile, MeshFormat};
use perirobot_scene::scene::sdf::SdfFile;
use perirobot_scene::scene::spec::{NodeRule, ObjectSpec, PersonFile, SceneSpec, SurfaceSpec, UrdfSpec};
use perirobot_scene::scene::urdf::Geometry;
use perirobot_scene::scene::{Interior, Optical, Role, Up};
use perirobot_scene::source::{Sources, accepted_formats, is_other_format};
use person::PersonKeys;
use snapshots::SnapshotsFile;

/// A cell: the objects in it.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct SceneFile {
    /// What the inside of its objects is, unless an object has its own `interior`. Default "ignored".
    interior: Option<Interior>,
    /// At least one.
    #[serde(default)]
    object: Vec<ObjectFile>,
}

/// An object: a name, where it is, and one surface (box, room, plane, sphere, cylinder, capsule, mesh, octomap, mannequin, urdf or sdf).
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct ObjectFile {
    /// Unique in the scene.
    name: String,
    /// Default: "human" for a mannequin, "robot" for a urdf, else "environment".
    role: Option<Role>,
    /// What its inside is. Default: the `interior` of the scene.
    interior: Option<Interior>,
    /// Whether rays stop at it. Default "opaque".
    optical: Option<Optical>,
    /// Gives its role to voxels that other objects fill, and fills none itself. Default false.
    #[serde(default)]
    tag_only: bool,
    /// Where its own frame is, [x, y, z] in metres; bodies are centred on it. Default the origin.
    #[serde(default, deserialize_with = "exactly")]
    position_m: [f64; 3],
    /// How it is turned: roll, pitch, yaw in degrees.
    #[serde(default, deserialize_with = "exactly_if_given")]
    rpy_deg: Option<[f64; 3]>,
    /// How it is turned, instead of rpy_deg.
    quaternion: Option<Quaternion>,
    /// The unit of a file's numbers: "m", "cm", "mm", "in", or how many metres it is. Default "m", which glTF
    /// prescribes, but not every exporter keeps to; a .dae file states its own, and a .bvh file needs one.
    unit: Option<Unit>,
    /// The axis that points up in an .stl or .obj file (default "z"), in a .bvh file (default "y"), or in a glTF that is
    /// z up against the rules of the format (default "y").
    up: Option<UpFile>,
    /// A solid box.
    r#box: Option<SizeFile>,
    /// Six walls seen from inside.
    room: Option<SizeFile>,
    /// A rectangle in its xy plane.
    plane: Option<PlaneFile>,
    /// A ball.
    sphere: Option<BallFile>,
    /// A cylinder about z.
    cylinder: Option<CylinderFile>,
    /// A cylinder about z with round ends.
    capsule: Option<CapsuleFile>,
    /// A .glb, .gltf, .stl, .obj or .dae file.
    mesh: Option<PathBuf>,
    /// An OctoMap .bt or .ot file.
    octomap: Option<PathBuf>,
    /// A body around the joints of a person: a CSV file of them in the order of `layout`, or motion capture (.bvh).
    mannequin: Option<PathBuf>,
    /// The joints of a person that is not made by mannequin, as a CSV file.
    keypoints: Option<PathBuf>,
    /// Which joints the CSV files of a person have, in which order. Default "coco-17".
    layout: Option<Layout>,
    /// Which bone of a .bvh file begins at which joint, where its name is not a usual one: left_wrist = "LHand". The
    /// names of COCO's joints, and head for the base of the skull; with "" a joint is unknown.
    bones: Option<BTreeMap<String, String>>,
    /// A robot: a URDF, or a xacro, which the user's program of that name expands if it is allowed to.
    urdf: Option<PathBuf>,
    /// Arguments of a xacro by their names: ur_type = "ur10e".
    xacro_args: Option<BTreeMap<String, String>>,
    /// A world or a model of Gazebo (.sdf, .world).
    sdf: Option<PathBuf>,
    /// The folders in which model://NAME of an sdf is looked for.
    models: Option<Vec<PathBuf>>,
    /// Which geometry of a urdf or an sdf counts. Default "collision".
    geometry: Option<Geometry>,
    /// Where package://NAME of a urdf is: NAME = "folder".
    packages: Option<BTreeMap<String, PathBuf>>,
    /// Angles of a robot's joints by their names, in degrees.
    joints_deg: Option<BTreeMap<String, f64>>,
    /// Travels of a robot's sliding joints by their names, in metres.
    joints_m: Option<BTreeMap<String, f64>>,
    /// Rules for parts of a .glb or .gltf file, or for models and links of an sdf.
    #[serde(default)]
    nodes: Vec<NodeRule>,
    /// What changes from one snapshot to the next.
    snapshots: Option<SnapshotsFile>,
}

/// Edges.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct SizeFile {
    /// [x, y, z] in metres.
    #[serde(deserialize_with = "exactly")]
    size_m: [f64; 3],
}

/// A rectangle.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct PlaneFile {
    /// [x, y] in metres.
    #[serde(deserialize_with = "exactly")]
    size_m: [f64; 2],
}

/// A ball.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct BallFile {
    /// In metres.
    radius_m: f64,
}

/// A cylinder.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct CylinderFile {
    /// In metres.
    radius_m: f64,
    /// In metres.
    height_m: f64,
}

/// A cylinder with round ends.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct CapsuleFile {
    /// In metres.
    radius_m: f64,
    /// Between the centres of its ends, in metres.
    length_m: f64,
}

/// Reads and checks a scene file; the meshes it names are read later.
pub fn load_scene(path: &Path, sources: &Sources) -> Result<SceneSpec> {
    refuse_folder(path, "a scene file")?;
    parse_scene(path, sources.text(path)?).map_err(Error::first)
}

/// Checks the text of a scene file, every object of it.
pub(super) fn parse_scene(path: &Path, text: String) -> Result<SceneSpec, Vec<Error>> {
    refuse_study(path, &text).map_err(|e| vec![e])?;
    let mut problems = Problems::default();
    let lists = [("object", wrong_with::<ObjectFile> as _)];
    let file: Option<SceneFile> = parse_in_parts(path, &text, &lists, &mut problems);
    let at = Place::new(path);
    let (mut objects, mut interior) = (Vec::new(), Interior::Ignored);
    if let Some(file) = file {
        if problems.is_empty() {
            problems.keep(at.some("object", &file.object, "[[object]] name = \"table\""));
        }
        interior = file.interior.unwrap_or(interior);
        let checked = file.object.into_iter().map(|entry| object(&at, entry, interior));
        objects = checked.filter_map(|object| problems.keep(object)).collect();
        problems.keep(at.unique("object", objects.iter().map(|o| o.name.as_str())));
    }
    problems.none()?;
    let name = path.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned());
    let snapshots = snapshots::count(&at, &mut objects).map_err(|e| vec![e])?;
    let dwell_s = snapshots::dwell_s(&at, &objects, snapshots).map_err(|e| vec![e])?;
    let warnings = diagnostics::warnings(&text);
    Ok(SceneSpec {
        path: path.into(),
        text,
        name,
        interior,
        snapshots,
        dwell_s,
        variant: None,
        objects,
        warnings,
    })
}

/// Refuses what is a study by its keys.
fn refuse_study(path: &Path, text: &str) -> Result<()> {
    let keys = top_keys(text);
    match ["scene", "region", "sensor"].iter().any(|key| keys.contains_key(*key))
        && !keys.contains_key("object")
    {
        true => Err(Error::input(path, "this looks like a study")
            .wanted("name a scene file that it lists, with [[object]]")),
        false => Ok(()),
    }
}

fn object(at: &Place, entry: ObjectFile, default_interior: Interior) -> Result<ObjectSpec> {
    let at = &at.key(&format!("object {:?}", entry.name));
    let length = |key: &str, value: f64| {
        at.number(key, value, 1e-6..1e6, "a length in metres from 0.000001 to 1000000")
    };
    let folder = at.folder();
    let size = |key: &str, value: &Option<SizeFile>| {
        let size = value.as_ref().map(|s| s.size_m);
        size.map(|s| {
            s.iter().try_for_each(|&edge| length(key, edge).map(drop)).map(|()| DVec3::from_array(s))
        })
    };
    let cuboid = size("box.size_m", &entry.r#box).map(|s| Ok(SurfaceSpec::Box { size_m: s? }));
    let room = size("room.size_m", &entry.room).map(|s| Ok(SurfaceSpec::Room { size_m: s? }));
    let plane = entry.plane.as_ref().map(|p| {
        p.size_m.iter().try_for_each(|&edge| length("plane.size_m", edge).map(drop))?;
        Ok(SurfaceSpec::Plane { size_m: p.size_m })
    });
    let sphere = entry
        .sphere
        .as_ref()
        .map(|s| Ok(SurfaceSpec::Sphere { radius_m: length("sphere.radius_m", s.radius_m)? }));
    let cylinder = entry.cylinder.as_ref().map(|c| {
        let radius_m = length("cylinder.radius_m", c.radius_m)?;
        Ok(SurfaceSpec::Cylinder { radius_m, height_m: length("cylinder.height_m", c.height_m)? })
    });
    let capsule = entry.capsule.as_ref().map(|c| {
        let radius_m = length("capsule.radius_m", c.radius_m)?;
        Ok(SurfaceSpec::Capsule { radius_m, length_m: length("capsule.length_m", c.length_m)? })
    });
    let octomap = entry.octomap.as_ref().map(|path| match is_other_format(path, &["bt", "ot"]) {
        true => {
            let rule = accepted_formats(path, "a .bt or .ot file").to_string();
            Err(at.wrong("octomap", format!("{path:?}"), &rule))
        }
        false => Ok(SurfaceSpec::Octomap(folder.join(path))),
    });
    let person =
        PersonKeys { layout: entry.layout, unit: entry.unit, up: entry.up, bones: entry.bones.as_ref() };
    // A person who moves may have a file for each snapshot instead of one for all.
    let moving = entry.snapshots.as_ref().and_then(|s| s.mannequin.as_ref()?.first());
    let mannequin = entry.mannequin.as_ref().or(moving);
    let mannequin = mannequin.map(|path| person.check(at, "mannequin", path).map(SurfaceSpec::Mannequin));
    let choices = vec![
        ("box", cuboid),
        ("room", room),
        ("plane", plane),
        ("sphere", sphere),
        ("cylinder", cylinder),
        ("capsule", capsule),
        (
            "mesh",
            entry
                .mesh
                .as_ref()
                .map(|path| mesh(at, folder, path, entry.unit, entry.up).map(SurfaceSpec::Mesh)),
        ),
        ("octomap", octomap),
        ("mannequin", mannequin),
        ("sdf", sdf(at, &entry)?.map(|world| Ok(SurfaceSpec::Sdf(world)))),
        ("urdf", urdf(at, &entry, folder)?.map(|robot| Ok(SurfaceSpec::Urdf(robot)))),
    ];
    let surface = only_one(at, "surface", choices)??;

    let file = match &surface {
        SurfaceSpec::Mesh(file) => Some(file),
        _ => None,
    };
    if !matches!(surface, SurfaceSpec::Mannequin(PersonFile::Motion(_))) {
        unit_and_up_belong(at, file, entry.unit, entry.up)?;
    }
    let has_nodes = surface.gltf().is_some() || matches!(surface, SurfaceSpec::Sdf(_));
    if !has_nodes && !entry.nodes.is_empty() {
        return Err(at.says("nodes belong to a .glb or .gltf mesh or to an sdf"));
    }
    let rotation = rotation(at, "", entry.rpy_deg, entry.quaternion)?;
    let position_m = at.vector("position_m", entry.position_m)?;
    if matches!(surface, SurfaceSpec::Octomap(_))
        && (position_m != DVec3::ZERO || rotation != DQuat::IDENTITY)
    {
        return Err(at
            .says("an octomap stays where it is")
            .wanted("its voxels are the grid's; take its pose away"));
    }
    // The cell is inside the room, so a room has no interior of its own.
    let interior = match (&surface, entry.interior) {
        (SurfaceSpec::Room { .. }, Some(_)) => {
            return Err(at.says("interior does not belong to a room").wanted("it is the cell"));
        }
        (SurfaceSpec::Room { .. }, None) => Interior::Free,
        // A map mostly shows a whole cell: its closed walls are no body either, unless `interior` says so.
        (SurfaceSpec::Octomap(_), None) => Interior::Free,
        (_, interior) => interior.unwrap_or(default_interior),
    };
    let default_role = match surface {
        SurfaceSpec::Mannequin(_) => Role::Human,
        SurfaceSpec::Urdf(_) => Role::Robot,
        _ => Role::Environment,
    };
    let role = entry.role.unwrap_or(default_role);
    let moving = entry.snapshots.as_ref().is_some_and(|snapshots| snapshots.keypoints.is_some());
    let has_keypoints = moving || entry.keypoints.is_some();
    if has_keypoints && matches!(surface, SurfaceSpec::Mannequin(_)) {
        return Err(at.around(Issue::says("a mannequin's are its own; take them away").at("keypoints")));
    }
    person.belong(at, &surface, has_keypoints)?;
    let human = role == Role::Human || entry.nodes.iter().any(|rule| rule.role == Some(Role::Human));
    if has_keypoints && !human {
        return Err(at.says("keypoints are a human's joints").wanted("add role = \"human\""));
    }
    let keypoints = entry.keypoints.map(|path| person.joints(at, "keypoints", &path)).transpose()?;
    let motion =
        entry.snapshots.map(|snapshots| snapshots::check(at, snapshots, &surface, &person)).transpose()?;
    Ok(ObjectSpec {
        role,
        interior,
        optical: entry.optical.unwrap_or(Optical::Opaque),
        tag_only: entry.tag_only,
        position_m,
        rotation,
        surface,
        keypoints,
        nodes: entry.nodes,
        animated: None,
        motion: motion.unwrap_or_default(),
        name: entry.name,
    })
}

fn sdf(at: &Place, entry: &ObjectFile) -> Result<Option<SdfFile>> {
    if entry.sdf.is_none() && entry.models.is_some() {
        return Err(at.says("models belong to an sdf").wanted("give one, or take them away"));
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

/// Refuses `unit` and `up` where a file says them itself, and where there is no file.
pub(super) fn unit_and_up_belong(
    at: &Place,
    file: Option<&MeshFile>,
    unit: Option<Unit>,
    up: Option<UpFile>,
) -> Result<()> {
    match file.map(|file| file.format) {
        _ if unit.is_none() && up.is_none() => Ok(()),
        Some(MeshFormat::Stl | MeshFormat::Obj | MeshFormat::Gltf) => Ok(()),
        Some(MeshFormat::Collada) => Err(at.says("unit and up do not belong to a .dae mesh").wanted(
            "COLLADA says both itself and is turned to z up; if it was exported lying, \
                turn it with rpy_deg",
        )),
        None => {
            Err(at.says("unit and up belong to a mesh").wanted("all other lengths are metres, and z is up"))
        }
    }
}

/// The file of a mesh; whether `unit` and `up` belong to it is the caller's to check.
pub(super) fn mesh(
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

/// One rotation, none where neither is given; `index` is its place in a list.
fn rotation(
    at: &Place,
    index: &str,
    rpy_deg: Option<[f64; 3]>,
    quaternion: Option<Quaternion>,
) -> Result<DQuat> {
    match (rpy_deg, quaternion) {
        (None, None) => Ok(DQuat::IDENTITY),
        (Some(rpy), None) => {
            let rpy = at.vector(&format!("rpy_deg{index}"), rpy)?.to_array().map(f64::to_radians);
            Ok(Pose::turned(DVec3::ZERO, from_rpy(rpy), Frame::Link).rotation)
        }
        (None, Some(q)) => {
            let wxyz = [q.w, q.x, q.y, q.z];
            let pose = Pose::from_quaternion(DVec3::ZERO, wxyz, Frame::Link);
            let pose = pose.map_err(|rule| at.wrong(&format!("quaternion{index}"), q, &rule.to_string()))?;
            Ok(pose.rotation)
        }
        (Some(_), Some(_)) => Err(at.says("both rpy_deg and quaternion").wanted("give one rotation")),
    }
}
