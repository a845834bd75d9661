//! Maps and point clouds that real sensors recorded, turned into what a sensor says in the grid of a study.
//!
//! | file | what it is |
//! |---|---|
//! | `.bt`, `.ot` | an OctoMap |
//! | `.npz` | labels over a grid, as `perirobot export` writes them |
//! | `.pcd`, `.ply` | a point cloud, carved from where its sensor was |
//! | `.mcap` | point clouds of a ROS 2 bag, each carved from where its frame is |
//!
//! # Theory
//! A recording has a frame of its own, which stands in the world at a position, turned about the vertical. The
//! voxels of a map are cubes of that frame; their corners are rounded to 1/65536 voxel of the study's grid, and
//! what follows is integers ([`voxels`]):
//!
//! * a voxel of the study is occupied if a part of an occupied voxel of the map lies more than 1/256 voxel deep in it;
//! * it is free if all of it is covered by free voxels of the map;
//! * else it is unknown.
//!
//! So a map on the study's own grid comes back as it is. The points of a cloud mark and carve as returns of a
//! sensor do ([`cloud`]).

pub mod cloud;
mod header;
mod labels;
mod mcap;
mod npy;
mod npz;
mod number;
mod pcd;
mod ply;
mod points;
pub mod voxels;

use std::collections::HashSet;
use std::path::Path;

use glam::{DMat3, DVec3};

use crate::objects::octomap;
use crate::pose::{Pose, RotationFrame};
use crate::source::{Sources, accepted_formats};
use cloud::Cloud;
use labels::{Each, LabelArray, voxels_of};
use perirobot_march::backend::Planes;
use perirobot_march::error::Issue;
use perirobot_march::voxel::Grid;
use perirobot_march::voxel::grid::VOXEL_SIZES_M;
use perirobot_march::{Error, Result};
use voxels::VoxelMap;

/// The endings of all that can be read, for messages.
pub const ENDINGS: &str = "a .bt, .ot, .npz, .pcd, .ply or .mcap file";

/// How many voxels of a map may stand in a row in a voxel of the grid.
const FINEST: f64 = 64.0;

/// Most voxels of a map that are laid into a grid: three planes of a gigabyte.
const MOST_VOXELS: u64 = 1 << 33;

/// No frame is farther away: the northings of maps go up to ten million metres.
pub const FARTHEST_M: f64 = 1e8;

/// How far the parts x and y of a quaternion may be from zero where a frame is upright.
const LEVEL: f64 = 1e-9;

/// What was recorded, in its own frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Recording {
    /// Voxels that are occupied, free or unknown.
    Map(Box<VoxelMap>),
    /// Points that a sensor measured, from one place or from several.
    Clouds(Vec<Cloud>),
}

/// What of a file is read, where it holds more than one thing or leaves something out.
#[derive(Clone, Copy, Debug, Default)]
pub struct RecordingSelection<'a> {
    /// Where the sensor was, in the recording's frame. Without it the file of a cloud says it, or else the sensor
    /// was at the frame's origin. Of a map it tells only what was hidden.
    pub sensor_m: Option<DVec3>,
    /// The topic of a bag; needed where it has clouds on several.
    pub topic: Option<&'a str>,
    /// The number of a message of the topic, counted from 0; without it all of them are one recording.
    pub message: Option<usize>,
}

/// Where the frame of a recording stands in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchor {
    position_m: DVec3,
    world_from_frame: DMat3,
}

