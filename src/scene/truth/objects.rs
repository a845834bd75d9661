//! What is where in a scene, in voxels: the truth that sensors' claims are compared with.

use std::sync::Arc;

use glam::DVec3;

use crate::objects::keypoints::Keypoints;
use crate::objects::{Role, is_part_of};
use crate::pose::Pose;
use perirobot_march::backend::Shades;
use perirobot_march::voxel::{BitGrid, Grid};

/// A scene in voxels.
#[derive(Clone, Debug)]
pub struct Truth {
    /// Where the voxels are.
    pub grid: Grid,
    /// Voxels with a surface, or inside a body that is `occupied`; over the whole grid.
    pub occupied: Arc<BitGrid>,
    /// What stops rays: `occupied` less see-through objects; over the whole grid. The same allocation where
    /// there are none.
    pub blockers: Arc<BitGrid>,
    /// What a radar meets.
    pub radar: RadarTruth,
    /// How dark the blockers are, if sensors do not detect all of them equally far; over the whole grid.
    pub shades: Option<Arc<Shades>>,
    /// Insides of bodies that belong to no region. This and what follows covers the part of the grid that
    /// holds it.
    pub ignored: BitGrid,
    /// Voxels of people.
    pub human: BitGrid,
    /// Voxels of the robot.
    pub robot: BitGrid,
    /// The robot's voxels with the inside of its bodies, whatever their interior is.
    pub robot_volume: BitGrid,
    /// One entry for each object of the scene; one allocation for what does not move between snapshots.
    pub objects: Vec<Arc<ObjectVoxels>>,
}

impl Truth {
    /// How fast the fastest part of an object moves, in millimetres a second; `None` where that is unknown, or the object is
    /// not there.
    pub fn speed_mm_s(&self, object: &str) -> Option<u32> {
        let speeds = self.objects.iter().zip(&self.radar.speeds_mm_s);
        speeds.filter(|(part, _)| part.is_part_of(object)).filter_map(|(_, speed)| *speed).max()
    }
}

/// What a radar meets in a scene.
#[derive(Clone, Debug)]
pub struct RadarTruth {
    /// What stops its rays: `occupied` less objects that radar passes; over the whole grid. The same allocation as
    /// `occupied` where there are none.
    pub blockers: Arc<BitGrid>,
    /// How fast each object moves, in millimetres a second; `None`, or no entry, where that is unknown.
    pub speeds_mm_s: Vec<Option<u32>>,
}

/// What one object became.
#[derive(Clone, Debug)]
pub struct ObjectVoxels {
    /// Its name in the scene.
    pub name: String,
    /// Its role.
    pub role: Role,
    /// Whether rays end on it: it is opaque, and more than a tag.
    pub stops_rays: bool,
    /// Whether radar ends on it: it lets none pass, and is more than a tag.
    pub stops_radar: bool,
    /// Triangles of its surface; none for an OctoMap.
    pub triangles: usize,
    /// Whether each edge of its surface is used equally often in both directions; `None` for an OctoMap.
    pub watertight: Option<bool>,
    /// Lowest and highest corner of its surface in metres.
    pub bounds_m: [DVec3; 2],
    /// How far it reaches, if it is a robot of which that is known.
    pub reach: Option<RobotReach>,
    /// Its voxels inside the grid: the surface, and the inside where that is `occupied`.
    pub voxels: BitGrid,
    /// A human's joints in world metres, where they are known.
    pub keypoints: Option<Keypoints>,
    /// What was assumed about it that its author may not expect.
    pub warnings: Vec<String>,
}

impl ObjectVoxels {
    /// Whether it is the object of this name, or a part of it.
    pub fn is_part_of(&self, name: &str) -> bool {
        is_part_of(&self.name, name)
    }
}

/// How far a robot can reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RobotReach {
    /// Where its base stands, in the world.
    pub base_m: DVec3,
    /// The farthest it gets from there, whatever its joints.
    pub radius_m: f64,
    /// Where its root link stands.
    pub world_from_root: Pose,
}
