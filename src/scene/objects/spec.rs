//! Checked descriptions of scenes, objects, surfaces, robots and their motion, before any mesh is read.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};
use serde::{Deserialize, Serialize};

use super::bvh::MotionFile;
use super::gltf::WhichClip;
use super::joint_table::JointTableFile;
use super::keypoints::KeypointFile;
use super::mesh_file::{MeshFile, MeshFormat};
use super::sdf::SdfFile;
use super::urdf::{GeometryUse, JointValues, Packages};
use super::{Interior, ObjectCarrier, Optical, RadarOptics, Role, Specular};

/// A checked scene: what to load and where to put it.
#[derive(Clone, Debug)]
pub struct SceneSpec {
    /// The file it came from.
    pub path: PathBuf,
    /// Its text, for the manifest.
    pub text: String,
    /// Its name: the file's stem, unless the study gives another.
    pub name: String,
    /// What the inside of its objects is that do not say so themselves.
    pub interior: Interior,
    /// How many moments it has; one where nothing moves.
    pub snapshots: usize,
    /// How long each of them lasts, in seconds, if the file says so.
    pub dwell_s: Option<Vec<f64>>,
    /// Of which scene it is a variant, and which, where the study has candidate places of objects.
    pub variant: Option<SceneVariant>,
    /// Objects in file order.
    pub objects: Vec<ObjectSpec>,
    /// Numbers in it that look as if they had a wrong unit.
    pub warnings: Vec<String>,
}

/// A scene with objects at other places than its file says.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SceneVariant {
    /// The name of the scene.
    pub scene: String,
    /// The place of each object that has candidates: `robot/0.5/0/90`.
    pub place: String,
}

/// One object of a scene file.
#[derive(Clone, Debug, PartialEq)]
pub struct ObjectSpec {
    /// Unique in the file.
    pub name: String,
    /// What it is to the study.
    pub role: Role,
    /// What its inside is.
    pub interior: Interior,
    /// Whether rays stop at it.
    pub optical: Optical,
    /// Whether radar stops at it.
    pub radar: RadarOptics,
    /// How fast it moves, in metres a second, if the file contains that.
    pub speed_m_s: Option<f64>,
    /// The share of light that it reflects, if the file says so.
    pub reflectance: Option<f64>,
    /// What its surface does to light, if the file says so. No count depends on it.
    pub specular: Option<Specular>,
    /// The shade of its parts that are no people ([`perirobot_march::backend::Shades`]); 0 until the study is known.
    pub shade: u8,
    /// The shade of its parts that are people, alike.
    pub person_shade: u8,
    /// Gives its role without adding truth.
    pub tag_only: bool,
    /// What carries it; its position and rotation are then in that frame.
    pub on: Option<ObjectCarrier>,
    /// Where its own frame is, in the world or on the link that carries it.
    pub position_m: DVec3,
    /// How its own frame is turned.
    pub rotation: DQuat,
    /// What it is made of.
    pub surface: SurfaceSpec,
    /// A file with a human's joints in the object's own frame; a mannequin's are its own.
    pub keypoints: Option<KeypointFile>,
    /// Rules for the parts of a glTF or STEP file or of an SDF world.
    pub nodes: Vec<NodeRule>,
    /// The animation that poses a glTF file and when in it, in seconds.
    pub animated: Option<(WhichClip, f64)>,
    /// What changes over the snapshots of the scene.
    pub motion: MotionSpec,
}

/// What an object is made of. Bodies are centred on the object's own frame.
#[derive(Clone, Debug, PartialEq)]
pub enum SurfaceSpec {
    /// A solid box.
    Box {
        /// Edges in metres.
        size_m: DVec3,
    },
    /// Six walls seen from inside.
    Room {
        /// Edges in metres.
        size_m: DVec3,
    },
    /// A rectangle in the object's xy plane.
    Plane {
        /// Edges in metres.
        size_m: [f64; 2],
    },
    /// A sphere.
    Sphere {
        /// Radius in metres.
        radius_m: f64,
    },
    /// A cylinder about z.
    Cylinder {
        /// Radius in metres.
        radius_m: f64,
        /// Height in metres.
        height_m: f64,
    },
    /// A cylinder about z with round ends.
    Capsule {
        /// Radius in metres.
        radius_m: f64,
        /// Distance between the centres of its ends in metres.
        length_m: f64,
    },
    /// Triangles in a file.
    Mesh(MeshFile),
    /// An OctoMap `.bt` file.
    Octomap(PathBuf),
    /// A body around the joints of a person.
    Mannequin(PersonFile),
    /// The same of a person that ships with the program.
    Shipped(perirobot_shipped::Person),
    /// A robot from a URDF.
    Urdf(UrdfSpec),
    /// A world of Gazebo.
    Sdf(SdfFile),
}

