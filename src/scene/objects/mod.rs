//! Surfaces with a role, in world metres: what the cell is made of before it becomes voxels. Loaders turn
//! files into [`Object`]s once, at the edge.

pub mod build;
pub mod bvh;
pub mod carrier;
pub mod collada;
pub mod gltf;
pub mod joint_table;
pub mod keypoints;
pub mod mannequin;
pub mod obj;
pub mod octomap;
pub mod primitive;
pub mod sdf;
pub mod sides;
pub mod spec;
pub mod speed;
pub mod stl;
pub mod urdf;

mod links;
pub mod loaded;
mod mesh;
pub mod mesh_file;
mod moving;
mod parts;
pub mod polygon;
pub(crate) mod xml;

use crate::pose::Pose;
use std::sync::Arc;

use glam::DVec3;

use keypoints::Keypoints;
pub(crate) use links::unknown_link;
pub use links::{Linkage, MountLink, ObjectCarrier};

/// What an object is to the study (paper, section III).
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Walls, tables, fences.
    Environment,
    /// The robot.
    Robot,
    /// A person.
    Human,
}

/// What the inside of a watertight body is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Interior {
    /// Belongs to no region and stops no ray.
    Ignored,
    /// Free space like any other, as in the paper.
    Free,
    /// Filled.
    Occupied,
}

/// Whether a sensor's ray stops at the object.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Optical {
    /// Rays stop.
    Opaque,
    /// Wire fence, polycarbonate: it is there, and rays pass.
    SeeThrough,
}

/// A surface at which sensors do not measure the surface itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Specular {
    /// Light passes, or is reflected away.
    Glass,
    /// Light is reflected away.
    Mirror,
    /// Light comes back strongly, as from a warning vest or a reflector.
    Retroreflector,
}

impl Specular {
    /// Its name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Specular::Glass => "glass",
            Specular::Mirror => "mirror",
            Specular::Retroreflector => "retroreflector",
        }
    }
}

/// Whether a radar's ray stops at the object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Deserialize, serde::Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum RadarOptics {
    /// Radar stops: metal, walls, people.
    #[default]
    Stops,
    /// A plastic cover, a curtain, cardboard: it is there, and radar passes.
    Passes,
}

/// Triangles in metres, z up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Corners; loaders refuse NaN and infinities.
    pub vertices: Vec<DVec3>,
    /// Indices into `vertices`, always in range.
    pub triangles: Vec<[u32; 3]>,
}

/// Which axis of a file points up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Up {
    /// The first; the second points to the left.
    X,
    /// The second, as most programs that draw have it.
    Y,
    /// The third, as in a cell.
    Z,
}

/// What an object is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// Triangles in world metres.
    Mesh(Mesh),
    /// Occupied voxels of an OctoMap, as world keys floor(x / resolution) at this resolution.
    Voxels {
        /// Edge of the map's voxels in metres.
        resolution_m: f64,
        /// Occupied voxels, each once.
        keys: Vec<[i32; 3]>,
    },
}

/// One thing in the cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// Unique in the scene.
    pub name: String,
    /// What it is to the study.
    pub role: Role,
    /// What its inside is.
    pub interior: Interior,
    /// Whether rays stop at it.
    pub optical: Optical,
    /// Whether radar stops at it.
    pub radar: RadarOptics,
    /// How dark it is: 0, or a number from 1, the darkest, to 7 ([`perirobot_march::backend::Shades`]).
    pub shade: u8,
    /// Gives its role to voxels without adding truth.
    pub tag_only: bool,
    /// Whether `unit` may be written beside its file.
    pub takes_unit: bool,
    /// Its surface, in the world.
    pub surface: Surface,
    /// Its own frame in the world.
    pub frame: Pose,
    /// A human's joints in world metres, where they are known.
    pub keypoints: Option<Keypoints>,
    /// Where its links are, for a robot from a URDF.
    pub linkage: Option<Arc<Linkage>>,
    /// What was assumed while it was read that its author may not expect.
    pub warnings: Vec<String>,
}

impl Object {
    /// Whether it is the object of this name, or a part of it.
    pub fn is_part_of(&self, name: &str) -> bool {
        is_part_of(&self.name, name)
    }
}

/// Whether a name is that of an object, or of a part of it by the rules of its nodes.
pub(crate) fn is_part_of(part: &str, object: &str) -> bool {
    part.strip_prefix(object).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}

/// Everything in the cell at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// Name in the result table: the scene file's stem, or its `name`.
    pub name: String,
    /// Which moment it is, counted from 0.
    pub snapshot: usize,
    /// Objects in file order, the same ones in every snapshot of a scene. What does not move from one snapshot to
    /// another is one allocation in both, so that it is voxelized once.
    pub objects: Vec<Arc<Object>>,
    /// How fast each object moves at this moment, in millimetres a second; `None`, or no entry, where that is unknown.
    pub speeds_mm_s: Vec<Option<u32>>,
}
