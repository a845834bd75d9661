//! What the manifest says of a world: its grid, regions and baselines, and hashes of all that decides its
//! counts, by which the same study is known again.

use serde::{Deserialize, Serialize};

use super::{Baselines, World};
use crate::input::Study;
use crate::sensor::{self, Setting};
use perirobot_march::backend::GridPose;
use perirobot_march::voxel::BitGrid;
use perirobot_scene::objects::spec::SceneVariant;
use perirobot_scene::source::sha256;
use perirobot_scene::truth::Truth;

/// The entry of a world in the manifest. Values that are not needed to read a sweep back may be missing
/// there, and are empty then.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Described {
    /// The scene's name.
    pub name: String,
    /// Which moment of the scene it is, counted from 0.
    pub snapshot: usize,
    /// How long it lasts, in seconds, if the scene says so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dwell_s: Option<f64>,
    /// Of which scene it is a variant, if it is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub variant: Option<SceneVariant>,
    /// Where its voxels are.
    #[serde(default)]
    pub grid: DescribedGrid,
    /// How many are occupied.
    #[serde(default)]
    pub occupied_voxels: u64,
    /// Hashes of planes of voxels.
    #[serde(default)]
    pub occupied_sha256: String,
    /// The same of the voxels that stop rays.
    #[serde(default)]
    pub blockers_sha256: String,
    /// Of people.
    #[serde(default)]
    pub human_sha256: String,
    /// Of robots' surfaces.
    #[serde(default)]
    pub robot_sha256: String,
    /// Of what robots enclose.
    #[serde(default)]
    pub robot_volume_sha256: String,
    /// Of where people's joints are.
    #[serde(default)]
    pub keypoints_sha256: String,
    /// The study's regions, in study order.
    pub regions: Vec<DescribedRegion>,
    /// Where the sensors are in the grid.
    #[serde(default)]
    pub placements: Vec<DescribedPlacements>,
}

/// Where a grid is and how large, in voxels.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DescribedGrid {
    /// World key of its first voxel.
    pub origin: [i32; 3],
    /// Voxels on each axis.
    pub size: [u32; 3],
}

/// A region of a world.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DescribedRegion {
    /// Its name.
    pub name: String,
    /// How many voxels it has.
    #[serde(default)]
    pub voxels: u64,
    /// The share of its shape that lies outside the grid.
    #[serde(default)]
    pub cut_share: f64,
    /// Hash of its voxels.
    #[serde(default)]
    pub sha256: String,
    /// What the simplest answers would score.
    pub baselines: Baselines,
}

/// Where all poses of a sensor are in the grid.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DescribedPlacements {
    /// The sensor's name.
    pub sensor: String,
    /// Hash of the poses.
    pub placements_sha256: String,
}

/// The entry of a world in the manifest.
pub(super) fn describe(study: &Study, world: &World) -> Described {
    let (truth, whole) = (&*world.truth(), world.grid.window());
    let regions = world.regions.iter().zip(&world.baselines).map(|(region, baselines)| DescribedRegion {
        name: region.name.clone(),
        voxels: region.voxels.count(),
        cut_share: region.cut_share,
        sha256: plane_sha256(&region.voxels),
        baselines: *baselines,
    });
    let placements = study.sensors.iter().enumerate().map(|(s, sensor)| {
        let poses = world.settings[s].iter().filter_map(|setting| match setting {
            Setting::Pose(pose) => Some(pose),
            _ => None,
        });
        let all = poses.map(|pose| sensor::placement(&*sensor.kind, pose, &truth.grid, 0));
        DescribedPlacements { sensor: sensor.name.clone(), placements_sha256: placements_sha256(all) }
    });
    let scene = &study.scenes[world.scene];
    Described {
        name: world.name.clone(),
        snapshot: world.snapshot,
        dwell_s: scene.dwell_s.as_ref().map(|dwell_s| dwell_s[world.snapshot]),
        variant: scene.variant.clone(),
        grid: DescribedGrid { origin: truth.grid.origin, size: truth.grid.size },
        occupied_voxels: truth.occupied.count(),
        occupied_sha256: plane_sha256(&truth.occupied),
        blockers_sha256: plane_sha256(&truth.blockers),
        human_sha256: plane_sha256(&truth.human.to_window(whole)),
        robot_sha256: plane_sha256(&truth.robot.to_window(whole)),
        robot_volume_sha256: plane_sha256(&truth.robot_volume.to_window(whole)),
        keypoints_sha256: keypoints_sha256(truth),
        regions: regions.collect(),
        placements: placements.collect(),
    }
}

/// Hash of a plane: its window (min and size, little-endian i32) and its words.
fn plane_sha256(plane: &BitGrid) -> String {
    let window = plane.window();
    let corner: Vec<u8> = window.min.iter().flat_map(|m| m.to_le_bytes()).collect();
    let size: Vec<u8> = window.size.iter().flat_map(|n| n.to_le_bytes()).collect();
    let words: Vec<u8> = plane.words().iter().flat_map(|w| w.to_le_bytes()).collect();
    sha256([corner.as_slice(), &size, &words])
}

/// Hash of where all joints of all people are, in the grid; an unknown one counts as no number at all.
fn keypoints_sha256(truth: &Truth) -> String {
    let people = truth.objects.iter().filter_map(|object| object.keypoints.as_ref());
    let joints = people.flat_map(|keypoints| keypoints.iter().enumerate());
    let numbers =
        joints.filter_map(|(number, joint)| Some((number as i64, truth.grid.position_q16((*joint)?))));
    let bytes: Vec<u8> =
        numbers.flat_map(|(number, [x, y, z])| [number, x, y, z]).flat_map(i64::to_le_bytes).collect();
    sha256([bytes.as_slice()])
}

fn placements_sha256(placements: impl Iterator<Item = GridPose>) -> String {
    let numbers = placements.flat_map(|p| p.origin_q16.into_iter().chain(p.axis_q15.into_iter().flatten()));
    let bytes: Vec<u8> = numbers.flat_map(i32::to_le_bytes).collect();
    sha256([bytes.as_slice()])
}
