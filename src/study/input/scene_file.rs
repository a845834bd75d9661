//! A scene file, as TOML: the objects of a cell with their roles, poses and surfaces, checked and turned into
//! `objects::spec`.

mod object;
pub(super) mod person;
mod surface;
mod timeline;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};
use serde::Deserialize;

use crate::diagnostics::{self, Place, Problems, parse_in_parts, refuse_folder, top_keys, wrong_with};
use crate::keys::{QuaternionKeys, Unit, UpFile, exactly, exactly_if_given};
use perirobot_march::{Error, Result};
use perirobot_scene::objects::keypoints::JointLayout;
use perirobot_scene::objects::spec::{NodeRule, SceneSpec};
use perirobot_scene::objects::urdf::GeometryUse;
use perirobot_scene::objects::{Interior, ObjectCarrier, Optical, RadarOptics, Role, Specular};
use perirobot_scene::pose::{Pose, RotationFrame, from_rpy};
use perirobot_scene::source::Sources;
pub(super) use surface::{mesh, unit_and_up_belong};
use timeline::SnapshotsFile;

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
    /// Default: "robot" for a urdf and for what a robot carries, "human" for a mannequin, else "environment".
    role: Option<Role>,
    /// What its inside is. Default: the `interior` of the scene.
    interior: Option<Interior>,
    /// Whether rays stop at it. Default "opaque".
    optical: Option<Optical>,
    /// Whether radar stops at it: "passes" for a plastic cover, a curtain or cardboard. Default "stops".
    radar: Option<RadarOptics>,
    /// How fast it moves, in metres a second, for radars: 0 for one who stands still. Default: the speed of its walk, that by
    /// the times of its animation, that of the robot that carries it, else still; people need one where a radar looks.
    speed_m_s: Option<f64>,
    /// The share of a sensor's light that it reflects, above 0 and up to 1, for sensors with reflectance_ranges_m: 0.05 is dark
    /// cloth. Default: every sensor detects it up to its longest range; people 0.018, the black test piece of safety scanners.
    reflectance: Option<f64>,
    /// What its surface does to light: "glass", "mirror" or "retroreflector". No count depends on it; `perirobot check`
    /// warns of sensors that look at it.
    surface: Option<Specular>,
    /// Gives its role to voxels that other objects fill, and fills none itself. Default false.
    #[serde(default)]
    tag_only: bool,
    /// What carries it: a link of a robot, as a gripper, or another object, as the driver of a forklift. Its pose is then in
    /// that frame.
    on: Option<ObjectCarrier>,
    /// Where its own frame is, [x, y, z] in metres; bodies are centred on it. Default the origin.
    #[serde(default, deserialize_with = "exactly")]
    position_m: [f64; 3],
    /// How it is turned: roll, pitch, yaw in degrees.
    #[serde(default, deserialize_with = "exactly_if_given")]
    rpy_deg: Option<[f64; 3]>,
    /// How it is turned, instead of rpy_deg.
    quaternion: Option<QuaternionKeys>,
    /// The unit of a file's numbers: "m", "cm", "mm", "in", or how many metres it is. Default "m", which glTF
    /// prescribes, but not every exporter keeps to; .dae and .step files state their own, and a .bvh file needs one.
    unit: Option<Unit>,
    /// The axis that points up in an .stl, .obj or .step file (default "z"), in a .bvh file (default "y"), or in a glTF that is
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
    /// A .glb, .gltf, .stl, .obj, .dae or .step file; the package cascadio of Python converts the last
    /// if it is allowed to.
    mesh: Option<PathBuf>,
    /// An OctoMap .bt or .ot file.
    octomap: Option<PathBuf>,
    /// A body around the joints of a person: a CSV file of them in the order of `layout`, or motion capture (.bvh).
    mannequin: Option<PathBuf>,
    /// The joints of a person that is not made by mannequin, as a CSV file.
    keypoints: Option<PathBuf>,
    /// Which joints the CSV files of a person have, in which order. Default "coco-17".
    layout: Option<JointLayout>,
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
    geometry: Option<GeometryUse>,
    /// Where package://NAME of a urdf is: NAME = "folder".
    packages: Option<BTreeMap<String, PathBuf>>,
    /// Angles of a robot's joints by their names, in degrees.
    joints_deg: Option<BTreeMap<String, f64>>,
    /// Travels of a robot's sliding joints by their names, in metres.
    joints_m: Option<BTreeMap<String, f64>>,
    /// Rules for parts of a .glb, .gltf or .step file, or for models and links of an sdf.
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
        let names: Vec<String> = file.object.iter().map(|entry| entry.name.clone()).collect();
        let on_robots = object::on_robots(&file.object);
        let checked = file.object.into_iter().map(|entry| object::check(&at, entry, interior, &on_robots));
        objects = checked.filter_map(|object| problems.keep(object)).collect();
        problems.keep(at.unique("object", objects.iter().map(|o| o.name.as_str())));
        problems.keep(object::check_carriers(&at, &names, &objects));
    }
    problems.none()?;
    let name = path.file_stem().map_or_else(|| "scene".into(), |stem| stem.to_string_lossy().into_owned());
    let snapshots = timeline::count(&at, &mut objects).map_err(|e| vec![e])?;
    let dwell_s = timeline::dwell_s(&at, &objects, snapshots).map_err(|e| vec![e])?;
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
            .with_advice("name a scene file that it lists, with [[object]]")),
        false => Ok(()),
    }
}

/// One rotation, none where neither is given; `index` is its place in a list.
fn rotation(
    at: &Place,
    index: &str,
    rpy_deg: Option<[f64; 3]>,
    quaternion: Option<QuaternionKeys>,
) -> Result<DQuat> {
    match (rpy_deg, quaternion) {
        (None, None) => Ok(DQuat::IDENTITY),
        (Some(rpy), None) => {
            let rpy = at.vector(&format!("rpy_deg{index}"), rpy)?.to_array().map(f64::to_radians);
            Ok(Pose::from_rotation(DVec3::ZERO, from_rpy(rpy), RotationFrame::Link).rotation)
        }
        (None, Some(q)) => {
            let wxyz = [q.w, q.x, q.y, q.z];
            let pose = Pose::from_quaternion(DVec3::ZERO, wxyz, RotationFrame::Link);
            let pose = pose.map_err(|rule| at.wrong(&format!("quaternion{index}"), q, &rule.to_string()))?;
            Ok(pose.rotation)
        }
        (Some(_), Some(_)) => Err(at.says("both rpy_deg and quaternion").with_advice("give one rotation")),
    }
}
