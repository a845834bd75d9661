//! What the manifest says of a world: its grid, regions and baselines, and hashes of all that decides its
//! counts, by which the same study is known again.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde::{Deserialize, Serialize};

use super::{Baselines, World};
use crate::input::Study;
use crate::sensor::{self, Setting};
use perirobot_march::backend::{GridPose, Shades};
use perirobot_march::voxel::{BitGrid, Window};
use perirobot_scene::objects::spec::SceneVariant;
use perirobot_scene::source::{little_endian, sha256};
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
    /// Of how dark they are, if sensors do not detect all of them equally far.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shades_sha256: Option<String>,
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

/// What was hashed of a scene's snapshots, since most of it is the same in the next.
#[derive(Default)]
pub(super) struct KnownHashes {
    /// Planes, each with its hash over a window.
    planes: Mutex<VecDeque<(Arc<BitGrid>, Window, String)>>,
    /// Settings of a sensor, by its index, each with the hash of where that is in the grid.
    settings: Mutex<VecDeque<HashedSettings>>,
}

/// A sensor, its settings, and the hash of where they are in the grid.
type HashedSettings = (usize, Arc<Vec<Setting>>, String);

/// Hashes of a kind that are known, so that memory stays bounded: the latest.
const MOST_KNOWN: usize = 64;

impl KnownHashes {
    /// The hash of a plane over a window.
    fn plane_sha256(&self, plane: &BitGrid, window: Window) -> String {
        self.known_plane(plane, window).unwrap_or_else(|| self.add_plane(Arc::new(plane.clone()), window)).1
    }

    /// The hash of a plane, which becomes the allocation of an earlier one that is the same.
    fn shared_sha256(&self, plane: &mut Arc<BitGrid>) -> String {
        let window = plane.window();
        let (shared, sha256) =
            self.known_plane(plane, window).unwrap_or_else(|| self.add_plane(plane.clone(), window));
        *plane = shared;
        sha256
    }

    fn known_plane(&self, plane: &BitGrid, window: Window) -> Option<(Arc<BitGrid>, String)> {
        let planes = lock(&self.planes);
        let (plane, _, sha256) = planes.iter().find(|known| known.1 == window && *known.0 == *plane)?;
        Some((plane.clone(), sha256.clone()))
    }

    fn add_plane(&self, plane: Arc<BitGrid>, window: Window) -> (Arc<BitGrid>, String) {
        let sha256 = match plane.window() == window {
            true => plane_sha256(&plane),
            false => plane_sha256(&plane.to_window(window)),
        };
        keep(&self.planes, (plane.clone(), window, sha256.clone()));
        (plane, sha256)
    }

    /// The hash of where a sensor is at all of its settings.
    fn placements_sha256(&self, study: &Study, sensor: usize, world: &World) -> String {
        let settings = &world.settings[sensor];
        let is_same = |known: &&HashedSettings| known.0 == sensor && Arc::ptr_eq(&known.1, settings);
        if let Some((.., sha256)) = lock(&self.settings).iter().find(is_same) {
            return sha256.clone();
        }
        let poses = settings.iter().filter_map(|setting| match setting {
            Setting::Pose(pose) => Some(pose),
            _ => None,
        });
        let kind = &*study.sensors[sensor].kind;
        let sha256 = placements_sha256(poses.map(|pose| sensor::placement(kind, pose, &world.grid, 0)));
        keep(&self.settings, (sensor, settings.clone(), sha256.clone()));
        sha256
    }
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

fn keep<T>(all: &Mutex<VecDeque<T>>, new: T) {
    let mut all = lock(all);
    all.truncate(MOST_KNOWN - 1);
    all.push_front(new);
}

/// The entry of a world in the manifest. Regions that are the same in earlier snapshots are held once from now on.
pub(super) fn describe(study: &Study, world: &mut World, known: &KnownHashes) -> Described {
    let (truth, whole) = (&*world.truth(), world.grid.window());
    let hashes: Vec<String> =
        world.regions.iter_mut().map(|region| known.shared_sha256(&mut region.voxels)).collect();
    let regions = world.regions.iter().zip(&world.baselines).zip(hashes);
    let regions = regions.map(|((region, baselines), sha256)| DescribedRegion {
        name: region.name.clone(),
        voxels: region.voxels.count(),
        cut_share: region.cut_share,
        sha256,
        baselines: *baselines,
    });
    let placements = study.sensors.iter().enumerate().map(|(number, sensor)| DescribedPlacements {
        sensor: sensor.name.clone(),
        placements_sha256: known.placements_sha256(study, number, world),
    });
    let occupied_sha256 = plane_sha256(&truth.occupied);
    let all_block = Arc::ptr_eq(&truth.occupied, &truth.blockers);
    let blockers_sha256 = if all_block { occupied_sha256.clone() } else { plane_sha256(&truth.blockers) };
    let scene = &study.scenes[world.scene];
    Described {
        name: world.name.clone(),
        snapshot: world.snapshot,
        dwell_s: scene.dwell_s.as_ref().map(|dwell_s| dwell_s[world.snapshot]),
        variant: scene.variant.clone(),
        grid: DescribedGrid { origin: truth.grid.origin, size: truth.grid.size },
        occupied_voxels: truth.occupied.count(),
        occupied_sha256,
        blockers_sha256,
        shades_sha256: truth.shades.as_deref().map(|shades| shades_sha256(shades, &study.reflectances)),
        human_sha256: plane_sha256(&truth.human.to_window(whole)),
        robot_sha256: known.plane_sha256(&truth.robot, whole),
        robot_volume_sha256: known.plane_sha256(&truth.robot_volume, whole),
        keypoints_sha256: keypoints_sha256(truth),
        regions: regions.collect(),
        placements: placements.collect(),
    }
}

/// Hash of a plane: its window (min and size, little-endian i32) and its words.
fn plane_sha256(plane: &BitGrid) -> String {
    let window = plane.window();
    sha256([&*little_endian(&window.min), &little_endian(&window.size), &little_endian(plane.words())])
}

/// Hash of how dark the blockers are: the shares of light of each shade, as bits of f64, and the planes of their numbers.
fn shades_sha256(shades: &Shades, reflectances: &[f64]) -> String {
    let shares: Vec<u64> = reflectances.iter().map(|share| share.to_bits()).collect();
    let shares: Vec<u8> = shares.into_iter().flat_map(u64::to_le_bytes).collect();
    let planes = shades.bits.each_ref().map(plane_sha256);
    let planes = planes.each_ref().map(|hash| hash.as_bytes()).concat();
    sha256([shares.as_slice(), planes.as_slice()])
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
    sha256([&*little_endian(&numbers.collect::<Vec<i32>>())])
}