impl SurfaceSpec {
    /// The glTF file that it is in, or the STEP file that becomes one: only these have nodes with names.
    pub fn gltf(&self) -> Option<&MeshFile> {
        match self {
            SurfaceSpec::Mesh(file) if matches!(file.format, MeshFormat::Gltf | MeshFormat::Step) => {
                Some(file)
            }
            _ => None,
        }
    }

    /// The file of a mesh.
    pub fn mesh_file(&self) -> Option<&MeshFile> {
        match self {
            SurfaceSpec::Mesh(file) => Some(file),
            _ => None,
        }
    }

    /// Whether `unit` may be written beside its file: COLLADA and STEP contain their unit.
    pub fn takes_unit(&self) -> bool {
        self.mesh_file().is_some_and(|file| !matches!(file.format, MeshFormat::Collada | MeshFormat::Step))
    }

    /// Whether it is a solid whose lengths are in the scene file.
    pub fn is_body(&self) -> bool {
        use SurfaceSpec::{Box, Capsule, Cylinder, Sphere};
        matches!(self, Box { .. } | Sphere { .. } | Cylinder { .. } | Capsule { .. })
    }
}

/// The joints of a person, in a file.
#[derive(Clone, Debug, PartialEq)]
pub enum PersonFile {
    /// A table of joints.
    Joints(KeypointFile),
    /// A moment of a recorded motion.
    Motion(MotionFile),
}

impl PersonFile {
    /// The file itself.
    pub fn path(&self) -> &Path {
        match self {
            PersonFile::Joints(file) => &file.path,
            PersonFile::Motion(file) => &file.path,
        }
    }
}

/// What parts of a file are: of a glTF file by the names of nodes, of a STEP file by names of parts and by layers, and of
/// an SDF world by names of models and links.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct NodeRule {
    /// A pattern of names with `*` and `?`; it covers a node and all below it.
    pub r#match: Option<String>,
    /// A pattern of layers of a STEP file, alike: it covers solids and surfaces that are on such a layer, whatever their
    /// other layers. With `match`, both must fit.
    pub layer: Option<String>,
    /// Another role than the object's.
    pub role: Option<Role>,
    /// Another optical kind than the object's.
    pub optical: Option<Optical>,
    /// Another kind for radar than the object's.
    pub radar: Option<RadarOptics>,
    /// Leaves the parts out.
    #[serde(default)]
    pub ignore: bool,
}

impl NodeRule {
    /// The name of its parts, behind the name of the object: its patterns.
    pub fn name(&self) -> String {
        [&self.layer, &self.r#match].into_iter().flatten().map(String::as_str).collect::<Vec<_>>().join("/")
    }
}

/// A robot to load and to pose.
#[derive(Clone, Debug, PartialEq)]
pub struct UrdfSpec {
    /// The URDF.
    pub path: PathBuf,
    /// Which of its geometry counts.
    pub geometry: GeometryUse,
    /// Where the packages of its meshes are.
    pub packages: Packages,
    /// How it stands.
    pub joints: JointValues,
    /// Values of a xacro's arguments.
    pub xacro_args: BTreeMap<String, String>,
    /// What it did, and when, in seconds: joints of the table stand as they did then.
    pub recorded: Option<(JointTableFile, f64)>,
}

/// What changes about an object over the snapshots of its scene; an empty list changes nothing. A list shorter than the
/// scene belongs to an object whose lists repeat.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MotionSpec {
    /// Where it is, instead of the object's own position.
    pub position_m: Vec<DVec3>,
    /// How it is turned, instead of the object's own rotation.
    pub rotation: Vec<DQuat>,
    /// Whether the link carries it; where it does not, its position and rotation are in the world.
    pub carried: Vec<bool>,
    /// Keypoint files of a mannequin.
    pub mannequin: Vec<KeypointFile>,
    /// Keypoint files of another human.
    pub keypoints: Vec<KeypointFile>,
    /// Joint values of a robot, instead of the object's own; joints that an entry does not name keep those.
    pub joints: Vec<JointValues>,
    /// The animation that a glTF file is sampled from.
    pub clip: WhichClip,
    /// What a robot did.
    pub joint_table: Option<JointTableFile>,
    /// When the animation, the table or the motion of a mannequin is sampled.
    pub times_s: Vec<f64>,
    /// How long each entry lasts, in seconds.
    pub dwell_s: Vec<f64>,
    /// How fast the object moves, instead of its own speed.
    pub speed_m_s: Vec<f64>,
    /// Whether the lists repeat until the scene's snapshots are through.
    pub cycle: bool,
    /// Whether every entry is met with every snapshot of the rest of the scene; the lists are written out.
    pub cross: bool,
}