impl Anchor {
    /// At a position in metres, turned about the vertical from x towards y.
    pub fn new(position_m: DVec3, yaw_rad: f64) -> Anchor {
        // Quarter turns are made exact, so that a map that is not turned keeps its numbers.
        let exact = |v: f64| if (v - v.round()).abs() < 1e-12 { v.round() } else { v };
        let (sin, cos) = (exact(libm::sin(yaw_rad)), exact(libm::cos(yaw_rad)));
        let [x, y] = [DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.0)];
        Anchor { position_m, world_from_frame: DMat3::from_cols(x, y, DVec3::Z) }
    }

    /// Where a pose is. A turn about the vertical is that of [`Anchor::new`]; only point clouds can be tilted.
    pub fn from_pose(Pose { position_m, rotation }: Pose) -> Anchor {
        match rotation.x.abs().max(rotation.y.abs()) < LEVEL {
            true => Anchor::new(position_m, 2.0 * libm::atan2(rotation.z, rotation.w)),
            false => Anchor { position_m, world_from_frame: DMat3::from_quat(rotation) },
        }
    }

    /// Where a frame stands by numbers: x, y, z in metres and the yaw in degrees, or x, y, z and a quaternion w, x, y, z of
    /// length 1. `None` for other numbers, and for those beyond [`FARTHEST_M`].
    pub fn from_numbers(numbers: &[f64]) -> Option<Anchor> {
        if !numbers.iter().all(|number| number.abs() <= FARTHEST_M) {
            return None;
        }
        match *numbers {
            [x, y, z, yaw_deg] => Some(Anchor::new(DVec3 { x, y, z }, yaw_deg.to_radians())),
            [x, y, z, qw, qx, qy, qz] => {
                let pose = Pose::from_quaternion(DVec3 { x, y, z }, [qw, qx, qy, qz], RotationFrame::Link);
                pose.ok().map(Anchor::from_pose)
            }
            _ => None,
        }
    }

    /// Whether its frame is upright in the world.
    fn is_upright(&self) -> bool {
        self.world_from_frame.z_axis == DVec3::Z
    }

    /// A point of the frame in the world; both in metres.
    pub fn world(&self, point_m: DVec3) -> DVec3 {
        self.position_m + self.world_from_frame * point_m
    }

    /// A point of the world in the frame; both in metres.
    fn frame(&self, point_m: DVec3) -> DVec3 {
        self.world_from_frame.transpose() * (point_m - self.position_m)
    }
}

impl Recording {
    /// Reads a file by the ending of its name.
    ///
    /// # Errors
    /// When the file cannot be read, is damaged, or holds nothing; when something is asked that is not asked of
    /// such a file.
    pub fn read(path: &Path, asked: RecordingSelection, sources: &Sources) -> Result<Recording> {
        let at = |issue: Issue| Error::from(issue.with_place(path));
        let bytes = || sources.bytes(path);
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        let ending = ending.as_deref().unwrap_or_default();
        if ending != "mcap" && (asked.topic.is_some() || asked.message.is_some()) {
            return Err(Error::input(path, "is no bag, and topic and message are asked of .mcap files only")
                .with_advice("leave them out"));
        }
        let clouds = match ending {
            "pcd" => vec![pcd::parse(&sources.bytes_of_text(path)?).map_err(at)?],
            "ply" => vec![ply::parse(&sources.bytes_of_text(path)?).map_err(at)?],
            "mcap" => {
                let (clouds, remarks) = mcap::parse(&bytes()?, asked.topic, asked.message).map_err(at)?;
                remarks.iter().for_each(|remark| sources.remark(path, remark));
                clouds
            }
            "bt" | "ot" | "npz" => {
                let map = match ending {
                    "npz" => npz::parse(&bytes()?).map_err(at)?,
                    _ => VoxelMap::from_tree(octomap::read_tree(path, sources)?),
                };
                let map = VoxelMap { sensor_m: asked.sensor_m, ..map };
                return Recording::from_map(map).map_err(|e| e.with_place(path).into());
            }
            _ => return Err(Error::input(path, accepted_formats(path, ENDINGS))),
        };
        Ok(Recording::Clouds(clouds.into_iter().map(|cloud| cloud.seen_from(asked.sensor_m)).collect()))
    }