impl MotionSpec {
    /// The lists that are given, by their keys; a new kind of list joins here and in [`ObjectSpec::snapshot`].
    pub fn lists(&self) -> Vec<(&'static str, usize)> {
        let all = [
            ("position_m", self.position_m.len()),
            ("rpy_deg or quaternion", self.rotation.len()),
            ("carried", self.carried.len()),
            ("mannequin", self.mannequin.len()),
            ("keypoints", self.keypoints.len()),
            ("joints_deg or joints_m", self.joints.len()),
            ("animation.times_s", self.times_s.len()),
            ("dwell_s", self.dwell_s.len()),
            ("speed_m_s", self.speed_m_s.len()),
        ];
        all.into_iter().filter(|(_, length)| *length > 0).collect()
    }

    /// Whether the object is the same in every snapshot.
    pub fn is_still(&self) -> bool {
        self.lists().is_empty()
    }
}

impl ObjectSpec {
    /// Whether it, or a part of it by the rules of its nodes, has this name.
    pub fn has_part(&self, name: &str) -> bool {
        let rule = || name.strip_prefix(self.name.as_str())?.strip_prefix('/');
        let has_rule = |rule: &str| self.nodes.iter().any(|node| !node.ignore && node.name() == rule);
        self.name == name || rule().is_some_and(has_rule)
    }

    /// The object as it is in one snapshot, without its lists.
    pub fn snapshot(&self, snapshot: usize) -> ObjectSpec {
        fn pick<T: Clone>(list: &[T], snapshot: usize) -> Option<T> {
            let index = snapshot.checked_rem(list.len())?;
            Some(list[index].clone())
        }
        let motion = &self.motion;
        let mut surface = self.surface.clone();
        let time_s = pick(&motion.times_s, snapshot);
        if let Some(person) = pick(&motion.mannequin, snapshot) {
            surface = SurfaceSpec::Mannequin(PersonFile::Joints(person));
        }
        match &mut surface {
            SurfaceSpec::Mannequin(PersonFile::Motion(file)) => file.time_s = time_s.unwrap_or(file.time_s),
            SurfaceSpec::Urdf(robot) => {
                robot.joints.extend(pick(&motion.joints, snapshot).unwrap_or_default());
                robot.recorded = motion.joint_table.clone().zip(time_s);
            }
            _ => {}
        }
        ObjectSpec {
            on: self.on.clone().filter(|_| pick(&motion.carried, snapshot) != Some(false)),
            position_m: pick(&motion.position_m, snapshot).unwrap_or(self.position_m),
            rotation: pick(&motion.rotation, snapshot).unwrap_or(self.rotation),
            surface,
            keypoints: pick(&motion.keypoints, snapshot).or_else(|| self.keypoints.clone()),
            speed_m_s: pick(&motion.speed_m_s, snapshot).or(self.speed_m_s),
            animated: time_s
                .filter(|_| self.surface.gltf().is_some())
                .map(|time_s| (motion.clip.clone(), time_s)),
            motion: MotionSpec::default(),
            ..self.clone()
        }
    }
}

impl SceneSpec {
    /// Says where packages are for all robots of the scene; overrides what its file says.
    pub fn use_packages<'a>(&mut self, packages: impl Iterator<Item = (&'a str, &'a Path)> + Clone) {
        for object in &mut self.objects {
            if let SurfaceSpec::Urdf(robot) = &mut object.surface {
                packages.clone().for_each(|(name, folder)| robot.packages.insert(name, folder));
            }
        }
    }
}