    /// A map of labels: 1 is occupied, 0 free, 255 unknown. `origin_m` is the lowest corner of voxel [0, 0, 0] in the
    /// recording's frame.
    ///
    /// # Errors
    /// When a label is another number, none is known, or a length is none.
    pub fn from_labels(
        shape: [usize; 3],
        label: &dyn Fn([usize; 3]) -> u8,
        origin_m: DVec3,
        voxel_size_m: f64,
    ) -> Result<Recording, Issue> {
        let each: &Each = &|see| {
            for [x, y, z] in voxels_of(shape) {
                see([x, y, z].map(|n| n as i32), label([x, y, z]).into());
            }
        };
        let labels = LabelArray { shape, each, are_bytes: true, hits: None, origin_m, voxel_size_m };
        Recording::from_map(labels.map()?)
    }

    /// A map, if its voxels are of a size that is read.
    fn from_map(map: VoxelMap) -> Result<Recording, Issue> {
        match VOXEL_SIZES_M.contains(&map.voxel_size_m) {
            true => Ok(Recording::Map(Box::new(map))),
            false => {
                let what = format!("has voxels of {} m, must be from 0.0001 to 10 m", map.voxel_size_m);
                Err(Issue::says(what))
            }
        }
    }

    /// Whether it can stand somewhere: a map's frame must be upright, a cloud's need not be.
    pub fn fits(&self, anchor: &Anchor) -> bool {
        matches!(self, Recording::Clouds(_)) || anchor.is_upright()
    }

    /// What it says in a grid: planes over all of it. Its hits are empty
    /// where the recording does not tell which voxels its returns came from.
    pub fn planes(&self, anchor: &Anchor, grid: &Grid) -> Said {
        match self {
            Recording::Map(map) => map.to_grid(anchor, grid),
            Recording::Clouds(clouds) => {
                let mut planes = Planes::blank(grid.window());
                clouds.iter().for_each(|cloud| cloud.carve_in(anchor, grid, &mut planes));
                Said { planes, knows_hits: false }
            }
        }
    }

    /// Whether a map's voxels are so small beside those of a grid that they would get lost, or so many in it that laying
    /// it there takes more than some gigabytes.
    pub fn is_too_fine(&self, anchor: &Anchor, grid: &Grid) -> bool {
        match self {
            Recording::Map(map) => {
                map.voxel_size_m * FINEST < grid.voxel_size_m || map.voxels_near(anchor, grid) > MOST_VOXELS
            }
            Recording::Clouds(_) => false,
        }
    }

    /// The places in the world where sensors were, each once, as far as they are known.
    pub fn places_m(&self, anchor: &Anchor) -> Vec<DVec3> {
        let all = match self {
            Recording::Map(map) => Vec::from_iter(map.sensor_m),
            Recording::Clouds(clouds) => clouds.iter().map(|cloud| cloud.sensor_m).collect(),
        };
        let mut seen = HashSet::new();
        let places = all.into_iter().filter(|place| seen.insert(place.to_array().map(f64::to_bits)));
        places.map(|place| anchor.world(place)).collect()
    }

    /// What it is, for people.
    pub fn describe(&self) -> String {
        match self {
            Recording::Map(map) => map.describe(),
            Recording::Clouds(clouds) => cloud::describe(clouds),
        }
    }

    /// Lowest and highest corner of what it knows, in its frame, in metres.
    pub fn bounds_m(&self) -> [DVec3; 2] {
        match self {
            Recording::Map(map) => map.bounds_m(),
            Recording::Clouds(clouds) => {
                let all = clouds.iter().map(Cloud::bounds_m);
                all.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]).unwrap_or_default()
            }
        }
    }
}

/// What a recording says in a grid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Said {
    /// Occupied and free voxels, and those that returns came from, if that is known. A voxel may be both
    /// occupied and free: occupied wins.
    pub planes: Planes,
    /// Whether the recording tells which voxels its returns came from.
    pub knows_hits: bool,
}

#[cfg(test)]
mod tests;
